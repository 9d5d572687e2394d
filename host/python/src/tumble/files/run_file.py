"""Run files: recorded samples in, one mean per position and channel out.

A file goes one way: its bytes in blocks (incoming), its layout (run_layout), its rows as numbers (run_reader), grouped
by position (run_store), what those of a position say together (run_facts). Only the last two look at more than a block,
and only at the rows of one position at a time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.core import CoreSchedule
from tumble.files.incoming import Held, Incoming
from tumble.files.run_layout import COLUMNS, NO_WISHES, Wishes
from tumble.files.run_reader import PositionIndex, RunReader
from tumble.files.run_store import NO_BLOCKS, Blocks, RowStore, blocks_of
from tumble.files.run_temperature import Temperatures
from tumble.schedule import CHECK, CLOSED, Position, Schedule


@dataclass(frozen=True)
class Run:
    """A recorded run, position by position in the schedule's order.

    `samples` (positions,): rows of each, 0 where none; `means` (positions, 3); `scatter` (positions, 3): standard
    deviation of one sample (n - 1), NaN below two rows; `unit` of both; `counters`: what was found in the file;
    `sha256`: of its bytes, in hexadecimal digits, empty for a run that is in no file; `unit_told`: by the file or by
    the user, not assumed; `table`: the rows themselves, None where nobody has them; `blocks`: how they move together
    (files.run_blocks); `temperature`: None where it is not told; `passed_over`: sentences about columns that look like
    what they are not.
    """

    samples: Integers
    means: Floats
    scatter: Floats
    unit: str
    counters: dict[str, int]
    sha256: str = ""
    unit_told: bool = True
    table: RowStore | None = None
    blocks: Blocks = NO_BLOCKS
    temperature: Temperatures | None = None
    passed_over: tuple[str, ...] = ()

    @property
    def measured(self) -> Flags:
        """Which positions have a mean: (positions,) bool."""
        return self.samples > 0


def read_measured(
    source: str | Incoming | Held, schedule: CoreSchedule, wishes: Wishes = NO_WISHES
) -> tuple[Run, CoreSchedule]:
    """Read a run file as `read_run` does, on a schedule as `on_schedule` takes it. Raises BadInput."""
    return on_schedule(lambda planned: read_rows(source, planned, wishes), schedule)


def on_schedule(read: Callable[[Schedule], Rows], schedule: CoreSchedule) -> tuple[Run, CoreSchedule]:
    """A run on a schedule, or where it has positions that close its mountings, on the form of it that has them. It is
    read once, on that form."""
    if schedule.name not in CLOSED:
        return read(schedule.data).run(), schedule
    closed = CoreSchedule.built_in(CLOSED[schedule.name])
    rows = read(closed.data)
    if any(rows.store.samples[index] > 0 for index, one in enumerate(closed.data.positions) if one.use == CHECK):
        return rows.run(), closed
    return rows.on(closed.data, schedule.data).run(), schedule


def read_run(file: str, schedule: Schedule, wishes: Wishes = NO_WISHES) -> Run:
    """Read a run file (CSV), or standard input ("-"), compressed or not. Raises BadInput, NotInstalled."""
    return read_rows(file, schedule, wishes).run()


@dataclass(frozen=True)
class Rows:
    """What a file or a table holds: its rows in a `store`, the `unit` of their outputs and whether that is told, and as
    in Run `counters` of what was passed over, `sha256`, `temperature` and `passed_over`."""

    store: RowStore
    unit: str
    unit_told: bool
    counters: dict[str, int]
    sha256: str = ""
    temperature: Temperatures | None = None
    passed_over: tuple[str, ...] = ()

    def on(self, planned: Schedule, other: Schedule) -> Rows:
        """On a schedule that has all their positions, after the one that they were read on."""
        places = {_numbers(position): index for index, position in enumerate(planned.positions)}
        return replace(self, store=self.store.on([places[_numbers(position)] for position in other.positions]))

    def run(self) -> Run:
        """Averaged, position by position."""
        samples, facts = self.store.samples, self.store.facts
        measured = int((samples > 0).sum())
        counters = {
            "rows": int(samples.sum()),
            "positions": measured,
            "positions_missing": len(samples) - measured,
            **self.counters,
        }
        means, scatter = np.array([one.means for one in facts]), np.array([one.scatter for one in facts])
        given = samples, means, scatter, self.unit, counters, self.sha256, self.unit_told, self.store, blocks_of(facts)
        return Run(*given, self.temperature, self.passed_over)


def _numbers(position: Position) -> tuple[int, int]:
    return position.mounting, position.number


def read_rows(source: str | Incoming | Held, schedule: Schedule, wishes: Wishes = NO_WISHES) -> Rows:
    """As read_run, without looking at the rows. Raises BadInput, NotInstalled."""
    incoming = Incoming(source) if isinstance(source, str) else source
    reader = RunReader(incoming, PositionIndex(schedule), wishes, incoming.name)
    store = RowStore(len(schedule.positions), incoming.name)
    for index, values in reader:
        store.add(index, values)
    temperature, passed_over = reader.temperature
    counters = {
        "blank_lines": reader.blanks,
        "comment_lines": reader.comments,
        "columns_ignored": reader.layout.width - len(COLUMNS) - (temperature is not None),
    }
    told = reader.layout.unit, reader.layout.unit_told, counters
    return Rows(store, *told, incoming.sha256, temperature, passed_over)
