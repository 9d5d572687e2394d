"""Measure `tumble history` on a simulated fleet: rates of alarms, due dates, seconds.

    tools/benchmark history [--blocks N] [--each N] [--db FILE|URL] [--table]

A tenth of a per cent of all values are jumps, as many outliers, of six standard deviations of an innovation; of half a
per cent of the calibrations the seat was exchanged. Seconds are compared with those of pandas, which fits a straight
line to every parameter of every block.
"""

import argparse
import importlib.util
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "lib"))

from fleets import TRUTH, fleet, forecast_of, off_when_due, rows_of

from tumble.documents.labels import iso
from tumble.history import History, trend
from tumble.history.calibrations import OF_BLOCK, PARAMETERS

SHARES = {"jumps": 0.001, "outliers": 0.001, "size": 6.0, "seats": 0.005}
LIMIT_G, COVERAGE, CONFIDENCE = 6e-5, 2.0, 0.9973


def main(arguments):
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--blocks", type=int, default=10_000)
    parser.add_argument("--each", type=int, default=10, help="calibrations of a block")
    parser.add_argument("--db", help="of a history that is not there yet; default: SQLite in a folder of its own")
    parser.add_argument("--table", action="store_true", help="as Markdown")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        found = measured(options.blocks, options.each, options.db or f"{folder}/history.db", f"{folder}/h.parquet")
    lines_s = found["straight lines by pandas, s"]
    if options.table:
        print("| what | measured | beside pandas' straight lines |\n|---|---|---|")
    for name, value in found.items():
        beside = f"{value / lines_s:.2f}" if name.endswith(", s") else ""
        print(f"| {name} | {value:.3g} | {beside} |" if options.table else f"{name:42} {value:10.3g} {beside:>8}")
    return 0


def measured(blocks, each, where, exported, seed=71, with_lines=True):
    """Figures by name; `exported`: the file of Parquet."""
    made = fleet(blocks, each, seed, **SHARES)
    rows, seconds = rows_of(made.series), {}

    def timed(name, call):
        began = time.perf_counter()
        found = call()
        seconds[f"{name}, s"] = time.perf_counter() - began
        return found

    with History(where) as history:
        assert timed("add", lambda: history.add_rows(rows)) == blocks * each
        assert timed("add again", lambda: history.add_rows(rows)) == 0
        told = timed("trend", lambda: history.trend(confidence=CONFIDENCE))
        due = timed("due", lambda: history.due(LIMIT_G, coverage_factor=COVERAGE, confidence=CONFIDENCE))
        timed("export as Parquet", lambda: history.export(exported))
        if importlib.util.find_spec("duckdb"):
            timed("DuckDB: a slope of every block", lambda: slopes(exported, blocks))
        seconds |= lines(history.columns()) if with_lines else {}
    return {**alarms(made, told), **due_dates(made, due), **seconds}


def slopes(exported, blocks):
    """By DuckDB, from the exported file."""
    import duckdb

    query = f"SELECT serial, regr_slope(bias_x, epoch(measured)) FROM '{exported}' GROUP BY serial"
    assert len(duckdb.sql(query).fetchall()) == blocks


def alarms(made, told):
    """Shares of what was simulated that are found as what they are, and of calibrations in order with an alarm. A first
    calibration is no event; what follows an event is left out, for it is judged by what the event left."""
    shape = made.seats.shape
    place = {(serial, iso(round(days * trend.DAY_S))): (b, k) for b, serial in enumerate(made.series.serials)
             for k, days in enumerate(made.series.days[b])}  # fmt: skip
    kinds, seat = np.full((*shape, len(PARAMETERS)), "", dtype="U8"), np.zeros(shape, dtype=bool)
    for one in told.alarms:
        b, k = place[one.serial, one.measured]
        kinds[b, k, PARAMETERS.index(one.parameter)] = one.kind
        seat[b, k] |= one.of_seat
    events = (made.jumps | made.outliers).any(axis=2) | made.seats
    calm = ~events
    calm[:, 0] = False
    calm[:, 1:] &= ~events[:, :-1]
    single = (made.jumps.sum(axis=2) + made.outliers.sum(axis=2)) == 1
    inner = single[:, 1:-1] & ~events[:, 2:] & ~events[:, :-2]
    jumps, outliers = made.jumps[:, 1:-1] & inner[..., None], made.outliers[:, 1:-1] & inner[..., None]
    alone = made.seats & ~(made.jumps | made.outliers).any(axis=2)
    ends = (made.jumps | made.outliers)[:, -1]
    return {
        "false alarms, of calibrations in order": (kinds[calm] != "").any(axis=1).mean(),
        "jumps missed": (kinds[:, 1:-1][jumps] == "").mean(),
        "jumps taken for something else": np.isin(kinds[:, 1:-1][jumps], ["outlier", "drift", "open"]).mean(),
        "outliers missed": (kinds[:, 1:-1][outliers] == "").mean(),
        "outliers taken for something else": np.isin(kinds[:, 1:-1][outliers], ["jump", "drift", "open"]).mean(),
        "last calibrations beyond, missed": (kinds[:, -1][ends] == "").mean(),
        "exchanged seats missed": (~(kinds[..., OF_BLOCK:] != "").any(axis=2))[alone].mean(),
        "exchanged seats told as such": seat[alone].mean(),
    }


def due_dates(made, told):
    """Against those by the true growth, and whether blocks are within the limit on their day."""
    found = {one.serial: one for one in told.blocks}
    days = np.array([found[serial].days for serial in made.series.serials])
    calm = np.array([found[serial].why == "growth" for serial in made.series.serials])
    best = forecast_of(made.series, TRUTH, trend.control_limit(CONFIDENCE))
    off = np.abs(days / best.days(LIMIT_G, COVERAGE) - 1.0)[calm]
    clean = calm & ~(made.jumps | made.outliers)[..., :OF_BLOCK].any(axis=(1, 2))
    within = off_when_due(made, best, days, LIMIT_G, COVERAGE, 1)[clean] <= LIMIT_G
    return {
        "due after, days, median": np.median(days[calm]),
        "due date off, median of its days": np.median(off),
        "due date off, 95th percentile": np.percentile(off, 95),
        "within the limit when due (k = 2)": within.mean(),
    }


def lines(columns, blocks=200):
    """What pandas takes for a straight line of every parameter, of some blocks, times all of them."""
    import pandas

    frame = pandas.DataFrame({name: columns[name] for name in ("serial", "created_s", *PARAMETERS)})
    some = frame[frame["serial"].isin(frame["serial"].unique()[:blocks])]
    began = time.perf_counter()
    some.groupby("serial")[["created_s", *PARAMETERS]].apply(
        lambda one: np.polyfit(one["created_s"] - one["created_s"].iloc[0], one[list(PARAMETERS)].to_numpy(), 1)
    )
    share = some["serial"].nunique() / frame["serial"].nunique()
    return {"straight lines by pandas, s": (time.perf_counter() - began) / share}


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
