"""Settings of the node through tumble-gateway: every one by its number, exactly as the object has it, or not at all."""

import random
import re
import struct
import time

import pytest
from gateway_bench import (
    ADDRESS,
    BUSY,
    FUNCTION,
    KEYS,
    READ_HOLDING,
    ROOT,
    VALUE,
    register,
    registers,
    wait_until,
)  # fmt: skip
from test_gateway_commands import (
    ACCEPTED,
    ARGUMENT,
    COMMAND,
    EXECUTE,
    OBJECT,
    REFUSED,
    UNANSWERED,
    held,
    mbpoll_write,
    opened,
    result,
    unlocked,
    written,
)  # fmt: skip
from test_gateway_registers import DICTIONARY, example, variable

# Instrumented in any case: no need to run it with everything else once more.
pytestmark = [pytest.mark.slow, pytest.mark.real_time]
SETTING, VALUE_AT = (register(name, "holding")["register"] for name in ("Setting", "Value"))
ROWS = [row for row in registers() if row["table"] == "setting"]
NUMBER = {row["name"]: row["register"] for row in ROWS}
CALENDAR, INHIBIT = NUMBER["Host: Calendar"], NUMBER["Host: Inhibit"]
UNFIT, NO_SERVICE = 5, 6
KEY_OF_SERVICE, SERV = NUMBER["Service level: Key"], 0x76726573
PROTECTED = {number for first, last in
             re.findall(r"^\| (\d+)(?: to (\d+))? \|(?:[^|]*\|){4} service \|$",
                        (ROOT / "docs/modbus.md").read_text(encoding="utf-8"), re.MULTILINE)
             for number in range(int(first), int(last or first) + 1)}
SAVE = 0x65766173
PROPOSAL_AT, SERVICE_KEY_AT = (register(name, "holding")["register"] for name in ("Proposal", "Service key"))
BEHIND = SERVICE_KEY_AT + 2 - OBJECT  # registers from the first to the last that can be staged


def words_of(number):
    """An f64 in four registers, the high word first."""
    return struct.unpack(">4H", struct.pack(">d", number))


def tell(client, number, value, token=1):
    """Stage, execute, wait: (result, abort code)."""
    assert client.write(SETTING, number, *words_of(value)) is None
    assert client.write(EXECUTE, token) is None
    found = result(client)
    assert found[1] == token
    return found[0], found[2]


def open_service(gateway, client, token=1000):
    """The service level, for this session."""
    assert tell(client, KEY_OF_SERVICE, SERV, token) == (ACCEPTED, 0)
    assert written(gateway, 1) == ["write 2006 1 73657276"]  # "serv"


def is_protected(row):
    """By the column of docs/modbus.md."""
    return row["register"] in PROTECTED


def limits(row):
    """Least and greatest of an integer."""
    bits = int(row["type"][1:])
    return (0, (1 << bits) - 1) if row["type"][0] == "u" else (-(1 << bits - 1), (1 << bits - 1) - 1)


def some_numbers(row, draw):
    """That an f64 and the object can both hold."""
    if row["type"][0] == "f":
        return [0.0, -1.5, draw.uniform(-1e-6, 1e6)]
    low, high = limits(row)
    return [low, int(float(high)) if float(high) <= high else high & ~0x7FF, draw.randrange(low, min(high, 1 << 53))]


def test_every_setting_is_written_as_its_object_has_it(start):
    """The EDS file is the witness of types and sizes."""
    gateway, draw = start("--allow-commands"), random.Random(5)
    client, sent = unlocked(gateway), 0
    for row in ROWS:
        for number in some_numbers(row, draw):
            if is_protected(row):
                sent += 1
                open_service(gateway, client, sent)
            sent += 1
            assert tell(client, row["register"], number, sent) == (ACCEPTED, 0), row
            data = variable(row).encode_raw(number)
            assert written(gateway, 1) == [f"write {row['index']:04X} {row['subindex']} {data.hex().upper()}"], row
            assert client.read(SETTING, 5, READ_HOLDING) == (0, *words_of(number))
    assert (
        client.number("Commands sent") == sent == 3 * (len(ROWS) + len(PROTECTED))
        and client.number("Values unfit") == 0
    )
    assert gateway.written.empty() and DICTIONARY[0x1010]


