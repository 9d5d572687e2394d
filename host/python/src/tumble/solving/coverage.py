"""How well standard uncertainties are known themselves, and by what factor they are to be multiplied for 95 %.

What a stand file declares is taken as known: of infinitely many degrees of freedom. What the samples of the run say of
their noise comes from a finite number of blocks, one pooled estimate a channel. After Welch and Satterthwaite

    freedom = u^4 / sum over channels (u_measured^4 / freedom of the channel)

with u_measured the part of u that comes from the measured noise of that channel; the factor is Student's t.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.distributions import student_quantile
from tumble.model.norm import variances
from tumble.solving.noise import Noise
from tumble.stand import Stand

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
