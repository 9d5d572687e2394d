"""What follows from coefficients: the specific force that a calibrated block shows (Force), its length and its
uncertainty (worst_norm), intrinsic parameters, gravity check, closure and residuals, by other means than the core's.

The model (tumble.terms) is U = F(a) with

    F_i(a) = U0_i + sum_j K_ij a_j + K_ii (K2_i a_i^2 + K3_i a_i^3 + s_i |a_i| + sum_j C_ij a_i a_j)

Without further terms a = K^-1 (U - U0). With them it is found from there by Newton's method, a - J^-1 (F(a) - U) with
J = dF/da; what is exported to C and MATLAB (report/exports) does the same, PASSES times. Coefficients that are off by
dc show a force that is off by da = -J^-1 (dF/dc) dc to first order; so the covariance of the
coefficients gives that of the force, and of its length by the direction of a.

A covariance of coefficients is (12, 12), K row by row, then U0, as model.propagation gives it. A block at the attitude
n, a unit vector, puts out U = U0 + K n. Calibrated with coefficients that are off by dK and dU0 it shows

    a = (K + dK)^-1 (U - U0 - dU0) = n - K^-1 (dK n + dU0)

to first order, and the length of that is 1 - w (dK n + dU0) with w = n K^-1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.documents.result import WorstNorm
from tumble.model.estimators import time_of_run
from tumble.model.further import felt, slope
from tumble.model.geometry import ideal_force
from tumble.schedule import Schedule
from tumble.terms import DRIFT, POWERS, Terms, model_of, name

PASSES = 12  # for whoever does not look whether it moves: each doubles the digits, once the root is near
_STEPS = 50
_CLOSE = 1e-13  # of the largest component, or of one unit
_AT_ONCE = 1 << 15  # samples: what an uncertainty needs for one is 100 numbers
_LEAST_OWN = 0.1  # of the length of a row of K


class NotSolvable(Exception):
    """Of outputs from which no coefficients, or with further terms no specific force, can be found; says why."""


class NoForce(NotSolvable):
    """Further `terms` are so large that outputs do not tell the force. `rows`: indices of such samples."""

    def __init__(self, rows: Flags, terms: Terms):
        self.rows = np.flatnonzero(rows)
        super().__init__(f"{_either(terms)} is so large that the outputs do not tell the acceleration")


def _either(terms: Terms) -> str:
    return " or ".join(map(name, model_of(terms)))


class Force:
    """Outputs to specific force, in the unit of the coefficients, g or m/s^2: `values` in the order of COEFFICIENTS,
    then those of `terms`, of POWERS; `covariance` of these, None where it is not known."""

    def __init__(self, values: Floats, terms: Terms = (), covariance: Floats | None = None):
        self._covariance = covariance
        self._k, self._u0 = values[:9].reshape(3, 3), values[9:12]
        self._inverse = np.linalg.inv(self._k)
        self._further = dict(zip(terms, values[12:].reshape(-1, 3)))

    def of(self, outputs: Floats) -> Floats:
        """The force (samples, 3) of `outputs` (samples, 3), in the unit of the result; NaN where an output is. Raises
        NoForce."""
        left = outputs - self._u0
        force: Floats = left @ self._inverse.T
        if not self._further:
            return force
        # from a force without the further terms, whose roots are taken that are nearest to it
        sign = np.sign(np.linalg.det(self._k))
        known: Flags = np.isfinite(left.sum(axis=1))
        found = np.where(known[:, None], force, 0.0)
        target = np.where(known[:, None], left, 0.0)
        with np.errstate(all="ignore"):  # what does not converge is told of below
            for _ in range(_STEPS):
                steep = self._slope(found)
                singular = np.linalg.det(steep) * sign <= 0.0
                steep[singular] = self._k
                shown = found @ self._k.T
                for term, size in self._further.items():
                    shown += np.diag(self._k) * size * felt(term, found)
                step = np.linalg.solve(steep, (shown - target)[..., None])[..., 0]
                found = found - step
                moved = np.abs(step).max(axis=1)
                open_ones = ~(moved <= _CLOSE * np.maximum(1.0, np.abs(found).max(axis=1))) | singular
                if not open_ones.any():
                    break
        if open_ones.any():
            raise NoForce(open_ones, tuple(self._further))
        return np.where(known[:, None], found, np.nan)

    def _slope(self, force: Floats) -> Floats:
        """J (samples, 3, 3)."""
        found: Floats = np.repeat(self._k[None], len(force), axis=0)
        for term, size in self._further.items():
            found += (np.diag(self._k) * size)[:, None] * slope(term, force)
        return found

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
        by_coefficient = np.zeros((len(force), 3, 12 + 3 * len(self._further)))  # dF/dc
        by_coefficient[:, :, :12] = outputs_by_coefficient(force)
        for i in range(3):
            for place, (term, size) in enumerate(self._further.items()):
                shown = felt(term, force)[:, i]
                by_coefficient[:, i, 4 * i] += size[i] * shown
                by_coefficient[:, i, 12 + 3 * place + i] = self._k[i, i] * shown
        gradient = with_length(to_force, force) @ by_coefficient
        variance = ((gradient @ self._covariance) * gradient).sum(axis=2)
        found: Floats = np.sqrt(np.maximum(variance, 0.0))
        return found


def outputs_by_coefficient(force: Floats) -> Floats:
    """How outputs at a `force` (samples, 3) change with K row by row and U0: (samples, 3, 12)."""
    found = np.zeros((len(force), 3, 12))
    for i in range(3):
        found[:, i, 3 * i : 3 * i + 3] = force
        found[:, i, 9 + i] = 1.0
    return found


def with_length(to_force: Floats, force: Floats) -> Floats:
    """Rows (samples, 4, 3): `to_force` (samples, 3, 3), from outputs to components, and the same for the length."""
    with np.errstate(invalid="ignore"):
        direction = force / np.linalg.norm(force, axis=1)[:, None]
    return np.concatenate([to_force, direction[:, None] @ to_force], axis=1)


def linear_outputs(means: Floats, k: Floats, u0: Floats, sizes: Floats, terms: Terms) -> Floats:
    """What the outputs (positions, 3), of all positions of a run, are without the further terms: U0 + K a, at the
    specific force that they show. `sizes` (terms, 3) in the unit of the outputs. Raises NotSolvable."""
    size, powers = dict(zip(terms, sizes)), tuple(term for term in terms if term in POWERS)
    still: Floats = means - time_of_run(len(means)) * size.get(DRIFT, np.zeros(3))
    if not powers:
        return still
    if (np.abs(np.diag(k)) < _LEAST_OWN * np.linalg.norm(k, axis=1)).any():
        of = " and ".join(map(name, model_of(powers))) + (" are" if len(powers) > 1 else " is")
        raise NotSolvable(f"a channel does not measure along its own axis, of which {of}: channels exchanged?")
    further = [size[term] / np.diag(k) for term in powers]
    if (sum(POWERS[term] * np.abs(one) for term, one in zip(powers, further)) >= 1.0).any():  # they turn within 1 g
        raise NotSolvable(f"{_either(powers)} comes out so large that the outputs do not tell the acceleration")
    force = Force(np.concatenate([k.ravel(), u0, *further]), powers).of(still)
    linear: Floats = u0 + force @ k.T
    return linear


PAIRS = ((0, 1), (0, 2), (1, 2))
_START = 5000  # attitudes: a polynomial of degree four is then within 1 % of its maximum at one of them
_BEST = 100  # of these are refined
_ROUNDS = 80
_FIRST_STEP = 0.05
_LAST_STEP = 1e-9


@dataclass(frozen=True)
class IntrinsicUncertainties:
    """Standard uncertainties of what core.Intrinsic has: `scale` (3,), `angles` (3,) xy, xz, yz in rad, `bias` (3,)
    in g."""

    scale: Floats
    angles: Floats
    bias: Floats


def norm_uncertainty(k: Floats, covariance: Floats, attitudes: Floats, terms: Terms = ()) -> Floats:
    """Standard uncertainty (...), g, of the length of the specific force that the calibrated block shows at `attitudes`
    (..., 3), unit vectors. `terms`: further ones whose sizes the covariance has behind U0; a drift was the run's and is
    over."""
    gradient = norm_gradient(k, attitudes, terms)
    found: Floats = np.sqrt(np.maximum(((gradient @ covariance) * gradient).sum(axis=-1), 0.0))
    return found


def norm_gradient(k: Floats, attitudes: Floats, terms: Terms = ()) -> Floats:
    """Of how much that length falls short of the true one, by errors of K row by row, U0 and the sizes of further
    `terms`: (..., 12 + 3 x terms)."""
    n = np.asarray(attitudes, dtype=float)
    w = n @ np.linalg.inv(k)
    further = [w * felt(term, n) if term in POWERS else np.zeros(n.shape) for term in terms]
    by_k = np.einsum("...i,...j->...ij", w, n).reshape(*n.shape[:-1], 9)
    return np.concatenate([by_k, w, *further], axis=-1)


def worst_norm(k: Floats, covariance: Floats, terms: Terms = ()) -> WorstNorm:
    """The attitude at which the length of the shown specific force is least certain, and its standard uncertainty
    there, g; `terms` as of norm_uncertainty.

    The square of that uncertainty is a polynomial of degree four in the attitude (with K3: eight). It is computed at
    many, and climbed from the best of them, around each in eight directions, with steps that are halved where none
    leads up.
    """
    heights, start = partial(norm_uncertainty, k, covariance, terms=terms), spread_attitudes(_START)
    best = start[np.argsort(heights(start))[-_BEST:]]
    best, height = climbed(heights, best, heights(best), _ROUNDS)
    top = int(height.argmax())
    return WorstNorm(float(height[top]), best[top])


def climbed(heights: Callable[[Floats], Floats], best: Floats, height: Floats, rounds: int) -> tuple[Floats, Floats]:
    """Attitudes (n, 3) and heights (n,) at most so many steps further up from `best`, which have `height`. `heights`:
    of attitudes (n, 8, 3) around each, (n, 8)."""
    step, turn = np.full(len(best), _FIRST_STEP), np.arange(8) * np.pi / 4.0
    for _ in range(rounds):
        first = np.cross(best, np.eye(3)[np.abs(best).argmin(axis=1)])
        first /= np.linalg.norm(first, axis=1)[:, None]
        ways = np.cos(turn)[:, None] * first[:, None] + np.sin(turn)[:, None] * np.cross(best, first)[:, None]
        around = best[:, None] + step[:, None, None] * ways
        around = around / np.linalg.norm(around, axis=2)[..., None]
        found = heights(around)
        upward = found.argmax(axis=1)
        highest = np.take_along_axis(found, upward[:, None], axis=1)[:, 0]
        leads_up = highest > height
        best = np.where(leads_up[:, None], around[np.arange(len(best)), upward], best)
        height, step = np.where(leads_up, highest, height), np.where(leads_up, step, step / 2.0)
        if step.max() < _LAST_STEP:
            break
    return best, height


def intrinsic_uncertainties(k: Floats, u0: Floats, covariance: Floats) -> IntrinsicUncertainties:
    """Of the lengths of K's rows, the angles between them, and the biases over these lengths."""
    spread = np.sqrt(np.maximum(variances(by_intrinsic(k, u0), covariance), 0.0))
    return IntrinsicUncertainties(*spread.reshape(3, 3))


