"""Run files: recorded samples in, one mean per position and channel out.

A file goes one way: its bytes, its layout, its rows as numbers, their means. Rows are read fast where the file is
plain, carefully where it is not. The fast way hands plain files to numpy's parser after proving, from the places of
delimiters and line ends, that every row has as many fields as the header. Whatever it does not take for certain, it
leaves to the careful way, which reads line by line and is the one that complains: so both accept the same files, and
every complaint knows its row.
"""

from __future__ import annotations

import hashlib
import io
import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.core import MAX_MEAN, CoreSchedule
from tumble.errors import BadInput
from tumble.files import can_log
from tumble.files.csv_rows import NotANumber, Refused, fast_numbers, row_of_numbers
from tumble.files.disk import read_bytes
from tumble.files.run_blocks import NO_BLOCKS, Blocks, blocks_of
from tumble.files.run_layout import (
    COLUMNS,
    NO_WISHES,
    NUMBER,
    Layout,
    Wishes,
    decoded,
    detect,
    is_blank,
    is_comment,
    is_number,
    split,
)
from tumble.files.run_temperature import Temperatures, read_temperatures
from tumble.schedule import CHECK, CLOSED, Schedule


@dataclass(frozen=True)
class Run:
    """A recorded run, position by position in the schedule's order.

    `samples` (positions,): rows of each, 0 where none; `means` (positions, 3); `scatter` (positions, 3): standard
    deviation of one sample (n - 1), NaN below two rows; `unit` of both; `counters`: what was found in the file;
    `sha256`: of its bytes, in hexadecimal digits, empty for a run that is in no file; `unit_told`: by the file or by
    the user, not assumed; `table`: the rows themselves, None where nobody has them; `blocks`: how they move together
    (files.run_blocks); `temperature`: None where it is not told; `passed_over`: sentences about columns that look like
    what they are not.
    """

    samples: Integers
    means: Floats
    scatter: Floats
    unit: str
    counters: dict[str, int]
    sha256: str = ""
    unit_told: bool = True
    table: RunTable | None = None
    blocks: Blocks = NO_BLOCKS
    temperature: Temperatures | None = None
    passed_over: tuple[str, ...] = ()

    @property
    def measured(self) -> Flags:
        """Which positions have a mean: (positions,) bool."""
        return self.samples > 0


def read_measured(
    file: str, schedule: CoreSchedule, wishes: Wishes = NO_WISHES, data: bytes | None = None
) -> tuple[Run, CoreSchedule]:
    """Read a run file as `read_run` does, on a schedule as `on_schedule` takes it. Raises BadInput."""
    return on_schedule(lambda planned: read_run(file, planned, wishes, data), schedule)


def on_schedule(run_on: Callable[[Schedule], Run], schedule: CoreSchedule) -> tuple[Run, CoreSchedule]:
    """A run on a schedule, or where it has positions that close its mountings, on the form of it that has them."""
    if schedule.name in CLOSED:
        closed = CoreSchedule.built_in(CLOSED[schedule.name])
        run = run_on(closed.data)
        if any(run.samples[index] > 0 for index, one in enumerate(closed.data.positions) if one.use == CHECK):
            return run, closed
    return run_on(schedule.data), schedule


def read_run(file: str, schedule: Schedule, wishes: Wishes = NO_WISHES, data: bytes | None = None) -> Run:
    """Read a run file (CSV); `data`: what is in it, if that has been read. Raises BadInput."""
    data = read_bytes(file) if data is None else data
    can_log.refuse(data, file)
    require_text(data, file)
    layout = detect(data, wishes, file)
    table = read_table(data, layout, PositionIndex(schedule), file)
    temperature, passed_over = temperatures(data, layout, file)
    ignored = layout.width - len(COLUMNS) - (temperature is not None)
    told = ignored, hashlib.sha256(data).hexdigest(), temperature, passed_over
    return averaged(table, schedule, layout.unit, layout.unit_told, *told)


def averaged(
    table: RunTable,
    schedule: Schedule,
    unit: str,
    unit_told: bool,
    columns_ignored: int,
    sha256: str = "",
    temperature: Temperatures | None = None,
    passed_over: tuple[str, ...] = (),
) -> Run:
    """The run that the rows of a `table` are."""
    samples, means, scatter, blocks = _average(table, len(schedule.positions))
    measured = int((samples > 0).sum())
    counters = {
        "rows": len(table.index),
        "positions": measured,
        "positions_missing": len(schedule.positions) - measured,
        "blank_lines": table.blanks,
        "comment_lines": table.comments,
        "columns_ignored": columns_ignored,
    }
    given = samples, means, scatter, unit, counters, sha256, unit_told, table, blocks
    return Run(*given, temperature, passed_over)


