"""Recorded runs before their schedule is known: from files in several formats, DataFrames, arrays."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np

from tumble.api.arguments import import_in_python, layout_options, told_in_python
from tumble.arrays import Floats, Integers
from tumble.core import MAX_MEAN, CoreSchedule
from tumble.errors import BadInput, UsageError
from tumble.files import can_log, frames, run_file
from tumble.files.disk import RUN_FILE, STANDARD_INPUT, Held, blocks_of, held, name_of, opened, require_no_folder_of
from tumble.files.frames import SUFFIXES, read_table_file, suffix_of
from tumble.files.rows import (
    FELT,
    NUMBERS,
    Anywhere,
    PositionIndex,
    Refused,
    Temperatures,
    temperatures_of_rows,
    temperatures_of_table,
)
from tumble.files.run_file import Rows, RowStore, Run, RunReader
from tumble.files.run_layout import (
    COLUMNS,
    NO_LAYOUT_OPTIONS,
    TEMPERATURE,
    LayoutOptions,
    find_all,
    unit_of,
)
from tumble.schedule import Schedule


class Recording:
    """Rows of a run as they were recorded. Made by `tumble.read`, given to `tumble.solve`. Immutable.

    A row is one sample, or one mean, of the three outputs at a position of a mounting. `notes`: of a CAN log, what was
    found in it and taken for granted, as sentences; else empty.
    """

    def __init__(
        self,
        name: str,
        options: LayoutOptions,
        source: str | Held | None = None,
        table: Any = None,
        is_file: bool = True,
    ):
        """`source`: a run file, "-" for standard input, or what was in one; else `table`: any that files.frames knows.
        `name`: what errors call it."""
        self.name = name
        self.is_file = is_file
        """Was it read from a file?"""
        self._options = options
        self._source = source
        self._table = table
        self.notes: tuple[str, ...] = ()

    @property
    def sha256(self) -> str | None:
        """Of the bytes of a CSV file, in hexadecimal digits, as results have it; None for other recordings."""
        return None if self._source is None else self._held.sha256

    @property
    def mounting(self) -> Integers:
        """Number of each row's mounting: (rows,)."""
        return self._rows.index // NUMBERS

    @property
    def position(self) -> Integers:
        """Number of each row's position: (rows,)."""
        return self._rows.index % NUMBERS

    @property
    def outputs(self) -> Floats:
        """Outputs of the three channels, in `unit`: (rows, 3)."""
        return self._rows.outputs

    @property
    def unit(self) -> str | None:
        """Of the outputs; None where nobody told it: volts are assumed."""
        return self._rows.unit

    @property
    def temperature_c(self) -> tuple[float, float] | None:
        """The lowest and the highest of the run, degrees Celsius; None where its rows do not tell it."""
        found = self._temperatures[0]
        return None if found is None else (found.low_c, found.high_c)

    @cached_property
    def temperatures_c(self) -> Floats | None:
        """Of every row, degrees Celsius: (rows,), NaN where a row does not tell it; None where no row does."""
        if self._temperatures[0] is None:
            return None
        if self._source is None:
            return temperatures_of_rows(self._table, self._options.columns, self.name)
        reader = RunReader(self._held, Anywhere(), self._options, self.name, recorded=True)
        return np.concatenate([values[:, FELT] for _, values in reader])

    def __len__(self) -> int:
        return len(self._rows.index)

    def __repr__(self) -> str:
        return f"<tumble.Recording {self.name}: {len(self)} rows, unit {self.unit or 'not told'}>"

    def averaged_on(self, schedule: CoreSchedule) -> tuple[Run, CoreSchedule]:
        """The run, averaged position by position, and the schedule: the given one, or its form with closures where the
        run has them. Raises BadInput."""
        if self._source is not None:
            # What is in memory is not read again; what is not goes through in blocks, and never is there as a whole.
            known = self._held if "_held" in self.__dict__ else self._source
            return run_file.read_measured(known, schedule, self._options)
        return run_file.on_schedule(self._on, schedule)

    def _on(self, schedule: Schedule) -> Rows:
        positions, rows = PositionIndex(schedule), self._rows
        index = positions.of_arrays(self.mounting.astype(float), self.position.astype(float))
        if (index < 0).any():
            row = int(np.argmax(index < 0))
            try:
                positions.of_row(float(self.mounting[row]), float(self.position[row]))
            except Refused as refused:
                raise BadInput(str(refused), self.name, int(rows.lines[row]), refused.column) from None
        store = RowStore(len(schedule.positions), self.name)
        store.add(index, np.column_stack((rows.outputs, rows.lines)))
        unit, (felt, passed_over) = self.unit, self._temperatures
        ignored = len(frames.names_of(self._table)) - len(COLUMNS) - (felt is not None)
        counters = {"blank_lines": 0, "comment_lines": 0, "columns_ignored": ignored}
        return Rows(store, unit or "V", unit is not None, counters, temperature=felt, passed_over=passed_over)

    @cached_property
    def _held(self) -> Held:
        """All of a run file."""
        return held(self._source) if isinstance(self._source, str) else cast(Held, self._source)

    @cached_property
    def _temperatures(self) -> tuple[Temperatures | None, tuple[str, ...]]:
        """And sentences on a column that is passed over."""
        if self._rows.reader is not None:
            return self._rows.reader.temperature
        return temperatures_of_table(self._table, self._options.columns, len(self), self.name)

    @cached_property
    def _rows(self) -> _Rows:
        if self._source is not None:
            reader = RunReader(self._held, Anywhere(), self._options, self.name)
            indices, values = zip(*reader)
            text, layout = np.concatenate(values), reader.layout
            unit = layout.unit if layout.unit_told else None
            return _Rows(np.concatenate(indices), text[:, :3], text[:, 3].astype(int), unit, reader)
        names = frames.names_of(self._table)
        try:
            places = find_all(names, self._options, is_text=False)
        except ValueError as error:
            raise BadInput(str(error), self.name) from None
        unit = unit_of(self._options, [names[place] for place in places[-3:]], self.name, None)
        rows = frames.stacked(self._table, places, COLUMNS, self.name)
        if not len(rows):
            raise BadInput("no samples", self.name)
        # numbers in range, as of a run file; the first row that has none is complained of
        bad = ~(np.abs(rows) <= MAX_MEAN)
        bad[:, :2] |= ~((rows[:, :2] >= 0) & (rows[:, :2] < NUMBERS) & (rows[:, :2] == np.floor(rows[:, :2])))
        if bad.any():
            row, column = np.argwhere(bad)[0].tolist()
            kind = "the number of a place" if column < 2 else "a finite number in range"
            raise BadInput(f"{float(rows[row, column])!r} is not {kind}", self.name, row + 1, COLUMNS[column])
        index = Anywhere().of_arrays(rows[:, 0], rows[:, 1])
        return _Rows(index, rows[:, 2:], np.arange(1, len(rows) + 1), unit)


