"""Results as JSON documents of schema tumble.result/1: written by solve and bench, read by export.

Unknown is null, never NaN. Numbers have as many digits as it takes to read back the same bits.
"""

from __future__ import annotations

import json
import math
import re
from typing import Any

import numpy as np

from tumble.errors import BadInput, quoted
from tumble.files.disk import read_bytes
from tumble.files.run_layout import UNIT
from tumble.solving import stand_seen
from tumble.solving.solution import Solution, Truth
from tumble.stand import volts_per

SCHEMA = "tumble.result/1"


def per_g(unit: str) -> str:
    """The unit of K for outputs in `unit`."""
    return f"({unit})/g" if "/" in unit else f"{unit}/g"


def document(
    solution: Solution,
    item: dict[str, Any] | None,
    environment: dict[str, Any] | None,
    serial: str | None = None,
    run_file: str | None = None,
) -> dict[str, Any]:
    """The result of a solve, ready for JSON. `serial`: of the block; `run_file`: name of what was solved."""
    unit = solution.run.unit
    return {
        "schema": SCHEMA,
        "run_file": run_file,
        "serial": serial,
        "estimator": solution.found.estimator,
        "unit": unit,
        "units": {"K": per_g(unit), "U0": unit, "u_K": per_g(unit), "u_U0": unit},
        "K": solution.found.k.tolist(),
        "U0": solution.found.u0.tolist(),
        "u_K": None if solution.u_k is None else solution.u_k.tolist(),
        "u_U0": None if solution.u_u0 is None else solution.u_u0.tolist(),
        "second_order": None if solution.second_order is None else solution.second_order.document(),
        "misfit": solution.misfit,
        "stand_doubts": None if solution.doubts is None else [doubt.source for doubt in solution.doubts],
        "verification": _verification(solution),
        "stand_seen": stand_seen.document(solution.stand_seen, volts_per(unit)),
        "intrinsic": {
            "scale": solution.found.intrinsic.scale.tolist(),
            "angle_rad": dict(zip(("xy", "xz", "yz"), solution.found.intrinsic.angles.tolist())),
            "bias_g": solution.found.intrinsic.bias.tolist(),
        },
        "reference": {
            "max_abs_difference_K": float(np.abs(solution.comparison.k).max()),
            "max_abs_difference_U0": float(np.abs(solution.comparison.u0).max()),
            "difference_K": solution.comparison.k.tolist(),
            "difference_U0": solution.comparison.u0.tolist(),
        },
        "means": _means(solution),
        "counters": solution.run.counters,
        "item": item,
        "environment": environment,
    }


def _places(solution: Solution) -> list[tuple[int, dict[str, Any]]]:
    """Index and names of every measured position."""
    return [
        (index, {"mounting": position.mounting, "position": position.number, "use": position.use})
        for index, position in enumerate(solution.schedule.positions)
        if solution.run.samples[index] > 0
    ]


def _verification(solution: Solution) -> dict[str, Any]:
    gravity, rms = solution.found.gravity, solution.found.residual_rms
    judged = [largest for largest in (gravity.max_abs_fit, gravity.max_abs_check) if largest is not None]
    return {
        "delta_g_g": [{**place, "delta_g_g": float(gravity.delta_g[index])} for index, place in _places(solution)],
        "max_abs_delta_g_g": max(judged),
        "max_abs_delta_g_fit_g": gravity.max_abs_fit,
        "max_abs_delta_g_check_g": gravity.max_abs_check,
        "limit_g": solution.limit_g,
        "pass": gravity.passed,
        "closure": [
            {"mounting": mounting, "difference": difference.tolist()}
            for mounting, difference in solution.found.closure.items()
        ],
        "residual_rms": None if rms is None else rms.tolist(),
    }


def _means(solution: Solution) -> list[dict[str, Any]]:
    run = solution.run
    return [
        {
            **place,
            "samples": int(run.samples[index]),
            "mean": run.means[index].tolist(),
            "scatter": run.scatter[index].tolist() if run.samples[index] > 1 else None,
        }
        for index, place in _places(solution)
    ]


