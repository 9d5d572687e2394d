"""Coefficients in the formats of other tools: 17 digits, with every number its unit and its standard uncertainty."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.solving import si
from tumble.solving.assumptions import phrase
from tumble.terms import DRIFT, KEYS, POWERS, Terms, names
from tumble.units import per_g, per_m_s2

_C_HEADER = """\
/* Coefficients of a three-axis block of accelerometers: U = U0 + K a{model}
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
#define TUMBLE_TEMPERATURE_KNOWN {temperature_known}
{temperatures}
{definitions}

typedef struct {{
    double k[3][3]; /* {k_unit} */
    double u0[3];   /* {unit} */
}} tumble_exported_t;

/* tumble_exported_t coefficients = TUMBLE_COEFFICIENTS_INITIALIZER; */
#define TUMBLE_COEFFICIENTS_INITIALIZER \\
    {{ {{ {rows} }}, \\
      {{ {biases} }} }}

/* K^-1, {inverse_unit}: double inverse[3][3]. */
#define TUMBLE_K_INVERSE_INITIALIZER \\
    {inverse}
{covariance}{force_function}
#endif
"""
_FORCE = """
/* The specific force that outputs show: a = K^-1 (U - U0). */
static inline void tumble_exported_force(const double outputs[3], double force[3])
{{
    static const double inverse[3][3] = TUMBLE_K_INVERSE_INITIALIZER;
    const double left[3] = {{ {biases} }};
    for (int i = 0; i < 3; i++) {{
        force[i] = inverse[i][0] * left[0] + inverse[i][1] * left[1] + inverse[i][2] * left[2];
    }}
}}
"""
_FORCE_WITH_TERMS = """
/* The specific force that outputs show. Every pass is closer by a factor of 2 K2 a + 3 K3 a^2: of a few thousandths. */
static inline void tumble_exported_force(const double outputs[3], double force[3])
{{
    static const double inverse[3][3] = TUMBLE_K_INVERSE_INITIALIZER;
    const double shown[3] = {{ {biases} }};
    double left[3] = {{ shown[0], shown[1], shown[2] }};
    for (int n = 0; n < 8; n++) {{
        for (int i = 0; i < 3; i++) {{
            force[i] = inverse[i][0] * left[0] + inverse[i][1] * left[1] + inverse[i][2] * left[2];
        }}
{beyond}
    }}
}}
"""
_MODEL = {"k2": " + K_ii K2_i a_i^2", "k3": " + K_ii K3_i a_i^3"}

FORCE_UNITS = {"g": "units of local gravity", "m/s2": "m/s^2"}
NAMES = tuple([f"K_{i}{j}" for i in "xyz" for j in "xyz"] + [f"U0_{i}" for i in "xyz"])


def _assumed(result: dict[str, Any], coefficient: str) -> list[str]:
    """Names of what a coefficient rests on."""
    of = result["assumed_for"]
    return [name for name in result["assumes"] if coefficient in (of.get(name) or [coefficient])]


@dataclass(frozen=True)
class Coefficients:
    """What is exported: the twelve in the order of NAMES, then K2 and K3 if the model has them, each with its unit and
    its standard uncertainty, and their covariance (None: unknown), for accelerations in `force_unit`, one of
    FORCE_UNITS. `terms`: of POWERS, those of the model."""

    values: Floats
    units: list[str]
    covariance: Floats | None
    uncertainties: list[float] | None
    force_unit: str
    terms: Terms

    @classmethod
    def of(cls, result: dict[str, Any], force_unit: str = "g") -> Coefficients:
        """Of a result. Raises ValueError for m/s2 where its environment names no gravity, and for a singular K."""
        extended = result["extended"] or {"terms": [], "covariance": result["covariance"]}
        terms = tuple(term for term in extended["terms"] if term in POWERS)
        values = np.array([*chain(*result["K"]), *result["U0"], *chain(*(extended[KEYS[term]] for term in terms))])
        powers = np.concatenate([si.POWERS_OF_TWELVE, np.repeat([POWERS[term] - 1.0 for term in terms], 3)])
        joint = None if extended["covariance"] is None else np.array(extended["covariance"])[: len(values)]
        joint = None if joint is None else joint[:, : len(values)]
        stated = None if result["u_K"] is None else [*chain(*result["u_K"]), *result["u_U0"]]
        if stated is not None:
            stated += [u for term in terms for u in extended[f"u_{KEYS[term]}"]]
        unit, is_g = result["unit"], force_unit == "g"
        force = "g" if is_g else "(m/s^2)"
        units = [per_g(unit) if is_g else per_m_s2(unit)] * 9 + [unit] * 3
        units += [f"1/{force}" + ("" if POWERS[term] == 2 else "^2") for term in terms for _ in "xyz"]
        if not is_g:
            gravity, u_gravity = si.gravity_of(result["environment"])
            if gravity is None:
                raise ValueError("no coefficients in m/s2: its environment has no gravity_m_s2")
            if joint is not None:
                joint = None if u_gravity is None else si.joint(values, powers, joint, gravity, u_gravity)
            stated = None if joint is None else np.sqrt(np.diag(joint)).tolist()
            values = values / gravity**powers
        if not np.isfinite(np.linalg.cond(values[:9].reshape(3, 3))):
            raise ValueError("K is singular: it tells no acceleration")
        return cls(values, units, joint, stated, force_unit, terms)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all."""
        return NAMES + names(self.terms)

    @property
    def inverse(self) -> Floats:
        """K^-1 (3, 3)."""
        inverse: Floats = np.linalg.inv(self.values[:9].reshape(3, 3)).astype(float)
        return inverse

    @property
    def inverse_unit(self) -> str:
        """Of its elements."""
        return f"{'g' if self.force_unit == 'g' else '(m/s^2)'}/{self.units[9]}"

    @property
    def u_inverse(self) -> Floats | None:
        """Standard uncertainties of K^-1 (3, 3): it changes by - K^-1 dK K^-1."""
        if self.covariance is None:
            return None
        by_k = np.kron(self.inverse, self.inverse.T)
        u: Floats = np.sqrt(np.diag(by_k @ self.covariance[:9, :9] @ by_k.T)).reshape(3, 3)
        return u


