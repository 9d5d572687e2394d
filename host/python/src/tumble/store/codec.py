"""The records of the store as bytes, with struct: sets, entries of the history, positions of a run.

Only sets are encoded here, for makers of factory sets (docs/embedding.md); the firmware alone writes the others.
"""

from __future__ import annotations

import math
import struct
import zlib
from dataclasses import dataclass
from typing import Any

SET_BYTES = 320
MARK_BYTES = 32
PLACE_BYTES = SET_BYTES + MARK_BYTES
ENTRY_BYTES = 128
CELL_BYTES = 64

ORIGINS = {1: "factory", 2: "committed", 3: "accepted", 4: "rolled back", 5: "held"}
HAS_TEMPERATURE, HAS_GRAVITY, HAS_UNCERTAINTY, HAS_CHECK, HAS_CLOSURE, RESUMED, OTHER_RULES, HAS_TEMPERATURE_RANGE = (
    1 << bit for bit in range(8)
)
HAS_SLOPES = 1 << 8
COLDEST_C, WARMEST_C = -64.0, 63.5  # that a sample can tell

_HEADS = {version: struct.pack("<4sHH", b"TSET", version, SET_BYTES) for version in (1, 2)}
_SETS = {1: struct.Struct("<8sIBBH24sQ2d12d12d4dIBB2b5I"), 2: struct.Struct("<8sIBBH24sQ2d36f12f4dIBB2b5I")}
_FLAGS = {1: 0x0FF, 2: 0x1FF}
_ALWAYS = HAS_SLOPES | HAS_TEMPERATURE_RANGE  # in version 2, and never HAS_TEMPERATURE, which is that of a run
_ENTRY = struct.Struct("<4sIIBBHQf12f12f")
_RUN_HEAD = struct.pack("<4sHH", b"TRUN", 1, CELL_BYTES)
_POSITION = struct.Struct("<2sBxI3q3f2B14x")


class NotARecord(Exception):
    """The bytes hold no such record; the message says why."""


class NewerVersion(NotARecord):
    """The record is valid, but of a newer version."""


@dataclass
class CoefficientSet:
    """A coefficient set, with the names of docs/embedding.md. None: unknown. With slopes it is of version 2."""

    sequence: int
    origin: int
    estimator: int
    serial: str
    date_utc_s: int | None
    temperature_c: float | None
    gravity_m_s2: float | None
    k: list[float]  # 9, row by row, V/g
    u0: list[float]  # 3, V
    u_k: list[float] | None
    u_u0: list[float] | None
    check: list[float] | None  # largest on fit and on check positions, limit; g
    closure_v: float | None
    samples: int
    fit_positions: int
    check_positions: int
    schedule_crc: int
    stand_crc: int
    reasons: int
    restores: int
    from_crc: int
    resumed: bool
    other_rules: bool = False  # judged, committed or accepted under rules other than the board's
    temperature_range_c: list[float] | None = None  # of the run's samples; with slopes, where these hold
    slopes: list[list[float]] | None = None  # per K and per K^2 about temperature_c: K row by row, then U0


@dataclass
class HistoryEntry:
    """An entry of the history."""

    number: int
    sequence: int
    origin: int
    estimator: int
    flags: int
    date_utc_s: int | None
    temperature_c: float
    values: list[float]  # K row by row, then U0
    u: list[float]


@dataclass
class Position:
    """A finished position of a run."""

    index: int
    samples: int
    sums: list[int]
    scatter: list[float]
    temperature_range_c: list[float] | None = None  # of the run so far; None also where it touches an end


def _check_seal(bytes_: bytes, before: int = 0) -> None:
    if struct.pack("<I", zlib.crc32(bytes_[:-4], before)) != bytes_[-4:]:
        raise NotARecord("its checksum is wrong")


