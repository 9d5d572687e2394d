"""The firmware core, for every room but `model`: numpy arrays in and out, a refusal as an exception.

No coefficient and no check is computed here: they come from the C functions that fly, through `_tumble_core`. The
names below are what most need: schedules, the linear estimators, the check of a calibration; `binding` has the rest.
"""

from tumble.core.binding import (
    AXES,
    MAX_MEAN,
    MAX_MOUNTINGS,
    MAX_POSITIONS,
    MAX_SAMPLES,
    MAX_STAND_ERROR_RAD,
    MAX_YAWS,
    MIN_ROW_RATIO,
    Calibration,
    CoreRefusal,
    CoreSchedule,
    GravityCheck,
    Intrinsic,
    built_in,
    closure,
    estimate,
    estimate_gains,
    gravity_check,
    intrinsic,
    paper_schedule,
    residual_rms,
    sine_cosine,
    statuses,
)

__all__ = [
    "AXES",
    "MAX_MEAN",
    "MAX_MOUNTINGS",
    "MAX_POSITIONS",
    "MAX_SAMPLES",
    "MAX_STAND_ERROR_RAD",
    "MAX_YAWS",
    "MIN_ROW_RATIO",
    "Calibration",
    "CoreRefusal",
    "CoreSchedule",
    "GravityCheck",
    "Intrinsic",
    "built_in",
    "closure",
    "estimate",
    "estimate_gains",
    "gravity_check",
    "intrinsic",
    "paper_schedule",
    "residual_rms",
    "sine_cosine",
    "statuses",
]
