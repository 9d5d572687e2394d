"""`tumble import` of a block that is bolted on once, its stand inclined: rests matched, inclinations found."""

import re
import shlex

import numpy as np
import pytest
from blocks import NOMINAL_K
from recordings import Habits, inclined_anew, recording

from tumble.core import CoreSchedule
from tumble.files.schedule_file import default_estimator, to_toml
from tumble.importing import match
from tumble.importing.attitudes import attitudes_of, fitted
from tumble.importing.match import Doubtful, UserChoices
from tumble.importing.rests import Rests
from tumble.model import Geometry, built_in, inclined
from tumble.schedule import Schedule

pytestmark = pytest.mark.python

U0 = np.array([0.1, 0.2, 0.3])
OFF, ZERO, BOLTING = np.deg2rad([5.0, 3.0, 2.0])  # of an inclination, of its zero of the table angle, of the block
SAID = (1, 1, 1)
SCHEDULE = built_in("inclined")
NUMBERS = tuple(range(27))


def rests_of(stand, visits, k=NOMINAL_K, noise=0.0, rng=None):
    """What a block gives on a stand, visited in this order."""
    means = Geometry(stand).outputs(k, U0)[list(visits)]
    means = means if rng is None else means + rng.normal(0.0, noise, means.shape)
    begin = 1000 * np.arange(len(means))
    return Rests(begin, begin + 900, means, np.full(means.shape, max(noise, 1e-9)))


def any_block(rng):
    return 10.0 ** rng.uniform(-3, 3) * (np.diag(rng.uniform(0.7, 1.3, 3)) + rng.uniform(-0.05, 0.05, (3, 3)))


def in_order(schedule, numbers):
    return [place for number in numbers for place, one in enumerate(schedule.positions) if one.mounting == number]


@pytest.mark.parametrize("name", ["inclined", "inclined_closed"])
@pytest.mark.parametrize("order", ["schedule", "any"])
def test_inclinations_that_nobody_measured_are_found(name, order, cases):
    """Any inclinations up to 5 degrees off, any zero, any order: every rest is told, and each inclination exactly. Of
    eight stands with --full."""
    schedule, rng = built_in(name), np.random.default_rng(35)
    for _ in range(cases(8)):
        stand = inclined_anew(schedule, OFF, ZERO, BOLTING, rng)
        numbers = [one.number for one in schedule.mountings]
        if order == "any":
            rng.shuffle(numbers)
            places = [place for place, number in enumerate(numbers) if number in (1, 4)]
            for place, number in zip(places, (1, 4)):  # of the two at 0 the first is 1
                numbers[place] = number
        visits = in_order(schedule, numbers)
        found = match.match(rests_of(stand, visits, any_block(rng)), schedule, UserChoices(SAID, order))
        assert found.positions.tolist() == visits and set(found.states) == {"taken"}
        tilts = [one.tilt_deg for one in stand.mountings]
        assert np.rad2deg(found.fit.inclinations.beta) == pytest.approx(tilts, abs=1e-6)
        zeros = [stand.positions[9 * place].angle_deg for place in range(len(numbers))]
        tau = np.rad2deg(found.fit.inclinations.tau)
        assert tau - tau[0] == pytest.approx(np.array(zeros) - zeros[0], abs=1e-6)
        assert found.off.max() < 1e-8


def test_leverage_is_what_a_rest_takes_into_the_fit():
    """Held against the derivative of the fit: a rest that moves takes its attitude along by its leverage."""
    stand = inclined_anew(SCHEDULE, OFF, ZERO, BOLTING, np.random.default_rng(1))
    means, places = rests_of(stand, NUMBERS).means, attitudes_of(SCHEDULE).of_positions(SCHEDULE)
    fit = fitted(places, np.arange(27), means)
    assert fit.unknowns == 12 + 3 + 2
    assert 3.0 * fit.leverage.sum() == pytest.approx(fit.unknowns, abs=1e-9)
    step = 1e-6
    for rest in NUMBERS:
        taken = 0.0
        for axis in np.eye(3):
            moved = means.copy()
            moved[rest] += fit.k @ axis * step
            other = fitted(places, np.arange(27), moved)
            drawn = other.k @ other.forces[rest] + other.u0 - fit.k @ fit.forces[rest] - fit.u0
            taken += np.linalg.solve(fit.k, drawn) @ axis / step / 3.0
        assert fit.leverage[rest] == pytest.approx(taken, abs=1e-4)


