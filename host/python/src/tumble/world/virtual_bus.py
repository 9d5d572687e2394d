"""Firmware and simulated stand in one process, as a bus of python-can whose time is the caller's.

    with VirtualBus("stand.txt", seed=3) as bus:
        bus.send(can.Message(arbitration_id=0x601, data=..., is_extended_id=False))
        bus.sleep(60)  # at once
        bus.recv()

The navigation computer's firmware (node 1), the drive (node 2), the block (node 3) and the bus between them run in
this process in virtual time. It goes on only while the thread that made the bus waits: in `sleep`, in `recv`, and in
`send` of an SDO request until its answer has come. So a calibration of minutes takes about a second, a pause in the
debugger takes no time at all, and the same calls have the same outcome, to the last bit. Other threads, such as
python-can's Notifier of a python-canopen network, only receive what has come: `send` and `sleep` return when they have
taken it. What `send_periodic` sends is sent in virtual time. Needs python-can, which knows the bus as
`can.Bus(interface="tumble", channel="stand.txt")` where the package is installed.
"""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import can

from tumble.documents import bench
from tumble.documents.bench import Bench
from tumble.files.disk import read_bytes
from tumble.world import in_process
from tumble.world.border import ENDED, FOREVER_US, FRAME, Border, Refused

_ANSWER_US = 5_000_000  # of virtual time, for an answer to an SDO request
_FOREVER_US = 10**12
_STUCK_S = 60.0  # of the machine's, for another thread to take a frame
_KEPT = 100_000  # frames that nobody has taken
_GUEST = 3  # of border.SENDERS: what this bus has sent itself

_PAPER = (None, "", "paper")  # scenarios that are no file

_REQUESTS = (0x600, 0x400)  # to SDO servers; the second one's are those of object 1201h
_SERVICE = 0x780
_TO_ANSWER = -0x80
_ABORT = 0x80


