"""Logs of a CAN bus, frame by frame: candump -L, what candump shows on a screen, Vector's ASC and BLF, PEAK's TRC,
ASAM MF4, CSV of python-can.

Which of them a file is, shows in its beginning, whatever its name. python-can reads them (MF4 by asammdf); it is loaded
when there is such a file.
"""

from __future__ import annotations

import gc
import io
import itertools
import re
import sys
import traceback
from collections.abc import Iterator
from datetime import datetime, timezone
from typing import Any, NamedTuple

from tumble.errors import BadInput, NotInstalled, file_name, needing, quoted
from tumble.files.disk import bounded
from tumble.files.run_layout import decoded

CANDUMP, ASC, BLF, TRC, MF4, CSV = "candump", "ASC", "BLF", "TRC", "MF4", "python-can CSV"
SCREEN = "candump's screen"
HEAD = 4096  # bytes that tell it
_KINDS = {  # how each begins; what reads it in python-can
    BLF: (rb"LOGG", "BLFReader"),
    MF4: (rb"(MDF     |UnFinMF )4\.", "MF4Reader"),
    CSV: (rb"timestamp,arbitration_id,extended,remote,error,dlc,data\s", "CSVReader"),
    TRC: (rb";(\$FILEVERSION=|#{40})", "TRCReader"),
    ASC: (rb"(?is)(//[^\n]*\n)*date [^\n]*\n(//[^\n]*\n)*base\s+(hex|dec)\b", "ASCReader"),
    CANDUMP: (rb"\s*\(\d+\.\d+\)\s+\S+\s+[0-9A-Fa-f]{3,8}#", "CanutilsLogReader"),
    SCREEN: (
        rb"\s*(\([-\d.: ]+\)\s+)?\w+\s+([RT]X\s+\S+\s+\S+\s+)?([0-9A-F]{3}|[0-9A-F]{8})\s+\[\d+\]\s",
        "CanutilsLogReader",
    ),
}
_BINARY = (BLF, MF4)
_CANDUMP_LINE = re.compile(
    rb"\s*\((\d{1,10})\.(\d{6})\)\s+\S+\s+"
    rb"(?:[0-9A-Fa-f]{8}#|([0-7][0-9A-Fa-f]{2})#(?:[R#]|((?:[0-9A-Fa-f]{2}){0,8})(?:\s|$)))"
)


_SCREEN_LINE = re.compile(
    r"\s*(?:\(([-\d.: ]+)\)\s+)?(\w+)\s+(?:[RT]X\s+\S+\s+\S+\s+)?([0-9A-F]{3}|[0-9A-F]{8})\s+\[\d+\]"
    r"((?:\s+[0-9A-F]{2}\b)*)(.*)"
)


class Frame(NamedTuple):
    """A data frame. `seconds`: of the logger's clock; `channel`: the interface, empty if the log names none; `line`: of
    a text, or the number of the message."""

    seconds: float
    identifier: int
    extended: bool
    channel: str
    data: bytes
    line: int


def kind_of(data: bytes) -> str | None:
    """What kind of CAN log this is, as it is called in messages; None: it is none."""
    head = data[:HEAD].removeprefix(b"\xef\xbb\xbf")
    return next((kind for kind, (beginning, _) in _KINDS.items() if re.match(beginning, head)), None)


def refuse(data: bytes, file: str) -> None:
    """Raises BadInput for a CAN log, where a run file is wanted."""
    if (kind := kind_of(data)) is not None:
        advice = f"tumble import {file_name(file)} --out RUN.csv finds them by the rests"
        raise BadInput(f"is a CAN log ({kind}), which has no positions: {advice}", file)


def candump_frames(data: bytes, file: str) -> Iterator[tuple[int, int, bytes]]:
    """Time in microseconds, identifier and data of the classic data frames of 11 bits in a log of candump -L: all that
    it says of them, where python-can rounds times, and guesses at what is no such line. Raises BadInput with the line.
    """
    for number, line in enumerate(io.BytesIO(data), start=1):
        if line.isspace():
            continue
        found = _CANDUMP_LINE.match(line)
        if found is None:
            raise BadInput(
                "is not a line of candump -L: (seconds.microseconds) interface ID#DATA", f"{file_name(file)}:{number}"
            )
        seconds, fraction, identifier, own = found.groups()
        if own is not None:
            yield int(seconds) * 1_000_000 + int(fraction), int(identifier, 16), bytes.fromhex(own.decode("ascii"))


