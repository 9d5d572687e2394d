"""The table stops whatever an outsider has done, on a real bus: seen by who watches the drive's reports."""

import struct
import subprocess
import time

import can
import pytest
from processes import HASTE, Node, Stand, scenario, sdo_command

HOMING_DEG_S = 45.0
BOUND_DEG = 790.0  # the cable's span and one turn
WITHIN_S = 3.0  # of ABORT
TABLE = {
    **HASTE,
    "profile__homing_fast_deg_s": HOMING_DEG_S,
    "motion__acceleration_deg_s2": 180,
    "fault": "homing_endless time=0",
}
HOME_AXIS, ABORT = 12, 2


class Watcher:
    """The drive's reports: (seconds since the watch began, angle in degrees)."""

    def __init__(self, bus):
        filters = [{"can_id": 0x182, "can_mask": 0x7FF}, {"can_id": 0x581, "can_mask": 0x7FF}]
        self.bus = can.Bus(interface="socketcan", channel=str(bus), can_filters=filters)
        self.began, self.reports, self.answers = time.time(), [], []

    def look(self, seconds):
        """For so long."""
        end = time.time() + seconds
        while time.time() < end:
            if (message := self.bus.recv(timeout=0.2)) is None:
                continue
            if message.arbitration_id == 0x581:
                self.answers.append(bytes(message.data))
            else:
                counts = struct.unpack_from("<i", message.data, 2)[0]
                self.reports.append((message.timestamp - self.began, counts / 1000.0))

    def rested_s(self):
        """Since when the angle has not changed any more."""
        last = self.reports[-1][1]
        moving = [when for when, angle in self.reports if abs(angle - last) > 0.01]
        return moving[-1] if moving else 0.0

    def close(self):
        self.bus.shutdown()


@pytest.fixture
def homing(bus, started, tmp_path):
    """A table that homes and will find no mark, and who watches it."""
    path = scenario(tmp_path, **TABLE)
    stand = Stand(bus, path, "--operator", "none")
    node = Node(bus, path, folder=tmp_path)
    started.extend([stand, node])
    watcher = Watcher(bus)
    watcher.look(3.0)
    sdo_command(bus, HOME_AXIS)
    yield watcher, stand
    watcher.close()


@pytest.mark.parametrize("write", [None, "601#2300180102020080"], ids=["alone", "after 1800h:1 = 80000202h"])
def test_an_abort_stops_a_homing_that_would_not_end(homing, bus, write):
    watcher, stand = homing
    watcher.look(2.0)
    assert abs(watcher.reports[-1][1] - watcher.reports[0][1]) > 20.0  # it turns
    if write is not None:
        subprocess.run(["cansend", str(bus), write], check=True)
        watcher.look(0.5)
        assert watcher.answers[-1] == bytes.fromhex("8000180122000008")  # held
    told = time.time() - watcher.began
    sdo_command(bus, ABORT)
    watcher.look(WITHIN_S + 2.0)
    print(f"at rest {watcher.rested_s() - told:.3f} s after ABORT")
    assert watcher.rested_s() - told < WITHIN_S
    assert stand.end()["table"]["at_rest"]


def test_homing_ends_within_its_bound(homing):
    watcher, stand = homing
    watcher.look(BOUND_DEG / HOMING_DEG_S + 4.0)
    travelled = abs(watcher.reports[-1][1] - watcher.reports[0][1])
    brake_deg = HOMING_DEG_S**2 / (2.0 * 180.0)
    print(f"turned {travelled:.1f} deg, at rest {watcher.rested_s():.1f} s after the watch began")
    assert 700.0 < travelled < BOUND_DEG + brake_deg + HOMING_DEG_S * 1.0  # and a second of a machine that waits
    assert watcher.rested_s() < watcher.reports[-1][0] - 1.0
    assert stand.end()["table"]["at_rest"]
