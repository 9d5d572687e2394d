"""`tumble compare`: are two calibrations of one block the same?"""

from __future__ import annotations

import argparse
import sys

from tumble.cli import options
from tumble.defaults import ANEW, DEFAULT_CONFIDENCE, LEVELLED
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, UsageError
from tumble.messages import warn
from tumble.schedule import file_of


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Compare two calibrations of one block: the differences in units of their combined"
        " uncertainty, and whether the block has changed, only the way it sits, or neither."
    )
    parser.epilog = (
        "Exit codes: 0 the block has not changed (its seat may have), 1 it has, or this is unknown because a result"
        " has no uncertainties or failed its check, 2 bad input, 77 --plot cannot be drawn here, 130 interrupted."
    )
    parser.add_argument("a", metavar="RESULT_A.json", help="the earlier result")
    parser.add_argument("b", metavar="RESULT_B.json", help="the later one, in the same unit")
    parser.add_argument(
        "--stand",
        metavar="FILE",
        help="stand file (TOML) of the stand on which both were measured: errors that are the same in both runs"
        " are counted once; default: the stand that both results declare, if it is the same",
    )
    parser.add_argument(
        "--schedule",
        metavar="NAME",
        help="schedule file (TOML) of a result that has neither its schedule nor a built-in one; with --stand",
    )
    parser.add_argument(
        "--levelled",
        choices=LEVELLED,
        help="was the stand levelled once for both, or again before each? default: anew",
    )
    parser.add_argument(
        "--two-stands", action="store_true", help="the results are from two stands with equal declarations"
    )
    parser.add_argument(
        "--confidence",
        metavar="P",
        default=str(DEFAULT_CONFIDENCE),
        help=f"share of unchanged blocks that are called unchanged; default: {DEFAULT_CONFIDENCE}",
    )
    options.add(parser, "--json")
    parser.add_argument("--plot", metavar="FILE", help="draw the differences: .svg, .png or .pdf; needs matplotlib")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Compare and print. Returns the exit code; raises TumbleError."""
    confidence = options.parse_confidence(arguments.confidence)
    if arguments.schedule is not None and arguments.stand is None:
        raise UsageError("--schedule serves to tell what the stand brings to a result: it needs --stand FILE")
    if arguments.two_stands and (arguments.stand, arguments.levelled) != (None, None):
        raise UsageError("--two-stands: nothing is shared then, which --stand and --levelled speak of")

    from tumble.api.comparing import compared
    from tumble.comparison import report
    from tumble.documents.base import to_json
    from tumble.files.disk import refuse_overwriting, write_bytes

    inputs = arguments.a, arguments.b, arguments.stand, file_of(arguments.schedule)
    refuse_overwriting(arguments.plot, *inputs, option="--plot")
    if arguments.plot is not None:
        from tumble.pictures import require_format

        require_format(arguments.plot, "--plot")
    told = compared(
        arguments.a,
        arguments.b,
        arguments.stand,
        arguments.schedule,
        arguments.levelled or ANEW,
        arguments.two_stands,
        confidence,
    )
    if arguments.plot is not None:
        from tumble.pictures import comparison, written

        write_bytes(arguments.plot, written(comparison(told), arguments.plot))
    warn(told.warnings)
    sys.stdout.write(to_json(told) if arguments.json else report.render(told))
    return EXIT_PASS if told.verdict in ("unchanged", "seat") else EXIT_LIMITS_FAILED
