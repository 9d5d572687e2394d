"""The coefficients of a result for other programs, 17 digits, each with its unit and its uncertainty.

c        a header of constants and a function
csv      one row a coefficient, with its covariances and the element of K^-1 in its place
matlab   a script that sets a struct `tumble`; also for Octave
ros      YAML of imu_calib (github.com/dpkoch/imu_calib)
imucal   JSON of imucal 2 (github.com/mad-lab-fau/imucal)
px4, ardupilot   parameters of an autopilot: an offset and a scale for each axis
dcc      a Digital Calibration Certificate, XML of the schema of PTB (ptb.de/dcc)

A format is a row of FORMATS and a template, exports/NAME.j2, that is given what `_names` names. Unknown
uncertainties are left out, not invented.
"""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tumble.errors import listed
from tumble.terms import ASYMMETRY, CROSSES, POWERS, model_of, name as name_of
from tumble.units import SI

if TYPE_CHECKING:
    from tumble.documents.result import Result
    from tumble.solving.coefficients import Coefficients


@dataclass(frozen=True)
class Format:
    """What it is `about`, how names of its files end, the unit of accelerations that it takes if nobody says another;
    `twelve`: the program that it is for, if that has no place for further terms; `scales`: the range in which it takes
    them, if it has an offset and a scale for each axis, and nothing else."""

    about: str
    endings: tuple[str, ...]
    unit: str = "g"
    twelve: str | None = None
    scales: tuple[float, float] | None = None


FORMATS = {
    "c": Format("a header", (".h", ".c")),
    "csv": Format("one row a coefficient", (".csv",)),
    "matlab": Format("a script", (".m",)),
    "ros": Format("YAML of imu_calib", (".yaml", ".yml"), SI, "imu_calib"),
    "imucal": Format("its JSON", (".json",), SI, "imucal"),
    "px4": Format("CAL_ACC parameters for QGroundControl", (".params",), "g", "PX4", (0.1, 3.0)),
    "ardupilot": Format("INS_ACC parameters", (".param", ".parm"), "g", "ArduPilot", (0.8, 1.2)),
    "dcc": Format("a Digital Calibration Certificate", (".xml",), SI, "a certificate"),
}
MOST_ACCELEROMETERS = 3  # of an autopilot
_STANDARD_GRAVITY = 9.80665  # m/s^2
_M_S2 = {"m/s^2": 1.0, "g": _STANDARD_GRAVITY, "mg": _STANDARD_GRAVITY / 1000.0}  # a unit of outputs
FORCE_UNITS = {"g": "units of local gravity", SI: "m/s^2"}
DOUBLE, FLOAT, FIXED = NUMBERS = ("double", "float", "fixed")
_CONDITIONS = ("gravity_m_s2", "u_gravity_m_s2", "temperature_c", "pressure_hpa", "humidity_percent")


def exported(
    result: Result,
    name: str,
    unit: str | None = None,
    number: str = DOUBLE,
    step: float | None = None,
    labels: bool = False,
    warnings: Iterable[str] = (),
    accelerometer: int = 1,
    certificate_number: str | None = None,
    issued: str | None = None,
) -> str:
    """A result in the format of that `name`, of FORMATS. `unit` of accelerations, None: the format's; `number`: what
    the C header computes with, one of NUMBERS; `step`: of a count of the outputs, for FIXED; `labels`: also those that
    tell whose block it is; `warnings` go into its comments; `accelerometer`: of an autopilot, from 1;
    `certificate_number`, `issued`: of a certificate, None for those of the result. Raises ValueError for what the
    format cannot hold, UsageError for what is no number or date."""
    from tumble.solving.coefficients import Coefficients

    form = FORMATS[name]
    them = Coefficients.of(result, unit or form.unit)
    if form.twelve is not None and them.terms:
        raise ValueError(f"{form.twelve} holds twelve coefficients, no {_listed(them)}")
    names = _names(result, them, warnings, labels)
    fixed = None if step is None else _fixed_point(them, step)
    given = result.unit, result.environment, them.values, them.uncertainties
    axes = None if form.scales is None else axes_of(*given, form)
    more: dict[str, Any] = {"fixed": fixed, "axes": axes, "number": accelerometer}
    if name == "dcc":
        from tumble.report.certificate import certified

        more["certificate"] = certified(result, them, warnings, certificate_number, issued)
    return filled(name, FLOAT if number == FLOAT else DOUBLE, {**names, **more})