def refusal(visits, stand=None, schedule=SCHEDULE, change=lambda rests: None, **user_choices):
    """What is said of rests in this order."""
    stand = inclined_anew(schedule, OFF, ZERO, BOLTING, np.random.default_rng(4)) if stand is None else stand
    rests = rests_of(stand, visits, noise=1e-6, rng=np.random.default_rng(5))
    change(rests)
    with pytest.raises(Doubtful) as refused:
        match.match(rests, schedule, UserChoices(**{"signs": SAID, **user_choices}))
    return str(refused.value)


def turned(rest, rad):
    """A rest that is off by an angle."""

    def change(rests):
        rests.means[rest] += NOMINAL_K @ np.array([0.0, rad, 0.0])

    return change


def tilted(schedule, tilts):
    """The schedule as a stand has it that is inclined otherwise, deg."""
    seen = inclined.Inclinations(tuple(tilts), np.deg2rad(list(tilts.values())), np.zeros(len(tilts)))
    return inclined.as_seen(schedule, seen)


CLOSED = built_in("inclined_closed")
TWICE = [*range(18), 12, *range(18, 27)]
FOUND = "in the schedule's order, K positive, 18 of 27 positions are found; all 27 would be found"
IN_ANY = "in another order, K positive"
NOT_SHOWN = (
    "rests do not show scale and bias of every channel: give the recordings of all inclinations together, or check "
    "whether --still, --drift or --min-rest hide some"
)
LAST = "positions measured more than once: the last rest is used"


@pytest.mark.parametrize(
    ("said", "visits", "more"),
    [
        (f"{FOUND} {IN_ANY} (--order any)", in_order(SCHEDULE, (2, 3, 1)), {}),
        (
            f"{FOUND} in 2 ways: (1) in the schedule's order, K negative in y (--signs=+-+) (2) {IN_ANY} (--signs=+++ "
            "--order any); choose one by its options",
            in_order(SCHEDULE, (1, 3, 2)),
            {"signs": None},
        ),
        (
            f"in the schedule's order, K positive, 27 of 36 positions are found; all 36 would be found {IN_ANY} "
            "(--order any)",
            in_order(CLOSED, (1, 2, 4, 3)),
            {"schedule": CLOSED},
        ),
        (
            f"9 {NOT_SHOWN}",
            range(9),
            {},
        ),
        (
            "of 18 rests none fit the positions of this schedule; is an inclination missing, or is this another "
            "schedule? (--schedule; any_pose takes poses that nobody knows, a schedule file poses of your own)",
            range(18),
            {},
        ),
        (
            f"27 {NOT_SHOWN}",
            NUMBERS,
            {"stand": tilted(SCHEDULE, {1: 0.0, 2: 1.0, 3: -1.0})},
        ),
        (
            "rests 13 and 19 are all at 2.4: --repeats first|last|longest selects one, --leave-out 19 continues"
            " without the later ones",
            TWICE,
            {},
        ),
        (
            "rest 15 is 10 mrad off 2.6, far more than the other rests: --take 15 uses it, --leave-out 15 "
            "leaves it out",
            NUMBERS,
            {"change": turned(14, 0.01)},
        ),
    ],
)
def test_what_is_in_doubt_is_refused(said, visits, more):
    assert refusal(visits, **more) == said


MISSING = "no rest at 3.1, 3.2, 3.3, 3.4, 3.5, 3.6, 3.7, 3.8, 3.9"
UNKNOWN = "inclinations: the rests do not show all of them, the others are as in the schedule"


@pytest.mark.parametrize(
    ("tilts", "visits", "user_choices", "notes"),
    [
        ((1.25, 44.5, -46.0), TWICE, {"repeats": "last"}, [LAST]),
        ((1.25, 44.5, -46.0), NUMBERS, {"leave_out": frozenset({13})}, ["no rest at 2.4"]),
        ((1.25, 44.5, -46.0), [*range(8), *range(9, 17), *range(18, 26)], {}, ["no rest at 1.9, 2.9, 3.9"]),
        ((0.0, 45.0, -20.0), NUMBERS, {}, [MISSING, UNKNOWN]),  # 25 degrees off: no inclination of the schedule
        ((0.0, 45.0, 20.0), NUMBERS, {}, [MISSING, UNKNOWN]),
        ((3.0, 57.0, -33.0), NUMBERS, {}, []),
    ],
)
def test_what_is_taken_for_granted_is_told(tilts, visits, user_choices, notes):
    stand = tilted(SCHEDULE, dict(zip((1, 2, 3), tilts)))
    rests = rests_of(stand, visits, noise=1e-6, rng=np.random.default_rng(6))
    told = match.match(rests, SCHEDULE, UserChoices(SAID, **user_choices))
    shown = f"inclinations found from the rests: 1 at {tilts[0]:.2f}, 2 at {tilts[1]:.2f}, 3 at {tilts[2]:.2f} deg"
    usual = ["signs of K: +++, as given", "order: the schedule's"]
    assert sorted(told.notes) == sorted([*usual, *notes, *([] if UNKNOWN in notes else [shown])])


