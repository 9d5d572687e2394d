"""Where a block was at rest, by a statistic of intervals that knows the noise.

The recording is cut into blocks of a quarter of a window, for each channel a mean and a scatter. Four neighbouring
blocks are a window. It is still if no channel scatters within its blocks more than `still` times the noise, and if the
means of its blocks differ by no more than `drift` times what they differ at rest. Noise of samples and noise of block
means are both taken from the recording itself: of all windows, the quietest cluster. So noise that is not white, or
a coarse converter, is no motion. Where steady handling outweighs the rests it is a cluster as well, and theirs is
small: a quieter one, however small, counts if it makes no fewer rests, which windows that are quiet by chance do not.

A rest is a run of still windows. Blocks at its ends that are off its level or scatter, where the table settles,
are left out, and half a window more at each end.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.errors import UsageError
from tumble.files.run_file import smallest_step

_PER_WINDOW = 4  # blocks
FEWEST_IN_BLOCK = 4  # samples: fewer have no scatter to speak of
_FEWEST_BLOCKS = 3  # of a rest
_CLUSTER = 4.0  # a cluster of variances spans this factor: chi-squared of a few degrees of freedom
_PART_OF_DENSEST = 0.4  # of the windows in the densest cluster: fewer may be chance
_PART_IF_LONG = 0.03  # of them, if they make rests: some 1 s for each 30 s of handling
_FEWEST_RESTS = 4  # that do
_NEAR = 3.0  # block noises: a block at an end that is further off the level of its rest is not at rest
_STEPS = 0.5  # noise is no less than this part of the converter's step: the scatter of a value between two


@dataclass(frozen=True)
class Thresholds:
    """What is called a rest. `window_s`, `min_rest_s`: seconds, or without a clock samples are counted instead
    (`window_samples`, `min_rest_samples`; None: what was said counts none). `still`: scatter within a window, in units
    of the noise; `drift`: range of the means of its blocks, in units of their noise."""

    window_s: float = 0.4
    min_rest_s: float = 0.6
    still: float = 2.5
    drift: float = 8.0
    window_samples: int | None = 40
    min_rest_samples: int | None = 60


@dataclass(frozen=True)
class Rests:
    """The table of rests, which everything after works on: rows `begin` to `end` (exclusive) of all recordings
    (rests,); `means`, `errors` (rests, 3): of each channel, the latter the standard error of the mean by the scatter of
    samples or of blocks, whichever is larger, and by rounding. Where rows have labels: the `file` (rests,), from 0,
    and `labels`, a column of texts by name."""

    begin: Integers
    end: Integers
    means: Floats
    errors: Floats
    file: Integers = field(default_factory=lambda: np.zeros(0, dtype=int))
    labels: dict[str, list[str]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.begin)

    @property
    def samples(self) -> Integers:
        """How many rows each has: (rests,)."""
        return self.end - self.begin

    def part(self, kept: Integers) -> Rests:
        """Some of them."""
        labels = {name: [texts[rest] for rest in kept.tolist()] for name, texts in self.labels.items()}
        return Rests(self.begin[kept], self.end[kept], self.means[kept], self.errors[kept], self.file[kept], labels)


@dataclass(frozen=True)
class Found:
    """The rests, in order of time; `noise` (3,): standard deviation of a sample; `rounding` (3,): error of a mean of
    samples that round alike, 0 where noise spreads them; `block`: samples of one."""

    rests: Rests
    noise: Floats
    rounding: Floats
    block: int


@dataclass(frozen=True)
class _Blocks:
    """`begin` (blocks,): first rows; `means`, `variances` (blocks, 3); `part` (blocks,): of which stretch without
    gaps."""

    begin: Integers
    means: Floats
    variances: Floats
    part: Integers
    length: int


def find_rests(outputs: Floats, gaps: Integers, interval_s: float | None, thresholds: Thresholds) -> Found:
    """Rests of `outputs` (rows, 3). `gaps`: rows before which time is missing; `interval_s`: between two rows, None if
    unknown. Raises UsageError for lengths that count no samples then."""
    block, guard, fewest = _lengths(interval_s, thresholds)
    blocks = _blocks(outputs, gaps, block)
    nothing = Found(rests_of(outputs, [], block, np.zeros(3)), np.zeros(3), np.zeros(3), block)
    if len(blocks.begin) < _PER_WINDOW:
        return nothing
    windows = np.lib.stride_tricks.sliding_window_view
    whole = blocks.part[: 1 - _PER_WINDOW] == blocks.part[_PER_WINDOW - 1 :]
    within = windows(blocks.variances, _PER_WINDOW, axis=0).mean(axis=-1)
    means = windows(blocks.means, _PER_WINDOW, axis=0)
    ranges = means.max(axis=-1) - means.min(axis=-1)
    if not whole.any():
        return nothing
    steps = np.array([smallest_step(channel) for channel in outputs.T])

    def of_quietest(share: float) -> Found:
        floor = _STEPS * steps
        scatter = np.sqrt(_quietest(within[whole], share))
        rounding = np.where(scatter < steps / 2, steps / math.sqrt(12.0), 0.0)
        noise = np.maximum(scatter, floor)
        white = noise / math.sqrt(block)
        usual = np.sqrt(_quietest(means.var(axis=-1, ddof=1)[whole], share))
        block_noise = np.maximum(np.minimum(usual, noise), np.maximum(white, floor / 2))
        still = whole & (within <= (thresholds.still * noise) ** 2).all(axis=1)
        still &= (ranges <= thresholds.drift * block_noise).all(axis=1)
        parts = (
            _calm_part(blocks, first, last + _PER_WINDOW, _NEAR * block_noise, noise, guard)
            for first, last in _runs(still)
        )
        spans = [part for part in parts if part is not None and part[1] - part[0] >= fewest]
        return Found(rests_of(outputs, spans, block, rounding), noise, rounding, block)

    found, quieter = of_quietest(_PART_OF_DENSEST), of_quietest(_PART_IF_LONG)
    is_another = (thresholds.still * quieter.noise < found.noise).any()
    return quieter if is_another and len(quieter.rests) >= max(_FEWEST_RESTS, len(found.rests)) else found


def rests_of(outputs: Floats, spans: Sequence[tuple[int, int]], block: int, rounding: Floats) -> Rests:
    """Of rows that are at rest, from one to another (exclusive); `rounding` (3,): error of a mean of samples that round
    alike."""
    means, errors = np.empty((len(spans), 3)), np.empty((len(spans), 3))
    for rest, (begin, end) in enumerate(spans):
        rows = outputs[begin:end]
        error = rows.std(axis=0, ddof=1) / math.sqrt(len(rows)) if len(rows) > 1 else np.zeros(3)
        count = len(rows) // block
        if count >= _FEWEST_BLOCKS:
            spread = rows[: count * block].reshape(count, block, 3).mean(axis=1).std(axis=0, ddof=1)
            error = np.maximum(error, spread / math.sqrt(count))
        means[rest], errors[rest] = rows.mean(axis=0), np.hypot(error, rounding)
    edges = np.array(spans, dtype=int).reshape(-1, 2)
    return Rests(edges[:, 0], edges[:, 1], means, errors)


def _lengths(interval_s: float | None, thresholds: Thresholds) -> tuple[int, int, int]:
    """Samples of a block, blocks to be left out at each end of a rest, and the fewest samples of a rest. Raises
    UsageError."""
    interval, window, rest = interval_s or 1.0, thresholds.window_s, thresholds.min_rest_s
    if interval_s is None:
        for option, told, samples in (
            ("--window", window, thresholds.window_samples),
            ("--min-rest", rest, thresholds.min_rest_samples),
        ):
            if samples is None:
                why = "without a clock it counts samples, a whole number; --rate HZ gives seconds"
                raise UsageError(f"{option} {told:g}: {why}")
        window, rest = float(thresholds.window_samples or 0), float(thresholds.min_rest_samples or 0)
    block = max(round(window / interval / _PER_WINDOW), FEWEST_IN_BLOCK)
    guard = max(round(window / interval / 2 / block), 1)
    return block, guard, max(math.ceil(rest / interval), FEWEST_IN_BLOCK)


def _blocks(outputs: Floats, gaps: Integers, length: int) -> _Blocks:
    """What is left over at the end of a stretch without gaps belongs to no block."""
    edges = [0, *np.asarray(gaps).tolist(), len(outputs)]
    stretches = [(first, (last - first) // length) for first, last in itertools.pairwise(edges)]
    begin = np.concatenate([first + length * np.arange(count) for first, count in stretches]).astype(int)
    part = np.repeat(np.arange(len(stretches)), [count for _, count in stretches])
    grouped = outputs[begin[:, None] + np.arange(length)]
    means: Floats = grouped.mean(axis=1)
    variances: Floats = grouped.var(axis=1, ddof=1)
    return _Blocks(begin, means, variances, part, length)


def _quietest(variances: Floats, share: float) -> Floats:
    """Of each channel the median variance in the quietest cluster of windows (windows, 3) with that `share` of what the
    densest has: rest is one cluster on a scale of factors, motion is spread over many of them."""
    found = []
    for ordered in map(np.sort, variances.T):
        counts = np.searchsorted(ordered, _CLUSTER * ordered, side="right") - np.arange(len(ordered))
        first = int(np.argmax(counts >= share * counts.max()))
        if share < _PART_OF_DENSEST:  # the edge of a cluster: on to where it is densest
            first += int(np.argmax(counts[first : first + counts[first]]))
        found.append(float(np.median(ordered[first : first + counts[first]])))
    return np.array(found)


def _runs(flags: Flags) -> list[tuple[int, int]]:
    """First and last index of each run of true ones."""
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(int))
    return list(zip(np.flatnonzero(edges == 1).tolist(), (np.flatnonzero(edges == -1) - 1).tolist()))


def _calm_part(blocks: _Blocks, first: int, end: int, far: Floats, noise: Floats, guard: int) -> tuple[int, int] | None:
    """Rows of the blocks `first` to `end` (exclusive) without those at the ends that are off their level or scatter
    more than the noise, and `guard` more, in which a table still settles unseen; None: nothing is left."""
    level = np.median(blocks.means[first:end], axis=0)
    calm = (np.abs(blocks.means[first:end] - level) <= far).all(axis=1)
    calm &= (blocks.variances[first:end] <= noise**2 * (1.0 + 3.0 / math.sqrt(blocks.length))).all(axis=1)
    inner = np.flatnonzero(calm)
    if len(inner) < _FEWEST_BLOCKS:
        return None
    begin, last = first + int(inner[0]) + guard, first + int(inner[-1]) - guard
    if last - begin + 1 < _FEWEST_BLOCKS:
        return None
    return int(blocks.begin[begin]), int(blocks.begin[last]) + blocks.length