def axes_of(
    unit: str, environment: dict[str, str | int | float] | None, values: Any, u: list[float] | None, form: Format
) -> dict[str, Any]:
    """Offsets and scales (3,) of a force = (output - offset) scale in m/s^2, with their uncertainties, None where these
    are unknown, of the `values` of twelve coefficients; `lost`: the cross-axis terms that this cannot hold, as parts of
    their channel's own; `error`: the most that these leave at 1 g, m/s^2; `size`: of the unit. Raises ValueError."""
    import numpy as np

    if unit not in _M_S2:
        raise ValueError(f"outputs in {unit}: {form.twelve} calibrates accelerations, in m/s^2 or g")
    size, told = _M_S2[unit], (environment or {}).get("gravity_m_s2")
    gravity = told if isinstance(told, (int, float)) else _STANDARD_GRAVITY
    k = values[:9].reshape(3, 3) * size / gravity
    scales = 1.0 / np.diag(k)
    low, high = form.scales or (0.0, 0.0)
    for axis, scale in zip("XYZ", scales):
        if not low <= scale <= high:
            raise ValueError(f"scale {scale:.4g} of {axis}: {form.twelve} takes {low:g} to {high:g}")
    left = scales[:, None] * k - np.eye(3)
    return {
        "size": size,
        "offset": (values[9:12] * size).tolist(),
        "scale": scales.tolist(),
        "u_offset": None if u is None else [one * size for one in u[9:12]],
        "u_scale": None if u is None else [one * size / gravity * s**2 for one, s in zip(u[0:9:4], scales)],
        "lost": {f"{a}{b}": left[i, j] for i, a in enumerate("xyz") for j, b in enumerate("xyz") if i != j},
        "error": float(np.linalg.norm(left, 2)) * gravity,
        "gravity": gravity,
        "why_gravity": "of [environment]" if gravity is told else "the standard one, for the result has none",
    }


def _names(result: Result, them: Coefficients, warnings: Iterable[str], labels: bool) -> dict[str, Any]:
    """What templates know, by name: numbers and lists of numbers for accelerations in `force_unit`, and sentences that
    fit into a comment. `u`, `covariance`, `u_inverse` and `temperature` are None where they are unknown."""
    import numpy as np

    from tumble.model.coefficients import PASSES
    from tumble.solving.decision import Decision

    k, check, decision = them.values[:9].reshape(3, 3), result.verification, Decision.of(result).sentence
    lengths = np.linalg.norm(k, axis=1, keepdims=True)
    unit, force, verdict = result.unit, FORCE_UNITS[them.force_unit], "passed" if check.passed else "FAILED"
    largest, limit = check.max_abs_delta_g_g, check.limit_g
    why_unknown = "no stand was declared" if result.u_K is None else "that of gravity is unknown"
    origin = _origin(result, labels) + [f"WARNING: {comment(warning)}" for warning in warnings]
    about = [
        f"Coefficients of a three-axis block of accelerometers, estimator {result.estimator}.",
        f"Outputs in {ascii(unit)[1:-1]}, specific force in {force}.",
        f"Gravity check: {verdict}, largest error {largest!r} g, limit {limit!r} g.",
        f"Verdict: {decision}.",
        *([] if them.uncertainties is not None else [f"Uncertainties unknown: {why_unknown}."]),
        *origin,
    ]
    of = result.assumed_for
    return {
        "result": result,
        "about": about,
        "origin": origin,
        "wrapped_decision": textwrap.wrap(f"Verdict: {decision}.", 116),
        "passed": result.passed,
        "gravity_passed": check.passed,
        "verdict": verdict,
        "largest": largest,
        "limit": limit,
        "unit": unit,
        "force_unit": them.force_unit,
        "force": force,
        "names": them.names,
        "terms": them.terms,
        "further": {term: _further(term, them) for term in them.terms},
        "model": model_of(them.terms),
        "name_of": name_of,
        "passes": PASSES,
        "values": them.values.tolist(),
        "units": them.units,
        "u": them.uncertainties,
        "why_unknown": why_unknown,
        "covariance": None if them.covariance is None else them.covariance.tolist(),
        "assumed": {name: [one for one in result.assumes if name in (of.get(one) or [name])] for name in them.names},
        "K": k.tolist(),
        "lengths": lengths.ravel().tolist(),  # of the rows of K
        "directions": (k / lengths).tolist(),
        "inverse": them.inverse.tolist(),
        "inverse_unit": them.inverse_unit,
        "u_inverse": None if them.u_inverse is None else them.u_inverse.tolist(),
        "bias": (them.inverse @ them.values[9:12]).tolist(),  # K^-1 U0
        "temperature": result.temperature,
    }


def _listed(them: Coefficients) -> str:
    return listed([name_of(term) for term in model_of(them.terms)])


def _further(term: str, them: Coefficients) -> list[dict[str, Any]]:
    """Of a further term, by channel: the name of its size, and in C the product that it is a factor of, and that of its
    slope by each component of the force."""
    first, found = 12 + 3 * them.terms.index(term), []
    for i, name in enumerate(them.names[first : first + 3]):
        force, power = f"force[{i}]", POWERS[term]
        if term in CROSSES:
            j = (i + (1 if term == CROSSES[0] else 2)) % 3
            felt, slopes = f"{force} * force[{j}]", {i: ["", f" * force[{j}]"], j: ["", f" * {force}"]}
        elif term == ASYMMETRY:
            felt, slopes = f"({force} < 0 ? -{force} : {force})", {i: ["", f" * ({force} < 0 ? -1 : 1)"]}
        else:
            felt, slopes = " * ".join([force] * power), {i: [f"{power} * ", f" * {force}" * (power - 1)]}
        found.append({"name": name, "felt": felt, "slopes": slopes})
    return found


