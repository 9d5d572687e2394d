"""`tumble solve`: a recorded run in, twelve coefficients with a verdict out."""

from __future__ import annotations

import argparse
import os
from typing import TYPE_CHECKING

from tumble.cli import options
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, UsageError, quoted
from tumble.estimators import OPTIMAL
from tumble.schedule import file_of

if TYPE_CHECKING:
    from tumble.files.run_layout import Wishes

FEWEST_SIMULATED, MOST_SIMULATED = 1000, 1_000_000
_DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "\\t": "\t"}


def add_to(subparsers: options.Subparsers) -> None:
    """Describe the command to argparse."""
    parser = subparsers.add_parser(
        "solve",
        help="solve a recorded run: K, U0, their uncertainties and a verdict",
        description="Solve a recorded run: the firmware's code computes, an independent numpy computation confirms.",
        epilog="Exit codes: 0 pass, 1 gravity check failed or the run does not fit its stand, 2 bad input,"
        " 3 core and numpy disagree, 130 interrupted.",
    )
    parser.add_argument("run", metavar="RUN.csv", help="run file with columns mounting,position,ux,uy,uz")
    options.add_estimator(parser, "; optimal needs --stand")
    parser.add_argument("--stand", metavar="FILE", help="stand file (TOML): gives the uncertainties")
    options.add_schedule(parser)
    options.add_model(parser)
    options.add_limit(parser)
    options.add_confidence(parser)
    options.add_json(parser)
    parser.add_argument("--out", metavar="RESULT.json", help="write the result to a file as well")
    parser.add_argument(
        "--monte-carlo",
        metavar="N",
        help="simulate N runs on the declared stand at the result, and hold its uncertainties against theirs (100000"
        " decide nearly all); 1000 to 1000000; needs --stand",
    )
    parser.add_argument("--seed", metavar="N", help="of --monte-carlo, 0 to 2^64 - 1; default: 1")
    layout = parser.add_argument_group("layout of the run file", "detected, unless given")
    layout.add_argument("--columns", metavar="NAME=COLUMN,...", help="names of its columns, such as ux=AccX,uy=AccY")
    layout.add_argument("--delimiter", metavar="SIGN", help="comma, semicolon, tab or another sign")
    layout.add_argument("--decimal", choices=(".", ","), help="decimal mark")
    layout.add_argument("--unit", help="unit of the outputs; default: the one in brackets in the header, else V")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Solve and print. Returns the exit code; raises TumbleError."""
    limit_g = options.parse_limit(arguments.limit)
    if arguments.estimator == OPTIMAL and arguments.stand is None:
        raise UsageError("--estimator optimal weighs the means by the stand's errors: it needs --stand FILE")
    runs, seed = _parse_monte_carlo(arguments)
    terms = options.parse_model(arguments.model, arguments.estimator)
    wishes = _wishes(arguments)

    from tumble.cli.output import print_solution, warn
    from tumble.core import CoreSchedule
    from tumble.files import run_rows
    from tumble.files.disk import refuse_overwriting, write_text
    from tumble.files.documents import to_json
    from tumble.files.run_file import read_measured
    from tumble.solving import plausibility, provenance, result
    from tumble.solving.solution import solve

    created = provenance.created()
    refuse_overwriting(arguments.out, arguments.run, arguments.stand, file_of(arguments.schedule))
    stand_file = None
    if arguments.stand is not None:
        from tumble.files.stand_file import read_stand

        stand_file = read_stand(arguments.stand)
        limit_g = limit_g if limit_g is not None else stand_file.delta_g_limit_g
    if arguments.schedule is None:
        schedule = CoreSchedule.built_in("paper")
    else:
        from tumble.files.schedule_file import read_schedule

        schedule = read_schedule(arguments.schedule, estimator=arguments.estimator)
    recorded, schedule = read_measured(arguments.run, schedule, wishes)
    odd_rows = run_rows.require(recorded, schedule.data, stand_file, arguments.run)
    step_v = 0.0 if stand_file is None else stand_file.step_v
    solution = solve(
        recorded,
        schedule,
        arguments.estimator,
        options.DEFAULT_LIMIT_G if limit_g is None else limit_g,
        None if stand_file is None else stand_file.stand,
        arguments.run,
        step_v,
        confidence=options.parse_confidence(arguments.confidence),
        terms=terms,
    )
    odd = plausibility.require(solution, stand_file, arguments.run)
    if runs is not None:
        solution = solution.simulated(runs, seed)
    text = ""
    if arguments.json or arguments.out is not None:
        item, environment = (None, None) if stand_file is None else (stand_file.item, stand_file.environment)
        serial = None if stand_file is None else stand_file.serial
        name = os.path.basename(arguments.run)
        text = to_json(result.document(solution, item, environment, serial, name, created))
    if arguments.out is not None:
        write_text(arguments.out, text)
    warn(solution, (*odd_rows, *odd))
    print_solution(solution, text if arguments.json else None, os.path.basename(arguments.run))
    return EXIT_PASS if solution.passed else EXIT_LIMITS_FAILED


def _wishes(arguments: argparse.Namespace) -> Wishes:
    """What the options say about the layout of the run file. Raises UsageError."""
    from tumble.files.run_layout import Wishes

    return Wishes(
        columns={} if arguments.columns is None else _parse_columns(arguments.columns),
        delimiter=None if arguments.delimiter is None else _parse_delimiter(arguments.delimiter),
        decimal=arguments.decimal,
        unit=None if arguments.unit is None else _parse_unit(arguments.unit),
    )


def _parse_monte_carlo(arguments: argparse.Namespace) -> tuple[int | None, int]:
    """Runs to simulate, None for no such wish, and the seed. Raises UsageError."""
    if arguments.monte_carlo is None:
        if arguments.seed is not None:
            raise UsageError("--seed: without --monte-carlo there is nothing to draw")
        return None, 0
    if arguments.stand is None:
        raise UsageError("--monte-carlo draws the stand's errors: it needs --stand FILE")
    runs = options.parse_whole(arguments.monte_carlo, "--monte-carlo", FEWEST_SIMULATED, MOST_SIMULATED)
    return runs, options.parse_seed("1" if arguments.seed is None else arguments.seed)


def _parse_columns(text: str) -> dict[str, str]:
    """Read `ux=AccX,uy=AccY`."""
    from tumble.files.run_layout import COLUMNS

    columns = {}
    for part in text.split(","):
        wanted, equals, name = (piece.strip() for piece in part.partition("="))
        if not equals or wanted not in COLUMNS or not name or wanted in columns:
            known = ", ".join(COLUMNS)
            raise UsageError(f"--columns: {quoted(part)} is not NAME=COLUMN with NAME one of {known}, once each")
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
