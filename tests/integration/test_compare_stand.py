"""What two calibrations share of one stand: against the reference, and how often pairs of runs are said to differ."""

import math
from dataclasses import replace

import numpy as np
import pytest
from blocks import NOMINAL_K, write_run
from conftest import EXAMPLES
from documents import paper_stand, valid

from tumble.comparison.verdict import Calibration, Verdict, judge
from tumble.core import CoreSchedule, estimate_runs
from tumble.distributions import chi_squared_quantile
from tumble.files.stand_file import read_stand
from tumble.fixture.judge import repeats
from tumble.model import built_in, optimal_covariance
from tumble.model.errors import exact_outputs, sources
from tumble.model.propagation import Propagation
from tumble.solving.computation import estimator_for
from tumble.stand import PAPER_STAND

pytestmark = pytest.mark.python
U0 = np.array([0.01, -0.02, 0.03])
ANEW = {"axis_tilt": 0.0, "level": 0.0, "platform": 0.0, "encoder": 0.0}
SHARED = ["alpha1", "alpha2", "platform", "encoder"]
RICH = replace(PAPER_STAND, platform=1e-4, encoder=3e-5, seat=2e-5, axis_tilt=1e-4)
SCHEDULES = {name: built_in(name) for name in ("paper", "three_mountings", "diagonal")}


def ones(schedule):
    return np.ones(len(schedule.positions), dtype=int)


def run_of(schedule, k, stand, estimator):
    """How errors reach a run of means."""
    return Propagation(schedule, k, stand, ones(schedule), estimator)


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares", "optimal"])
@pytest.mark.parametrize("name", SCHEDULES)
def test_what_is_shared_is_all_but_what_a_stand_without_it_has(name, estimator):
    """Of one K: the covariance of the difference is twice that of the same stand without the shared errors."""
    schedule, k = SCHEDULES[name], NOMINAL_K
    errors = run_of(schedule, k, RICH, estimator).brought()
    assert [name for name in errors if repeats(name, True)] == SHARED
    total, both = sum(one.T @ one for one in errors.values()), of_a_run(np.concatenate([k.ravel(), U0]), errors, True)
    left = judge(both, both, 0.0, 0.999).coefficients.u ** 2
    if estimator == "optimal":
        expected = 2.0 * sum(one.T @ one for name, one in errors.items() if name not in SHARED)
        bound = optimal_covariance(schedule, k, RICH, ones(schedule), 0.0, np.zeros((len(ones(schedule)), 3)))
        assert total == pytest.approx(bound, rel=1e-6, abs=1e-7 * np.abs(bound).max())
    else:
        expected = 2.0 * Propagation(schedule, k, replace(RICH, **ANEW), ones(schedule), estimator).covariance()
    assert left == pytest.approx(np.diag(expected), rel=1e-9)


def of_a_run(values, errors, once):
    """A calibration with what returns with every run told apart; with nothing where there was not one stand."""
    returns = [name for name in errors if once and repeats(name, True)]
    own = sum(one.T @ one for name, one in errors.items() if name not in returns)
    return Calibration(values, own, (), np.concatenate([np.zeros((0, 12)), *(errors[name] for name in returns)]))


def test_the_schedules_of_the_two_may_differ():
    """Brute force: one draw of what is shared, through both, 20,000 times."""
    rng, found = np.random.default_rng(21), []
    one = replace(RICH, noise=0.0, angle=0.0, remount=0.0, seat=0.0)
    both = [SCHEDULES[name] for name in ("paper", "diagonal")]
    draws = [run_of(each, NOMINAL_K, one, "refined").brought() for each in both]
    expected = sum(draws[0][name].T @ draws[1][name] for name in SHARED)
    common = rng.standard_normal((20000, 7))
    for each in both:
        errors = sources(each, NOMINAL_K, one, ones(each))
        kept = {source: error for source, error in errors.items() if source in SHARED}
        found.append(estimate_runs(CoreSchedule(each), exact_outputs(each, NOMINAL_K, U0, kept, common), "refined"))
    a, b = (one - one.mean(axis=0) for one in found)
    u = [one.std(axis=0) for one in (a, b)]
    scaled = (a.T @ b / len(a) - expected) / np.outer(*u)
    assert np.abs(scaled).max() < 6.0 / math.sqrt(len(a))


