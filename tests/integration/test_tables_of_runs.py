"""Weights for many runs at once are those that optimal_table makes for each of them."""

import dataclasses

import numpy as np
import pytest
from conftest import EXAMPLES
from core_functions import apply_table

from tumble import core
from tumble.errors import UsageError
from tumble.files.stand_file import read_stand
from tumble.model.optimal import optimal_table
from tumble.planning.case import Case
from tumble.planning.validate import position_means
from tumble.solving import optimal_run

pytestmark = pytest.mark.python
STANDS = {
    "paper": {},
    "angle": {},
    "lab": {"remounting": "common"},
    "paper, more declared": {"seat": 2e-4, "platform": 1e-4, "encoder": 1e-4, "drift": 1e-3},
    "lab, angles exact": {"angle": 0.0},
}


def case_of(name):
    file = read_stand(str(EXAMPLES / f"{name.split(',')[0]}_stand.toml"))
    return Case.of(dataclasses.replace(file, stand=dataclasses.replace(file.stand, **STANDS[name])), name, None)


def means_of(case, runs):
    return position_means(case, case.nominal_k(), runs, np.random.default_rng(7))


def solved(case, means):
    return optimal_run.solve_each(case.fitted, means, case.stand, case.step_v, case.stand.samples)


@pytest.mark.parametrize("name", STANDS)
def test_each_run_gets_what_it_gets_alone(name):
    case = case_of(name)
    schedule, means = core.CoreSchedule(case.fitted), means_of(case, 12)
    found, u = solved(case, means)
    everything = np.ones(len(schedule), dtype=bool)
    weighting = optimal_run.Weighting(case.stand, everything.astype(int), case.step_v)
    for index, run in enumerate(means):
        table = optimal_run.make_table(schedule, run, everything, weighting)
        alone = apply_table(table, schedule, run)
        assert np.abs(found[index] - [*alone.k.ravel(), *alone.u0]).max() <= 1e-13 * np.abs(alone.k).max()
        stated = optimal_table(case.fitted, alone.k, case.stand, case.step_v).u
        assert np.abs(u[index] / stated - 1.0).max() <= 1e-12


def test_results_do_not_depend_on_how_runs_are_cut():
    case = case_of("paper")
    means = means_of(case, 2 * optimal_run._AT_ONCE + 3)
    whole = solved(case, means)
    for cut in (slice(0, 1), slice(3, 8), slice(50, None)):
        assert all((part == all_[cut]).all() for part, all_ in zip(solved(case, means[cut]), whole))


def test_weights_that_rounding_spoils_are_refused():
    case = case_of("paper")
    stand = dataclasses.replace(case.stand, angle=1e8, remount=1e9)
    with pytest.raises(UsageError, match="too unequal"):
        optimal_run.solve_each(case.fitted, means_of(case, 3), stand, 0.0, stand.samples)


def test_a_drift_beyond_any_noise_is_refused():
    case = case_of("paper")
    stand = dataclasses.replace(case.stand, drift=1e9)
    with pytest.raises(UsageError, match="times the noise of a mean, above 1e"):
        optimal_run.solve_each(case.fitted, means_of(case, 3), stand, 0.0, stand.samples)


def test_a_run_that_the_core_refuses_is_named():
    case = case_of("paper")
    means = means_of(case, 4)
    means[2, 5] += 3.0  # errors of the stand beyond what the series hold
    with pytest.raises(core.CoreRefusal) as refusal:
        solved(case, means)
    assert refusal.value.name == "TUMBLE_E_STAND_ERROR" and refusal.value.details["run"] == 2
