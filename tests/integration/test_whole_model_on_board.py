"""The whole model on board, in steps: the same verdict as numpy's."""

import dataclasses
import math

import core_whole_model
import numpy as np
import pytest
from blocks import NOMINAL_K
from core_chi_squared import chi_squared
from core_whole_model import averages_of
from test_fixture_check import PAPER, U0, stand_named

from tumble import core, model
from tumble.distributions import chi_squared_quantile
from tumble.model.fit import variance_of_means
from tumble.model.inclined import as_seen, solve
from tumble.model.patterns import BY_NAME, Scene
from tumble.solving.computation import LARGEST_MISFIT
from tumble.stand import SOURCES

ANGLES = [source.attribute for source in SOURCES.values() if source.is_angle and not source.of_inclinations]
pytestmark = pytest.mark.python
V_PER_COUNT = 2e-9


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares"])
@pytest.mark.parametrize("name", ["paper", "three_mountings", "diagonal"])
def test_in_steps_on_board_it_is_the_witness_s(name, estimator):
    """From the averages of counts, beginning with what the estimator found, on random stands and blocks."""
    rng = np.random.default_rng(51)
    data = PAPER.data if name == "paper" else core.built_in(name)
    schedule, count, mountings = core.CoreSchedule(data), len(data.positions), len(data.mountings)
    near = 0
    for _ in range(8):
        stand = dataclasses.replace(
            stand_named("paper"), limits="sigma1", remounting=rng.choice(["independent", "common"]),
            noise=10.0 ** rng.uniform(-6, -3),
            samples=1,
            **{source: rng.choice([0.0, 1.0]) * 10.0 ** rng.uniform(-5, -3) for source in ANGLES},
        )
        means = model.Geometry(data).outputs(
            NOMINAL_K + 0.02 * rng.normal(size=(3, 3)),
            0.02 * rng.normal(size=3),
            alpha1=stand.axis_tilt * rng.normal(),
            alpha3=2e-3 * rng.normal(size=mountings),
            delta=stand.angle * rng.normal(size=count),
        )
        counts = np.rint((means + stand.noise * rng.normal(size=means.shape)) / V_PER_COUNT)
        means = counts * V_PER_COUNT
        verdict = on_board(schedule, averages_of(counts), *core.estimate(schedule, means, None, estimator), stand)
        variance = variance_of_means(stand, np.ones(count, dtype=int), rounding(stand, V_PER_COUNT))
        witness = model.WholeModel(data, means, variance, stand)
        assert verdict.freedom == witness.freedom == 3 * count - 12
        misfit = math.sqrt(witness.chi_squared / witness.freedom)
        if misfit > LARGEST_MISFIT:  # the problem is not linear any more, and nobody needs the figure
            assert verdict.misfit > LARGEST_MISFIT
            continue
        near += 1
        assert verdict.chi_squared == pytest.approx(witness.chi_squared, rel=1e-7)
        assert verdict.misfit == pytest.approx(misfit, rel=1e-7)
        assert verdict.limit == pytest.approx(chi_squared_quantile(0.999, witness.freedom), rel=2.5e-3)
        assert verdict.misfits == (verdict.chi_squared > verdict.limit)
    assert near >= 3


@pytest.mark.parametrize("name", ["inclined", "inclined_closed"])
def test_inclinations_that_nobody_declares_are_unknowns_on_board(name):
    """Inclinations off by 5 mrad, zeros by 10, the axis out of level by 50: chi-squared and freedom are the witness's.
    With a hysteresis of the block, both tell of it."""
    rng = np.random.default_rng(53)
    data = core.built_in(name)
    schedule, count, mountings = core.CoreSchedule(data), len(data.positions), len(data.mountings)
    column = BY_NAME["hysteresis"].columns(Scene(data.fitted, NOMINAL_K))[0]
    for round_ in range(12):
        stand = dataclasses.replace(
            stand_named("paper"), limits="sigma1", remounting=rng.choice(["independent", "common"]), samples=1,
            noise=10.0 ** rng.uniform(-6, -3), drift=rng.choice([0.0, 1e-4]), inclination=math.inf,
            **{source: rng.choice([0.0, 1.0]) * 10.0 ** rng.uniform(-5, -3) for source in ANGLES},
        )
        means = model.Geometry(data).outputs(
            NOMINAL_K + 0.02 * rng.normal(size=(3, 3)), 0.02 * rng.normal(size=3),
            alpha1=0.05 + 5e-3 * rng.normal(size=mountings), seat_n=1e-2 * rng.normal(size=mountings),
            seat_h=1e-2 * rng.normal(), alpha3=1e-2 * rng.normal(), delta=stand.angle * rng.normal(size=count),
        )
        if round_ % 2:
            means[data.fit_indices] += 1e7 * (stand.noise + 2.0 * stand.angle) * sum(column.values()) / 2.0
        counts = np.rint((means + stand.noise * rng.normal(size=means.shape)) / V_PER_COUNT)
        means = counts * V_PER_COUNT
        k, u0, _ = solve(data, means)
        variance = variance_of_means(stand, np.ones(count, dtype=int), rounding(stand, V_PER_COUNT))
        witness = model.WholeModel(data, means, variance, stand)
        verdict = on_board(schedule, averages_of(counts), k, u0, stand)
        square, freedom = chi_squared(schedule, means, np.ones(count, dtype=bool), variance, stand)
        assert verdict.freedom == freedom == witness.freedom == 24 * mountings - 12 - (2 * mountings - 1)
        assert verdict.chi_squared == pytest.approx(witness.chi_squared, rel=1e-7)
        assert square == pytest.approx(witness.chi_squared, rel=1e-7)
        assert verdict.misfits == (verdict.chi_squared > verdict.limit) == bool(round_ % 2)


