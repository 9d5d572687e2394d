"""Rows that no block at rest gives: taken while the table turned, absurd, stuck, saturated; or not those of one block.

The gates are those of the firmware (core/averaging.c), which sees every sample, for a file of which nobody knows how
it was averaged. A row is held against the other rows of its position. Noise is taken from the rows themselves, by
quantiles, so that a third of them may be wrong; where the converter is coarse, it is no less than half a step.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.errors import BadInput
from tumble.files import run_copies
from tumble.files.run_facts import WITHIN_ONE_SIGMA
from tumble.files.run_file import Run
from tumble.files.run_store import ROWS_IN_MEMORY, RowStore
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


@dataclass(frozen=True)
class Stretch:
    """Rows of one position that belong together, in the order of the file: outputs (rows, 3), numbers of lines."""

    position: int
    outputs: Floats
    lines: Integers


@dataclass(frozen=True)
class _Found:
    """What was not at rest, what is absurd, and sentences about what does not matter."""

    moving: list[Stretch]
    absurd: list[Stretch]
    warnings: list[str]


def require(run: Run, schedule: Schedule, stand_file: StandFile | None, file: str) -> tuple[str, ...]:
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
                if rows >= _EXTREMES:
                    line = self._first_with(channel, extreme)
                    said = f"{self._said(extreme)} in {rows} rows, and none beyond: saturated"
                    raise self._refusal(said, line, channel)

    def _first_with(self, channel: int, value: float) -> int:
        """The line of the first row with a value of a channel."""
        lines = []
        for position in self._present:
            if value in self._facts[position].channels[channel].ends:
                outputs, own = self._table.rows(position)
                lines.append(int(own[(outputs[:, channel] == value).argmax()]))
        return min(lines)

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
        chance = math.erf(0.5 / (math.sqrt(2.0) * noise)) if noise > 0.0 else 1.0
        if chance >= 1.0:
            return math.inf
        return 1.0 + math.log(_STUCK_CHANCE / (3 * int(self._table.samples.sum()))) / math.log(chance)

    # Is every row a measurement, and all of one block?

    def require_no_copies(self) -> None:
        """No rows that come again, digit for digit, where noise should have changed them."""
        for outputs, lines, position in self._in_order():
            found = run_copies.copied(outputs, position, self._table.step)
            if found is not None:
                last = found.length - 1
                again, first = (
                    f"{_range(lines[begin], lines[begin + last])} ({self._labels(position, begin, begin + last)})"
                    for begin in (found.again, found.first)
                )
                said = f"rows {again} are rows {first} again, digit for digit: written twice? Leave them out"
                raise self._refusal(said, int(lines[found.again]))

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
        rests = (self._table.rows(position, run_copies.MOST_IN_TURN)[0] for position in self._present)
        found = run_copies.in_turn(rests, self._table.step, self._run.unit)
        first = min(self._facts[position].lines[0] for position in self._present)
        if found is not None and found.is_certain:
            raise self._refusal(f"{found.sentence}? Keep the rows of one", first)
        return () if found is None else (f"from row {first} on {found.sentence}, or a vibration in step with them?",)

    def judge_held(self) -> tuple[str, ...]:
        """A warning where every measurement stands in several rows."""
        times = run_copies.held(self._table.rows(position, run_copies.MOST_IN_TURN)[0] for position in self._present)
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
        found = _Found([], [], [])
        for position in self._present:
            if self._facts[position].samples > 1:
                self._judge_position(position, noise, found)
        if found.moving:
            raise self._turned(found.moving)
        if found.absurd:
            raise self._absurd(found.absurd)
        return tuple(found.warnings)

    def _judge_position(self, position: int, noise: Floats, found: _Found) -> None:
        channels = self._facts[position].channels
        own, farthest = np.array([one.usual for one in channels]), np.array([one.farthest for one in channels])
        level = np.maximum(noise, own)
        if not (own > _FAR * noise).any() and not (farthest > _FAR * level).any():
            return
        outputs, lines = self._table.rows(position)
        if (own > _FAR * noise).any():
            if _is_ramp(outputs, int(_beyond(own, noise).argmax())):
                found.moving.append(Stretch(position, outputs, lines))
            else:
                found.warnings.append(self._restless(position, own, noise))
            return
        off = np.abs(outputs - self._medians(position))
        far: Flags = np.any(off > _FAR * level, axis=1)
        at_edge = _edges(far)
        matters = _matters(outputs, far, level)
        if matters and at_edge.any():
            found.moving.extend(Stretch(position, outputs[part], lines[part]) for part in _parts(at_edge))
        elif matters and (off > _ABSURD * level).any():
            found.absurd.append(Stretch(position, outputs[far], lines[far]))
        else:
            found.warnings.append(self._odd(Stretch(position, outputs[far], lines[far])))

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

    def _turned(self, stretches: list[Stretch]) -> BadInput:
        named = [f"{_range(one.lines[0], one.lines[-1])} ({self._label(one.position)})" for one in stretches]
        rest = len(named) - _MOST_NAMED
        more = f" and {rest} more such stretches" if rest > 0 else ""
        said = f"the table was not at rest: rows {', '.join(named[:_MOST_NAMED])}{more} are off the others of their"
        return self._refusal(f"{said} position; leave them out", int(stretches[0].lines[0]))

    def _absurd(self, stretches: list[Stretch]) -> BadInput:
        row, channel = self._farthest(stretches[0])
        lines = [str(line) for one in stretches for line in one.lines]
        more = ""
        if len(lines) > 1:
            shown = ", ".join(lines[: 2 * _MOST_NAMED])
            more = f"; absurd are rows {shown}" + (
                f" and {len(lines) - 2 * _MOST_NAMED} more" if len(lines) > 6 else ""
            )
        said = f"{self._beside(stretches[0], row, channel)}{more}"
        return self._refusal(said, int(stretches[0].lines[row]), channel)

    def _odd(self, one: Stretch) -> str:
        row, channel = self._farthest(one)
        place = f"row {int(one.lines[row])}, column {_CHANNELS[channel]}"
        return f"{place}: {self._beside(one, row, channel)}"

    def _restless(self, position: int, own: Floats, noise: Floats) -> str:
        beyond = _beyond(own, noise)
        channel = int(beyond.argmax())
        times = (
            "and does not elsewhere"
            if np.isinf(beyond[channel])
            else f"{beyond[channel]:.0f} times as much as elsewhere"
        )
        place = f"rows {_range(*self._facts[position].lines)} ({self._label(position)})"
        return f"{place}: {_CHANNELS[channel]} scatters {times}"

    def _medians(self, position: int) -> Floats:
        return np.array([one.median for one in self._facts[position].channels])

    def _farthest(self, one: Stretch) -> tuple[int, int]:
        off = np.abs(one.outputs - self._medians(one.position))
        row, channel = np.unravel_index(int(off.argmax()), off.shape)
        return int(row), int(channel)

    def _beside(self, one: Stretch, row: int, channel: int) -> str:
        usual = self._facts[one.position].channels[channel].median
        others = f"the others of {self._label(one.position)} lie about {usual:.5g} {self._run.unit}"
        return f"{self._said(one.outputs[row, channel])} is far off: {others}"

    def _said(self, value: float) -> str:
        return f"{value:.5g} {self._run.unit}"

    def _labels(self, position: Integers, first: int, last: int) -> str:
        """Of the positions of two rows."""
        ends = [self._label(int(position[row])) for row in (first, last)]
        return ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"

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


def _is_ramp(outputs: Floats, channel: int) -> bool:
    """Is most of a position's scatter a straight line in the order of its rows?"""
    if len(outputs) < _FEWEST_FOR_TREND:
        return False
    return float(np.corrcoef(np.arange(len(outputs)), outputs[:, channel])[0, 1]) ** 2 > _TREND


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
