"""What the tests of tumble-gateway share: the gateway, instrumented, with a node that the test plays; raw frames."""

import contextlib
import csv
import functools
import json
import os
import queue
import re
import select
import shutil
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
import tty
from pathlib import Path

import pytest
from c_compiler import SANITIZERS, compiled
from simulated_bench import wait_until

ROOT = Path(__file__).resolve().parents[2]
FLAGS = ["-Wall", "-Wextra", "-Werror", "-g", "-O1", *SANITIZERS, "-fsanitize=float-cast-overflow"]
REGISTERS = ROOT / "docs/modbus.csv"

READ_HOLDING, READ_INPUT, WRITE_ONE, WRITE_SEVERAL = 3, 4, 6, 16
FUNCTION, ADDRESS, VALUE, BUSY, NO_PATH, TARGET = 1, 2, 3, 6, 10, 11
KEYS = (0x4F50, 0x454E)
MOST_CLIENTS = 32
PIPE_BYTES = 65536
GOOD = struct.pack(">BHH", READ_INPUT, 0, 2)
GOOD_ANSWER = b"\4\4\x54\x55\x4d\x42"
GAP_S = 0.05  # longer than the gateway's on a serial line


@functools.cache
def build(folder):
    """Compile tests/integration/gateway_harness.c with the gateway, once; returns the program. Skips where libmodbus is
    not installed."""
    config = shutil.which("pkg-config")
    if config is None or subprocess.run([config, "libmodbus"]).returncode:
        pytest.skip("libmodbus is not installed (Debian: libmodbus-dev, pkg-config)")
    library = subprocess.run([config, "--cflags", "--libs", "libmodbus"], check=True, capture_output=True, text=True)
    sources = [str(path) for path in sorted((ROOT / "host/gateway").glob("*.c")) if path.name != "main.c"]
    firmware = ("canopen/sdo_client", "canopen/link", "core/count", "core/status", "core/status_sentence",
                "navcomp/commands", "procedure/names", "sets/objections")
    sources += [f"firmware/{name}.c" for name in firmware]
    programs = ("arguments", "event_log", "outlet", "remedies", "run_log")
    sources += [*(f"host/programs/{name}.c" for name in programs), "host/world/json.c"]
    sources += ["boards/linux/can_socket.c", "boards/linux/events.c", "tests/lib/played_sdo.c"]
    return compiled(folder / "tumble-gateway", *FLAGS, "-Ihost", "-Ihost/gateway", "-Ihost/programs", "-Iboards/linux",
                    "-Itests/lib", "tests/integration/gateway_harness.c", *sources, *library.stdout.split())


