"""Rows that no block at rest gives: taken while the table turned, absurd, stuck, saturated.

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
from tumble.files.run_file import Run, RunTable
from tumble.files.stand_file import StandFile
from tumble.schedule import Schedule
from tumble.units import volts_per

_FAR = 8.0  # noise: further off no row is at rest, nor is a position that scatters so much more than the others
_ABSURD = 20.0  # noise: further off a single row is no spike of a block that has some
_MATTERS = 3.0  # standard errors of a mean: rows that move it further are not averaged
_FEWEST = 12  # degrees of freedom, to know the noise of a channel
_WITHIN_ONE_SIGMA = 0.6827
_TREND = 0.5  # part of the scatter that is a ramp where a table moves
_FEWEST_FOR_TREND = 8
_STUCK_CHANCE = 1e-6  # that a run of honest rows has so many equal values in a row
_STUCK_RUN, _STUCK_POSITION = 10, 4  # rows, at least: within a position, or all of it
_EXTREMES, _STEPS_FOR_EXTREMES = 15, 5.0  # equal largest values, where noise is so many steps
_ROWS_FOR_STEP = 20000
_MOST_NAMED = 3
_CHANNELS = ("ux", "uy", "uz")


@dataclass(frozen=True)
class Stretch:
    """Rows of one position that belong together: indices into the table, in the order of the file."""

    position: int
    rows: Integers


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
    return (*run.passed_over, *judge.judge_rest())


class _Judge:
    def __init__(self, run: Run, table: RunTable, schedule: Schedule, file: str):
        self._run, self._table, self._schedule, self._file = run, table, schedule, file
        order = np.argsort(table.index, kind="stable")
        ends = np.cumsum(run.samples)[:-1]
        self._rows: list[Integers] = np.split(order, ends)
        self._outputs = [table.outputs[rows] for rows in self._rows]
        self._step = np.array([_step(channel) for channel in table.outputs.T])

    # What the converter cannot have given, or gave for want of a better value.

    def require_range(self, range_v: float | None, step_v: float) -> None:
        """No output at or beyond the declared range of the converter."""
        if range_v is None:
            return
        unit = volts_per(self._run.unit)
        full, step = range_v / unit, step_v / unit
        size = np.abs(self._table.outputs)
        for limit, what in (
            (full + step, f"beyond the declared range of +-{full:g} {self._run.unit}; another unit? (--unit)"),
            (full - 1.5 * step, f"at the end of the range of +-{full:g} {self._run.unit}: saturated"),
        ):
            over = size > limit if limit > full else size >= limit
            if over.any():
                row, channel = np.argwhere(over)[0].tolist()
                rows = int(over.any(axis=1).sum())
                more = f" (and {rows - 1} more rows)" if rows > 1 else ""
                raise self._refusal(f"{self._value(row, channel)} is {what}{more}", row, channel)

    def require_no_stuck_channel(self) -> None:
        """No value that comes again and again where noise should have changed it."""
        for channel, name in enumerate(_CHANNELS):
            least = self._least_run(channel)
            for position, rows in enumerate(self._rows):
                first, length = _longest_run(self._outputs[position][:, channel])
                whole = length == len(rows) >= _STUCK_POSITION
                if length >= least and (whole or length >= _STUCK_RUN):
                    begin, end = rows[first], rows[first + length - 1]
                    raise self._refusal(
                        f"{self._value(begin, channel)} in all rows to {self._line(end)} ({self._label(position)}), "
                        f"where {name} shows noise elsewhere: stuck or saturated",
                        begin,
                        channel,
                    )

    def require_no_extremes(self) -> None:
        """No largest or smallest value that many rows share: noise that is cut off."""
        for channel in range(3):
            outputs = self._table.outputs[:, channel]
            if self._least_noise(channel) < _STEPS_FOR_EXTREMES:
                continue
            for extreme in (outputs.max(), outputs.min()):
                rows = np.flatnonzero(outputs == extreme)
                if len(rows) >= _EXTREMES:
                    said = f"{self._value(rows[0], channel)} in {len(rows)} rows, and none beyond: saturated"
                    raise self._refusal(said, int(rows[0]), channel)

    def _least_noise(self, channel: int) -> float:
        """Noise of a channel in steps of its values, at least, by the differences of neighbouring rows of positions in
        which it changes; 0 where the steps hide it."""
        changes = [np.abs(np.diff(outputs[:, channel])) for outputs in self._outputs]
        changing = [change for change in changes if change.any()]
        if not changing or sum(map(len, changing)) < _FEWEST:
            return 0.0
        steps = float(np.quantile(np.concatenate(changing), _WITHIN_ONE_SIGMA) / self._step[channel])
        return 0.0 if steps < 1.5 else (steps - 0.5) / math.sqrt(2.0)  # one step back and forth needs no noise

    def _least_run(self, channel: int) -> float:
        """How many equal values in a row honest noise does not give: each but the first has the chance of the step in
        which the mean may lie."""
        noise = self._least_noise(channel)
        chance = math.erf(0.5 / (math.sqrt(2.0) * noise)) if noise > 0.0 else 1.0
        if chance >= 1.0:
            return math.inf
        return 1.0 + math.log(_STUCK_CHANCE / (3 * len(self._table.index))) / math.log(chance)

    # Was the table at rest?

    def judge_rest(self) -> tuple[str, ...]:
        """Warnings; raises BadInput for rows that move a mean."""
        noise = self._noise()
        if noise is None:
            return ()
        found = _Found([], [], [])
        for position, rows in enumerate(self._rows):
            if len(rows) > 1:
                self._judge_position(position, noise, found)
        if found.moving:
            raise self._turned(found.moving)
        if found.absurd:
            raise self._absurd(found.absurd)
        return tuple(found.warnings)

    def _judge_position(self, position: int, noise: Floats, found: _Found) -> None:
        rows, outputs = self._rows[position], self._outputs[position]
        off = _off(outputs)
        own = _usual(off)
        if (own > _FAR * noise).any():
            if _is_ramp(outputs, int((own / noise).argmax())):
                found.moving.append(Stretch(position, rows))
            else:
                found.warnings.append(self._restless(position, own, noise))
            return
        level = np.maximum(noise, own)
        far: Flags = np.any(off > _FAR * level, axis=1)
        if not far.any():
            return
        at_edge = _edges(far)
        matters = _matters(outputs, far, level)
        if matters and at_edge.any():
            found.moving.extend(Stretch(position, rows[part]) for part in _parts(at_edge))
        elif matters and (off > _ABSURD * level).any():
            found.absurd.append(Stretch(position, rows[far]))
        else:
            found.warnings.append(self._odd(Stretch(position, rows[far])))

    def _noise(self) -> Floats | None:
        """Of one sample of each channel; None where too few rows tell."""
        freedom = int(np.maximum(self._run.samples - 1, 0).sum())
        if freedom < _FEWEST:
            return None
        off = [_off(outputs) for outputs in self._outputs if len(outputs) > 1]
        free = [math.sqrt(len(part) / (len(part) - 1)) * np.sort(part, axis=0)[1:] for part in off]
        return np.maximum(np.quantile(np.concatenate(free), _WITHIN_ONE_SIGMA, axis=0), self._step / 2)

    # Words.

    def _turned(self, stretches: list[Stretch]) -> BadInput:
        named = [f"{self._range(one.rows)} ({self._label(one.position)})" for one in stretches]
        rest = len(named) - _MOST_NAMED
        more = f" and {rest} more such stretches" if rest > 0 else ""
        said = f"the table was not at rest: rows {', '.join(named[:_MOST_NAMED])}{more} are off the others of their"
        return self._refusal(f"{said} position; leave them out", int(stretches[0].rows[0]))

    def _absurd(self, stretches: list[Stretch]) -> BadInput:
        row, channel = self._farthest(stretches[0])
        lines = [str(self._line(row)) for one in stretches for row in one.rows]
        more = ""
        if len(lines) > 1:
            shown = ", ".join(lines[: 2 * _MOST_NAMED])
            more = f"; absurd are rows {shown}" + (
                f" and {len(lines) - 2 * _MOST_NAMED} more" if len(lines) > 6 else ""
            )
        return self._refusal(f"{self._beside(stretches[0], row, channel)}{more}", row, channel)

    def _odd(self, one: Stretch) -> str:
        row, channel = self._farthest(one)
        place = f"row {self._line(row)}, column {_CHANNELS[channel]}"
        return f"{place}: {self._beside(one, row, channel)}"

    def _restless(self, position: int, own: Floats, noise: Floats) -> str:
        channel = int((own / noise).argmax())
        rows = self._rows[position]
        times = f"{own[channel] / noise[channel]:.0f} times as much as elsewhere"
        return f"rows {self._range(rows)} ({self._label(position)}): {_CHANNELS[channel]} scatters {times}"

    def _farthest(self, one: Stretch) -> tuple[int, int]:
        outputs = self._table.outputs[one.rows]
        off = np.abs(outputs - np.median(self._outputs[one.position], axis=0))
        row, channel = np.unravel_index(int(off.argmax()), off.shape)
        return int(one.rows[row]), int(channel)

    def _beside(self, one: Stretch, row: int, channel: int) -> str:
        usual = np.median(self._outputs[one.position][:, channel])
        others = f"the others of {self._label(one.position)} lie about {usual:.5g} {self._run.unit}"
        return f"{self._value(row, channel)} is far off: {others}"

    def _value(self, row: int, channel: int) -> str:
        return f"{self._table.outputs[row, channel]:.5g} {self._run.unit}"

    def _range(self, rows: Integers) -> str:
        first, last = self._line(rows[0]), self._line(rows[-1])
        return str(first) if first == last else f"{first} to {last}"

    def _line(self, row: int) -> int:
        return int(self._table.lines[row])

    def _label(self, position: int) -> str:
        return self._schedule.positions[position].label

    def _refusal(self, message: str, row: int, channel: int | None = None) -> BadInput:
        column = None if channel is None else _CHANNELS[channel]
        return BadInput(message, self._file, self._line(row), column)


def _off(outputs: Floats) -> Floats:
    """How far each row of a position is off their median."""
    found: Floats = np.abs(outputs - np.median(outputs, axis=0))
    return found


def _step(values: Floats) -> float:
    """The smallest difference of two values: the converter's step where it is coarse, next to nothing where it is not;
    0 where all are equal."""
    different = np.diff(np.unique(values[:: max(1, len(values) // _ROWS_FOR_STEP)]))
    return float(different.min()) if len(different) else 0.0


def _longest_run(values: Floats) -> tuple[int, int]:
    """Where the longest run of equal values begins, and its length; (0, 0) of none."""
    if len(values) == 0:
        return 0, 0
    begins = np.flatnonzero(np.append(True, np.diff(values) != 0.0))
    lengths = np.diff(np.append(begins, len(values)))
    longest = int(lengths.argmax())
    return int(begins[longest]), int(lengths[longest])


def _usual(off: Floats) -> Floats:
    """Scatter of each channel of a position, by the rows within one sigma: one wrong row of three does not show."""
    root = math.sqrt(len(off) / (len(off) - 1))
    found: Floats = root * np.quantile(off, _WITHIN_ONE_SIGMA, axis=0, method="lower")
    return found


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
