"""A CAN log as a recording: the samples of a block of ours (docs/bus/README.md), or the signals of a user's DBC file;
and what was not taken.

The receiver takes, refuses and counts frames of the block as firmware/sample/block_frames.c does; what the bytes mean
is read off the package's DBC file. Of a user's DBC file three signals are the outputs, of one message or of several:
messages that are sent together make a row, of each the frame that is nearest in time to one of the first.

Needs python-can and cantools.
"""

from __future__ import annotations

import io
from array import array
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tumble import data
from tumble.arrays import Flags, Floats, Integers
from tumble.errors import BadInput, UsageError, file_name, needing, quoted
from tumble.files.can_log import CanLog, Frame
from tumble.files.disk import read_bytes
from tumble.files.frames import suffix_of
from tumble.files.run_layout import LayoutOptions, find_all, unit_of
from tumble.stand import PerChannel, by_channel

COUNTS, VOLTS = "counts", "V"
OUTPUTS = ("ux", "uy", "uz")
FEWEST = 2  # samples: one has no clock


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
                raise UsageError(f"{option} applies to CAN logs, and none is given")


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


def read(data: bytes, file: str, kind: str, options: LayoutOptions, bus: Bus) -> Found:
    """Read a log of this kind (files.can_log). Raises BadInput, UsageError, NotInstalled."""
    others = sorted(set(options.columns) - set(OUTPUTS))
    if others:
        raise UsageError(f"--columns {others[0]}=: of a CAN log ux, uy and uz can be named")
    log = CanLog(data, file, kind)
    with needing(f"{file_name(file)}: a CAN log", "cantools", extra="can"):
        import cantools  # noqa: F401
    frames = _of_channel(log, file, bus.channel)
    found = _of_block(log, frames, file, options, bus) if bus.dbc is None else _of_dbc(log, frames, file, options, bus)
    notes = [f"CAN log ({kind}): {log.frames} frames", *found.notes]
    notes += ["its last line is incomplete and not read"] if log.torn else []
    outputs, unit = found.outputs, options.unit or found.unit
    if found.unit == COUNTS and options.unit is None:
        if bus.v_per_count:
            outputs, unit = outputs * by_channel(bus.v_per_count), VOLTS
            sizes = ", ".join(f"{one:.6g}" for one in np.atleast_1d(bus.v_per_count).tolist())
            notes.append(f"counts converted to volts: {sizes} V per count, from converter_bits and range_v")
        else:
            notes.append(
                "in counts: set converter_bits and range_v in [block] of the stand file (--stand) to get volts"
            )
    return replace(found, outputs=outputs, unit=unit, notes=tuple(notes))


def _of_channel(log: CanLog, file: str, channel: str | None) -> Iterator[Frame]:
    """The frames of a channel, or of all. Raises BadInput where there is no such channel."""
    seen = set()
    for frame in log:
        seen.add(frame.channel)
        if channel in (None, frame.channel):
            yield frame
    if channel is not None and channel not in seen:
        names = ", ".join(sorted(filter(None, seen))) or "no named channels"
        raise BadInput(f"--can-channel {quoted(channel)}: no such channel; the log has {names}", file)


def _require_forwards(latest: dict[str, float], frame: Frame, file: str) -> None:
    """Raise BadInput where the time of the frames goes back; `latest`: of each channel."""
    before = latest.get(frame.channel, frame.seconds)
    if frame.seconds < before:
        went = f"the time runs backwards, from {before:.6f} to {frame.seconds:.6f} s"
        raise BadInput(f"{went}: two logs in one file? Pass each log as a file of its own", file, frame.line)
    latest[frame.channel] = frame.seconds


# A block of ours.

