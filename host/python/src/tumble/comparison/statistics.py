"""Tests of a difference whose covariance is known, also where that has directions without any variance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.distributions import chi_squared_above
from tumble.documents.comparison import Test

_NONE = 1e-12  # variance of a direction, in units of the standard uncertainties: what is left of rounding
_ASYMMETRY = 1e-6  # in the same units: more than a file of fifteen digits leaves, or of fewer
_BEYOND = 1e-5  # of a difference in such a direction, in the same units: more than rounding


def test_of(chi_squared: float, freedom: int) -> Test:
    """How often it is as large by chance: 1 without freedom."""
    return Test(chi_squared, freedom, chi_squared_above(chi_squared, freedom) if freedom else 1.0)


@dataclass(frozen=True)
class Whitened:
    """A difference in coordinates (n,) that are independent, of variance 1: `rows` (n, n) times it. `freedom`: how many
    of them count."""

    rows: Floats
    difference: Floats
    freedom: int

    @property
    def test(self) -> Test:
        """Of the whole difference."""
        return test_of(float(self.difference @ self.difference), self.freedom)


def whitened(covariance: Floats, difference: Floats, rounding: Floats) -> Whitened:
    """Of a difference (n,) with this covariance (n, n); `rounding` (n,): sizes below which it is nothing.

    A direction without variance counts where the difference has more in it than rounding leaves, which no chance
    explains. Else it is no degree of freedom, and the difference is taken to be 0 there.
    """
    size = np.sqrt(np.maximum(np.diag(covariance), 0.0) + rounding**2)
    variance, directions = np.linalg.eigh((covariance + np.diag(rounding**2)) / np.outer(size, size))
    shown = directions.T @ (difference / size)
    counts: Flags = (variance > _NONE) | (np.abs(shown) > _BEYOND)
    scale = np.sqrt(np.maximum(variance, _NONE))
    rows: Floats = (directions / scale).T / size
    return Whitened(rows, np.where(counts, shown / scale, 0.0), int(counts.sum()))


def is_covariance(matrix: Floats) -> bool:
    """Whether a matrix (n, n) is symmetric, and has no direction with less variance than rounding leaves."""
    variance = np.diag(matrix)
    if (variance < 0.0).any() or matrix[variance == 0.0].any():
        return False
    size = np.sqrt(np.where(variance > 0.0, variance, 1.0))
    scaled = matrix / np.outer(size, size)
    return bool(np.abs(scaled - scaled.T).max() < _ASYMMETRY and np.linalg.eigvalsh(scaled).min() > -_ASYMMETRY)


def normal_p(difference: Floats, u: Floats) -> Floats:
    """How often differences (n,) of these standard uncertainties (n,), above 0, are as large by chance."""
    return np.array([chi_squared_above(float(one), 1.0) for one in (difference / u) ** 2])


def holm(p: Sequence[float]) -> list[float]:
    """Each p such that any is below a level, where nothing is there, in no more runs than that level says (Holm 1979):
    times the number of those that are no smaller, and no less than what a smaller one came to."""
    found, worst = [1.0] * len(p), 0.0
    for rank, place in enumerate(sorted(range(len(p)), key=lambda one: p[one])):
        worst = max(worst, min(1.0, (len(p) - rank) * p[place]))
        found[place] = worst
    return found