def _half_degrees(range_c: list[float], inwards: bool) -> tuple[int, int]:
    """A range in half degrees, rounded outwards or inwards."""
    low_c, high_c = range_c
    if not COLDEST_C <= low_c <= high_c <= WARMEST_C:
        raise ValueError(f"a temperature range must lie within {COLDEST_C} and {WARMEST_C} deg C, the lower end first")
    of_low, of_high = (math.ceil, math.floor) if inwards else (math.floor, math.ceil)
    low, high = of_low(2 * low_c), of_high(2 * high_c)
    if low > high:
        raise ValueError("a temperature range must hold a half degree")
    return low, high


def encode_set(s: CoefficientSet) -> bytes:
    """Encode a set into 320 bytes. Widens the temperature range to half degrees; with slopes, narrows it, and rounds
    coefficients and uncertainties to single precision. Raises ValueError."""
    known = (
        (HAS_TEMPERATURE, s.temperature_c),
        (HAS_GRAVITY, s.gravity_m_s2),
        (HAS_UNCERTAINTY, s.u_k),
        (HAS_CHECK, s.check),
        (HAS_CLOSURE, s.closure_v),
        (HAS_TEMPERATURE_RANGE, s.temperature_range_c),
    )
    flags = sum(bit for bit, value in known if value is not None) | (RESUMED if s.resumed else 0)
    flags |= (OTHER_RULES if s.other_rules else 0) | (0 if s.slopes is None else HAS_SLOPES)
    version = 1 if s.slopes is None else 2
    if version == 2:
        if s.temperature_c is None or s.temperature_range_c is None:
            raise ValueError("slopes need the temperature that they are about, and the range where they hold")
        flags &= ~HAS_TEMPERATURE
    serial = s.serial.encode()
    if len(serial) > 24 or b"\0" in serial:
        raise ValueError("a serial has at most 24 bytes of UTF-8, none of them zero")
    slopes = [number for power in s.slopes or () for number in power]
    low, high = _half_degrees(s.temperature_range_c or [0.0, 0.0], inwards=version == 2)
    try:
        record = _SETS[version].pack(
            *(_HEADS[version], s.sequence, s.origin, s.estimator, flags, serial, s.date_utc_s or 0),
            *(s.temperature_c or 0.0, s.gravity_m_s2 or 0.0, *s.k, *s.u0, *slopes),
            *(*(s.u_k or [0.0] * 9), *(s.u_u0 or [0.0] * 3), *(s.check or [0.0] * 3), s.closure_v or 0.0),
            *(s.samples, s.fit_positions, s.check_positions, low, high),
            *(s.schedule_crc, s.stand_crc, s.reasons, s.restores, s.from_crc),
        )
    except OverflowError:
        raise ValueError("a number is too large for single precision") from None
    return record + struct.pack("<I", zlib.crc32(record))


def decode_set(bytes_: bytes) -> CoefficientSet:
    """Decode a set of 320 bytes, of either version. Raises NotARecord."""
    version = next((version for version, head in _HEADS.items() if bytes_[:8] == head), None)
    if len(bytes_) != SET_BYTES or version is None:
        raise NotARecord("there is no set of coefficients")
    _check_seal(bytes_)
    fields = _SETS[version].unpack(bytes_[:-4])
    _, sequence, origin, estimator, flags, serial, date, temperature, gravity, *rest = fields
    *numbers, samples, fit, check, low, high, schedule, stand, reasons, restores, from_crc = rest
    finite = all(map(math.isfinite, [temperature, gravity, *numbers]))
    in_range = low <= high if flags & HAS_TEMPERATURE_RANGE else low == high == 0
    complete = version == 1 or flags & (_ALWAYS | HAS_TEMPERATURE) == _ALWAYS
    if origin not in ORIGINS or flags & ~_FLAGS[version] or not (finite and in_range and complete):
        raise NotARecord("a field is out of its range")
    slopes = None if version == 1 else [numbers[12:24], numbers[24:36]]
    doubles = numbers if version == 1 else numbers[:12] + numbers[36:]

    def known(bit: int, value: Any) -> Any:
        return value if flags & bit else None

    return CoefficientSet(
        sequence,
        origin,
        estimator,
        serial.rstrip(b"\0").decode("utf-8", "backslashreplace"),
        date or None,
        known(HAS_TEMPERATURE | HAS_SLOPES, temperature),
        known(HAS_GRAVITY, gravity),
        doubles[:9],
        doubles[9:12],
        known(HAS_UNCERTAINTY, doubles[12:21]),
        known(HAS_UNCERTAINTY, doubles[21:24]),
        known(HAS_CHECK, doubles[24:27]),
        known(HAS_CLOSURE, doubles[27]),
        samples,
        fit,
        check,
        schedule,
        stand,
        reasons,
        restores,
        from_crc,
        bool(flags & RESUMED),
        bool(flags & OTHER_RULES),
        known(HAS_TEMPERATURE_RANGE, [low / 2, high / 2]),
        slopes,
    )


