"""tumble.client on a node that the tests play: the whole of a run, and every way in which it can end otherwise."""

import logging
import re

import pytest
from conftest import ROOT
from played_node import U0, K, PlayedCanNode
from simulated_bench import wait_until

from tumble import client
from tumble.client import can_link
from tumble.client.link import read_map
from tumble.client.node import kinds_of_settings
from tumble.errors import TumbleError, UsageError

can = pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("canopen", reason="python-canopen is not installed")
pytestmark = pytest.mark.python
logging.getLogger("canopen").setLevel(logging.CRITICAL)


@pytest.fixture
def played():
    """Make (node that is played, node that a client has)."""
    opened = []

    def begin(**keys):
        node = PlayedCanNode(**keys)
        opened.extend([node, client.connect(f"can:virtual@{node.channel}")])
        return opened[-2:]

    yield begin
    for one in reversed(opened):
        one.close()


def test_a_run_from_start_to_accept(played):
    theirs, node = played()
    assert (node.state, node.reason.name, node.run) == ("IDLE", "NONE", 0)
    assert node.start() == "PREFLIGHT"
    asked = []
    while node.wait(until=("WAIT_MOUNTING", "DONE"), timeout=30) == "WAIT_MOUNTING":
        asked.append(node.mounting)
        assert node.confirm() == "MOVE"
    result = node.result()
    assert asked == [1, 2] and result.run == 1
    assert result.K.tolist() == K and result.U0.tolist() == U0 and result.u_K.shape == (3, 3)
    assert (result.verdict, [one.name for one in result.objections]) == ("HELD", ["FIRST"])
    assert node.accept(result) == "ACCEPTED" and node.result().calibration_counter == 1
    assert theirs.commands == [("START", 0), ("CONFIRM_MOUNTING", 1), ("CONFIRM_MOUNTING", 2), ("ACCEPT", 0)]


@pytest.mark.parametrize("bolted_once", [False, True])
def test_what_the_operator_is_asked_to_do(played, bolted_once):
    theirs, node = played()
    theirs.bolted_once, asked = bolted_once, []
    node.start()
    while node.wait(until=("WAIT_MOUNTING", "DONE"), timeout=30) == "WAIT_MOUNTING":
        asked.append((node.mounting, node.inclination))
        node.confirm()
    assert asked == [(1, None), (2, 45.0 if bolted_once else None)]


def test_a_node_without_inclinations_asks_to_mount(played, monkeypatch):
    theirs, node = played()
    theirs.bolted_once, theirs.mounting = True, 2
    assert node.inclination == 45.0
    monkeypatch.setattr(node.link, "has", lambda name: name != "Progress: Inclination")
    assert node.inclination is None


def test_what_a_drive_refuses_is_named_in_a_run_and_between_runs(played):
    theirs, node = played(fails={1: "STAND_PROTOCOL"})
    before, theirs.refusal = node.drive_refusal, (0x6084, 0, 0x06020000, 1)
    said = "drive object 6084h:0, abort 0602 0000h, in configuration"
    assert (before, node.drive_refusal) == ("", said)
    with pytest.raises(client.Refused, match=f"HOME_AXIS was refused: .* the stand homing: {said}"):
        node.command("HOME_AXIS")
    node.start()
    node.wait(until="WAIT_MOUNTING", timeout=30)
    node.confirm()
    theirs.refusal = (0x6041, 0, 0x05040000, 9)
    with pytest.raises(client.RunFailed, match=r"6041h:0, .*, in the set-point: bit 12 after bit 4 was set") as end:
        node.wait(timeout=30)
    assert end.value.drive_refusal == node.drive_refusal


def test_a_fault_that_cannot_be_cleared_yet_says_why(played):
    theirs, node = played()
    for rung, why in ((0, ""), (3, ", and the axis is not yet known to be at rest after the stop: try again"), (6, "")):
        theirs.rung = rung
        with pytest.raises(client.Refused) as end:
            node.command("CLEAR_FAULT")
        assert str(end.value).endswith(f"it is IDLE{why}")


def test_a_fault_says_why_and_what_to_do_and_a_resume_goes_on(played):
    _theirs, node = played(fails={1: "STALL"})
    node.start()
    node.wait(until="WAIT_MOUNTING", timeout=30)
    node.confirm()
    with pytest.raises(client.RunFailed, match=r"in FAULT: STALL, .* Remedy: The axis does not follow") as end:
        node.wait(timeout=30)
    assert (end.value.state, end.value.reason.name) == ("FAULT", "STALL") and isinstance(end.value, TumbleError)
    assert node.wait(until="FAULT") == "FAULT"
    assert node.resume() == "MOVE"
    with pytest.raises(client.RunFailed, match="the run is in ABORT: COMMAND, aborted by command"):
        node.abort()
        node.wait()


