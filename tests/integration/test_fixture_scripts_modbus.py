"""tools/fixture over Modbus: tumble-gateway as it is, before a node that the test plays."""

import struct
import threading

import pytest
from fixture_table import limits, read_limits
from gateway_bench import gateway_program, start
from test_gateway_serial import far_end, line, serve
from validation import session
from validation.errors import CommunicationError, Refused, StandFault
from validation.judge import Verdict
from validation.links import open_link
from validation.modbus_link import read_map

pytest.importorskip("pymodbus", reason="pymodbus is not installed")
assert gateway_program and start and line and far_end and serve
pytestmark = [pytest.mark.slow, pytest.mark.python]
ARGUMENT, COMMAND, ANGLE = (0x2002, 1), (0x2002, 2), (0x2002, 3)
STATE, ACTUAL, STAND = (0x2000, 0), (0x2003, 10), (0x2003, 12)
HOME, TURN, IN_POSITION, READY, STOPPED = 12, 13, 4, 1, 5


class PlayedNode(threading.Thread):
    """Homes and turns at once. `off_deg`: what the encoder reads beside the angle asked for."""

    def __init__(self, gateway, off_deg=0.0, serial=1):
        super().__init__(daemon=True)
        self.gateway, self.off_deg, self.commands, self.asked = gateway, off_deg, [], 0.0
        for sub, number in enumerate((0, 0x54420001, 0x10000, serial), start=1):
            gateway.set(0x1018, sub, struct.pack("<I", number))
        gateway.set(*STATE, b"\0")
        self.stand(READY, 0.0)
        self.start()

    def stand(self, state, angle):
        self.gateway.set(*ACTUAL, struct.pack("<d", angle))
        self.gateway.set(*STAND, bytes([state]))

    def run(self):
        while line := self.gateway.written.get():
            _, index, sub, *data = line.split()
            data = bytes.fromhex("".join(data))
            if (int(index, 16), int(sub)) == ANGLE:
                self.asked = struct.unpack("<d", data)[0]
            elif (int(index, 16), int(sub)) == COMMAND:
                self.commands.append(data[0])
                self.stand(IN_POSITION, 0.0 if data[0] == HOME else self.asked + self.off_deg)


@pytest.fixture
def played(start):
    """(gateway, node, link) of a gateway that reads its node every 50 ms."""
    links = []

    def begin(*options, **node):
        gateway = start(*(options or ["--allow-commands"]))
        player = PlayedNode(gateway, **node)
        links.append(open_link(f"modbus:127.0.0.1:{gateway.port}"))
        return gateway, player, links[-1]

    yield begin
    for link in links:
        link.close()


def test_objects_are_read_by_the_same_names_as_over_can(played):
    gateway, _node, link = played()
    assert (link.read("State"), link.read("Identity object: Product code")) == (0, 0x54420001)
    assert link.read("K: K_xx") is None and not link.has("Position: Mean x")
    gateway.set(0x2020, 1, struct.pack("<d", -1.98765432109))
    for entry in range(2, 10):
        gateway.set(0x2020, entry, struct.pack("<d", 0.0))
    link.fresh()
    assert link.read("K: K_xx") == pytest.approx(-1.98765432109, rel=1e-7)
    with pytest.raises(Refused, match="no such object"):
        link.read("Weather")


def test_every_input_register_is_in_the_objects_names():
    names = [name for table, name in read_map() if table == "input"]
    assert "Progress: Stand state" in names and "Progress: Actual angle" in names


def test_link_read_back_and_settling(played, tmp_path):
    _gateway, node, link = played()
    asked = read_limits(str(limits(tmp_path, settling__settling_s=2)))
    with session.opened(link, asked, [], None) as context:
        outcomes = {name: session.run(name, context) for name in ("link", "positions", "settling", "backlash")}
    assert outcomes["link"].verdict == outcomes["settling"].verdict == Verdict.MEETS
    read_back, set_angle = outcomes["positions"].lines
    assert read_back.verdict == Verdict.MEETS and read_back.value < 1e-4
    assert set_angle.value is None and outcomes["backlash"].verdict == Verdict.CANNOT_TELL
    assert node.commands.count(HOME) == 1 and node.commands.count(TURN) == 2 * 9 + 2


def test_an_encoder_that_reads_beside_and_a_wrong_identity_fail(played, tmp_path):
    _gateway, _node, link = played(off_deg=0.05, serial=7)
    path = limits(tmp_path)
    path.write_text(path.read_text().replace("vendor_id = 0", "vendor_id = 0\nserial_number = 8"))
    with session.opened(link, read_limits(str(path)), [], None) as context:
        positions, identity = session.run("positions", context), session.run("link", context)
    assert positions.lines[0].verdict == Verdict.FAILS and positions.lines[0].value == pytest.approx(0.05, rel=1e-3)
    failed = [line for line in identity.lines if line.verdict == Verdict.FAILS]
    assert [(line.name, line.found) for line in failed] == [("serial number", "0x7")]


def test_a_command_that_the_node_refuses_is_a_fault_of_the_stand(played, tmp_path):
    gateway, _node, link = played()
    gateway.tell("refuse 08000022")
    with session.opened(link, read_limits(str(limits(tmp_path))), [], None) as context:
        with pytest.raises(StandFault, match=r"homing: .* the state does not allow it \(0800 0022h\)"):
            context.instrument.home()


def test_a_silent_node_and_a_gateway_that_takes_no_commands(played):
    gateway, _node, link = played("--unlock", 60)
    with pytest.raises(CommunicationError, match="exception 1: it takes no commands unless started with --allow-comm"):
        link.command(HOME)
    gateway.tell("silent 1")
    with pytest.raises(CommunicationError, match="the gateway says: the node is silent"):
        for _ in range(1000):
            link.fresh()


def test_a_serial_line(serve, far_end, tmp_path):
    """modbus-rtu over a pair of pseudo terminals, which have no parity."""
    pytest.importorskip("serial", reason="pyserial is not installed")
    gateway = serve("--allow-commands", parity="N")
    node = PlayedNode(gateway)
    link = open_link(f"modbus-rtu:{far_end},19200,N")
    with session.opened(link, read_limits(str(limits(tmp_path, link__latency_s=1))), [], None) as context:
        assert session.run("link", context).verdict == Verdict.MEETS
        context.instrument.turn(45.0)
        assert context.instrument.angle() == 45.0
    assert node.commands == [HOME, TURN]
