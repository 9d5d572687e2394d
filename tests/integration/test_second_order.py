"""The bias that squares of the stand's errors leave: against closed forms, means of the exact geometry, and runs."""

import dataclasses

import numpy as np
import pytest
from blocks import NOMINAL_K, random_block, usable_schedule
from conftest import EXAMPLES
from documents import document_of
from hypothesis import given, settings, strategies as st
from test_plan_validate import case_of

from tumble import model
from tumble.core import estimate_runs
from tumble.estimators import COEFFICIENTS, LINEAR
from tumble.model.optimal import optimal_table
from tumble.model.propagation import Propagation, SecondOrder, second_order
from tumble.planning.validate import validate
from tumble.schedule import FIT, Schedule
from tumble.solving.computation import estimator_or_linear
from tumble.stand import COMMON, INDEPENDENT, PAPER_STAND, Stand

pytestmark = pytest.mark.python
PAPER = model.built_in("paper")
seeds = st.integers(0, 2**32 - 1)
ANY_U = np.full(12, 1e-3)


def bias_of(schedule, k, u, stand, estimator, step=0.0):
    """Of means of so many samples as the stand says."""
    given = Propagation(schedule, k, stand, np.ones(len(schedule.positions), dtype=int), estimator, step)
    return second_order(given, u, estimator_or_linear(given))


def stand_of(axis_tilt=0.0, level=0.0, remount=0.0, angle=0.0, noise=1e-3, **others):
    return Stand(axis_tilt, level, remount, angle, noise, 1, "sigma1", **others)


@pytest.mark.parametrize("remounting", [INDEPENDENT, COMMON])
@pytest.mark.parametrize("estimator", LINEAR)
def test_closed_form_on_the_papers_schedule(estimator, remounting):
    """E cos of a normal angle is exp(-sigma^2/2), E sin is 0: every error shortens what it turns, and no more."""
    sizes = {"axis_tilt": 3e-3, "level": 2e-3, "remount": 7e-3, "angle": 5e-3}
    found = bias_of(PAPER, NOMINAL_K, ANY_U, stand_of(**sizes, remounting=remounting), estimator)
    common = sum(sizes[name] ** 2 for name in ("axis_tilt", "level", "angle"))
    shortened = np.array([common + sizes["remount"] ** 2, common, common])
    expected = NOMINAL_K * np.expm1(-shortened / 2)
    assert found.bias[:9].reshape(3, 3) == pytest.approx(expected, rel=1e-8)
    assert np.abs(found.bias[9:]).max() < 1e-14
    assert list(found.parts) == ["alpha1", "alpha2", "alpha3", "alpha4"]
    assert sum(found.parts.values())[:9] == pytest.approx(expected.ravel(), rel=1e-4)


def mean_outputs(schedule, k, stand):
    """By hand: outputs of the mean specific force. In the table frame h and v are shortened by whatever turns the
    table, all by the tilt; a yaw then shortens h and n."""
    force = []
    tilt = np.exp(-(stand.axis_tilt**2) / 2)
    turn = np.exp(-(stand.level**2 + stand.angle**2) / 2)
    yaw = np.exp(-(stand.remount**2) / 2)
    for position in schedule.positions:
        [mounting] = [one for one in schedule.mountings if one.number == position.mounting]
        known, phi = np.deg2rad(mounting.tilt_deg), np.deg2rad(position.angle_deg)
        h, n, v = np.cos(known) * np.sin(phi) * turn * yaw, np.sin(known) * yaw, np.cos(known) * np.cos(phi) * turn
        force.append(np.array(mounting.matrix) @ (tilt * np.array([h, n, v])))
    return np.array(force) @ k.T


@given(seeds)
@settings(max_examples=60)
def test_any_schedule(seed):
    rng = np.random.default_rng(seed)
    schedule, (k, _) = usable_schedule(rng), random_block(rng)
    stand = stand_of(*(10.0 ** rng.uniform(-4, -2, 4)).tolist())
    found = bias_of(schedule.data, k, ANY_U, stand, "least_squares")
    expected = estimate_runs(schedule, mean_outputs(schedule.data, k, stand)[None], "least_squares")[0]
    expected -= np.concatenate([k.ravel(), np.zeros(3)])
    assert found.bias == pytest.approx(expected, rel=1e-6, abs=1e-9 * np.abs(expected).max() + 1e-12 * np.abs(k).max())