def to_csv(result: dict[str, Any], force_unit: str = "g") -> str:
    """One row a coefficient, then its covariances with all, the element of K^-1 in its place, and what all rows have in
    common. What is unknown is an empty field."""
    them = Coefficients.of(result, force_unit)
    joint_names = ",".join(f"covariance_{name}" for name in them.names)
    heading = f"coefficient,value,unit,standard_uncertainty,uncertainty_unit,assumes,{joint_names}"
    further = "inverse,inverse_unit,inverse_standard_uncertainty,created,tumble,temperature_min_c,temperature_max_c"
    rows = [f"{heading},{further}"]
    at = result["temperature"]
    span = ["", ""] if at is None else [format(at[key], ".17g") for key in ("min_c", "max_c")]
    origin = [result["created"] or "", _plain(result["tumble"] or ""), *span]
    for i, (name, value, unit) in enumerate(zip(them.names, them.values, them.units)):
        u = "" if them.uncertainties is None else format(them.uncertainties[i], ".17g")
        joint = [""] * len(them.names) if them.covariance is None else [format(x, ".17g") for x in them.covariance[i]]
        assumed = " ".join(_assumed(result, name))
        inverse = ["", "", ""]
        if i < 9:
            u_inverse = "" if them.u_inverse is None else format(them.u_inverse.flat[i], ".17g")
            inverse = [format(them.inverse.flat[i], ".17g"), them.inverse_unit, u_inverse]
        rows.append(",".join([name, format(value, ".17g"), unit, u, unit, assumed, *joint, *inverse, *origin]))
    return "\n".join(rows) + "\n"


def _plain(text: str) -> str:
    """Foreign text without what a field of CSV would need quotes for."""
    return re.sub(r"[^A-Za-z0-9.+:_-]", "", text)


