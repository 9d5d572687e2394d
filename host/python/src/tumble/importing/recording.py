"""Recordings in, as loggers write them: rows of a preamble, a row of units, clocks, labels, raw logs of receivers.

The layout is found by files.run_layout, the rows by files.rows; what a run file must not have and a recording may is
added here. Everything that was passed over or taken for granted is noted.
"""

from __future__ import annotations

import csv
import functools
import io
import itertools
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from datetime import datetime

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput, quoted
from tumble.files import can_log, run_layout
from tumble.files.disk import MOST_OF_RECORDING, read_bytes
from tumble.files.frames import SUFFIXES, suffix_of
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
from tumble.importing import can_bus
from tumble.importing.can_bus import NO_BUS, OUTPUTS, Bus
from tumble.importing.labels import LABELS

OPTIONAL = ("time", *LABELS)
COLUMNS = (*OUTPUTS, *OPTIONAL, run_layout.TEMPERATURE)  # that a user may name
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}  # of a clock
CONTRADICTED = "clock: --rate says"
_ROWS_OF_CLOCK = 5000  # that tell its rate well enough
_MOST_LABELS = 256  # different running numbers: more count samples


@dataclass(frozen=True)
class Clock:
    """`seconds` (rows,), from the first row on; `interval_s`: usual, between two rows; `gaps`: rows before which time
    is missing or the clock was set back; `notes`: sentences on what was taken for granted."""

    seconds: Floats
    interval_s: float
    gaps: Integers
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Recording:
    """One file. `outputs` (rows, 3) in `unit`, which is `unit_told` or assumed; `lines` (rows,): where each stands;
    `clock`: None where there is none; `notes`: sentences; `labels`: texts of each row, by name in LABELS;
    `temperature` (rows,): in deg C, NaN where it is not known, None where no row tells it; `clock_column`: its name,
    where nobody but the file says that it is the clock."""

    file: str
    data: bytes
    outputs: Floats
    lines: Integers
    unit: str
    unit_told: bool
    clock: Clock | None
    notes: tuple[str, ...]
    labels: dict[str, list[str]] = field(default_factory=dict)
    temperature: Floats | None = None
    clock_column: str | None = None


@dataclass(frozen=True)
class Timing:
    """What the user says about time: `rate_hz` instead of a clock; `unit` of its numbers, one of UNITS."""

    rate_hz: float | None = None
    unit: str | None = None


def read(file: str, wishes: run_layout.Wishes, timing: Timing, bus: Bus = NO_BUS) -> Recording:
    """Read one file. Raises BadInput with file, row and column; UsageError; NotInstalled."""
    if suffix_of(file) in SUFFIXES:
        raise BadInput(
            "no text: import takes CSV and RAWIMU logs, tumble solve such a file of samples at positions", file
        )
    data = read_bytes(file, most=MOST_OF_RECORDING, look=functools.partial(_require_kind, file))
    if (kind := can_log.kind_of(data)) is not None:
        log = can_bus.read(data, file, kind, wishes, bus)
        clock = _clock_of(log.seconds, "time s", replace(timing, unit=None), file)
        unit, notes = log.unit or run_layout.DEFAULT_UNIT, (*log.notes, *clock.notes)
        told = log.unit is not None
        return Recording(file, data, log.outputs, log.lines, unit, told, clock, notes, temperature=log.temperature)
    bus.require_log()
    run_layout.require_text(data, file)
    is_rawimu = _START.search(data[:_BEGINNING]) is not None
    return (_read_rawimu if is_rawimu else _read_table)(file, data, wishes, timing)


def _require_kind(file: str, beginning: bytes) -> None:
    """It is text, if it is no CAN log. Raises BadInput."""
    if beginning.strip() and can_log.kind_of(beginning) is None:
        run_layout.require_text(beginning, file)


# Tables.


