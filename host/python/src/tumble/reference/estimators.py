"""The estimators, by other means than the core's: the formulas written out as printed, and dense least squares.

Means have the shape (..., positions, 3): any number of runs at once. Each estimator is linear in the means, so it also
maps derivatives of outputs to derivatives of coefficients.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.records import dataclass
from tumble.reference.geometry import Geometry
from tumble.reference.schedules import paper_schedule
from tumble.schedule import FIT, Mounting, Schedule

_SAME = 1e-9
_SQRT2 = np.sqrt(2.0)
_NINE = [45.0 * turn for turn in range(9)]
_FOUR = [45.0, 135.0, 225.0, 315.0]
SENSITIVITY = 1e-3
_NULL_COMPONENT = 1e-7
_REMEMBERED = 64  # schedules: a run asks for its own again and again


def fit_indices(schedule: Schedule) -> list[int]:
    """Indices of the positions that an estimator may use."""
    return [index for index, position in enumerate(schedule.positions) if position.use == FIT]


@dataclass(frozen=True)
class Circle:
    """A mounting that the closed forms use: its circle lies in two block axes. `normal`: the third axis (0 to 2);
    `matrix` (3, 3); `slots`: indices of its nine positions in the schedule, or of its four on the diagonals."""

    normal: int
    matrix: Floats
    slots: Integers


@lru_cache(_REMEMBERED)
def circles(schedule: Schedule) -> list[Circle] | None:
    """The circles of a schedule, found by mounting and angle; None where they do not hold every block axis.

    The attitude alone would not do: a block yawed about the vertical feels the same force at 0 and 180 degrees.
    """
    found = [circle for circle in (_circle(schedule, mounting) for mounting in schedule.mountings) if circle]
    return found if len({circle.normal for circle in found}) > 1 else None


def _circle(schedule: Schedule, mounting: Mounting) -> Circle | None:
    matrix = np.array(mounting.matrix, dtype=float)
    normal = int(np.abs(matrix[:, 1]).argmax())
    if np.abs(np.abs(matrix[:, 1]) - np.eye(3)[normal]).max() > _SAME or abs(mounting.tilt_deg) > _SAME:
        return None
    at: dict[float, int] = {}
    for index in fit_indices(schedule):
        position = schedule.positions[index]
        nearest = 45.0 * round(position.angle_deg / 45.0)
        if position.mounting == mounting.number and nearest in _NINE and abs(position.angle_deg - nearest) < _SAME:
            at.setdefault(nearest, index)
    angles = sorted(at)
    return Circle(normal, matrix, np.array([at[a] for a in angles])) if angles in (_NINE, _FOUR) else None


def paper_slots(schedule: Schedule) -> Integers | None:
    """Indices (2, 9) of the paper's positions; None if one is not there, or where there are other circles."""
    found = circles(schedule) or []
    paper = [np.array(mounting.matrix) for mounting in paper_schedule().mountings]
    alike = [[c.slots for c in found if len(c.slots) == 9 and np.abs(c.matrix - m).max() < _SAME] for m in paper]
    return np.array(alike)[:, 0] if len(found) == 2 and all(alike) else None


def functionals(u: Floats) -> tuple[Floats, Floats, Floats]:
    """c, s, b of one circle: amplitudes of cos phi (formula 3) and sin phi, mean. u (..., 9 or 4, 3) -> (..., 3)."""
    if u.shape[-2] == 4:
        u1, u2, u3, u4 = np.moveaxis(u, -2, 0)
        root8 = 2 * _SQRT2
        return (u1 - u2 - u3 + u4) / root8, (u1 + u2 - u3 - u4) / root8, (u1 + u2 + u3 + u4) / 4
    u1, u2, u3, u4, u5, u6, u7, u8, u9 = np.moveaxis(u, -2, 0)
    c = (u1 + u9 - 2 * u5 + _SQRT2 * (u2 + u8 - u4 - u6)) / 8
    s = (2 * (u3 - u7) + _SQRT2 * (u2 + u4 - u6 - u8)) / 8
    b = ((u1 + u9) / 2 + u2 + u3 + u4 + u5 + u6 + u7 + u8) / 8
    return c, s, b


def averaged(schedule: Schedule, means: Floats) -> tuple[Floats, Floats]:
    """The earlier formulas: K_ij is the mean over all circles that hold the axis j, U0 that over all circles."""
    return _mean_over_circles(schedule, means, np.zeros((3, 3), dtype=bool))


def refined(schedule: Schedule, means: Floats) -> tuple[Floats, Floats]:
    """Formula (7), of any circles: as averaged, but K_ij and K_ji only from those that hold both axes i and j."""
    return _mean_over_circles(schedule, means, ~np.eye(3, dtype=bool))


def _mean_over_circles(schedule: Schedule, means: Floats, choosy: Flags) -> tuple[Floats, Floats]:
    """`choosy` (3, 3): the K_ij that are taken only from circles that hold both axes, where there are any."""
    found = circles(schedule)
    assert found is not None  # whoever asks for this estimator has seen to it
    holds = np.array([np.arange(3) != circle.normal for circle in found])
    both = holds[:, :, None] & holds[:, None, :]
    tells = np.where(choosy & both.any(axis=0), both, holds[:, None, :])
    k, u0 = np.zeros((3, 3)), np.zeros(3)
    for circle, told in zip(found, tells):
        c, s, b = functionals(means[..., circle.slots, :])
        k_here = s[..., :, None] * circle.matrix[:, 0] + c[..., :, None] * circle.matrix[:, 2]
        k, u0 = k + np.where(told, k_here, 0.0), u0 + b
    return k / tells.sum(axis=0), u0 / len(found)


@lru_cache(_REMEMBERED)
def dense_design(schedule: Schedule) -> Floats:
    """The design of all channels at once, (3 x fit positions, 12): K column by column, then U0."""
    force = Geometry(schedule).force()[fit_indices(schedule)]
    with_bias = np.column_stack([force, np.ones(len(force))])
    return np.kron(with_bias, np.eye(3)).astype(float, copy=False)


def least_squares(schedule: Schedule, means: Floats) -> tuple[Floats, Floats]:
    """Ordinary least squares on the ideal geometry, from the dense design by singular values."""
    observed = means[..., fit_indices(schedule), :]
    batch = observed.shape[:-2]
    right = observed.reshape(int(np.prod(batch)), -1).T
    solution = solved(dense_design(schedule), right)
    columns = solution.T.reshape(*batch, 4, 3)
    return np.swapaxes(columns[..., :3, :], -1, -2), columns[..., 3, :]


def solved(design: Floats, right: Floats) -> Floats:
    """Least squares for any number of right sides (rows, n).

    Refined once from residuals in the longest floating-point format there is: a witness must be better than what it
    judges, also where an offset is large and the design weak.
    """
    solution, _, rank, _ = np.linalg.lstsq(design, right, rcond=None)
    if rank < design.shape[1]:
        raise ValueError(f"the dense design has rank {rank} of {design.shape[1]}")
    residuals = right - design.astype(np.longdouble) @ solution
    refined: Floats = solution + np.linalg.lstsq(design, residuals.astype(float), rcond=None)[0]
    return refined


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
    null_space = directions[strength <= SENSITIVITY * np.sqrt(len(design) / 3)]
    names = [f"K_{i}{j}" for j in "xyz" for i in "xyz"] + [f"U0_{i}" for i in "xyz"]
    touched = np.sqrt((null_space**2).sum(axis=0)) > _NULL_COMPONENT
    return [name for name, lost in zip(names, touched) if lost]
