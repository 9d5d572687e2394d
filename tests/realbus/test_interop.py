"""Others on the interface: python-canopen leads tumble-stand's drive, tumble-node leads a drive that is not ours."""

import struct

import can
import canopen
import numpy as np
import pytest
from bench_moves import COUNTS_PER_DEG, configure, move
from can.interfaces.socketcan import SocketcanBus
from conftest import ROOT
from processes import HASTE, Node, Stand, scenario, wait_until


class TurningBus(SocketcanBus):
    """An interface, and the way to the stand's table for a drive that runs elsewhere (boards/linux/stand_bridge.h)."""

    def turn_table(self, angle_deg, speed_deg_s):
        """An extended frame with identifier 0."""
        units = struct.pack("<iI", round(angle_deg * 1e5), max(1, round(speed_deg_s * 1e5)))
        self.send(can.Message(arbitration_id=0, is_extended_id=True, data=units))


@pytest.fixture
def network(bus):
    """python-canopen on the interface."""
    made = canopen.Network()
    made.NOTIFIER_CYCLE = 0.01
    made.connect(interface="socketcan", channel=str(bus))
    yield made
    made.disconnect()


def test_python_canopen_homes_and_moves_the_axis(bus, network, started, tmp_path):
    stand = Stand(bus, scenario(tmp_path, motion__settling_s=0.1), "--operator", "none")
    started.append(stand)
    drive = network.add_node(canopen.BaseNode402(2, str(ROOT / "docs/eds/tumble_drive.eds")))
    drive.sdo.RESPONSE_TIMEOUT = 5.0
    heartbeat = network.send_periodic(0x701, [5], 0.1)
    configure(drive)
    drive.nmt.state = "OPERATIONAL"
    drive.setup_402_state_machine(read_pdos=False)
    drive.state = "OPERATION ENABLED"
    assert drive.homing(timeout=20)
    drive.op_mode = "PROFILED POSITION"
    for target_deg in (90.0, -45.0, 12.345):
        move(drive, round(target_deg * COUNTS_PER_DEG))
    heartbeat.stop()
    wait_until(lambda: drive.sdo[0x6041].raw & 0x4F == 0x08)  # a fault: nobody is its master any more
    document = stand.end()
    assert document["table"]["at_rest"] and abs(document["angle_deg"] - 12.345) < 0.05
    assert document["table"]["highest_deg"] > 89.99 and document["table"]["lowest_deg"] < -44.99


def test_a_drive_that_is_not_ours(bus, started, tmp_path):
    import python_drive as d

    keys = {
        **HASTE,
        "present__drive": "no",
        "profile__counts_per_turn": d.COUNTS_PER_TURN,
        "profile__sign": d.SIGN,
        "profile__velocity_per_deg_s": d.UNITS_PER_DEG_S,
        "profile__acceleration_per_deg_s2": d.UNITS_PER_DEG_S,
        "profile__receive_pdo": "2 0x302 607A:0:32 6040:0:16 6060:0:8",
        "profile__transmit_pdo": "1 0x282 0 50 6061:0:8 6064:0:32 6041:0:16",
        "profile__write": "0x2100 0 1 1",
        "procedure__settle_ms": 150,
    }
    path = scenario(tmp_path, **keys)
    stand = Stand(bus, path, "--seed", 5)
    node = Node(bus, path, "--start", folder=tmp_path)
    started.extend([stand, node])
    node.wait_for("PREFLIGHT")
    drive = d.PythonDrive(TurningBus(channel=str(bus)))  # it is silent but for its boot-up, which the node must hear
    try:
        code, document = node.wait(timeout=90)
    finally:
        drive.close()
    truth = stand.end()["truth"]
    assert (code, document["end"]) == (0, "done"), document["reason"]
    assert np.abs(np.array(document["K"]) - truth["K"]).max() < 3e-3
    angles = [event for event in drive.events[1:] if isinstance(event, float)]
    assert drive.events[0] == "home" and {45.0 * number for number in range(9)} <= set(angles)
