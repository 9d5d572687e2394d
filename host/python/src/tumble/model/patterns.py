"""What a run that does not fit its stand may show instead: the table of patterns. A pattern is one row of it.

A pattern is what one cause adds to the outputs: columns, each for one unit of the cause's size. A cause at an unknown
place has variants, one for each place. The table knows the schedule, the forces, K and the order of the positions; it
computes no statistics.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.model.geometry import geometry_of, ideal_force
from tumble.schedule import Schedule
from tumble.stand import LARGEST_ERROR_RAD, Stand

BLOCK, STAND, RUN = "block", "stand", "run"  # whose fault it is
_MILLIONTH = 1e-6
_WARM_UPS = (0.05, 0.1, 0.2, 0.4)  # time constants over the length of the run
_MIDDLE = 0.5  # of the run
_ROUNDING = 1e-9
_CHANNELS = "xyz"
_TURNS = {"yaw": "alpha3", "theta_h": "seat_h", "theta_n": "seat_n"}

Columns = dict[str, Floats]  # by label, such as the channel: outputs (positions, 3) for a millionth


@dataclass(frozen=True)
class Scene:
    """The fit positions of a run, in the order in which they were measured, and `k` (3, 3) as found. `attitudes` (n,
    3): a block that is used there, for a pattern that `lasts`."""

    schedule: Schedule
    k: Floats
    attitudes: Floats | None = None

    @property
    def force(self) -> Floats:
        """Specific force on the ideal stand, g: (P, 3)."""
        return ideal_force(self.schedule) if self.attitudes is None else self.attitudes

    @property
    def time(self) -> Floats:
        """From 0 to 1 (P,): positions take equally long."""
        return np.linspace(0.0, 1.0, len(self.schedule.positions))

    def by(self, **error: float | Floats) -> Floats:
        """The outputs' derivatives by an error of the stand, as Geometry.force has it: (P, 3)."""
        return geometry_of(self.schedule).force_by(**error) @ np.asarray(self.k).T

    def by_channel(self, felt: Floats) -> Columns:
        """Columns for a cause that every channel feels by itself, as `felt` (P, 3) in units of its own axis, or (P,)
        alike."""
        shape, sensitivity = felt if felt.ndim > 1 else felt[:, None], np.diag(self.k) * _MILLIONTH
        return {name: shape * sensitivity * np.eye(3)[i] for i, name in enumerate(_CHANNELS)}


def _felt(shapes: Callable[[Scene], list[Floats]]) -> Callable[[Scene], list[Columns]]:
    """Of what every channel feels by itself: one variant for each of the `shapes`, as of Scene.by_channel."""
    return lambda scene: [scene.by_channel(shape) for shape in shapes(scene)]


# What changes within a run counts from its middle: K and U0 are those of the block at that time.


def _settling(scene: Scene) -> list[Floats]:
    return [np.exp(-scene.time / tau) - np.exp(-_MIDDLE / tau) for tau in _WARM_UPS]


def _steps(scene: Scene) -> list[Floats]:
    return [(scene.time >= first) - float(first <= _MIDDLE) for first in scene.time[1:]]


def _half_circles(scene: Scene) -> list[Floats]:
    return [np.where(np.sin(geometry_of(scene.schedule).phi) > -_ROUNDING, 1.0, -1.0)]


def _per_turn(times: int) -> Callable[[Scene], list[Columns]]:
    def columns(scene: Scene) -> list[Columns]:
        turned, by_angle = times * geometry_of(scene.schedule).phi, scene.by(delta=1.0)
        waves = {"sine": np.sin(turned), "cosine": np.cos(turned)}
        return [{name: by_angle * wave[:, None] * _MILLIONTH for name, wave in waves.items()}]

    return columns


def _position(scene: Scene) -> list[Columns]:
    labels = [position.label for position in scene.schedule.positions]
    found = []
    for label, place in zip(labels, np.eye(len(labels))):
        found.append({f"{label} {name}": one for name, one in scene.by_channel(place).items()})
    return found


def _cross_coupling(scene: Scene) -> list[Columns]:
    found = {}
    for i, j in ((i, j) for i in range(3) for j in range(3) if i != j):
        product = scene.force[:, i] * scene.force[:, j]
        found[f"{_CHANNELS[i]}{_CHANNELS[j]}"] = scene.by_channel(product)[_CHANNELS[i]]
    return [found]


def _seat(scene: Scene) -> list[Columns]:
    """Either tilted against the axis in every mounting, or turned about it."""
    changes = {"theta_h": scene.by(seat_h=1.0), "theta_n": scene.by(seat_n=1.0)}
    numbers, mounting = [one.number for one in scene.schedule.mountings], geometry_of(scene.schedule).mounting_index
    inside = {number: (mounting == m).astype(float)[:, None] for m, number in enumerate(numbers)}
    return [
        {f"mounting {number}, {name}": by * here * _MILLIONTH for number, here in inside.items()}
        for name, by in changes.items()
    ]


def _lost_steps(scene: Scene) -> list[Columns]:
    """Counted on from mounting to mounting, or anew in each."""
    moves = np.arange(len(scene.time), dtype=float)
    mounting = geometry_of(scene.schedule).mounting_index
    anew = moves - np.array([moves[mounting == index].min() for index in mounting])
    by_angle = scene.by(delta=1.0)
    return [{"": by_angle * count[:, None] * _MILLIONTH} for count in (moves, anew)]


