"""Where the block's axes point, for somebody in front of the stand: in numbers, in words, and in signs for a terminal.

In front is where the block is: one looks along +n, the axis, at the block and the table behind it. Directions are given
in (right, away, up), a right-handed frame that stays in the room. At table angle 0 on a level stand the table's h, n, v
are right, away and up. A positive angle raises h and tips v to the left: counterclockwise, as seen from the front. The
known tilt of the axis raises its far end. Derived from the specific force of docs/method.md, which these poses give.

An axis within a degree of a direction has its exact word. Any other is described by the angle from the nearest
direction towards the next one, and by the angle out of that plane, if there is one.
"""

from __future__ import annotations

import math
import textwrap

import numpy as np

from tumble.arrays import Floats
from tumble.errors import listed
from tumble.schedule import Mounting, Schedule

RIGHT, AWAY, UP = range(3)
NEAR_DEG = 1.0
WIDTH = 80

# By direction in (right, away, up) and sign. Of two that are equally near the first here counts.
_WORDS = {
    (UP, 1): ("up", "up"),
    (UP, -1): ("down", "down"),
    (RIGHT, 1): ("to the right", "the right"),
    (RIGHT, -1): ("to the left", "the left"),
    (AWAY, -1): ("towards you", "the front"),
    (AWAY, 1): ("away from you", "the back"),
}
_ORDER = (UP, RIGHT, AWAY)
_TIED = 1e-9


def table(angle_deg: float, tilt_deg: float = 0.0) -> Floats:
    """The table's frame: (3, 3), rows h, n, v in (right, away, up)."""
    angle, tilt = math.radians(math.fmod(angle_deg, 360.0)), math.radians(tilt_deg)
    right = np.array([1.0, 0.0, 0.0])
    along = np.array([0.0, math.cos(tilt), math.sin(tilt)])
    across = np.array([0.0, -math.sin(tilt), math.cos(tilt)])  # upwards at a right angle to the axis
    h = math.cos(angle) * right + math.sin(angle) * across
    v = math.cos(angle) * across - math.sin(angle) * right
    return np.array([h, along, v])


def pose(mounting: Mounting, angle_deg: float) -> Floats:
    """The block: (3, 3), rows x, y, z in (right, away, up)."""
    block: Floats = np.array(mounting.matrix) @ table(angle_deg, mounting.tilt_deg)
    return block


def gravity(mounting: Mounting, angle_deg: float) -> Floats:
    """The direction of gravity on the block's axes x, y, z: (3,), of length 1. An accelerometer at rest feels its
    opposite: an axis that points up feels +1 g."""
    return -pose(mounting, angle_deg)[:, UP]


def direction(axis: Floats) -> str:
    """One axis, a unit vector in (right, away, up), such as "up", or "30 deg from up towards the left"."""
    nearest = sorted(_ORDER, key=lambda one: (-round(abs(float(axis[one])) / _TIED), _ORDER.index(one)))
    first, second, third = (float(abs(axis[one])) for one in nearest)
    name, towards, aside = (_WORDS[one, 1 if axis[one] >= 0.0 else -1] for one in nearest)
    if math.hypot(second, third) <= math.sin(math.radians(NEAR_DEG)):
        return name[0]
    turned, lifted = math.degrees(math.atan2(second, first)), math.degrees(math.asin(min(1.0, third)))
    said = [f"{_degrees(turned)} from {name[1]} towards {towards[1]}"]
    said += [f"{_degrees(lifted)} towards {aside[1]}"] if lifted >= 0.05 else []
    return ", ".join(said)


def axes(mounting: Mounting, angle_deg: float) -> list[str]:
    """A line for each of x, y, z at a table angle, such as "x to the right"."""
    return [f"{name} {direction(axis)}" for name, axis in zip("xyz", pose(mounting, angle_deg))]


def face_up(mounting: Mounting, angle_deg: float) -> str:
    """What of the block is up: "face +z", the edge of two faces, the corner of three; and how far it is off."""
    feels = pose(mounting, angle_deg)[:, UP]
    largest = float(np.abs(feels).max())
    shared = np.abs(feels) >= largest - math.sin(math.radians(NEAR_DEG))
    names = [f"{'+' if one >= 0.0 else '-'}{axis}" for axis, one, is_shared in zip("xyz", feels, shared) if is_shared]
    upright = float(np.abs(feels[shared]).sum()) / math.sqrt(len(names))
    off_deg = math.degrees(math.acos(min(1.0, upright)))
    off = f", {_degrees(off_deg)} off" if off_deg > NEAR_DEG else ""
    if len(names) == 1:
        return f"face {names[0]}{off}"
    return f"the {'edge' if len(names) == 2 else 'corner'} of faces {listed(names)}{off}"


