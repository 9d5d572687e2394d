"""The weights of the optimal estimator: made for a run, carried by a gain record, evaluated by the core.

Weights depend on K: they are made at the last known K of the block, or at a first least-squares estimate by the core;
for many runs at once (`solve_each`) at each run's own. A gain record is a table of them as bytes for non-volatile
memory, laid down in docs/files.md, and as a C header. Units in it are volts and radians.
"""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats, Integers
from tumble.core import GainRecord, Gains, estimate_runs, optimal_each, optimal_runs
from tumble.errors import UsageError
from tumble.model.errors import free, places, unit_effect
from tumble.model.estimators import design
from tumble.model.optimal import (
    LARGEST_LOSS,
    UNEQUAL,
    OptimalTable,
    by_mounting,
    channel_weights,
    mean_sigma,
    optimal_table,
    require_drift,
    samples_in_a_mean,
    shared_errors,
)
from tumble.schedule import FIT, Schedule
from tumble.stand import PerChannel, Stand, by_channel
from tumble.terms import Terms

MAGIC = b"TGR1"
SCHEMA = 1
_HEAD = struct.Struct("<4sIBBBBBBBBII")
_TAIL = struct.Struct("<II")


@dataclass(frozen=True)
class Record(OptimalTable):
    """A table for a schedule with so many `mountings`, and for one block unless `block_crc` is 0."""

    mountings: int
    schedule_crc: int
    block_crc: int

    @property
    def fit_positions(self) -> int:
        """That it weighs."""
        return int(self.gains.shape[1]) // 3


def record_of(table: OptimalTable, schedule: Schedule, serial: str | None = None) -> Record:
    """A table as a record, for one block if `serial` names it."""
    block_crc = 0 if serial is None else zlib.crc32(serial.encode("utf-8"))
    return Record(
        **vars(table), mountings=len(schedule.mountings), schedule_crc=fingerprint(schedule), block_crc=block_crc
    )


def fingerprint(schedule: Schedule) -> int:
    """CRC-32 over mountings and fit positions: gains of one schedule must not be applied to another."""
    crc = 0
    for mounting in schedule.mountings:
        numbers = [number + 0.0 for row in mounting.matrix for number in row]
        crc = zlib.crc32(struct.pack("<B10d", mounting.number, *numbers, mounting.tilt_deg + 0.0), crc)
        crc = zlib.crc32(bytes([mounting.bolting]) if mounting.bolting else b"", crc)
    for position in schedule.positions:
        if position.use == FIT:
            place = struct.pack("<BBd", position.mounting, position.number, position.angle_deg + 0.0)
            crc = zlib.crc32(place, crc)
    return crc


def to_bytes(record: Record) -> bytes:
    """The record, CRC and all."""
    head = np.concatenate([record.k.ravel(), record.sigma, [record.sigma_mean], record.u])
    inclination = [record.sigma_inclination] if record.inclinations else []
    tables = record.gains.ravel(), record.nuisance_gains.ravel()
    values = np.concatenate([head, *tables, inclination, _squares(record)])
    numbers: bytes = values.astype("<f8").tobytes()
    size = _HEAD.size + len(numbers) + _TAIL.size
    counts = record.fit_positions, record.mountings, record.yaws, record.seats, record.waves, record.drifts
    kind = MAGIC, size, SCHEMA, record.inclinations
    body = _HEAD.pack(*kind, *counts, record.schedule_crc, record.block_crc) + numbers + bytes(4)
    return body + struct.pack("<I", zlib.crc32(body))


def _squares(record: Record) -> Floats:
    """What the square of an output counts (3,); nothing where the channels are alike."""
    squares: Floats = record.weights**2
    return squares[: 0 if (squares == 1.0).all() else 3]