class CanLog:
    """The frames of a log, to be gone through once. `frames`: how many have been read; `torn`: the last line is not
    whole, as when the logger lost its power, and was left out.

    Raises BadInput with file and line, NotInstalled where a package is missing.
    """

    def __init__(self, data: bytes, file: str, kind: str):
        self.frames = 0
        self.torn = False
        self._file, self._kind = file, kind
        text = "" if kind in _BINARY else decoded(data)
        self._lines = None if kind in _BINARY else _Lines(_as_log(text, file) if kind == SCREEN else text)
        reader = _reader_of(file, kind)
        try:
            with bounded(file):
                self._reader = reader(io.BytesIO(data) if self._lines is None else self._lines)
        except Exception as error:  # each reader has its own for what it does not know
            raise self._refusal(error) from None

    def __iter__(self) -> Iterator[Frame]:
        try:
            with bounded(self._file):
                yield from self._frames()
        except BadInput:
            raise
        except Exception as error:  # likewise
            if not self.frames or self._lines is None or not self._lines.at_end:
                raise self._refusal(error) from None
            self.torn = True
        if getattr(self._reader, "timestamps_format", None) == "relative":
            raise BadInput("its times count from the line before; log it with absolute timestamps", self._file)

    def _frames(self) -> Iterator[Frame]:
        for number, message in enumerate(self._reader, 1):
            if message.is_error_frame or message.is_remote_frame:
                continue
            self.frames += 1
            channel = "" if message.channel is None else str(message.channel)
            line = number if self._lines is None else self._lines.number
            data = bytes(message.data)
            yield Frame(message.timestamp, message.arbitration_id, message.is_extended_id, channel, data, line)

    def _refusal(self, error: Exception) -> BadInput:
        row = None if self._lines is None or not self._lines.number else self._lines.number
        place = f" after {self.frames} frames" if self._lines is None else ""
        why = f": {quoted(error)}" if str(error) else ""
        _forget(error)
        return BadInput(f"cannot be read as a CAN log ({self._kind}){place}{why}", self._file, row)


def _as_log(text: str, file: str) -> str:
    """What candump shows on a screen, line by line as candump -L has it; lines of anything else stay empty. Raises
    BadInput where it does not show the time."""
    found = [_SCREEN_LINE.match(line) for line in text.splitlines()]
    if any(one is not None and one[1] is None for one in found):
        raise BadInput("candump's screen without times: log it with candump -L", file)
    seconds = [0.0 if one is None else _seconds_of(one[1]) for one in found]
    shown = [second for one, second in zip(found, seconds) if one is not None]
    if sum(b < a for a, b in itertools.pairwise(shown)) > len(shown) // 10:  # each since the frame before (-td)
        seconds = list(itertools.accumulate(seconds))
    lines = []
    for one, second in zip(found, seconds):
        is_frame = one is not None and "ERRORFRAME" not in one[5] and "remote request" not in one[5]
        lines.append(f"({second:.6f}) {one[2]} {one[3]}#{''.join(one[4].split())}" if one and is_frame else "")
    return "\n".join(lines) + "\n"


def _seconds_of(shown: str) -> float:
    """Of the seconds of -ta, -tz and -td, and of the date of -tA."""
    if "-" not in shown:
        return float(shown)
    return datetime.fromisoformat(shown.strip()).replace(tzinfo=timezone.utc).timestamp()


def _forget(error: BaseException | None) -> None:
    """Delete here, unheard, what a reader had half made when it failed: asammdf's complains on standard error then."""
    hook, sys.unraisablehook = sys.unraisablehook, lambda _: None
    try:
        while error is not None:
            traceback.clear_frames(error.__traceback__)
            error = error.__context__
        gc.collect()
    finally:
        sys.unraisablehook = hook


class _Lines(io.StringIO):
    """Text that knows how many of its lines have been read: `number`."""

    def __init__(self, text: str):
        super().__init__(text, newline=None)
        self.number = 0
        self._lines = text.count("\n") + (not text.endswith("\n"))

    def __next__(self) -> str:  # type: ignore[override] # as that of StringIO, whose base has bytes
        line = super().__next__()
        self.number += 1
        return line

    @property
    def at_end(self) -> bool:
        """Is the line that was read last the last one?"""
        return self.number >= self._lines


def _reader_of(file: str, kind: str) -> Any:
    """The class of python-can that reads such logs. Raises NotInstalled."""
    with needing(f"{file_name(file)}: a CAN log", "python-can", extra="can"):
        import can
    reader = _KINDS[kind][1]
    if not hasattr(can, reader):
        raise NotInstalled(f"{file_name(file)}: a CAN log in {kind}", "a newer python-can", extra="can")
    if kind == MF4:
        with needing(f"{file_name(file)}: a CAN log in MF4", "asammdf", extra="mf4"):
            import asammdf  # noqa: F401
    import logging

    for library in ("can", "asammdf"):  # else their remarks would stand among ours
        logging.getLogger(library).handlers = [logging.NullHandler()]
    return getattr(can, reader)
