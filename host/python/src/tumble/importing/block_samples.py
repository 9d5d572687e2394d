"""The accelerometer block's samples on a CAN bus (docs/bus/README.md), of two frames each: checked, paired, counted.

The receiver takes, refuses and counts frame by frame as firmware/sample/block_frames.c does; what the bytes mean is
read off the package's DBC file, by cantools.
"""

from __future__ import annotations

from array import array
from collections import Counter
from typing import Any

import numpy as np

from tumble import data
from tumble.arrays import Floats, Integers
from tumble.files.can_log import Frame

XY, Z = "BLOCK_XY", "BLOCK_Z"  # in the DBC file, where they have the identifiers of node 3
AXES = ("x", "y", "z")
FIRST, SECOND = 0x680, 0x690  # of the halves' identifiers, and the block's node
STATUS = ("saturated", "self_test_failed", "converter_fault", "temperature_out_of_range")
SILENCE_S = 1.0  # beyond, eight bits do not tell how many samples are missing, or whether the block began anew
_BYTES = 8
_POLYNOMIAL = 0x2F
_LONGEST_STEP = 127


def _crc_table() -> list[int]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = (byte << 1 ^ (_POLYNOMIAL if byte & 0x80 else 0)) & 0xFF
        table.append(byte)
    return table


_CRC = _crc_table()


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
    """Of one block. `counts`: of frames and samples that were not taken, by reason."""

    def __init__(self, halves: tuple[Any, Any]):
        self._xy, self._z = halves
        self._last: int | None = None  # sample counter of the last sample
        self._pending: tuple[str, int, dict[str, Any], Frame] | None = None  # a half, and the counter in it
        self._seconds = array("d")
        self._outputs = array("d")
        self._temperature = array("d")
        self._lines = array("q")
        self._heard: float | None = None
        self.halves = 0
        self.counts: Counter[str] = Counter()

    def __len__(self) -> int:
        return len(self._seconds)

    @property
    def seconds(self) -> Floats:
        """When each sample's first half came: (samples,)."""
        return np.array(self._seconds)

    @property
    def outputs(self) -> Floats:
        """Counts of x, y, z: (samples, 3)."""
        return np.array(self._outputs).reshape(-1, len(AXES))

    @property
    def temperature(self) -> Floats:
        """Of the block, in deg C: (samples,)."""
        return np.array(self._temperature)

    @property
    def lines(self) -> Integers:
        """Where in the log each sample's first half is: (samples,)."""
        return np.array(self._lines)

    def restart(self) -> None:
        """The block has begun anew, or may have: its next counter tells nothing of what was lost."""
        self._last = self._pending = None

    def take(self, frame: Frame) -> None:
        """One of its frames, as they come."""
        self.halves += 1
        if self._heard is not None and frame.seconds - self._heard > SILENCE_S:
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
        self._seconds.append(frame.seconds)
        self._outputs.extend((first["x"], first["y"], second["z"]))
        self._temperature.append(second["temperature"])
        self._lines.append(frame.line)


def _frame_counter(sample_counter: int) -> int:
    """What the second half carries of the first one's counter."""
    return (2 * sample_counter + 1) % 256
