"""A script over CAN beside the gateway, in a run: each has an SDO server of the node to itself, and no read is lost.

A virtual interface has no bit rate, so the gateway makes as many frames as the machine can. The script lets the kernel
filter them: python-can takes every frame by itself, falls behind, and loses what its socket has no room for.
"""

import time

import canopen
import pytest
from conftest import ROOT
from processes import HASTE, PATIENCE, Node, Stand, scenario
from test_gateway import Served

READS = 200
PACE_S = 0.05
PATIENCE_S = 150.0  # for all of it; each read has its own limit
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


def test_a_script_beside_the_gateway_loses_no_read(bus, script, started, tmp_path):
    path = scenario(tmp_path, **HASTE, **PATIENCE)
    stand = Stand(bus, path, "--operator", "start")
    node = Node(bus, path, "--nv", tmp_path / "memory", folder=tmp_path)
    served = Served(bus, "--poll", FASTEST)
    started.extend([stand, node, served])
    began, took, lost = time.monotonic(), [], []
    while len(took) < READS or not any(event.get("state") == "TUMBLE_STATE_DONE" for event in node.events()):
        assert time.monotonic() - began < PATIENCE_S, (len(took), [event["state"] for event in node.events()][-3:])
        asked = time.monotonic()
        try:
            read(script, len(took))
        except canopen.SdoCommunicationError as error:
            lost.append((len(took), str(error)))
        took.append(time.monotonic() - asked)
        time.sleep(max(0.0, PACE_S - took[-1]))
    took.sort()
    print(f"{len(took)} reads, {len(lost)} lost; 50 % within {1e3 * took[len(took) // 2]:.1f} ms, "
          f"99 % {1e3 * took[len(took) * 99 // 100]:.1f} ms, all {1e3 * took[-1]:.1f} ms; {counted(served)}")
    assert not lost, lost
    assert counted(served)["Polls failed"] == 0
    stand.end()
