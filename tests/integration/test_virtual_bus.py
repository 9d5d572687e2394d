"""Firmware and stand in virtual time as a bus of python-can: what its time is, and that nothing else counts."""

import json
import re
import time

import pytest
from conftest import ROOT
from simulated_bench import scenario

from tumble import World, client
from tumble.errors import UsageError
from tumble.testing.rigs import FAST
from tumble.testing.virtual_bus import VirtualBus, time_of

can = pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("canopen", reason="python-canopen is not installed")
pytestmark = pytest.mark.python

HEARTBEATS = (0x701, 0x702, 0x703)


@pytest.fixture
def virtual(tmp_path):
    """Open a bus with the scenario FAST, changed by keys."""
    opened = []

    def begin(operator="on-confirm", seed=1, memory=False, out=None, can_filters=None, **keys):
        path = scenario(tmp_path, **{name.replace(".", "__"): value for name, value in FAST.items()} | keys)
        opened.append(VirtualBus(path, seed=seed, operator=operator, memory=memory, out=out, can_filters=can_filters))
        return opened[-1]

    yield begin
    for bus in opened:
        bus.shutdown()


def request(subindex, value=None):
    """To write 2002h, or to read it."""
    command, data = (0x40, 0) if value is None else (0x2F, value)
    return can.Message(arbitration_id=0x601, data=[command, 0x02, 0x20, subindex, data, 0, 0, 0], is_extended_id=False)


def test_time_goes_on_only_while_its_owner_waits(virtual):
    bus = virtual()
    assert bus.now_s == 0.0
    bus.sleep(0.25)
    assert bus.now_s == 0.25
    time.sleep(0.02)  # of the machine's
    assert bus.now_s == 0.25
    bus.sleep(-1)
    bus.sleep(0)
    assert bus.now_s == 0.25
    stamps = [bus.recv(timeout=1.0).timestamp for _ in range(50)]
    assert stamps == sorted(stamps) and bus.now_s == max(0.25, stamps[-1])


def test_waiting_for_what_does_not_come_takes_its_virtual_time(virtual):
    bus = virtual(can_filters=[{"can_id": 0x7FF, "can_mask": 0x7FF}])
    assert bus.recv(timeout=7.5) is None and bus.now_s == 7.5


def test_a_request_is_answered_when_send_returns(virtual):
    bus = virtual()
    bus.sleep(1)
    while bus.recv(0) is not None:
        pass
    bus.send(request(1))
    come = [message.arbitration_id for message in iter(lambda: bus.recv(0), None)]
    assert come.count(0x581) == 1 and 1.0 < bus.now_s < 1.01
    before = bus.now_s
    bus.send(can.Message(arbitration_id=0x601, data=[0x80, 0, 0, 0, 0, 0, 0, 0], is_extended_id=False))
    assert bus.now_s == before  # an abort has no answer


def test_another_thread_has_taken_all_when_the_owner_goes_on(virtual):
    """Every heartbeat of ten seconds, none later; each is handled slowly."""
    bus = virtual()
    heard = []

    def hear(message):
        if message.arbitration_id == HEARTBEATS[0]:
            time.sleep(0.0005)
            heard.append(message.timestamp)

    notifier = can.Notifier(bus, [hear], timeout=0.01)
    for second in range(1, 11):
        bus.sleep(1.0)
        assert len(heard) == 10 * second and heard[-1] <= bus.now_s == second
    notifier.stop()
    bus.sleep(1.0)  # nobody receives any more
    assert len(heard) == 100 and bus.now_s == 11


def calibrated(bus, pause_s=0.0):
    """(result, when it was there, how many states were seen)"""
    seen = []
    with time_of(bus), client.connect(bus) as node:
        node.start()
        while (state := node.wait(until=("WAIT_MOUNTING", "DONE"), timeout=600)) != "DONE":
            time.sleep(pause_s)
            seen.append((state, node.confirm()))
        return node.result(), bus.now_s, seen


def test_the_same_calls_have_the_same_outcome_to_the_last_bit(virtual, tmp_path):
    runs = [calibrated(virtual(seed=5, out=tmp_path / name), 0.3) for name in ("a", "b")]
    assert runs[0][0].K.tobytes() == runs[1][0].K.tobytes() and runs[0][1:] == runs[1][1:]
    assert [state for state, _ in runs[0][2]] == ["WAIT_MOUNTING"] * 2
    for bus in (calibrated(virtual(seed=6))[0], calibrated(virtual(seed=5))[0]):
        assert bus.passed and bus.K.tobytes() != runs[0][0].K.tobytes()  # another seed; another moment


