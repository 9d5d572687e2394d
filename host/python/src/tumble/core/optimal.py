"""The core's stand-optimal estimator and its gain record, for Python; and any estimator for many runs at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Flags, Floats
from tumble.core.binding import LINEAR_ESTIMATORS, CoreSchedule, require_ok, unpack

if TYPE_CHECKING:
    from _tumble_core import CData


_BEFORE_NUMBERS, _HEAD, _SIGMA_MEAN = 24, 26, 13  # of a gain record: bytes; numbers before the gains; one of them


@dataclass(frozen=True)
class OptimalEstimate:
    """K (3, 3), U0 (3,), and the errors of the stand (rad): `alpha1`, `alpha2`, `alpha3` (mountings,)."""

    k: Floats
    u0: Floats
    alpha1: float
    alpha2: float
    alpha3: Floats


class GainRecord:
    """A gain record (docs/gain-record.md) opened by the core for one schedule. Raises CoreRefusal."""

    def __init__(self, schedule: CoreSchedule, record: bytes):
        self.schedule = schedule
        self._memory = ffi.new("double[]", (len(record) + 7) // 8)  # aligned as the record demands
        ffi.memmove(self._memory, record, len(record))
        opened = ffi.new("const tumble_gain_record_t **")
        require_ok(lib.tumble_gain_record_open(self._memory, len(record), schedule.struct, opened))
        self.struct = opened[0]

    @property
    def gains(self) -> Floats:
        """The rows of the coefficients (12, 3 x fit positions), K row by row, then U0."""
        return self._table(lib.tumble_gain_record_gains(self.struct), lib.TUMBLE_COEFFICIENTS)

    @property
    def stand_gains(self) -> Floats:
        """The rows of alpha1, alpha2, the yaws, the seats, the encoder and the drifts: (2 + yaws + 2 seats + waves +
        drifts, 3 x fit positions)."""
        rows = 2 + self.struct.yaws + 2 * self.struct.seats + self.struct.waves + self.struct.drifts
        return self._table(lib.tumble_gain_record_stand_gains(self.struct), rows)

    def numbers(self) -> Floats:
        """K, the prior, the noise and the uncertainties (26 numbers), then all gains: in place."""
        return np.frombuffer(ffi.buffer(self._memory), offset=_BEFORE_NUMBERS)[:-1]  # the last: zero and CRC

    def _table(self, numbers: CData, rows: int) -> Floats:
        shape = rows, 3 * int(self.struct.fit_positions)
        return np.frombuffer(ffi.buffer(numbers, 8 * rows * shape[1])).reshape(shape).copy()


def schedule_crc(schedule: CoreSchedule) -> int:
    """The fingerprint that a record for this schedule must carry."""
    crc: int = lib.tumble_gain_record_schedule_crc(schedule.struct)
    return crc


def optimal(record: bytes, schedule: CoreSchedule, means: Floats, measured: Flags | None = None) -> OptimalEstimate:
    """Coefficients and the stand's errors from one run's means (positions, 3). Raises CoreRefusal."""
    opened = GainRecord(schedule, record)
    found, work = ffi.new("tumble_coefficients_t *"), ffi.new("tumble_optimal_t *")
    filled = schedule.means(means, measured)
    require_ok(lib.tumble_estimate_optimal(opened.struct, schedule.struct, filled, found, work))
    stand = work.stand
    alpha3 = np.array(list(stand.alpha3_rad))[: opened.struct.mountings]
    return OptimalEstimate(*unpack(found), stand.alpha1_rad, stand.alpha2_rad, alpha3)


def estimate_runs(schedule: CoreSchedule, means: Floats, estimator: str) -> Floats:
    """Coefficients (runs, 12), K row by row, then U0, of means (runs, positions, 3), all measured, by one of
    estimators.LINEAR. Raises CoreRefusal(run=index) at the first run refused."""
    means, found, where = _arrays(schedule, means)
    pointers = ffi.from_buffer("double[]", means), ffi.from_buffer("double[]", found)
    status = lib.batch_estimate(LINEAR_ESTIMATORS[estimator], schedule.struct, len(means), *pointers, where)
    require_ok(status, run=where[0])
    return found


def optimal_runs(record: GainRecord, means: Floats) -> tuple[Floats, Floats]:
    """As estimate_runs, by `optimal`: coefficients (runs, 12) and the stand's errors (runs, 2 + mountings): alpha1,
    alpha2, alpha3 by mounting, rad."""
    means, found, where = _arrays(record.schedule, means)
    stand = np.empty((len(means), ffi.sizeof("tumble_stand_errors_t") // 8))
    pointers = [ffi.from_buffer("double[]", array) for array in (means, found, stand)]
    status = lib.batch_optimal(record.struct, record.schedule.struct, len(means), *pointers, where)
    require_ok(status, run=where[0])
    return found, stand[:, : 2 + record.struct.mountings]


@dataclass(frozen=True)
class Gains:
    """Tables of many runs: `k` (runs, 3, 3) that each was made at, `sigma_mean` (runs,) and `weights` (runs, 3) of the
    channels, `gains` (runs, 12, 3 x fit positions) and `stand_gains`, rows as in a gain record."""

    k: Floats
    sigma_mean: Floats
    weights: Floats
    gains: Floats
    stand_gains: Floats


def optimal_each(record: GainRecord, means: Floats, tables: Gains) -> Floats:
    """As optimal_runs, but each run by its own table, of finite numbers: coefficients (runs, 12). The tables take turns
    in the memory of `record`, which the core has checked and which lends the rest; nobody else sees them, so they get
    no checksum. Raises CoreRefusal(run=index)."""
    means, found, where = _arrays(record.schedule, means)
    stand = np.empty(ffi.sizeof("tumble_stand_errors_t") // 8)
    parts = [tables.gains.reshape(len(means), -1), tables.stand_gains.reshape(len(means), -1)]
    numbers, into = np.concatenate(parts, axis=1), record.numbers()
    if len(into) > _HEAD + numbers.shape[1]:
        numbers = np.hstack([numbers, tables.weights**2])
    pointers = [ffi.from_buffer("double[]", array) for array in (means, found)]
    spare, columns = ffi.from_buffer("double[]", stand), means[0].size
    for run, (k, sigma_mean) in enumerate(zip(tables.k.reshape(-1, 9), tables.sigma_mean)):
        into[:9], into[_SIGMA_MEAN], into[_HEAD:] = k, sigma_mean, numbers[run]
        here = pointers[0] + run * columns, pointers[1] + run * lib.TUMBLE_COEFFICIENTS
        status = lib.batch_optimal(record.struct, record.schedule.struct, 1, *here, spare, where)
        require_ok(status, run=run)
    return found


def require_small(angles: Floats) -> None:
    """Raise CoreRefusal where an error of a stand, rad, is larger than the estimator can do with."""
    if not np.abs(angles).max(initial=0.0) <= lib.TUMBLE_MAX_STAND_ERROR_RAD:
        require_ok(lib.TUMBLE_E_STAND_ERROR)


def _arrays(schedule: CoreSchedule, means: Floats) -> tuple[Floats, Floats, CData]:
    means = np.ascontiguousarray(means, dtype=float)
    if means.ndim != 3 or means.shape[1:] != (len(schedule), 3):
        raise ValueError(f"means must have shape (runs, {len(schedule)}, 3), not {means.shape}")
    return means, np.empty((len(means), lib.TUMBLE_COEFFICIENTS)), ffi.new("size_t *")
