"""The built-in schedules, from what they mean: which table axis each block axis lies along, and the angles."""

from __future__ import annotations

from tumble.schedule import CHECK, FIT, Mounting, Position, Schedule

_TABLE = {"h": (1.0, 0.0, 0.0), "n": (0.0, 1.0, 0.0), "v": (0.0, 0.0, 1.0), "-h": (-1.0, 0.0, 0.0)}
_AXES = {1: ("h", "n", "v"), 2: ("-h", "v", "n"), 3: ("n", "v", "h")}  # of x, y, z; the paper has the first two
_NINE = {turn: 45.0 * (turn - 1) for turn in range(1, 10)}
_FOUR = {turn: 90.0 * turn - 45.0 for turn in range(1, 5)}
_CLOSED = {**_FOUR, 5: 45.0}  # the last to check only
_FACES = {1: (1, 3, 5, 7), 2: (1, 5)}


def built_in(name: str) -> Schedule:
    """A schedule of tumble.schedule.BUILT_IN."""
    angles = {
        "paper": {1: _NINE, 2: _NINE},
        "three_mountings": {1: _NINE, 2: _NINE, 3: _NINE},
        "diagonal": {1: _FOUR, 2: _FOUR, 3: _FOUR},
        "diagonal_closed": {1: _CLOSED, 2: _CLOSED, 3: _CLOSED},
        "six_faces": {number: {turn: _NINE[turn] for turn in faces} for number, faces in _FACES.items()},
    }[name]
    mountings = tuple(Mounting(number, tuple(_TABLE[axis] for axis in _AXES[number])) for number in angles)
    positions = (
        Position(m, turn, angle, CHECK if turns is _CLOSED and turn == 5 else FIT)
        for m, turns in angles.items()
        for turn, angle in turns.items()
    )
    return Schedule(mountings, tuple(positions))


def paper_schedule() -> Schedule:
    """The paper's schedule: nine positions 45 degrees apart in each of two mountings, the last where the first was.

    Mounting 1 has the block axes (x, y, z) along (h, n, v); mounting 2, turned by 180 degrees about the bisector of y
    and z, along (-h, v, n).
    """
    return built_in("paper")
