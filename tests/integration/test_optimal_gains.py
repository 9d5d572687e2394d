"""Gains of the estimators: the optimal ones against an inverted covariance of 60 digits, and refined beside them."""

import dataclasses

import mpmath
import numpy as np
import pytest
from blocks import NOMINAL_K, gains_of, random_block, random_schedule, standard_deviations, usable_schedule
from conftest import EXAMPLES
from hypothesis import given, strategies as st

from tumble.errors import UsageError
from tumble.estimators import LINEAR
from tumble.files.stand_file import read_stand
from tumble.model import Geometry, built_in, estimate
from tumble.model.errors import unit_effect
from tumble.model.estimators import design, linear_gains
from tumble.model.geometry import ideal_force
from tumble.model.optimal import mean_sigma, optimal_table
from tumble.schedule import Schedule
from tumble.stand import COMMON, INDEPENDENT, PAPER_STAND, Stand

pytestmark = pytest.mark.python

PAPER = built_in("paper")
STANDS = {name: read_stand(str(EXAMPLES / f"{name}_stand.toml")).stand for name in ("paper", "angle", "lab")}
ODD_STANDS = {
    **STANDS,
    "one yaw": dataclasses.replace(PAPER_STAND, remounting=COMMON),
    "three sigma": dataclasses.replace(PAPER_STAND, limits="sigma3"),
    "no errors but noise": Stand(0, 0, 0, 0, 3e-4, 50, "sigma1"),
    "no alpha1": dataclasses.replace(PAPER_STAND, axis_tilt=0.0),
    "no alpha3": dataclasses.replace(PAPER_STAND, remount=0.0),
    "no alpha4": dataclasses.replace(PAPER_STAND, angle=0.0),
    "no noise": dataclasses.replace(PAPER_STAND, noise=0.0),
    "nothing at all": Stand(0, 0, 0, 0, 0, 50, "sigma1"),
    "yaw of 15 mrad": dataclasses.replace(PAPER_STAND, remount=15e-3),
    "half a radian": Stand(0.5, 0.5, 0.5, 0.5, 3e-4, 50, "sigma1"),
    "noise beyond reason": dataclasses.replace(PAPER_STAND, noise=1e60),
}

# Worked out independently: standard deviation of refined over the least possible, of K_xx; K_yy, K_zz; K_xy, K_xz;
# K_yx, K_zx; K_yz, K_zy; U0_x; U0_y, U0_z
GAIN_OVER_REFINED = {
    "paper": (1.37, 1.33, 1.04, 1.11, 1.04, 1.26, 1.71),
    "angle": (5.43, 6.38, 1.185, 1.30, 1.05, 6.29, 4.86),
    "lab": (2.30, 2.045, 1.06, 1.09, 1.04, 2.07, 5.65),
}
GROUPS = (0, 2, 2, 3, 1, 4, 3, 4, 1, 5, 6, 6)


def errors_of(schedule, k, stand):
    """J S^1/2, of derivatives by complex steps: (3P, draws)."""
    geometry, fit, step = Geometry(schedule), schedule.fit_indices, 1e-30
    mountings, positions = len(schedule.mountings), len(schedule.positions)
    yaws = [np.ones(mountings)] if stand.remounting == COMMON else np.eye(mountings)
    draws = [({"alpha1": 1.0}, "axis_tilt"), ({"alpha2": 1.0}, "level"), *(({"alpha3": y}, "remount") for y in yaws)]
    draws += [({"delta": one}, "angle") for one in np.eye(positions)[fit]]

    def column(draw):
        derivative = geometry.force(**{name: 1j * step * value for name, value in draw.items()}).imag / step
        return (derivative[fit] @ k.T).ravel()

    return np.array([stand.sigma(source) * column(draw) for draw, source in draws]).T


