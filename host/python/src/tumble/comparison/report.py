"""A comparison as a document of schema tumble.comparison/1, and as text."""

from __future__ import annotations

import math
import textwrap
from typing import Any

from tumble.comparison.pair import Comparison, Side
from tumble.comparison.statistics import Test
from tumble.comparison.verdict import Differences, Tests, Verdict
from tumble.estimators import COEFFICIENTS
from tumble.terms import names
from tumble.units import per_g

SCHEMA = "tumble.comparison/1"
_MILLIONTHS = 1e6
_WIDTH = 80
_SOURCES = {"alpha1": "axis tilt", "alpha2": "level"}  # those whose names are not words


def document(compared: Comparison) -> dict[str, Any]:
    """Ready for JSON."""
    found, stand = compared.found, compared.one_stand
    return {
        "schema": SCHEMA,
        "verdict": found.verdict.value,
        "confidence": found.confidence,
        "changed": [row["name"] for row in _parameters(compared) if row["changed"]],
        "a": _side(compared.a),
        "b": _side(compared.b),
        "unit": compared.a.document["unit"],
        "coefficients": _rows(_coefficient_names(compared), _coefficient_units(compared), found.coefficients),
        "parameters": _parameters(compared),
        "seat": _rows([f"seat_{axis}" for axis in "xyz"], ["urad"] * 3, found.seat, _MILLIONTHS),
        "tests": None if found.tests is None else _tests(found.tests),
        "shared": {
            "stand": None if stand is None else stand.declares.stand.name,
            "levelled": None if stand is None else stand.levelled,
            "sources": None if compared.shared is None else list(compared.shared),
        },
        "warnings": list(compared.warnings),
        "notes": _notes(compared),
    }


def _side(side: Side) -> dict[str, Any]:
    told = side.document
    temperature = side.temperature
    return {
        "file": side.name,
        **{key: told[key] for key in ("created", "run_file", "serial", "estimator", "item", "pass")},
        "temperature_c": None if temperature is None else [temperature.low_c, temperature.high_c],
        "gravity_m_s2": side.gravity[0],
    }


def _coefficient_names(compared: Comparison) -> list[str]:
    return [*COEFFICIENTS, *names(compared.terms)]


def _coefficient_units(compared: Comparison) -> list[str]:
    unit = compared.a.document["unit"]
    further = ["1/g" if term == "k2" else "1/g^2" for term in compared.terms for _ in "xyz"]
    return [per_g(unit)] * 9 + [unit] * 3 + further


def _rows(named: list[str], units: list[str], found: Differences, factor: float = 1.0) -> list[dict[str, Any]]:
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
    rows = _rows([*reduced.parameter_names], [*reduced.parameter_units], found.parameters, _MILLIONTHS)
    p = [None] * len(rows) if found.tests is None else found.tests.p_parameters.tolist()
    return [{**row, "p": one, "changed": bool(has)} for row, one, has in zip(rows, p, found.changed)]


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


def _notes(compared: Comparison) -> list[str]:
    """What was counted as shared comes first."""
    if compared.found.tests is None:
        return list(compared.notes)
    return [_of_sharing(compared), *compared.notes]


def _of_sharing(compared: Comparison) -> str:
    stand = compared.one_stand
    if compared.shared is None or stand is None:
        return (
            "Nothing is counted as shared: right for two stands. Of one stand, what both have in common cancels, and"
            " these uncertainties are too large (--stand)."
        )
    told = f"stand levelled {stand.levelled}"
    if not compared.shared:
        return f"Counted once: nothing, for nothing that this stand declares returns with every run ({told})."
    listed = ", ".join(_SOURCES.get(name, name) for name in compared.shared)
    return f"Counted once, for both have it of one stand: {listed} ({told})."


def render(compared: Comparison) -> str:
    """For people, 80 columns wide."""
    told = document(compared)
    lines = [
        "B less A",
        *_wrapped(f"A: {_described(told['a'])}", "   "),
        *_wrapped(f"B: {_described(told['b'])}", "   "),
    ]
    lines += ["", *_table(told["parameters"], told["coefficients"])]
    lines += ["", *_wrapped(_seat(told["seat"]))]
    if told["tests"] is not None:
        lines += _tests_text(told["tests"])
    lines += ["", *(line for note in told["notes"] for line in _wrapped(note)), ""]
    return "\n".join([*lines, *_wrapped(sentence(told))]) + "\n"


