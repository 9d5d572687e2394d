"""Coefficients in the formats of other tools: 17 digits, with every number its unit and its standard uncertainty."""

from __future__ import annotations

import re
import textwrap

import msgspec

from tumble.api.complaints import complaints_of_document
from tumble.arrays import Floats
from tumble.cli import newton
from tumble.cli.fixed_point import double_literal, fixed_point_function, float_literal
from tumble.documents.result import Result, Temperature
from tumble.solving.assumptions import phrase
from tumble.solving.coefficients import Coefficients
from tumble.solving.decision import Decision
from tumble.terms import DRIFT, Terms

_C_HEADER = """\
/* Coefficients of a three-axis block of accelerometers: U = U0 + K a{model}
 *
 * U: outputs in {unit}; a: specific force in {force}; K_ij in {k_unit}: response of channel i to
 * acceleration along axis j; U0_i in {unit}. Estimator: {estimator}.
 * Gravity check: {verdict}, largest error {largest!r} g, limit {limit!r} g.
 * Standard uncertainties (one sigma): {known}.
{decision}{origin} */
#ifndef TUMBLE_COEFFICIENTS_H
#define TUMBLE_COEFFICIENTS_H

#define TUMBLE_OUTPUT_UNIT "{unit}"
#define TUMBLE_FORCE_UNIT "{force_unit}"
#define TUMBLE_GRAVITY_CHECK_PASSED {passed}
#define TUMBLE_PASSED {all_passed}
#define TUMBLE_UNCERTAINTY_KNOWN {is_known}
#define TUMBLE_TEMPERATURE_KNOWN {temperature_known}
{temperatures}
{definitions}

typedef struct {{
    {number} k[3][3]; /* {k_unit} */
    {number} u0[3];   /* {unit} */
}} tumble_exported_t;

/* tumble_exported_t coefficients = TUMBLE_COEFFICIENTS_INITIALIZER; */
#define TUMBLE_COEFFICIENTS_INITIALIZER \\
    {{ {{ {rows} }}, \\
      {{ {biases} }} }}

/* K^-1, {inverse_unit}: {number} inverse[3][3]. */
#define TUMBLE_K_INVERSE_INITIALIZER \\
    {inverse}
{covariance}{force_function}
#endif
"""
_FORCE = """
/* The specific force that outputs show: a = K^-1 (U - U0). */
static inline void tumble_exported_force(const {number} outputs[3], {number} force[3])
{{
    static const {number} inverse[3][3] = TUMBLE_K_INVERSE_INITIALIZER;
    const {number} left[3] = {{ {biases} }};
    for (int i = 0; i < 3; i++) {{
        force[i] = inverse[i][0] * left[0] + inverse[i][1] * left[1] + inverse[i][2] * left[2];
    }}
}}
"""
_MODEL = {"k2": " + K_ii K2_i a_i^2", "k3": " + K_ii K3_i a_i^3"}

DOUBLE, FLOAT = "double", "float"
_LITERALS = {DOUBLE: double_literal, FLOAT: float_literal}

_CONDITIONS = ("gravity_m_s2", "u_gravity_m_s2", "temperature_c", "pressure_hpa", "humidity_percent")
FORCE_UNITS = {"g": "units of local gravity", "m/s2": "m/s^2"}


def _assumed(result: Result, coefficient: str) -> list[str]:
    """Names of what a coefficient rests on."""
    of = result.assumed_for
    return [name for name in result.assumes if coefficient in (of.get(name) or [coefficient])]


def to_csv(result: Result, force_unit: str = "g") -> str:
    """One row a coefficient, then its covariances with all, the element of K^-1 in its place, and what all rows have in
    common. What is unknown is an empty field."""
    them = Coefficients.of(result, force_unit)
    joint_names = ",".join(f"covariance_{name}" for name in them.names)
    heading = f"coefficient,value,unit,standard_uncertainty,uncertainty_unit,assumes,{joint_names}"
    further = "inverse,inverse_unit,inverse_standard_uncertainty,created,tumble,temperature_min_c,temperature_max_c"
    rows = [f"{heading},{further}"]
    at = result.temperature
    span = ["", ""] if at is None else [format(one, ".17g") for one in (at.min_c, at.max_c)]
    origin = [result.created or "", _plain(result.tumble or ""), *span]
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


def _wrapped(sentence: str) -> str:
    """As lines of a comment."""
    return "".join(f" * {one}\n" for one in textwrap.wrap(f"Verdict: {sentence}.", 116))


def _plain(text: str) -> str:
    """Foreign text without what a field of CSV would need quotes for."""
    return re.sub(r"[^A-Za-z0-9.+:_-]", "", text)


