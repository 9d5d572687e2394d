"""A schedule of test positions as plain data: what the firmware core and its numpy witness are both told.

Nothing is computed here. Both sides turn the degrees and matrices into geometry on their own, so neither can hide the
other's mistake.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

FIT = "fit"
CHECK = "check"

# Built-in schedules: the core and its witness each have their own. --schedule takes these names; a file of the same
# name is given with a path.
BUILT_IN = (
    *("paper", "three_mountings", "diagonal", "diagonal_closed", "hand_laid", "six_faces"),
    *("inclined", "inclined_closed"),
)
ANY_POSE = "any_pose"  # of a run alone: its poses, whose directions nobody knows
WITH_STAND = ("hand_laid", ANY_POSE)  # they bring a stand of their own, for whoever declares none
CLOSED = {"diagonal": "diagonal_closed", "inclined": "inclined_closed"}  # the same, and back where it began


def file_of(name: str | None) -> str | None:
    """The file that --schedule names; None for a built-in schedule."""
    return None if name in (*BUILT_IN, ANY_POSE) else name


@dataclass(frozen=True)
class Mounting:
    """How the block sits on the platform.

    `number` is 1 to 255. `matrix` is 3 x 3, a proper rotation: its rows are the block axes x, y, z in the table frame
    (h horizontal across the axis, n along the axis, v up at table angle 0). `tilt_deg` is the known tilt of the axis
    out of the horizontal, 0 on a level stand. Mountings of one `bolting` (1 to 255) are inclinations of a block that is
    bolted on once; None: it is bolted on for itself. `off_deg`: how far an inclination as a run shows it, and the zero
    of the table angle with it, are from where they were set.
    """

    number: int
    matrix: tuple[tuple[float, ...], ...]
    tilt_deg: float = 0.0
    bolting: int | None = None
    off_deg: tuple[float, float] = (0.0, 0.0)


def mark_of(angle_deg: float) -> float:
    """The mark of the table that an angle is at, deg: 0 to 360, to a millionth."""
    return round(angle_deg % 360.0, 6) % 360.0


@dataclass(frozen=True)
class Position:
    """Where the table stands: `number` (1 to 255, unique within its mounting), `angle_deg`, and `use`.

    `use` is "fit" (measured, used by the estimator, judged) or "check" (measured and judged only).
    """

    mounting: int
    number: int
    angle_deg: float
    use: str = FIT

    @property
    def label(self) -> str:
        """What people call it: mounting and position, as in "2.7"."""
        return f"{self.mounting}.{self.number}"

    @property
    def mark(self) -> float:
        """Of the table, at which it is."""
        return mark_of(self.angle_deg)


@dataclass(frozen=True)
class Schedule:
    """Mountings and positions, in the order in which means and results are listed."""

    mountings: tuple[Mounting, ...]
    positions: tuple[Position, ...]

    @property
    def fitted_mountings(self) -> tuple[Mounting, ...]:
        """The mountings that an estimator hears of: those with fit positions."""
        used = {position.mounting for position in self.positions if position.use == FIT}
        return tuple(mounting for mounting in self.mountings if mounting.number in used)

    @property
    def boltings(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the mountings that are one bolting of the block, by bolting."""
        groups: dict[object, list[int]] = {}
        for index, one in enumerate(self.mountings):
            groups.setdefault(one.bolting or f"of {index}", []).append(index)
        return tuple(map(tuple, groups.values()))

    @property
    def is_inclined(self) -> bool:
        """Is a block inclined as it is bolted on, in two mountings or more?"""
        return len(self.boltings) < len(self.mountings)

    @property
    def is_laid_by_hand(self) -> bool:
        """Is every position a pose of its own, so that no table need turn, and none need be there?"""
        return len({one.mounting for one in self.positions}) == len(self.positions) and not any(
            one.angle_deg for one in self.positions
        )

    @property
    def fit_indices(self) -> list[int]:
        """Indices of the positions that an estimator may use."""
        return [index for index, position in enumerate(self.positions) if position.use == FIT]

    @property
    def fitted(self) -> Schedule:
        """The schedule without its check positions."""
        return Schedule(self.mountings, tuple(position for position in self.positions if position.use == FIT))

    def part(self, measured: Iterable[bool]) -> Schedule:
        """The schedule without the positions that a run does not have."""
        kept = tuple(position for position, is_measured in zip(self.positions, measured) if is_measured)
        return Schedule(self.mountings, kept)
