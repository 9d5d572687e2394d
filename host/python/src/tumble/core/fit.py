"""Whether a run fits its stand: the core's chi-squared of all residuals. Arrays as in tumble.core.binding."""

from __future__ import annotations

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Flags, Floats
from tumble.core.binding import CoreSchedule, require_ok
from tumble.stand import COMMON, Stand


def chi_squared(
    schedule: CoreSchedule, means: Floats, measured: Flags, variance: Floats, stand: Stand
) -> tuple[float, int]:
    """The sum of squares, and its degrees of freedom. `variance` (positions,) of each mean by its noise; `stand` and
    `variance` in the unit of the means. Raises CoreRefusal."""
    record = {
        "axis_tilt_rad": stand.sigma("axis_tilt"),
        "level_rad": stand.sigma("level"),
        "remount_rad": stand.sigma("remount"),
        "angle_rad": stand.sigma("angle"),
        "seat_rad": stand.sigma("seat"),
        "platform_rad": stand.sigma("platform"),
        "common_yaw": stand.remounting == COMMON,
    }
    declared = ffi.new("tumble_stand_record_t *", record)
    noise = np.ascontiguousarray(np.where(measured, variance, 0.0), dtype=float)
    given, work = schedule.means(means, measured), ffi.new("tumble_whole_work_t *")
    run = ffi.new("tumble_whole_run_t *", [schedule.struct, given, declared, ffi.from_buffer("double[]", noise)])
    square, freedom = ffi.new("double *"), ffi.new("uint8_t *")
    require_ok(lib.tumble_whole_chi_squared(run, work, square, freedom))
    return square[0], freedom[0]
