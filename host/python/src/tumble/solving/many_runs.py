"""An estimator for thousands of runs on one schedule at once, by the core."""

from __future__ import annotations

from collections.abc import Callable

from tumble import core
from tumble.arrays import Floats, Integers
from tumble.core.optimal import GainRecord, estimate_runs, optimal_runs
from tumble.estimators import OPTIMAL
from tumble.reference.estimators import fit_indices
from tumble.schedule import Schedule
from tumble.solving import extended
from tumble.solving.gain_record import record_of, to_bytes
from tumble.solving.gains import OptimalTable, optimal_table
from tumble.stand import PerChannel, Stand
from tumble.terms import Terms

ManyRuns = Callable[[Floats], Floats]


def estimator_for(
    schedule: Schedule,
    k: Floats,
    stand: Stand,
    estimator: str,
    samples: Integers,
    step: PerChannel = 0.0,
    terms: Terms = (),
) -> ManyRuns:
    """From means (runs, positions, 3), all measured, to coefficients (runs, 12). `optimal` has weights made at `k`: its
    second order makes up for those of each run's own K. `terms`: further unknowns. What is returned raises
    CoreRefusal."""
    positions = core.CoreSchedule(schedule)
    if terms:
        table = table_at(schedule, k, stand, samples, step, terms) if estimator == OPTIMAL else None
        return lambda means: extended.estimate_runs(positions, means, terms, table)[:, :12]
    if estimator != OPTIMAL:
        return lambda means: estimate_runs(positions, means, estimator)
    table = table_at(schedule, k, stand, samples, step)
    record = GainRecord(positions, to_bytes(record_of(table, schedule)))
    return lambda means: optimal_runs(record, means)[0]


def table_at(
    schedule: Schedule, k: Floats, stand: Stand, samples: Integers, step: PerChannel = 0.0, terms: Terms = ()
) -> OptimalTable:
    """The weights of `optimal` at `k`; `samples` (positions,): rows of each, as Stand.averaged_over has them."""
    fitted = stand.averaged_over(samples)[fit_indices(schedule)]
    further = extended.fitted_columns(core.CoreSchedule(schedule), terms)
    return optimal_table(schedule, k, stand, step, float(1.0 / (1.0 / fitted).mean()), further)