class VirtualBus(can.BusABC):
    """`scenario`, or `channel` in the words of python-can: a scenario file; None, "" or "paper": the paper's stand;
    `operator`: who mounts the block and who confirms, by-itself, on-confirm or never; `memory`: the node keeps
    coefficients, and the scenario names the block by keeper.serial; `out`: a folder for run.csv, bus.log and
    bench.json; `script_time`: with `time_of` the bus until it is left. `world`: of somebody who holds it himself
    (tumble.World.bus): it goes on when the bus has been left.

    Classic data frames with 11-bit identifiers only. Timestamps are seconds since power-on. Raises
    can.CanInitializationError, can.CanOperationError, BadInput.
    """

    def __init__(
        self,
        scenario: str | os.PathLike[str] | None = None,
        *,
        channel: str | os.PathLike[str] | None = None,
        seed: int = 1,
        operator: str = "on-confirm",
        memory: bool = False,
        out: str | os.PathLike[str] | None = None,
        script_time: bool = False,
        world: Border | None = None,
        **options: Any,
    ):
        self._owner = threading.current_thread()
        self._frames: deque[can.Message] = deque(maxlen=_KEPT)
        self._come = threading.Condition()
        self._readers: set[threading.Thread] = set()  # other threads that receive ...
        self._busy: set[threading.Thread] = set()  # ... and those of them that do something with what they have got
        self._talk = threading.RLock()
        self._told = 0  # frames of the world that have been looked at
        self._document: Bench | None = None
        self._out = None if out is None else Path(out)
        self._until_left = ExitStack()
        self.periodic: list[_Periodic] = []
        scenario = channel if scenario is None else scenario
        self.channel_info = "a simulated bus in virtual time"
        self._held = world is not None
        self._border = _world_of(scenario, seed, operator, memory) if world is None else world
        super().__init__(channel="virtual", **options)
        if script_time:
            self._until_left.enter_context(time_of(self))

    @property
    def now_us(self) -> int:
        """Virtual time since power-on, us."""
        return self._border.now_us

    @property
    def now_s(self) -> float:
        """Virtual time since power-on, s."""
        return self._border.now_us * 1e-6

    @property
    def has_been_left(self) -> bool:
        """There is no time of its own any more."""
        return self._document is not None

    def sleep(self, seconds: float) -> None:
        """Let so much virtual time pass. Of another thread than the one that made the bus: real time."""
        if threading.current_thread() is not self._owner:
            _MACHINE["sleep"](seconds)
            return
        with self._talk:
            self._go_on(self._border.now_us + max(0, round(seconds * 1e6)))
        self._settle()

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Put a frame on the bus. An SDO request: and let time pass until it is answered, 5 s at most."""
        _require_classic(msg)
        asks = msg.arbitration_id & _SERVICE in _REQUESTS and len(msg.data) > 0 and msg.data[0] != _ABORT
        with self._talk:
            self._require_there()
            self._border.send(msg.arbitration_id, bytes(msg.data))
            if asks:
                answer = msg.arbitration_id + _TO_ANSWER
                self._go_on_to(answer)
        self._settle()

    def turn_table(self, angle_deg: float, speed_deg_s: float) -> None:
        """Turn the table, as World.turn_table does. Raises can.CanOperationError."""
        self._require_there()
        try:
            self._border.turn_table(angle_deg, speed_deg_s)
        except Refused as refused:
            raise can.CanOperationError(str(refused)) from None

    def _send_periodic_internal(
        self,
        msgs: Sequence[can.Message] | can.Message,
        period: float,
        duration: float | None = None,
        autostart: bool = True,
        modifier_callback: Callable[[can.Message], None] | None = None,
    ) -> _Periodic:
        task = _Periodic(self, msgs, period, duration, modifier_callback)
        if autostart:
            task.start()
        return task

    def _send_due(self) -> int:
        """What is sent periodically. Returns when the next of it is due."""
        for task in [task for task in self.periodic if task.due_us <= self.now_us]:
            message = task.take()
            if message is not None:
                self._border.send(message.arbitration_id, bytes(message.data))
        return min((task.due_us for task in self.periodic), default=FOREVER_US)

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """The next frame that has come or, of the thread that made the bus, comes within so much virtual time (of
        another thread: real time)."""
        if threading.current_thread() is not self._owner:
            return super().recv(timeout)
        until_us = None if timeout is None else self._border.now_us + max(0, round(timeout * 1e6))
        with self._talk:
            while True:
                while self._frames:
                    message = self._frames.popleft()
                    if self._matches_filters(message):
                        return message
                if until_us is not None and self._border.now_us >= until_us:
                    return None
                self._go_on(self._border.now_us + _FOREVER_US if until_us is None else until_us, FRAME)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        return self._take(timeout), False

    def _take(self, timeout: float | None) -> can.Message | None:
        """Another thread's next frame, of those that have come."""
        me = threading.current_thread()
        with self._come:
            self._readers.add(me)
            self._busy.discard(me)
            self._come.notify_all()
            if not self._come.wait_for(lambda: self._frames, timeout):
                return None
            self._busy.add(me)
            return self._frames.popleft()

    def _settle(self) -> None:
        """Until the other threads that receive have taken all that has come, and done with it what they do."""
        if threading.current_thread() is not self._owner or not self._readers:
            return
        with self._come:
            self._come.notify_all()
            for _ in range(round(_STUCK_S / 0.1)):
                self._readers = {thread for thread in self._readers if thread.is_alive()}
                self._busy &= self._readers
                if not self._readers or self._come.wait_for(lambda: not self._frames and not self._busy, 0.1):
                    return
        raise can.CanOperationError(f"a thread that receives has taken no frame for {_STUCK_S:.0f} s")

    def _go_on_to(self, answer: int) -> None:
        """Let virtual time pass until a frame with this identifier has come, or in vain."""
        until_us = self._border.now_us + _ANSWER_US
        while self._border.now_us < until_us:
            if any(message.arbitration_id == answer for message in self._go_on(until_us, FRAME)):
                return

    def _go_on(self, until_us: int, stop_at: int = 0) -> list[can.Message]:
        """Let virtual time pass until a moment, or the first frame. Returns what has come."""
        self._require_there()
        happened, next_us = 0, 0
        while not happened and next_us <= until_us:
            next_us = self._send_due()
            happened = self._border.advance(min(next_us, until_us), stop_at)
        new = self._border.frames(self._told)
        self._told += len(new)
        come = [self._message(*frame) for frame in new.tolist() if frame[3] != _GUEST]
        with self._come:
            self._frames.extend(come)
        if happened & ENDED:
            raise can.CanOperationError("the simulated run has come to its end")
        return come

    def _message(self, time_us: int, identifier: int, length: int, _sender: int, data: bytes) -> can.Message:
        return can.Message(
            timestamp=time_us * 1e-6,
            arbitration_id=identifier,
            is_extended_id=False,
            data=data[:length],
            channel=self.channel_info,
        )

    def _require_there(self) -> None:
        if self.has_been_left:
            raise can.CanOperationError("the bus has been shut down")

    def end(self) -> dict[str, Any]:
        """Leave the bus, and let the table come to rest: the document of the run, tumble.bench/1, with `truth` (K, U0
        and the stand's errors), state, reason, result and counters."""
        self.shutdown()
        assert self._document is not None
        return bench.written(self._document)

    def shutdown(self) -> None:
        """Leave the bus. Raises OSError where the folder cannot be written."""
        super().shutdown()
        self._until_left.close()
        if self._document is not None:
            return
        if not self._held:
            self._border.end("left")
            self._border.advance(FOREVER_US, 0)
        self._document = self._border.document()
        if self._out is not None:
            self._out.mkdir(exist_ok=True)
            in_process.write(self._border, self._out)