def test_the_run_is_kept_as_any_run_of_the_bench(virtual, tmp_path):
    bus = virtual(seed=5, out=tmp_path / "run")
    result, _, _ = calibrated(bus)
    document = bus.end()
    assert (document["end"], document["state"]) == ("left", "TUMBLE_STATE_DONE") and document["table"]["at_rest"]
    assert abs(result.K - document["truth"]["K"]).max() < 3e-3
    assert (tmp_path / "run/run.csv").read_text().count("\n") == 1 + 18 * 10
    assert json.loads((tmp_path / "run/bench.json").read_text())["state"] == "TUMBLE_STATE_DONE"


def test_a_node_with_memory_keeps_what_the_script_accepts_and_commits_the_next_run_by_itself(virtual):
    bus = virtual(memory=True, keeper__serial="TB-0001")
    with time_of(bus), client.connect(bus) as node:
        for verdict in ("HELD", "COMMITTED"):
            node.start()
            while node.wait(until=("WAIT_MOUNTING", "DONE"), timeout=600) != "DONE":
                node.confirm()
            result = node.result()
            assert result.verdict == verdict and result.u_K.shape == (3, 3)
            if verdict == "HELD":
                assert [one.name for one in result.objections] == ["FIRST"] and node.accept(result) == "ACCEPTED"
        assert node.status.calibration_counter == 2


def test_without_a_confirmation_the_node_waits_and_the_block_is_not_mounted(virtual):
    bus = virtual(procedure__mounting_timeout_ms=3_600_000)
    with time_of(bus), client.connect(bus) as node:
        node.start()
        node.wait("WAIT_MOUNTING", timeout=60)
        time.sleep(100)
        assert node.state == "WAIT_MOUNTING"
        with pytest.raises(client.Refused):
            node.confirm(2)
        assert node.confirm(1) != "WAIT_MOUNTING"
        node.wait("WAIT_MOUNTING", timeout=60)  # mounting 1 was right, or there were a fault
        assert node.mounting == 2


@pytest.mark.parametrize("operator", ["by-itself", "never"])
def test_who_mounts_without_a_confirmation(virtual, operator):
    bus = virtual(operator=operator)
    with time_of(bus), client.connect(bus) as node:
        node.start()
        if operator == "by-itself":
            assert node.wait("DONE", timeout=60) == "DONE"
            return
        with pytest.raises(client.RunFailed) as end:
            for _ in range(2):  # it lies on the table as mounting 1 wants it
                node.wait("WAIT_MOUNTING", timeout=60)
                node.confirm()
            node.wait("DONE", timeout=60)
        assert end.value.reason.name in ("WRONG_MOUNTING", "SWAPPED_CHANNELS")


def test_a_fault_is_mended_when_the_script_goes_on(virtual):
    bus = virtual(fault="drive_fault at=1.2 phase=move value=0x7500", operator__mends=1, procedure__retries=0)
    with time_of(bus), client.connect(bus) as node:
        node.start()
        node.wait("WAIT_MOUNTING", timeout=60)
        node.confirm()
        node.wait("FAULT", timeout=60)
        assert node.reason.name == "DRIVE_FAULT"
        time.sleep(100)
        assert node.state == "FAULT"
        node.resume()
        node.wait("WAIT_MOUNTING", timeout=60)
        assert node.mounting == 2


def test_what_is_no_classic_frame_and_a_bus_that_has_been_left(virtual):
    bus = virtual()
    for wrong in ({"is_extended_id": True}, {"is_remote_frame": True, "is_extended_id": False}):
        with pytest.raises(can.CanOperationError, match="only classic data frames"):
            bus.send(can.Message(arbitration_id=1, **wrong))
    bus.shutdown()
    bus.shutdown()
    for call in (lambda: bus.sleep(1), lambda: bus.recv(1), lambda: bus.send(request(1))):
        with pytest.raises(can.CanOperationError, match="the bus has been shut down"):
            call()


def test_a_scenario_that_is_none_is_told_in_one_line(tmp_path):
    path = scenario(tmp_path, no__such_key=1)
    with pytest.raises(can.CanInitializationError, match=r"scenario.txt:1: no such key: no.such_key") as told:
        VirtualBus(path)
    assert "\n" not in str(told.value)


def test_the_end_of_its_time_is_told(virtual):
    bus = virtual(limit__virtual_s=30, firmware__starts="yes")
    bus.sleep(29)
    with pytest.raises(can.CanOperationError, match=r"the simulated run has come to its end"):
        bus.sleep(2)
    document = bus.end()
    assert (document["end"], document["state"]) == ("left", "TUMBLE_STATE_IDLE")  # it has begun nothing by itself


def test_a_memory_needs_the_name_of_the_block(tmp_path):
    with pytest.raises(can.CanInitializationError, match=r"keeper\.serial is missing: who keeps coefficients must be"):
        VirtualBus(memory=True)


