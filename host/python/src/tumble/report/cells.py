"""What a report says, as HTML: texts escaped, numbers each with the path that it came from.

Whatever has `__html__` goes into a template as it is; all else is escaped there.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Protocol, TypeAlias

from tumble.report.rounding import Shown
from tumble.signs import signed


class Inline(Protocol):
    """A piece of a line."""

    def __html__(self) -> str: ...


@dataclass(frozen=True)
class Number:
    """A number of the document at `path`, times ten to the `power`, times each of `times`: numbers, or paths of such;
    as `shown`."""

    shown: Shown
    path: str
    times: tuple[str, ...] = ()
    power: int = 0

    def __html__(self) -> str:
        more = f' data-times="{escape(" ".join(self.times))}"' if self.times else ""
        more += f' data-power="{self.power}"' if self.power else ""
        by_power = f" {TIMES} 10<sup>{self.shown.power}</sup>" if self.shown.power else ""
        return f'<span class="number" data-path="{escape(self.path)}"{more}>{self.shown.digits}{by_power}</span>'


@dataclass(frozen=True)
class Text:
    """A text of the document at `path`."""

    text: str
    path: str

    def __html__(self) -> str:
        return f'<span class="told" data-path="{escape(self.path)}">{escape(readable(self.text))}</span>'


@dataclass(frozen=True)
class Fixed:
    """A text of the report's own."""

    text: str

    def __html__(self) -> str:
        return escape(in_signs(self.text))


@dataclass(frozen=True)
class Missing:
    """What the document does not tell."""

    text: str = "not stated"

    def __html__(self) -> str:
        return f'<span class="missing">{self.text}</span>'


@dataclass(frozen=True)
class Line:
    """Pieces in a row."""

    parts: tuple[Inline, ...]

    def __html__(self) -> str:
        return "".join(part.__html__() for part in self.parts)


@dataclass(frozen=True)
class Table:
    """`rows`, whose first piece names the row, under `columns`; the columns of `left` are texts."""

    columns: tuple[str, ...]
    rows: Sequence[tuple[Inline, ...]]
    left: tuple[int, ...] = ()


Facts: TypeAlias = "list[tuple[Inline, Inline]]"  # a name and what is said of it

MISSING = Missing()
NO_UNCERTAINTY = Missing("no uncertainty")
FIGURE_SPACE, POINT_SPACE = "\u2007", "\u2008"
TIMES = "\u00d7"
_POWERS = {"^2": "²", "^3": "³"}
_POWER = re.compile(r"(?<=/[gs])\^[23]\b")
NU = "\u03bd"  # degrees of freedom


def line(*parts: Inline | str) -> Line:
    """Pieces in a row; strings are the report's own words."""
    return Line(tuple(Fixed(part) if isinstance(part, str) else part for part in parts))


def joined(parts: Sequence[Inline], between: str) -> Line:
    """Pieces in a row, with this between them."""
    pieces = [piece for part in parts for piece in (Fixed(between), part)]
    return Line(tuple(pieces[1:]))


def aligned(rows: Sequence[tuple[Inline, ...]], *columns: int) -> list[tuple[Inline, ...]]:
    """Rows whose numbers in these columns, which end at the right, have their points beneath each other: blanks as wide
    as a digit or a point stand for what they lack. Nothing moves where one has a power of ten."""
    found = [list(row) for row in rows]
    for column in columns:
        digits = [cell.shown for cell in (row[column] for row in rows) if isinstance(cell, Number)]
        longest = max((len(one.digits.partition(".")[2]) for one in digits), default=0)
        for row in found if not any(one.power for one in digits) else []:
            cell = row[column]
            if isinstance(cell, Number):
                _, point, places = cell.shown.digits.partition(".")
                blanks = FIGURE_SPACE * (longest - len(places))
                row[column] = line(cell, blanks if point or not longest else POINT_SPACE + blanks)
    return [tuple(row) for row in found]


def readable(text: str) -> str:
    """Foreign text without what no file of text may hold: control characters and halves of characters; and with the
    signs of units that the report itself has."""
    kept = ("\ufffd" if unicodedata.category(one) in ("Cc", "Cs") and one not in "\n\t" else one for one in text)
    return in_signs("".join(kept))


def in_signs(text: str) -> str:
    """With the signs of quantities, and powers of units as such: m/s²."""
    return _POWER.sub(lambda power: _POWERS[power[0]], signed(text))
