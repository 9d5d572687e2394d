"""`tumble report`: a result as a document for people, HTML or PDF."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace

from tumble.cli import options
from tumble.errors import EXIT_PASS, UsageError


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Write a calibration report on a result, with the contents required by ISO/IEC 17025: one HTML file that"
        " needs no other, or the same as PDF."
    )
    parser.epilog = (
        "Exit codes: 0 done, also of a result that failed; 2 bad input; 77 a package is missing; 130 interrupted."
    )
    parser.add_argument(
        "result", metavar="RESULT.json", help="a result of tumble solve, also over temperature, or of tumble bench"
    )
    parser.add_argument(
        "--out", metavar="FILE.html|.pdf", help="default: HTML on standard output, unless that is a terminal"
    )
    parser.add_argument("--run", metavar="RUN.csv", help="the run that was solved: draws its samples too")
    parser.add_argument("--template", metavar="FILE", help="in place of the built-in one, or extending it (Jinja2)")
    parser.add_argument("--logo", metavar="FILE", help="PNG, JPEG or SVG, for the head of the first page")
    parser.add_argument(
        "--number", metavar="TEXT", help="default: label certificate_number, else by date and content of the result"
    )
    parser.add_argument("--issued", metavar="DATE", help="of issue, such as 2026-11-28; default: today's (UTC)")
    parser.add_argument("--since", metavar="OLD.json", help="an earlier result of the block: has it changed since?")
    parser.add_argument(
        "--history", metavar="FILE|URL", help="of tumble history: the calibrations of the block, when it is due"
    )
    options.add_layout(parser, "run file")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Write. Returns the exit code; raises TumbleError."""
    from tumble.report.make import HTML, kind_of, require_installed

    if arguments.out is None and sys.stdout.isatty():
        raise UsageError("a page is no text for a terminal: --out FILE.html or --out FILE.pdf")
    kind = HTML if arguments.out is None else kind_of(arguments.out)

    from tumble.api.recording import recording_of
    from tumble.api.result import load
    from tumble.api.thermal import is_thermal, load_thermal
    from tumble.files.disk import refuse_overwriting, write_bytes
    from tumble.files.run_layout import COLUMNS

    for name in ("columns", "delimiter", "decimal", "unit"):
        if arguments.run is None and getattr(arguments, name) is not None:
            raise UsageError(f"--{name} says how the run file is laid out: it needs --run RUN.csv")
    layout = options.layout_options(arguments, COLUMNS)
    inputs = arguments.result, arguments.run, arguments.template, arguments.logo, arguments.since, arguments.history
    refuse_overwriting(arguments.out, *inputs)
    given = {name: getattr(arguments, name) for name in ("template", "logo", "number", "issued")}
    if is_thermal(arguments.result):
        for name in ("run", "since", "history"):
            if getattr(arguments, name) is not None:
                raise UsageError(f"--{name} is for a result of one run, not for one over temperature")
        warm = load_thermal(arguments.result)
        require_installed(kind)
        text = warm.reported(kind, **given)
    else:
        result = load(arguments.result)
        require_installed(kind)
        recorded = None
        if arguments.run is not None:
            recorded = recording_of(arguments.run, layout if layout.unit else replace(layout, unit=result.unit))
        text = result.reported(kind, recorded, since=arguments.since, history=arguments.history, **given)
    if arguments.out is None:
        sys.stdout.buffer.write(text)
        sys.stdout.buffer.flush()
    else:
        write_bytes(arguments.out, text)
    return EXIT_PASS