def _read_table(file: str, data: bytes, wishes: run_layout.Wishes, timing: Timing) -> Recording:
    own = data
    if wishes.delimiter == " ":
        data = b"\n".join(b" ".join(line.split()) for line in data.splitlines())
    wishes = replace(wishes, wanted=OUTPUTS, has_preamble=True)
    layout = run_layout.detect(data, wishes, file)
    names = run_layout.split(run_layout.lines_of(data)[layout.header_row - 1], layout.delimiter)
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
    clock_name = names[columns["time"]] if "time" in columns else None
    notes += _rate_doubt(data, layout, clock_name, columns, timing, file)
    labels = parser.texts
    clock = _clock(labels.pop("time", rows[:, TIME]), lines, clock_name, timing, file)
    if "number" in labels and ("position" in labels or len(set(labels["number"])) > _MOST_LABELS):
        del labels["number"]
        notes.append(f"column {quoted(names[columns['number']])} counts samples: not read")
    felt, odd = parser.thermometer.told(file)
    notes += clock.notes if clock else ()
    notes += odd
    if felt is not None and layout.temperature is not None:
        notes.append(f"temperature: of column {quoted(layout.temperature.name)}, {felt.text}")
    return Recording(
        file=file,
        data=own,
        outputs=outputs,
        lines=lines,
        unit=layout.unit,
        unit_told=layout.unit_told,
        clock=clock,
        notes=tuple(notes),
        labels=labels,
        temperature=None if felt is None else rows[:, FELT],
        clock_column=None if clock is None or timing.rate_hz or "time" in wishes.columns else clock_name,
    )


def _optional_columns(names: list[str], wishes: run_layout.Wishes, file: str, row: int) -> dict[str, int]:
    """Where the columns of OPTIONAL are that are there. Raises BadInput for one that the user names and is not."""
    found = {}
    for wanted in OPTIONAL:
        try:
            index = run_layout.find_column(wanted, names, wishes.columns)
        except ValueError as error:
            raise BadInput(str(error), file, row) from None
        if index is None and wanted in wishes.columns:
            asked = f"no column {quoted(wishes.columns[wanted])} (for {wanted})"
            raise BadInput(f"{asked} among {quoted(','.join(names), 400)}", file, row)
        if index is not None:
            found[wanted] = index
    return found


def _below_units(
    data: bytes, layout: run_layout.Layout, names: list[str], wishes: run_layout.Wishes, file: str
) -> tuple[run_layout.Layout, list[str]]:
    """The layout with a row of units taken for a part of the header, if there is one."""
    row, line = next(_lines(data, layout), (0, ""))
    try:
        fields = run_layout.split(line, layout.delimiter)
    except csv.Error:
        return layout, []
    if any(map(run_layout.is_number, fields)) or len(fields) < len(names) or all(f.lower() in NO_VALUE for f in fields):
        return layout, []
    units = [f"[{fields[index].strip('[]()')}]" for index in layout.indices]
    unit = run_layout.unit_of(wishes, units, file, row)
    felt = layout.temperature
    if felt is not None and not felt.unit and fields[felt.index].lower() not in NO_VALUE:
        felt = replace(felt, unit=fields[felt.index].strip("[]()"))
    told = layout.unit_told or unit is not None
    layout = replace(layout, header_row=row, unit=unit or layout.unit, unit_told=told, temperature=felt)
    return layout, [f"row {row} is taken for units" + (f": {unit}" if unit else "")]


def _parse(
    data: bytes, layout: run_layout.Layout, columns: dict[str, int], timing: Timing, file: str
) -> tuple[RowParser, Floats]:
    """All rows, and the parser that knows the rest of them; a clock that is no number is one of its texts. Raises
    BadInput."""
    texts = {name: place for name, place in columns.items() if name != "time"}
    time = columns.get("time") if timing.rate_hz is None else None

    def parsed(time: int | None, texts: dict[str, int]) -> tuple[RowParser, Floats]:
        parser = RowParser(layout, OUTPUTS, recorded=True, time=time, texts=texts)
        return parser, parser.parse(run_layout.body_of(data, layout.header_row))[1]

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


def _lines(data: bytes, layout: run_layout.Layout) -> Iterator[tuple[int, str]]:
    """What follows the header, without comments and blank lines: numbers of lines and their text."""
    body = run_layout.as_text(run_layout.body_of(data, layout.header_row))
    for row, line in enumerate(io.StringIO(body, newline=None), start=layout.header_row + 1):
        if line.strip() and not line.startswith("#"):
            yield row, line


# Clocks.

_IN_NAME = re.compile(r"(?:[\[(\s_]|^t|time|stamp)(ns|us|µs|ms|s|sec|seconds)[\])]?\s*$", re.IGNORECASE)
_WORDS = {"sec": "s", "seconds": "s", "µs": "us"}
_OF_DAY = re.compile(r"(\d{1,2}):(\d{2}):(\d{2}(?:[.,]\d+)?)")
_GAP = 5.0  # intervals: a step of the clock beyond is a gap
_SAME_RATE = 1.2  # of two rates, a factor
_FEWEST_STEPS = 10
_SLOWEST_S = 0.5  # between samples of a recording: beyond, a column without a unit does not count seconds
_WITHOUT = "--rate HZ reads the recording without it"


