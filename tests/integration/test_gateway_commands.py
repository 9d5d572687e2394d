"""Commands through tumble-gateway: only where allowed, only in an unlocked session, staged, with a result."""

import struct
import subprocess
import time
from contextlib import contextmanager

import pytest
from gateway_bench import (
    ADDRESS,
    BUSY,
    FUNCTION,
    KEYS,
    READ_HOLDING,
    TARGET,
    VALUE,
    WRITE_ONE,
    end_of,
    register,
    wait_until,
)  # fmt: skip
from test_gateway_registers import mbpoll

# Instrumented in any case: no need to run it with everything else once more.
pytestmark = [pytest.mark.slow, pytest.mark.real_time]
OBJECT, ARGUMENT, ANGLE, COMMAND, EXECUTE = (
    register(name, "holding")["register"] for name in ("Command object", "Argument", "Angle", "Command", "Execute")
)
PENDING, ACCEPTED, REFUSED, UNANSWERED = 1, 2, 3, 4


def unlocked(gateway):
    """A session that may command, once the node has answered."""
    client = gateway.connect()
    wait_until(lambda: client.number("Link state") == 1)
    client.unlock()
    return client


def opened(start):
    """A gateway that may write, and a session that may command."""
    gateway = start("--allow-commands")
    return gateway, unlocked(gateway)


def result(client):
    """(result, what it is of, abort code), once there is one."""
    wait_until(lambda: client.number("Result", "holding") != PENDING)
    return tuple(client.number(name, "holding") for name in ("Result", "Result of", "Abort code"))


@contextmanager
def held(gateway):
    """The node answers no write meanwhile; longer than an SDO client waits would be another test."""
    gateway.tell("hold 1")
    began = time.monotonic()
    yield
    gateway.tell("hold 0")
    if time.monotonic() - began > 0.4:
        pytest.skip("this machine is too busy to do it within the time of an SDO answer")


def written(gateway, count):
    return [gateway.written.get(timeout=5) for _ in range(count)]


def test_without_being_allowed_nothing_is_written(start):
    gateway = start()
    client = gateway.connect()
    assert " read only" in gateway.line
    for at, words in ((0, KEYS), (ARGUMENT, (1,)), (EXECUTE, (1,))):
        assert client.write(at, *words) == FUNCTION
    assert client.ask(struct.pack(">BHH", WRITE_ONE, EXECUTE, 1)) == b"\x86\1"
    assert client.number("Access") == 0 and client.number("Locked") == 4
    assert gateway.written.empty()


def test_locked_until_unlocked(start):
    gateway = start("--allow-commands")
    client = gateway.connect()
    assert client.number("Access") == 1
    assert client.write(OBJECT, 0, 0, 0, 0, 1, 1) == FUNCTION
    assert client.number("Locked") == 1
    client.unlock()
    assert client.number("Access") == 3 and client.number("Unlocked for", "holding") == 60
    assert client.read(0, 2, READ_HOLDING) == (0, 0)
    assert gateway.written.empty()


@pytest.mark.parametrize("keys", [(0, 0), KEYS[::-1], (KEYS[0], 0), (0, KEYS[1])])
def test_other_keys_lock(start, keys):
    client = start("--allow-commands").connect()
    client.unlock()
    assert client.write(0, *keys) == VALUE
    assert client.number("Access") == 1 and client.number("Wrong keys") == 1


def test_the_keys_must_come_in_one_request(start):
    client = start("--allow-commands").connect()
    for at in (0, 1):
        assert client.ask(struct.pack(">BHH", WRITE_ONE, at, KEYS[at])) == b"\x86\2"
    assert client.write(0, *KEYS, 0) == ADDRESS
    assert client.number("Access") == 1 and client.number("Wrong address") == 3


def test_the_lock_is_the_sessions_own_and_closes_by_itself(start):
    gateway = start("--allow-commands", "--unlock", 1)
    one, other = unlocked(gateway), gateway.connect()
    assert other.number("Access") == 1 and other.write(ARGUMENT, 1) == FUNCTION
    for _ in range(4):  # each write keeps it open
        time.sleep(0.5)
        assert one.write(ARGUMENT, 1) is None
    wait_until(lambda: one.number("Access") == 1, timeout=2)
    assert one.write(ARGUMENT, 1) == FUNCTION
    one.unlock()
    one.close()
    again = gateway.connect()
    assert again.number("Access") == 1


