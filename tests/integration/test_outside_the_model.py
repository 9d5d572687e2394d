"""What happens when a stand or a block leaves the model: the campaign of tests/benchmark/violations.py, its fast search
for causes against the product's own, and what it must show."""

import sys

import numpy as np
import pytest
from blocks import NOMINAL_K
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests/benchmark"))

import violations
from violation_rows import rows

from tumble.distributions import chi_squared_above
from tumble.estimators import LINEAR, OPTIMAL
from tumble.files.run_file import Run
from tumble.model import WholeModel, built_in
from tumble.model.fit import CONFIDENCE, judge
from tumble.model.patterns import BY_NAME, Scene
from tumble.model.stand_seen import StandSeen
from tumble.solving.solution import solve

pytestmark = pytest.mark.python
ROWS = {row.name: row for row in rows()}
NOTHING = StandSeen(None, None, 0.0, {}, {}, None)
SEEN = ("drift 100", "K3 100", "once per turn 100", "stepper, a move 20", "slip 200", "scale drift 100", "platform 300")


def judged(case, means):
    """By the product: does the run fit, and the names of its first explanation."""
    model = WholeModel(case.schedule.data, means, case.variance, case.stand)
    fit = judge(model, CONFIDENCE, NOTHING)
    return fit.fits, fit.explanations[0].patterns if fit.explanations else ()


@pytest.mark.parametrize(
    ("stand", "schedule", "runs"),
    [
        ("paper", "paper", 3),
        ("lab", "diagonal", 3),
        *(pytest.param(*one, 30, marks=pytest.mark.full) for one in (("paper", "three_mountings"), ("angle", "paper"))),
    ],
)
def test_thousands_of_runs_are_judged_as_one(stand, schedule, runs):
    """Runs near a limit may fall on its other side, for the fast search is linear."""
    case, compared, differ = violations.Case(stand, schedule), 0, 0
    for name in SEEN:
        means = ROWS[name].means(case.world(runs))
        rest = case.causes.rest(means)
        fits = (rest**2).sum(axis=1) <= case.limit
        fast = case.causes.first(rest, fits)
        for one, fits_fast, names in zip(means, fits, fast):
            slow_fits, slow = judged(case, one)
            right = [bool(set(found) & set(ROWS[name].causes)) for found in (slow, names)]
            compared += 1
            differ += slow_fits != fits_fast or bool(slow) != bool(names) or right[0] != right[1]
    print(f"{stand}, {schedule}: {differ} of {compared} differ")
    assert differ <= 0.05 * compared


@pytest.mark.parametrize("schedule", violations.SCHEDULES)
@pytest.mark.parametrize("stand", violations.STANDS)
def test_honest_runs_are_left_alone(stand, schedule, request):
    """One in a thousand does not fit, at most one more is said to show something."""
    runs = 10_000 if request.config.getoption("--full") else 1000
    found = violations.Case(stand, schedule).cell(ROWS["nothing"], runs)
    print(f"{stand}, {schedule}: {found.failed:.2%} do not fit, {found.told:.2%} are told of something")
    assert found.failed <= (0.002 if runs == 10_000 else 0.006) and found.told <= (0.003 if runs == 10_000 else 0.008)
    assert abs(found.coverage - 0.954).max() < 5 * np.sqrt(0.954 * 0.046 / runs)


def test_every_estimator_has_the_same_verdict():
    case = violations.Case("paper", "three_mountings")
    means = ROWS["drift 100"].means(case.world(1))[0]
    run = Run(case.samples, means, np.full(means.shape, case.stand.noise), "V", {})
    verdicts = [solve(run, case.schedule, name, 1.0, case.stand, "run.csv").fit for name in (*LINEAR, OPTIMAL)]
    assert len(verdicts) == 4 and all(one == verdicts[0] for one in verdicts) and not verdicts[0].fits


@pytest.mark.parametrize("name", SEEN)
def test_three_mountings_tell_what_is_wrong_and_what_it_is(name):
    """At sizes that cost the coverage of some coefficient: told in most runs, and rightly explained."""
    found = violations.Case("paper", "three_mountings").cell(ROWS[name], 200)
    assert found.coverage.min() < 0.9 and found.told > 0.6 and found.explained > 0.85
    assert found.told <= found.best + 0.05


def test_two_mountings_never_tell_a_platform_that_is_not_square():
    """No test of residuals can: not even the best one finds it more often than its false alarms."""
    found = violations.Case("paper", "paper").cell(ROWS["platform 2000"], 200)
    assert found.coverage.min() == 0.0 and found.told < 0.02 and found.best == pytest.approx(0.001, abs=1e-4)


def test_the_diagonals_never_tell_a_third_order():
    found = violations.Case("paper", "diagonal").cell(ROWS["K3 300"], 200)
    assert found.coverage.min() == 0.0 and found.told < 0.02 and found.best == pytest.approx(0.001, abs=1e-4)


@pytest.mark.parametrize("name", ["channels y, z exchanged", "y, z exchanged within the run"])
def test_exchanged_channels_are_refused(name):
    assert violations.Case("lab", "paper").cell(ROWS[name], 20).failed == 1.0


def test_the_false_alarms_of_a_limit_are_those_of_chi_squared():
    case = violations.Case("angle", "paper")
    assert chi_squared_above(case.limit, case.causes.freedom) == pytest.approx(1 - CONFIDENCE, rel=1e-6)


def test_two_columns_of_the_table():
    cell = violations.Cell(np.full((2, 12), 0.5), 0.25, 0.5, 0.75, 1.0)
    assert violations.columns(ROWS["drift 100"], cell) == ("50, 50; 50, 50", "25, 50, 75, 100")
    none = violations.Cell(np.full((2, 12), np.nan), 1.0, 1.0, 0.0, 1.0)
    assert violations.columns(ROWS["channels y, z exchanged"], none) == ("-; -", "100, 100, -, 100")


@pytest.mark.parametrize("name", ["noise AR(1) 0.5", "undithered, not declared"])
def test_noise_that_is_not_white_is_told_and_counted(name):
    found = violations.Case("paper", "paper").cell(ROWS[name], 400)
    assert found.told > 0.98 and found.coverage.min() > 0.85


def test_a_seat_is_told_by_its_mounting():
    """As in "seat of mounting 1, theta_n -306 +- 22 urad"."""
    found = BY_NAME["seat"].columns(Scene(built_in("paper"), NOMINAL_K))
    labels = [f"mounting {number}, {name}" for name in ("theta_h", "theta_n") for number in (1, 2)]
    assert [label for columns in found for label in columns] == labels
