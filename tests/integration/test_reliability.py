"""What a run could not have shown: by the formula, by simulated runs, and where it is said."""

import json
import math
import sys
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest
from blocks import NOMINAL_K
from conftest import EXAMPLES, ROOT
from test_whole_model import beyond

sys.path.insert(0, str(ROOT / "tests/benchmark"))

import violations
from violation_rows import U0, K, honest

from tumble.distributions import chi_squared_log_above, chi_squared_quantile, noncentrality
from tumble.files.stand_file import read_stand
from tumble.model import built_in
from tumble.model.coefficients import spread_attitudes
from tumble.model.fit import CONFIDENCE, DOUBTS, basis
from tumble.model.patterns import BY_NAME, PATTERNS, Scene
from tumble.model.propagation import Propagation
from tumble.model.reliability import Undetected, largest, lines, reliability

pytestmark = pytest.mark.python
WORDS = {
    "drift": "drift, µg",
    "k2": "K2, µg/g²",
    "k3": "K3, µg/g³",
    "hysteresis": "hysteresis, µg",
    "step": "step, µg",
    "twice_per_turn": "twice per turn, µrad",
}
CHECKED = tuple(WORDS)
POWERS = {"k2": 2, "k3": 3}
TESTS = 20  # patterns, and the noise that samples show
OF_THE_PAGE = tuple(name for name in violations.SCHEDULES if name != "inclined")  # which has a page of its own
ESTIMATORS = ("optimal", "refined")


@cache
def found(stand="paper", schedule="paper", estimator="refined"):
    """By name."""
    declared = read_stand(str(EXAMPLES / f"{stand}_stand.toml")).stand
    positions = built_in(schedule)
    samples = np.full(len(positions.positions), declared.samples)
    listed = reliability(Propagation(positions, NOMINAL_K, declared, samples, estimator, 0.0))
    return {one.pattern.name: one for one in listed}


@pytest.mark.parametrize(
    ("estimator", "name", "size", "error_ug"),
    [
        ("optimal", "drift", 97, 38),
        ("optimal", "k2", 101, 68),
        ("optimal", "k3", 206, 90),
        ("optimal", "hysteresis", 66, 71),
        ("refined", "drift", 141, 10),
        ("refined", "k2", 101, 76),
        ("refined", "k3", 279, 70),
        ("refined", "hysteresis", 66, 53),
    ],
)
def test_the_values_of_the_method(estimator, name, size, error_ug):
    """Computed elsewhere, for a noncentrality of 34.9: that of 20 tests is 34.1, so these sizes are 1.2 % larger."""
    one = found(estimator=estimator)[name]
    assert one.size == pytest.approx(size, rel=0.02) and 1e6 * one.norm_g == pytest.approx(error_ug, rel=0.03)


DECLARED = {
    "seat": ("seat", {"seat"}), "platform": ("platform", {"seat"}), "drift": ("drift", {"drift"}),
    "encoder": ("encoder", {"once_per_turn", "twice_per_turn"}),
}  # fmt: skip


@pytest.mark.parametrize("case", DECLARED)
def test_what_is_declared_is_in_the_uncertainties_and_not_listed(case):
    source, names = DECLARED[case]
    plain = read_stand(str(EXAMPLES / "paper_stand.toml")).stand
    schedule, samples = built_in("paper"), np.full(18, 50)
    listed = [
        {one.pattern.name for one in reliability(Propagation(schedule, NOMINAL_K, stand, samples, "refined", 0.0))}
        for stand in (plain, plain.with_sigma(source, 1e-4))
    ]
    assert listed[0] - listed[1] == names and listed[1] < listed[0]


def test_what_is_listed():
    """The largest error first, and at the end what no size shows."""
    listed = found().values()
    assert {one.pattern.name for one in listed} == {one.name for one in PATTERNS} - set(DOUBTS)
    errors = [one.norm_g for one in listed]
    known = [error for error in errors if error is not None]
    assert known == sorted(known, reverse=True) and errors == known + [None] * 2
    assert [one.pattern.name for one in listed if one.size is None] == ["cross_coupling", "seat"]
    assert largest(tuple(listed)) == known[0]
    assert found(schedule="diagonal")["k3"].norm_g is None and found(schedule="three_mountings")["seat"].size > 0


@pytest.mark.parametrize("freedom", [1, 3, 6])
@pytest.mark.parametrize("false_alarms", [1e-3, 1e-3 / 540])
def test_the_noncentrality(freedom, false_alarms):
    shift = noncentrality(freedom, false_alarms, 0.9)
    assert beyond(shift, freedom, chi_squared_quantile(1 - false_alarms, freedom)) == pytest.approx(0.9, abs=1e-9)


def test_of_one_column_it_is_that_of_a_normal():
    shift = math.sqrt(noncentrality(1, 1e-3, 0.9))
    above = 0.5 * math.erfc((3.2905267 - shift) / math.sqrt(2))
    assert shift**2 == pytest.approx(20.9, abs=0.05) and above == pytest.approx(0.9, abs=1e-6)


