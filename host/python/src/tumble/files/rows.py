"""Rows of CSV as numbers: the one parser of run files, of recordings and of measured data; which position of the
schedule a row belongs to; and its temperature, degrees Celsius.

C (binding/rows.c) takes lines of whose numbers it is certain, and stops at any other. That one is read here, which is
the one way that complains: so what C takes does not matter to what is accepted, and every complaint knows its row,
its column and its reason.

A column that only looks like one of temperatures is passed over; one that the user names is read or refused.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Floats, Integers
from tumble.core import MAX_MEAN
from tumble.errors import BadInput, quoted
from tumble.files import frames
from tumble.files.run_layout import NO_VALUE, NUMBER, Column, Layout, as_text, split, temperature_column
from tumble.schedule import Schedule

LARGEST_OUTPUT: float = MAX_MEAN  # of either sign: beyond, no output is believed
NUMBERS = 256  # of mountings and of positions: 0 to 255
OUTPUTS, LINE, TIME, FELT = slice(0, 3), 3, 4, 5  # columns of what RowParser gives
_NOT_FINITE = {"nan", "inf", "infinity"}
_DIGITS = re.compile(r"[+-]?\d*(e[+-]?\d+)?", re.IGNORECASE)  # what a decimal comma leaves on either side of it
_ROLES = {name: role for role, name in enumerate(("ux", "uy", "uz", "mounting", "position", "time", "temperature"))}
_SHORTEST_ROW = 6  # bytes: three fields of a digit each, and what ends them
_AT_ONCE = 1 << 22  # bytes
_MOST_CAREFUL = 1 << 10  # lines that are read here before C is tried again


class Refused(Exception):
    """What is wrong with a row, and in which column; of a parser, the number of its line (`row`), and the data from
    there on (`rest`)."""

    def __init__(self, message: str, column: str | None = None):
        super().__init__(message)
        self.column, self.row, self.rest = column, 0, b""


class NotANumber(Refused):
    """A `text` that is none with the decimal mark of the file."""

    def __init__(self, text: str, column: str):
        super().__init__(f"{quoted(text)} is not a number" if text else "no value", column)
        self.text = text


class PositionIndex:
    """From mounting and position numbers to the index of a position in the schedule; `table` (256, 256), -1: none."""

    def __init__(self, schedule: Schedule):
        self.mountings = {mounting.number for mounting in schedule.mountings}
        self.hint = f"mountings are {listed(self.mountings)}"
        if schedule.is_inclined:
            first, *_, last = schedule.mountings
            again = len(schedule.mountings) > 3 and last.tilt_deg == first.tilt_deg
            numbers = listed(self.mountings - {last.number} if again else self.mountings)
            self.hint = f"mountings are {numbers}{f', and {last.number} for the first again' if again else ''}"
            self.hint += "; the column holds the number of the inclination"
        self.table = np.full((NUMBERS, NUMBERS), -1, dtype=np.int32)
        for index, position in enumerate(schedule.positions):
            self.table[position.mounting, position.number] = index

    def of_arrays(self, mountings: Floats, positions: Floats) -> Integers:
        """Indices of many rows; -1 where a number is not whole or the schedule does not have it."""
        known = (mountings >= 0) & (mountings < NUMBERS) & (positions >= 0) & (positions < NUMBERS)
        known &= (mountings == np.floor(mountings)) & (positions == np.floor(positions))
        rows = np.where(known, mountings, 0).astype(np.intp)
        return np.where(known, self.table[rows, np.where(known, positions, 0).astype(np.intp)], -1)

    def of_row(self, mounting: float, position: float) -> int:
        """Index of one row. Raises Refused, saying what the schedule does not have."""
        for column, number in (("mounting", mounting), ("position", position)):
            if number != math.floor(number):
                raise Refused(f"{number!r} is not a whole number", column)
        if mounting not in self.mountings:
            hint = self.hint
            if position in self.mountings and 0 <= mounting < NUMBERS and self.table[int(position), int(mounting)] >= 0:
                hint = "are mounting and position exchanged? Or is it a run of another schedule (--schedule)?"
            raise Refused(f"the schedule has no mounting {mounting:.15g}; {hint}", "mounting")
        index = int(self.table[int(mounting), int(position)]) if 0 <= position < NUMBERS else -1
        if index < 0:
            missing = f"the schedule has no position {position:.15g} in mounting {mounting:.15g}"
            known = np.flatnonzero(self.table[int(mounting)] >= 0).tolist()
            raise Refused(f"{missing}; positions are {listed(known)}", "position")
        return index


class Anywhere(PositionIndex):
    """For rows whose schedule is not known yet: every number is good; the index is 256 mounting + position."""

    def __init__(self) -> None:
        self.mountings = set(range(NUMBERS))
        self.hint = f"mountings are {listed(self.mountings)}"
        self.table = np.arange(NUMBERS**2, dtype=np.int32).reshape(NUMBERS, NUMBERS)


def listed(numbers: Iterable[int]) -> str:
    """As "1 to 9", or all of them where some between are missing."""
    known = sorted(numbers)
    if known and len(known) > 2 and known[-1] - known[0] == len(known) - 1:
        return f"{known[0]} to {known[-1]}"
    return ", ".join(map(str, known)) or "none"


Part = tuple[Integers, Floats]  # of rows: index of the position (rows,); the columns OUTPUTS, LINE and so on


class RowParser:
    """The lines below the header of a layout, block by block. `columns`: the names of those that the layout's indices
    are. `positions`: what mounting and position mean, where these are wanted; else every index is 0. `decoded` makes
    text of the bytes of a line. `fast`: by C where that can be.

    `recorded`: as loggers write them. A row without a value is left out (`lost`), empty fields behind the last column
    are none, points may stand where the decimal mark is a comma; rows have TIME, of a column of numbers whose place is
    `time`, and FELT; of columns `texts` (places by name) the fields are kept, by name in `texts`.

    Counted are `rows`, `blanks` and `comments`; `line`: the number of the next one; `is_marked`: has a number of the
    rows a decimal mark?
    """

    def __init__(
        self,
        layout: Layout,
        columns: tuple[str, ...],
        positions: PositionIndex | None = None,
        decoded: Callable[[bytes], str] = as_text,
        fast: bool = True,
        recorded: bool = False,
        time: int | None = None,
        texts: Mapping[str, int] | None = None,
    ):
        self.layout, self.thermometer = layout, Thermometer(layout)
        self.line, self.rows, self.blanks, self.comments, self.lost = layout.header_row + 1, 0, 0, 0, 0
        self.texts: dict[str, list[str]] = {name: [] for name in texts or {}}
        self.is_marked = False
        self._columns, self._positions, self._decoded = columns, positions, decoded
        self._recorded, self._time, self._texts = recorded, time, texts or {}
        self._width = 6 if recorded else 4
        self._index, self._values = np.empty(0, dtype=np.uint16), np.empty((0, self._width))
        roles = {index: _ROLES[name] for name, index in zip(columns, layout.indices)}
        roles |= {} if time is None else {time: _ROLES["time"]}
        roles |= {} if self.thermometer.index is None else {self.thermometer.index: _ROLES["temperature"]}
        wanted = len(columns) + (time is not None) + (self.thermometer.index is not None)
        can_be_plain = layout.decimal != layout.delimiter and layout.delimiter.isascii() and len(roles) == wanted
        self._plain = self._for_c(roles) if fast and not self._texts and can_be_plain else None

    def _for_c(self, roles: dict[int, int]) -> Any:
        """What C must know of the lines."""
        self._felt, self._roles = self.thermometer.index, np.full(self.layout.width, -1, dtype=np.int8)
        self._roles[list(roles)] = list(roles.values())
        self._found = ffi.new("rows_found_t *", {"low_c": math.inf, "high_c": -math.inf})
        return ffi.new(
            "rows_layout_t *",
            {
                "delimiter": self.layout.delimiter.encode(),
                "decimal": self.layout.decimal.encode(),
                "columns": self.layout.width,
                "width": self._width,
                "role": ffi.from_buffer("int8_t[]", self._roles),
                "position": (
                    ffi.NULL if self._positions is None else ffi.from_buffer("int32_t[]", self._positions.table)
                ),
                "coldest": LOWEST_C,
                "hottest": HIGHEST_C,
            },
        )

    def parse(self, data: bytes) -> Part:
        """All rows of a block, which ends where a line does. Raises Refused for the first that is none."""
        if not data.endswith(b"\n"):
            data += b"\n"
        parts: list[Part] = []
        at, careful = 0, 1
        while at < len(data):
            if self._plain is not None:
                rows = self.rows
                at += self._take_plain(data, at, parts)
                careful = 1 if self.rows > rows else min(2 * careful, _MOST_CAREFUL)
                end = at
                for _ in range(careful):
                    end = data.find(b"\n", end) + 1 or len(data)
            else:
                end = data.rfind(b"\n", at, at + _AT_ONCE) + 1 or len(data)
            if at < end:
                parts.append(self._take_carefully(data, at, end))
            at = end
        if len(parts) == 1:
            return parts[0]
        index, values = zip(*parts) if parts else ((self._index[:0],), (self._values[:0],))
        return np.concatenate(index), np.concatenate(values)

    def _take_plain(self, data: bytes, at: int, parts: list[Part]) -> int:
        """The lines from `at` up to the first that is not plain. Returns their bytes."""
        if self._felt is not None and self.thermometer.index is None:
            self._roles[self._felt], self._felt = -1, None
        size, found = len(data) - at, self._found
        if size > _AT_ONCE:
            size = (data.rfind(b"\n", at, at + _AT_ONCE) + 1 or data.find(b"\n", at) + 1) - at
        if len(self._index) < (room := size // _SHORTEST_ROW + 1):
            self._index, self._values = np.empty(room, dtype=np.uint16), np.empty((room, self._width))
        index, values = ffi.from_buffer("uint16_t[]", self._index), ffi.from_buffer("double[]", self._values)
        lib.rows_parse(self._plain, ffi.from_buffer("char[]", data) + at, size, self.line, index, values, found)
        self.thermometer.take_range(found.low_c, found.high_c)
        self.is_marked |= found.marked
        self.rows, self.blanks, self.line = (
            self.rows + found.rows, self.blanks + found.blanks, self.line + found.rows + found.blanks
        )  # fmt: skip
        if found.rows:
            parts.append((self._index[: found.rows].copy(), self._values[: found.rows].copy()))
        return int(found.bytes)

    def _take_carefully(self, data: bytes, at: int, end: int) -> Part:
        """The lines between two places."""
        index: list[int] = []
        values: list[list[float]] = []
        for line in data[at:end].splitlines(keepends=True):
            text = self._decoded(line).rstrip("\r\n")
            if not text.strip():
                self.blanks += 1
            elif text.startswith("#"):
                self.comments += 1
            else:
                try:
                    row = self._read_row(text)
                except Refused as refused:
                    refused.row, refused.rest = self.line, data[at:]
                    raise
                if row is None:
                    self.lost += 1
                else:
                    index.append(row[0])
                    values.append(row[1])
                    self.rows += 1
            self.line += 1
            at += len(line)
        return np.array(index, dtype=np.uint16), np.array(values).reshape(-1, self._width)

    def can_read(self, data: bytes) -> bool:
        """Are the wanted fields of these lines numbers, whatever else is wrong with some of them?"""
        for line in map(self._decoded, data.splitlines()):
            if line.strip() and not line.startswith("#"):
                try:
                    self._read_row(line)
                except NotANumber:
                    return False
                except Refused:
                    pass
        return True

    def _read_row(self, line: str) -> tuple[int, list[float]] | None:
        fields, layout = self._fields(line), self.layout
        numbers = []
        for column, place in zip(self._columns, layout.indices):
            if (number := self._number(fields[place], column)) is None:
                return None
            numbers.append(number)
        index = 0 if self._positions is None else self._positions.of_row(*numbers[:2])
        felt = math.nan if self.thermometer.index is None else self.thermometer.take(fields, self.line)
        self.is_marked |= any(layout.decimal in fields[place] for place in layout.indices)
        values = [*numbers[-3:], float(self.line)]
        if self._recorded:
            values += [math.nan if self._time is None else self._pointed(fields[self._time], "time"), felt]
            for name, place in self._texts.items():
                self.texts[name].append(fields[place])
        return index, values

    def _fields(self, line: str) -> list[str]:
        width, delimiter = self.layout.width, self.layout.delimiter
        try:
            fields = split(line, delimiter)
        except csv.Error as error:
            raise Refused(f"cannot be split into columns: {error}") from None
        if self._recorded and len(fields) > width and not any(fields[width:]):
            return fields[:width]
        if len(fields) != width:
            advice = "; delete the row, or begin it with #" if self._recorded else ""
            if delimiter == "," and len(fields) > width and all(map(_DIGITS.fullmatch, fields)):
                advice = (
                    "; if some of its commas are decimal marks, write the file with semicolons or with decimal points"
                )
            raise Refused(f"{len(fields)} fields, but the header has {width}{advice}")
        return fields

    def _number(self, text: str, column: str) -> float | None:
        """None: a logger had no value."""
        bare = text.lower().lstrip("+-")
        if self._recorded and bare in NO_VALUE:
            return None
        if not self._recorded and bare in _NOT_FINITE:
            raise Refused(f"{quoted(text)} is not a finite number", column)
        if self.layout.decimal == "," and "." in text and not self._recorded:
            raise NotANumber(text, column)
        value = self._pointed(text, column)
        if abs(value) > LARGEST_OUTPUT:
            raise Refused(f"{quoted(text)} is out of range", column)
        return value

    def _pointed(self, text: str, column: str) -> float:
        """Of a text with the layout's decimal mark. Raises NotANumber."""
        pointed = text.replace(",", ".") if self.layout.decimal == "," else text
        if not NUMBER.fullmatch(pointed):
            raise NotANumber(text, column)
        return float(pointed)


