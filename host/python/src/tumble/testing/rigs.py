"""A stand and a node that wait for a script: in virtual time, or as processes on a CAN interface."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tumble.errors import BadInput, BenchFault, UsageError, quoted
from tumble.world import programs

if TYPE_CHECKING:
    import can

OPERATORS = ("by-itself", "on-confirm", "never")
FAST = {  # a calibration within seconds of real time
    "motion.speed_deg_s": 720,
    "motion.acceleration_deg_s2": 7200,
    "motion.settling_s": 0.05,
    "profile.homing_fast_deg_s": 720,
    "profile.homing_slow_deg_s": 90,
    "procedure.settle_ms": 50,
    "procedure.samples": 10,
    "procedure.warm_up_samples": 5,
    "procedure.gravity_limit_g": 1e-3,
    "operator.mount_s": 0.05,
    "firmware.heartbeat_timeout_ms": 3000,
    "profile.heartbeat_timeout_ms": 3000,
    "profile.handshake_timeout_ms": 10000,
}
SERIAL = {"keeper.serial": "SIMULATED"}

_READY_S, _END_S = 60.0, 60.0

Document = dict[str, Any]


class Wanted:
    """What the marker `tumble` says.

    `operator`: who mounts the block (OPERATORS); `seed`: of all that is random; `scenario`: a scenario file, else the
    keys FAST; `memory`: the node keeps coefficients; `keys`: more keys of the scenario, `__` for the
    point, a list for a key that comes several times. `unnamed`: there must be none. Raises UsageError.
    """

    def __init__(
        self,
        *unnamed: object,
        operator: str = "on-confirm",
        seed: int = 1,
        scenario: str | Path | None = None,
        memory: bool = False,
        **keys: Any,
    ):
        if unnamed:
            raise UsageError(f"tumble({quoted(unnamed[0])}): an argument needs its name, such as operator=")
        if operator not in OPERATORS:
            raise UsageError(f"tumble(operator=): {quoted(operator)} is not {', '.join(OPERATORS)}")
        self.operator, self.seed, self.memory = operator, seed, memory
        self._file = None if scenario is None else Path(scenario)
        self._keys = {name.replace("__", "."): value for name, value in keys.items()}

    def write(self, folder: Path) -> Path:
        """The scenario file. Raises BadInput."""
        try:
            text = "" if self._file is None else self._file.read_text("utf-8", "surrogateescape").rstrip("\n") + "\n"
        except OSError as error:
            raise BadInput(f"the scenario cannot be read: {error.strerror}", str(self._file)) from None
        usual = {**FAST, **(SERIAL if self.memory else {})} if self._file is None else {}
        for key, value in {**usual, **self._keys}.items():
            text += "".join(f"{key} = {one}\n" for one in (value if isinstance(value, list) else [value]))
        path = folder / "tumble-scenario.txt"
        path.write_text(text, encoding="utf-8", errors="surrogateescape")
        return path


@dataclass(frozen=True)
class Stand:
    """`operator`: who mounts the block."""

    operator: str
    _end: Callable[[], Document]
    _kill: Callable[[], None]

    def end(self) -> Document:
        """Switch it off, when the table is at rest. Returns its document: `truth` (K, U0 and the errors that were
        simulated), `faults`, `table`, `counters`; empty when it was killed."""
        return self._end()

    def kill(self) -> None:
        """Drive and block are silent from now on (SIGKILL). Raises UsageError in virtual time."""
        self._kill()


@dataclass(frozen=True)
class Node:
    """`link`: what tumble.client.connect takes."""

    link: str | can.BusABC
    _end: Callable[[], Document]

    def end(self) -> Document:
        """Switch it off. Returns its document of the last run: `state`, `reason`, `cause`, coefficients, `counters`; in
        virtual time that of both."""
        return self._end()


@dataclass(frozen=True)
class Rig:
    """Both."""

    stand: Stand
    node: Node


# In virtual time.


@contextmanager
def virtual(wanted: Wanted, folder: Path) -> Iterator[Rig]:
    """Both in one process, and the time of the caller's thread is theirs. Raises UsageError, BadInput, BenchFault."""
    import can

    from tumble.testing.virtual_bus import VirtualBus, time_of

    try:
        path = wanted.write(folder)
        bus = VirtualBus(path, seed=wanted.seed, operator=wanted.operator, memory=wanted.memory)
    except can.CanInitializationError as error:
        raise BenchFault(str(error)) from None
    try:
        with time_of(bus):
            yield Rig(Stand(wanted.operator, bus.end, _no_process), Node(bus, bus.end))
    finally:
        bus.shutdown()


def _no_process() -> None:
    raise UsageError("in virtual time the stand is no process; let a fault of the scenario take its power instead")


# On a CAN interface.


@contextmanager
def on_can(wanted: Wanted, folder: Path, where: str) -> Iterator[Rig]:
    """tumble-stand and tumble-node on the interface behind "can:". What they told is printed in the end, for pytest to
    show where a test fails. Raises BadInput, BenchFault."""
    interface, scenario = where.removeprefix("can:"), str(wanted.write(folder))
    memory = ["--nv", str(folder / "tumble-memory")] if wanted.memory else []
    options = ["--seed", str(wanted.seed), "--operator", wanted.operator]
    started: list[_Process] = []
    try:
        stand = _Process("tumble-stand", folder, interface, scenario, *options)
        started.append(stand)
        node = _Process("tumble-node", folder, interface, scenario, *memory)
        started.append(node)
        yield Rig(Stand(wanted.operator, stand.end, stand.kill), Node(where, node.end))
    finally:
        for process in reversed(started):
            process.kill()
            print(process.told(), end="")


class _Process:
    """One of our programs, from the moment when it is ready."""

    def __init__(self, name: str, folder: Path, *words: str):
        self._name, self._log = name, folder / f"{name}.log"
        self._document: Document | None = None
        command = [programs.find(name), *words, "--with-parent", "--log", "json"]
        with open(self._log, "w", encoding="utf-8") as log:
            self._process = subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log, start_new_session=True, text=True
            )
        self._wait_until_ready()

    def _wait_until_ready(self) -> None:
        end = time.monotonic() + _READY_S
        while not any(event.get("event") == "ready" for event in self._events()):
            if self._process.poll() is not None or time.monotonic() > end:
                self.kill()
                raise BenchFault(f"{self._name} does not start: {programs.last_words(self._log.read_text())}")
            time.sleep(0.01)

    def _events(self) -> list[Document]:
        lines = self._log.read_text(encoding="utf-8", errors="replace").split("\n")[:-1]
        return [json.loads(line) if line.startswith("{") else {"message": line} for line in lines]

    def told(self) -> str:
        """Its log, as text."""
        return "".join(f"{self._name}: {event.get('time', '')} {event['message']}\n" for event in self._events())

    def kill(self) -> None:
        """At once, if it has not ended."""
        if self._document is None:
            self._process.kill()
            self._close()

    def end(self) -> Document:
        """Tell it to end. Returns its last document; empty when it had none."""
        if self._document is None:
            self._process.send_signal(signal.SIGTERM)
            return self._close()
        return self._document

    def _close(self) -> Document:
        try:
            lines = self._process.communicate(timeout=_END_S)[0].splitlines()
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.communicate()
            raise BenchFault(f"{self._name} does not end within {_END_S:.0f} s") from None
        self._document = json.loads(lines[-1]) if lines else {}
        return self._document
