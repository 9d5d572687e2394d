"""How the errors of a stand and the noise of the means reach an estimate, to first order.

An estimator is linear in the means, with gains G, and the errors add J s to these: so they add G J s to the
coefficients, and each source its part of the covariance.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.estimators import OPTIMAL
from tumble.model.errors import Draws, brought, by_gains, joint, sources
from tumble.model.estimators import linear_gains
from tumble.model.optimal import OptimalTable, optimal_covariance, optimal_table, samples_in_a_mean
from tumble.schedule import Schedule
from tumble.stand import PerChannel, Stand
from tumble.terms import Terms


@dataclass(frozen=True)
class Propagation:
    """Of an estimate on a `schedule`, all of it measured, of a block of sensitivity `k` (3, 3), with `samples`
    (positions,): rows of each, as Stand.averaged_over takes them. `stand` and the converter's `step` (0: unknown) in
    the outputs' unit; `terms`: further unknowns of the model. Methods raise UsageError where the schedule does not
    allow the estimator."""

    schedule: Schedule
    k: Floats
    stand: Stand
    samples: Integers
    estimator: str
    step: PerChannel = 0.0
    terms: Terms = ()

    @cached_property
    def table(self) -> OptimalTable:
        """The weights of `optimal`, made at `k`."""
        number = samples_in_a_mean(self.schedule, self.stand, self.samples)
        return optimal_table(self.schedule, self.k, self.stand, self.step, number, self.terms)

    @cached_property
    def gains(self) -> Floats:
        """By which the estimator finds K row by row, U0 and the sizes of further terms (12 + 3 x terms, 3 x fit
        positions)."""
        if self.estimator == OPTIMAL:
            return self.table.gains
        return linear_gains(self.schedule, self.estimator, self.terms)

    def errors(self, variance: Floats | None = None) -> dict[str, Draws]:
        """Every source of error; `variance` (positions, 3): of the means by the noise as measured, where it counts for
        more than the stand's."""
        return sources(self.schedule, self.k, self.stand.with_step(self.step), self.samples, variance)

    def brought(self, variance: Floats | None = None) -> dict[str, Floats]:
        """What one standard deviation of each draw brings to the unknowns: by source, (draws, 12 + 3 x terms)."""
        return brought(by_gains(self.schedule, self.gains), self.errors(variance))

    def covariance(self, variance: Floats | None = None) -> Floats:
        """Of the unknowns. That of `optimal` needs no table."""
        if self.estimator == OPTIMAL:
            given = self.schedule, self.k, self.stand, self.samples
            return optimal_covariance(*given, self.step, variance, self.terms)
        return joint(by_gains(self.schedule, self.gains), self.errors(variance))


def covariance(
    schedule: Schedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    estimator: str,
    mean_variance: Floats | None = None,
) -> Floats:
    """Covariance (12, 12) of an estimate, K row by row, then U0, in its units. Arguments as of Propagation; `k` is the
    solved K, `mean_variance` as of `errors`."""
    return Propagation(schedule, k, stand, np.asarray(samples), estimator).covariance(mean_variance)
