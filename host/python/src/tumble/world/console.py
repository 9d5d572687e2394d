"""What stands at the bench of a computer on a CAN interface: starts the simulated stand and the computer, tumble-node
or the emulated board, and follows them to their end.

    console.py JOB.json

A program of its own, of the standard library alone: it runs inside user-mode Linux, too, where every import is slow.
JOB holds `interface`, and the commands `stand` and either `node` or `board`. Everything goes into the job's folder:
stand.json, stand.err; `progress`, a line of JSON for every event; and ended.json: {end, ...}, where `end` is "done",
"failed", "stopped", "stand", or a sentence. A file `stop` in that folder ends it: the table is stopped first.

    node   node.err; {code} of the program; with the end "stand" that of the stand, which gave up at once. A file
           answer.1 is what a person says first, answer.2 next.
    board  candump's bus.log, serial.log, board.err; told to begin, and read, by SDO: {state, reason, numbers (twelve,
           hexadecimal bits), counters}. Its events are its state PDOs.
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
    from collections.abc import Callable, Sequence
    from typing import Any

COMMAND, START, ABORT = 0x2002, 1, 2
IDLE, DONE, FAULT, ABORTED = 0, 12, 13, 14
STATE_PDO, ANSWER, REQUEST, HEARTBEAT = 0x181, 0x581, 0x601, 0x701

_EARLY_S = 0.3  # within which a program that cannot work gives up
_TICK_S = 0.1
_PATIENCE_S = 15.0  # for a node that has been told to end
_BOOT_S = 90.0  # an emulator inside an emulator takes its time
_SILENCE_S = 5.0  # of a heartbeat that comes ten times a second
_ANSWER_S = 5.0
_TRIES = 3  # an emulator that is held up loses frames
_TIMED_OUT = 0x05040000  # abort code
_FRAME = struct.Struct("<IB3x8s")
_COUNTERS = {0x2030: ("sent", "received", "busy", "down", "invalid"), 0x2032: ("samples", "lost")}


class Ended(Exception):
    """The run is over; says how, and what `more` there is to tell."""

    def __init__(self, how: str, **more: Any) -> None:
        super().__init__(how)
        self.more = more


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
    """A run; `run` is that of one kind of computer."""

    ENDS: tuple[tuple[str, float], ...] = (
        ("stand", 15.0),
    )  # who is told to end, and how long that may take: the stand comes to rest, and reports

    def __init__(self, job: dict[str, Any], folder: Path) -> None:
        self._job, self._folder = job, folder
        self._parent = os.getppid()
        self._processes: dict[str, subprocess.Popen[bytes]] = {}

    def document(self) -> dict[str, Any]:
        """The run, to its end."""
        try:
            return {"end": "done", **self.run()}
        except Ended as ended:
            return {"end": str(ended), **ended.more}
        finally:
            self._stop_all()

    def run(self) -> dict[str, Any]:
        """To its end. Returns what is to be told. Raises Ended."""
        raise NotImplementedError

    def _spawn(self, name: str, out: str, err: str = os.devnull, arguments: Sequence[str] = (), **options: Any) -> None:
        options = {"stdin": subprocess.DEVNULL, **options}
        command = [*self._job[name], *arguments]
        with open(self._folder / out, "w") as stdout, open(self._folder / err, "w") as stderr:
            try:
                self._processes[name] = subprocess.Popen(command, stdout=stdout, stderr=stderr, **options)
            except OSError as error:
                why = (error.strerror or "unknown").lower()
                raise Ended(f"{os.path.basename(command[0])} cannot be started: {why}") from None

    def _must_stop(self) -> bool:
        """It is to end; or nobody is there any more who could say so."""
        return (self._folder / "stop").exists() or os.getppid() != self._parent

    def _tell(self, lines: bytes) -> None:
        """A file appears outside of user-mode Linux when it is closed inside."""
        with open(self._folder / "progress", "ab") as progress:
            progress.write(lines + b"\n")

    def _stop_all(self) -> None:
        for name, patience_s in self.ENDS:
            if (process := self._processes.get(name)) is not None:
                process.send_signal(signal.SIGTERM)
                try:
                    process.wait(patience_s)
                except subprocess.TimeoutExpired:
                    process.kill()
                    process.wait()


class Node(Console):
    """By tumble-node, which tells its progress and writes its document by itself."""

    ENDS = (("node", 0.0), *Console.ENDS)

    def run(self) -> dict[str, Any]:
        self._spawn("stand", "stand.json", "stand.err", stdin=subprocess.PIPE)
        try:
            raise Ended("stand", code=self._processes["stand"].wait(_EARLY_S))
        except subprocess.TimeoutExpired:
            pass
        if self._must_stop():
            raise Ended("stopped")
        ours, theirs = os.pipe()
        try:
            self._spawn("node", os.devnull, "node.err", ("--progress-fd", str(theirs)), pass_fds=(theirs,))
        finally:
            os.close(theirs)
        self._follow(ours)
        return {"code": self._processes["node"].wait()}

    def _follow(self, progress: int) -> None:
        """Until it has nothing more to tell."""
        rest, said, given_up = b"", 1, float("inf")
        while True:
            if select.select([progress], [], [], _TICK_S)[0]:
                data = os.read(progress, 65536)
                if not data:
                    return
                whole, newline, rest = (rest + data).rpartition(b"\n")
                if newline:
                    self._tell(whole)
            if (answer := self._folder / f"answer.{said}").exists():
                self._answer(answer.read_bytes())
                said += 1
            if self._must_stop() and given_up == float("inf"):
                self._processes["node"].send_signal(signal.SIGTERM)
                given_up = time.monotonic() + _PATIENCE_S
            if time.monotonic() > given_up:
                self._processes["node"].kill()

    def _answer(self, line: bytes) -> None:
        """Have it done at the stand, or let the node leave the run as it is."""
        if line == b"leave\n":
            self._processes["node"].send_signal(signal.SIGUSR1)
            return
        stdin = self._processes["stand"].stdin
        try:
            assert stdin is not None  # it is a pipe
            stdin.write(line)
            stdin.flush()
        except BrokenPipeError:
            pass  # it has ended; the node misses its block


class Board(Console):
    """By the emulated board."""

    ENDS = (*Console.ENDS, ("board", 3.0), ("candump", 3.0))

    def __init__(self, job: dict[str, Any], folder: Path) -> None:
        super().__init__({"candump": ["candump", "-L", job["interface"]], **job}, folder)
        self._state: int | None = None
        self._reason = 0
        self._began = time.monotonic()
        self._bus = Bus(job["interface"], self._on_state)

    def document(self) -> dict[str, Any]:
        found = {"numbers": None, "counters": {}, **super().document()}
        return {**found, "state": self._state, "reason": self._reason}

    def run(self) -> dict[str, Any]:
        self._start_board()
        self._wait_for_boot()
        self._spawn("stand", "stand.json", "stand.err")
        self._begin()
        self._follow()
        return self._read()

    def _start_board(self) -> None:
        """On a bus that is silent: an emulator keeps what it hears while it starts, seconds of it, and then fills the
        board's receive queue at once."""
        self._spawn("candump", "bus.log")
        time.sleep(0.3)  # it listens
        self._spawn("board", "serial.log", "board.err")

    def _look(self) -> None:
        for name, process in self._processes.items():
            if process.poll() is not None:
                raise Ended(f"{name} ended by itself ({process.returncode})")
        if self._must_stop():
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
        self._tell(json.dumps(event).encode())

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


def main(path: str) -> int:
    """Run a job. Returns the exit code: 0, whatever came of it."""
    folder, job = Path(path).resolve().parent, json.loads(Path(path).read_text())
    document = (Board if "board" in job else Node)(job, folder).document()
    (folder / "ended.part").write_text(json.dumps(document))
    (folder / "ended.part").rename(folder / "ended.json")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
