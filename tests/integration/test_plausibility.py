"""A run whose K is not that of the declared block is refused by the name of the mistake; a proper one is left alone."""

import dataclasses
import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from blocks import write_run
from conftest import EXAMPLES

import tumble as tumble_package
from tumble.core import CoreSchedule
from tumble.files.run_file import Run
from tumble.files.stand_file import StandFile
from tumble.model import Geometry, built_in
from tumble.schedule import Mounting, Position, Schedule
from tumble.solving.plausibility import examine, with_order_flag
from tumble.solving.solution import solve
from tumble.stand import PAPER_STAND

pytestmark = pytest.mark.python
PAPER = built_in("paper")
AXES = np.eye(3)
ROTATIONS = AXES, AXES[[0, 2, 1]] * [[-1], [1], [1]], AXES[[1, 2, 0]]
THREE = Schedule(
    tuple(Mounting(number, tuple(map(tuple, rotation))) for number, rotation in enumerate(ROTATIONS, start=1)),
    tuple(Position(mounting, number, 45.0 * (number - 1)) for mounting in (1, 2, 3) for number in range(1, 10)),
)
LINES = [line.split(",") for line in (EXAMPLES / "paper_stand.csv").read_text().split()]


def declared(scale=2.0, misalignment=0.02, true=None):
    block = {"scale_v_per_g": scale, "misalignment_rad": misalignment, "converter_bits": None, "range_v": None}
    truth = None if true is None else {"K": true, "U0": [0.0, 0.0, 0.0]}
    return StandFile(PAPER_STAND, block, truth, None, None, None, None)


def same(means):
    return means


def examined(stand_file, k, u0=(0.0, 0.0, 0.0), schedule=PAPER, measured=None, unit="V", change=same, rng=None):
    """A block `k` measured as by `measured` (a schedule) or by the one that it is solved with, then `change`d; K by
    plain least squares, for a whole solve takes long."""
    rng = rng or np.random.default_rng(0)
    noise = rng.normal(size=(len(schedule.positions), 3)) * 2e-5 * np.abs(k).max()
    means = change(Geometry(measured or schedule).outputs(k, np.array(u0)) + noise)
    design = np.column_stack([Geometry(schedule).force(), np.ones(len(means))])
    found = np.linalg.lstsq(design, means, rcond=None)[0][:3].T
    run = Run(np.ones(len(means), dtype=int), means, np.full_like(means, np.nan), unit, {})
    of_core = SimpleNamespace(k=found, residual_rms=None)
    unknown = {"u_k": None, "stated": None, "scatter_alone": None, "inclinations": None}
    solved = SimpleNamespace(run=run, found=of_core, measured_schedule=schedule, **unknown)
    return examine(solved, stand_file)


def block(rng, misalignment, scale=2.0, signs=(1, 1, 1)):
    """Scales within a tenth of the nominal one, every misalignment at most the declared one."""
    rows = np.diag(rng.uniform(0.9, 1.1, 3)) + rng.uniform(-misalignment, misalignment, (3, 3)) * (1 - AXES)
    return scale * np.array(signs)[:, None] * rows


def turned(schedule, mountings):
    return Schedule(
        schedule.mountings,
        tuple(
            dataclasses.replace(one, angle_deg=-one.angle_deg) if one.mounting in mountings else one
            for one in schedule.positions
        ),
    )


def exchanged(schedule, one, other):
    pair = {one: other, other: one}
    positions = (dataclasses.replace(p, mounting=pair.get(p.mounting, p.mounting)) for p in schedule.positions)
    return Schedule(schedule.mountings, tuple(positions))


@pytest.mark.parametrize("misalignment", [0.0, 0.02, 0.1, 0.3])
@pytest.mark.parametrize("schedule", [PAPER, THREE], ids=["two mountings", "three"])
def test_a_proper_block_is_left_alone(misalignment, schedule):
    rng = np.random.default_rng(11)
    for scale in rng.choice([-1, 1], 100) * 10.0 ** rng.uniform(-4, 4, 100):
        k = block(rng, misalignment, scale)
        found = examined(declared(float(scale), misalignment), k, rng.uniform(-1, 1, 3) * abs(scale), schedule)
        assert found.refusal is None and found.warnings == ()
        assert examined(None, k, schedule=schedule).warnings == ()


