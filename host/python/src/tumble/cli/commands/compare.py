"""`tumble compare`: are two calibrations of one block the same?"""

from __future__ import annotations

import argparse
import sys

from tumble.cli import options
from tumble.defaults import DEFAULT_CONFIDENCE
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, UsageError
from tumble.schedule import file_of

LEVELLED = ("once", "anew")


def add_to(subparsers: options.Subparsers) -> None:
    """Describe the command to argparse."""
    parser = subparsers.add_parser(
        "compare",
        help="two results of one block: has it changed, or only its seat?",
        description="Hold two calibrations of one block against each other: the differences in units of their combined"
        " uncertainty, and whether the block has changed, only the way it sits, or neither.",
        epilog="Exit codes: 0 the block has not changed (its seat may have), 1 it has, or a result has no uncertainties"
        " and nobody can tell, 2 bad input, 77 --plot cannot be drawn here, 130 interrupted.",
    )
    parser.add_argument("a", metavar="RESULT_A.json", help="the earlier result")
    parser.add_argument("b", metavar="RESULT_B.json", help="the later one, in the same unit")
    parser.add_argument(
        "--stand",
        metavar="FILE",
        help="stand file (TOML) of the one stand that both were measured on: what it repeats is counted once",
    )
    parser.add_argument(
        "--schedule",
        metavar="NAME",
        help="schedule file (TOML) that they were measured by, where it is none of the built-in ones; with --stand",
    )
    parser.add_argument(
        "--levelled",
        choices=LEVELLED,
        help="was the stand levelled once for both, or anew before each (default)? With --stand",
    )
    parser.add_argument(
        "--confidence",
        metavar="P",
        default=str(DEFAULT_CONFIDENCE),
        help=f"of calling a block unchanged that is; default: {DEFAULT_CONFIDENCE}",
    )
    options.add_json(parser)
    parser.add_argument("--plot", metavar="FILE", help="draw the differences: .svg, .png or .pdf; needs matplotlib")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Compare and print. Returns the exit code; raises TumbleError."""
    confidence = options.parse_confidence(arguments.confidence)
    for option in ("schedule", "levelled"):
        if arguments.stand is None and getattr(arguments, option) is not None:
            raise UsageError(f"--{option} says something of the stand of both: it needs --stand FILE")

    from tumble.api.comparing import compare
    from tumble.cli.output import warn
    from tumble.files.disk import refuse_overwriting

    refuse_overwriting(arguments.plot, arguments.a, arguments.b, arguments.stand, file_of(arguments.schedule))
    found = compare(
        arguments.a,
        arguments.b,
        stand=arguments.stand,
        schedule=arguments.schedule,
        levelled=arguments.levelled or "anew",
        confidence=confidence,
    )
    warn(found.warnings)
    sys.stdout.write(found.to_json() if arguments.json else found.text)
    return EXIT_PASS if found.block_changed is False else EXIT_LIMITS_FAILED
