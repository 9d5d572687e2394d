"""What the firmware core makes of a run: coefficients, checks, and what follows from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats
from tumble.model.force import linear_outputs
from tumble.model.optimal import by_table
from tumble.solving import further, optimal_run
from tumble.terms import Terms


@dataclass(frozen=True)
class Computation:
    """Results of the core. Arrays as in tumble.core.binding.

    `closure`: by mounting number, for mountings that came back to an attitude. `residual_rms`: None with fewer than
    five fit positions. `sizes` (terms, 3) of further `terms` (tumble.terms); `linear` (positions, 3): the means without
    them, which is what the gravity check and all others look at.
    """

    estimator: str
    k: Floats
    u0: Floats
    gravity: core.GravityCheck
    intrinsic: core.Intrinsic
    closure: dict[int, Floats]
    residual_rms: Floats | None
    terms: Terms
    sizes: Floats
    linear: Floats


def compute(
    schedule: core.CoreSchedule,
    means: Floats,
    measured: Flags,
    estimator: str,
    limit_g: float,
    weighting: optimal_run.Weighting | None = None,
    terms: Terms = (),
) -> Computation:
    """Let the core estimate and verify. `weighting`: of the optimal estimator, which alone needs it.

    Raises CoreRefusal; DeadChannels where a channel does not feel gravity; NotSolvable.
    """
    sizes, linear = np.zeros((0, 3)), means
    if terms:
        found = _with_terms(schedule, means, measured, weighting, terms)
        k, u0, sizes = found[:9].reshape(3, 3), found[9:12], found[12:].reshape(-1, 3)
    elif weighting is None:
        k, u0 = core.estimate(schedule, means, measured, estimator)
    else:
        one = optimal_run.estimate(schedule, means, measured, weighting)
        k, u0 = one.k, one.u0
    _require_response(k, means[measured])
    calibration = core.Calibration(k, u0)
    if terms:
        linear = means.copy()
        linear[measured] = linear_outputs(means[measured], k, u0, sizes, terms)
    return Computation(
        estimator=estimator,
        k=k,
        u0=u0,
        gravity=core.gravity_check(schedule, linear, measured, calibration, limit_g),
        intrinsic=core.intrinsic(k, u0),
        closure=_closures(schedule, means, measured),
        residual_rms=_residual_rms(schedule, linear, measured, k, u0, len(terms)),
        terms=terms,
        sizes=sizes,
        linear=linear,
    )


def _with_terms(
    schedule: core.CoreSchedule,
    means: Floats,
    measured: Flags,
    weighting: optimal_run.Weighting | None,
    terms: Terms,
) -> Floats:
    """K row by row, U0 and the sizes (12 + 3 x terms,): by a table of gains where there are weights, else by the
    core's least squares."""
    part, lone = schedule.part(measured), means[None, measured]
    if weighting is None:
        found = further.least_squares(part, lone, terms)
    else:
        table = optimal_run.make_table(schedule, means, measured, weighting, terms)
        found = by_table(table, part.data, weighting.stand, terms, lone)
    return found.ravel()


def _residual_rms(
    schedule: core.CoreSchedule, means: Floats, measured: Flags, k: Floats, u0: Floats, terms: int
) -> Floats | None:
    """The core's, which is over the positions less four, over those less all unknowns of a channel."""
    rms = core.residual_rms(schedule, means, measured, k, u0)
    left = len(schedule.data.part(measured).fit_indices) - 4
    if rms is None or left <= terms:
        return None
    found: Floats = rms * (left / (left - terms)) ** 0.5
    return found


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
