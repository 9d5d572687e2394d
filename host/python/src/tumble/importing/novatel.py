"""Raw logs of inertial units on NovAtel receivers, ASCII: RAWIMU, RAWIMUX, RAWIMUS, RAWIMUSX.

    #RAWIMUA,header;week,seconds,status,Z,-Y,X,gyro Z,-gyro Y,gyro X*crc
    %RAWIMUSXA,header;info,type,week,seconds,status,Z,-Y,X,gyro Z,-gyro Y,gyro X*crc

(OEM7 Commands and Logs Reference Manual.) Accelerations are counts of velocity gained in an interval; how large a count
is depends on the unit, so K comes out in counts per g. The last eight digits are a CRC-32 of all between the first sign
and the asterisk, with zero to begin with and no inversion.
"""

from __future__ import annotations

import re
import zlib
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput
from tumble.files.rows import LARGEST_OUTPUT

_LINE = re.compile(rb"[#%](RAWIMU(S?)(X?)A,[^;*#%]*;([^*#%]*))\*([0-9a-fA-F]{8})")
_START = re.compile(rb"[#%]RAWIMUS?X?A,")
_HEAD = 1 << 16
_WEEK_S = 604800.0
UNIT = "counts"


@dataclass(frozen=True)
class Log:
    """`outputs` (rows, 3): x, y, z in counts; `seconds` (rows,): of GNSS time; `lines` (rows,): numbers of lines;
    `damaged`: messages of such a log that are torn or
    whose check sum is wrong; `others`: lines of something else."""

    outputs: Floats
    seconds: Floats
    lines: Integers
    damaged: int
    others: int


def is_log(data: bytes) -> bool:
    """Does this begin like such a log?"""
    return _START.search(data[:_HEAD]) is not None


def read(data: bytes, file: str) -> Log:
    """Read a log. Raises BadInput if no line is good."""
    rows, lines = [], []
    damaged = others = 0
    for number, line in enumerate(data.split(b"\n"), start=1):
        begun = len(_START.findall(line))  # two, where the end of one was lost
        others += begun == 0 and bool(line.strip())
        for found in _LINE.finditer(line):
            row = _row(found) if int(found[5], 16) == crc32(found[1]) else None
            if row is not None:
                rows.append(row)
                lines.append(number)
                begun -= 1
        damaged += begun
    if not rows:
        raise BadInput(f"{damaged} lines of a RAWIMU log, none with a good check sum: log it anew, as ASCII", file)
    values = np.array(rows)
    return Log(values[:, 1:], values[:, 0], np.array(lines), damaged, others)


def crc32(data: bytes) -> int:
    """That of the receivers: zlib's polynomial, nothing inverted."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def _row(found: re.Match[bytes]) -> tuple[float, float, float, float] | None:
    fields = found[4].split(b",")[2 if found[3] else 0 :]
    try:
        week, second, z, minus_y, x = (float(fields[place]) for place in (0, 1, 3, 4, 5))
    except (ValueError, IndexError):
        return None
    row = week * _WEEK_S + second, x, -minus_y, z
    return row if all(abs(value) <= LARGEST_OUTPUT for value in row) else None