XY, Z = "BLOCK_XY", "BLOCK_Z"  # in the DBC file, where they have the identifiers of node 3
AXES = ("x", "y", "z")
FIRST, SECOND = 0x680, 0x690  # of the halves' identifiers, and the block's node
STATUS = ("saturated", "self_test_failed", "converter_fault", "temperature_out_of_range")
_USUAL = 3  # the node of the only block of a bench
_BLOCKS = range(1, 16)  # nodes that a block can be: the lowest four bits of its identifiers
_BOOT_UP, _HEARTBEATS = b"\0", 0x700
_SILENCE_S = 1.0  # beyond, eight bits do not tell how many samples are missing, or whether the block began anew
_BYTES = 8
_LONGEST_STEP = 127
_SAID = {
    "wrong_crc": "{} frames with a wrong CRC",
    "wrong_length": "{} frames that are not 8 bytes long",
    "wrong_pair": "{} second halves that belong to another sample",
    "lone_halves": "{} halves without their counterpart",
    "repeated": "{} repeated frames",
    "reordered": "{} frames out of order",
    "unfit": "{} samples that the block marks invalid",
}


def _of_block(log: CanLog, frames: Iterator[Frame], file: str, options: LayoutOptions, bus: Bus) -> Found:
    if bus.identifier is not None and bus.identifier - FIRST not in _BLOCKS:
        raise UsageError(f"--can-id {bus.identifier:#x}: first frames of blocks are {FIRST + 1:#x} to {FIRST + 15:#x}")
    (channel, node), receiver = _the_block(_received(frames, file), log, file, bus)
    counts, samples = receiver.counts, receiver.samples
    where = f" on {channel}" if channel else ""
    notes = [f"block {FIRST + node:#x}, {SECOND + node:#x}{where}: {len(samples)} samples"]
    if said := [text.format(counts[name]) for name, text in _SAID.items() if counts[name]]:
        why = ", ".join(f"{counts[name]} {name.replace('_', ' ')}" for name in STATUS if counts[name])
        notes.append(f"left out: {', '.join(said)}{f' ({why})' if why else ''}")
    if counts["lost"]:
        notes.append(f"{counts['lost']} samples are missing according to the block's counter")
    if counts["silences"]:
        notes.append(f"the block was silent {counts['silences']} times, for over {_SILENCE_S:g} s")
    try:  # the user may exchange the axes
        axes = find_all(list(AXES), LayoutOptions(columns=options.columns, wanted=OUTPUTS))
    except ValueError as error:
        raise BadInput(str(error), file) from None
    seconds, temperature, lines = (samples[:, column].copy() for column in (0, 4, 5))
    outputs = samples[:, 1:4].copy()[:, axes]
    return Found(seconds, outputs, lines.astype(int), COUNTS, temperature, tuple(notes))


def _received(frames: Iterator[Frame], file: str) -> dict[tuple[str, int], Receiver]:
    """What came of each block that there can be, by channel and node."""
    halves, latest = messages(), dict[str, float]()
    receivers: dict[tuple[str, int], Receiver] = {}
    for frame in frames:
        group, node = frame.identifier & ~0xF, frame.identifier & 0xF
        if frame.extended or node not in _BLOCKS:
            continue
        place = frame.channel, node
        if group in (FIRST, SECOND):
            if place not in receivers:
                receivers[place] = Receiver(halves)
            _require_forwards(latest, frame, file)
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
    blocks = {place: one for place, one in tried.items() if len(one.samples) >= FEWEST}
    if not blocks:
        node = _USUAL if asked is None else asked
        its = [one for place, one in tried.items() if place[1] == node]
        damaged = sum(one.counts["wrong_crc"] + one.counts["wrong_length"] for one in its)
        what = f"{sum(one.halves for one in its)} of its frames, {damaged} of them damaged, among {log.frames}"
        advice = "another block? --dbc FILE.dbc describes its frames"
        raise BadInput(f"no samples of the block {FIRST + node:#x}, {SECOND + node:#x}: {what}; {advice}", file)
    if len(blocks) > 1:
        names = " and ".join(f"{FIRST + node:#x}{f' on {channel}' if channel else ''}" for channel, node in blocks)
        nodes = {node for _, node in blocks}
        advice = f"--can-id {FIRST + min(nodes):#x}" if len(nodes) > 1 else f"--can-channel {min(blocks)[0]}"
        raise BadInput(f"{len(blocks)} blocks, {names}: {advice} selects one", file)
    return next(iter(blocks.items()))


