"""The estimators, by other means than the core's: the formulas written out as printed, and dense least squares.

Means have the shape (..., positions, 3): any number of runs at once. Each estimator is linear in the means, so it also
maps derivatives of outputs to derivatives of coefficients.
"""

from __future__ import annotations

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.reference.geometry import Geometry, paper_schedule
from tumble.schedule import FIT, Mounting, Schedule

_SAME = 1e-9
_SQRT2 = np.sqrt(2.0)
_SENSITIVITY = 1e-3
_NULL_COMPONENT = 1e-7


def fit_indices(schedule: Schedule) -> list[int]:
    """Indices of the positions that an estimator may use."""
    return [index for index, position in enumerate(schedule.positions) if position.use == FIT]


def paper_slots(schedule: Schedule) -> Integers | None:
    """Indices (2, 9) of the paper's positions in a schedule, found by mounting and angle; None if one is not there.

    The attitude alone would not do: a block yawed about the vertical feels the same force at 0 and 180 degrees.
    """
    paper = paper_schedule()
    slots = [_slot(schedule, paper.mountings[place.mounting - 1], place.angle_deg) for place in paper.positions]
    return None if None in slots else np.array(slots).reshape(2, 9)


def _slots(schedule: Schedule) -> Integers:
    """The same, where whoever asks for this estimator has seen to it that they are there."""
    slots = paper_slots(schedule)
    assert slots is not None
    return slots


def _slot(schedule: Schedule, mounting: Mounting, angle_deg: float) -> int | None:
    """Index of the first fit position at an angle in a mounting like this one; None if there is none."""
    alike = {
        other.number
        for other in schedule.mountings
        if np.abs(np.subtract(other.matrix, mounting.matrix)).max() < _SAME and abs(other.tilt_deg) < _SAME
    }
    positions = schedule.positions
    found = (i for i in fit_indices(schedule) if positions[i].mounting in alike)
    return next((i for i in found if abs(positions[i].angle_deg - angle_deg) < _SAME), None)


def functionals(u: Floats) -> tuple[Floats, Floats, Floats]:
    """c, s, b of one mounting: amplitudes of cos phi (formula 3) and sin phi, mean. u (..., 9, 3) -> (..., 3)."""
    u1, u2, u3, u4, u5, u6, u7, u8, u9 = np.moveaxis(u, -2, 0)
    c = (u1 + u9 - 2 * u5 + _SQRT2 * (u2 + u8 - u4 - u6)) / 8
    s = (2 * (u3 - u7) + _SQRT2 * (u2 + u4 - u6 - u8)) / 8
    b = ((u1 + u9) / 2 + u2 + u3 + u4 + u5 + u6 + u7 + u8) / 8
    return c, s, b


def averaged(schedule: Schedule, means: Floats) -> tuple[Floats, Floats]:
    """The earlier formulas: what both mountings tell is averaged."""
    slots = _slots(schedule)
    c1, s1, b1 = functionals(means[..., slots[0], :])
    c2, s2, b2 = functionals(means[..., slots[1], :])
    k1_x, k2_x = s1, -s2
    return np.stack([(k1_x + k2_x) / 2, c2, c1], axis=-1), (b1 + b2) / 2


def refined(schedule: Schedule, means: Floats) -> tuple[Floats, Floats]:
    """Formula (7): as averaged, but K_yx from mounting 2 alone and K_zx from mounting 1 alone."""
    slots = _slots(schedule)
    k, u0 = averaged(schedule, means)
    k[..., 1, 0] = -functionals(means[..., slots[1], :])[1][..., 1]
    k[..., 2, 0] = functionals(means[..., slots[0], :])[1][..., 2]
    return k, u0


def dense_design(schedule: Schedule) -> Floats:
    """The design of all channels at once, (3 x fit positions, 12): K column by column, then U0."""
    force = Geometry(schedule).force()[fit_indices(schedule)]
    with_bias = np.column_stack([force, np.ones(len(force))])
    return np.kron(with_bias, np.eye(3)).astype(float, copy=False)


def least_squares(schedule: Schedule, means: Floats) -> tuple[Floats, Floats]:
    """Ordinary least squares on the ideal geometry, from the dense design by singular values.

    Refined once from residuals in the longest floating-point format there is: a witness must be better than what it
    judges, also where an offset is large and the design weak.
    """
    observed = means[..., fit_indices(schedule), :]
    batch = observed.shape[:-2]
    right = observed.reshape(int(np.prod(batch)), -1).T
    design = dense_design(schedule)
    solution, _, rank, _ = np.linalg.lstsq(design, right, rcond=None)
    if rank < 12:
        raise ValueError(f"the dense design has rank {rank} of 12")
    residuals = right - design.astype(np.longdouble) @ solution
    solution = solution + np.linalg.lstsq(design, residuals.astype(float), rcond=None)[0]
    columns = solution.T.reshape(*batch, 4, 3)
    return np.swapaxes(columns[..., :3, :], -1, -2), columns[..., 3, :]


def magnification(schedule: Schedule) -> float:
    """How much larger than the rounding of the outputs the rounding of a coefficient may be: the largest absolute row
    sum of the least-squares gains of one channel."""
    force = Geometry(schedule).force()[fit_indices(schedule)]
    return float(np.abs(np.linalg.pinv(np.column_stack([force, np.ones(len(force))]))).sum(axis=1).max())


_ESTIMATORS = {"averaged": averaged, "refined": refined, "least_squares": least_squares}


def estimate(schedule: Schedule, means: Floats, estimator: str) -> tuple[Floats, Floats]:
    """K (..., 3, 3) and U0 (..., 3) from means (..., positions, 3) of all positions of the schedule."""
    return _ESTIMATORS[estimator](schedule, np.asarray(means, dtype=float))


def unidentified(schedule: Schedule) -> list[str]:
    """Names of the coefficients that the fit positions cannot identify, by the null space of the dense design.

    A direction counts as identified when its singular value, per square root of the number of positions, is at least
    1e-3 g: the threshold of the core, which tests pivots instead.
    """
    design = dense_design(schedule)
    _, singular, directions = np.linalg.svd(design)
    strength = np.zeros(12)
    strength[: len(singular)] = singular
    null_space = directions[strength <= _SENSITIVITY * np.sqrt(len(design) / 3)]
    names = [f"K_{i}{j}" for j in "xyz" for i in "xyz"] + [f"U0_{i}" for i in "xyz"]
    touched = np.sqrt((null_space**2).sum(axis=0)) > _NULL_COMPONENT
    return [name for name, lost in zip(names, touched) if lost]
