"""The weights of the optimal estimator for one run: the record that carries them, and the run that is solved by them.

The gain record: a table of the optimal estimator as bytes for non-volatile memory, and as a C header.

The layout is laid down in docs/gain-record.md. Units in it are volts and radians.

The optimal estimator for a recorded run: weights made for the run, evaluated by the core.

Weights depend on K: they are made at the last known K of the block, or at a first least-squares estimate by the core.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats, Integers
from tumble.core.binding import OptimalEstimate, optimal
from tumble.model.optimal import OptimalTable, optimal_table, samples_in_a_mean
from tumble.schedule import FIT, Schedule
from tumble.stand import PerChannel, Stand
from tumble.terms import Terms

MAGIC = b"TGR1"
SCHEMA = 1
_HEAD = struct.Struct("<4sIHBBBBBBII")
_TAIL = struct.Struct("<II")
_WEIGHTS_BYTES = 24  # of the channels, behind the gains, if they differ
_HEAD_DOUBLES = 26  # K, sigma alpha1..4, sigma of a mean, u of K and U0


class BadRecord(Exception):
    """Bytes that are no gain record: says why."""


@dataclass(frozen=True)
class Record:
    """A record's contents. `fit_positions` to `drifts`: its counts; arrays as in OptimalTable."""

    fit_positions: int
    mountings: int
    yaws: int
    seats: int
    waves: int
    drifts: int
    schedule_crc: int
    block_crc: int
    k: Floats
    sigma: Floats
    sigma_mean: float
    u: Floats
    gains: Floats
    nuisance_gains: Floats
    weights: Floats = field(default_factory=lambda: np.ones(3))


def record_of(table: OptimalTable, schedule: Schedule, serial: str | None = None) -> Record:
    """A table as a record, for one block if `serial` names it."""
    return Record(
        fit_positions=table.gains.shape[1] // 3,
        mountings=len(schedule.mountings),
        yaws=table.yaws,
        seats=table.seats,
        waves=table.waves,
        drifts=table.drifts,
        schedule_crc=fingerprint(schedule),
        block_crc=0 if serial is None else zlib.crc32(serial.encode("utf-8")),
        k=table.k,
        sigma=table.sigma,
        sigma_mean=table.sigma_mean,
        weights=table.weights,
        u=table.u,
        gains=table.gains,
        nuisance_gains=table.nuisance_gains,
    )


def fingerprint(schedule: Schedule) -> int:
    """CRC-32 over mountings and fit positions: gains of one schedule must not be applied to another."""
    crc = 0
    for mounting in schedule.mountings:
        numbers = [number + 0.0 for row in mounting.matrix for number in row]
        crc = zlib.crc32(struct.pack("<B10d", mounting.number, *numbers, mounting.tilt_deg + 0.0), crc)
    for position in schedule.positions:
        if position.use == FIT:
            place = struct.pack("<BBd", position.mounting, position.number, position.angle_deg + 0.0)
            crc = zlib.crc32(place, crc)
    return crc


def to_bytes(record: Record) -> bytes:
    """The record, CRC and all."""
    head = np.concatenate([record.k.ravel(), record.sigma, [record.sigma_mean], record.u])
    values = np.concatenate([head, record.gains.ravel(), record.nuisance_gains.ravel(), _squares(record)])
    numbers: bytes = values.astype("<f8").tobytes()
    size = _HEAD.size + len(numbers) + _TAIL.size
    counts = record.fit_positions, record.mountings, record.yaws, record.seats, record.waves, record.drifts
    body = _HEAD.pack(MAGIC, size, SCHEMA, *counts, record.schedule_crc, record.block_crc) + numbers + bytes(4)
    return body + struct.pack("<I", zlib.crc32(body))


def _squares(record: Record) -> Floats:
    """What the square of an output counts (3,); nothing where the channels are alike."""
    squares: Floats = record.weights**2
    return squares[: 0 if (squares == 1.0).all() else 3]