@pytest.mark.parametrize("misalignment", [0.02, 0.3])
def test_any_order_and_handedness_may_be_declared(misalignment):
    rng = np.random.default_rng(12)
    for order, signs in itertools.product(itertools.permutations(range(3)), itertools.product((1, -1), repeat=3)):
        k = block(rng, misalignment, signs=signs)[list(order)]
        found = examined(declared(true=k.tolist(), misalignment=misalignment), k * rng.uniform(0.95, 1.05))
        assert found.refusal is None and found.warnings == ()


MISTAKES = {
    "channels ux and uy look exchanged (--columns): ": {"change": lambda means: means[:, [1, 0, 2]]},
    "channels ux and uz look exchanged (--columns): ": {"change": lambda means: means[:, [2, 1, 0]]},
    "channels uy and uz look exchanged (--columns): ": {"change": lambda means: means[:, [0, 2, 1]]},
    "channels ux, uy and uz look exchanged (--columns): ": {"change": lambda means: means[:, [1, 2, 0]]},
    "mountings 1 and 2 look exchanged: ": {"measured": exchanged(PAPER, 1, 2)},
    "channel ux looks reversed or the table looks to have turned the other way: ": {"measured": turned(PAPER, (1, 2))},
    "channel uy looks reversed: ": {"change": lambda means: means * [1, -1, 1]},
    "channel uz looks reversed: ": {"change": lambda means: means * [1, 1, -1]},
    "all channels look reversed (the sign of scale_v_per_g?): ": {"change": lambda means: -means},
    "outputs look to be in mV, not in V (--unit mV): ": {"change": lambda means: 1e3 * means},
    "outputs look to be in uV, not in V (--unit uV): ": {"change": lambda means: 1e6 * means},
    "outputs look to be in V, not in mV (--unit V): ": {"unit": "mV"},
    "outputs look to be in mV, not in V (--unit mV) and channels ux and uy look exchanged (--columns): ": {
        "change": lambda means: 1e3 * means[:, [1, 0, 2]]
    },
}


@pytest.mark.parametrize("misalignment", [0.02, 0.1, 0.3])
@pytest.mark.parametrize("said", MISTAKES)
def test_every_mistake_is_named(said, misalignment):
    rng = np.random.default_rng(13)
    for _ in range(8):
        scale = float(rng.choice([-1, 1]) * rng.uniform(0.5, 8))
        u0 = rng.uniform(-0.1, 0.1, 3)
        found = examined(declared(scale, misalignment), block(rng, misalignment, scale), u0, rng=rng, **MISTAKES[said])
        assert found.refusal is not None and found.refusal.startswith(said)


@pytest.mark.parametrize(
    ("said", "measured"),
    [
        ("mountings 1 and 2 look exchanged: ", exchanged(THREE, 1, 2)),
        ("mountings 2 and 3 look exchanged: ", exchanged(THREE, 2, 3)),
        ("mountings 1 and 3 look exchanged: ", exchanged(THREE, 1, 3)),
        ("the table looks to have turned the other way: ", turned(THREE, (1, 2, 3))),
        ("the table looks to have turned the other way in mounting 2: ", turned(THREE, (2,))),
    ],
)
@pytest.mark.parametrize("misalignment", [0.02, 0.3])
def test_mistakes_with_three_mountings(said, measured, misalignment):
    rng = np.random.default_rng(14)
    for _ in range(8):
        k = block(rng, misalignment)
        found = examined(declared(misalignment=misalignment), k, schedule=THREE, measured=measured, rng=rng)
        assert found.refusal is not None and found.refusal.startswith(said)


def test_what_no_mistake_explains_is_a_warning():
    k = np.array([[2.0, 0.2, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 2.0]])
    found = examined(declared(), k)
    assert found.refusal is None
    assert found.warnings == (
        "K is not that of the declared block: "
        "K_xy = 0.2 V/g where 0 +- 0.04 is declared; K_yy = 3 V/g where 2 is declared",
    )


