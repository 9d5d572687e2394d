"""A calibration over temperature for other programs: a C header with the polynomials, parameters of autopilots.

A format has a template, exports/NAME_thermal.j2. An autopilot has polynomials for its offsets alone: what the change of
its scales leaves is named in the file.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tumble.documents.thermal import Thermal
from tumble.estimators import COEFFICIENTS
from tumble.model.thermal import Polynomials
from tumble.report.coefficients import DOUBLE, FLOAT, FORMATS as OF_ONE, axes_of, comment, filled
from tumble.solving.thermal import verdict_of

FORMATS = ("c", "px4", "ardupilot")
_ARDUPILOT_C = 35.0  # its reference, whatever that of the result is
_ENDS = 2


def exported(told: Thermal, name: str, number: str = DOUBLE, accelerometer: int = 1) -> str:
    """In the format of that `name`, of FORMATS; `number`: what the C header computes with, double or float;
    `accelerometer`: of an autopilot, from 1. Raises ValueError for what the format cannot hold."""
    if name not in FORMATS:
        raise ValueError(f"over temperature there are formats {', '.join(FORMATS)}, not {name}")
    decision, (low, high) = told.decision, told.range_c
    verdict = "".join(verdict_of(told))
    about = [
        f"Coefficients of a three-axis block of accelerometers, {low:.4g} to {high:.4g} deg C, {len(told.runs)} runs.",
        f"Outputs in {ascii(told.unit)[1:-1]}. Gravity check: largest error {told.max_abs_delta_g_g!r} g.",
        f"Verdict: {verdict}; limit {decision.limit_g!r} g.",
        *(["Uncertainties unknown: no stand was declared."] if told.u_K is None else []),
        *(f"WARNING: {comment(one)}" for one in told.warnings),
    ]
    values = [np.concatenate([k.ravel(), u0]).tolist() for k, u0 in zip(told.K, told.U0)]
    u = None if told.u_K is None or told.u_U0 is None else [
        np.concatenate([k.ravel(), u0]).tolist() for k, u0 in zip(told.u_K, told.u_U0)
    ]  # fmt: skip
    names = {"told": told, "about": about, "names": COEFFICIENTS, "values": values, "u": u, "number": accelerometer}
    if name != "c":
        names |= _offsets(told, name)
    return filled(f"{name}_thermal", FLOAT if number == FLOAT else DOUBLE, names)


def _offsets(told: Thermal, name: str) -> dict[str, Any]:
    """The polynomial of offsets, m/s^2, by power of T - `about_c` (powers, 3), with `axes` at the reference temperature
    (coefficients.axes_of); `error`: the most that the change of scales and cross-axis terms over the range leaves at 1
    g, m/s^2. Raises ValueError."""
    form = OF_ONE[name]
    axes = axes_of(told.unit, told.environment, np.append(told.K[0].ravel(), told.U0[0]), None, form)
    size, about_c = axes["size"], _ARDUPILOT_C if name == "ardupilot" else told.reference_c
    polynomials = Polynomials(told.reference_c, np.array(told.K), np.array(told.U0))
    shift = about_c - told.reference_c
    offsets = [one * size for one in told.U0]
    if len(offsets) > _ENDS:
        offsets[1] = offsets[1] + 2.0 * shift * offsets[2]
    ends = [polynomials.at(one)[0] * size / axes["gravity"] for one in told.range_c]
    left = max(float(np.linalg.norm(np.array(axes["scale"])[:, None] * k - np.eye(3), 2)) for k in ends)
    return {"axes": axes, "offsets": [one.tolist() for one in offsets], "error": left * axes["gravity"]}
