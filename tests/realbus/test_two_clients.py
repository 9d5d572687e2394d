"""A script over CAN beside the gateway and a client of it, in runs: script and gateway have an SDO server of the node
each to themselves, and no read is lost.

A virtual interface has no bit rate, so the gateway makes as many frames as the machine can. The script lets the kernel
filter them: python-can takes every frame by itself, falls behind, and loses what its socket has no room for.
"""

import threading
import time

import canopen
import pytest
from conftest import ROOT
from processes import HASTE, PATIENCE, Node, Stand, scenario, wait_until
from test_gateway import Served

from tumble import client

PACE_S = 0.05
PATIENCE_S = 150.0  # for the first run; each read has its own limit
ANSWER_S = 10.0  # a machine that lets a process wait is not what is tested
NAME = "Tumble navigation computer"
NO_DATA = 0x08000024
FASTEST = "50"
ITS_ANSWERS = [{"can_id": 0x581, "can_mask": 0x7FF}]


@pytest.fixture
def script(bus):
    """Node 1 as python-canopen has it."""
    network = canopen.Network()
    network.NOTIFIER_CYCLE = 0.01
    network.connect(interface="socketcan", channel=str(bus), can_filters=ITS_ANSWERS)
    node = network.add_node(1, str(ROOT / "docs/eds/tumble_navcomp.eds"))
    node.sdo.RESPONSE_TIMEOUT, node.sdo.MAX_RETRIES = ANSWER_S, 0
    yield node
    network.disconnect()


def read(node, number):
    """One object after the other; a mean, and a result, may not be there yet."""
    wanted = [(0x2000, 0), (0x2003, 7), (0x2010, 1), (0x1008, 0), (0x2020, 5), (0x2007, 0)][number % 6]
    try:
        entry = node.sdo[wanted[0]] if wanted[1] == 0 else node.sdo[wanted[0]][wanted[1]]
        value = entry.raw
    except canopen.SdoAbortedError as error:
        assert error.code == NO_DATA and wanted[0] in (0x2010, 0x2020), error
        return
    assert wanted[0] != 0x1008 or value == NAME


def counted(served):
    """What the gateway has counted of its polls; it has closed the connection that said nothing."""
    served.client.close()
    served.client.connect()
    served.renew()
    return {name: served.number(name) for name in ("Polls", "Polls torn", "Polls failed")}


class Second(threading.Thread):
    """A client of the gateway, which reads without a pause, and begins another run whenever one is done."""

    def __init__(self, port):
        super().__init__(daemon=True)
        self.link, self.reads, self.runs, self.lost = f"modbus:127.0.0.1:{port}", 0, 0, []
        self.is_over = threading.Event()
        self.start()

    def run(self):
        with client.connect(self.link) as node:
            while not self.is_over.is_set():
                try:
                    if node.state == "DONE":
                        node.start()
                        self.runs += 1
                except client.Refused:
                    pass  # the last result is being judged
                except client.CommunicationError as error:
                    self.lost.append(str(error))
                self.reads += 1

    def end(self):
        """Wait for what it does now."""
        self.is_over.set()
        self.join(timeout=60)
        assert not self.is_alive()


def was_done(node):
    """Has a calibration come to its end? One that ended in a fault fails at once."""
    states = [event["state"] for event in node.events() if event["event"] == "state"]
    assert "TUMBLE_STATE_FAULT" not in states, node.events()[-3:]
    return "TUMBLE_STATE_DONE" in states


@pytest.mark.parametrize("reads, pace_s", [(200, PACE_S), pytest.param(10_000, 0.0, marks=pytest.mark.full)])
def test_a_script_beside_the_gateway_loses_no_read(bus, script, started, tmp_path, reads, pace_s):
    path = scenario(tmp_path, **HASTE, **PATIENCE)
    stand = Stand(bus, path, "--operator", "start")
    node = Node(bus, path, "--nv", tmp_path / "memory", folder=tmp_path)
    served = Served(bus, "--poll", FASTEST, "--allow-commands")
    started.extend([stand, node, served])
    wait_until(lambda: counted(served)["Polls"])  # until then it asks on the first channel where its own is
    unanswered = counted(served)["Polls failed"]  # while the node was starting
    second = Second(served.port)
    began, took, lost = time.monotonic(), [], []
    while len(took) < reads or not was_done(node):
        assert len(took) < reads or time.monotonic() - began < PATIENCE_S, node.events()[-3:]
        asked = time.monotonic()
        try:
            read(script, len(took))
        except canopen.SdoCommunicationError as error:
            lost.append((len(took), str(error)))
        took.append(time.monotonic() - asked)
        time.sleep(max(0.0, pace_s - took[-1]))
    second.end()
    took.sort()
    print(f"{len(took)} reads, {len(lost)} lost; 50 % within {1e3 * took[len(took) // 2]:.1f} ms, "
          f"99 % {1e3 * took[len(took) * 99 // 100]:.1f} ms, all {1e3 * took[-1]:.1f} ms; the second client: "
          f"{second.reads} reads, {len(second.lost)} lost, {second.runs} runs begun; {counted(served)}, "
          f"{unanswered} failed while the node was starting")
    assert (lost, second.lost) == ([], []) and second.reads > 0
    assert counted(served)["Polls failed"] == unanswered
    stand.end()
