"""What people get wrong with a stand that inclines, in the example's run: each is named, by status and message."""

import json
import re

import numpy as np
import pytest
from blocks import NOMINAL_K, write_run
from conftest import EXAMPLES

import tumble as package
from tumble import core, model
from tumble.errors import BadInput
from tumble.model.coefficients import worst_norm
from tumble.model.geometry import Geometry
from tumble.model.inclined import Inclinations, as_seen
from tumble.stand import Stand

pytestmark = pytest.mark.python
INCLINED = "--schedule", "inclined"
STAND = "--stand", EXAMPLES / "inclined_stand.toml"
HEADER, *LINES = (EXAMPLES / "inclined_stand.csv").read_text().splitlines()
ROWS = [(*map(int, line.split(",")[:2]), np.array(line.split(",")[2:], dtype=float)) for line in LINES]


U0 = np.array([0.01, -0.02, 0.03])


def at(path, degrees, noise=3e-6, seed=4):
    """A run of `inclined` by the exact geometry, inclined otherwise than it says."""
    schedule = core.built_in("inclined")
    seen = as_seen(schedule, Inclinations((1, 2, 3), np.deg2rad(degrees), np.zeros(3)))
    rough = noise * np.random.default_rng(seed).standard_normal((27, 3))
    return write_run(path / "run.csv", schedule, Geometry(seen).outputs(NOMINAL_K, U0) + rough)


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
    file = changed(tmp_path, lambda one, at, u: (mountings.get(one, one), positions.get(at, at), np.multiply(u, signs)))
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


DIFFER = "three must differ by tens of degrees (+-20 deg leave five times the uncertainty of +-45 deg)"
SIDES = "inclinations 2 and 3, set to either side of the level, lie on one side of it"
UNKNOWN = ", which leaves |a| unknown"
CONTRADICTED = {  # how the stand was inclined, deg; what is said, and, where a stand is declared, of u(|a|)
    "never inclined": ([0.0, 0.0, 0.0], "inclinations 1, 2 and 3 are alike", UNKNOWN),
    "the second not inclined": ([0.5, 0.5, -45.0], "inclinations 1 and 2 are alike", UNKNOWN),
    "hardly inclined": ([0.5, 0.7, -45.0], "inclinations 1 and 2 are alike", ", which leaves u(|a|) of up to 0.0083 g"),
    "the third not inclined": ([0.5, 45.0, 0.5], "inclinations 1 and 3 are alike", UNKNOWN),
    "+45 twice": ([0.9, 46.0, 46.0], "inclinations 2 and 3 are alike", UNKNOWN),
    "all alike at +45": ([45.0, 45.0, 45.0], "inclinations 1, 2 and 3 are alike", UNKNOWN),
    "on one side": ([5.7, 45.8, 17.2], f"{SIDES}: 1 at +5.7, 2 at +45.8, 3 at +17.2 deg", None),
    "on one side, nearly alike": ([3.2, 45.0, 44.0], f"{SIDES}: 1 at +3.2, 2 at +45.0, 3 at +44.0 deg", None),
}


@pytest.mark.parametrize("degrees, said, left", CONTRADICTED.values(), ids=CONTRADICTED)
def test_what_contradicts_the_schedule_is_named(tmp_path, tumble, degrees, said, left):
    """Without a stand nothing is known of the noise of lone rows."""
    file = at(tmp_path, degrees)
    for stand, with_stand in (((), ""), (STAND, left)):
        done = tumble("solve", file, *INCLINED, *stand)
        whole = said if left is None else f"{said}{with_stand}; {DIFFER}"
        assert (done.returncode, done.stderr) == (2, f"tumble: {file}: {whole}\n")


