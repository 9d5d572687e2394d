"""A recorded bus log through the firmware again: in this process, or on the emulated board zcu102. Either way the same
numbers, to the last bit, as in the recorded run.
"""

from __future__ import annotations

import contextlib
import struct
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from msgspec import structs

from tumble.arrays import Floats
from tumble.documents.bench import Bench, Replay, ReplayCounters
from tumble.errors import BadInput, BenchFault, Skipped, UsageError, file_name
from tumble.files import can_log
from tumble.files.can_log import CANDUMP, CanLog
from tumble.files.disk import MIB, MOST_OF_RECORDING, joined
from tumble.world import emulator, folder
from tumble.world.border import FRAMES, Border, Refused, require_good

with contextlib.suppress(ImportError):  # which Border tells of
    from _tumble_world import ffi, lib

BOARD = "zcu102"
READABLE = "candump -L, ASC, BLF, TRC, MF4, CSV of python-can"

_SUFFIXES = {".asc": can_log.ASC, ".blf": can_log.BLF, ".trc": can_log.TRC, ".mf4": can_log.MF4}
_MOST_BYTES, _MOST_IDENTIFIER = 8, 0x7FF
_REFUSED = "commands_refused_in_replay"
_COUNTERS = {  # by our name: as the firmware has it
    "received": "frames_received",
    "samples": "procedure_samples",
    "averaged": "samples_averaged",
    "lost": "samples_lost",
    "retries": "retries",
    "commands_refused": _REFUSED,
}


class Log(NamedTuple):
    """`frames`: the classic data frames of 11 bits in the file, as border.FRAMES; their times never fall.
    `time_step_us`: all times are multiples of this; None: not looked at."""

    file: str
    frames: Any
    format: str
    time_step_us: int | None


def read(file: str) -> Log:
    """Read a log. A time before that of the predecessor is taken for the same. Raises BadInput, NotInstalled."""
    data = _bytes(file)
    kind = can_log.kind_of(data)
    named = _SUFFIXES.get(Path(file).suffix.lower())
    if kind is None and (data.strip() or named):
        said = f"called {Path(file).suffix}, but is no log in {named}" if named else "is no CAN log"
        raise BadInput(f"{said}; these can be read: {READABLE}", file)
    if kind in (None, CANDUMP):
        return Log(file, _frames(can_log.candump_frames(data, file), file), CANDUMP, None)
    frames = _frames(_from_the_first_on(CanLog(data, file, kind)), file)
    return Log(file, frames, kind, int(np.gcd.reduce(frames["time_us"])))


def _bytes(file: str) -> bytes:
    if Path(file).is_dir():
        raise BadInput("a folder, not a file; the log of a run folder is its bus.log", file)
    try:
        with open(file, "rb") as stream:
            return joined(iter(lambda: stream.read(MIB), b""), file, MOST_OF_RECORDING)
    except OSError as error:
        raise BadInput(error.strerror or "cannot be read", file) from None


def _from_the_first_on(log: CanLog) -> Iterator[tuple[int, int, bytes]]:
    """As can_log.candump_frames; times are rounded, and count from the first frame."""
    first = None
    for frame in log:
        if not frame.extended and len(frame.data) <= _MOST_BYTES and frame.identifier <= _MOST_IDENTIFIER:
            first = frame.seconds if first is None else first
            yield max(round(1e6 * (frame.seconds - first)), 0), frame.identifier, frame.data


def _frames(found: Iterable[tuple[int, int, bytes]], file: str) -> Any:
    rows = ((time_us, identifier, len(data), 0, data.ljust(_MOST_BYTES, b"\0")) for time_us, identifier, data in found)
    frames = np.fromiter(rows, FRAMES)
    if not len(frames):
        raise BadInput("holds no frames", file)
    frames["time_us"] = np.maximum.accumulate(frames["time_us"])
    return frames


class Firmware(Border):
    """The firmware of node 1 with a scenario, for which a log is to be the bus. Raises Refused."""

    def __init__(self, lines: Iterable[str], gains: bytes | None):
        self._set(lines, gains)
        require_good(lib.world_check(self._world))

    def play(self, frames: Any) -> None:
        """Power it on, and let the frames of others come in at their times. Raises Refused."""
        self._played, refused = frames, ffi.new("uint32_t *")
        require_good(lib.world_replay(self._world, *_as_c(frames), refused))
        self.commands_refused = int(refused[0])

    def frames(self, first: int = 0) -> Any:
        """Those of the log, node 1's included."""
        return self._played[first:]

    def document(self) -> Bench:
        """Counters are those of the firmware: there was no bus."""
        found = super().document()
        own = {name: value for name, value in found.counters.items() if not name.startswith("bus_")}
        return structs.replace(found, counters={**own, _REFUSED: self.commands_refused})

    def recording(self, frames: Any) -> bytes:
        """The log, for the board. Raises Refused."""
        first, size = ffi.new("uint8_t **"), ffi.new("size_t *")
        require_good(lib.world_recording(self._world, *_as_c(frames), first, size))
        return bytes(ffi.buffer(first[0], size[0]))

    def commissioning(self) -> bytes:
        """The record that tells the board what the scenario says. Raises Refused."""
        record, size = ffi.new("uint8_t[]", lib.WORLD_COMMISSIONING_BYTES), ffi.new("size_t *")
        require_good(lib.world_commissioning(self._world, record, size))
        return bytes(ffi.buffer(record, size[0]))


