"""The rows of a run: what is kept of them, and what is known of every position.

What the rows of one position say together: all that a run keeps of them.

How the samples of a run move together: differences of the sums of neighbouring blocks, and the steps of values.

Rows of a position are taken for consecutive samples, in the order of the file.

The rows of a run, grouped by position, of which few are in memory: a file of the system's holds the others.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import BinaryIO

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput
from tumble.files.disk import reason

WITHIN_ONE_SIGMA = 0.6827
_FEW_ROWS = 1 << 14  # as many are kept of what is ordered or follows in time
_FEW_SUMMED, _SUMMED_AT_ONCE = 1 << 11, 1 << 16
_TINY = 1e-250  # units of what is larger are no denormal numbers
_SORTED_BY_NUMPY = 1 << 11


@dataclass(frozen=True)
class Channel:
    """One output at one position. `usual`: the scatter by the rows within one sigma, which one wrong row of three does
    not show; 0 of fewer than two. `farthest`: the largest distance from the `median`. `at_ends`: how many rows have the
    smallest and the largest value. `run`: the longest run of equal values, as indices of its first row and the one
    behind its last. `off`: distances from the median in order, the smallest left out; `changes`: between neighbouring
    rows; of both every `stride`-th. `resolution`: the smallest difference of two values, infinite where there is none.
    """

    median: float
    usual: float
    farthest: float
    ends: tuple[float, float]
    at_ends: tuple[int, int]
    run: tuple[int, int]
    off: Floats
    changes: Floats
    resolution: float


@dataclass(frozen=True)
class PositionFacts:
    """Of `samples` rows: `means` (3,) and `scatter` (3,), NaN of no row and of fewer than two; `squares` (lengths, 3),
    see run_blocks; the `channels`, none of no row; `stride` of what they keep; `lines` of the first and the last row,
    and those of each channel's longest run."""

    samples: int
    means: Floats
    scatter: Floats
    squares: Floats
    channels: tuple[Channel, ...]
    stride: int
    lines: tuple[int, int]
    runs: tuple[tuple[int, int], ...]


def facts_of(rows: Floats) -> PositionFacts:
    """Of the rows of a position in the order of the file: three outputs and the number of the line, (rows, 4)."""
    samples, unknown = len(rows), np.full(3, np.nan)
    if samples == 0:
        return PositionFacts(0, unknown, unknown, np.zeros((0, 3)), (), 1, (0, 0), ())
    stride = 1
    while samples > stride * _FEW_ROWS:
        stride *= 2
    sums, channels = zip(*(_sum_and_channel(rows[:, channel].copy(), stride) for channel in range(3)))
    runs = tuple((int(rows[one.run[0], 3]), int(rows[one.run[1] - 1, 3])) for one in channels)
    ends = int(rows[0, 3]), int(rows[-1, 3])
    return PositionFacts(samples, np.array(sums) / samples, *_spread(rows), channels, stride, ends, runs)


def exact_sum(values: Floats) -> float:
    """The sum, rounded once, as math.fsum has it. The upper bits of up to 2^16 values are multiples of one unit, small
    enough for their sum to be exact; what they leave is summed in the same way."""
    if len(values) < _FEW_SUMMED:
        return math.fsum(values.tolist())
    parts: list[float] = []
    for begin in range(0, len(values), _SUMMED_AT_ONCE):
        rest = values[begin : begin + _SUMMED_AT_ONCE]
        while (largest := float(np.abs(rest).max())) > _TINY:
            unit = math.ldexp(1.0, math.frexp(largest)[1] - 36)
            upper = np.rint(rest / unit) * unit
            parts.append(float(upper.sum()))
            rest = rest - upper
        if largest > 0.0:
            parts += rest.tolist()
    return math.fsum(parts)