@pytest.mark.parametrize("off", [0.1, 0.2])
def test_an_inclination_may_be_far_from_its_schedule_s(off):
    """11 degrees: four rounds of Newton come to 1e-3 of chi-squared from the schedule's."""
    data, stand = core.built_in("inclined"), dataclasses.replace(stand_named("paper"), limits="sigma1", samples=1)
    rng, tilts = np.random.default_rng(54), np.array([0.0, off, -off])
    means = model.Geometry(data).outputs(NOMINAL_K, U0, alpha1=tilts) + stand.noise * rng.normal(size=(27, 3))
    counts = np.rint(means / V_PER_COUNT)
    k, u0, found = solve(data, counts * V_PER_COUNT)
    variance = variance_of_means(stand, np.ones(27, dtype=int), 0.0)
    witness = model.WholeModel(as_seen(data, found), counts * V_PER_COUNT, variance, stand)
    verdict = on_board(core.CoreSchedule(data), averages_of(counts), k, u0, stand)
    assert verdict.chi_squared == pytest.approx(witness.chi_squared, rel=1e-3) and not verdict.misfits


@pytest.mark.parametrize("step_v, misfits", [(0.0, False), (6e-7, True)])
def test_a_channel_that_is_quiet_counts_by_its_own_scale(step_v, misfits):
    """In another unit, ten thousand times smaller: it shows a step of 20 of its own standard deviations, which is
    less than a hundredth of one of the others. On board, by numpy, and by numpy with outputs that are scaled alike."""
    rng, small = np.random.default_rng(53), np.array([1.0, 1.0, 1e-4])
    stand = dataclasses.replace(stand_named("paper"), limits="sigma1", noise=(3e-4, 3e-4, 3e-8), samples=1)
    means = model.Geometry(PAPER.data).outputs(NOMINAL_K, U0, delta=stand.angle * rng.normal(size=18))
    means = (means + 3e-4 * rng.normal(size=means.shape)) * small
    means[9:14, 2] += step_v
    counts = np.rint(means / V_PER_COUNT)
    means = counts * V_PER_COUNT
    verdict = on_board(PAPER, averages_of(counts), *core.estimate(PAPER, means, None, "refined"), stand)
    variance = variance_of_means(stand, np.ones(18, dtype=int), 0.0)
    witness = model.WholeModel(PAPER.data, means, variance, stand)
    alike = model.WholeModel(PAPER.data, means / small, variance / small**2, dataclasses.replace(stand, noise=3e-4))
    assert witness.chi_squared == pytest.approx(alike.chi_squared, rel=1e-6)
    assert verdict.chi_squared == pytest.approx(witness.chi_squared, rel=1e-6)
    assert (verdict.freedom, verdict.misfits) == (42, misfits)


def rounding(stand, step):
    return step / math.sqrt(12.0) if stand.noise < step / 2.0 else 0.0


def on_board(schedule, averaging, k, u0, stand):
    return core_whole_model.judge(schedule, averaging, k, u0, stand, V_PER_COUNT)


@pytest.mark.parametrize("noise", [0.0, 0.2, 0.28, 0.3, 0.49, 0.51, 3.0])
def test_on_board_samples_that_round_alike_are_not_averaged(noise):
    """As in `solve`: less noise than half a step of the converter is none that averages out."""
    rng, step = np.random.default_rng(52), 1e-4
    stand = dataclasses.replace(stand_named("paper"), limits="sigma1", noise=noise * step, angle=0.0, samples=1)
    counts = np.rint(model.Geometry(PAPER.data).outputs(NOMINAL_K, U0) / step) + rng.integers(-1, 2, (18, 3))
    found = core.estimate(PAPER, counts * step, None, "refined")
    verdict = core_whole_model.judge(PAPER, averages_of(counts), *found, stand, step)
    variance = variance_of_means(stand, np.ones(18, dtype=int), rounding(stand, step))
    witness = model.WholeModel(PAPER.data, counts * step, variance, stand)
    assert verdict.chi_squared == pytest.approx(witness.chi_squared, rel=1e-9)
