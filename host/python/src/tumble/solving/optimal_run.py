"""The optimal estimator for a recorded run: weights made for the run, evaluated by the core.

Weights depend on K: they are made at the last known K of the block, or at a first least-squares estimate by the core.
"""

from __future__ import annotations

from dataclasses import dataclass

from tumble import core
from tumble.arrays import Flags, Floats, Integers
from tumble.core.optimal import OptimalEstimate, optimal
from tumble.model.optimal import OptimalTable, optimal_table, samples_in_a_mean
from tumble.solving.gain_record import record_of, to_bytes
from tumble.stand import PerChannel, Stand
from tumble.terms import Terms


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


def make_table(
    schedule: core.CoreSchedule, means: Floats, measured: Flags, weighting: Weighting, terms: Terms = ()
) -> OptimalTable:
    """The weights for a run, of a model with further `terms`. Raises CoreRefusal, UsageError."""
    part, known = schedule.data.part(measured), weighting.known
    if known is not None:
        return optimal_table(part, known.k, weighting.stand, weighting.step, known.samples, terms)
    first = core.estimate(schedule, means, measured, "least_squares")[0]
    samples = samples_in_a_mean(part, weighting.stand, weighting.samples[measured])
    return optimal_table(part, first, weighting.stand, weighting.step, samples, terms)


def apply_table(table: OptimalTable, schedule: core.CoreSchedule, means: Floats) -> OptimalEstimate:
    """Let the core evaluate a table made for this very schedule, all of it measured. Raises CoreRefusal."""
    return optimal(to_bytes(record_of(table, schedule.data)), schedule, means)


def estimate(schedule: core.CoreSchedule, means: Floats, measured: Flags, weighting: Weighting) -> OptimalEstimate:
    """Coefficients and the stand's errors by the core. Raises CoreRefusal; UsageError where weights cannot be made."""
    table = make_table(schedule, means, measured, weighting)
    return apply_table(table, schedule.part(measured), means[measured])
