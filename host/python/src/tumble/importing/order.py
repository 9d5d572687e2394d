"""Which rest is which position, once it is known which attitude each rest has.

In the schedule's order: the longest way through rests and positions that goes forward in both. In any order: the
mountings one after another with as few changes as can be, and positions of one attitude and mounting told apart by the
shortest way of the table. A rest that another assignment, as good, would call otherwise is in doubt.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.schedule import Schedule

SCHEDULE, ANY = "schedule", "any"
NONE = -1
_NEARER = 0.25  # part of a match that nearness is worth, so that it never outweighs one
_MOST_OPEN = 10  # rests whose mounting is open: more are not tried


@dataclass(frozen=True)
class Assigned:
    """`positions` (rests,): index in the schedule, NONE where the rest is none; `doubts`: by rest, the positions that
    it could be as well; `alike`: positions of one attitude in one mounting, which order alone tells apart."""

    positions: Integers
    doubts: dict[int, tuple[int, ...]] = field(default_factory=dict)
    alike: tuple[tuple[int, ...], ...] = ()

    @property
    def matched(self) -> int:
        """How many positions have a rest."""
        return len(set(self.positions.tolist()) - {NONE})


def assign(order: str, nearest: Integers, nearness: Floats, of_position: Integers, schedule: Schedule) -> Assigned:
    """`nearest` (rests,): attitude of each rest, NONE: of no position; `nearness` (rests,), 0 to 1; `of_position`:
    attitude of each position."""
    if order == SCHEDULE:
        return _in_order(nearest, nearness, of_position)
    return _in_any_order(nearest, of_position, schedule)


def _in_order(nearest: Integers, nearness: Floats, of_position: Integers) -> Assigned:
    rests, positions = len(nearest), len(of_position)
    worth = np.where(nearest[:, None] == of_position, 1.0 + _NEARER * nearness[:, None] / max(rests, 1), 0.0)
    ahead, behind = _best_ways(worth), _best_ways(worth[::-1, ::-1])[::-1, ::-1]
    found, doubts = np.full(rests, NONE), {}
    best = ahead[rests, positions]
    rest, position = rests, positions
    while rest and position:
        if worth[rest - 1, position - 1] > 0 and np.isclose(
            ahead[rest, position], ahead[rest - 1, position - 1] + worth[rest - 1, position - 1]
        ):
            rest, position = rest - 1, position - 1
            found[rest] = position
        elif np.isclose(ahead[rest, position], ahead[rest - 1, position]):
            rest -= 1
        else:
            position -= 1
    for rest in np.flatnonzero(found != NONE).tolist():
        through = ahead[rest, :-1] + worth[rest] + behind[rest + 1, 1:]
        others = np.flatnonzero((worth[rest] > 0) & (through > best - 0.5))
        if len(others) > 1:
            doubts[rest] = tuple(map(int, others))
    return Assigned(found, doubts)


def _best_ways(worth: Floats) -> Floats:
    """Best sum over the first r rests and p positions, both in order: (rests + 1, positions + 1)."""
    best = np.zeros((worth.shape[0] + 1, worth.shape[1] + 1))
    for rest, row in enumerate(worth):
        taken = np.maximum(best[rest, 1:], np.where(row > 0, best[rest, :-1] + row, 0.0))
        best[rest + 1, 1:] = np.maximum.accumulate(taken)
    return best


def _in_any_order(nearest: Integers, of_position: Integers, schedule: Schedule) -> Assigned:
    by_attitude = _places(of_position, schedule)
    used = [rest for rest, attitude in enumerate(nearest.tolist()) if attitude != NONE]
    open_to = {rest: sorted(by_attitude[int(nearest[rest])]) for rest in used}
    chosen, doubtful = _mountings(used, open_to, nearest, by_attitude)
    found = np.full(len(nearest), NONE)
    groups: dict[tuple[int, int], list[int]] = {}
    for rest in used:
        groups.setdefault((chosen[rest], int(nearest[rest])), []).append(rest)
    for (mounting, attitude), here in groups.items():
        places = by_attitude[attitude][mounting]
        found[here[: len(places)]] = places[: len(here)]
    alike = []
    for (mounting, attitude), here in groups.items():
        if len(places := by_attitude[attitude][mounting]) > 1:
            alike.append(tuple(places))
            _tell_apart(here, places, [rest for rest in used if chosen[rest] == mounting], found, schedule)
    doubts = {rest: tuple(by_attitude[int(nearest[rest])][m][0] for m in open_to[rest]) for rest in doubtful}
    return Assigned(found, doubts, tuple(sorted(alike)))


def _places(of_position: Integers, schedule: Schedule) -> list[dict[int, list[int]]]:
    """By attitude and mounting: the positions."""
    found: list[dict[int, list[int]]] = [{} for _ in range(int(of_position.max()) + 1)]
    for index, position in enumerate(schedule.positions):
        found[of_position[index]].setdefault(position.mounting, []).append(index)
    return found


def _mountings(
    used: list[int], open_to: dict[int, list[int]], nearest: Integers, by_attitude: list[dict[int, list[int]]]
) -> tuple[dict[int, int], set[int]]:
    """The mounting of each rest, and the rests for which another would do as well: most positions found, then fewest
    changes of mounting."""
    open_rests = [rest for rest in used if len(open_to[rest]) > 1]
    if len(open_rests) > _MOST_OPEN:
        return {rest: open_to[rest][0] for rest in used}, set(open_rests)
    ranked = []
    for choice in itertools.product(*(open_to[rest] for rest in open_rests)):
        mounting = {rest: open_to[rest][0] for rest in used} | dict(zip(open_rests, choice))
        changes = sum(mounting[one] != mounting[other] for one, other in itertools.pairwise(used))
        ranked.append((-_positions_found(mounting, nearest, by_attitude), changes, choice))
    ranked.sort()
    best = [choice for found, changes, choice in ranked if (found, changes) == ranked[0][:2]]
    doubtful = {rest for place, rest in enumerate(open_rests) if len({choice[place] for choice in best}) > 1}
    return {rest: open_to[rest][0] for rest in used} | dict(zip(open_rests, best[0])), doubtful


def _positions_found(mounting: dict[int, int], nearest: Integers, by_attitude: list[dict[int, list[int]]]) -> int:
    counts: dict[tuple[int, int], int] = {}
    for rest, number in mounting.items():
        key = (int(nearest[rest]), number)
        counts[key] = counts.get(key, 0) + 1
    return sum(min(count, len(by_attitude[attitude][number])) for (attitude, number), count in counts.items())


def _tell_apart(here: list[int], places: list[int], block: list[int], found: Integers, schedule: Schedule) -> None:
    """Of positions that share an attitude: those that make the table's way the shortest, else in order of time."""
    count = min(len(here), len(places))
    if count == 0 or len(places) > 4:
        return

    def way(choice: Iterable[int]) -> float:
        tried = found.copy()
        tried[here[:count]] = list(choice)
        angles = [schedule.positions[tried[rest]].angle_deg for rest in block if tried[rest] != NONE]
        return float(np.abs(np.diff(angles)).sum())

    found[here[:count]] = min(itertools.permutations(places, count), key=way)
