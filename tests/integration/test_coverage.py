"""Effective degrees of freedom and coverage factors: against the GUM's own example, exact quantiles, and simulation."""

import math

import mpmath
import numpy as np
import pytest
from conftest import EXAMPLES
from documents import valid
from hypothesis import given, strategies as st
from test_noise import OUTPUTS, POSITIONS, K, autoregressive, noisy_run, run_of, solved

from tumble import model
from tumble.cli import output
from tumble.core import CoreSchedule, paper_schedule
from tumble.model.estimators import estimate
from tumble.solving.result import coverage_of
from tumble.solving.solution import solve
from tumble.solving.uncertainty import Coverage, effective
from tumble.stand import PAPER_STAND

pytestmark = pytest.mark.python


def exact_t(freedom, p=0.95):
    """Student's t, two-sided, by mpmath's own root finder and beta function."""
    mpmath.mp.dps = 30
    if math.isinf(freedom):
        return float(mpmath.sqrt(2) * mpmath.erfinv(p))
    half = mpmath.mpf(freedom) / 2
    inside = lambda t: 1 - mpmath.betainc(half, 0.5, 0, freedom / (freedom + t * t), regularized=True) - p  # noqa: E731
    return float(mpmath.findroot(inside, (1.5, 30.0), solver="anderson", tol=1e-18))


def test_the_guide_s_example():
    """JCGM 100:2008, G.4.1: u of 0.25, 0.57 and 0.82 % from 10, 5 and 15 readings: 19.0 degrees, t 2.09."""
    u, readings = np.array([0.25, 0.57, 0.82]), np.array([10, 5, 15])
    found = effective(np.array([1.03**2]), u[:, None] ** 2, readings - 1)
    assert found[0] == pytest.approx(19.0, abs=0.1)
    assert Coverage(np.full(12, found[0])).factors == pytest.approx(np.full(12, 2.09), abs=0.005)


@given(st.lists(st.tuples(st.floats(1e-6, 1e3), st.integers(1, 1000)), min_size=1, max_size=4), st.floats(0, 1e3))
def test_effective_freedom_is_no_less_than_the_least(parts, known):
    """And that of a single source where nothing else is in it."""
    sizes, freedom = np.array([size for size, _ in parts])[:, None], np.array([one for _, one in parts])
    total = sizes.sum(axis=0) + known
    found = effective(total, sizes, freedom)[0]
    assert found >= freedom.min() * (1 - 1e-12)
    if known == 0.0:
        assert found <= freedom.sum() * (1 + 1e-12)
    if len(parts) == 1 and known == 0.0:
        assert found == pytest.approx(freedom[0])


def test_factors_are_student_s():
    freedom = [1.0, 1.5, 2.0, 2.71, 4.0, 6.0, 9.9, 18.0, 72.0, 882.0, 1e4, math.inf]
    found = Coverage(np.array(freedom))
    assert found.factors == pytest.approx([exact_t(one) for one in freedom], rel=1e-8)
    document = coverage_of(found)
    told = [*sum(document.freedom_K, ()), *document.freedom_U0]
    assert [math.inf if one is None else one for one in told] == freedom


def test_what_is_declared_counts_as_known():
    solution = solved(noisy_run(np.random.default_rng(70), 50))
    assert not solution.noise.exceeds.any() and np.isinf(solution.coverage.freedom).all()
    assert list(coverage_of(solution.coverage).k_U0) == pytest.approx([1.959964] * 3, abs=1e-6)
    assert output.uncertainty_notes(solution) == ["95 % within k u: k = 1.96"]


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares"])
@pytest.mark.parametrize("samples", [2, 3])
def test_scatter_alone_has_the_freedom_of_its_samples(estimator, samples):
    """So few samples have blocks of one length: all of u is the pooled scatter of 18 positions."""
    solution = solved(noisy_run(np.random.default_rng(71), samples), None, estimator=estimator)
    assert solution.coverage.freedom == pytest.approx(np.full(12, POSITIONS * (samples - 1.0)), rel=1e-6)
    k = exact_t(POSITIONS * (samples - 1))
    only, advice, expanded = output.uncertainty_notes(solution)
    assert only == "u contains noise only. For faces laid by hand the real uncertainty can be over"
    assert advice == "100 times larger. To include errors of the stand, describe it: --stand FILE"
    assert expanded == f"95 % of the noise within k u: k = {k:.2f} ({POSITIONS * (samples - 1)} degrees of freedom)"


def test_freedom_beyond_a_million_is_not_told():
    few, many = (output._expanded(Coverage(np.full(12, freedom))) for freedom in (1e6, 392471701697.0))
    assert few == "95 % within k u: k = 1.96 (1e+06 degrees of freedom)" and many == "95 % within k u: k = 1.96"


