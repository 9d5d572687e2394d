"""TOML files read strictly: every key known, every value of the right type and range, every complaint with its row."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterable
from typing import Any

from tumble.errors import BadInput, quoted
from tumble.files.disk import TOML, kind_of, read_bytes
from tumble.stand import PerChannel, by_channel, per_channel

_HEADER = re.compile(r"^\s*(\[\[?)\s*([\w.\s\"'-]+?)\s*\]\]?\s*(?:#.*)?$")
_KEY = re.compile(r"^\s*([\w.\"'-]+(?:\s*\.\s*[\w\"'-]+)*)\s*=")
_PLACE = re.compile(r"\s*\(at line (\d+), column (\d+)\)")
_NO_NUMBER = re.compile(r"^[^=]*=\s*[-+]?[\d.]+(?:,\d|[eE][-+]?\d+\s+\w|\s+[A-Za-z])")
_REQUIRED: Any = object()

Path = tuple[str | int, ...]


def read_toml(file: str, data: bytes | None = None) -> Table:
    """The top-level table of a TOML file; `data`: what is in it, if that has been read. Raises BadInput."""
    data = read_bytes(file) if data is None else data
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise BadInput("not UTF-8 text", file, data.count(b"\n", 0, error.start) + 1) from None
    if sys.version_info >= (3, 11):
        from tomllib import loads
    else:
        from tomli import loads
    try:
        values = loads(text)
    except ValueError as error:
        if (kind := kind_of(data)) not in (None, TOML):
            raise BadInput(f"is {kind}; TOML is expected, such as a stand or a schedule file", file) from None
        place = _PLACE.search(str(error))
        row, column = place.groups() if place else (text.count("\n") + 1, None)
        message = _PLACE.sub("", str(error)).removesuffix(" (at end of document)")
        line = text.split("\n")[min(int(row), text.count("\n") + 1) - 1]
        hint = "; a number has a decimal point and no unit" if _NO_NUMBER.match(line) else ""
        raise BadInput(f"not valid TOML: {message.lower()}{hint}", file, int(row), column) from None
    except RecursionError:
        raise BadInput("not valid TOML: nested too deeply", file, 1) from None
    return Table(file, values, (), _rows(text))


def _rows(text: str) -> dict[Path, int]:
    """The row of every table and key, by path: a table's name, an index in an array of tables, a key."""
    rows: dict[Path, int] = {}
    path: Path = ()
    counts: dict[str, int] = {}
    for row, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            path = _path(header[2])
            if header[1] == "[[":
                counts[header[2]] = counts.get(header[2], -1) + 1
                path += (counts[header[2]],)
            rows.setdefault(path, row)
        elif key := _KEY.match(line):
            rows.setdefault(path + _path(key[1]), row)
    return rows


def _path(dotted: str) -> tuple[str, ...]:
    return tuple(part.strip().strip("\"'") for part in dotted.split("."))