def _origin(result: Result, labels: bool) -> list[str]:
    """Where the coefficients come from. Names and `labels`, which tell whose block it is, have no place in somebody's
    source code unless they are asked for. The run's SHA-256 has, by which the result and its report are found."""
    environment = result.environment or {}
    told: list[tuple[str, str | int | float | None]] = [("SHA-256 of the run file", result.run_sha256)]
    if labels:
        told = [("Block", result.serial), ("Run file", result.run_file), *told]
    told += [(f"item.{key}", text) for key, text in (result.item or {}).items() if labels]
    told += [(f"environment.{key}", text) for key, text in environment.items() if labels or key in _CONDITIONS]
    lines = [f"{comment(name)}: {comment(text)}" for name, text in told if text is not None]
    if result.extended is not None and "drift" in result.extended.terms:
        lines.append("A drift over the run was found and taken out: U0 is that of the middle of the run.")
    return lines


def comment(text: object) -> str:
    """Foreign text, made fit for a comment in C: ASCII in one line that neither ends nor opens one, no trigraphs."""
    plain = ascii(str(text))[1:-1].replace("*/", "* /").replace("/*", "/ *")
    return re.sub(r"\?(?=\?)", "? ", plain)


_NOT_IN_XML = re.compile("[^\t\n\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def filled(name: str, real: str, names: dict[str, Any]) -> str:
    """The template of a format. Its numbers are `digits`, in C a `literal` of the type `real`."""
    import numpy as np
    from jinja2 import Environment, StrictUndefined

    from tumble.solving.decision import phrase

    environment = Environment(
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,  # what is foreign is made fit by `comment`, `plain`, `json` and `xml`
    )
    environment.filters |= {
        "digits": lambda value: format(value, ".17g"),
        "short": lambda value: format(value, ".2g"),
        "double": _literal,
        "literal": lambda value: f"{_literal(float(np.float32(value)), 9)}f" if real == FLOAT else _literal(value),
        "phrase": phrase,
        "plain": lambda text: re.sub(r"[^A-Za-z0-9.+:_-]", "", text),  # without what needs quotes in CSV
        "json": lambda value: json.dumps(value, indent=4).replace("\n", "\n    "),  # of a member
        "xml": lambda text: escape(_NOT_IN_XML.sub("\ufffd", str(text))),
    }
    template = (Path(__file__).parent / f"exports/{name}.j2").read_text(encoding="utf-8")
    return environment.from_string(template).render(names, real=real)


def _literal(value: float, digits: int = 17) -> str:
    """Of a C double, or of the digits that a float has; never an integer literal."""
    text = format(value, f".{digits}g")
    return text if any(sign in text for sign in ".e") else text + ".0"


_LARGEST_FACTOR = 2**29
_LARGEST_COUNT = 2**31
_LARGEST_SHIFT = 60


def _fixed_point(them: Coefficients, step: float) -> dict[str, Any]:
    """Constants for a computer without floating point: counts in, millionths of the force's unit out, by integers.

        force_i = (sum_j M_ij counts_j - C_i) / 2^shift, rounded

    with M = K^-1 step / 10^-6 2^shift and C = M U0 / step, whole numbers: M of at most 30 bits, so that no sum of three
    products with counts of 32 bits leaves 64 bits. `step`: the size of a count, in the unit of the outputs. Raises
    ValueError.
    """
    from fractions import Fraction

    if them.terms:
        raise ValueError(f"fixed point has no {_listed(them)}: export them as float or double")
    if not abs(them.values[9:12]).max() < _LARGEST_COUNT * step:
        raise ValueError(f"--step {step:g}: U0 has more counts than 32 bits hold")
    factors = [[Fraction(one) * Fraction(step) * 10**6 for one in row] for row in them.inverse.tolist()]
    largest = max(abs(one) for row in factors for one in row)
    shift = next((s for s in range(_LARGEST_SHIFT, 0, -1) if largest * 2**s < _LARGEST_FACTOR), None)
    if shift is None:
        raise ValueError(f"--step {step:g}: a count is too large for a force in steps of 1e-6")
    matrix = [[round(one * 2**shift) for one in row] for row in factors]
    counts = [Fraction(one) / Fraction(step) for one in them.values[9:12].tolist()]
    offset = [round(sum(one * bias for one, bias in zip(row, counts))) for row in matrix]
    force = "g" if them.force_unit == "g" else "m/s^2"
    return {"step": step, "shift": shift, "matrix": matrix, "offset": offset, "force_unit": force}