def by_intrinsic(k: Floats, u0: Floats) -> Floats:
    """Derivatives (9, 12) of these lengths, angles and biases by the coefficients."""
    length = np.linalg.norm(k, axis=1)
    axis = k / length[:, None]
    by_scale, by_angle, by_bias = np.zeros((3, 3, 12))
    for i in range(3):
        by_scale[i, 3 * i : 3 * i + 3] = axis[i]
        by_bias[i, 3 * i : 3 * i + 3] = -u0[i] / length[i] ** 3 * k[i]
        by_bias[i, 9 + i] = 1.0 / length[i]
    for place, (i, j) in enumerate(PAIRS):
        cosine = axis[i] @ axis[j]
        sine = np.linalg.norm(np.cross(axis[i], axis[j]))
        for one, other in ((i, j), (j, i)):
            by_angle[place, 3 * one : 3 * one + 3] = (cosine * axis[one] - axis[other]) / (sine * length[one])
    return np.concatenate([by_scale, by_angle, by_bias])


def variances(gradients: Floats, covariance: Floats) -> Floats:
    """Variances (n,) of what has these gradients (n, 12)."""
    found: Floats = ((gradients @ covariance) * gradients).sum(axis=1)
    return found


def spread_attitudes(count: int) -> Floats:
    """Unit vectors (count, 3) all over the sphere, on a spiral of the golden angle."""
    index = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * index / count, np.pi * (3.0 - np.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


_SAME_ATTITUDE = 1e-12


def gravity_errors(means: Floats, k: Floats, u0: Floats) -> Floats:
    """Formula (8) in g at every position: (|a|^2 - 1)/2 with K a = U - U0 solved. means (positions, 3)."""
    force = np.linalg.solve(k, (means - u0).T)
    errors: Floats = ((force**2).sum(axis=0) - 1.0) / 2.0
    return errors


def intrinsic(k: Floats, u0: Floats) -> tuple[Floats, Floats, Floats]:
    """Lengths of the rows of K (3,), angles between the rows xy, xz, yz in radians (3,), biases over lengths (3,)."""
    scale = np.linalg.norm(k, axis=1)
    angles = [np.arctan2(np.linalg.norm(np.cross(k[i], k[j])), k[i] @ k[j]) for i, j in PAIRS]
    return scale, np.array(angles), u0 / scale


def closure(schedule: Schedule, means: Floats, mounting: int) -> Floats | None:
    """Output at the last position of a mounting whose attitude came before, less the first such one's; None if none."""
    own = [index for index, position in enumerate(schedule.positions) if position.mounting == mounting]
    force = ideal_force(schedule)
    for late in reversed(own):
        for early in own:
            if early < late and np.abs(force[late] - force[early]).max() < _SAME_ATTITUDE:
                difference: Floats = means[late] - means[early]
                return difference
    return None


def residual_rms(schedule: Schedule, means: Floats, k: Floats, u0: Floats, unknowns: int = 4) -> Floats | None:
    """Root mean square of U - U0 - K a over the fit positions, less the `unknowns` of a channel: (3,); None where there
    are no more positions than that."""
    fit = schedule.fit_indices
    if len(fit) <= unknowns:
        return None
    residuals = (means - ideal_force(schedule) @ k.T - u0)[fit]
    rms: Floats = np.sqrt((residuals**2).sum(axis=0) / (len(fit) - unknowns))
    return rms
