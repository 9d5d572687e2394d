"""Standard uncertainties: the published geometry's reference values, the estimators' weights, and Monte Carlo."""

import dataclasses

import numpy as np
import pytest
from blocks import NOMINAL_K

from tumble import core, model
from tumble.estimators import LINEAR
from tumble.model.errors import brought, sources
from tumble.model.stand_seen import pooled_noise
from tumble.stand import COMMON, Stand

PAPER = model.built_in("paper")
LONE_ROWS = np.ones(18, dtype=int)
STAND = Stand(axis_tilt=2e-5, level=2e-5, remount=4e-4, angle=4e-5, noise=3e-4, samples=50, limits="sigma1")

# Worked out independently, in ppm of K_xx; K_yy, K_zz; K_xy, K_xz; K_yx, K_zx; K_yz, K_zy, then in ug a0_x; a0_y, a0_z
BUDGET = {
    ("averaged", "independent"): (11.8, 14.1, 1368, 10030, 497, 8.4, 12.5),
    ("refined", "independent"): (11.8, 14.1, 1368, 1480, 497, 8.4, 12.5),
    ("averaged", "common"): (10.3, 14.1, 1368, 9829, 497, 8.4, 12.5),
    ("refined", "common"): (10.3, 14.1, 1368, 1480, 497, 8.4, 12.5),
}

# Weights of one set angle's error, and of the noise of one mean: same columns
WEIGHTS = {
    "averaged": (
        (0.1768, 0.2500, 0.3953, 0.2165, 0.4677, 0.1654, 0.1250),
        (0.3536, 0.4677, 0.4677, 0.3536, 0.4677, 0.2421, 0.2421),
    ),
    "refined": (
        (0.1768, 0.2500, 0.3953, 0.4330, 0.4677, 0.1654, 0.1250),
        (0.3536, 0.4677, 0.4677, 0.5000, 0.4677, 0.2421, 0.2421),
    ),
}
COLUMNS = {"xx": 0, "yy": 1, "zz": 1, "xy": 2, "xz": 2, "yx": 3, "zx": 3, "yz": 4, "zy": 4}


def stated(stand, samples, estimator="refined"):
    """u_K and u_U0."""
    return model.by_coefficient(model.Propagation(PAPER, NOMINAL_K, stand, samples, estimator).covariance())


def named(values, table):
    """Pairs of what was found for each of the twelve (K row by row, then U0) and the table's value for it."""
    names = [i + j for i in "xyz" for j in "xyz"]
    expected = [table[COLUMNS[name]] for name in names] + [table[5], table[6], table[6]]
    return np.asarray(values), np.array(expected)


@pytest.mark.parametrize(("estimator", "remounting"), BUDGET)
def test_budget_of_the_papers_stand(estimator, remounting):
    stand = dataclasses.replace(STAND, remounting=remounting)
    u_k, u_u0 = stated(stand, LONE_ROWS, estimator)
    relative = np.concatenate([(u_k / NOMINAL_K).ravel(), u_u0 / np.diag(NOMINAL_K)]) * 1e6
    found, expected = named(relative, BUDGET[estimator, remounting])
    assert found == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("estimator", WEIGHTS)
def test_weights_of_set_angles_and_noise(estimator):
    misalignment = 0.02

    def coefficients(means):
        k, u0 = model.estimate(PAPER, means, estimator)
        return np.concatenate([k.reshape(-1, 9), u0], axis=1)

    unit = dataclasses.replace(STAND, angle=1.0, noise=1.0, samples=1)
    draws = brought(coefficients, sources(PAPER, NOMINAL_K, unit, LONE_ROWS))
    parts = {name: np.linalg.norm(one, axis=0) for name, one in draws.items()}
    relative = parts["alpha4"] / np.concatenate([NOMINAL_K.ravel(), np.diag(NOMINAL_K)])
    times_misalignment = [misalignment if i + j in ("xy", "xz", "yx", "zx") else 1.0 for i in "xyz" for j in "xyz"]
    found, expected = named(relative * np.array([*times_misalignment, 1.0, 1.0, 1.0]), WEIGHTS[estimator][0])
    assert found == pytest.approx(expected, rel=0.01)
    found, expected = named(parts["noise"], WEIGHTS[estimator][1])
    assert found == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("limits", "factor"), [("sigma1", 1.0), ("sigma3", 3.0), ("uniform", 3.0**0.5)])
def test_limits_say_what_the_numbers_are(limits, factor):
    u_k, u_u0 = stated(STAND, LONE_ROWS)
    stand = dataclasses.replace(STAND, limits=limits)
    other_k, other_u0 = stated(stand, LONE_ROWS)
    assert other_k * factor == pytest.approx(u_k, rel=1e-13)
    assert other_u0 * factor == pytest.approx(u_u0, rel=1e-13)


def test_samples_of_the_run_count_and_a_lone_row_is_a_mean():
    noise_only = dataclasses.replace(STAND, axis_tilt=0.0, level=0.0, remount=0.0, angle=0.0)
    lone, _ = stated(noise_only, LONE_ROWS)
    same, _ = stated(noise_only, np.full(18, 50))
    fewer, _ = stated(noise_only, np.full(18, 2))
    assert lone == pytest.approx(same, rel=1e-13)
    assert fewer == pytest.approx(lone * 5, rel=1e-13)


def simulated(rng, geometry, stand, runs):
    """Means of many runs on a stand, on the exact geometry: (runs, 18, 3)."""
    for _ in range(runs):
        yaw = rng.normal() * np.ones(2) if stand.remounting == COMMON else rng.normal(size=2)
        outputs = geometry.outputs(
            NOMINAL_K,
            np.array([0.1, -0.2, 0.3]),
            alpha1=rng.normal() * stand.axis_tilt,
            alpha2=rng.normal() * stand.level,
            alpha3=yaw * stand.remount,
            delta=rng.normal(size=18) * stand.angle,
        )
        yield outputs + rng.normal(size=(18, 3)) * stand.noise / np.sqrt(stand.samples)


@pytest.mark.slow
@pytest.mark.parametrize("remounting", ["independent", "common"])
def test_spread_of_the_core_over_many_runs_is_what_is_stated(remounting):
    """6,000 runs: a standard deviation is then known to 0.9 %, so a stated one 4 % off would show."""
    stand = dataclasses.replace(STAND, remounting=remounting)
    paper, geometry = core.CoreSchedule(PAPER), model.Geometry(PAPER)
    runs = list(simulated(np.random.default_rng(51), geometry, stand, 6000))
    for estimator in LINEAR:
        found = np.array(
            [np.concatenate([c.ravel() for c in core.estimate(paper, run, None, estimator)]) for run in runs]
        )
        u_k, u_u0 = stated(stand, LONE_ROWS, estimator)
        assert found.std(axis=0) == pytest.approx(np.concatenate([u_k.ravel(), u_u0]), rel=0.04)


def test_pooled_noise_weighs_by_degrees_of_freedom():
    samples = np.array([1, 2, 5, 0])
    scatter = np.array([[np.nan] * 3, [1.0, 2.0, 3.0], [2.0, 2.0, 1.0], [np.nan] * 3])
    variance = ((1 + 4 + 9) * 1 + (4 + 4 + 1) * 4) / 15
    found = pooled_noise(samples, scatter)
    assert (found.value, found.u) == pytest.approx((variance**0.5, (variance / 30) ** 0.5))
    assert pooled_noise(np.array([1, 1]), np.full((2, 3), np.nan)) is None
