"""`tumble replay` of one run's log in every form that python-can writes: the same bits; and what is no log."""

import json
import os
import re
import subprocess
import sys

import pytest

can = pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("cantools", reason="cantools is not installed")

from can_logs import rewritten  # noqa: E402
from simulated_bench import bench_program as bench, scenario  # noqa: E402

pytestmark = pytest.mark.python
QUICK = {"motion__settling_s": 0.05, "motion__speed_deg_s": 720, "motion__acceleration_deg_s2": 7200,
         "procedure__settle_ms": 100, "procedure__samples": 10, "operator__mount_s": 0.1}
FORMATS = {".asc": "ASC", ".blf": "BLF", ".trc": "TRC", ".csv": "python-can CSV", ".mf4": "MF4"}
READABLE = "these can be read: candump -L, ASC, BLF, TRC, MF4, CSV of python-can\n"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Its folder, and what the run itself has found."""
    folder = tmp_path_factory.mktemp("run")
    done = bench(scenario(folder, **QUICK), "--seed", 11, "--out", folder / "run")
    assert done.returncode == 0, done.stderr
    return folder, json.loads(done.stdout)


def replayed(tumble, folder, log):
    done = tumble("replay", log, "--scenario", folder / "scenario.txt", "--json")
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_same_bits_from_every_format(suffix, run, tumble, tmp_path):
    if suffix == ".mf4":
        pytest.importorskip("asammdf", reason="asammdf is not installed")
    folder, found = run
    own = replayed(tumble, folder, folder / "run/bus.log")
    other = replayed(tumble, folder, rewritten(folder / "run/bus.log", tmp_path / f"bus{suffix}"))
    assert (own["format"], own["time_step_us"]) == ("candump", None)
    assert other["format"] == FORMATS[suffix] and other["time_step_us"] is not None
    assert (own["K"], own["U0"]) == (found["K"], found["U0"])
    for key in ("K", "U0", "bits", "pass", "state", "reason", "counters"):
        assert other[key] == own[key], key


@pytest.mark.toolchain
@pytest.mark.parametrize("suffix", [suffix for suffix in FORMATS if suffix != ".mf4"])
def test_as_can_logconvert_writes_it(suffix, run, tumble, tmp_path):
    """python-can's own program, there and back. It takes names of channels for none."""
    folder, found = run
    log, back = tmp_path / f"bus{suffix}", tmp_path / "back.log"
    for source, target in ((folder / "run/bus.log", log), (log, back)):
        command = [sys.executable, "-m", "can.logconvert", source, target]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
    for file in (log, back):
        again = replayed(tumble, folder, file)
        assert (again["K"], again["U0"]) == (found["K"], found["U0"]), file.name


def test_times_that_a_format_has_rounded_are_told(run, tumble, tmp_path):
    """A log to the millisecond: the bits stay, for they rest on the block's own clock and the order alone."""
    folder, found = run
    rounded = tmp_path / "bus.asc"
    with can.Logger(str(rounded)) as writer:
        for message in can.CanutilsLogReader(str(folder / "run/bus.log")):
            message.timestamp, message.channel = round(message.timestamp, 3), 0
            writer.on_message_received(message)
    again = replayed(tumble, folder, rounded)
    assert (again["K"], again["time_step_us"]) == (found["K"], 1000)
    shown = tumble("replay", rounded, "--scenario", folder / "scenario.txt").stdout
    assert "read as ASC, whose times are multiples of 1000 us here" in shown


def test_one_changed_bit_shows_in_another_format_as_well(run, tumble, tmp_path):
    """Canary: samples without their checksum are not averaged."""
    folder, _ = run
    changed = tmp_path / "bus.blf"
    with can.Logger(str(changed)) as writer:
        for number, message in enumerate(can.CanutilsLogReader(str(folder / "run/bus.log"))):
            if message.arbitration_id == 0x683 and number > 1000:
                message.data[0] ^= 1
            message.channel = 0
            writer.on_message_received(message)
    done = tumble("replay", changed, "--scenario", folder / "scenario.txt", "--json")
    assert done.returncode == 3 and "comes to no result" in done.stderr


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("bus.blf", b"(0000000000.000100", "called .blf, but is no log in BLF; " + READABLE),
        ("bus.asc", b"date of the ASC\n", "called .asc, but is no log in ASC; " + READABLE),
        ("bus.mf4", b"", "called .mf4, but is no log in MF4; " + READABLE),
        ("bus.db", b"SQLite format 3\0", "is no CAN log; " + READABLE),
        ("run.csv", b"mounting,position,ux,uy,uz\n1,1,0,0,0\n", "is no CAN log; " + READABLE),
        ("cut.blf", b"LOGG\x90\0\0\0", "cannot be read as a CAN log (BLF)"),
        ("bus.csv", b"timestamp,arbitration_id,extended,remote,error,dlc,data\n", "holds no frames\n"),
        ("ext.csv", b"timestamp,arbitration_id,extended,remote,error,dlc,data\n1.0,0x18FF50E5,1,0,0,1,AA==\n",
         "holds no frames\n"),
    ],
)  # fmt: skip
def test_what_is_no_log_is_named_with_what_can_be_read(name, data, said, refused, tmp_path):
    (tmp_path / name).write_bytes(data)
    line = refused("replay", tmp_path / name)
    assert line.startswith(f"tumble: {tmp_path / name}: ") and said in line


@pytest.mark.parametrize("kept", [0.001, 0.5, 0.99])
def test_a_log_in_mf4_that_was_cut_is_one_line(kept, run, tmp_path):
    """In a process of its own: asammdf has more to say when that ends."""
    pytest.importorskip("asammdf", reason="asammdf is not installed")
    cut = rewritten(run[0] / "run/bus.log", tmp_path / "bus.mf4")
    data = cut.read_bytes()
    cut.write_bytes(data[: max(100, int(kept * len(data)))])
    command = [sys.executable, "-m", "tumble", "replay", cut]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    said = f"tumble: {cut}: cannot be read as a CAN log (MF4) after 0 frames: "
    assert (done.returncode, done.stderr.count("\n")) == (2, 1) and done.stderr.startswith(said), done.stderr


def test_a_log_away_from_its_run_names_the_option(tumble, run, tmp_path):
    """Without its scenario it is replayed on the paper's stand, where it may come to no result."""
    folder, _ = run
    log = tmp_path / "bus.log"
    log.write_bytes((folder / "run/bus.log").read_bytes())
    done = tumble("replay", log)
    said = r"tumble: .*: the firmware comes to no result in this log \(TUMBLE_STATE_\w+, TUMBLE_REASON_\w+\)"
    hint = "; it took the paper's stand: --scenario names the run's own\n"
    assert done.returncode == 3 and re.fullmatch(said + hint, done.stderr), done.stderr
    (tmp_path / "empty.txt").touch()
    assert hint not in tumble("replay", log, "--scenario", tmp_path / "empty.txt").stderr


def test_without_python_can_a_line_says_what_to_install(run, tumble, tmp_path):
    folder, _ = run
    log = rewritten(folder / "run/bus.log", tmp_path / "bus.blf")
    (tmp_path / "can.py").write_text("raise ImportError('none')\n")
    path = f"{tmp_path}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    done = tumble("replay", log, PYTHONPATH=path)
    said = f"tumble: {log}: a CAN log needs python-can: .venv/bin/pip install python-can cantools\n"
    assert (done.returncode, done.stdout, done.stderr) == (77, "", said)
    own = folder / "run/bus.log", "--scenario", folder / "scenario.txt"
    assert tumble("replay", *own, PYTHONPATH=path).returncode == 0
