"""Exact geometry of a single-axis stand: the specific force on the block's axes, with every error of the stand.

The table frame turns with the table: h horizontal across the axis, n along the axis, v up at table angle 0. Errors, in
radians: alpha1 the axis is not level, alpha2 the zero of the table angle, alpha3 the yaw of the block on the platform,
delta the error of one set angle. In units of local g the specific force in the table frame is the unit vector

    f = (cos(t + alpha1) sin p,  sin(t + alpha1),  cos(t + alpha1) cos p),     p = phi + alpha2 + theta_n + delta

with t the known tilt of the axis. A tilt theta_h of the block against the axis turns it about h, n towards v; then a
yaw about v and the mounting's rotation bring it to the block. theta_h and theta_n are the seat of a mounting.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from tumble.arrays import Floats
from tumble.schedule import CHECK, FIT, Mounting, Position, Schedule

Error = complex | Floats | NDArray[np.complex128]
STEP = (
    2.0**-100
)  # a complex step has no cancellation, so it may be as small as one likes; of a power of two no rounding

# The built-in schedules, from what they mean: which table axis each block axis lies along, and the angles.
_TABLE = {"h": (1.0, 0.0, 0.0), "n": (0.0, 1.0, 0.0), "v": (0.0, 0.0, 1.0)}
_TABLE |= {f"-{name}": (0.0 - h, 0.0 - n, 0.0 - v) for name, (h, n, v) in _TABLE.items()}
_AXES = {1: ("h", "n", "v"), 2: ("-h", "v", "n"), 3: ("n", "v", "h")}  # of x, y, z; the paper has the first two
_NINE = {turn: 45.0 * (turn - 1) for turn in range(1, 10)}
_FOUR = {turn: 90.0 * turn - 45.0 for turn in range(1, 5)}
_CLOSED = {**_FOUR, 5: 45.0}  # the last to check only
_INCLINATIONS = {1: 0.0, 2: 45.0, 3: -45.0, 4: 0.0}  # deg, of a block bolted on once
_FACES = {1: (1, 3, 5, 7), 2: (1, 5)}
_LAID = {  # x, y, z of a block that lies on a face: along h, n, v
    1: ("v", "h", "n"),
    2: ("-v", "-h", "n"),
    3: ("n", "v", "h"),
    4: ("n", "-v", "-h"),
    5: ("h", "n", "v"),
    6: ("h", "-n", "-v"),
}


def built_in(name: str) -> Schedule:
    """A schedule of tumble.schedule.BUILT_IN. The `paper`'s has nine positions 45 degrees apart in each of two
    mountings, the last where the first was: the block axes (x, y, z) along (h, n, v), then, turned by 180 degrees about
    the bisector of y and z, along (-h, v, n)."""
    angles = {
        "paper": {1: _NINE, 2: _NINE},
        "three_mountings": {1: _NINE, 2: _NINE, 3: _NINE},
        "diagonal": {1: _FOUR, 2: _FOUR, 3: _FOUR},
        "diagonal_closed": {1: _CLOSED, 2: _CLOSED, 3: _CLOSED},
        "hand_laid": {number: {1: 0.0} for number in _LAID},
        "six_faces": {number: {turn: _NINE[turn] for turn in faces} for number, faces in _FACES.items()},
        "inclined": dict.fromkeys((1, 2, 3), _NINE),
        "inclined_closed": dict.fromkeys((1, 2, 3, 4), _NINE),
    }[name]
    inclined, axes = name.startswith("inclined"), _LAID if name == "hand_laid" else _AXES
    mountings = tuple(
        Mounting(number, tuple(_TABLE[axis] for axis in _AXES[1]), _INCLINATIONS[number], 1)
        if inclined
        else Mounting(number, tuple(_TABLE[axis] for axis in axes[number]))
        for number in angles
    )
    last = 9 if inclined else 5
    positions = (
        Position(m, turn, angle, CHECK if (inclined or turns is _CLOSED) and turn == last else FIT)
        for m, turns in angles.items()
        for turn, angle in turns.items()
    )
    return Schedule(mountings, tuple(positions))


class Geometry:
    """A schedule's geometry. `force` is analytic in every argument: complex steps through it give derivatives."""

    def __init__(self, schedule: Schedule):
        numbers = [mounting.number for mounting in schedule.mountings]
        self.schedule = schedule
        self.mounting_index = np.array([numbers.index(position.mounting) for position in schedule.positions])
        self._rotation = np.array([mounting.matrix for mounting in schedule.mountings])[self.mounting_index]
        self._tilt = np.deg2rad([schedule.mountings[index].tilt_deg for index in self.mounting_index])
        self.phi = np.deg2rad([position.angle_deg for position in schedule.positions])

    def force(
        self,
        alpha1: Error = 0.0,
        alpha2: Error = 0.0,
        alpha3: Error = 0.0,
        delta: Error = 0.0,
        seat_h: Error = 0.0,
        seat_n: Error = 0.0,
    ) -> Floats:
        """Specific force (g) on the block axes x, y, z: (positions, 3).

        alpha2: scalar; alpha1, alpha3, seat_h, seat_n: one, or one per mounting; delta: one error, or one per
        position. Radians, real or complex. For many runs at once, (..., positions, 3): alpha1 and alpha2 (..., 1),
        those by mounting (..., mountings), delta (..., positions).
        """
        tilt = self._tilt + self._by_mounting(alpha1)
        phi = self.phi + alpha2 + delta + self._by_mounting(seat_n)
        lean, yaw = self._by_mounting(seat_h), self._by_mounting(alpha3)
        h, n, v = np.cos(tilt) * np.sin(phi), np.sin(tilt), np.cos(tilt) * np.cos(phi)
        n, v = n * np.cos(lean) + v * np.sin(lean), v * np.cos(lean) - n * np.sin(lean)
        yawed = np.stack([h * np.cos(yaw) + n * np.sin(yaw), n * np.cos(yaw) - h * np.sin(yaw), v + 0 * yaw], axis=-1)
        force: Floats = np.einsum("pij,...pj->...pi", self._rotation, yawed)
        return force

    def _by_mounting(self, error: Error) -> Floats:
        """One error, or one per mounting, for every position."""
        errors = np.broadcast_to(error, (*np.shape(error)[:-1], len(self.schedule.mountings)))
        by_position: Floats = errors[..., self.mounting_index]
        return by_position

    def outputs(self, k: Floats, u0: Floats, **errors: Error) -> Floats:
        """Outputs U = U0 + K a of a block: (positions, 3). `errors` as in `force`."""
        return self.force(**errors) @ np.asarray(k).T + u0

    def force_by(self, **unit: float | Floats) -> Floats:
        """Derivative of the specific force, g, by errors that grow together, on the ideal stand: (positions, 3). `unit`
        of each, real, as in `force`."""
        force: Floats = np.imag(self.force(**{name: 1j * STEP * np.asarray(one) for name, one in unit.items()})) / STEP
        return force


@lru_cache(64)
def geometry_of(schedule: Schedule) -> Geometry:
    """Its geometry: whoever plans asks for the same one thousands of times."""
    return Geometry(schedule)


@lru_cache(64)
def ideal_force(schedule: Schedule) -> Floats:
    """The specific force at every position without errors (positions, 3), g."""
    force = geometry_of(schedule).force()
    force.setflags(write=False)
    return force