def from_bytes(data: bytes) -> Record:
    """Read a record again. Raises BadRecord."""
    if len(data) < _HEAD.size + _TAIL.size or data[:4] != MAGIC:
        raise BadRecord("not a gain record")
    _, size, schema, positions, mountings, yaws, seats, waves, drifts, *crcs = _HEAD.unpack_from(data)
    alike = size_of(positions, yaws, seats, waves, drifts)
    if schema != SCHEMA or size not in (alike, alike + _WEIGHTS_BYTES) or size > len(data):
        raise BadRecord("a gain record of another schema or size")
    possible = yaws in (1, mountings) and seats in (0, mountings) and waves in (0, 4) and drifts in (0, 3)
    if positions == 0 or not possible:
        raise BadRecord(
            "a gain record without a position, or with an impossible number of yaws, seats, waves or drifts"
        )
    zero, crc = _TAIL.unpack_from(data, size - _TAIL.size)
    if zlib.crc32(data[: size - 4]) != crc or zero != 0:
        raise BadRecord("a gain record whose checksum does not agree")
    numbers = np.frombuffer(data, "<f8", (size - _HEAD.size - _TAIL.size) // 8, _HEAD.size).astype(float)
    head, squares = numbers[:_HEAD_DOUBLES], numbers[(alike - _HEAD.size - _TAIL.size) // 8 :]
    tables = numbers[_HEAD_DOUBLES : len(numbers) - len(squares)].reshape(-1, 3 * positions)
    if not (squares > 0.0).all():
        raise BadRecord("a gain record with a weight that is not above 0")
    return Record(
        *(positions, mountings, yaws, seats, waves, drifts),
        schedule_crc=crcs[0],
        block_crc=crcs[1],
        k=head[:9].reshape(3, 3),
        sigma=head[9:13],
        sigma_mean=float(head[13]),
        weights=np.sqrt(squares) if len(squares) else np.ones(3),
        u=head[14:],
        gains=tables[:12],
        nuisance_gains=tables[12:],
    )


def size_of(fit_positions: int, yaws: int, seats: int = 0, waves: int = 0, drifts: int = 0) -> int:
    """Size in bytes of a record for channels that are alike."""
    rows = 14 + yaws + 2 * seats + waves + drifts
    return _HEAD.size + 8 * _HEAD_DOUBLES + 8 * 3 * fit_positions * rows + _TAIL.size


_WEIGHTS_FIELD = "    double weights[3]; /* of the channels, squared */\n"
_HEADER = """\
/* Stand-optimal gains{title}: written by `tumble plan optimize`.
 *
 * For {positions} fit positions in {mountings} mountings. The object is a gain record, byte for byte:
 * tumble_gain_record_open(&tumble_optimal_gains, sizeof tumble_optimal_gains, schedule, &record) checks it.
 */
#ifndef TUMBLE_OPTIMAL_GAINS_H
#define TUMBLE_OPTIMAL_GAINS_H

#include "tumble/core.h"

#include <assert.h>
#include <stdint.h>

static const struct {{
    tumble_gain_record_t head;
    double gains[{gain_rows}][{columns}];       /* K row by row (1/g), then U0 */
    double stand_gains[{stand_rows}][{columns}]; /* alpha1, alpha2, each yaw, seats, encoder (rad/V), drifts */
{weights_field}    uint32_t zero;
    uint32_t crc;
}} tumble_optimal_gains = {{
    .head = {{
        .magic = {{'T', 'G', 'R', '1'}},
        .size_bytes = {size}U,
        .schema = {schema}U,
        .fit_positions = {positions}U,
        .mountings = {mountings}U,
        .yaws = {yaws}U,
        .seats = {seats}U,
        .waves = {waves}U,
        .drifts = {drifts}U,
        .schedule_crc = 0x{schedule_crc:08X}U,
        .block_crc = 0x{block_crc:08X}U,
        .k_v_per_g = {k},
        .sigma_rad = {sigma},
        .sigma_mean_v = {sigma_mean!r},
        .u_k_v_per_g = {u_k},
        .u_u0_v = {u_u0},
    }},
    .gains = {gains},
    .stand_gains = {stand_gains},{weights}
    .zero = 0U,
    .crc = 0x{crc:08X}U,
}};

static_assert(sizeof tumble_optimal_gains == {size}U, "laid out as docs/gain-record.md says");

#endif
"""


def to_c_header(record: Record, title: str = "") -> str:
    """The record as C source. `title`: of the stand, made fit for a comment."""
    data, squares = to_bytes(record), _squares(record)
    words = "".join(sign if sign.isalnum() or sign in " -.,()" else "_" for sign in ascii(title)[1:-1])
    return _HEADER.format(
        title=f" for: {words}" if words else "",
        positions=record.fit_positions,
        mountings=record.mountings,
        yaws=record.yaws,
        seats=record.seats,
        waves=record.waves,
        drifts=record.drifts,
        gain_rows=len(record.gains),
        stand_rows=len(record.nuisance_gains),
        columns=record.gains.shape[1],
        size=len(data),
        schema=SCHEMA,
        schedule_crc=record.schedule_crc,
        block_crc=record.block_crc,
        k=_c_array(record.k),
        sigma=_c_array(record.sigma),
        sigma_mean=float(record.sigma_mean),
        u_k=_c_array(record.u[:9].reshape(3, 3)),
        u_u0=_c_array(record.u[9:]),
        gains=_c_array(record.gains),
        stand_gains=_c_array(record.nuisance_gains),
        weights_field=_WEIGHTS_FIELD if len(squares) else "",
        weights=f"\n    .weights = {_c_array(squares)}," if len(squares) else "",
        crc=_TAIL.unpack_from(data, len(data) - _TAIL.size)[1],
    )


def _c_array(values: Floats) -> str:
    """Braces and numbers that read back as the same bits, a few to a line."""
    if values.ndim > 1:
        return "{\n        " + ",\n        ".join(map(_c_array, values)) + "}"
    numbers = [repr(float(value)) for value in values]
    lines = [", ".join(numbers[start : start + 4]) for start in range(0, len(numbers), 4)]
    return "{" + ",\n         ".join(lines) + "}"


@dataclass(frozen=True)
class Known:
    """What a table was made for that existed before the run: the block's `k` (3, 3), `samples` expected in every mean,
    not necessarily a whole number."""

    k: Floats
    samples: float


@dataclass(frozen=True)
class Weighting:
    """What weights are made from: the declared `stand`, its noise and the converter's `step` (0: unknown) in the unit
    of the outputs; `samples` (positions,) of the run; `known`: of a table that existed before the run,
    if one did."""

    stand: Stand
    samples: Integers
    step: PerChannel = 0.0
    known: Known | None = None


def make_table(
    schedule: core.CoreSchedule, means: Floats, measured: Flags, weighting: Weighting, terms: Terms = ()
) -> OptimalTable:
    """The weights for a run, of a model with further `terms`. Raises CoreRefusal, UsageError."""
    part, known = schedule.data.part(measured), weighting.known
    if known is not None:
        return optimal_table(part, known.k, weighting.stand, weighting.step, known.samples, terms)
    first = core.estimate(schedule, means, measured, "least_squares")[0]
    samples = samples_in_a_mean(part, weighting.stand, weighting.samples[measured])
    return optimal_table(part, first, weighting.stand, weighting.step, samples, terms)


def apply_table(table: OptimalTable, schedule: core.CoreSchedule, means: Floats) -> OptimalEstimate:
    """Let the core evaluate a table made for this very schedule, all of it measured. Raises CoreRefusal."""
    return optimal(to_bytes(record_of(table, schedule.data)), schedule, means)


def estimate(schedule: core.CoreSchedule, means: Floats, measured: Flags, weighting: Weighting) -> OptimalEstimate:
    """Coefficients and the stand's errors by the core. Raises CoreRefusal; UsageError where weights cannot be made."""
    table = make_table(schedule, means, measured, weighting)
    return apply_table(table, schedule.part(measured), means[measured])