def _clock(time: Floats | list[str], lines: Integers, name: str | None, timing: Timing, file: str) -> Clock | None:
    """By the rate that the user says, else of the column of that `name`; None where there is neither."""
    if timing.rate_hz is not None:
        return _of_rate(len(lines), timing.rate_hz)
    if name is None or len(lines) < 2:
        return None
    if isinstance(time, list):
        return _of_texts(time, file, lines)
    far = ~(np.abs(time) <= LARGEST_OUTPUT)
    if far.any():
        row = int(far.argmax())
        raise BadInput(f"{float(time[row])!r} is out of range", file, int(lines[row]), "time")
    return _of_numbers(time, name, timing.unit, file)


def _clock_of(values: Floats, name: str, timing: Timing, file: str) -> Clock:
    """Of a log whose time is sure to be a number; a rate that the user says is held against it."""
    if timing.rate_hz is None:
        return _of_numbers(values, name, timing.unit, file)
    try:
        doubt = _contradiction(_of_numbers(values, name, timing.unit, file), timing.rate_hz, name)
    except BadInput:
        doubt = []
    return _of_rate(len(values), timing.rate_hz, *doubt)


def _rate_doubt(
    data: bytes, layout: run_layout.Layout, name: str | None, columns: dict[str, int], timing: Timing, file: str
) -> list[str]:
    """That a clock at the beginning of the file contradicts the rate that the user says; a clock that cannot be read
    may be why it is said."""
    if timing.rate_hz is None or name is None:
        return []
    try:
        lines, texts = [], []
        for row, line in itertools.islice(_lines(data, layout), _ROWS_OF_CLOCK):
            lines.append(row)
            texts.append(run_layout.split(line, layout.delimiter)[columns["time"]])
        pointed = [text.replace(",", ".") if layout.decimal == "," else text for text in texts]
        own = (
            _of_numbers(np.array(list(map(float, pointed))), name, timing.unit, file)
            if all(map(run_layout.NUMBER.fullmatch, pointed))
            else _of_texts(texts, file, np.array(lines))
        )
    except (csv.Error, IndexError, BadInput):
        return []
    return _contradiction(own, timing.rate_hz, name)


def _contradiction(own: Clock, rate_hz: float, name: str) -> list[str]:
    """That the file's `own` clock, of the column `name`, has another rate than the one that the user says; nothing
    where they agree, or where the clock has moved on too seldom to tell."""
    seen = 1.0 / own.interval_s
    moved = int((np.diff(own.seconds) > 0.0).sum())
    if moved < _FEWEST_STEPS or seen / _SAME_RATE < rate_hz < seen * _SAME_RATE:
        return []
    return [f"{CONTRADICTED} {rate_hz:g} Hz, but {quoted(name)} moves on at {seen:.4g} Hz: which is right?"]


def _of_rate(rows: int, rate_hz: float, *notes: str) -> Clock:
    return Clock(np.arange(rows) / rate_hz, 1.0 / rate_hz, np.zeros(0, dtype=int), notes)


def _of_numbers(values: Floats, name: str, told_unit: str | None, file: str) -> Clock:
    """Of a column of numbers; its unit is the one that the user told, or that its name ends in. Raises BadInput."""
    in_name, notes = _IN_NAME.search(name), []
    unit = told_unit or (in_name and _WORDS.get(in_name[1].lower(), in_name[1].lower()))
    steps = np.diff(values)
    forward = steps[steps > 0.0]
    if not len(forward):
        raise BadInput(f"column {quoted(name)} does not count: {_WITHOUT}", file)
    step = float(np.median(forward))
    if unit is None:
        unit = "s" if step <= _SLOWEST_S else "ms" if step < 1000.0 * _SLOWEST_S else "us"
        notes.append(f"clock: {quoted(name)} names no unit, steps of {step:.6g}: taken for {unit} (--time-unit)")
    return _with_gaps((values - values[0]) * UNITS[unit], notes, file)


def _of_texts(texts: list[str], file: str, lines: Integers) -> Clock:
    """Of a column of dates or times of day. Raises BadInput."""
    seconds = []
    for text, line in zip(texts, lines):
        second = _second(text.strip())
        if second is None:
            advice = f"a number, 12:34:56.789 or 2026-05-01T12:34:56.789; {_WITHOUT}"
            raise BadInput(f"{quoted(text)} is no time: {advice}", file, int(line), "time")
        seconds.append(second)
    values = np.array(seconds)
    return _with_gaps(values - values[0], [], file)


