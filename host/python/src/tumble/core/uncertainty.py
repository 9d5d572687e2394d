"""The core's standard uncertainties, for Python."""

from __future__ import annotations

from typing import Any

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Flags, Floats, Integers
from tumble.core.binding import ESTIMATOR_ROWS, CoreSchedule, pack, require_estimable, require_ok, unpack
from tumble.stand import COMMON, PER_CHANNEL, SOURCES, Stand, per_channel


def record_of(stand: Stand, least_noise: float = 0.0) -> Any:
    """The declared stand as the core takes it; the noise of a mean never counts as less than `least_noise`."""
    angles = [source for source in SOURCES.values() if source.is_angle]
    numbers: dict[str, Any] = {source.key: stand.sigma(source.attribute) for source in angles}
    for source in PER_CHANNEL:
        sigma = per_channel(stand.sigmas(source))
        numbers[f"channel_{source}_v" if isinstance(sigma, tuple) else f"{source}_v"] = sigma
    labels = {"least_noise_v": least_noise, "samples": stand.samples, "common_yaw": stand.remounting == COMMON}
    return ffi.new("tumble_stand_record_t *", numbers | labels)


class _JudgedRun:
    """A run as the core has it; keeps what the structure points at."""

    def __init__(
        self,
        schedule: CoreSchedule,
        k: Floats,
        stand: Stand,
        samples: Integers,
        measured: Flags | None,
        mean_variance: Floats | None = None,
        least_noise: float = 0.0,
        at: tuple[Any, Any] = (ffi.NULL, ffi.NULL),
    ):
        """`at`: an attitude, double[3], and where u(|a|) there is to be written, double *."""
        averaged_over = stand.averaged_over(samples)
        self._stand = record_of(stand, least_noise)
        self._coefficients = pack(k, np.zeros(3))
        self._samples = ffi.new("uint32_t[]", averaged_over.tolist())
        self._flags = schedule.flags(measured)
        self._excess = ffi.NULL
        if mean_variance is not None:
            declared = np.maximum(stand.mean_variance(samples), least_noise**2)
            self._excess = ffi.from_buffer(np.maximum(mean_variance - declared, 0.0))
        self.struct = ffi.new(
            "tumble_judged_run_t *",
            {
                "schedule": schedule.struct,
                "stand": self._stand,
                "coefficients": self._coefficients,
                "measured": self._flags,
                "samples": self._samples,
                "excess_variance_v2": ffi.cast("double (*)[3]", self._excess),
                "attitude": at[0],
                "norm_g": at[1],
            },
        )


def uncertainties(
    schedule: CoreSchedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    estimator: str,
    measured: Flags | None = None,
    mean_variance: Floats | None = None,
) -> tuple[Floats, Floats]:
    """u_K (3, 3) and u_U0 (3,) of an estimate by a linear estimator of the core.

    `k` (3, 3): the solved K; `samples` (positions,): rows of the run at each position, as Stand.averaged_over takes
    them; `measured` (positions,) bool; `mean_variance` (positions, 3): by the noise as measured, counts
    where it is larger than the stand's. Raises CoreRefusal(missing=..., unidentified=...).
    """
    run, found = _JudgedRun(schedule, k, stand, samples, measured, mean_variance), ffi.new("tumble_uncertainty_t *")
    refusal = ffi.new("tumble_refusal_t *")
    require_estimable(schedule, ESTIMATOR_ROWS[estimator].uncertainty(run.struct, found, refusal), refusal)
    return unpack(found)


def uncertainties_of_gains(
    schedule: CoreSchedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    gains: Floats,
    measured: Flags | None = None,
    mean_variance: Floats | None = None,
    least_noise: float = 0.0,
) -> tuple[Floats, Floats]:
    """The same for an estimate by constant gains (12, 3 x fit positions). The noise of a mean never counts as less than
    `least_noise`. Raises CoreRefusal."""
    table = np.ascontiguousarray(gains, dtype=float)
    if table.ndim != 2 or table.shape[0] != lib.TUMBLE_COEFFICIENTS or table.shape[1] % 3:
        raise ValueError(f"gains must have shape (12, 3 x fit positions), not {table.shape}")
    run = _JudgedRun(schedule, k, stand, samples, measured, mean_variance, least_noise)
    found = ffi.new("tumble_uncertainty_t *")
    struct = ffi.new("tumble_gain_table_t *", [ffi.from_buffer("double[]", table), table.shape[1] // 3])
    require_ok(lib.tumble_uncertainty_gains(struct, run.struct, found))
    return unpack(found)


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
    run = _JudgedRun(schedule, k, stand, samples, None, at=(place, found))
    table = None if gains is None else np.ascontiguousarray(gains, dtype=float)

    def judge() -> float:
        if table is not None:
            struct = ffi.new("tumble_gain_table_t *", [ffi.from_buffer("double[]", table), table.shape[1] // 3])
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