def to_c(result: Result, force_unit: str = "g", number: str = DOUBLE, step: float | None = None) -> str:
    """A header of constants that needs nothing else. Unknown uncertainties are left out, not invented. `number`: what
    they are, DOUBLE or FLOAT; with a `step`, the size of a count of the outputs, they are double, but the function
    computes with integers (cli.fixed_point). Raises ValueError."""
    real = FLOAT if number == FLOAT else DOUBLE
    _literal = _LITERALS[real]
    them, definitions = Coefficients.of(result, force_unit), []
    for i, (name, value, unit) in enumerate(zip(them.names, them.values.tolist(), them.units)):
        condition = phrase(_assumed(result, name))
        definitions.append(f"#define TUMBLE_{name.upper()} ({_literal(value)}) /* {unit}{condition} */")
        if them.uncertainties is not None:
            u = _literal(them.uncertainties[i])
            definitions.append(f"#define TUMBLE_U_{name.upper()} ({u}) /* {unit}, standard uncertainty */")
    verification = result.verification
    is_known = them.uncertainties is not None
    return _C_HEADER.format(
        unit=result.unit,
        k_unit=them.units[0],
        force=FORCE_UNITS[force_unit],
        force_unit=force_unit,
        estimator=result.estimator,
        verdict="passed" if verification.passed else "FAILED",
        decision=_wrapped(Decision.of(result).sentence),
        largest=verification.max_abs_delta_g_g,
        limit=verification.limit_g,
        known="TUMBLE_U_..., below" if is_known else f"unknown, {why_unknown(result)}",
        origin="".join(f" * {line}\n" for line in origin(result)),
        passed=int(verification.passed),
        all_passed=int(result.passed),
        is_known=int(is_known),
        temperature_known=int(result.temperature is not None),
        temperatures=_temperature_macros(result.temperature),
        definitions="\n".join(definitions),
        rows=", \\\n        ".join(f"{{ {', '.join(f'TUMBLE_K_{i}{j}' for j in 'XYZ')} }}" for i in "XYZ"),
        biases=", ".join(f"TUMBLE_U0_{i}" for i in "XYZ"),
        covariance=_covariance(them, real),
        model="".join(_MODEL[term] for term in them.terms),
        inverse=_matrix(them.inverse, real),
        number=real,
        inverse_unit=them.inverse_unit,
        force_function=_force_function(them.terms, real) if step is None else fixed_point_function(them, step),
    )


def _temperature_macros(at: Temperature | None) -> str:
    """Of the run; nothing where it is not known."""
    ends = {} if at is None else {"MIN": at.min_c, "MAX": at.max_c}
    return "".join(
        f"#define TUMBLE_TEMPERATURE_{end}_C ({double_literal(c)}) /* deg C, of the run */\n" for end, c in ends.items()
    )


def _matrix(rows: Floats, number: str) -> str:
    """As an initializer."""
    return "{ " + ", \\\n      ".join(f"{{ {', '.join(map(_LITERALS[number], row))} }}" for row in rows.tolist()) + " }"


def _force_function(terms: Terms, number: str) -> str:
    """In C: from outputs to the specific force."""
    biases = ", ".join(f"outputs[{i}] - TUMBLE_U0_{axis}" for i, axis in enumerate("XYZ"))
    if not terms:
        return _FORCE.format(biases=biases, number=number)
    return newton.in_c(terms, number, biases)


def why_unknown(result: Result) -> str:
    return "no stand was declared" if result.u_K is None else "that of gravity is not told"


def _covariance(them: Coefficients, number: str) -> str:
    """The macro for an array of all coefficients; nothing where it is unknown."""
    if them.covariance is None:
        return ""
    rows, count = [], len(them.names)
    for row in them.covariance.tolist():
        numbers = [_LITERALS[number](value) for value in row]
        lines = [", ".join(numbers[start : start + 4]) for start in range(0, count, 4)]
        rows.append("{ " + ", \\\n        ".join(lines) + " }")
    body = ", \\\n      ".join(rows)
    order = "K row by row, then U0" + "".join(f", then {term.upper()}" for term in them.terms)
    about = f"/* Of {order}, in the products of their units: {number} covariance[{count}][{count}]. */"
    return f"\n{about}\n#define TUMBLE_COVARIANCE_INITIALIZER \\\n    {{ {body} }}\n"


def unlabelled(result: Result) -> Result:
    """Without what tells whose block it is: names and labels, which have no place in somebody's source code. The run's
    SHA-256 stays, by which the result and its report are found."""
    environment = {key: value for key, value in (result.environment or {}).items() if key in _CONDITIONS}
    return msgspec.structs.replace(result, serial=None, run_file=None, item=None, environment=environment)


def origin(result: Result) -> list[str]:
    """Where the coefficients come from, as lines that fit into a comment."""
    told = [("Block", result.serial), ("Run file", result.run_file)]
    told.append(("SHA-256 of the run file", result.run_sha256))
    told += [
        (f"{name}.{key}", text)
        for name in ("item", "environment")
        for key, text in (getattr(result, name) or {}).items()
    ]
    lines = [f"{_comment(name)}: {_comment(text)}" for name, text in told if text is not None]
    if result.extended is not None and DRIFT in result.extended.terms:
        lines.append("A drift over the run was found and taken out: U0 is that of the middle of the run.")
    return lines + [f"WARNING: {warning}" for warning in complaints_of_document(result)]


def _comment(text: object) -> str:
    """Foreign text, made fit for a comment in C: ASCII in one line that neither ends nor opens one, no trigraphs."""
    plain = ascii(str(text))[1:-1].replace("*/", "* /").replace("/*", "/ *")
    return re.sub(r"\?(?=\?)", "? ", plain)