@pytest.mark.parametrize("number", [float("nan"), float("inf"), -float("inf"), 1e300])
def test_no_setting_takes_what_is_no_number_of_its_type(start, number):
    gateway, client = opened(start)
    rows = [row for row in ROWS if row["type"] != "f64" or number != 1e300]
    for count, row in enumerate(rows, 1):
        assert tell(client, row["register"], number, count) == (UNFIT, 0), row
        assert client.number("Values unfit") == count
    assert gateway.written.empty() and client.number("Commands sent") == client.number("Commands refused") == 0


def test_an_integer_takes_no_fraction_and_nothing_beyond_its_type(start):
    gateway, client = opened(start)
    for row in (row for row in ROWS if row["type"][0] != "f"):
        if is_protected(row):
            open_service(gateway, client)
        low, high = limits(row)
        for number in (low - 1, float(high) + 1 if high < 1 << 53 else 2.0**64, 0.5, 1e-9, high / 2 + 0.25):
            wanted = UNFIT if number != int(number) or not low <= number <= high else ACCEPTED
            assert tell(client, row["register"], number) == (wanted, 0), (row, number)
            assert wanted == UNFIT or written(gateway, 1)
    assert gateway.written.empty()
    assert tell(client, INHIBIT, 90) == (ACCEPTED, 0)  # the session goes on
    assert written(gateway, 1) == ["write 2121 2 5A00"]


def test_without_permission_nothing_is_written(start):
    for options, refusals in (((), 1), (("--allow-commands",), 1)):
        gateway = start(*options)
        client = gateway.connect()
        assert client.write(SETTING, CALENDAR, *words_of(1.8e9)) == FUNCTION
        assert client.number("Locked") == refusals and client.read(SETTING, 5, READ_HOLDING) == 5 * (0,)
        assert client.write(EXECUTE, 1) == FUNCTION
        assert gateway.written.empty()


def test_a_number_that_is_no_setting(start):
    gateway, client = opened(start)
    assert client.write(SETTING, CALENDAR) is None
    for number in (6, 10, 13, max(NUMBER.values()) + 1, 65535):
        assert number not in NUMBER.values() and client.write(SETTING, number, *words_of(1.0)) == VALUE
    assert client.read(SETTING, 5, READ_HOLDING) == (CALENDAR, 0, 0, 0, 0)
    assert client.write(SETTING, 0) is None  # none: what is executed is a command again
    assert client.write(COMMAND, 3, 1) is None and result(client)[0] == ACCEPTED
    assert written(gateway, 2) == ["write 2002 1 00", "write 2002 2 03"]


def test_a_setting_is_executed_once_and_what_was_staged_for_a_command_stays(start):
    gateway, client = opened(start)
    angle = struct.unpack(">HH", struct.pack(">i", 9000000))
    assert client.write(OBJECT, 0, 4, *angle, 7) is None
    assert tell(client, INHIBIT, 60) == (ACCEPTED, 0)
    assert client.write(EXECUTE, 2) is None and result(client) == (ACCEPTED, 2, 0)
    assert written(gateway, 4) == ["write 2121 2 3C00", "write 2002 1 04",
                                   f"write 2002 3 {struct.pack('<d', 90.0).hex().upper()}", "write 2002 2 07"]


