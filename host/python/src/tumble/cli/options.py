"""What several commands have in common: their options, and how the words given become values."""

from __future__ import annotations

import argparse
import math
import os
import re
from typing import TypeAlias

from tumble.defaults import DEFAULT_CONFIDENCE, DEFAULT_ESTIMATOR, DEFAULT_LIMIT_G
from tumble.errors import UsageError, quoted
from tumble.estimators import ESTIMATORS
from tumble.schedule import BUILT_IN
from tumble.terms import EXTENDABLE, TERMS

Subparsers: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"  # in quotes: no generic when it runs
Options: TypeAlias = "argparse._ActionsContainer"  # a parser, or a group of options in one

FIRMWARES = ("host", "zcu102")
_PROMISING = frozenset(
    ".c .csv .h .htm .html .jpeg .jpg .json .m .mat .md .npz .parquet .pdf .png .pq .svg .toml .tsv .xls .xlsx .xml"
    " .yaml .yml".split()
)  # endings that say what is in a file
LARGEST_SEED = 2**64 - 1


def add_subjects(subparsers: Subparsers, name: str, about: str, description: str = "") -> Subparsers:
    """A command that is nothing without a subject. Returns the subparsers of these. `description`: if it is not what
    `about` says."""
    said = description or f"{about[0].upper()}{about[1:]}."
    parser = subparsers.add_parser(name, help=about, description=said)
    return parser.add_subparsers(metavar="SUBJECT", required=True)


def add_schedule(parser: Options) -> None:
    """--schedule."""
    names = ", ".join(BUILT_IN[1:])
    about = f"{names}, or a schedule file (TOML); default: paper, its 2 x 9 positions"
    parser.add_argument("--schedule", metavar="NAME", help=about)


def add_estimator(parser: Options, remark: str = "") -> None:
    """--estimator."""
    parser.add_argument(
        "--estimator",
        choices=ESTIMATORS,
        default=DEFAULT_ESTIMATOR,
        metavar="NAME",
        help=f"{', '.join(ESTIMATORS[:-1])} or {ESTIMATORS[-1]}; default: {DEFAULT_ESTIMATOR}{remark}",
    )


def add_model(parser: Options) -> None:
    """--model."""
    parser.add_argument(
        "--model",
        metavar="TERM,...",
        help=f"further terms to find: {', '.join(TERMS)} (second and third order, drift over the run); needs"
        f" --estimator {' or '.join(EXTENDABLE)}",
    )


def refuse_model(parser: argparse.ArgumentParser, why: str) -> None:
    """--model, where it makes no sense."""

    class Refuse(argparse.Action):
        def __call__(self, *_: object) -> None:
            raise UsageError(f"--model: {why}")

    parser.add_argument("--model", action=Refuse, help=argparse.SUPPRESS)


def add_limit(parser: Options) -> None:
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


def add_firmware(parser: Options, remark: str = "") -> None:
    """--firmware."""
    parser.add_argument("--firmware", choices=FIRMWARES, default=FIRMWARES[0], help=f"{remark}default: {FIRMWARES[0]}")


def add_seed(parser: Options, remark: str = "") -> None:
    """--seed."""
    parser.add_argument("--seed", metavar="N", default="1", help=f"0 to 2^64 - 1{remark}; default: 1")


def add_json(parser: Options) -> None:
    """--json, of a command that gives a result."""
    parser.add_argument("--json", action="store_true", help="print the result as one JSON document")


def require_ending(file: str | None, option: str, *endings: str) -> None:
    """Raise UsageError for an output, given by `option`, whose name promises another format than those that are written
    under `endings`. A name that promises none is taken as it is."""
    ending = "" if file is None else os.path.splitext(file)[1].lower()
    if ending in _PROMISING and ending not in endings:
        listed = " or ".join([", ".join(endings[:-1]), endings[-1]] if len(endings) > 1 else endings)
        raise UsageError(f"{option}: {quoted(file)} does not end in {listed}")


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
