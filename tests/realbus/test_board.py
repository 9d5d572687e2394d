"""The emulated board zcu102 on an interface of this machine: `--bus socketcan:IF --firmware zcu102`."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from simulated_bench import HASTY_STAND
from test_command import assert_quiet

from tumble.world import emulator

_LACKING = emulator.missing("navcomp-emulated")
pytestmark = pytest.mark.skipif(_LACKING is not None, reason=f"the emulated board is not there: {_LACKING}")


@pytest.fixture
def command(bus, tmp_path):
    """Of a quick run."""
    (tmp_path / "stand.toml").write_text(HASTY_STAND)
    arguments = ["bench", "--bus", f"socketcan:{bus}", "--firmware", "zcu102", "--stand", tmp_path / "stand.toml"]
    return [sys.executable, "-m", "tumble", *map(str, arguments), "--out", str(tmp_path / "run"), "--json"]


def test_the_board_calibrates_with_gains_of_its_own(command, bus, tmp_path):
    ended = subprocess.run([*command, "--estimator", "optimal"], capture_output=True, text=True, timeout=120,
                           env=dict(os.environ), check=False)
    assert ended.returncode == 0, ended.stderr
    result = json.loads(ended.stdout)
    assert (result["bus"], result["firmware"], result["estimator"]) == (f"socketcan:{bus}", "zcu102", "optimal")
    assert result["counters"]["samples_lost"] == 0  # else the bits, too, would be others than the replay's
    assert_quiet(bus)


def test_ctrl_c_stops_the_table_of_the_board(command, bus, tmp_path):
    child = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=dict(os.environ))
    assert "mounting 1: position 1" in child.stderr.readline()
    child.send_signal(signal.SIGINT)
    began = time.monotonic()
    errors = child.communicate(timeout=60)[1]
    assert (child.returncode, errors) == (130, "tumble: interrupted; the table is at rest\n")
    assert time.monotonic() - began < 20.0
    assert not (tmp_path / "run").exists()
    assert_quiet(bus)