def test_waiting_ends_in_time_with_the_last_state(played):
    _theirs, node = played(stays="WARM_UP")
    node.start()
    with pytest.raises(TimeoutError, match=r"DONE did not come within 0\.2 s; the state is WARM_UP") as end:
        node.wait(timeout=0.2)
    assert isinstance(end.value, client.TimedOut) and end.value.state == "WARM_UP"
    with pytest.raises(UsageError, match="there is no state 'FINISHED'; there are IDLE, PREFLIGHT"):
        node.wait(until="FINISHED")


@pytest.mark.parametrize(("now", "said"), [
    (0, "run 2 is gone: the node has restarted; the state is IDLE"),
    (3, "run 2 is gone: run 3 has begun; the state is IDLE"),
])
def test_a_run_that_is_gone_is_waited_for_no_longer(played, now, said):
    theirs, node = played(stays="AVERAGE")
    theirs.run = 1
    node.start()
    node.wait(until="AVERAGE", timeout=30)

    theirs.run, theirs.states = now, ["IDLE"]
    with pytest.raises(client.RunGone, match=said) as end:
        node.wait()
    assert (end.value.run, end.value.state) == (2, "IDLE") and isinstance(end.value, client.RunFailed)


def test_a_run_that_somebody_else_begins_is_waited_for(played):
    theirs, node = played()
    begins_a_run_at(theirs, (0x2001, 0))
    assert node.wait(until="WAIT_MOUNTING", timeout=30) == "WAIT_MOUNTING" and node.run == 1


def test_what_the_state_does_not_allow_is_refused(played):
    theirs, node = played()
    for command in (node.abort, node.resume, node.confirm, node.discard):
        with pytest.raises(client.Refused, match=r"refused: the state does not allow it \(0800 0022h\); it is IDLE"):
            command()
    with pytest.raises(client.Refused, match=r"does not allow it \(0800 0022h\); it is IDLE, the stand homing$"):
        node.command("HOME_AXIS")
    with pytest.raises(client.NoResult, match="the node has no result; its state is IDLE"):
        node.result()
    assert theirs.commands == []


def test_settings_by_name_with_their_units(played):
    theirs, node = played()
    settings = node.settings
    assert set(settings) == set(kinds_of_settings()) and len(settings) == len(kinds_of_settings())
    assert settings.unit("Configuration: Settling time") == "ms" and not settings.needs_unlock("Host: Inhibit")
    settings["Configuration: Settling time"] = 70
    assert settings["Configuration: Settling time"] == 70
    coverage = "Commit rules: Coverage"
    with pytest.raises(client.Refused, match=rf"{coverage} was refused: .*; no run may be on, .* unlock\(\) opens it"):
        settings[coverage] = 2.5
    with node.unlock():
        settings[coverage] = 2.5
    assert (settings[coverage], theirs.level) == (2.5, 0)


@pytest.mark.parametrize("value", [1.5, -1, 300, float("inf")])
def test_a_value_that_no_such_object_can_hold_is_refused_before_it_is_sent(played, value):
    _theirs, node = played()
    node.settings["Configuration: Estimator"] = 1
    with pytest.raises(client.Refused, match=r"Estimator was refused: value out of range \(0609 0030h\)"):
        node.settings["Configuration: Estimator"] = value
    assert node.settings["Configuration: Estimator"] == 1


def test_what_there_is_not_is_told_by_its_name(played):
    _theirs, node = played()
    with pytest.raises(KeyError):
        node.settings["Weather"]
    with pytest.raises(UsageError, match="there is no setting 'Weather'"):
        node.settings["Weather"] = 1
    with pytest.raises(UsageError, match="there is no command 'FLY'; there are NONE, START"):
        node.command("FLY")
    with pytest.raises(UsageError, match="TURN_AXIS needs angle_deg"):
        node.command("TURN_AXIS")
    with pytest.raises(client.Refused, match=r"reading Weather was refused: no such object \(0602 0000h\)"):
        node.read("Weather")
    assert node.has("Progress: Actual angle") and not node.has("Progress: Weather") and not node.has("Weather")


def begins_a_run_at(theirs, entry, times=1):
    """Somebody else gives START just when this object is read, so many times."""
    value, left = theirs.computed.get(entry, lambda: 0), [theirs] * times

    def read():
        if left:
            left.pop().start(0)
        return value()

    theirs.computed[entry] = read


