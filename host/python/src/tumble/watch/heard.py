"""What a listener hears of a navigation computer on CAN: its process data, the drive's, emergencies. It sends nothing.

Identifiers are those at power-on (docs/bus/README.md). Where they were changed, nothing is heard, and a reader has to
ask.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

STATE_PDO, SERVICE_PDO, DRIVE_PDO = 0x181, 0x6C1, 0x182
EMERGENCIES = {0x081: "navcomp", 0x082: "drive", 0x083: "block"}
IDENTIFIERS = (STATE_PDO, SERVICE_PDO, DRIVE_PDO, *EMERGENCIES)
_FRESH_S = 2.5  # the state is sent every second at the latest


@dataclass(frozen=True)
class Status:
    """2000h, 2001h, 2003h:1, :3 and :7, as transmit PDO 3 has them."""

    state: int
    reason: int
    index: int
    finished: int
    samples: int


class Heard:
    """Given frames in one thread, asked in another. `clock`: seconds."""

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
        """Take one."""
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
        """The last one, while it is fresh."""
        with self._lock:
            return self._status if self._clock() - self._status_s <= _FRESH_S else None

    def run(self) -> int | None:
        """The number of the run."""
        with self._lock:
            return self._run

    def drive_has_changed(self) -> bool:
        """Whether the drive has told something new since this was asked last; its position above all."""
        with self._lock:
            changed, self._drive_changed = self._drive_changed, False
            return changed

    def emergencies(self) -> dict[str, str]:
        """Of each node that has raised one and not taken it back: its error code (CiA 301), as hexadecimal digits."""
        with self._lock:
            return {node: f"{code:04X}" for node, code in self._emergencies.items() if code}
