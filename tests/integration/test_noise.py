"""The standard errors of means that the samples show: block means against sums of autocovariances, coverage, notices.

The simulations are vectorised: all runs of a case are one array (runs, positions, samples) of one channel, whose errors
in the means go through one weight of a coefficient.
"""

import dataclasses
import json
from fractions import Fraction

import numpy as np
import pytest
from blocks import NOMINAL_K
from conftest import EXAMPLES
from hypothesis import given, strategies as st
from test_fixture_check import stand_named

from tumble import model
from tumble.cli import output
from tumble.core import paper_schedule
from tumble.distributions import chi_squared_above
from tumble.files.run_file import NO_BLOCKS, Run, blocks_of, facts_of
from tumble.model.errors import exact_outputs, sources
from tumble.model.estimators import estimate
from tumble.solving import noise
from tumble.solving.decision import assumed
from tumble.solving.noise import CHANCE_SIGMAS, CORRELATED, chance_limit, log_p_if_white
from tumble.solving.solution import solve
from tumble.stand import PAPER_STAND

POSITIONS = 18
K = np.array([[2.0, 0.04, 0.04], [0.04, 2.0, 0.04], [0.04, 0.04, 2.0]])
OUTPUTS = model.Geometry(paper_schedule()).outputs(K, np.zeros(3))


def autoregressive(rng, shape, rho):
    """AR(1) of variance 1 along the last axis."""
    x, innovation = rng.standard_normal(shape), np.sqrt(1 - rho**2)
    for t in range(1, shape[-1]):
        x[..., t] = rho * x[..., t - 1] + innovation * x[..., t]
    return x


def flicker(rng, shape):
    """1/f, cut below two lengths of a position: one record for each."""
    length = 2 * shape[-1]
    frequency = np.fft.rfftfreq(length)
    frequency[0] = np.inf
    x = np.fft.irfft(np.fft.rfft(rng.standard_normal((*shape[:-1], length))) / np.sqrt(frequency), length)
    return (x / x.std())[..., : shape[-1]]


def run_of(samples, unit="V"):
    """A run of samples (positions, samples, 3)."""
    count = samples.shape[1]
    scatter = samples.std(axis=1, ddof=1) if count > 1 else np.full((len(samples), 3), np.nan)
    return Run(np.full(len(samples), count), samples.mean(axis=1), scatter, unit, {}, blocks=blocks_of_rows(samples))


def blocks_of_rows(positions):
    """Of the rows (samples, 3) of every position."""
    return blocks_of([facts_of(np.column_stack((rows, np.arange(len(rows))))) for rows in positions])


def noisy_run(rng, samples, rho=0.0, sigma=PAPER_STAND.noise, step=0.0):
    x = OUTPUTS[:, None, :] + sigma * np.moveaxis(autoregressive(rng, (POSITIONS, 3, samples), rho), 1, 2)
    return run_of(np.round(x / step) * step if step else x)


def solved(run, stand=PAPER_STAND, step_v=0.0, estimator="refined"):
    return solve(run, None, estimator, 1.0, stand, "run.csv", step_v)


whole = st.integers(-(2**31), 2**31 - 1)


