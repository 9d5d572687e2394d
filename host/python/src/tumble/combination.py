"""Several runs of one block as one result: a weighted mean of the coefficients.

A run's covariance has two parts. What is drawn anew in every run (noise, set angles, the yaw of every re-mounting, and
unless the stand was levelled once for all, its levelling) averages out; what all runs share stays as it is:

    cov of the mean = (sum of (own covariances)^-1)^-1 + shared covariance

Weights by the own covariances are the best there are: the shared part moves all runs alike.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import reference
from tumble.distributions import chi_squared_quantile
from tumble.reference.uncertainty import sources
from tumble.schedule import Schedule
from tumble.solution import Solution, measured_part
from tumble.standseen import averaged_over

_LEVELLING = ("alpha1", "alpha2")
_NEGLIGIBLE = 1e-12


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


def combine(solutions: list[Solution], levelled_once: bool, confidence: float) -> Combination:
    """Combine runs of one block on one declared stand. All in one unit, by one linear estimator; at least two."""
    values = np.array([np.concatenate([s.found.k.ravel(), s.found.u0]) for s in solutions])
    parts = [covariances(solution, levelled_once) for solution in solutions]
    own, shared = np.array([part[0] for part in parts]), np.mean([part[1] for part in parts], axis=0)
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


def covariances(solution: Solution, levelled_once: bool) -> tuple[np.ndarray, np.ndarray]:
    """Covariance (12, 12) of a run's coefficients, K row by row, then U0: what is its own, and what all runs share."""
    run, k = solution.run, solution.found.k
    schedule = measured_part(solution.schedule, run.measured)
    stand = solution.stand.in_unit(run.unit)
    errors = sources(schedule, k, stand, run.samples[run.measured])
    own, shared = np.zeros((2, 12, 12))
    for name, source in errors.items():
        draws = _coefficients(schedule, source.derivative, solution.found.estimator) * source.sigma[:, None]
        if levelled_once and name in _LEVELLING:
            shared += draws.T @ draws
        else:
            own += draws.T @ draws
    return own, shared


def _coefficients(schedule: Schedule, outputs: np.ndarray, estimator: str) -> np.ndarray:
    k, u0 = reference.estimate(schedule, outputs, estimator)
    return np.concatenate([k.reshape(-1, 9), u0], axis=1)
