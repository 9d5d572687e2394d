"""Logs of a bus in other forms than candump's, rewritten in that form: whatever python-can reads."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

from tumble.errors import BadInput
from tumble.files import can_log
from tumble.files.can_log import CANDUMP, CanLog, Frame

READABLE = "candump -L, ASC, BLF, TRC, MF4, CSV of python-can"
_SUFFIXES = {".asc": can_log.ASC, ".blf": can_log.BLF, ".trc": can_log.TRC, ".mf4": can_log.MF4}
_MOST_BYTES, _MOST_IDENTIFIER = 8, 0x7FF


class Read(NamedTuple):
    """`path`: of the log in candump's form. `time_step_us`: all times are multiples of this; None: not looked at."""

    path: str
    format: str
    time_step_us: int | None


def as_candump(log: str, folder: Path) -> Read:
    """A log as tumble-replay reads it: itself, or rewritten into a file of `folder`. Frames that are no classic ones of
    11 bits are left out; times are rounded to microseconds and count from the first frame, as far as it is not older.

    Raises BadInput, NotInstalled.
    """
    try:
        data = Path(log).read_bytes()
    except OSError:
        return Read(log, CANDUMP, None)  # which tumble-replay complains of
    kind = can_log.kind_of(data)
    named = _SUFFIXES.get(Path(log).suffix.lower())
    if kind is None and (data.strip() or named):
        said = f"called {Path(log).suffix}, but is no log in {named}" if named else "is no CAN log"
        raise BadInput(f"{said}; these can be read: {READABLE}", log)
    if kind in (None, CANDUMP):
        return Read(log, CANDUMP, None)
    frames = [frame for frame in CanLog(data, log, kind) if _is_classic(frame)]
    if not frames:
        raise BadInput("holds no frames", log)
    times_us = [round(1e6 * (frame.seconds - frames[0].seconds)) for frame in frames]
    path = folder / "bus.log"
    path.write_text("".join(map(_line, times_us, frames)), encoding="ascii")
    return Read(str(path), kind, math.gcd(*times_us))


def _is_classic(frame: Frame) -> bool:
    return not frame.extended and len(frame.data) <= _MOST_BYTES and frame.identifier <= _MOST_IDENTIFIER


def _line(time_us: int, frame: Frame) -> str:
    """Of candump -L. A time before that of the first frame is taken for the same."""
    seconds, fraction = divmod(max(time_us, 0), 1_000_000)
    return f"({seconds:010}.{fraction:06}) can0 {frame.identifier:03X}#{frame.data.hex().upper()}\n"