LOWEST_C, HIGHEST_C = -100.0, 230.0  # beyond any block; room temperature in kelvins is above
OF_RUN_FILE, OF_ENVIRONMENT = "run_file", "environment"
_CELSIUS = re.compile(r"(\u00b0|deg ?)?C|celsius", re.IGNORECASE)


@dataclass(frozen=True)
class Temperatures:
    """Of a run, from `low_c` to `high_c`; `source`: OF_RUN_FILE, or OF_ENVIRONMENT of the stand file."""

    low_c: float
    high_c: float
    source: str

    @property
    def text(self) -> str:
        """As `range_text` has it."""
        return range_text(self.low_c, self.high_c)


def range_text(low_c: float, high_c: float) -> str:
    """Such as "20.5 deg C" or "20 to 21.5 deg C"."""
    low, high = f"{low_c:.3g}", f"{high_c:.3g}"
    return f"{low} deg C" if low == high else f"{low} to {high} deg C"


class Thermometer:
    """The temperatures of rows, as far as they are wanted: `index` of their column, None where there
    is none or where a row has shown that they are no temperatures."""

    def __init__(self, layout: Layout):
        self._layout, self._low_c, self._high_c = layout, math.inf, -math.inf
        self._odd: _Odd | None = None
        self._values: dict[str, float] = {"": math.nan}  # a thermometer gives the same few values again and again
        column = layout.temperature
        self.index = None if column is None or not _is_celsius(column) else column.index

    def take(self, fields: list[str], row: int) -> float:
        """What a row says; NaN where it tells nothing."""
        assert self.index is not None
        text = fields[self.index]
        if text not in self._values:
            pointed = text.replace(",", ".") if self._layout.decimal == "," else text
            if not NUMBER.fullmatch(pointed) or not LOWEST_C <= float(pointed) <= HIGHEST_C:
                self._odd, self.index = (_no_temperature(quoted(text)), row), None
                return math.nan
            self._values[text] = float(pointed)
            self.take_range(self._values[text], self._values[text])
        return self._values[text]

    def take_range(self, low_c: float, high_c: float) -> None:
        """Of other rows; an empty range tells nothing."""
        self._low_c, self._high_c = min(self._low_c, low_c), max(self._high_c, high_c)

    def told(self, file: str) -> tuple[Temperatures | None, tuple[str, ...]]:
        """By all rows, and sentences about a column that is passed over. Raises BadInput with row and column."""
        known = Temperatures(self._low_c, self._high_c, OF_RUN_FILE) if self._low_c <= self._high_c else None
        return _told(self._layout.temperature, self._layout.doubt, self._odd, known, file)