@dataclass(frozen=True)
class _Rows:
    """`index` (rows,): NUMBERS times the mounting, and the position; `outputs` (rows, 3), in `unit`, if it is told;
    `lines` (rows,): their numbers in the file, from 1; `reader`: of a run file, what has read them."""

    index: Integers
    outputs: Floats
    lines: Integers
    unit: str | None
    reader: RunReader | None = None


def recording_of(source: Any, options: LayoutOptions = NO_LAYOUT_OPTIONS) -> Recording:
    """A recording as it is, or of whatever `read` takes. The rows of a CSV file are looked at when they are needed."""
    if isinstance(source, Recording):
        return source
    if isinstance(source, (str, os.PathLike)):
        file = str(os.fspath(source))
        if suffix_of(file) in SUFFIXES:
            return Recording(file, options, table=read_table_file(file))
        return Recording(name_of(file), options, file, is_file=file != STANDARD_INPUT)
    if not frames.is_table(source):
        source = _of_array(source)
    return Recording(frames.library_of(source) or "table", options, table=source, is_file=False)


def _of_array(source: Any) -> dict[str, Floats]:
    """A table of the columns of a plain array."""
    if type(source).__name__ == "LazyFrame":
        raise UsageError("a LazyFrame has no rows yet: collect() it")
    try:
        rows = frames.real(source)
    except (TypeError, ValueError):
        kind = f"{type(source).__module__}.{type(source).__name__}"
        raise UsageError(f"{kind} is neither a file, nor a table, nor an array of numbers") from None
    if rows.ndim != 2 or rows.shape[1] != len(COLUMNS):
        raise UsageError(f"an array of shape {rows.shape} is no run: (rows, 5) is one, of {', '.join(COLUMNS)}")
    return dict(zip(COLUMNS, rows.T))


