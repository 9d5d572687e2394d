"""`tumble plan schedule`: what a schedule is worth and takes; the one found is quick, and does what it claims."""

import math
from dataclasses import astuple, replace
from itertools import combinations

import numpy as np
import pytest
from conftest import EXAMPLES
from documents import document_of, paper_stand, valid
from test_plan_budget import plan

from tumble.core import CoreSchedule
from tumble.files.schedule_file import read_schedule, to_toml
from tumble.files.stand_file import read_stand
from tumble.model import built_in
from tumble.model.errors import Draws
from tumble.planning import schedule_search
from tumble.planning.case import Case
from tumble.planning.promise import growing_promise
from tumble.planning.schedule_search import (
    KINDS,
    ROTATIONS,
    Goal,
    NormSpread,
    Pace,
    Reach,
    _Candidates,
    fewest_samples,
    held_to,
    inclined_schedules,
    mounting_sets,
    mountings,
    plan_schedule,
    quickest,
    quickest_inclined,
    worst_norm_of,
)
from tumble.schedule import Position, Schedule
from tumble.terms import EXTENDABLE

pytestmark = pytest.mark.python

PACE = Pace(90.0, 180.0, 0.5, 100.0, 300.0)
# Worst u(|a|) in ug of two and of three mountings, nine positions each
STATED = {"paper": (14.6, 12.5), "angle": (11.1, 9.7), "lab": (36.7, 31.6)}


def case_of(name, schedule=None):
    file = EXAMPLES / f"{name}_stand.toml"
    return Case.of(read_stand(file), file, schedule)


def everything(schedule):
    return np.ones(len(schedule.positions), dtype=bool)


@pytest.mark.parametrize("name", STATED)
def test_the_worst_norm_is_the_one_stated(name):
    for schedule, stated in zip(("paper", "three_mountings"), STATED[name]):
        worst = worst_norm_of(case_of(name, built_in(schedule)), "optimal")
        assert 1e6 * worst.worst_g == pytest.approx(stated, rel=0.01)
        assert np.linalg.norm(worst.attitude) == pytest.approx(1.0)


def test_plain_least_squares_mixes_two_rotations():
    u = worst_norm_of(case_of("paper", built_in("three_mountings")), "least_squares").worst_g
    assert 1e6 * u == pytest.approx(138, rel=0.01)


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
@pytest.mark.parametrize("name", STATED)
def test_a_subset_is_worth_what_its_own_gains_say(name, estimator):
    """Information that adds up, against the gains of each subset by themselves."""
    case, whole = case_of(name), built_in("three_mountings")
    rng = np.random.default_rng(1)
    chosen = np.array([rng.permutation(np.arange(27) < count) for count in (12, 18, 26)])
    found = NormSpread(case, whole, estimator).worst(chosen, 20)
    quiet = replace(case.stand, samples=20)
    for subset, u in zip(chosen, found):
        alone = replace(case, own_schedule=whole.part(subset), stand=quiet)
        assert u == pytest.approx(worst_norm_of(alone, estimator).worst_g, rel=0.02)  # at some attitudes
        exact = NormSpread(case, whole, estimator).exact(subset, 20)
        assert u <= exact and exact == pytest.approx(worst_norm_of(alone, estimator).worst_g, rel=1e-5)


def test_a_subset_that_cannot_identify_is_far_off():
    whole = built_in("paper")
    one_mounting = np.array([position.mounting == 1 for position in whole.positions])
    for estimator in EXTENDABLE:
        spread = NormSpread(case_of("paper"), whole, estimator)
        assert spread.worst(one_mounting[None], 50)[0] > 1.0
        assert fewest_samples(spread, one_mounting, 1e-3) is None


@pytest.mark.parametrize("estimator", ["inclined", "optimal"])
@pytest.mark.parametrize("declared", [{}, {"inclination": 3e-4}, {"drift": 1e-4, "seat": 1e-3}])
@pytest.mark.parametrize("name", [*STATED, "inclined"])
def test_a_schedule_of_one_bolting_is_worth_what_its_own_gains_say(name, declared, estimator):
    case = case_of(name)
    case = replace(case, stand=replace(case.stand, **declared))
    for schedule in list(inclined_schedules(15.0, 60.0, closed=True))[3::29]:
        CoreSchedule(schedule).inclinations()
        alone = replace(case, own_schedule=schedule, stand=replace(case.stand, samples=20))
        exact = NormSpread(case, schedule, estimator).exact(everything(schedule), 20)
        assert exact == pytest.approx(worst_norm_of(alone, estimator).worst_g, rel=1e-6)


