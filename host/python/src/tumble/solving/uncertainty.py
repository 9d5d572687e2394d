"""The standard uncertainties that a result states: by the core, confirmed by the covariance that numpy finds.

How well these are known themselves, and by what factor they are to be multiplied for 95 % (`coverage`): what a stand
file declares is taken as known, of infinitely many degrees of freedom. What the samples of the run say of their noise
comes from a finite number of blocks, one pooled estimate a channel. After Welch and Satterthwaite

    freedom = u^4 / sum over channels (u_measured^4 / freedom of the channel)

with u_measured the part of u that comes from the measured noise of that channel; the factor is Student's t.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats, Integers
from tumble.core.binding import uncertainties, uncertainties_of_gains
from tumble.distributions import student_quantile
from tumble.estimators import OPTIMAL
from tumble.model.coefficients import variances
from tumble.model.optimal import NOISE_FLOOR_G, OptimalEstimate
from tumble.model.propagation import Propagation
from tumble.solving.computation import compare_uncertainties
from tumble.solving.noise import Noise
from tumble.stand import Stand


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


PROBABILITY = 0.95
HANDS = "For faces laid by hand the real uncertainty can be over 100 times larger."  # than that of noise alone
NEARLY_INFINITE = 1e6  # degrees of freedom, for people: k is that of infinitely many to 2e-6


@dataclass(frozen=True)
class Coverage:
    """`freedom` (12,): effective degrees of freedom of the standard uncertainties of K row by row and U0; `intrinsic`
    (9,): those of scale, angles and bias. Infinite where nothing in them was measured in the run."""

    freedom: Floats
    intrinsic: Floats = field(default_factory=lambda: np.full(9, math.inf))

    @property
    def factors(self) -> Floats:
        """k (12,): within k u of the value the truth lies with PROBABILITY."""
        return factors_of(self.freedom)


def factors_of(freedom: Floats) -> Floats:
    """k of Student's t for PROBABILITY."""
    return np.array([student_quantile(PROBABILITY, one) for one in freedom])


def coverage(
    noise: Noise,
    measured: Flags,
    stand: Stand,
    samples: Integers,
    covariance_with: Callable[[Floats], Floats],
    by_intrinsic: Floats,
) -> Coverage:
    """Of the uncertainties that `covariance_with` gives: from variances (positions, 3) of the means, which count where
    they are larger than those of `stand`, to a covariance of the twelve, and perhaps of more behind them.

    `noise` of the run; `measured` (all positions,) bool; `samples` (measured positions,) as Stand.averaged_over takes
    them. `by_intrinsic` (9, 12): derivatives of the intrinsic parameters by the twelve.
    """
    variance, by_samples = noise.mean_variance[measured], noise.by_samples[measured]
    by_samples = np.where(by_samples >= stand.mean_variance(samples), by_samples, 0.0)
    if noise.measured is None or not by_samples.any():
        return Coverage(np.full(12, math.inf))
    gradients = np.concatenate([np.eye(12), by_intrinsic])
    whole, parts = variances(gradients, covariance_with(variance)[:12, :12]), np.zeros((3, len(gradients)))
    for channel in np.flatnonzero(by_samples.any(axis=0)):
        once_more = variance.copy()  # a variance is linear in those of the means: what the same again adds is its part
        once_more[:, channel] += by_samples[:, channel]
        parts[channel] = variances(gradients, covariance_with(once_more)[:12, :12]) - whole
    freedom = effective(whole, parts, noise.measured.freedom)
    return Coverage(freedom[:12], freedom[12:])


def effective(variance: Floats, parts: Floats, freedom: Integers | Floats) -> Floats:
    """Degrees of freedom (n,) of a `variance` (n,), of which `parts` (sources, n) are estimates with `freedom`
    (sources,) each, and the rest is known."""
    below = (np.maximum(parts, 0.0) ** 2 / np.asarray(freedom, dtype=float)[:, None]).sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        found: Floats = np.where(below > 0.0, variance**2 / below, math.inf)
    return found
