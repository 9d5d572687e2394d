"""python-canopen as master and as slave beside our nodes: NMT, heartbeat, EMCY, PDO mapping, and our own SDO client."""

import struct

import pytest
from canopen_bridge import canopen, program, start  # noqa: F401
from simulated_bench import wait_until

pytestmark = pytest.mark.real_time

datatypes = canopen.objectdictionary.datatypes


def test_nmt_boot_up_and_heartbeats(start):
    ours = start("drive")
    ours.bus.let_pass(99)
    assert ours.bus.log == ["702#00"]
    ours.bus.let_pass(1)
    assert ours.bus.log == ["702#00", "702#7F"]
    for state, byte in (("OPERATIONAL", "05"), ("STOPPED", "04"), ("PRE-OPERATIONAL", "7F")):
        ours.node.nmt.state = state
        ours.bus.let_pass(100)
        assert ours.bus.log[-1] == f"702#{byte}"
        wait_until(lambda wanted=state: ours.node.nmt.state == wanted)
    ours.node.sdo["Homing method"].raw = 17
    before = ours.bus.log.count("702#00")
    ours.node.nmt.state = "RESET"
    ours.bus.let_pass(0)
    assert ours.bus.log.count("702#00") == before + 1
    assert ours.node.sdo["Homing method"].raw == 35


def test_heartbeat_time_is_what_was_written(start):
    ours = start("drive")
    ours.node.sdo["Producer heartbeat time"].raw = 20
    before = ours.bus.log.count("702#7F")
    ours.bus.let_pass(500)
    assert ours.bus.log.count("702#7F") - before == 25


def test_a_silent_master_is_noticed(start):
    """The drive watches node 1: while python-canopen beats for it nothing happens, then the emergency comes."""
    ours = start("drive")
    ours.node.nmt.state = "OPERATIONAL"
    for _ in range(10):
        ours.network.send_message(0x701, b"\x05")
        ours.bus.let_pass(499)
    assert not [line for line in ours.bus.log if line.startswith("082#")]
    assert ours.bus.log[-1] == "702#05"
    ours.bus.let_pass(101)
    wait_until(lambda: ours.node.emcy.log)
    error = ours.node.emcy.log[0]
    assert (error.code, error.register, error.data) == (0x8130, 0x11, b"\x01\0\0\0\0")
    assert ours.bus.log[-1] == "702#7F"
    ours.network.send_message(0x701, b"\x05")
    wait_until(lambda: len(ours.node.emcy.log) == 2)
    assert ours.node.emcy.log[1].code == 0


def test_emergencies_and_their_history(start):
    ours = start("drive")
    ours.bus.tell("!emcy 8611 20")
    wait_until(lambda: ours.node.emcy.log)
    error = ours.node.emcy.log[0]
    assert error.code == 0x8611 and (error.register, error.data) == (0x21, b"\1\2\3\4\5")
    assert ours.node.sdo["Error register"].raw == 0x21
    assert ours.node.sdo[0x1003][1].raw == 0x02018611
    ours.bus.tell("!clear 20")
    wait_until(lambda: ours.node.emcy.active == [])
    ours.node.sdo[0x1003][0].raw = 0
    assert ours.node.sdo[0x1003][0].raw == 0


def configure_pdos(ours):
    """The sequence of CiA 301 as python-canopen writes it."""
    node = ours.node
    node.tpdo.read()
    node.rpdo.read()
    assert [variable.name for variable in node.tpdo[1].map] == ["Statusword"]
    assert [variable.name for variable in node.rpdo[1].map] == ["Controlword"]
    node.tpdo[1].clear()
    node.tpdo[1].add_variable("Statusword")
    node.tpdo[1].add_variable("Position actual value")
    node.tpdo[1].trans_type = 254
    node.tpdo[1].event_timer = 20
    node.tpdo[1].enabled = True
    node.rpdo[1].clear()
    node.rpdo[1].add_variable("Modes of operation")
    node.rpdo[1].add_variable("Controlword")
    node.rpdo[1].add_variable("Target position")
    node.rpdo[1].enabled = True
    node.tpdo.save()
    node.rpdo.save()


def test_pdo_mapping_written_by_sdo(start):
    ours = start("drive")
    configure_pdos(ours)
    node = ours.node
    assert node.sdo[0x1A00][0].raw == 2
    assert node.sdo[0x1A00][2].raw == 0x60640020
    assert node.sdo[0x1600][0].raw == 3
    received = []
    node.tpdo[1].add_callback(lambda pdo: received.append([variable.raw for variable in pdo]))
    ours.bus.let_pass(1000)
    assert not [line for line in ours.bus.log if line.startswith("182#")]  # not before Operational
    node.nmt.state = "OPERATIONAL"
    ours.bus.let_pass(100)
    wait_until(lambda: len(received) == 6)  # at once, and by the event timer
    assert received[0] == [0, 0]
    node.rpdo[1]["Modes of operation"].raw = 6
    node.rpdo[1]["Controlword"].raw = 0x000F
    node.rpdo[1]["Target position"].raw = -123456
    node.rpdo[1].transmit()
    wait_until(lambda: node.sdo["Target position"].raw == -123456)
    assert node.sdo["Controlword"].raw == 0x000F
    assert node.sdo["Modes of operation"].raw == 6