def temperatures_of_table(
    table: Any, columns: dict[str, str], rows: int, name: str
) -> tuple[Temperatures | None, tuple[str, ...]]:
    """The range of a table of files.frames with so many `rows`, of which `columns` (names by name) are told; and
    the same sentences."""
    column, doubt = temperature_column(frames.names_of(table), columns)
    odd, known = (None, None) if column is None or not _is_celsius(column) else _of_table(table, column, rows, name)
    return _told(column, doubt, odd, known, name)


def temperatures_of_rows(table: Any, columns: dict[str, str], name: str) -> Floats:
    """Of every row of such a table, deg C. Raises BadInput where no column tells them."""
    column, _ = temperature_column(frames.names_of(table), columns)
    if column is None or not _is_celsius(column):
        raise BadInput("has no column temperature, deg C", name)
    return frames.column_of(table, column.index, name)


_Odd = tuple[str, int | None]  # why a column is none of temperatures, and in which row


def _of_table(table: Any, column: Column, rows: int, name: str) -> tuple[_Odd | None, Temperatures | None]:
    try:
        values = frames.column_of(table, column.index, name)
    except BadInput as error:
        return (error.fault, None), None
    if len(values) != rows:
        return (f"its length is {len(values)}, that of the outputs {rows}", None), None
    odd = ~np.isnan(values) & ~((values >= LOWEST_C) & (values <= HIGHEST_C))
    if odd.any():
        row = int(odd.argmax())
        return (_no_temperature(repr(float(values[row]))), row + 1), None
    known = values[~np.isnan(values)]
    return None, Temperatures(float(known.min()), float(known.max()), OF_RUN_FILE) if len(known) else None


def _told(
    column: Column | None, doubt: str | None, odd: _Odd | None, known: Temperatures | None, file: str
) -> tuple[Temperatures | None, tuple[str, ...]]:
    """What is `known` by a column; or why it is passed over, which is refused where the user named it."""
    if column is None:
        return None, (() if doubt is None else (doubt,))
    if not _is_celsius(column):
        odd = "its unit is not deg C", None
    if odd is None:
        return known, ()
    message, row = odd
    if column.told:
        raise BadInput(message, file, row, column.name)
    where = "" if row is None else f"row {row}: "
    return None, (f"column {quoted(column.name)} passed over: {where}{message}",)


def _is_celsius(column: Column) -> bool:
    return not column.unit or _CELSIUS.fullmatch(column.unit) is not None


def _no_temperature(text: str) -> str:
    return f"{text} is no temperature from {LOWEST_C:g} to {HIGHEST_C:g} deg C"
