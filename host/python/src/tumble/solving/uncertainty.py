"""The standard uncertainties that a result states: by the core, confirmed by the covariance that numpy finds.

How well these are known themselves, and by what factor they are to be multiplied for 95 % (`coverage`): what a stand
file declares is taken as known, of infinitely many degrees of freedom. What the samples of the run say of their noise
comes from a finite number of blocks, one pooled estimate a channel. After Welch and Satterthwaite

    freedom = u^4 / sum over channels (u_measured^4 / freedom of the channel)

with u_measured the part of u that comes from the measured noise of that channel; the factor is Student's t.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats, Integers
from tumble.core import uncertainties, uncertainties_of_gains
from tumble.distributions import student_quantile
from tumble.documents.further import WithoutTerms
from tumble.documents.result import WorstNorm
from tumble.errors import BadInput
from tumble.estimators import INCLINED, NORM, OPTIMAL
from tumble.model.coefficients import variances, worst_norm
from tumble.model.optimal import NOISE_FLOOR_G, OptimalEstimate
from tumble.model.propagation import Propagation
from tumble.solving.computation import compare_uncertainties
from tumble.solving.noise import Noise
from tumble.terms import POWERS, Terms, expanded, model_of


@dataclass(frozen=True)
class ExtendedTerms:
    """`sizes` (terms, 3) of `terms`, expanded, beside `k` (3, 3), in the unit of the outputs, and these less the
    witness's (`difference`); `covariance` of K row by row, U0 and the sizes, and what uncertainties would be
    `without` the terms: None without a declared stand."""

    terms: Terms
    k: Floats
    sizes: Floats
    difference: Floats
    covariance: Floats | None = None
    without: WithoutTerms | None = None

    @property
    def values(self) -> Floats:
        """K2 in 1/g, K3 in 1/g^2, and so on, the drift over the run in the unit of the outputs: (terms, 3)."""
        return self.sizes * self.factors

    @property
    def factors(self) -> Floats:
        """Of the values, times the sizes: (terms, 3)."""
        return np.array([1.0 / np.diag(self.k) if term in POWERS else np.ones(3) for term in self.terms])

    @property
    def of_values(self) -> Floats | None:
        """Covariance of K row by row, U0 and the values."""
        if self.covariance is None:
            return None
        by_size = np.diag(np.concatenate([np.ones(12), self.factors.ravel()]))
        for row, (value, factor) in enumerate(zip(self.values.ravel(), self.factors.ravel())):
            if self.terms[row // 3] in POWERS:
                by_size[12 + row, 4 * (row % 3)] = -value * factor  # by K_ii
        found: Floats = by_size @ self.covariance @ by_size.T
        return (found + found.T) / 2.0

    @property
    def u(self) -> Floats | None:
        """Standard uncertainties of `values` (terms, 3)."""
        joint = self.of_values
        return None if joint is None else np.sqrt(np.diag(joint)[12:]).reshape(-1, 3)

    def by_term(self, numbers: Floats) -> dict[str, Floats]:
        """Numbers (terms, 3) by the names that a model has: six of `cross`."""
        of = dict(zip(self.terms, numbers))
        return {term: np.concatenate([of[one] for one in expanded((term,))]) for term in model_of(self.terms)}

    @property
    def worst_norm(self) -> WorstNorm | None:
        """Where the block shows the length of gravity worst, further terms applied."""
        return None if self.covariance is None else worst_norm(self.k, self.covariance, self.terms)

    @property
    def worst_norm_of_twelve(self) -> WorstNorm | None:
        """The same by what the uncertainties of K and U0 alone bring."""
        return None if self.covariance is None else worst_norm(self.k, self.covariance[:12, :12])


@dataclass(frozen=True)
class Uncertainties:
    """Standard uncertainties `u_k` (3, 3), `u_u0` (3,); `covariance` of K row by row, U0 and the sizes of further
    terms, where there are any: then also what they would be `without`."""

    u_k: Floats
    u_u0: Floats
    covariance: Floats
    without: WithoutTerms | None = None


def confirmed(
    given: Propagation,
    schedule: core.CoreSchedule,
    measured: Flags,
    mean_variance: Floats,
    optimal: OptimalEstimate | None,
    file: str,
) -> Uncertainties:
    """By the core and by numpy, of an estimate as `given`, of the measured positions of a `schedule`; `mean_variance`
    (positions of `given`, 3): by the noise as measured; `optimal`: what numpy found by that estimator, if it has.
    Raises Disagreement; BadInput of the run in `file` for a stand beyond what the core computes with."""
    try:
        u = standard_uncertainties(given, schedule, measured, mean_variance)
    except core.CoreRefusal as refusal:
        raise BadInput(f"no uncertainties from this stand: {refusal}", file) from None
    covariance = given.covariance(mean_variance) if optimal is None else optimal.covariance
    compare_uncertainties(u, np.sqrt(np.diag(covariance)), given.estimator == OPTIMAL)
    without = None
    if given.terms:
        alone = confirmed(replace(given, terms=()), schedule, measured, mean_variance, None, file)
        without = WithoutTerms(alone.u_k, alone.u_u0, worst_norm(given.k, alone.covariance).worst_g)
    return Uncertainties(u[:9].reshape(3, 3), u[9:12], covariance, without)


def standard_uncertainties(
    given: Propagation, schedule: core.CoreSchedule, measured: Flags, mean_variance: Floats | None = None
) -> Floats:
    """Of K row by row, U0 and the sizes of further terms (12 + 3 x terms,), by the core; arguments as of `confirmed`.

    Those of the optimal estimator are for weights made at the solved K: the second order, which it takes out, makes up
    for weights made elsewhere.
    """
    part, stand = schedule.part(measured), given.stand.with_step(given.step)
    if given.estimator == NORM:  # which nothing that turns a pose moves
        stand = replace(stand, seat=0.0)
    elif given.estimator != OPTIMAL and not given.terms:
        run = part, given.k, stand, given.samples, given.estimator
        weights = given.weights if given.estimator == INCLINED else None
        u_k, u_u0 = uncertainties(*run, mean_variance=mean_variance, weights=weights)
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


def coverage(noise: Noise, measured: Flags, given: Propagation, by_intrinsic: Floats) -> Coverage:
    """Of the uncertainties of an estimate as `given`, of a run with this `noise` at its `measured` positions.
    `by_intrinsic` (9, 12): derivatives of the intrinsic parameters by the twelve."""
    variance, by_samples = noise.mean_variance[measured], noise.by_samples[measured]
    by_samples = np.where(by_samples >= given.stand.mean_variance(given.samples), by_samples, 0.0)
    if noise.measured is None or not by_samples.any():
        return Coverage(np.full(12, math.inf))
    gradients = np.concatenate([np.eye(12), by_intrinsic])
    whole, parts = variances(gradients, given.covariance(variance)[:12, :12]), np.zeros((3, len(gradients)))
    for channel in np.flatnonzero(by_samples.any(axis=0)):
        once_more = variance.copy()  # a variance is linear in those of the means: what the same again adds is its part
        once_more[:, channel] += by_samples[:, channel]
        parts[channel] = variances(gradients, given.covariance(once_more)[:12, :12]) - whole
    freedom = effective(whole, parts, noise.measured.freedom)
    return Coverage(freedom[:12], freedom[12:])


def effective(variance: Floats, parts: Floats, freedom: Integers | Floats) -> Floats:
    """Degrees of freedom (n,) of a `variance` (n,), of which `parts` (sources, n) are estimates with `freedom`
    (sources,) each, and the rest is known."""
    below = (np.maximum(parts, 0.0) ** 2 / np.asarray(freedom, dtype=float)[:, None]).sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        found: Floats = np.where(below > 0.0, variance**2 / below, math.inf)
    return found
