"""The temperatures of a run, degrees Celsius: what the column `temperature` of its file says.

Extra columns of a run file hold whatever they like, so a column that only looks like one of temperatures is passed over
where it is not; one that the user names is read or refused.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass

from tumble.errors import BadInput, quoted
from tumble.files.run_layout import Column, Layout, is_number

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


def read_temperatures(
    lines: Iterable[tuple[int, str]], layout: Layout, file: str
) -> tuple[Temperatures | None, tuple[str, ...]]:
    """What the rows of a run file say, and sentences about a column that is passed over. `lines`: numbers and texts of
    those with a row. Fields that are empty tell nothing. Raises BadInput with row and column."""
    column = layout.temperature
    if column is None:
        return None, (() if layout.doubt is None else (layout.doubt,))
    try:
        found = _read(lines, layout, column)
    except _NotTemperatures as odd:
        if column.told:
            raise BadInput(odd.message, file, odd.row, column.name) from None
        where = "" if odd.row is None else f"row {odd.row}: "
        return None, (f"column {quoted(column.name)} passed over: {where}{odd.message}",)
    return found, ()


class _NotTemperatures(Exception):
    def __init__(self, message: str, row: int | None = None):
        super().__init__(message)
        self.message, self.row = message, row


def _read(lines: Iterable[tuple[int, str]], layout: Layout, column: Column) -> Temperatures | None:
    if column.unit and not _CELSIUS.fullmatch(column.unit):
        raise _NotTemperatures("its unit is not deg C")
    seen: dict[str, int] = {}  # a thermometer gives the same few values again and again
    rows: list[int] = []

    def texts() -> Iterable[str]:
        for row, line in lines:
            rows.append(row)
            yield line

    for fields in csv.reader(texts(), delimiter=layout.delimiter, strict=True):
        seen.setdefault(fields[column.index].strip(), rows[-1])
    values = [_value(text, layout, row) for text, row in seen.items() if text]
    return Temperatures(min(values), max(values), OF_RUN_FILE) if values else None


def _value(text: str, layout: Layout, row: int) -> float:
    pointed = text.replace(",", ".") if layout.decimal == "," else text
    if not is_number(pointed) or not LOWEST_C <= float(pointed) <= HIGHEST_C:
        raise _NotTemperatures(f"{quoted(text)} is no temperature from {LOWEST_C:g} to {HIGHEST_C:g} deg C", row)
    return float(pointed)