def test_a_command_goes_to_the_node(start):
    gateway, client = opened(start)
    assert client.write(ARGUMENT, 7) is None and client.write(COMMAND, 3) is None
    assert gateway.written.empty() and client.read(ARGUMENT, 1, READ_HOLDING) == (7,)
    assert client.write(EXECUTE, 99) is None
    assert result(client) == (ACCEPTED, 99, 0)
    assert written(gateway, 2) == ["write 2002 1 07", "write 2002 2 03"]
    assert client.write(OBJECT, 0, 1, 0, 0, 2, 100) is None  # all in one: an angle of 0 is staged as well
    assert result(client) == (ACCEPTED, 100, 0)
    assert written(gateway, 3) == ["write 2002 1 01", "write 2002 3 0000000000000000", "write 2002 2 02"]
    assert client.number("Commands sent") == 2
    assert gateway.written.empty()


@pytest.mark.parametrize("units", [0, 1, -1, 12345678, -36000000])
def test_an_angle_goes_with_one_command(start, units):
    gateway, client = opened(start)
    assert client.write(ANGLE, *struct.unpack(">HH", struct.pack(">i", units))) is None
    assert client.number("Angle", "holding") == units * 1e-5
    for token in (1, 2):
        assert client.write(COMMAND, 9, token) is None
        assert result(client)[0] == ACCEPTED
    angle = struct.pack("<d", units / 1e5).hex().upper()
    assert written(gateway, 5) == ["write 2002 1 00", f"write 2002 3 {angle}", "write 2002 2 09",
                                   "write 2002 1 00", "write 2002 2 09"]


def test_a_refusal_of_the_node_is_told(start):
    gateway = start("--allow-commands")
    gateway.tell("refuse 08000022")
    client = unlocked(gateway)
    assert client.write(COMMAND, 1, 5) is None
    assert result(client) == (REFUSED, 5, 0x08000022)
    assert client.number("Commands refused") == 1
    gateway.tell("refuse 0")
    assert client.write(EXECUTE, 6) is None
    assert result(client) == (ACCEPTED, 6, 0)


@pytest.mark.parametrize("words, at", [((256,), ARGUMENT), ((256,), COMMAND), ((0,), EXECUTE), ((1,), OBJECT),
                                       ((5, 0, 0, 256, 1), ARGUMENT), ((5, 0, 0, 1, 0), ARGUMENT)])
def test_numbers_out_of_range_change_nothing(start, words, at):
    gateway, client = opened(start)
    before = client.read(OBJECT, EXECUTE - OBJECT + 1, READ_HOLDING)
    assert client.write(at, *words) == VALUE
    assert client.read(OBJECT, EXECUTE - OBJECT + 1, READ_HOLDING) == before
    assert client.number("Result", "holding") == 0 and gateway.written.empty()


def test_registers_that_cannot_be_written(start):
    client = unlocked(start("--allow-commands"))
    for at, count in ((2, 1), (2, 2), (EXECUTE, 2), (EXECUTE + 1, 1), (EXECUTE + 4, 2), (1, 3), (COMMAND, 4)):
        assert client.write(at, *[1] * count) == ADDRESS, at
    assert client.write(end_of("holding"), 1) == ADDRESS
    assert client.write(65535, 1) == ADDRESS


def test_a_silent_node_gets_no_commands(start):
    gateway, client = opened(start)
    gateway.tell("silent 1")
    wait_until(lambda: client.number("Link state") == 2)
    assert client.write(COMMAND, 1, 5) == TARGET
    assert client.read(COMMAND, 2, READ_HOLDING) == (0, 0)  # nothing of it was staged
    gateway.tell("down 1")
    wait_until(lambda: client.number("Link state") == 3)
    assert client.write(COMMAND, 1, 5) == TARGET
    assert gateway.written.empty()


def test_a_node_that_falls_silent_over_a_command(start):
    gateway = start("--allow-commands")
    client, other = unlocked(gateway), gateway.connect()
    gateway.tell("hold 1")
    assert client.write(COMMAND, 1, 5) is None
    assert client.number("Result", "holding") == PENDING
    assert client.write(COMMAND, 2, 6) == BUSY and client.write(ARGUMENT, 2) == BUSY
    assert client.write(0, *KEYS) is None
    other.unlock()
    assert other.write(COMMAND, 3, 8) is None  # waits behind it
    assert result(client) == (UNANSWERED, 5, 0)
    assert client.number("Commands unanswered") >= 1
    gateway.tell("hold 0")
    assert result(other)[0] in (ACCEPTED, UNANSWERED)


