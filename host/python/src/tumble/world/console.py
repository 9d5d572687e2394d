"""What stands at the bench of a board on a CAN interface: starts the simulated stand, the emulated board and candump,
tells the board to begin, follows it, reads its result by SDO.

    console.py JOB.json

A program of its own, of the standard library alone: it runs inside user-mode Linux, where every import is slow. JOB
holds `interface`, and the commands `stand` and `board`. Everything goes into the job's folder: bus.log, serial.log,
stand.json, stand.err, board.err; `progress`, a line of JSON for every state PDO; and board.json {end, state,
reason, numbers (twelve, hexadecimal bits), counters}. `end`: "done", "failed", "stopped", or a sentence. A file `stop`
in that folder ends it: the table is stopped first.
"""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

TYPE_CHECKING = False  # for whoever checks types alone: the import of typing takes its time
if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

COMMAND, START, ABORT = 0x2002, 1, 2
IDLE, DONE, FAULT, ABORTED = 0, 12, 13, 14
STATE_PDO, ANSWER, REQUEST, HEARTBEAT = 0x181, 0x581, 0x601, 0x701

_BOOT_S = 90.0  # an emulator inside an emulator takes its time
_SILENCE_S = 5.0  # of a heartbeat that comes ten times a second
_ANSWER_S = 5.0
_TRIES = 3  # an emulator that is held up loses frames
_REST_S = 15.0
_TIMED_OUT = 0x05040000  # abort code
_FRAME = struct.Struct("<IB3x8s")
_COUNTERS = {0x2030: ("sent", "received", "busy", "down", "invalid"), 0x2032: ("samples", "lost")}


class Ended(Exception):
    """The run is over; says how."""


class Unanswered(Ended):
    """A request, or the answer to it, was lost, or the board is held up."""


class Bus:
    """The interface, as an SDO client of node 1 that also hears its state."""

    def __init__(self, interface: str, on_state: Callable[[bytes], None]) -> None:
        self._socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        filters = b"".join(struct.pack("<II", number, 0xC00007FF) for number in (STATE_PDO, ANSWER, HEARTBEAT))
        self._socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, filters)
        self._socket.bind((interface,))
        self._on_state = on_state
        self.heard: float | None = None

    def take(self, timeout_s: float) -> bytes | None:
        """The next answer of the SDO server, or None when the time is over and nothing more is there."""
        end = time.monotonic() + timeout_s
        while select.select([self._socket], [], [], max(0.0, end - time.monotonic()))[0]:
            data: bytes
            number, length, data = _FRAME.unpack(self._socket.recv(_FRAME.size))
            self.heard = time.monotonic()
            if number == STATE_PDO and length == 8:
                self._on_state(data)
            elif number == ANSWER:
                return data
        return None

    def ask(self, data: bytes) -> bytes:
        """The answer to one request. Late answers to earlier ones are not taken for it."""
        while self.take(0.0) is not None:
            pass
        self._socket.send(_FRAME.pack(REQUEST, 8, data))
        answer = self.take(_ANSWER_S)
        if answer is None:
            raise Unanswered("the board does not answer by SDO")
        if answer[0] == 0x80:
            raise Ended(f"the board refuses an SDO request: {answer[3::-1].hex()} {answer[:3:-1].hex()}")
        return answer

    def read(self, index: int, subindex: int) -> bytes:
        """The bytes of an object: from the beginning again where an answer fails to come."""
        for _ in range(_TRIES - 1):
            try:
                return self._read(index, subindex)
            except Unanswered:
                self._socket.send(_FRAME.pack(REQUEST, 8, struct.pack("<BHBI", 0x80, index, subindex, _TIMED_OUT)))
        return self._read(index, subindex)

    def _read(self, index: int, subindex: int) -> bytes:
        answer = self.ask(struct.pack("<BHB4x", 0x40, index, subindex))
        if answer[0] & 2:
            return answer[4 : 8 - (answer[0] >> 2 & 3)]
        data, toggle, last = b"", 0, 0
        while not last:
            answer = self.ask(bytes([0x60 | toggle]) + bytes(7))
            data += answer[1 : 8 - (answer[0] >> 1 & 7)]
            last, toggle = answer[0] & 1, toggle ^ 0x10
        return data

    def command(self, command: int) -> None:
        """Give node 1 a command without an argument."""
        for subindex, value in ((1, 0), (2, command)):
            self.ask(struct.pack("<BHBB3x", 0x2F, COMMAND, subindex, value))


