"""A CAN log as a recording: the frames of a block of ours, or the signals of a user's DBC file; and what was not taken.

Needs python-can and cantools.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput, NotInstalled, UsageError, file_name, quoted
from tumble.files.can_log import CanLog, Frame
from tumble.files.run_layout import Wishes, find_all
from tumble.importing import can_signals, rests
from tumble.importing.rests import AXES, FIRST, SECOND, STATUS, Receiver
from tumble.stand import PerChannel, by_channel

COUNTS = "counts"
VOLTS = "V"
FEWEST = 2  # samples: one has no clock
USUAL = 3  # the node of the only block of a bench
_BLOCKS = range(1, 16)  # nodes that a block can be: the lowest four bits of its identifiers
_BOOT_UP, _HEARTBEATS = b"\0", 0x700
_SAID = {
    "wrong_crc": "{} frames with a wrong CRC",
    "wrong_length": "{} frames that are not 8 bytes long",
    "wrong_pair": "{} second halves of another sample",
    "lone_halves": "{} halves without the other",
    "repeated": "{} frames that came again",
    "reordered": "{} frames out of order",
    "unfit": "{} samples that the block calls unfit",
}


@dataclass(frozen=True)
class Bus:
    """What the user says of CAN logs. `dbc`: his DBC file; `identifier`: of a block's first frame; `channel`: the
    interface; `v_per_count`: size of a count, V, 0 if unknown."""

    dbc: str | None = None
    identifier: int | None = None
    channel: str | None = None
    v_per_count: PerChannel = 0.0

    def require_log(self) -> None:
        """Raises UsageError where something is said that only a CAN log has."""
        said = {"--dbc": self.dbc, "--can-id": self.identifier, "--can-channel": self.channel}
        for option, value in said.items():
            if value is not None:
                raise UsageError(f"{option} is for a CAN log, and none is given")


NO_BUS = Bus()


@dataclass(frozen=True)
class Found:
    """`seconds`, `lines` (rows,); `outputs` (rows, 3) in `unit`, None where nobody tells it; `temperature` (rows,) in
    deg C, None where there is none; `notes`: sentences."""

    seconds: Floats
    outputs: Floats
    lines: Integers
    unit: str | None
    temperature: Floats | None
    notes: tuple[str, ...]


def read(data: bytes, file: str, kind: str, wishes: Wishes, bus: Bus) -> Found:
    """Read a log of this kind (files.can_log). Raises BadInput, UsageError, NotInstalled."""
    others = sorted(set(wishes.columns) - set(can_signals.OUTPUTS))
    if others:
        raise UsageError(f"--columns {others[0]}=: of a CAN log ux, uy and uz can be named")
    log = CanLog(data, file, kind)
    try:
        import cantools  # noqa: F401
    except ImportError:
        raise NotInstalled(f"{file_name(file)}: a CAN log", "cantools", extra="can") from None
    frames = _of_channel(log, file, bus.channel)
    found = _of_block(log, frames, file, wishes, bus) if bus.dbc is None else _of_dbc(log, frames, file, wishes, bus)
    notes = (f"CAN log ({kind}): {log.frames} frames", *found.notes)
    notes += ("its last line is torn: not read",) if log.torn else ()
    if found.unit == COUNTS and bus.v_per_count and wishes.unit is None:
        sizes = ", ".join(f"{one:.6g}" for one in np.atleast_1d(bus.v_per_count).tolist())
        return Found(
            found.seconds, found.outputs * by_channel(bus.v_per_count), found.lines, VOLTS, found.temperature,
            (*notes, f"counts made volts: {sizes} V a count, as converter_bits and range_v have it"),
        )  # fmt: skip
    if found.unit == COUNTS and wishes.unit is None:
        notes += ("in counts: write converter_bits and range_v into [block] of the stand file (--stand) to have V",)
    return Found(found.seconds, found.outputs, found.lines, wishes.unit or found.unit, found.temperature, notes)


def _of_channel(log: CanLog, file: str, channel: str | None) -> Iterator[Frame]:
    """The frames of a channel, or of all. Raises BadInput where there is no such channel."""
    seen = set()
    for frame in log:
        seen.add(frame.channel)
        if channel in (None, frame.channel):
            yield frame
    if channel is not None and channel not in seen:
        names = ", ".join(sorted(filter(None, seen))) or "none with a name"
        raise BadInput(f"--can-channel {quoted(channel)}: there is no such channel; there are: {names}", file)


class _Clock:
    """Watches that the time of the frames does not go back, channel by channel."""

    def __init__(self, file: str):
        self._file = file
        self._before: dict[str, float] = {}

    def require(self, frame: Frame) -> None:
        """Raises BadInput."""
        before = self._before.get(frame.channel, frame.seconds)
        if frame.seconds < before:
            went = f"the time goes back, from {before:.6f} to {frame.seconds:.6f} s"
            raise BadInput(f"{went}: two logs in one file? give each as a file of its own", self._file, frame.line)
        self._before[frame.channel] = frame.seconds


# A block of ours.


def _of_block(log: CanLog, frames: Iterator[Frame], file: str, wishes: Wishes, bus: Bus) -> Found:
    if bus.identifier is not None and bus.identifier - FIRST not in _BLOCKS:
        raise UsageError(f"--can-id {bus.identifier:#x}: first frames of blocks are {FIRST + 1:#x} to {FIRST + 15:#x}")
    (channel, node), receiver = _the_block(_received(frames, file), log, file, bus)
    counts = receiver.counts
    where = f" on {channel}" if channel else ""
    notes = [f"block {FIRST + node:#x}, {SECOND + node:#x}{where}: {len(receiver)} samples"]
    if said := [text.format(counts[name]) for name, text in _SAID.items() if counts[name]]:
        why = ", ".join(f"{counts[name]} {name.replace('_', ' ')}" for name in STATUS if counts[name])
        notes.append(f"left out: {', '.join(said)}{f' ({why})' if why else ''}")
    if counts["lost"]:
        notes.append(f"{counts['lost']} samples are missing, by the block's counter")
    if counts["silences"]:
        notes.append(f"the block was silent {counts['silences']} times, for over {rests.SILENCE_S:g} s")
    outputs = receiver.outputs[:, _axes(wishes, file)]
    return Found(receiver.seconds, outputs, receiver.lines, COUNTS, receiver.temperature, tuple(notes))


def _received(frames: Iterator[Frame], file: str) -> dict[tuple[str, int], Receiver]:
    """What came of each block that there can be, by channel and node."""
    halves, clock = rests.messages(), _Clock(file)
    receivers: dict[tuple[str, int], Receiver] = {}
    for frame in frames:
        group, node = frame.identifier & ~0xF, frame.identifier & 0xF
        if frame.extended or node not in _BLOCKS:
            continue
        place = frame.channel, node
        if group in (FIRST, SECOND):
            if place not in receivers:
                receivers[place] = Receiver(halves)
            clock.require(frame)
            receivers[place].take(frame)
        elif group == _HEARTBEATS and frame.data == _BOOT_UP and place in receivers:
            receivers[place].restart()
    return receivers


def _the_block(
    receivers: dict[tuple[str, int], Receiver], log: CanLog, file: str, bus: Bus
) -> tuple[tuple[str, int], Receiver]:
    """The one that is there, or the one that is asked for."""
    asked = None if bus.identifier is None else bus.identifier - FIRST
    tried = {place: one for place, one in receivers.items() if asked in (None, place[1])}
    blocks = {place: one for place, one in tried.items() if len(one) >= FEWEST}
    if not blocks:
        node = USUAL if asked is None else asked
        its = [one for place, one in tried.items() if place[1] == node]
        damaged = sum(one.counts["wrong_crc"] + one.counts["wrong_length"] for one in its)
        what = f"{sum(one.halves for one in its)} of its frames, {damaged} of them damaged, among {log.frames}"
        advice = "another block? --dbc FILE.dbc describes its frames"
        raise BadInput(f"no samples of the block {FIRST + node:#x}, {SECOND + node:#x}: {what}; {advice}", file)
    if len(blocks) > 1:
        names = " and ".join(f"{FIRST + node:#x}{f' on {channel}' if channel else ''}" for channel, node in blocks)
        nodes = {node for _, node in blocks}
        advice = f"--can-id {FIRST + min(nodes):#x}" if len(nodes) > 1 else f"--can-channel {min(blocks)[0]}"
        raise BadInput(f"{len(blocks)} blocks, {names}: {advice} takes one", file)
    return next(iter(blocks.items()))


def _axes(wishes: Wishes, file: str) -> tuple[int, ...]:
    """Which axis is ux, uy, uz: the user may exchange them."""
    named = {name: column for name, column in wishes.columns.items() if name in can_signals.OUTPUTS}
    try:
        return find_all(list(AXES), Wishes(columns=named, wanted=can_signals.OUTPUTS))
    except ValueError as error:
        raise BadInput(str(error), file) from None


# Signals of a user's DBC file.


def _of_dbc(log: CanLog, frames: Iterator[Frame], file: str, wishes: Wishes, bus: Bus) -> Found:
    assert bus.dbc is not None
    if bus.identifier is not None:
        raise UsageError("--can-id chooses a block of ours: with --dbc the DBC file has the identifiers")
    outputs = can_signals.chosen(can_signals.load(bus.dbc), wishes, bus.dbc)
    messages = {
        (one.message.frame_id, one.message.is_extended_frame): can_signals.Message(
            one.message, [(place, s.name) for place, s in enumerate(outputs) if s.message is one.message]
        )
        for one in outputs
    }
    channels = _taken(frames, messages, file)
    few = [one.message.name for one in messages.values() if len(one.table()[0]) < FEWEST]
    if few:
        raise BadInput(f"fewer than {FEWEST} good frames of {few[0]} among {log.frames}", file)
    if len(channels) > 1:
        names = " and ".join(channels)
        raise BadInput(f"the signals are on {names}: --can-channel {channels[0]} takes one", file)
    rows = can_signals.joined(list(messages.values()))
    if len(rows.seconds) < FEWEST:
        raise BadInput("no frames of the messages are close enough to be of one sample", file)
    names = ", ".join(f"{name} {one.label}" for name, one in zip(can_signals.OUTPUTS, outputs))
    notes = [f"signals of {file_name(bus.dbc)}: {names}; {len(rows.seconds)} samples; no checksum is looked at"]
    damaged = sum(one.damaged for one in messages.values())
    said = (
        (damaged, "frames that are too short"),
        (rows.repeated, "frames that came again"),
        (rows.alone, "frames without those of the other messages"),
        (rows.lost, "samples without a number"),
    )
    if any(number for number, _ in said):
        notes.append(f"left out: {', '.join(f'{number} {what}' for number, what in said if number)}")
    unit = can_signals.unit_told(outputs, wishes, bus.dbc)
    return Found(rows.seconds, rows.outputs, rows.lines, unit, None, tuple(notes))


def _taken(frames: Iterator[Frame], messages: dict[tuple[int, bool], can_signals.Message], file: str) -> list[str]:
    """Let the messages take their frames. Returns the channels on which they came."""
    channels, clock = set(), _Clock(file)
    for frame in frames:
        message = messages.get((frame.identifier, frame.extended))
        if message is not None:
            clock.require(frame)
            message.take(frame)
            channels.add(frame.channel)
    return sorted(channels)
