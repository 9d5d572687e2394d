"""What a report may say: the numbers and texts of a result's document, each with the path that it came from.

A path is that of RFC 6901 (JSON pointer), such as /K/0/1. It goes into the HTML with what it led to, so that every
number of a report can be held against the document.
"""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from typing import Any, TypeAlias

from tumble.documents.base import checked
from tumble.documents.result import RESULT, Result
from tumble.report import cells
from tumble.report.cells import MISSING, NO_UNCERTAINTY, Inline, Number, Shown, Text

Key: TypeAlias = "str | int"
Path: TypeAlias = "tuple[Key, ...]"
Factor: TypeAlias = "Path | Decimal"  # a number of the document, or one of the report's own
STANDARD_GRAVITY = Decimal("9.80665")  # m/s^2 (CGPM 1901); the local one differs from it by less than 0.5 %
_DIGITS_ALONE = 7  # of a value whose uncertainty is not known


class Source:
    """A document, and the same by its types, `solved`. `name`: what errors call it. Raises BadInput."""

    def __init__(self, document: dict[str, Any], name: str):
        self.document = document
        self.name = name
        self.solved = checked(Result, RESULT, document, name)

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

    def flag(self, *path: Key) -> bool | None:
        """True or false; None where nothing is said."""
        found: bool | None = self.at(*path)
        return found

    def decimal(self, *path: Key) -> Decimal | None:
        """A number; None where there is none."""
        found = self.at(*path)
        return None if found is None else cells.exact(found)

    def told(self, *path: Key) -> Inline:
        """A text or a number as it stands there."""
        found = self.at(*path)
        if found is None:
            return MISSING
        if isinstance(found, str):
            return Text(found, pointer(path))
        return self._number(path, cells.plain)

    def each(self, *path: Key) -> list[Inline]:
        """All of an array, as `told`."""
        return [self.told(*path, i) for i in range(len(self.array(*path)))]

    def rounded(self, digits: int, *path: Key) -> Inline:
        """A number with so many significant digits."""
        return self._number(path, lambda value: cells.rounded(value, digits))

    def to_places(self, places: int, *path: Key) -> Inline:
        """A number with so many digits behind the point."""
        return self._number(path, lambda value: cells.to_places(value, places))

    def millionths(self, places: int | None, *path: Key) -> Inline:
        """A number in millionths, with so many digits behind the point; None: all."""
        show = cells.plain if places is None else lambda value: cells.to_places(value, places)
        return self.scaled(path, show, power=6)

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
            return Number(cells.rounded(center, digits), pointer(value), _named(times), power), NO_UNCERTAINTY
        shown, by = cells.to_match(center, spread, whole=power != 0)
        at_value, at_u = (pointer(value), _named(times)), (pointer(u), _named(factors))
        return Number(shown, *at_value, power), Number(by, *at_u, power)

    def _product(self, path: Path, times: tuple[Factor, ...], power: int) -> Decimal | None:
        """Exactly; None where one of them is not told."""
        found = Decimal(10**power)
        for one in (path, *times):
            factor = one if isinstance(one, Decimal) else self.decimal(*one)
            if factor is None:
                return None
            found = cells.product(found, factor)
        return found

    def _number(self, path: tuple[Key, ...], show: Any) -> Inline:
        value = self.decimal(*path)
        return MISSING if value is None else Number(show(value), pointer(path))


def _named(times: tuple[Factor, ...]) -> tuple[str, ...]:
    return tuple(str(one) if isinstance(one, Decimal) else pointer(one) for one in times)


def pointer(path: Path) -> str:
    """A path as RFC 6901 writes it."""
    return "".join("/" + str(key).replace("~", "~0").replace("/", "~1") for key in path)
