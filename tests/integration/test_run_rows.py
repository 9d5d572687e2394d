"""Rows that no block at rest gives are named, and refused where they matter; honest rows are left alone."""

import numpy as np
import pytest
from conftest import EXAMPLES

from tumble.errors import BadInput
from tumble.files.run_file import RowStore, Run, read_run
from tumble.files.run_rows import check_rows
from tumble.model import Geometry, built_in

pytestmark = pytest.mark.python
PAPER = built_in("paper")
FORCE = Geometry(PAPER).force()
K = 2.0 * np.eye(3) + 0.03
SIGMA = 3e-4
ROWS = (EXAMPLES / "paper_stand.csv").read_text().split()  # 50 rows a position; row 2 of the file is the first of 1.1
STAND = EXAMPLES / "paper_stand.toml"


def honest(rng, rows, step=0.0, rho=0.0):
    """A run of Gaussian noise, white or AR(1), rounded by a converter of this step."""
    noise = rng.normal(size=(18, rows, 3))
    for row in range(1, rows if rho else 0):
        noise[:, row] = rho * noise[:, row - 1] + np.sqrt(1 - rho**2) * noise[:, row]
    outputs = (FORCE @ K.T + rng.uniform(-0.05, 0.05, 3))[:, None] + SIGMA * noise
    outputs = np.round(outputs / step) * step if step else outputs
    return run_of(outputs)


def run_of(outputs):
    """Of outputs (18, rows, 3)."""
    rows = outputs.shape[1]
    store = RowStore(18, "run.csv")
    store.add(np.repeat(np.arange(18), rows), np.column_stack((outputs.reshape(-1, 3), np.arange(18 * rows) + 2)))
    return Run(np.full(18, rows), outputs.mean(axis=1), np.zeros((18, 3)), "V", {}, table=store)


@pytest.mark.parametrize("rows", [1, 2, 3, 5, 50])
@pytest.mark.parametrize("step", [0.0, 0.3, 1.0, 1.5, 2.5, 10.0])
@pytest.mark.parametrize("rho", [0.0, 0.9])
def test_honest_rows_are_left_alone(rows, step, rho, request):
    """Steps of the converter in standard deviations. Beyond 8 of them is no honest row; measured with --full."""
    rng = np.random.default_rng(21)
    for _ in range(400 if request.config.getoption("--full") else 8):
        assert check_rows(honest(rng, rows, step * SIGMA, rho), PAPER, None, "run.csv") == ()


def changed(path, change):
    """The paper's run with some rows changed: `change` gets the number of a line in the file, its label and outputs."""
    lines = [ROWS[0]]
    for number, line in enumerate(ROWS[1:], start=2):
        mounting, position, *outputs = line.split(",")
        lines.append(",".join([mounting, position, *change(number, f"{mounting}.{position}", outputs)]))
    path.write_text("\n".join(lines) + "\n")
    return path


def at(first, last, channel, value):
    """Another value of one channel, in these lines of the file: a text, or what is added, by line."""

    def change(number, _label, outputs):
        if first <= number <= last:
            added = value if isinstance(value, str) else f"{float(outputs[channel]) + value(number):.7f}"
            return [*outputs[:channel], added, *outputs[channel + 1 :]]
        return outputs

    return change