def test_the_return_to_an_inclination_is_told_apart_by_time():
    """It comes last, and what is at 0 degrees first is the first inclination, even where it does not come at all."""
    for numbers, places in (((2, 1, 4, 3), (2, 1, 4, 3)), ((3, 4, 2), (3, 1, 2)), ((1, 4, 3, 2), (1, 4, 3, 2))):
        stand = inclined_anew(CLOSED, OFF, ZERO, BOLTING, np.random.default_rng(7))
        found = match.match(rests_of(stand, in_order(CLOSED, numbers)), CLOSED, UserChoices(SAID, "any"))
        assert found.positions.tolist() == in_order(CLOSED, places)
        assert ("1 and 4 have the same attitudes and are told apart by time" in found.notes) == (len(numbers) == 4)


# Recordings, by the command.

QUIET = Habits(rate_hz=50.0, rest_s=(2.0, 3.0), noise_g=1e-4, angle=1e-5, seat=0.0, bench=0.0, pause=0.0, gap=0.0)


def logged(folder, schedule=SCHEDULE, visits=NUMBERS, seed=1):
    """A recording of the block on a stand that nobody measured, as a file; and the truth."""
    rng = np.random.default_rng(seed)
    stand = inclined_anew(schedule, OFF, ZERO, BOLTING, rng)
    made = recording(stand, list(visits), NOMINAL_K, U0, QUIET, rng)
    (folder / "log.csv").write_text(made.csv())
    return folder / "log.csv", stand


def means_of(run, schedule):
    """Of a run file, by position; NaN where it has none."""
    lines = [line.split(",") for line in run.read_text().splitlines() if not line.startswith("#")]
    assert lines[0][:5] == ["mounting", "position", "ux", "uy", "uz"]
    rows = np.array([list(map(float, line[:5])) for line in lines[1:]])
    places = [(one.mounting, one.number) for one in schedule.positions]
    return np.array([rows[(rows[:, :2] == place).all(axis=1), 2:5].mean(axis=0) for place in places])


def test_a_recording_leads_to_the_solution(tumble, tmp_path):
    """The whole session in one recording: the run file solves to the block, and the next command is told."""
    file, stand = logged(tmp_path)
    run = tmp_path / "run.csv"
    done = tumble("import", file, "--schedule", "inclined", "--out", run)
    assert (done.returncode, done.stderr) == (0, "")
    shown = re.search(r"1 at (\S+), 2 at (\S+), 3 at (\S+) deg", " ".join(done.stdout.split()))
    assert list(map(float, shown.groups())) == pytest.approx([one.tilt_deg for one in stand.mountings], abs=0.02)
    said = shlex.split(done.stdout.partition("\nNext:\n")[2].replace("\\\n", ""))
    assert said == ["tumble", "solve", str(run), "--schedule", "inclined", "--out", str(tmp_path / "result.json")]
    k, u0, found = inclined.solve(SCHEDULE, means_of(run, SCHEDULE))
    assert np.rad2deg(found.beta) == pytest.approx([one.tilt_deg for one in stand.mountings], abs=0.01)
    any_way = np.random.default_rng(2).normal(size=(500, 3))
    any_way /= np.linalg.norm(any_way, axis=1, keepdims=True)
    lengths = np.linalg.norm(np.linalg.solve(k, (any_way @ NOMINAL_K.T + U0 - u0).T), axis=0)
    assert lengths == pytest.approx(1.0, abs=1e-4)