def test_the_size_of_other_units_is_not_judged_by_thousands():
    found = examined(declared(scale=2.0), 2e3 * AXES, unit="m/s^2")
    assert found.refusal is None and "K_xx = 2000 (m/s^2)/g where 2 is declared" in found.warnings[0]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            lambda means: means[:, [0, 2, 1]],
            "channel uy measures along z: K_yz = 2 V/g, K_yy = 0 V/g; channels or mountings exchanged?",
        ),
        (
            lambda means: means * [-1, 1, 1],
            "K_xx = -2 V/g has another sign than the other two: a channel reversed, or the table turned the other way?",
        ),
    ],
)
def test_without_a_declared_block_the_structure_warns(change, said):
    clean = Geometry(PAPER).outputs(2.0 * AXES, np.zeros(3))
    run = Run(np.ones(18, dtype=int), np.round(change(clean), 12), np.full((18, 3), np.nan), "V", {})
    found = examine(solve(run, None, "least_squares", 1.0, None, "run.csv"), None)
    assert found.refusal is None and [abs_free(line) for line in found.warnings] == [said]


def abs_free(line):
    """Without the rounding errors of a zero."""
    return " ".join("0" if "e-1" in word else word for word in line.split())


def rewritten(path, change):
    path.write_text("\n".join(",".join(row) for row in [LINES[0], *(change(row) for row in LINES[1:])]) + "\n")
    return path


def test_the_command_refuses_and_says_why(refused, tmp_path):
    swapped = rewritten(tmp_path / "run.csv", lambda row: [*row[:3], row[4], row[3]])
    line = refused("solve", swapped, "--stand", EXAMPLES / "paper_stand.toml", "--out", tmp_path / "result.json")
    assert line == (
        f"tumble: {swapped}: channels uy and uz look exchanged (--columns): K_yz = 2.004 V/g where 0 +- 0.04 is "
        "declared\n"
    )
    line = refused("fixture", "check", swapped, "--stand", EXAMPLES / "paper_stand.toml")
    assert "channels uy and uz look exchanged" in line


def test_the_command_solves_what_is_named_as_the_line_says(tumble, tmp_path):
    millivolts = rewritten(tmp_path / "run.csv", lambda row: [*row[:2], *(f"{float(u) * 1e3:.4f}" for u in row[2:])])
    command = ("solve", millivolts, "--stand", EXAMPLES / "paper_stand.toml")
    assert tumble(*command).returncode == 2
    assert tumble(*command, "--unit", "mV").returncode == 0


def test_without_a_stand_the_command_warns(tumble, tmp_path):
    schedule = built_in("paper")
    means = Geometry(schedule).outputs(2.0 * AXES + 0.01, [0.1, 0.2, 0.3])
    done = tumble("solve", write_run(tmp_path / "run.csv", schedule, means[:, [0, 2, 1]]))
    assert done.returncode == 0
    assert "tumble: warning: channel uy measures along z: K_yz = 2.01 V/g" in done.stderr
    verdict = done.stdout.partition("\n\n")[0]
    assert " nothing exchanged or reversed (it looks so), " in " ".join(verdict.split())
    assert max(map(len, verdict.splitlines())) <= 80


def test_a_channel_along_another_axis_has_no_relative_uncertainty(tumble, tmp_path):
    """K_yy is no scale of uy then: u over it was 8e+05 ppm."""
    schedule, rng = built_in("paper"), np.random.default_rng(1)
    means = Geometry(schedule).outputs(2.0 * AXES + 0.01, [0.1, 0.2, 0.3])[:, [0, 2, 1]]
    rows = [
        f"{place.mounting},{place.number}," + ",".join(f"{one:.7f}" for one in mean + 1e-4 * rng.normal(size=3))
        for place, mean in zip(schedule.positions, means)
        for _ in range(20)
    ]
    (tmp_path / "run.csv").write_text("\n".join(["mounting,position,ux,uy,uz", *rows, ""]))
    done = tumble("solve", tmp_path / "run.csv")
    last = {row.split()[0].rstrip("*^"): row.split()[-1] for row in done.stdout.splitlines() if row[:2] in ("K_", "U0")}
    without = {f"K_{row}{column}" for row in "yz" for column in "xyz"} | {"U0_y", "U0_z"}
    assert len(last) == 12 and {name for name, text in last.items() if text == "-"} == without