def test_schedules_of_one_bolting_are_those_that_the_closed_form_takes():
    def told(step_deg, steepest_deg, closed):
        return [
            (tuple(m.tilt_deg for m in one.mountings), tuple(p.angle_deg for p in one.positions if p.mounting == 1))
            for one in inclined_schedules(step_deg, steepest_deg, closed)
        ]

    fours, eight = [(0.0, 90.0, 180.0, 270.0), (45.0, 135.0, 225.0, 315.0)], tuple(45.0 * n for n in range(8))
    level = [(0.0, tilt, -tilt) for tilt in (15.0, 30.0)]
    assert told(45.0, 30.0, False) == [(tilts, angles) for tilts in level for angles in (*fours, eight)]
    closed = [(*tilts, 0.0) for tilts in level]
    both = [level[0], closed[0], level[1], closed[1]]
    assert told(45.0, 30.0, True) == [(tilts, angles) for tilts in both for angles in (*fours, eight)]
    assert told(45.0, 0.0, True) == []
    assert {len(angles) for _, angles in told(15.0, 60.0, False)} == {3, 4, 6, 8, 12}
    for step_deg in (15.0, 22.5, 45.0):
        for one in inclined_schedules(step_deg, 60.0, closed=True):
            assert CoreSchedule(one).inclinations() == len(one.mountings)


@pytest.mark.parametrize("estimator", ["inclined", "optimal"])
@pytest.mark.parametrize("name, norm_g", [("paper", 2e-5), ("lab", 5e-5)])
def test_no_schedule_of_one_bolting_is_quicker(name, norm_g, estimator):
    """By the gains of each by themselves."""
    case = case_of(name)

    def worst(schedule, samples):
        alone = replace(case, own_schedule=schedule, stand=replace(case.stand, samples=samples))
        return worst_norm_of(alone, estimator).worst_g

    found = quickest_inclined(case, estimator, norm_g, PACE, 45.0, 60.0)
    assert worst(found.schedule, found.samples) <= norm_g < worst(found.schedule, found.samples - 1)
    for other in inclined_schedules(45.0, 60.0, closed=False):
        spare = found.duration.total - PACE.duration(other, 0).total
        samples = int(spare * PACE.rate / len(other.positions) * (1.0 - 1e-9))  # as many as take no longer
        assert other == found.schedule or samples < 1 or worst(other, samples) > norm_g


def test_twelve_mountings_and_the_sets_of_them():
    assert (len(ROTATIONS), len(KINDS)) == (24, 12)
    assert all(np.linalg.det(one) == pytest.approx(1.0) for one in ROTATIONS)
    assert [len(mounting_sets(count)) for count in (1, 2, 3)] == [1, 6, 13]


def test_every_set_of_mountings_is_worth_as_much_as_one_that_is_tried():
    """Of a block whose axes are alike: without misalignments and with one noise."""
    case = replace(case_of("lab"), misalignment=0.0)

    def worth(kinds):
        block = mountings(kinds)
        positions = tuple(Position(one.number, n, 45.0 * n) for one in block for n in range(8))
        schedule = Schedule(block, positions)
        return NormSpread(case, schedule, "optimal").worst(everything(schedule)[None], 50)[0]

    tried = np.array([worth(kinds) for kinds in mounting_sets(2)])
    for kinds in combinations(KINDS, 2):
        assert np.abs(tried / worth(kinds) - 1.0).min() < 0.01


def test_time_by_hand():
    """45 deg take 1 s, as speed is reached and left in half a second each; the way back of 360 deg takes 4.5 s."""
    found = PACE.duration(built_in("paper"), 50)
    assert (found.moving, found.settling, found.averaging, found.remounting) == (20.5, 9.0, 9.0, 300.0)
    assert found.total == 338.5
    inclined = replace(PACE, inclining=70.0).duration(built_in("inclined_closed"), 50)
    assert (inclined.moving, inclined.remounting, inclined.inclining) == (45.5, 0.0, 210.0)
    anew = built_in("inclined").mountings
    twice = Schedule((*anew, *(replace(one, number=3 + one.number, bolting=2) for one in anew)), ())
    turned = replace(twice, positions=tuple(Position(one.number, 1, 0.0) for one in twice.mountings))
    assert astuple(PACE.duration(turned, 100)) == (0.0, 3.0, 6.0, 300.0, 240.0)
    slow = replace(PACE, acceleration=20.0).duration(built_in("diagonal"), 1)
    ways = [2 * (45 / 20) ** 0.5, *[2 * (90 / 20) ** 0.5] * 9, *[2 * (270 / 20) ** 0.5] * 2]
    assert slow.moving == pytest.approx(sum(ways), rel=1e-12)


