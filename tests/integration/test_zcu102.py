"""The board zcu102, bare metal, in its emulator: its CAN driver conforms, and it computes the same bits as this
machine. Calibrations by it take a minute each."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager

import pytest
from conftest import EXAMPLES
from simulated_bench import HASTY_STAND, wait_until

from tumble.errors import BenchFault
from tumble.world import console, emulator, replay, uml

pytestmark = pytest.mark.toolchain

# An emulator that is held up for a second has a queue of 64 frames.
FEW_FRAMES = """
[block]
scale_v_per_g = 1.0
misalignment_rad = 1e-3
sample_rate_hz = 25.0
"""


def need(image):
    if (lacking := emulator.missing(image)) is not None:
        pytest.skip(f"the emulated board is not there: {lacking}")


@pytest.mark.parametrize("layout", ["silicon", "emulated"])
def test_the_two_controllers_conform(layout):
    need(f"conformance-{layout}")
    wire = ["-object", "can-bus,id=wire", "-machine", "canbus0=wire,canbus1=wire"]
    command = emulator.command(f"conformance-{layout}", *wire)
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr
    verdicts = [line.split()[0] for line in ended.stdout.splitlines()[:-1]]
    assert verdicts.count("passed") == 20 and verdicts.count("skipped") == 3 and len(verdicts) == 23, ended.stdout
    assert ended.stdout.splitlines()[-1] == "conforms"


def test_the_suite_fails_without_a_wire():
    """Canary: the exit code comes through."""
    need("conformance-silicon")
    command = emulator.command("conformance-silicon")
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 1 and "does not conform" in ended.stdout


def bench(tumble, folder, *options):
    """Document of a run in the process; its folder is run."""
    ended = tumble("bench", "--out", "run", "--json", *options, cwd=folder)
    assert ended.returncode == 0, ended.stderr
    return json.loads(ended.stdout)


def prepare(folder):
    """What the board needs for a replay of the run there: recording, record; its gain record, if it had one."""
    scenario = str(folder / "run/inputs/scenario.txt")
    (folder / "recording").write_bytes(replay.recording(replay.read(str(folder / "run/bus.log")), scenario))
    (folder / "record").write_bytes(replay.commissioning(scenario))
    return replay.gains_beside(scenario)


@pytest.mark.parametrize(
    "options",
    [["--seed", 1], ["--seed", 2, "--samples", 80, "--estimator", "averaged", "--limit", "1e-3"],
     ["--seed", 3, "--estimator", "least_squares", "--limit", "1e-3"], ["--seed", 5, "--estimator", "optimal"],
     *(["--seed", 4, "--limit", "1e-3", "--stand", EXAMPLES / f"{stand}_stand.toml"]
       for stand in ("paper", "angle", "lab")),
     ["--schedule", EXAMPLES / "six_faces.toml", "--estimator", "least_squares", "--limit", "1e-3"]],
    ids=["as it is", "averaged", "least squares", "optimal", "paper's stand", "angle stand", "lab stand", "six faces"],
)
def test_the_board_computes_the_same_bits(options, tumble, tmp_path):
    need("replay")
    result = bench(tumble, tmp_path, *options)
    documents = []
    for firmware in ("host", "zcu102"):
        ended = tumble("replay", "run/bus.log", "--firmware", firmware, "--json", cwd=tmp_path)
        assert ended.returncode == 0, ended.stderr
        documents.append(json.loads(ended.stdout))
    host, board = documents
    assert board["firmware"] == "zcu102"
    assert host["bits"] == board["bits"] and len(set(board["bits"])) == 12
    assert (board["K"], board["U0"]) == (result["K"], result["U0"])
    for name in ("samples", "averaged", "lost", "retries", "commands_refused"):
        assert host["counters"][name] == board["counters"][name]


def test_another_log_gives_other_bits(tumble, tmp_path):
    """Canary: the board's numbers come from the log."""
    need("replay")
    first = bench(tumble, tmp_path, "--seed", 1)
    shutil.rmtree(tmp_path / "run")
    bench(tumble, tmp_path, "--seed", 2)
    board = json.loads(tumble("replay", "run/bus.log", "--firmware", "zcu102", "--json", cwd=tmp_path).stdout)
    assert board["K"] != first["K"]


def test_without_its_gains_the_board_does_not_run(tumble, tmp_path):
    need("replay")
    bench(tumble, tmp_path, "--estimator", "optimal")
    gains = prepare(tmp_path)
    told = emulator.replay(tmp_path / "recording", tmp_path / "record")
    assert "K" not in told and told["reason"] == ["TUMBLE_REASON_CONFIGURATION"], told
    told = emulator.replay(tmp_path / "recording", tmp_path / "record", gains)
    assert "K" in told and told["pass"] == ["1"]


