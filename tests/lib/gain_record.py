"""A gain record read again (docs/files.md), to hold against what was written."""
import struct
import zlib

import numpy as np

from tumble.solving.optimal_run import MAGIC, SCHEMA, Record

_HEAD, _TAIL = struct.Struct("<4sIBBBBBBBBII"), struct.Struct("<II")
_WEIGHTS_BYTES = 24  # of the channels, behind the gains, if they differ
_HEAD_DOUBLES = 26  # K, sigma alpha1..4, sigma of a mean, u of K and U0


class BadRecord(Exception):
    """Bytes that are no gain record: says why."""


def from_bytes(data):
    """Read a record again. Raises BadRecord."""
    if len(data) < _HEAD.size + _TAIL.size or data[:4] != MAGIC:
        raise BadRecord("not a gain record")
    _, size, schema, inclinations, positions, mountings, yaws, seats, waves, drifts, *crcs = _HEAD.unpack_from(data)
    alike = size_of(positions, yaws, seats, waves, drifts, inclinations)
    if schema != SCHEMA or size not in (alike, alike + _WEIGHTS_BYTES) or size > len(data):
        raise BadRecord("a gain record of another schema or size")
    possible = yaws in (1, mountings) and seats in (0, mountings) and waves in (0, 4) and drifts in (0, 3)
    if positions == 0 or not possible or inclinations not in (0, mountings):
        raise BadRecord(
            "a gain record without a position, or with an impossible number of yaws, seats, waves, drifts, inclinations"
        )
    zero, crc = _TAIL.unpack_from(data, size - _TAIL.size)
    if zlib.crc32(data[: size - 4]) != crc or zero != 0:
        raise BadRecord("a gain record whose checksum does not agree")
    numbers = np.frombuffer(data, "<f8", (size - _HEAD.size - _TAIL.size) // 8, _HEAD.size).astype(float)
    head, squares = numbers[:_HEAD_DOUBLES], numbers[(alike - _HEAD.size - _TAIL.size) // 8 :]
    tables, sigma = numbers[_HEAD_DOUBLES : len(numbers) - len(squares)], 0.0
    if inclinations:
        tables, sigma = tables[:-1], float(tables[-1])
    tables = tables.reshape(-1, 3 * positions)
    if not (squares > 0.0).all():
        raise BadRecord("a gain record with a weight that is not above 0")
    return Record(
        yaws=yaws,
        seats=seats,
        waves=waves,
        drifts=drifts,
        mountings=mountings,
        schedule_crc=crcs[0],
        block_crc=crcs[1],
        k=head[:9].reshape(3, 3),
        sigma=head[9:13],
        sigma_mean=float(head[13]),
        weights=np.sqrt(squares) if len(squares) else np.ones(3),
        u=head[14:],
        gains=tables[:12],
        nuisance_gains=tables[12:],
        inclinations=inclinations,
        sigma_inclination=sigma,
        floored=False,
    )


def size_of(fit_positions, yaws, seats=0, waves=0, drifts=0, inclinations=0):
    """Size in bytes of a record for channels that are alike."""
    rows = 14 + yaws + 2 * seats + waves + drifts + 2 * inclinations
    sigma_bytes = 8 if inclinations else 0
    return _HEAD.size + 8 * _HEAD_DOUBLES + 8 * 3 * fit_positions * rows + sigma_bytes + _TAIL.size