def _described(side: dict[str, Any]) -> str:
    low, high = side["temperature_c"] or (None, None)
    warm = None if low is None else f"{low:.3g} deg C" if low == high else f"{low:.3g} to {high:.3g} deg C"
    serial = None if side["serial"] is None else f"serial {side['serial']}"
    return ", ".join(filter(None, (side["file"], side["estimator"], serial, side["created"], warm)))


def _table(parameters: list[dict[str, Any]], coefficients: list[dict[str, Any]]) -> list[str]:
    rows = [("", "difference", "u", "unit", "in u", "p")]
    rows += [(_words(row["name"]), *_figures(row), _p(row["p"])) for row in parameters]
    rows += [(row["name"], *_figures(row), "") for row in coefficients]
    widths = [max(map(len, column)) for column in zip(*rows)]
    aligned = (str.ljust, str.rjust, str.rjust, str.ljust, str.rjust, str.rjust)
    lines = ["  ".join(fit(cell, width) for fit, cell, width in zip(aligned, row, widths)).rstrip() for row in rows]
    return [*lines[: len(parameters) + 1], "", *lines[len(parameters) + 1 :]]


def _figures(row: dict[str, Any]) -> tuple[str, str, str, str]:
    u = "-" if row["u"] is None else f"{row['u']:.2g}"
    in_u = "-" if row["in_u"] is None else f"{row['in_u']:+.2f}"
    return f"{row['difference']:+.3g}", u, row["unit"], in_u


def _p(p: float | None) -> str:
    return "-" if p is None else f"{p:.2g}"


def _words(name: str) -> str:
    return name if name.startswith("K") else name.replace("_", " ")


def _seat(seat: list[dict[str, Any]]) -> str:
    turned = ", ".join(f"{_sized(row)} about {row['name'][-1]}" for row in seat)
    return f"Seat, if it has turned and the block is as it was: {turned}."


def _sized(row: dict[str, Any]) -> str:
    u = "" if row["u"] is None else f" +- {row['u']:.2g}"
    return f"{row['difference']:+.3g}{u} {row['unit']}"


def _tests_text(tests: dict[str, Any]) -> list[str]:
    words = {"all": "all twelve", "block": "the block alone", "seat": "the seat alone"}
    return [
        f"{word:<15}  chi-squared {tests[name]['chi2']:.1f}, {tests[name]['dof']} degrees of freedom,"
        f" p {tests[name]['p']:.2g}"
        for name, word in words.items()
    ]


def sentence(told: dict[str, Any]) -> str:
    """The verdict of a document."""
    at = f"at {100 * told['confidence']:.6g} %"
    verdict, seat = (
        Verdict(told["verdict"]),
        ", ".join(f"{_sized(row)} about {row['name'][-1]}" for row in told["seat"]),
    )
    if verdict is Verdict.CANNOT_TELL:
        return "CANNOT TELL: a result without uncertainties (tumble solve --stand) says nothing of a change."
    if verdict is Verdict.UNCHANGED:
        return f"UNCHANGED {at}: the differences are what the uncertainties allow."
    if verdict is Verdict.SEAT:
        return f"ONLY THE SEAT HAS CHANGED {at}, the block has not: it sits turned by {seat}."
    shown = [
        f"{_words(row['name'])} by {_sized(row)}" + ("" if row["in_u"] is None else f" ({abs(row['in_u']):.1f} u)")
        for row in told["parameters"]
        if row["changed"]
    ]
    return f"THE BLOCK HAS CHANGED {at}: {', '.join(shown) or 'no parameter by itself, but all together'}."


def _wrapped(text: str, indent: str = "") -> list[str]:
    return textwrap.wrap(text, _WIDTH, break_long_words=False, break_on_hyphens=False, subsequent_indent=indent)
