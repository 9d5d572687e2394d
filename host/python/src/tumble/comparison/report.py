"""A comparison as a document of schema tumble.comparison/1, and this for people, 80 columns wide: what was found, its
grounds, the numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from tumble.comparison import pair
from tumble.comparison.verdict import Differences, Verdict
from tumble.documents.comparison import (
    AfterHolm,
    Alone,
    Comparison,
    Explained,
    OfCoefficient,
    OfParameter,
    OfSeat,
    ResultSummary,
    Shared,
    Tests,
)
from tumble.errors import file_name
from tumble.estimators import COEFFICIENTS
from tumble.files.rows import range_text
from tumble.fixture.report import in_columns, wrapped
from tumble.solving.decision import NOT_SHOWN, UNCERTAINTY, phrase
from tumble.terms import UNITS_OF_VALUES, names
from tumble.units import per_g, rounded

_MILLIONTHS = 1e6


def document(compared: pair.Comparison) -> Comparison:
    """Ready for JSON."""
    found, stand, unit = compared.found, compared.one_stand, compared.a.document.unit
    reduced, is_firm = compared.a.calibration.reduced(compared.terms), compared.verdict is Verdict.BLOCK
    named = reduced.parameter_names, reduced.parameter_units
    rows = _rows([*named[0]], [*named[1]], found.parameters, _MILLIONTHS)
    tests, p = None, [None] * len(rows)
    if (told := found.tests) is not None:
        tests, p = (
            Tests(told.all_twelve, told.block, Alone(told.alone), told.seat, AfterHolm(**told.adjusted)),
            told.p_parameters.tolist(),
        )
    parameters = tuple(
        OfParameter(**row, p=one, changed=is_firm and bool(has)) for row, one, has in zip(rows, p, found.changed)
    )
    explained = None
    if is_firm and (one := found.explanation) is not None:
        name, of_name = (of[one.index] for of in named)
        explained = Explained(name, one.size * _MILLIONTHS, one.u * _MILLIONTHS, of_name, one.p)
    seat = _rows([f"seat_{axis}" for axis in "xyz"], ["urad"] * 3, found.seat, _MILLIONTHS)
    units = [per_g(unit)] * 9 + [unit] * 3
    units += [UNITS_OF_VALUES[term] for term in compared.terms for _ in "xyz"]
    coefficients = _rows([*COEFFICIENTS, *names(compared.terms)], units, found.coefficients)
    return Comparison(
        verdict=compared.verdict.value,
        apparent=None if found.tests is None else found.verdict.value,
        confidence=found.confidence,
        changed=tuple(row.name for row in parameters if row.changed),
        explained_by=explained,
        assumes=tuple(dict.fromkeys((*compared.a.document.assumes, *compared.b.document.assumes))),
        a=_summary(compared.a),
        b=_summary(compared.b),
        unit=unit,
        parameters=parameters,
        seat=tuple(OfSeat(**row) for row in seat),
        coefficients=tuple(OfCoefficient(**row) for row in coefficients),
        tests=tests,
        shared=Shared(
            stand=None if stand is None else stand.label,
            levelled=None if stand is None else stand.levelled,
            sources=compared.shared,
        ),
        warnings=compared.warnings,
        notes=compared.notes,
    )


def _summary(given: pair.ComparedResult) -> ResultSummary:
    told, temperature = given.document, given.temperature
    return ResultSummary(
        file=given.name,
        **{key: getattr(told, key) for key in ("created", "run_file", "serial", "estimator", "item")},
        passed=not given.failures,
        pass_reason=" and ".join(given.failures) or None,
        uncertainties=given.calibration.covariance is not None,
        temperature_c=None if temperature is None else (temperature.low_c, temperature.high_c),
        gravity_m_s2=given.gravity[0],
    )


def _rows(named: list[str], units: list[str], found: Differences, factor: float = 1.0) -> list[dict[str, Any]]:
    """Keys of one for each; a difference over an uncertainty of 0 is null."""
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


_FAILED = "FAILED"
_PERCENT = 100.0
_LEAST_PERCENT = 1e-4
_QUESTIONS = {"whole": "the block, all together", "alone": "the block, any one alone", "seat": "its seat"}
COLUMNS = ("B less A", "difference", "u", "unit", "in u", "by chance")
_NOTHING_SEEN = "no change of the block or of its seat is detectable"
_ADVICE = (
    "with --stand FILE. A stand file (TOML) says how exact the stand is; to get one, copy examples/paper_stand.toml and"
    " put in the numbers of your own stand (docs/first-calibration.md, step 1)."
)
Reword = Callable[[str], str]
Row: TypeAlias = OfParameter | OfSeat | OfCoefficient


def render(told: Comparison, reword: Reword = str) -> str:
    """The whole of it. `reword`: what turns options of the command line into what the reader has in their place."""
    lines = [*wrapped(reword(sentence(told))), ""]
    for name, summary in (("A", told.a), ("B", told.b)):
        lines += wrapped(f"{name}: {_described(summary)}", "   ")
    given = [line for one in grounds(told) for line in wrapped(f"- {reword(one)}", "  ")]
    lines += ["", "Assumptions:", *given] if given else []
    lines += _table(told.parameters, told.seat, told.coefficients)
    if told.tests is not None:
        lines += ["", *wrapped(legend(told)), "", *_chances(told)]
    return "\n".join(lines) + "\n"


def sentence(told: Comparison) -> str:
    """What was found, and where nothing firm can be: why, what the numbers alone say, and what to do."""
    if told.verdict == Verdict.CANNOT_TELL:
        return f"CANNOT TELL: {_why_not(told)}"
    if told.verdict == Verdict.UNCHANGED:
        return f"UNCHANGED: {_NOTHING_SEEN}."
    if told.verdict == Verdict.SEAT:
        return f"ONLY THE SEAT HAS CHANGED: {_turned(told)}."
    return f"THE BLOCK HAS CHANGED: {_moved(told)}."


def _why_not(told: Comparison) -> str:
    failed = [summary for summary in (told.a, told.b) if _verdict(summary) == _FAILED]
    unsure = [summary for summary in (told.a, told.b) if not summary.uncertainties]
    checks = "its check" if len(failed) == 1 else "their checks"
    if unsure:
        has, runs = ("has", "its run") if len(unsure) == 1 else ("have", "their runs")
        also = f" And {_named(failed)} FAILED {checks}." if failed else ""
        return f"{_named(unsure)} {has} no uncertainties: solve {runs} again {_ADVICE}{also}"
    apparent = _NOTHING_SEEN if told.apparent == Verdict.UNCHANGED else f"the block has changed: {_moved(told)}"
    apparent = _turned(told) if told.apparent == Verdict.SEAT else apparent
    return f"{_named(failed)} FAILED {checks}: nothing firm can be said. By the numbers alone, {apparent}."


def _named(summaries: list[ResultSummary]) -> str:
    return " and ".join(file_name(summary.file) for summary in summaries)


def _turned(told: Comparison) -> str:
    angles = ", ".join(f"{_sized(row)} about {row.name[-1]}" for row in told.seat)
    return f"the block is as it was, but sits turned by {angles}"


def _moved(told: Comparison) -> str:
    """The parameters that stand out by themselves, or what else there is to say of a block that has changed."""
    shown = [_of(row) for row in told.parameters if row.p is not None and row.p < 1.0 - told.confidence]
    alone = told.explained_by
    rest = "" if alone is None else f"; {_of(alone)} alone would explain it"
    return ", ".join(shown) or f"no parameter by itself, but all together{rest}"


def _of(row: Row | Explained) -> str:
    return f"{_words(row.name)} {_sized(row)}"


def grounds(told: Comparison) -> list[str]:
    """What it rests on, a sentence or two each."""
    share = f"{_PERCENT * told.confidence:.6g} %"
    sure = f"Confidence: {share} or more of untouched blocks are called unchanged{phrase(told.assumes)}."
    return [*([] if told.tests is None else [sure]), *told.notes]


def _described(summary: ResultSummary) -> str:
    warm = None if summary.temperature_c is None else range_text(*summary.temperature_c)
    serial = None if summary.serial is None else f"serial {summary.serial}"
    parts = (summary.file, _verdict(summary), summary.estimator, serial, summary.created, warm)
    return ", ".join(filter(None, parts))


def _verdict(summary: ResultSummary) -> str | None:
    """Where it did not pass: that it failed, or that nothing but the uncertainty stands in the way."""
    if summary.passed:
        return None
    return NOT_SHOWN if summary.pass_reason == UNCERTAINTY else _FAILED


def _table(*parts: Sequence[Row]) -> list[str]:
    """A paragraph for each part."""
    aligned = (str.ljust, str.rjust, str.rjust, str.ljust, str.rjust, str.rjust)
    lines = iter(in_columns([COLUMNS, *(cells(row) for part in parts for row in part)], aligned))
    found = ["", next(lines)]
    for part in parts:
        found += [*([] if part is parts[0] else [""]), *(next(lines) for _ in part)]
    return found


def cells(row: Row) -> tuple[str, ...]:
    """A difference as it stands under COLUMNS."""
    in_u, p = row.in_u, getattr(row, "p", None)
    judged = "-" if in_u is None else f"{in_u:+.2f}", "" if p is None else _chance(p)
    return _words(row.name), *rounded(row.difference, row.u), row.unit, *judged


def legend(told: Comparison) -> str:
    """Of COLUMNS."""
    return (
        "u: standard uncertainty of the difference; in u: how many of these it is; by chance: in how many of 100"
        f" comparisons of an unchanged block any of the {len(told.parameters)} parameters is as many u off or more."
        " Near 100 %: nothing unusual; a small number speaks for a change."
    )


def _chances(told: Comparison) -> list[str]:
    """Of the questions whose answers make the verdict."""
    tests = told.tests
    assert tests is not None  # as the caller has seen to
    below = f"{_PERCENT * (1.0 - told.confidence):.3g} %"
    head = f"Probability of as large a difference by chance (a change: below {below}):"
    shown = {name: _chance(getattr(tests.after_holm, key)) for key, name in _QUESTIONS.items()}
    return [head, *(f"{name:<24}  {chance:>9}" for name, chance in shown.items())]


def _chance(p: float) -> str:
    """In percent."""
    percent = _PERCENT * p
    if percent < _LEAST_PERCENT:
        return f"<{_LEAST_PERCENT:.4f} %"
    return f"{percent:.0f} %" if percent >= 10.0 else f"{percent:.2g} %"


def _words(name: str) -> str:
    return name if name[0] in "KU" else name.replace("_", " ")


def _sized(row: Row | Explained) -> str:
    size, u = rounded(row.difference, row.u)
    return f"{size} +- {u} {row.unit}" if row.u is not None else f"{size} {row.unit}"
