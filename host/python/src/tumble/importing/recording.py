"""Recordings in, as loggers write them: rows of a preamble, a row of units, clocks, labels, raw logs of receivers.

The layout is found by files.run_layout, the rows by files.rows; what a run file must not have and a recording may is
added here. Everything that was passed over or taken for granted is noted.
"""

from __future__ import annotations

import csv
import functools
import itertools
import os
import re
import zlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput, Remedy, UsageError, listed, quoted
from tumble.files import can_log, containers, run_layout
from tumble.files.disk import MOST_OF_RECORDING, bounded, joined, read_bytes
from tumble.files.rows import (
    FELT,
    LARGEST_OUTPUT,
    LINE,
    OUTPUTS as PLACES,
    TIME,
    NotANumber,
    Refused,
    RowParser,
)
from tumble.importing import can_bus, clocks, repairs
from tumble.importing.can_bus import NO_BUS, OUTPUTS, Bus
from tumble.importing.clocks import Clock, Timing
from tumble.importing.labels import LABELS

OPTIONAL = ("time", *LABELS)
COLUMNS = (*OUTPUTS, *OPTIONAL, run_layout.TEMPERATURE)  # that a user may name
_MOST_LABELS = 256  # different running numbers: more count samples
_ROWS_IN_TURN, _MOST_SOURCES, _IN_TURN = 400, 4, 0.2  # that tell sources apart; the share of rows that change


@dataclass(frozen=True)
class Recording:
    """One file. `outputs` (rows, 3) in `unit`, which is `unit_told` or assumed; `lines` (rows,): where each stands;
    `clock`: None where there is none; `notes`: sentences; `labels`: texts of each row, by name in LABELS;
    `temperature` (rows,): in deg C, NaN where it is not known, None where no row tells it; `columns`: names of those
    that were read, by name in COLUMNS; `source`: name and texts (rows,) of a column that may tell sources apart."""

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
    columns: dict[str, str] = field(default_factory=dict)
    source: tuple[str, list[str]] | None = None

    def part(self, kept: Integers, *notes: str) -> Recording:
        """Some of the rows, in another order; where some are missing, time is."""
        clock = self.clock
        if clock is not None:
            part_of = np.cumsum(np.isin(np.arange(len(self.outputs)), clock.gaps))[kept]
            gaps = np.flatnonzero((np.diff(kept) > 1) | (np.diff(part_of) != 0)) + 1
            clock = replace(clock, seconds=clock.seconds[kept], gaps=gaps)
        return replace(
            self,
            outputs=self.outputs[kept],
            lines=self.lines[kept],
            clock=clock,
            notes=(*self.notes, *notes),
            labels={name: [texts[row] for row in kept.tolist()] for name, texts in self.labels.items()},
            temperature=None if self.temperature is None else self.temperature[kept],
            source=self.source and (self.source[0], [self.source[1][row] for row in kept.tolist()]),
        )


def read(
    file: str, options: run_layout.LayoutOptions, timing: Timing, bus: Bus = NO_BUS, rows: Choice | None = None
) -> Recording:
    """Read one file; of its `rows` those that are chosen. Raises BadInput with file, row and column; UsageError;
    NotInstalled."""
    container: str | None
    if os.path.isfile(os.path.join(file, containers.METADATA)):
        data, container = _bytes_within(file), containers.ROS_2
    else:
        data = read_bytes(file, most=MOST_OF_RECORDING, look=functools.partial(_require_kind, file))
        container = containers.kind_of(file, data[:_BEGINNING]) if data else None
    if container is not None:
        bus.require_log()
        return _read_container(file, data, container, options, timing, rows)
    if (kind := can_log.kind_of(data)) is not None:
        log = can_bus.read(data, file, kind, options, bus)
        clock = _clock_of(log.seconds, "time s", replace(timing, unit="s"), file)
        unit, notes = log.unit or run_layout.DEFAULT_UNIT, (*log.notes, *clock.notes)
        told = log.unit is not None
        return Recording(file, data, log.outputs, log.lines, unit, told, clock, notes, temperature=log.temperature)
    bus.require_log()
    data = _utf_8(data)
    run_layout.require_text(data, file)
    if _START.search(data[:_BEGINNING]) is not None:
        return _read_rawimu(file, data, options, timing)
    return _read_table(file, data, options, timing, rows)


def _require_kind(file: str, beginning: bytes) -> None:
    """It is text, if it is no CAN log and none of containers. Raises BadInput."""
    known = can_log.kind_of(beginning) or containers.kind_of(file, beginning)
    if beginning.strip() and known is None and not beginning.startswith(run_layout.UTF_16):
        run_layout.require_text(beginning, file)


