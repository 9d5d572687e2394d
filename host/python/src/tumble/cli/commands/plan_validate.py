"""`tumble plan validate`: do thousands of simulated runs turn out as accurate as they claim to be?"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tumble.cli.commands.plan_options import add_case_options, add_subject, read_case, write_json
from tumble.cli.options import Subparsers, add_seed, parse_seed, parse_whole
from tumble.cli.working import add_workers, progress_bar, team_of
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, UsageError, quoted
from tumble.estimators import ESTIMATORS, HARMONIC
from tumble.schedule import file_of

if TYPE_CHECKING:
    from tumble.planning.case import Case

DEFAULT_RUNS = 20_000
FEWEST_RUNS, MOST_RUNS = 100, 10_000_000


def add_to(subparsers: Subparsers) -> None:
    """Describe the subject to argparse."""
    parser = add_subject(
        subparsers,
        "validate",
        run,
        help="Monte Carlo: thousands of simulated runs against what they claim",
        description="Monte Carlo: the firmware's estimators on simulated runs of the exact geometry. Bias, spread,"
        " coverage of the stated intervals, efficiency against the least possible spread.",
        epilog="Exit codes: 0 every figure within its limits, 1 not so, 2 bad input, 77 --plot cannot be drawn here,"
        " 130 interrupted.",
    )
    add_case_options(parser, choose_estimator=False)
    parser.add_argument(
        "--estimator", choices=ESTIMATORS, metavar="NAME", help="one of them; default: all that the schedule allows"
    )
    least = f"{FEWEST_RUNS} or more; "
    parser.add_argument("--runs", metavar="N", default=str(DEFAULT_RUNS), help=f"{least}default: {DEFAULT_RUNS}")
    add_seed(parser)
    parser.add_argument(
        "--table",
        choices=("known", "run"),
        default="known",
        help="optimal weights: for the block's known K (default), or made anew for each run, as solve does",
    )
    parser.add_argument(
        "--plot", metavar="FILE.svg", help="also draw histograms of error over stated uncertainty; needs matplotlib"
    )
    add_workers(parser)


def run(arguments: argparse.Namespace) -> int:
    """Simulate, judge, print. Returns the exit code; raises TumbleError."""
    runs = parse_whole(arguments.runs, "--runs", FEWEST_RUNS, MOST_RUNS)
    seed = parse_seed(arguments.seed)
    if arguments.plot is not None and not arguments.plot.endswith(".svg"):
        raise UsageError(f"--plot: {quoted(arguments.plot)} does not end in .svg")
    case = read_case(arguments)
    if case.terms and arguments.table != "known":
        raise UsageError("--table run: not with --model; the second order makes up for weights made elsewhere")

    from tumble.files.disk import refuse_overwriting, write_text
    from tumble.planning.validate import document, judge, show, validate

    refuse_overwriting(arguments.plot, arguments.stand, file_of(arguments.schedule), option="--plot")
    if arguments.plot is not None:
        from tumble.pictures import require, svg
        from tumble.pictures.histograms import histograms

        require("--plot")
    estimators = _estimators(arguments, case)
    depends = {"case": case, "estimators": estimators, "seed": seed, "table": arguments.table}
    with team_of(arguments, "plan validate", **depends) as team, progress_bar("simulating", runs) as progress:
        found = validate(case, estimators, runs, seed, arguments.table, progress, team)
    plan = document(case, {one.estimator: judge(one) for one in found}, runs, seed, arguments.table)
    if arguments.plot is not None:
        write_text(arguments.plot, svg(histograms(found, f"{case.stand.name}: error over stated u, {runs} runs")))
    if arguments.json:
        write_json(plan)
    else:
        show(plan)
    return EXIT_PASS if plan.passed else EXIT_LIMITS_FAILED


def _estimators(arguments: argparse.Namespace, case: Case) -> tuple[str, ...]:
    """The one asked for, or all that the schedule allows."""
    from tumble.model.estimators import circles
    from tumble.planning.weights import estimators_of

    if arguments.estimator is not None:
        return (arguments.estimator,)
    harmonic = circles(case.fitted) is not None
    return tuple(name for name in estimators_of(case) if harmonic or name not in HARMONIC)