_INCLINATION_FIELD = "    double inclination_rad;\n"
_WEIGHTS_FIELD = "    double weights[3]; /* of the channels, squared */\n"
_HEADER = """\
/* Stand-optimal gains{title}: written by `tumble plan optimize`.
 *
 * For {record.fit_positions} fit positions in {record.mountings} mountings. The object is a gain record, byte for byte:
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
    double stand_gains[{stand_rows}][{columns}]; /* alpha1, alpha2, each yaw, seats, encoder (rad/V), drifts{more} */
{inclination_field}{weights_field}    uint32_t zero;
    uint32_t crc;
}} tumble_optimal_gains = {{
    .head = {{
        .magic = {{'T', 'G', 'R', '1'}},
        .size_bytes = {size}U,
        .schema = {schema}U,{inclinations}
        .fit_positions = {record.fit_positions}U,
        .mountings = {record.mountings}U,
        .yaws = {record.yaws}U,
        .seats = {record.seats}U,
        .waves = {record.waves}U,
        .drifts = {record.drifts}U,
        .schedule_crc = 0x{record.schedule_crc:08X}U,
        .block_crc = 0x{record.block_crc:08X}U,
        .k_v_per_g = {k},
        .sigma_rad = {sigma},
        .sigma_mean_v = {record.sigma_mean!r},
        .u_k_v_per_g = {u_k},
        .u_u0_v = {u_u0},
    }},
    .gains = {gains},
    .stand_gains = {stand_gains},{inclination}{weights}
    .zero = 0U,
    .crc = 0x{crc:08X}U,
}};

static_assert(sizeof tumble_optimal_gains == {size}U, "laid out as docs/files.md says");

#endif
"""