def _bytes_within(folder: str) -> bytes:
    """Of all files in it, by name, which are one recording. Raises BadInput."""
    inner = (os.path.join(folder, name) for name in sorted(os.listdir(folder)))
    return joined((read_bytes(one, most=MOST_OF_RECORDING) for one in inner), folder, MOST_OF_RECORDING)


def _utf_8(data: bytes) -> bytes:
    """Text of UTF-16 as UTF-8, which all others read."""
    return data.decode("utf-16", "replace").encode() if data.startswith(run_layout.UTF_16) else data


# Tables.


def _read_container(
    file: str, data: bytes, kind: str, options: run_layout.LayoutOptions, timing: Timing, choice: Choice | None
) -> Recording:
    tables = containers.read(file, kind)
    source, is_column = None, len(tables) == 1 and containers.SOURCE in tables[0].columns
    if choice is not None and choice.column == containers.SOURCE and not is_column:
        source, choice = choice.value, None
    options = replace(options, wanted=OUTPUTS, delimiter=",", decimal=".")
    table = containers.chosen(tables, kind, source, options, file)
    with bounded(file):
        text = table.text
    own = _read_table(file, text, options, timing, choice)
    which = f": source {quoted(table.source)}" if table.source else ""
    among = f" of {len(tables)}" if len(tables) > 1 else ""
    notes = [f"{kind}{which}{among}", *filter(None, [containers.CAUTIONS.get(kind)])]
    if kind in containers.OF_AUTOPILOTS and (instance := re.search(r"_([1-9])$", table.source)):
        number = int(instance[1]) + 1
        notes.append(f"the autopilot's accelerometer {number}: export it with --accelerometer {number}")
    return replace(own, data=data, notes=(*notes, *own.notes))


def _read_table(
    file: str, data: bytes, options: run_layout.LayoutOptions, timing: Timing, choice: Choice | None
) -> Recording:
    own = data
    if options.delimiter == " ":
        data = b"\n".join(b" ".join(line.split()) for line in data.splitlines())
    options = replace(options, wanted=OUTPUTS, has_preamble=True)
    try:
        layout = run_layout.detect(data, options, file)
    except BadInput as refused:
        refused.assumed = ("a table with unknown columns",)
        raise refused.advising(*_named_columns(data, refused.row, options)) from None
    names = list(layout.names)
    columns = _optional_columns(names, options, file, layout.header_row)
    notes = run_layout.about_header(data, layout, options) + _other_sensors(names, layout.indices)
    layout, units, unit_note = run_layout.below_units(data, layout, options, file)
    notes += unit_note
    if layout.decimal == ",":
        notes.append("decimal mark: the comma")
    told = {name: names[place] for name, place in (*zip(OUTPUTS, layout.indices), *columns.items())}
    if "time" in columns and (unit := units[columns["time"]]) in clocks.UNITS:
        told["time"] += f" [{unit}]"
    try:
        source = _source_column(data, layout, {*layout.indices, *columns.values()}, choice)
        places = columns | ({} if source is None else {"source": source})
        parser, rows = _parse(data, layout, places, timing, file)
        notes += [f"{parser.lost} rows without a number in an output are left out"] if parser.lost else []
        notes += _rate_doubt(data, layout, told.get("time"), columns, timing, file)
        texts = parser.texts
        if choice is not None:
            rows, texts = choice.of(rows, texts)
            notes.append(f"rows: {len(rows)}, selected by --rows {choice.text}")
        clock = _clock(texts.pop("time", rows[:, TIME]), rows[:, LINE].astype(int), told.get("time"), timing, file)
    except (BadInput, UsageError) as refused:
        refused.assumed = (*_about_columns(told, layout.unit, layout.unit_told), *notes)
        raise
    if clock is not None and clock.order is not None:
        rows, texts = rows[clock.order], {name: [one[row] for row in clock.order] for name, one in texts.items()}
    if "number" in texts and ("position" in texts or len(set(texts["number"])) > _MOST_LABELS):
        del texts["number"]
        notes.append(f"column {quoted(told['number'])} counts samples: not read")
    outputs, about_signs = repairs.signed(rows[:, PLACES])
    felt, odd = parser.thermometer.told(file)
    notes += (*(clock.notes if clock else ()), *about_signs, *odd)
    if felt is not None and layout.temperature is not None:
        notes.append(f"temperature: of column {quoted(layout.temperature.name)}, {felt.text}")
    sources = texts.pop("source", None)
    return Recording(
        file=file,
        data=own,
        outputs=outputs,
        lines=rows[:, LINE].astype(int),
        unit=layout.unit,
        unit_told=layout.unit_told,
        clock=clock,
        notes=tuple(notes),
        labels=texts,
        temperature=None if felt is None else rows[:, FELT],
        columns=told,
        source=None if source is None or sources is None else (names[source], sources),
    )


