"""Recordings in, as loggers write them: rows of a preamble, a row of units, clocks, labels, raw logs of receivers.

The layout is found by files.run_layout, the numbers of a plain file by files.csv_rows; what a run file must not have
and a recording may is added here. Everything that was passed over or taken for granted is noted.
"""

from __future__ import annotations

import csv
import functools
import itertools
from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput, UsageError, quoted
from tumble.files import can_log
from tumble.files.disk import MOST_OF_RECORDING, read_bytes
from tumble.files.incoming import LARGEST_OUTPUT, SUFFIXES, body_of, read_plain, suffix_of, wrong_width
from tumble.files.run_layout import (
    DEFAULT_UNIT,
    NUMBER,
    TEMPERATURE,
    Layout,
    Wishes,
    decoded,
    detect,
    find_column,
    is_blank,
    is_comment,
    is_number,
    require_text,
    split,
    unit_of,
)
from tumble.files.run_temperature import range_of, temperatures_of_rows
from tumble.importing import can_bus, clock, novatel
from tumble.importing.can_bus import NO_BUS, Bus
from tumble.importing.clock import Clock

OUTPUTS = ("ux", "uy", "uz")
LABELS = ("mounting", "position", "angle", "number")
OPTIONAL = ("time", *LABELS)
COLUMNS = (*OUTPUTS, *OPTIONAL, TEMPERATURE)  # that a user may name
SPACE = " "
_ROWS_OF_CLOCK = 5000  # that tell its rate well enough
_MOST_LABELS = 256  # different running numbers: more count samples
_LOST = {"", "nan", "-", "null", "none", "n/a"}


@dataclass(frozen=True)
class Recording:
    """One file. `outputs` (rows, 3) in `unit`, which is `unit_told` or assumed; `lines` (rows,): where each stands;
    `clock`: None where there is none; `labels`: texts of each row, by name in LABELS; `notes`: sentences;
    `temperature` (rows,): in deg C, NaN where it is not known, None where no row tells it."""

    file: str
    outputs: Floats
    lines: Integers
    unit: str
    unit_told: bool
    clock: Clock | None
    labels: dict[str, list[str]]
    notes: tuple[str, ...]
    data: bytes
    temperature: Floats | None = None


@dataclass(frozen=True)
class Timing:
    """What the user says about time: `rate_hz` instead of a clock; `unit` of its numbers, one of clock.UNITS."""

    rate_hz: float | None = None
    unit: str | None = None


def read(file: str, wishes: Wishes, timing: Timing, bus: Bus = NO_BUS) -> Recording:
    """Read one file. Raises BadInput with file, row and column; UsageError; NotInstalled."""
    if suffix_of(file) in SUFFIXES:
        raise BadInput(
            "no text: import takes CSV and RAWIMU logs, tumble solve such a file of samples at positions", file
        )
    data = read_bytes(file, most=MOST_OF_RECORDING, look=functools.partial(_require_kind, file))
    if (kind := can_log.kind_of(data)) is not None:
        return _read_bus(file, data, kind, wishes, timing, bus)
    bus.require_log()
    require_text(data, file)
    return _read_log(file, data, wishes, timing) if novatel.is_log(data) else _read_table(file, data, wishes, timing)


def _require_kind(file: str, beginning: bytes) -> None:
    """It is text, if it is no CAN log. Raises BadInput."""
    if beginning.strip() and can_log.kind_of(beginning) is None:
        require_text(beginning, file)


def _read_log(file: str, data: bytes, wishes: Wishes, timing: Timing) -> Recording:
    log = novatel.read(data, file)
    notes = [f"RAWIMU log: {len(log.lines)} messages; ux is its X, uy the negative of its -Y, uz its Z, in counts"]
    if log.damaged or log.others:
        notes.append(f"left out: {log.damaged} messages that are damaged, {log.others} lines of something else")
    told = _clock_of(log.seconds, "time s", timing, file)
    return Recording(
        file, log.outputs, log.lines, wishes.unit or novatel.UNIT, True, told, {}, (*notes, *told.notes), data
    )


def _read_bus(file: str, data: bytes, kind: str, wishes: Wishes, timing: Timing, bus: Bus) -> Recording:
    log = can_bus.read(data, file, kind, wishes, bus)
    told = _clock_of(log.seconds, "time s", replace(timing, unit=None), file)
    notes = (*log.notes, *told.notes)
    unit = log.unit or DEFAULT_UNIT
    return Recording(
        file, log.outputs, log.lines, unit, log.unit is not None, told, {}, notes, data, log.temperature
    )  # fmt: skip