ODD = {
    "nothing": (same, False),
    "all reversed": (lambda means: -means, False),
    "exchanged": (lambda means: means[:, [0, 2, 1]], True),
    "reversed": (lambda means: means * [1, -1, 1], True),
}


@pytest.mark.parametrize("name", ODD)
@pytest.mark.parametrize("stand", [None, "stand", "block"])
def test_a_pass_says_that_it_assumes_the_order(name, stand, tmp_path):
    """Where K looks exchanged and no block is declared to be so: not with the truth of such a block, nor in a proper
    run. The text, the result and a table of it have it, with the coefficients: all."""
    change, is_odd = ODD[name]
    means = change(Geometry(PAPER).outputs(2.0 * AXES + 0.01, np.array([0.1, 0.2, 0.3])))
    k = change((2.0 * AXES + 0.01).T).T
    text = (EXAMPLES / "paper_stand.toml").read_text().partition("[block")[0]
    rows = ", ".join(str(row) for row in k.tolist())
    block = "[block]\nscale_v_per_g = 2.0\nmisalignment_rad = 0.02\n"
    true = f"[block.true]\nK = [{rows}]\nU0 = [0.1, 0.2, 0.3]\n"
    (tmp_path / "stand.toml").write_text(text + (block + true if stand == "block" else ""))
    run = write_run(tmp_path / "run.csv", PAPER, means)
    found = tumble_package.solve(run, stand=None if stand is None else tmp_path / "stand.toml")
    expected = is_odd and stand != "block"
    assert found.document["pass_reason"] in (None, "uncertainty")  # the yaw of an exchanged channel is in u(|a|)
    assert found.passed or name == "exchanged"
    assert ("order" in found.assumes) == expected == bool(found.warnings)
    assert ("order", []) in found.document["assumed_for"].items() or not expected
    assert ("nothing exchanged or reversed" in found._repr_html_()) == (expected and found.passed)


FACES = built_in("six_faces")
FORCE = Geometry(FACES).force()
TURNED_TO = {  # which way gravity was at each position
    "same": (lambda force: np.tile(force[0], (6, 1)), "the outputs do not follow the positions: K_"),
    "z twice": (lambda force: force * [1, 1, 0] + [0, 0, 1] * (force != 0)[:, 2:], "the outputs do not change with"),
}


@pytest.mark.parametrize("scattered", [False, True], ids=["means", "samples"])
@pytest.mark.parametrize("scale", [None, 9.8])
@pytest.mark.parametrize("case", TURNED_TO)
def test_noise_names_no_cause(case, scale, scattered):
    """A sensor that was not turned between positions: whatever is largest in K is no exchange. Not even where a block
    is declared, of which K may be a thousandth."""
    turn, said = TURNED_TO[case]
    k, declared_block = 9.8 * (AXES + 0.01), None if scale is None else declared(scale)
    for seed in range(20):
        noise = np.random.default_rng(seed).normal(size=(20, 6, 3)) * 0.2
        samples = turn(FORCE) @ k.T + [0.1, -0.2, 0.3] + noise
        scatter = samples.std(axis=0, ddof=1) if scattered else np.full((6, 3), np.nan)
        run = Run(np.full(6, 20 if scattered else 1), samples.mean(axis=0), scatter, "m/s^2", {})
        solution = solve(run, CoreSchedule(FACES), "least_squares", 1.0, None, "run.csv")
        found = examine(solution, declared_block)
        assert found.refusal is None and len(found.warnings) == 1 and found.warnings[0].startswith(said)
        assert not with_order_flag(solution, declared_block).is_out_of_order


def test_a_channel_that_follows_nothing_measures_along_no_axis():
    rng = np.random.default_rng(15)
    means = FORCE @ ((2.0 * AXES + 0.1) * [[1], [1], [0]]).T + rng.normal(size=(6, 3)) * 1e-3
    run = Run(np.ones(6, dtype=int), means, np.full((6, 3), np.nan), "V", {})
    (warning,) = examine(solve(run, CoreSchedule(FACES), "least_squares", 1.0, None, "run.csv"), None).warnings
    assert warning.startswith("channel uz does not follow the positions: K_z")
