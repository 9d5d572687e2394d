"""What a report may say: the numbers and texts of a result's document, each with the path that it came from.

A path is that of RFC 6901 (JSON pointer), such as /K/0/1. It goes into the HTML with what it led to, so that every
number of a report can be held against the document.

A number of a result is the decimal that its JSON has: the shortest one that reads back as the same double. It is
computed with exactly, and rounded once, half to even (ISO 80000-1, B.3, rule A). An expanded uncertainty has two
significant digits, and its value ends at the same place (JCGM 100:2008, 7.2.6). Two digits never lose 5 % or more of an
uncertainty, so that it need not be rounded up (EA-4/02 M:2022, 6.3).

Whatever has `__html__` goes into a template as it is; all else is escaped there.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import ROUND_HALF_EVEN, Context, Decimal
from functools import partial
from html import escape, unescape
from typing import Any, Protocol, TypeAlias

from tumble.documents.base import checked
from tumble.documents.result import RESULT, Result
from tumble.messages import signed

DIGITS_OF_UNCERTAINTY = 2
_OF_A_DOUBLE = 17
_MOST_PLACES = 9  # behind the point, before a value and its uncertainty are given by powers of ten
_SMALLEST_PLAIN = -4  # power of ten of the first digit of what is given without one
_LARGEST_PLAIN = 15
_EXACT = Context(prec=2000, rounding=ROUND_HALF_EVEN)  # no product of doubles has more digits


@dataclass(frozen=True)
class Shown:
    """What is printed: `digits`, times ten to the `power` where that is not 0."""

    digits: str
    power: int = 0

    @property
    def text(self) -> str:
        """As programs read it."""
        return f"{self.digits}e{self.power}" if self.power else self.digits


def exact(number: float) -> Decimal:
    """The decimal that stands in JSON for it."""
    return Decimal(repr(number))


def product(one: Decimal, other: Decimal) -> Decimal:
    """Exactly."""
    return _EXACT.multiply(one, other)


def significant(value: Decimal, digits: int) -> Decimal:
    """The nearest decimal of so many significant digits."""
    if not value:
        return Decimal(0)
    rounded = _to_place(value, value.adjusted() - digits + 1)
    return _to_place(rounded, rounded.adjusted() - digits + 1)  # 9.96 has become 10.0


def to_match(value: Decimal, uncertainty: Decimal, whole: bool = False) -> tuple[Shown, Shown]:
    """A value and its uncertainty, this with DIGITS_OF_UNCERTAINTY, both with the same places; `whole`: at least to
    whole numbers, never by powers of ten. A value has no more digits than a double holds. Without an uncertainty, 0,
    all that it has."""
    spread = significant(uncertainty, DIGITS_OF_UNCERTAINTY)
    if not spread:
        return plain(value), plain(spread)
    place = max(_place(spread), value.adjusted() - _OF_A_DOUBLE + 1) if value else _place(spread)
    if whole and place > 0:
        place, spread = 0, _to_place(uncertainty, 0)
    found = _to_place(value, place)
    if -_MOST_PLACES <= place <= 0:
        return Shown(_fixed(found)), Shown(_fixed(spread))
    power = max(found.adjusted() if found else spread.adjusted(), spread.adjusted())
    return _by_power(found, power), _by_power(spread, power)


def plain(value: Decimal) -> Shown:
    """All digits that it has; by a power of ten where it would need many zeros."""
    if not value:
        return Shown("0")
    value = value.normalize(_EXACT)
    if _SMALLEST_PLAIN <= value.adjusted() <= _LARGEST_PLAIN:
        return Shown(_fixed(value))
    return _by_power(value, value.adjusted())


def rounded(value: Decimal, digits: int) -> Shown:
    """With so many significant digits, zeros at the end too."""
    found = significant(value, digits)
    if not found:
        return Shown("0")
    if _SMALLEST_PLAIN <= found.adjusted() and _place(found) <= 0:
        return Shown(_fixed(found))
    return _by_power(found, found.adjusted())


def to_places(value: Decimal, places: int) -> Shown:
    """With so many digits behind the point."""
    return Shown(_fixed(_to_place(value, -places)))


def _to_place(value: Decimal, place: int) -> Decimal:
    """The nearest multiple of ten to the `place`."""
    return value.quantize(Decimal((0, (1,), place)), context=_EXACT)


def _place(value: Decimal) -> int:
    """Power of ten of the last digit of a finite decimal."""
    return int(value.as_tuple().exponent)


def _by_power(value: Decimal, power: int) -> Shown:
    return Shown(_fixed(value.scaleb(-power, _EXACT)), power)


def _fixed(value: Decimal) -> str:
    """Without an exponent, and without a sign where all digits are 0."""
    return f"{value or abs(value):f}"


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


def in_words(said: Inline) -> str:
    """A piece of a line as plain text, powers behind ^."""
    return unescape(re.sub("<[^>]*>", "", said.__html__().replace("<sup>", "^")))


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


Key: TypeAlias = "str | int"
Path: TypeAlias = "tuple[Key, ...]"
Factor: TypeAlias = "Path | Decimal"  # a number of the document, or one of the report's own
STANDARD_GRAVITY = Decimal("9.80665")  # m/s^2 (CGPM 1901); the local one differs from it by less than 0.5 %
_DIGITS_ALONE = 7  # of a value whose uncertainty is not known


class DocumentSource:
    """A document. `name`: what errors call it."""

    def __init__(self, document: dict[str, Any], name: str):
        self.document = document
        self.name = name

    def at(self, *path: Key) -> Any:
        """What is there, of whatever kind; None where nothing is."""
        found: Any = self.document
        for key in path:
            if isinstance(found, dict):
                found = found.get(str(key))
            elif isinstance(found, list) and isinstance(key, int) and key < len(found):
                found = found[key]
            else:
                return None
        return found

    def table(self, *path: Key) -> dict[str, Any]:
        """An object; an empty one where there is none."""
        return self.at(*path) or {}

    def array(self, *path: Key) -> list[Any]:
        """An array; an empty one where there is none."""
        return self.at(*path) or []

    @property
    def gravity(self) -> Factor:
        """One g in m/s^2: the local one, else the standard one."""
        local: Path = ("environment", "gravity_m_s2")
        return STANDARD_GRAVITY if self.decimal(*local) is None else local

    def decimal(self, *path: Key) -> Decimal | None:
        """A number; None where there is none."""
        found = self.at(*path)
        return None if found is None else exact(found)

    def told(self, *path: Key) -> Inline:
        """A text or a number as it stands there."""
        found = self.at(*path)
        if found is None:
            return MISSING
        if isinstance(found, str):
            return Text(found, pointer(path))
        return self.scaled(path, plain)

    def each(self, *path: Key) -> list[Inline]:
        """All of an array, as `told`."""
        return [self.told(*path, i) for i in range(len(self.array(*path)))]

    def rounded(self, digits: int, *path: Key) -> Inline:
        """A number with so many significant digits."""
        return self.scaled(path, partial(rounded, digits=digits))

    def to_places(self, places: int, *path: Key) -> Inline:
        """A number with so many digits behind the point."""
        return self.scaled(path, partial(to_places, places=places))

    def millionths(self, places: int | None, *path: Key) -> Inline:
        """A number in millionths, with so many digits behind the point; None: all."""
        return self.scaled(path, plain if places is None else partial(to_places, places=places), power=6)

    def scaled(self, path: Path, show: Callable[[Decimal], Shown], *times: Factor, power: int = 0) -> Inline:
        """A number times others, times ten to the `power`."""
        value = self._product(path, times, power)
        return MISSING if value is None else Number(show(value), pointer(path), _named(times), power)

    def with_uncertainty(
        self, value: Path, u: Path, k: Path | None, *times: Factor, power: int = 0, digits: int = _DIGITS_ALONE
    ) -> tuple[Inline, Inline]:
        """A value and its uncertainty, u or k u, rounded alike, both as `scaled`. MISSING for a value that is not told;
        one without uncertainty has so many significant `digits`. What is scaled by a power of ten is shown without."""
        center, factors = self._product(value, times, power), times if k is None else (k, *times)
        if center is None:
            return MISSING, MISSING
        spread = self._product(u, factors, power)
        if spread is None:
            return Number(rounded(center, digits), pointer(value), _named(times), power), NO_UNCERTAINTY
        shown, by = to_match(center, spread, whole=power != 0)
        at_value, at_u = (pointer(value), _named(times)), (pointer(u), _named(factors))
        return Number(shown, *at_value, power), Number(by, *at_u, power)

    def _product(self, path: Path, times: tuple[Factor, ...], power: int) -> Decimal | None:
        """Exactly; None where one of them is not told."""
        found = Decimal(10**power)
        for one in (path, *times):
            factor = one if isinstance(one, Decimal) else self.decimal(*one)
            if factor is None:
                return None
            found = product(found, factor)
        return found


class Source(DocumentSource):
    """A result's document, and the same by its types, `solved`. Raises BadInput."""

    def __init__(self, document: dict[str, Any], name: str):
        super().__init__(document, name)
        self.solved = checked(Result, RESULT, document, name)


def _named(times: tuple[Factor, ...]) -> tuple[str, ...]:
    return tuple(str(one) if isinstance(one, Decimal) else pointer(one) for one in times)


def pointer(path: Path) -> str:
    """A path as RFC 6901 writes it."""
    return "".join("/" + str(key).replace("~", "~0").replace("/", "~1") for key in path)