def to_c_header(record: Record, title: str = "") -> str:
    """The record as C source. `title`: of the stand, made fit for a comment."""
    data, squares, inclined = to_bytes(record), _squares(record), record.inclinations > 0
    printable = "".join(sign if sign.isalnum() or sign in " -.,()" else "_" for sign in ascii(title)[1:-1])
    return _HEADER.format(
        title=f" for: {printable}" if printable else "",
        record=record,
        gain_rows=len(record.gains),
        stand_rows=len(record.nuisance_gains),
        columns=record.gains.shape[1],
        size=len(data),
        schema=SCHEMA,
        k=_c_array(record.k),
        sigma=_c_array(record.sigma),
        u_k=_c_array(record.u[:9].reshape(3, 3)),
        u_u0=_c_array(record.u[9:]),
        gains=_c_array(record.gains),
        stand_gains=_c_array(record.nuisance_gains),
        more=", inclinations" if inclined else "",
        inclinations=f"\n        .inclinations = {record.inclinations}U," if inclined else "",
        inclination_field=_INCLINATION_FIELD if inclined else "",
        inclination=f"\n    .inclination_rad = {record.sigma_inclination!r}," if inclined else "",
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
    of the outputs; `samples` (positions,) of the run; `known`: of a table that existed before the run, if one did;
    `schedule`: where inclinations are declared and the run shows others, the one that they are for."""

    stand: Stand
    samples: Integers
    step: PerChannel = 0.0
    known: Known | None = None
    schedule: core.CoreSchedule | None = None


def require_declared_inclinations(schedule: Schedule, stand: Stand) -> None:
    """Raise UsageError where a gain record, which exists before a run, would need the inclinations that it shows."""
    if free(stand, schedule):
        raise UsageError(
            "a gain record needs inclination_rad, how well the stand is inclined: declare it, or take inclined on"
            " board; solve and plan validate have optimal without"
        )


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


def apply_table(table: OptimalTable, schedule: core.CoreSchedule, means: Floats) -> Floats:
    """Coefficients (12,) by the core, from a table for this very schedule, all of it measured. Raises CoreRefusal."""
    found: Floats = optimal_runs(GainRecord(schedule, to_bytes(record_of(table, schedule.data))), means[None])[0][0]
    return found


# Many runs at once, each with weights at its own K: optimal_table in stacks. The system is the one of model.optimal but
# for the errors of the set angles. Each of these moves the three outputs of its own position alone, along d =
# sigma4 K f', so it needs no column: the reflection that turns d to the first axis leaves noise of
# sqrt(sigma^2 + |d|^2) along that axis and of sigma on the other two, and dividing the first row by their ratio makes
# all noise alike. Exact, and as well conditioned as the whole system. Every run is reckoned by itself, so numbers do
# not depend on how many runs are in a stack.

_AT_ONCE = 50  # runs: what a stack of them takes stays in a processor's second cache


def solve_each(
    schedule: Schedule, means: Floats, stand: Stand, step: PerChannel, samples: float
) -> tuple[Floats, Floats]:
    """Coefficients (runs, 12) by the core, with weights made at each run's first estimate, from means (runs, positions,
    3) of a schedule that has fit positions alone; and standard uncertainties (runs, 12) at the K found. `step` as in
    optimal_table; `samples`: of a mean, for the weights; uncertainties are for the stand's own.

    Raises CoreRefusal; UsageError where weights cannot be made.
    """
    system = _System(schedule, stand, step)
    opened = core.CoreSchedule(schedule)
    first = estimate_runs(opened, means, "least_squares")[:, :9].reshape(-1, 3, 3)
    table = optimal_table(schedule, first[0], stand, step, samples)
    record = GainRecord(opened, to_bytes(record_of(table, schedule)))
    found, u = np.empty((2, len(means), 12))
    for start in range(0, len(means), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        found[part] = optimal_each(record, means[part], system.weights(first[part], samples))
        u[part] = system.uncertainties(found[part, :9].reshape(-1, 3, 3))
    return found, u


class _Mirror:
    """Makes the noise of outputs alike: for positions whose angle's error moves them by `along` (runs, P, 3), beside
    noise `sigma` (runs,). The reflection is I - v w^T, with v along the sum of d/|d| and the first axis, both taken to
    one side, so that nothing cancels."""

    def __init__(self, along: Floats, sigma: Floats):
        size = np.linalg.norm(along, axis=2, keepdims=True)
        anywhere = np.broadcast_to(np.eye(3)[0], along.shape).copy()
        self.v = np.divide(along, size, out=anywhere, where=size > 0.0)
        self.v[..., 0] += np.where(self.v[..., 0] < 0.0, -1.0, 1.0)
        self.w = self.v / np.abs(self.v[..., :1])
        self.ratio = sigma[:, None] / np.hypot(size[..., 0], sigma[:, None])

    def of(self, outputs: Floats) -> Floats:
        """Of columns (runs, P, 3, n) of outputs."""
        across = _dot(np.swapaxes(outputs, 2, 3), self.w[:, :, None])
        turned: Floats = outputs - self.v[..., None] * across[:, :, None]
        turned[:, :, 0] *= self.ratio[..., None]
        return turned

    def back(self, rows: Floats) -> Floats:
        """Gains (runs, n, 3P) of what `of` made, as gains of the outputs."""
        by_position = rows.reshape(*rows.shape[:2], -1, 3).copy()
        by_position[..., 0] *= self.ratio[:, None]
        across = _dot(by_position, self.v[:, None])
        turned: Floats = by_position - across[..., None] * self.w[:, None]
        return turned.reshape(rows.shape)


@dataclass(frozen=True)
class _Whitened:
    """Runs with noise alike in all rows: `rows` (runs, 3P + shared, shared + 12), the prior's behind the outputs'. What
    they came from: outputs `by_shared` (runs, P, 3, shared), in units of the prior, and `by_angle` (runs, P, 3);
    `mirror`; `sigma` (runs, 3) of a mean, and the `weights` (runs, 1, 3) that make channels alike."""

    rows: Floats
    by_shared: Floats
    by_angle: Floats
    mirror: _Mirror
    sigma: Floats
    weights: Floats


class _System:
    """What the runs of a stand and a schedule share."""

    def __init__(self, schedule: Schedule, stand: Stand, step: PerChannel):
        self.schedule, self.stand, self.step = schedule, stand, step
        self.errors = shared_errors(schedule, np.eye(3), stand)
        self.shared = np.concatenate([source.sigma for source in self.errors.values()])
        self.design = design(schedule).reshape(-1, 3, 12)
        by_shared = np.concatenate([source.derivative for source in self.errors.values()])
        self.by_shared = np.moveaxis(by_shared, 0, 2) * self.shared
        self.drift = places(self.errors).get("drift", slice(0))  # which does not depend on K
        self.by_angle = unit_effect(schedule, "alpha4").derivative(np.eye(3)).sum(axis=0) * stand.sigma("angle")

    def whiten(self, k: Floats, samples: float) -> _Whitened:
        """For blocks of sensitivity `k` (runs, 3, 3)."""
        runs, positions, shared = len(k), len(self.design), len(self.shared)
        sigma = mean_sigma(k, self.stand, self.step, samples)[0]
        require_drift(self.stand.sigmas("drift") / sigma)
        weights, largest = channel_weights(sigma)[:, None], sigma.max(axis=1)
        by_channel = k @ np.swapaxes(self.by_shared, 0, 1).reshape(3, -1)  # those of `by_shared` are for K = 1
        by_shared = np.swapaxes(by_channel.reshape(runs, 3, positions, shared), 1, 2).copy()
        by_shared[..., self.drift] = self.by_shared[..., self.drift]
        by_angle = self.by_angle @ np.swapaxes(k, 1, 2)
        outputs = np.empty((runs, positions, 3, shared + 12))
        outputs[..., :shared], outputs[..., shared:] = by_shared, self.design
        outputs *= weights[..., None]
        mirror = _Mirror(by_angle * weights, largest)
        prior = largest[:, None, None] * np.eye(shared, shared + 12)
        rows = np.concatenate([mirror.of(outputs).reshape(runs, -1, shared + 12), prior], axis=1)
        return _Whitened(rows, by_shared, by_angle, mirror, sigma, weights)

    def weights(self, k: Floats, samples: float) -> Gains:
        """For each run. Raises UsageError where numbers are beyond any stand."""
        system, shared = self.whiten(k, samples), len(self.shared)
        q, r = np.linalg.qr(system.rows)
        data = np.swapaxes(q[:, : 3 * len(self.design)], 1, 2)
        with np.errstate(all="ignore"):
            beta = np.linalg.solve(r[:, shared:, shared:], data[:, shared:])
            left = data[:, :shared] - r[:, :shared, shared:] @ beta
            prior = self.shared[:, None] * np.linalg.solve(r[:, :shared, :shared], left)
            weights = np.tile(system.weights, len(self.design))
            beta, prior = system.mirror.back(beta) * weights, system.mirror.back(prior) * weights
            # as optimal_table: the gains give back the coefficients, and their spread is the one that QR says
            u = _deviations(r[:, shared:, shared:], system.sigma)
            lost = np.abs(beta @ self.design.reshape(-1, 12) - np.eye(12)).max()
            by_shared = beta @ system.by_shared.reshape(*beta.shape[::2], -1)
            by_angle = _dot(beta.reshape(*beta.shape[:2], -1, 3), system.by_angle[:, None])
            noise = _dot((beta**2).reshape(*beta.shape[:2], -1, 3).sum(axis=2), system.sigma[:, None] ** 2)
            claimed = np.sqrt((by_shared**2).sum(axis=2) + (by_angle**2).sum(axis=2) + noise)
            sound = lost < LARGEST_LOSS and (np.abs(claimed - u) < LARGEST_LOSS * u).all()
        if not (np.isfinite(prior).all() and sound):
            raise UsageError(UNEQUAL)
        return Gains(
            k,
            system.sigma.max(axis=1),
            system.weights[:, 0],
            beta,
            by_mounting(prior, self.errors, self.schedule, self.stand),
        )

    def uncertainties(self, k: Floats) -> Floats:
        """What the runs state (runs, 12): of the estimates, for blocks of sensitivity `k`."""
        system, shared = self.whiten(k, self.stand.samples), len(self.shared)
        r = np.asarray(np.linalg.qr(system.rows, mode="r"))
        u, rounding = _deviations(r[:, shared:, shared:], system.sigma), by_channel(self.stand.rounding)
        if not rounding.any():
            return u
        gains_of_runs = self.weights(k, self.stand.samples).gains
        by_rounding = (gains_of_runs**2).reshape(len(k), 12, -1, 3).sum(axis=2) @ rounding**2
        together: Floats = np.sqrt(u**2 + by_rounding)
        return together


def _dot(one: Floats, other: Floats) -> Floats:
    """Over a last axis of three, which a sum of numpy takes several times as long for."""
    product: Floats = one[..., 0] * other[..., 0] + one[..., 1] * other[..., 1] + one[..., 2] * other[..., 2]
    return product


def _deviations(r: Floats, sigma: Floats) -> Floats:
    deviations: Floats = sigma.max(axis=1)[:, None] * np.sqrt((np.linalg.inv(r) ** 2).sum(axis=2))
    return deviations
