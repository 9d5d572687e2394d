"""What the rows of one position say together: all that a run keeps of them."""

from __future__ import annotations

import math

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Floats
from tumble.records import dataclass

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
