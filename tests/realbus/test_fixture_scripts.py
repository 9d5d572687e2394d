"""tools/fixture on a CAN interface: tumble-node and tumble-stand over CAN, and over Modbus through tumble-gateway."""

import re
import signal
import subprocess
import sys
import time

import pytest
from conftest import ROOT
from fixture_table import limits
from processes import HASTE, Node, Stand, scenario

from tumble.bench import programs
from tumble.errors import BenchFault

pytest.importorskip("canopen", reason="python-canopen is not installed")
STAND = {**HASTE, "motion__settling_s": 0.1, "procedure__samples": 50}
ASKED = {
    "table__rest_s": 0.1,
    "table__samples": 40,
    "table__homings": 4,
    "table__backlash_angles": 3,
    "settling__settling_s": 0.4,
    "homing__repeatability_deg": 0.05,
    "positions__set_angle_rad": 4e-4,
    "backlash__backlash_deg": 0.04,
    "link__latency_s": 1.0,
}
LIVE = ("link", "homing", "positions", "backlash", "settling", "closure", "noise")


def command(*arguments):
    return [sys.executable, "-B", str(ROOT / "tools/fixture/launch.py"), *map(str, arguments)]


def validate(*arguments):
    return subprocess.run(command(*arguments), capture_output=True, text=True, timeout=200)


@pytest.fixture
def fixture(bus, started, tmp_path):
    """A stand and a node that waits for commands: (node, stand)."""

    def start(*options, **keys):
        path = scenario(tmp_path, **{**STAND, **keys})
        stand = Stand(bus, path, "--seed", 11)
        node = Node(bus, path, *options, folder=tmp_path)
        started.extend([stand, node])
        return node, stand

    return start


def test_all_that_can_be_seen_live_over_can(bus, fixture, tmp_path):
    _node, stand = fixture()
    done = validate(f"can:{bus}", *LIVE, "--limits", limits(tmp_path, **ASKED))
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "not checked: level, remounting and support." in " ".join(done.stdout.split())
    table = stand.end()["table"]
    assert table["at_rest"] and table["highest_deg"] > 359.9


@pytest.mark.full
def test_backlash_is_found(bus, fixture, tmp_path):
    fixture(motion__backlash_deg=0.2)
    done = validate(f"can:{bus}", "positions", "backlash", "--limits", limits(tmp_path, **ASKED))
    said = " ".join(done.stdout.split())
    assert done.returncode == 1 and "does not support a calibration to 3e-4 g: backlash 0." in said, said


@pytest.mark.full
def test_level_and_remounting_from_the_run_that_the_node_keeps(bus, fixture, started, tmp_path):
    """A node with non-volatile memory has the means of its last run, and no file is needed."""
    import can
    import canopen

    _node, stand = fixture("--nv", tmp_path / "memory", procedure__gravity_limit_g=1e-2)
    network = canopen.Network(can.Bus(interface="socketcan", channel=str(bus)))
    network.connect()
    one = network.add_node(1, str(ROOT / "docs/eds/tumble_navcomp.eds"))
    try:
        one.sdo["Command"]["Command"].raw = 1
        end = time.monotonic() + 120
        while one.sdo["State"].raw not in (12, 13):
            assert time.monotonic() < end
            time.sleep(0.1)
        assert one.sdo["State"].raw == 12, one.sdo["Reason"].raw
    finally:
        network.disconnect()
    asked = limits(tmp_path, **ASKED)
    done = validate(f"can:{bus}", "level", "remounting", "support", "--limits", asked)
    print(done.stdout)
    assert done.returncode == 0, done.stdout + done.stderr
    truth = stand.end()["truth"]
    row = next(line for line in done.stdout.splitlines() if line.strip().startswith("axis tilt"))
    value, u = float(row.split()[2]), float(row.split()[4])
    assert abs(value - abs(truth["alpha1_rad"])) < 4.0 * u, (row, truth)


def test_over_modbus(bus, fixture, started, tmp_path):
    pytest.importorskip("pymodbus", reason="pymodbus is not installed")
    try:
        program = programs.find("tumble-gateway", "host/gateway")
    except BenchFault:
        pytest.skip("tumble-gateway is not built: pkg-config finds no libmodbus")
    fixture()
    gateway = subprocess.Popen(
        [program, "--can", str(bus), "--tcp", "127.0.0.1:0", "--poll", "100", "--allow-commands"],
        stderr=subprocess.PIPE, text=True,
    )
    started.append(gateway)
    port = re.search(r" at 127\.0\.0\.1:(\d+)", gateway.stderr.readline())[1]
    asked = limits(tmp_path, **{**ASKED, "settling__settling_s": 2.0})
    done = validate(f"modbus:127.0.0.1:{port}", "link", "positions", "settling", "--limits", asked)
    print(done.stdout)
    said = " ".join(done.stdout.split())
    assert done.returncode == 1, done.stdout + done.stderr
    assert re.search(r"read-back, worst [-.e0-9]+ deg .*? meets", said), said
    assert re.search(r"settling time, worst [-.e0-9]+ s .*? meets", said), said
    assert "as far as can be told: no set angle, std dev (only gravity shows it" in said
    gateway.terminate()
    assert gateway.wait(timeout=20) == 0


@pytest.mark.full
def test_a_node_that_falls_silent_and_one_that_is_not_there(bus, fixture, tmp_path):
    asked = limits(tmp_path, **ASKED)
    alone = validate(f"can:{bus}", "--limits", asked)
    assert (alone.returncode, alone.stdout) == (3, "") and alone.stderr.startswith("validate: node 1 does not answer")
    node, stand = fixture()
    running = subprocess.Popen(command(f"can:{bus}", "positions", "--limits", asked), stderr=subprocess.PIPE, text=True)
    time.sleep(8.0)
    node.signal(signal.SIGKILL)
    errors = running.communicate(timeout=60)[1]
    assert running.returncode == 3 and re.match("validate: (node 1 does not answer|the block sends no)", errors), errors
    assert stand.end()["table"]["at_rest"]


def test_no_such_interface(tmp_path):
    done = validate("can:can999", "--limits", limits(tmp_path))
    assert (done.returncode, done.stderr) == (2, "validate: can:can999: there is no CAN interface of this name\n")
