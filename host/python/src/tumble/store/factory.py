"""A factory set from a calibration over temperature."""

from __future__ import annotations

from datetime import datetime

import numpy as np

from tumble.documents.thermal import Thermal
from tumble.errors import BadInput
from tumble.estimators import ESTIMATORS
from tumble.files.rows import range_text
from tumble.store.codec import COLDEST_C, WARMEST_C, CoefficientSet
from tumble.units import noise_unit, volts_per

_SERIAL_BYTES = 24
_MOST_POSITIONS = 255


def factory_set(found: Thermal, serial: str | None = None) -> CoefficientSet:
    """The set of a calibration over temperature, for `codec.encode_set`. Its range ends where that of a block's samples
    does, and its uncertainties are the largest over it. `serial`: in place of what the calibration says. Raises
    BadInput."""
    serial = serial or found.serial
    if not found.passed:
        raise BadInput(f"it did not pass: {found.pass_reason}", "the calibration")
    if noise_unit(found.unit) != "V":
        raise BadInput(f"its outputs are in {found.unit}, and a set is in volts", "the calibration")
    if serial is None:
        raise BadInput("names no block: write serial under [block] of the stand file, or give it", "the calibration")
    if len(serial.encode()) > _SERIAL_BYTES:
        raise BadInput(f"a set names its block by a serial of at most {_SERIAL_BYTES} bytes", "the calibration")
    low_c, high_c = max(found.range_c[0], COLDEST_C), min(found.range_c[1], WARMEST_C)
    if np.ceil(2 * low_c) > np.floor(2 * high_c):
        told = f"its range, {range_text(*found.range_c)}, has no half degree from {COLDEST_C:g} to {WARMEST_C:g} deg C"
        raise BadInput(told, "the calibration")
    volts = volts_per(found.unit)
    powers = [volts * np.concatenate([np.ravel(k), u0]) for k, u0 in zip(found.K, found.U0)]
    (constant, *slopes), u = [one.tolist() for one in powers], _largest_u(found, low_c, high_c)
    return CoefficientSet(
        sequence=0,
        origin=1,
        estimator=ESTIMATORS.index(found.runs[0].estimator),
        serial=serial,
        date_utc_s=_seconds(found.created),
        temperature_c=found.reference_c,
        gravity_m_s2=None,
        k=constant[:9],
        u0=constant[9:],
        u_k=None if u is None else (volts * u[:9]).tolist(),
        u_u0=None if u is None else (volts * u[9:]).tolist(),
        check=[found.max_abs_delta_g_g, 0.0, found.decision.limit_g],
        closure_v=None,
        samples=0,
        fit_positions=min(sum(run.positions for run in found.runs), _MOST_POSITIONS),
        check_positions=0,
        schedule_crc=0,
        stand_crc=0,
        reasons=0,
        restores=0,
        from_crc=0,
        resumed=False,
        temperature_range_c=[low_c, high_c],
        slopes=[*slopes, *([0.0] * 12 for _ in range(2 - len(slopes)))],
    )


def _largest_u(found: Thermal, low_c: float, high_c: float) -> np.ndarray | None:
    """Of each coefficient, over the half degrees of the range; None: no stand was declared."""
    if found.covariance is None:
        return None
    at = np.arange(np.ceil(2 * low_c), np.floor(2 * high_c) + 1) / 2 - found.reference_c
    count = len(found.K)
    own = np.reshape(found.covariance, (count, 12, count, 12)).diagonal(axis1=1, axis2=3)  # by two powers, coefficient
    powers = at[:, None] ** np.arange(count)
    u: np.ndarray = np.sqrt(np.einsum("tm,tn,mnc->tc", powers, powers, own).max(axis=0))
    return u


def _seconds(created: str | None) -> int | None:
    """Since 1970 UTC, of a document's time."""
    return None if created is None else int(datetime.fromisoformat(created.replace("Z", "+00:00")).timestamp())