@dataclass(frozen=True)
class Choice:
    """Rows of one source: of a `column` those of a `value`; of every `number` of rows the one that is so `many`-th; or
    the lines from `first` to `last`. `text`: as it is typed."""

    text: str
    column: str | None = None
    value: str = ""
    first: int = 1
    last: int = 0
    number: int = 0

    @classmethod
    def parsed(cls, text: str) -> Choice:
        """Of COLUMN=VALUE, 1/2 or 2:481. Raises UsageError."""
        if found := re.fullmatch(r"(\d{1,9})/(\d{1,3})", text):
            if 1 <= int(found[1]) <= int(found[2]):
                return cls(text, first=int(found[1]), number=int(found[2]))
        elif found := re.fullmatch(r"(\d{1,9}):(\d{1,9})", text):
            if 1 <= int(found[1]) <= int(found[2]):
                return cls(text, first=int(found[1]), last=int(found[2]))
        elif "=" in text.strip("= "):
            column, _, value = text.partition("=")
            return cls(text, column.strip(), value.strip())
        raise UsageError(f"--rows: {quoted(text)} is not COLUMN=VALUE, 1/2 (the first of every two) or 2:481 (lines)")

    def of(self, rows: Floats, texts: dict[str, list[str]]) -> tuple[Floats, dict[str, list[str]]]:
        """The rows, and the texts in them. Raises UsageError where there are none."""
        if self.column is not None:
            kept = np.flatnonzero(np.array(texts["source"]) == self.value)
        elif self.number:
            kept = np.arange(self.first - 1, len(rows), self.number)
        else:
            kept = np.flatnonzero((rows[:, LINE] >= self.first) & (rows[:, LINE] <= self.last))
        if not len(kept):
            there = f"; there are {', '.join(map(quoted, dict.fromkeys(texts.get('source', [])[:1000])))}"
            raise UsageError(f"--rows {self.text}: no such rows{there if self.column is not None else ''}")
        return rows[kept], {name: [one[row] for row in kept.tolist()] for name, one in texts.items()}


def _named_columns(data: bytes, row: int | None, options: run_layout.LayoutOptions) -> list[Remedy]:
    """Ways to name the outputs in the header of this `row`: columns of numbers side by side that do not count."""
    lines = run_layout.lines_of(data[:_BEGINNING])
    if row is None or row > len(lines):
        return []
    sign = options.delimiter or max(",;\t", key=lines[row - 1].count)
    if sign not in lines[row - 1]:
        return [Remedy({"delimiter": "space"})]
    names, *rows = (line.split(sign) for line in lines[row - 1 : row + _ROWS_IN_TURN] if line.strip())
    columns = list(zip(*(fields for fields in rows[:-1] if len(fields) == len(names))))
    free = []
    for name, texts in zip(map(str.strip, names), columns):
        values = [float(text.replace(",", ".")) for text in map(str.strip, texts) if run_layout.is_number(text)]
        counts = all(a <= b for a, b in itertools.pairwise(values))
        if len(values) > len(texts) / 2 and not counts and name not in options.columns.values() and "," not in name:
            free.append(name)
    wanted = [name for name in OUTPUTS if name not in options.columns]
    found = []
    for begin in range(len(free) - len(wanted) + 1) if wanted else ():
        way = free[begin : begin + len(wanted)]
        told = ",".join(f"{one}={name}" for one, name in zip(wanted, way))
        found.append(Remedy({"columns": told}, f"the outputs are {listed(way)}"))
    return found


def _other_sensors(names: list[str], outputs: Sequence[int]) -> list[str]:
    """That columns named as the outputs are but for a number, as ax2 beside ax, may be those of another sensor."""
    plain = [run_layout.unit_in(name)[0] for name in names]
    stems = [re.sub(r"\d", "", name) for name in plain]
    alike = [[plain[k] for k in range(len(names)) if k not in outputs and stems[k] == stems[own]] for own in outputs]
    told = [",".join(f"{one}={name}" for one, name in zip(OUTPUTS, axes)) for axes in zip(*alike)]
    is_sensor = (
        len(set(map(len, alike))) == 1 and all(stems[own] for own in outputs) and not any("," in n for n in plain)
    )
    return [f"another sensor? --columns {one}" for one in told] if is_sensor else []


def _about_columns(told: dict[str, str], unit: str, unit_told: bool) -> list[str]:
    """Which columns the outputs are, and their unit."""
    names = ", ".join(told[name] for name in OUTPUTS)
    return [f"outputs {quoted(names, 100)[1:-1]} in {unit}{'' if unit_told else ', assumed because no unit is given'}"]


