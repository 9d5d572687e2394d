"""What the firmware core makes of a run: coefficients, checks, and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats
from tumble.estimators import OPTIMAL
from tumble.solving import optimal_run


@dataclass(frozen=True)
class Computation:
    """Results of the core. Arrays as in tumble.core.binding.

    `closure`: by mounting number, for mountings that came back to an attitude. `residual_rms`: None with fewer than
    five fit positions.
    """

    estimator: str
    k: Floats
    u0: Floats
    gravity: core.GravityCheck
    intrinsic: core.Intrinsic
    closure: dict[int, Floats]
    residual_rms: Floats | None


def compute(
    schedule: core.CoreSchedule,
    means: Floats,
    measured: Flags,
    estimator: str,
    limit_g: float,
    weighting: optimal_run.Weighting | None = None,
) -> Computation:
    """Let the core estimate and verify. `weighting`: of the optimal estimator, which alone needs it.

    Raises CoreRefusal; DeadChannels where a channel does not feel gravity.
    """
    if estimator == OPTIMAL:
        assert weighting is not None
        found = optimal_run.estimate(schedule, means, measured, weighting)
        k, u0 = found.k, found.u0
    else:
        k, u0 = core.estimate(schedule, means, measured, estimator)
    _require_response(k, means[measured])
    return Computation(
        estimator=estimator,
        k=k,
        u0=u0,
        gravity=core.gravity_check(schedule, means, measured, core.Calibration(k, u0), limit_g),
        intrinsic=core.intrinsic(k, u0),
        closure=_closures(schedule, means, measured),
        residual_rms=core.residual_rms(schedule, means, measured, k, u0),
    )


class DeadChannels(Exception):
    """K is singular, and one can say why: `channels`, such as ["ux"], do not respond to gravity."""

    def __init__(self, channels: list[str]):
        super().__init__(f"no response to gravity in channel {' and '.join(channels)}: K is singular")


_ROUNDING = 1e-13  # of the outputs: a response below it is what summing them leaves, whatever the core makes of it


def _require_response(k: Floats, outputs: Floats) -> None:
    response = np.linalg.norm(k, axis=1)
    dead = response <= np.maximum(core.MIN_ROW_RATIO * response.max(), _ROUNDING * np.abs(outputs).max(axis=0))
    if dead.any():
        raise DeadChannels([f"u{axis}" for axis, is_dead in zip(core.AXES, dead) if is_dead])


def _closures(schedule: core.CoreSchedule, means: Floats, measured: Flags) -> dict[int, Floats]:
    numbers = [mounting.number for mounting in schedule.data.mountings]
    differences = {number: core.closure(schedule, means, measured, number) for number in numbers}
    return {number: difference for number, difference in differences.items() if difference is not None}
