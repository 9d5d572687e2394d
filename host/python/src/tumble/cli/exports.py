"""Coefficients in the formats of other tools: 17 digits, unit and standard uncertainty with every number."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from tumble.solving.assumptions import phrase
from tumble.units import per_g

_C_HEADER = """\
/* Coefficients of a three-axis block of accelerometers: U = U0 + K a
 *
 * U: outputs in {unit}; a: specific force in units of local gravity; K_ij in {k_unit}: response of channel i to
 * acceleration along axis j; U0_i in {unit}. Estimator: {estimator}.
 * Gravity check: {verdict}, largest error {largest!r} g, limit {limit!r} g.
 * Standard uncertainties (one sigma): {known}.
{origin} */
#ifndef TUMBLE_COEFFICIENTS_H
#define TUMBLE_COEFFICIENTS_H

#define TUMBLE_OUTPUT_UNIT "{unit}"
#define TUMBLE_GRAVITY_CHECK_PASSED {passed}
#define TUMBLE_UNCERTAINTY_KNOWN {is_known}

{definitions}

typedef struct {{
    double k[3][3]; /* {k_unit} */
    double u0[3];   /* {unit} */
}} tumble_exported_t;

/* tumble_exported_t coefficients = TUMBLE_COEFFICIENTS_INITIALIZER; */
#define TUMBLE_COEFFICIENTS_INITIALIZER \\
    {{ {{ {rows} }}, \\
      {{ {biases} }} }}

#endif
"""


def _coefficients(result: dict[str, Any]) -> Iterator[tuple[str, float, str, float | None]]:
    """Name, value, unit and standard uncertainty (None: unknown) of the twelve."""
    unit, u_k, u_u0 = result["unit"], result["u_K"], result["u_U0"]
    for i, channel in enumerate("xyz"):
        for j, axis in enumerate("xyz"):
            yield f"K_{channel}{axis}", result["K"][i][j], per_g(unit), None if u_k is None else u_k[i][j]
    for i, channel in enumerate("xyz"):
        yield f"U0_{channel}", result["U0"][i], unit, None if u_u0 is None else u_u0[i]


def _assumed(result: dict[str, Any], coefficient: str) -> list[str]:
    """Names of what a coefficient rests on."""
    of = result["assumed_for"]
    return [name for name in result["assumes"] if coefficient in (of.get(name) or [coefficient])]


def to_csv(result: dict[str, Any]) -> str:
    """One row a coefficient. An unknown uncertainty is an empty field."""
    rows = ["coefficient,value,unit,standard_uncertainty,uncertainty_unit,assumes"]
    for name, value, unit, u in _coefficients(result):
        known, assumed = "" if u is None else format(u, ".17g"), " ".join(_assumed(result, name))
        rows.append(f"{name},{value:.17g},{unit},{known},{unit},{assumed}")
    return "\n".join(rows) + "\n"


def to_c(result: dict[str, Any]) -> str:
    """A header of constants that needs nothing else. Unknown uncertainties are left out, not invented."""
    definitions = []
    for name, value, unit, u in _coefficients(result):
        condition = phrase(_assumed(result, name))
        definitions.append(f"#define TUMBLE_{name.upper()} ({_literal(value)}) /* {unit}{condition} */")
        if u is not None:
            definitions.append(f"#define TUMBLE_U_{name.upper()} ({_literal(u)}) /* {unit}, standard uncertainty */")
    verification = result["verification"]
    is_known = result["u_K"] is not None
    return _C_HEADER.format(
        unit=result["unit"],
        k_unit=per_g(result["unit"]),
        estimator=result["estimator"],
        verdict=f"passed{phrase(result['assumes'])}" if verification["pass"] else "FAILED",
        largest=verification["max_abs_delta_g_g"],
        limit=verification["limit_g"],
        known="TUMBLE_U_..., below" if is_known else "unknown, no stand was declared",
        origin="".join(f" * {line}\n" for line in _origin(result)),
        passed=int(verification["pass"]),
        is_known=int(is_known),
        definitions="\n".join(definitions),
        rows=", \\\n        ".join(f"{{ {', '.join(f'TUMBLE_K_{i}{j}' for j in 'XYZ')} }}" for i in "XYZ"),
        biases=", ".join(f"TUMBLE_U0_{i}" for i in "XYZ"),
    )


def warnings(result: dict[str, Any]) -> list[str]:
    """What whoever uses these coefficients should know first."""
    found, check = [], result["verification"]
    if not check["pass"]:
        sizes = f"largest error {check['max_abs_delta_g_g']:.2g} g, limit {check['limit_g']:g} g"
        found.append(f"the gravity check FAILED: {sizes}")
    if result["stand_doubts"]:
        found.append("the run does not fit the stand file: the uncertainties are too small")
    return found


def _origin(result: dict[str, Any]) -> list[str]:
    """Where the coefficients come from, as lines that fit into a comment."""
    told = [("Block", result["serial"]), ("Run file", result["run_file"])]
    told += [(f"{name}.{key}", text) for name in ("item", "environment") for key, text in (result[name] or {}).items()]
    lines = [f"{_comment(name)}: {_comment(text)}" for name, text in told if text is not None]
    return lines + [f"WARNING: {warning}" for warning in warnings(result)]


def _comment(text: object) -> str:
    """Foreign text, made fit for a comment in C: ASCII in one line that neither ends nor opens one, no trigraphs."""
    plain = ascii(str(text))[1:-1].replace("*/", "* /").replace("/*", "/ *")
    return re.sub(r"\?(?=\?)", "? ", plain)


def _literal(value: float) -> str:
    """A C double: 17 digits, and never an integer literal."""
    text = format(value, ".17g")
    return text if any(sign in text for sign in ".e") else text + ".0"