def require_text(data: bytes, file: str) -> None:
    """Raise BadInput for what is no text, or empty."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise BadInput("UTF-16 text; save it as UTF-8", file, 1)
    zero = data.find(b"\0")
    if zero >= 0:
        raise BadInput("not a text file", file, data.count(b"\n", 0, zero) + 1)
    if not data.strip():
        raise BadInput("the file is empty", file, 1)


@dataclass(frozen=True)
class RunTable:
    """`index` (rows,): each row's position in the schedule; `outputs` (rows, 3); `lines` (rows,): their numbers in the
    file, from 1; lines that were passed over."""

    index: Integers
    outputs: Floats
    lines: Integers
    blanks: int
    comments: int


class PositionIndex:
    """From mounting and position numbers to the index of a position in the schedule."""

    def __init__(self, schedule: Schedule):
        self.mountings = {mounting.number for mounting in schedule.mountings}
        self._table = np.full((256, 256), -1)
        for index, position in enumerate(schedule.positions):
            self._table[position.mounting, position.number] = index

    def of_arrays(self, mountings: Floats, positions: Floats) -> Integers:
        """Indices of many rows; -1 where a number is not whole or the schedule does not have it."""
        known = (mountings >= 0) & (mountings <= 255) & (positions >= 0) & (positions <= 255)
        known &= (mountings == np.floor(mountings)) & (positions == np.floor(positions))
        rows = np.where(known, mountings, 0).astype(np.intp)
        return np.where(known, self._table[rows, np.where(known, positions, 0).astype(np.intp)], -1)

    def of_row(self, mounting: float, position: float) -> int:
        """Index of one row. Raises Refused, saying what the schedule does not have."""
        for column, number in (("mounting", mounting), ("position", position)):
            if number != math.floor(number):
                raise Refused(f"{number!r} is not a whole number", column)
        if mounting not in self.mountings:
            hint = self._are_exchanged(mounting, position) or f"mountings are {_listed(self.mountings)}"
            raise Refused(f"the schedule has no mounting {mounting:.15g}; {hint}", "mounting")
        index = int(self._table[int(mounting), int(position)]) if 0 <= position <= 255 else -1
        if index < 0:
            missing = f"the schedule has no position {position:.15g} in mounting {mounting:.15g}"
            known = np.flatnonzero(self._table[int(mounting)] >= 0).tolist()
            raise Refused(f"{missing}; positions are {_listed(known)}", "position")
        return index

    def _are_exchanged(self, mounting: float, position: float) -> str | None:
        """A question, where the row would be good the other way round."""
        known = position in self.mountings and 0 <= mounting <= 255
        is_good = known and self._table[int(position), int(mounting)] >= 0
        asked = "are mounting and position exchanged? Or is it a run of another schedule (--schedule)?"
        return asked if is_good else None


def _listed(numbers: Iterable[int]) -> str:
    """As "1 to 9", or all of them where some between are missing."""
    known = sorted(numbers)
    if known and len(known) > 2 and known[-1] - known[0] == len(known) - 1:
        return f"{known[0]} to {known[-1]}"
    return ", ".join(map(str, known)) or "none"


def read_table(data: bytes, layout: Layout, positions: PositionIndex, file: str) -> RunTable:
    """All rows of a run file. Raises BadInput with row and column."""
    table = _read_fast(data, layout, positions)
    return table if table is not None else _read_carefully(data, layout, positions, file)


def _read_fast(data: bytes, layout: Layout, positions: PositionIndex) -> RunTable | None:
    """All rows, or None where the file is not plain or not in order."""
    plain = read_plain(data, layout)
    if plain is None:
        return None
    values, lines, blanks = plain
    index = positions.of_arrays(values[:, 0], values[:, 1])
    outputs = values[:, 2:]
    if not (np.abs(outputs) <= MAX_MEAN).all() or (index < 0).any():
        return None
    return RunTable(index, outputs, lines, blanks, layout.comments)


def read_plain(data: bytes, layout: Layout) -> tuple[Floats, Integers, int] | None:
    """The numbers in the layout's columns, their lines, and how many blank lines there are; None where the file is not
    plain."""
    found = fast_numbers(data, _end_of_line(data, layout.header_row), layout)
    if found is None:
        return None
    values, full = found
    lines = layout.header_row + 1 + np.flatnonzero(full)
    blanks = int((~full).sum()) - (0 if full[-1] else 1)  # what follows the last line end is no line
    return values, lines, layout.blanks + blanks


def _end_of_line(data: bytes, row: int) -> int:
    """Where the line after line number `row` begins."""
    end = 0
    for _ in range(row):
        newline = data.find(b"\n", end)
        end = len(data) if newline < 0 else newline + 1
    return end


def _read_carefully(data: bytes, layout: Layout, positions: PositionIndex, file: str) -> RunTable:
    """All rows, line by line."""
    indices: list[int] = []
    outputs, lines = [], []
    blanks, comments = layout.blanks, layout.comments
    for row, line in body_of(data, layout):
        if is_blank(line) or is_comment(line):
            blanks, comments = blanks + is_blank(line), comments + is_comment(line)
            continue
        try:
            index, values = _read_row(line, layout, positions)
        except NotANumber as refused:
            hint = _hint(refused, line, not indices, data, layout, positions)
            raise BadInput(f"{refused}{hint}", file, row, refused.column) from None
        except Refused as refused:
            raise BadInput(str(refused), file, row, refused.column) from None
        indices.append(index)
        outputs.append(values)
        lines.append(row)
    if not indices:
        raise BadInput("no samples after the header", file, layout.header_row)
    return RunTable(np.array(indices), np.array(outputs), np.array(lines), blanks, comments)


def body_of(data: bytes, layout: Layout) -> Iterable[tuple[int, str]]:
    """What follows the header: lines and their numbers."""
    lines = enumerate(io.StringIO(decoded(data), newline=None), start=1)
    return ((row, line) for row, line in lines if row > layout.header_row)


def temperatures(data: bytes, layout: Layout, file: str) -> tuple[Temperatures | None, tuple[str, ...]]:
    """Of a run file, as read_temperatures reads them. Raises BadInput."""
    rows = ((row, line) for row, line in body_of(data, layout) if not is_blank(line) and not is_comment(line))
    return read_temperatures(rows, layout, file)


def _hint(refused: NotANumber, line: str, is_first: bool, data: bytes, layout: Layout, positions: PositionIndex) -> str:
    """What to do about it. Another option is advised only where all rows can be read with it: else one piece of advice
    would lead to the next."""
    if is_first and not any(map(is_number, split(line, layout.delimiter))):
        return " (a row of units? Delete it, or begin it with #; --unit says the unit)"
    if refused.column == "mounting":
        return f"; mountings are {_listed(positions.mountings)}"
    if not NUMBER.fullmatch(re.sub(r"[.,\s']", "", refused.text)):
        return ""
    other = replace(layout, decimal="." if layout.decimal == "," else ",")
    if other.decimal in refused.text and _has_numbers_alone(data, other, positions):
        return f" (its decimal mark? see --decimal {other.decimal})"
    return " (write all numbers with the same decimal mark, and without thousands separators)"


def _has_numbers_alone(data: bytes, layout: Layout, positions: PositionIndex) -> bool:
    """Can all rows be read, as far as numbers go?"""
    for _, line in body_of(data, layout):
        try:
            if not is_blank(line) and not is_comment(line):
                _read_row(line, layout, positions)
        except NotANumber:
            return False
        except Refused:
            continue
    return True


def _read_row(line: str, layout: Layout, positions: PositionIndex) -> tuple[int, list[float]]:
    values = row_of_numbers(line, layout, COLUMNS)
    return positions.of_row(*values[:2]), values[2:]


def _average(table: RunTable, positions: int) -> tuple[Integers, Floats, Floats, Blocks]:
    """Samples, means, scatter and blocks per position. Sums are exact (fsum): to them the order does not matter."""
    samples = np.bincount(table.index, minlength=positions)
    means, scatter = np.full((2, positions, 3), np.nan)
    grouped = np.split(table.outputs[np.argsort(table.index, kind="stable")], np.cumsum(samples)[:-1])
    for index, rows in enumerate(grouped):
        if len(rows) > 0:
            means[index] = [math.fsum(channel) / len(rows) for channel in rows.T.tolist()]
        if len(rows) > 1:
            scatter[index] = rows.std(axis=0, ddof=1)
    return samples, means, scatter, blocks_of(grouped)
