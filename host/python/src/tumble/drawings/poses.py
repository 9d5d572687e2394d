"""Where the block's axes point, for somebody in front of the stand.

In front is where the block is: one looks along +n, the axis, at the block and the table behind it. Directions are told
in (right, away, up), a right-handed frame that stays in the room. At table angle 0 on a level stand the table's h, n, v
are right, away and up. A positive angle raises h and tips v to the left: counterclockwise, as seen from the front. The
known tilt of the axis raises its far end. Derived from the specific force of docs/method.md, which these poses give.
"""

from __future__ import annotations

import math

import numpy as np

from tumble.arrays import Floats
from tumble.schedule import Mounting

RIGHT, AWAY, UP = range(3)


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
