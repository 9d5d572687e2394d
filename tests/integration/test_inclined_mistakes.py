"""What people get wrong with a stand that inclines, in the example's run: each is named, by status and message."""

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble as package

pytestmark = pytest.mark.python
INCLINED = "--schedule", "inclined"
STAND = "--stand", EXAMPLES / "inclined_stand.toml"
HEADER, *LINES = (EXAMPLES / "inclined_stand.csv").read_text().splitlines()
ROWS = [(*map(int, line.split(",")[:2]), np.array(line.split(",")[2:], dtype=float)) for line in LINES]


def changed(tmp_path, change):
    """The example's run, its rows (mounting, position, outputs) as `change` makes them."""
    rows = (change(*row) for row in ROWS)
    lines = [f"{mounting},{position}," + ",".join(f"{u:.7f}" for u in outputs) for mounting, position, outputs in rows]
    (tmp_path / "run.csv").write_text("\n".join([HEADER, *lines]) + "\n")
    return tmp_path / "run.csv"


MIRRORED = "inclinations of opposite sign look exchanged (2 and 3) or channel uy looks reversed"
BACKWARDS = "channel ux looks reversed or the table looks to have turned the other way"
MISUSED = {  # what a run is in truth: what is told of each row, and how the outputs are changed; channel, what is said
    "exchanged": ({2: 3, 3: 2}, {}, (1, 1, 1), "y", MIRRORED),
    "channel along the axis reversed": ({}, {}, (1, -1, 1), "y", MIRRORED),
    "turned backwards": ({}, {n: 10 - n for n in range(2, 9)}, (1, 1, 1), "x", BACKWARDS),
    "channel across the axis reversed": ({}, {}, (-1, 1, 1), "x", BACKWARDS),
}


@pytest.mark.parametrize("mountings, positions, signs, axis, said", MISUSED.values(), ids=MISUSED)
def test_what_looks_like_a_reversed_channel_is_named(tmp_path, tumble, mountings, positions, signs, axis, said):
    """Nothing in such a run tells one from the other: so both are named, and what comes of believing it."""
    file = changed(
        tmp_path, lambda one, at, u: (mountings.get(one, one), positions.get(at, at), np.multiply(u, signs))
    )
    given = "solve", file, *INCLINED
    done = tumble(*given, *STAND)
    odd = ["x", "y", "z"].index(axis)
    found = package.solve(str(file), schedule="inclined").K[odd][odd]
    scales = ", ".join("-2" if one == odd else "2" for one in range(3))
    value = f"K_{axis}{axis} = {found:.4g} V/g"
    assert found < 0.0
    assert (done.returncode, done.stderr) == (
        2,
        f"tumble: {file}: {said}, which look alike to this run: {value} where 2 is declared; if the stand was used as"
        f" told and the block is so, [block] says it per channel: scale_v_per_g = [{scales}]\n",
    )
    mirrored = "inclinations of opposite sign exchanged (2 and 3), " if axis == "y" else ""
    causes = f"{mirrored}a channel reversed, or the table turned the other way?"
    assert f"warning: {value} has another sign than the other two: {causes}\n" in tumble(*given).stderr
