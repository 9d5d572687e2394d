"""Several runs of one block as one result: a weighted mean of the coefficients.

A run's covariance has two parts. What is drawn anew in every run (noise, set angles, the yaw of every re-mounting, and
unless the stand was levelled once for all, its levelling) averages out; what all runs share stays as it is:

    cov of the mean = (sum of (own covariances)^-1)^-1 + shared covariance

Weights by the own covariances are the best there are: the shared part moves all runs alike.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tumble import reference
from tumble.distributions import chi_squared_quantile
from tumble.reference.estimators import fit_indices
from tumble.reference.uncertainty import sources
from tumble.schedule import Schedule
from tumble.solving import optimal_run
from tumble.solving.gains import optimal_table
from tumble.solving.solution import Solution
from tumble.stand import OPTIMAL, volts_per

_LEVELLING = ("alpha1", "alpha2")
_NEGLIGIBLE = 1e-12
_ROUNDING = 1e-13  # of the largest output, in a coefficient


@dataclass(frozen=True)
class Combination:
    """`k` (3, 3), `u0` (3,) and their standard uncertainties. `chi_squared` of what the runs differ by, with
    `freedom`, and the `limit` of it at the confidence asked for."""

    k: np.ndarray
    u0: np.ndarray
    u_k: np.ndarray
    u_u0: np.ndarray
    chi_squared: float
    freedom: int
    limit: float

    @property
    def consistent(self) -> bool:
        """Whether the runs differ by no more than the declared stand lets them."""
        return self.chi_squared <= self.limit


def combine(solutions: list[Solution], levelled_once: bool, confidence: float, step_v: float = 0.0) -> Combination:
    """Combine runs of one block on one declared stand. All in one unit, by one estimator; at least two. `step_v`: of
    the converter, 0: unknown."""
    values = np.array([np.concatenate([s.found.k.ravel(), s.found.u0]) for s in solutions])
    parts = [covariances(solution, levelled_once, step_v) for solution in solutions]
    # of a stand without any error nothing else would be left to compare runs by
    rounded = [(_ROUNDING * float(np.nanmax(np.abs(s.run.means)))) ** 2 * np.eye(12) for s in solutions]
    own = np.array([part[0] for part in parts]) + rounded
    shared = np.mean([part[1] for part in parts], axis=0)
    information = np.array([np.linalg.pinv(covariance, rcond=_NEGLIGIBLE, hermitian=True) for covariance in own])
    total = np.linalg.pinv(information.sum(axis=0), rcond=_NEGLIGIBLE, hermitian=True)
    mean = values.mean(axis=0)
    mean = mean + total @ np.einsum("rij,rj->i", information, values - mean)
    rest = values - mean
    chi_squared = float(np.einsum("ri,rij,rj->", rest, information, rest))
    rank = int(np.linalg.matrix_rank(information.sum(axis=0), hermitian=True, tol=None))
    freedom = rank * (len(solutions) - 1)
    u = np.sqrt(np.diag(total + shared))
    limit = chi_squared_quantile(confidence, freedom)
    return Combination(mean[:9].reshape(3, 3), mean[9:], u[:9].reshape(3, 3), u[9:], chi_squared, freedom, limit)


def covariances(solution: Solution, levelled_once: bool, step_v: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Covariance (12, 12) of a run's coefficients, K row by row, then U0: what is its own, and what all runs share."""
    run, k = solution.run, solution.found.k
    schedule = solution.measured_schedule
    stand = solution.stand.in_unit(run.unit).with_step(step_v / volts_per(run.unit))
    errors = sources(schedule, k, stand, run.samples[run.measured])
    linear = _estimator(solution, schedule, step_v)
    own, shared = np.zeros((2, 12, 12))
    for name, source in errors.items():
        draws = linear(source.derivative) * source.sigma[:, None]
        if levelled_once and name in _LEVELLING:
            shared += draws.T @ draws
        else:
            own += draws.T @ draws
    return own, shared


def _estimator(solution: Solution, schedule: Schedule, step_v: float) -> Callable[[np.ndarray], np.ndarray]:
    """From outputs (draws, positions, 3) to coefficients (draws, 12); of `optimal` the weights for this run."""
    run, estimator = solution.run, solution.found.estimator

    def closed_form(outputs: np.ndarray) -> np.ndarray:
        k, u0 = reference.estimate(schedule, outputs, estimator)
        return np.concatenate([k.reshape(-1, 9), u0], axis=1)

    if estimator != OPTIMAL:
        return closed_form
    step = step_v / volts_per(run.unit)
    weighting = optimal_run.Weighting(solution.stand.in_unit(run.unit), run.samples, step)
    samples = optimal_run.samples_in_a_mean(solution.schedule, run.measured, weighting)
    gains = optimal_table(schedule, solution.found.k, weighting.stand, step, samples).gains
    return lambda outputs: outputs[:, fit_indices(schedule)].reshape(len(outputs), -1) @ gains.T
