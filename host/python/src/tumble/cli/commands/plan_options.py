"""What the subjects of `tumble plan` have in common: their options, and how these become a case to plan for."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from tumble.cli.options import (
    Subparsers,
    add_estimator,
    add_limit,
    add_model,
    add_schedule,
    parse_limit,
    parse_number,
)
from tumble.errors import UsageError, quoted
from tumble.terms import parse

if TYPE_CHECKING:
    from tumble.documents.plan import Plan
    from tumble.planning.case import Case
    from tumble.terms import Terms

DEFAULT_PROBABILITY = 0.95
_LEAST_PROBABLE, _MOST_PROBABLE = 0.5, 0.9999  # few are served by less, and none is computed better than the last
PUBLISHED = "published"
DERIVED = "derived"
EXIT_CODES = "Exit codes: 0 done, 2 bad input, 130 interrupted."


def add_subject(
    subparsers: Subparsers, name: str, run: Callable[[argparse.Namespace], int], **texts: Any
) -> argparse.ArgumentParser:
    """A subject's parser, with the options that all have."""
    parser = subparsers.add_parser(name, **{"epilog": EXIT_CODES, **texts})
    parser.add_argument("--json", action="store_true", help="print one JSON document, schema tumble.plan/1")
    parser.set_defaults(run_command=run)
    return parser


def add_case_options(parser: argparse.ArgumentParser, choose_estimator: bool = True, extendable: bool = True) -> None:
    """--stand, --schedule, --limit, --model if further terms may be found, --estimator if there is a choice of one."""
    add_limit_options(parser)
    add_schedule(parser)
    if extendable:
        add_model(parser)
    if choose_estimator:
        add_estimator(parser)


def add_limit_options(parser: argparse.ArgumentParser) -> None:
    """--stand and --limit."""
    parser.add_argument("--stand", metavar="FILE", help="stand file (TOML); default: the paper's stand, equation (5)")
    add_limit(parser)


def add_probability(parser: argparse.ArgumentParser, what: str) -> None:
    """--probability."""
    about = f"{what}; {_LEAST_PROBABLE:g} to {_MOST_PROBABLE:g}, default: {DEFAULT_PROBABILITY:g}"
    parser.add_argument("--probability", metavar="P", help=about)


def parse_probability(text: str | None) -> float:
    """The value of --probability. Raises UsageError."""
    probability = DEFAULT_PROBABILITY if text is None else parse_number(text)
    if not _LEAST_PROBABLE <= probability <= _MOST_PROBABLE:
        allowed = f"{_LEAST_PROBABLE:g} to {_MOST_PROBABLE:g}"
        raise UsageError(f"--probability: {quoted(str(text))} is not a number from {allowed}")
    return probability


def add_weights_option(parser: argparse.ArgumentParser) -> None:
    """--weights."""
    parser.add_argument(
        "--weights",
        choices=(PUBLISHED, DERIVED),
        default=DERIVED,
        help="derived: the estimator's own, on the exact geometry (default); published: the paper's Tables 1 and 4",
    )


def read_case(arguments: argparse.Namespace) -> Case:
    """The planning.case.Case that the options describe. Raises TumbleError."""
    from tumble.planning.case import Case

    stand_file = schedule = None
    limit_g = parse_limit(arguments.limit)
    if arguments.stand is not None:
        from tumble.files.stand_file import read_stand

        stand_file = read_stand(arguments.stand)
    if getattr(arguments, "schedule", None) is not None:
        from tumble.files.schedule_file import read_schedule

        derived = getattr(arguments, "weights", DERIVED) == DERIVED
        estimator = getattr(arguments, "estimator", None) if derived else None
        schedule = read_schedule(arguments.schedule, estimator=estimator).data
    case = replace(Case.of(stand_file, arguments.stand, schedule), terms=_terms(arguments))
    if case.terms and hasattr(arguments, "schedule"):
        from tumble.solving.further import require_told_apart

        require_told_apart(case.schedule, case.terms)
    return case if limit_g is None else replace(case, limit_g=limit_g)


def _terms(arguments: argparse.Namespace) -> Terms:
    """Of --model. Raises UsageError."""
    text = getattr(arguments, "model", None)
    if text is not None and getattr(arguments, "weights", DERIVED) == PUBLISHED:
        raise UsageError("--model: the paper's weights are for twelve coefficients (--weights derived)")
    return parse(text, getattr(arguments, "estimator", None))


def parse_positive(text: str, option: str) -> float:
    """A finite number above 0. Raises UsageError."""
    value = parse_number(text)
    if not 0.0 < value < math.inf:
        raise UsageError(f"{option}: {quoted(text)} is not a number above 0")
    return value


def write_json(plan: Plan) -> None:
    """Print a plan as JSON."""
    import sys

    from tumble.documents.base import to_json

    sys.stdout.write(to_json(plan))