def _crc_of_byte(byte: int) -> int:
    for _ in range(8):
        byte = (byte << 1 ^ (0x2F if byte & 0x80 else 0)) & 0xFF
    return byte


_CRC = [_crc_of_byte(byte) for byte in range(256)]


def checksum(identifier: int, payload: bytes) -> int:
    """CRC-8 of a frame: over the low byte of its identifier and its seven bytes before the checksum."""
    crc = _CRC[0xFF ^ (identifier & 0xFF)]
    for byte in payload[: _BYTES - 1]:
        crc = _CRC[crc ^ byte]
    return crc ^ 0xFF


def messages() -> tuple[Any, Any]:
    """Both halves, as cantools reads them from the DBC file."""
    import cantools

    bus: Any = cantools.database.load_file(data.file("bus/block.dbc"))
    return bus.get_message_by_name(XY), bus.get_message_by_name(Z)


class Receiver:
    """Of one block. `halves`: how many frames came; `counts`: of frames and samples that were not taken, by reason."""

    def __init__(self, halves: tuple[Any, Any]):
        self._xy, self._z = halves
        self._last: int | None = None  # sample counter of the last sample
        self._pending: tuple[str, int, dict[str, Any], Frame] | None = None  # a half, and the counter in it
        self._samples = array("d")
        self._heard: float | None = None
        self.halves = 0
        self.counts: Counter[str] = Counter()

    @property
    def samples(self) -> Floats:
        """When the first half came (s), counts of x, y, z, temperature (deg C), its line: (samples, 6)."""
        return np.array(self._samples).reshape(-1, 6)

    def restart(self) -> None:
        """The block has begun anew, or may have: its next counter tells nothing of what was lost."""
        self._last = self._pending = None

    def take(self, frame: Frame) -> None:
        """One of its frames, as they come."""
        self.halves += 1
        if self._heard is not None and frame.seconds - self._heard > _SILENCE_S:
            self.counts["silences"] += 1
            self.restart()
        self._heard = frame.seconds
        if len(frame.data) != _BYTES:
            self.counts["wrong_length"] += 1
        elif frame.data[-1] != checksum(frame.identifier, frame.data):
            self.counts["wrong_crc"] += 1
        elif frame.identifier < SECOND:
            self._take_xy(self._xy.decode(frame.data, decode_choices=False), frame)
        else:
            self._take_z(self._z.decode(frame.data, decode_choices=False), frame)

    def _take_xy(self, half: dict[str, Any], frame: Frame) -> None:
        counter = half["sample_counter"]
        kind, waiting = (None, None) if self._pending is None else self._pending[:2]
        if counter == self._last or (kind == XY and counter == waiting):
            self.counts["repeated"] += 1
        elif kind == Z and waiting == _frame_counter(counter):
            self._pending = None
            self.counts["reordered"] += 1
        else:
            self.counts["lone_halves"] += kind is not None
            self._pending = XY, counter, half, frame

    def _take_z(self, half: dict[str, Any], frame: Frame) -> None:
        counter = half["frame_counter"]
        if self._pending is not None and self._pending[0] == XY and counter == _frame_counter(self._pending[1]):
            self._complete(*self._pending[1:], half)
        elif self._last is not None and counter == _frame_counter(self._last):
            self.counts["repeated"] += 1
        elif (self._pending is not None and self._pending[0] == XY) or counter % 2 == 0:
            self._pending = None
            self.counts["wrong_pair"] += 1
        else:
            self.counts["lone_halves"] += self._pending is not None
            self._pending = Z, counter, half, frame

    def _complete(self, counter: int, first: dict[str, Any], frame: Frame, second: dict[str, Any]) -> None:
        self._pending = None
        step = 1 if self._last is None else (counter - self._last) % 256
        if step > _LONGEST_STEP:
            self.counts["reordered"] += 1
            return
        self.counts["lost"] += step - 1
        self._last = counter
        if any(second[name] for name in STATUS):
            self.counts.update(name for name in STATUS if second[name])
            self.counts["unfit"] += 1
            return
        self._samples.extend((frame.seconds, first["x"], first["y"], second["z"], second["temperature"], frame.line))


