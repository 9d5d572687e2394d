"""A comparison as a document of schema tumble.comparison/1.

A document of schema tumble.comparison/1 for people, 80 columns wide: what was found, its grounds, the numbers.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from tumble.comparison import pair, verdict
from tumble.comparison.verdict import Differences, Verdict
from tumble.documents.comparison import (
    AfterHolm,
    Alone,
    Comparison,
    Explained,
    OfCoefficient,
    OfParameter,
    OfSeat,
    Shared,
    Side,
    Tests,
)
from tumble.errors import file_name
from tumble.estimators import COEFFICIENTS
from tumble.files.rows import range_text
from tumble.solving.decision import NOT_SHOWN, UNCERTAINTY, phrase
from tumble.terms import names
from tumble.units import per_g, rounded

_MILLIONTHS = 1e6


def document(compared: pair.Comparison) -> Comparison:
    """Ready for JSON."""
    found, stand = compared.found, compared.one_stand
    parameters = _parameters(compared)
    seat = _rows([f"seat_{axis}" for axis in "xyz"], ["urad"] * 3, found.seat, _MILLIONTHS)
    coefficients = _rows([*COEFFICIENTS, *names(compared.terms)], _units(compared), found.coefficients)
    return Comparison(
        verdict=compared.verdict.value,
        apparent=None if found.tests is None else found.verdict.value,
        confidence=found.confidence,
        changed=tuple(row.name for row in parameters if row.changed),
        explained_by=_explained(compared),
        assumes=compared.assumes,
        a=_side(compared.a),
        b=_side(compared.b),
        unit=compared.a.document.unit,
        parameters=parameters,
        seat=tuple(OfSeat(**row) for row in seat),
        coefficients=tuple(OfCoefficient(**row) for row in coefficients),
        tests=None if found.tests is None else _tests(found.tests),
        shared=Shared(
            stand=None if stand is None else stand.label,
            levelled=None if stand is None else stand.levelled,
            sources=compared.shared,
        ),
        warnings=compared.warnings,
        notes=compared.notes,
    )


def _side(side: pair.Side) -> Side:
    told, temperature = side.document, side.temperature
    return Side(
        file=side.name,
        **{key: getattr(told, key) for key in ("created", "run_file", "serial", "estimator", "item")},
        passed=not side.failures,
        pass_reason=" and ".join(side.failures) or None,
        uncertainties=side.calibration.covariance is not None,
        temperature_c=None if temperature is None else (temperature.low_c, temperature.high_c),
        gravity_m_s2=side.gravity[0],
    )


def _units(compared: pair.Comparison) -> list[str]:
    """Of the coefficients."""
    unit = compared.a.document.unit
    further = ["1/g" if term == "k2" else "1/g^2" for term in compared.terms for _ in "xyz"]
    return [per_g(unit)] * 9 + [unit] * 3 + further


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


def _parameters(compared: pair.Comparison) -> tuple[OfParameter, ...]:
    found, reduced = compared.found, compared.a.calibration.reduced(compared.terms)
    is_firm = compared.verdict is Verdict.BLOCK
    rows = _rows([*reduced.parameter_names], [*reduced.parameter_units], found.parameters, _MILLIONTHS)
    p = [None] * len(rows) if found.tests is None else found.tests.p_parameters.tolist()
    return tuple(
        OfParameter(**row, p=one, changed=is_firm and bool(has)) for row, one, has in zip(rows, p, found.changed)
    )


def _explained(compared: pair.Comparison) -> Explained | None:
    one, named = compared.found.explanation, compared.a.calibration.reduced(compared.terms)
    if one is None or compared.verdict is not Verdict.BLOCK:
        return None
    return Explained(
        name=named.parameter_names[one.index],
        difference=one.size * _MILLIONTHS,
        u=one.u * _MILLIONTHS,
        unit=named.parameter_units[one.index],
        p=one.p,
    )


def _tests(tests: verdict.Tests) -> Tests:
    return Tests(tests.all_twelve, tests.block, Alone(tests.alone), tests.seat, AfterHolm(**tests.adjusted))


_WIDTH = 80
_FAILED = "FAILED"
_PERCENT = 100.0
_LEAST_PERCENT = 1e-4
_QUESTIONS = {"whole": "the block, all together", "alone": "the block, any one alone", "seat": "its seat"}
COLUMNS = ("B less A", "difference", "u", "unit", "in u", "by chance")
_NOTHING_SEEN = "no change is to be seen, neither of the block nor of its seat"
_ADVICE = (
    "with --stand FILE. A stand file (TOML) says how exact the stand is; to get one, copy examples/paper_stand.toml and"
    " put in the numbers of your own stand (docs/tutorial.md, chapter 1)."
)
Words = Callable[[str], str]
Row: TypeAlias = OfParameter | OfSeat | OfCoefficient


def render(told: Comparison, words: Words = str) -> str:
    """The whole of it. `words`: what turns options of the command line into what the reader has in their place."""
    lines = [*_wrapped(words(sentence(told))), ""]
    lines += [
        line for name, side in (("A", told.a), ("B", told.b)) for line in _wrapped(f"{name}: {_described(side)}", "   ")
    ]
    given = [_wrapped(f"- {words(one)}", "  ") for one in grounds(told)]
    lines += ["", "What this rests on:", *(line for one in given for line in one)] if given else []
    lines += ["", *_table(told.parameters, told.seat, told.coefficients)]
    if told.tests is not None:
        lines += ["", *_wrapped(legend(told)), "", *_chances(told)]
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
    failed = [side for side in (told.a, told.b) if _verdict(side) == _FAILED]
    unsure = [side for side in (told.a, told.b) if not side.uncertainties]
    checks = "its check" if len(failed) == 1 else "their checks"
    if unsure:
        has, runs = ("has", "its run") if len(unsure) == 1 else ("have", "their runs")
        also = f" And {_named(failed)} FAILED {checks}." if failed else ""
        return f"{_named(unsure)} {has} no uncertainties: solve {runs} again {_ADVICE}{also}"
    return f"{_named(failed)} FAILED {checks}: nothing firm can be said. By the numbers alone, {_apparent(told)}."


def _apparent(told: Comparison) -> str:
    """What the numbers alone say."""
    if told.apparent == Verdict.UNCHANGED:
        return _NOTHING_SEEN
    return _turned(told) if told.apparent == Verdict.SEAT else f"the block has changed: {_moved(told)}"


def _named(sides: list[Side]) -> str:
    return " and ".join(file_name(side.file) for side in sides)


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
    sure = f"Confidence: of blocks that nobody touched, {share} or more are called unchanged{phrase(told.assumes)}."
    return [*([] if told.tests is None else [sure]), *told.notes]


def _described(side: Side) -> str:
    warm = None if side.temperature_c is None else range_text(*side.temperature_c)
    serial = None if side.serial is None else f"serial {side.serial}"
    parts = (side.file, _verdict(side), side.estimator, serial, side.created, warm)
    return ", ".join(filter(None, parts))


def _verdict(side: Side) -> str | None:
    """Where it did not pass: that it failed, or that nothing but the uncertainty stands in the way."""
    if side.passed:
        return None
    return NOT_SHOWN if side.pass_reason == UNCERTAINTY else _FAILED


def _table(*parts: Sequence[Row]) -> list[str]:
    """A paragraph for each part."""
    rows = [COLUMNS, *(cells(row) for part in parts for row in part)]
    widths = [max(map(len, column)) for column in zip(*rows)]
    aligned = (str.ljust, str.rjust, str.rjust, str.ljust, str.rjust, str.rjust)
    lines = ["  ".join(fit(cell, width) for fit, cell, width in zip(aligned, row, widths)).rstrip() for row in rows]
    ends = [1 + sum(map(len, parts[:count])) for count in range(1, len(parts))]
    return [line for number, line in enumerate(lines) for line in ([""] if number in ends else []) + [line]]


def cells(row: Row) -> tuple[str, ...]:
    """A difference as it stands under COLUMNS."""
    return _words(row.name), *rounded(row.difference, row.u), row.unit, *_judged(row)


def _judged(row: Row) -> tuple[str, str]:
    in_u, p = row.in_u, getattr(row, "p", None)
    return "-" if in_u is None else f"{in_u:+.2f}", "" if p is None else _chance(p)


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
    head = f"How often chance alone shows as much (a change is what is rarer than {below}):"
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


def _wrapped(text: str, indent: str = "") -> list[str]:
    return textwrap.wrap(text, _WIDTH, break_long_words=False, break_on_hyphens=False, subsequent_indent=indent)
