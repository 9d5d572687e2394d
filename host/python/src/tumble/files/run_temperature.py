"""The temperatures of a run, degrees Celsius: what the column `temperature` of its file or table says.

Extra columns hold whatever they like, so a column that only looks like one of temperatures is passed over
where it is not; one that the user names is read or refused.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.errors import BadInput, quoted
from tumble.files import frames
from tumble.files.run_layout import NUMBER, Column, Layout, temperature_column
from tumble.records import dataclass

LOWEST_C, HIGHEST_C = -100.0, 230.0  # beyond any block; room temperature in kelvins is above
OF_RUN_FILE, OF_ENVIRONMENT = "run_file", "environment"
_CELSIUS = re.compile(r"(\N{DEGREE SIGN}|deg ?)?C|celsius", re.IGNORECASE)


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
    """The temperatures of a run file, row by row, as far as they are wanted: `index` of their column, None where there
    is none or where a row has shown that they are no temperatures."""

    def __init__(self, layout: Layout):
        self._layout, self._low_c, self._high_c = layout, math.inf, -math.inf
        self._odd: _NotTemperatures | None = None
        self._values: dict[str, float] = {}  # a thermometer gives the same few values again and again
        column = layout.temperature
        self.index = None if column is None or not _is_celsius(column) else column.index

    def take(self, text: str, row: int) -> None:
        """What a row says; empty tells nothing."""
        try:
            if text and text not in self._values:
                self._values[text] = _value(text, self._layout, row)
        except _NotTemperatures as odd:
            self._odd, self.index = odd, None
        else:
            if text:
                self.take_range(self._values[text], self._values[text])

    def take_range(self, low_c: float, high_c: float) -> None:
        """Of other rows; an empty range tells nothing."""
        self._low_c, self._high_c = min(self._low_c, low_c), max(self._high_c, high_c)

    def told(self, file: str) -> tuple[Temperatures | None, tuple[str, ...]]:
        """By all rows, and sentences about a column that is passed over. Raises BadInput with row and column."""
        found, odd = _told(self._layout.temperature, self._layout.doubt, lambda _: self._range(), file)
        return range_of(found), odd

    def _range(self) -> Floats:
        if self._odd is not None:
            raise self._odd
        return np.array([self._low_c, self._high_c] if self._low_c <= self._high_c else [])


def read_temperatures(
    lines: Iterable[tuple[int, str]], layout: Layout, file: str
) -> tuple[Temperatures | None, tuple[str, ...]]:
    """The range of `temperatures_of_rows`, and its sentences. Raises BadInput with row and column."""
    rows, odd = temperatures_of_rows(lines, layout, file)
    return range_of(rows), odd


def temperatures_of_rows(
    lines: Iterable[tuple[int, str]], layout: Layout, file: str
) -> tuple[Floats | None, tuple[str, ...]]:
    """What the rows of a file say: (rows,), NaN where a field is empty; None where there is no such column; and
    sentences about a column that is passed over. `lines`: numbers and texts of those with a row. Raises BadInput with
    row and column."""
    return _told(layout.temperature, layout.doubt, lambda column: _read(lines, layout, column), file)


def temperatures_of_table(
    table: Any, columns: dict[str, str], rows: int, name: str
) -> tuple[Temperatures | None, tuple[str, ...]]:
    """The range of a table of files.frames with so many `rows`, of which `columns` (names by name) are told; and
    the same sentences."""
    column, doubt = temperature_column(frames.names_of(table), columns)
    found, odd = _told(column, doubt, lambda column: _of_table(table, column, rows, name), name)
    return range_of(found), odd


def range_of(temperatures_c: Floats | None) -> Temperatures | None:
    """From the lowest to the highest; None where all are unknown."""
    known = np.zeros(0) if temperatures_c is None else temperatures_c[~np.isnan(temperatures_c)]
    return Temperatures(float(known.min()), float(known.max()), OF_RUN_FILE) if len(known) else None


def _told(
    column: Column | None, doubt: str | None, read: Callable[[Column], Floats], file: str
) -> tuple[Floats | None, tuple[str, ...]]:
    """What `read` gives of a column; or why it is passed over, which is refused where the user named it."""
    if column is None:
        return None, (() if doubt is None else (doubt,))
    try:
        if not _is_celsius(column):
            raise _NotTemperatures("its unit is not deg C")
        return read(column), ()
    except _NotTemperatures as odd:
        if column.told:
            raise BadInput(odd.message, file, odd.row, column.name) from None
        where = "" if odd.row is None else f"row {odd.row}: "
        return None, (f"column {quoted(column.name)} passed over: {where}{odd.message}",)


def _is_celsius(column: Column) -> bool:
    return not column.unit or _CELSIUS.fullmatch(column.unit) is not None


class _NotTemperatures(Exception):
    def __init__(self, message: str, row: int | None = None):
        super().__init__(message)
        self.message, self.row = message, row


def _read(lines: Iterable[tuple[int, str]], layout: Layout, column: Column) -> Floats:
    seen: dict[str, float] = {"": math.nan}  # a thermometer gives the same few values again and again
    rows: list[int] = []
    found = []

    def texts() -> Iterable[str]:
        for row, line in lines:
            rows.append(row)
            yield line

    for fields in csv.reader(texts(), delimiter=layout.delimiter, strict=True):
        text = fields[column.index].strip()
        if text not in seen:
            seen[text] = _value(text, layout, rows[-1])
        found.append(seen[text])
    return np.array(found, dtype=float)


def _value(text: str, layout: Layout, row: int) -> float:
    pointed = text.replace(",", ".") if layout.decimal == "," else text
    if not NUMBER.fullmatch(pointed) or not LOWEST_C <= float(pointed) <= HIGHEST_C:
        raise _NotTemperatures(_odd(quoted(text)), row)
    return float(pointed)


def _of_table(table: Any, column: Column, rows: int, name: str) -> Floats:
    try:
        values = frames.column_of(table, column.index, name)
    except BadInput as error:
        raise _NotTemperatures(error.fault) from None
    if len(values) != rows:
        raise _NotTemperatures(f"its length is {len(values)}, that of the outputs {rows}")
    odd = ~np.isnan(values) & ~((values >= LOWEST_C) & (values <= HIGHEST_C))
    if odd.any():
        row = int(odd.argmax())
        raise _NotTemperatures(_odd(repr(float(values[row]))), row + 1)
    return values


def _odd(text: str) -> str:
    return f"{text} is no temperature from {LOWEST_C:g} to {HIGHEST_C:g} deg C"
