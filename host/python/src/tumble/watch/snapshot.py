"""What is known of a run at one moment, in numbers and words; unknown is None. And what a listener hears of it on CAN:
the computer's process data, the drive's, emergencies. It sends nothing.

Identifiers are those at power-on (docs/bus/README.md). Where they were changed, nothing is heard, and a reader has to
ask.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import msgspec
from msgspec.structs import replace

from tumble.client import names
from tumble.client.tables import REASONS
from tumble.documents.base import written
from tumble.documents.watch import Outage, Snapshot, Watch
from tumble.firmware_tables import STATES

STANDS = ("OFFLINE", "READY", "HOMING", "MOVING", "IN_POSITION", "STOPPED", "FAULT")  # tumble_stand_state_t
ANGLE_KNOWN = ("MOVING", "IN_POSITION", "STOPPED")
_REASONS = {name: (meaning, remedy) for name, meaning, remedy in REASONS}


def with_sentences(now: Snapshot) -> Snapshot:
    """State, action, problem and remedy as a sentence, as far as known."""
    sentence, remedy = _REASONS.get(now.reason or "", (None, None))
    return replace(now, meaning=STATES.get(now.state or ""), sentence=sentence, remedy=remedy)


class Lost(Exception):
    """The source does not answer. The message follows "connection lost: "."""


class Source(Protocol):
    """A source of snapshots of a run."""

    def snapshot(self) -> Snapshot:
        """The current state. Raises Lost."""

    def close(self) -> None:
        """Release the source; no snapshot is taken after this."""


class View(msgspec.Struct, frozen=True):
    """What viewers see: the last snapshot (None: none yet), and whether it is current. `name`: of the source. `time`:
    of the snapshot; `lost_since`: since when the source has not answered; both in seconds since 1970 UTC. `why`: the
    reason that it does not answer."""

    name: str
    number: int
    time: float
    snapshot: Snapshot | None = None
    lost_since: float | None = None
    why: str | None = None


def document(view: View) -> dict[str, Any]:
    """A view as JSON. Infinite values and NaN become null."""
    lost = None if view.lost_since is None else Outage(view.lost_since, view.why or "")
    shown = None if view.snapshot is None else with_sentences(view.snapshot)
    return written(
        Watch(source=view.name, time_unix_s=view.time, lost=lost, snapshot=shown),
        lambda value: None if isinstance(value, float) and not math.isfinite(value) else value,
    )


def without_prefix(name: str) -> str:
    """A name of the firmware without its prefix: AVERAGE for TUMBLE_STATE_AVERAGE."""
    for prefix in ("TUMBLE_STATE_", "TUMBLE_REASON_", "TUMBLE_STAND_"):
        name = name.removeprefix(prefix)
    return name


STATE_PDO, SERVICE_PDO, DRIVE_PDO = 0x181, 0x6C1, 0x182
EMERGENCIES = {0x081: "navcomp", 0x082: "drive", 0x083: "block"}
IDENTIFIERS = (STATE_PDO, SERVICE_PDO, DRIVE_PDO, *EMERGENCIES)
_FRESH_S = 2.5  # the state is sent every second at the latest


@dataclass(frozen=True)
class Status:
    """The objects 2000h, 2001h, 2003h:1, :3 and :7, as in transmit PDO 3."""

    state: int
    reason: int
    index: int
    finished: int
    samples: int

    @property
    def told(self) -> dict[str, Any]:
        """The values by the names of a Snapshot."""
        state = names.state(self.state)
        reason = names.reason(self.reason).name if self.reason else None
        samples = self.samples if state == "AVERAGE" else None
        return {"state": state, "reason": reason, "finished": self.finished, "samples": samples}


class Heard:
    """What frames on the bus have said. One thread passes frames, another reads. `clock`: seconds."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._lock = threading.Lock()
        self._status: Status | None = None
        self._status_s = 0.0
        self._run: int | None = None
        self._drive: bytes | None = None
        self._drive_changed = True
        self._emergencies: dict[str, int] = {}

    def frame(self, identifier: int, data: bytes) -> None:
        """Process a frame."""
        with self._lock:
            if identifier == STATE_PDO and len(data) == 8:
                self._status = Status(data[0], data[1], data[2], data[3], int.from_bytes(data[4:], "little"))
                self._status_s = self._clock()
            elif identifier == SERVICE_PDO and len(data) == 7:
                self._run = int.from_bytes(data[3:], "little")
            elif identifier == DRIVE_PDO and data != self._drive:
                self._drive, self._drive_changed = bytes(data), True
            elif identifier in EMERGENCIES and len(data) >= 2:
                self._emergencies[EMERGENCIES[identifier]] = int.from_bytes(data[:2], "little")

    def status(self) -> Status | None:
        """The last status, while it is fresh."""
        with self._lock:
            return self._status if self._clock() - self._status_s <= _FRESH_S else None

    def run(self) -> int | None:
        """The number of the run."""
        with self._lock:
            return self._run

    def drive_has_changed(self) -> bool:
        """Whether the drive has reported something new since the last call, above all a position."""
        with self._lock:
            changed, self._drive_changed = self._drive_changed, False
            return changed

    def emergencies(self) -> dict[str, str]:
        """Active emergencies by node: the error code (CiA 301) as hexadecimal digits."""
        with self._lock:
            return {node: f"{code:04X}" for node, code in self._emergencies.items() if code}