def test_the_table_turns_for_a_drive_outside(virtual):
    with virtual(present__drive="no") as bus:
        bus.turn_table(30.0, 60.0)
        bus.sleep(0.25)
        assert 5.0 < bus.end()["table"]["highest_deg"] <= 30.0
    world = World(1, **{"present.drive": False})
    world.turn_table(-36000, 1e5)
    for wrong in ((36000.1, 1.0), (0.0, 0.0), (0.0, -1.0), (0.0, 1.1e5), (float("nan"), 1.0), (0.0, float("inf"))):
        with pytest.raises(UsageError, match="the table turns to -36000 to 36000 deg, at 1e-5 to 1e5 deg/s"):
            world.turn_table(*wrong)
    with virtual() as bus, pytest.raises(can.CanOperationError, match=r"present\.drive = no leaves it to another"):
        bus.turn_table(30.0, 60.0)


def sent(world):
    """(time, ms, rounded; the first byte) of the frames that python-can has sent."""
    return [(round(frame.time_s * 1e3), frame.data[0]) for frame in world.frames() if frame.sender == "guest"]


def test_what_is_sent_periodically_is_sent_in_virtual_time():
    world = World(1, **{"firmware.starts": False})
    a, b = (can.Message(arbitration_id=0x10, data=[byte], is_extended_id=False) for byte in b"ab")
    c = can.Message(arbitration_id=0x11, data=b"a", is_extended_id=False)
    with world.bus() as bus:
        bus.sleep(0.1)
        task = bus.send_periodic([a, b], 0.25)
        bus.sleep(0.9)
        task.stop()
        bus.sleep(1.0)
        assert sent(world) == [(100, 97), (350, 98), (600, 97), (850, 98)] and bus.now_s == 2.0
        task.start()
        bus.send_periodic(c, 0.1, duration=0.25, modifier_callback=lambda message: message.data.__setitem__(0, 99))
        while bus.now_s < 2.31:
            bus.recv(timeout=0.01)  # which stops at every frame
        assert sorted(sent(world)[4:]) == [(2000, 97), (2000, 99), (2100, 99), (2200, 99), (2250, 98)]
        assert bus.periodic == [task]
        with pytest.raises(can.CanOperationError, match="only classic data frames"):
            bus.send_periodic(can.Message(arbitration_id=1, is_extended_id=True), 1.0)


@pytest.mark.parametrize("channel", [None, "", "paper", "FILE"])
def test_python_can_finds_it_by_its_name(channel, tmp_path, monkeypatch):
    entry = r'\[project\.entry-points\."can\.interface"\]\ntumble = "([a-z._]+):(\w+)"\n'
    [found] = re.findall(entry, (ROOT / "host/python/pyproject.toml").read_text())
    monkeypatch.setitem(can.interface.BACKENDS, "tumble", found)
    channel = str(scenario(tmp_path, present__block="no")) if channel == "FILE" else channel
    with can.Bus(interface="tumble", channel=channel, ignore_config=True, seed=3) as bus:
        heard = {bus.recv(1.0).arbitration_id for _ in range(100)}
        assert isinstance(bus, VirtualBus) and (0x703 in heard) == (channel in (None, "", "paper"))


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_a_script_has_the_time_of_its_bus_until_it_is_left(order):
    """Of the last one, where it has several."""
    machine = time.sleep, time.monotonic, time.time
    buses = [VirtualBus(script_time=True) for _ in range(2)]
    for left, stays in ((None, 1), order):
        if left is not None:
            buses[left].shutdown()
        before, bus_before = time.monotonic(), buses[stays].now_s
        time.sleep(50)
        assert time.monotonic() - before == pytest.approx(50.0) and buses[stays].now_s == bus_before + 50
    buses[order[1]].shutdown()
    assert (time.sleep, time.monotonic, time.time) == machine


def test_the_link_of_a_script(tmp_path):
    """A calibration of a minute or more, by a script that knows nothing of virtual time."""
    path = scenario(tmp_path, **{name.replace(".", "__"): value for name, value in FAST.items()})
    with client.connect(f"can:tumble@{path}") as node:
        began = time.time()
        node.start()
        while node.wait(until=("WAIT_MOUNTING", "DONE"), timeout=600) != "DONE":
            time.sleep(30)
            node.confirm()
        assert node.result().passed and time.time() > began + 60
    for wrong, says in (("no\n", "scenario.txt:1: "), (None, "scenario.txt: no such file")):
        path.unlink() if wrong is None else path.write_text(wrong)
        with pytest.raises(UsageError, match=rf"^can:tumble@\S+ cannot be opened: \S+{says}"):
            client.connect(f"can:tumble@{path}")
