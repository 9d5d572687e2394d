"""The log of tumble-gateway: a line for each client, command, refusal, change of the link and of the node."""

import fcntl
import os
import re
import struct
import subprocess
from contextlib import contextmanager

import documents
import pytest
from gateway_bench import (
    ADDRESS,
    BUSY,
    FUNCTION,
    GOOD,
    GOOD_ANSWER,
    KEYS,
    ROOT,
    TARGET,
    VALUE,
    WRITE_SEVERAL,
    Raw,
    frame,
    register,
)  # fmt: skip
from simulated_bench import wait_until
from test_gateway_commands import ACCEPTED, REFUSED, UNANSWERED, result, unlocked

# Instrumented in any case: no need to run it with everything else once more.
pytestmark = [pytest.mark.slow, pytest.mark.real_time]
COMMAND, SETTING, EXECUTE = (register(name, "holding")["register"] for name in ("Command", "Setting", "Execute"))
UNFIT, NO_SERVICE = 5, 6
PAGE = (ROOT / "docs/operations.md").read_text(encoding="utf-8")


@pytest.fixture
def logged(launch):
    """Start a gateway with a log; its lines are to be read in the end."""
    return lambda *options, form="json": launch("--poll", 50, "--log", form, *options)


def lines(gateway):
    """All that it has told, after it was ended well."""
    code, rest = gateway.end()
    assert code == 0, rest
    found = [documents.valid(line, "log") for line in [gateway.line, *rest.splitlines()]]
    assert all(line["program"] == "tumble-gateway" for line in found)
    return found


def told(found, *events):
    """(event, level, message) of these events; none: of all but those of the node's link."""
    return [(line["event"], line["level"], line["message"]) for line in found
            if line["event"] in events or (not events and line["event"] != "link")]


def u16(number):
    return struct.pack("<H", number)


def u32(number):
    return struct.pack("<I", number)


def wait_link(client, state):
    """Until the gateway has seen that, and told it."""
    wait_until(lambda: client.number("Link state") == state)


def test_clients_come_and_go(logged):
    gateway = logged()
    first = gateway.connect()
    first.number("Clients")
    second = gateway.connect(source="127.0.0.2")
    second.number("Clients")
    second.close()
    wait_until(lambda: first.number("Clients") == 1)
    first.send(b"\0\0\0\0\xff\xff\1")
    assert first.receive() == b""
    last = gateway.connect()
    last.number("Clients")
    found = lines(gateway)
    assert told(found)[1:] == [
        ("connected", "info", "client 127.0.0.1 connected, 1 in all"),
        ("connected", "info", "client 127.0.0.2 connected, 2 in all"),
        ("disconnected", "info", "client 127.0.0.2 disconnected, by itself; 1 left"),
        ("disconnected", "info", "client 127.0.0.1 disconnected, broken off, or it speaks no Modbus; 0 left"),
        ("connected", "info", "client 127.0.0.1 connected, 1 in all"),
        ("disconnected", "info", "client 127.0.0.1 disconnected, the gateway ends; 0 left"),
        ("end", "notice", "ends with exit code 0"),
    ]
    assert (found[0]["event"], found[0]["access"], found[0]["interface"]) == ("ready", "read only", "played")
    assert re.fullmatch(r"node 1 on played, unit 1 at 127\.0\.0\.1:\d+, read only", found[0]["message"])


def test_a_client_that_is_silent(logged):
    gateway = logged("--idle", 1)
    assert gateway.connect().receive(timeout=60.0) == b""
    assert told(lines(gateway), "connected", "disconnected") == [
        ("connected", "info", "client 127.0.0.1 connected, 1 in all"),
        ("disconnected", "info", "client 127.0.0.1 disconnected, silent for too long; 0 left"),
    ]