def _world_of(scenario: str | os.PathLike[str] | None, seed: int, operator: str, memory: bool) -> Border:
    """A world whose computer waits for commands."""
    file = "the defaults" if scenario is None or scenario in _PAPER else os.fspath(scenario)
    given = b"" if scenario in _PAPER else read_bytes(file)
    lines = [line.decode("ascii", "replace") for line in given.split(b"\n")]
    try:
        return Border(seed, _waiting(lines), None, operator, memory)
    except Refused as refused:
        raise can.CanInitializationError(refused.where(file)) from None


def _waiting(lines: list[str]) -> list[str]:
    """The computer begins nothing by itself, whatever the scenario says."""
    starts = "firmware.starts"
    return [*("" if line.partition("=")[0].strip() == starts else line for line in lines), f"{starts} = no"]


def _require_classic(message: can.Message) -> None:
    odd = message.is_extended_id or message.is_remote_frame or message.is_fd or message.is_error_frame
    if odd or not 0 <= message.arbitration_id <= 0x7FF or len(message.data) > 8:
        raise can.CanOperationError("only classic data frames with 11-bit identifiers can be sent")


class _Periodic(can.LimitedDurationCyclicSendTaskABC, can.ModifiableCyclicTaskABC, can.RestartableCyclicTaskABC):
    """Messages in turn, one every `period` seconds of the bus's time, for `duration` seconds."""

    def __init__(
        self,
        bus: VirtualBus,
        messages: Sequence[can.Message] | can.Message,
        period: float,
        duration: float | None,
        modify: Callable[[can.Message], None] | None,
    ):
        super().__init__(messages, period, duration)
        for message in self.messages:
            _require_classic(message)
        self._bus, self._modify = bus, modify
        self.due_us = self._end_us = self._number = 0

    def start(self) -> None:
        """Begin, or begin anew."""
        self.stop()
        self.due_us = self._bus.now_us
        self._end_us = FOREVER_US if self.duration is None else self.due_us + round(self.duration * 1e6)
        self._bus.periodic.append(self)

    def stop(self) -> None:
        """Until `start`."""
        if self in self._bus.periodic:
            self._bus.periodic.remove(self)

    def take(self) -> can.Message | None:
        """The message that is due; None: the end has come."""
        if self.due_us >= self._end_us:
            self.stop()
            return None
        message = self.messages[self._number % len(self.messages)]
        self._number += 1
        self.due_us = self._bus.now_us + max(1, round(self.period * 1e6))
        if self._modify is not None:
            self._modify(message)
        return message


class _Script(NamedTuple):
    """A thread whose time is a bus's; `power_on`: what its clocks said then."""

    thread: threading.Thread
    bus: VirtualBus
    power_on: dict[str, float]


_scripts: list[_Script] = []
_MACHINE: dict[str, Callable[..., Any]] = {name: getattr(time, name) for name in ("sleep", "monotonic", "time")}


def _script() -> _Script | None:
    return next((one for one in reversed(_scripts) if one.thread is threading.current_thread()), None)


def _sleep(seconds: float) -> None:
    script = _script()
    (_MACHINE["sleep"] if script is None or script.bus.has_been_left else script.bus.sleep)(seconds)


def _clock(name: str) -> Callable[[], float]:
    def read() -> float:
        script = _script()
        return float(_MACHINE[name]() if script is None else script.power_on[name] + script.bus.now_s)

    return read


_VIRTUAL: dict[str, Callable[..., Any]] = {"sleep": _sleep, "monotonic": _clock("monotonic"), "time": _clock("time")}


def _install(functions: dict[str, Callable[..., Any]]) -> None:
    for name, function in functions.items():
        setattr(time, name, function)


@contextmanager
def time_of(bus: VirtualBus) -> Iterator[None]:
    """For this thread, which has made the bus, time.sleep, time.monotonic and time.time are virtual: a script that
    waits by them lets the bus go on. Other threads keep the machine's."""
    power_on = {name: getattr(time, name)() - bus.now_s for name in ("monotonic", "time")}
    script = _Script(threading.current_thread(), bus, power_on)
    _scripts.append(script)
    _install(_VIRTUAL)
    try:
        yield
    finally:
        _scripts.remove(script)
        if not _scripts:
            _install(_MACHINE)
