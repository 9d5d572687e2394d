"""The quickest schedule for a limit or a worst u(|a|), beside what the built-in schedules take for the same.

How long a schedule takes (`Pace`): moves, settling, averaging, and what people need to mount the block anew, or to
incline the stand. The table comes to every angle from below, as the play of its gear asks for: it turns up through a
mounting's angles and back to the lowest of the next. Homing and the first mounting are the same for all schedules, and
not counted.

Ways to mount a block on a table square to its axes (`KINDS`): there are 24 proper rotations. Half a turn about the
stand's axis is one of the table, so 12 remain. And which of a block's axes bears which name makes no difference to what
several mountings together can tell: of sets that differ by their names alone one is kept, the one that starts with the
first mounting of the paper.

How well subsets of positions know the norm of a (`NormSpread`): the worst u(|a|) over all attitudes, for thousands of
them. What does not depend on the subset is computed once, for all candidate positions: what the stand's errors do to
the outputs, and what errors of the unknowns do to |a|. An error of the stand that touches one position only, such as
that of a set angle, adds to the covariance of its outputs; one that positions share is an unknown with a prior. For
`optimal` the information of the positions then simply adds up. `least_squares` is propagated as it is. Unknowns are the
coefficients, and the sizes of the case's further terms. A drift goes by the order of the candidates; of a subset that
leaves some out it is nearly the drift of the run.

The search (`quickest`): for every set of mountings, the table angle is left out that is needed least, again and again,
and each time the samples are counted that what is left needs. The quickest of all these is then improved by exchanges
of one angle for another, as long as that saves time. It proves no optimum; it always finds the same.

Of one bolting (`inclined_schedules`) all are tried: the closed form takes three inclinations on both sides of the level
and angles that divide a turn equally, which leaves few. There the inclinations are unknowns, of no size where the stand
declares none; `optimal` has them among its own, and where that is not asked for, `inclined` takes the place of
`least_squares`, which would need them known.

A limit is kept when a run passes, and |a| is within the limit at every attitude, with the probability asked for. That
is a worst u(|a|) too, another for each schedule; it is found by trying (`reaching`). Nobody inclines a stand exactly:
so it is kept at inclinations that are less steep too (`less_steep`).
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Iterator
from dataclasses import asdict, astuple, dataclass, replace
from functools import partial
from itertools import combinations, groupby, pairwise, permutations, product
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import UNSET, UnsetType

from tumble.arrays import Flags, Floats
from tumble.core import MAX_POSITIONS, MAX_SAMPLES
from tumble.documents import plan
from tumble.documents.plan import GrowingPromise, ModelCost, Quickest
from tumble.documents.result import WorstNorm
from tumble.errors import UsageError
from tumble.estimators import INCLINED, OPTIMAL
from tumble.files.stand_file import StandFile
from tumble.model import inclined, reliability
from tumble.model.coefficients import norm_gradient, spread_attitudes, worst_norm
from tumble.model.errors import NOISE, Errors, declared, free, of_stand
from tumble.model.estimators import columns_at
from tumble.model.geometry import built_in, ideal_force
from tumble.model.optimal import UNEQUAL, mean_sigma
from tumble.model.reliability import Reliability
from tumble.planning import tables
from tumble.planning.case import Case
from tumble.planning.model_cost import model_cost, model_cost_part, sentence as cost_sentence
from tumble.planning.promise import error_field, growing_promise, sentence
from tumble.schedule import Mounting, Position, Schedule
from tumble.solving.computation import confused
from tumble.solving.result import unseen
from tumble.stand import by_channel
from tumble.terms import DRIFT, EXTENDABLE, Terms, model_of
from tumble.workers.over import ALONE, Piece, Progress, Result, Team, over

if TYPE_CHECKING:
    from rich.console import Console

DEFAULT_REMOUNT_S, DEFAULT_INCLINE_S = 300.0, 60.0
_MOTION = {"velocity_deg_per_s": 90.0, "acceleration_deg_per_s2": 180.0, "settling_s": 0.5}
_RATE_HZ = 100.0


@dataclass(frozen=True)
class Duration:
    """Durations of the parts of a test, seconds."""

    moving: float
    settling: float
    averaging: float
    remounting: float
    inclining: float

    @property
    def total(self) -> float:
        """The sum of all parts."""
        return self.moving + self.settling + self.averaging + self.remounting + self.inclining


@dataclass(frozen=True)
class Timed:
    """A schedule that reaches the goal with `samples` at each position. `norm_g`: the worst u(|a|) that it was, or
    could be, held to."""

    schedule: Schedule
    samples: int
    norm_g: float
    duration: Duration

    def freedom(self, terms: Terms) -> int:
        """Of the residuals: what a fit, with further `terms`, leaves to show that the model holds. Inclinations and
        their zeros of the table angle are unknowns, but for the first zero."""
        of_stand = 2 * len(self.schedule.mountings) - 1 if self.schedule.is_inclined else 0
        return 3 * (len(self.schedule.fit_indices) - len(terms)) - 12 - of_stand


@dataclass(frozen=True)
class Pace:
    """How fast a table, a block and people work: deg/s, deg/s^2, s, samples a second, s."""

    velocity: float
    acceleration: float
    settling: float
    rate: float
    remounting: float
    inclining: float = DEFAULT_INCLINE_S

    @classmethod
    def of(cls, stand_file: StandFile | None, remount_s: float, incline_s: float = DEFAULT_INCLINE_S) -> Pace:
        """The pace by a stand file, else by the simulated stand."""
        motion = {**_MOTION, **((stand_file and stand_file.motion) or {})}
        rate = ((stand_file and stand_file.block) or {}).get("sample_rate_hz") or _RATE_HZ
        velocity, acceleration, settling = (motion[key] for key in _MOTION)
        return cls(velocity, acceleration, settling, rate, remount_s, incline_s)

    def duration(self, schedule: Schedule, samples: int) -> Duration:
        """Of a schedule whose positions stand mounting by mounting. Moves are at rest at both ends, with limited speed
        and acceleration."""
        angles = [0.0, *(position.angle_deg for position in schedule.positions)]
        bolting = {one.number: one.bolting or -one.number for one in schedule.mountings}
        mounted = [bolting[number] for number, _ in groupby(one.mounting for one in schedule.positions)]
        remountings = sum(a != b for a, b in pairwise(mounted))

        def move(degrees: float) -> float:
            if degrees < self.velocity**2 / self.acceleration:
                return 2.0 * math.sqrt(degrees / self.acceleration)
            return degrees / self.velocity + self.velocity / self.acceleration

        return Duration(
            moving=sum(move(abs(b - a)) for a, b in pairwise(angles)),
            settling=self.settling * len(schedule.positions),
            averaging=samples * len(schedule.positions) / self.rate,
            remounting=self.remounting * remountings,
            inclining=self.inclining * (len(mounted) - 1 - remountings),
        )

    def timed(self, schedule: Schedule, samples: int, norm_g: float) -> Timed:
        """The schedule with what it takes."""
        return Timed(schedule, samples, norm_g, self.duration(schedule, samples))


_HALF_TURN = np.diag([-1.0, 1.0, -1.0])  # about n, in the table frame h, n, v
_SIGNED_AXES = [
    np.eye(3)[list(order)] * np.array(signs)[:, None]
    for order in permutations(range(3))
    for signs in product((1.0, -1.0), repeat=3)
]
ROTATIONS = sorted(
    (matrix for matrix in _SIGNED_AXES if np.linalg.det(matrix) > 0.0),
    key=lambda matrix: (np.abs(matrix - np.eye(3)).sum(), *matrix.ravel()),
)


def _kind(matrix: Floats) -> int:
    """Number of the first of ROTATIONS that is the same mounting."""
    return _KIND_OF[(matrix + 0.0).tobytes()]


_KIND_OF: dict[bytes, int] = {}
for _number, _matrix in enumerate(ROTATIONS):
    for _same in (_matrix, _matrix @ _HALF_TURN):
        _KIND_OF.setdefault((_same + 0.0).tobytes(), _number)
KINDS = tuple(sorted({_kind(matrix) for matrix in ROTATIONS}))


def mounting_sets(count: int) -> list[tuple[int, ...]]:
    """Sets of `count` of KINDS, no two of them equivalent."""
    found: dict[tuple[int, ...], tuple[int, ...]] = {}
    for others in combinations(KINDS[1:], count - 1):
        one = (KINDS[0], *others)
        named = {tuple(sorted(_kind(names @ ROTATIONS[kind]) for kind in one)) for names in ROTATIONS}
        found.setdefault(min(named), one)
    return list(found.values())


def mountings(kinds: tuple[int, ...]) -> tuple[Mounting, ...]:
    """The mountings of a schedule, numbered from 1."""
    return tuple(
        Mounting(number, tuple(tuple((row + 0.0).tolist()) for row in ROTATIONS[kind]))
        for number, kind in enumerate(kinds, 1)
    )


ESTIMATORS = (*EXTENDABLE, INCLINED)
_ATTITUDES = 400  # a worst u(|a|) at one of these is short of the true one by a percent or two
_SENSITIVITY = 1e-3  # g: with less, per square root of the positions, a coefficient is not identified
_UNKNOWN_G = 1e3  # prior of a coefficient, in parts of max|K|: what a subset cannot identify is this far off


class NormSpread:
    """The candidates are the fit positions of `schedule`, for the case's stand and nominal block. The closed form
    `inclined` needs all of them: of subsets it knows nothing."""

    def __init__(self, case: Case, schedule: Schedule, estimator: str):
        if estimator not in ESTIMATORS:
            raise UsageError(f"--estimator: schedules are searched for {' or '.join(ESTIMATORS)}, not {estimator}")
        k, count = case.nominal_k(), len(schedule.positions)
        self.estimator, self.schedule, self.k = estimator, schedule, k
        one_sample = replace(case.stand, samples=1)
        self.noise = mean_sigma(k, one_sample, case.step_v, 1)[0] ** 2
        self.rounding = by_channel(case.stand.rounding) ** 2
        names = [name for name in declared(one_sample, schedule) if name != NOISE]
        if estimator == OPTIMAL:
            names += free(one_sample, schedule)
        found = of_stand(schedule, k, one_sample, names)
        sigmas = Errors(schedule, found).sigma
        errors = np.concatenate([one.derivative for one in found.values()]) * sigmas[:, None, None]
        shared = (np.abs(errors).max(axis=2) > 0.0).sum(axis=1) > 1
        self.shared = np.moveaxis(errors[shared], 0, 2)
        self.local = np.einsum("dpi,dpj->pij", errors[~shared], errors[~shared])
        force, self.terms = ideal_force(schedule), case.terms
        further, force = columns_at(force, case.terms), np.column_stack([force, np.ones(count)])
        own = np.einsum("tipi->ipt", further.reshape(-1, 3, count, 3))  # of no term but its own does a channel feel any
        self.felt = np.concatenate([np.broadcast_to(force, (3, count, 4)), own], axis=2)
        self.weak = (_UNKNOWN_G * np.abs(k).max()) ** -2
        self.gradient = norm_gradient(k, spread_attitudes(_ATTITUDES), case.terms)
        self.gains = inclined.gains(schedule, k, case.stand.weights) if estimator == INCLINED else None

    def worst(self, chosen: Flags, samples: int) -> Floats:
        """The worst u(|a|), g, of every subset at some attitudes: `chosen` (subsets, candidates), `samples` at each
        position."""
        variances = ((self.gradient @ self._covariances(chosen, samples)) * self.gradient).sum(axis=2)
        u: Floats = np.sqrt(variances.max(axis=1))
        return u

    def exact(self, chosen: Flags, samples: int) -> float:
        """The worst u(|a|), g, of one subset (candidates,) at any attitude."""
        return worst_norm(self.k, self._covariances(chosen[None], samples)[0], self.terms).worst_g

    def _covariances(self, chosen: Flags, samples: int) -> Floats:
        """Of the unknowns (subsets, n, n): K row by row, U0, sizes by term and channel."""
        noise = self.local + np.diag(self.noise / samples)
        if self.gains is not None:
            assert chosen.all()
            return np.repeat(self._inclined(self.gains, noise)[None], len(chosen), axis=0)
        found = (self._optimal if self.estimator == OPTIMAL else self._least_squares)(chosen, noise)
        rows = np.arange(found.shape[1]).reshape(3, -1)
        order = np.concatenate([rows[:, :3].ravel(), rows[:, 3:].T.ravel()])
        return found[:, order[:, None], order]

    def _inclined(self, gains: Floats, noise: Floats) -> Floats:
        """Of K row by row, and U0; of all candidates."""
        by_position = gains.reshape(len(gains), -1, 3)
        noise = noise + np.diag(self.rounding)
        by_local = np.einsum("rpi,spj,pij->rs", by_position, by_position, noise, optimize=True)
        by_shared = gains @ self.shared.reshape(gains.shape[1], -1)
        found: Floats = by_local + by_shared @ by_shared.T
        return found

    def _optimal(self, chosen: Flags, noise: Floats) -> Floats:
        """Channel by channel: unknowns are those of the model, and the shared errors over their sigma."""
        positions, count = self.felt.shape[1:]
        design = np.einsum("ipr,ij->pijr", self.felt, np.eye(3)).reshape(positions, 3, 3 * count)
        model = np.concatenate([design, self.shared], axis=2)
        weighted = np.linalg.solve(noise, model)
        each = np.swapaxes(model, 1, 2) @ weighted
        total = np.tensordot(chosen.astype(float), each, axes=1)
        prior = np.r_[np.full(3 * count, self.weak), np.ones(model.shape[2] - 3 * count)]
        scale = np.sqrt(total.diagonal(axis1=1, axis2=2) + prior)
        total = (total + np.diag(prior)) / scale[:, :, None] / scale[:, None, :]
        try:
            inverse = np.linalg.inv(total) / scale[:, :, None] / scale[:, None, :]
        except np.linalg.LinAlgError:
            raise UsageError(UNEQUAL) from None
        if self.rounding.any():  # weights, as those of a solve, do not know it
            unweighted = np.swapaxes(weighted, 1, 2) @ (self.rounding[:, None] * weighted)
            inverse = inverse + inverse @ np.tensordot(chosen.astype(float), unweighted, axes=1) @ inverse
        found: Floats = inverse[:, : 3 * count, : 3 * count]
        if not (found.diagonal(axis1=1, axis2=2) > 0.0).all():
            raise UsageError(UNEQUAL)
        return found

    def _least_squares(self, chosen: Flags, noise: Floats) -> Floats:
        """Likewise."""
        count = self.felt.shape[2]
        weighted = chosen[:, None, :, None] * self.felt
        normal = np.swapaxes(weighted, 2, 3) @ self.felt
        lost = np.linalg.eigvalsh(normal)[..., 0] <= _SENSITIVITY**2 * chosen.sum(axis=1)[:, None]
        gains = weighted @ np.linalg.inv(np.where(lost[..., None, None], np.eye(count), normal))
        gains[lost] *= _UNKNOWN_G / self.noise.min() ** 0.5  # far off too
        by_shared = np.einsum("bipr,pid->bird", gains, self.shared, optimize=True).reshape(len(chosen), 3 * count, -1)
        noise = noise + np.diag(self.rounding)
        by_local = np.einsum("bipr,bjps,pij->birjs", gains, gains, noise, optimize=True)
        found: Floats = by_local.reshape(len(chosen), 3 * count, 3 * count) + by_shared @ np.swapaxes(by_shared, 1, 2)
        return found


_FEWEST_POSITIONS = 6  # so that six residuals are left to check the model with
_ALL_SETS = 3  # of so many mountings; more are added one by one


def fewest_samples(spread: NormSpread, chosen: Flags, norm_g: float) -> int | None:
    """The fewest samples with which a subset has no worse u(|a|) at any attitude; None if none do."""
    least = fewest_at_some(spread, chosen, norm_g)
    return None if least is None else _fewest(lambda samples: spread.exact(chosen, samples) <= norm_g, least)


def fewest_at_some(spread: NormSpread, chosen: Flags, norm_g: float) -> int | None:
    """The same at some attitudes, much faster: never more, and few less."""
    return _fewest(lambda samples: bool(spread.worst(chosen[None], samples)[0] <= norm_g), 1)


def _fewest(reached: Callable[[int], bool], least: int) -> int | None:
    """The fewest samples from `least` on; None if not even the most suffice."""
    if not reached(MAX_SAMPLES):
        return None
    low, high, step = least - 1, least, 1
    while not reached(high):
        low, high, step = high, min(high + step, MAX_SAMPLES), 2 * step
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if reached(middle) else (middle, high)
    return high


@dataclass(frozen=True)
class _Candidates:
    """All angles in a set of mountings."""

    spread: NormSpread
    pace: Pace
    norm_g: float

    def timed(self, chosen: Flags) -> Timed | None:
        """What a subset takes; None if it cannot do it, or has too many positions to be measured."""
        samples = fewest_at_some(self.spread, chosen, self.norm_g)
        return None if samples is None else _part(self.spread.schedule, chosen, samples, self.norm_g, self.pace)

    def quickest(self) -> tuple[Timed | None, Flags]:
        """By leaving out, then by exchange; and which positions it has."""
        one = np.eye(len(self.spread.schedule.positions), dtype=bool)
        best, chosen = None, np.ones(len(one), dtype=bool)
        left, fewest = chosen, _FEWEST_POSITIONS + len(self.spread.terms)
        while left.sum() >= fewest and (found := self.timed(left)) is not None:
            if left.sum() <= MAX_POSITIONS and (best is None or found.duration.total < best.duration.total):
                best, chosen = found, left
            fewer = left & ~one[left]
            left = fewer[self.spread.worst(fewer, found.samples).argmin()]
        while best is not None:
            ways = product(np.flatnonzero(chosen), np.flatnonzero(~chosen))
            swaps = np.array([(chosen & ~one[out]) | one[into] for out, into in ways])
            tried = swaps[self.spread.worst(swaps, best.samples).argmin()] if len(swaps) else chosen
            swapped = self.timed(tried)
            if swapped is None or swapped.duration.total >= best.duration.total:
                break
            best, chosen = swapped, tried
        return best, chosen


def _part(everything: Schedule, chosen: Flags, samples: int, norm_g: float, pace: Pace) -> Timed:
    """A subset of the positions with the mountings it uses, both numbered from 1."""
    part = everything.part(chosen)
    used = part.fitted_mountings
    places = {mounting.number: number for number, mounting in enumerate(used, 1)}
    counts = dict.fromkeys(places, 0)
    positions = []
    for position in part.positions:
        counts[position.mounting] += 1
        positions.append(Position(places[position.mounting], counts[position.mounting], position.angle_deg))
    renamed = tuple(replace(mounting, number=places[mounting.number]) for mounting in used)
    return pace.timed(Schedule(renamed, tuple(positions)), samples, norm_g)


@dataclass(frozen=True)
class _OfSet:
    """A job: find the quickest schedule of a set of mountings."""

    case: Case
    estimator: str
    norm_g: float
    pace: Pace
    step_deg: float

    def __call__(self, kinds: tuple[int, ...]) -> Result:
        spread = NormSpread(self.case, self._all(kinds), self.estimator)
        best, chosen = _Candidates(spread, self.pace, self.norm_g).quickest()
        return {
            "positions": np.flatnonzero(chosen if best is not None else []),
            "samples": np.array([] if best is None else [best.samples], dtype=int),
        }

    def timed(self, kinds: tuple[int, ...], result: Result) -> Timed | None:
        """What a call has found, None for nothing."""
        if not len(result["samples"]):
            return None
        everything = self._all(kinds)
        chosen = np.isin(np.arange(len(everything.positions)), result["positions"])
        return _part(everything, chosen, int(result["samples"][0]), self.norm_g, self.pace)

    def _all(self, kinds: tuple[int, ...]) -> Schedule:
        angles = [index * self.step_deg for index in range(round(360.0 / self.step_deg))]
        block = mountings(kinds)
        positions = tuple(Position(one.number, index, angle) for one in block for index, angle in enumerate(angles, 1))
        return Schedule(block, positions)


def quickest(
    case: Case,
    estimator: str,
    norm_g: float,
    pace: Pace,
    step_deg: float,
    most_mountings: int,
    progress: Callable[..., None] = lambda done, of: None,
    team: Team = ALONE,
) -> Timed | None:
    """The quickest schedule of at most so many mountings, with table angles of multiples of `step_deg`; None if there
    is none, whatever the `team`. `progress`: how many sets of mountings more are done, and of how many all in all, as
    far as it is known."""
    job, rounds = _OfSet(case, estimator, norm_g, pace, step_deg), range(2, most_mountings + 1)
    known = [mounting_sets(count) for count in rounds if count <= _ALL_SETS]
    best: Timed | None = None
    best_kinds, of = known[0][0], 0

    def takes_longer(kinds: tuple[int, ...]) -> bool:
        """Do the mountings of a set alone take as long as the best?"""
        return best is not None and pace.remounting * (len(kinds) - 1) >= best.duration.total

    def hopeful(sets: list[tuple[int, ...]], asked: list[tuple[int, ...]], done: Progress) -> Iterator[Piece]:
        for kinds in sets:
            if takes_longer(kinds):
                done(1)
            else:
                asked.append(kinds)
                yield Piece(f"{norm_g!r} {kinds}", kinds)

    for count in rounds:
        one_more = [(*best_kinds, kind) for kind in KINDS if kind not in best_kinds]
        sets, asked = known[count - 2] if count <= _ALL_SETS else one_more, list[tuple[int, ...]]()
        of += len(sets)
        done = partial(progress, of=of)
        for place, result in enumerate(over(hopeful(sets, asked, done), job, team, done)):
            if takes_longer(asked[place]):  # whoever works ahead may do more of them, to no effect
                continue
            found = job.timed(asked[place], result)
            if found is not None and (best is None or found.duration.total < best.duration.total):
                best, best_kinds = found, asked[place]
    return best


STEEP_DEG = (15.0, 30.0, 45.0, 60.0)  # of both sides
ABOUT_DEG = 3.0  # what people who are told to incline a stand to about so many degrees stay below them
_COVERED = 3.0  # sigmas of an inclination that is declared
_WORTH_TELLING_DEG = 0.1
_FEWEST_ANGLES = 3  # at every inclination


def inclined_schedules(step_deg: float, steepest_deg: float, closed: bool) -> Iterator[Schedule]:
    """Of one bolting, with the paper's first mounting: level and inclined to both sides, no more than `steepest_deg`,
    and if `closed` also back to the level. Table angles are multiples of `step_deg` that divide a turn equally."""
    matrix, steps = mountings(KINDS[:1])[0].matrix, round(360.0 / step_deg)
    ways = product((tilt for tilt in STEEP_DEG if tilt <= steepest_deg), (False, True) if closed else (False,))
    for tilt, closes in ways:
        tilts = (0.0, tilt, -tilt, 0.0) if closes else (0.0, tilt, -tilt)
        block = tuple(Mounting(number, matrix, one, 1) for number, one in enumerate(tilts, 1))
        for count in range(_FEWEST_ANGLES, MAX_POSITIONS // len(block) + 1):
            for first in range(steps // count if steps % count == 0 else 0):
                angles = [first * step_deg + 360.0 / count * place for place in range(count)]
                yield Schedule(block, tuple(Position(m.number, n, a) for m in block for n, a in enumerate(angles, 1)))


def quickest_inclined(
    case: Case, estimator: str, norm_g: float, pace: Pace, step_deg: float, steepest_deg: float
) -> Timed | None:
    """The quickest of these that reaches a worst u(|a|); None if none does."""
    closed = case.stand.declares_drift or DRIFT in case.terms
    tried = (held_to(case, estimator, one, norm_g, pace) for one in inclined_schedules(step_deg, steepest_deg, closed))
    return min(filter(None, tried), key=lambda one: one.duration.total, default=None)


def less_steep(case: Case, schedule: Schedule) -> float:
    """How many degrees nearer to the level than they should be the inclinations of a limit's schedule may be."""
    declared_deg = math.degrees(case.stand.sigma("inclination"))
    return min(ABOUT_DEG, _COVERED * declared_deg) if schedule.is_inclined else 0.0


