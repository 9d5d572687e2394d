"""`tumble export`: the coefficients of a result, as a C header or as CSV, with unit and uncertainty of every number."""

from __future__ import annotations

import argparse
import sys

from tumble.cli.options import Subparsers
from tumble.errors import EXIT_PASS, BadInput, file_name
from tumble.messages import tell

FORMATS = ("c", "csv")


def add_to(subparsers: Subparsers) -> None:
    """Describe the command to argparse."""
    parser = subparsers.add_parser(
        "export",
        help="write the coefficients of a result as a C header or as CSV",
        description="Write the coefficients of a result, each with its unit and its standard uncertainty.",
        epilog="Exit codes: 0 done, 2 bad input, 130 interrupted.",
    )
    parser.add_argument("result", metavar="RESULT.json", help="a result of tumble solve")
    parser.add_argument("--format", choices=FORMATS, required=True, help="c: a header; csv: one row a coefficient")
    parser.add_argument(
        "--unit",
        choices=("g", "m/s2"),
        default="g",
        help="of accelerations; m/s2 needs gravity_m_s2 in the result's environment; default: g",
    )
    parser.add_argument("--out", metavar="FILE", help="default: standard output")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Convert and write. Returns the exit code; raises TumbleError."""
    from tumble.api.complaints import complaints_of_document
    from tumble.cli.exports import to_c, to_csv
    from tumble.files.disk import refuse_overwriting, write_text
    from tumble.files.documents import read_coefficients

    refuse_overwriting(arguments.out, arguments.result)
    result = read_coefficients(arguments.result)
    try:
        text = {"c": to_c, "csv": to_csv}[arguments.format](result, arguments.unit)
    except ValueError as error:
        raise BadInput(str(error), arguments.result) from None
    for warning in complaints_of_document(result):
        tell(f"tumble: warning: {file_name(arguments.result)}: {warning}")
    if arguments.out is None:
        sys.stdout.write(text)
    else:
        write_text(arguments.out, text)
    return EXIT_PASS
