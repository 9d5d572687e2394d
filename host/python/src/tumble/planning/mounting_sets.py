"""Ways to mount a block on a table square to its axes, without those that come to the same.

There are 24 proper rotations. Half a turn about the stand's axis is one of the table, so 12 remain. And which of a
block's axes bears which name makes no difference to what several mountings together can tell: of sets that differ by
their names alone one is kept, the one that starts with the first mounting of the paper.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, permutations, product

import numpy as np

from tumble.arrays import Floats
from tumble.schedule import Mounting, Position, Schedule

_HALF_TURN = np.diag([-1.0, 1.0, -1.0])  # about n, in the table frame h, n, v


def _rotations() -> Iterator[Floats]:
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            matrix = np.eye(3)[list(order)] * np.array(signs)[:, None]
            if np.linalg.det(matrix) > 0.0:
                yield matrix


ROTATIONS = sorted(_rotations(), key=lambda matrix: (np.abs(matrix - np.eye(3)).sum(), *matrix.ravel()))


def _kind(matrix: Floats) -> int:
    """Number of the first of ROTATIONS that is the same mounting."""
    alike = (np.array_equal(matrix, one) or np.array_equal(matrix @ _HALF_TURN, one) for one in ROTATIONS)
    return next(number for number, same in enumerate(alike) if same)


KINDS = tuple(sorted({_kind(matrix) for matrix in ROTATIONS}))


def mounting_sets(count: int) -> list[tuple[int, ...]]:
    """Sets of so many of KINDS, no two of which come to the same."""
    found: dict[tuple[int, ...], tuple[int, ...]] = {}
    for others in combinations(KINDS[1:], count - 1):
        one = (KINDS[0], *others)
        named = {tuple(sorted(_kind(names @ ROTATIONS[kind]) for kind in one)) for names in ROTATIONS}
        found.setdefault(min(named), one)
    return list(found.values())


def mountings(kinds: tuple[int, ...]) -> tuple[Mounting, ...]:
    """As a schedule has them, numbered from 1."""
    return tuple(
        Mounting(number, tuple(tuple((row + 0.0).tolist()) for row in ROTATIONS[kind]))
        for number, kind in enumerate(kinds, 1)
    )


def without_unused(schedule: Schedule) -> Schedule:
    """The schedule with the mountings that it uses, both these and its positions numbered from 1."""
    used = schedule.fitted_mountings
    places = {mounting.number: number for number, mounting in enumerate(used, 1)}
    counts = dict.fromkeys(places, 0)
    positions = []
    for position in schedule.positions:
        counts[position.mounting] += 1
        positions.append(Position(places[position.mounting], counts[position.mounting], position.angle_deg))
    renamed = tuple(Mounting(places[mounting.number], mounting.matrix, mounting.tilt_deg) for mounting in used)
    return Schedule(renamed, tuple(positions))