def test_commands_and_what_came_of_them(logged):
    gateway = logged("--allow-commands")
    client = unlocked(gateway)

    def execute(number, *staged):
        assert client.write(COMMAND, *staged, number) is None
        return result(client)[0]

    def setting(number, row, value):
        words = struct.unpack(">4H", struct.pack(">d", value))
        assert client.write(SETTING, register(row, "setting")["register"], *words) is None
        assert client.write(EXECUTE, number) is None
        return result(client)[0]

    assert execute(1, 1) == ACCEPTED
    gateway.tell("refuse 8000022")
    assert execute(2, 9) == REFUSED
    gateway.tell("refuse 0")
    assert setting(3, "Recalibration: Temperature samples", 0.5) == UNFIT
    assert setting(4, "Commit rules: Coverage", 3.0) == NO_SERVICE
    gateway.tell("hold 1")
    assert execute(5, 2) == UNANSWERED
    assert client.write(0, 1, 2) == VALUE
    assert client.write(COMMAND, 1) == FUNCTION
    who = "127.0.0.1: "
    assert told(lines(gateway), "unlock", "lock", "command", "refused") == [
        ("unlock", "notice", who + "the session is unlocked"),
        ("command", "notice", who + "TUMBLE_COMMAND_START (1) accepted"),
        ("refused", "warning", who + "TUMBLE_COMMAND_ACCEPT (9) refused by the node, abort code 08000022h"),
        ("refused", "warning", who + "setting 2122h:4 not sent: the object cannot hold the value"),
        ("refused", "warning", who + "setting 2123h:1 not sent: it needs the service level"),
        ("refused", "warning", who + "TUMBLE_COMMAND_ABORT (2) not answered by the node"),
        ("refused", "warning", who + "wrong keys"),
        ("lock", "info", who + "the session is locked"),
        ("refused", "warning", who + "writing refused, the session is locked or commands are not allowed"),
    ]


def test_the_node_as_its_snapshots_show_it(logged):
    """What was so at first is told as a state, and is no verdict; then what changes. Silence, and an interface that is
    down."""
    gateway = logged()
    client = gateway.connect()
    gateway.set_all({
        (0x2000, 0): b"\5", (0x2001, 0): b"\0", (0x2003, 1): b"\2", (0x2003, 2): b"\x12", (0x2003, 3): b"\2",
        (0x2003, 4): b"\1", (0x2003, 5): b"\3", (0x2004, 1): b"\5", (0x2004, 3): u16(0x7500),
        (0x2120, 2): u32(4), (0x2120, 6): u16(0x40), (0x2120, 7): b"\3",
    })  # fmt: skip
    gateway.wait_fresh(client)
    gateway.set_all({(0x2000, 0): b"\x0d", (0x2001, 0): b"\7"})
    gateway.wait_fresh(client)
    gateway.set_all({(0x2120, 2): u32(5), (0x2120, 7): b"\5"})
    gateway.wait_fresh(client)
    gateway.tell("silent 1")
    wait_link(client, 2)
    gateway.tell("down 1")
    wait_link(client, 3)
    found = lines(gateway)
    assert ("state", "info", "TUMBLE_STATE_MOVE at position 1.3, 2 of 18 finished: turning the table") in told(found)
    [fault] = [line for line in found if line["event"] == "fault"]
    row = re.search(r"`TUMBLE_REASON_DRIVE_FAULT` \| (.*) \|", PAGE)[1]
    assert (fault["reason_number"], fault["drive_code"], fault["remedy"]) == (7, 0x7500, row)
    assert fault["state"] == "TUMBLE_STATE_MOVE" and fault["message"].endswith("Remedy: " + row)
    assert told(found, "held", "commit") == [("commit", "notice", "the proposal is accepted: calibration counter 5")]
    assert [line["link"] for line in found if line["event"] == "link"] == ["up", "silent", "down"]


def test_a_run_as_its_snapshots_show_it(logged):
    """Each position, attempt and fault; what runs on is no event. Nothing is told that no object has: the first cause
    of an ABORT, and whether the node waits."""
    gateway = logged()
    client = gateway.connect()

    def show(state, reason, index, position, attempt=0, failed_in=0, samples=0):
        gateway.set_all({
            (0x2000, 0): bytes([state]), (0x2001, 0): bytes([reason]), (0x2003, 1): bytes([index]),
            (0x2003, 2): b"\x12", (0x2003, 3): bytes([index]), (0x2003, 4): b"\1", (0x2003, 5): bytes([position]),
            (0x2003, 6): bytes([attempt]), (0x2003, 7): u32(samples), (0x2004, 1): bytes([failed_in]),
        })  # fmt: skip
        gateway.wait_fresh(client)

    average, move, fault, abort, stall = 7, 5, 13, 14, 9
    show(average, 0, 2, 3)
    show(average, 0, 2, 3, samples=7)
    show(average, 0, 2, 3, attempt=1)
    show(average, 0, 3, 4)
    show(fault, stall, 4, 5, failed_in=move)
    show(fault, stall, 4, 5, failed_in=move, samples=9)
    show(fault, stall, 5, 6, failed_in=move)
    show(fault, stall, 5, 6, failed_in=6)
    show(abort, 1, 5, 6, failed_in=fault)
    found = [line for line in lines(gateway) if line["event"] in ("state", "fault")]
    assert [(line["event"], line["position"], line.get("attempt")) for line in found] == [
        ("state", 3, 0), ("state", 3, 1), ("state", 4, 0), ("fault", 5, None), ("fault", 6, None), ("fault", 6, None),
        ("state", 6, 0),
    ]  # fmt: skip
    assert [line["state"] for line in found[3:]] == [
        f"TUMBLE_STATE_{name}" for name in ("MOVE", "MOVE", "SETTLE", "ABORT")]
    assert "waits" not in " ".join(line["message"] for line in found) and all("cause" not in line for line in found)
    assert found[-1]["message"] == (
        "TUMBLE_STATE_ABORT at position 1.6, 5 of 18 finished: given up, table stopped: aborted by command")