def _slip(scene: Scene) -> list[Columns]:
    """From a place on, until the block is mounted anew."""
    turns = {name: scene.by(**{error: 1.0}) * _MILLIONTH for name, error in _TURNS.items()}
    mounting = geometry_of(scene.schedule).mounting_index
    places = np.arange(len(mounting))
    found = []
    for first in places[1:][mounting[1:] == mounting[:-1]]:
        after = ((places >= first) & (mounting == mounting[first])).astype(float)[:, None]
        found.append({name: by * after for name, by in turns.items()})
    return found


def _level(scene: Scene) -> list[Columns]:
    return [{"": scene.by(alpha2=1.0)}]


def _yaw_change(scene: Scene) -> list[Columns]:
    first, *others = np.eye(len(scene.schedule.mountings))
    names = [mounting.number for mounting in scene.schedule.mountings]
    return [{f"{names[0]} - {name}": scene.by(alpha3=(first - one) / 2) for name, one in zip(names[1:], others)}]


def _inclination(scene: Scene) -> list[Columns]:
    """Each less the first, which is the tilt of the axis; and likewise the zero of the table angle there."""
    first, *others = scene.schedule.mountings
    own = [(f"{one.number} - {first.number}", error) for one, error in zip(others, np.eye(len(others) + 1)[1:])]
    zeros = {f"{name}, zero": scene.by(seat_n=error) for name, error in own}
    return [{**{name: scene.by(alpha1=error) for name, error in own}, **zeros}]


def _set_angles(scene: Scene) -> list[Columns]:
    positions = scene.schedule.positions
    return [{one.label: scene.by(delta=error) for one, error in zip(positions, np.eye(len(positions)))}]


@dataclass(frozen=True)
class Pattern:
    """`name`; `columns` by variant; `unit` of the size; `largest`: size that such a cause may have, beyond which it is
    another one; `whose` fault it is; `description` for people; `random`: errors that have no shape; `lasts`: a property
    of the block, which its outputs hold at any attitude."""

    name: str
    columns: Callable[[Scene], list[Columns]]
    unit: str
    largest: float
    whose: str
    description: str
    random: bool = False
    lasts: bool = False


# What such causes never exceed: outputs that change by 0.1 g in a run, a block that is off by 5 % at 1 g, and angles at
# which nothing is linear. An error at one position may have any size: a crumb, a wrong file, an exchanged position.

_OUTPUTS, _AT_1_G, _ANGLE, _ANY = 1e5, 5e4, LARGEST_ERROR_RAD, math.inf  # ug, ug or ppm, rad
_MICRO = _ANGLE / _MILLIONTH

PATTERNS = (
    Pattern("drift", _felt(lambda s: [s.time - _MIDDLE]), "ug", _OUTPUTS, RUN, "a drift of the outputs over the run"),
    Pattern("drift_exp", _felt(_settling), "ug", _OUTPUTS, RUN, "an exponential settling of the outputs"),
    Pattern("step", _felt(_steps), "ug", _OUTPUTS, RUN, "a step of the outputs within the run"),
    Pattern(
        "k2", _felt(lambda s: [s.force**2]), "ug/g^2", _AT_1_G, BLOCK, "a second-order term of the block", lasts=True
    ),
    Pattern(
        "k3", _felt(lambda s: [s.force**3]), "ug/g^3", _AT_1_G, BLOCK, "a third-order term of the block", lasts=True
    ),
    Pattern(
        "asymmetry", _felt(lambda s: [abs(s.force)]), "ug/g", _AT_1_G, BLOCK, "a scale that differs by sign", lasts=True
    ),
    Pattern(
        "cross_coupling",
        _cross_coupling,
        "ug/g^2",
        _AT_1_G,
        BLOCK,
        "a product of two axes in the block's outputs",
        lasts=True,
    ),
    Pattern("hysteresis", _felt(_half_circles), "ug", _OUTPUTS, BLOCK, "hysteresis"),
    Pattern("once_per_turn", _per_turn(1), "urad", _MICRO, STAND, "an error of the table angle once per turn"),
    Pattern("twice_per_turn", _per_turn(2), "urad", _MICRO, STAND, "an error of the table angle twice per turn"),
    Pattern("lost_steps", _lost_steps, "urad", _MICRO, STAND, "a loss of angle in every move of the table"),
    Pattern("seat", _seat, "urad", _MICRO, STAND, "a tilt of the mountings on the platform"),
    Pattern("slip", _slip, "urad", _MICRO, STAND, "a movement of the block within a mounting"),
    Pattern(
        "scale_drift", _felt(lambda s: [s.force * (s.time[:, None] - _MIDDLE)]), "ppm", _AT_1_G, RUN, "a scale drift"
    ),
    Pattern("position", _position, "ug", _ANY, RUN, "an error at one position"),
    Pattern("alpha1_rad", lambda s: [{"": s.by(alpha1=1.0)}], "rad", _ANGLE, STAND, "an axis tilt beyond the declared"),
    Pattern("alpha2_plus_alpha3_rad", _level, "rad", _ANGLE, STAND, "a level or yaw beyond the declared"),
    Pattern("alpha3_difference_rad", _yaw_change, "rad", _ANGLE, STAND, "a yaw change beyond the declared"),
    Pattern("alpha4_rad", _set_angles, "rad", _ANGLE, STAND, "an error of set angles beyond the declared", random=True),
)
INCLINATION = Pattern("inclination_rad", _inclination, "rad", _ANGLE, STAND, "an inclination beyond the declared")
BY_NAME = {pattern.name: pattern for pattern in (*PATTERNS, INCLINATION)}


def patterns_of(schedule: Schedule, stand: Stand) -> tuple[Pattern, ...]:
    """Those that a run on a stand may show: of inclinations only where they are declared."""
    declares = schedule.is_inclined and math.isfinite(stand.inclination)
    return (*PATTERNS, INCLINATION) if declares else PATTERNS
