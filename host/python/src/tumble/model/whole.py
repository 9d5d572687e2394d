"""Does the whole model fit a run? Generalised least squares on the exact geometry, dense, by orthogonal factors.

Unknown are the coefficients and every error that the stand declares, each with its variance as prior. The smallest sum
of the squares of all that is left, outputs and errors in units of their standard deviations, is r^T C^-1 r: with r the
residuals of the coefficients' fit, and C the covariance that the declared errors give the outputs. It is found by
Newton's way after Gauss, from a least-squares fit on the ideal stand; so it depends on no estimator.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tumble.arrays import Floats
from tumble.model.errors import NOISE, OF_OUTPUTS, Errors, declared, of_stand
from tumble.model.estimators import by_coefficients, design, estimate
from tumble.model.patterns import Columns, Scene
from tumble.schedule import Schedule
from tumble.stand import Stand
from tumble.terms import Terms

PASSES = 4
_FLOOR_G = 1e-7
_LARGEST_RAD = 0.1
_NULL = 1e-7
_INESTIMABLE = 1e-6
_SHOWN = 0.01


@dataclass(frozen=True)
class Score:
    """Of one pattern: `square` is chi-squared with `freedom`; `sizes`, `u` by label (None: not determined)."""

    square: float
    freedom: int
    sizes: dict[str, tuple[float, float]]


class WholeModel:
    """The declared `stand`, in the unit of the `means` (positions, 3) of a schedule, all measured; `variance`
    (positions, 3), or (positions,) for channels that are alike, of each mean by its noise. `terms`: unknown too."""

    def __init__(self, schedule: Schedule, means: Floats, variance: Floats, stand: Stand, terms: Terms = ()):
        self._given = schedule, means, variance, stand
        self.terms, self._further = terms, design(schedule, terms)[:, 12:]
        self._sizes = np.zeros(3 * len(terms))
        self.schedule, self._outputs = schedule.fitted, means[schedule.fit_indices]
        self.k, self._u0 = estimate(self.schedule, self._outputs, "least_squares")
        by_channel = np.broadcast_to(variance.reshape(len(means), -1), means.shape)[schedule.fit_indices]
        self._noise = np.maximum(np.sqrt(by_channel), _FLOOR_G * np.abs(self.k).max())
        names = [name for name in declared(stand) if name != NOISE]
        self._errors = Errors(self.schedule, of_stand(self.schedule, self.k, stand, names))
        self._sigma = self._errors.sigma
        self._largest = np.full(len(self._sigma), _LARGEST_RAD)
        for name in set(OF_OUTPUTS) & set(names):
            self._largest[self._errors.of[name]] = np.inf
        self._x = np.zeros(len(self._sigma))  # rad, or as outputs are
        for _ in range(PASSES):
            self._linearise()

    def with_variance(self, variance: Floats) -> WholeModel:
        """The same run, with other noise."""
        schedule, means, _, stand = self._given
        return WholeModel(schedule, means, variance, stand, self.terms)

    def with_set_angles(self, sigma: float) -> WholeModel:
        """The same run, with another standard deviation of set angles, rad."""
        schedule, means, variance, stand = self._given
        return WholeModel(schedule, means, variance, stand.with_sigma("angle", sigma), self.terms)

    @property
    def chi_squared(self) -> float:
        """The smallest sum of squares."""
        return float(self.rest @ self.rest)

    @property
    def freedom(self) -> int:
        """Its degrees of freedom: every declared error brings a square of its own."""
        return len(self.rest)

    def _linearise(self) -> None:
        """Solve the problem that is linear where the pass before ended. `rest`: what no unknown explains, as
        independent numbers of variance 1; `_left`: the directions of these among outputs and errors; `_coefficients`:
        those of the coefficients."""
        force = self._errors.force(self._x)
        by_unknown = np.hstack([by_coefficients(force), self._further])
        noise = self._noise.reshape(-1, 1)
        derivatives = self._errors.derivative(self.k, self._x).reshape(len(self._x), -1).T
        prior = np.eye(len(self._x), by_unknown.shape[1] + len(self._x), by_unknown.shape[1])
        system = np.vstack([np.hstack([by_unknown / noise, derivatives * self._sigma / noise]), prior])
        sigma = np.where(self._sigma > 0.0, self._sigma, 1.0)
        shown = (self._outputs - self._errors.outputs(self.k, self._u0, self._x)).ravel() - self._further @ self._sizes
        left = shown / noise[:, 0]
        right = np.concatenate([left, -self._x / sigma])
        length = np.sqrt((system**2).sum(axis=0))
        q, r = np.linalg.qr(system / length, mode="complete")
        unknowns = system.shape[1]
        change = np.linalg.solve(r[:unknowns], q[:, :unknowns].T @ right) / length
        self._coefficients, self._left = q[: len(left), :12], q[: len(left), unknowns:]
        self.rest = q[:, unknowns:].T @ right
        self.k = self.k + change[:9].reshape(3, 3)
        self._u0 = self._u0 + change[9:12]
        self._sizes = self._sizes + change[12 : by_unknown.shape[1]]
        self._x = np.clip(self._x + change[by_unknown.shape[1] :] * self._sigma, -self._largest, self._largest)

    @cached_property
    def scene(self) -> Scene:
        """What patterns are made from."""
        return Scene(self.schedule, self.k)

    def whitened(self, columns: Columns) -> Floats:
        """What the residuals show of a pattern: (freedom, columns), where they are independent and of variance 1. A
        column that the unknowns take up is 0. So is one of which the coefficients leave less than a hundredth: it shows
        only by the errors of the stand, as cubes do on the diagonals; or only by rounding, as a yaw does where gravity
        lies along its axis."""
        outputs = np.array([(column / self._noise).ravel() for column in columns.values()]).T
        shown, length = self._left.T @ outputs, np.linalg.norm(outputs, axis=0)
        beside = outputs - self._coefficients @ (self._coefficients.T @ outputs)
        seen = np.linalg.norm(shown, axis=0) > _NULL * length
        seen &= np.linalg.norm(beside, axis=0) > _SHOWN * length
        seen &= length > _NULL * length.max(initial=0.0)
        return np.where(seen, shown, 0.0)

    def beside(self, besides: Columns) -> tuple[Floats, Floats]:
        """The space of other patterns that are there `besides`, (freedom, their rank), and what remains of `rest`."""
        known = basis(self.whitened(besides)) if besides else np.zeros((len(self.rest), 0))
        return known, self.rest - known @ (known.T @ self.rest)

    def score(self, columns: Columns, beside: tuple[Floats, Floats]) -> Score:
        """The score test of a pattern, given others, as `beside` has them."""
        (known, rest), shown = beside, self.whitened(columns)
        if known.shape[1] > 0:
            length = np.linalg.norm(shown, axis=0)
            shown = shown - known @ (known.T @ shown)
            shown = np.where(np.linalg.norm(shown, axis=0) > _NULL * length, shown, 0.0)
        own = basis(shown)
        part = own.T @ rest
        return Score(float(part @ part), own.shape[1], _sizes(list(columns), shown, rest))


def basis(columns: Floats) -> Floats:
    """Orthonormal, of the space that columns span, each taken at its own length."""
    length = np.linalg.norm(columns, axis=0)
    used = columns[:, length > 0.0] / length[length > 0.0]
    left, singular, _ = np.linalg.svd(used, full_matrices=False)
    space: Floats = left[:, singular > _NULL]
    return space


def _sizes(names: list[str], shown: Floats, rest: Floats) -> dict[str, tuple[float, float]]:
    """Estimate and standard uncertainty of every column's size, where the others leave it to be told."""
    length = np.linalg.norm(shown, axis=0)
    seen = np.flatnonzero(length)
    if len(seen) == 0:
        return {}
    left, singular, directions = np.linalg.svd(shown[:, seen] / length[seen], full_matrices=True)
    rank = int((singular > _NULL).sum())
    inverse = (directions[:rank].T / singular[:rank]) @ left[:, :rank].T
    found = {}
    for row, place in enumerate(seen):
        if np.abs(directions[rank:, row]).max(initial=0.0) < _INESTIMABLE:
            gains = inverse[row] / length[place]
            found[names[place]] = float(gains @ rest), float(np.linalg.norm(gains))
    return found
