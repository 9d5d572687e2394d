"""The C core against the numpy witness: 10,000 random blocks, stands and schedules."""

import core_functions
import numpy as np
import pytest
from blocks import random_block, random_means, usable_schedule

from tumble import core, model
from tumble.estimators import LINEAR
from tumble.schedule import Schedule

LIMIT = 1e-12  # of max|K|


def runs_on(rng, schedule, count):
    """Means (count, positions, 3) of as many random blocks, each on a stand of its own: errors of 1 urad to 0.1 rad."""
    size = 10.0 ** rng.uniform(-6, -1, (count, 1))
    draws = {"alpha1": 1, "alpha2": 1, "alpha3": len(schedule.mountings), "delta": len(schedule.positions)}
    errors = {name: rng.normal(size=(count, number)) * size for name, number in draws.items()}
    force = model.Geometry(schedule).force(**errors)
    k, u0 = map(np.array, zip(*(random_block(rng) for _ in range(count))))
    noise = rng.normal(size=force.shape) * 1e-4 * np.abs(k).max(axis=(1, 2), keepdims=True)
    return force @ np.swapaxes(k, 1, 2) + u0[:, None] + noise


def worst_difference(core_schedule, means, estimator):
    """Largest difference of a coefficient between core and witness in any of the runs, over its max|K|."""
    by_core = [core.estimate(core_schedule, one, None, estimator) for one in means]
    k, u0 = model.estimate(core_schedule.data, means, estimator)
    apart = [max(np.abs(one_k - k[i]).max(), np.abs(one_u0 - u0[i]).max()) for i, (one_k, one_u0) in enumerate(by_core)]
    return (np.array(apart) / np.abs(k).max(axis=(1, 2))).max()


def worst_of_paper_schedule(rng, cases):
    paper, means = core.CoreSchedule(core.paper_schedule()), runs_on(rng, core.paper_schedule(), cases)
    return max(worst_difference(paper, means[turn::3], estimator) for turn, estimator in enumerate(LINEAR))


def worst_of_any_schedule(rng, schedules):
    """Four blocks on each."""
    worst = 0.0
    for _ in range(schedules):
        schedule = usable_schedule(rng)
        worst = max(worst, worst_difference(schedule, runs_on(rng, schedule.data, 4), "least_squares"))
    return worst


@pytest.mark.slow
def test_random_cases_agree(cases):
    """10,000 with --full."""
    rng = np.random.default_rng(20)
    assert worst_of_paper_schedule(rng, cases(4_000)) <= LIMIT
    assert worst_of_any_schedule(rng, cases(1_500)) <= LIMIT


@pytest.mark.full
def test_100000_other_random_cases_agree(fresh_seed):
    rng = np.random.default_rng(fresh_seed)
    assert worst_of_paper_schedule(rng, 40_000) <= LIMIT
    assert worst_of_any_schedule(rng, 15_000) <= LIMIT


def test_attitudes_agree():
    rng = np.random.default_rng(21)
    for _ in range(300):
        schedule = usable_schedule(rng)
        assert np.abs(core_functions.attitudes(schedule) - model.Geometry(schedule.data).force()).max() < 4e-15


def test_paper_schedule_is_the_same_on_both_sides():
    assert core.paper_schedule() == model.built_in("paper")


def test_what_follows_from_the_coefficients_agrees():
    rng = np.random.default_rng(22)
    for _ in range(500):
        schedule = usable_schedule(rng)
        k, u0 = random_block(rng)
        means = random_means(rng, schedule.data, k, u0, size=0.01)
        gravity = core.gravity_check(schedule, means, None, core.Calibration(k, u0), 1e-3)
        expected = model.gravity_errors(means, k, u0)
        assert np.abs(gravity.delta_g - expected).max() < 1e-13
        is_fit = np.array([position.use == "fit" for position in schedule.data.positions])
        assert gravity.max_abs_fit == pytest.approx(np.abs(expected[is_fit]).max(), abs=1e-13)
        assert (gravity.max_abs_check is None) == is_fit.all()
        assert gravity.passed == (np.abs(gravity.delta_g).max() <= 1e-3)
        intrinsic = core.intrinsic(k, u0)
        scale, angles, bias = model.intrinsic(k, u0)
        assert intrinsic.scale == pytest.approx(scale, rel=1e-14)
        assert intrinsic.angles == pytest.approx(angles, abs=1e-14)
        assert intrinsic.bias == pytest.approx(bias, rel=1e-14)


def test_closure_and_residuals_agree():
    rng = np.random.default_rng(23)
    paper = core.CoreSchedule(core.paper_schedule())
    for _ in range(200):
        k, u0 = random_block(rng)
        means = random_means(rng, paper.data, k, u0)
        measured = rng.random(18) < 0.9
        kept = tuple(position for position, keep in zip(paper.data.positions, measured) if keep)
        part = Schedule(paper.data.mountings, kept)
        for mounting in (1, 2):
            ours = core.closure(paper, means, measured, mounting)
            theirs = model.closure(part, means[measured], mounting)
            assert (ours is None) == (theirs is None)
            assert ours is None or (ours == theirs).all()
        rms = core.residual_rms(paper, means, measured, k, u0)
        assert rms == pytest.approx(model.residual_rms(part, means[measured], k, u0), rel=1e-9)


def test_gain_table_of_an_estimator_gives_its_estimate():
    rng = np.random.default_rng(24)
    impulses = np.eye(54).reshape(54, 18, 3)
    paper = core.CoreSchedule(core.paper_schedule())
    for estimator in LINEAR:
        k_gains, u0_gains = model.estimate(paper.data, impulses, estimator)
        gains = np.concatenate([k_gains.reshape(54, 9), u0_gains], axis=1).T
        means = random_means(rng, paper.data, *random_block(rng))
        k, u0 = core_functions.estimate_gains(paper, gains, means)
        expected_k, expected_u0 = core.estimate(paper, means, None, estimator)
        limit = LIMIT * np.abs(expected_k).max()
        assert np.abs(k - expected_k).max() < limit and np.abs(u0 - expected_u0).max() < limit


def test_applying_a_calibration_undoes_the_block():
    rng = np.random.default_rng(25)
    for _ in range(200):
        k, u0 = random_block(rng)
        force = rng.normal(size=3)
        assert core_functions.apply(core.Calibration(k, u0), k @ force + u0) == pytest.approx(force, abs=1e-13)
        counts = rng.integers(-(2**23), 2**23, 3)
        expected = np.linalg.solve(k, counts * 1e-6 - u0)
        found = core_functions.apply_counts(core.Calibration(k, u0), 1e-6, counts)
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)