def test_further_terms_of_the_model_have_the_same_freedom():
    run = noisy_run(np.random.default_rng(77), 3)
    solution = solve(run, None, "least_squares", 1.0, None, "run.csv", terms=("k2", "drift"))
    assert solution.coverage.freedom == pytest.approx(np.full(12, POSITIONS * 2.0), rel=1e-6)
    loud = loud_in_x(np.random.default_rng(78))
    plain, wider = (solve(loud, None, "optimal", 1.0, PAPER_STAND, "run.csv", terms=t).coverage for t in ((), ("k2",)))
    least = solved(loud).noise.measured.freedom[0]
    assert (plain.freedom >= least * (1 - 1e-6)).all() and (wider.freedom >= least * (1 - 1e-6)).all()
    assert wider.freedom[9] != pytest.approx(plain.freedom[9], rel=1e-3)  # K2 takes weight from U0


def test_a_run_of_means_alone_has_no_coverage():
    solution = solved(noisy_run(np.random.default_rng(72), 1), None)
    assert solution.coverage is None
    assert np.isinf(solved(noisy_run(np.random.default_rng(72), 1)).coverage.freedom).all()


def loud_in_x(rng):
    """A run with AR(1) noise in one channel, which is counted, beside declared noise in the other two."""
    x = OUTPUTS[:, None, :] + np.zeros((1, 50, 1))
    x[:, :, 0] += PAPER_STAND.noise * autoregressive(rng, (POSITIONS, 50), 0.9)
    x[:, :, 1:] += PAPER_STAND.noise * rng.standard_normal((POSITIONS, 50, 2))
    return run_of(x)


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares"])
def test_measured_and_declared_parts_together(estimator):
    """Of a linear estimator by hand: the gains of every mean, squared, times its measured variance."""
    solution = solved(loud_in_x(np.random.default_rng(73)), estimator=estimator)
    noise = solution.noise
    assert noise.exceeds.tolist() == [True, False, False]
    one_each = np.eye(3 * POSITIONS).reshape(-1, POSITIONS, 3)
    k, u0 = estimate(paper_schedule(), one_each, estimator)
    gains = np.concatenate([k.reshape(-1, 9), u0], axis=1)[0::3]  # by the means of ux
    part = (gains**2 * noise.mean_variance[0, 0]).sum(axis=0)
    u = np.concatenate([solution.u_k.ravel(), solution.u_u0])
    rows_of_x = [0, 1, 2, 9]
    expected = noise.measured.freedom[0] * u[rows_of_x] ** 4 / part[rows_of_x] ** 2
    assert solution.coverage.freedom[rows_of_x] == pytest.approx(expected, rel=1e-6)
    assert np.isinf(np.delete(solution.coverage.freedom, rows_of_x)).all()
    said = output.uncertainty_notes(solution)[-1]
    assert said.startswith("95 % within k u: k = 1.96 to ") and "degrees of freedom)" in said


def lengths_angles_and_biases(k, u0):
    length = np.linalg.norm(k, axis=1)
    x, y, z = k / length[:, None]
    return np.concatenate([length, [math.acos(x @ y), math.acos(x @ z), math.acos(y @ z)], u0 / length])


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares"])
def test_intrinsic_parameters_have_a_freedom_of_their_own(estimator):
    """By differences of estimates: what the loud channel's means, moved one by one, do to lengths, angles, biases."""
    solution = solved(loud_in_x(np.random.default_rng(73)), estimator=estimator)
    noise, means, step = solution.noise, solution.run.means, 1e-5

    def moved(position, by):
        changed = means.copy()
        changed[position, 0] += by
        return lengths_angles_and_biases(*estimate(paper_schedule(), changed, estimator))

    gains = np.array([moved(p, step) - moved(p, -step) for p in range(POSITIONS)]) / (2.0 * step)
    part = (gains**2 * noise.mean_variance[:, :1]).sum(axis=0)
    found = solution.u_intrinsic
    u = np.concatenate([found.scale, found.angles, found.bias])
    of_x = [0, 3, 4, 6]  # scale and bias of x, its angles with y and z
    expected = noise.measured.freedom[0] * u[of_x] ** 4 / part[of_x] ** 2
    assert solution.coverage.intrinsic[of_x] == pytest.approx(expected, rel=1e-4)
    assert np.isinf(np.delete(solution.coverage.intrinsic, of_x)).all()
    told = coverage_of(solution.coverage)
    assert told.freedom_intrinsic.angle_rad.yz is None
    assert told.freedom_intrinsic.angle_rad.xy == solution.coverage.intrinsic[3]
    assert told.k_intrinsic.bias_g[0] == pytest.approx(exact_t(solution.coverage.intrinsic[6]), rel=1e-8)