@functools.cache
def registers():
    """docs/modbus.csv: {name: row}, numbers as such."""
    with open(REGISTERS, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        for key in ("register", "words", "subindex", "valid_register", "valid_bit"):
            row[key] = int(row[key]) if row[key] else None
        row["index"] = int(row["index"], 16) if row["index"] else None
        row["scale"] = float(row["scale"]) if row["scale"] else None
    return rows


def register(name, table="input", scaled=False):
    """The one of that name; scaled: that of the number as an integer."""
    wanted = (f"{name} (scaled)" if scaled else name, table)
    [found] = [row for row in registers() if (row["name"], row["table"]) == wanted]
    return found


def end_of(table):
    """One beyond the last register."""
    return max(row["register"] + row["words"] for row in registers() if row["table"] == table)


class Gateway:
    """The gateway in a process of its own, and the node behind it."""

    def __init__(self, program, *options, tcp="127.0.0.1:0"):
        command = [program, "--can", "played", *(["--tcp", tcp] if tcp else []), *map(str, options)]
        environment = {key: value for key, value in os.environ.items() if key != "LD_PRELOAD"}
        environment |= {"ASAN_OPTIONS": "detect_leaks=1", "UBSAN_OPTIONS": "print_stacktrace=1"}
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        text=True, env=environment)
        self.line = self.process.stderr.readline()
        found = re.search(r" at 127\.0\.0\.1:(\d+)", self.line)
        self.port = int(found[1]) if found else None
        self.answers, self.written = queue.Queue(), queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        for line in self.process.stdout:
            (self.answers if line == "ok\n" else self.written).put(line.strip())

    def tell(self, line):
        """A line for the node."""
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        assert self.answers.get(timeout=20) == "ok"

    def set(self, index, sub, data=None, boot=True):
        """An object of the node has these bytes; or none. By booting the node says that all may be different."""
        self.tell(f"set {index:X} {sub} {data.hex()}" if data is not None else f"unset {index:X} {sub}")
        if boot:
            self.tell("boot")

    def set_all(self, objects, boot=True):
        """Objects of the node that belong together, {(index, sub): bytes}: no poll sees half of them. The harness
        takes at once what is written at once, as long as the pipe, which is empty, has room for it."""
        told = [f"set {index:X} {sub} {data.hex()}" for (index, sub), data in objects.items()] + ["boot"] * boot
        data = "".join(line + "\n" for line in told).encode()
        assert os.write(self.process.stdin.fileno(), data) == len(data) < PIPE_BYTES
        assert all(self.answers.get(timeout=20) == "ok" for _ in told)

    def connect(self, source=None):
        """A raw client, of that address if one is given."""
        return Raw(self.port, source=source)

    def end(self, number=signal.SIGTERM):
        """(exit code, standard error) after a signal."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        errors = self.process.stderr.read()
        return self.process.wait(timeout=20), errors

    def wait_fresh(self, client=None):
        """Until a snapshot has been begun and ended from now on."""
        mine = client or self.connect()
        before = mine.snapshot()
        wait_until(lambda: (mine.snapshot() - before) >= 2)
        if client is None:
            mine.close()


class Raw:
    """A TCP client that sends whatever it is told to."""

    def __init__(self, port, timeout=5.0, source=None):
        own = (source, 0) if source else None
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=timeout, source_address=own)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.transaction = 0

    def send(self, data):
        """Bytes as they are."""
        self.socket.sendall(data)

    def receive(self, timeout=5.0):
        """One whole frame, b"" when the connection was closed, None when nothing comes in time."""
        self.socket.settimeout(timeout)
        try:
            head = self._exactly(6)
            return head and head + self._exactly(struct.unpack(">H", head[4:6])[0])
        except TimeoutError:
            return None
        except ConnectionResetError:
            return b""

    def _exactly(self, count):
        data = b""
        while len(data) < count:
            more = self.socket.recv(count - len(data))
            if not more:
                return b""
            data += more
        return data

    def ask(self, pdu, unit=1, protocol=0, timeout=5.0):
        """The PDU of the answer to a PDU; its header is checked."""
        self.transaction = self.transaction + 1 & 0xFFFF
        self.send(frame(pdu, unit, protocol, self.transaction))
        answer = self.receive(timeout)
        if not answer:
            return answer
        assert answer[:2] == struct.pack(">H", self.transaction) and answer[2:4] == b"\0\0" and answer[6] == unit
        return answer[7:]

    def read(self, at, count, function=READ_INPUT):
        """Registers, as numbers."""
        answer = self.ask(struct.pack(">BHH", function, at, count))
        assert answer[0] == function and answer[1] == 2 * count == len(answer) - 2, answer
        return struct.unpack(f">{count}H", answer[2:])

    def write(self, at, *words):
        """None, or the number of the exception."""
        pdu = struct.pack(f">BHHB{len(words)}H", WRITE_SEVERAL, at, len(words), 2 * len(words), *words)
        answer = self.ask(pdu)
        if answer[0] == WRITE_SEVERAL:
            assert answer == pdu[:5]
            return None
        assert answer[0] == WRITE_SEVERAL | 0x80 and len(answer) == 2
        return answer[1]

    def value(self, row):
        """A register of the CSV, as a number; None where its bit of validity is not set."""
        words = self.read(row["register"], row["words"], READ_INPUT if row["table"] == "input" else READ_HOLDING)
        if row["valid_register"] is not None and not self.read(row["valid_register"], 1)[0] >> row["valid_bit"] & 1:
            assert not any(words)
            return None
        return decode(row, words)

    def number(self, name, table="input", scaled=False):
        """The same by its name."""
        return self.value(register(name, table, scaled))

    def snapshot(self):
        """Number of the newest snapshot, which is this session's now."""
        return self.number("Snapshot number")

    def unlock(self):
        """With the keys."""
        assert self.write(0, *KEYS) is None

    def close(self):
        """The connection."""
        self.socket.close()


