"""An estimator for thousands of runs on one schedule at once, by the core."""

from __future__ import annotations

from tumble import core
from tumble.arrays import Floats
from tumble.core.optimal import GainRecord, estimate_runs, optimal_runs
from tumble.estimators import OPTIMAL
from tumble.model.errors import by_gains
from tumble.model.optimal import by_table
from tumble.model.propagation import Propagation
from tumble.model.second_order import ManyRuns
from tumble.solving import extended
from tumble.solving.gain_record import record_of, to_bytes


def estimator_for(given: Propagation) -> ManyRuns:
    """From means (runs, positions, 3), all measured, to K row by row, U0 and the sizes of further terms (runs, 12 + 3 x
    terms). `optimal` has weights made at the `k` given: its second order makes up for those of each run's own K. What
    is returned raises CoreRefusal."""
    schedule, terms = core.CoreSchedule(given.schedule), given.terms
    if given.estimator != OPTIMAL:
        if terms:
            return lambda means: extended.least_squares(schedule, means, terms)
        return lambda means: estimate_runs(schedule, means, given.estimator)
    if terms:
        return lambda means: by_table(given.table, given.schedule, given.stand, terms, means)
    record = GainRecord(schedule, to_bytes(record_of(given.table, given.schedule)))
    return lambda means: optimal_runs(record, means)[0]


def or_linear(given: Propagation) -> ManyRuns:
    """The same, of the twelve alone; beyond 0.1 rad, where `optimal` gives no result, its linear part, whose bias says
    enough."""
    estimate = estimator_for(given)

    def of(means: Floats) -> Floats:
        try:
            return estimate(means)[:, :12]
        except core.CoreRefusal:
            if given.estimator != OPTIMAL:
                raise
            return by_gains(given.schedule, given.gains[:12])(means)

    return of
