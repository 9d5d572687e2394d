"""Run files: recorded samples in, one mean per position and channel out.

A file goes one way: its bytes, its layout, its rows as numbers, their means. Rows are read fast where the file is
plain, carefully where it is not. The fast way hands plain files to numpy's parser after proving, from the places of
delimiters and line ends, that every row has as many fields as the header. Whatever it does not take for certain, it
leaves to the careful way, which reads line by line and is the one that complains: so both accept the same files, and
every complaint knows its row.
"""

from __future__ import annotations

import csv
import hashlib
import io
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.core import MAX_MEAN, CoreSchedule
from tumble.errors import BadInput, quoted
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
from tumble.schedule import CHECK, CLOSED, Schedule

_NOT_FINITE = {"nan", "inf", "infinity"}


@dataclass(frozen=True)
class Run:
    """A recorded run, position by position in the schedule's order.

    `samples` (positions,): rows of each, 0 where none; `means` (positions, 3); `scatter` (positions, 3): standard
    deviation of one sample (n - 1), NaN below two rows; `unit` of both; `counters`: what was found in the file;
    `sha256`: of its bytes, in hexadecimal digits, empty for a run that is in no file; `unit_told`: by the file or by
    the user, not assumed; `table`: the rows themselves, None where nobody has them; `blocks`: how they move together
    (files.run_blocks).
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

    @property
    def measured(self) -> Flags:
        """Which positions have a mean: (positions,) bool."""
        return self.samples > 0


def read_measured(file: str, schedule: CoreSchedule, wishes: Wishes = NO_WISHES) -> tuple[Run, CoreSchedule]:
    """Read a run file on a schedule, or where the run has positions that close its mountings, on the form of it that
    has them. Raises BadInput."""
    if schedule.name in CLOSED:
        closed = CoreSchedule.built_in(CLOSED[schedule.name])
        run = read_run(file, closed.data, wishes)
        if any(run.samples[index] > 0 for index, one in enumerate(closed.data.positions) if one.use == CHECK):
            return run, closed
    return read_run(file, schedule.data, wishes), schedule


def read_run(file: str, schedule: Schedule, wishes: Wishes = NO_WISHES) -> Run:
    """Read a run file (CSV). Raises BadInput with file, row and column."""
    data = read_bytes(file)
    require_text(data, file)
    layout = detect(data, wishes, file)
    table = read_table(data, layout, PositionIndex(schedule), file)
    samples, means, scatter, blocks = _average(table, len(schedule.positions))
    measured = int((samples > 0).sum())
    counters = {
        "rows": len(table.index),
        "positions": measured,
        "positions_missing": len(schedule.positions) - measured,
        "blank_lines": table.blanks,
        "comment_lines": table.comments,
        "columns_ignored": layout.width - len(COLUMNS),
    }
    digest = hashlib.sha256(data).hexdigest()
    return Run(samples, means, scatter, layout.unit, counters, digest, layout.unit_told, table, blocks)


def require_text(data: bytes, file: str) -> None:
    """Raises BadInput for what is no text, or none at all."""
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
        """Index of one row. Raises _Refused, saying what the schedule does not have."""
        for column, number in (("mounting", mounting), ("position", position)):
            if number != math.floor(number):
                raise _Refused(f"{number!r} is not a whole number", column)
        if mounting not in self.mountings:
            hint = self._are_exchanged(mounting, position) or f"mountings are {_listed(self.mountings)}"
            raise _Refused(f"the schedule has no mounting {mounting:.15g}; {hint}", "mounting")
        index = int(self._table[int(mounting), int(position)]) if 0 <= position <= 255 else -1
        if index < 0:
            missing = f"the schedule has no position {position:.15g} in mounting {mounting:.15g}"
            known = np.flatnonzero(self._table[int(mounting)] >= 0).tolist()
            raise _Refused(f"{missing}; positions are {_listed(known)}", "position")
        return index

    def _are_exchanged(self, mounting: float, position: float) -> str | None:
        """A question, where the row would be good the other way round."""
        known = position in self.mountings and 0 <= mounting <= 255
        is_good = known and self._table[int(position), int(mounting)] >= 0
        return "are mounting and position exchanged?" if is_good else None


def _listed(numbers: Iterable[int]) -> str:
    """As "1 to 9", or all of them where some between are missing."""
    known = sorted(numbers)
    if known and len(known) > 2 and known[-1] - known[0] == len(known) - 1:
        return f"{known[0]} to {known[-1]}"
    return ", ".join(map(str, known)) or "none"


class _Refused(Exception):
    """What is wrong with a row, and in which column."""

    def __init__(self, message: str, column: str | None = None):
        super().__init__(message)
        self.column = column


class _NotANumber(_Refused):
    """A `text` that is none with the decimal mark of the file."""

    def __init__(self, text: str, column: str):
        super().__init__(f"{quoted(text)} is not a number" if text else "no value", column)
        self.text = text


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
    body = _end_of_line(data, layout.header_row)
    if not _is_plain(data, body, layout):
        return None
    full = _full_lines(data, body, layout)
    if full is None:
        return None
    if layout.decimal == ",":
        data = data.replace(b",", b".")
    try:
        values = np.loadtxt(
            io.BytesIO(data),
            delimiter=layout.delimiter,
            skiprows=layout.header_row,
            usecols=layout.indices,
            comments=None,
            encoding="latin-1",
            ndmin=2,
        )
    except ValueError:
        return None
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


def _is_plain(data: bytes, body: int, layout: Layout) -> bool:
    """No quotes, comments or lone carriage returns; one decimal mark, and that not the delimiter."""
    unusual = [b'"', b"#"] + ([b"."] if layout.decimal == "," else [])
    return (
        not any(data.find(sign, body) >= 0 for sign in unusual)
        and data.count(b"\r") == data.count(b"\r\n")
        and layout.decimal != layout.delimiter
        and layout.delimiter.isascii()
    )


def _full_lines(data: bytes, body: int, layout: Layout) -> Flags | None:
    """Which lines of the body hold a row, what follows the last line end being one more; None unless each has as many
    fields as the header, or nothing."""
    signs = np.frombuffer(data, dtype=np.uint8)[body:]
    ends = np.append(np.flatnonzero(signs == ord("\n")), len(signs))
    delimiters = np.searchsorted(np.flatnonzero(signs == ord(layout.delimiter)), ends)
    lengths = np.diff(ends, prepend=-1) - 1
    carriage_returns = np.zeros(len(ends), dtype=bool)
    carriage_returns[lengths == 1] = signs[ends[lengths == 1] - 1] == ord("\r")
    empty: Flags = (lengths == 0) | carriage_returns
    full = np.diff(delimiters, prepend=0) == layout.width - 1
    return None if not (empty | full).all() or empty.all() else ~empty


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
        except _NotANumber as refused:
            hint = _hint(refused, line, not indices, data, layout, positions)
            raise BadInput(f"{refused}{hint}", file, row, refused.column) from None
        except _Refused as refused:
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


def _hint(
    refused: _NotANumber, line: str, is_first: bool, data: bytes, layout: Layout, positions: PositionIndex
) -> str:
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
        except _NotANumber:
            return False
        except _Refused:
            continue
    return True


def _read_row(line: str, layout: Layout, positions: PositionIndex) -> tuple[int, list[float]]:
    try:
        fields = split(line, layout.delimiter)
    except csv.Error as error:
        raise _Refused(f"cannot be split into columns: {error}") from None
    if len(fields) != layout.width:
        raise _Refused(f"{len(fields)} fields, but the header has {layout.width}")
    values = [_number(fields[index], column, layout) for column, index in zip(COLUMNS, layout.indices)]
    return positions.of_row(*values[:2]), values[2:]


def _number(text: str, column: str, layout: Layout) -> float:
    if text.lower().lstrip("+-") in _NOT_FINITE:
        raise _Refused(f"{quoted(text)} is not a finite number", column)
    pointed = text.replace(",", ".") if layout.decimal == "," and "." not in text else text
    if not NUMBER.fullmatch(pointed) or (layout.decimal == "," and "." in text):
        raise _NotANumber(text, column)
    value = float(pointed)
    if abs(value) > MAX_MEAN:
        raise _Refused(f"{quoted(text)} is out of range", column)
    return value


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