class Console:
    """A run."""

    def __init__(self, job: dict[str, Any], folder: Path) -> None:
        self._job, self._folder = job, folder
        self._state: int | None = None
        self._reason = 0
        self._began = time.monotonic()
        self._progress = open(folder / "progress", "a", buffering=1)  # noqa: SIM115 - as long as the run
        self._bus = Bus(job["interface"], self._on_state)
        self._processes: dict[str, subprocess.Popen[bytes]] = {}

    def run(self) -> dict[str, Any]:
        """To its end. Returns the document."""
        document: dict[str, Any] = {"numbers": None, "counters": {}}
        try:
            self._start_board()
            self._wait_for_boot()
            self._spawn("stand", self._job["stand"], "stand.json", "stand.err")
            self._begin()
            self._follow()
            document = self._read()
            end = "done"
        except Ended as ended:
            end = str(ended)
        finally:
            self._stop_all()
        return {"end": end, "state": self._state, "reason": self._reason, **document}

    def _spawn(self, name: str, command: list[str], out: str, err: str = os.devnull) -> None:
        with open(self._folder / out, "w") as stdout, open(self._folder / err, "w") as stderr:
            self._processes[name] = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr)

    def _start_board(self) -> None:
        """On a bus that is silent: an emulator keeps what it hears while it starts, seconds of it, and then fills the
        board's receive queue at once."""
        self._spawn("candump", ["candump", "-L", self._job["interface"]], "bus.log")
        time.sleep(0.3)  # it listens
        self._spawn("board", self._job["board"], "serial.log", "board.err")

    def _look(self) -> None:
        for name, process in self._processes.items():
            if process.poll() is not None:
                raise Ended(f"{name} ended by itself ({process.returncode})")
        if (self._folder / "stop").exists():
            self._abort()
            raise Ended("stopped")

    def _abort(self) -> None:
        try:
            self._bus.command(ABORT)
            self._bus.take(0.5)
        except Ended:
            pass  # the stand's drive stops by itself, without its master

    def _wait_for_boot(self) -> None:
        end = time.monotonic() + _BOOT_S
        while self._bus.heard is None:
            self._look()
            self._bus.take(0.2)
            if time.monotonic() > end:
                raise Ended(f"the board does not boot within {_BOOT_S:.0f} s")
        self._bus.take(0.2)

    def _begin(self) -> None:
        """START, again where no answer comes and none shows that it was taken."""
        for _ in range(_TRIES - 1):
            try:
                self._bus.command(START)
                return
            except Unanswered:
                if self._state not in (None, IDLE):
                    return
        self._bus.command(START)

    def _on_state(self, data: bytes) -> None:
        moved = (data[0], data[1]) != (self._state, self._reason)
        self._state, self._reason = data[0], data[1]
        event: dict[str, Any] = {"state": data[0], "reason": data[1], "index": data[2], "finished": data[3]}
        event |= {"samples": struct.unpack("<I", data[4:])[0], "moved": moved, "s": time.monotonic() - self._began}
        print(json.dumps(event), file=self._progress)

    def _follow(self) -> None:
        while self._state != DONE:
            self._look()
            self._bus.take(0.2)
            if self._state in (FAULT, ABORTED):
                raise Ended("failed")
            if self._bus.heard is not None and time.monotonic() - self._bus.heard > _SILENCE_S:
                raise Ended("the board has fallen silent")

    def _read(self) -> dict[str, Any]:
        numbers = [self._bus.read(0x2020, i) for i in range(1, 10)] + [self._bus.read(0x2021, i) for i in range(1, 4)]
        counters = {}
        for index, names in _COUNTERS.items():
            for subindex, name in enumerate(names, 1):
                counters[name] = int.from_bytes(self._bus.read(index, subindex), "little")
        return {"numbers": [number[::-1].hex() for number in numbers], "counters": counters}

    def _stop_all(self) -> None:
        """The stand first, which comes to rest and reports."""
        for name, patience_s in (("stand", _REST_S), ("board", 3.0), ("candump", 3.0)):
            process = self._processes.get(name)
            if process is None:
                continue
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(patience_s)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def main(path: str) -> int:
    """Run a job. Returns the exit code: 0, whatever came of it."""
    folder = Path(path).resolve().parent
    document = Console(json.loads(Path(path).read_text()), folder).run()
    (folder / "board.part").write_text(json.dumps(document))
    (folder / "board.part").rename(folder / "board.json")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