def _degrees(angle: float) -> str:
    return f"{angle:.1f}".removesuffix(".0") + " deg"


def line(mounting: Mounting, angle_deg: float) -> str:
    """All of it in one line, such as "x up, y towards you, z to the right; up: face +x"."""
    return f"{', '.join(axes(mounting, angle_deg))}; up: {face_up(mounting, angle_deg)}"


def tilt(mounting: Mounting) -> str:
    """How the axis of the stand is tilted for a mounting; empty where it is level."""
    end = "far" if mounting.tilt_deg > 0.0 else "near"
    return f"axis tilted by {abs(mounting.tilt_deg):g} deg, its {end} end raised" if mounting.tilt_deg else ""


def positions(schedule: Schedule, mounting: Mounting) -> list[str]:
    """A line for each position of a mounting: its number, its table angle, and which face is up there."""
    own = [one for one in schedule.positions if one.mounting == mounting.number]
    rows = [(str(one.number), f"{one.angle_deg:g} deg", face_up(mounting, one.angle_deg)) for one in own]
    wide = [max(map(len, column)) for column in zip(*rows)]
    return [f"  position {number:>{wide[0]}}, {angle:>{wide[1]}}, up: {face}" for number, angle, face in rows]


# On a grid of signs: columns and rows of a step in each of eight directions, from the right over up.
_STEPS = ((1, 0), (2, -1), (0, -1), (-2, -1), (-1, 0), (-2, 1), (0, 1), (2, 1))
_SIGNS = ("-", "/", "|", "\\", "-", "/", "|", "\\")
_HEADS = (">", "/", "^", "\\", "<", "/", "v", "\\")
_LONG, _SHORT = {True: 7, False: 3}, {True: 4, False: 2}  # steps: along a row, or across rows
_COLUMNS, _ROWS = 23, 9
_LEAST = 0.26  # of an axis that is drawn in the plane of the picture: the sine of 15 degrees


def sketch(mounting: Mounting, angle_deg: float) -> list[str]:
    """The block's axes as seen from the front, and in words beside them: lines of at most 80 columns."""
    rows = pose(mounting, angle_deg)
    grid = [[" "] * _COLUMNS for _ in range(_ROWS)]
    arrows: dict[int, tuple[float, str]] = {}
    ends = {}
    for name, axis in zip("xyz", rows):
        length = math.hypot(axis[RIGHT], axis[UP])
        if length < _LEAST:
            ends[name] = "away from you" if axis[AWAY] > 0.0 else "towards you"
            continue
        eighth = round(math.degrees(math.atan2(axis[UP], axis[RIGHT])) / 45.0) % 8
        before = arrows.get(eighth, (0.0, ""))
        arrows[eighth] = max(before[0], length), ",".join(filter(None, (before[1], name)))
    for eighth, (length, names) in arrows.items():
        across, down = _STEPS[eighth]
        steps = (_LONG if length > 0.6 else _SHORT)[down == 0]
        for step in range(1, steps + 1):
            sign = (_HEADS if step == steps else _SIGNS)[eighth]
            grid[_ROWS // 2 + step * down][_COLUMNS // 2 + step * across] = sign
        row, column = _ROWS // 2 + (steps + 1) * down, _COLUMNS // 2 + (steps + 1) * across
        for offset, sign in enumerate(names):
            grid[row][column + (1 if down == 0 and across > 0 else 0) + offset] = sign
    grid[_ROWS // 2][_COLUMNS // 2] = "o"
    said = [f"o: {name} points {where}" for name, where in ends.items()]
    return _beside(grid, [*axes(mounting, angle_deg), f"up: {face_up(mounting, angle_deg)}", *said])


def _beside(grid: list[list[str]], said: list[str]) -> list[str]:
    """The grid without its empty rows, the words to its right."""
    drawn = ["".join(row) for row in grid]
    while not drawn[0].strip():
        drawn.pop(0)
    while not drawn[-1].strip():
        drawn.pop()
    words = [part for one in said for part in textwrap.wrap(one, WIDTH - _COLUMNS - 6, subsequent_indent="  ")]
    height = max(len(drawn), len(words))
    left = drawn + [" " * _COLUMNS] * (height - len(drawn))
    right = [""] * ((height - len(words)) // 2) + words
    right += [""] * (height - len(right))
    return [f"  {picture}    {text}".rstrip() for picture, text in zip(left, right)]
