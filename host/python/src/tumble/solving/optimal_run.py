"""The optimal estimator for a recorded run: weights made for the run, evaluated by the core.

Weights depend on K: they are made at the last known K of the block, or at a first least-squares estimate by the core.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats, Integers
from tumble.core.optimal import OptimalEstimate, optimal
from tumble.schedule import CHECK, Schedule
from tumble.solving.gain_record import record_of, to_bytes
from tumble.solving.gains import OptimalTable, optimal_table
from tumble.stand import PerChannel, Stand


@dataclass(frozen=True)
class Known:
    """What a table was made for that existed before the run: the block's `k` (3, 3), `samples` expected in every mean,
    not necessarily a whole number."""

    k: Floats
    samples: float


@dataclass(frozen=True)
class Weighting:
    """What weights are made from: the declared `stand`, its noise and the converter's `step` (0: unknown) in the unit
    of the outputs; `samples` (positions,) of the run; `known`: of a table that existed before the run,
    if one did."""

    stand: Stand
    samples: Integers
    step: PerChannel = 0.0
    known: Known | None = None


def estimate(schedule: core.CoreSchedule, means: Floats, measured: Flags, weighting: Weighting) -> OptimalEstimate:
    """Coefficients and the stand's errors by the core. Raises CoreRefusal; UsageError where weights cannot be made."""
    table = make_table(schedule, means, measured, weighting)
    return apply_table(table, schedule.part(measured), means[measured])


def make_table(
    schedule: core.CoreSchedule, means: Floats, measured: Flags, weighting: Weighting, further: Floats | None = None
) -> OptimalTable:
    """The weights for a run; `further` as of optimal_table. Raises CoreRefusal, UsageError."""
    first = core.estimate(schedule, means, measured, "least_squares")[0]
    k = first if weighting.known is None else weighting.known.k
    samples = samples_in_a_mean(schedule.data, measured, weighting)
    return optimal_table(schedule.data.part(measured), k, weighting.stand, weighting.step, samples, further)


def apply_table(table: OptimalTable, schedule: core.CoreSchedule, means: Floats) -> OptimalEstimate:
    """Let the core evaluate a table made for this very schedule, all of it measured. Raises CoreRefusal."""
    return optimal(to_bytes(record_of(table, schedule.data)), schedule, means)


def samples_in_a_mean(schedule: Schedule, measured: Flags, weighting: Weighting) -> float:
    """As many samples in every mean as give the same noise on the average."""
    if weighting.known is not None:
        return float(weighting.known.samples)
    fit = measured & np.array([position.use != CHECK for position in schedule.positions])
    samples = weighting.stand.averaged_over(weighting.samples)[fit]
    return float(1.0 / (1.0 / samples).mean())