@pytest.mark.parametrize("value, found", [(60, ACCEPTED), (0.5, UNFIT)])
def test_an_execute_that_is_repeated_after_a_setting_sends_no_command(start, value, found):
    """As by a client that has lost the answer: the setting is no longer staged, but a command still is."""
    gateway, client = opened(start)
    assert client.write(COMMAND, 7, 1) is None and result(client) == (ACCEPTED, 1, 0)
    assert tell(client, INHIBIT, value, 2) == (found, 0)
    for _ in range(2):
        assert client.write(EXECUTE, 2) is None and result(client) == (found, 2, 0)
    assert written(gateway, 2) == ["write 2002 1 00", "write 2002 2 07"]
    assert tell(client, INHIBIT, 90, 2) == (ACCEPTED, 0)  # staged anew
    assert client.write(COMMAND, 8) is None and client.write(EXECUTE, 2) is None and result(client)[0] == ACCEPTED
    settings = ["write 2121 2 3C00"] * (found == ACCEPTED) + ["write 2121 2 5A00"]
    assert written(gateway, len(settings) + 2) == [*settings, "write 2002 1 00", "write 2002 2 08"]


def test_what_was_staged_before_the_lock_closed_is_forgotten(start):
    """Somebody else may be at the same line by then: what he executes is his own."""
    gateway = start("--allow-commands", "--unlock", 1)
    client = unlocked(gateway)
    angle = struct.unpack(">HH", struct.pack(">i", 9000000))
    assert client.write(OBJECT, 0, 4, *angle, 7) is None and client.write(SETTING, INHIBIT, *words_of(60)) is None
    assert client.write(PROPOSAL_AT, 1, 2, 3, 4) is None
    staged = client.read(OBJECT, BEHIND, READ_HOLDING)
    wait_until(lambda: client.number("Access") == 1)
    assert client.read(OBJECT, BEHIND, READ_HOLDING) == staged
    client.unlock()
    assert client.read(OBJECT, BEHIND, READ_HOLDING) == BEHIND * (0,)
    assert client.write(COMMAND, 3, 1) is None and result(client) == (ACCEPTED, 1, 0)
    assert written(gateway, 2) == ["write 2002 1 00", "write 2002 2 03"]
    assert client.write(SETTING, INHIBIT, *words_of(60)) is None
    client.unlock()  # while it is open: that it stays so
    assert client.write(EXECUTE, 2) is None and result(client) == (ACCEPTED, 2, 0)
    assert written(gateway, 1) == ["write 2121 2 3C00"]


def test_all_in_one_request(start):
    gateway = start("--allow-commands")
    client = gateway.connect()
    wait_until(lambda: client.number("Link state") == 1)
    good = [*KEYS, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0, 0, CALENDAR, *words_of(1795000000)]
    for place in (2, *range(EXECUTE + 1, SETTING)):
        wrong = [*good[:place], 1, *good[place + 1 :]]
        assert client.write(0, *wrong) == VALUE and client.number("Access") == 1
    assert gateway.written.empty() and client.read(OBJECT, BEHIND, READ_HOLDING) == BEHIND * (0,)
    assert client.write(0, *good) is None
    assert result(client) == (ACCEPTED, 9, 0)
    assert written(gateway, 1) == ["write 2121 1 " + struct.pack("<Q", 1795000000).hex().upper()]
    assert client.write(EXECUTE, *good[EXECUTE:]) is None and result(client)[0] == ACCEPTED
    for at, words in (
        (EXECUTE + 1, good[EXECUTE + 1 :]),
        (EXECUTE, good[EXECUTE:SETTING]),
        (SETTING, (SERVICE_KEY_AT + 3 - SETTING) * [0]),
    ):
        assert client.write(at, *words) == ADDRESS


def test_a_refusal_of_the_node_is_told(start):
    gateway, client = opened(start)
    open_service(gateway, client)
    gateway.tell("refuse 08000020")
    save = NUMBER["Store parameters: Save all parameters"]
    assert tell(client, save, SAVE - 1) == (REFUSED, 0x08000020)
    assert client.number("Commands refused") == 1 and client.number("Commands sent") == 1
    gateway.tell("refuse 0")
    assert tell(client, save, SAVE) == (ACCEPTED, 0)
    assert written(gateway, 1) == ["write 1010 1 73617665"]  # "save"


