"""A comparison as a document of schema tumble.comparison/1."""

from __future__ import annotations

import math
from typing import Any

from tumble.comparison.pair import Comparison, Side
from tumble.comparison.statistics import Test
from tumble.comparison.verdict import Differences, Tests, Verdict
from tumble.estimators import COEFFICIENTS
from tumble.terms import names
from tumble.units import per_g

SCHEMA = "tumble.comparison/1"
_MILLIONTHS = 1e6


def document(compared: Comparison) -> dict[str, Any]:
    """Ready for JSON."""
    found, stand = compared.found, compared.one_stand
    parameters = _parameters(compared)
    return {
        "schema": SCHEMA,
        "verdict": compared.verdict.value,
        "apparent": None if found.tests is None else found.verdict.value,
        "confidence": found.confidence,
        "changed": [row["name"] for row in parameters if row["changed"]],
        "explained_by": _explained(compared),
        "assumes": list(compared.assumes),
        "a": _side(compared.a),
        "b": _side(compared.b),
        "unit": compared.a.document["unit"],
        "parameters": parameters,
        "seat": _rows([f"seat_{axis}" for axis in "xyz"], ["urad"] * 3, found.seat, _MILLIONTHS),
        "coefficients": _rows([*COEFFICIENTS, *names(compared.terms)], _units(compared), found.coefficients),
        "tests": None if found.tests is None else _tests(found.tests),
        "shared": {
            "stand": None if stand is None else stand.label,
            "levelled": None if stand is None else stand.levelled,
            "sources": None if compared.shared is None else list(compared.shared),
        },
        "warnings": list(compared.warnings),
        "notes": list(compared.notes),
    }


def _side(side: Side) -> dict[str, Any]:
    told, temperature = side.document, side.temperature
    return {
        "file": side.name,
        **{key: told[key] for key in ("created", "run_file", "serial", "estimator", "item")},
        "pass": not side.failures,
        "pass_reason": " and ".join(side.failures) or None,
        "uncertainties": side.calibration.covariance is not None,
        "temperature_c": None if temperature is None else [temperature.low_c, temperature.high_c],
        "gravity_m_s2": side.gravity[0],
    }


def _units(compared: Comparison) -> list[str]:
    """Of the coefficients."""
    unit = compared.a.document["unit"]
    further = ["1/g" if term == "k2" else "1/g^2" for term in compared.terms for _ in "xyz"]
    return [per_g(unit)] * 9 + [unit] * 3 + further


def _rows(named: list[str], units: list[str], found: Differences, factor: float = 1.0) -> list[dict[str, Any]]:
    """One for each; a difference over an uncertainty of 0 is null."""
    in_u = found.in_u
    return [
        {
            "name": name,
            "difference": float(found.size[i]) * factor,
            "u": None if found.u is None else float(found.u[i]) * factor,
            "in_u": None if in_u is None or not math.isfinite(in_u[i]) else float(in_u[i]),
            "unit": unit,
        }
        for i, (name, unit) in enumerate(zip(named, units))
    ]


def _parameters(compared: Comparison) -> list[dict[str, Any]]:
    found, reduced = compared.found, compared.a.calibration.reduced(compared.terms)
    is_firm = compared.verdict is Verdict.BLOCK
    rows = _rows([*reduced.parameter_names], [*reduced.parameter_units], found.parameters, _MILLIONTHS)
    p = [None] * len(rows) if found.tests is None else found.tests.p_parameters.tolist()
    return [{**row, "p": one, "changed": is_firm and bool(has)} for row, one, has in zip(rows, p, found.changed)]


def _explained(compared: Comparison) -> dict[str, Any] | None:
    one, named = compared.found.explanation, compared.a.calibration.reduced(compared.terms)
    if one is None or compared.verdict is not Verdict.BLOCK:
        return None
    return {
        "name": named.parameter_names[one.index],
        "difference": one.size * _MILLIONTHS,
        "u": one.u * _MILLIONTHS,
        "unit": named.parameter_units[one.index],
        "p": one.p,
    }


def _tests(tests: Tests) -> dict[str, Any]:
    return {
        "all": _test(tests.all_twelve),
        "block": _test(tests.block),
        "alone": {"p": tests.alone},
        "seat": _test(tests.seat),
        "after_holm": tests.adjusted,
    }


def _test(test: Test) -> dict[str, Any]:
    return {"chi2": test.chi_squared, "dof": test.freedom, "p": test.p}
