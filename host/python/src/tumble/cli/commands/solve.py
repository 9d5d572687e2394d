"""`tumble solve`: a recorded run in, twelve coefficients with a verdict out."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from typing import TYPE_CHECKING

from tumble.cli import options, prior, thermal
from tumble.defaults import NEEDS_STAND
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, UsageError
from tumble.estimators import ESTIMATORS, NORM, OPTIMAL
from tumble.messages import warn
from tumble.schedule import ANY_POSE, WITH_STAND, file_of
from tumble.terms import parse

if TYPE_CHECKING:
    from tumble.solving.solution import Solution

FEWEST_SIMULATED, MOST_SIMULATED = 1000, 1_000_000


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Solve a recorded run: the firmware's code computes, an independent numpy computation confirms."
    )
    parser.epilog = (
        "Exit codes: 0 pass, 1 gravity check failed, the run does not fit its stand, its uncertainty does not show the"
        " limit (NOT SHOWN), or the block has changed since its prior; 2 bad input, 3 core and numpy disagree, 130"
        " interrupted."
    )
    parser.add_argument(
        "run",
        metavar="RUN.csv",
        nargs="+",
        help="run file with columns mounting,position,ux,uy,uz, also compressed by gzip or zstd; - for standard input",
    )
    known = *ESTIMATORS, NORM
    remark = f", {NORM} on {ANY_POSE}, optimal on hand_laid; elsewhere optimal needs --stand"
    options.add(parser, "--estimator", remark=remark, choices=known, default=None)  # None: see solved
    parser.add_argument("--stand", metavar="FILE", help="stand file (TOML): gives the uncertainties")
    options.add(parser, "--schedule", remark=f", {ANY_POSE}")
    options.add(parser, "--model", "--limit", "--confidence", "--details", "--json")
    parser.add_argument("--out", metavar="RESULT.json", help="write the result to a file as well")
    parser.add_argument(
        "--monte-carlo",
        metavar="N",
        help="simulate N runs of this result on the declared stand, and compare the uncertainties (100000"
        " decide nearly all cases); 1000 to 1000000; needs --stand",
    )
    thermal.add_options(parser)
    prior.add_options(parser)
    parser.add_argument("--seed", metavar="N", help="of --monte-carlo, 0 to 2^64 - 1; default: 1")
    options.add(parser.add_argument_group("processes for --monte-carlo"), *options.WORKERS)
    options.add_layout(parser, "run file")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Solve and print. Returns the exit code; raises TumbleError."""
    limit_g, confidence = options.parse_limit(arguments.limit), options.parse_confidence(arguments.confidence)
    if arguments.estimator == OPTIMAL and arguments.stand is None and arguments.schedule not in WITH_STAND:
        raise UsageError(NEEDS_STAND)
    if arguments.temperature is not None:
        return thermal.run(arguments, limit_g, confidence)
    arguments.run = thermal.only_run(arguments)
    prior.require_options(arguments)
    runs, seed = _parse_monte_carlo(arguments)
    parse(arguments.model, arguments.estimator)

    from tumble.api.recording import recording_of
    from tumble.api.solving import solved
    from tumble.cli.output import print_solution
    from tumble.documents.base import to_json
    from tumble.files.disk import refuse_overwriting, write_text
    from tumble.files.run_layout import COLUMNS, TEMPERATURE
    from tumble.solving.decision import decide

    recording = recording_of(arguments.run, options.layout_options(arguments, (*COLUMNS, TEMPERATURE)))
    refuse_overwriting(
        arguments.out, arguments.run, arguments.stand, file_of(arguments.schedule), prior.file_of(arguments)
    )
    options.require_ending(arguments.out, "--out", ".json")
    found = solved(
        recording,
        stand=arguments.stand,
        schedule=arguments.schedule,
        estimator=arguments.estimator,
        limit_g=limit_g,
        confidence=confidence,
        model=arguments.model or (),
        prior=prior.last_calibration(arguments, recording),
    )
    if runs is not None:
        found = replace(found, solution=_simulated(arguments, found.solution, runs, seed))
    wanted = arguments.json or arguments.out is not None
    text = to_json(found.document) if wanted else ""
    if arguments.out is not None:
        write_text(arguments.out, text)
    warn(found.complaints)
    title = os.path.basename(recording.name)
    print_solution(found.solution, text if arguments.json else None, title, arguments.details)
    has_changed = found.solution.prior is not None and not found.solution.prior.used
    return EXIT_PASS if decide(found.solution).passed and not has_changed else EXIT_LIMITS_FAILED


def _parse_monte_carlo(arguments: argparse.Namespace) -> tuple[int | None, int]:
    """Runs to simulate, None for none asked for, and the seed. Raises UsageError."""
    if arguments.monte_carlo is None:
        for option in ("seed", "workers", "cluster", "resume"):
            if getattr(arguments, option) is not None:
                raise UsageError(f"--{option}: without --monte-carlo there is nothing to draw")
        return None, 0
    if arguments.stand is None and arguments.schedule not in WITH_STAND:
        raise UsageError("--monte-carlo draws the stand's errors: it needs --stand FILE")
    runs = options.parse_whole(arguments.monte_carlo, "--monte-carlo", FEWEST_SIMULATED, MOST_SIMULATED)
    return runs, options.parse_seed("1" if arguments.seed is None else arguments.seed)


def _simulated(arguments: argparse.Namespace, solution: Solution, runs: int, seed: int) -> Solution:
    """With its Monte Carlo, by whoever is to do it. Raises TumbleError."""
    depends = {"seed": seed, **solution.drawn_from}
    with (
        options.team_of(arguments, "solve --monte-carlo", **depends) as team,
        options.progress_bar("simulating", runs) as progress,
    ):
        return solution.simulated(runs, seed, team, progress)