def test_the_fewest_samples_are_the_fewest():
    case, schedule = case_of("paper"), built_in("paper")
    spread = NormSpread(case, schedule, "optimal")
    for norm_g in (1.2e-5, 2e-5, 1e-4):
        found = fewest_samples(spread, everything(schedule), norm_g)
        assert spread.exact(everything(schedule), found) <= norm_g
        assert found == 1 or spread.exact(everything(schedule), found - 1) > norm_g


def test_no_subset_of_eight_positions_is_much_quicker():
    """Against all subsets of two mountings at 0, 90, 180 and 270 deg."""
    case = case_of("paper")
    block = mountings(mounting_sets(2)[3])
    schedule = Schedule(block, tuple(Position(m.number, n + 1, 90.0 * n) for m in block for n in range(4)))
    candidates = _Candidates(NormSpread(case, schedule, "optimal"), PACE, 3e-5)
    found, _ = candidates.quickest()
    subsets = [np.isin(range(8), one) for count in (6, 7, 8) for one in combinations(range(8), count)]
    best = min(timed.duration.total for timed in map(candidates.timed, subsets) if timed is not None)
    assert best <= found.duration.total <= best + 1.0


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
def test_the_schedule_found_is_quicker_than_the_papers(estimator):
    case = case_of("paper", built_in("paper"))
    norm_g = worst_norm_of(case, estimator).worst_g
    found = quickest(case, estimator, norm_g, PACE, 45.0, 2)
    assert found.duration.total < PACE.duration(built_in("paper"), 50).total
    reached = replace(case, own_schedule=found.schedule, stand=replace(case.stand, samples=found.samples))
    assert worst_norm_of(reached, estimator).worst_g <= norm_g * 1.02  # the search looks at some attitudes
    held = held_to(case, estimator, found.schedule, norm_g, PACE)
    assert found.samples <= held.samples <= 1.05 * found.samples + 1
    assert worst_norm_of(replace(reached, stand=replace(case.stand, samples=held.samples)), estimator).worst_g <= norm_g
    assert found == quickest(case, estimator, norm_g, PACE, 45.0, 2)


def with_seats(monkeypatch, sigma):
    """Let the block's seat be off by `sigma` about h in every mounting."""
    honest = schedule_search.of_stand

    def of_stand(schedule, k, stand, names):
        from tumble.model import Geometry

        geometry, numbers = Geometry(schedule), [one.number for one in schedule.mountings]
        of = np.array([numbers.index(position.mounting) for position in schedule.positions])
        matrices = np.array([one.matrix for one in schedule.mountings])[of]
        table = np.einsum("pji,pj->pi", matrices, geometry.force())
        turned = np.einsum("pij,pj->pi", matrices, np.cross([1.0, 0.0, 0.0], table)) @ k.T
        each = (np.arange(len(numbers))[:, None] == of)[..., None] * turned
        return {**honest(schedule, k, stand, names), "seats": Draws(np.full(len(numbers), sigma), each)}

    monkeypatch.setattr(schedule_search, "of_stand", of_stand)


def test_a_declared_seat_needs_three_mountings(monkeypatch):
    """At 1e-4 rad two mountings have 72 ug whatever the samples, three 13.4."""
    case = case_of("paper")
    with_seats(monkeypatch, 1e-4)
    worst = {
        name: NormSpread(case, built_in(name), "optimal").worst(everything(built_in(name))[None], 50)[0]
        for name in ("paper", "three_mountings")
    }
    assert 1e6 * worst["paper"] == pytest.approx(72.0, rel=0.01)
    assert 1e6 * worst["three_mountings"] == pytest.approx(13.4, rel=0.015)
    assert held_to(case, "optimal", built_in("paper"), 2e-5, PACE) is None
    assert quickest(case, "optimal", 2e-5, PACE, 45.0, 2) is None
    found = quickest(case, "optimal", 2e-5, PACE, 45.0, 3)
    assert len(found.schedule.mountings) == 3