def decode(row, words):
    """A number from its registers."""
    data = struct.pack(f">{len(words)}H", *words)
    if row["type"] == "text":
        return data.rstrip(b"\0").decode()
    letter = {"u16": "H", "i16": "h", "u32": "I", "i32": "i", "u64": "Q", "i64": "q", "f32": "f",
              "f64": "d"}[row["type"]]
    [number] = struct.unpack(">" + letter, data)
    return number if row["scale"] is None else number * row["scale"]


def frame(pdu, unit=1, protocol=0, transaction=0):
    """A frame of TCP."""
    return struct.pack(">HHHB", transaction, protocol, len(pdu) + 1, unit) + pdu


@pytest.fixture(scope="session")
def gateway_program(tmp_path_factory):
    """The instrumented gateway."""
    return build(tmp_path_factory.getbasetemp() / "gateway")


@pytest.fixture
def launch(gateway_program):
    """Launch gateways. In the end none of them is left, whatever the test has found."""
    launched = []

    def launch_one(*options, **keys):
        launched.append(Gateway(gateway_program, *options, **keys))
        return launched[-1]

    yield launch_one
    for gateway in launched:
        gateway.process.kill()
        gateway.process.wait()


@pytest.fixture
def start(launch):
    """Start gateways. In the end each must end well, and no sanitizer may have spoken."""
    started = []

    def start_one(*options, **keys):
        started.append(launch("--poll", 50, *options, **keys))
        assert started[-1].line, started[-1].process.stderr.read()
        return started[-1]

    yield start_one
    ends = [gateway.end() for gateway in started]
    assert all(end == (0, "") for end in ends), ends


def crc(data):
    """Of Modbus, bit by bit, from its definition."""
    value = 0xFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return struct.pack("<H", value)


def whole(data):
    return data + crc(data)


class Line:
    """A pseudo terminal: the gateway opens `name`; we are its master."""

    def __init__(self):
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.name = os.ttyname(self.slave)

    def send(self, data):
        os.write(self.master, data)

    def receive(self, timeout=2.0):
        """What comes until the line is silent for a while."""
        data = b""
        while select.select([self.master], [], [], GAP_S if data else timeout)[0]:
            data += os.read(self.master, 1000)
        return data

    def ask(self, data):
        self.send(whole(data))
        return self.receive()

    def close(self):
        for fd in (self.master, self.slave):
            with contextlib.suppress(OSError):
                os.close(fd)


@pytest.fixture
def line():
    made = Line()
    yield made
    made.close()


@pytest.fixture
def far_end(line):
    """The name of a second pseudo terminal whose bytes are those of the first."""
    other, done = Line(), threading.Event()

    def pump():
        ends = {line.master: other.master, other.master: line.master}
        while not done.is_set():
            for fd in select.select(list(ends), [], [], 0.05)[0]:
                os.write(ends[fd], os.read(fd, 1000))

    thread = threading.Thread(target=pump)
    thread.start()
    yield other.name
    done.set()
    thread.join()
    other.close()


@pytest.fixture
def serve(start, line):
    """Start a gateway on the line, beside TCP."""

    def run(*options, parity="E"):
        gateway = start("--rtu", f"{line.name},19200,{parity}", *options)
        assert f" and {line.name}" in gateway.line
        gateway.wait_fresh()
        return gateway

    return run


class Bystander:
    """A well-behaved client (gateway_bystander.py)."""

    def __init__(self, port):
        self.process = subprocess.Popen([sys.executable, Path(__file__).with_name("gateway_bystander.py"), str(port)],
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout.readline() == "ready\n"
        self.began = time.monotonic()

    def again(self):
        """The abuse is to be repeated until there has been enough time to measure."""
        yield
        while time.monotonic() - self.began < 1.0:
            yield

    def end(self):
        """Text for the table. It must have been answered, always."""
        out, _ = self.process.communicate(timeout=30)
        assert self.process.returncode == 0, out
        p95_ms, most_ms, count = json.loads(out)
        assert count >= 10
        return f"{p95_ms:.2f} | {most_ms:.2f} | {count}"


@pytest.fixture
def abused(start):
    """A gateway, and a bystander on it; prints what it measured."""
    gateway = start()
    gateway.bystander = Bystander(gateway.port)
    yield gateway
    told = gateway.bystander.end()
    print(f"| {gateway.abuse} | {gateway.came_back} | {told} |")


def counter(gateway, name):
    client = gateway.connect()
    number = client.number(name)
    client.close()
    return number