def test_exceptions_are_refusals_too(logged):
    gateway = logged("--allow-commands")
    client = unlocked(gateway)

    def written(at, *words):
        return struct.pack(f">BHHB{len(words)}H", WRITE_SEVERAL, at, len(words), 2 * len(words), *words)

    client.send(frame(written(COMMAND, 1, 5)) + frame(written(COMMAND, 2, 6)) + frame(GOOD))
    answers = [client.receive()[7:9] for _ in range(3)]
    assert answers == [b"\x10\0", bytes((WRITE_SEVERAL | 0x80, BUSY)), GOOD_ANSWER[:2]]
    assert result(client)[0] == ACCEPTED
    assert client.write(COMMAND - 3, 0x0100, 0, 0, 9, 7) == VALUE
    assert client.write(SETTING, 6) == VALUE
    assert client.write(EXECUTE + 1, 1) == ADDRESS
    gateway.tell("silent 1")
    wait_link(client, 2)
    assert client.write(COMMAND, 1, 8) == TARGET
    assert client.write(SETTING - 3, 0, 0, 0, 0) == ADDRESS
    assert client.write(0, *KEYS) is None
    found = lines(gateway)
    who = "127.0.0.1: "
    assert told(found, "command", "refused", "lock", "unlock") == [
        ("unlock", "notice", who + "the session is unlocked"),
        ("refused", "warning",
         who + "TUMBLE_COMMAND_ABORT (2) refused with exception 06h: another command is under way"),
        ("command", "notice", who + "TUMBLE_COMMAND_START (1) accepted"),
        ("refused", "warning",
         who + "TUMBLE_COMMAND_ACCEPT (9) refused with exception 03h: a value is out of its range"),
        ("refused", "warning",
         who + f"registers {SETTING} to {SETTING} refused with exception 03h: a value is out of its range"),
        ("refused", "warning", who + f"registers {EXECUTE + 1} to {EXECUTE + 1} refused with exception 02h: "
                                     "these registers cannot be written together"),
        ("refused", "warning",
         who + "TUMBLE_COMMAND_START (1) refused with exception 0Bh: the node does not answer"),
        ("refused", "warning", who + f"registers {SETTING - 3} to {SETTING} refused with exception 02h: "
                                     "these registers cannot be written together"),
    ]
    assert [line["exception"] for line in found if line["event"] == "refused"] == [6, 3, 3, 2, 11, 2]


def test_a_name_that_is_no_utf8(logged):
    """The line is JSON, and what else the name has is there."""
    [ready, *_] = lines(logged("--can", os.fsdecode(b"pl\xff\xc3\xa4yed")))
    assert ready["interface"] == "pl?\u00e4yed" and "node 1 on pl?\u00e4yed, unit 1" in ready["message"]


@contextmanager
def killed(process):
    """In the end, whatever it waits for."""
    with process:
        try:
            yield process
        finally:
            process.kill()


@contextmanager
def terminal():
    master, slave = os.openpty()
    yield master, slave
    os.close(master)
    os.close(slave)


@contextmanager
def small_pipe():
    ends = os.pipe()
    fcntl.fcntl(ends[1], fcntl.F_SETPIPE_SZ, 4096)
    yield ends
    os.close(ends[0])
    os.close(ends[1])


