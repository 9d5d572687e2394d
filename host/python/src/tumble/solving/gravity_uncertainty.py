"""How well the gravity check knows its errors: delta_g = (|a|^2 - 1)/2 at a position, with a = K^-1 (U - U0).

The coefficients are those found, and the length of gravity is 1 g at every attitude, so that no error of the stand is
in delta_g: the noise of the position's mean alone makes it uncertain, d delta_g = a K^-1 dU.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.distributions import student_quantile
from tumble.solving import noise as noise_of_runs
from tumble.solving.coverage import PROBABILITY, effective
from tumble.solving.solution import Solution


@dataclass(frozen=True)
class GravityUncertainty:
    """At every position of the schedule, NaN where it was not measured: standard uncertainty `u_g` of delta_g, and its
    coverage `factor` for PROBABILITY."""

    u_g: Floats
    factor: Floats


def gravity_uncertainty(solution: Solution) -> GravityUncertainty | None:
    """By the declared noise or the measured one, whichever counts in the other uncertainties; None where neither is
    known."""
    noise, run = solution.noise, solution.run
    if solution.stand is None and not noise.is_known:
        return None
    stand = noise_of_runs.NO_STAND if solution.stand is None else solution.declared.with_step(solution.step)
    declared = np.broadcast_to(stand.mean_variance(run.samples), noise.mean_variance.shape)
    inverse = np.linalg.inv(solution.found.k)
    force = (run.means - solution.found.u0) @ inverse.T
    weights = (force @ inverse) ** 2
    variance = (weights * np.maximum(declared, noise.mean_variance)).sum(axis=1)
    if noise.measured is None:
        freedom = np.full(len(variance), np.inf)
    else:
        measured = np.where(noise.by_samples >= declared, noise.by_samples, 0.0)
        freedom = effective(variance, (weights * measured).T, noise.measured.freedom)
    factor = np.array([student_quantile(PROBABILITY, one) for one in freedom.tolist()])
    return GravityUncertainty(np.sqrt(variance), factor)
