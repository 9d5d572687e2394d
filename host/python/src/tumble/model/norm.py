"""What the covariance of the coefficients says of whatever is computed from them: of the specific force that the
calibrated block shows, of its length, of the intrinsic parameters.

A covariance is (12, 12), K row by row, then U0, as model.propagation gives it. A block at the attitude n, a unit
vector, puts out U = U0 + K n. Calibrated with coefficients that are off by dK and dU0 it shows

    a = (K + dK)^-1 (U - U0 - dU0) = n - K^-1 (dK n + dU0)

to first order, and the length of that is 1 - w (dK n + dU0) with w = n K^-1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.terms import POWERS, Terms

PAIRS = ((0, 1), (0, 2), (1, 2))
_START = 5000  # attitudes: a polynomial of degree four is then within 1 % of its maximum at one of them
_BEST = 100  # of these are refined
_ROUNDS = 80
_FIRST_STEP = 0.05
_LAST_STEP = 1e-9


@dataclass(frozen=True)
class WorstNorm:
    """The largest standard uncertainty of |a|, in g, and the `attitude` (3,) where it is."""

    worst: float
    attitude: Floats


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
    further = [w * n ** POWERS[term] if term in POWERS else np.zeros(n.shape) for term in terms]
    by_k = np.einsum("...i,...j->...ij", w, n).reshape(*n.shape[:-1], 9)
    return np.concatenate([by_k, w, *further], axis=-1)


def worst_norm(k: Floats, covariance: Floats, terms: Terms = ()) -> WorstNorm:
    """The attitude at which the length of the shown specific force is least certain; `terms` as of norm_uncertainty.

    The square of that uncertainty is a polynomial of degree four in the attitude (with K3: eight). It is computed at
    many, and climbed from the best of them, around each in eight directions, with steps that are halved where none
    leads up.
    """

    def heights(attitudes: Floats) -> Floats:
        return norm_uncertainty(k, covariance, attitudes, terms)

    start = spread_attitudes(_START)
    best = start[np.argsort(heights(start))[-_BEST:]]
    best, height = climbed(heights, best, heights(best), _ROUNDS)
    top = int(height.argmax())
    return WorstNorm(float(height[top]), best[top])


def climbed(heights: Callable[[Floats], Floats], best: Floats, height: Floats, rounds: int) -> tuple[Floats, Floats]:
    """Attitudes (n, 3) and heights (n,) at most so many steps further up from `best`, which have `height`. `heights`:
    of attitudes (n, 8, 3) around each, (n, 8)."""
    step = np.full(len(best), _FIRST_STEP)
    for _ in range(rounds):
        around = _around(best, step)
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
    return IntrinsicUncertainties(*_spread(by_intrinsic(k, u0), covariance).reshape(3, 3))


def by_intrinsic(k: Floats, u0: Floats) -> Floats:
    """Derivatives (9, 12) of these lengths, angles and biases by the coefficients."""
    length = np.linalg.norm(k, axis=1)
    axis = k / length[:, None]
    by_scale, by_angle = np.zeros((2, 3, 12))
    for i in range(3):
        by_scale[i, 3 * i : 3 * i + 3] = axis[i]
    for place, (i, j) in enumerate(PAIRS):
        cosine = axis[i] @ axis[j]
        sine = np.linalg.norm(np.cross(axis[i], axis[j]))
        for one, other in ((i, j), (j, i)):
            by_angle[place, 3 * one : 3 * one + 3] = (cosine * axis[one] - axis[other]) / (sine * length[one])
    return np.concatenate([by_scale, by_angle, by_bias(k, u0)])


def named(nine: Sequence[Any]) -> dict[str, Any]:
    """What there is of each intrinsic parameter, by the names that these have in a result."""
    return {"scale": nine[:3], "angle_rad": dict(zip(("xy", "xz", "yz"), nine[3:6])), "bias_g": nine[6:]}


def by_bias(k: Floats, u0: Floats) -> Floats:
    """Derivatives (3, 12) of U0_i over the length of row i by the coefficients."""
    length, found = np.linalg.norm(k, axis=1), np.zeros((3, 12))
    for i in range(3):
        found[i, 3 * i : 3 * i + 3] = -u0[i] / length[i] ** 3 * k[i]
        found[i, 9 + i] = 1.0 / length[i]
    return found


def _spread(gradients: Floats, covariance: Floats) -> Floats:
    """Standard uncertainties (n,) of what has these gradients (n, 12)."""
    spread: Floats = np.sqrt(np.maximum(variances(gradients, covariance), 0.0))
    return spread


def variances(gradients: Floats, covariance: Floats) -> Floats:
    """Variances (n,) of the same."""
    found: Floats = ((gradients @ covariance) * gradients).sum(axis=1)
    return found


def spread_attitudes(count: int) -> Floats:
    """Unit vectors (count, 3) all over the sphere, on a spiral of the golden angle."""
    index = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * index / count, np.pi * (3.0 - np.sqrt(5.0)) * index
    radius = np.sqrt(1.0 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


def _around(attitudes: Floats, step: Floats) -> Floats:
    """Eight neighbours of each (n, 8, 3), `step` (n,) away."""
    least = np.eye(3)[np.abs(attitudes).argmin(axis=1)]
    first = np.cross(attitudes, least)
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(attitudes, first)
    turn = np.arange(8) * np.pi / 4.0
    ways = np.cos(turn)[:, None] * first[:, None] + np.sin(turn)[:, None] * second[:, None]
    found = attitudes[:, None] + step[:, None, None] * ways
    moved: Floats = found / np.linalg.norm(found, axis=2)[..., None]
    return moved