def test_inclinations_lost_in_noise_are_refused_with_what_they_leave(tmp_path):
    """Whatever the refusal: what it says of |a| is of the size that the true inclinations and the noise leave."""
    schedule, samples = core.built_in("inclined"), 8
    seen = as_seen(schedule, Inclinations((1, 2, 3), np.deg2rad([0.0, 0.2, -0.2]), np.zeros(3)))
    outputs, rough, told = Geometry(seen).outputs(NOMINAL_K, U0), np.random.default_rng(7), []
    says = r"no inclinations of the axis, which leaves u\(\|a\|\) of up to (\S+) g; three"
    noisy = Stand(0.0, 0.0, 0.0, 0.0, 5e-5, samples, "sigma1")
    truth = model.Propagation(seen, NOMINAL_K, noisy, np.full(27, samples), "inclined")
    true_u = worst_norm(NOMINAL_K, truth.covariance()).worst_g
    for _ in range(40):
        rows = outputs + 5e-5 * rough.standard_normal((samples, 27, 3))
        lines = [
            f"{p.mounting},{p.number},{x!r},{y!r},{z!r}"
            for one in rows.tolist()
            for p, (x, y, z) in zip(schedule.positions, one)
        ]
        (tmp_path / "run.csv").write_text("\n".join([HEADER, *lines]) + "\n")
        try:
            package.solve(str(tmp_path / "run.csv"), schedule="inclined")
        except BadInput as error:
            told += re.findall(says, str(error))
    assert len(told) > 3
    assert 0.5 * true_u < np.median(np.array(told, dtype=float)) < 2.0 * true_u


FEW = {"0.6 of 45": [0.0, 0.65, -45.0], "1": [0.0, 1.0, -1.0], "0.3": [0.0, 0.3, -0.3], "5 of 45": [-40.0, 3.0, -43.0]}


@pytest.mark.parametrize("estimator", ["inclined", "optimal"])
@pytest.mark.parametrize("degrees", FEW.values(), ids=FEW)
def test_inclinations_that_hardly_differ_are_solved_with_their_uncertainty(tmp_path, degrees, estimator):
    """The core and numpy round differently there, and no disagreement is made of it."""
    for seed in range(2):
        file = at(tmp_path, degrees, seed=seed)
        result = package.solve(str(file), stand=str(STAND[1]), schedule="inclined", estimator=estimator)
        document = json.loads(result.to_json())
        assert document["pass_reason"] == "uncertainty"
        off = [(one["deg"] - deg) / one["u_deg"] for one, deg in zip(document["inclinations"], degrees)]
        assert np.abs(off).max() < 4.0


def test_only_the_user_is_told_of_inclinations_alike(tmp_path):
    """As found: of 12 runs at the level in place of +45 deg none is an internal error, whatever its noise."""
    for seed in range(12):
        file = at(tmp_path, [0.53, 0.53, -44.68], 3e-5, seed)
        with pytest.raises(BadInput, match="inclinations 1 and 2 are alike"):
            package.solve(str(file), schedule="inclined", stand=str(STAND[1]))


@pytest.mark.parametrize("off", [(0.0, 3e-3, 0.0), (0.0, 0.0, -2e-3), (2e-3, 0.0, 0.0)])
def test_an_inclination_that_is_declared_and_does_not_hold_is_blamed(tmp_path, tumble, off):
    """The second or third by what it is off from the first; the first by what both others are off from it."""
    degrees = np.array([0.0, 45.0, -45.0]) + np.rad2deg(off)
    declared = tmp_path / "stand.toml"
    declared.write_text(STAND[1].read_text().replace("[stand]", "[stand]\ninclination_rad = 1e-4"))
    given = "solve", at(tmp_path, degrees), "--stand", declared, *INCLINED, "--estimator", "optimal"
    shown = tumble(*given)
    said = r"inclination of [23] - 1 [123]\.\de-03 rad \(declared 1\.0e-04\)"
    assert shown.returncode == 1 and re.search(said, " ".join(shown.stdout.split()))
    first = json.loads(tumble(*given, "--json").stdout)["fit"]["explanations"][0]
    others = {"2 - 1": off[1] - off[0], "3 - 1": off[2] - off[0]}
    assert first["patterns"][0] == "inclination_rad" and first["unit"] == "rad"
    assert first["size"] == pytest.approx(others[first["column"]], abs=3.0 * first["u_size"])
    assert abs(first["size"]) == pytest.approx(max(map(abs, others.values())), rel=0.2)