def test_a_schedule_is_advised_and_what_lacks_is_asked_for(tumble, refused, tmp_path):
    file, _ = logged(tmp_path, CLOSED, range(36))
    said = refused("import", file).partition("\n")[0]
    assert said.endswith("paper does not fit: all of inclined_closed have: --schedule inclined_closed")
    file, _ = logged(tmp_path, visits=[place for place in NUMBERS if place != 12])
    done = tumble("import", file, "--schedule", "inclined", "--out", tmp_path / "run.csv")
    assert "- no rest at 2.4\n" in done.stdout
    assert done.stdout.endswith(
        "\nNext: measure the missing rest, or leave out that inclination: the estimator inclined takes\n"
        "inclinations on both sides of the level, three or more, turned in equal steps.\n"
    )


def test_a_schedule_file_of_inclinations(tumble, tmp_path):
    """Four turns at each of 0, 30 and -30 degrees."""
    fewer = [one for one in SCHEDULE.positions if one.number in (2, 4, 6, 8)]
    own = tilted(Schedule(SCHEDULE.mountings, tuple(fewer)), {1: 0.0, 2: 30.0, 3: -30.0})
    (tmp_path / "own.toml").write_text(to_toml(own))
    file, stand = logged(tmp_path, own, range(12))
    done = tumble("import", file, "--schedule", tmp_path / "own.toml", "--out", tmp_path / "run.csv")
    assert (done.returncode, done.stderr) == (0, "") and "--estimator" not in done.stdout
    assert default_estimator(CoreSchedule(own)) == "inclined"
    _, _, found = inclined.solve(own, means_of(tmp_path / "run.csv", own))
    assert np.rad2deg(found.beta) == pytest.approx([one.tilt_deg for one in stand.mountings], abs=0.02)


# Rows that say where they were taken.


def labelled(folder, names="123", visits=NUMBERS, label="angle"):
    """Ten rows a position, without a clock, with the mounting's name and the table's angle; or without these."""
    rng = np.random.default_rng(8)
    stand = inclined_anew(SCHEDULE, OFF, ZERO, BOLTING, rng)
    means = Geometry(stand).outputs(NOMINAL_K, U0)
    rows = [f"mounting,{label},ux,uy,uz"]
    for place in visits:
        one = SCHEDULE.positions[place]
        value = one.angle_deg if label == "angle" else one.number
        for x, y, z in means[place] + rng.normal(0, 1e-4, (10, 3)):
            rows.append(f"{names[one.mounting - 1]},{value:g},{x:.7f},{y:.7f},{z:.7f}")
    (folder / "rows.csv").write_text("\n".join(rows) + "\n")
    return folder / "rows.csv", stand


BY_LABELS = "signs of K: {}, assuming that the labels tell up from down; not given (--signs)"


@pytest.mark.parametrize(
    ("label", "names", "options", "said"),
    [
        ("angle", "123", (), BY_LABELS.format("+++")),
        ("position", "123", ("--signs=+++",), "mountings 1=1,2=2,3=3"),
        ("angle", "abc", ("--signs=+++",), "mountings a=1,b=2,c=3"),
        ("angle", "132", (), BY_LABELS.format("+-+")),  # up and down exchanged: nothing shows it, so it is said
    ],
)
def test_labelled_rows_of_inclinations(label, names, options, said, tumble, tmp_path):
    file, stand = labelled(tmp_path, names, label=label)
    done = tumble("import", file, "--schedule", "inclined", *options, "--out", tmp_path / "run.csv")
    assert (done.returncode, done.stderr) == (0, "") and said in " ".join(done.stdout.split())
    found = inclined.solve(SCHEDULE, means_of(tmp_path / "run.csv", SCHEDULE))[2]
    tilts = np.array([one.tilt_deg for one in stand.mountings])
    assert np.rad2deg(found.beta) == pytest.approx(-tilts[[0, 2, 1]] if names == "132" else tilts, abs=0.02)


@pytest.mark.parametrize(
    ("names", "visits", "options", "said"),
    [
        ("213", NUMBERS, (), "rest 14 is labelled 1.5, but gravity is 91.8 deg off there: correct its label, "),
        ("132", NUMBERS, ("--signs=+++",), "with these labels, channels measure axes other than their own, or "),
        ("abc", NUMBERS, (), "the mountings fit 2 ways, a=1,b=2,c=3 and a=1,b=3,c=2: choose with --mountings"),
        (
            "123",
            range(9),
            (),
            "9 positions do not show scale and bias of every channel: give the recordings of all inclinations together",
        ),
    ],
)
def test_labels_that_inclinations_deny(names, visits, options, said, refused, tmp_path):
    file, _ = labelled(tmp_path, names, visits)
    assert f"rows.csv: {said}" in refused("import", file, "--schedule", "inclined", *options)
