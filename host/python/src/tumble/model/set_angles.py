"""The errors of a stand's set angles that stay from run to run: learnt from several runs, and taken out of another.

A table turned to the same mark comes to the same wrong angle. What a mark is off by (`table`) is common to all runs;
where a position came to beside it is drawn anew each time, with a standard deviation that the runs show too, the
`repeatability`. Everything else is of its own run: coefficients, levelling, yaw, seats, noise. With those taken off,
whitened (model.fit), what is left of a run is

    rest = E (W t + e) + noise of variance 1

with e of every position, t of every mark, and W which mark a position has. By the singular values of E = B S V^T this
is diagonal: B^T rest = S V^T W t + noise of variance 1 + repeatability^2 S^2. The repeatability is that of the largest
restricted likelihood, t the least squares beside its declared prior.

What all marks are off by in common is a zero of the table angle, which no run tells from its level: the table has mean
0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from tumble.arrays import Floats
from tumble.distributions import chi_squared_above
from tumble.model.estimators import estimate, unidentified
from tumble.model.fit import WholeModel
from tumble.model.geometry import geometry_of, ideal_force
from tumble.schedule import Schedule
from tumble.stand import Stand

_PASSES = 2  # of learning: the second order of what the first one found
_CORRECTIONS = 3  # K is found with the angles that it takes to correct them
_STEPS = 60  # of a search by halving
_DROP = 0.5  # of the logarithm of a likelihood, one standard uncertainty away


@dataclass(frozen=True)
class LearningRun:
    """`means` (positions, 3) on the measured part of a `schedule`, their `variance` (positions, 3) by the noise, and
    the `stand` as declared, in the unit of the outputs."""

    schedule: Schedule
    means: Floats
    variance: Floats
    stand: Stand


@dataclass(frozen=True)
class Learnt:
    """`errors` (marks,) of the set angles at `marks` (marks,), deg, with standard uncertainties `u`; likewise of the
    `repeatability`; all rad. `p`: by run, how often a run that fits with them comes out worse."""

    marks: tuple[float, ...]
    errors: Floats
    u: Floats
    repeatability: float
    u_repeatability: float
    p: tuple[float, ...]


def learn(runs: Sequence[LearningRun], angle: float) -> Learnt:
    """From at least two runs, on stands whose set angles are off by the declared standard deviation `angle`, rad."""
    marks = tuple(sorted({p.mark for run in runs for p in run.schedule.positions}))
    found = np.zeros(len(marks))
    for _ in range(_PASSES):
        parts = [_Part(run, marks, found) for run in runs]
        repeatability = _highest(partial(_likelihood, parts), 4.0 * angle)
        rows, left = _equations(parts, repeatability)
        information = rows.T @ rows + np.eye(len(marks)) / angle**2
        covariance = np.linalg.inv(information)
        change = covariance @ (rows.T @ left - found / angle**2)
        found = found + change
    left_out = np.eye(len(marks)) - 1.0 / len(marks)  # what is common to all
    errors, covariance = left_out @ found, left_out @ covariance @ left_out
    best = _likelihood(parts, repeatability)
    upper = _lowered(lambda size: best - _likelihood(parts, size) - _DROP, repeatability, 8.0 * angle)
    u = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    p = tuple(part.p(repeatability, change) for part in parts)
    return Learnt(marks, errors, u, repeatability, upper - repeatability, p)


class _Part:
    """What a run shows of its set angles beside those `found` (marks,): `shown` (n,), with noise of variance 1 +
    repeatability^2 `steep`^2, and its derivatives `by_mark` (n, marks); `beyond`: the squares that no set angle
    moves."""

    def __init__(self, run: LearningRun, marks: tuple[float, ...], found: Floats):
        place = [marks.index(position.mark) for position in run.schedule.positions]
        means = turned_back(run.schedule, run.means, found[place])
        stand = run.stand.with_sigma("angle", 0.0).with_sigma("encoder", 0.0)
        model = WholeModel(run.schedule, means, run.variance, stand)
        geometry, positions = geometry_of(model.schedule), len(model.schedule.positions)
        columns = {str(i): geometry.force_by(delta=one) @ model.k.T for i, one in enumerate(np.eye(positions))}
        left, self.steep, right = np.linalg.svd(model.whitened(columns), full_matrices=False)
        of_mark = np.eye(len(marks))[[place[index] for index in run.schedule.fit_indices]]
        self.shown, self.by_mark = left.T @ model.rest, self.steep[:, None] * (right @ of_mark)
        self.beyond, self.freedom = float(model.rest @ model.rest - self.shown @ self.shown), model.freedom

    def p(self, repeatability: float, change: Floats) -> float:
        """How often a run that fits has a larger chi-squared, with the marks off by a `change` (marks,) more."""
        left, variance = self.shown - self.by_mark @ change, 1.0 + (repeatability * self.steep) ** 2
        square = self.beyond + float((left**2 / variance).sum())
        return chi_squared_above(square, self.freedom)


def _equations(parts: Sequence[_Part], repeatability: float) -> tuple[Floats, Floats]:
    """Of the table, all of variance 1."""
    sigma = [np.sqrt(1.0 + (repeatability * part.steep) ** 2) for part in parts]
    rows = np.concatenate([part.by_mark / one[:, None] for part, one in zip(parts, sigma)])
    return rows, np.concatenate([part.shown / one for part, one in zip(parts, sigma)])


def _likelihood(parts: Sequence[_Part], repeatability: float) -> float:
    """Its logarithm, restricted to what no table moves."""
    rows, left = _equations(parts, repeatability)
    own, singular, _ = np.linalg.svd(rows, full_matrices=False)
    used = singular > 1e-6 * singular[0]  # not what is common to all marks
    rest = left - own[:, used] @ (own[:, used].T @ left)
    spread = sum(float(np.log1p((repeatability * part.steep) ** 2).sum()) for part in parts)
    return -(float(rest @ rest) + spread) / 2.0 - float(np.log(singular[used]).sum())


def _highest(height: Callable[[float], float], most: float) -> float:
    """Where a function with one maximum in 0..most is highest, by the golden section; 0 where it falls from there."""
    low, high, ratio = 0.0, most, (math.sqrt(5.0) - 1.0) / 2.0
    for _ in range(_STEPS):
        one, other = high - ratio * (high - low), low + ratio * (high - low)
        low, high = (low, other) if height(one) >= height(other) else (one, high)
    found = (low + high) / 2.0
    return 0.0 if height(0.0) >= height(found) else found


def _lowered(depth: Callable[[float], float], low: float, high: float) -> float:
    """Where a function that rises from below 0 at `low` reaches 0; `high` where it does not."""
    if depth(high) < 0.0:
        return high
    for _ in range(_STEPS):
        middle = (low + high) / 2.0
        low, high = (middle, high) if depth(middle) < 0.0 else (low, middle)
    return high


def turned_back(schedule: Schedule, means: Floats, errors: Floats, known: Floats | None = None) -> Floats:
    """The means (positions, 3) as they would be at the angles that were set, of a table that came to angles off by
    `errors` (positions,), rad. Where the positions do not identify the twelve, by the K that is `known` (3, 3); as they
    are where none is."""
    off, back = geometry_of(schedule).force(delta=errors) - ideal_force(schedule), means
    if unidentified(schedule):
        return means if known is None else means - off @ known.T
    for _ in range(_CORRECTIONS):
        k, _ = estimate(schedule, back, "least_squares")
        back = means - off @ k.T
    return back