@pytest.mark.parametrize("made", [terminal, small_pipe])
def test_whoever_does_not_read_holds_nothing_up(gateway_program, made):
    """The first line is read, and then nothing any more."""
    command = [gateway_program, "--can", "played", "--tcp", "127.0.0.1:0", "--log", "json"]
    with made() as (ours, theirs), killed(subprocess.Popen(command, stdin=subprocess.PIPE, stderr=theirs)) as process:
        ready = b""
        while b"\n" not in ready:
            ready += os.read(ours, 4096)
        port = int(re.search(rb"127\.0\.0\.1:(\d+)", ready)[1])
        for _ in range(150):
            client = Raw(port)
            assert client.ask(GOOD, timeout=20.0) == GOOD_ANSWER
            client.close()
        process.terminate()
        assert process.wait(timeout=20) == 0 and os.get_blocking(theirs)


def test_text_and_level(logged):
    gateway = logged("--log-level", "notice", form="text")
    stamp = r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z tumble-gateway: "
    assert re.fullmatch(stamp + r"notice: node 1 on played, unit 1 at 127\.0\.0\.1:\d+, read only\n", gateway.line)
    wait_link(gateway.connect(), 1)
    code, rest = gateway.end()
    assert code == 0 and re.fullmatch(f"{stamp}notice: node 1: the node answers\n"
                                      f"{stamp}notice: ends with exit code 0\n", rest), rest


@pytest.mark.parametrize("form", [[], ["--log", "text"], ["--log", "json"]])
def test_the_journal_is_told_the_level(gateway_program, form):
    """Where standard error is what JOURNAL_STREAM says, and nowhere else."""
    ours, theirs = os.pipe()
    status = os.fstat(theirs)
    environment = {key: value for key, value in os.environ.items() if key != "LD_PRELOAD"}
    first = []
    for inode in (status.st_ino, status.st_ino + 1):
        environment["JOURNAL_STREAM"] = f"{status.st_dev}:{inode}"
        with killed(subprocess.Popen([gateway_program, "--can", "played", "--tcp", "127.0.0.1:0", *form],
                                     stdin=subprocess.PIPE, stderr=theirs, env=environment)) as process:
            first.append(os.read(ours, 4096).decode().splitlines()[0])
            process.terminate()
            assert process.wait(timeout=20) == 0
        os.set_blocking(ours, False)
        while True:
            try:
                os.read(ours, 4096)
            except BlockingIOError:
                break
        os.set_blocking(ours, True)
    os.close(ours)
    os.close(theirs)
    begins = {"": "tumble-gateway: node 1", "text": "node 1", "json": '{"schema":"tumble.log/1",'}[(form or [""])[-1]]
    assert first[0].startswith("<5>" + begins) and not first[1].startswith("<")


def test_an_unlocked_session_whose_client_goes(logged):
    """The keys belong to the session that wrote them: the next one in its place is told anew."""
    gateway = logged("--allow-commands")
    watcher = gateway.connect()
    for _ in range(2):
        client = unlocked(gateway)
        client.close()
        wait_until(lambda: watcher.number("Clients") == 1)
    events = [line[0] for line in told(lines(gateway), "connected", "unlock", "disconnected")]
    assert events == ["connected", *2 * ["connected", "unlock", "disconnected"], "disconnected"]


def test_the_serial_line_is_a_client_too(logged, line):
    gateway = logged("--allow-commands", "--rtu", f"{line.name},19200,E")
    gateway.wait_fresh()
    for keys in ((1, 2), KEYS):
        assert line.ask(struct.pack(">BBHHBHH", 1, WRITE_SEVERAL, 0, 2, 4, *keys))
    assert line.ask(struct.pack(">BBHHBHH", 1, WRITE_SEVERAL, COMMAND, 2, 4, 1, 7))
    gateway.wait_fresh()
    assert line.ask(struct.pack(">BBHHBHH", 1, WRITE_SEVERAL, 0, 2, 4, 1, 2))
    who = "the serial line: "
    found = lines(gateway)
    assert found[0]["rtu"] == line.name
    assert told(found, "unlock", "lock", "command", "refused") == [
        ("refused", "warning", who + "wrong keys"),
        ("unlock", "notice", who + "the session is unlocked"),
        ("command", "notice", who + "TUMBLE_COMMAND_START (1) accepted"),
        ("refused", "warning", who + "wrong keys"),
        ("lock", "info", who + "the session is locked"),
    ]
