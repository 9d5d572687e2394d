"""Tables of plans for people, with rich: at most 80 columns wide, plain text where standard output is no terminal."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from tumble.messages import signed_for

WIDTH = 80


class _Signed(Console):
    """Prints typographic signs of quantities where the terminal has them."""

    def render_str(self, text: str, **how: Any) -> Text:
        return super().render_str(signed_for(text, sys.stdout), **how)


def console() -> Console:
    """Standard output, at least 80 columns wide. Colours follow NO_COLOR; without Unicode the lines are ASCII."""
    out = _Signed(highlight=False, soft_wrap=False)
    out.width = max(out.width, WIDTH) if out.is_terminal else WIDTH
    return out


def table(headings: Sequence[str], rows: Iterable[Sequence[str | Text]], left: Sequence[int] = (0,)) -> Table:
    """A table with numbers aligned right; columns in `left` hold text."""
    made = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, header_style="dim")
    for column, heading in enumerate(headings):
        made.add_column(heading, justify="left" if column in left else "right", no_wrap=column not in left)
    for row in rows:
        made.add_row(*row)
    return made


def heading(text: str) -> Text:
    """The title of a table."""
    return Text(signed_for(text, sys.stdout), style="bold")


def number(value: float | None, digits: int = 3) -> str:
    """A number with so many digits; a dash for None."""
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}g}"


def millionths(value: float | None) -> str:
    """Parts in a million, with three digits and without an exponent where possible."""
    return "-" if value is None or math.isnan(value) else f"{float(f'{1e6 * value:.3g}'):.6g}"


def percent(probability: float) -> str:
    """A percentage to one decimal, the accuracy of the probabilities."""
    return "> 99.9 %" if probability > 0.9995 else f"{100.0 * probability:.1f} %"


def scientific(value: float | None, digits: int = 2) -> str:
    """A number such as 1.15e-04; a dash for None."""
    return "-" if value is None or math.isnan(value) else f"{value:.{digits}e}"