def _read_table(file: str, data: bytes, wishes: Wishes, timing: Timing) -> Recording:
    own = data
    if wishes.delimiter == SPACE:
        data = b"\n".join(b" ".join(line.split()) for line in data.splitlines())
    wishes = replace(wishes, wanted=OUTPUTS, has_preamble=True)
    layout = detect(data, wishes, file)
    names = split(_line(data, layout.header_row), layout.delimiter)
    columns = _optional_columns(names, wishes, file, layout.header_row)
    notes = []
    if layout.header_row - layout.comments - layout.blanks > 1:
        notes.append(f"header: row {layout.header_row}; the rows above it are not read")
    layout, unit_note = _below_units(data, layout, names, wishes, file)
    notes += unit_note
    if layout.decimal == ",":
        notes.append("decimal mark: the comma")
    rows = _read_rows(data, layout, names, columns, timing, file)
    notes += [f"{rows.lost} rows without a number in an output are left out"] if rows.lost else []
    notes += _rate_doubt(data, layout, names, columns, timing, file)
    told = _clock(rows, names, columns, timing, file)
    labels = _labels(rows)
    if "number" in rows.texts and "number" not in labels:
        notes.append(f"column {quoted(names[columns['number']])} counts samples: not read")
    felt, about_temperature = _temperatures(data, layout, rows, file)
    return Recording(
        file, rows.outputs, rows.lines, layout.unit, layout.unit_told, told, labels,
        (*notes, *(told.notes if told else ()), *about_temperature), own, felt,
    )  # fmt: skip


@dataclass(frozen=True)
class _Rows:
    """`time`: numbers or texts; `texts`: of the labels."""

    outputs: Floats
    lines: Integers
    time: Floats | list[str] | None
    texts: dict[str, list[str]]
    lost: int


def _line(data: bytes, row: int) -> str:
    return decoded(data).replace("\r\n", "\n").replace("\r", "\n").split("\n")[row - 1]


def _optional_columns(names: list[str], wishes: Wishes, file: str, row: int) -> dict[str, int]:
    """Where the columns of OPTIONAL are that are there. Raises BadInput for one that the user names and is not."""
    found = {}
    for wanted in OPTIONAL:
        try:
            index = find_column(wanted, names, wishes.columns)
        except ValueError as error:
            raise BadInput(str(error), file, row) from None
        if index is None and wanted in wishes.columns:
            asked = f"no column {quoted(wishes.columns[wanted])} (for {wanted})"
            raise BadInput(f"{asked} among {quoted(','.join(names), 400)}", file, row)
        if index is not None:
            found[wanted] = index
    return found


def _below_units(data: bytes, layout: Layout, names: list[str], wishes: Wishes, file: str) -> tuple[Layout, list[str]]:
    """The layout with a row of units taken for a part of the header, if there is one."""
    for row, line in body_of(data, layout):
        if is_blank(line) or is_comment(line):
            continue
        try:
            fields = split(line, layout.delimiter)
        except csv.Error:
            break
        if any(map(is_number, fields)) or len(fields) < len(names) or all(f.lower() in _LOST for f in fields):
            break
        units = [f"[{fields[index].strip('[]()')}]" for index in layout.indices]
        unit = unit_of(wishes, units, file, row)
        told = layout.unit_told or unit is not None
        note = f"row {row} is taken for units" + (f": {unit}" if unit else "")
        felt = layout.temperature
        if felt is not None and not felt.unit and fields[felt.index].lower() not in _LOST:
            felt = replace(felt, unit=fields[felt.index].strip("[]()"))
        return replace(layout, header_row=row, unit=unit or layout.unit, unit_told=told, temperature=felt), [note]
    return layout, []


def _temperatures(data: bytes, layout: Layout, rows: _Rows, file: str) -> tuple[Floats | None, tuple[str, ...]]:
    """Of the rows that are kept, and sentences about them. Raises BadInput where the user names a column of others."""
    kept = set(rows.lines.tolist())
    lines = ((row, line) for row, line in body_of(data, layout) if row in kept)
    found, odd = temperatures_of_rows(lines, layout, file)
    if (known := range_of(found)) is None or layout.temperature is None:
        return None, odd
    return found, (f"temperature: of column {quoted(layout.temperature.name)}, {known.text}",)


def _read_rows(
    data: bytes, layout: Layout, names: list[str], columns: dict[str, int], timing: Timing, file: str
) -> _Rows:
    """All rows: as numbers alone where the file is plain and has no labels, else line by line."""
    time = columns.get("time") if timing.rate_hz is None else None
    if not set(columns) - {"time"}:
        indices = (*layout.indices, *([] if time is None else [time]))
        plain = read_plain(data, replace(layout, indices=indices))
        if plain is not None and (np.abs(plain[0]) <= LARGEST_OUTPUT).all():
            values, lines, _ = plain
            return _Rows(values[:, :3], lines, None if time is None else values[:, 3], {}, 0)
    return _read_carefully(data, layout, names, columns, time, file)