def _frame_counter(sample_counter: int) -> int:
    """What the second half carries of the first one's counter."""
    return (2 * sample_counter + 1) % 256


# Signals of a user's DBC file.

_FORMATS = ("arxml", "cdd", "dbc", "kcd", "sym")  # of cantools, by the file's name
_TOGETHER = 0.5  # intervals: frames farther apart are not of one sample
_AGAIN = 0.1  # intervals: a frame that comes so soon with the same bytes is the one before, logged twice


@dataclass(frozen=True)
class Signal:
    """One of a DBC file: `label`: its name, with its message's before it where several have that name."""

    label: str
    name: str
    message: Any
    unit: str


class Message:
    """The frames of one message, decoded. `outputs`: places of OUTPUTS and the names of their signals."""

    def __init__(self, message: Any, outputs: Sequence[tuple[int, str]]):
        self.message, self.outputs = message, outputs
        self.damaged = 0
        self._seconds, self._values, self._lines = array("d"), array("d"), array("q")

    def take(self, frame: Frame) -> None:
        """One of its frames. Without the signals, as a multiplexed one can be, it is passed over."""
        try:
            found = self.message.decode(frame.data, decode_choices=False)
        except Exception:  # cantools and its helpers have classes of their own for what is too short
            self.damaged += 1
            return
        if all(name in found for _, name in self.outputs):
            self._seconds.append(frame.seconds)
            self._values.extend(float(found[name]) for _, name in self.outputs)
            self._lines.append(frame.line)

    def table(self) -> tuple[Floats, Floats, Integers]:
        """Seconds (rows,), values (rows, its outputs), lines (rows,)."""
        return np.array(self._seconds), np.array(self._values).reshape(-1, len(self.outputs)), np.array(self._lines)


def _of_dbc(log: CanLog, frames: Iterator[Frame], file: str, options: LayoutOptions, bus: Bus) -> Found:
    assert bus.dbc is not None
    if bus.identifier is not None:
        raise UsageError("--can-id selects a Tumble block; with --dbc, the DBC file gives the identifiers")
    outputs = _chosen(_load(bus.dbc), options, bus.dbc)
    messages = {
        (one.message.frame_id, one.message.is_extended_frame): Message(
            one.message, [(place, s.name) for place, s in enumerate(outputs) if s.message is one.message]
        )
        for one in outputs
    }
    channels, latest = set(), dict[str, float]()
    for frame in frames:
        message = messages.get((frame.identifier, frame.extended))
        if message is not None:
            _require_forwards(latest, frame, file)
            message.take(frame)
            channels.add(frame.channel)
    few = [one.message.name for one in messages.values() if len(one.table()[0]) < FEWEST]
    if few:
        raise BadInput(f"fewer than {FEWEST} good frames of {few[0]} among {log.frames}", file)
    if len(channels) > 1:
        names = " and ".join(sorted(channels))
        raise BadInput(f"the signals are on {names}: --can-channel {min(channels)} selects one", file)
    seconds, values, lines, left_out = _joined(list(messages.values()))
    if len(seconds) < FEWEST:
        raise BadInput("no frames of the messages are close enough to be of one sample", file)
    names = ", ".join(f"{name} {one.label}" for name, one in zip(OUTPUTS, outputs))
    notes = [f"signals of {file_name(bus.dbc)}: {names}; {len(seconds)} samples; checksums are not verified"]
    if left_out:
        notes.append(f"left out: {', '.join(left_out)}")
    unit = unit_of(options, [f"{one.label} [{one.unit}]" for one in outputs], file_name(bus.dbc), None)
    return Found(seconds, values, lines, unit, None, tuple(notes))


