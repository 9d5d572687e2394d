"""A result as a small table of HTML, for notebooks."""

from __future__ import annotations

import html
import math

from tumble.documents.result import Result
from tumble.estimators import COEFFICIENTS
from tumble.solving.decision import Decision
from tumble.units import per_g

_UNKNOWN = "unknown"
_DIGITS = 6  # of a value whose uncertainty is not known
_MOST_DECIMALS = 12


def html_table(result: Result) -> str:
    """The verdict, then a row for each of the twelve coefficients: its
    value to the second digit of its standard uncertainty, that, and the unit of both."""
    values, unit = [*result.K.ravel().tolist(), *result.U0.tolist()], result.unit
    uncertainties: list[float | None] = [None] * len(values)
    if result.u_K is not None and result.u_U0 is not None:
        uncertainties = [*result.u_K.ravel().tolist(), *result.u_U0.tolist()]
    rows = "".join(
        _row("td", name, *_rounded(value, u), unit if name.startswith("U0") else per_g(unit))
        for name, value, u in zip(COEFFICIENTS, values, uncertainties)
    )
    return f"<p>{_verdict(result)}</p><table>{_row('th', '', 'value', 'std uncertainty', 'unit')}{rows}</table>"


def _verdict(result: Result) -> str:
    decision = Decision.of(result)
    return f"<b>{decision.word}</b>{html.escape(decision.reason)}"


def _row(tag: str, *cells: str) -> str:
    return f"<tr>{''.join(f'<{tag}>{html.escape(cell)}</{tag}>' for cell in cells)}</tr>"


def _rounded(value: float, u: float | None) -> tuple[str, str]:
    if u is None or u == 0.0:
        return f"{value:.{_DIGITS}g}", _UNKNOWN if u is None else "0"
    decimals = min(_MOST_DECIMALS, max(0, 1 - math.floor(math.log10(u))))
    return f"{value:.{decimals}f}", f"{u:.1e}"