CAUSES = "inclinations exchanged, not all inclined, or axis_tilt_deg in radians?"
ELSEWHERE = {  # tilts of a schedule file, None: the built-in one; which inclinations are exchanged; what is said
    "1 and 2 exchanged": (None, {1: 2, 2: 1}, "1 at +45.4 deg, set to 0; 2 at +0.5 deg, set to 45"),
    "radians": ((0.0, 0.785, -0.785), {}, "2 at +45.4 deg, set to 0.785; 3 at -44.7 deg, set to -0.785"),
    "14 deg off": ((0.0, 59.0, -58.5), {}, None),
    "16 deg off": ((0.0, 61.5, -45.0), {}, "2 at +45.4 deg, set to 61.5"),
    "as set": (None, {}, None),
}


@pytest.mark.parametrize("tilts, order, said", ELSEWHERE.values(), ids=ELSEWHERE)
def test_inclinations_far_from_those_set_are_a_warning(tmp_path, tumble, tilts, order, said):
    """They are solved as found, so the verdict stays."""
    file, schedule = changed(tmp_path, lambda one, place, u: (order.get(one, one), place, u)), INCLINED
    if tilts is not None:
        schedule = "--schedule", schedule_file(tmp_path / "mine.toml", tilts)
    done = tumble("solve", file, *schedule, *STAND)
    warned = (
        "" if said is None else f"tumble: warning: inclinations found far from where they were set: {said}: {CAUSES}\n"
    )
    assert (done.returncode, done.stderr) == (0, warned)


def schedule_file(path, tilts):
    turned = "matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
    lines = [
        f"[[mounting]]\nnumber = {n}\n{turned}\naxis_tilt_deg = {tilt}\nbolting = 1" for n, tilt in enumerate(tilts, 1)
    ]
    for number in (1, 2, 3):
        for place in range(1, 10):
            angle, use = 45.0 * (place - 1), "check" if place == 9 else "fit"
            lines.append(f'[[position]]\nmounting = {number}\nposition = {place}\nangle_deg = {angle}\nuse = "{use}"')
    path.write_text("\n".join(lines) + "\n")
    return path


def test_what_hardly_inclines_is_told_to_incline_further(tmp_path, tumble):
    """The cheapest remedy comes first, and it keeps what it promises: the same run at 45 deg is shown."""
    done = tumble("solve", at(tmp_path, [1.0, 6.0, -4.0]), *INCLINED, *STAND, "--json")
    document = json.loads(done.stdout)
    first, *others = document["would_show"]
    assert (done.returncode, document["pass_reason"]) == (1, "uncertainty")
    assert (first["change"], first["to"]) == ("inclinations", 45.0) and "stand" in [one["change"] for one in others]
    steep = package.solve(str(at(tmp_path, [1.0, 45.0, -45.0])), stand=str(STAND[1]), schedule="inclined")
    kept = json.loads(steep.to_json())["decision"]
    assert kept["coverage_factor"] * kept["u_norm_worst_g"] == pytest.approx(first["reach_g"], rel=0.05)
    assert steep.passed
    told = " ".join(tumble("solve", at(tmp_path, [1.0, 6.0, -4.0]), *INCLINED, *STAND).stdout.split())
    assert "It would be shown by inclining further, to 45 deg either way (5." in told


def test_degrees_in_the_column_of_numbers_are_named(tmp_path, tumble):
    file = changed(tmp_path, lambda one, place, u: ({1: 0, 2: 45, 3: -45}[one], place, u))
    done = tumble("solve", file, *INCLINED)
    assert (done.returncode, done.stderr) == (
        2,
        f"tumble: {file}: row 2, column mounting: the schedule has no mounting 0; mountings are 1 to 3, and 4 for the"
        " first again; the column holds the number of the inclination\n",
    )