def test_a_node_that_falls_silent_over_a_setting(start):
    gateway, client = opened(start)
    with held(gateway):
        assert client.write(SETTING, CALENDAR, *words_of(1.0)) is None and client.write(EXECUTE, 1) is None
        assert client.write(SETTING, INHIBIT) == BUSY
    assert result(client)[0] == ACCEPTED
    gateway.tell("hold 1")
    assert client.write(SETTING, CALENDAR) is None and client.write(EXECUTE, 2) is None
    assert result(client) == (UNANSWERED, 2, 0)
    gateway.tell("hold 0")


def test_the_position_that_is_selected_is_read_at_once(start):
    """And no other value that is kept."""
    gateway, client = opened(start)
    for index, sub, data in ((0x2150, 1, b"\1"), (0x2150, 4, struct.pack("<d", 0.5)), (0x2151, 2, b"\2"),
                             (0x2104, 1, struct.pack("<d", 1.0))):
        gateway.set(index, sub, data)
    gateway.wait_fresh(client)
    for index, sub, data in ((0x2150, 4, struct.pack("<d", 0.75)), (0x2151, 2, b"\4"),
                             (0x2104, 1, struct.pack("<d", 2.0))):
        gateway.set(index, sub, data, boot=False)
    gateway.wait_fresh(client)
    names = ("Position: Position index", "Position: Mean y", "Schedule: Mounting number", "Active set: K: K_xx")
    assert [client.number(name) for name in names] == [1, 0.5, 2, 1.0]  # nothing told of them
    assert tell(client, NUMBER["Position: Position index"], 1) == (ACCEPTED, 0)
    gateway.wait_fresh(client)
    assert [client.number(name) for name in names] == [1, 0.75, 4, 1.0]
    assert client.number("Position: Mean y", scaled=True) == 0.75


def test_pymodbus_tells_the_calendar_and_saves(start):
    client_module = pytest.importorskip("pymodbus.client", reason="pymodbus is not installed")
    gateway = start("--allow-commands")
    gateway.wait_fresh()
    with client_module.ModbusTcpClient("127.0.0.1", port=gateway.port) as client:
        def executed(number, value, token):
            words = client.convert_to_registers(float(value), client.DATATYPE.FLOAT64, word_order="big")
            answers = [client.write_registers(0, list(KEYS), device_id=1),
                       client.write_registers(SETTING, [number, *words], device_id=1),
                       client.write_register(EXECUTE, token, device_id=1)]
            assert not any(answer.isError() for answer in answers)
            at = register("Result", "holding")["register"]
            wait_until(lambda: client.read_holding_registers(at, count=2, device_id=1).registers == [ACCEPTED, token])

        executed(CALENDAR, 1795252800, 5)
        executed(NUMBER["Recalibration: Gravity"], 9.81234, 6)
        executed(KEY_OF_SERVICE, SERV, 8)
        executed(NUMBER["Store parameters: Save all parameters"], SAVE, 7)
    data = struct.pack("<d", 9.81234).hex().upper()
    assert written(gateway, 5) == ["write 2121 1 4062016B00000000", f"write 2122 1 {data}", "write 2006 1 73657276",
                                   "write 1010 1 73617665", "write 2006 1 00000000"]  # the connection is closed


def test_mbpoll_tells_the_calendar_in_one_request(start):
    gateway = start("--allow-commands")
    gateway.wait_fresh()
    staged = [0, 0, 0, 0, 0, 1, 0, 0, 0, 0]  # from the command object to Execute, and what cannot be written
    assert mbpoll_write(gateway, 0, *KEYS, 0, *staged, CALENDAR, *words_of(1795252800)) == ""
    assert mbpoll_write(gateway, 0, *KEYS, 0, *staged, INHIBIT, *words_of(600)) == ""
    assert written(gateway, 2) == ["write 2121 1 4062016B00000000", "write 2121 2 5802"]
    assert "Illegal function" in mbpoll_write(gateway, SETTING, INHIBIT)
    assert ARGUMENT == OBJECT + 1 and gateway.written.empty()