@pytest.mark.parametrize("entry", [(0x2007, 0), (0x2021, 3), (0x2022, 1)])
def test_a_result_is_of_one_run_whenever_another_one_begins(played, entry):
    theirs, node = played(mountings=1)
    node.start()
    node.wait(until="WAIT_MOUNTING", timeout=30)
    node.confirm()
    node.wait(timeout=30)
    begins_a_run_at(theirs, entry)
    with pytest.raises(client.NoResult, match="the node has no result"):
        node.result()
    assert node.run == 2


def test_a_status_is_of_one_run_and_reading_ends(played):
    theirs, node = played(stays="WARM_UP")
    begins_a_run_at(theirs, (0x2001, 0))
    theirs.states = ["ABORT"]
    status = node.status
    assert (status.run, status.state) == (1, "PREFLIGHT")
    theirs.states = ["ABORT"]
    theirs.computed[0x2001, 0] = lambda: setattr(theirs, "run", theirs.run + 1) or 0
    with pytest.raises(client.CommunicationError, match="runs begin faster than the node can be read"):
        _ = node.status


def test_a_board_without_memory_has_a_result_and_no_verdict(played):
    _theirs, node = played(memory=False, mountings=1)
    node.start()
    node.wait(until="WAIT_MOUNTING", timeout=30)
    node.confirm()
    node.wait(timeout=30)
    result = node.result()
    assert (result.verdict, result.proposal, result.calibration_counter) == (None, None, None)
    assert result.K.tolist() == K
    assert node.settings["Commit rules: Coverage"] is None
    with pytest.raises(UsageError, match="the result is not held: its verdict is None"):
        node.accept(result)


def test_events_are_the_changes(played):
    _theirs, node = played(mountings=1)
    node.start()
    seen = []
    for status in node.events(timeout=30):
        seen.append((status.run, status.state, status.verdict))
        if status.state == "WAIT_MOUNTING":
            node.confirm()
        if status.verdict == "HELD":
            break
    states = [state for _, state, _ in seen]
    assert states[0] in ("WARM_UP", "WAIT_MOUNTING") and states[-1] == "DONE" and len(set(seen)) == len(seen)
    assert [status.state for status in node.events(timeout=0)] == ["DONE"]


def test_a_bus_that_is_given_is_left_open_and_both_servers_answer(played):
    theirs, _node = played()
    bus = can.Bus(interface="virtual", channel=theirs.channel)
    with client.connect(bus) as node:
        assert node.state == "IDLE"
    bus.send(can.Message(arbitration_id=0x601, data=bytes(8), is_extended_id=False))  # it is open still
    requests = theirs.answer_as_second_server()
    with client.connect(bus, server=2) as node:
        assert node.state == "IDLE" and node.start() == "PREFLIGHT"
    assert requests == [0x401] * len(requests) and len(requests) > 4
    bus.shutdown()


def test_a_silent_node_is_a_sentence(played):
    theirs, node = played()
    theirs.network.unsubscribe(0x601)
    node.link._sdo.RESPONSE_TIMEOUT = 0.05
    for act in (lambda: node.state, node.start, lambda: node.wait(timeout=9)):
        with pytest.raises(client.CommunicationError, match="node 1 does not answer: No SDO response received"):
            act()


def test_a_bus_that_goes_away_is_told_and_when_it_is_back_the_client_goes_on(played, capfd, monkeypatch):
    """As an interface of Linux does: receiving ends with an error, and each sending, until it is up again."""
    _theirs, node = played()
    bus = node.link.network.bus
    gone, failures = can.CanOperationError("Network is down [Error Code 100]", 100), [1]

    def fail(*_, **__):
        failures.append(1)
        raise gone

    with monkeypatch.context() as down:
        down.setattr(bus, "send", fail)
        down.setattr(bus, "_recv_internal", fail)
        wait_until(lambda: len(failures) > 3)
        for act in (lambda: node.state, node.start, node.unlock().__enter__):
            with pytest.raises(client.CommunicationError, match="the bus takes no request: Network is down"):
                act()
    assert node.state == "IDLE" and node.start() == "PREFLIGHT"
    assert capfd.readouterr().err == ""


def test_what_goes_wrong_while_unlocked_is_what_is_told(played, monkeypatch):
    theirs, node = played()
    with monkeypatch.context() as down, pytest.raises(ValueError, match="mine"), node.unlock():
        down.setattr(node.link.network.bus, "send", lambda *_: (_ for _ in ()).throw(can.CanOperationError("gone")))
        raise ValueError("mine")
    with pytest.raises(ValueError, match="mine"), node.unlock():
        raise ValueError("mine")
    assert theirs.level == 0
    with pytest.raises(ValueError, match="mine"), node.unlock():
        node.close()
        raise ValueError("mine")