def test_commands_of_several_sessions_wait_for_each_other(start):
    gateway = start("--allow-commands")
    clients = [unlocked(gateway) for _ in range(10)]
    with held(gateway):
        for number, client in enumerate(clients):
            assert client.write(ARGUMENT, number, 0, 0, 20 + number, 1) is None
    assert [result(client)[0] for client in clients] == 10 * [ACCEPTED]
    lines = [line for line in written(gateway, 30) if not line.startswith("write 2002 3")]
    assert lines == [f"write 2002 {at} {byte:02X}" for number in range(10)
                     for at, byte in ((1, number), (2, 20 + number))]


def test_the_command_of_a_session_that_has_gone_is_sent(start):
    """What was accepted counts; and whoever comes into its place is not told its result."""
    gateway = start("--allow-commands")
    first, second, third = (unlocked(gateway) for _ in range(3))
    with held(gateway):
        for number, client in enumerate((first, second, third)):
            assert client.write(ARGUMENT, number) is None and client.write(COMMAND, 20 + number, 1) is None
        first.close()
        second.close()
        wait_until(lambda: third.number("Clients") == 1)
        newcomers = [gateway.connect() for _ in range(2)]
    assert result(third)[0] == ACCEPTED
    assert [client.number("Result", "holding") for client in newcomers] == [0, 0]
    assert written(gateway, 6) == [f"write 2002 {at} {byte}" for number in range(3)
                                   for at, byte in ((1, f"{number:02X}"), (2, f"{20 + number:02X}"))]


def test_more_commands_than_may_wait(start):
    gateway = start("--allow-commands")
    waiting = unlocked(gateway)
    gateway.tell("hold 1")
    answers = []
    for number in range(40):
        client = gateway.connect()
        answers.append(client.write(0, *KEYS, 0, 0, number, 0, 0, 1, 1))
        client.close()
    assert answers[:33] == 33 * [None] and BUSY in answers and set(answers) == {None, BUSY}
    gateway.tell("hold 0")
    wait_until(lambda: waiting.number("Commands sent") + waiting.number("Commands unanswered") == answers.count(None))


def test_pymodbus_commands(start):
    client_module = pytest.importorskip("pymodbus.client", reason="pymodbus is not installed")
    gateway = start("--allow-commands")
    gateway.wait_fresh()
    with client_module.ModbusTcpClient("127.0.0.1", port=gateway.port) as client:
        assert client.write_register(ARGUMENT, 1, device_id=1).exception_code == FUNCTION
        assert not client.write_registers(0, list(KEYS), device_id=1).isError()
        assert not client.write_register(ARGUMENT, 1, device_id=1).isError()
        assert not client.write_registers(COMMAND, [3, 77], device_id=1).isError()
        at = register("Result", "holding")["register"]
        wait_until(lambda: client.read_holding_registers(at, count=2, device_id=1).registers == [ACCEPTED, 77])
    assert written(gateway, 2) == ["write 2002 1 01", "write 2002 2 03"]


def mbpoll_write(gateway, at, *numbers):
    """What mbpoll says; empty: it was done."""
    command = ["mbpoll", "-m", "tcp", "-p", gateway.port, "-a", 1, "-0", "-1", "-q", "-t", "4", "-r", at, "127.0.0.1"]
    done = subprocess.run(list(map(str, (*command, *numbers))), capture_output=True, text=True, timeout=20)
    return done.stderr.strip() + "".join(line for line in done.stdout.splitlines() if "failed" in line)


def test_mbpoll_commands_in_one_request(start):
    """It connects anew each time: what it unlocks ends with the connection."""
    gateway = start("--allow-commands")
    gateway.wait_fresh()
    assert mbpoll(gateway, "-t", "4", "-r", 2, "-c", 1) == {2: "0"}
    assert mbpoll_write(gateway, 0, *KEYS) == ""
    assert "Illegal function" in mbpoll_write(gateway, ARGUMENT, 1)
    assert gateway.written.empty()
    assert mbpoll_write(gateway, 0, *KEYS, 0, 0, 4, 0, 0, 5, 1) == ""
    assert written(gateway, 3) == ["write 2002 1 04", "write 2002 3 0000000000000000", "write 2002 2 05"]


@pytest.mark.parametrize("words, wrong", [
    ((*KEYS, 1, 0, 4), VALUE), ((*KEYS, 0, 0, 256), VALUE), ((*KEYS, 0, 7), VALUE), ((1, 2, 0, 0, 4), VALUE),
    ((*KEYS, *7 * [0], 1), ADDRESS),
])  # fmt: skip
def test_keys_and_more_in_one_request_are_all_or_nothing(start, words, wrong):
    client = start("--allow-commands").connect()
    assert client.write(0, *words) == wrong
    assert client.number("Access") == 1 and client.read(2, 7, READ_HOLDING) == 7 * (0,)