REFUSED = {
    "first rows": (
        at(52, 56, 0, lambda line: -0.03 * (57 - line)),
        "row 52: the table was not at rest: rows 52 to 56 (1.2) are off the others of their position; leave them out",
    ),
    "last rows": (
        at(49, 51, 0, lambda line: 0.03 * (line - 48)),
        "row 49: the table was not at rest: rows 49 to 51 (1.1) are off the others",
    ),
    "a whole position": (
        at(52, 101, 0, lambda line: 1e-3 * (line - 52)),
        "row 52: the table was not at rest: rows 52 to 101 (1.2) are off",
    ),
    "one absurd row": (
        at(120, 120, 1, "9"),
        "row 120, column uy: 9 V is far off: the others of 1.3 lie about -0.027",
    ),
    "two absurd rows": (
        lambda number, label, outputs: ["0.5", *outputs[1:]] if number in (120, 130) else outputs,
        "row 120, column ux: 0.5 V is far off: the others of 1.3 lie about 2.0147 V; absurd are rows 120, 130",
    ),
    "stuck channel": (
        at(102, 151, 2, "0.0472"),
        "row 102, column uz: 0.0472 V in all rows to 151 (1.3), where uz shows noise elsewhere: stuck or saturated",
    ),
    "stuck for a while": (at(120, 140, 2, "0.0472"), "row 120, column uz: 0.0472 V in all rows to 140 (1.3)"),
    "cut off": (
        lambda number, label, outputs: [f"{min(float(u), 2.0145):.7f}" for u in outputs],
        "stuck or saturated",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_rows_that_matter_are_refused(case, refused, tmp_path):
    change, said = REFUSED[case]
    run = changed(tmp_path / "run.csv", change)
    for command in (["solve", run], ["fixture", "check", run, "--stand", STAND]):
        line = refused(*command)
        assert f"{run}: " in line and said in line


def test_every_position_begun_while_the_table_turned(refused, tmp_path):
    """A tenth of all samples: the first three are named, the others counted."""
    run = changed(
        tmp_path / "run.csv",
        lambda number, label, outputs: [f"{float(u) + (0.1 if (number - 2) % 50 < 5 else 0):.7f}" for u in outputs],
    )
    line = refused("solve", run, "--stand", STAND)
    assert "rows 2 to 6 (1.1), 52 to 56 (1.2), 102 to 106 (1.3) and 15 more such stretches are off" in line


def test_an_odd_row_that_does_not_matter_is_a_warning(tumble, tmp_path):
    run = changed(tmp_path / "run.csv", at(120, 120, 1, lambda _: 12 * SIGMA))
    done = tumble("solve", run)
    assert done.returncode == 0
    assert "tumble: warning: row 120, column uy: -0.0" in done.stderr
    assert "V is far off: the others of 1.3" in done.stderr


def test_a_position_that_shakes_is_a_warning(tumble, tmp_path):
    rng = np.random.default_rng(22)
    run = changed(tmp_path / "run.csv", at(52, 101, 1, lambda _: 20 * SIGMA * rng.normal()))
    done = tumble("solve", run, "--limit", "0.1")
    assert done.returncode == 0
    assert "rows 52 to 101 (1.2): uy scatters " in done.stderr and " times as much as elsewhere" in done.stderr


@pytest.mark.parametrize(
    ("bits", "range_v", "said"),
    [
        (24, 1.9, "row 2, column uz: 2.0259 V is beyond the declared range of +-1.9 V; another unit? (--unit) (and "),
        (8, 2.048, " V is at the end of the range of +-2.048 V: saturated (and "),
    ],
)
def test_the_declared_range(bits, range_v, said, refused, tmp_path):
    stand = tmp_path / "stand.toml"
    text = STAND.read_text().replace("[block]\n", f"[block]\nconverter_bits = {bits}\nrange_v = {range_v}\n")
    stand.write_text(text)
    assert said in refused("solve", EXAMPLES / "paper_stand.csv", "--stand", stand)


def test_noise_that_is_cut_off_without_a_run_of_equal_values():
    run = honest(np.random.default_rng(23), 50)
    outputs = np.array([run.table.rows(position)[0] for position in range(18)])
    top = np.sort(outputs[..., 2], axis=None)[-30]
    outputs[..., 2] = np.minimum(outputs[..., 2], top)
    with pytest.raises(BadInput, match=r"column uz: 2\.\d+ V in 30 rows, and none beyond: saturated"):
        check_rows(run_of(outputs), PAPER, None, "run.csv")


@pytest.mark.parametrize("name", ["paper_stand", "angle_stand", "lab_stand"])
def test_examples_are_left_alone(name):
    assert check_rows(read_run(str(EXAMPLES / f"{name}.csv"), PAPER), PAPER, None, "run.csv") == ()
