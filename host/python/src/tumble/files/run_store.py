"""The rows of a run, grouped by position, of which few are in memory: a file of the system's holds the others."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from functools import cached_property
from typing import BinaryIO

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput
from tumble.files.disk import reason
from tumble.files.run_facts import PositionFacts, facts_of, in_order, smallest_step_of

ROWS_IN_MEMORY = 1 << 18
_ROWS_FOR_STEP = 20000
_WIDTH = 4  # of a row: three outputs and the number of its line


class RowStore:
    """Rows of `positions` positions. They are added in the order of the file, in parts of any size, and come back
    position by position, in that order. `samples` (positions,): how many of each.

    Beyond `in_memory` rows they are written to a file that nobody else sees and that goes with this object, in the
    folder that TMPDIR names, else in /var/tmp. Raises BadInput, naming the run `name`, where there is no room.
    """

    def __init__(self, positions: int, name: str, in_memory: int = ROWS_IN_MEMORY):
        self.samples = np.zeros(positions, dtype=np.intp)
        self._name, self._most, self._held = name, in_memory, 0
        self._parts: list[list[Floats]] = [[] for _ in range(positions)]
        self._written: list[list[tuple[int, int]]] = [[] for _ in range(positions)]  # where, and how many rows
        self._file: BinaryIO | None = None
        self._some = _EveryNth()

    def add(self, index: Integers, values: Floats) -> None:
        """More rows: the index of the position of each, (rows,), and its outputs and line, (rows, 4)."""
        self._some.add(values)
        counts = np.bincount(index, minlength=len(self.samples))
        grouped = values[np.argsort(index, kind="stable")]
        for position, part in enumerate(np.split(grouped, np.cumsum(counts)[:-1])):
            if len(part):
                self._parts[position].append(part)
        self.samples += counts
        self._held += len(index)
        if self._held > self._most:
            self._write()

    def _write(self) -> None:
        import tempfile

        folder = os.environ.get("TMPDIR") or ("/var/tmp" if os.access("/var/tmp", os.W_OK) else tempfile.gettempdir())
        try:
            self._file = self._file or tempfile.TemporaryFile(dir=folder)  # noqa: SIM115 # it lives as long as its rows
            for position, parts in enumerate(self._parts):
                self._written[position] += [(self._file.tell(), sum(map(len, parts)))] if parts else []
                for part in parts:
                    self._file.write(part.data)
            self._file.flush()
        except OSError as error:
            raise BadInput(f"its rows have no room in {folder} (TMPDIR): {reason(error)}", self._name) from None
        self._parts, self._held = [[] for _ in self._parts], 0

    def on(self, positions: Sequence[int]) -> RowStore:
        """The same rows on a schedule of which they are all: at its position i are those of positions[i]."""
        other = RowStore(len(positions), self._name, self._most)
        other.samples, other._file, other._some = self.samples[list(positions)], self._file, self._some
        other._parts = [self._parts[position] for position in positions]
        other._written = [self._written[position] for position in positions]
        return other

    def rows(self, position: int, most: int | None = None) -> tuple[Floats, Integers]:
        """Of a position: outputs (rows, 3) and numbers of lines (rows,), of all or of so many."""
        values = self._rows(position, most)
        return values[:, :3], values[:, 3].astype(np.intp)

    def _rows(self, position: int, most: int | None = None) -> Floats:
        values, begin = np.empty((int(self.samples[position]), _WIDTH))[:most], 0
        for place, count in self._written[position]:
            assert self._file is not None
            self._file.seek(place)
            self._file.readinto(values[begin : begin + count].data)  # type: ignore[attr-defined]
            begin += count
            if begin >= len(values):
                return values
        for part in self._parts[position]:
            values[begin : begin + len(part)] = part[: len(values) - begin]
            begin += len(part)
        return values

    @cached_property
    def facts(self) -> list[PositionFacts]:
        """What the rows of every position say together."""
        return [facts_of(self._rows(position)) for position in range(len(self.samples))]

    @cached_property
    def step(self) -> Floats:
        """(3,): the smallest difference of two values of a channel, the converter's step where it is coarse, next to
        nothing where it is not; 0 where all are equal. Of many rows some are looked at."""
        return np.array([_smallest_difference(channel) for channel in self._some.outputs.T])


class _EveryNth:
    """Of the rows of a file every n-th, n a power of two: 20,000 to 40,000 of them, or all that there are."""

    def __init__(self) -> None:
        self._kept: list[Floats] = []
        self._count, self._seen, self._stride = 0, 0, 1

    def add(self, values: Floats) -> None:
        some = values[-self._seen % self._stride :: self._stride, :3].copy()
        self._kept.append(some)
        self._seen += len(values)
        self._count += len(some)
        while self._count >= 2 * _ROWS_FOR_STEP:
            self._kept = [self.outputs[::2].copy()]
            self._count, self._stride = len(self._kept[0]), 2 * self._stride

    @property
    def outputs(self) -> Floats:
        return np.concatenate(self._kept) if self._kept else np.zeros((0, 3))


def _smallest_difference(values: Floats) -> float:
    step = smallest_step_of(in_order(values))
    return step if math.isfinite(step) else 0.0
