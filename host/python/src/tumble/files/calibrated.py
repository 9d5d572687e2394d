"""Measured data, and the same data with calibrated columns behind its own: CSV and Parquet, piece by piece, so that a
file may be larger than the memory.

Whoever calls says what becomes of outputs (samples, 3): an array (samples, 3) of x, y, z, or (samples, 7) with u_x,
u_y, u_z, u_norm behind.
"""

from __future__ import annotations

import codecs
import io
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any, BinaryIO

import numpy as np

from tumble.arrays import Floats
from tumble.errors import BadInput, file_name, quoted
from tumble.files import frames
from tumble.files.disk import blocks_of, bounded, opened, pieces
from tumble.files.rows import (
    FELT,
    LINE,
    OUTPUTS as PLACES,
    Refused,
    RowParser,
    Temperatures,
    temperatures_of_rows,
    temperatures_of_table,
)
from tumble.files.run_layout import (
    UTF_16,
    LayoutOptions,
    about_header,
    below_units,
    body_of,
    detect,
    find_all,
    has_header,
    require_text,
    unit_of,
)
from tumble.units import looks_as_applied, noise_unit, volts_per

OUTPUTS = ("ux", "uy", "uz")
CALIBRATED = ("x", "y", "z")
UNCERTAINTIES = ("u_x", "u_y", "u_z", "u_norm")
_PIECE = 1 << 22  # bytes of CSV
_ROWS = 1 << 16  # of Parquet
_STEADY_ROWS, _STEADY = 20, 0.02  # rows of which the length scatters by no larger part of itself
_FEWEST_RESTS, _MOST_RESTS = 3, 100_000
_ALIKE = 0.1  # part by which most rests may differ
_FAR_FROM_1_G, _NEVER_1_G = 1.25, 2.0  # factors
_NEARLY_ALL = 0.95

Calibrate = Callable[[Floats], Floats]
CalibrateAtTemperature = Callable[[Floats, Floats], Floats]


