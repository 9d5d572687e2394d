"""Recordings in, as loggers write them: rows of a preamble, a row of units, clocks, labels, raw logs of receivers.

The layout is found by files.run_layout, the rows by files.rows; what a run file must not have and a recording may is
added here. Everything that was passed over or taken for granted is noted.
"""

from __future__ import annotations

import csv
import functools
import io
import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput, UsageError, quoted
from tumble.files import can_log
from tumble.files.disk import MOST_OF_RECORDING, read_bytes
from tumble.files.incoming import SUFFIXES, suffix_of
from tumble.files.rows import (
    FELT,
    LARGEST_OUTPUT,
    LINE,
    NO_VALUE,
    OUTPUTS as PLACES,
    TIME,
    NotANumber,
    Refused,
    RowParser,
)
from tumble.files.run_layout import (
    DEFAULT_UNIT,
    NUMBER,
    TEMPERATURE,
    Layout,
    Wishes,
    as_text,
    body_of,
    decoded,
    detect,
    find_column,
    is_number,
    require_text,
    split,
    unit_of,
)
from tumble.importing import can_bus, clock, novatel
from tumble.importing.can_bus import NO_BUS, Bus
from tumble.importing.clock import Clock
from tumble.importing.labels import LABELS

OUTPUTS = ("ux", "uy", "uz")
OPTIONAL = ("time", *LABELS)
COLUMNS = (*OUTPUTS, *OPTIONAL, TEMPERATURE)  # that a user may name
SPACE = " "
_ROWS_OF_CLOCK = 5000  # that tell its rate well enough
_MOST_LABELS = 256  # different running numbers: more count samples


@dataclass(frozen=True)
class Recording:
    """One file. `outputs` (rows, 3) in `unit`, which is `unit_told` or assumed; `lines` (rows,): where each stands;
    `clock`: None where there is none; `labels`: texts of each row, by name in LABELS; `notes`: sentences;
    `temperature` (rows,): in deg C, NaN where it is not known, None where no row tells it; `clock_column`: its name,
    where nobody but the file says that it is the clock."""

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
    clock_column: str | None = None


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
    parser, rows = _parse(data, layout, columns, timing, file)
    outputs, lines = rows[:, PLACES], rows[:, LINE].astype(int)
    notes += [f"{parser.lost} rows without a number in an output are left out"] if parser.lost else []
    notes += _rate_doubt(data, layout, names, columns, timing, file)
    labels = parser.texts
    told = _clock(labels.pop("time", rows[:, TIME]), lines, names, columns, timing, file)
    if _counts_samples(labels):
        del labels["number"]
        notes.append(f"column {quoted(names[columns['number']])} counts samples: not read")
    felt, odd = parser.thermometer.told(file)
    notes += told.notes if told else ()
    notes += odd
    if felt is not None and layout.temperature is not None:
        notes.append(f"temperature: of column {quoted(layout.temperature.name)}, {felt.text}")
    return Recording(
        file, outputs, lines, layout.unit, layout.unit_told, told, labels, tuple(notes), own,
        None if felt is None else rows[:, FELT],
        None if told is None or timing.rate_hz or "time" in wishes.columns else names[columns["time"]],
    )  # fmt: skip


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
    for row, line in _lines(data, layout):
        try:
            fields = split(line, layout.delimiter)
        except csv.Error:
            break
        if any(map(is_number, fields)) or len(fields) < len(names) or all(f.lower() in NO_VALUE for f in fields):
            break
        units = [f"[{fields[index].strip('[]()')}]" for index in layout.indices]
        unit = unit_of(wishes, units, file, row)
        told = layout.unit_told or unit is not None
        note = f"row {row} is taken for units" + (f": {unit}" if unit else "")
        felt = layout.temperature
        if felt is not None and not felt.unit and fields[felt.index].lower() not in NO_VALUE:
            felt = replace(felt, unit=fields[felt.index].strip("[]()"))
        return replace(layout, header_row=row, unit=unit or layout.unit, unit_told=told, temperature=felt), [note]
    return layout, []