def _inclined_less(schedule: Schedule, degrees: float) -> Schedule:
    less = degrees * np.sign([one.tilt_deg for one in schedule.mountings])
    nearer = (replace(one, tilt_deg=one.tilt_deg - each) for one, each in zip(schedule.mountings, less.tolist()))
    return replace(schedule, mountings=tuple(nearer))


def held_to(case: Case, estimator: str, schedule: Schedule, norm_g: float, pace: Pace) -> Timed | None:
    """The time that a given schedule takes; None if it does not reach the goal."""
    if not _can_tell(case, estimator, schedule):
        return None
    spread = NormSpread(case, schedule.fitted, estimator)
    samples = fewest_samples(spread, np.ones(len(schedule.fit_indices), dtype=bool), norm_g)
    return None if samples is None else pace.timed(schedule, samples, norm_g)


def _can_tell(case: Case, estimator: str, schedule: Schedule) -> bool:
    """Whether the run determines the case's extended terms, if any."""
    return not case.terms or (estimator in EXTENDABLE and confused(schedule, case.terms) is None)


def _measured_with(case: Case, schedule: Schedule, samples: int) -> Case:
    return replace(case, own_schedule=schedule, stand=replace(case.stand, samples=samples))


def worst_norm_of(case: Case, estimator: str) -> WorstNorm:
    """The worst u(|a|) of a case, from the estimator's own gains."""
    k = case.nominal_k()
    return worst_norm(k, error_field(case, estimator, k).covariance, case.terms)