def _second(text: str) -> float | None:
    if found := _OF_DAY.fullmatch(text):
        return 3600.0 * int(found[1]) + 60.0 * int(found[2]) + float(found[3].replace(",", "."))
    text = text.replace(",", ".").removesuffix("Z")
    whole, point, decimals = text.partition(".")
    if point and decimals.isdigit():  # with six of them, as older versions of Python want it
        text = f"{whole}.{decimals[:6]:0<6}"
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        return None
    return (moment.replace(tzinfo=None) - datetime(2000, 1, 1)).total_seconds()


def _with_gaps(seconds: Floats, notes: list[str], file: str) -> Clock:
    steps = np.diff(seconds)
    forward = steps[steps > 0.0]
    if not len(forward):
        raise BadInput(f"the clock stands still: {_WITHOUT}", file)
    coarse = len(forward) < 0.8 * len(steps)
    interval = float(seconds[-1] - seconds[0]) / len(steps) if coarse else float(np.median(forward))
    if coarse:
        notes.append(
            f"clock: it moves on at {len(forward)} of {len(steps)} rows; {1 / max(interval, 1e-9):.4g} Hz on average"
        )
    if not interval > 0.0:
        raise BadInput(f"the clock runs backwards: {_WITHOUT}", file)
    back = steps < 0.0
    gaps = np.flatnonzero(back | (steps > _GAP * max(interval, float(np.median(forward))))) + 1
    if back.any():
        notes.append(f"clock: set back {int(back.sum())} times, taken for gaps")
    return Clock(seconds, interval, gaps, tuple(notes))


# Raw logs of inertial units on NovAtel receivers, ASCII: RAWIMU, RAWIMUX, RAWIMUS, RAWIMUSX.
#
#     #RAWIMUA,header;week,seconds,status,Z,-Y,X,gyro Z,-gyro Y,gyro X*crc
#     %RAWIMUSXA,header;info,type,week,seconds,status,Z,-Y,X,gyro Z,-gyro Y,gyro X*crc
#
# (OEM7 Commands and Logs Reference Manual.) Accelerations are counts of velocity gained in an interval; how large a
# count is depends on the unit, so K comes out in counts per g. The last eight digits are a CRC-32 of all between the
# first sign and the asterisk.

_LINE = re.compile(rb"[#%](RAWIMU(S?)(X?)A,[^;*#%]*;([^*#%]*))\*([0-9a-fA-F]{8})")
_BEGINNING = 1 << 16  # bytes that show what a log is
_START = re.compile(rb"[#%]RAWIMUS?X?A,")
_WEEK_S = 604800.0


def _read_rawimu(file: str, data: bytes, wishes: run_layout.Wishes, timing: Timing) -> Recording:
    rows, lines = [], []
    damaged = others = 0
    for number, line in enumerate(data.split(b"\n"), start=1):
        begun = len(_START.findall(line))  # two, where the end of one was lost
        others += begun == 0 and bool(line.strip())
        for found in _LINE.finditer(line):
            row = _row(found) if int(found[5], 16) == crc32(found[1]) else None
            if row is not None:
                rows.append(row)
                lines.append(number)
                begun -= 1
        damaged += begun
    if not rows:
        raise BadInput(f"{damaged} lines of a RAWIMU log, none with a good check sum: log it anew, as ASCII", file)
    values = np.array(rows)
    notes = [f"RAWIMU log: {len(lines)} messages; ux is its X, uy the negative of its -Y, uz its Z, in counts"]
    if damaged or others:
        notes.append(f"left out: {damaged} messages that are damaged, {others} lines of something else")
    clock = _clock_of(values[:, 0], "time s", timing, file)
    unit = wishes.unit or can_bus.COUNTS
    return Recording(file, data, values[:, 1:], np.array(lines), unit, True, clock, (*notes, *clock.notes))


def crc32(data: bytes) -> int:
    """That of the receivers: zlib's polynomial, zero to begin with, nothing inverted."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def _row(found: re.Match[bytes]) -> tuple[float, float, float, float] | None:
    """Seconds of GNSS time; x, y, z in counts."""
    fields = found[4].split(b",")[2 if found[3] else 0 :]
    try:
        week, second, z, minus_y, x = (float(fields[place]) for place in (0, 1, 3, 4, 5))
    except (ValueError, IndexError):
        return None
    row = week * _WEEK_S + second, x, -minus_y, z
    return row if all(abs(value) <= LARGEST_OUTPUT for value in row) else None
