"""People's scripts on a real bus, with the fixtures of the pytest plugin: docs/client.md."""

import threading
from datetime import datetime, timezone

import can
import documents
import numpy as np
import pytest
from paced_scripts import calibrate

from tumble import client
from tumble.testing import rigs

pytest.importorskip("canopen", reason="python-canopen is not installed")
SLOW_TABLE = {
    "motion__speed_deg_s": 60,
    "profile__homing_fast_deg_s": 60,
    "profile__homing_slow_deg_s": 60,
    "firmware__heartbeat_timeout_ms": 500,
    "profile__heartbeat_timeout_ms": 500,
}
LOST = ("STAND_HEARTBEAT", "BLOCK_HEARTBEAT")
PACES_S = [0.0, *(0.001 * 1.5**power for power in range(19))]  # to 1.5 s between two calls


@pytest.fixture
def rig(bus, tmp_path):
    """Stand and node as a marker would have them."""
    opened = []

    def begin(**wanted):
        opened.append(rigs.on_can(rigs.Wanted(**wanted), tmp_path, f"can:{bus}"))
        return opened[-1].__enter__()

    yield begin
    for one in opened:
        one.__exit__(None, None, None)


@pytest.mark.parametrize("pace_s", [pytest.param(pace, marks=[] if number in (0, 14) else pytest.mark.full)
                                    for number, pace in enumerate(PACES_S)])
def test_the_script_of_the_page_works_at_any_pace(rig, pace_s):
    """The block is in the asked mounting as soon as the script confirms; the stand itself tells node 1 nothing."""
    made = rig(seed=11)
    with client.connect(made.node.link) as node:
        result = calibrate(node, pace_s)
    document, truth = made.node.end(), made.stand.end()
    assert result.passed and result.run == 1 and document["end"] == "done"
    assert np.abs(result.K - truth["truth"]["K"]).max() < 3e-3 and np.abs(result.U0 - truth["truth"]["U0"]).max() < 3e-3
    assert truth["operator"] == {"answers": 0, "refusals": 0}


def test_the_paces_are_twenty():
    assert len(PACES_S) == 20 and PACES_S[0] == 0 and 1 < PACES_S[-1] < 2


@pytest.mark.parametrize("operator", ["by-itself", "never"])
def test_who_mounts_without_the_script(rig, operator):
    made = rig(operator=operator, procedure__mounting_timeout_ms=2000)
    with client.connect(made.node.link) as node:
        node.start()
        if operator == "by-itself":
            assert node.wait("DONE", timeout=60) == "DONE"
        else:
            with pytest.raises(client.RunFailed) as end:
                node.wait("DONE", timeout=60)
            assert end.value.reason.name == "MOUNTING_NOT_CONFIRMED"
    assert made.stand.end()["operator"]["answers"] == (2 if operator == "by-itself" else 0)


def test_a_node_with_memory_keeps_what_the_script_accepts(rig, tmp_path):
    made = rig(memory=True)
    with client.connect(made.node.link) as node:
        result = calibrate(node)
        assert (result.verdict, [one.name for one in result.objections]) == ("HELD", ["FIRST"])
        assert node.accept(result) == "ACCEPTED"
    assert made.node.end()["state"] == "TUMBLE_STATE_DONE" and (tmp_path / "tumble-memory").exists()


class LastWords:
    """When drive and block were last heard, by the stamps of the kernel, s since 1970."""

    def __init__(self, interface):
        filters = [{"can_id": node, "can_mask": 0x7F} for node in (2, 3)]
        self.bus = can.Bus(interface="socketcan", channel=str(interface), can_filters=filters)
        self.last_s, self.thread = 0.0, threading.Thread(target=self.listen, daemon=True)
        self.thread.start()

    def listen(self):
        while message := self.bus.recv(timeout=2.0):
            if message.arbitration_id not in (0x202, 0x602, 0x603):  # what node 1 sends them
                self.last_s = message.timestamp

    def end(self):
        """After two seconds of silence."""
        self.thread.join(timeout=60)
        self.bus.shutdown()
        return self.last_s


@pytest.mark.parametrize("ended_by", ["signal", "abort"])
def test_a_stand_that_is_killed_is_the_cause_that_a_client_reads(rig, bus, tmp_path, ended_by):
    """kill -9 in a run: the line within a second of the stand's last frame, by the stamps of kernel and node; the
    reason over CAN; and the cause in the last document and the last line, whatever follows."""
    made, heard = rig(**SLOW_TABLE), LastWords(bus)
    with client.connect(made.node.link) as node:
        node.start()
        node.wait("WAIT_MOUNTING", timeout=60)
        node.confirm()
        node.wait("AVERAGE", timeout=60)
        node.wait("MOVE", timeout=60)
        made.stand.kill()
        with pytest.raises(client.RunFailed) as end:
            node.wait("DONE", timeout=60)
        assert end.value.state == node.state == "FAULT" and end.value.reason.name == node.reason.name
        reason = node.reason
        assert reason.name in LOST and reason.remedy
        last_s = heard.end()
        if ended_by == "abort":
            assert node.abort() == "ABORT" and node.reason.name == "COMMAND"
    document = made.node.end()
    assert made.stand.end() == {}
    assert (document["cause"]["reason"], document["cause"]["failed_in"]) == (f"TUMBLE_REASON_{reason.name}",
                                                                             "TUMBLE_STATE_MOVE")
    lines = [documents.valid(line, "log") for line in (tmp_path / "tumble-node.log").read_text().splitlines()]
    told = [line for line in lines if line["event"] == "fault"]
    assert [line["reason"] for line in told] == [f"TUMBLE_REASON_{reason.name}"] and told[0]["remedy"] == reason.remedy
    told_s = datetime.strptime(told[0]["time"], "%Y-%m-%dT%H:%M:%S.%fZ").replace(tzinfo=timezone.utc).timestamp()
    print(f"told {told_s - last_s:.3f} s after the last frame of the stand")
    assert 0.0 < told_s - last_s < 1.0
    assert (lines[-1]["event"], lines[-1]["cause"]) == ("end", f"TUMBLE_REASON_{reason.name}")