def test_a_spoilt_recording_is_refused(tumble, tmp_path):
    need("replay")
    bench(tumble, tmp_path)
    prepare(tmp_path)
    data = bytearray((tmp_path / "recording").read_bytes())
    data[5000] ^= 4
    (tmp_path / "recording").write_bytes(data)
    loader = f"loader,file={tmp_path}/recording,addr=0x2000000,force-raw=on"
    ended = subprocess.run(emulator.command("replay", "-device", loader), capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout.strip()) == (2, "refused TUMBLE_E_CRC")


def test_a_spoilt_commissioning_record_is_refused(tumble, tmp_path):
    need("replay")
    bench(tumble, tmp_path)
    prepare(tmp_path)
    data = bytearray((tmp_path / "record").read_bytes())
    data[100] ^= 1
    (tmp_path / "record").write_bytes(data)
    with pytest.raises(BenchFault, match="refused TUMBLE_E_CRC"):
        emulator.replay(tmp_path / "recording", tmp_path / "record")


def test_what_is_missing_is_said(tumble, tmp_path):
    bench(tumble, tmp_path)
    nothing = {"TUMBLE_ZCU102": str(tmp_path), "PATH": str(tmp_path)}
    ended = tumble("replay", "run/bus.log", "--firmware", "zcu102", cwd=tmp_path, **nothing)
    assert (ended.returncode, ended.stdout) == (77, "") and "install qemu-system-arm" in ended.stderr
    ended = tumble("bench", "--firmware", "zcu102", cwd=tmp_path)
    assert ended.returncode == 2 and "on a real bus only" in ended.stderr


def test_the_console_needs_the_standard_library_alone():
    """Isolated, without site packages: so it runs where every import is slow."""
    code = f"import runpy; runpy.run_path({console.__file__!r})"
    subprocess.run([sys.executable, "-I", "-S", "-c", code], check=True)


def need_bus():
    need("navcomp-emulated")
    if (lacking := uml.missing()) is not None:
        pytest.skip(f"user-mode Linux is not there: {lacking}")
    if shutil.which("candump") is None:
        pytest.skip("no candump: install can-utils")


@pytest.mark.slow
@pytest.mark.real_time
def test_the_board_calibrates_the_simulated_stand(tumble, tmp_path):
    need_bus()
    (tmp_path / "stand.toml").write_text(HASTY_STAND + FEW_FRAMES)
    command = ["bench", "--bus", "uml", "--firmware", "zcu102", "--stand", "stand.toml", "--seed", 11, "--samples", 20]
    command += ["--out", "run", "--json"]
    ended = tumble(*command, cwd=tmp_path, timeout=300)
    assert ended.returncode == 0, ended.stderr
    result = json.loads(ended.stdout)
    assert (result["bus"], result["firmware"], result["verification"]["pass"]) == ("uml", "zcu102", True)
    counters = result["counters"]
    for name in ("board_lost", "board_busy", "board_down", "board_controller_bus_off", "stand_kernel_dropped",
                 "samples_lost"):
        assert counters[name] == 0, name
    assert counters["samples_averaged"] == 18 * 20
    for firmware in ("host", "zcu102"):
        again = json.loads(tumble("replay", "run/bus.log", "--firmware", firmware, "--json", cwd=tmp_path).stdout)
        assert (again["K"], again["U0"]) == (result["K"], result["U0"])


@pytest.mark.slow
@pytest.mark.real_time
def test_an_interrupt_stops_the_table(tmp_path):
    need_bus()
    with interrupted_run(tmp_path) as process:
        assert "mounting 1: position 1" in process.stderr.readline()
        time.sleep(2.0)


@pytest.mark.slow
@pytest.mark.real_time
def test_an_interrupt_before_the_board_has_booted(tmp_path):
    """There is no stand yet, whose document tells that it is at rest."""
    need_bus()
    with interrupted_run(tmp_path):
        wait_until(lambda: list(tmp_path.glob("tmp/tumble-*/job.json")))  # the last before the board is started
        time.sleep(1.0)
    assert not list(tmp_path.rglob("stand.json")) and not list(tmp_path.glob(".run*"))


@contextmanager
def interrupted_run(folder):
    """A calibration by the board, which is interrupted in the end, and must say what becomes of the table."""
    (folder / "stand.toml").write_text(HASTY_STAND + FEW_FRAMES)
    command = [sys.executable, "-m", "tumble", "bench", "--bus", "uml", "--firmware", "zcu102", "--out", "run"]
    command += ["--stand", "stand.toml", "--samples", "100"]
    (folder / "tmp").mkdir()
    environment = {**os.environ, "TMPDIR": str(folder / "tmp")}
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=folder, env=environment)
    try:
        yield process
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130, complaint
    assert "the table is at rest" in complaint
    assert not (folder / "run").exists()
