"""Rows that no block at rest gives: taken while the table turned, absurd, stuck, saturated; or not those of one block:
written again, or of several sources in turn.

The gates are those of the firmware (core/averaging.c), which sees every sample, for a file of which nobody knows how
it was averaged. A row is held against the other rows of its position. Noise is taken from the rows themselves, by
quantiles, so that a third of them may be wrong; where the converter is coarse, it is no less than half a step.

An honest run repeats itself too, where its converter is coarse. So a stretch of equal rows counts only where noise
would have changed it: by the innovations of its noisiest channel, what a linear prediction from the rows before leaves,
so that hum, drift and slow noise are none; and no more than neighbouring rows change, which a sensor may hold.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tumble.arrays import Flags, Floats, Integers
from tumble.errors import BadInput
from tumble.files.run_file import ROWS_IN_MEMORY, WITHIN_ONE_SIGMA, RowStore, Run
from tumble.files.stand_file import StandFile
from tumble.schedule import Schedule
from tumble.stand import PerChannel, by_channel
from tumble.units import volts_per

_FAR = 8.0  # noise: further off no row is at rest, nor is a position that scatters so much more than the others
_ABSURD = 20.0  # noise: further off a single row is no spike of a block that has some
_MATTERS = 3.0  # standard errors of a mean: rows that move it further are not averaged
_FEWEST = 12  # degrees of freedom, to know the noise of a channel
_TREND = 0.5  # part of the scatter that is a ramp where a table moves
_FEWEST_FOR_TREND = 8
_STUCK_CHANCE = 1e-6  # that a run of honest rows has so many equal values in a row
_STUCK_RUN, _STUCK_POSITION = 10, 4  # rows, at least: within a position, or all of it
_EXTREMES, _STEPS_FOR_EXTREMES = 15, 5.0  # equal largest values, where noise is so many steps
_MOST_NAMED = 3
_CHANNELS = ("ux", "uy", "uz")


_Stretch = tuple[int, Floats, Integers]  # rows that belong together: position, outputs (rows, 3), numbers of lines


def check_rows(run: Run, schedule: Schedule, stand_file: StandFile | None, file: str) -> tuple[str, ...]:
    """Warnings about columns that are passed over, and about rows that are odd but do not matter. Raises BadInput,
    naming rows, for those that do.

    `stand_file` tells of the block's range; None: unknown."""
    if run.table is None:
        return run.passed_over
    judge = _Judge(run, run.table, schedule, file)
    if stand_file is not None and stand_file.block is not None:
        judge.require_range(stand_file.block["range_v"], stand_file.step_v)
    judge.require_no_stuck_channel()
    judge.require_no_extremes()
    judge.require_no_copies()
    return (*run.passed_over, *judge.judge_sources(), *judge.judge_held(), *judge.judge_rest())


