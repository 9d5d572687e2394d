"""What a Digital Calibration Certificate says of a result, for the template exports/dcc.j2: schema 3.3.0 of PTB, units
as the D-SI writes them.

Who, where and when are labels of the stand file, those that a report reads. What a certificate may not be without is
asked for, not invented; docs/files.md says what stands where a label may be missing.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Iterable
from datetime import date
from typing import TYPE_CHECKING, Any

from tumble._version import __version__
from tumble.documents.base import to_json, written
from tumble.errors import listed, quoted
from tumble.files.stand_file import plain_key
from tumble.report.pages import number_of, require_date, require_number
from tumble.report.sections import (
    AUTHORISED,
    DATES,
    ITEM,
    PARTIES,
    assumptions,
    findings,
    rule,
    unseen,
)
from tumble.report.source import Source, exact, in_words, product, rounded, to_match
from tumble.solving.decision import Decision

if TYPE_CHECKING:
    from tumble.documents.result import Result
    from tumble.solving.coefficients import Coefficients

_M_S2 = r"\metre\second\tothe{-2}"
_D_SI = {  # of the outputs, of K
    "V": (r"\volt", r"\volt\second\tothe{2}\metre\tothe{-1}"),
    "mV": (r"\milli\volt", r"\milli\volt\second\tothe{2}\metre\tothe{-1}"),
    "µV": (r"\micro\volt", r"\micro\volt\second\tothe{2}\metre\tothe{-1}"),
    "uV": (r"\micro\volt", r"\micro\volt\second\tothe{2}\metre\tothe{-1}"),
    "kV": (r"\kilo\volt", r"\kilo\volt\second\tothe{2}\metre\tothe{-1}"),
    "counts": (r"\one", r"\second\tothe{2}\metre\tothe{-1}"),
    "m/s^2": (_M_S2, r"\one"),
}
_NEEDED = {
    "country": ("country",),
    "laboratory": PARTIES["Laboratory"],
    "operator": (*PARTIES[AUTHORISED], *PARTIES["Measured by"]),
    "date": DATES["Date of the run"],
    "customer": PARTIES["Customer"],
    "serial": ITEM["Serial number"],
}
_OPTIONAL = {
    "laboratory_address": PARTIES["Address of the laboratory"],
    "customer_address": PARTIES["Contact of the customer"],
    "place": PARTIES["Place of the calibration"],
    "description": ITEM["Item"],
    "manufacturer": ITEM["Manufacturer"],
    "model": ITEM["Type"],
}
_CONDITIONS = {  # of [environment], and of the result's temperature
    "gravity_m_s2": ("Local gravity", _M_S2),
    "pressure_hpa": ("Air pressure", r"\hecto\pascal"),
    "humidity_percent": ("Relative humidity", r"\percent"),
    "min_c": ("Lowest temperature", r"\degreecelsius"),
    "max_c": ("Highest temperature", r"\degreecelsius"),
}
_DIGITS_OF_K = 3
_CONFORMITY = {"PASS": "pass", "FAIL": "fail", "NOT SHOWN": "noPass"}


def certified(
    result: Result, them: Coefficients, warnings: Iterable[str], number: str | None, issued: str | None
) -> dict[str, Any]:
    """By the names of the template. `them`: the coefficients in units of the SI; `number`, `issued`: None for those of
    the result. Raises ValueError for what the result does not tell, with the key of the stand file that does;
    UsageError for what is no number and no date."""
    labels = _labels(result)
    decision, environment = Decision.of(result), result.environment or {}
    known = environment if result.temperature is None else environment | written(result.temperature)
    conditions = [
        {"name": name, "value": known[key], "unit": unit, "u": known.get(f"u_{key}")}
        for key, (name, unit) in _CONDITIONS.items()
        if key in known
    ]
    for name in [one for key in _CONDITIONS for one in (key, f"u_{key}") if isinstance(known.get(one), str)]:
        raise ValueError(f"environment.{name} is {quoted(known[name])}, no number, which a certificate needs")
    tables = {"item": result.item or {}, "environment": environment}
    told: list[tuple[str, Any]] = [("run_file", result.run_file), ("run_sha256", result.run_sha256)]
    told += [(f"{table}.{key}", text) for table, labelled in tables.items() for key, text in labelled.items()]
    return {
        **labels,
        "number": number_of(written(result)) if number is None else require_number(number, "--certificate-number"),
        "version": __version__,
        "issued": (result.created or "")[:10] if issued is None else require_date(issued),
        "quantities": _quantities(result, them),
        "conditions": conditions,
        "told": [(name, text) for name, text in told if text is not None],
        "conformity": _CONFORMITY[decision.word],
        "statements": _statements(result, decision, warnings),
        "attached": base64.b64encode(to_json(result).encode()).decode(),
    }


def _statements(result: Result, decision: Decision, warnings: Iterable[str]) -> list[tuple[str, str]]:
    """Each with its name, in the words of the report: of conformity first."""
    source = Source(written(result), "result")
    found = "; ".join(f"{in_words(name)}: {in_words(said)}" for name, said in findings(source))
    told = [("Conformity", f"{decision.sentence}. Decision rule: {in_words(rule(source))} Found: {found}.")]
    for name, said in assumptions(source):  # without the mark, which no name of a coefficient has here
        told.append((f"Assumption: {in_words(name)}", in_words(said).lstrip("*^ ")))
    if (lacking := unseen(source)) is not None:
        never = f"Would not have shown at any size: {in_words(lacking[1])}."
        told.append(("What this run could not have shown", f"{in_words(lacking[2])} {never}"))
    told += [("Warning", one) for one in warnings]
    simulated = isinstance(result.bus, str)
    return [*told, ("Simulation", "The run was simulated: no block was measured.")] if simulated else told


def _labels(result: Result) -> dict[str, str | None]:
    """By the names of _NEEDED and _OPTIONAL; None for one that may be missing, and is. Raises ValueError."""
    told = {plain_key(key): str(text).strip() for key, text in (result.environment or {}).items()}
    of_item = {plain_key(key): str(text).strip() for key, text in (result.item or {}).items()}
    told = {key: text for key, text in told.items() if key not in ITEM["Serial number"]} | of_item
    names = {**_NEEDED, **_OPTIONAL}
    found = {name: next((told[key] for key in keys if told.get(key)), None) for name, keys in names.items()}
    found["serial"] = (result.serial or "").strip() or found["serial"]
    if missing := [name for name in _NEEDED if not found[name]]:
        raise ValueError(f"a certificate needs {listed(missing)}: write {_where(missing)}, and solve again")
    if not re.fullmatch("[A-Z]{2}", found["country"] or ""):
        raise ValueError(f"country is {quoted(found['country'])}, no code of ISO 3166-1 such as DE")
    try:
        if len(found["date"] or "") != len("2026-11-20"):  # other forms of ISO 8601 are none of XML's
            raise ValueError
        date.fromisoformat(found["date"] or "")
    except ValueError:
        raise ValueError(f"date is {quoted(found['date'])}, no date such as 2026-11-20") from None
    return found


def _where(missing: list[str]) -> str:
    """In which tables of a stand file these labels belong."""
    serial = [name for name in missing if name == "serial"]
    places = {"[item] or [environment]": [name for name in missing if name not in serial], "[block] or [item]": serial}
    called = {tables: listed(names) if len(missing) > 1 else "it" for tables, names in places.items() if names}
    told = [f"{names} under {tables}" for tables, names in called.items()]
    return f"{', '.join(told)} of the stand file"


def _quantities(result: Result, them: Coefficients) -> list[dict[str, Any]]:
    """The twelve, each with its expanded uncertainty U = k u, rounded as a report rounds them. Raises ValueError."""
    if them.force_unit == "g":
        raise ValueError("a certificate has units of the SI: leave out the unit g")
    if result.unit not in _D_SI:
        raise ValueError(f"outputs in {result.unit}: a certificate has units of the SI, and this is none")
    coverage = result.coverage
    if them.uncertainties is None or result.u_U0 is None or coverage is None:
        known = "write u_gravity_m_s2 under [environment], and solve again"
        why = "solve with --stand" if result.u_K is None else known
        raise ValueError(f"a certificate needs uncertainties: {why}")
    uncertainties = [*them.uncertainties[:9], *result.u_U0.tolist()]
    factors = [one for row in coverage.k_K for one in row] + list(coverage.k_U0)
    units = [unit for unit, count in zip(_D_SI[result.unit][::-1], (9, 3)) for _ in range(count)]
    told = zip(them.names, them.values.tolist(), units, uncertainties, factors)
    return [
        {"name": name, "value": shown.text, "unit": unit, "u": spread.text, "k": rounded(exact(k), _DIGITS_OF_K).text}
        | {"probability": coverage.probability}
        for name, value, unit, u, k in told
        for shown, spread in (to_match(exact(value), product(exact(k), exact(u))),)
    ]