def _parse(data: bytes, layout: Layout, columns: dict[str, int], timing: Timing, file: str) -> tuple[RowParser, Floats]:
    """All rows, and the parser that knows the rest of them; a clock that is no number is one of its texts. Raises
    BadInput."""
    texts = {name: place for name, place in columns.items() if name != "time"}
    time = columns.get("time") if timing.rate_hz is None else None

    def parsed(time: int | None, texts: dict[str, int]) -> tuple[RowParser, Floats]:
        parser = RowParser(layout, OUTPUTS, recorded=True, time=time, texts=texts)
        return parser, parser.parse(body_of(data, layout.header_row))[1]

    try:
        try:
            parser, rows = parsed(time, texts)
        except NotANumber as refused:
            if refused.column != "time" or time is None:
                raise
            parser, rows = parsed(None, {**texts, "time": time})
    except Refused as refused:
        hint = ""
        if isinstance(refused, NotANumber):
            other = "." if layout.decimal == "," else ","
            mark = f" (its decimal mark? see --decimal {other})"
            hint = mark if other in refused.text else "; begin the row with # to leave it out"
        raise BadInput(f"{refused}{hint}", file, refused.row, refused.column) from None
    if not len(rows):
        raise BadInput("no samples after the header", file, layout.header_row)
    return parser, rows


def _lines(data: bytes, layout: Layout) -> Iterator[tuple[int, str]]:
    """What follows the header, without comments and blank lines: numbers of lines and their text."""
    body = as_text(body_of(data, layout.header_row))
    for row, line in enumerate(io.StringIO(body, newline=None), start=layout.header_row + 1):
        if line.strip() and not line.startswith("#"):
            yield row, line


def _rate_doubt(
    data: bytes, layout: Layout, names: list[str], columns: dict[str, int], timing: Timing, file: str
) -> list[str]:
    """That a clock at the beginning of the file contradicts the rate that the user says; a clock that cannot be read
    may be why it is said."""
    if timing.rate_hz is None or "time" not in columns:
        return []
    name = names[columns["time"]]
    try:
        lines, texts = [], []
        for row, line in itertools.islice(_lines(data, layout), _ROWS_OF_CLOCK):
            lines.append(row)
            texts.append(split(line, layout.delimiter)[columns["time"]])
        pointed = [text.replace(",", ".") if layout.decimal == "," else text for text in texts]
        own = (
            clock.of_numbers(np.array(list(map(float, pointed))), name, timing.unit, file)
            if all(map(NUMBER.fullmatch, pointed))
            else clock.of_texts(texts, file, np.array(lines))
        )
    except (csv.Error, IndexError, BadInput):
        return []
    return clock.contradiction(own, timing.rate_hz, name)


def _clock(
    time: Floats | list[str], lines: Integers, names: list[str], columns: dict[str, int], timing: Timing, file: str
) -> Clock | None:
    if timing.rate_hz is not None:
        return clock.of_rate(len(lines), timing.rate_hz)
    if "time" not in columns or len(lines) < 2:
        return None
    if isinstance(time, list):
        return clock.of_texts(time, file, lines)
    far = ~(np.abs(time) <= LARGEST_OUTPUT)
    if far.any():
        row = int(far.argmax())
        raise BadInput(f"{float(time[row])!r} is out of range", file, int(lines[row]), "time")
    return _clock_of(time, names[columns["time"]], timing, file)


def _clock_of(values: Floats, name: str, timing: Timing, file: str) -> Clock:
    if timing.rate_hz is not None:
        try:
            doubt = clock.contradiction(clock.of_numbers(values, name, timing.unit, file), timing.rate_hz, name)
        except BadInput:
            doubt = []
        return clock.of_rate(len(values), timing.rate_hz, doubt)
    return clock.of_numbers(values, name, timing.unit, file)


def _counts_samples(labels: dict[str, list[str]]) -> bool:
    """Does the label `number` count samples? So where it is another in nearly every row, or beside a position."""
    return "number" in labels and ("position" in labels or len(set(labels["number"])) > _MOST_LABELS)


def require_alike(recordings: list[Recording]) -> None:
    """Several files that are to be one run have the same unit. Raises UsageError."""
    units = {one.unit for one in recordings}
    if len(units) > 1:
        raise UsageError(
            f"recordings in different units, {', '.join(sorted(units))}: --unit says which, or import each"
        )