class _Judge:
    def __init__(self, run: Run, table: RowStore, schedule: Schedule, file: str):
        self._run, self._table, self._schedule, self._file = run, table, schedule, file
        self._facts = table.facts
        self._present = [position for position, one in enumerate(self._facts) if one.samples > 0]

    # What the converter cannot have given, or gave for want of a better value.

    def require_range(self, range_v: PerChannel | None, step_v: PerChannel) -> None:
        """No output at or beyond the declared range of the converter."""
        if range_v is None:
            return
        unit = volts_per(self._run.unit)
        full, step = by_channel(range_v) / unit, by_channel(step_v) / unit
        over = np.where(step > 0.0, np.nextafter(full + step, math.inf), full)
        for least, before, behind in (
            (over, "beyond the declared range", "; another unit? (--unit)"),
            (full - 1.5 * step, "at the end of the range", ": saturated"),
        ):
            found = self._rows_from(least)
            if found is not None:
                line, channel, value, rows = found
                more = f" (and {rows - 1} more rows)" if rows > 1 else ""
                what = f"{before} of +-{full[channel]:g} {self._run.unit}{behind}"
                raise self._refusal(f"{self._said(value)} is {what}{more}", line, channel)

    def _rows_from(self, least: Floats) -> tuple[int, int, float, int] | None:
        """Of the outputs that are so large (3,), of either sign, the first one's line, channel and value, and how many
        rows have such; None: there are none."""
        first, rows = (0, 0, 0.0), 0
        for position in self._present:
            channels = self._facts[position].channels
            if all(max(map(abs, channel.ends)) < one for channel, one in zip(channels, least.tolist())):
                continue
            outputs, lines = self._table.rows(position)
            found = np.abs(outputs) >= least
            if (count := int(found.any(axis=1).sum())) > 0:
                row, channel = np.argwhere(found)[0].tolist()
                one = int(lines[row]), channel, float(outputs[row, channel])
                first, rows = one if rows == 0 or one < first else first, rows + count
        return (*first, rows) if rows else None

    def require_no_stuck_channel(self) -> None:
        """No value that comes again and again where noise should have changed it."""
        for channel, name in enumerate(_CHANNELS):
            least = self._least_run(channel)
            for position in self._present:
                one = self._facts[position]
                first, behind = one.channels[channel].run
                length = behind - first
                whole = length == one.samples >= _STUCK_POSITION
                if length >= least and (whole or length >= _STUCK_RUN):
                    begin, end = one.runs[channel]
                    value = float(self._table.rows(position)[0][first, channel])
                    raise self._refusal(
                        f"{self._said(value)} in all rows to {end} ({self._label(position)}), "
                        f"where {name} shows noise elsewhere: stuck or saturated",
                        begin,
                        channel,
                    )

    def require_no_extremes(self) -> None:
        """No largest or smallest value that many rows share: noise that is cut off."""
        for channel in range(3):
            if self._least_noise(channel) < _STEPS_FOR_EXTREMES:
                continue
            own = [self._facts[position].channels[channel] for position in self._present]
            for end, extreme in ((1, max(one.ends[1] for one in own)), (0, min(one.ends[0] for one in own))):
                rows = sum(one.at_ends[end] for one in own if one.ends[end] == extreme)
                if rows < _EXTREMES:
                    continue
                lines = []  # of the first such row of each position
                for position in self._present:
                    if extreme in self._facts[position].channels[channel].ends:
                        outputs, its_lines = self._table.rows(position)
                        lines.append(int(its_lines[(outputs[:, channel] == extreme).argmax()]))
                said = f"{self._said(extreme)} in {rows} rows, and none beyond: saturated"
                raise self._refusal(said, min(lines), channel)

    def _least_noise(self, channel: int) -> float:
        """Noise of a channel in steps of its values, at least, by the differences of neighbouring rows of positions in
        which it changes; 0 where the steps hide it."""
        facts = [self._facts[position] for position in self._present]
        changing = [one for one in facts if one.channels[channel].ends[0] < one.channels[channel].ends[1]]
        if sum(one.samples - 1 for one in changing) < _FEWEST:
            return 0.0
        changes = _at_one_stride([(one.stride, one.channels[channel].changes) for one in changing])
        steps = float(np.quantile(changes, WITHIN_ONE_SIGMA) / self._table.step[channel])
        return 0.0 if steps < 1.5 else (steps - 0.5) / math.sqrt(2.0)  # one step back and forth needs no noise

    def _least_run(self, channel: int) -> float:
        """How many equal values in a row honest noise does not give: each but the first has the chance of the step in
        which the mean may lie."""
        noise = self._least_noise(channel)
        chance = chance_of_a_value(noise)
        if chance >= 1.0:
            return math.inf
        return 1.0 + math.log(_STUCK_CHANCE / (3 * int(self._table.samples.sum()))) / math.log(chance)

    # Is every row a measurement, and all of one block?

    def require_no_copies(self) -> None:
        """No rows that come again, digit for digit, where noise should have changed them."""
        for outputs, lines, position in self._in_order():
            found = copied(outputs, position, self._table.step)
            if found is None:
                continue
            named = []
            for begin in (found.again, found.first):
                end = begin + found.length - 1
                labels = dict.fromkeys(self._label(int(position[row])) for row in (begin, end))
                named.append(f"{_range(lines[begin], lines[end])} ({' to '.join(labels)})")
            raise self._refusal(WRITTEN_AGAIN.format(*named), int(lines[found.again]))

    def _in_order(self) -> Iterator[tuple[Floats, Integers, Integers]]:
        """Rows, their lines and positions, in the order of the file: all, or of each position where they are many."""
        if int(self._table.samples.sum()) > ROWS_IN_MEMORY:
            for position in self._present:
                outputs, lines = self._table.rows(position)
                yield outputs, lines, np.broadcast_to(position, len(lines))
            return
        outputs, lines = map(np.concatenate, zip(*map(self._table.rows, self._present)))
        order = np.argsort(lines, kind="stable")
        yield outputs[order], lines[order], np.repeat(self._present, self._table.samples[self._present])[order]

    def judge_sources(self) -> tuple[str, ...]:
        """A warning where rows come in turn from what may be several sources; raises BadInput where they do."""
        rests = (self._table.rows(position, MOST_IN_TURN)[0] for position in self._present)
        found = in_turn(rests, self._table.step, self._run.unit)
        first = min(self._facts[position].lines[0] for position in self._present)
        if found is not None and found.is_certain:
            raise self._refusal(found.sentence, first)
        return () if found is None else (f"from row {first} on {found.sentence}",)

    def judge_held(self) -> tuple[str, ...]:
        """A warning where every measurement stands in several rows."""
        times = held(self._table.rows(position, MOST_IN_TURN)[0] for position in self._present)
        if times == 1:
            return ()
        first = min(self._facts[position].lines[0] for position in self._present)
        said = f"rows {first} to {first + times - 1}, and so on, are equal, digit for digit"
        return (f"{said}: each measurement is written {times} times, or held; keep one of each",)

    # Was the table at rest?

    def judge_rest(self) -> tuple[str, ...]:
        """Warnings; raises BadInput for rows that move a mean."""
        noise = self._noise()
        if noise is None:
            return ()
        moving: list[_Stretch] = []
        absurd: list[_Stretch] = []
        warnings = []
        for position in self._present:
            channels = self._facts[position].channels
            own, farthest = np.array([one.usual for one in channels]), np.array([one.farthest for one in channels])
            level = np.maximum(noise, own)
            is_restless = (own > _FAR * noise).any()
            if self._facts[position].samples < 2 or not (is_restless or (farthest > _FAR * level).any()):
                continue
            outputs, lines = self._table.rows(position)
            if is_restless:
                worst = outputs[:, int(_beyond(own, noise).argmax())]
                if len(worst) >= _FEWEST_FOR_TREND and np.corrcoef(np.arange(len(worst)), worst)[0, 1] ** 2 > _TREND:
                    moving.append((position, outputs, lines))
                else:
                    warnings.append(self._restless(position, own, noise))
                continue
            off = np.abs(outputs - self._medians(position))
            far: Flags = np.any(off > _FAR * level, axis=1)
            at_edge, matters = _edges(far), _matters(outputs, far, level)
            if matters and at_edge.any():
                moving += [(position, outputs[part], lines[part]) for part in _parts(at_edge)]
            elif matters and (off > _ABSURD * level).any():
                absurd.append((position, outputs[far], lines[far]))
            else:
                line, channel, said = self._far_off((position, outputs[far], lines[far]))
                warnings.append(f"row {line}, column {_CHANNELS[channel]}: {said}")
        if moving:
            raise self._turned(moving)
        if absurd:
            raise self._absurd(absurd)
        return tuple(warnings)

    def _noise(self) -> Floats | None:
        """Of one sample of each channel; None where too few rows tell."""
        facts = [one for one in self._facts if one.samples > 1]
        if sum(one.samples - 1 for one in facts) < _FEWEST:
            return None
        noise = []
        for channel in range(3):
            free = [
                (one.stride, math.sqrt(one.samples / (one.samples - 1)) * one.channels[channel].off) for one in facts
            ]
            noise.append(np.quantile(_at_one_stride(free), WITHIN_ONE_SIGMA))
        return np.maximum(np.array(noise), self._table.step / 2)

    # Words.

    def _turned(self, stretches: list[_Stretch]) -> BadInput:
        named = [f"{_range(lines[0], lines[-1])} ({self._label(position)})" for position, _, lines in stretches]
        rest = len(named) - _MOST_NAMED
        more = f" and {rest} more such stretches" if rest > 0 else ""
        said = f"the table was not at rest: rows {', '.join(named[:_MOST_NAMED])}{more} are off the others of their"
        return self._refusal(f"{said} position; leave them out", int(stretches[0][2][0]))

    def _absurd(self, stretches: list[_Stretch]) -> BadInput:
        first, channel, said = self._far_off(stretches[0])
        lines = [str(line) for _, _, numbers in stretches for line in numbers]
        more = ""
        if len(lines) > 1:
            shown = ", ".join(lines[: 2 * _MOST_NAMED])
            more = f"; absurd are rows {shown}" + (
                f" and {len(lines) - 2 * _MOST_NAMED} more" if len(lines) > 6 else ""
            )
        return self._refusal(f"{said}{more}", first, channel)

    def _restless(self, position: int, own: Floats, noise: Floats) -> str:
        beyond = _beyond(own, noise)
        channel = int(beyond.argmax())
        times = f"{beyond[channel]:.0f} times as much as elsewhere"
        times = "and does not elsewhere" if np.isinf(beyond[channel]) else times
        place = f"rows {_range(*self._facts[position].lines)} ({self._label(position)})"
        return f"{place}: {_CHANNELS[channel]} scatters {times}"

    def _medians(self, position: int) -> Floats:
        return np.array([one.median for one in self._facts[position].channels])

    def _far_off(self, stretch: _Stretch) -> tuple[int, int, str]:
        """Line and channel of the value that is farthest off, and what to say of it."""
        position, outputs, lines = stretch
        off = np.abs(outputs - self._medians(position))
        row, channel = map(int, np.unravel_index(int(off.argmax()), off.shape))
        usual = self._facts[position].channels[channel].median
        others = f"the others of {self._label(position)} lie about {usual:.5g} {self._run.unit}"
        return int(lines[row]), channel, f"{self._said(outputs[row, channel])} is far off: {others}"

    def _said(self, value: float) -> str:
        return f"{value:.5g} {self._run.unit}"

    def _label(self, position: int) -> str:
        return self._schedule.positions[position].label

    def _refusal(self, message: str, line: int, channel: int | None = None) -> BadInput:
        column = None if channel is None else _CHANNELS[channel]
        return BadInput(message, self._file, line, column)


