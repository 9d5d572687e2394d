"""Options that say how a file of samples is laid out, of every command that reads one."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING

from tumble.errors import UsageError, quoted

if TYPE_CHECKING:
    from tumble.files.run_layout import Wishes

_DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "\\t": "\t", "space": " "}


def add_layout(
    parser: argparse.ArgumentParser, what: str, example: str = "ux=AccX,uy=AccY", has_unit: bool = True
) -> argparse._ArgumentGroup:
    """--columns, --delimiter, --decimal, and if it `has_unit` --unit, of `what`. Returns their group."""
    layout = parser.add_argument_group(f"layout of the {what}", "detected, unless given")
    layout.add_argument("--columns", metavar="NAME=COLUMN,...", help=f"names of its columns, such as {example}")
    layout.add_argument("--delimiter", metavar="SIGN", help="comma, semicolon, tab or another sign")
    layout.add_argument("--decimal", choices=(".", ","), help="decimal mark")
    if has_unit:
        layout.add_argument("--unit", help="unit of the outputs; default: the one in brackets in the header, else V")
    return layout


def wishes(arguments: argparse.Namespace, names: Sequence[str], has_unit: bool = True) -> Wishes:
    """What the options say about the layout, with columns of these names. Raises UsageError."""
    from tumble.files.run_layout import Wishes

    return Wishes(
        columns={} if arguments.columns is None else _parse_columns(arguments.columns, names),
        delimiter=None if arguments.delimiter is None else _parse_delimiter(arguments.delimiter),
        decimal=arguments.decimal,
        unit=_parse_unit(arguments.unit) if has_unit and arguments.unit is not None else None,
    )


def _parse_columns(text: str, names: Sequence[str]) -> dict[str, str]:
    """Read `ux=AccX,uy=AccY`."""
    columns = {}
    for part in text.split(","):
        wanted, equals, name = (piece.strip() for piece in part.partition("="))
        if not equals or wanted not in names or not name or wanted in columns:
            known = ", ".join(names)
            raise UsageError(f"--columns: {quoted(part)} is not NAME=COLUMN with NAME one of {known}, once each")
        columns[wanted] = name
    return columns


def _parse_delimiter(text: str) -> str:
    """Read one character, or comma, semicolon, tab."""
    from tumble.files.run_layout import is_delimiter

    delimiter = _DELIMITERS.get(text.lower(), text)
    if not is_delimiter(delimiter):
        raise UsageError(f"--delimiter: {quoted(text)} is not comma, semicolon, tab or another single sign")
    return delimiter


def _parse_unit(text: str) -> str:
    """Read a unit such as V, mV or m/s^2: up to 16 letters, digits and / ^ . _ + - signs."""
    from tumble.units import is_unit, spelled

    if not is_unit(spelled(text)):
        raise UsageError(f"--unit: {quoted(text)} is not a unit such as V, mV or m/s^2")
    return spelled(text)