def to_c(result: dict[str, Any], force_unit: str = "g") -> str:
    """A header of constants that needs nothing else. Unknown uncertainties are left out, not invented."""
    them, definitions = Coefficients.of(result, force_unit), []
    for i, (name, value, unit) in enumerate(zip(them.names, them.values.tolist(), them.units)):
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
        temperature_known=int(result["temperature"] is not None),
        temperatures=_temperature_macros(result["temperature"]),
        definitions="\n".join(definitions),
        rows=", \\\n        ".join(f"{{ {', '.join(f'TUMBLE_K_{i}{j}' for j in 'XYZ')} }}" for i in "XYZ"),
        biases=", ".join(f"TUMBLE_U0_{i}" for i in "XYZ"),
        covariance=_covariance(them),
        model="".join(_MODEL[term] for term in them.terms),
        inverse=_matrix(them.inverse),
        inverse_unit=them.inverse_unit,
        force_function=_force_function(them.terms),
    )


def _temperature_macros(at: dict[str, Any] | None) -> str:
    """Of the run; nothing where it is not known."""
    ends = {} if at is None else {"MIN": at["min_c"], "MAX": at["max_c"]}
    lines = [f"#define TUMBLE_TEMPERATURE_{end}_C ({_literal(c)}) /* deg C, of the run */\n" for end, c in ends.items()]
    return "".join(lines)


def _matrix(rows: Floats) -> str:
    """As an initializer."""
    return (
        "{ " + ", \\\n      ".join(f"{{ {', '.join(_literal(one) for one in row)} }}" for row in rows.tolist()) + " }"
    )


def _force_function(terms: Terms) -> str:
    """In C: from outputs to the specific force."""
    biases = ", ".join(f"outputs[{i}] - TUMBLE_U0_{axis}" for i, axis in enumerate("XYZ"))
    if not terms:
        return _FORCE.format(biases=biases)
    beyond = [f"TUMBLE_K_{axis * 2} * ({_powers(terms, i, axis)})" for i, axis in enumerate("XYZ")]
    lines = [f"        left[{i}] = shown[{i}] - {one};" for i, one in enumerate(beyond)]
    return _FORCE_WITH_TERMS.format(biases=biases, beyond="\n".join(lines))


def _powers(terms: Terms, i: int, axis: str) -> str:
    force = f"force[{i}]"
    return " + ".join(" * ".join([f"TUMBLE_{term.upper()}_{axis}", *[force] * POWERS[term]]) for term in terms)


def _why_unknown(result: dict[str, Any]) -> str:
    return "no stand was declared" if result["u_K"] is None else "that of gravity is not told"


def _covariance(them: Coefficients) -> str:
    """The macro for an array of all coefficients; nothing where it is unknown."""
    if them.covariance is None:
        return ""
    rows, count = [], len(them.names)
    for row in them.covariance.tolist():
        numbers = [_literal(value) for value in row]
        lines = [", ".join(numbers[start : start + 4]) for start in range(0, count, 4)]
        rows.append("{ " + ", \\\n        ".join(lines) + " }")
    body = ", \\\n      ".join(rows)
    order = "K row by row, then U0" + "".join(f", then {term.upper()}" for term in them.terms)
    about = f"/* Of {order}, in the products of their units: double covariance[{count}][{count}]. */"
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
    if DRIFT in (result["extended"] or {"terms": []})["terms"]:
        lines.append("A drift over the run was found and taken out: U0 is that of the middle of the run.")
    return lines + [f"WARNING: {warning}" for warning in warnings(result)]


def _comment(text: object) -> str:
    """Foreign text, made fit for a comment in C: ASCII in one line that neither ends nor opens one, no trigraphs."""
    plain = ascii(str(text))[1:-1].replace("*/", "* /").replace("/*", "/ *")
    return re.sub(r"\?(?=\?)", "? ", plain)


def _literal(value: float) -> str:
    """A C double: 17 digits, and never an integer literal."""
    text = format(value, ".17g")
    return text if any(sign in text for sign in ".e") else text + ".0"
