"""tumble-node leads a motor controller over Modbus TCP that turns the table of a simulated stand: docs/porting.md."""

import re

import numpy as np
import pytest
from processes import HASTE, PATIENCE, Node, Stand, scenario, wait_until
from test_interop import TurningBus

pytest.importorskip("pymodbus.server", reason="pymodbus is not installed")
from modbus_positioner import ModbusPositioner

PATIENT = {"silence_ms": 3000, "watch_ms": 3000}  # where a busy machine that lets a process wait is not what is tested
KEYS = {**HASTE, **PATIENCE, "present__drive": "no", "procedure__settle_ms": 150}
SLOW_DEG_S = 60.0
PATIENT_MARGIN_MS = 8000  # half of it without progress: silence, which is told first, must be shorter
WATCHED = {"silence_ms": 1500, "watch_ms": 1500, "stop_timeout_ms": 500}
CRAWLING_DEG_S = 15.0  # so that a move lasts longer than the watchdog


@pytest.fixture
def run(bus, started, tmp_path):
    """Begin a calibration: (node, stand, controller)."""
    controllers = []

    def begin(speed_deg_s=720.0, numbers=PATIENT, before=lambda _: None, host="127.0.0.1", **keys):
        path = scenario(tmp_path, **{**KEYS, **keys})
        stand = Stand(bus, path, "--seed", 5)
        controller = ModbusPositioner(TurningBus(channel=str(bus)).turn_table, speed_deg_s)
        controllers.append(controller)
        before(controller)
        where = f"modbus:{host}:{controller.port}" + "".join(f",{name}={value}" for name, value in numbers.items())
        node = Node(bus, path, "--start", "--stand", where, folder=tmp_path)
        started.extend([stand, node])
        return node, stand, controller

    yield begin
    for controller in controllers:
        controller.close()


def failed(node, reason, state="MOVE"):
    """It has ended so."""
    code, document = node.wait(timeout=60)
    assert (code, document["end"], document["reason"]) == (3, "fault", f"TUMBLE_REASON_{reason}"), node.errors
    assert document["failed_in"] == f"TUMBLE_STATE_{state}"
    return document


def test_a_calibration_finds_the_truth_within_its_uncertainty(run):
    node, stand, controller = run()
    code, document = node.wait(timeout=90)
    truth = stand.end()["truth"]
    assert (code, document["end"]) == (0, "done"), (document["reason"], controller.events)
    errors = np.append(np.array(document["K"]) - truth["K"], np.array(document["U0"]) - truth["U0"])
    u = np.append(document["u_K"], document["u_U0"])
    print("errors over uncertainties:", np.round(errors / u, 2))
    assert np.all(u > 0.0) and np.abs(errors / u).max() < 4.0
    angles = [event for event in controller.events if isinstance(event, float)]
    assert controller.events[0] == "home" and {45.0 * number for number in range(9)} <= set(angles)
    assert "watchdog" not in controller.events[:-1], controller.events  # it was fed until the end


def test_a_controller_that_falls_silent_in_a_move_stops_by_itself(run):
    """The computer tells; nobody else can stop the table but the controller's own watchdog."""
    node, stand, controller = run(CRAWLING_DEG_S, WATCHED, procedure__motion_margin_ms=PATIENT_MARGIN_MS)
    node.wait_for("MOVE", 2)
    wait_until(lambda: controller.goal_deg == 90.0)
    controller.silent = True
    failed(node, "STAND_HEARTBEAT")
    ended = stand.end()
    assert controller.events[-2:] == ["watchdog", "stop"], controller.events
    assert ended["table"]["at_rest"] and ended["angle_deg"] < 85.0


def test_a_computer_that_is_killed_in_a_move_leaves_a_table_that_stops(run):
    node, stand, controller = run(CRAWLING_DEG_S, WATCHED)
    node.wait_for("MOVE", 2)
    wait_until(lambda: controller.goal_deg == 90.0)
    node.kill()
    wait_until(lambda: controller.events[-2:] == ["watchdog", "stop"])
    ended = stand.end()
    assert ended["table"]["at_rest"] and ended["angle_deg"] < 85.0


def test_a_fault_of_the_controller_in_a_move(run):
    node, stand, controller = run(SLOW_DEG_S, host="[127.0.0.1]")
    node.wait_for("MOVE", 2)
    wait_until(lambda: controller.goal_deg == 90.0)
    controller.fail(0x77)
    document = failed(node, "DRIVE_FAULT")
    assert document["cause"]["drive_code"] == 0x77
    assert stand.end()["table"]["at_rest"]


def test_a_register_that_no_such_controller_has(run):
    node, stand, controller = run(SLOW_DEG_S)
    node.wait_for("MOVE", 2)
    wait_until(lambda: controller.goal_deg == 90.0)
    controller.spoilt = {17: 0x8000}
    failed(node, "STAND_PROTOCOL")
    wait_until(lambda: "stop" in controller.events)  # it was told to, whatever it says
    assert stand.end()["angle_deg"] < 85.0


def test_another_device_at_that_address_is_not_written_to(run):
    node, _, controller = run(before=lambda one: one.spoilt.update({16: 0}), procedure__preflight_timeout_ms=2000)
    failed(node, "STAND_PROTOCOL", "PREFLIGHT")
    assert (controller.events, controller.number, controller.watch_until) == ([], 0, 0.0)


FORM = "must be modbus:HOST:PORT[,NAME=NUMBER...], with PORT from 1 to 65535; see --help"


@pytest.mark.parametrize("text, what", [
    ("modbus:", FORM),
    ("tcp:127.0.0.1:502", FORM),
    ("modbus:127.0.0.1:70000", FORM),
    ("modbus:127.0.0.1:502,speed=1", "no such number of a stand; see --help"),
    ("modbus:127.0.0.1:502,unit=248", "a number is out of its range, or no number; see --help"),
    ("modbus:127.0.0.1:502,cycle_ms=1.5", "a number is out of its range, or no number; see --help"),
    ("modbus:127.0.0.1:502,cycle_ms=300", "needs counts_per_deg other than 0, and silence_ms and watch_ms of two "
                                          "cycle_ms or more"),
])
def test_what_the_option_refuses(bus, tmp_path, text, what):
    node = Node(bus, "--stand", text, folder=tmp_path)
    assert node.wait(timeout=20) == (2, None)
    assert re.sub(r"^\S+: ", "", node.errors) == f"--stand: {what}\n"
