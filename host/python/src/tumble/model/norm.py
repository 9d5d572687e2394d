"""Any still poses, nobody knows how they lie: K and U0 from the length of gravity alone, which is 1 g at every pose
(multi-position scalar calibration).

    U_p = U0 + K n_p,   |n_p| = 1

The outputs lie on an ellipsoid: its centre is U0, and it shows K but for a rotation of the block's frame, and which
way each axis points. So nine are found, by convention those of a lower triangular K: x of the block's frame is the
sensitive axis of channel x, and y lies in the plane of x and that of channel y. The start is the linear fit of an
ellipsoid, whose Cholesky factor is such a K; then least squares of the outputs over K, U0 and all directions n_p, by
Newton's way after Gauss. With e the residual of a pose, and w the normal of the ellipsoid there, which is K^-T n,

    w . (dK n + dU0) = w . e      over all poses;   n += K^-1 e, less what leaves the sphere along (K^T K)^-1 n

Every pose counts as one mean; channels are weighed. At the solution K and U0 are those of plain least squares on the
directions found, by which the core confirms them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tumble.arrays import Floats
from tumble.model.geometry import ideal_force
from tumble.schedule import Mounting, Position, Schedule

NINE = ("K_xx", "K_yx", "K_yy", "K_zx", "K_zy", "K_zz", "U0_x", "U0_y", "U0_z")
ROWS, COLUMNS = np.tril_indices(3)  # of K, those that are found
TURNED = tuple(3 * i + j for i, j in zip(*np.triu_indices(3, 1)))  # row by row, those that are 0 by convention
_PASSES = 60
_SETTLED = 1e-13  # of the largest element: the next change is far below the last bit
_WEAK = 0.03  # singular value, per square root of the poses: beside it noise counts over thirty times
_NOTHING = 1e-9  # the same: nothing at all
_IN_IT = 0.3  # of the largest part of a combination
_ONE_SIDE = np.sin(np.deg2rad(1.0))  # how far beyond a plane through the centre a pose shows its other side


class NotShown(ValueError):
    """The means are on no ellipsoid."""


def solve(means: Floats, weights: Floats) -> tuple[Floats, Floats, Floats]:
    """K (..., 3, 3), lower triangular, U0 (..., 3) and the directions (..., poses, 3) of gravity's opposite, of means
    (..., poses, 3). `weights` (3,) of the channels, best in proportion to 1 / noise; negative where the scale of a
    channel is. Raises NotShown."""
    weighed = np.asarray(means) * np.abs(weights)
    try:
        k, u0 = _ellipsoid(weighed)
    except np.linalg.LinAlgError:
        raise NotShown("the means lie on no ellipsoid: did the block rest in every pose, within its range?") from None
    n = np.linalg.solve(k[..., None, :, :], (weighed - u0[..., None, :])[..., None])[..., 0]
    n = n / np.linalg.norm(n, axis=-1, keepdims=True)
    for _ in range(_PASSES):
        system, normal = _design(k, n)
        left = (normal * (weighed - u0[..., None, :] - n @ np.swapaxes(k, -1, -2))).sum(axis=-1)
        change = (np.linalg.pinv(system) @ left[..., None])[..., 0]
        k[..., ROWS, COLUMNS] += change[..., :6]
        u0 = u0 + change[..., 6:]
        n = _nearest(k, n, weighed - u0[..., None, :])
        if (np.abs(change).max(axis=-1) <= _SETTLED * np.abs(k).max(axis=(-1, -2))).all():
            break
    signs = np.where(weights < 0.0, -1.0, 1.0)
    return k * signs / np.abs(weights)[:, None], u0 / np.abs(weights), n * signs


def gains(schedule: Schedule, k: Floats, weights: Floats) -> Floats:
    """Derivatives (12, 3 x poses) of K row by row and U0 by the means, the channel running fastest, for a block of
    sensitivity `k`, lower triangular, at the directions of the schedule."""
    weights = np.abs(weights)
    system, normal = _design(k * weights[:, None], ideal_force(schedule))
    nine = np.linalg.pinv(system)[:, :, None] * (normal * weights)
    nine = nine.reshape(9, -1) / weights[np.concatenate([ROWS, range(3)])][:, None]
    found = np.zeros((12, nine.shape[1]))
    found[np.concatenate([3 * ROWS + COLUMNS, [9, 10, 11]])] = nine
    return found


def unshown(n: Floats, sigma_g: float | None = None) -> str | None:
    """What poses at directions `n` (poses, 3) do not show, or hardly, in words; None where they show all nine.
    `sigma_g`: of a mean, g, None: unknown; then what it would leave of each combination is told with it."""
    _, singular, combinations = np.linalg.svd(_design(np.eye(3), n)[0])
    shown = np.zeros(len(NINE))
    shown[: len(singular)] = singular

    def told(index: int) -> str:
        parts = np.abs(combinations[index])
        named = " with ".join(name for name, part in zip(NINE, parts) if part > _IN_IT * parts.max())
        if shown[index] < _NOTHING:
            return named
        return named + ("" if sigma_g is None else f" (u {sigma_g / shown[index]:.2g} g)")

    weak = [told(index) for index in np.flatnonzero(shown < _WEAK * len(n) ** 0.5).tolist()]
    if weak:
        few = f"{len(n)} poses are fewer than nine coefficients: they" if len(n) < len(NINE) else "these poses"
        return f"{few} do not show {', nor '.join(weak)}; lay the block otherwise too, at angles between"
    side = _one_side(n)
    if side is None:
        return None
    axis = int(np.abs(side).argmax())
    face = f"{'-' if side[axis] > 0.0 else '+'}{'xyz'[axis]}"
    return f"all poses lie in one hemisphere, none has {face} up: they hardly show {told(8)}; turn the block over, too"


def as_seen(schedule: Schedule, directions: Floats) -> Schedule:
    """The schedule at the `directions` (positions, 3) that a run shows; every position is a mounting of its own."""
    mountings = (replace(one, matrix=_upright(n)) for one, n in zip(schedule.mountings, directions))
    return Schedule(tuple(mountings), schedule.positions)


def of_poses(numbers: Sequence[tuple[int, int]]) -> Schedule:
    """A schedule of poses of these mountings and positions, whose directions nobody knows yet."""
    upright = _upright(np.array([0.0, 0.0, 1.0]))
    mountings = dict.fromkeys(mounting for mounting, _ in numbers)
    return Schedule(tuple(Mounting(one, upright) for one in mountings), tuple(Position(*one, 0.0) for one in numbers))


def _upright(n: Floats) -> tuple[tuple[float, ...], ...]:
    """A block, its axes in the table frame h, n, v, in which the direction `n` points up."""
    along = np.cross(np.eye(3)[np.abs(n).argmin()], n)
    along = along / np.linalg.norm(along)
    return tuple(map(tuple, np.column_stack([along, np.cross(n, along), n]).tolist()))


def roughly(means: Floats, weights: Floats) -> tuple[Floats, float]:
    """Directions (poses, 3) of means (poses, 3), and what 1 g is in the channel that is weighed most, for a block whose
    axes are square: which few poses show."""
    weighed = means * np.abs(weights)
    low, high = weighed.min(axis=0), weighed.max(axis=0)
    size = float((high - low).max()) / 2.0 or 1.0
    outputs = (weighed - (low + high) / 2.0) / size
    squares, lines = np.split(np.linalg.lstsq(np.hstack([outputs**2, outputs]), np.ones(len(means)), rcond=None)[0], 2)
    if not (squares > 0.0).all():
        squares, lines = np.ones(3), np.zeros(3)
    n = (outputs + lines / (2.0 * squares)) * np.sqrt(squares)
    return n / np.maximum(np.linalg.norm(n, axis=1, keepdims=True), _NOTHING), size


def _ellipsoid(u: Floats) -> tuple[Floats, Floats]:
    """K, lower triangular, and U0 of the ellipsoid u^T A u + b u = 1 that a linear fit finds."""
    low, high = u.min(axis=-2), u.max(axis=-2)
    middle, size = (low + high) / 2.0, (high - low).max(axis=-1)[..., None] / 2.0
    x, y, z = np.moveaxis((u - middle[..., None, :]) / size[..., None, :], -1, 0)
    columns = np.stack([x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z, 2 * x, 2 * y, 2 * z], axis=-1)
    found = np.linalg.pinv(columns).sum(axis=-1)
    a, b = found[..., [[0, 3, 4], [3, 1, 5], [4, 5, 2]]], found[..., 6:]
    centre = -np.linalg.solve(a, b[..., None])[..., 0]
    to_one = 1.0 - (b * centre).sum(axis=-1)
    k = np.linalg.cholesky(np.linalg.inv(a / to_one[..., None, None]))
    return k * size[..., None], middle + centre * size


def _design(k: Floats, n: Floats) -> tuple[Floats, Floats]:
    """The outputs (..., poses, 9) along the normal of the ellipsoid by the nine, and that normal (..., poses, 3), at
    directions n."""
    normal = n @ np.linalg.inv(k)
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.concatenate([normal[..., ROWS] * n[..., COLUMNS], normal], axis=-1), normal


def _nearest(k: Floats, n: Floats, outputs: Floats) -> Floats:
    """The directions whose outputs K n are nearest, from directions n that nearly are."""
    inverse = np.linalg.inv(k)
    change = (outputs - n @ np.swapaxes(k, -1, -2)) @ np.swapaxes(inverse, -1, -2)
    across = n @ inverse @ np.swapaxes(inverse, -1, -2)
    leaves = (n * change).sum(axis=-1, keepdims=True) / (n * across).sum(axis=-1, keepdims=True)
    nearer = n + change - leaves * across
    found: Floats = nearer / np.linalg.norm(nearer, axis=-1, keepdims=True)
    return found


def _one_side(n: Floats) -> Floats | None:
    """A direction (3,) against which no pose has more than a degree; None where there is none: then poses lie on both
    sides of every plane."""
    first, second = np.triu_indices(len(n), 1)
    sides = np.cross(n[first], n[second])
    length = np.linalg.norm(sides, axis=1)
    sides = sides[length > 1e-9] / length[length > 1e-9][:, None]
    sides = np.concatenate([sides, -sides])
    least = (sides @ n.T).min(axis=1, initial=1.0)
    return sides[least.argmax()] if len(sides) and least.max() >= -_ONE_SIDE else None
