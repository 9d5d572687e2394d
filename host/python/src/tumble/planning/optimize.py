"""Optimal weights for a stand: the gain table for a stand and a schedule, and its gain in accuracy."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

from tumble.arrays import Floats
from tumble.documents.plan import Optimize, Promise
from tumble.estimators import COEFFICIENTS, OPTIMAL
from tumble.model.estimators import circles, linear_gains
from tumble.model.optimal import optimal_table
from tumble.model.propagation import SecondOrder, second_order
from tumble.planning.case import Case
from tumble.planning.promise import promise
from tumble.solving.computation import estimator_or_linear
from tumble.solving.optimal_run import Record, record_of, require_declared_inclinations
from tumble.solving.result import second_order_of
from tumble.stand import per_channel


@dataclass(frozen=True)
class Optimized:
    """`u` (12,): standard deviations of the estimate with the table. `u_refined`, `u_least_squares`: of those
    estimators, the first None where the schedule does not allow it. `efficiency`: bound over `u`. `promise`: for a run
    with the table."""

    case: Case
    table: Record
    u: Floats
    u_refined: Floats | None
    u_least_squares: Floats
    promise: Promise

    @property
    def efficiency(self) -> Floats:
        """The smallest possible standard deviations, from the QR factors, over those of the stored gains."""
        return self.table.u / self.u

    @cached_property
    def second_order(self) -> SecondOrder:
        """Whether the linear theory is accurate enough on this stand."""
        given = replace(self.case.propagation(OPTIMAL, self.table.k, fitted=True), terms=())
        return second_order(given, self.u, estimator_or_linear(given))


def optimize(case: Case, k: Floats | None = None, serial: str | None = None) -> Optimized:
    """Compute the weights for a block of sensitivity `k` (V/g), by default the nominal one. Raises UsageError."""
    require_declared_inclinations(case.schedule, case.stand)
    k = case.nominal_k() if k is None else k
    table = optimal_table(case.fitted, k, case.stand, case.step_v)
    harmonic = circles(case.fitted) is not None
    return Optimized(
        case=case,
        table=record_of(table, case.fitted, serial),
        u=case.spread(table.gains, k),
        u_refined=case.spread(linear_gains(case.fitted, "refined"), k) if harmonic else None,
        u_least_squares=case.spread(linear_gains(case.fitted, "least_squares"), k),
        promise=promise(case, OPTIMAL, k=k),
    )


def document(found: Optimized) -> Optimize:
    """The plan for JSON."""
    table, case = found.table, found.case
    return Optimize(
        stand=case.stand.name,
        block=case.block,
        names=COEFFICIENTS,
        K=table.k,
        gains=table.gains,
        stand_gains=table.nuisance_gains,
        u_K=found.u[:9].reshape(3, 3),
        u_U0=found.u[9:],
        efficiency=found.efficiency,
        gain_over_refined=None if found.u_refined is None else found.u_refined / found.u,
        gain_over_least_squares=found.u_least_squares / found.u,
        sigma_mean_v=per_channel(table.sigma_mean / table.weights),
        noise_floored=table.floored,
        second_order=second_order_of(found.second_order),
        promise=found.promise,
    )
