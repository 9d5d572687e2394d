"""A document of schema tumble.comparison/1 for people, 80 columns wide."""

from __future__ import annotations

import textwrap
from typing import Any

from tumble.comparison.verdict import Verdict
from tumble.files.run_temperature import range_text
from tumble.rounding import rounded
from tumble.solving.assumptions import phrase

_WIDTH = 80
_LEAST_P = 1e-99
_TESTS = {"all": "all twelve", "block": "the block", "seat": "its seat"}


def render(told: dict[str, Any]) -> str:
    """The whole of it."""
    lines = ["Two calibrations of one block: B less A"]
    lines += [line for side in "ab" for line in _wrapped(f"{side.upper()}: {_described(told[side])}", "   ")]
    lines += ["", *_table(told["parameters"], told["seat"], told["coefficients"]), ""]
    if told["tests"] is not None:
        lines += [_test(name, told["tests"]) for name in _TESTS] + [""]
    lines += [line for note in told["notes"] for line in _wrapped(note)]
    return "\n".join([*lines, "", *_wrapped(sentence(told))]) + "\n"


def sentence(told: dict[str, Any]) -> str:
    """The verdict."""
    verdict = Verdict(told["verdict"])
    if verdict is Verdict.CANNOT_TELL:
        return "CANNOT TELL: results without uncertainties (tumble solve --stand) do not show a change."
    at = f"at {100 * told['confidence']:.6g} %{phrase(told['assumes'])}"
    if verdict is Verdict.UNCHANGED:
        return f"UNCHANGED {at}: the differences are within what the uncertainties let them be."
    if verdict is Verdict.SEAT:
        turned = ", ".join(f"{_sized(row)} about {row['name'][-1]}" for row in told["seat"])
        return f"ONLY THE SEAT HAS CHANGED {at}: the block sits turned by {turned}."
    shown = [f"{_words(row['name'])} {_sized(row)}" for row in told["parameters"] if row["changed"]]
    if not shown:
        alone = told["explained_by"]
        rest = "" if alone is None else f"; {_words(alone['name'])} {_sized(alone)} alone would explain it"
        shown = [f"no parameter by itself, but all together{rest}"]
    return f"THE BLOCK HAS CHANGED {at}: {', '.join(shown)}."


def _described(side: dict[str, Any]) -> str:
    warm = None if side["temperature_c"] is None else range_text(*side["temperature_c"])
    serial = None if side["serial"] is None else f"serial {side['serial']}"
    return ", ".join(filter(None, (side["file"], side["estimator"], serial, side["created"], warm)))


def _table(*parts: list[dict[str, Any]]) -> list[str]:
    """A paragraph for each part; p stands where it is known, after Holm."""
    rows: list[tuple[str, ...]] = [("", "difference", "u", "unit", "in u", "p")]
    rows += [
        (_words(row["name"]), *rounded(row["difference"], row["u"]), row["unit"], *_judged(row))
        for part in parts
        for row in part
    ]
    widths = [max(map(len, column)) for column in zip(*rows)]
    aligned = (str.ljust, str.rjust, str.rjust, str.ljust, str.rjust, str.rjust)
    lines = ["  ".join(fit(cell, width) for fit, cell, width in zip(aligned, row, widths)).rstrip() for row in rows]
    ends = [1 + sum(map(len, parts[:count])) for count in range(1, len(parts))]
    return [line for number, line in enumerate(lines) for line in ([""] if number in ends else []) + [line]]


def _judged(row: dict[str, Any]) -> tuple[str, str]:
    in_u, p = row["in_u"], row.get("p")
    return "-" if in_u is None else f"{in_u:+.2f}", "" if p is None else _chance(p)


def _chance(p: float) -> str:
    return f"{p:.1g}" if p >= _LEAST_P else f"<{_LEAST_P:g}"


def _words(name: str) -> str:
    return name if name[0] in "KU" else name.replace("_", " ")


def _sized(row: dict[str, Any]) -> str:
    size, u = rounded(row["difference"], row["u"])
    return f"{size} +- {u} {row['unit']}" if row["u"] is not None else f"{size} {row['unit']}"


def _test(name: str, tests: dict[str, Any]) -> str:
    test = tests[name]
    return (
        f"{_TESTS[name]:<10}  chi-squared {test['chi2']:.4g} of {test['dof']} degrees of freedom,"
        f" p {_chance(test['p'])}"
    )


def _wrapped(text: str, indent: str = "") -> list[str]:
    return textwrap.wrap(text, _WIDTH, break_long_words=False, break_on_hyphens=False, subsequent_indent=indent)