@dataclass(frozen=True)
class Demand:
    """What to do with data: `calibrate` turns outputs in `unit` into what is appended, `with_uncertainty` or without;
    `layout`: what the user says about the data's layout; `unit_told`: by the run of the result, not assumed; `one_g`:
    as what is appended has it; `at_temperature`: in place of `calibrate`, of outputs and temperatures (samples,), in
    deg C."""

    calibrate: Calibrate
    unit: str
    with_uncertainty: bool
    layout: LayoutOptions
    unit_told: bool = True
    one_g: float = 1.0
    at_temperature: CalibrateAtTemperature | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Of the columns that are appended, x, y, z being the last."""
        return (*UNCERTAINTIES, *CALIBRATED) if self.with_uncertainty else CALIBRATED

    def values(self, outputs: Floats, factor: float, felt_c: Floats) -> Floats:
        """In the order of `names`; `factor`: from the data's unit to the result's; `felt_c`: temperatures (samples,),
        NaN where they are not known. Raises BadInput."""
        if self.at_temperature is not None:
            if (unknown := np.isnan(felt_c)).any():
                raise BadInput("tells no temperature, which this result needs", "data", int(unknown.argmax()) + 1)
            return self.at_temperature(outputs * factor, felt_c)
        found = self.calibrate(outputs * factor)
        return np.concatenate([found[:, 3:], found[:, :3]], axis=1)


@dataclass
class Seen:
    """What was found beside the outputs: columns that were `renamed`; `temperatures_c`, the lowest and the highest,
    empty where the data tell none; sentences on columns that are `passed_over`; `unit_told`: of the outputs, by the
    data or the user; `rests_g`: the length of the acceleration wherever it is steady; `notes`: on the layout."""

    renamed: dict[str, str] = field(default_factory=dict)
    temperatures_c: tuple[float, ...] = ()
    passed_over: tuple[str, ...] = ()
    unit_told: bool = False
    rests_g: list[float] = field(default_factory=list)
    notes: tuple[str, ...] = ()

    def feel(self, found: Temperatures | None, passed_over: tuple[str, ...]) -> None:
        """Keep what further rows say of their temperature."""
        self.passed_over = self.passed_over or passed_over
        if found is not None:
            known = (*self.temperatures_c, found.low_c, found.high_c)
            self.temperatures_c = (min(known), max(known))

    def weigh(self, force_g: Floats) -> None:
        """Keep how long the acceleration (samples, 3) of further rows is while it is steady."""
        whole = len(force_g) // _STEADY_ROWS * _STEADY_ROWS
        lengths = np.linalg.norm(force_g[:whole], axis=1).reshape(-1, _STEADY_ROWS)
        means = lengths.mean(axis=1)
        steady = means[lengths.std(axis=1) < _STEADY * means]  # of NaN nothing is
        self.rests_g += steady[: _MOST_RESTS - len(self.rests_g)].tolist()

    def doubt(self, demand: Demand) -> str | None:
        """That rests are not of 1 g: outputs in another unit? None where units are told, or nothing says so."""
        usual = float(np.median(self.rests_g)) if len(self.rests_g) >= _FEWEST_RESTS else 1.0
        alike = sum(abs(one - usual) < _ALIKE * usual for one in self.rests_g)
        if (self.unit_told and demand.unit_told) or usual == 0.0:
            return None
        if 1.0 / _FAR_FROM_1_G < usual < _FAR_FROM_1_G or (2 * alike < len(self.rests_g) and not self._never_1_g):
            return None
        other = looks_as_applied(usual, demand.unit)
        seen = f"outputs look to be in {other or 'another unit'}, the result is for {demand.unit}"
        return f"at rest the acceleration comes out as {usual:.3g} g: {seen}"

    def refusal(self, demand: Demand) -> str | None:
        """The same where nearly no rest may be one of 1 g, and what to do if all is right; else None."""
        doubt = self.doubt(demand) if self._never_1_g else None
        if doubt is None:
            return None
        remedy = (
            f"name the unit in the header, as ux [{demand.unit}]" if demand.unit_told else "solve again with --unit"
        )
        return f"{doubt}; if it is right, {remedy}"

    @property
    def _never_1_g(self) -> bool:
        far = sum(not 1.0 / _NEVER_1_G < one < _NEVER_1_G for one in self.rests_g)
        return far >= _NEARLY_ALL * len(self.rests_g)


def factor_of(told: str | None, unit: str, name: str) -> float:
    """From outputs in the unit that is `told`, None for none, to those of a result in `unit`. Raises BadInput."""
    if told is None or told == unit:
        return 1.0
    if noise_unit(told) != "V" or noise_unit(unit) != "V":
        raise BadInput(f"outputs in {told}, but the result is for {unit}", name)
    return volts_per(told) / volts_per(unit)


def raw_names(names: list[str], with_uncertainty: bool) -> dict[str, str]:
    """New names for columns of data that are named like what is appended: raw_x for x."""
    taken, renamed = set(names), {}
    for name in (*CALIBRATED, *(UNCERTAINTIES if with_uncertainty else ())):
        if name in taken:
            other = f"raw_{name}"
            while other in taken:
                other = f"raw_{other}"
            taken.add(other)
            renamed[name] = other
    return renamed


class CsvData:
    """A CSV file of measured data, laid out as `tumble import` takes it, read in pieces that end where a line does. A
    header may stand in a comment or be missing, with rows above it, or a row of units below. Raises BadInput."""

    def __init__(self, stream: BinaryIO, file: str, demand: Demand):
        self._demand, self._file, self.close = demand, file, stream.close
        blocks = _in_utf_8(blocks_of(stream, file, _PIECE))
        self._pieces = pieces(blocks, file)
        if demand.layout.delimiter == " ":
            self._pieces = map(_single_spaced, self._pieces)
        self._first = next(self._pieces, b"")
        require_text(self._first, file)
        options = replace(demand.layout, has_preamble=True)
        layout = detect(self._first, options, file)
        lines, names_row = _lines(self._first), layout.header_row
        is_named = has_header(self._first, layout)
        notes = about_header(self._first, layout, options)
        self._layout, _, more = below_units(self._first, layout, options, file)
        told = self._layout.unit if self._layout.unit_told else None
        self._factor = factor_of(told, demand.unit, file)
        head = [next(lines) for _ in range(self._layout.header_row)]
        self._names = list(layout.names)
        renamed = raw_names(self._names, demand.with_uncertainty) if is_named else {}
        self.seen = Seen(renamed, unit_told=told is not None, notes=(*notes, *more))
        self._parser = RowParser(self._layout, OUTPUTS, decoded=_decoded, recorded=demand.at_temperature is not None)
        self._body = body_of(self._first, self._layout.header_row)
        above, self._units = (head[: names_row - 1], head[names_row:]) if is_named else (head, [])
        self._preamble, self._header = "".join(above), head[names_row - 1] if is_named else ""
        self._end = _end_of(self._header or next(lines, "")) or "\n"

    @property
    def header(self) -> bytes:
        """What stands above the rows: the file's own, with the names of the new columns, and their units below if the
        file has units there."""
        if not self._header:
            return _encoded(self._preamble)
        delimiter, names = self._layout.delimiter, self._demand.names
        own = self._header.rstrip("\r\n")
        if self.seen.renamed:
            sign = own[: len(own) - len(own.lstrip("\ufeff# "))]
            own = sign + delimiter.join(_quoted(self.seen.renamed.get(name, name), delimiter) for name in self._names)
        lines = [delimiter.join([own, *names]) + self._end]
        for line, text in zip(self._units, ("g" if self._demand.one_g == 1.0 else "m/s^2", "", "")):
            lines.append(delimiter.join([line.rstrip("\r\n"), *[text] * len(names)]) + self._end)
        return _encoded(self._preamble + "".join(lines))

    def require_header_of(self, other: CsvData) -> None:
        """The rows of both can stand in one file. Raises BadInput."""
        own, its = (self._names, self._layout.delimiter, self._layout.decimal), other._layout
        if own != (other._names, its.delimiter, its.decimal):
            raise BadInput(
                f"has other columns than {file_name(other._file)}: --out FOLDER keeps them apart", self._file
            )

    def rows(self) -> Iterator[bytes]:
        """Every row with its calibrated columns, in pieces; blank lines and comments as they are."""
        for piece in chain([self._body] if self._body else [], self._pieces):
            yield self._calibrated(piece)
        if not self._parser.rows:
            raise BadInput("no samples after the header", self._file, self._layout.header_row)

    def _calibrated(self, piece: bytes) -> bytes:
        """A piece with its new columns."""
        first, lines = self._parser.line, list(_lines(piece))
        try:
            _, rows = self._parser.parse(piece)
        except Refused as refused:
            raise BadInput(str(refused), self._file, refused.row, refused.column) from None
        if self._parser.lost:
            raise BadInput("a row has no value", self._file)
        self.seen.feel(*self._parser.thermometer.told(self._file))
        numbers = rows[:, LINE].astype(int).tolist()
        try:
            values = self._demand.values(rows[:, PLACES], self._factor, rows[:, FELT:].ravel())
        except BadInput as error:
            raise BadInput(error.fault, self._file, None if error.row is None else numbers[error.row - 1]) from None
        self.seen.weigh(values[:, -3:] / self._demand.one_g)
        for number, appended in zip(numbers, values.tolist()):
            lines[number - first] = self._with_numbers(lines[number - first], appended)
        return _encoded("".join(lines))

    def _with_numbers(self, line: str, numbers: list[float]) -> str:
        end = _end_of(line)
        text = [f"{number:.9f}" for number in numbers]
        if self._layout.decimal == ",":
            text = [one.replace(".", ",") for one in text]
            if self._layout.delimiter == ",":
                text = [f'"{one}"' for one in text]
        if not all(map(math.isfinite, numbers)):
            text = [one if math.isfinite(number) else "" for one, number in zip(text, numbers)]
        own = line[: len(line) - len(end)] if end else line
        return self._layout.delimiter.join([own, *text]) + (end or self._end)


def _in_utf_8(blocks: Iterator[bytes]) -> Iterator[bytes]:
    """Of text in UTF-16, if its first bytes say so."""
    first = next(blocks, b"")
    if not first.startswith(UTF_16):
        yield from chain([first] if first else [], blocks)
        return
    decode = codecs.getincrementaldecoder("utf-16")("replace").decode
    for block in chain([first], blocks):
        yield decode(block).encode()


def _single_spaced(piece: bytes) -> bytes:
    """With one blank between columns, however they are aligned."""
    return re.sub(rb"(?m)^ | (?=\r?$)", b"", re.sub(rb"[ \t]+", b" ", piece))


def _lines(data: bytes) -> Iterator[str]:
    """Of CSV, with their ends; what is no UTF-8 comes back as it was."""
    return iter(io.StringIO(_decoded(data), newline=""))


def _decoded(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape")


def _encoded(text: str) -> bytes:
    return text.encode("utf-8", "surrogateescape")


def _end_of(line: str) -> str:
    return line[len(line.rstrip("\r\n")) :]


def _quoted(name: str, delimiter: str) -> str:
    special = delimiter in name or '"' in name
    return '"' + name.replace('"', '""') + '"' if special else name


def calibrate_parquet(file: str, out: BinaryIO, demand: Demand) -> Seen:
    """Write a Parquet file with calibrated columns: piece by piece by pyarrow, as a whole by polars. Raises BadInput,
    NotInstalled."""
    seen = Seen()
    with bounded(file):
        opened(file).close()  # the system's own complaint, whatever the library's is
        try:
            from pyarrow import Table, parquet
        except ImportError:
            table = _read_by(frames.load_polars(file).read_parquet, file)
            with_calibrated(table, file, demand, seen).write_parquet(out)
            return seen
        source, writer = _read_by(parquet.ParquetFile, file), None
        try:
            for batch in source.iter_batches(_ROWS):
                table = with_calibrated(Table.from_batches([batch]), file, demand, seen)
                writer = writer or parquet.ParquetWriter(out, table.schema)
                writer.write_table(table)
            if writer is None:
                empty = Table.from_batches([], schema=source.schema_arrow)
                writer = parquet.ParquetWriter(out, with_calibrated(empty, file, demand, seen).schema)
        finally:
            if writer is not None:
                writer.close()
    return seen


def _read_by(read: Callable[[str], Any], file: str) -> Any:
    try:
        return read(file)
    except Exception as error:  # classes of its own for what is no such file
        raise BadInput(f"not a Parquet file that can be read: {quoted(error)}", file) from None


def with_calibrated(table: Any, name: str, demand: Demand, seen: Seen) -> Any:
    """A table of files.frames with its calibrated columns; what else is in it is added to what was `seen`. Raises
    BadInput."""
    names, options = frames.names_of(table), demand.layout
    try:
        places = find_all(names, LayoutOptions(columns=options.columns, wanted=OUTPUTS), is_text=False)
    except ValueError as error:
        raise BadInput(str(error), name) from None
    told = unit_of(options, [names[place] for place in places], name, None, "outputs_unit")
    outputs = frames.stacked(table, places, OUTPUTS, name)
    felt_c = np.zeros(0) if demand.at_temperature is None else temperatures_of_rows(table, options.columns, name)
    try:
        values = demand.values(outputs, factor_of(told, demand.unit, name), felt_c)
    except BadInput as error:
        raise BadInput(error.fault, name, error.row) from None
    seen.renamed, seen.unit_told = raw_names(names, demand.with_uncertainty), told is not None
    seen.weigh(values[:, -3:] / demand.one_g)
    seen.feel(*temperatures_of_table(table, options.columns, len(outputs), name))
    return frames.with_columns(table, seen.renamed, dict(zip(demand.names, values.T)))