def test_the_examples_of_the_page(start):
    pytest.importorskip("pymodbus.client", reason="pymodbus is not installed")
    gateway, before = start("--allow-commands"), int(time.time())
    gateway.wait_fresh()
    assert example(gateway, 1) == (0, "the calendar is set\n", "")
    [line] = written(gateway, 1)
    told = struct.unpack("<Q", bytes.fromhex(line.removeprefix("write 2121 1 ")))[0]
    assert before <= told <= time.time()
    page = (ROOT / "docs/gateway.md").read_text(encoding="utf-8")
    words = re.search(r"^    mbpoll .* -r 0 127.0.0.1 (20304 .* 12 \d+ \d+ 0 0)$", page, re.MULTILINE)[1].split()
    assert mbpoll_write(gateway, 0, *words) == "" and written(gateway, 1) == ["write 2121 2 5802"]
    gateway.tell("refuse 08000022")
    assert example(gateway, 1) == (0, "result 3\n", "")


def test_the_service_level_ends_with_the_lock_and_by_the_key_0(start):
    gateway = start("--allow-commands")
    client, limit = unlocked(gateway), NUMBER["Commit rules: Flags"]
    open_service(gateway, client)
    assert tell(client, KEY_OF_SERVICE, 0) == (ACCEPTED, 0) and written(gateway, 1) == ["write 2006 1 00000000"]
    assert tell(client, limit, 1) == (NO_SERVICE, 0)
    open_service(gateway, client)
    assert client.write(0, 1, 2) == VALUE  # other keys lock
    assert written(gateway, 1) == ["write 2006 1 00000000"]
    client.unlock()
    assert tell(client, limit, 1) == (NO_SERVICE, 0)
    gateway.tell("refuse 06090030")
    assert tell(client, KEY_OF_SERVICE, SERV + 1) == (REFUSED, 0x06090030)  # the node's to say
    gateway.tell("refuse 0")
    assert tell(client, limit, 1) == (NO_SERVICE, 0) and gateway.written.empty()


def test_without_permission_there_is_no_service_level(start):
    gateway = start()
    client = gateway.connect()
    assert client.write(SETTING, KEY_OF_SERVICE, *words_of(SERV)) == FUNCTION
    assert client.write(SERVICE_KEY_AT, 0x7672, 0x6573) == FUNCTION
    gateway = start("--allow-commands")
    client = gateway.connect()
    assert client.write(SETTING, KEY_OF_SERVICE, *words_of(SERV)) == FUNCTION and gateway.written.empty()


def test_mbpoll_writes_a_protected_setting_in_one_request(start):
    """The key goes first, and the level ends with the connection."""
    gateway = start("--allow-commands")
    gateway.wait_fresh()
    staged = [0, 0, 0, 0, 0, 1, 0, 0, 0, 0]
    limit = [NUMBER["Configuration: Gravity limit"], *words_of(1e-3)]
    assert mbpoll_write(gateway, 0, *KEYS, 0, *staged, *limit, 0, 0, 0x7672, 0x6573) == ""
    assert written(gateway, 3) == ["write 2006 1 73657276", "write 2050 5 " + struct.pack("<d", 1e-3).hex().upper(),
                                   "write 2006 1 00000000"]
    assert mbpoll_write(gateway, 0, *KEYS, 0, *staged, *limit) == ""
    time.sleep(0.2)
    assert gateway.written.empty()


def test_accept_names_its_proposal(start):
    gateway, client = opened(start)
    assert client.write(PROPOSAL_AT, 0xFEDC, 0xBA98) is None
    assert client.write(COMMAND, 9, 1) is None and result(client) == (ACCEPTED, 1, 0)
    assert written(gateway, 3) == ["write 2002 1 00", "write 2002 4 98BADCFE", "write 2002 2 09"]
    assert client.write(COMMAND, 9, 2) is None and result(client) == (ACCEPTED, 2, 0)  # not named again
    assert written(gateway, 2) == ["write 2002 1 00", "write 2002 2 09"]
