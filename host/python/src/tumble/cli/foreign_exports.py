"""Coefficients as files of other programs: MATLAB, imu_calib of ROS, imucal.

matlab   a script that sets a struct `tumble`; also for Octave
ros      YAML of imu_calib (github.com/dpkoch/imu_calib): corrected = SM raw - bias
imucal   JSON of imucal 2 (github.com/mad-lab-fau/imucal), a Ferraris calibration: acc = R_a^-1 K_a^-1 (raw - b_a)
"""

from __future__ import annotations

import json

import numpy as np

from tumble.arrays import Floats
from tumble.cli import newton
from tumble.cli.exports import FORCE_UNITS, origin, why_unknown
from tumble.documents.result import Result
from tumble.solving.coefficients import Coefficients
from tumble.solving.decision import Decision


def to_matlab(result: Result, force_unit: str = "g") -> str:
    """A script. Raises ValueError."""
    them = Coefficients.of(result, force_unit)
    lines = [f"% {line}" for line in _about(result, them)]
    lines += [
        f"tumble.output_unit = '{result.unit}';",
        f"tumble.force_unit = '{force_unit}';",
        f"tumble.passed = {str(result.passed).lower()};",
        f"tumble.K = {_matrix(them.values[:9].reshape(3, 3))};",
        f"tumble.U0 = {_matrix(them.values[9:12, None])};",
        f"tumble.K_inverse = {_matrix(them.inverse)};",
    ]
    u = None if them.uncertainties is None else np.array(them.uncertainties)
    lines.append(f"tumble.u_K = {'[]' if u is None else _matrix(u[:9].reshape(3, 3))};")
    lines.append(f"tumble.u_U0 = {'[]' if u is None else _matrix(u[9:12, None])};")
    for place, term in enumerate(them.terms):
        part = slice(12 + 3 * place, 15 + 3 * place)
        lines.append(f"tumble.{term.upper()} = {_matrix(them.values[part, None])};")
        lines.append(f"tumble.u_{term.upper()} = {'[]' if u is None else _matrix(u[part, None])};")
    lines.append(f"tumble.covariance = {'[]' if them.covariance is None else _matrix(them.covariance)};")
    return "\n".join([*lines, "% Outputs (samples x 3) to specific force (samples x 3):", *_function(them)]) + "\n"


def _function(them: Coefficients) -> list[str]:
    if them.terms:
        return newton.in_matlab(them.terms)
    return ["tumble.apply = @(U) (U - tumble.U0') * tumble.K_inverse';"]


def _matrix(rows: Floats) -> str:
    return "[" + "; ".join(" ".join(format(one, ".17g") for one in row) for row in rows.tolist()) + "]"


def to_ros(result: Result, force_unit: str = "m/s2") -> str:
    """YAML: SM is K^-1 row by row, bias is K^-1 U0. Raises ValueError."""
    them = _twelve(result, force_unit, "imu_calib")
    bias = them.inverse @ them.values[9:12]
    lines = [f"# {line}" for line in _about(result, them)]
    lines.append(f"# U0, {result.unit}: {_flow(them.values[9:12])}")
    return "\n".join([*lines, f"SM: {_flow(them.inverse.ravel())}", f"bias: {_flow(bias)}"]) + "\n"


def _flow(values: Floats) -> str:
    return f"[{', '.join(format(one, '.17g') for one in values.tolist())}]"


def to_imucal(result: Result, force_unit: str = "m/s2") -> str:
    """JSON: K = K_a R_a with K_a the lengths of its rows, which imucal inverts itself; b_a is U0. The gyroscope's part
    changes nothing. Raises ValueError."""
    them = _twelve(result, force_unit, "imucal")
    k, same, none = them.values[:9].reshape(3, 3), np.eye(3).tolist(), np.zeros((3, 3)).tolist()
    length = np.linalg.norm(k, axis=1)
    document = {
        "acc_unit": FORCE_UNITS[force_unit] if force_unit == "m/s2" else "g",
        "gyr_unit": None,
        "from_acc_unit": result.unit,
        "from_gyr_unit": None,
        "comment": "\n".join([*_about(result, them), f"K^-1, row by row: {_flow(them.inverse.ravel())}"]),
        "K_a": np.diag(length).tolist(),
        "R_a": (k / length[:, None]).tolist(),
        "b_a": them.values[9:12].tolist(),
        "K_g": same,
        "R_g": same,
        "K_ga": none,
        "b_g": [0.0, 0.0, 0.0],
        "cal_type": "Ferraris",
        "_format_version": "2.0.0",
    }
    return json.dumps(document, indent=4) + "\n"


def _twelve(result: Result, force_unit: str, program: str) -> Coefficients:
    them = Coefficients.of(result, force_unit)
    if them.terms:
        raise ValueError(f"{program} holds twelve coefficients, no {' and '.join(map(str.upper, them.terms))}")
    return them


def _about(result: Result, them: Coefficients) -> list[str]:
    """What the coefficients are, in lines of ASCII."""
    check = result.verification
    verdict = "passed" if check.passed else "FAILED"
    known = "" if them.uncertainties is not None else f"Uncertainties unknown: {why_unknown(result)}."
    return [
        f"Coefficients of a three-axis block of accelerometers, estimator {result.estimator}.",
        f"Outputs in {ascii(result.unit)[1:-1]}, specific force in {FORCE_UNITS[them.force_unit]}.",
        f"Gravity check: {verdict}, largest error {check.max_abs_delta_g_g!r} g, limit {check.limit_g!r} g.",
        f"Verdict: {Decision.of(result).sentence}.",
        *([known] if known else []),
        *origin(result),
    ]
