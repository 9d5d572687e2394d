"""What the subjects of `tumble plan` have in common: their options, and how these become a case to plan for."""

from __future__ import annotations

import argparse

from tumble.errors import UsageError, quoted

ESTIMATORS = ("averaged", "refined", "least_squares", "optimal")
PUBLISHED = "published"
DERIVED = "derived"
EXIT_CODES = "Exit codes: 0 done, 2 bad input, 130 interrupted."


def add_subject(subparsers, name: str, run, **texts: str) -> argparse.ArgumentParser:
    """A subject's parser, with the options that all have."""
    parser = subparsers.add_parser(name, **{"epilog": EXIT_CODES, **texts})
    parser.add_argument("--json", action="store_true", help="print one JSON document, schema tumble.plan/1")
    parser.set_defaults(run_command=run)
    return parser


def add_case_options(parser: argparse.ArgumentParser, default_estimator: str | None = "refined") -> None:
    """--stand, --schedule, and --estimator unless there is no choice of one (None)."""
    parser.add_argument("--stand", metavar="FILE", help="stand file (TOML); default: the paper's stand, equation (5)")
    parser.add_argument("--schedule", metavar="FILE", help="schedule file (TOML); default: the paper's 2 x 9 positions")
    if default_estimator is not None:
        parser.add_argument(
            "--estimator",
            choices=ESTIMATORS,
            default=default_estimator,
            metavar="NAME",
            help=f"averaged, refined, least_squares or optimal; default: {default_estimator}",
        )


def add_weights_option(parser: argparse.ArgumentParser) -> None:
    """--weights."""
    parser.add_argument(
        "--weights",
        choices=(PUBLISHED, DERIVED),
        default=DERIVED,
        help="derived: the estimator's own, on the exact geometry (default); published: the paper's Tables 1 and 4",
    )


def read_case(arguments: argparse.Namespace):
    """The planning.case.Case that the options describe. Raises TumbleError."""
    from tumble.planning.case import Case

    stand_file = schedule = None
    if arguments.stand is not None:
        from tumble.standfile import read_stand

        stand_file = read_stand(arguments.stand)
    if arguments.schedule is not None:
        from tumble.schedulefile import read_schedule

        schedule = read_schedule(arguments.schedule).data
    return Case.of(stand_file, arguments.stand, schedule)


def parse_positive(text: str, option: str) -> float:
    """A finite number above 0. Raises UsageError."""
    from math import isfinite

    from tumble.dialect import NUMBER

    value = float(text) if NUMBER.fullmatch(text) else 0.0
    if not (value > 0.0 and isfinite(value)):
        raise UsageError(f"{option}: {quoted(text)} is not a number above 0")
    return value


def write_json(document: dict) -> None:
    """Print a plan as JSON."""
    import sys

    from tumble.result import to_json

    sys.stdout.write(to_json(document))
