"""`tumble acquire`: a run on one's own stand, by instruments that a file describes, and its solution."""

from __future__ import annotations

import argparse
import os
from contextlib import suppress
from typing import TYPE_CHECKING

from tumble.cli import options
from tumble.defaults import DEFAULT_ESTIMATOR, DEFAULT_INCLINED
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, BadInput, BenchFault, Interrupted, NotInstalled, file_name
from tumble.estimators import ESTIMATORS
from tumble.messages import tell, warn

if TYPE_CHECKING:
    from tumble.acquisition.instruments import Bench
    from tumble.schedule import Schedule


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Turn a rotary table, or ask you to, wait until the block is at rest, sample it, and solve the run. Instruments"
        " are reached through PyVISA or a serial port."
    )
    parser.epilog = (
        "Leaves a folder: run.csv, which grows position by position, result.json, report.html. Whatever ends the run"
        " stops the table first. Exit codes: 0 pass, 1 gravity check failed, the run does not fit its stand, or its"
        " uncertainty does not show the limit (NOT SHOWN), 2 bad input, 3 a fault of an instrument or of the stand, 77"
        " a package is missing, 130 interrupted."
    )
    parser.add_argument("bench", metavar="FILE.toml", help="the table and the block, and how they are spoken to")
    parser.add_argument("--out", metavar="DIR", required=True, help="folder of the run, new or empty")
    parser.add_argument("--resume", action="store_true", help="go on with the run that --out has")
    parser.add_argument("--stand", metavar="FILE", help="stand file (TOML): gives the uncertainties")
    parser.add_argument("--estimator", choices=ESTIMATORS, metavar="NAME", help="as of solve; default: by the schedule")
    options.add(parser, "--limit", "--confidence", "--details", "--json")
    options.add(parser, "--no-report")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Acquire, solve and print. Returns the exit code; raises TumbleError."""
    limit_g, confidence = options.parse_limit(arguments.limit), options.parse_confidence(arguments.confidence)

    from tumble.acquisition.instruments import opened
    from tumble.api.recording import recording_of
    from tumble.api.result import Result
    from tumble.api.solving import solved
    from tumble.cli.output import print_solution
    from tumble.documents.base import to_json
    from tumble.files.disk import RESULT_FILE, RUN_FILE, write_all
    from tumble.files.schedule_file import read_schedule
    from tumble.files.stand_file import read_stand
    from tumble.report.make import HTML
    from tumble.solving.decision import decide

    if arguments.stand is not None:
        read_stand(arguments.stand)  # what cannot be used is told before anything moves
    run_file = os.path.join(arguments.out, RUN_FILE)
    with opened(arguments.bench) as bench:
        schedule = read_schedule(bench.schedule)
        is_inclined = schedule.data.is_inclined
        estimator = arguments.estimator or (DEFAULT_INCLINED if is_inclined else DEFAULT_ESTIMATOR)
        read_schedule(bench.schedule, estimator=estimator)
        _made(arguments.out, arguments.resume)
        _measure(bench, schedule.data, run_file, arguments.resume)
    recording = recording_of(run_file)
    found = solved(
        recording,
        stand=arguments.stand,
        schedule=bench.schedule,
        estimator=estimator,
        limit_g=limit_g,
        confidence=confidence,
    )
    text = to_json(found.document)
    files = {RESULT_FILE: text.encode()}
    if not (arguments.no_report or os.environ.get(options.NO_REPORT)):
        with suppress(NotInstalled):
            files["report.html"] = Result(text).reported(HTML, recording)
    write_all({os.path.join(arguments.out, name): data for name, data in files.items()})
    tell(f"run folder: {file_name(arguments.out)}")
    warn(found.complaints)
    print_solution(found.solution, text if arguments.json else None, os.path.basename(run_file), arguments.details)
    return EXIT_PASS if decide(found.solution).passed else EXIT_LIMITS_FAILED


def _made(folder: str, may_have_run: bool) -> None:
    """A new folder, an empty one, or one to go on with. Raises BadInput."""
    from tumble.files.disk import reason

    try:
        os.makedirs(folder, exist_ok=True)
        if os.listdir(folder) and not may_have_run:
            raise BadInput("is not empty; --resume goes on with the run in it", folder)
    except OSError as error:
        raise BadInput(reason(error), folder) from None


def _measure(bench: Bench, schedule: Schedule, run_file: str, resume: bool) -> None:
    """All positions, or those that are left. Raises BenchFault, Interrupted."""
    from tumble.acquisition.run import AcquisitionPlan
    from tumble.api.acquiring import Operator, acquired

    operator = Operator(schedule)
    plan = AcquisitionPlan(
        schedule=schedule,
        samples=bench.samples,
        unit=bench.unit,
        file=run_file,
        read=bench.read,
        mount=operator.mount,
        drive=bench.drive,
        turn_by_hand=operator.turn,
        rest_timeout_s=bench.rest_timeout_s,
        forget=bench.forget,
    )
    try:
        acquired(plan, resume)
    except (BenchFault, Interrupted, KeyboardInterrupt) as ended:
        kept = f"; what was measured is in {file_name(run_file)}: --resume goes on" if os.path.exists(run_file) else ""
        if isinstance(ended, BenchFault):
            raise BenchFault(f"{ended}{kept}") from None
        stopped = "" if bench.drive is None else "; the table is stopped"
        raise Interrupted(f"{str(ended) or 'interrupted'}{stopped}{kept}") from None
