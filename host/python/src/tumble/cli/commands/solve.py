"""`tumble solve`: a recorded run in, twelve coefficients with a verdict out."""

from __future__ import annotations

import argparse
import os

from tumble.cli import layout_options, options
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, UsageError, quoted
from tumble.estimators import OPTIMAL
from tumble.schedule import file_of
from tumble.terms import EXTENDABLE, TERMS, Terms

FEWEST_SIMULATED, MOST_SIMULATED = 1000, 1_000_000


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
    parser.add_argument(
        "--model",
        metavar="TERM,...",
        help=f"further terms to find: {', '.join(TERMS)} (second and third order, drift over the run); needs"
        f" --estimator {' or '.join(EXTENDABLE)}",
    )
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
    layout_options.add_layout(parser, "run file")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Solve and print. Returns the exit code; raises TumbleError."""
    limit_g = options.parse_limit(arguments.limit)
    if arguments.estimator == OPTIMAL and arguments.stand is None:
        raise UsageError("--estimator optimal weighs the means by the stand's errors: it needs --stand FILE")
    runs, seed = _parse_monte_carlo(arguments)
    terms = _parse_model(arguments)

    from tumble.cli.output import print_solution, warn
    from tumble.core import CoreSchedule
    from tumble.files import run_rows
    from tumble.files.disk import refuse_overwriting, write_text
    from tumble.files.documents import to_json
    from tumble.files.run_file import read_measured
    from tumble.files.run_layout import COLUMNS
    from tumble.solving import plausibility, provenance, result
    from tumble.solving.solution import solve

    wishes = layout_options.wishes(arguments, COLUMNS)
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


def _parse_model(arguments: argparse.Namespace) -> Terms:
    """The further terms, in the order of TERMS. Raises UsageError."""
    if arguments.model is None:
        return ()
    named = [term.strip() for term in arguments.model.split(",")]
    for term in named:
        if term not in TERMS or named.count(term) > 1:
            raise UsageError(f"--model: {quoted(term)} is not one of {', '.join(TERMS)}, once each")
    if arguments.estimator not in EXTENDABLE:
        closed = f"{arguments.estimator} is a closed form of twelve coefficients"
        raise UsageError(f"--model: {closed}; use --estimator least_squares, or optimal with --stand FILE")
    return tuple(term for term in TERMS if term in named)