def read(
    source: Any,
    *,
    columns: dict[str, str] | None = None,
    unit: str | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
    dbc: str | None = None,
    schedule: str | None = None,
    v_per_count: float | None = None,
) -> Recording:
    """Read a recorded run.

    Its columns are mounting, position, ux, uy, uz; it may have temperature, deg C; others are ignored. A log of a CAN
    bus has no positions: its rests are found and matched to those of a schedule, as `tumble import` does
    (docs/first-calibration.md), and the recording's `notes` report what was found.

    Parameters
    ----------
    source : path, table or array
        A run file (CSV; Parquet, `.parquet`; NPZ, `.npz`, and MAT, `.mat`, with an array for every column), a log of a
        CAN bus in any format that python-can reads, a DataFrame of pandas or polars, a table of pyarrow, a mapping from
        names to columns, a structured array, or an array (rows, 5).
    columns : dict of str to str, optional
        The columns that are named otherwise, as in `{"ux": "AccX"}`; of a CAN log three of its signals.
    unit : str, optional
        Of the outputs; detected unless given.
    delimiter, decimal : str, optional
        Of CSV; detected unless given.
    dbc : path, optional
        The DBC file of a CAN log whose block is not Tumble's.
    schedule : str or path, optional
        Of a CAN log: the name of a built-in one, or a file; default: "paper".
    v_per_count : float, optional
        Of a CAN log: volts of a count, above 0, where the block sends counts.

    Returns
    -------
    Recording

    Raises
    ------
    BadInput
        For what cannot be used, a ValueError: it names file, row and column; row 1 of a table that is no CSV file is
        its first.
    NotInstalled
        Where a library is missing, an ImportError.

    Examples
    --------
    >>> import tumble
    >>> run = tumble.read({"mounting": [1, 1], "position": [1, 2], "ux": [0.1, 1.5], "uy": [0, 0], "uz": [2.0, 1.4]},
    ...                   unit="V")
    >>> run
    <tumble.Recording table: 2 rows, unit V>
    >>> run.outputs.shape
    (2, 3)
    """
    with told_in_python():
        options = layout_options(columns, unit, delimiter, decimal)
        log = _can_log(source, dbc, schedule, v_per_count)
        if log is None:
            recording = recording_of(source, options)
            len(recording)  # what cannot be used is told now
            _ = recording.temperature_c if TEMPERATURE in (columns or {}) else None
            return recording
    with told_in_python(import_in_python):
        return _imported(log, options, dbc, schedule, v_per_count)


def _can_log(source: Any, dbc: str | None, schedule: str | None, v_per_count: float | None) -> str | None:
    """The file of a CAN log; None for any other source, which must be told nothing that only a log has."""
    file = str(os.fspath(source)) if isinstance(source, (str, os.PathLike)) else None
    is_log = False
    if file is not None and file != STANDARD_INPUT and suffix_of(file) not in SUFFIXES:
        require_no_folder_of(file, RUN_FILE)
        with opened(file) as stream:
            is_log = can_log.kind_of(next(blocks_of(stream, file, can_log.HEAD), b"")) is not None
    if file is None or not is_log:
        said = {"dbc": dbc, "schedule": schedule, "v_per_count": v_per_count}
        for name, value in said.items():
            if value is not None:
                raise UsageError(f"{name} is for a log of a CAN bus")
        return None
    if v_per_count is not None and not (isinstance(v_per_count, (int, float)) and 0 < v_per_count < MAX_MEAN):
        raise UsageError(f"v_per_count: {v_per_count!r} is no number of volts above 0")
    return file


def _imported(
    file: str, options: LayoutOptions, dbc: str | None, schedule: str | None, v_per_count: float | None
) -> Recording:
    """What the rests of a CAN log tell."""
    from tumble.files.schedule_file import read_schedule
    from tumble.importing import report
    from tumble.importing.can_bus import Bus
    from tumble.importing.pipeline import Settings, import_recordings

    bus = Bus(dbc=None if dbc is None else str(os.fspath(dbc)), v_per_count=float(v_per_count or 0.0))
    settings = Settings(schedule=None if schedule is None else str(schedule), layout=options, bus=bus)
    done = import_recordings([file], read_schedule(settings.schedule_name).data, settings)
    own = Held(report.run_csv(done).encode(), file)
    found = Recording(file, replace(NO_LAYOUT_OPTIONS, unit=done.unit if done.unit_told else None), own)
    found.notes = tuple(map(import_in_python, done.notes))
    len(found)  # what cannot be used is told now
    return found
