"""tumble.client over Modbus: tumble-gateway as it is, before a node that the test plays."""

import os
import struct
import threading

import pytest
from false_gateway import FalseGateway
from played_behind_gateway import PlayedBehindGateway
from simulated_bench import wait_until

from tumble import client
from tumble.client.names import COMMAND, STATE_NAMES

pytest.importorskip("pymodbus", reason="pymodbus is not installed")
pytestmark = [pytest.mark.slow, pytest.mark.python, pytest.mark.real_time]
STATE = {name: number for number, name in enumerate(STATE_NAMES)}
K = [[-2.00000001, 0.01, 0.02], [0.03, -2.01, 0.04], [0.05, 0.06, -2.02]]
PROPOSAL, SERVICE_KEY = 0xBEEF0001, 0x76726573


class PlayedRun(PlayedBehindGateway):
    """Node 1 with a run that the test moves on by `show`. It has finished one already. `written`: all that it was told
    since: ((index, subindex), bytes)."""

    def __init__(self, gateway):
        super().__init__(gateway)
        self.run_number, self.written = 1, []
        self.show("DONE")
        self.put((0x2001, 0), "B", 0)
        self.put((0x2003, 4), "B", 2)
        self.put((0x2007, 0), "<I", 1)
        self.put((0x2123, 1), "<f", 3.0)
        self.put((0x2120, 7), "B", 2)
        for place in range(9):
            self.put((0x2020, place + 1), "<d", K[place // 3][place % 3])
        for place in range(3):
            self.put((0x2021, place + 1), "<d", 0.1)
        self.begin()

    def put(self, entry, form, value):
        self.set(*entry, struct.pack(form, value))

    def show(self, state):
        self.put((0x2000, 0), "B", STATE[state])

    def take(self, entry, data):
        self.written.append((entry, data))
        if entry == (0x2002, 2):
            self.obey(data[0])
        elif entry[0] == 0x2123:
            self.set(*entry, data)

    def obey(self, command):
        if command == COMMAND["START"]:
            self.run_number += 1
            self.put((0x2007, 0), "<I", self.run_number)
            self.show("PREFLIGHT")
        elif command == COMMAND["ABORT"]:
            self.put((0x2001, 0), "B", 1)
            self.show("ABORT")
        elif command == COMMAND["ACCEPT"]:
            self.put((0x2120, 7), "B", 5)


@pytest.fixture
def played(start):
    """(node that is played, node that a client has)."""
    gateway = start("--allow-commands")
    theirs = PlayedRun(gateway)
    with client.connect(f"modbus:127.0.0.1:{gateway.port}") as node:
        yield theirs, node


def test_done_is_never_that_of_the_run_before(played):
    """Twenty times: START, and at once a wait for what the node was in until then."""
    theirs, node = played
    assert node.wait() == "DONE"
    for number in range(2, 22):
        assert (node.start(), node.run) == ("PREFLIGHT", number)
        with pytest.raises(client.TimedOut):
            node.wait(timeout=0)
        assert node.abort() == "ABORT"
        with pytest.raises(client.RunFailed, match=r"in ABORT: COMMAND, aborted by command\. Remedy: Some"):
            node.wait()
    node.start()
    threading.Timer(0.2, theirs.show, ["DONE"]).start()
    assert node.wait(timeout=30) == "DONE"


def test_a_node_that_restarts_in_a_run_is_waited_for_no_longer(played):
    theirs, node = played
    node.start()

    def restart():
        theirs.put((0x2007, 0), "<I", 0)
        theirs.show("IDLE")

    threading.Timer(1.0, restart).start()
    with pytest.raises(client.RunGone, match="run 2 is gone: the node has restarted; the state is IDLE"):
        node.wait()


def test_a_result_is_read_as_fine_as_registers_have_it_and_accepted_by_its_name(played):
    theirs, node = played
    theirs.put((0x2120, 7), "B", 3)
    theirs.put((0x2120, 6), "<H", 0x41)
    theirs.put((0x2102, 14), "<I", PROPOSAL)
    theirs.gateway.tell("boot")
    node.link.fresh()
    result = node.result()
    assert [[pytest.approx(one, abs=0.51e-8) for one in row] for row in K] == result.K.tolist()
    assert (result.verdict, result.proposal, result.u_K) == ("HELD", PROPOSAL, None)
    assert [one.name for one in result.objections] == ["GRAVITY_CHECK", "FIRST"]
    assert node.accept(result) == "ACCEPTED"
    assert theirs.written[-2:] == [((0x2002, 4), struct.pack("<I", PROPOSAL)), ((0x2002, 2), b"\x09")]
    with pytest.raises(client.UsageError, match="the result is not held: its verdict is ACCEPTED"):
        node.accept(node.result())


def test_a_setting_that_is_written_is_the_one_that_is_read(played):
    theirs, node = played
    for value in (2.0, 5.5, 1.0):
        with node.unlock():
            node.settings["Commit rules: Coverage"] = value
        assert node.settings["Commit rules: Coverage"] == value
    assert node.settings["Drift limits per kelvin: U0_z"] is None  # this node has none
    told = [data for entry, data in theirs.written if entry == (0x2006, 1)]
    assert told == 3 * [struct.pack("<I", SERVICE_KEY), bytes(4)]


def test_what_is_not_allowed_says_what_would_allow_it(played):
    theirs, node = played
    with pytest.raises(client.Refused, match=r"Coverage was refused: .*\(0800 0022h\).* unlock\(\) opens it"):
        node.settings["Commit rules: Coverage"] = 2.0
    with pytest.raises(client.Refused, match=r"Estimator was refused: value out of range \(0609 0030h\)"):
        node.settings["Configuration: Estimator"] = 300
    theirs.gateway.tell("refuse 08000022")
    with pytest.raises(client.Refused, match=r"START was refused: the state does not allow it \(0800 0022h\)") as end:
        node.start()
    assert end.value.code == 0x08000022
    theirs.written.clear()
    with pytest.raises(client.UsageError, match="TURN_AXIS needs angle_deg"):
        node.command("TURN_AXIS")
    assert theirs.written == []


def test_a_moment_of_silence_is_waited_out(played):
    theirs, node = played
    for act, said in ((lambda: node.state, "DONE"), (node.start, "PREFLIGHT")):
        theirs.gateway.tell("silent 1")
        wait_until(lambda: node.link._own("Link state") == 2)
        threading.Timer(0.3, theirs.gateway.tell, ["silent 0"]).start()
        assert act() == said


def test_a_gateway_that_takes_no_commands_and_a_node_that_falls_silent(start):
    gateway = start()
    PlayedRun(gateway)
    with client.connect(f"modbus:127.0.0.1:{gateway.port}") as node:
        with pytest.raises(client.CommunicationError, match="takes no commands unless started with --allow-commands"):
            node.start()
        gateway.tell("silent 1")
        with pytest.raises(client.CommunicationError, match="the gateway says: the node is silent"):
            node.wait(until="IDLE", timeout=60)




@pytest.mark.parametrize("spoil", [
    pytest.param(lambda function, words: (function, words[:1]), id="short"),
    pytest.param(lambda function, _: (function, []), id="empty"),
    pytest.param(lambda function, words: (3, words), id="another function"),
    pytest.param(lambda function, words: (function, [*words, 0]), id="long"),
])
def test_an_answer_to_another_question_is_told_as_such(spoil):
    said = r"the gateway answers another request: function \d, \d+ words"
    gateway = FalseGateway(spoil)
    with pytest.raises(client.CommunicationError, match=said):
        client.connect(gateway.link)
    gateway = FalseGateway()
    with client.connect(gateway.link) as node:
        assert node.state == "IDLE"
        gateway.spoil = spoil
        with pytest.raises(client.CommunicationError, match=said):
            _ = node.status
    gateway.close()


def test_arguments_that_no_command_can_have_are_refused_as_over_can(played):
    theirs, node = played
    theirs.show("WAIT_MOUNTING")
    for argument in (-1, 70000, 1.5, float("nan"), float("inf")):
        with pytest.raises(client.Refused, match=r"CONFIRM_MOUNTING was refused: value out of range \(0609 0030h\)"):
            node.confirm(argument)
    with pytest.raises(client.Refused, match=r"CONFIRM_MOUNTING was refused: value out of range"):
        node.confirm(300)  # the gateway says so
    for angle in (1e9, float("nan")):
        with pytest.raises(client.Refused, match=r"TURN_AXIS was refused: value out of range \(0609 0030h\)"):
            node.command("TURN_AXIS", angle_deg=angle)
    for name in ("Configuration: Samples per position", "Commit rules: Coverage"):
        for value in (None, "abc"):
            with pytest.raises(client.UsageError, match=rf"writing {name}: '{value}' is not a number"):
                node.settings[name] = value
    assert theirs.written == []


def test_a_gateway_that_has_read_nothing_yet_is_waited_for():
    """As after its restart: the node is there, and there is no snapshot of it."""
    gateway = FalseGateway()
    with client.connect(gateway.link) as node:
        gateway.values["Snapshot number"] = 0
        threading.Timer(0.5, gateway.values.pop, ["Snapshot number"]).start()
        assert node.state == "IDLE" and "Snapshot number" not in gateway.values
    with pytest.raises(client.UsageError, match="the link is closed"):
        _ = node.state
    gateway.close()


def test_a_connect_in_vain_leaves_nothing_open_and_nothing_said(capfd):
    gateway = FalseGateway(lambda function, words: (function, [0] * len(words)))
    kept = []
    before = open_sockets()
    for _ in range(5):
        with pytest.raises(client.CommunicationError, match="this is not a tumble-gateway") as error:
            client.connect(gateway.link)
        kept.append(error)
    wait_until(lambda: open_sockets() <= before)
    gateway.close()
    with pytest.raises(client.CommunicationError, match="the gateway cannot be reached"):
        client.connect("modbus:127.0.0.1:1")
    assert capfd.readouterr().err == ""


def open_sockets():
    return len(os.listdir("/proc/self/fd"))