def _range(first: int, last: int) -> str:
    return str(int(first)) if first == last else f"{int(first)} to {int(last)}"


def _at_one_stride(parts: list[tuple[int, Floats]]) -> Floats:
    """Values of several positions, of each every n-th, with one n for all: none weighs more than its rows."""
    widest = max(stride for stride, _ in parts)
    return np.concatenate([values[:: widest // stride] for stride, values in parts])


def _beyond(own: Floats, noise: Floats) -> Floats:
    """How many times as much; infinite where there is no noise elsewhere."""
    there = noise > 0.0
    return np.where(there, own / np.where(there, noise, 1.0), np.where(own > 0.0, np.inf, 0.0))


def _edges(far: Flags) -> Flags:
    """Of the far rows those, two or more, with which a position begins or ends."""
    edges = np.zeros(len(far), dtype=bool)
    for order in (slice(None), slice(None, None, -1)):
        begin = int(np.argmin(np.append(far[order], False)))
        if begin > 1:
            edges[order][:begin] = True
    return edges


def _parts(edges: Flags) -> Iterator[Integers]:
    """Those at the beginning, those at the end."""
    places = np.flatnonzero(edges)
    for part in np.split(places, np.flatnonzero(np.diff(places) > 1) + 1):
        if len(part):
            yield part


def _matters(outputs: Floats, far: Flags, noise: Floats) -> bool:
    """Do the far rows move a mean by more than it can be off by noise?"""
    moved = np.abs(outputs.mean(axis=0) - outputs[~far].mean(axis=0))
    return bool((moved > _MATTERS * noise / math.sqrt(len(outputs))).any())


# Rows that are written again, held, or of several sources in turn.

CHANCE = 1e-9  # that an honest run is taken for one with copies
_SHORTEST = 4  # rows of a stretch
_WINDOWS = 1 << 14  # of which the search is made
_NEIGHBOURS = 3
_ORDER = 8  # of the prediction
_FEWEST_COPIED = 12  # innovations, to know their size
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

WRITTEN_AGAIN = "rows {} are rows {} again, digit for digit: written twice? Leave them out"

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
        chance_of_a_value(float((changes / np.where(step > 0.0, step, np.inf)).max())),
        chance_of_a_value(float(_innovations(outputs, position, step).max())),  # all rows before it having come again
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
    if best is None:
        return None
    first, again = (int(places[one]) for one in best)
    apart = again - first
    equal: Flags = (outputs[:-apart] == outputs[apart:]).all(axis=1)  # backwards and forwards, until rows differ
    unequal = np.flatnonzero(~equal)
    begin = int(unequal[unequal < first].max(initial=-1)) + 1
    end = int(unequal[unequal >= first].min(initial=len(equal)))
    return Repeat(begin, begin + apart, end - begin)


def _mixed(keys: Keys) -> Keys:
    mixed: Keys = (keys ^ (keys >> np.uint64(29))) * _MULTIPLIERS[1]
    return mixed ^ (mixed >> np.uint64(32))


def _equal_apart(keys: Keys, length: int) -> tuple[int, int] | None:
    """Indices of two equal keys that are at least so far apart."""
    ordered = np.sort(keys >> np.uint64(2))
    equal = ordered[1:][ordered[1:] == ordered[:-1]]
    if not len(equal):
        return None
    places = np.flatnonzero(np.isin(keys >> np.uint64(2), equal))
    places = places[np.argsort(keys[places], kind="stable")]
    first = np.concatenate(([True], np.diff(keys[places].view(np.int64)) != 0))
    begins = places[np.flatnonzero(first)][np.cumsum(first) - 1]
    apart = np.flatnonzero(places - begins >= length)
    return (int(begins[apart[0]]), int(places[apart[0]])) if len(apart) else None


def _held(outputs: Floats, position: Integers) -> float:
    """The largest share of rows that are equal to the one, two or three rows before."""
    shares = [0.0]
    for apart in range(1, min(_NEIGHBOURS, len(outputs) - 1) + 1):
        beside = position[apart:] == position[:-apart]
        equal = (outputs[apart:] == outputs[:-apart]).all(axis=1) & beside
        shares.append(float(equal.sum() / max(1, beside.sum())))
    return max(shares)


def chance_of_a_value(noise: float) -> float:
    """Of the likeliest value, by the noise in steps."""
    return math.erf(0.5 / (math.sqrt(2.0) * noise)) if noise > 0.0 else 1.0


def _innovations(outputs: Floats, position: Integers, step: Floats) -> Floats:
    """Of each channel in steps, without what rounding adds; where too few rows tell, the least that there can be."""
    ends = np.flatnonzero(np.diff(position, append=-1)) + 1
    lengths = np.diff(ends, prepend=0)
    order = min(_ORDER, int(np.median(lengths)) // 4)
    visit = np.repeat(np.arange(len(lengths)), lengths)
    off = outputs - (np.add.reduceat(outputs, ends - lengths) / lengths[:, None])[visit]
    places = np.arange(order, len(off))
    places = places[(visit[places] == visit[places - order]) & (lengths[visit[places]] > 1)][:_MOST_INNOVATIONS]
    if len(places) < _FEWEST_COPIED + 2 * order:
        least: Floats = _LEAST_NOISE * np.ptp(outputs, axis=0) / np.where(step > 0.0, step, np.inf)
        return least
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
    """A `sentence` that rows may be of this `number` of sources in turn; `is_certain`: no noise does that."""

    sentence: str
    is_certain: bool
    number: int


_Parts = tuple[Floats, Floats, int]  # means of the sources (sources, 3), squares within them (3,), rows of each


def in_turn(positions: Iterable[Floats], step: Floats, unit: str) -> Sources | None:
    """What the rows (rows, 3) of each position that has enough, at rest, show of several sources in turn; None where
    noise explains it, or a converter that alternates."""
    long = (rows[:MOST_IN_TURN] for rows in positions if len(rows) >= _FEWEST_IN_TURN)
    by_sources = zip(*([_stretches(rows, sources) for sources in _SOURCES] for rows in long))
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
    is_certain = clear >= _OF_POSITIONS * len(best)
    end = "? Keep the rows of one" if is_certain else ", or a vibration in step with them?"
    return Sources(f"{said}: {_NUMBERS[len(levels)]} sources in one file{end}", is_certain, len(levels))


def _stretches(rows: Floats, sources: int) -> _Parts:
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
    told = (widest > _STEPS_APART * step) & (noise > 0.0) & (freedom >= _FEWEST_COPIED)
    return float((np.where(told, np.mean(between, axis=0), 0.0) / np.where(told, noise, 1.0)).max())


def _apart(parts: _Parts, step: Floats) -> Floats:
    """The largest difference between sources (3,), in standard deviations of their noise."""
    means, squares, each = parts
    noise = np.sqrt(np.maximum(squares / ((each - 1) * len(means)), (step / 2) ** 2))
    apart: Floats = np.ptp(means, axis=0) / np.where(noise > 0.0, noise, np.inf)
    return apart
