"""The gain record of a bench run with the optimal estimator: made before the run, for what is known of the block."""

from __future__ import annotations

import numpy as np

from tumble.model.optimal import optimal_table
from tumble.solving.optimal_run import Known, record_of, to_bytes
from tumble.stand import by_channel
from tumble.world.setup import Setup, step_v

_USUAL_BLOCK = {"scale_v_per_g": -2.0, "misalignment_rad": 0.02}  # the program's own, where no file describes a block

_FEWEST_SAMPLES = 16  # before which the procedure does not look at an error budget
_MOST = 1e6  # times the budget that one sample's noise counts as, at most


def known(setup: Setup) -> Known:
    """The block's nominal K and the samples of a position."""
    block = _USUAL_BLOCK if setup.block is None else setup.block
    shape = np.full((3, 3), block["misalignment_rad"])
    np.fill_diagonal(shape, 1.0)
    return Known(by_channel(block["scale_v_per_g"])[:, None] * shape, _expected_samples(setup))


def _expected_samples(setup: Setup) -> float:
    """All that are asked for; with an error budget as many as bring the noise of a mean to it, but no fewer than the
    procedure takes before it looks."""
    if setup.error_budget_v == 0.0:
        return float(setup.samples)
    one_sample = float(setup.stand.with_step(step_v(setup)).sigmas("noise").max())
    wanted = (one_sample / setup.error_budget_v) ** 2 if one_sample < _MOST * setup.error_budget_v else _MOST**2
    return max(wanted, float(min(_FEWEST_SAMPLES, setup.samples)))


def record(setup: Setup) -> bytes:
    """What goes into the navigation computer's non-volatile memory. Raises UsageError where no weights can be made."""
    before, schedule = known(setup), setup.schedule.data
    return to_bytes(record_of(optimal_table(schedule, before.k, setup.stand, step_v(setup), before.samples), schedule))