def test_a_short_pdo_is_an_emergency(start):
    ours = start("drive")
    configure_pdos(ours)
    ours.node.nmt.state = "OPERATIONAL"
    ours.network.send_message(0x202, b"\x06\x0F")
    wait_until(lambda: ours.node.emcy.log)
    assert ours.node.emcy.log[0].code == 0x8210
    assert ours.node.sdo["Controlword"].raw == 0


def test_synchronous_pdos_are_refused(start):
    ours = start("drive")
    for kind in (0, 1, 240, 252, 253):
        assert ours.refusal_of_raw(ours.node.sdo[0x1800][2], kind) == 0x06090030


def test_a_full_send_queue_loses_no_answer(start):
    ours = start("block")
    for busy in (1, 2, 5):
        ours.bus.tell(f"!busy {busy}")
        assert ours.node.sdo["Sample rate"].raw == 100


# Our client, python-canopen as the server.

SERVER = 10


@pytest.fixture
def server(start):
    """python-canopen's LocalNode with objects of several kinds, on the bus of our block."""
    dictionary = canopen.ObjectDictionary()
    for index, kind, access, value in (
        (0x1017, datatypes.UNSIGNED16, "rw", 0),
        (0x2000, datatypes.UNSIGNED8, "rw", 1),
        (0x2001, datatypes.UNSIGNED16, "rw", 2),
        (0x2002, datatypes.UNSIGNED32, "rw", 3),
        (0x2003, datatypes.REAL64, "rw", 0.5),
        (0x2004, datatypes.VISIBLE_STRING, "rw", "a text of some length, in segments"),
        (0x2005, datatypes.UNSIGNED16, "ro", 7),
        (0x2006, datatypes.UNSIGNED16, "wo", 0),
    ):
        variable = canopen.objectdictionary.ODVariable(f"Object {index:04X}", index)
        variable.data_type, variable.access_type, variable.default = kind, access, value
        dictionary.add_object(variable)
    ours = start("block")
    local = ours.network.create_node(SERVER, dictionary)
    return ours.bus, local


def test_our_client_reads(server):
    bus, _ = server
    assert bus.transfer(f"!read {SERVER} 2000 0 8") == ("TUMBLE_OK", 0, b"\x01")
    assert bus.transfer(f"!read {SERVER} 2001 0 8") == ("TUMBLE_OK", 0, b"\x02\x00")
    assert bus.transfer(f"!read {SERVER} 2002 0 8") == ("TUMBLE_OK", 0, b"\x03\x00\x00\x00")
    assert bus.transfer(f"!read {SERVER} 2003 0 8") == ("TUMBLE_OK", 0, struct.pack("<d", 0.5))
    text = b"a text of some length, in segments"
    assert bus.transfer(f"!read {SERVER} 2004 0 64") == ("TUMBLE_OK", 0, text)
    assert bus.transfer(f"!read {SERVER} 2004 0 {len(text)}") == ("TUMBLE_OK", 0, text)
    assert bus.transfer(f"!read {SERVER} 2004 0 {len(text) - 1}")[:2] == ("TUMBLE_E_SDO_ABORTED", 0x05040005)


def test_our_client_writes(server):
    bus, local = server
    assert bus.transfer(f"!write {SERVER} 2000 0 7F")[:2] == ("TUMBLE_OK", 0)
    assert bus.transfer(f"!write {SERVER} 2002 0 78563412")[:2] == ("TUMBLE_OK", 0)
    assert bus.transfer(f"!write {SERVER} 2003 0 {struct.pack('<d', -1.25).hex()}")[:2] == ("TUMBLE_OK", 0)
    for length in range(1, 60):
        text = bytes(65 + (i + length) % 26 for i in range(length))
        assert bus.transfer(f"!write {SERVER} 2004 0 {text.hex()}")[:2] == ("TUMBLE_OK", 0)
        assert bytes(local.get_data(0x2004, 0)) == text
    assert local.sdo[0x2000].raw == 0x7F
    assert local.sdo[0x2002].raw == 0x12345678
    assert local.sdo[0x2003].raw == -1.25


def test_our_client_is_refused(server):
    bus, _ = server
    assert bus.transfer(f"!read {SERVER} 3000 0 8")[:2] == ("TUMBLE_E_SDO_ABORTED", 0x06020000)
    assert bus.transfer(f"!read {SERVER} 2006 0 8")[:2] == ("TUMBLE_E_SDO_ABORTED", 0x06010001)
    assert bus.transfer(f"!write {SERVER} 2005 0 0100")[:2] == ("TUMBLE_E_SDO_ABORTED", 0x06010002)
    assert bus.transfer("!read 99 2000 0 8", ms=500)[:2] == ("TUMBLE_E_SDO_TIMEOUT", 0x05040000)
    assert bus.transfer(f"!read {SERVER} 2000 0 8")[0] == "TUMBLE_OK"


def test_our_master_starts_another_node(server):
    bus, local = server
    local.nmt.state = "PRE-OPERATIONAL"
    bus.tell(f"!start {SERVER}")
    wait_until(lambda: local.nmt.state == "OPERATIONAL")