BESIDE = ("paper", "three_mountings", "diagonal", "inclined", "inclined_closed")
_STEPS = 8
_PARTS = (1.0, 0.99, 0.95)  # of the goal to search with: what is found for it by a few attitudes may just miss it


@dataclass(frozen=True)
class Goal:
    """What a schedule is for: `norm_g`, a worst u(|a|), or else the case's limit with a `probability`; the
    `estimator`."""

    norm_g: float | None
    probability: float
    estimator: str

    def estimator_on(self, schedule: Schedule) -> str:
        """`least_squares` takes inclinations for exact; what finds them without the stand is `inclined`."""
        return INCLINED if schedule.is_inclined and self.estimator != OPTIMAL else self.estimator


@dataclass(frozen=True)
class Reach:
    """The schedules to search: table angles that are multiples of `step_deg`, in a limited number of mountings, or in
    one bolting on a stand that inclines to `steepest_deg`, 0: not at all."""

    step_deg: float
    most_mountings: int
    steepest_deg: float


@dataclass(frozen=True)
class Planned:
    """`best`; `other`: the quickest of the other kind, re-mounted or of one bolting; `beside` them built-in ones by
    name; None where a schedule does not get there. Of the best: the worst u(|a|), the promise, what its runs will not
    show, and what further terms of the model cost."""

    case: Case
    goal: Goal
    pace: Pace
    best: Timed
    other: Timed | None
    beside: dict[str, Timed | None]
    u_norm: WorstNorm
    promise: GrowingPromise
    unseen: Reliability
    further: ModelCost | UnsetType = UNSET

    def less_steep(self, one: Timed) -> float:
        """How many degrees nearer to the level its inclinations may be for the limit, 0 where none is asked for."""
        return less_steep(self.case, one.schedule) if self.goal.norm_g is None else 0.0

    @property
    def estimator(self) -> str:
        """For the best."""
        return self.goal.estimator_on(self.best.schedule)