def degree_of(slopes: list[list[float]]) -> int:
    """The highest power of the temperature of which a slope is not 0."""
    return max((power for power, numbers in enumerate(slopes, 1) if any(numbers)), default=0)


def mark_of(record: bytes) -> bytes:
    """The mark of 32 bytes that follows a record and makes it valid."""
    return (b"DONE" + record[-4:]).ljust(MARK_BYTES, b"\xff")


def decode_place(bytes_: bytes) -> CoefficientSet:
    """Decode the set of a place, with its mark. Raises NotARecord, NewerVersion."""
    record = bytes_[:SET_BYTES]
    is_marked = bytes_[SET_BYTES : SET_BYTES + 8] == mark_of(record)[:8]
    if is_marked:
        _require_known(record)
    found = decode_set(record)
    if not is_marked:
        raise NotARecord("it was not written completely: the mark is missing")
    return found


def _require_known(record: bytes) -> None:
    """Raises NewerVersion for a valid set with another schema or unknown flags."""
    magic, schema, flags = record[:4], *struct.unpack_from("<H8xH", record, 4)
    if magic == _HEADS[1][:4] and (schema not in _FLAGS or flags & ~_FLAGS[schema]):
        _check_seal(record)
        raise NewerVersion(f"a set of a newer version (schema {schema}, flags {flags:#x})")


def decode_entry(bytes_: bytes) -> HistoryEntry:
    """Decode an entry of 128 bytes. Raises NotARecord."""
    if bytes_[:4] != b"THS1":
        raise NotARecord("there is no entry of a history")
    _check_seal(bytes_)
    _, number, sequence, origin, estimator, flags, date, temperature, *numbers = _ENTRY.unpack(bytes_[:-4])
    return HistoryEntry(
        number, sequence, origin, estimator, flags, date or None, temperature, numbers[:12], numbers[12:]
    )


def decode_run(bytes_: bytes) -> int:
    """The fingerprint of the stored run. Raises NotARecord."""
    if bytes_[:8] != _RUN_HEAD:
        raise NotARecord("no run is kept")
    _check_seal(bytes_)
    fingerprint: int = struct.unpack_from("<I", bytes_, 8)[0]
    return fingerprint


def decode_position(bytes_: bytes, fingerprint: int) -> Position:
    """Decode a position of 64 bytes. Raises NotARecord, also for a position of another run."""
    if bytes_[:2] != b"TP":
        raise NotARecord("there is no position")
    _check_seal(bytes_, _seed(fingerprint))
    _, index, samples, *numbers, cold, warm = _POSITION.unpack(bytes_[:-4])
    return Position(index, samples, numbers[:3], numbers[3:], _range_c(cold, warm))


def _range_c(cold: int, warm: int) -> list[float] | None:
    """The range that is so many half degrees off the coldest and off the warmest that a sample can tell, as the
    firmware has it. None at an end, beyond which the block may have been: the cold one is two values wide, for a block
    whose values are as many below 0 as above ends at -63.5 deg C."""
    low_c, high_c = COLDEST_C + cold / 2, WARMEST_C - warm / 2
    return [low_c, high_c] if cold > 1 and warm > 0 and low_c <= high_c else None


def _seed(fingerprint: int) -> int:
    return zlib.crc32(struct.pack("<I", fingerprint))
