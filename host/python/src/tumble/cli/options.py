"""What several commands have in common: their options, and how the words given become values."""

from __future__ import annotations

import argparse
import math
import re
from typing import TYPE_CHECKING, TypeAlias

from tumble.defaults import DEFAULT_CONFIDENCE, DEFAULT_ESTIMATOR, DEFAULT_LIMIT_G
from tumble.errors import UsageError, quoted
from tumble.estimators import ESTIMATORS
from tumble.schedule import BUILT_IN

if TYPE_CHECKING:
    from tumble.files.run_layout import Wishes

Subparsers: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"  # in quotes: no generic when it runs

FIRMWARES = ("host", "zcu102")
LARGEST_SEED = 2**64 - 1
_DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "\\t": "\t"}


def add_subjects(subparsers: Subparsers, name: str, about: str, description: str = "") -> Subparsers:
    """A command that is nothing without a subject. Returns the subparsers of these. `description`: if it is not what
    `about` says."""
    said = description or f"{about[0].upper()}{about[1:]}."
    parser = subparsers.add_parser(name, help=about, description=said)
    return parser.add_subparsers(metavar="SUBJECT", required=True)


def add_schedule(parser: argparse.ArgumentParser) -> None:
    """--schedule."""
    names = ", ".join(BUILT_IN[1:])
    about = f"{names}, or a schedule file (TOML); default: paper, its 2 x 9 positions"
    parser.add_argument("--schedule", metavar="NAME", help=about)


def add_estimator(parser: argparse.ArgumentParser, remark: str = "") -> None:
    """--estimator."""
    parser.add_argument(
        "--estimator",
        choices=ESTIMATORS,
        default=DEFAULT_ESTIMATOR,
        metavar="NAME",
        help=f"{', '.join(ESTIMATORS[:-1])} or {ESTIMATORS[-1]}; default: {DEFAULT_ESTIMATOR}{remark}",
    )


def add_limit(parser: argparse.ArgumentParser) -> None:
    """--limit."""
    parser.add_argument(
        "--limit",
        metavar="G",
        help=f"limit of the gravity check in g; default: the stand file's, else {DEFAULT_LIMIT_G:g}",
    )


def add_confidence(parser: argparse.ArgumentParser) -> None:
    """--confidence."""
    parser.add_argument(
        "--confidence",
        metavar="P",
        default=str(DEFAULT_CONFIDENCE),
        help=f"at which the run must fit its stand; default: {DEFAULT_CONFIDENCE}",
    )


def add_firmware(parser: argparse.ArgumentParser, remark: str = "") -> None:
    """--firmware."""
    parser.add_argument("--firmware", choices=FIRMWARES, default=FIRMWARES[0], help=f"{remark}default: {FIRMWARES[0]}")


def add_seed(parser: argparse.ArgumentParser, remark: str = "") -> None:
    """--seed."""
    parser.add_argument("--seed", metavar="N", default="1", help=f"0 to 2^64 - 1{remark}; default: 1")


def add_json(parser: argparse.ArgumentParser) -> None:
    """--json, of a command that gives a result."""
    parser.add_argument("--json", action="store_true", help="print the result as one JSON document")


def add_layout(parser: argparse.ArgumentParser, file: str) -> argparse._ArgumentGroup:
    """--columns, --delimiter, --decimal, of a table in a `file`. Returns their group."""
    layout = parser.add_argument_group(f"layout of {file}", "detected, unless given")
    layout.add_argument("--columns", metavar="NAME=COLUMN,...", help="names of its columns, such as ux=AccX,uy=AccY")
    layout.add_argument("--delimiter", metavar="SIGN", help="comma, semicolon, tab or another sign")
    layout.add_argument("--decimal", choices=(".", ","), help="decimal mark")
    return layout


def wishes(arguments: argparse.Namespace, unit: str | None, known: tuple[str, ...] = ()) -> Wishes:
    """What the options of add_layout say, and the `unit` of the outputs, if it is given. `known`: the columns that are
    wanted; empty for a run's. Raises UsageError."""
    from tumble.files.run_layout import COLUMNS, TEMPERATURE, Wishes

    wanted, named = known or COLUMNS, known or (*COLUMNS, TEMPERATURE)
    return Wishes(
        columns={}
        if arguments.columns is None
        else _parse_columns(arguments.columns, known or (*COLUMNS, TEMPERATURE)),
        delimiter=None if arguments.delimiter is None else _parse_delimiter(arguments.delimiter),
        decimal=arguments.decimal,
        unit=None if unit is None else _parse_unit(unit),
        wanted=wanted,
    )


def parse_limit(text: str | None) -> float | None:
    """The value of --limit, g; None without one. Raises UsageError."""
    if text is None:
        return None
    limit_g = parse_number(text)
    if not 0.0 < limit_g <= 1.0:
        raise UsageError(f"--limit: {quoted(text)} is not a number of g above 0, at most 1")
    return limit_g


def parse_confidence(text: str) -> float:
    """The value of --confidence. Raises UsageError."""
    confidence = parse_number(text)
    if not 0.5 <= confidence <= 0.999999:
        raise UsageError(f"--confidence: {quoted(text)} is not a number from 0.5 to 0.999999")
    return confidence


def parse_seed(text: str) -> int:
    """The value of --seed. Raises UsageError."""
    return parse_whole(text, "--seed", 0, LARGEST_SEED)


def parse_whole(text: str, option: str, low: int, high: int) -> int:
    """The value of an option, a whole number of a range. Raises UsageError."""
    if re.fullmatch(r"[0-9]{1,20}", text, re.ASCII) and low <= int(text) <= high:
        return int(text)
    raise UsageError(f"{option}: {quoted(text)} is not a whole number from {low} to {high}")


def parse_number(text: str) -> float:
    """A number as run files have it, not a number where it is none: outside every range."""
    from tumble.files.run_layout import NUMBER

    return float(text) if NUMBER.fullmatch(text) else math.nan


def _parse_columns(text: str, known: tuple[str, ...]) -> dict[str, str]:
    """Read `ux=AccX,uy=AccY`."""
    columns = {}
    for part in text.split(","):
        wanted, equals, name = (piece.strip() for piece in part.partition("="))
        if not equals or wanted not in known or not name or wanted in columns:
            listed = ", ".join(known)
            raise UsageError(f"--columns: {quoted(part)} is not NAME=COLUMN with NAME one of {listed}, once each")
        columns[wanted] = name
    return columns


def _parse_delimiter(text: str) -> str:
    """Read one character, or comma, semicolon, tab."""
    delimiter = _DELIMITERS.get(text.lower(), text)
    if len(delimiter) != 1 or delimiter in '"#\r\n.+-' or delimiter.isalnum():
        raise UsageError(f"--delimiter: {quoted(text)} is not comma, semicolon, tab or another single sign")
    return delimiter


def _parse_unit(text: str) -> str:
    """Read a unit such as V, mV or m/s^2: up to 16 letters, digits and / ^ . _ + - signs."""
    from tumble.units import UNIT

    if not UNIT.fullmatch(text) or text != text.strip():
        raise UsageError(f"--unit: {quoted(text)} is not a unit such as V, mV or m/s^2")
    return text