DECLARED = replace(PAPER_STAND, platform=1e-4, encoder=3e-5, seat=2e-5)


@pytest.fixture
def two_results(tumble, tmp_path):
    """Two solved runs of a block on the stand DECLARED, which was levelled once: a.json and b.json. Returns the stand
    file."""

    def make(schedules=("paper", "paper"), estimators=("refined", "refined"), model=None):
        rng, file, same = np.random.default_rng(22), paper_stand(tmp_path), {}
        more = "samples = 50\nplatform_rad = 1e-4\nencoder_rad = 3e-5\nseat_rad = 2e-5"
        file.write_text(file.read_text().replace("samples = 50", more))
        for name, schedule, estimator in zip("ab", schedules, estimators):
            errors = sources(SCHEDULES[schedule], NOMINAL_K, DECLARED, ones(SCHEDULES[schedule]))
            drawn = {source: rng.standard_normal(len(one.sigma)) for source, one in errors.items()}
            drawn |= {source: same.setdefault(source, drawn[source]) for source in SHARED}
            draws = np.concatenate([*drawn.values()])
            means = exact_outputs(SCHEDULES[schedule], NOMINAL_K, U0, errors, draws[None])[0]
            run = write_run(tmp_path / f"{name}.csv", SCHEDULES[schedule], means)
            given = "--stand", file, "--schedule", schedule, "--estimator", estimator, "--limit", "1e-3"
            given += ("--out", f"{name}.json", *(("--model", model) if model else ()))
            done = tumble("solve", run, *given, cwd=tmp_path)
            assert done.returncode == 0, done.stderr
        return file

    return make


@pytest.mark.parametrize("estimators", [("refined", "refined"), ("optimal", "optimal"), ("averaged", "optimal")])
def test_the_stand_file_tells_what_is_shared(estimators, two_results, tumble, tmp_path):
    stand = two_results(("paper", "three_mountings"), estimators)
    found = {}
    for levelled, names in (("anew", ["platform", "encoder"]), ("once", SHARED)):
        done = tumble("compare", "a.json", "b.json", "--stand", stand, "--levelled", levelled, "--json", cwd=tmp_path)
        found[levelled] = valid(done.stdout, "comparison")
        assert (done.returncode, done.stderr) == (0, "")
        assert found[levelled]["shared"] == {"stand": str(stand), "levelled": levelled, "sources": names}
    alone = valid(tumble("compare", "a.json", "b.json", "--json", "--two-stands", cwd=tmp_path).stdout, "comparison")
    u = [np.array([row["u"] for row in one["coefficients"]]) for one in (alone, found["anew"], found["once"])]
    assert (u[0] > u[1]).any() and (u[1] > u[2]).any() and (u[0] >= 0.999 * u[1]).all()
    assert alone["shared"] == {"stand": None, "levelled": None, "sources": None}


@pytest.mark.parametrize("estimators", [("least_squares", "least_squares"), ("least_squares", "optimal")])
def test_further_terms_share_their_part_of_the_stand(estimators, two_results, tumble, tmp_path):
    """K2 and K3 with a drift: nothing comes out as certain that is not, and K2 is no surer than the noise leaves it."""
    stand = two_results(("three_mountings", "three_mountings"), estimators, "k2,k3,drift")
    told = {}
    for once in (True, False):
        given = ("--stand", stand, "--levelled", "once") if once else ("--two-stands",)
        done = tumble("compare", "a.json", "b.json", *given, "--json", cwd=tmp_path)
        told[once] = valid(done.stdout, "comparison")
        assert (done.returncode, done.stderr, told[once]["verdict"]) == (0, "", "unchanged")
    assert told[True]["shared"]["sources"] == SHARED
    u = {once: np.array([row["u"] for row in one["parameters"]]) for once, one in told.items()}
    assert len(u[True]) == 15 and (u[True] <= u[False] * 1.001).all() and (u[True] > 0.1 * u[False]).all()
    assert (u[True] < 0.9 * u[False]).any()


