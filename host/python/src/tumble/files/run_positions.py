"""Which position of the schedule a row belongs to, by the numbers of its mounting and position."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.files.csv_rows import Refused
from tumble.schedule import Schedule

NUMBERS = 256  # of mountings and of positions: 0 to 255


class PositionIndex:
    """From mounting and position numbers to the index of a position in the schedule; `table` (256, 256), -1: none."""

    def __init__(self, schedule: Schedule):
        self.mountings = {mounting.number for mounting in schedule.mountings}
        self.table = np.full((NUMBERS, NUMBERS), -1, dtype=np.int32)
        for index, position in enumerate(schedule.positions):
            self.table[position.mounting, position.number] = index

    def of_arrays(self, mountings: Floats, positions: Floats) -> Integers:
        """Indices of many rows; -1 where a number is not whole or the schedule does not have it."""
        known = (mountings >= 0) & (mountings < NUMBERS) & (positions >= 0) & (positions < NUMBERS)
        known &= (mountings == np.floor(mountings)) & (positions == np.floor(positions))
        rows = np.where(known, mountings, 0).astype(np.intp)
        return np.where(known, self.table[rows, np.where(known, positions, 0).astype(np.intp)], -1)

    def of_row(self, mounting: float, position: float) -> int:
        """Index of one row. Raises Refused, saying what the schedule does not have."""
        for column, number in (("mounting", mounting), ("position", position)):
            if number != math.floor(number):
                raise Refused(f"{number!r} is not a whole number", column)
        if mounting not in self.mountings:
            hint = self._are_exchanged(mounting, position) or f"mountings are {listed(self.mountings)}"
            raise Refused(f"the schedule has no mounting {mounting:.15g}; {hint}", "mounting")
        index = int(self.table[int(mounting), int(position)]) if 0 <= position < NUMBERS else -1
        if index < 0:
            missing = f"the schedule has no position {position:.15g} in mounting {mounting:.15g}"
            known = np.flatnonzero(self.table[int(mounting)] >= 0).tolist()
            raise Refused(f"{missing}; positions are {listed(known)}", "position")
        return index

    def _are_exchanged(self, mounting: float, position: float) -> str | None:
        """A question, where the row would be good the other way round."""
        known = position in self.mountings and 0 <= mounting < NUMBERS
        is_good = known and self.table[int(position), int(mounting)] >= 0
        asked = "are mounting and position exchanged? Or is it a run of another schedule (--schedule)?"
        return asked if is_good else None


class Anywhere(PositionIndex):
    """For rows whose schedule is not known yet: every number is good; the index is 256 mounting + position."""

    def __init__(self) -> None:
        self.mountings = set(range(NUMBERS))
        self.table = np.arange(NUMBERS**2, dtype=np.int32).reshape(NUMBERS, NUMBERS)


def listed(numbers: Iterable[int]) -> str:
    """As "1 to 9", or all of them where some between are missing."""
    known = sorted(numbers)
    if known and len(known) > 2 and known[-1] - known[0] == len(known) - 1:
        return f"{known[0]} to {known[-1]}"
    return ", ".join(map(str, known)) or "none"