def _read_carefully(
    data: bytes, layout: Layout, names: list[str], columns: dict[str, int], time: int | None, file: str
) -> _Rows:
    outputs, lines, times, lost = [], [], [], 0
    texts: dict[str, list[str]] = {name: [] for name in columns if name != "time"}
    for row, line in body_of(data, layout):
        if is_blank(line) or is_comment(line):
            continue
        fields = _fields(line, layout, len(names), file, row)
        values = [_number(fields[index], layout, file, row, name) for index, name in zip(layout.indices, OUTPUTS)]
        if None in values:
            lost += 1
            continue
        outputs.append(values)
        lines.append(row)
        times.append("" if time is None else fields[time])
        for name, column in texts.items():
            column.append(fields[columns[name]])
    if not outputs:
        raise BadInput("no samples after the header", file, layout.header_row)
    return _Rows(np.array(outputs), np.array(lines), None if time is None else _times(times, layout), texts, lost)


def _fields(line: str, layout: Layout, width: int, file: str, row: int) -> list[str]:
    try:
        fields = split(line, layout.delimiter)
    except csv.Error as error:
        raise BadInput(f"cannot be split into columns: {error}", file, row) from None
    if len(fields) > width and not any(fields[width:]):
        return fields[:width]
    if len(fields) != width:
        raise BadInput(wrong_width(fields, width, layout.delimiter, "; delete the row, or begin it with #"), file, row)
    return fields


def _number(text: str, layout: Layout, file: str, row: int, name: str) -> float | None:
    """None: the logger had no value."""
    if text.lower().lstrip("+-") in _LOST:
        return None
    pointed = text.replace(",", ".") if layout.decimal == "," else text
    if not NUMBER.fullmatch(pointed):
        other = "." if layout.decimal == "," else ","
        hint = (
            f" (its decimal mark? see --decimal {other})" if other in text else "; begin the row with # to leave it out"
        )
        raise BadInput(f"{quoted(text)} is not a number{hint}", file, row, name)
    if abs(float(pointed)) > LARGEST_OUTPUT:
        raise BadInput(f"{quoted(text)} is out of range", file, row, name)
    return float(pointed)


def _times(texts: list[str], layout: Layout) -> Floats | list[str]:
    """As numbers where all of them are."""
    pointed = [text.replace(",", ".") if layout.decimal == "," else text for text in texts]
    return np.array([float(text) for text in pointed]) if all(map(NUMBER.fullmatch, pointed)) else texts


def _rate_doubt(
    data: bytes, layout: Layout, names: list[str], columns: dict[str, int], timing: Timing, file: str
) -> list[str]:
    """That a clock at the beginning of the file contradicts the rate that the user says; a clock that cannot be read
    may be why it is said."""
    if timing.rate_hz is None or "time" not in columns:
        return []
    lines = ((row, line) for row, line in body_of(data, layout) if not (is_blank(line) or is_comment(line)))
    try:
        texts, rows = [], []
        for row, line in itertools.islice(lines, _ROWS_OF_CLOCK):
            texts.append(split(line, layout.delimiter)[columns["time"]])
            rows.append(row)
        times, name = _times(texts, layout), names[columns["time"]]
        own = (
            clock.of_texts(times, file, np.array(rows))
            if isinstance(times, list)
            else clock.of_numbers(times, name, timing.unit, file)
        )
    except (csv.Error, IndexError, BadInput):
        return []
    return clock.contradiction(own, timing.rate_hz, name)


def _clock(rows: _Rows, names: list[str], columns: dict[str, int], timing: Timing, file: str) -> Clock | None:
    if timing.rate_hz is not None:
        return clock.of_rate(len(rows.outputs), timing.rate_hz)
    if rows.time is None or len(rows.outputs) < 2:
        return None
    if isinstance(rows.time, list):
        return clock.of_texts(rows.time, file, rows.lines)
    far = ~(np.abs(rows.time) <= LARGEST_OUTPUT)
    if far.any():
        row = int(far.argmax())
        raise BadInput(f"{float(rows.time[row])!r} is out of range", file, int(rows.lines[row]), "time")
    return _clock_of(rows.time, names[columns["time"]], timing, file)


def _clock_of(values: Floats, name: str, timing: Timing, file: str) -> Clock:
    if timing.rate_hz is not None:
        try:
            doubt = clock.contradiction(clock.of_numbers(values, name, timing.unit, file), timing.rate_hz, name)
        except BadInput:
            doubt = []
        return clock.of_rate(len(values), timing.rate_hz, doubt)
    return clock.of_numbers(values, name, timing.unit, file)


def _labels(rows: _Rows) -> dict[str, list[str]]:
    """Those that name positions: a number that is another in every row counts samples, unless there are few rows."""
    labels = dict(rows.texts)
    if "number" in labels and ("position" in labels or len(set(labels["number"])) > _MOST_LABELS):
        del labels["number"]
    return labels


def require_alike(recordings: list[Recording]) -> None:
    """Several files that are to be one run have the same unit. Raises UsageError."""
    units = {one.unit for one in recordings}
    if len(units) > 1:
        raise UsageError(
            f"recordings in different units, {', '.join(sorted(units))}: --unit says which, or import each"
        )