def test_a_stand_that_does_not_give_the_uncertainties_is_told(two_results, tumble, tmp_path):
    two_results()
    done = tumble("compare", "a.json", "b.json", "--stand", EXAMPLES / "lab_stand.toml", "--json", cwd=tmp_path)
    said = "with a schedule that is known (--schedule) does not give the uncertainties of both"
    assert done.stderr == f"tumble: warning: {EXAMPLES}/lab_stand.toml {said}: nothing is counted as shared\n"
    found = valid(done.stdout, "comparison")
    assert found["shared"]["sources"] is None and found["notes"][0].startswith("Nothing is counted as shared.")


# How often it says what. Thousands of pairs, solved by the core, stated at each run's own K as a solve does.


def pairs(rng, stand, count, once, change=lambda k, u0: (k, u0), schedule="paper", estimator="refined"):
    """Verdicts on pairs of runs, the second of a block that has changed; `once`: on one stand that was levelled once,
    and told so; else on two stands."""
    positions = SCHEDULES[schedule]
    errors = sources(positions, NOMINAL_K, stand, ones(positions))
    sizes = [len(one.sigma) for one in errors.values()]
    ends = np.cumsum(sizes)
    first, second = rng.standard_normal((2, count, ends[-1]))
    for name, end, size in zip(errors, ends, sizes):
        if once and repeats(name, True):
            second[:, end - size : end] = first[:, end - size : end]
    solve = estimator_for(run_of(positions, NOMINAL_K, stand, estimator))
    runs = []
    for draws, (k, u0) in zip((first, second), ((NOMINAL_K, U0), change(NOMINAL_K, U0))):
        runs.append(solve(exact_outputs(positions, k, u0, errors, draws)))
    return [compared(a, b, positions, stand, estimator, once) for a, b in zip(*runs)]


def compared(a, b, positions, stand, estimator, once):
    given = [run_of(positions, run[:9].reshape(3, 3), stand, estimator).brought() for run in (a, b)]
    return judge(*(of_a_run(run, errors, once) for run, errors in zip((a, b), given)), 0.0, 0.999)


def nominal(stand, once, schedule="paper"):
    """What a pair without errors states: u of the parameters and of the seat."""
    same = np.concatenate([NOMINAL_K.ravel(), U0])
    found = compared(same, same, SCHEDULES[schedule], stand, "refined", once)
    return found.parameters.u, found.seat.u


def scaled(size):
    """A block whose scale factor x has changed by this part."""
    return lambda k, u0: (k * (1.0 + size * np.eye(3)[0])[:, None], u0)


def turned(size):
    """A block that sits turned about x."""
    c, s = math.cos(size), math.sin(size)
    return lambda k, u0: (k @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]), u0)


def binomial_range(count, p, beyond=1e-6):
    """Fewest and most of `count` that are not rarer than `beyond` on either side, where each has probability p."""
    chances = np.array([math.comb(count, k) * p**k * (1.0 - p) ** (count - k) for k in range(count + 1)])
    low = int(np.argmax(np.cumsum(chances) > beyond))
    high = count - int(np.argmax(np.cumsum(chances[::-1]) > beyond))
    return low, high


def seen_alone(size):
    """Probability that a parameter which has changed by so many u is found by itself: z beyond the point of p = 1e-3
    over three questions and nine parameters. Less than that of the whole test."""
    point = math.sqrt(chi_squared_quantile(1.0 - 1e-3 / 27.0, 1.0))
    return 0.5 * math.erfc((point - size) / math.sqrt(2.0))


def seen_turned(size):
    """The same of a turn about one axis that is known to u with the others unknown: chi-squared of three, shifted by at
    least the square of that."""
    draws = np.random.default_rng(1).noncentral_chisquare(3, size**2, 200000)
    return float((draws > chi_squared_quantile(1.0 - 1e-3 / 3.0, 3.0)).mean())


def share_of(found, verdict):
    return sum(one.verdict is verdict for one in found)


WORDS = {True: "one stand", False: "two stands"}
COUNTS = [100, pytest.param(1000, marks=pytest.mark.full)]
STANDS = {"paper": PAPER_STAND, "rich": RICH, "lab": read_stand(str(EXAMPLES / "lab_stand.toml")).stand}


