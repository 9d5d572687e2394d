"""Rows of a CSV file whose layout is known, as numbers: fast where many lines are plain, carefully where one is not.

What a run file and measured data have in common. The fast way proves first, from the places of delimiters and line
ends, that every line has as many fields as the header; what it does not take for certain is left to the careful way,
line by line, which is the one that complains.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.core import MAX_MEAN
from tumble.errors import quoted
from tumble.files.run_layout import NUMBER, Layout, decoded, split

LARGEST_OUTPUT: float = MAX_MEAN  # of either sign: beyond, no output is believed
_NOT_FINITE = {"nan", "inf", "infinity"}
_DIGITS = re.compile(r"[+-]?\d*(e[+-]?\d+)?", re.IGNORECASE)  # what a decimal comma leaves on either side of it


class Refused(Exception):
    """What is wrong with a row, and in which column."""

    def __init__(self, message: str, column: str | None = None):
        super().__init__(message)
        self.column = column


class NotANumber(Refused):
    """A `text` that is none with the decimal mark of the file."""

    def __init__(self, text: str, column: str):
        super().__init__(f"{quoted(text)} is not a number" if text else "no value", column)
        self.text = text


def fast_numbers(data: bytes, body: int, layout: Layout) -> tuple[Floats, Flags] | None:
    """The wanted columns (rows, wanted) of all that follows byte `body`, where a line begins; and which of its lines
    (lines,) hold a row, what follows the last line end being one more. None where that is not plain or not in order."""
    if not _is_plain(data, body, layout):
        return None
    full = _full_lines(data, body, layout)
    if full is None:
        return None
    if layout.decimal == ",":
        data = data.replace(b",", b".")
    stream = io.BytesIO(data)
    stream.seek(body)
    try:
        values = np.loadtxt(
            stream, delimiter=layout.delimiter, usecols=layout.indices, comments=None, encoding="latin-1", ndmin=2
        )
    except ValueError:
        return None
    return values, full


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


def body_of(data: bytes, layout: Layout) -> Iterable[tuple[int, str]]:
    """What follows the header: lines and their numbers."""
    lines = enumerate(io.StringIO(decoded(data), newline=None), start=1)
    return ((row, line) for row, line in lines if row > layout.header_row)


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


def row_of_numbers(line: str, layout: Layout, columns: tuple[str, ...]) -> list[float]:
    """The wanted `columns` of one line. Raises Refused."""
    try:
        fields = split(line, layout.delimiter)
    except csv.Error as error:
        raise Refused(f"cannot be split into columns: {error}") from None
    if len(fields) != layout.width:
        raise Refused(wrong_width(fields, layout.width, layout.delimiter))
    return [_number(fields[index], column, layout) for column, index in zip(columns, layout.indices)]


def wrong_width(fields: list[str], width: int, delimiter: str, advice: str = "") -> str:
    """What to say of a row that has not as many fields as the header, with `advice` unless there is a better one."""
    if delimiter == "," and len(fields) > width and all(map(_DIGITS.fullmatch, fields)):
        advice = "; if some of its commas are decimal marks, write the file with semicolons or with decimal points"
    return f"{len(fields)} fields, but the header has {width}{advice}"


def _number(text: str, column: str, layout: Layout) -> float:
    if text.lower().lstrip("+-") in _NOT_FINITE:
        raise Refused(f"{quoted(text)} is not a finite number", column)
    pointed = text.replace(",", ".") if layout.decimal == "," and "." not in text else text
    if not NUMBER.fullmatch(pointed) or (layout.decimal == "," and "." in text):
        raise NotANumber(text, column)
    value = float(pointed)
    if abs(value) > LARGEST_OUTPUT:
        raise Refused(f"{quoted(text)} is out of range", column)
    return value
