"""A history as a script sees it."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Sequence
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.documents.labels import iso, serial_of
from tumble.documents.result import Result as ResultDocument, parse_result
from tumble.errors import BadInput, UsageError, needing, quoted
from tumble.files.disk import JSON, RESULT_FILE, kind_of, path_of, read_bytes, written
from tumble.history import calibrations
from tumble.history.calibrations import Row
from tumble.history.database import Columns, Database
from tumble.model.prior import DAY_S, Growth, LastCalibration
from tumble.store.image import MIN_SECTOR, read_image

if TYPE_CHECKING:
    from tumble.documents.history import Due, Listing, Trend

CONTROL = 0.9973  # confidence of the control charts: three standard deviations
COVERAGE = 3.0
_CONFIDENCES = 0.5, 0.999999


class History:
    """Calibrations of many blocks in a database: the path of a file of SQLite, or a URL of SQLAlchemy, such as
    postgresql://USER@HOST/NAME. The first results that are added make it. Close it, or use it in a `with`.

    Raises UsageError for a URL that is none, NotInstalled without SQLAlchemy; its methods BadInput for what is no
    history.
    """

    def __init__(self, db: str | os.PathLike[str]):
        self._database = Database(path_of(db))

    def __enter__(self) -> History:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the database."""
        self._database.close()

    def add(
        self,
        *results: Any,
        serial: str | None = None,
        type: str | None = None,
        date: str | None = None,
    ) -> int:
        """Add results: objects of `tumble.Result`, files, or folders, in which every result.json is taken; and images
        of a navigation computer's memory, whose history is. Returns how many are new: one that is there already is not
        added again.

        `serial`, `type`: of the block, in place of what the results say; `date`, YYYY-MM-DD: when it was measured; not
        for images, whose sets have dates of their own. All are added or none. Raises BadInput for a file that cannot
        be used, a result that names no block or no date; UsageError for a `date` that is none, or with an image.
        """
        rows: list[Row] = []
        for name, data in _documents(results):
            if data and len(data) % MIN_SECTOR == 0 and kind_of(data) != JSON:
                if date is not None:
                    raise UsageError(f"--date: the sets in a memory have dates of their own: leave it out for {name}")
                rows += calibrations.rows_of_image(read_image(data, name=name), name, serial, type)
            else:
                rows.append(calibrations.row_of(data, name, serial, type, date))
        return self._database.add(rows)

    def add_rows(self, rows: Sequence[Row]) -> int:
        """Add rows as `tumble.history.calibrations.row_of` makes them, with or without a document."""
        return self._database.add(rows)

    def columns(self, *serials: str, type: str | None = None) -> Columns:
        """All columns as arrays, by block and time. Raises BadInput where no calibration is found."""
        found = self._database.read(serials, type)
        if not len(found["id"]):
            raise BadInput(f"no calibration{_of(serials, type)}", self._database.name)
        return found

    def document(self, sha256: str) -> bytes:
        """A result as it was added. Raises BadInput."""
        return self._database.document(sha256)

    def show(self, *serials: str, type: str | None = None) -> Listing:
        """The calibrations, of these blocks or of all."""
        from tumble.history import report

        return report.listing(self._database.name, self.columns(*serials, type=type))

    def trend(self, serial: str | None = None, *, type: str | None = None, confidence: float = CONTROL) -> Trend:
        """Growth of the types and alarms. `serial`: of one block the alarms alone, and the points of its charts.
        `confidence`: 0.5 to 0.999999. Raises UsageError, BadInput."""
        from tumble.history import report

        _require("confidence", confidence, *_CONFIDENCES)
        columns = self._of_type(serial, type)
        return report.trend(self._database.name, columns, confidence, serial)

    def due(
        self,
        limit_g: float,
        serial: str | None = None,
        *,
        type: str | None = None,
        coverage_factor: float = COVERAGE,
        method: str = "control-chart",
        confidence: float = CONTROL,
    ) -> Due:
        """When blocks are due, so that `coverage_factor` times the standard uncertainty of the length of a calibrated
        acceleration stays within `limit_g`, in g, above 0 and at most 1. `coverage_factor`: 1 to 10; `method`:
        "control-chart" or "staircase"; `confidence`: 0.5 to 0.999999. Raises UsageError, BadInput."""
        from tumble.history import report
        from tumble.history.due import METHODS

        if method not in METHODS:
            raise UsageError(f"method: {quoted(method)} is not one of {', '.join(METHODS)}")
        _require("limit_g", limit_g, math.ulp(0.0), 1.0, "a number of g above 0, at most 1")
        _require("coverage_factor", coverage_factor, 1.0, 10.0)
        _require("confidence", confidence, *_CONFIDENCES)
        columns = self._of_type(serial, type)
        return report.due(self._database.name, columns, limit_g, coverage_factor, method, confidence, serial)

    def trend_and_due(self, result: ResultDocument, name: str) -> tuple[Trend, Due]:
        """What is known of the block of a result called `name`, and when it is due by the limit and the coverage factor
        of that result. Raises BadInput."""
        serial = serial_of(result.serial, result.item)
        if serial is None:
            raise BadInput("names no block: write serial under [block] of its stand file", name)
        factor = COVERAGE if result.decision is None else result.decision.coverage_factor
        return self.trend(serial), self.due(result.verification.limit_g, serial, coverage_factor=factor)

    def prior(
        self,
        serial: str,
        *,
        on: str | None = None,
        other_than_run: str | None = None,
        growth: Growth | None = None,
    ) -> LastCalibration:
        """The last calibration of a block that counts, as a prior of its next run, and how blocks of its type grow.
        `on`, YYYY-MM-DD: the day of that run; `other_than_run`: SHA-256 of its file, which may be in the history
        already; `growth`: in place of that of its type. Raises BadInput, UsageError where the growth is not known."""
        columns = self.columns(serial)
        end_s = math.inf if on is None else calibrations.seconds_of(on, "on") + DAY_S
        counts = columns["believed"] & np.isfinite(columns["u_scale_x"]) & (columns["created_s"] < end_s)
        counts &= columns["estimator"] != calibrations.ON_BOARD
        if other_than_run is not None:
            counts &= columns["run_sha256"] != other_than_run
        for row in reversed(np.flatnonzero(counts).tolist()):
            name = f"{self._database.name}: {serial} of {iso(columns['created_s'][row])[:10]}"
            result = parse_result(self.document(columns["sha256"][row]), name)
            if result.extended is None:  # a prior has the twelve alone
                known = self._growth_of(str(columns["type"][-1])) if growth is None else growth
                return LastCalibration(result, name, known, serial, int(columns["created_s"][row]))
        raise BadInput(f"no earlier calibration of block {quoted(serial)} that may be a prior", self._database.name)

    def _growth_of(self, kind: str) -> Growth:
        from tumble.history import trend as trends

        series = trends.fleet_of(self.columns(type=kind))[0].get(kind, [])
        found = trends.growth_of(series, trends.control_limit(CONTROL))
        if found is None:
            intervals = sum(one.intervals for one in series)
            raise UsageError(
                f"growth of type {quoted(kind or '-')} unknown: {intervals} intervals between calibrations,"
                f" {trends.LEAST_INTERVALS} are needed; give --growth SCALE,ANGLE,BIAS, in ppm, urad and ug a year"
            )
        block = slice(calibrations.OF_BLOCK)
        return Growth(found.walk[block], found.drift[block], found.spread[block], "history")

    def to_frame(self, *serials: str, type: str | None = None) -> Any:
        """The columns as a DataFrame of pandas, `measured` as times."""
        with needing("a table of calibrations", "pandas", extra="pandas"):
            import pandas
        columns = self.columns(*serials, type=type)
        del columns["covariance"]
        columns["measured"] = columns.pop("created_s").astype("datetime64[s]")
        return pandas.DataFrame(columns)

    def export(self, file: str, *serials: str, type: str | None = None) -> int:
        """Write the columns as Parquet; DuckDB, pandas and polars read it. Returns how many calibrations."""
        with needing("an export of the history", "pyarrow", extra="parquet"):
            from pyarrow import Table, array, parquet, timestamp
        columns: dict[str, Any] = dict(self.columns(*serials, type=type))
        columns["measured"] = array(columns.pop("created_s").astype("datetime64[s]"), timestamp("s", "UTC"))
        arrays = {name: array(column, from_pandas=True) for name, column in columns.items() if name != "measured"}
        table = Table.from_pydict({**arrays, "measured": columns["measured"]})
        with written(file) as stream:
            parquet.write_table(table, stream, compression="zstd")
        return int(table.num_rows)

    def _of_type(self, serial: str | None, type: str | None) -> Columns:
        """Of one block all blocks of its type: its growth is theirs."""
        if serial is not None:
            type = str(self.columns(serial, type=type)["type"][-1])
        return self.columns(type=type)


def _require(name: str, value: float, low: float, high: float, what: str = "") -> None:
    if not (isinstance(value, Real) and low <= value <= high):
        raise UsageError(f"{name}: {quoted(value)} is not {what or f'a number from {low:g} to {high:g}'}")


def _of(serials: Sequence[str], type: str | None) -> str:
    """Such as " of block A-1"."""
    told = [f" of block {quoted(', '.join(serials))}"] if serials else []
    told += [f" of type {quoted(type)}"] if type is not None else []
    return "".join(told)


def _documents(results: Iterable[Any]) -> Iterator[tuple[str, bytes]]:
    for result in results:
        if not isinstance(result, (str, os.PathLike)):
            if not hasattr(result, "to_json"):
                raise UsageError(f"a {type(result).__name__} is neither a tumble.Result nor the path of one")
            yield "result", result.to_json().encode()
            continue
        path = path_of(result)
        if not os.path.isdir(path):
            yield path, read_bytes(path)
            continue
        found = sorted(Path(path).rglob(RESULT_FILE))
        if not found:
            raise BadInput(f"no {RESULT_FILE} in it, nor in a folder below", path)
        yield from ((os.fspath(one), read_bytes(os.fspath(one))) for one in found)