@given(st.lists(st.lists(st.tuples(whole, whole, whole), max_size=40), min_size=1, max_size=4).filter(any))
def test_block_sums_are_those_of_exact_arithmetic(positions):
    """Against fractions, by the definition: every pair of neighbouring blocks of every length."""
    found = blocks_of_rows([np.array(rows, dtype=float).reshape(-1, 3) for rows in positions])
    assert len(found.squares) == max(map(len, positions)).bit_length() - 1
    for level, of_positions in enumerate(found.squares):
        m = 2**level
        for rows, squares in zip(positions, of_positions):
            for channel in range(3):
                blocks = [
                    sum(Fraction(row[channel]) for row in rows[start : start + m])
                    for start in range(0, len(rows) // m * m, m)
                ]
                pairs = zip(blocks[0::2], blocks[1::2])
                exact = sum(((a - b) ** 2 for a, b in pairs), Fraction(0)) / (2 * m)
                assert squares[channel] == pytest.approx(float(exact), rel=1e-12, abs=1e-9)


@given(st.integers(2, 70), st.integers(1, 5), st.integers(0, 2**32))
def test_pooled_blocks_are_the_variance_of_block_means(samples, positions, seed):
    """Of a power of two samples, all lengths from m on together have the squares of m-blocks about their means."""
    x = np.random.default_rng(seed).standard_normal((positions, 2 ** (samples.bit_length() - 1), 3))
    found = noise.measured_noise(*_arguments(x))
    for level, variance in enumerate(found.pooled):
        blocks = x.reshape(positions, -1, 2**level, 3).mean(axis=2)
        freedom = positions * (blocks.shape[1] - 1)
        squares = ((blocks - blocks.mean(axis=1, keepdims=True)) ** 2).sum(axis=(0, 1))
        assert found.pooled_freedom[level] == freedom
        np.testing.assert_allclose(variance, 2**level * squares / freedom, rtol=1e-9)


def _arguments(x):
    """Of samples (positions, samples, 3)."""
    run = run_of(x)
    return run.samples, run.scatter, run.blocks.squares


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.5, 0.8])
def test_block_means_agree_with_the_sum_of_autocovariances(rho):
    """Of long positions, where both are sharp: the variance of means of 128 samples is the sum of the autocovariances
    (Newey and West's window), and nearly (1 + rho)/(1 - rho) by theory."""
    x = np.moveaxis(autoregressive(np.random.default_rng(51), (60, 3, 4096), rho), 1, 2)
    found = noise.measured_noise(*_arguments(x))
    centred, lags = x - x.mean(axis=1, keepdims=True), 128
    sums = np.stack([(centred[:, lag:] * centred[:, : 4096 - lag]).sum(axis=(0, 1)) for lag in range(lags)])
    window = 1 - np.arange(lags) / lags
    newey_west = (2 * window @ sums - sums[0]) / (60 * 4096)
    np.testing.assert_allclose(found.pooled[7], newey_west, rtol=0.08)
    np.testing.assert_allclose(found.pooled[7], (1 + rho) / (1 - rho), rtol=0.12)
    assert (found.variance >= found.pooled[7] * 0.95).all()


def test_alternating_noise_counts_as_its_scatter():
    x = np.moveaxis(autoregressive(np.random.default_rng(52), (POSITIONS, 3, 64), -0.7), 1, 2)
    found = noise.measured_noise(*_arguments(x))
    assert (found.length == 1).all()
    np.testing.assert_allclose(found.variance, found.scatter**2, rtol=0.02)
    assert (found.variance >= found.scatter**2 * (1 - 1e-12)).all()


def cases(rng, runs, samples):
    shape = runs, POSITIONS, samples
    return {
        "white": rng.standard_normal(shape),
        "AR(1) 0.5": autoregressive(rng, shape, 0.5),
        "AR(1) 0.9": autoregressive(rng, shape, 0.9),
        "1/f": flicker(rng, shape),
        "AR(1) -0.5": autoregressive(rng, shape, -0.5),
    }


def stated(x):
    """By run, of one channel (runs, positions, samples): the variance of a mean by its blocks, and whether it exceeds a
    declared noise of 1."""
    for run in x:
        found = noise.measured_noise(*_arguments(np.repeat(run[:, :, None], 3, axis=2)))
        yield found.mean_variance(np.array([x.shape[2]]))[0, 0], bool(found.exceeds(1.0)[0])


@pytest.mark.toolchain
def test_the_stated_error_covers(capsys):
    """k = 2 covers 90 % at least, by the declared noise where the samples say no more, and by scatter alone."""
    rng, samples = np.random.default_rng(53), 50
    weight = np.cos(2 * np.pi * np.arange(POSITIONS) / 9)
    for name, x in cases(rng, 500, samples).items():
        error = x.mean(axis=2) @ weight / np.linalg.norm(weight)
        variance, exceeds = map(np.array, zip(*stated(x)))
        with_stand = np.where(exceeds, variance, 1.0 / samples)
        old = np.abs(error) < 2 * x.std(axis=2, ddof=1).mean() / np.sqrt(samples)
        covered = [float(np.mean(np.abs(error) < 2 * np.sqrt(of))) for of in (with_stand, variance)]
        true = error.std() * np.sqrt(samples)
        ratio = np.median(np.sqrt(variance * samples)) / true
        told = f"{name:11} true {true:.2f} stated/true {ratio:.2f} scatter {old.mean():.3f} stand {covered[0]:.3f}"
        with capsys.disabled():
            print(f"\n{told} alone {covered[1]:.3f} told {exceeds.mean():.3f}", end="")
        assert min(covered) > 0.90
        assert exceeds.mean() > 0.9 if name.startswith(("AR(1) 0", "1/f")) else exceeds.mean() < 0.01


@pytest.mark.parametrize("freedom", [1, 6, 18, 54, 882])
def test_limits_are_never_below_the_quantile(freedom):
    """The limit of Wilson and Hilferty against the exact tail of chi-squared."""
    beyond = chi_squared_above(float(chance_limit(freedom, CHANCE_SIGMAS)) * freedom, freedom)
    assert 0 < beyond < 1.35e-5