def _source_column(data: bytes, layout: run_layout.Layout, used: set[int], choice: Choice | None) -> int | None:
    """The column that is chosen, or that may tell several sources apart: two to four texts, in turn. Raises
    UsageError."""
    if choice is not None and choice.column is not None:
        found = run_layout.find_column("source", list(layout.names), {"source": choice.column})
        if found is None:
            raise UsageError(f"--rows: no column {quoted(choice.column)} among {quoted(','.join(layout.names), 400)}")
        return found
    rows = []
    for _, line in itertools.islice(run_layout.rows_of(data, layout), _ROWS_IN_TURN):
        with suppress(csv.Error):
            rows.append(run_layout.split(line, layout.delimiter))
    for place, texts in enumerate(zip(*(row for row in rows if len(row) == layout.width))):
        changes = sum(one != other for one, other in itertools.pairwise(texts))
        if place not in used and 2 <= len(set(texts)) <= _MOST_SOURCES and changes >= _IN_TURN * len(texts):
            return place
    return None


def _optional_columns(names: list[str], options: run_layout.LayoutOptions, file: str, row: int) -> dict[str, int]:
    """Where the columns of OPTIONAL are that are there. Raises BadInput for one that the user names and is not."""
    found = {}
    for wanted in OPTIONAL:
        try:
            index = run_layout.find_column(wanted, names, options.columns)
        except ValueError as error:
            raise BadInput(str(error), file, row) from None
        if index is None and options.columns.get(wanted):
            asked = f"no column {quoted(options.columns[wanted])} (for {wanted})"
            raise BadInput(f"{asked} among {quoted(','.join(names), 400)}", file, row)
        if index is not None:
            found[wanted] = index
    return found


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
            hint = mark if other in refused.text else "; start the row with # to leave it out"
        raise BadInput(f"{refused}{hint}", file, refused.row, refused.column) from None
    if not len(rows):
        raise BadInput("no samples after the header", file, layout.header_row)
    return parser, rows


# Clocks.


def _clock(time: Floats | list[str], lines: Integers, name: str | None, timing: Timing, file: str) -> Clock | None:
    """By the rate that the user says, else of the column of that `name`; None where there is neither."""
    if timing.rate_hz is not None:
        return clocks.of_rate(len(lines), timing.rate_hz)
    if name is None or len(lines) < 2:
        return None
    if isinstance(time, list):
        return clocks.of_texts(time, file, lines)
    far = ~(np.abs(time) <= LARGEST_OUTPUT)
    if far.any():
        row = int(far.argmax())
        raise BadInput(f"{float(time[row])!r} is out of range", file, int(lines[row]), "time")
    return clocks.of_numbers(time, name, timing, file)


def _clock_of(values: Floats, name: str, timing: Timing, file: str) -> Clock:
    """Of a log whose time is sure to be a number; a rate that the user says is held against it."""
    if timing.rate_hz is None:
        return clocks.of_numbers(values, name, timing, file)
    try:
        doubt = clocks.contradiction(clocks.of_numbers(values, name, timing, file), timing.rate_hz, name)
    except BadInput:
        doubt = []
    return clocks.of_rate(len(values), timing.rate_hz, *doubt)


def _rate_doubt(
    data: bytes, layout: run_layout.Layout, name: str | None, columns: dict[str, int], timing: Timing, file: str
) -> list[str]:
    """That a clock at the beginning of the file contradicts the rate that the user says; a clock that cannot be read
    may be why it is said."""
    if timing.rate_hz is None or name is None:
        return []
    try:
        lines, texts = [], []
        for row, line in itertools.islice(run_layout.rows_of(data, layout), clocks.ROWS_OF_CLOCK):
            lines.append(row)
            texts.append(run_layout.split(line, layout.delimiter)[columns["time"]])
        pointed = [text.replace(",", ".") if layout.decimal == "," else text for text in texts]
        own = (
            clocks.of_numbers(np.array(list(map(float, pointed))), name, timing, file)
            if all(map(run_layout.NUMBER.fullmatch, pointed))
            else clocks.of_texts(texts, file, np.array(lines))
        )
    except (csv.Error, IndexError, BadInput):
        return []
    return clocks.contradiction(own, timing.rate_hz, name)


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


def _read_rawimu(file: str, data: bytes, options: run_layout.LayoutOptions, timing: Timing) -> Recording:
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
        raise BadInput(f"{damaged} lines of a RAWIMU log, none with a good checksum: record it again as ASCII", file)
    values = np.array(rows)
    notes = [f"RAWIMU log: {len(lines)} messages; ux is its X, uy the negative of its -Y, uz its Z, in counts"]
    if damaged or others:
        notes.append(f"left out: {damaged} messages that are damaged, {others} lines of something else")
    clock = _clock_of(values[:, 0], "time s", replace(timing, unit=timing.unit or "s"), file)
    unit = options.unit or can_bus.COUNTS
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