def truth(known: Truth) -> dict[str, Any]:
    """What a simulated run was made of."""
    return {
        "K": known.k.tolist(),
        "U0": known.u0.tolist(),
        "alpha1_rad": known.alpha1,
        "alpha2_rad": known.alpha2,
        "alpha3_rad": list(known.alpha3),
        "alpha4_rad": list(known.alpha4),
    }


def to_json(result: dict[str, Any]) -> str:
    """A result as text, innermost arrays on one line. A NaN would be a programming error and raises ValueError."""
    text = json.dumps(result, indent=2, allow_nan=False)
    return re.sub(r"\[\n\s+([^\[\]{}]*?)\n\s+\]", lambda array: f"[{' '.join(array[1].split())}]", text) + "\n"


def read_coefficients(file: str) -> dict[str, Any]:
    """What an export needs of a result file: estimator, unit, K, U0, u_K, u_U0 and the verdict, all checked; and where
    it has them serial, run_file, item, environment and stand_doubts, else None.

    Raises BadInput.
    """
    result = _parse(file)
    checks = {
        "schema": lambda value: value == SCHEMA,
        "estimator": lambda value: isinstance(value, str) and value.isidentifier() and value.isascii(),
        "unit": lambda value: isinstance(value, str) and UNIT.fullmatch(value) is not None,
        "K": lambda value: _is_array(value, 3, lambda row: _is_array(row, 3, _is_number)),
        "U0": lambda value: _is_array(value, 3, _is_number),
        "u_K": lambda value: value is None or _is_array(value, 3, lambda row: _is_array(row, 3, _is_uncertainty)),
        "u_U0": lambda value: value is None or _is_array(value, 3, _is_uncertainty),
    }
    for key, is_valid in checks.items():
        _require(result, key, is_valid, file)
    if (result["u_K"] is None) != (result["u_U0"] is None):
        raise BadInput("u_K and u_U0 must be both known or both null", file)
    _require(result, "verification", lambda value: isinstance(value, dict), file)
    for key, is_valid in {
        "pass": lambda value: isinstance(value, bool),
        "max_abs_delta_g_g": _is_uncertainty,
        "limit_g": _is_uncertainty,
    }.items():
        _require(result["verification"], key, is_valid, file, "verification.")
    for key, kind in {"serial": str, "run_file": str, "item": dict, "environment": dict, "stand_doubts": list}.items():
        _require(result, key, lambda value: value is None or isinstance(value, kind), file, default=None)
    return result


def _parse(file: str) -> dict[str, Any]:
    def refuse_constant(name: str) -> None:
        raise ValueError(f"{name} is not a number")

    try:
        result = json.loads(read_bytes(file).decode("utf-8-sig"), parse_constant=refuse_constant)
    except json.JSONDecodeError as error:
        raise BadInput(f"not valid JSON: {error.msg.lower()}", file, error.lineno, str(error.colno)) from None
    except (ValueError, RecursionError) as error:
        raise BadInput(f"not valid JSON: {quoted(error)}", file) from None
    if not isinstance(result, dict):
        raise BadInput("not a result: an object is expected", file)
    return result


def _require(table: dict[str, Any], key: str, is_valid, file: str, prefix: str = "", **otherwise: Any) -> None:
    """`default`, if given, is what a key that is not there comes to."""
    if key not in table and "default" in otherwise:
        table[key] = otherwise["default"]
    if key not in table:
        raise BadInput(f"not a result of schema {SCHEMA}: no {prefix}{key}", file)
    if not is_valid(table[key]):
        raise BadInput(f"not a result of schema {SCHEMA}: {prefix}{key} is {quoted(table[key])}", file)


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and abs(value) < 1e300 and math.isfinite(value)


def _is_uncertainty(value: Any) -> bool:
    return _is_number(value) and value >= 0


def _is_array(value: Any, length: int, is_item) -> bool:
    return isinstance(value, list) and len(value) == length and all(map(is_item, value))