OPTIONS = ("schedule", "--norm", "2e-5", "--angles", "45", "--mountings", "2", "--inclination", "0")
INCLINED = (*OPTIONS[:-1], "60")


def test_what_is_written_is_what_was_found(tumble, tmp_path):
    document = plan(tumble, *OPTIONS, "--out", tmp_path / "quick.toml")
    read = read_schedule(str(tmp_path / "quick.toml")).data
    assert [[list(row) for row in one.matrix] for one in read.mountings] == document["schedule"]["matrices"]
    angles = [[one.angle_deg for one in read.positions if one.mounting == m.number] for m in read.mountings]
    assert angles == document["schedule"]["angles_deg"]
    assert document["schedule"]["freedom"] == 3 * len(read.positions) - 12
    assert document["goal"] == {"norm_g": 2e-5, "limit_g": None, "probability": None}
    assert document["u_norm_g"]["worst_g"] <= 2e-5 * (1 + 1e-9)
    assert document["schedule"]["seconds"] < document["beside"]["paper"]["seconds"]
    assert document["schedule"]["boltings"] == 2 and set(document["schedule"]["axis_tilts_deg"]) == {0.0}
    beside = [document["other"], *(document["beside"][name] for name in ("inclined", "inclined_closed"))]
    assert beside == [None] * 3  # the stand cannot be inclined
    for name in ("paper", "three_mountings", "diagonal"):
        (tmp_path / "again.toml").write_text(to_toml(built_in(name)))
        assert read_schedule(str(tmp_path / "again.toml")).data == built_in(name)


def test_bench_and_validate_take_it(tumble, tmp_path):
    """Simulated runs on the exact geometry have the accuracy that the plan states."""
    found = plan(tumble, *OPTIONS, "--out", tmp_path / "quick.toml")
    samples = found["schedule"]["samples"]
    stand = paper_stand(tmp_path, samples=samples)
    common = ("--stand", stand, "--schedule", tmp_path / "quick.toml", "--estimator", "optimal")
    bench = ("bench", "--seed", "3", "--samples", samples, "--out", tmp_path / "run", "--json")
    done = tumble(*bench, *common)
    assert done.returncode == 0
    result = valid(done.stdout)
    assert result["verification"]["pass"] and len(result["means"]) == found["schedule"]["positions"]
    solved = document_of(tumble("solve", tmp_path / "run/run.csv", "--unit", "V", "--json", *common))
    apart = np.abs(np.subtract(solved["K"], result["K"])) / solved["u_K"]
    assert apart.max() < 0.1  # a solve weighs at the K found, the bench at the nominal one
    validated = plan(tumble, "validate", "--runs", "4000", *common)
    assert validated["pass"]
    again = validated["estimators"]["optimal"]["promise"]
    assert again.pop("assumes") == found["promise"].pop("assumes") == ["seat"]
    promised = {key: value for key, value in found["promise"].items() if key != "growth"}
    assert again == pytest.approx(promised)


def test_of_one_bolting_it_is_told_written_read_and_solved(tumble, tmp_path):
    """Simulated runs on the exact geometry have the accuracy that the plan states, and a solve states the same."""
    file = tmp_path / "quick.toml"
    document = plan(tumble, *INCLINED, "--out", file)
    found, read = document["schedule"], read_schedule(str(file)).data
    assert (found["estimator"], document["estimator"], found["boltings"]) == ("optimal", "optimal", 1)
    assert {one.bolting for one in read.mountings} == {1}
    assert [one.tilt_deg for one in read.mountings] == found["axis_tilts_deg"] == [0.0, 60.0, -60.0]
    assert found["freedom"] == 3 * found["positions"] - 12 - 5
    assert (found["remounting_s"], found["inclining_s"]) == (0.0, 120.0)
    again = plan(tumble, *OPTIONS)
    assert document["other"] == again["schedule"] and found["seconds"] < again["schedule"]["seconds"]
    assert document["promise"]["assumes"] == []
    samples, stand = found["samples"], paper_stand(tmp_path, samples=found["samples"])
    for name, one in document["beside"].items():
        assert (one is None) == (name not in again["beside"]), name
    bench = ("--schedule", file, "--stand", stand, "--samples", samples, "--estimator", "inclined")
    assert tumble("bench", *bench, "--out", tmp_path / "run").returncode == 0
    common = ("--schedule", file, "--stand", stand)
    solved = document_of(tumble("solve", tmp_path / "run/run.csv", "--estimator", "optimal", "--json", *common))
    assert solved["u_norm_g"]["worst_g"] == pytest.approx(document["u_norm_g"]["worst_g"], rel=0.05)
    closed = plan(tumble, *INCLINED, "--estimator", "least_squares", "--out", file)
    assert closed["estimator"] == closed["schedule"]["estimator"] == "inclined" and closed["other"] is None
    paper_stand(tmp_path, samples=closed["schedule"]["samples"])
    assert plan(tumble, "validate", "--runs", "4000", "--estimator", "inclined", *common)["pass"]


