"""How long a schedule takes: moves, settling, averaging, and what people need to mount the block anew.

The table comes to every angle from below, as the play of its gear asks for: it turns up through a mounting's angles and
back to the lowest of the next. Homing and the first mounting are the same for all schedules, and not counted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import groupby, pairwise

from tumble.files.stand_file import StandFile
from tumble.schedule import Schedule

DEFAULT_REMOUNT_S = 300.0
_MOTION = {"velocity_deg_per_s": 90.0, "acceleration_deg_per_s2": 180.0, "settling_s": 0.5}
_RATE_HZ = 100.0


@dataclass(frozen=True)
class Duration:
    """Parts of a test, seconds."""

    moving: float
    settling: float
    averaging: float
    remounting: float

    @property
    def total(self) -> float:
        """All of them."""
        return self.moving + self.settling + self.averaging + self.remounting


@dataclass(frozen=True)
class Pace:
    """What a table, a block and people take their time for: deg/s, deg/s^2, s, samples a second, s."""

    velocity: float
    acceleration: float
    settling: float
    rate: float
    remounting: float

    @classmethod
    def of(cls, stand_file: StandFile | None, remount_s: float) -> Pace:
        """As a stand file has it, else that of the simulated stand."""
        motion = {**_MOTION, **((stand_file and stand_file.motion) or {})}
        rate = ((stand_file and stand_file.block) or {}).get("sample_rate_hz") or _RATE_HZ
        velocity, acceleration, settling = (motion[key] for key in _MOTION)
        return cls(velocity, acceleration, settling, rate, remount_s)

    def duration(self, schedule: Schedule, samples: int) -> Duration:
        """Of a schedule whose positions stand mounting by mounting."""
        angles = [0.0, *(position.angle_deg for position in schedule.positions)]
        mountings = len(list(groupby(position.mounting for position in schedule.positions)))
        return Duration(
            moving=sum(self._move(abs(b - a)) for a, b in pairwise(angles)),
            settling=self.settling * len(schedule.positions),
            averaging=samples * len(schedule.positions) / self.rate,
            remounting=self.remounting * (mountings - 1),
        )

    def _move(self, degrees: float) -> float:
        """At rest at both ends, with limited speed and acceleration."""
        ramps = self.velocity**2 / self.acceleration
        if degrees < ramps:
            return 2.0 * math.sqrt(degrees / self.acceleration)
        return degrees / self.velocity + self.velocity / self.acceleration
