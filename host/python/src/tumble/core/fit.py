"""Whether a run fits its stand: the core's chi-squared of all residuals. Arrays as in tumble.core.binding."""

from __future__ import annotations

from typing import Any

import numpy as np
from _tumble_core import ffi, lib

from tumble.arrays import Flags, Floats
from tumble.core.binding import CoreSchedule, require_ok
from tumble.stand import COMMON, Stand

ANGLES = ("axis_tilt", "level", "remount", "angle", "seat", "platform", "encoder")


def chi_squared(
    schedule: CoreSchedule, means: Floats, measured: Flags, variance: Floats, stand: Stand
) -> tuple[float, int]:
    """The sum of squares, and its degrees of freedom. `variance` (positions,) of each mean by its noise; `stand` and
    `variance` in the unit of the means. Raises CoreRefusal."""
    declared = record_of(stand)
    noise = np.ascontiguousarray(np.where(measured, variance, 0.0), dtype=float)
    given, work = schedule.means(means, measured), ffi.new("tumble_whole_work_t *")
    run = ffi.new("tumble_whole_run_t *", [schedule.struct, given, declared, ffi.from_buffer("double[]", noise)])
    square, freedom = ffi.new("double *"), ffi.new("uint8_t *")
    require_ok(lib.tumble_whole_chi_squared(run, work, square, freedom))
    return square[0], freedom[0]


def record_of(stand: Stand) -> Any:
    """The declared stand as the core takes it."""
    angles = {f"{source}_rad": stand.sigma(source) for source in ANGLES}
    outputs = {f"{source}_v": stand.sigma(source) for source in ("noise", "drift")}
    return ffi.new("tumble_stand_record_t *", angles | outputs | {"common_yaw": stand.remounting == COMMON})