class Table:
    """One table of a file. `only` refuses unknown keys, each getter checks one value. All raise BadInput."""

    def __init__(self, file: str, values: dict[str, Any], path: Path, rows: dict[Path, int]):
        self.file = file
        self._values = values
        self._path = path
        self._rows = rows

    @property
    def name(self) -> str:
        """How the file writes this table, such as [stand] or [[position]]."""
        names = ".".join(part for part in self._path if isinstance(part, str))
        return f"[[{names}]]" if self._path and isinstance(self._path[-1], int) else f"[{names}]"

    @property
    def keys(self) -> frozenset[str]:
        """The names of what is in it."""
        return frozenset(self._values)

    def refuse(self, message: str, key: str | None = None) -> BadInput:
        """An error about this table, or about one of its keys."""
        where = (self._path,) if key is None else ((*self._path, key), (*self._path, key, 0), self._path)
        row = next((self._rows[path] for path in where if path in self._rows), None)
        prefix = f"{self.name} " if self._path else ""
        return BadInput(f"{prefix}{'' if key is None else key + ' '}{message}", self.file, row)

    def only(self, *known: str) -> Table:
        """This table, if it has no other keys than these."""
        unknown = next((key for key in self._values if key not in known), None)
        if unknown is None:
            return self
        import difflib

        close = difflib.get_close_matches(unknown, known, n=1, cutoff=0.7)
        hint = f"; is {close[0]} meant? (a name states its unit)" if close else ""
        place = f" in {self.name}" if self._path else ""
        row = self._rows.get((*self._path, unknown))
        raise BadInput(f"unknown key {quoted(unknown)}{place}{hint}", self.file, row)

    def _get(self, key: str, default: Any, kind: str, is_kind: Callable[[Any], bool]) -> Any:
        if key not in self._values:
            if default is _REQUIRED:
                raise self.refuse(f"has no {key}" if self._path else f"no {key}")
            return default
        value = self._values[key]
        if not is_kind(value):
            raise self.refuse(f"must be {kind}, not {quoted(value)}", key)
        return value

    def number(self, key: str, low: float = -math.inf, high: float = math.inf, default: Any = _REQUIRED) -> float:
        """A finite number within low..high."""
        value: float = self._get(key, default, "a number", _is_number)
        if value is not default and not (math.isfinite(value) and low <= value <= high):
            raise self.refuse(f"must be {_range(low, high)}, not {quoted(value)}", key)
        return value if value is default else float(value)

    def per_channel(
        self, key: str, low: float = -math.inf, high: float = math.inf, default: Any = _REQUIRED
    ) -> PerChannel:
        """A finite number within low..high, for all channels, or an array of three, one for each."""
        if not isinstance(self._values.get(key), list):
            return self.number(key, low, high, default)
        value = self._get(key, default, "a number or three of them", lambda v: _is_vector(v, 3))
        if not all(low <= one <= high for one in value):
            raise self.refuse(f"must be {_range(low, high)} in each channel, not {quoted(value)}", key)
        return per_channel(by_channel(value))

    def integer(self, key: str, low: int, high: int, default: Any = _REQUIRED) -> int:
        """A whole number within low..high."""
        value: int = self._get(key, default, "a whole number", lambda v: type(v) is int)
        if value is not default and not low <= value <= high:
            raise self.refuse(f"must be {_range(low, high)}, not {quoted(value)}", key)
        return value

    def text(self, key: str, default: Any = _REQUIRED) -> str:
        """A text of one line."""
        value: str = self._get(key, default, "a text of one line", lambda v: isinstance(v, str) and v.isprintable())
        return value

    def texts(self, key: str) -> list[str]:
        """Texts of one line, one or an array of them; none where the key is missing."""
        if not isinstance(self._values.get(key), list):
            return [self.text(key)] if key in self._values else []
        texts: list[str] = self._get(
            key, _REQUIRED, "a text of one line or several",
            lambda v: all(isinstance(one, str) and one.isprintable() for one in v),
        )  # fmt: skip
        return texts

    def choice(self, key: str, options: Iterable[str], default: Any = _REQUIRED) -> str:
        """One of several words."""
        listed = " or ".join(f'"{option}"' for option in options)
        value: str = self._get(key, default, listed, lambda v: isinstance(v, str) and v in options)
        return value

    def vector(self, key: str, length: int) -> tuple[float, ...]:
        """Finite numbers, so many of them."""
        value = self._get(key, _REQUIRED, f"{length} numbers", lambda v: _is_vector(v, length))
        return tuple(map(float, value))

    def numbers(self, key: str, fewest: int, most: int) -> tuple[float, ...]:
        """Finite numbers, from `fewest` to `most` of them."""
        value = self._get(
            key, _REQUIRED, f"{fewest} to {most} numbers",
            lambda v: isinstance(v, list) and fewest <= len(v) <= most and _is_vector(v, len(v)),
        )  # fmt: skip
        return tuple(map(float, value))

    def matrix(self, key: str) -> tuple[tuple[float, ...], ...]:
        """3 x 3 finite numbers."""
        value = self._get(
            key, _REQUIRED, "3 rows of 3 numbers",
            lambda v: isinstance(v, list) and len(v) == 3 and all(_is_vector(row, 3) for row in v),
        )  # fmt: skip
        return tuple(tuple(map(float, row)) for row in value)

    def labels(self) -> dict[str, str | int | float]:
        """Every key with a text, a number or a date (as text): something to be carried along."""
        found: dict[str, str | int | float] = {}
        for key, value in self._values.items():
            if hasattr(value, "isoformat"):
                found[key] = value.isoformat()
            elif isinstance(value, str) or (_is_number(value) and math.isfinite(value)):
                found[key] = value
            else:
                raise self.refuse(f"must be a text, a number or a date, not {quoted(value)}", key)
        return found

    def table(self, key: str) -> Table | None:
        """A table inside this one, or None."""
        value = self._get(key, None, "a table", lambda v: isinstance(v, dict))
        return None if value is None else Table(self.file, value, (*self._path, key), self._rows)

    def tables(self, key: str) -> list[Table]:
        """An array of tables, [[key]], at least one."""
        value = self._get(
            key, _REQUIRED, f"tables, [[{key}]]",
            lambda v: isinstance(v, list) and bool(v) and all(isinstance(row, dict) for row in v),
        )  # fmt: skip
        return [Table(self.file, row, (*self._path, key, index), self._rows) for index, row in enumerate(value)]


def _is_number(value: Any) -> bool:
    return type(value) is float or (type(value) is int and abs(value) < 2**63)


def _is_vector(value: Any, length: int) -> bool:
    numbers = isinstance(value, list) and len(value) == length and all(_is_number(item) for item in value)
    return numbers and all(math.isfinite(item) for item in value)


def _range(low: float, high: float) -> str:
    if math.isfinite(low) and math.isfinite(high):
        return f"{low:g} to {high:g}"
    return f"at least {low:g}" if math.isfinite(low) else "a finite number"
