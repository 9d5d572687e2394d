"""Signals of a user's DBC file in a CAN log: three of them are the outputs, of one message or of several.

Messages that are sent together make a row: of each, the frame that is nearest in time to one of the first.
"""

from __future__ import annotations

import io
from array import array
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.errors import BadInput, file_name, quoted
from tumble.files.can_log import Frame
from tumble.files.disk import read_bytes
from tumble.files.incoming import suffix_of
from tumble.files.run_layout import Wishes, find_all, unit_of

OUTPUTS = ("ux", "uy", "uz")
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


def load(file: str) -> list[Signal]:
    """All signals of a DBC file. Raises BadInput."""
    import cantools

    data, suffix = read_bytes(file), suffix_of(file)[1:]
    encoding = "cp1252" if suffix in ("dbc", "sym") else "utf-8"  # as cantools does with a file of this name
    text = io.TextIOWrapper(io.BytesIO(data), encoding, "replace").read()
    kind = suffix if suffix in _FORMATS else None
    try:
        found: Any = cantools.database.load_string(text, kind, strict=False)  # signals that overlap can be none of ours
    except Exception as error:  # the parser has classes of its own, and others escape it
        raise BadInput(f"not a DBC file that can be read: {quoted(error)}", file) from None
    signals = [(signal, message) for message in getattr(found, "messages", ()) for signal in message.signals]
    if not signals:
        raise BadInput("describes no signal of a CAN message", file)
    names = [signal.name for signal, _ in signals]
    return [
        Signal(s.name if names.count(s.name) == 1 else f"{m.name}.{s.name}", s.name, m, s.unit or "")
        for s, m in signals
    ]  # fmt: skip


def chosen(signals: Sequence[Signal], wishes: Wishes, file: str) -> list[Signal]:
    """Those of ux, uy, uz: by the user's names, with or without the message's (MESSAGE.SIGNAL), else by their own.
    Raises BadInput."""
    labels = [one.label for one in signals]
    whole = {f"{one.message.name}.{one.name}": one.label for one in signals}
    named = {wanted: whole.get(name, name) for wanted, name in wishes.columns.items() if wanted in OUTPUTS}
    try:
        return [signals[place] for place in find_all(labels, replace(wishes, columns=named, wanted=OUTPUTS))]
    except ValueError as error:
        raise BadInput(str(error), file) from None


def unit_told(outputs: Sequence[Signal], wishes: Wishes, file: str) -> str | None:
    """The unit of the three, by the user or the file; None where neither tells one. Raises BadInput as unit_of."""
    return unit_of(wishes, [f"{one.label} [{one.unit}]" for one in outputs], file_name(file), None)


class Message:
    """The frames of one message, decoded. `outputs`: places of OUTPUTS and the names of their signals."""

    def __init__(self, message: Any, outputs: Sequence[tuple[int, str]]):
        self.message = message
        self.outputs = outputs
        self.frames = 0
        self.damaged = 0
        self._seconds, self._values, self._lines = array("d"), array("d"), array("q")

    def take(self, frame: Frame) -> None:
        """One of its frames. Without the signals, as a multiplexed one can be, it is passed over."""
        self.frames += 1
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


@dataclass(frozen=True)
class Rows:
    """`seconds`, `lines` (rows,); `outputs` (rows, 3); how many frames came `repeated` or `alone`, without those of the
    other messages; `lost`: rows without a number."""

    seconds: Floats
    outputs: Floats
    lines: Integers
    repeated: int
    alone: int
    lost: int


def joined(messages: Sequence[Message]) -> Rows:
    """Rows of what the messages have brought, two at least of each."""
    tables, repeated = [], 0
    for one in messages:
        seconds, values, lines = one.table()
        kept = _not_again(seconds, values)
        repeated += len(kept) - int(kept.sum())
        tables.append((seconds[kept], values[kept], lines[kept]))
    seconds, _, lines = tables[0]
    partners = [_nearest(seconds, other) for other, _, _ in tables]
    whole = np.logical_and.reduce([partner >= 0 for partner in partners])
    outputs = np.empty((int(whole.sum()), len(OUTPUTS)))
    for one, (_, values, _), partner in zip(messages, tables, partners):
        outputs[:, [place for place, _ in one.outputs]] = values[partner[whole]]
    alone = sum(len(table[0]) - len(outputs) for table in tables)
    known = np.isfinite(outputs).all(axis=1)
    lost = len(outputs) - int(known.sum())
    return Rows(seconds[whole][known], outputs[known], lines[whole][known], repeated, alone, lost)


def _interval(seconds: Floats) -> float:
    steps = np.diff(seconds)
    return float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else 0.0


def _not_again(seconds: Floats, values: Floats) -> Flags:
    """Which frames are not the one before once more."""
    again = (np.diff(seconds) < _AGAIN * _interval(seconds)) & (np.diff(values, axis=0) == 0.0).all(axis=1)
    kept: Flags = np.concatenate([[True], ~again])
    return kept


def _nearest(seconds: Floats, other: Floats) -> Integers:
    """Of each of `seconds` the place in `other` that is nearest; -1 where that is too far, or nearer to another."""
    after = np.clip(np.searchsorted(other, seconds), 1, len(other) - 1)
    place = after - (seconds - other[after - 1] <= other[after] - seconds)
    distance = np.abs(other[place] - seconds)
    found: Integers = np.where(distance <= _TOGETHER * _interval(other), place, -1)
    order = np.lexsort((distance, found))
    second = np.concatenate([[False], found[order][1:] == found[order][:-1]])
    found[order[second]] = -1
    return found