@pytest.mark.parametrize(
    "name, declared, less", [("angle", {}, 3.0), ("paper", {"inclination": 0.01}, 1.719), ("lab", {}, 3.0)]
)
def test_of_one_bolting_a_limit_is_kept_by_the_quickest_also_when_less_steep(name, declared, less):
    """By brute force: what each schedule takes for the limit as it is told, and less steep."""
    case = case_of(name)
    case = replace(case, stand=replace(case.stand, **declared))
    goal, reach = Goal(None, 0.95, "optimal"), Reach(45.0, 2, 45.0)
    pace = replace(PACE, remounting=1e4, inclining=5.0)
    found = plan_schedule(case, goal, pace, reach, lambda *done, **of: None)
    best = found.best
    assert best.schedule.is_inclined and found.less_steep(best) == pytest.approx(less, abs=1e-3)

    def keeps(schedule, samples):
        nearer = tuple(
            replace(one, tilt_deg=one.tilt_deg - math.copysign(less, one.tilt_deg) if one.tilt_deg else 0.0)
            for one in schedule.mountings
        )
        growths = [
            growing_promise(
                replace(case, own_schedule=one, stand=replace(case.stand, samples=samples)), "optimal", 0.95
            ).growth
            for one in (schedule, replace(schedule, mountings=nearer))
        ]
        return min(growths) >= 1.0

    assert keeps(best.schedule, best.samples)
    for other in inclined_schedules(45.0, 45.0, closed=case.stand.declares_drift):
        spare = best.duration.total - pace.duration(other, 0).total
        samples = int(spare * pace.rate / len(other.positions) * (1.0 - 1e-9))  # as many as take no longer
        assert other == best.schedule or samples < 1 or not keeps(other, samples)


def test_what_a_stand_can_be_inclined_to_and_how_long_it_takes(tumble, tmp_path):
    found = plan(tumble, *OPTIONS[:-1], "30")
    assert found["schedule"]["axis_tilts_deg"] == [0.0, 30.0, -30.0] and found["beside"]["inclined"] is None
    slow = plan(tumble, *INCLINED, "--inclining", "600")
    assert slow["schedule"]["boltings"] == 2 and slow["other"]["inclining_s"] == 1200.0
    assert slow["pace"]["inclining_s"] == 600.0
    drifts = paper_stand(tmp_path)
    drifts.write_text(drifts.read_text().replace("[stand]", "[stand]\ndrift_v = 1e-4"))
    closed = plan(tumble, *INCLINED, "--stand", drifts, "--inclining", "0", "--estimator", "least_squares")
    first, steep, low, last = closed["schedule"]["axis_tilts_deg"]
    assert (first, last) == (0.0, 0.0) and steep == -low > 0.0
    assert closed["beside"]["inclined"] is None and closed["schedule"]["inclining_s"] == 0.0


@pytest.mark.slow
def test_a_limit_is_kept_with_the_probability_asked_for(tumble, tmp_path):
    options = ("--limit", "5e-5", "--probability", "0.9", *OPTIONS[3:])
    found = plan(tumble, "schedule", *options, "--out", tmp_path / "quick.toml")
    assert found["goal"] == {"norm_g": None, "limit_g": 5e-5, "probability": 0.9}
    assert found["promise"]["growth"] >= 1.0
    lowest = min(found["promise"]["passes"], found["promise"]["every_attitude"])
    shown = 3.0 * found["promise"]["u_norm_worst_g"] / 5e-5  # the decision rule may ask for more samples than the share
    assert lowest >= 0.9 and (lowest < 0.93 or 0.95 < shown <= 1.0)
    stand = paper_stand(tmp_path, samples=found["schedule"]["samples"])
    common = ("--stand", stand, "--schedule", tmp_path / "quick.toml", "--estimator", "optimal", "--limit", "5e-5")
    simulated = plan(tumble, "validate", "--runs", "10000", *common)["estimators"]["optimal"]["simulated"]
    for name in ("passes", "every_attitude"):
        assert simulated[name] == pytest.approx(found["promise"][name], abs=0.015)


