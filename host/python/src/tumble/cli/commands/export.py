"""`tumble export`: the coefficients of a result in the formats of other programs."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from tumble.cli.options import Subparsers, parse_number, require_ending
from tumble.errors import EXIT_PASS, BadInput, UsageError, file_name, quoted
from tumble.messages import tell
from tumble.units import SI, force_unit

if TYPE_CHECKING:
    from tumble.documents.result import Result

FORMATS = {  # and how the names of their files end
    "c": (".h", ".c"),
    "csv": (".csv",),
    "matlab": (".m",),
    "ros": (".yaml", ".yml"),
    "imucal": (".json",),
}
_FOR_SI = ("ros", "imucal")  # which take accelerations in m/s^2
_NUMBERS = ("double", "float", "fixed")


def add_to(subparsers: Subparsers, about: str) -> None:
    """Describe the command to argparse."""
    parser = subparsers.add_parser(
        "export",
        help=about,
        description="Write the coefficients of a result, each with its unit and its standard uncertainty.",
        epilog="Exit codes: 0 done, 2 bad input, 130 interrupted.",
    )
    parser.add_argument("result", metavar="RESULT.json", help="a result of tumble solve")
    parser.add_argument(
        "--format",
        choices=FORMATS,
        required=True,
        help="c: a header; csv: one row a coefficient; matlab: a script; ros: YAML of imu_calib; imucal: its JSON",
    )
    parser.add_argument(
        "--unit",
        type=force_unit,
        choices=("g", SI),
        help="of accelerations; m/s2 needs gravity_m_s2 in the result's environment; default: g, for ros and imucal"
        " m/s2",
    )
    parser.add_argument(
        "--number", choices=_NUMBERS, default=_NUMBERS[0], help="what the C header computes with; default: double"
    )
    parser.add_argument("--step", metavar="SIZE", help="of one count of the outputs, in their unit; for fixed")
    parser.add_argument(
        "--labels",
        action="store_true",
        help="also the block's serial number, the run file's name, labels of [item] and [environment]; default: none",
    )
    parser.add_argument("--out", metavar="FILE", help="default: standard output")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Convert and write. Returns the exit code; raises TumbleError."""
    step = _parse_step(arguments)

    from tumble.api.complaints import complaints_of_document
    from tumble.cli import exports
    from tumble.documents.result import read_result
    from tumble.files.disk import refuse_overwriting, write_text

    refuse_overwriting(arguments.out, arguments.result)
    require_ending(arguments.out, "--out", *FORMATS[arguments.format])
    result = read_result(arguments.result)
    try:
        text = _converted(result if arguments.labels else exports.unlabelled(result), arguments, step)
    except ValueError as error:
        raise BadInput(str(error), arguments.result) from None
    for warning in complaints_of_document(result):
        tell(f"tumble: warning: {file_name(arguments.result)}: {warning}")
    if arguments.out is None:
        sys.stdout.write(text)
    else:
        write_text(arguments.out, text)
    return EXIT_PASS


def _parse_step(arguments: argparse.Namespace) -> float | None:
    """The value of --step. Raises UsageError."""
    if arguments.number != _NUMBERS[0] and arguments.format != "c":
        raise UsageError(f"--number {arguments.number}: is for --format c")
    if (arguments.step is None) == (arguments.number == "fixed"):
        raise UsageError("--number fixed and --step SIZE belong together: a count of the outputs has a size")
    if arguments.step is None:
        return None
    step = parse_number(arguments.step)
    if not 0.0 < step < 1e9:
        raise UsageError(f"--step: {quoted(arguments.step)} is not a size above 0")
    return step


def _converted(result: Result, arguments: argparse.Namespace, step: float | None) -> str:
    from tumble.cli import exports, foreign_exports

    name = arguments.format
    unit = arguments.unit or ("m/s2" if name in _FOR_SI else "g")
    if name == "c":
        return exports.to_c(result, unit, arguments.number, step)
    writers = {
        "csv": exports.to_csv,
        "matlab": foreign_exports.to_matlab,
        "ros": foreign_exports.to_ros,
        "imucal": foreign_exports.to_imucal,
    }
    return writers[name](result, unit)