def own_share(case, name, rest):
    """Share of runs in which the pattern's own test finds it, as `solve` corrects it."""
    places, squares = BY_NAME[name].columns(Scene(case.schedule.data, K)), []
    model = case.causes._model
    for columns in places:
        space = basis(model.whitened(columns))
        squares.append(((rest @ space) ** 2).sum(axis=1))
    limit = math.log((1 - CONFIDENCE) / TESTS / len(places))
    tails = [chi_squared_log_above(square, space.shape[1]) for square in np.max(squares, axis=0)]
    return float(np.mean(np.array(tails) <= limit))


def error_g(case, one, estimator, means):
    """The largest error of |a| that a block shows which is calibrated by runs with a pattern, on average, less that of
    runs without. A second or third order it keeps."""
    estimate = case.estimate[estimator]
    twelve = violations.TRUTH + (estimate(means + one.outputs) - estimate(means)).mean(axis=0)
    force, attitudes = case.world(1).geometry.force(), spread_attitudes(20000)
    outputs = attitudes @ K.T + U0
    if one.pattern.name in POWERS:
        power = POWERS[one.pattern.name]
        volts = (one.outputs * force**power).sum(axis=0) / (force ** (2 * power)).sum(axis=0)
        outputs = outputs + volts * attitudes**power
    shown = np.linalg.solve(twelve[:9].reshape(3, 3), (outputs - twelve[9:]).T).T
    return np.abs(np.linalg.norm(shown, axis=1) - 1).max()


@dataclass(frozen=True)
class Simulated:
    """Shares of runs, with as much of a pattern as the formula says, that `own` test and any test find; `error_g`."""

    own: float
    any: float
    error_g: float


def simulated(schedule, estimator, name, runs):
    case, one = violations.Case("paper", schedule), found("paper", schedule, estimator)[name]
    means = honest(case.world(runs))
    rest = case.causes.rest(means + one.outputs)
    fits = (rest**2).sum(axis=1) <= case.limit
    told = ~fits | np.array([bool(names) for names in case.causes.first(rest, fits)])
    return Simulated(own_share(case, name, rest), float(told.mean()), error_g(case, one, estimator, means))


def cell(said, one):
    """Of the table on the page: size and error as said; per cent found by its own test, by any; error found."""
    return f"{expected(said)}; {100 * one.own:.0f}, {100 * one.any:.0f}; {1e6 * one.error_g:.3g}"


def expected(said):
    return f"{said.size:.3g} → {1e6 * said.norm_g:.3g}"


def hold(said, one):
    assert one.own == pytest.approx(0.9, rel=0.05) and one.any > 0.9 * 0.95
    assert one.error_g == pytest.approx(said.norm_g, rel=0.05)


@pytest.mark.parametrize(
    ("schedule", "estimator", "name"),
    [
        ("paper", "refined", "drift"),
        ("paper", "optimal", "k3"),
        ("three_mountings", "optimal", "hysteresis"),
        ("three_mountings", "refined", "step"),
        ("diagonal", "refined", "k2"),
        ("diagonal", "optimal", "twice_per_turn"),
    ],
)
def test_nine_of_ten_are_found_and_the_error_is_as_said(schedule, estimator, name):
    hold(found("paper", schedule, estimator)[name], simulated(schedule, estimator, name, 1000))


@pytest.mark.parametrize("schedule", OF_THE_PAGE)
def test_the_page_has_these_sizes_and_errors(schedule):
    rows = (ROOT / "docs/outside_the_model.md").read_text().partition("## What a run could not")[2].splitlines()
    cells = [row.split(" | ")[1 + OF_THE_PAGE.index(schedule)] for row in rows if row.startswith("| ")][1:]
    said = [found("paper", schedule, estimator)[name] for name in CHECKED for estimator in ESTIMATORS]
    told = ["never" if one.size is None else expected(one) for one in said]
    assert [cell.partition(";")[0].removesuffix(" |") for cell in cells[: len(told)]] == told


@pytest.mark.full
def test_the_table_of_the_page():
    """Prints it: `pytest --full -s -k table`."""
    print(f"\n| | {' | '.join(f'`{name}`' for name in OF_THE_PAGE)} |\n|---|---|---|---|")
    for name in CHECKED:
        for estimator in ESTIMATORS:
            cells = []
            for schedule in OF_THE_PAGE:
                said = found("paper", schedule, estimator)[name]
                cells.append("never")
                if said.size is not None:
                    one = simulated(schedule, estimator, name, 4000)
                    cells[-1] = cell(said, one)
                    hold(said, one)
            print(f"| {WORDS[name]}, `{estimator}` | {' | '.join(cells)} |", flush=True)


PAPER = ("--stand", EXAMPLES / "paper_stand.toml")


def words(text):
    return " ".join(text.split())