def test_what_is_no_number_and_no_whole_one(played):
    theirs, node = played()
    for name in ("Configuration: Samples per position", "Commit rules: Coverage"):
        for value in (None, "abc"):
            with pytest.raises(UsageError, match=rf"writing {name}: '{value}' is not a number"):
                node.settings[name] = value
    for argument in (-1, 1.5, 300, float("nan")):
        with pytest.raises(client.Refused, match=r"value out of range \(0609 0030h\)"):
            node.confirm(argument)
    with pytest.raises(UsageError, match="no state is given to wait for"):
        node.wait(())
    with pytest.raises(client.NoResult):
        node.result(timeout=None)
    assert theirs.commands == []


def test_a_record_is_no_object(played):
    _theirs, node = played()
    for name in ("Command", "State: foo", "K: foo", ""):
        assert not node.has(name)
        with pytest.raises(client.Refused, match=r"no such object \(0602 0000h\)"):
            node.read(name)
        with pytest.raises(client.Refused, match=r"no such object \(0602 0000h\)"):
            node.write(name, 1)


def test_a_link_that_is_closed_stays_so(played):
    _theirs, node = played()
    node.close()
    node.close()
    with pytest.raises(UsageError, match="the link is closed"):
        _ = node.state


@pytest.mark.real_time
def test_an_answer_that_is_lost_is_asked_for_again(played):
    """Twice of each reading and each setting; of a command it is told."""
    theirs, node = played()
    node.link._sdo.RESPONSE_TIMEOUT = 0.3
    send, lost = theirs.network.send_message, []

    def lose(identifier, data, remote=False):
        if len(lost) < 2 and identifier == 0x581:
            lost.append(bytes(data))
        else:
            send(identifier, data, remote)

    theirs.network.send_message = lose
    assert node.state == "IDLE" and len(lost) == 2
    lost.clear()
    node.settings["Configuration: Settling time"] = 70
    assert len(lost) == 2 and node.settings["Configuration: Settling time"] == 70
    lost.clear()
    with pytest.raises(client.CommunicationError, match="node 1 does not answer"):
        node.link._tell("Command: Command", 1, "START")
    lost.extend([b""] * 2)
    assert (node.state, theirs.commands) == ("PREFLIGHT", [("START", 0)])


class Shared(can_link.CanLink):
    """A channel on which so many answers are to another client first."""

    def __init__(self, others):
        self.others = others

    def _ask_once(self, sdo, name):
        self.others -= 1
        if self.others >= 0:
            raise can_link._silent(sdo, Exception("Unexpected response 0x43"))
        return 7


def test_what_another_client_was_told_is_asked_for_again(played):
    _theirs, node = played()
    assert Shared(20).ask(node.link._sdo, "State") == 7
    with pytest.raises(client.CommunicationError, match="node 1 answers another SDO client as well, say a gateway: Un"):
        Shared(21).ask(node.link._sdo, "State")


def test_both_links_call_an_object_by_the_same_name(played):
    """The names of the registers are those of the EDS file, and every setting is in both."""
    _theirs, node = played()
    register_map = read_map()
    own = register_map.input["Magic word"][0].at
    names = [name for name, rows in register_map.input.items() if rows[0].valid is not None]
    assert own == 0 and len(names) > 200
    assert [name for name in names if not node.has(name)] == []
    assert [name for name in kinds_of_settings() if name not in register_map.settings or not node.has(name)] == []


def test_the_page_lists_every_setting_with_its_unit():
    page = (ROOT / "docs/client.md").read_text(encoding="utf-8").partition("## The settings")[2].partition("##")[0]
    listed = {}
    for names, unit, unlock in re.findall(r"^\| (`.*`.*) \| (.*?) ?\| (yes)? ?\|$", page, re.MULTILINE):
        first, *others = re.findall(r"`([^`]+)`", names)
        record = first.partition(": ")[0]
        entries = [first.partition(": ")[2], *others]
        if " to " in names:
            entries = [f"{entries[0][:-len(end)]}{one}" for end in [re.search("x+$", entries[0])[0]]
                       for one in (("xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz") if end == "xx" else "xyz")]
        listed |= {f"{record}: {entry}": (unit, bool(unlock)) for entry in entries}
    assert listed == {name: (unit, level) for name, (unit, _, level) in kinds_of_settings().items()}
