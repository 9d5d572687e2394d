"""The gain record of a bench run with the optimal estimator: made before the run, for what is known of the block."""

from __future__ import annotations

import numpy as np

from tumble.bench.setup import Setup
from tumble.planning.gains import optimal_table
from tumble.planning.record import record_of, to_bytes
from tumble.standfile import converter_step_v
from tumble.weighted import Known

_USUAL_BLOCK = {"scale_v_per_g": -2.0, "misalignment_rad": 0.02}  # the program's own, where no file describes a block


def known(setup: Setup) -> Known:
    """The block's nominal K and the samples of a position."""
    block = _USUAL_BLOCK if setup.block is None else setup.block
    shape = np.full((3, 3), block["misalignment_rad"])
    np.fill_diagonal(shape, 1.0)
    return Known(block["scale_v_per_g"] * shape, setup.samples)


def step_v(setup: Setup) -> float:
    """Size of a count as the stand file declares it; 0 where it does not."""
    return 0.0 if setup.block is None else converter_step_v(setup.block)


def record(setup: Setup) -> bytes:
    """What goes into the navigation computer's non-volatile memory. Raises UsageError where no weights can be made."""
    before, schedule = known(setup), setup.schedule.data
    return to_bytes(record_of(optimal_table(schedule, before.k, setup.stand, step_v(setup), before.samples), schedule))
