"""`tumble export`: the coefficients of a result for other programs (tumble.report.coefficients)."""

from __future__ import annotations

import argparse
import math
import sys

from tumble.cli import options
from tumble.errors import EXIT_PASS, BadInput, TumbleError, UsageError, listed
from tumble.messages import warn
from tumble.report.coefficients import DOUBLE, FIXED, FORCE_UNITS, FORMATS, MOST_ACCELEROMETERS, NUMBERS, exported
from tumble.units import SI, force_unit


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = "Write the coefficients of a result, each with its unit and its standard uncertainty."
    parser.epilog = "Exit codes: 0 done, 2 bad input, 130 interrupted."
    parser.add_argument("result", metavar="RESULT.json", help="a result of tumble solve")
    parser.add_argument(
        "--format",
        choices=FORMATS,
        required=True,
        help="; ".join(f"{name}: {one.about}" for name, one in FORMATS.items()),
    )
    for_si = listed([name for name, one in FORMATS.items() if one.unit == SI])
    parser.add_argument(
        "--unit",
        type=force_unit,
        choices=FORCE_UNITS,
        help=f"of accelerations; m/s2 needs gravity_m_s2 in the result's environment; default: g, for {for_si} m/s2",
    )
    parser.add_argument(
        "--number", choices=NUMBERS, default=DOUBLE, help="what the C header computes with; default: double"
    )
    parser.add_argument(
        "--accelerometer", metavar="N", help=f"of an autopilot, 1 to {MOST_ACCELEROMETERS}; default: 1, its first"
    )
    parser.add_argument("--step", metavar="SIZE", help="of one count of the outputs, in their unit; for fixed")
    parser.add_argument(
        "--labels",
        action="store_true",
        help="also serial number, run file's name, labels of [item] and [environment]; default: none; dcc: all",
    )
    parser.add_argument("--certificate-number", metavar="TEXT", help="of a dcc; default: as of report")
    parser.add_argument("--issued", metavar="DATE", help="of issue of a dcc; default: that of the result")
    parser.add_argument("--out", metavar="FILE", help="default: standard output")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Convert and write. Returns the exit code; raises TumbleError."""
    step, number = _parse_step(arguments), _parse_accelerometer(arguments)
    for option in ("certificate_number", "issued"):
        if arguments.format != "dcc" and getattr(arguments, option) is not None:
            raise UsageError(f"--{option.replace('_', '-')}: is for --format dcc")

    from tumble.api.thermal import is_thermal, load_thermal
    from tumble.documents.result import read_result
    from tumble.files.disk import refuse_overwriting, write_text
    from tumble.report import thermal
    from tumble.solving.decision import complaints_of_result

    refuse_overwriting(arguments.out, arguments.result)
    options.require_ending(arguments.out, "--out", *FORMATS[arguments.format].endings)
    try:
        if is_thermal(arguments.result):
            if arguments.unit == SI:
                raise ValueError("over temperature for g alone: leave out --unit")
            if arguments.number == FIXED:
                raise ValueError("over temperature in double or float, for g alone")
            warm = load_thermal(arguments.result)
            text, warnings = thermal.exported(warm.checked, arguments.format, arguments.number, number), warm.complaints
        else:
            result = read_result(arguments.result)
            warnings = complaints_of_result(result)
            told = arguments.format, arguments.unit, arguments.number, step, arguments.labels, warnings, number
            text = exported(result, *told, arguments.certificate_number, arguments.issued)
    except TumbleError:
        raise
    except ValueError as error:
        raise BadInput(str(error), arguments.result) from None
    warn(warnings, arguments.result)
    if arguments.out is None:
        sys.stdout.write(text)
    else:
        write_text(arguments.out, text)
    return EXIT_PASS


def _parse_step(arguments: argparse.Namespace) -> float | None:
    """The value of --step. Raises UsageError."""
    if arguments.number != DOUBLE and arguments.format != "c":
        raise UsageError(f"--number {arguments.number}: is for --format c")
    if (arguments.step is None) == (arguments.number == FIXED):
        raise UsageError("--number fixed and --step SIZE belong together: a count of the outputs has a size")
    if arguments.step is None:
        return None
    return options.parse_number(arguments.step, "--step", options.ABOVE_0, math.nextafter(1e9, 0.0), "a size above 0")


def _parse_accelerometer(arguments: argparse.Namespace) -> int:
    """The value of --accelerometer. Raises UsageError."""
    if FORMATS[arguments.format].scales is None:
        if arguments.accelerometer is not None:
            raise UsageError("--accelerometer: is for the parameters of an autopilot")
        return 1
    if arguments.unit == "g":
        raise UsageError(f"--unit g: the parameters of {arguments.format} are in m/s^2")
    return options.parse_whole(arguments.accelerometer or "1", "--accelerometer", 1, MOST_ACCELEROMETERS)
