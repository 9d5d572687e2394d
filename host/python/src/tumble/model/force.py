"""The specific force that a calibrated block shows, of any number of samples at once, and its standard uncertainty.

The model (tumble.terms) is U = F(a) with

    F_i(a) = U0_i + sum_j K_ij a_j + K_ii (K2_i a_i^2 + K3_i a_i^3)

Without K2 and K3 a = K^-1 (U - U0). With them it is found from there by Newton's method, a - J^-1 (F(a) - U) with
J = dF/da; what is exported to C and MATLAB (cli/exports) does the same, PASSES times. Coefficients that are off by
dc show a force that is off by da = -J^-1 (dF/dc) dc to first order; so the covariance of the
coefficients gives that of the force, and of its length by the direction of a.
"""

from __future__ import annotations

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.model.estimators import time_of_run
from tumble.terms import DRIFT, POWERS, Terms

PASSES = 12  # for whoever does not look whether it moves: each doubles the digits, once the root is near
_STEPS = 50
_CLOSE = 1e-13  # of the largest component, or of one unit
_AT_ONCE = 1 << 15  # samples: what an uncertainty needs for one is 100 numbers


_LEAST_OWN = 0.1  # of the length of a row of K


class NotSolvable(Exception):
    """Of outputs from which further terms do not let a specific force be found; says why."""


class NoForce(NotSolvable):
    """K2 or K3 is so large that outputs do not tell the force. `rows`: indices of such samples."""

    def __init__(self, rows: Flags):
        self.rows = np.flatnonzero(rows)
        super().__init__("K2 or K3 is so large that the outputs do not tell the acceleration")


class Force:
    """Outputs to specific force, in the unit of the coefficients, g or m/s^2: `values` in the order of COEFFICIENTS,
    then those of `terms` (K2, K3); `covariance` of these, None where it is not known."""

    def __init__(self, values: Floats, terms: Terms = (), covariance: Floats | None = None):
        self._covariance = covariance
        self._k, self._u0 = values[:9].reshape(3, 3), values[9:12]
        self._inverse = np.linalg.inv(self._k)
        self._further = [(POWERS[term], size) for term, size in zip(terms, values[12:].reshape(-1, 3))]

    def of(self, outputs: Floats) -> Floats:
        """The force (samples, 3) of `outputs` (samples, 3), in the unit of the result; NaN where an output is. Raises
        NoForce."""
        left = outputs - self._u0
        force: Floats = left @ self._inverse.T
        return self._refined(left, force) if self._further else force

    def _refined(self, left: Floats, force: Floats) -> Floats:
        """From a force without the further terms, whose roots are taken that are nearest to it."""
        sign = np.sign(np.linalg.det(self._k))
        known: Flags = np.isfinite(left.sum(axis=1))
        found = np.where(known[:, None], force, 0.0)
        target = np.where(known[:, None], left, 0.0)
        with np.errstate(all="ignore"):  # what does not converge is told of below
            for _ in range(_STEPS):
                slope = self._slope(found)
                singular = np.linalg.det(slope) * sign <= 0.0
                slope[singular] = self._k
                step = np.linalg.solve(slope, (self._outputs(found) - target)[..., None])[..., 0]
                found = found - step
                moved = np.abs(step).max(axis=1)
                open_ones = ~(moved <= _CLOSE * np.maximum(1.0, np.abs(found).max(axis=1))) | singular
                if not open_ones.any():
                    break
        if open_ones.any():
            raise NoForce(open_ones)
        return np.where(known[:, None], found, np.nan)

    def _outputs(self, force: Floats) -> Floats:
        """F(a) - U0 (samples, 3)."""
        outputs: Floats = force @ self._k.T
        for power, size in self._further:
            outputs += np.diag(self._k) * size * force**power
        return outputs

    def _slope(self, force: Floats) -> Floats:
        """J (samples, 3, 3)."""
        slope: Floats = np.repeat(self._k[None], len(force), axis=0)
        for power, size in self._further:
            slope[:, range(3), range(3)] += np.diag(self._k) * power * size * force ** (power - 1)
        return slope

    @property
    def is_certain(self) -> bool:
        """Is the covariance of the coefficients known?"""
        return self._covariance is not None

    def uncertainty(self, force: Floats) -> Floats:
        """Standard uncertainties (samples, 4) of the components of a `force` (samples, 3) and of its length: by those
        of the coefficients; noise of the outputs is not in them. NaN where the force is NaN, and for the length of a
        force of 0."""
        parts = [self._uncertainty(force[start : start + _AT_ONCE]) for start in range(0, len(force), _AT_ONCE)]
        return np.concatenate([np.zeros((0, 4)), *parts])

    def _uncertainty(self, force: Floats) -> Floats:
        assert self._covariance is not None  # as is_certain says
        known: Flags = np.isfinite(force.sum(axis=1))
        to_force = np.linalg.inv(np.where(known[:, None, None], self._slope(force), self._k))
        with np.errstate(invalid="ignore"):
            direction = force / np.linalg.norm(force, axis=1)[:, None]
        rows = np.concatenate([to_force, direction[:, None] @ to_force], axis=1)  # of the outputs, for all four
        gradient = rows @ self._by_coefficients(force)
        variance = ((gradient @ self._covariance) * gradient).sum(axis=2)
        found: Floats = np.sqrt(np.maximum(variance, 0.0))
        return found

    def _by_coefficients(self, force: Floats) -> Floats:
        """dF/dc (samples, 3, coefficients)."""
        found = np.zeros((len(force), 3, 12 + 3 * len(self._further)))
        for i in range(3):
            found[:, i, 3 * i : 3 * i + 3] = force
            found[:, i, 9 + i] = 1.0
            for place, (power, size) in enumerate(self._further):
                found[:, i, 4 * i] += size[i] * force[:, i] ** power
                found[:, i, 12 + 3 * place + i] = self._k[i, i] * force[:, i] ** power
        return found


def linear_outputs(means: Floats, k: Floats, u0: Floats, sizes: Floats, terms: Terms) -> Floats:
    """What the outputs (positions, 3), of all positions of a run, are without the further terms: U0 + K a, at the
    specific force that they show. `sizes` (terms, 3) in the unit of the outputs. Raises NotSolvable."""
    size, powers = dict(zip(terms, sizes)), tuple(term for term in terms if term in POWERS)
    still: Floats = means - time_of_run(len(means)) * size.get(DRIFT, np.zeros(3))
    if not powers:
        return still
    if (np.abs(np.diag(k)) < _LEAST_OWN * np.linalg.norm(k, axis=1)).any():
        raise NotSolvable("a channel does not measure along its own axis, of which K2 and K3 are: channels exchanged?")
    further = [size[term] / np.diag(k) for term in powers]
    if (sum(POWERS[term] * np.abs(one) for term, one in zip(powers, further)) >= 1.0).any():  # they turn within 1 g
        raise NotSolvable("K2 or K3 comes out so large that the outputs do not tell the acceleration")
    force = Force(np.concatenate([k.ravel(), u0, *further]), powers).of(still)
    linear: Floats = u0 + force @ k.T
    return linear
