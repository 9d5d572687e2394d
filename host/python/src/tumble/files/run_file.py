"""Run files: recorded samples in, one mean per position and channel out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tumble.errors import BadInput
from tumble.files.disk import read_bytes
from tumble.files.run_layout import COLUMNS, NO_WISHES, Wishes, detect
from tumble.files.run_table import PositionIndex, RunTable, read_table
from tumble.schedule import Schedule


@dataclass(frozen=True)
class Run:
    """A recorded run, position by position in the schedule's order.

    `samples` (positions,): rows of each, 0 where none; `means` (positions, 3); `scatter` (positions, 3): standard
    deviation of one sample (n - 1), NaN below two rows; `unit` of both; `counters`: what was found in the file.
    """

    samples: np.ndarray
    means: np.ndarray
    scatter: np.ndarray
    unit: str
    counters: dict[str, int]

    @property
    def measured(self) -> np.ndarray:
        """Which positions have a mean: (positions,) bool."""
        return self.samples > 0


def read_run(file: str, schedule: Schedule, wishes: Wishes = NO_WISHES) -> Run:
    """Read a run file (CSV). Raises BadInput with file, row and column."""
    data = read_bytes(file)
    _require_text(data, file)
    dialect = detect(data, wishes, file)
    table = read_table(data, dialect, PositionIndex(schedule), file)
    samples, means, scatter = _average(table, len(schedule.positions))
    measured = int((samples > 0).sum())
    counters = {
        "rows": len(table.index),
        "positions": measured,
        "positions_missing": len(schedule.positions) - measured,
        "blank_lines": table.blanks,
        "comment_lines": table.comments,
        "columns_ignored": dialect.width - len(COLUMNS),
    }
    return Run(samples, means, scatter, dialect.unit, counters)


def _require_text(data: bytes, file: str) -> None:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise BadInput("UTF-16 text; save it as UTF-8", file, 1)
    zero = data.find(b"\0")
    if zero >= 0:
        raise BadInput("not a text file", file, data.count(b"\n", 0, zero) + 1)
    if not data.strip():
        raise BadInput("the file is empty", file, 1)


def _average(table: RunTable, positions: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Samples, means and scatter per position. Sums are exact (fsum), so their order does not matter."""
    samples = np.bincount(table.index, minlength=positions)
    means, scatter = np.full((2, positions, 3), np.nan)
    grouped = np.split(table.outputs[np.argsort(table.index, kind="stable")], np.cumsum(samples)[:-1])
    for index, rows in enumerate(grouped):
        if len(rows) > 0:
            means[index] = [math.fsum(channel) / len(rows) for channel in rows.T.tolist()]
        if len(rows) > 1:
            scatter[index] = rows.std(axis=0, ddof=1)
    return samples, means, scatter