def test_noise_as_declared_changes_nothing():
    solution = solved(noisy_run(np.random.default_rng(54), 50))
    assert not solution.noise.exceeds.any() and not solution.noise.mean_variance.any()
    assert assumed(solution).keys() == {"seat", "temperature"}
    samples = np.full(POSITIONS, 50)
    covariance = model.Propagation(paper_schedule(), solution.found.k, PAPER_STAND, samples, "refined").covariance()
    u_k, _ = model.by_coefficient(covariance)
    np.testing.assert_allclose(solution.u_k, u_k, rtol=1e-9)


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares", "optimal"])
def test_measured_noise_counts_where_it_exceeds_the_declared(estimator):
    """In one channel: its coefficients alone become less certain. The estimate does not change."""
    rng, x = np.random.default_rng(55), OUTPUTS[:, None, :] + np.zeros((1, 50, 1))
    x[:, :, 0] += PAPER_STAND.noise * autoregressive(rng, (POSITIONS, 50), 0.9)
    x[:, :, 1:] += PAPER_STAND.noise * rng.standard_normal((POSITIONS, 50, 2))
    solution = solved(run_of(x), estimator=estimator)
    assert solution.noise.exceeds.tolist() == [True, False, False]
    fewer = Run(*(getattr(solution.run, name) for name in ("samples", "means", "scatter", "unit", "counters")))
    quiet = solved(run_of(OUTPUTS[:, None, :] + PAPER_STAND.noise * rng.standard_normal((POSITIONS, 50, 3))))
    assert (solution.found.k == solved(fewer, estimator=estimator).found.k).all()
    assert solution.u_u0[0] > 1.5 * quiet.u_u0[0] * (0.6 if estimator == "optimal" else 1.0)
    text = noise.notice(solution.noise, solution.declared, solution.run.samples, "V")
    assert text.startswith("noise above the declared 3.0e-04 V: ") and " in ux by blocks of 16 samples" in text


@pytest.mark.parametrize("samples", [2, 5, 50])
def test_scatter_alone_is_all_that_is_known_without_a_stand(samples):
    run = noisy_run(np.random.default_rng(56), samples)
    solution = solved(run, None)
    assert solution.u_k is None and solution.u_u0 is None
    sigma = solution.noise.measured.variance**0.5
    expected = sigma * np.sqrt((2 * 0.125**2 + 7 * 0.25**2) * 2) / 4 * 2 / np.sqrt(2) / np.sqrt(samples)
    assert (solution.scatter_alone.u_u0 > 0.5 * expected).all() and (solution.scatter_alone.u_u0 < 2 * expected).all()
    assert ("white_noise" in assumed(solution)) == (samples < 4)


def test_a_run_of_means_assumes_white_noise():
    run = noisy_run(np.random.default_rng(57), 1)
    assert assumed(solved(run))["white_noise"] == ()
    assert solved(run, None).scatter_alone is None and solved(run, None).noise.measured is None


def test_rounding_that_does_not_average_out_counts_undivided():
    """The step declared, seen in the values, or only known to hide the noise."""
    rng, step = np.random.default_rng(58), 2e-3
    coarse = noisy_run(rng, 50, step=step)
    for run, step_v in ((coarse, step), (coarse, 0.0), (run_of(OUTPUTS[:, None, :]), step)):
        solution = solved(run, step_v=step_v)
        assert "undithered" in assumed(solution) and solution.noise.undithered.all()
        assert (solution.noise.mean_variance >= step**2 / 12).all()
        assert (solution.noise.mean_variance < step**2 / 12 * 1.2).all()
    still = run_of(np.repeat(np.round(OUTPUTS, 2)[:, None, :], 5, axis=1))
    assert "undithered" in assumed(solved(still)) and not solved(still).noise.rounding.any()
    for dithered in (noisy_run(rng, 50, step=4e-4), noisy_run(rng, 50, sigma=3e-4, step=5e-4)):
        assert "undithered" not in assumed(solved(dithered))


def with_a_lone_row(run, position):
    """All other rows of a position lost: its mean is the first one."""
    few = run.samples.copy()
    few[position] = 1
    blocks = dataclasses.replace(run.blocks, squares=run.blocks.squares.copy())
    blocks.squares[:, position] = 0.0
    scatter = run.scatter.copy()
    scatter[position] = np.nan
    return dataclasses.replace(run, samples=few, scatter=scatter, blocks=blocks)


