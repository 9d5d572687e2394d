"""tools/fixture on a CAN interface: tumble-node and tumble-stand over CAN, and over Modbus through tumble-gateway."""

import re
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import ROOT
from fixture_table import limits, read_limits
from processes import HASTE, Node, Stand, scenario
from simulated_bench import built
from validation import session
from validation.samples import MeanByNode

pytest.importorskip("canopen", reason="python-canopen is not installed")
STAND = {
    **HASTE,
    "motion__settling_s": 0.1,
    "procedure__samples": 50,
    "firmware__heartbeat_timeout_ms": 3000,  # a busy machine is not what is tested here
    "profile__heartbeat_timeout_ms": 3000,
    "profile__handshake_timeout_ms": 5000,
}
ASKED = {
    "table__rest_s": 0.1,
    "table__samples": 40,
    "table__homings": 4,
    "table__backlash_angles": 3,
    "settling__settling_s": 0.4,
    "homing__repeatability_deg": 0.05,
    "positions__set_angle_rad": 4e-4,
    "backlash__backlash_deg": 0.04,
    "noise__noise_v": 6e-4,
    "link__latency_s": 1.0,
}
SLIPS = {"fault": [f"slip time={at} value=1" for at in range(4, 36, 2)]}  # whatever the machine takes for a motion
OVER_MODBUS = {"settling__settling_s": 1.0}
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
def test_by_the_run_that_the_node_keeps_all_is_told_over_can_and_over_modbus(bus, fixture, started, tmp_path):
    """A node with non-volatile memory has the means of its last run, and no file is needed. Both links say the same of
    one stand, and find the tilt that it has."""
    _node, stand = fixture("--nv", tmp_path / "memory", procedure__gravity_limit_g=1e-2)
    calibrate(bus)
    over_can = supported(f"can:{bus}", tmp_path)
    over_modbus = supported(served(bus, started), tmp_path)
    assert list(over_can) == list(over_modbus) and len(over_can) > 10
    for name in ("axis tilt", "level + yaw", "yaw change", "gravity error"):  # of the same means
        assert over_modbus[name] == pytest.approx(over_can[name], rel=2e-2), name
    truth = abs(stand.end()["truth"]["alpha1_rad"])
    for value, u in (over_can["axis tilt"], over_modbus["axis tilt"]):
        assert abs(value - truth) < 4.0 * u, (value, u, truth)


def supported(link, folder):
    """Figures of all checks, which are met."""
    done = validate(link, "--limits", limits(folder, **{**ASKED, **OVER_MODBUS}))
    print(done.stdout)
    assert done.returncode == 0 and done.stderr == "", done.stdout + done.stderr
    assert "This fixture does support a calibration to 3e-4 g: " in done.stdout
    return figures(done.stdout)


def calibrate(bus):
    """A whole run, to DONE."""
    import can
    import canopen

    network = canopen.Network(can.Bus(interface="socketcan", channel=str(bus)))
    network.connect()
    one = network.add_node(1, str(ROOT / "docs/eds/tumble_navcomp.eds"))
    one.sdo.RESPONSE_TIMEOUT = 20.0
    try:
        one.sdo["Command"]["Command"].raw = 1
        end = time.monotonic() + 120
        while one.sdo["State"].raw not in (12, 13):
            assert time.monotonic() < end
            time.sleep(0.1)
        assert one.sdo["State"].raw == 12, one.sdo["Reason"].raw
    finally:
        network.disconnect()


def figures(text):
    """{name: (value, standard uncertainty)} of the summary's rows; "-" is None."""
    rows = [(line[2:26].strip(), line[26:].split()) for line in text.splitlines() if re.match(r"  \S", line)]
    return {name: tuple(None if cell == "-" else float(cell) for cell in (cells[0], cells[2]))
            for name, cells in rows if cells[-1] == "meets" and cells[1] in ("deg", "rad", "s", "g", "V")}


def served(bus, started):
    """The LINK of a tumble-gateway."""
    pytest.importorskip("pymodbus", reason="pymodbus is not installed")
    program = built("tumble-gateway")
    gateway = subprocess.Popen(
        [program, "--can", str(bus), "--tcp", "127.0.0.1:0", "--poll", "200", "--allow-commands"],
        stderr=subprocess.PIPE, text=True,
    )
    started.append(gateway)
    port = re.search(r" at 127\.0\.0\.1:(\d+)", gateway.stderr.readline())[1]
    return f"modbus:127.0.0.1:{port}"


def test_all_that_can_be_seen_live_over_modbus(bus, fixture, started, tmp_path):
    """The node takes the means itself: it has memory. Backlash and settling, which take long, --full asks for."""
    _node, stand = fixture("--nv", tmp_path / "memory")
    chosen = [name for name in LIVE if name not in ("backlash", "settling")]
    done = validate(served(bus, started), *chosen, "--limits", limits(tmp_path, **{**ASKED, **OVER_MODBUS}))
    print(done.stdout)
    assert done.returncode == 0 and done.stderr == "", done.stdout + done.stderr
    assert "not checked: backlash, settling, level, remounting and support." in " ".join(done.stdout.split())
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert stand.end()["table"]["at_rest"]
    assert started[-1].poll() is None
    started[-1].terminate()
    assert started[-1].wait(timeout=20) == 0


@pytest.mark.full
@pytest.mark.parametrize(
    ("check", "keys", "said"),
    [
        ("backlash", {"motion__backlash_deg": 0.2}, "backlash"),
        ("noise", {"block__noise_v": "2e-3 2e-3 2e-3"}, "noise of a sample"),
        ("homing", SLIPS, "homing repeatability"),
    ],
)
def test_each_fault_is_found_over_modbus(bus, fixture, started, tmp_path, check, keys, said):
    fixture("--nv", tmp_path / "memory", **keys)
    done = validate(served(bus, started), check, "--limits", limits(tmp_path, **{**ASKED, **OVER_MODBUS}))
    flat = " ".join(done.stdout.split())
    assert done.returncode == 1 and re.search(rf"does not support .*: {said} [-.e0-9]+ \w+ exceeds", flat), done.stdout


def test_the_node_measures_at_rest_what_is_heard_on_the_bus(bus, fixture, tmp_path):
    """2152h and the block's own frames, one after the other on one table: within five standard uncertainties."""
    fixture("--nv", tmp_path / "memory")
    asked = read_limits(str(limits(tmp_path, **ASKED)))
    with session.opened(f"can:{bus}", asked, [], None) as context:
        context.instrument.approach(30.0)
        heard, taken = context.instrument.mean(), MeanByNode(context.link, 1e-6).mean(40)
    assert np.all(np.abs(taken.value - heard.value) < 5.0 * np.hypot(taken.u, heard.u)), (taken, heard)
    assert np.all(np.abs(np.log(taken.scatter / heard.scatter)) < 0.8), (taken, heard)  # five times 1 / sqrt(39)
    assert taken.samples == heard.samples == 40


@pytest.mark.full
def test_over_modbus_without_memory_gravity_cannot_tell(bus, fixture, started, tmp_path):
    fixture()
    done = validate(served(bus, started), "link", "positions", "--limits", limits(tmp_path, **{**ASKED, **OVER_MODBUS}))
    said = " ".join(done.stdout.split())
    assert done.returncode == 1 and re.search(r"read-back, worst [-.e0-9]+ deg .*? meets", said), said
    assert "as far as can be told: no set angle, std dev (only gravity shows it, and node 1 takes no means" in said


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