def test_people_get_80_columns(tumble, tmp_path):
    paper_stand(tmp_path).rename(tmp_path / "my stand.toml")
    given = ("--stand", "my stand.toml", "--out", "quick.toml")
    shown = tumble("plan", *OPTIONS, *given, cwd=tmp_path).stdout
    *lines, command = shown.splitlines()
    assert max(map(len, lines)) <= 80 and "three_mountings" in shown
    files = "--schedule quick.toml --stand 'my stand.toml'"
    assert command.startswith(f"Run it: tumble bench {files} --samples ") and command.endswith("--estimator optimal")
    assert "re-mounted: needs seat, level and axis as good as declared" in shown
    shown = tumble("plan", *INCLINED, *given, cwd=tmp_path).stdout
    *lines, command, solving = shown.splitlines()
    assert max(map(len, lines)) <= 80
    assert "Found, bolted once: needs a stand that inclines to 60 deg and is locked;" in lines
    assert "Beside it, re-mounted: needs seat, level and axis as good as declared" in lines
    assert command.endswith("--estimator inclined --out run")
    assert solving == f"Solve it: tumble solve run/run.csv {files} --estimator optimal"
    mine = tmp_path / "my stand.toml"
    mine.write_text(mine.read_text().replace("[stand]", "[stand]\ninclination_rad = 0.01"))  # a gain record can be made
    assert tumble("plan", *INCLINED, *given, cwd=tmp_path).stdout.splitlines()[-1].endswith("--estimator optimal")
    assert max(map(len, tumble("plan", "schedule", "--help", COLUMNS="80").stdout.splitlines())) <= 80


BAD = {
    "both": (["--norm", "1e-5", "--limit", "1e-4"], "--norm: a worst u(|a|) takes the place of --limit and"),
    "none": (["--norm", "0"], "--norm: '0' is not a number above 0"),
    "one mounting": (["--mountings", "1"], "--mountings: '1' is not a whole number from 2 to 6"),
    "angles": (["--angles", "10"], "invalid choice: '10'"),
    "time": (["--remounting", "-1"], "--remounting: '-1' is not a number of seconds from 0"),
    "time to incline": (["--inclining", "1e7"], "--inclining: '1e7' is not a number of seconds from 0"),
    "steep": (["--inclination", "90"], "argument --inclination: invalid choice: '90'"),
    "kind": (["--out", "quick.csv"], "--out: 'quick.csv' does not end in .toml"),
    "estimator": (["--estimator", "refined"], "invalid choice: 'refined'"),
    "probability": (["--probability", "1"], "--probability: '1' is not a number from 0.5 to 0.9999"),
    "out of reach": (
        ["--norm", "1e-9", "--angles", "45", "--mountings", "2"],
        "unreachable: no schedule of at most 2 mountings, or inclined to at most 60 deg, reaches a worst u(|a|) of",
    ),
    "out of reach on a stand that does not incline": (
        ["--norm", "1e-9", "--angles", "45", "--mountings", "2", "--inclination", "0"],
        "unreachable: no schedule of at most 2 mountings reaches a worst u(|a|) of 1e-09 g here",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case, refused):
    arguments, message = BAD[case]
    assert message in refused("plan", "schedule", *arguments)


def test_a_stand_beyond_the_arithmetic_is_refused(refused, tmp_path):
    """One error alone, and no noise: information of a position beyond what a double holds beside the others'."""
    stand = tmp_path / "stand.toml"
    zeros = "".join(f"{key} = 0\n" for key in ("axis_tilt_rad", "level_rad", "remount_rad", "angle_rad", "noise_v"))
    head = '[stand]\nname = "odd"\nsamples = 50\nlimits = "sigma1"\nseat_rad = 1e-4\n'
    stand.write_text(f"{head}{zeros}[block]\nscale_v_per_g = -2.0\nmisalignment_rad = 0.02\n")
    given = ("--stand", stand, "--mountings", "3", "--angles", "45", "--norm", "1e-4")
    assert "too large, or too unequal" in refused("plan", "schedule", *given)
