"""The estimators, by other means than the core's: the formulas written out as printed, and dense least squares.

Means have the shape (..., positions, 3): any number of runs at once. Each estimator is linear in the means, so its
gains also map derivatives of outputs to derivatives of coefficients. Unknowns are K row by row, then U0, then the sizes
of further terms (tumble.terms), by term and channel; the terms are those of the ideal stand.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import UsageError
from tumble.estimators import COEFFICIENTS, HARMONIC, INCLINED, NORM
from tumble.model import inclined, norm
from tumble.model.further import felt
from tumble.model.geometry import built_in, ideal_force
from tumble.schedule import Mounting, Schedule
from tumble.terms import POWERS, Terms, names

SENSITIVITY = 1e-3  # g, per square root of the positions: with less, the core's threshold, nothing is identified
_SAME = 1e-9
_SQRT2 = np.sqrt(2.0)
_NINE = [45.0 * turn for turn in range(9)]
_FOUR = [45.0, 135.0, 225.0, 315.0]
_NULL_COMPONENT = 1e-7
_TOUCHED = 1e-3
_REMEMBERED = 64  # schedules: a run asks for its own again and again


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
    for index in schedule.fit_indices:
        position = schedule.positions[index]
        nearest = 45.0 * round(position.angle_deg / 45.0)
        if position.mounting == mounting.number and nearest in _NINE and abs(position.angle_deg - nearest) < _SAME:
            at.setdefault(nearest, index)
    angles = sorted(at)
    return Circle(normal, matrix, np.array([at[a] for a in angles])) if angles in (_NINE, _FOUR) else None


def paper_slots(schedule: Schedule) -> Integers | None:
    """Indices (2, 9) of the paper's positions; None if one is not there, or where there are other circles."""
    found = circles(schedule) or []
    paper = [np.array(mounting.matrix) for mounting in built_in("paper").mountings]
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


def _harmonic(schedule: Schedule, means: Floats, estimator: str) -> tuple[Floats, Floats]:
    """The earlier formulas (`averaged`): K_ij is the mean over all circles that hold the axis j, U0 that over all
    circles. Formula (7), of any circles (`refined`): as these, but K_ij and K_ji only from circles that hold both axes
    i and j, where there are any."""
    choosy = {"averaged": np.zeros((3, 3), dtype=bool), "refined": ~np.eye(3, dtype=bool)}[estimator]
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


def time_of_run(count: int) -> Floats:
    """From -1/2 to 1/2 at so many positions, which take equally long: (positions, 1)."""
    return np.arange(count)[:, None] / max(1, count - 1) - 0.5


def columns_at(force: Floats, terms: Terms) -> Floats:
    """Outputs by the size of every term at specific forces (positions, 3), in the order of the run: (3 x terms,
    positions, 3)."""
    time = np.repeat(time_of_run(len(force)), 3, axis=1)
    shown = [felt(term, force) if term in POWERS else time for term in terms]
    return np.array([one * np.eye(3)[i] for one in shown for i in range(3)]).reshape(-1, len(force), 3)


@lru_cache(_REMEMBERED)
def design(schedule: Schedule, terms: Terms = ()) -> Floats:
    """The outputs of the fit positions by all unknowns: (3 x fit positions, 12 + 3 x terms)."""
    force, fit = ideal_force(schedule), schedule.fit_indices
    further = columns_at(force, terms)[:, fit].reshape(3 * len(terms), 3 * len(fit)).T
    return np.hstack([by_coefficients(force[fit]), further])


def by_coefficients(force: Floats) -> Floats:
    """The derivatives (3 x positions, 12) of outputs at a `force` (positions, 3) by K row by row, then U0."""
    with_bias = np.column_stack([force, np.ones(len(force))])
    by_channel = np.einsum("pj,ic->picj", with_bias, np.eye(3))
    return np.concatenate([by_channel[..., :3].reshape(-1, 9), by_channel[..., 3].reshape(-1, 3)], axis=1)


def unknowns(
    schedule: Schedule, means: Floats, estimator: str, terms: Terms = (), weights: Floats = inclined.EQUAL
) -> Floats:
    """What an estimator that needs no stand finds (..., 12 + 3 x terms), from means (..., positions, 3) of all
    positions of the schedule. Further terms are for least squares alone, `weights` of the channels (3,) for `inclined`
    and `norm`. Raises inclined.NotShown, norm.NotShown."""
    means = np.asarray(means, dtype=float)
    if estimator == INCLINED:
        k, u0, _ = inclined.solve(schedule, means, weights)
        return np.concatenate([k.reshape(*k.shape[:-2], 9), u0], axis=-1)
    if estimator == NORM:
        k, u0, _ = norm.solve(means[..., schedule.fit_indices, :], weights)
        return np.concatenate([k.reshape(*k.shape[:-2], 9), u0], axis=-1)
    if estimator in HARMONIC:
        k, u0 = _harmonic(schedule, means, estimator)
        return np.concatenate([k.reshape(*k.shape[:-2], 9), u0], axis=-1)
    observed = means[..., schedule.fit_indices, :]
    found = _solved(design(schedule, terms), observed.reshape(-1, 3 * observed.shape[-2]).T).T
    return found.reshape(*observed.shape[:-2], -1)


