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
from tumble.reference.estimators import fit_indices, least_squares
from tumble.reference.extended import fitted_columns
from tumble.reference.geometry import Geometry
from tumble.reference.patterns import Columns, Scene
from tumble.reference.uncertainty import course, encoder_waves, sources
from tumble.schedule import Schedule
from tumble.stand import Stand
from tumble.terms import Terms

PASSES = 4
_STEP = 1e-30
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
        self.terms, self._further = terms, fitted_columns(schedule, terms)
        self._sizes = np.zeros(3 * len(terms))
        fit = fit_indices(schedule)
        self.schedule = Schedule(schedule.mountings, tuple(schedule.positions[index] for index in fit))
        self._geometry = Geometry(self.schedule)
        self._outputs = means[fit]
        self.k, self._u0 = least_squares(self.schedule, self._outputs)
        by_channel = np.broadcast_to(variance.reshape(len(means), -1), means.shape)[fit]
        self._noise = np.maximum(np.sqrt(by_channel), _FLOOR_G * np.abs(self.k).max())
        errors = sources(self.schedule, self.k, stand, np.ones(len(fit), dtype=int))
        self._names = [name for name in errors if name != "noise"]
        angles = [errors[name].sigma for name in self._names]
        self._sigma = np.concatenate(angles)
        self._ends = np.cumsum([len(sigma) for sigma in angles])[:-1]
        drifts = np.repeat([name == "drift" for name in self._names], [len(sigma) for sigma in angles])
        self._largest = np.where(drifts, np.inf, _LARGEST_RAD)
        self._waves, self._course = encoder_waves(self.schedule), course(self.schedule)[:, None]
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
        force = self._force(self._x)
        design = np.hstack([np.kron(np.column_stack([force, np.ones(len(force))]), np.eye(3)), self._further])
        noise = self._noise.reshape(-1, 1)
        by_error = self._derivatives() * self._sigma / noise
        system = np.block(
            [[design / noise, by_error], [np.zeros((len(self._x), design.shape[1])), np.eye(len(self._x))]]
        )
        sigma = np.where(self._sigma > 0.0, self._sigma, 1.0)
        linear = self._u0 + self._drift(self._x)
        shown = (self._outputs - force @ self.k.T - linear).reshape(-1) - self._further @ self._sizes
        left = shown / noise[:, 0]
        right = np.concatenate([left, -self._x / sigma])
        length = np.sqrt((system**2).sum(axis=0))
        q, r = np.linalg.qr(system / length, mode="complete")
        unknowns = system.shape[1]
        change = np.linalg.solve(r[:unknowns], q[:, :unknowns].T @ right) / length
        self._coefficients, self._left = q[: len(left), :12], q[: len(left), unknowns:]
        self.rest = q[:, unknowns:].T @ right
        self.k = self.k + change[:9].reshape(3, 3).T
        self._u0 = self._u0 + change[9:12]
        self._sizes = self._sizes + change[12 : design.shape[1]]
        self._x = np.clip(self._x + change[design.shape[1] :] * self._sigma, -self._largest, self._largest)

    def _by_name(self, errors: Floats) -> dict[str, Floats]:
        return dict(zip(self._names, np.split(errors, self._ends, axis=-1)))

    def _drift(self, errors: Floats) -> Floats:
        """What drifts add to the outputs (..., positions, 3), of which they are linear."""
        drifts: Floats = self._course * self._by_name(errors).get("drift", np.zeros(3))[..., None, :]
        return drifts

    def _force(self, errors: Floats) -> Floats:
        """Specific force on the exact geometry, for errors (..., errors) in rad, real or complex."""
        of = self._by_name(errors)
        seat_h, seat_n = np.split(of.get("seat", np.zeros(2)), 2, axis=-1)
        return self._geometry.force(
            alpha1=of["alpha1"],
            alpha2=of["alpha2"],
            alpha3=of["alpha3"],
            delta=of["alpha4"] + of.get("encoder", np.zeros(4)) @ self._waves,
            seat_h=seat_h + of.get("platform", np.zeros(1)),
            seat_n=seat_n,
        )

    def _derivatives(self) -> Floats:
        """Of all outputs by every error: (3 x positions, errors)."""
        each = np.eye(len(self._x))
        steps = self._x + 1j * _STEP * each
        by_error = np.imag(self._force(steps)) / _STEP @ self.k.T + self._drift(each)
        derivatives: Floats = by_error.reshape(len(steps), -1).T
        return derivatives

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