def by_inversion(schedule, k, stand, sigma_mean):
    """Standard deviations (12,) and gains (12, 3P) by the textbook, (A^T C^-1 A)^-1 A^T C^-1, in 60 digits. With
    C = J S J^T + v I, and J standing for J S^1/2, v C^-1 A is A - J (v I + J^T J)^-1 J^T A: a smaller inverse."""
    with mpmath.workdps(60):
        force = Geometry(schedule).force()[schedule.fit_indices]
        rows = [
            np.concatenate([np.kron(np.eye(3)[channel], f), np.eye(3)[channel]]) for f in force for channel in range(3)
        ]
        a = mpmath.matrix(np.array(rows).tolist())
        j, v = mpmath.matrix(errors_of(schedule, k, stand).tolist()), mpmath.mpf(sigma_mean) ** 2
        weighted = (a - j * ((v * mpmath.eye(j.cols) + j.T * j) ** -1 * (j.T * a))) / v
        covariance_of_beta = (a.T * weighted) ** -1
        found = covariance_of_beta * weighted.T
        u = [float(mpmath.sqrt(covariance_of_beta[i, i])) for i in range(12)]
        return np.array(u), np.array(found.tolist(), dtype=float)


@pytest.mark.parametrize("name", ODD_STANDS)
def test_optimal_gains_are_those_of_the_inverted_covariance(name):
    table = optimal_table(PAPER, NOMINAL_K, ODD_STANDS[name])
    u, weights = by_inversion(PAPER, NOMINAL_K, ODD_STANDS[name], table.sigma_mean)
    assert table.u == pytest.approx(u, rel=1e-10)
    assert table.gains == pytest.approx(weights, abs=1e-6 if name in ("no noise", "half a radian") else 1e-11)
    assert table.floored == (ODD_STANDS[name].noise == 0.0)


def test_a_hopeless_stand_has_still_the_right_uncertainties():
    """No noise, errors of half a radian: nine orders of magnitude between what is known and what is not."""
    stand = Stand(0.5, 0.5, 0.5, 0.5, 0.0, 50, "sigma1")
    table = optimal_table(PAPER, NOMINAL_K, stand)
    assert table.u == pytest.approx(by_inversion(PAPER, NOMINAL_K, stand, table.sigma_mean)[0], rel=1e-8)


@pytest.mark.slow
def test_optimal_gains_of_other_schedules_and_blocks():
    rng = np.random.default_rng(71)
    for remounting in (COMMON, INDEPENDENT):
        schedule = usable_schedule(rng).data
        k, _ = random_block(rng)
        stand = dataclasses.replace(STANDS["lab"], noise=1e-4 * np.abs(k).max(), remounting=remounting)
        table = optimal_table(schedule, k, stand)
        u, weights = by_inversion(schedule, k, stand, table.sigma_mean)
        assert table.u == pytest.approx(u, rel=1e-9)
        assert table.gains == pytest.approx(weights, abs=1e-8 * np.abs(weights).max())


@pytest.mark.parametrize("name", GAIN_OVER_REFINED)
def test_gain_over_refined_is_the_published_one(name):
    table = optimal_table(PAPER, NOMINAL_K, STANDS[name])
    refined = linear_gains(PAPER, "refined")
    spread = standard_deviations(PAPER, refined, NOMINAL_K, STANDS[name], table.sigma_mean)
    expected = np.array(GAIN_OVER_REFINED[name])[list(GROUPS)]
    assert spread / table.u == pytest.approx(expected, rel=0.005)


SIZES = st.one_of(st.just(0.0), st.floats(1e-9, 0.5))


@given(st.tuples(SIZES, SIZES, SIZES, SIZES), st.one_of(st.just(0.0), st.floats(1e-9, 10.0)), st.booleans())
def test_any_stand_has_unbiased_gains_no_worse_than_the_others(angles, noise, common):
    stand = Stand(*angles, noise, 10, "sigma1", COMMON if common else INDEPENDENT)
    table = optimal_table(PAPER, NOMINAL_K, stand)
    assert np.isfinite(table.gains).all() and np.isfinite(table.nuisance_gains).all()
    assert table.gains @ design(PAPER) == pytest.approx(np.eye(12), abs=1e-5)
    for estimator in LINEAR:
        other = standard_deviations(PAPER, linear_gains(PAPER, estimator), NOMINAL_K, stand, table.sigma_mean)
        assert (table.u <= other * (1 + 1e-9)).all()
    absent = table.sigma[[0, 1] + [2] * table.yaws] == 0.0
    assert (table.nuisance_gains[absent] == 0.0).all()