def _solved(matrix: Floats, right: Floats) -> Floats:
    """Least squares for any number of right sides (rows, n).

    Refined once from residuals in the longest floating-point format there is: a witness must be better than what it
    judges, also where an offset is large and the design weak.
    """
    solution, _, rank, _ = np.linalg.lstsq(matrix, right, rcond=None)
    if rank < matrix.shape[1]:
        raise ValueError(f"the dense design has rank {rank} of {matrix.shape[1]}")
    residuals = right - matrix.astype(np.longdouble) @ solution
    better: Floats = solution + np.linalg.lstsq(matrix, residuals.astype(float), rcond=None)[0]
    return better


def estimate(schedule: Schedule, means: Floats, estimator: str) -> tuple[Floats, Floats]:
    """K (..., 3, 3) and U0 (..., 3); as `unknowns`."""
    found = unknowns(schedule, means, estimator)
    return found[..., :9].reshape(*found.shape[:-1], 3, 3), found[..., 9:]


@lru_cache(_REMEMBERED)
def linear_gains(schedule: Schedule, estimator: str, terms: Terms = ()) -> Floats:
    """Gains (12 + 3 x terms, 3 x fit positions) of an estimator that needs no stand: unknowns = gains times means, the
    channel running fastest. Raises UsageError where the schedule does not allow that estimator."""
    if estimator in HARMONIC and circles(schedule) is None:
        raise UsageError(f"the schedule lacks positions that {estimator} needs; least_squares solves any schedule")
    require_rank(schedule)
    count, fit = len(schedule.positions), schedule.fit_indices
    rows = unknowns(schedule, np.eye(3 * count).reshape(-1, count, 3), estimator, terms).reshape(count, 3, -1)
    return rows[fit].reshape(3 * len(fit), -1).T.copy()


def gains_at(
    schedule: Schedule, k: Floats, estimator: str, terms: Terms = (), weights: Floats = inclined.EQUAL
) -> Floats:
    """The same of any such estimator, for a block of sensitivity `k` (3, 3): of one that is not linear in the means,
    its derivatives there. Arguments as of `unknowns`."""
    if estimator == INCLINED:
        return inclined.gains(schedule, k, weights)
    if estimator == NORM:
        return norm.gains(schedule, k, weights)
    return linear_gains(schedule, estimator, terms)


@lru_cache(_REMEMBERED)
def magnification(schedule: Schedule, terms: Terms = ()) -> float:
    """How much larger than the rounding of the outputs the rounding of an unknown may be: the largest absolute row sum
    of the least-squares gains."""
    return float(np.abs(np.linalg.pinv(design(schedule, terms))).sum(axis=1).max())


@lru_cache(_REMEMBERED)
def require_rank(schedule: Schedule) -> None:
    """Raise UsageError where the fit positions do not identify all twelve."""
    lost = unidentified(schedule)
    if lost:
        raise UsageError(f"these positions cannot identify {', '.join(lost)}")


def unidentified(schedule: Schedule) -> list[str]:
    """Names of the coefficients that the fit positions cannot identify, by the null space of the design.

    A direction counts as identified when its singular value, per square root of the number of positions, is at least
    1e-3 g: the threshold of the core, which tests pivots instead.
    """
    touched = np.linalg.norm(null_space(design(schedule)), axis=0) > _NULL_COMPONENT
    lost = {name for name, one in zip(COEFFICIENTS, touched) if one}
    by_column = [*(f"K_{i}{j}" for j in "xyz" for i in "xyz"), *(f"U0_{i}" for i in "xyz")]
    return [name for name in by_column if name in lost]


def confused(schedule: Schedule, terms: Terms) -> list[list[str]]:
    """Sets of coefficients that the fit positions cannot tell apart, each with a further one in it, alone where no
    position shows it; the threshold is that of `unidentified`. The schedule identifies the twelve; no term is felt by
    two channels."""
    matrix, all_names, found = design(schedule, terms), (*COEFFICIENTS, *names(terms)), []
    for channel in "xyz":
        own = [index for index, name in enumerate(all_names) if name.partition("_")[2].startswith(channel)]
        unseen = [index for index in own if np.linalg.norm(matrix[:, index]) <= SENSITIVITY * len(matrix) ** 0.5]
        found += [[all_names[index]] for index in unseen]
        own = sorted(set(own) - set(unseen), key=lambda index: (index < 12, index))
        touched = np.linalg.norm(null_space(matrix[:, own]), axis=0) > _TOUCHED
        found.append([all_names[index] for index, one in zip(own, touched) if one])
    return [alike for alike in found if alike]


def null_space(matrix: Floats) -> Floats:
    """Directions (n, unknowns) that no output shows."""
    _, singular, directions = np.linalg.svd(matrix)
    strength = np.zeros(len(directions))
    strength[: len(singular)] = singular
    hidden: Floats = directions[strength <= SENSITIVITY * np.sqrt(len(matrix) / 3)]
    return hidden
