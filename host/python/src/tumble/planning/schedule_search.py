"""The schedule that reaches a worst u(|a|) in the least test time.

For every set of mountings: from all table angles the one is left out that is needed least, again and again, and each
time the samples are counted that what is left needs. The quickest of all these is then improved by exchanges of one
angle for another, as long as that saves time. It is a search, and proves no optimum; it always finds the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from tumble.arrays import Flags
from tumble.core import MAX_POSITIONS, MAX_SAMPLES
from tumble.model.norm import worst_norm
from tumble.planning.case import Case
from tumble.planning.duration import Duration, Pace
from tumble.planning.error_field import error_field
from tumble.planning.mounting_sets import KINDS, mounting_sets, mountings, without_unused
from tumble.planning.norm_spread import NormSpread
from tumble.schedule import Position, Schedule
from tumble.workers.kept import Result
from tumble.workers.over import ALONE, Piece, Progress, Team, over

_FEWEST_POSITIONS = 6  # so that six residuals are left to check the model with
_ALL_SETS = 3  # of so many mountings; more are added one by one


@dataclass(frozen=True)
class Timed:
    """A schedule that reaches what was asked for: with so many `samples` at each position, `norm_g` the worst u(|a|)
    that it was held to."""

    schedule: Schedule
    samples: int
    norm_g: float
    duration: Duration


def fewest_samples(spread: NormSpread, chosen: Flags, norm_g: float) -> int | None:
    """The fewest samples with which a subset has no worse u(|a|) at any attitude; None if none do."""
    least = fewest_at_some(spread, chosen, norm_g)
    return None if least is None else _fewest(lambda samples: spread.exact(chosen, samples) <= norm_g, least)


def fewest_at_some(spread: NormSpread, chosen: Flags, norm_g: float) -> int | None:
    """The same at some attitudes, much faster: never more, and few less."""
    return _fewest(lambda samples: bool(spread.worst(chosen[None], samples)[0] <= norm_g), 1)


def _fewest(reached: Callable[[int], bool], least: int) -> int | None:
    """From `least` on; None if not even the most suffice."""
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
        best, chosen = self._left_out()
        while best is not None:
            tried = self._swapped(chosen, best.samples)
            found = self.timed(tried)
            if found is None or found.duration.total >= best.duration.total:
                break
            best, chosen = found, tried
        return best, chosen

    def _left_out(self) -> tuple[Timed | None, Flags]:
        chosen = np.ones(len(self.spread.schedule.positions), dtype=bool)
        best, best_chosen, fewest = None, chosen, _FEWEST_POSITIONS + len(self.spread.terms)
        while chosen.sum() >= fewest and (found := self.timed(chosen)) is not None:
            if chosen.sum() <= MAX_POSITIONS and (best is None or found.duration.total < best.duration.total):
                best, best_chosen = found, chosen
            fewer = chosen & ~np.eye(len(chosen), dtype=bool)[chosen]
            chosen = fewer[self.spread.worst(fewer, found.samples).argmin()]
        return best, best_chosen

    def _swapped(self, chosen: Flags, samples: int) -> Flags:
        """The exchange of one position for another that is best for the norm."""
        one = np.eye(len(chosen), dtype=bool)
        swaps = [(chosen & ~one[out]) | one[into] for out in np.flatnonzero(chosen) for into in np.flatnonzero(~chosen)]
        if not swaps:
            return chosen
        best: Flags = swaps[int(self.spread.worst(np.array(swaps), samples).argmin())]
        return best


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
    best, of = _Best(None, known[0][0]), 0
    for count in rounds:
        sets = known[count - 2] if count <= _ALL_SETS else best.with_one_more()
        of += len(sets)
        for kinds, found in job.over(sets, best, team, partial(progress, of=of)):
            if found is not None and (best.timed is None or found.duration.total < best.timed.duration.total):
                best.timed, best.kinds = found, kinds
    return best.timed


@dataclass
class _Best:
    """The quickest so far, and its set of mountings."""

    timed: Timed | None
    kinds: tuple[int, ...]

    def with_one_more(self) -> list[tuple[int, ...]]:
        """Its set with another mounting."""
        return [(*self.kinds, kind) for kind in KINDS if kind not in self.kinds]

    def is_out_of_reach(self, kinds: tuple[int, ...], pace: Pace) -> bool:
        """Do the mountings of a set alone take as long?"""
        return self.timed is not None and pace.remounting * (len(kinds) - 1) >= self.timed.duration.total


@dataclass(frozen=True)
class _OfSet:
    """A job: the quickest of a set of mountings."""

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

    def over(
        self, sets: list[tuple[int, ...]], best: _Best, team: Team, progress: Progress
    ) -> Iterator[tuple[tuple[int, ...], Timed | None]]:
        """What is found for each of the sets, in their order, but for those that their mountings alone make slower than
        the `best` so far: whoever works ahead may do more of them, to no effect."""
        asked = []

        def hopeful() -> Iterator[Piece]:
            for kinds in sets:
                if best.is_out_of_reach(kinds, self.pace):
                    progress(1)
                else:
                    asked.append(kinds)
                    yield Piece(f"{self.norm_g!r} {kinds}", kinds)

        for place, result in enumerate(over(hopeful(), self, team, progress)):
            if not best.is_out_of_reach(asked[place], self.pace):
                yield asked[place], self._timed(asked[place], result)

    def _timed(self, kinds: tuple[int, ...], result: Result) -> Timed | None:
        """None if nothing has been found."""
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


def _part(everything: Schedule, chosen: Flags, samples: int, norm_g: float, pace: Pace) -> Timed:
    schedule = without_unused(everything.part(chosen))
    return Timed(schedule, samples, norm_g, pace.duration(schedule, samples))


def held_to(case: Case, estimator: str, schedule: Schedule, norm_g: float, pace: Pace) -> Timed | None:
    """What a given schedule takes; None if it does not get there."""
    spread = NormSpread(case, schedule, estimator)
    samples = fewest_samples(spread, np.ones(len(schedule.positions), dtype=bool), norm_g)
    return None if samples is None else Timed(schedule, samples, norm_g, pace.duration(schedule, samples))


def measured_with(case: Case, timed: Timed) -> Case:
    """The case with a schedule and its samples."""
    return replace(case, own_schedule=timed.schedule, stand=replace(case.stand, samples=timed.samples))


def worst_norm_of(case: Case, estimator: str) -> tuple[float, list[float]]:
    """The worst u(|a|) of a case, g, and at which attitude, from the estimator's own gains."""
    k = case.nominal_k()
    found = error_field(case, estimator, k).unknowns
    worst = worst_norm(k, found.T @ found, case.terms)
    return worst.worst, worst.attitude.tolist()
