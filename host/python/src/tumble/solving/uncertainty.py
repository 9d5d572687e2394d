"""The standard uncertainties that a result states: by the core, confirmed by the covariance that numpy finds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats
from tumble.core.uncertainty import uncertainties, uncertainties_of_gains
from tumble.estimators import OPTIMAL
from tumble.model.optimal import NOISE_FLOOR_G, OptimalEstimate
from tumble.model.propagation import Propagation
from tumble.solving.crosscheck import compare_uncertainties


@dataclass(frozen=True)
class Stated:
    """Standard uncertainties `u_k` (3, 3), `u_u0` (3,); `covariance` of K row by row, U0 and the sizes of further
    terms, where there are any."""

    u_k: Floats
    u_u0: Floats
    covariance: Floats

    @property
    def of_twelve(self) -> Floats:
        """Covariance (12, 12) of K row by row and U0."""
        return self.covariance[:12, :12]


def stated(
    given: Propagation,
    schedule: core.CoreSchedule,
    measured: Flags,
    mean_variance: Floats,
    optimal: OptimalEstimate | None = None,
) -> Stated:
    """Of an estimate as `given`, of the measured positions of a `schedule`; `mean_variance` (positions of `given`, 3):
    by the noise as measured; `optimal`: what numpy found by that estimator, if it has. Raises CoreRefusal,
    Disagreement."""
    u = standard_uncertainties(given, schedule, measured, mean_variance)
    covariance = given.covariance(mean_variance) if optimal is None else optimal.covariance
    compare_uncertainties(u, np.sqrt(np.diag(covariance)), given.estimator == OPTIMAL)
    return Stated(u[:9].reshape(3, 3), u[9:12], covariance)


def standard_uncertainties(
    given: Propagation, schedule: core.CoreSchedule, measured: Flags, mean_variance: Floats | None = None
) -> Floats:
    """Of K row by row, U0 and the sizes of further terms (12 + 3 x terms,), by the core; arguments as of `stated`.

    Those of the optimal estimator are for weights made at the solved K: the second order, which it takes out, makes up
    for weights made elsewhere.
    """
    part, stand = schedule.part(measured), given.stand.with_step(given.step)
    if given.estimator != OPTIMAL and not given.terms:
        run = part, given.k, stand, given.samples, given.estimator
        u_k, u_u0 = uncertainties(*run, mean_variance=mean_variance)
        return np.concatenate([u_k.ravel(), u_u0])
    least_noise = NOISE_FLOOR_G * float(np.abs(given.k).max()) if given.estimator == OPTIMAL else 0.0
    found = []
    for start in range(0, len(given.gains), 12):  # the core takes twelve rows at a time
        rows = given.gains[start : start + 12]
        table = np.vstack([rows, np.zeros((12 - len(rows), rows.shape[1]))])
        u_k, u_u0 = uncertainties_of_gains(
            part, given.k, stand, given.samples, table, mean_variance=mean_variance, least_noise=least_noise
        )
        found.append(np.concatenate([u_k.ravel(), u_u0])[: len(rows)])
    return np.concatenate(found)