def by_hand(schedule):
    """The ideal force at every position, and its derivatives by what all share, on paper: (positions, 3) each."""
    mounting = [next(m for m in schedule.mountings if m.number == p.mounting) for p in schedule.positions]
    rotation, tilt = np.array([m.matrix for m in mounting]), np.deg2rad([m.tilt_deg for m in mounting])
    phi = np.deg2rad([position.angle_deg for position in schedule.positions])
    s, c, sine, cosine, zero = np.sin(phi), np.cos(phi), np.sin(tilt), np.cos(tilt), np.zeros(len(phi))
    of_table = {
        "force": (cosine * s, sine, cosine * c),
        "alpha1": (-sine * s, cosine, -sine * c),
        "alpha2": (cosine * c, zero, -cosine * s),
        "alpha3": (sine, -cosine * s, zero),
        "platform": (zero, cosine * c, -sine),
    }
    return {name: np.einsum("pij,jp->pi", rotation, axes) for name, axes in of_table.items()}


def test_derivatives_by_hand_are_those_of_the_exact_geometry():
    rng = np.random.default_rng(72)
    for _ in range(20):
        schedule = random_schedule(rng)
        expected = by_hand(schedule)
        assert ideal_force(schedule) == pytest.approx(expected.pop("force"), abs=1e-14)
        for name, one in expected.items():
            first = unit_effect(schedule, name, common=True).derivative(np.eye(3))[0]
            assert first == pytest.approx(one, abs=1e-14), name
        own = np.array([[p.mounting == m.number for p in schedule.positions] for m in schedule.mountings])[..., None]
        each = {
            "alpha3": own * expected["alpha3"],
            "seat": np.concatenate([own * expected["platform"], own * expected["alpha2"]]),
            "alpha4": np.eye(len(schedule.positions))[..., None] * expected["alpha2"],
        }
        for name, of_draws in each.items():
            assert unit_effect(schedule, name).derivative(np.eye(3)) == pytest.approx(of_draws, abs=1e-14), name


@pytest.mark.parametrize("estimator", LINEAR)
def test_linear_gains_are_the_estimator(estimator):
    means = np.random.default_rng(73).normal(size=(18, 3))
    k, u0 = estimate(PAPER, means, estimator)
    found = linear_gains(PAPER, estimator) @ means.ravel()
    assert found == pytest.approx(np.concatenate([k.ravel(), u0]), abs=1e-14)


def test_the_converter_sets_the_noise_where_the_stand_has_less():
    quiet = dataclasses.replace(PAPER_STAND, noise=1e-6)
    assert mean_sigma(NOMINAL_K, quiet, 1e-3, 50)[0] == pytest.approx([1e-3 / 12**0.5 / 50**0.5] * 3)
    assert mean_sigma(NOMINAL_K, PAPER_STAND, 1e-5, 50)[0] == pytest.approx([3e-4 / 50**0.5] * 3)
    sigma, floored = mean_sigma(NOMINAL_K, dataclasses.replace(PAPER_STAND, noise=0.0), 0.0, 50)
    assert sigma.tolist() == [2e-9] * 3 and floored is True


def test_what_cannot_be_weighed_is_refused():
    one_mounting = Schedule(PAPER.mountings[:1], PAPER.positions[:9])
    for estimator in ("least_squares", "optimal"):
        with pytest.raises(UsageError, match=r"cannot identify K_xy, K_yy, K_zy$"):
            gains_of(one_mounting, estimator, NOMINAL_K, PAPER_STAND)
    with pytest.raises(UsageError, match="lacks positions that refined needs"):
        gains_of(one_mounting, "refined", NOMINAL_K, PAPER_STAND)
    for noise in (1e150, 1e300):
        with pytest.raises(UsageError, match="noise beyond any number"):
            optimal_table(PAPER, NOMINAL_K, dataclasses.replace(PAPER_STAND, noise=noise))
    with pytest.raises(UsageError, match="K is zero"):
        optimal_table(PAPER, np.zeros((3, 3)), dataclasses.replace(PAPER_STAND, noise=0.0))
