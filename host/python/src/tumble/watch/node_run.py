"""A navigation computer as a source: over CAN it listens and uploads by SDO, over Modbus it reads input registers. It
never writes."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from tumble.client import open_link
from tumble.client.can_link import CanLink
from tumble.client.link import CommunicationError, Link, Value, keep_quiet
from tumble.documents.watch import Gravity, Matrix, Mean, Snapshot, Vector
from tumble.errors import TumbleError, UsageError, quoted
from tumble.watch.runs import FolderRun
from tumble.watch.snapshot import ANGLE_KNOWN, IDENTIFIERS, STANDS, Heard, Lost, Source, Status

_AXES = "xyz"
_STATUS = ("State", "Reason", "Progress: Position index", "Progress: Positions finished", "Progress: Samples taken")
_PLACE = ("Mounting number", "Position number", "Position count", "Attempt", "Samples wanted", "Target angle")
_TABLE = ("Stand state", "Actual angle", "Block temperature")
_GRAVITY = (
    *("Largest deviation on fit positions", "Largest deviation on check positions", "Limit"),
    *("Fit positions judged", "Check positions judged", "Pass"),
)
_WITH_RESULT = ("VERIFY", "PROPOSE", "DONE", "FAULT", "ABORT", "IDLE")
_FEWEST = 2  # samples that make a mean and its error
_HALF_DEGREES_C = 2.0
_TIMES_ASKED = 5  # where others ask as well


KINDS = "bench, can:INTERFACE, modbus:HOST:PORT, modbus-rtu:DEVICE or the folder of a run"


def opened(name: str) -> Source:
    """Open the source that the user names. Raises UsageError; NotInstalled, Skipped where this machine lacks
    something."""
    if name.startswith(("can:", "modbus:", "modbus-rtu:")):
        keep_quiet("can", "canopen", "pymodbus")  # what they have to say comes as an exception as well
        return NodeRun(name)
    folder = FolderRun(Path(name))
    if folder.is_there():
        return folder
    raise UsageError(f"{quoted(name)} is neither {KINDS}")


class NodeRun:
    """A run on a navigation computer. `spec`: as for tumble.client.connect. The link is opened at once, so that
    mistakes show at once: raises UsageError, NotInstalled, Skipped. A node that does not answer yet may answer
    later."""

    def __init__(self, spec: str, opened: Callable[[str], Link] = open_link):
        self._spec, self._open = spec, opened
        self._link: Link | None = None
        self._heard: Heard | None = None
        self._why: str | None = None
        try:
            self._connect()
        except CommunicationError as error:
            self._why = str(error)

    def snapshot(self) -> Snapshot:
        """Read the state of the node. Raises Lost; the next call reconnects."""
        try:
            if self._why is not None:  # has been found out just now
                raise CommunicationError(self._why)
            link = self._link or self._connect()
            now, self._key, self._result = link.of_one_moment(lambda: self._read(link))
            self._last = now
            return now
        except _failures() as error:
            self._why = None
            self.close()
            raise Lost(str(error)) from None

    def close(self) -> None:
        """Close the link."""
        link, self._link = self._link, None
        if link is not None:
            with contextlib.suppress(*_failures()):
                link.close()

    def _connect(self) -> Link:
        link = self._link = self._open(self._spec)
        self._last, self._key, self._result = Snapshot(), None, None
        self._heard = _listening(link) if isinstance(link, CanLink) else None
        return link

    def _read(self, link: Link) -> tuple[Snapshot, Any, Any]:
        """Read what may have changed since the last reading, and what shows at the next one whether place and result
        have."""
        status, run = self._status(link)
        told = status.told
        state = told["state"]
        key: Any = (status.state, status.index, status.finished, run)
        now = self._last
        if key != self._key:
            now = replace(now, **_place(link))
        if self._heard is None or key != self._key or self._heard.drive_has_changed():
            now = replace(now, **_table(link))
        result: Any = (run, state if state in _WITH_RESULT else None)
        if result != self._result:
            now = replace(now, **_found_twice(link))
        now = replace(now, run=run, emergencies={} if self._heard is None else self._heard.emergencies(), **told)
        grown = key != self._key or now.samples != self._last.samples
        if grown and now.samples is not None and now.samples >= _FEWEST:
            now = replace(now, mean=_mean(link, now))
        elif run != self._last.run:
            now = replace(now, mean=None)
        complete = state != "DONE" or None not in (now.k_v_per_g, now.u0_v)
        return now, key, result if complete else None

    def _status(self, link: Link) -> tuple[Status, int | None]:
        heard = None if self._heard is None else self._heard.status()
        run = None if self._heard is None else self._heard.run()
        if heard is not None and run is not None:
            return heard, run
        *asked, run_asked = _asked(link, *_STATUS, "Run number")
        return Status(*map(_whole, asked)), _whole(run_asked)


def _failures() -> tuple[type[Exception], ...]:
    """The exceptions that a link raises when the other end has gone."""
    try:
        from can import CanError
    except ImportError:
        return TumbleError, OSError
    return TumbleError, OSError, CanError


def _listening(link: CanLink) -> Heard:
    """Start to listen. Of other traffic, only answers to our own requests reach this process."""
    heard = Heard()
    network = link.network
    for identifier in IDENTIFIERS:
        network.subscribe(identifier, lambda number, data, _: heard.frame(number, bytes(data)))
    assert network.bus is not None  # it is connected
    wanted = (*IDENTIFIERS, *network.subscribers)
    network.bus.set_filters([{"can_id": one, "can_mask": 0x7FF, "extended": False} for one in sorted(set(wanted))])
    return heard


def _asked(link: Link, *names: str) -> list[Value]:
    """Read objects that every node always has. On CAN, None means that the answer was to another client."""
    found = link.read_together(*names)
    for _ in range(_TIMES_ASKED):
        if None not in found:
            break
        found = link.read_together(*names)
    return found


def _place(link: Link) -> dict[str, Any]:
    mounting, position, count, attempt, wanted, target = _asked(link, *(f"Progress: {one}" for one in _PLACE))
    numbers = {"mounting": mounting, "position": position, "count": count, "attempt": attempt, "wanted": wanted}
    return {**numbers, "target_rad": _radians(target)}


def _table(link: Link) -> dict[str, Any]:
    stand, angle, temperature = _asked(link, *(f"Progress: {one}" for one in _TABLE))
    number = _whole(stand)
    name = STANDS[number] if number < len(STANDS) else f"STAND_{number}"
    return {
        "stand": name,
        "angle_rad": _radians(angle) if name in ANGLE_KNOWN else None,
        "temperature_c": None if temperature is None else _number(temperature) / _HALF_DEGREES_C,
    }


def _mean(link: Link, now: Snapshot) -> Mean | None:
    """The mean of the open position, each channel as of its own reading."""
    names = (f"{one}: {one} {axis}" for one in ("Running mean", "Standard error") for axis in _AXES)
    found = link.read_together(*names)
    mean, error = _vector(found[:3]), _vector(found[3:])
    if mean is None:
        return None
    return Mean(now.mounting, now.position, now.samples, now.wanted, mean, error)


def _found_twice(link: Link) -> dict[str, Any]:
    """Read the result of the last run until two readings agree: on CAN, another client of the same SDO server may
    disturb a transfer unnoticed. The node keeps the result until the next run."""
    before = _found(link)
    for _ in range(_TIMES_ASKED):
        again = _found(link)
        if again == before:
            break
        before = again
    return before


def _found(link: Link) -> dict[str, Any]:
    return {
        "k_v_per_g": _matrix(link, "K"),
        "u0_v": _of_channels(link, "U0"),
        "u_k_v_per_g": _matrix(link, "u_K"),
        "u_u0_v": _of_channels(link, "u_U0"),
        "gravity": _gravity(link),
    }


def _matrix(link: Link, name: str) -> Matrix | None:
    found = _all(link, [f"{name}: {name}_{row}{column}" for row in _AXES for column in _AXES])
    return None if found is None else (found[:3], found[3:6], found[6:])


def _of_channels(link: Link, name: str) -> Vector | None:
    return _all(link, [f"{name}: {name}_{axis}" for axis in _AXES])


def _all(link: Link, names: list[str]) -> Vector | None:
    """Read all of these objects, or return None. On CAN, the others are not read if the first is unknown."""
    if not link.has(names[0]) or (isinstance(link, CanLink) and link.read(names[0]) is None):
        return None
    return _vector(link.read_together(*names))


def _gravity(link: Link) -> Gravity | None:
    found = link.read_together(*(f"Gravity check: {one}" for one in _GRAVITY))
    fit, check, limit, fitted, checked, passed = found
    judged = bool(fitted) or bool(checked)
    return Gravity(
        _number(fit) if fitted and fit is not None else None,
        _number(check) if checked and check is not None else None,
        None if limit is None else _number(limit),
        bool(passed) if judged and passed is not None else None,
    )


def _vector(values: list[Value]) -> Vector | None:
    return None if any(value is None for value in values) else tuple(map(_number, values))


def _radians(value: Value) -> float | None:
    return None if value is None else math.radians(_number(value))


def _number(value: Value) -> float:
    if not isinstance(value, int | float):
        raise CommunicationError(f"the node sends {value!r} where a number is expected")
    return float(value)


def _whole(value: Value) -> int:
    return int(_number(value))
