"""Coefficients in the formats of other tools: 17 digits, with every number its unit and its standard uncertainty."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from tumble.solving import si
from tumble.solving.assumptions import phrase
from tumble.units import per_g, per_m_s2

_C_HEADER = """\
/* Coefficients of a three-axis block of accelerometers: U = U0 + K a
 *
 * U: outputs in {unit}; a: specific force in {force}; K_ij in {k_unit}: response of channel i to
 * acceleration along axis j; U0_i in {unit}. Estimator: {estimator}.
 * Gravity check: {verdict}, largest error {largest!r} g, limit {limit!r} g.
 * Standard uncertainties (one sigma): {known}.
{origin} */
#ifndef TUMBLE_COEFFICIENTS_H
#define TUMBLE_COEFFICIENTS_H

#define TUMBLE_OUTPUT_UNIT "{unit}"
#define TUMBLE_FORCE_UNIT "{force_unit}"
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
{covariance}
#endif
"""


FORCE_UNITS = {"g": "units of local gravity", "m/s2": "m/s^2"}
NAMES = tuple([f"K_{i}{j}" for i in "xyz" for j in "xyz"] + [f"U0_{i}" for i in "xyz"])


def _assumed(result: dict[str, Any], coefficient: str) -> list[str]:
    """Names of what a coefficient rests on."""
    of = result["assumed_for"]
    return [name for name in result["assumes"] if coefficient in (of.get(name) or [coefficient])]


@dataclass(frozen=True)
class Coefficients:
    """What is exported: the twelve in the order of NAMES, each with its unit and its standard uncertainty, and their
    covariance (None: unknown), for accelerations in `force_unit`, one of FORCE_UNITS."""

    values: list[float]
    units: list[str]
    uncertainties: list[float] | None
    covariance: list[list[float]] | None
    force_unit: str

    @classmethod
    def of(cls, result: dict[str, Any], force_unit: str = "g") -> Coefficients:
        """Of a result. Raises ValueError for m/s2 where its environment names no gravity."""
        unit, u_k = result["unit"], result["u_K"]
        units = [per_g(unit) if force_unit == "g" else per_m_s2(unit)] * 9 + [unit] * 3
        if force_unit == "g":
            values = [*chain(*result["K"]), *result["U0"]]
            stated = None if u_k is None else [*chain(*u_k), *result["u_U0"]]
            return cls(values, units, stated, result["covariance"], force_unit)
        gravity, u_gravity = si.gravity_of(result["environment"])
        if gravity is None:
            raise ValueError("its environment has no gravity_m_s2")
        known = None if result["covariance"] is None else np.array(result["covariance"])
        found = si.converted(np.array(result["K"]), np.array(result["U0"]), known, gravity, u_gravity)
        joint = found.covariance
        stated = None if joint is None else np.sqrt(np.diag(joint)).tolist()
        values = [*found.k.ravel().tolist(), *result["U0"]]
        return cls(values, units, stated, None if joint is None else joint.tolist(), force_unit)


def to_csv(result: dict[str, Any], force_unit: str = "g") -> str:
    """One row a coefficient, its covariances with all twelve at the end. What is unknown is an empty field."""
    them = Coefficients.of(result, force_unit)
    joint_names = ",".join(f"covariance_{name}" for name in NAMES)
    rows = [f"coefficient,value,unit,standard_uncertainty,uncertainty_unit,assumes,{joint_names}"]
    for i, (name, value, unit) in enumerate(zip(NAMES, them.values, them.units)):
        u = "" if them.uncertainties is None else format(them.uncertainties[i], ".17g")
        joint = [""] * 12 if them.covariance is None else [format(one, ".17g") for one in them.covariance[i]]
        assumed = " ".join(_assumed(result, name))
        rows.append(",".join([name, format(value, ".17g"), unit, u, unit, assumed, *joint]))
    return "\n".join(rows) + "\n"


def to_c(result: dict[str, Any], force_unit: str = "g") -> str:
    """A header of constants that needs nothing else. Unknown uncertainties are left out, not invented."""
    them, definitions = Coefficients.of(result, force_unit), []
    for i, (name, value, unit) in enumerate(zip(NAMES, them.values, them.units)):
        condition = phrase(_assumed(result, name))
        definitions.append(f"#define TUMBLE_{name.upper()} ({_literal(value)}) /* {unit}{condition} */")
        if them.uncertainties is not None:
            u = _literal(them.uncertainties[i])
            definitions.append(f"#define TUMBLE_U_{name.upper()} ({u}) /* {unit}, standard uncertainty */")
    verification = result["verification"]
    is_known = them.uncertainties is not None
    return _C_HEADER.format(
        unit=result["unit"],
        k_unit=them.units[0],
        force=FORCE_UNITS[force_unit],
        force_unit=force_unit,
        estimator=result["estimator"],
        verdict=f"passed{phrase(result['assumes'])}" if verification["pass"] else "FAILED",
        largest=verification["max_abs_delta_g_g"],
        limit=verification["limit_g"],
        known="TUMBLE_U_..., below" if is_known else f"unknown, {_why_unknown(result)}",
        origin="".join(f" * {line}\n" for line in _origin(result)),
        passed=int(verification["pass"]),
        is_known=int(is_known),
        definitions="\n".join(definitions),
        rows=", \\\n        ".join(f"{{ {', '.join(f'TUMBLE_K_{i}{j}' for j in 'XYZ')} }}" for i in "XYZ"),
        biases=", ".join(f"TUMBLE_U0_{i}" for i in "XYZ"),
        covariance=_covariance(them),
    )


def _why_unknown(result: dict[str, Any]) -> str:
    return "no stand was declared" if result["u_K"] is None else "that of gravity is not told"


def _covariance(them: Coefficients) -> str:
    """The macro for an array [12][12]; nothing where it is unknown."""
    if them.covariance is None:
        return ""
    rows = []
    for row in them.covariance:
        numbers = [_literal(value) for value in row]
        lines = [", ".join(numbers[start : start + 4]) for start in (0, 4, 8)]
        rows.append("{ " + ", \\\n        ".join(lines) + " }")
    body = ", \\\n      ".join(rows)
    about = "/* Of the twelve, K row by row, then U0, in the products of their units: double covariance[12][12]. */"
    return f"\n{about}\n#define TUMBLE_COVARIANCE_INITIALIZER \\\n    {{ {body} }}\n"


def warnings(result: dict[str, Any]) -> list[str]:
    """What whoever uses these coefficients should know first."""
    found, check = [], result["verification"]
    if not check["pass"]:
        sizes = f"largest error {check['max_abs_delta_g_g']:.2g} g, limit {check['limit_g']:g} g"
        found.append(f"the gravity check FAILED: {sizes}")
    fit = result["fit"] or {}
    if result["stand_doubts"] or fit.get("fits") is False:
        found.append("the run does not fit the stand file: the uncertainties are too small")
    elif fit.get("explanations"):
        found.append("the run shows what the stand file does not declare: the uncertainties are too small")
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