def _spread(rows: Floats) -> tuple[Floats, Floats]:
    """`scatter` and `squares`."""
    scatter, squares = np.full(3, np.nan), np.zeros((len(rows).bit_length() - 1, 3))
    if len(rows) > 1:
        given, sums = ffi.from_buffer("double[][4]", np.ascontiguousarray(rows)), np.empty((len(rows) // 2, 3))
        lib.rows_scatter(given, len(rows), ffi.from_buffer("double[]", scatter))
        lib.rows_squares(given, len(rows), *(ffi.from_buffer("double[][3]", one) for one in (sums, squares)))
    return scatter, squares


def _sum_and_channel(values: Floats, stride: int) -> tuple[float, Channel]:
    return exact_sum(values), _channel(values, stride)


def _channel(values: Floats, stride: int) -> Channel:
    rows, ordered = len(values), in_order(values)
    median = float(ordered[(rows - 1) // 2] + ordered[rows // 2]) / 2
    off = _distances(ordered, median)
    within = math.floor((rows - 1) * WITHIN_ONE_SIGMA)
    ends = float(ordered[0]), float(ordered[-1])
    at_ends = int(np.searchsorted(ordered, ends[0], "right")), rows - int(np.searchsorted(ordered, ends[1], "left"))
    steps = np.diff(values)
    return Channel(
        median,
        math.sqrt(rows / (rows - 1)) * float(off[within]) if rows > 1 else 0.0,
        float(off[-1]),
        ends,
        at_ends,
        _longest_run(steps),
        off[1::stride].copy(),
        np.abs(steps[::stride]),
        smallest_step_of(ordered),
    )


def in_order(values: Floats) -> Floats:
    """A sorted copy: by digits where there are many, six times as fast as by comparison."""
    if len(values) < _SORTED_BY_NUMPY:
        return np.sort(values)
    ordered = values.copy()
    scratch = np.empty_like(ordered)
    lib.rows_sort(ffi.from_buffer("uint64_t[]", ordered), ffi.from_buffer("uint64_t[]", scratch), len(ordered))
    return ordered


def _distances(ordered: Floats, median: float) -> Floats:
    """From the median, in order: those of the values below and above it are so already, and are merged."""
    off = np.abs(ordered - median)
    below = int(np.searchsorted(ordered, median))
    return np.sort(np.concatenate((off[:below][::-1], off[below:])), kind="stable")


def smallest_step_of(ordered: Floats) -> float:
    """Between two different values, given in order; infinite where there is one value alone."""
    steps = np.diff(ordered)
    return float(steps.min(initial=np.inf, where=steps > 0.0))


def _longest_run(steps: Floats) -> tuple[int, int]:
    """The first of the longest runs of equal values, given the differences of neighbours: its first row, and the one
    behind its last."""
    begins = np.flatnonzero(np.concatenate(([True], steps != 0.0, [True])))
    longest = int(np.diff(begins).argmax())
    return int(begins[longest]), int(begins[longest + 1])


@dataclass(frozen=True)
class Blocks:
    """`squares` (lengths, positions, 3): of blocks of 1, 2, 4, ... samples, the sum over neighbouring pairs of
    (A - B)^2 / 2m, with A and B the sums of m samples each; a position of N samples has N / 2m pairs, rounded down. Of
    white noise each pair's expectation is the variance of a sample, whatever m is. `resolution` (3,): the smallest
    difference between two values of a channel at one position; infinite where there is none."""

    squares: Floats
    resolution: Floats


NO_BLOCKS = Blocks(np.zeros((0, 0, 3)), np.full(3, np.inf))


def blocks_of(positions: Sequence[PositionFacts]) -> Blocks:
    """Of all positions."""
    lengths = max(len(one.squares) for one in positions)
    squares, resolution = np.zeros((lengths, len(positions), 3)), np.full(3, np.inf)
    for index, one in enumerate(positions):
        squares[: len(one.squares), index] = one.squares
        resolution = np.minimum(resolution, [channel.resolution for channel in one.channels] or np.inf)
    return Blocks(squares, resolution)


def smallest_step(values: Floats) -> float:
    """Between two values of a channel: the converter's, where it is coarse; infinite where there is one value alone."""
    return smallest_step_of(np.sort(values))


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
