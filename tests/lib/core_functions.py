"""Functions of the core that the package has no use for, beside those that it has. Arrays as in tumble.core."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Flags, Floats, Integers
from tumble.core import (
    ESTIMATOR_ROWS,
    Calibration,
    CoreRefusal,
    CoreSchedule,
    GainRecord,
    JudgedRun,
    gain_table,
    require_estimable,
    require_ok,
    unpack,
)
from tumble.model.optimal import OptimalTable
from tumble.model.thermal import Polynomials
from tumble.solving.optimal_run import Weighting, make_table, record_of, to_bytes
from tumble.stand import Stand


def statuses() -> list[tuple[str, str]]:
    """Name and sentence of every status, by number."""
    refusals = [CoreRefusal(status) for status in range(lib.TUMBLE_STATUS_COUNT)]
    return [(refusal.name, refusal.sentence) for refusal in refusals]


def attitudes(schedule: CoreSchedule) -> Floats:
    """Specific force (g) on the block axes at every position of the ideal stand: (positions, 3)."""
    attitudes = np.empty((len(schedule), 3))
    for index, row in enumerate(attitudes):
        lib.tumble_schedule_attitude(schedule.struct, index, ffi.from_buffer("double[]", row))
    return attitudes


def estimate_gains(
    schedule: CoreSchedule, gains: Floats, means: Floats, measured: Flags | None = None
) -> tuple[Floats, Floats]:
    """K and U0 from a constant gain table (12, 3 x fit positions): rows K row by row, then U0; channel fastest."""
    table = np.ascontiguousarray(gains, dtype=float)
    if table.ndim != 2 or table.shape[0] != lib.TUMBLE_COEFFICIENTS or table.shape[1] % 3:
        raise ValueError(f"gains must have shape (12, 3 x fit positions), not {table.shape}")
    struct = ffi.new("tumble_gain_table_t *", [ffi.from_buffer("double[]", table), table.shape[1] // 3])
    coefficients = ffi.new("tumble_coefficients_t *")
    require_ok(lib.tumble_estimate_gains(struct, schedule.struct, schedule.means(means, measured), coefficients))
    return unpack(coefficients)


def apply(calibration: Calibration, outputs: Floats) -> Floats:
    """Specific force (g) from outputs (V), both (3,)."""
    outputs, force = np.ascontiguousarray(outputs, dtype=float).reshape(3), np.empty(3)
    pointers = ffi.from_buffer("double[]", outputs), ffi.from_buffer("double[]", force)
    lib.tumble_calibration_apply(calibration.struct, *pointers)
    return force


def apply_counts(calibration: Calibration, v_per_count: float, counts: Integers) -> Floats:
    """Specific force (g) from raw counts (3,) of `v_per_count` volts each."""
    whole, force = np.ascontiguousarray(counts, dtype=np.int32).reshape(3), np.empty(3)
    pointers = ffi.from_buffer("int32_t[]", whole), ffi.from_buffer("double[]", force)
    lib.tumble_calibration_apply_counts(calibration.struct, v_per_count, *pointers)
    return force


def schedule_crc(schedule: CoreSchedule) -> int:
    """The fingerprint that a record for this schedule must carry."""
    crc: int = lib.tumble_gain_record_schedule_crc(schedule.struct)
    return crc


def shown_inclinations(
    schedule: CoreSchedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    mean_variance: Floats | None = None,
    weights: Floats | None = None,
) -> tuple[Floats, Floats, tuple[float, float] | None]:
    """Of an estimate by `inclined`, arguments as of `uncertainties`: angles and their standard uncertainties, deg, and
    the level error with its own, rad, where the schedule has an inclination of 0. Raises CoreRefusal."""
    run = JudgedRun(schedule, k, stand, samples, None, mean_variance, weights=weights)
    found, refusal = ffi.new("tumble_shown_inclinations_t *"), ffi.new("tumble_refusal_t *")
    require_estimable(schedule, lib.tumble_uncertainty_inclinations(run.struct, found, refusal), refusal)
    deg, u_deg = (np.array(list(angles)[: found.count]) for angles in (found.deg, found.u_deg))
    return deg, u_deg, (found.level_rad, found.u_level_rad) if found.has_level else None


def worst_norm(
    schedule: CoreSchedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    estimator: str | None,
    gains: Floats | None = None,
    attitude: Floats | None = None,
) -> float:
    """The worst u(|a|), g, as the firmware finds it, within 1 %, or that at one `attitude`, a unit vector. `estimator`:
    a linear one, or None and its `gains`; else as of `uncertainties`. Raises CoreRefusal."""
    search, found = ffi.new("tumble_worst_norm_t *"), ffi.new("double *")
    none, refusal = ffi.new("tumble_uncertainty_t *"), ffi.new("tumble_refusal_t *")
    place = ffi.new("double[3]", [0.0] * 3 if attitude is None else attitude.tolist())
    run = JudgedRun(schedule, k, stand, samples, None, at=(place, found))
    table = None if gains is None else np.ascontiguousarray(gains, dtype=float)

    def judge() -> float:
        if table is not None:
            struct = gain_table(table, stand)
            require_ok(lib.tumble_uncertainty_gains(struct, run.struct, none))
        else:
            assert estimator is not None  # as documented
            require_estimable(schedule, ESTIMATOR_ROWS[estimator].uncertainty(run.struct, none, refusal), refusal)
        return float(found[0])

    if attitude is not None:
        return judge()
    lib.tumble_worst_norm_begin(search)
    while True:
        lib.tumble_worst_norm_attitude(search, place)
        if not lib.tumble_worst_norm_next(search, judge()):
            return float(search.worst_g)


def gains_of(record: GainRecord) -> Floats:
    """The rows of the coefficients (12, 3 x fit positions), K row by row, then U0."""
    return _table(record, lib.tumble_gain_record_gains(record.struct), lib.TUMBLE_COEFFICIENTS)


def stand_gains_of(record: GainRecord) -> Floats:
    """The rows of alpha1, alpha2, the yaws, the seats, the encoder, the drifts and the inclinations: (2 + yaws + 2
    seats + waves + drifts + 2 inclinations, 3 x fit positions)."""
    of = record.struct
    rows = 2 + of.yaws + 2 * of.seats + of.waves + of.drifts + 2 * of.inclinations
    return _table(record, lib.tumble_gain_record_stand_gains(of), rows)


def _table(record, numbers, rows: int) -> Floats:
    shape = rows, 3 * int(record.struct.fit_positions)
    return np.frombuffer(ffi.buffer(numbers, 8 * rows * shape[1])).reshape(shape).copy()


@dataclass(frozen=True)
class OptimalEstimate:
    """K (3, 3), U0 (3,), and the errors of the stand (rad): `alpha1`, `alpha2`, `alpha3` (mountings,)."""

    k: Floats
    u0: Floats
    alpha1: float
    alpha2: float
    alpha3: Floats


def optimal(record: bytes, schedule: CoreSchedule, means: Floats, measured: Flags | None = None) -> OptimalEstimate:
    """Coefficients and the stand's errors from one run's means (positions, 3). Raises CoreRefusal."""
    opened = GainRecord(schedule, record)
    found, work = ffi.new("tumble_coefficients_t *"), ffi.new("tumble_optimal_t *")
    filled = schedule.means(means, measured)
    require_ok(lib.tumble_estimate_optimal(opened.struct, schedule.struct, filled, found, work))
    stand = work.stand
    alpha3 = np.array(list(stand.alpha3_rad))[: opened.struct.mountings]
    return OptimalEstimate(*unpack(found), stand.alpha1_rad, stand.alpha2_rad, alpha3)


def apply_table(table: OptimalTable, schedule: CoreSchedule, means: Floats) -> OptimalEstimate:
    """By a table made for this very schedule, all of it measured."""
    return optimal(to_bytes(record_of(table, schedule.data)), schedule, means)


def estimate_optimal(schedule: CoreSchedule, means: Floats, measured: Flags, weighting: Weighting) -> OptimalEstimate:
    """By a table made for the run."""
    return apply_table(make_table(schedule, means, measured, weighting), schedule.part(measured), means[measured])


def _thermal(polynomials: Polynomials, range_c: tuple[float, float]) -> Any:
    """A tumble_thermal_t."""
    struct = ffi.new("tumble_thermal_t *", [polynomials.reference_c, *range_c])
    for power, k, u0 in zip(struct.power, polynomials.k, polynomials.u0):
        power.k_v_per_g, power.u0_v = k.tolist(), u0.tolist()
    return struct


def thermal_at(polynomials: Polynomials, range_c: tuple[float, float], temperature_c: float) -> tuple[Floats, Floats]:
    """K and U0 at a temperature within a range."""
    coefficients = ffi.new("tumble_coefficients_t *")
    require_ok(lib.tumble_thermal_at(_thermal(polynomials, range_c), temperature_c, coefficients))
    return unpack(coefficients)


def thermal_apply(
    polynomials: Polynomials, range_c: tuple[float, float], temperature_c: float, outputs: Floats
) -> Floats:
    """Specific force (g) from outputs (V), both (3,), at a temperature."""
    calibration, force = ffi.new("tumble_calibration_t *"), np.empty(3)
    require_ok(lib.tumble_thermal_calibration(_thermal(polynomials, range_c), temperature_c, calibration))
    lib.tumble_calibration_apply(calibration, ffi.from_buffer("double[]", outputs), ffi.from_buffer("double[]", force))
    return force


def thermal_update(
    polynomials: Polynomials,
    range_c: tuple[float, float],
    u: Floats,
    growth: Floats,
    temperature_c: float,
    run: Floats,
    u_run: Floats,
) -> tuple[Polynomials, Floats]:
    """The polynomials moved by a run, and their uncertainty (12,) there; K row by row, then U0."""
    thermal = _thermal(polynomials, range_c)
    coefficients = ffi.new("tumble_coefficients_t *", [run[:9].reshape(3, 3).tolist(), run[9:].tolist()])
    uncertain = [
        ffi.new("tumble_uncertainty_t *", [one[:9].reshape(3, 3).tolist(), one[9:].tolist()])
        for one in (u, growth, u_run)
    ]
    of_run = ffi.new("tumble_thermal_run_t *", [temperature_c, coefficients, uncertain[2]])
    require_ok(lib.tumble_thermal_update(thermal, uncertain[0], uncertain[1], of_run))
    powers = [unpack(ffi.addressof(thermal.power, power)) for power in range(len(thermal.power))]
    moved = Polynomials(polynomials.reference_c, *(np.array(one) for one in zip(*powers)))
    return moved, np.concatenate([np.ravel(one) for one in unpack(uncertain[0])])
