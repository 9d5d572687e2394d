"""What the CANopen interoperation tests share: our node in a process of its own, and python-can's side of its pipe."""

import functools
import os
import queue
import subprocess
import threading
import time
from pathlib import Path

import pytest
from c_compiler import SANITIZERS, compiled, firmware_sources

canopen = pytest.importorskip("canopen", reason="python-canopen is not installed")
can = pytest.importorskip("can", reason="python-can is not installed")

ROOT = Path(__file__).resolve().parents[2]
NUMBERS = {"navcomp": 1, "navcomp_without_sets": 1, "drive": 2, "block": 3}
EDS = {name: ROOT / "docs" / "eds" / f"tumble_{name}.eds" for name in NUMBERS}
FLAGS = ["-Wall", "-Wextra", "-Werror", "-g", *SANITIZERS]


@functools.cache
def build_harness(folder):
    """Compile tests/integration/canopen_harness.c with the firmware, once; returns the program."""
    own = ["tests/integration/canopen_harness.c", "tests/lib/flash.c"]
    own += [f"host/simulation/{name}_objects.c" for name in ("drive", "block")]
    return compiled(folder / "canopen_harness", *FLAGS, "-Ihost", "-Itests/lib", *own, *firmware_sources())


class PipeBus(can.BusABC):
    """A python-can bus whose other end is the harness's stdin and stdout."""

    def __init__(self, program, name):
        super().__init__(channel=name)
        self.channel_info = f"pipe to {name}"
        self.process = subprocess.Popen([program, name], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.frames = queue.Queue()
        self.results = queue.Queue()
        self.log = []
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            line = line.decode().strip()
            if line.startswith("="):
                self.results.put(line[1:].split())
                continue
            identifier, data = line.split("#")
            self.log.append(line)
            self.frames.put(can.Message(arbitration_id=int(identifier, 16), data=bytes.fromhex(data),
                                        is_extended_id=False, timestamp=time.time()))

    def tell(self, line):
        """A line for the harness: a frame or one of its commands. Safe from any thread, and from a destructor within
        one: a short write to a pipe is atomic."""
        os.write(self.process.stdin.fileno(), f"{line}\n".encode())

    def send(self, msg, timeout=None):
        assert not msg.is_extended_id and not msg.is_remote_frame
        self.tell(f"{msg.arbitration_id:03X}#{bytes(msg.data).hex().upper()}")

    def _recv_internal(self, timeout):
        try:
            return self.frames.get(timeout=timeout), False
        except queue.Empty:
            return None, False

    def let_pass(self, ms):
        """Let the node's clock go on; when this returns, all that the node sent meanwhile is in `log`."""
        self.tell(f"!pass {ms}")
        assert self.results.get(timeout=60) == ["passed"]

    def transfer(self, command, ms=0):
        """An SDO transfer of the harness's client: (status name, abort code, bytes). `ms` passes after its start."""
        self.tell(command)
        if ms:
            self.let_pass(ms)
        status, abort, data = self.results.get(timeout=60)
        return status, int(abort, 16), bytes.fromhex(data[1:])

    def shutdown(self):
        super().shutdown()
        self.process.stdin.close()
        try:
            code = self.process.wait(timeout=60)
        finally:
            self.process.kill()
        assert code == 0, f"the harness ended with {code}: a sanitizer spoke?"


@pytest.fixture(scope="session")
def program(tmp_path_factory):
    return build_harness(tmp_path_factory.getbasetemp() / "canopen")


class Ours:
    """One of our nodes with python-canopen as its master."""

    def __init__(self, program, name):
        self.bus = PipeBus(program, name)
        self.network = canopen.Network(self.bus)
        self.network.NOTIFIER_CYCLE = 0.02
        self.network.connect()
        self.node = self.network.add_node(NUMBERS[name], str(EDS[name]))
        self.node.sdo.RESPONSE_TIMEOUT = 20.0

    def close(self):
        self.network.disconnect()
        self.bus.shutdown()

    def entries(self):
        """All variables of the EDS file."""
        for item in self.node.object_dictionary.values():
            if item.index >= 0x1000:
                yield from ([item] if isinstance(item, canopen.objectdictionary.ODVariable) else item.values())

    def upload(self, entry):
        return self.node.sdo.upload(entry.index, entry.subindex)

    def download(self, entry, data):
        self.node.sdo.download(entry.index, entry.subindex, data)

    def refusal_of_raw(self, variable, value):
        """The abort code when python-canopen's variable is set to a value."""
        return refusal_of(setattr, variable, "raw", value)


@pytest.fixture
def start(program):
    opened = []

    def start_one(name):
        opened.append(Ours(program, name))
        return opened[-1]

    yield start_one
    for ours in opened:
        ours.close()


def refusal_of(action, *arguments):
    """The abort code of a call that must be refused. python-canopen sends one more segment when the stream of an
    aborted write is collected: no exception may be kept, so that this happens here and not in what follows."""
    try:
        action(*arguments)
    except canopen.SdoAbortedError as refusal:
        return refusal.code
    return pytest.fail("was not refused")