def test_a_lone_row_among_many_is_one_sample():
    """U0 is the mean over positions 1 to 8: the lone one has 50 times the variance of the others."""
    run = noisy_run(np.random.default_rng(59), 50)
    quiet = dataclasses.replace(PAPER_STAND, axis_tilt=0.0, level=0.0, remount=0.0, angle=0.0)
    whole_run, broken = solved(run, quiet), solved(with_a_lone_row(run, 3), quiet)
    assert whole_run.lone == [] and broken.lone == ["1.4"]
    ratio = broken.u_u0 / whole_run.u_u0
    np.testing.assert_allclose(ratio**2, (15 + 50) / 16, rtol=0.2)
    means = dataclasses.replace(run, samples=np.ones(POSITIONS, dtype=int), blocks=NO_BLOCKS)
    assert solved(means, quiet).lone == [] and PAPER_STAND.samples == 50
    np.testing.assert_allclose(solved(means, quiet).u_u0, whole_run.u_u0, rtol=1e-9)


def test_a_lone_row_is_named(tumble, tmp_path):
    rows = (EXAMPLES / "paper_stand.csv").read_text().splitlines(keepends=True)
    kept = [row for row in rows[1:] if not row.startswith("2,7,")]
    lost = [row for row in rows[1:] if row.startswith("2,7,")]
    (tmp_path / "run.csv").write_text("".join([rows[0], *kept, lost[0]]))
    shown = tumble("solve", tmp_path / "run.csv", "--unit", "V", "--stand", EXAMPLES / "paper_stand.toml", "--json")
    assert shown.stderr == "tumble: warning: a single row, taken for one sample, at 2.7\n"
    assert shown.returncode == 0 and json.loads(shown.stdout)["fit"]["fits"]


@pytest.mark.parametrize("factor", [1.3, 1.5, 2.0])
def test_a_little_more_noise_than_declared_is_said(factor):
    """It does not always spoil the fit, and is counted and told all the same."""
    run = noisy_run(np.random.default_rng(60), 50, sigma=factor * PAPER_STAND.noise)
    solution = solved(run)
    assert solution.noise.exceeds.all()
    text = noise.notice(solution.noise, solution.declared, run.samples, "V")
    assert text.startswith("noise above the declared 3.0e-04 V: ") and text.endswith(" by the scatter of samples")
    assert noise.CHANNELS[solution.noise.exceeds].tolist() == ["ux", "uy", "uz"]
    scatter, samples = solution.noise.measured.scatter, np.full(POSITIONS, 50)
    np.testing.assert_allclose(scatter, factor * PAPER_STAND.noise, rtol=0.1)
    for i in range(3):
        louder = dataclasses.replace(PAPER_STAND, noise=scatter[i])
        covariance = model.Propagation(paper_schedule(), solution.found.k, louder, samples, "refined").covariance()
        u_k, _ = model.by_coefficient(covariance)
        np.testing.assert_allclose(solution.u_k[i], u_k[i], rtol=1e-9)


@pytest.mark.parametrize("estimator", ["refined", "optimal"])
def test_all_that_states_an_uncertainty_counts_the_measured_noise(estimator):
    """Covariance, norm, intrinsic parameters and Monte Carlo, as if the stand had declared what was measured."""
    run = noisy_run(np.random.default_rng(61), 50, rho=0.9)
    solution = solved(run, estimator=estimator)
    assert solution.noise.exceeds.all()
    np.testing.assert_allclose(np.sqrt(np.diag(solution.covariance))[9:], solution.u_u0, rtol=1e-6)
    declared = solved(dataclasses.replace(run, blocks=NO_BLOCKS), estimator=estimator)
    assert solution.u_norm.worst_g > 1.2 * declared.u_norm.worst_g
    assert (solution.u_intrinsic.bias > 1.5 * declared.u_intrinsic.bias).all()
    monte_carlo = solution.simulated(2000, 1).monte_carlo
    np.testing.assert_allclose(monte_carlo.u[9:], solution.u_u0, rtol=0.1)
    assert (solution.found.k == declared.found.k).all() and solution.fit.chi_squared == declared.fit.chi_squared


def test_white_noise_is_seldom_called_correlated():
    """Whatever its size: one run in a hundred at a p of 1 %, and less for lengths and channels are not independent."""
    rng, runs = np.random.default_rng(62), 300
    found = [noise.measured_noise(*_arguments(rng.standard_normal((9, 32, 3)))) for _ in range(runs)]
    p = np.exp([log_p_if_white(one) for one in found])
    print(f"p below 0.5, 0.1, 0.01: {[float((p.min(axis=1) < one).mean()) for one in (0.5, 0.1, 0.01)]}")
    for one in (0.5, 0.1, 0.01):
        assert (p.min(axis=1) < one).mean() <= one + 3 * (one * (1 - one) / runs) ** 0.5
    assert (p.min(axis=1) < 0.5).mean() > 0.2


