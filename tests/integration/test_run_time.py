"""run.csv's `time_s`: the block's timestamp with its wraps counted, however long the pauses; readers pass it over."""

import csv
import itertools
import json
import re
import struct

import numpy as np
import pytest
from simulated_bench import QUICK, bench

import tumble as package

pytestmark = pytest.mark.python
FRAME = re.compile(r"\((\d+\.\d+)\) \S+ (683|693)#([0-9A-F]{16})")
PERIOD_MS = 4096


@pytest.fixture(scope="module", params=[0.1, 61.3, 590.0], ids=lambda pause: f"{pause} s to mount")
def folder(request, tmp_path_factory):
    """Of a run with a pause between the mountings, shorter and longer than timestamp and counter go round."""
    made = tmp_path_factory.mktemp("made") / "run"
    assert bench(QUICK | {"operator.mount_s": request.param}, seed=4, out=made)["exit"] == 0
    return made


def rows_of(folder):
    with open(folder / "run.csv", encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def on_the_bus(folder):
    """{(counter, timestamp): ms of the block's clock, counted on from frame to frame}, of all samples of the log."""
    found, clock_ms = {}, None
    for _, identifier, data in FRAME.findall((folder / "bus.log").read_text()):
        if identifier == "683":
            counter = int(data[12:14], 16)
            continue
        timestamp = struct.unpack("<4xH2x", bytes.fromhex(data))[0] & 0xFFF
        clock_ms = timestamp if clock_ms is None else clock_ms + (timestamp - clock_ms) % PERIOD_MS
        found.setdefault((counter, timestamp), []).append(clock_ms)
    return found


def test_it_is_the_clock_of_the_block_counted_from_frame_to_frame(folder):
    clock, rows = on_the_bus(folder), rows_of(folder)
    first_ms = None
    for row in sorted(rows, key=lambda row: float(row["time_s"])):
        time_ms = round(1000 * float(row["time_s"]))
        candidates = clock[int(row["counter"]) % 256, int(row["timestamp"])]
        first_ms = candidates[0] - time_ms if first_ms is None else first_ms
        assert time_ms % PERIOD_MS == int(row["timestamp"]) and time_ms + first_ms in candidates, row
    assert first_ms % PERIOD_MS == 0 and len(rows) == 180


def test_it_goes_on_within_and_between_positions(folder):
    times = {}
    for row in rows_of(folder):
        times.setdefault((row["mounting"], row["position"]), []).append(float(row["time_s"]))
    for seconds in times.values():
        assert np.allclose(np.diff(seconds), 0.01)
    ends = [(seconds[0], seconds[-1]) for seconds in times.values()]
    assert all(after[0] > before[1] for before, after in itertools.pairwise(ends))


def test_readers_pass_it_over(folder, tmp_path):
    """The same bits with the column and without, whoever reads; a model with a drift goes by the order of the rows."""
    lines = (folder / "run.csv").read_text().splitlines()
    assert lines[0].endswith(",temperature,time_s")
    (tmp_path / "run.csv").write_text("".join(line.rpartition(",")[0] + "\n" for line in lines))
    both = [str(one) for one in (folder / "run.csv", tmp_path / "run.csv")]
    for options in ({}, {"estimator": "least_squares", "model": "drift"}):
        one, other = (package.solve(path, **options) for path in both)
        assert one.K.tobytes() == other.K.tobytes() and one.U0.tobytes() == other.U0.tobytes()
    one, other = map(package.read, both)
    for name in ("mounting", "position", "outputs"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert one.temperature_c is None or np.array_equal(one.temperature_c, other.temperature_c)


def test_import_takes_it_for_the_time_and_not_the_timestamp_that_goes_round(folder, tumble):
    own, told, other = (tumble("import", folder / "run.csv", "--json", *columns)
                        for columns in ((), ("--columns", "time=time_s"), ("--columns", "time=timestamp")))
    assert own.returncode == 0, own.stderr
    assert json.loads(own.stdout)["rests"] == json.loads(told.stdout)["rests"]
    assert other.returncode == 2 or json.loads(other.stdout)["rests"] != json.loads(own.stdout)["rests"]