Find = Callable[[float], Timed | None]  # the quickest of a kind that is held to a worst u(|a|), g


def plan_schedule(
    case: Case,
    goal: Goal,
    pace: Pace,
    reach: Reach,
    progress: Callable[..., None],
    team: Team = ALONE,
) -> Planned:
    """Whatever the `team`. `progress` as of `quickest`, of which there may be several. Raises UsageError where no
    schedule gets there."""
    named = {name: built_in(name) for name in BESIDE}
    steep = {name: max(abs(m.tilt_deg) for m in one.mountings) for name, one in named.items()}
    beside = {
        name: reaching(case, goal, one, pace) if steep[name] <= reach.steepest_deg else None
        for name, one in named.items()
    }

    def remounted(norm_g: float) -> Timed | None:
        return quickest(case, goal.estimator, norm_g, pace, reach.step_deg, reach.most_mountings, progress, team)

    def bolted_once(norm_g: float) -> Timed | None:
        estimator = OPTIMAL if goal.estimator == OPTIMAL else INCLINED
        return quickest_inclined(case, estimator, norm_g, pace, reach.step_deg, reach.steepest_deg)

    kinds = []
    for find, inclines in ((remounted, False), (bolted_once, True)):
        known = [one for one in beside.values() if one is not None and one.schedule.is_inclined == inclines]
        kinds.append(_of_kind(case, goal, pace, find, known))
    found = sorted(filter(None, kinds), key=lambda one: one.duration.total)
    if not found:
        wanted = f"{case.limit_g:g} g" if goal.norm_g is None else f"a worst u(|a|) of {goal.norm_g:g} g"
        why = "" if case.rounding_sentence is None else f". {case.rounding_sentence}"
        tried = f"no schedule of at most {reach.most_mountings} mountings"
        tried += f", or inclined to at most {reach.steepest_deg:g} deg," if reach.steepest_deg else ""
        raise UsageError(f"unreachable: {tried} reaches {wanted} here{why}")
    best, other = found[0], found[1] if len(found) > 1 else None
    chosen, estimator = _measured_with(case, best.schedule, best.samples), goal.estimator_on(best.schedule)
    u_norm, promised = worst_norm_of(chosen, estimator), growing_promise(chosen, estimator, goal.probability)
    unseen, further = chosen.reliability(estimator), model_cost_part(model_cost(chosen, estimator))
    return Planned(case, goal, pace, best, other, beside, u_norm, promised, unseen, further)


