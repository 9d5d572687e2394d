"""Others on the interface: python-canopen leads tumble-stand's drive, tumble-node leads a drive that is not ours."""

import struct
import threading
import time
from contextlib import contextmanager

import can
import canopen
import numpy as np
import pytest
import python_drive
from bench_moves import axis, lead, require_moved
from can.interfaces.socketcan import SocketcanBus
from processes import HASTE, PATIENCE, Node, Stand, scenario

ANSWERS_S = 0.25  # half of what the node gives a server: a drive in Python that is not let run cannot keep to it


class TurningBus(SocketcanBus):
    """An interface, and the way to the stand's table for a drive that runs elsewhere (host/stand/stand_bridge.h)."""

    def turn_table(self, angle_deg, speed_deg_s):
        """An extended frame with identifier 0."""
        units = struct.pack("<iI", round(angle_deg * 1e5), max(1, round(speed_deg_s * 1e5)))
        self.send(can.Message(arbitration_id=0, is_extended_id=True, data=units))


def test_python_canopen_homes_and_moves_the_axis(bus, network, started, tmp_path):
    stand = Stand(bus, scenario(tmp_path, motion__settling_s=0.1), "--operator", "none")
    started.append(stand)
    drive = axis(network)
    lead(drive)
    document = stand.end()
    require_moved(document["table"])
    assert abs(document["angle_deg"] - 12.345) < 0.05


@contextmanager
def foreign_stand(bus, started, tmp_path, **keys):
    """Another's drive, there before the node and without a heartbeat of its own: (the scenario, stand, drive)."""
    path = scenario(tmp_path, **{**HASTE, **PATIENCE, **python_drive.PROFILE, "procedure__settle_ms": 150, **keys})
    stand = Stand(bus, path, "--seed", 5)
    started.append(stand)
    turning, off = TurningBus(channel=str(bus)), threading.Event()
    drive = python_drive.PythonDrive(turning)

    def live():
        while not off.is_set():
            drive.step()

    thread = threading.Thread(target=live, daemon=True)
    thread.start()
    try:
        yield path, stand, drive
    finally:
        off.set()
        thread.join(5)
        turning.shutdown()


@pytest.mark.answers_within(ANSWERS_S)
def test_a_drive_that_is_not_ours(bus, started, tmp_path):
    with foreign_stand(bus, started, tmp_path) as (path, stand, drive):
        node = Node(bus, path, "--start", folder=tmp_path)
        started.append(node)
        code, document = node.wait(timeout=90)
    truth = stand.end()["truth"]
    assert (code, document["end"]) == (0, "done"), document["reason"]
    assert np.abs(np.array(document["K"]) - truth["K"]).max() < 3e-3
    drive.require_all_positions()


@pytest.mark.answers_within(ANSWERS_S)
def test_a_drive_that_refuses_to_send_a_heartbeat_does_not_run(bus, started, tmp_path):
    """A reason within the time that the preflight has; nothing has moved."""
    with foreign_stand(bus, started, tmp_path, procedure__preflight_timeout_ms=2000) as (path, stand, drive):
        drive.node.add_write_callback(refuse_heartbeat)
        node = Node(bus, path, "--start", folder=tmp_path)
        started.append(node)
        began = time.monotonic()
        code, document = node.wait(timeout=20)
    assert (code, document["reason"]) == (3, "TUMBLE_REASON_STAND_PROTOCOL")
    assert document["failed_in"] == "TUMBLE_STATE_PREFLIGHT"
    assert time.monotonic() - began < 5.0 and drive.events == []
    assert stand.end()["table"]["at_rest"]


def refuse_heartbeat(index, **_):
    """An object that cannot be written: 0604 0043h, general parameter incompatibility."""
    if index == 0x1017:
        raise canopen.SdoAbortedError(0x06040043)
