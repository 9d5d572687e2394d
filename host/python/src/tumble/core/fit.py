"""Whether a run fits its stand: the core's chi-squared of all residuals. Arrays as in tumble.core.binding."""

from __future__ import annotations

from typing import Any

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Flags, Floats
from tumble.core.binding import CoreSchedule, require_ok
from tumble.stand import COMMON, PER_CHANNEL, Stand, per_channel

ANGLES = ("axis_tilt", "level", "remount", "angle", "seat", "platform", "encoder")


def chi_squared(
    schedule: CoreSchedule, means: Floats, measured: Flags, variance: Floats, stand: Stand
) -> tuple[float, int]:
    """The sum of squares, and its degrees of freedom. `variance` (positions, 3), or (positions,) for channels
    that are alike, of each mean by its noise; `stand` and `variance` in the unit of the means. Raises CoreRefusal."""
    declared = record_of(stand)
    of_each = np.broadcast_to(variance.reshape(len(means), -1), means.shape)
    noise = np.ascontiguousarray(np.where(measured[:, None], of_each, 0.0), dtype=float)
    given, work = schedule.means(means, measured), ffi.new("tumble_whole_work_t *")
    by_channel = ffi.cast("double (*)[3]", ffi.from_buffer(noise))
    run = ffi.new("tumble_whole_run_t *", [schedule.struct, given, declared, ffi.NULL, by_channel])
    square, freedom = ffi.new("double *"), ffi.new("uint8_t *")
    require_ok(lib.tumble_whole_chi_squared(run, work, square, freedom))
    return square[0], freedom[0]


def record_of(stand: Stand, least_noise: float = 0.0) -> Any:
    """The declared stand as the core takes it; the noise of a mean never counts as less than `least_noise`."""
    numbers: dict[str, Any] = {f"{source}_rad": stand.sigma(source) for source in ANGLES}
    for source in PER_CHANNEL:
        sigma = per_channel(stand.sigmas(source))
        numbers[f"channel_{source}_v" if isinstance(sigma, tuple) else f"{source}_v"] = sigma
    labels = {"least_noise_v": least_noise, "samples": stand.samples, "common_yaw": stand.remounting == COMMON}
    return ffi.new("tumble_stand_record_t *", numbers | labels)