@pytest.mark.parametrize("estimator", ["refined", "optimal"])
def test_noise_that_is_not_white_explains_a_run_that_does_not_fit(estimator, tumble):
    """By name and with its size, and the uncertainties are said to count it. White noise is not named so."""
    run = noisy_run(np.random.default_rng(63), 50, rho=0.9)
    solution = solved(run, estimator=estimator)
    first = solution.fit.explanations[0]
    assert not solution.fit.fits and first.patterns == (CORRELATED,) and len(solution.fit.explanations) == 1
    assert first.unit == "V" and first.column in "xyz" and first.p < 1e-9
    assert abs(first.size - 3.8 * PAPER_STAND.noise) < 3 * first.u_size
    assert solution.fit.stand_doubts == () and output.misfit_consequence(solution) == "count it"
    assert f"{CORRELATED} of {first.column} 0.00" in output.misfit_sentence(solution)
    louder = solved(noisy_run(np.random.default_rng(64), 50, sigma=3 * PAPER_STAND.noise), estimator=estimator)
    assert [one.patterns for one in louder.fit.explanations] == [("noise_v",)]


def test_noise_that_the_declared_noise_covers_explains_nothing():
    """Correlated, but the means are no worse than declared: the run fits, and other faults keep their names."""
    run = noisy_run(np.random.default_rng(65), 50, rho=0.5, sigma=0.4 * PAPER_STAND.noise)
    solution = solved(run)
    assert solution.fit.fits and not solution.noise.exceeds.any()
    assert log_p_if_white(solution.noise.measured).min() < -20
    tilted = dataclasses.replace(run, means=run.means + 5e-3 * OUTPUTS[:, [1]] * np.arange(POSITIONS)[:, None] / 17)
    explanations = solved(tilted).fit.explanations
    assert explanations and all(CORRELATED not in one.patterns for one in explanations)


def coefficients(means):
    k, u0 = estimate(paper_schedule(), means, "refined")
    return np.concatenate([k.reshape(len(means), 9), u0], axis=1)


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.9])
@pytest.mark.parametrize("name", ["paper", "angle", "lab"])
@pytest.mark.parametrize("runs", [100, pytest.param(2000, marks=pytest.mark.full)])
def test_refined_covers(name, rho, runs):
    """k = 2 of every coefficient, the stand's errors drawn on the exact geometry: by the declared noise and by the
    measured one. Honest runs are not told of more noise than declared."""
    rng, schedule, samples, stand = np.random.default_rng(70), paper_schedule(), 50, stand_named(name)
    errors, sigma = sources(schedule, NOMINAL_K, stand, np.full(POSITIONS, samples)), stand.sigma("noise")
    by_channel = (coefficients(errors.pop("noise").derivative) ** 2).reshape(POSITIONS, 3, 12).sum(axis=0)
    by_angles = sum(((coefficients(one.derivative) * one.sigma[:, None]) ** 2).sum(axis=0) for one in errors.values())
    draws = rng.standard_normal((runs, sum(len(one.sigma) for one in errors.values())))
    x = sigma * np.moveaxis(autoregressive(rng, (runs, POSITIONS, 3, samples), rho), 3, 2)
    means = exact_outputs(schedule, NOMINAL_K, np.zeros(3), errors, draws) + x.mean(axis=2)
    error = coefficients(means) - np.append(NOMINAL_K.ravel(), np.zeros(3))
    found = [noise.measured_noise(*_arguments(one)) for one in x]
    told = np.array([one.exceeds(sigma) for one in found])
    measured = np.array([one.mean_variance(np.array([samples]))[0] for one in found])
    before = np.full((runs, 3), sigma**2 / samples)
    after = np.where(told, measured, before)
    covered = [np.abs(error) < 2 * np.sqrt(by_angles + of @ by_channel) for of in (before, after)]
    shares = " ".join(f"{100 * one.mean():.1f}, {100 * one.mean(axis=0).min():.1f};" for one in covered)
    print(f"{name} AR(1) {rho}, {runs} runs: {shares} told {told.mean():.4f}")
    assert covered[1].mean() > 0.93 and covered[1].mean(axis=0).min() > 0.85
    assert told.mean() == 0.0 if rho == 0.0 else told.mean() > 0.95