def test_positions_that_only_check_leave_none():
    """They are not fitted: with them there, in whatever order, the bias is the same."""
    positions = tuple(dataclasses.replace(one, number=one.number + 20, use="check") for one in PAPER.positions)
    both = Schedule(PAPER.mountings, (*positions, *PAPER.positions))
    assert all(one.use == FIT for one in PAPER.positions)
    for estimator in ("refined", "optimal"):
        alone, beside = (bias_of(one, NOMINAL_K, ANY_U, PAPER_STAND, estimator).bias for one in (PAPER, both))
        assert beside == pytest.approx(alone, abs=1e-12)


LARGE = {
    "yaw": {"remount": 15e-3},
    "tilt": {"axis_tilt": 15e-3},
    "level": {"level": 15e-3},
    "all four": {"remount": 10e-3, "axis_tilt": 10e-3, "level": 10e-3, "angle": 10e-3},
}


@pytest.mark.toolchain
@pytest.mark.slow
@pytest.mark.parametrize("errors", LARGE)
def test_runs_are_biased_as_it_says(errors):
    """20,000 runs of the core: a mean is then known to 0.007 of the spread."""
    case = case_of("paper", **LARGE[errors])
    k = case.nominal_k()
    for one in validate(case, ("averaged", "refined", "least_squares", "optimal"), 20_000, 1):
        found = bias_of(case.fitted, k, one.u, case.stand, one.estimator, step=case.step_v)
        known = 4.0 * one.tally.spread / 20_000**0.5
        assert np.all(np.abs(found.bias - one.tally.bias) <= known + 0.02 * np.abs(found.bias)), one.estimator
        flagged = {shift.coefficient for shift in found.shifts}
        sure = np.abs(np.abs(one.tally.bias) - 0.2 * one.u) > known + 0.02 * np.abs(found.bias)
        told = {name for name, bias, u in zip(COEFFICIENTS, one.tally.bias, one.u) if abs(bias) > 0.2 * u}
        assert flagged ^ told <= {name for name, is_sure in zip(COEFFICIENTS, sure) if not is_sure}
        if one.estimator == "optimal":
            assert found.matters == (errors == "all four")


@pytest.mark.parametrize("name", ["paper", "angle", "lab"])
def test_the_examples_are_not_flagged(name):
    case = case_of(name)
    u = optimal_table(case.fitted, case.nominal_k(), case.stand, case.step_v).u
    for estimator in (*LINEAR, "optimal"):
        found = bias_of(case.fitted, case.nominal_k(), u, case.stand, estimator, step=case.step_v)
        assert not found.matters, estimator


def test_a_stand_without_errors_has_none():
    for estimator in ("refined", "optimal"):
        found = bias_of(PAPER, NOMINAL_K, np.zeros(12), stand_of(), estimator)
        assert not found.bias.any() and not found.matters and found.complaints == []


def test_the_limit_is_a_fifth():
    bias = np.zeros(12)
    bias[3] = -2e-4
    u = np.full(12, 1e-3)
    scale = np.full(12, 2.0)
    at_limit = SecondOrder(bias, {"alpha3": bias, "alpha1": 0 * bias}, u, scale, 0.0)
    assert not at_limit.matters
    beyond = dataclasses.replace(at_limit, bias=bias * 1.0001)
    [shift] = beyond.shifts
    assert (shift.source, shift.coefficient) == ("alpha3", "K_yx")
    assert (shift.bias_relative, shift.limit) == (pytest.approx(1.0001e-4), pytest.approx(1e-4))
    assert beyond.complaints == ["large yaw: second order shifts K_yx by 0.0001, more than 0.2 u(K_yx)/K_yy = 0.0001"]
    unknown = dataclasses.replace(beyond, u=np.full(12, np.nan))
    assert not unknown.matters


def test_beyond_what_the_firmware_takes_the_linear_part_is_judged():
    stand = dataclasses.replace(PAPER_STAND, remount=0.3)
    found = bias_of(PAPER, NOMINAL_K, np.full(12, 1e-5), stand, "optimal")
    assert found.matters and found.complaints[0].startswith("large yaw")


def test_a_result_has_the_bias_of_every_coefficient(tumble):
    done = tumble("solve", "lab_stand.csv", "--unit", "V", "--stand", "lab_stand.toml", "--json", cwd=EXAMPLES)
    result = document_of(done, codes=(0, 1))
    bias, k = result["second_order"]["bias"], np.array(result["K"])
    shortened = 2e-4**2 + 5e-4**2 + 2e-4**2
    expected = -k / 2 * np.array([shortened + 2e-3**2, shortened, shortened])
    assert np.array(bias["K"]) == pytest.approx(expected, rel=1e-4)
    assert bias["U0"] == pytest.approx([0, 0, 0], abs=1e-12)