@pytest.mark.slow
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("once", [True, False], ids=["one stand", "two stands"])
@pytest.mark.parametrize("name", STANDS)
def test_an_unchanged_block_is_called_unchanged(name, once, count, fresh_seed):
    found = pairs(np.random.default_rng(fresh_seed), STANDS[name], count, once)
    unchanged = share_of(found, Verdict.UNCHANGED)
    squares = [one.tests.all_twelve.chi2 for one in found]
    print(f"{name}, {WORDS[once]}: {unchanged} of {count} unchanged, mean chi-squared {np.mean(squares):.2f}")
    assert unchanged >= min(binomial_range(count, 0.999)[0], math.ceil(0.995 * count))
    assert np.mean(squares) == pytest.approx(12.0, abs=5.0 * math.sqrt(24.0 / count))


@pytest.mark.slow
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("once", [True, False], ids=["one stand", "two stands"])
@pytest.mark.parametrize("size", [1.0, 3.0, 5.0])
def test_a_scale_factor_that_has_changed_is_found_as_often_as_it_can_be(size, once, count, fresh_seed):
    u = nominal(RICH, once)[0][0]
    found = pairs(np.random.default_rng(fresh_seed), RICH, count, once, scaled(math.expm1(size * u)))
    block, named = share_of(found, Verdict.BLOCK), sum(bool(one.changed[0]) for one in found)
    others = sum(bool(one.changed[1:].any()) for one in found)
    explained = sum(one.explanation is not None and one.explanation.index == 0 for one in found)
    print(f"{size} u, {WORDS[once]}: {block} of {count} found, {named} named, {explained} explained by it")
    assert block >= binomial_range(count, seen_alone(size))[0]
    assert named <= block and others <= binomial_range(count, 0.001)[1]
    sizes = np.array([one.parameters.size[0] for one in found])
    assert sizes.mean() == pytest.approx(size * u, abs=5.0 * u / math.sqrt(count))
    assert sizes.std(ddof=1) == pytest.approx(u, rel=5.0 / math.sqrt(2.0 * count))


@pytest.mark.slow
@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("once", [True, False], ids=["one stand", "two stands"])
@pytest.mark.parametrize("size", [1.0, 3.0, 5.0])
def test_a_seat_that_has_changed_is_no_change_of_the_block(size, once, count, fresh_seed):
    u = nominal(RICH, once)[1][0]
    found = pairs(np.random.default_rng(fresh_seed), RICH, count, once, turned(size * u))
    seat, block = share_of(found, Verdict.SEAT), share_of(found, Verdict.BLOCK)
    print(f"{size} u, {WORDS[once]}: seat {seat}, block {block} of {count}")
    assert seat >= binomial_range(count, seen_turned(size))[0]
    assert block <= binomial_range(count, 0.001)[1]


def test_to_count_once_is_sharper():
    """Most of all for biases, which the axis tilt moves, and for turns about y and z."""
    (one, turn), (two, turn_of_two) = nominal(RICH, True), nominal(RICH, False)
    assert (one <= two * (1 + 1e-9)).all() and one[6:].max() < 0.5 * two[6:].max()
    assert (turn <= turn_of_two * (1 + 1e-9)).all() and (turn[1:] < 0.8 * turn_of_two[1:]).all()


def test_errors_that_a_levelling_does_not_repeat_are_not_taken_for_shared(fresh_seed):
    """The canary: two stands that are taken for one come out as changed."""
    rng, positions = np.random.default_rng(fresh_seed), SCHEDULES["paper"]
    errors = sources(positions, NOMINAL_K, RICH, ones(positions))
    draws = rng.standard_normal((2, 20, sum(len(one.sigma) for one in errors.values())))
    outputs = [exact_outputs(positions, NOMINAL_K, U0, errors, one) for one in draws]
    runs = [estimate_runs(CoreSchedule(positions), one, "refined") for one in outputs]
    found = [compared(a, b, positions, RICH, "refined", True) for a, b in zip(*runs)]
    assert share_of(found, Verdict.UNCHANGED) < 10
