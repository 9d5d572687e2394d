"""The rows of a run file as numbers, fast where the file is plain, carefully where it is not.

The fast way hands plain files to numpy's parser after proving, from the places of delimiters and line ends, that every
row has as many fields as the header. Whatever it does not take for certain, it leaves to the careful way, which reads
line by line and is the one that complains: so both accept the same files, and every complaint knows its row.
"""

from __future__ import annotations

import csv
import io
import math
from dataclasses import dataclass

import numpy as np

from tumble.core import MAX_MEAN
from tumble.errors import BadInput, quoted
from tumble.files.run_layout import COLUMNS, NUMBER, Dialect, decoded, is_blank, is_comment, split
from tumble.schedule import Schedule

_NOT_FINITE = {"nan", "inf", "infinity"}


@dataclass(frozen=True)
class RunTable:
    """`index` (rows,): each row's position in the schedule; `outputs` (rows, 3); lines that were passed over."""

    index: np.ndarray
    outputs: np.ndarray
    blanks: int
    comments: int


class PositionIndex:
    """From mounting and position numbers to the index of a position in the schedule."""

    def __init__(self, schedule: Schedule):
        self._mountings = {mounting.number for mounting in schedule.mountings}
        self._table = np.full((256, 256), -1)
        for index, position in enumerate(schedule.positions):
            self._table[position.mounting, position.number] = index

    def of_arrays(self, mountings: np.ndarray, positions: np.ndarray) -> np.ndarray:
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
        if mounting not in self._mountings:
            raise _Refused(f"the schedule has no mounting {mounting:.15g}", "mounting")
        index = int(self._table[int(mounting), int(position)]) if 0 <= position <= 255 else -1
        if index < 0:
            raise _Refused(f"the schedule has no position {position:.15g} in mounting {mounting:.15g}", "position")
        return index


class _Refused(Exception):
    """What is wrong with a row, and in which column."""

    def __init__(self, message: str, column: str | None = None):
        super().__init__(message)
        self.column = column


def read_table(data: bytes, dialect: Dialect, positions: PositionIndex, file: str) -> RunTable:
    """All rows of a run file. Raises BadInput with row and column."""
    table = _read_fast(data, dialect, positions)
    return table if table is not None else _read_carefully(data, dialect, positions, file)


def _read_fast(data: bytes, dialect: Dialect, positions: PositionIndex) -> RunTable | None:
    """All rows, or None where the file is not plain or not in order."""
    body = _end_of_line(data, dialect.header_row)
    if not _is_plain(data, body, dialect):
        return None
    blanks = _blank_lines(data, body, dialect)
    if blanks is None:
        return None
    if dialect.decimal == ",":
        data = data.replace(b",", b".")
    try:
        values = np.loadtxt(
            io.BytesIO(data),
            delimiter=dialect.delimiter,
            skiprows=dialect.header_row,
            usecols=dialect.indices,
            comments=None,
            encoding="latin-1",
            ndmin=2,
        )
    except ValueError:
        return None
    index = positions.of_arrays(values[:, 0], values[:, 1])
    outputs = values[:, 2:]
    if not (np.abs(outputs) <= MAX_MEAN).all() or (index < 0).any():
        return None
    return RunTable(index, outputs, dialect.blanks + blanks, dialect.comments)


def _end_of_line(data: bytes, row: int) -> int:
    """Where the line after line number `row` begins."""
    end = 0
    for _ in range(row):
        newline = data.find(b"\n", end)
        end = len(data) if newline < 0 else newline + 1
    return end


def _is_plain(data: bytes, body: int, dialect: Dialect) -> bool:
    """No quotes, comments or lone carriage returns; one decimal mark, and that not the delimiter."""
    unusual = [b'"', b"#"] + ([b"."] if dialect.decimal == "," else [])
    return (
        not any(data.find(sign, body) >= 0 for sign in unusual)
        and data.count(b"\r") == data.count(b"\r\n")
        and dialect.decimal != dialect.delimiter
        and dialect.delimiter.isascii()
    )


def _blank_lines(data: bytes, body: int, dialect: Dialect) -> int | None:
    """How many lines of the body are empty; None unless each of the others has as many fields as the header."""
    signs = np.frombuffer(data, dtype=np.uint8)[body:]
    ends = np.append(np.flatnonzero(signs == ord("\n")), len(signs))
    delimiters = np.searchsorted(np.flatnonzero(signs == ord(dialect.delimiter)), ends)
    lengths = np.diff(ends, prepend=-1) - 1
    carriage_returns = np.zeros(len(ends), dtype=bool)
    carriage_returns[lengths == 1] = signs[ends[lengths == 1] - 1] == ord("\r")
    empty = (lengths == 0) | carriage_returns
    full = np.diff(delimiters, prepend=0) == dialect.width - 1
    if not (empty | full).all() or empty.all():
        return None
    return int(empty.sum()) - (1 if empty[-1] else 0)  # what follows the last line end is no line


def _read_carefully(data: bytes, dialect: Dialect, positions: PositionIndex, file: str) -> RunTable:
    """All rows, line by line."""
    indices, outputs = [], []
    blanks, comments = dialect.blanks, dialect.comments
    for row, line in enumerate(io.StringIO(decoded(data), newline=None), start=1):
        if row <= dialect.header_row:
            continue
        if is_blank(line) or is_comment(line):
            blanks, comments = blanks + is_blank(line), comments + is_comment(line)
            continue
        try:
            index, values = _read_row(line, dialect, positions)
        except _Refused as refused:
            raise BadInput(str(refused), file, row, refused.column) from None
        indices.append(index)
        outputs.append(values)
    if not indices:
        raise BadInput("no samples after the header", file, dialect.header_row)
    return RunTable(np.array(indices), np.array(outputs), blanks, comments)


def _read_row(line: str, dialect: Dialect, positions: PositionIndex) -> tuple[int, list[float]]:
    try:
        fields = split(line, dialect.delimiter)
    except csv.Error as error:
        raise _Refused(f"cannot be split into columns: {error}") from None
    if len(fields) != dialect.width:
        raise _Refused(f"{len(fields)} fields, but the header has {dialect.width}")
    values = [_number(fields[index], column, dialect) for column, index in zip(COLUMNS, dialect.indices)]
    return positions.of_row(*values[:2]), values[2:]


def _number(text: str, column: str, dialect: Dialect) -> float:
    if text.lower().lstrip("+-") in _NOT_FINITE:
        raise _Refused(f"{quoted(text)} is not a finite number", column)
    pointed = text.replace(",", ".") if dialect.decimal == "," and "." not in text else text
    if not NUMBER.fullmatch(pointed) or (dialect.decimal == "," and "." in text):
        other = "." if dialect.decimal == "," else ","
        hint = f" (its decimal mark? see --decimal {other})" if other in text else ""
        raise _Refused((f"{quoted(text)} is not a number" + hint) if text else "no value", column)
    value = float(pointed)
    if abs(value) > MAX_MEAN:
        raise _Refused(f"{quoted(text)} is out of range", column)
    return value