def test_the_optimal_estimator_mixes_channels():
    """Its gains, by the derivative of its estimate, hold what one channel shows in coefficients of others."""
    solution = solved(loud_in_x(np.random.default_rng(74)), estimator="optimal")
    samples, noise = np.full(POSITIONS, 50), solution.noise
    given = paper_schedule(), solution.found.k, PAPER_STAND, samples, 0.0
    with_it = np.diag(model.optimal_covariance(*given, noise.mean_variance))
    variance = noise.mean_variance[0, 0]
    without = noise.mean_variance.copy()
    without[:, 0] = 0.0  # then the declared noise counts
    share = PAPER_STAND.noise**2 / 50 / variance
    part = (with_it - np.diag(model.optimal_covariance(*given, without))) / (1 - share)
    expected = noise.measured.freedom[0] * with_it**2 / part**2
    finite = part > 1e-6 * with_it
    assert finite[[0, 1, 2, 9]].all()
    assert solution.coverage.freedom[finite] == pytest.approx(expected[finite], rel=1e-6)


def test_results_say_it(tumble):
    run = ("solve", EXAMPLES / "paper_stand.csv", "--unit", "V", "--json")
    alone = valid(tumble(*run).stdout)["coverage"]
    assert alone["freedom_K"] == [[pytest.approx(18 * 49, rel=1e-6)] * 3] * 3
    assert alone["k_K"][0][0] == pytest.approx(exact_t(18 * 49), rel=1e-6) and alone["probability"] == 0.95
    declared = valid(tumble(*run, "--stand", EXAMPLES / "paper_stand.toml").stdout)["coverage"]
    assert declared["freedom_U0"] == [None] * 3 and declared["k_U0"] == [pytest.approx(1.959964)] * 3


@pytest.mark.toolchain
def test_expanded_intervals_of_few_samples_cover(capsys):
    """Six faces of two samples each on an ideal stand, without a stand file: six degrees of freedom. k u covers 95 %
    and 1.96 u would not."""
    schedule, rng, runs = CoreSchedule.built_in("six_faces"), np.random.default_rng(75), 300
    outputs = model.Geometry(schedule.data).outputs(K, np.zeros(3))
    scores = []
    for _ in range(runs):
        run = run_of(outputs[:, None, :] + 1e-3 * rng.standard_normal((6, 2, 3)))
        solution = solve(run, schedule, "least_squares", 1.0, None, "run.csv")
        u_k, u_u0 = solution.scatter_alone.u_k, solution.scatter_alone.u_u0
        assert solution.coverage.freedom == pytest.approx(np.full(12, 6.0), rel=1e-6)
        score = np.concatenate([((solution.found.k - K) / u_k).ravel(), solution.found.u0 / u_u0])
        scores.append(np.abs(score) / solution.coverage.factors)
    covered = float(np.mean(np.array(scores) <= 1.0))
    normal = float(np.mean(np.array(scores) * exact_t(6) <= exact_t(math.inf)))
    with capsys.disabled():
        print(f"\n{runs} runs of 6 x 2 samples: k u covers {covered:.4f}, 1.96 u covers {normal:.4f}", end="")
    assert covered == pytest.approx(0.95, abs=0.015)
    assert normal < 0.925  # by theory 0.902


@pytest.mark.toolchain
def test_mixed_parts_cover(capsys):
    """Welch and Satterthwaite's approximation itself: a known part beside two estimates, 50,000 draws each."""
    rng, draws = np.random.default_rng(76), 50_000
    for known, parts, freedom in ((1.0, [1.0, 0.0], [4, 9]), (0.2, [1.0, 0.5], [6, 3]), (0.0, [1.0, 1.0], [8, 8])):
        sizes = np.array(parts)
        error = rng.standard_normal(draws) * np.sqrt(known + sizes.sum())
        seen = sizes[:, None] * np.array([rng.chisquare(one, draws) / one for one in freedom])
        variance = known + seen.sum(axis=0)
        nu = effective(variance, seen, np.array(freedom))
        t = np.interp(np.log(nu), grid := np.linspace(0.0, 12.0, 100), [exact_t(math.exp(x)) for x in grid])
        covered = float(np.mean(np.abs(error) <= t * np.sqrt(variance)))
        with capsys.disabled():
            print(f"\nknown {known}, parts {parts} of {freedom}: {covered:.4f}", end="")
        assert covered == pytest.approx(0.95, abs=0.01)
