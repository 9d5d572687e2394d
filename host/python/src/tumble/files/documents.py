"""JSON documents: how they are written, and results, schema tumble.result/1, read back for what comes after.

Unknown is null, never NaN. Numbers have as many digits as it takes to read back the same bits.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from typing import Any

from tumble.errors import BadInput, quoted
from tumble.files.disk import JSON, RESULT_FILE, kind_of, read_bytes
from tumble.terms import KEYS, TERMS
from tumble.units import UNIT, spelled

RESULT = "tumble.result/1"
_NAME = re.compile("[A-Za-z0-9_]+")
_REASONS = ("gravity", "fit", "uncertainty")  # why it did not pass, in this order
_CHANGES: dict[str, tuple[type, ...]] = {  # what would show a limit, and what it would be changed to
    "estimator": (str,),
    "samples": (int,),
    "mountings": (int,),
    "stand": (int, float),
    "converter": (int, float),
}

Check = Callable[[Any], bool]


def to_json(result: dict[str, Any]) -> str:
    """A document as text, innermost arrays on one line. A NaN would be a programming error and raises ValueError."""
    text = json.dumps(result, indent=2, allow_nan=False)
    return re.sub(r"\[\n\s+([^\[\]{}]*?)\n\s+\]", lambda array: f"[{' '.join(array[1].split())}]", text) + "\n"


def read_coefficients(file: str) -> dict[str, Any]:
    """As `checked_coefficients`, of a file."""
    return checked_coefficients(read_bytes(file, RESULT_FILE), file)


def checked_coefficients(data: bytes, file: str) -> dict[str, Any]:
    """What an export needs of a result, called `file`: estimator, unit, K, U0, u_K, u_U0 and the verdict, all checked;
    and where it has them covariance, extended, created, tumble, serial, run_file, run_sha256, item, environment,
    fit, u_norm_g, pass_reason, decision, would_show, temperature and stand_doubts, else None; assumes and assumed_for,
    else empty.

    Raises BadInput.
    """
    result = _parse(data, file)
    checks = {
        "schema": lambda value: value == RESULT,
        "estimator": lambda value: isinstance(value, str) and value.isidentifier() and value.isascii(),
        "unit": lambda value: isinstance(value, str) and UNIT.fullmatch(value) is not None,
        "K": lambda value: _is_array(value, 3, lambda row: _is_array(row, 3, _is_number)),
        "U0": lambda value: _is_array(value, 3, _is_number),
        "u_K": lambda value: value is None or _is_array(value, 3, lambda row: _is_array(row, 3, _is_uncertainty)),
        "u_U0": lambda value: value is None or _is_array(value, 3, _is_uncertainty),
    }
    for key, is_valid in checks.items():
        _require(result, key, is_valid, file)
    result["unit"] = spelled(result["unit"])  # as runs have it now; older results have it as it was typed
    _require(result, "covariance", _null_or_covariance, file, default=None)
    _require(result, "extended", _null_or_extended, file, default=None)
    if (result["u_K"] is None) != (result["u_U0"] is None):
        raise BadInput("u_K and u_U0 must be both known or both null", file)
    _require(result, "verification", lambda value: isinstance(value, dict), file)
    for key, is_valid in {
        "pass": lambda value: isinstance(value, bool),
        "max_abs_delta_g_g": _is_uncertainty,
        "limit_g": _is_uncertainty,
    }.items():
        _require(result["verification"], key, is_valid, file, "verification.")
    optional: dict[str, type] = {"stand_doubts": list}
    optional |= dict.fromkeys(("created", "tumble", "serial", "run_file", "run_sha256"), str)
    optional |= dict.fromkeys(("item", "environment", "fit", "u_norm_g"), dict)
    for key, kind in optional.items():
        _require(result, key, _null_or(kind), file, default=None)
    _require(result, "pass", lambda value: isinstance(value, bool), file, default=result["verification"]["pass"])
    _require(result, "pass_reason", _null_or_reasons, file, default=None)
    _require(result, "decision", _null_or_decision, file, default=None)
    _require(result, "would_show", _null_or_remedies, file, default=None)
    _require(result, "temperature", _null_or_temperature, file, default=None)
    _require(result, "warnings", _null_or_sentences, file, default=None)
    _require(result, "assumes", _is_names, file, default=[])
    _require(result, "assumed_for", lambda value: _is_table(value, _is_names), file, default={})
    environment = result["environment"] or {}
    for key in environment.keys() & {"gravity_m_s2", "u_gravity_m_s2"}:
        is_valid = _is_uncertainty if key.startswith("u_") else lambda value: _is_uncertainty(value) and value > 0
        _require(environment, key, is_valid, file, "environment.")
    return result


def _parse(data: bytes, file: str) -> dict[str, Any]:
    def refuse_constant(name: str) -> None:
        raise ValueError(f"{name} is not a number")

    try:
        result = json.loads(data.decode("utf-8-sig"), parse_constant=refuse_constant)
    except json.JSONDecodeError as error:
        if (kind := kind_of(data)) not in (None, JSON):
            raise BadInput(f"is {kind}; a result of tumble solve (JSON) is expected", file) from None
        raise BadInput(f"not valid JSON: {error.msg.lower()}", file, error.lineno, str(error.colno)) from None
    except (ValueError, RecursionError) as error:
        raise BadInput(f"not valid JSON: {quoted(error)}", file) from None
    if not isinstance(result, dict):
        raise BadInput("not a result: an object is expected", file)
    return result


def _require(table: dict[str, Any], key: str, is_valid: Check, file: str, prefix: str = "", **otherwise: Any) -> None:
    """`default`, if given, is what a key that is not there comes to."""
    if key not in table and "default" in otherwise:
        table[key] = otherwise["default"]
    if key not in table:
        raise BadInput(f"not a result of schema {RESULT}: no {prefix}{key}", file)
    if not is_valid(table[key]):
        raise BadInput(f"not a result of schema {RESULT}: {prefix}{key} is {quoted(table[key])}", file)


def _null_or_sentences(value: Any) -> bool:
    return value is None or (isinstance(value, list) and all(isinstance(one, str) for one in value))


def _null_or(kind: type) -> Check:
    return lambda value: value is None or isinstance(value, kind)


def _is_names(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(name, str) and _NAME.fullmatch(name) for name in value)


def _is_table(value: Any, is_item: Check) -> bool:
    return isinstance(value, dict) and all(map(is_item, value.values()))


def _null_or_covariance(value: Any, size: int = 12) -> bool:
    return value is None or _is_array(value, size, lambda row: _is_array(row, size, _is_number))


def _null_or_temperature(value: Any) -> bool:
    return value is None or (isinstance(value, dict) and all(_is_number(value.get(key)) for key in ("min_c", "max_c")))


def _null_or_decision(value: Any) -> bool:
    if value is None:
        return True
    numbers = isinstance(value, dict) and all(_is_uncertainty(value.get(key)) for key in ("coverage_factor", "limit_g"))
    return numbers and (value.get("u_norm_worst_g") is None or _is_uncertainty(value["u_norm_worst_g"]))


def _null_or_reasons(value: Any) -> bool:
    if not isinstance(value, str):
        return value is None
    told = value.split(" and ")
    return told == [one for one in _REASONS if one in told]


def _null_or_remedies(value: Any) -> bool:
    return value is None or (isinstance(value, list) and all(map(_is_remedy, value)))


def _is_remedy(value: Any) -> bool:
    if not isinstance(value, dict) or not isinstance(value.get("change"), str):
        return False
    to = value.get("to")
    is_known = type(to) in _CHANGES.get(value["change"], ()) and (isinstance(to, str) or _is_uncertainty(to))
    return is_known and _is_uncertainty(value.get("reach_g"))


def _null_or_extended(value: Any) -> bool:
    if value is None:
        return True
    if not isinstance(value, dict) or not isinstance(value.get("terms"), list):
        return False
    terms = value["terms"]
    known = all(term in TERMS for term in terms) and len(set(terms)) == len(terms)
    sizes = [value.get(KEYS[term]) for term in terms] if known else []
    u = [value.get(f"u_{KEYS[term]}") for term in terms] if known else []
    return (
        known
        and all(_is_array(one, 3, _is_number) for one in sizes)
        and all(one is None or _is_array(one, 3, _is_uncertainty) for one in u)
        and _null_or_covariance(value.get("covariance"), 12 + 3 * len(terms))
    )


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and abs(value) < 1e300 and math.isfinite(value)


def _is_uncertainty(value: Any) -> bool:
    return _is_number(value) and value >= 0


def _is_array(value: Any, length: int, is_item: Check) -> bool:
    return isinstance(value, list) and len(value) == length and all(map(is_item, value))