def _load(file: str) -> list[Signal]:
    """All signals of a DBC file. Raises BadInput."""
    import cantools

    data, suffix = read_bytes(file), suffix_of(file)[1:]
    encoding = "cp1252" if suffix in ("dbc", "sym") else "utf-8"  # as cantools does with a file of this name
    text = io.TextIOWrapper(io.BytesIO(data), encoding, "replace").read()
    kind = suffix if suffix in _FORMATS else None
    try:
        found: Any = cantools.database.load_string(text, kind, strict=False)  # signals that overlap can be none of ours
    except Exception as error:  # the parser has classes of its own, and others escape it
        raise BadInput(f"cannot read this DBC file: {quoted(error)}", file) from None
    signals = [(signal, message) for message in getattr(found, "messages", ()) for signal in message.signals]
    if not signals:
        raise BadInput("describes no signal of a CAN message", file)
    names = [signal.name for signal, _ in signals]
    return [
        Signal(s.name if names.count(s.name) == 1 else f"{m.name}.{s.name}", s.name, m, s.unit or "")
        for s, m in signals
    ]  # fmt: skip


def _chosen(signals: Sequence[Signal], options: LayoutOptions, file: str) -> list[Signal]:
    """Those of ux, uy, uz: by the user's names, with or without the message's (MESSAGE.SIGNAL), else by their own.
    Raises BadInput."""
    labels = [one.label for one in signals]
    whole = {f"{one.message.name}.{one.name}": one.label for one in signals}
    named = {wanted: whole.get(name, name) for wanted, name in options.columns.items()}
    try:
        return [signals[place] for place in find_all(labels, replace(options, columns=named, wanted=OUTPUTS))]
    except ValueError as error:
        raise BadInput(str(error), file) from None


def _joined(messages: Sequence[Message]) -> tuple[Floats, Floats, Integers, list[str]]:
    """Rows of what the messages have brought, two at least of each: seconds (rows,), outputs (rows, 3), lines (rows,);
    and what is left out."""
    tables, repeated = [], 0
    for one in messages:
        seconds, values, lines = one.table()
        kept = _not_again(seconds, values)
        repeated += len(kept) - int(kept.sum())
        tables.append((seconds[kept], values[kept], lines[kept]))
    seconds, _, lines = tables[0]
    partners = [nearest(seconds, other) for other, _, _ in tables]
    whole = np.logical_and.reduce([partner >= 0 for partner in partners])
    outputs = np.empty((int(whole.sum()), len(OUTPUTS)))
    for one, (_, values, _), partner in zip(messages, tables, partners):
        outputs[:, [place for place, _ in one.outputs]] = values[partner[whole]]
    known = np.isfinite(outputs).all(axis=1)
    counts = {
        "frames that are too short": sum(one.damaged for one in messages),
        "repeated frames": repeated,
        "frames without matching frames of the other messages": sum(len(table[0]) - len(outputs) for table in tables),
        "samples that are not finite numbers": len(outputs) - int(known.sum()),
    }
    left_out = [f"{count} {what}" for what, count in counts.items() if count]
    return seconds[whole][known], outputs[known], lines[whole][known], left_out


def _interval(seconds: Floats) -> float:
    steps = np.diff(seconds)
    return float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0


def _not_again(seconds: Floats, values: Floats) -> Flags:
    """Which frames are not the one before once more."""
    again = (np.diff(seconds) < _AGAIN * _interval(seconds)) & (np.diff(values, axis=0) == 0.0).all(axis=1)
    kept: Flags = np.concatenate([[True], ~again])
    return kept


def nearest(seconds: Floats, other: Floats) -> Integers:
    """Of each of `seconds` the place in `other` that is nearest; -1 where that is too far, or nearer to another."""
    after = np.clip(np.searchsorted(other, seconds), 1, len(other) - 1)
    place = after - (seconds - other[after - 1] <= other[after] - seconds)
    distance = np.abs(other[place] - seconds)
    found: Integers = np.where(distance <= _TOGETHER * _interval(other), place, -1)
    order = np.lexsort((distance, found))
    second = np.concatenate([[False], found[order][1:] == found[order][:-1]])
    found[order[second]] = -1
    return found
