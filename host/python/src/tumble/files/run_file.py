"""Run files: recorded samples in, one mean per position and channel out.

A file goes one way: its bytes in blocks (disk), its layout (run_layout), its rows as numbers (rows), grouped by
position in a RowStore, of which few are in memory, what those of a position say together (PositionFacts), and the Run.
Only the last two look at more than a block, and only at the rows of one position at a time. Rows of a position are
taken for consecutive samples, in the order of the file.
"""

from __future__ import annotations

import itertools
import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from typing import BinaryIO

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Flags, Floats, Integers
from tumble.core import CoreSchedule
from tumble.errors import BadInput
from tumble.files import can_log, containers, run_layout
from tumble.files.disk import MIB, Held, Incoming, pieces, reason, size_text
from tumble.files.rows import NotANumber, Part, PositionIndex, Refused, RowParser, Temperatures, listed
from tumble.schedule import CLOSED, Schedule

WITHIN_ONE_SIGMA = 0.6827
_FEW_ROWS = 1 << 14  # as many are kept of what is ordered or follows in time
ROWS_IN_MEMORY = 1 << 18
_ROWS_FOR_STEP = 20000


@dataclass(frozen=True)
class Channel:
    """One output at one position. `usual`: the scatter by the rows within one sigma, which one wrong row of three does
    not show; 0 of fewer than two. `farthest`: the largest distance from the `median`. `at_ends`: how many rows have the
    smallest and the largest value. `run`: the longest run of equal values, as indices of its first row and the one
    behind its last. `off`: distances from the median in order, the smallest left out; `changes`: between neighbouring
    rows; of both every n-th, n the `stride` of PositionFacts. `resolution`: the smallest difference of two values,
    infinite where there is none.
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
    see Blocks; the `channels`, none of no row; `stride` of what they keep; `lines` of the first and the last row,
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
    outputs = [rows[:, channel].copy() for channel in range(3)]
    channels = tuple(_channel(values, stride) for values in outputs)
    scatter, squares = unknown, np.zeros((samples.bit_length() - 1, 3))
    if samples > 1:
        scatter, sums = np.empty(3), np.empty((samples // 2, 3))
        given = ffi.from_buffer("double[][4]", np.ascontiguousarray(rows))
        lib.rows_scatter(given, samples, ffi.from_buffer("double[]", scatter))
        lib.rows_squares(given, samples, *(ffi.from_buffer("double[][3]", one) for one in (sums, squares)))
    return PositionFacts(
        samples=samples,
        means=np.array([math.fsum(values.tolist()) for values in outputs]) / samples,
        scatter=scatter,
        squares=squares,
        channels=channels,
        stride=stride,
        lines=(int(rows[0, 3]), int(rows[-1, 3])),
        runs=tuple((int(rows[one.run[0], 3]), int(rows[one.run[1] - 1, 3])) for one in channels),
    )


def _channel(values: Floats, stride: int) -> Channel:
    rows, ordered = len(values), np.sort(values)
    median = float(ordered[(rows - 1) // 2] + ordered[rows // 2]) / 2
    off = np.sort(np.abs(ordered - median))
    within = math.floor((rows - 1) * WITHIN_ONE_SIGMA)
    ends = float(ordered[0]), float(ordered[-1])
    first_largest = int(np.searchsorted(ordered, ends[1], "left"))
    changes, steps = np.diff(values), np.diff(ordered)
    begins = np.flatnonzero(np.concatenate(([True], changes != 0.0, [True])))  # of runs of equal values
    longest = int(np.diff(begins).argmax())
    return Channel(
        median=median,
        usual=math.sqrt(rows / (rows - 1)) * float(off[within]) if rows > 1 else 0.0,
        farthest=float(off[-1]),
        ends=ends,
        at_ends=(int(np.searchsorted(ordered, ends[0], "right")), rows - first_largest),
        run=(int(begins[longest]), int(begins[longest + 1])),
        off=off[1::stride].copy(),
        changes=np.abs(changes[::stride]),
        resolution=float(steps.min(initial=np.inf, where=steps > 0.0)),
    )


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
    """Between two values of a channel: the converter's, where it is coarse, next to nothing where it is not; 0 where
    there is one value alone."""
    steps = np.diff(np.sort(values))
    step = float(steps.min(initial=np.inf, where=steps > 0.0))
    return step if math.isfinite(step) else 0.0


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
        self._sampled: list[Floats] = []  # every `_stride`-th row
        self._stride, self._added = 1, 0

    def add(self, index: Integers, values: Floats) -> None:
        """More rows: the index of the position of each, (rows,), and its outputs and line, (rows, 4)."""
        self._sample(values[:, :3])
        counts = np.bincount(index, minlength=len(self.samples))
        grouped = values[np.argsort(index, kind="stable")]
        for position, part in enumerate(np.split(grouped, np.cumsum(counts)[:-1])):
            if len(part):
                self._parts[position].append(part)
        self.samples += counts
        self._held += len(index)
        if self._held > self._most:
            self._write()

    def _sample(self, outputs: Floats) -> None:
        """Keep every n-th row, n a power of two: 20,000 to 40,000 of them, or all that there are."""
        self._sampled.append(outputs[-self._added % self._stride :: self._stride].copy())
        self._added += len(outputs)
        while sum(map(len, self._sampled)) >= 2 * _ROWS_FOR_STEP:
            self._sampled, self._stride = [np.concatenate(self._sampled)[::2].copy()], 2 * self._stride

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
        other.samples, other._file, other._sampled = self.samples[list(positions)], self._file, self._sampled
        other._parts = [self._parts[position] for position in positions]
        other._written = [self._written[position] for position in positions]
        return other

    def rows(self, position: int, most: int | None = None) -> tuple[Floats, Integers]:
        """Of a position: outputs (rows, 3) and numbers of lines (rows,), of all or of so many."""
        values = self._rows(position, most)
        return values[:, :3], values[:, 3].astype(np.intp)

    def _rows(self, position: int, most: int | None = None) -> Floats:
        values, begin = np.empty((int(self.samples[position]), 4))[:most], 0
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
        """(3,): the smallest difference of two values of a channel, as `smallest_step`. Of many rows some are looked
        at."""
        sampled = np.concatenate(self._sampled) if self._sampled else np.zeros((0, 3))
        return np.array([smallest_step(channel) for channel in sampled.T])


@dataclass(frozen=True)
class Run:
    """A recorded run, position by position in the schedule's order.

    `samples` (positions,): rows of each, 0 where none; `means` (positions, 3); `scatter` (positions, 3): standard
    deviation of one sample (n - 1), NaN below two rows; `unit` of both; `counters`: what was found in the file;
    `sha256`: of its bytes, in hexadecimal digits, empty for a run that is in no file; `unit_told`: by the file or by
    the user, not assumed; `table`: the rows themselves, None where nobody has them; `blocks`: how they move together
    (Blocks); `temperature`: None where it is not told; `passed_over`: sentences about columns that look like
    what they are not.
    """

    samples: Integers
    means: Floats
    scatter: Floats
    unit: str
    counters: dict[str, int]
    sha256: str = ""
    unit_told: bool = True
    table: RowStore | None = None
    blocks: Blocks = NO_BLOCKS
    temperature: Temperatures | None = None
    passed_over: tuple[str, ...] = ()

    @property
    def measured(self) -> Flags:
        """Which positions have a mean: (positions,) bool."""
        return self.samples > 0


def read_measured(
    source: str | Incoming | Held,
    schedule: CoreSchedule,
    options: run_layout.LayoutOptions = run_layout.NO_LAYOUT_OPTIONS,
) -> tuple[Run, CoreSchedule]:
    """Read a run file as `read_run` does, on a schedule as `on_schedule` takes it. Raises BadInput."""
    return on_schedule(lambda planned: read_rows(source, planned, options), schedule)


def on_schedule(read: Callable[[Schedule], Rows], schedule: CoreSchedule) -> tuple[Run, CoreSchedule]:
    """A run on a schedule. Where the schedule has a form with closures, the rows are read on that one first, once; it
    is kept if the run has a row at a position that this form alone has."""
    if schedule.name not in CLOSED:
        return read(schedule.data).run(), schedule
    closed = CoreSchedule.built_in(CLOSED[schedule.name])
    rows = read(closed.data)
    further = [index for index, one in enumerate(closed.data.positions) if one not in schedule.data.positions]
    if any(rows.store.samples[index] > 0 for index in further):
        return rows.run(), closed
    return rows.on(closed.data, schedule.data).run(), schedule


def read_run(file: str, schedule: Schedule, options: run_layout.LayoutOptions = run_layout.NO_LAYOUT_OPTIONS) -> Run:
    """Read a run file (CSV), or standard input ("-"), compressed or not. Raises BadInput, NotInstalled."""
    return read_rows(file, schedule, options).run()


@dataclass(frozen=True)
class Rows:
    """What a file or a table holds: its rows in a `store`, the `unit` of their outputs and whether that is told, and as
    in Run `counters` of what was passed over, `sha256`, `temperature` and `passed_over`."""

    store: RowStore
    unit: str
    unit_told: bool
    counters: dict[str, int]
    sha256: str = ""
    temperature: Temperatures | None = None
    passed_over: tuple[str, ...] = ()

    def on(self, planned: Schedule, other: Schedule) -> Rows:
        """On a schedule that has all their positions, after the one that they were read on."""
        places = {(one.mounting, one.number): index for index, one in enumerate(planned.positions)}
        return replace(self, store=self.store.on([places[one.mounting, one.number] for one in other.positions]))

    def run(self) -> Run:
        """Averaged, position by position."""
        samples, facts = self.store.samples, self.store.facts
        measured = int((samples > 0).sum())
        counters = {
            "rows": int(samples.sum()),
            "positions": measured,
            "positions_missing": len(samples) - measured,
            **self.counters,
        }
        return Run(
            samples=samples,
            means=np.array([one.means for one in facts]),
            scatter=np.array([one.scatter for one in facts]),
            unit=self.unit,
            counters=counters,
            sha256=self.sha256,
            unit_told=self.unit_told,
            table=self.store,
            blocks=blocks_of(facts),
            temperature=self.temperature,
            passed_over=self.passed_over,
        )


def read_rows(
    source: str | Incoming | Held, schedule: Schedule, options: run_layout.LayoutOptions = run_layout.NO_LAYOUT_OPTIONS
) -> Rows:
    """The rows of a run file, as read_run takes it, each one parsed and placed, none averaged. Raises BadInput,
    NotInstalled."""
    incoming = Incoming(source) if isinstance(source, str) else source
    reader = RunReader(incoming, PositionIndex(schedule), options, incoming.name)
    store = RowStore(len(schedule.positions), incoming.name)
    for index, values in reader:
        store.add(index, values)
    temperature, passed_over = reader.temperature
    layout, parser = reader.layout, reader.parser
    counters = {
        "blank_lines": layout.blanks + parser.blanks,
        "comment_lines": layout.comments + parser.comments,
        "columns_ignored": layout.width - len(run_layout.COLUMNS) - (temperature is not None),
    }
    return Rows(store, layout.unit, layout.unit_told, counters, incoming.sha256, temperature, passed_over)


LONGEST_HEAD = 16 * MIB  # of comments and blank lines above the header


class RunReader:
    """Goes through a run file once, given its bytes in blocks of any size; yields parts of rows. `layout` is known from
    the beginning; what `parser` counts, and `temperature`, when all is read. `fast`: by C where that can be;
    `recorded`: as RowParser has it, with the temperature of every row.

    Raises BadInput with row and column; a zero byte anywhere comes before other complaints.
    """

    def __init__(
        self,
        blocks: Iterable[bytes],
        positions: PositionIndex,
        options: run_layout.LayoutOptions,
        file: str,
        fast: bool = True,
        recorded: bool = False,
    ):
        self._positions, self._file = positions, file
        following = iter(blocks)
        start = self._grown(b"", following)
        try:
            run_layout.require_text(start, file)
            self._blocks = self._without_zeros(following, start.count(b"\n"))
            with _to_its_end(self._blocks):
                layout = run_layout.detect_in_head(start, options, file)
                if layout is None:
                    start = self._grown(start, self._blocks, to_its_end=True)
                    layout = run_layout.detect(start, options, file)
        except BadInput:
            can_log.refuse(start, file)
            containers.refuse(start, file)
            raise
        self.layout = layout
        self.parser = RowParser(layout, run_layout.COLUMNS, positions, fast=fast, recorded=recorded)
        self._pieces = pieces(itertools.chain((run_layout.body_of(start, layout.header_row),), self._blocks), file)

    def __iter__(self) -> Iterator[Part]:
        with _to_its_end(self._blocks):
            for piece in self._pieces:
                try:
                    part = self.parser.parse(piece)
                except Refused as refused:
                    hint = self._hint(refused) if isinstance(refused, NotANumber) else ""
                    raise BadInput(f"{refused}{hint}", self._file, refused.row, refused.column) from None
                if len(part[0]):
                    yield part
            if not self.parser.rows:
                raise BadInput("no samples after the header", self._file, self.layout.header_row)

    @property
    def temperature(self) -> tuple[Temperatures | None, tuple[str, ...]]:
        """Of the rows, and sentences about a column that is passed over. Raises BadInput."""
        return self.parser.thermometer.told(self._file)

    def _grown(self, start: bytes, blocks: Iterator[bytes], to_its_end: bool = False) -> bytes:
        """With blocks that follow: enough to find the layout in, or all. Raises BadInput where that is much."""
        grown = bytearray(start)
        for block in blocks:
            grown += block
            if not to_its_end and run_layout.is_long_enough(grown):
                break
            if len(grown) > LONGEST_HEAD:
                raise BadInput(f"no header line within {size_text(LONGEST_HEAD)}", self._file)
        return bytes(grown)

    def _without_zeros(self, blocks: Iterator[bytes], ends: int) -> Iterator[bytes]:
        """Raises BadInput for a zero byte; `ends`: of lines, before these blocks."""
        for block in blocks:
            zero = block.find(b"\0")
            if zero >= 0:
                raise BadInput("not a text file", self._file, ends + block.count(b"\n", 0, zero) + 1)
            ends += int(np.count_nonzero(np.frombuffer(block, np.uint8) == ord("\n")))  # ten times as fast as count
            yield block

    def _hint(self, refused: NotANumber) -> str:
        """What to do about it. Another option is advised only where all rows can be read with it: else one piece of
        advice would lead to the next."""
        line = run_layout.as_text(refused.rest.splitlines()[0])
        if not self.parser.rows and not any(map(run_layout.is_number, run_layout.split(line, self.layout.delimiter))):
            return " (a row of units? Delete it, or begin it with #; --unit says the unit)"
        if refused.column == "mounting":
            return f"; mountings are {listed(self._positions.mountings)}"
        if not run_layout.NUMBER.fullmatch(re.sub(r"[.,\s']", "", refused.text)):
            return ""
        other = "." if self.layout.decimal == "," else ","
        if other in refused.text and not self.parser.is_marked:
            parser = RowParser(replace(self.layout, decimal=other), run_layout.COLUMNS)
            if all(map(parser.can_read, itertools.chain((refused.rest,), self._pieces))):
                return f" (its decimal mark? see --decimal {other})"
        return " (write all numbers with the same decimal mark, and without thousands separators)"


@contextmanager
def _to_its_end(blocks: Iterator[bytes]) -> Iterator[None]:
    """After a complaint the rest is looked at too, for what comes before all other complaints."""
    try:
        yield
    except BadInput:
        for _ in blocks:
            pass
        raise