def _as_c(frames: Any) -> tuple[Any, int]:
    return ffi.from_buffer("world_frame_t[]", frames), len(frames)


def default_scenario(log: str) -> str | None:
    """The scenario of the run folder that the log stands in, if it does."""
    path = Path(log).resolve().parent / "inputs" / "scenario.txt"
    return str(path) if path.is_file() else None


def gains_beside(scenario: str | Path | None) -> Path | None:
    """The gain record of the scenario's run, if it had one."""
    path = None if scenario is None else Path(scenario).with_name(folder.GAINS)
    return path if path is not None and path.is_file() else None


def gain_options(scenario: str | Path | None) -> list[str]:
    """What tumble-node is told of it."""
    path = gains_beside(scenario)
    return [] if path is None else ["--gain-record", str(path)]


def of_scenario(scenario: str | None) -> Firmware:
    """The firmware as a scenario has it, or as the paper has it. Raises BadInput, UsageError, BenchFault."""
    gains = gains_beside(scenario)
    try:
        return Firmware(_lines(scenario), None if gains is None else gains.read_bytes())
    except Refused as refused:
        if scenario is not None and scenario.endswith(".toml") and refused.line:
            raise BadInput("looks like a stand file; a scenario file is wanted (docs/gateway.md)", scenario) from None
        raise UsageError(refused.where("the defaults" if scenario is None else file_name(scenario))) from None


def _lines(scenario: str | None) -> list[str]:
    if scenario is None:
        return []
    try:
        return Path(scenario).read_bytes().decode("utf-8", "surrogateescape").split("\n")
    except OSError as error:
        raise BadInput(error.strerror or "cannot be read", scenario) from None


def played(log: Log, scenario: str | None) -> Firmware:
    """The firmware when it has heard all of a log. Raises as `of_scenario` does."""
    firmware = of_scenario(scenario)
    try:
        firmware.play(log.frames)
    except Refused as refused:
        raise UsageError(f"{file_name(log.file)}: {refused}") from None
    return firmware


def recording(log: Log, scenario: str | None) -> bytes:
    """The log as a board replays it (boards/replay/replay.h). Raises as `of_scenario` does."""
    firmware = of_scenario(scenario)
    try:
        return firmware.recording(log.frames)
    except Refused as refused:
        raise UsageError(f"{file_name(log.file)}: {refused}") from None


def commissioning(scenario: str | None) -> bytes:
    """The record that tells the board what a scenario says. Raises as `of_scenario` does."""
    firmware = of_scenario(scenario)
    try:
        return firmware.commissioning()
    except Refused as refused:
        raise UsageError(str(refused)) from None


def replay(file: str, scenario: str | None, firmware: str) -> Replay:
    """Replay. Raises BadInput, UsageError, NotInstalled, Skipped, and BenchFault: also where there is no result."""
    log = read(file)
    found = (_on_board if firmware == BOARD else _on_host)(log, scenario)
    if found.numbers is None:
        told = f"{file_name(file)}: the firmware comes to no result in this log ({found.state}, {found.reason})"
        raise BenchFault(told if scenario else f"{told}; it took the paper's stand: --scenario names the run's own")
    return Replay(
        log=file_name(file),
        format=log.format,
        time_step_us=log.time_step_us,
        firmware=firmware,
        state=found.state,
        reason=found.reason,
        K=found.numbers[:9].reshape(3, 3),
        U0=found.numbers[9:],
        bits=tuple(struct.pack(">d", number).hex() for number in found.numbers.tolist()),
        passed=found.passed,
        counters=ReplayCounters(**found.counters),
    )


class _Found(NamedTuple):
    """`numbers` (12,): K row by row, V/g, and U0, V; None where the run came to no result."""

    state: str
    reason: str
    numbers: Floats | None
    passed: bool
    counters: dict[str, int]


def _on_host(log: Log, scenario: str | None) -> _Found:
    found = played(log, scenario).document()
    return _Found(
        found.state,
        found.reason,
        None if found.K is None or found.U0 is None else np.concatenate([found.K.ravel(), found.U0]),
        found.verification is not None and found.verification.passed,
        {name: found.counters[own] for name, own in _COUNTERS.items()},
    )


def _on_board(log: Log, scenario: str | None) -> _Found:
    if (lacking := emulator.missing("replay")) is not None:
        raise Skipped(f"--firmware {BOARD}: {lacking}")
    with tempfile.TemporaryDirectory(prefix="tumble-") as name:
        recorded, record = Path(name) / "recording", Path(name) / "commissioning"
        recorded.write_bytes(recording(log, scenario))
        record.write_bytes(commissioning(scenario))
        told = emulator.replay(recorded, record, gains_beside(scenario))
    known = "K" in told
    return _Found(
        told["state"][0],
        told["reason"][0],
        np.frombuffer(bytes.fromhex("".join(told["K"] + told["U0"])), ">f8").astype(float) if known else None,
        known and told["pass"] == ["1"],
        {name: int(told[name][0]) for name in _COUNTERS},
    )
