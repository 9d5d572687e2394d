"""Rows that are no measurements of their own: written again, or of several sources in turn.

An honest run repeats itself too, where its converter is coarse. So a stretch of equal rows counts only where noise
would have changed it: by the innovations of its noisiest channel, what a linear prediction from the rows before leaves,
so that hum, drift and slow noise are none; and no more than neighbouring rows change, which a sensor may hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tumble.arrays import Flags, Floats, Integers
from tumble.files.run_facts import WITHIN_ONE_SIGMA, in_order

CHANCE = 1e-9  # that an honest run is taken for one with copies
_SHORTEST = 4  # rows of a stretch
_WINDOWS = 1 << 14  # of which the search is made
_NEIGHBOURS = 3
_ORDER = 8  # of the prediction
_FEWEST = 12  # innovations, to know their size
_MOST_INNOVATIONS, MOST_IN_TURN = 20_000, 4096  # rows that are looked at; of a position
_LEAST_NOISE = 1e-6  # of all that a channel spans: no sensor with its converter repeats itself better
_SOURCES = (2, 3, 4)
_FEWEST_IN_TURN = 8  # rows at a position
_TIMES_NOISE = 30.0  # variance of the means of sources, over what noise makes of it; alternating noise makes up to 20
_CLEAR, _LARGE, _OF_POSITIONS = 8.0, 5e-3, 0.75  # times noise, parts of 1 g and of the positions: no vibration
_HELD, _CHANGES = (4, 3, 2), 0.9  # rows of a value; share of the next ones that are other ones
_NUMBERS = {2: "two", 3: "three", 4: "four"}
_STEPS_APART = 3.0  # of a converter: it may alternate by one by itself
_MULTIPLIERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)

Keys = NDArray[np.uint64]


@dataclass(frozen=True)
class Repeat:
    """Rows from `again` on are those from `first` on, `length` of them: indices in the order of the file."""

    first: int
    again: int
    length: int


def copied(outputs: Floats, position: Integers, step: Floats) -> Repeat | None:
    """The longest stretch of rows (rows, 3) that stands there once more and that noise would have changed; None: there
    is none. `position` of each row; `step` (3,) of the values."""
    found = _longest_repeat(outputs)
    if found is None or found.length < _SHORTEST:
        return None
    part = slice(found.first, found.first + found.length)
    changes = np.sqrt(np.mean(np.diff(outputs[part], axis=0) ** 2, axis=0) / 2.0)  # a part may be quiet
    likely = max(
        _held(outputs, position),
        _held(outputs[part], position[part]),
        _chance_of_a_value(changes / np.where(step > 0.0, step, np.inf)),
        _chance_of_a_row(outputs, position, step),
    )
    chance = 2.0 * math.log(len(outputs)) + found.length * math.log(likely)
    return found if chance < math.log(CHANCE) else None


def held(rests: Iterable[Floats]) -> int:
    """How many rows each measurement stands for: 1, or as many as are equal throughout where their neighbours are not:
    written several times one after the other, or held by a sensor that is slower than its log. `rests`: the rows
    (rows, 3) of each position."""
    whole = [rows for rows in rests if len(rows) >= _FEWEST_IN_TURN]
    for times in _HELD if whole else ():
        grouped = [rows[: len(rows) // times * times].reshape(-1, times, 3) for rows in whole]
        if all((group == group[:, :1]).all() for group in grouped):
            changes = [(group[1:, 0] != group[:-1, 0]).any(axis=1) for group in grouped]
            if np.concatenate(changes).mean() >= _CHANGES:
                return times
    return 1


def _longest_repeat(outputs: Floats) -> Repeat | None:
    """By windows of 4, 8, 16, ... rows, as long as any comes again behind its end; then as far as rows are equal. Of
    many windows every n-th or so counts, chosen by what is in it, so that those of a copy are chosen too."""
    bits = [(outputs[:, channel] + 0.0).view(np.uint64) for channel in range(3)]  # of which -0.0 has none
    bits = [one ^ (one >> np.uint64(31)) for one in bits]  # those of round numbers are all in the upper half
    keys = bits[0] * _MULTIPLIERS[0] + bits[1] * _MULTIPLIERS[1] + bits[2] * _MULTIPLIERS[2]
    keys = keys[:-1] * _MULTIPLIERS[1] + keys[1:]
    keys = _mixed(keys[:-2] * _MULTIPLIERS[2] + keys[2:])
    stride = 1 << max(0, len(keys).bit_length() - _WINDOWS.bit_length())
    places = np.flatnonzero((keys & np.uint64(stride - 1)) == 0)
    keys, length, best = keys[places], _SHORTEST if stride == 1 else 1, None
    while len(keys) > 1 and (pair := _equal_apart(keys, length)) is not None:
        best = pair
        keys, length = _mixed(keys[:-length] * _MULTIPLIERS[0] + keys[length:]), 2 * length
    return None if best is None else _extended(outputs, int(places[best[0]]), int(places[best[1]]))


def _mixed(keys: Keys) -> Keys:
    mixed: Keys = (keys ^ (keys >> np.uint64(29))) * _MULTIPLIERS[1]
    return mixed ^ (mixed >> np.uint64(32))


def _equal_apart(keys: Keys, length: int) -> tuple[int, int] | None:
    """Indices of two equal keys that are at least so far apart."""
    ordered = in_order((keys >> np.uint64(2)).view(np.float64)).view(np.uint64)  # so they are numbers that are finite
    equal = ordered[1:][ordered[1:] == ordered[:-1]]
    if not len(equal):
        return None
    places = np.flatnonzero(np.isin(keys >> np.uint64(2), equal))
    places = places[np.argsort(keys[places], kind="stable")]
    first = np.concatenate(([True], np.diff(keys[places].view(np.int64)) != 0))
    begins = places[np.flatnonzero(first)][np.cumsum(first) - 1]
    apart = np.flatnonzero(places - begins >= length)
    return (int(begins[apart[0]]), int(places[apart[0]])) if len(apart) else None


def _extended(outputs: Floats, first: int, again: int) -> Repeat:
    """Backwards and forwards, until rows differ."""
    apart = again - first
    equal: Flags = (outputs[:-apart] == outputs[apart:]).all(axis=1)
    unequal = np.flatnonzero(~equal)
    begin = int(unequal[unequal < first].max(initial=-1)) + 1
    end = int(unequal[unequal >= first].min(initial=len(equal)))
    return Repeat(begin, begin + apart, end - begin)


def _held(outputs: Floats, position: Integers) -> float:
    """The largest share of rows that are equal to the one, two or three rows before."""
    shares = [0.0]
    for apart in range(1, min(_NEIGHBOURS, len(outputs) - 1) + 1):
        beside = position[apart:] == position[:-apart]
        equal = (outputs[apart:] == outputs[:-apart]).all(axis=1) & beside
        shares.append(float(equal.sum() / max(1, beside.sum())))
    return max(shares)


def _chance_of_a_row(outputs: Floats, position: Integers, step: Floats) -> float:
    """That a row comes out as another one did, all before it having done so."""
    steps = _innovations(outputs, position, step)
    if steps is None:
        steps = _LEAST_NOISE * np.ptp(outputs, axis=0) / np.where(step > 0.0, step, np.inf)
    return _chance_of_a_value(steps)


def _chance_of_a_value(steps: Floats) -> float:
    """Of the likeliest in the noisiest channel, by the noise of each in steps."""
    noise = float(steps.max())
    return math.erf(0.5 / (math.sqrt(2.0) * noise)) if noise > 0.0 else 1.0


def _innovations(outputs: Floats, position: Integers, step: Floats) -> Floats | None:
    """Of each channel in steps, without what rounding adds; None where too few rows tell."""
    ends = np.flatnonzero(np.diff(position, append=-1)) + 1
    lengths = np.diff(ends, prepend=0)
    order = min(_ORDER, int(np.median(lengths)) // 4)
    visit = np.repeat(np.arange(len(lengths)), lengths)
    off = outputs - (np.add.reduceat(outputs, ends - lengths) / lengths[:, None])[visit]
    places = np.arange(order, len(off))
    places = places[(visit[places] == visit[places - order]) & (lengths[visit[places]] > 1)][:_MOST_INNOVATIONS]
    if len(places) < _FEWEST + 2 * order:
        return None
    sizes = np.zeros(3)
    for channel in np.flatnonzero(step > 0.0):
        before = off[places[:, None] - np.arange(1, order + 1), channel]
        weights = np.linalg.lstsq(before, off[places, channel], rcond=1e-9)[0]
        left = np.abs(off[places, channel] - before @ weights) / step[channel]
        rounding = (1.0 + float(weights @ weights)) / 12.0
        sizes[channel] = math.sqrt(max(0.0, float(np.quantile(left, WITHIN_ONE_SIGMA)) ** 2 - rounding))
    return sizes


@dataclass(frozen=True)
class Sources:
    """That rows may be of several sources in turn, a `sentence` without its end; `is_certain`: no noise does that."""

    sentence: str
    is_certain: bool


_Parts = tuple[Floats, Floats, int]  # means of the sources (sources, 3), squares within them (3,), rows of each


def in_turn(positions: Iterable[Floats], step: Floats, unit: str) -> Sources | None:
    """What the rows (rows, 3) of each position that has enough, at rest, show of several sources in turn; None where
    noise explains it, or a converter that alternates."""
    long = (rows[:MOST_IN_TURN] for rows in positions if len(rows) >= _FEWEST_IN_TURN)
    by_sources = zip(*([_parts(rows, sources) for sources in _SOURCES] for rows in long))
    ratio, best = max(((_ratio(parts, step), parts) for parts in by_sources), key=lambda one: one[0], default=(0.0, ()))
    if ratio <= _TIMES_NOISE:
        return None
    apart = np.array([_apart(parts, step) for parts in best])
    widths = np.array([np.ptp(parts[0], axis=0) for parts in best])
    scale = np.ptp([parts[0].mean(axis=0) for parts in best], axis=0).max() / 2
    place, channel = np.unravel_index(int(apart.argmax()), apart.shape)
    clear = int(((apart > _CLEAR) & (widths > _LARGE * scale)).any(axis=1).sum())
    levels = [f"{level:.5g}" for level in best[place][0][:, channel].tolist()]
    said = f"rows alternate, u{'xyz'[channel]} between {' and '.join(levels)} {unit}"
    return Sources(f"{said}: {_NUMBERS[len(levels)]} sources in one file", clear >= _OF_POSITIONS * len(best))


def _parts(rows: Floats, sources: int) -> _Parts:
    each = len(rows) // sources
    parted = rows[: each * sources].reshape(each, sources, 3)
    means = parted.mean(axis=0)
    return means, ((parted - means) ** 2).sum(axis=(0, 1)), each


def _ratio(positions: Sequence[_Parts], step: Floats) -> float:
    """Of the mean squares between and within sources, in the channel where it is largest."""
    between = [each * means.var(axis=0, ddof=1) for means, _, each in positions]
    freedom = sum((each - 1) * len(means) for means, _, each in positions)
    noise = np.maximum(np.sum([squares for _, squares, _ in positions], axis=0) / freedom, (step / 2) ** 2)
    widest = np.max([np.ptp(means, axis=0) for means, _, _ in positions], axis=0)
    told = (widest > _STEPS_APART * step) & (noise > 0.0) & (freedom >= _FEWEST)
    return float((np.where(told, np.mean(between, axis=0), 0.0) / np.where(told, noise, 1.0)).max())


def _apart(parts: _Parts, step: Floats) -> Floats:
    """The largest difference between sources (3,), in standard deviations of their noise."""
    means, squares, each = parts
    noise = np.sqrt(np.maximum(squares / ((each - 1) * len(means)), (step / 2) ** 2))
    apart: Floats = np.ptp(means, axis=0) / np.where(noise > 0.0, noise, np.inf)
    return apart
