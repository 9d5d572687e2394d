"""`tumble bench --bus socketcan:IF`: the same result as on the simulated bus, and the exit codes of what goes wrong."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from documents import valid
from processes import wait_until
from simulated_bench import HASTY_STAND

from tumble.world import programs


@pytest.fixture
def options(bus, tmp_path):
    """Arguments of a quick run."""
    (tmp_path / "stand.toml").write_text(HASTY_STAND)
    return ["bench", "--bus", f"socketcan:{bus}", "--stand", tmp_path / "stand.toml", "--out", tmp_path / "run"]


def wrapper(tmp_path, name, line):
    """A program in the place of tumble-node or tumble-stand; $REAL is the real one."""
    path = tmp_path / name
    path.write_text(f"#!/bin/sh\nREAL={programs.find(name)}\n{line}\n")
    path.chmod(0o755)
    return {name.upper().replace("-", "_"): str(path)}


def test_a_run_folder_and_a_result(options, bus, tumble, tmp_path):
    done = tumble(*options, "--json", "--seed", 3)
    assert done.returncode == 0, done.stderr
    result = valid(done.stdout)
    assert (result["seed"], result["bus"], result["firmware"]) == (3, f"socketcan:{bus}", "host")
    assert result["counters"]["kernel_dropped"] == result["counters"]["stand_kernel_dropped"] == 0
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == ["bus.log", "inputs", "result.json", "run.csv"]
    assert "mounting 2: position 10 of 18" in done.stderr
    other = tumble("bench", "--stand", tmp_path / "stand.toml", "--seed", 3, "--json", "--out", tmp_path / "inprocess")
    truth = json.loads(other.stdout)["truth"]
    assert all(truth[name] == result["truth"][name] for name in ("K", "U0", "alpha1_rad", "alpha2_rad"))


def test_the_optimal_estimator_has_its_gains_on_the_node(options, tumble, tmp_path):
    done = tumble(*options, "--json", "--estimator", "optimal")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)
    stand = ["--stand", tmp_path / "stand.toml"]
    other = tumble("bench", *stand, "--estimator", "optimal", "--json", "--out", tmp_path / "in")
    inprocess = json.loads(other.stdout)
    assert result["estimator"] == "optimal"
    for name in ("u_K", "u_U0"):  # of the same gains, at a K that differs by its noise
        assert result[name] == pytest.approx(np.array(inprocess[name]), rel=1e-4), name
    assert (tmp_path / "run/inputs/gains.bin").read_bytes() == (tmp_path / "in/inputs/gains.bin").read_bytes()
    again = json.loads(tumble("replay", tmp_path / "run/bus.log", "--json").stdout)
    assert (again["K"], again["U0"]) == (result["K"], result["U0"])


def test_ctrl_c_stops_the_table_and_leaves_nothing(options, bus, tmp_path):
    child = subprocess.Popen([sys.executable, "-m", "tumble", *map(str, options)], stderr=subprocess.PIPE, text=True,
                             start_new_session=True)
    before = bus.frames()
    wait_until(lambda: bus.frames() > before + 300, timeout=30)
    child.send_signal(signal.SIGINT)
    began = time.monotonic()
    errors = child.communicate(timeout=20)[1]
    assert (child.returncode, errors.splitlines()[-1]) == (130, "tumble: interrupted; the table is at rest")
    assert time.monotonic() - began < 6.0
    assert not (tmp_path / "run").exists()
    assert_quiet(bus)


def assert_quiet(bus):
    """Nobody is left who sends."""
    time.sleep(0.3)
    before = bus.frames()
    time.sleep(0.5)
    assert bus.frames() == before


def test_whoever_kills_the_command_leaves_no_process_behind(options, bus):
    child = subprocess.Popen([sys.executable, "-m", "tumble", *map(str, options)], stderr=subprocess.DEVNULL)
    before = bus.frames()
    wait_until(lambda: bus.frames() > before + 300, timeout=30)
    child.kill()
    child.wait()
    time.sleep(2.0)
    assert_quiet(bus)


@pytest.mark.parametrize("name, line, message", [
    ("tumble-node", '"$REAL" "$@" & sleep 3; kill -9 $!; kill -9 $$', "(killed by SIGKILL)"),
    ("tumble-node", "exit 5", "tumble-node ended without a result (exit code 5); the table is at rest"),
    ("tumble-stand", "echo broken >&2; exit 5", "tumble-stand failed (5): broken"),
    ("tumble-stand", '"$REAL" "$@" & sleep 3; kill -9 $!; exit 1', "tumble-stand ended without a document"),
])
def test_a_program_that_dies(options, bus, tmp_path, name, line, message):
    done = subprocess.run([sys.executable, "-m", "tumble", *map(str, options)], capture_output=True, text=True,
                          timeout=60, env={**os.environ, **wrapper(tmp_path, name, line)})
    assert done.returncode == 3 and message in done.stderr.splitlines()[-1], done.stderr
    assert done.stdout == ""


def test_an_interface_that_goes_down_meanwhile(options, bus, tmp_path):
    child = subprocess.Popen([sys.executable, "-m", "tumble", *map(str, options)], stderr=subprocess.PIPE, text=True)
    before = bus.frames()
    wait_until(lambda: bus.frames() > before + 500, timeout=30)
    bus.down()
    errors = child.communicate(timeout=20)[1]
    assert child.returncode == 3 and "the CAN controller is off the bus (BUS" in errors.splitlines()[-1], errors
    assert (tmp_path / "run/fault.json").exists()


@pytest.mark.parametrize("interface, code, message", [
    ("vcan998", 2, "there is no interface vcan998; a virtual one: ip link add dev vcan998 type vcan"),
    ("can7", 2, "there is no interface can7"),
    ("lo", 2, "there is no CAN interface of this name"),
    ("a b", 2, "is not inprocess, uml, or socketcan: and the name of an interface"),
])
def test_names(tumble, tmp_path, interface, code, message):
    done = tumble("bench", "--bus", f"socketcan:{interface}", "--out", tmp_path / "run")
    assert (done.returncode, done.stdout) == (code, "") and message in done.stderr, done.stderr
    assert len(done.stderr.splitlines()) == 1 and not (tmp_path / "run").exists()


def test_an_interface_that_is_down(bus, tumble, tmp_path):
    bus.down()
    done = tumble("bench", "--bus", f"socketcan:{bus}", "--out", tmp_path / "run")
    assert done.returncode == 3
    assert done.stderr == f"tumble: --bus: the interface {bus} is down: ip link set up {bus}\n"