def test_a_result_says_it(tumble):
    """In JSON and at the terminal, the same for the same stand and schedule."""
    command = ("solve", EXAMPLES / "paper_stand.csv", *PAPER)
    result = json.loads(tumble(*command, "--json").stdout)
    by_name = {one["pattern"]: one for one in result["reliability"]}
    assert list(by_name["k3"]) == ["pattern", "size", "unit", "norm_error_g"]
    assert by_name["k3"]["size"] == pytest.approx(found()["k3"].size, rel=0.02) and by_name["k3"]["unit"] == "ug/g^3"
    assert by_name["seat"]["size"] is by_name["seat"]["norm_error_g"] is None
    worst = result["reliability"][0]
    assert result["reliability_norm_g"] == worst["norm_error_g"] == pytest.approx(92e-6, rel=0.02)
    shown = tumble(*command).stdout
    assert max(map(len, shown.splitlines())) <= 80
    assert (
        f"{BY_NAME[worst['pattern']].description.capitalize()} below {worst['size']:.3g} {worst['unit']} could go"
        f" unnoticed; it would change |a| by up to {1e6 * worst['norm_error_g']:.3g} ug"
        " A run like this cannot show, at any size: a product of two axes in the block's outputs; a tilt of the"
        " mountings on the platform"
    ) in words(shown)


def test_without_a_stand_nothing_is_said(tumble):
    done = tumble("solve", EXAMPLES / "paper_stand.csv", "--json")
    result = json.loads(done.stdout)
    assert done.returncode == 0 and result["reliability"] is result["reliability_norm_g"] is None
    assert "A run like this" not in tumble("solve", EXAMPLES / "paper_stand.csv").stdout


def test_a_plan_says_it_before_the_run(tumble):
    """Of the nominal block, by the same function."""
    command = ("plan", "budget", *PAPER, "--schedule", "diagonal", "--estimator", "optimal")
    plan, said = json.loads(tumble(*command, "--json").stdout), found("paper", "diagonal", "optimal")
    assert [(one["pattern"], one["size"]) for one in plan["reliability"]] == [
        (name, one.size if one.size is None else pytest.approx(one.size, rel=1e-9)) for name, one in said.items()
    ]
    shown = words(tumble(*command).stdout)
    said = "A second-order term of the block below 248 ug/g^2 could go unnoticed; it would change |a| by up to 155 ug"
    assert said in shown
    assert "A run like this cannot show, at any size: a third-order term of the block" in shown
    published = json.loads(tumble("plan", "budget", "--weights", "published", "--json").stdout)
    assert published["reliability"] is published["reliability_norm_g"] is None


def test_a_planned_schedule_says_it(tumble):
    command = ("plan", "schedule", "--norm", "3e-5", "--angles", "45")
    plan = json.loads(tumble(*command, "--json").stdout)
    assert plan["reliability_norm_g"] == max(one["norm_error_g"] or 0.0 for one in plan["reliability"]) > 3e-5
    assert "could go unnoticed; it would change |a| by up to" in words(tumble(*command).stdout)


def test_a_report_has_a_table_of_it(tumble, tmp_path):
    result, report = tmp_path / "result.json", tmp_path / "report.html"
    tumble("solve", EXAMPLES / "paper_stand.csv", *PAPER, "--out", result)
    assert tumble("report", result, "--out", report).returncode == 0
    section = report.read_text().partition("<h2>What this run could not have shown</h2>")[2].partition("</section>")[0]
    assert section.count("<tr>") == 7 and 'data-path="/reliability/0/norm_error_g" data-power="6">92<' in section
    never = section.partition("Would not have shown at any size: ")[2]
    assert "a product of two axes" in never and "a tilt of the mountings" in never
    older = json.loads(result.read_text())
    del older["reliability"], older["reliability_norm_g"]
    result.write_text(json.dumps(older))
    assert tumble("report", result, "--out", report).returncode == 0
    assert "could not have shown" not in report.read_text()


def test_no_residuals_show_nothing():
    """As many outputs as unknowns."""
    stand, positions = read_stand(str(EXAMPLES / "paper_stand.toml")).stand, built_in("six_faces")
    four = positions.part(np.array([True, True, True, False, True, False]))
    listed = reliability(Propagation(four, NOMINAL_K, stand, np.full(4, 50), "least_squares", 0.0))
    assert listed and largest(listed) is None and all(one.size is one.norm_g is None for one in listed)
    assert "A run like this cannot show, at any size: " in words(" ".join(lines(listed)))


def test_large_sizes_are_shown_in_percent_or_milli():
    """What a block laid by hand shows is coarse: no exponents."""
    drift = Undetected(BY_NAME["scale_drift"], 9.04e4, 0.0451)
    assert words(" ".join(lines([drift]))) == (
        "A scale drift below 9.04 % could go unnoticed; it would change |a| by up to 45.1 mg"
    )
    assert "below 2580 ppm could" in lines([replace(drift, size=2580.0)])[0]