def _of_kind(case: Case, goal: Goal, pace: Pace, find: Find, known: list[Timed]) -> Timed | None:
    """The quickest schedule of a kind that reaches the goal, None if there is none. `known`: built-in ones that do."""

    def search(norm_g: float) -> Timed | None:
        for part in _PARTS:
            found = find(part * norm_g)
            reached = None if found is None else reaching(case, goal, found.schedule, pace)
            if found is None or reached is not None:
                return reached
        return None

    if goal.norm_g is not None:
        return search(goal.norm_g)
    # the strictest that a built-in one is held to: a limit asks for about the same of all
    best = search(min((one.norm_g for one in known), default=case.limit_g / 3.0))
    again = None if best is None else search(best.norm_g)
    return min(filter(None, (best, again)), key=lambda one: one.duration.total, default=None)


def reaching(case: Case, goal: Goal, schedule: Schedule, pace: Pace) -> Timed | None:
    """A schedule with the fewest samples that reach the goal; None if none do, or it does not tell further terms."""
    estimator = goal.estimator_on(schedule)
    if goal.norm_g is not None:
        return held_to(case, estimator, schedule, goal.norm_g, pace)
    if not _can_tell(case, estimator, schedule):
        return None
    everything = np.ones(len(schedule.fit_indices), dtype=bool)
    about = list(dict.fromkeys((schedule, _inclined_less(schedule, less_steep(case, schedule)))))
    spreads = [NormSpread(case, one.fitted, estimator) for one in about]

    def growth(samples: int) -> float:
        promised = (growing_promise(_measured_with(case, one, samples), estimator, goal.probability) for one in about)
        return min(math.inf if one.growth is None else one.growth for one in promised)

    samples, room = MAX_SAMPLES, growth(MAX_SAMPLES)
    for _ in range(_STEPS if room >= 1.0 else 0):  # a worst u(|a|) as much larger as the errors have room to grow
        before = samples
        norms_g = [float(one.worst(everything[None], samples)[0]) * room for one in spreads]
        samples = max(fewest_at_some(one, everything, each) or MAX_SAMPLES for one, each in zip(spreads, norms_g))
        room = growth(samples)
        if samples == before:
            break
    while room < 1.0 and samples < MAX_SAMPLES:
        samples = min(MAX_SAMPLES, samples + 1 + samples // 100)
        room = growth(samples)
    return pace.timed(schedule, samples, room * spreads[0].exact(everything, samples)) if room >= 1.0 else None


def document(found: Planned, step_deg: float) -> Quickest:
    """The plan for JSON."""
    goal, case, pace = found.goal, found.case, found.pace
    wanted = plan.Goal(goal.norm_g, None, None)
    if goal.norm_g is None:
        wanted = plan.Goal(None, case.limit_g, goal.probability)

    def timed(one: Timed) -> dict[str, Any]:
        return {
            "mountings": len(one.schedule.mountings),
            "positions": len(one.schedule.positions),
            "samples": one.samples,
            "freedom": one.freedom(case.terms),
            "seconds": one.duration.total,
            **{f"{part}_s": seconds for part, seconds in asdict(one.duration).items()},
        }

    def whole(one: Timed) -> plan.FoundSchedule:
        schedule = one.schedule
        return plan.FoundSchedule(
            **timed(one),
            estimator=goal.estimator_on(schedule),
            matrices=tuple(np.array(mounting.matrix) for mounting in schedule.mountings),
            boltings=len(schedule.boltings),
            axis_tilts_deg=tuple(mounting.tilt_deg for mounting in schedule.mountings),
            less_steep_deg=found.less_steep(one),
            angles_deg=tuple(_angles(schedule, mounting) for mounting in schedule.mountings),
        )

    return Quickest(
        stand=case.stand.name,
        block=case.block,
        estimator=found.estimator,
        goal=wanted,
        angles_deg=step_deg,
        pace=plan.Pace(*astuple(pace)),
        schedule=whole(found.best),
        other=None if found.other is None else whole(found.other),
        u_norm_g=found.u_norm,
        promise=found.promise,
        reliability=unseen(found.unseen),
        reliability_norm_g=reliability.largest(found.unseen),
        extended=found.further,
        beside=plan.Beside(
            **{name: None if one is None else plan.Timed(**timed(one)) for name, one in found.beside.items()}
        ),
    )


def _angles(schedule: Schedule, mounting: Mounting) -> tuple[float, ...]:
    return tuple(position.angle_deg for position in schedule.positions if position.mounting == mounting.number)


def show(found: Planned, written: str | None, stand: str | None) -> None:
    """Print the plan on standard output. `written`: the file that it went to; `stand`: that of the stand."""
    out, goal, pace, best = tables.console(), found.goal, found.pace, found.best
    wanted = f"a worst u(|a|) of {1e6 * (goal.norm_g or 0.0):.4g} ug"
    if goal.norm_g is None:
        wanted = f"{found.case.limit_g:g} g with {100 * goal.probability:g} %"
    out.print(tables.heading(f"Quickest schedule found for {wanted}, estimator {found.estimator}"))
    out.print(f"Stand: {found.case.stand.name or 'without a name'}")
    rows = [_row("found", best)]
    if found.other is not None:
        rows.append(_row(_kind_of(found.other), found.other))
    rows += [_row(name, timed) for name, timed in found.beside.items()]
    headings = ("", "positions", "samples", "moving", "settling", "averaging", "in all, s")
    out.print(tables.table(headings, rows))
    out.print(f"positions: in so many mountings, {pace.remounting:g} s for each after the first (--remounting);")
    out.print(f"  or inclinations of one bolting (i), {pace.inclining:g} s likewise (--inclining)")
    _show_needs(out, found, best, "Found")
    if found.other is not None:
        _show_needs(out, found, found.other, "Beside it")
    for mounting in best.schedule.mountings:
        along = [max(range(3), key=lambda axis: abs(row[axis])) for row in mounting.matrix]  # of the table's axes
        axes = [f"{name} {'-' if row[n] < 0 else '+'}{'hnv'[n]}" for name, row, n in zip("xyz", mounting.matrix, along)]
        angles = " ".join(f"{angle:g}" for angle in _angles(best.schedule, mounting))
        out.print(f"Mounting {mounting.number}: {', '.join(axes)} (h across, n along the axis, v up at 0);")
        if best.schedule.is_inclined:
            tilt = f"{mounting.tilt_deg:+g}" if mounting.tilt_deg else "0"
            out.print(f"  bolted on once, inclined to about {tilt} deg;")
        out.print(f"  table at {angles} deg")
    freedom = best.freedom(found.case.terms)
    out.print(f"Worst u(|a|): {1e6 * found.u_norm.worst_g:.4g} ug; {freedom} degrees of freedom check the model")
    if found.further is not UNSET:
        out.print(cost_sentence(found.further))
    if (note := found.case.rounding_sentence) is not None:
        out.print(note)
    out.print(sentence(found.promise))
    for line in reliability.lines(found.unseen):
        out.print(line)
    if written is not None:
        files = shlex.join(["--schedule", written, *([] if stand is None else ["--stand", stand])])
        how = f"--estimator {found.estimator}"
        how += f" --model {','.join(model_of(found.case.terms))}" if found.case.terms else ""
        by_record = not best.schedule.is_inclined or math.isfinite(found.case.stand.inclination)
        solved_after = found.estimator == OPTIMAL and not by_record
        on_bench = f"--estimator {INCLINED} --out run" if solved_after else how
        out.print(f"Run it: tumble bench {files} --samples {best.samples} {on_bench}", soft_wrap=True)
        if solved_after:
            out.print(f"Solve it: tumble solve run/run.csv {files} {how}", soft_wrap=True)


def _kind_of(timed: Timed) -> str:
    return "bolted once" if timed.schedule.is_inclined else "re-mounted"


def _show_needs(out: Console, found: Planned, timed: Timed, which: str) -> None:
    """Print what a schedule requires of a stand besides the declared errors."""
    if timed.schedule.is_inclined:
        steepest = max(mounting.tilt_deg for mounting in timed.schedule.mountings)
        out.print(f"{which}, {_kind_of(timed)}: needs a stand that inclines to {steepest:g} deg and is locked;")
        out.print("  inclinations are not measured, and level and seat need not be good")
        if (less := found.less_steep(timed)) >= _WORTH_TELLING_DEG:
            out.print(f"  with inclinations up to {less:.2g} deg less steep the limit is kept too")
    else:
        out.print(f"{which}, {_kind_of(timed)}: needs seat, level and axis as good as declared")


def _row(name: str, timed: Timed | None) -> tuple[str, ...]:
    if timed is None:
        return (name, *["-"] * 5, "out of reach")
    time = timed.duration
    inclines = " i" if timed.schedule.is_inclined else ""
    positions = f"{len(timed.schedule.positions)} in {len(timed.schedule.mountings)}{inclines}"
    seconds = (time.moving, time.settling, time.averaging, time.total)
    return (name, positions, str(timed.samples), *(f"{part:.1f}" for part in seconds))
