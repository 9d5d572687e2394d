"""`tumble fixture check`: is the stand what its file declares, and good enough? `tumble fixture learn`: what is its
table off by?"""

from __future__ import annotations

import argparse
import math
import os
import sys
from typing import TYPE_CHECKING

from tumble.cli import options
from tumble.defaults import ANEW, DEFAULT_LIMIT_G, LEVELLED, ONCE
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, BadInput, UsageError, file_name, listed, quoted
from tumble.messages import warn
from tumble.schedule import file_of

if TYPE_CHECKING:
    from tumble.core import CoreSchedule
    from tumble.documents.fixture import Combined
    from tumble.files.stand_file import StandFile
    from tumble.fixture.judge import Limits, RunView
    from tumble.stand import PerChannel

AGAINST = ("declared", "needed")
DEFAULT_CONFIDENCE = 0.95
DEFAULT_VALID_DAYS = 365


def describe(parser: argparse.ArgumentParser) -> None:
    subjects = parser.add_subparsers(metavar="SUBJECT", required=True)
    subject = subjects.add_parser(
        "check",
        help="runs against a stand file and an acceptance limit",
        description="What the runs show of every source of error, against what the stand file declares and what the"
        " limit of the gravity check needs. Several runs of one block are combined into one result.",
        epilog="Exit codes: 0 pass, 1 a limit is exceeded, 2 bad input, 3 core and numpy disagree, 130 interrupted.",
    )
    subject.add_argument("--stand", metavar="FILE", required=True, help="stand file (TOML)")
    subject.add_argument("runs", metavar="RUN.csv", nargs="+", help="run files with columns mounting,position,ux,uy,uz")
    options.add(subject, "--schedule", "--estimator", "--limit")
    subject.add_argument(
        "--against",
        choices=AGAINST,
        default="declared",
        help="which limits decide: the stand file's (default), or the needed ones",
    )
    subject.add_argument(
        "--levelled",
        choices=LEVELLED,
        help="was the stand levelled once for all these runs, or anew before each? default: as their axis tilts show",
    )
    subject.add_argument(
        "--confidence",
        metavar="P",
        default=str(DEFAULT_CONFIDENCE),
        help=f"of all verdicts together, 0.5 to 0.9999; default: {DEFAULT_CONFIDENCE}",
    )
    subject.add_argument("--json", action="store_true", help="print one JSON document, schema tumble.fixture/1")
    subject.set_defaults(run_command=check)
    _describe_learn(subjects)


def _describe_learn(subjects: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    subject = subjects.add_parser(
        "learn",
        help="the errors of set angles that stay from run to run, from several runs",
        description="What the marks of the stand's table are off by, from several runs on it, of one block or several,"
        " and how well the table comes to a mark again. The new stand file is the given one with a table"
        " [set_angles], by which tumble solve corrects the angles of a run until it expires.",
        epilog="Exit codes: 0 learnt, 1 the runs do not fit, or their set angles do not stay: nothing is written, 2 bad"
        " input, 3 core and numpy disagree, 130 interrupted.",
    )
    subject.add_argument("--stand", metavar="FILE", required=True, help="stand file (TOML)")
    subject.add_argument(
        "runs", metavar="RUN.csv", nargs="+", help="run files with columns mounting,position,ux,uy,uz; three or more"
    )
    options.add(subject, "--schedule", "--estimator")
    subject.add_argument("--out", metavar="STAND.toml", required=True, help="write the new stand file here")
    subject.add_argument(
        "--valid-days",
        metavar="N",
        default=str(DEFAULT_VALID_DAYS),
        help=f"how long the table is used, 1 to 3650; default: {DEFAULT_VALID_DAYS}",
    )
    subject.set_defaults(run_command=learn)


def learn(arguments: argparse.Namespace) -> int:
    """Learn, write and print. Returns the exit code; raises TumbleError."""
    days = options.parse_whole(arguments.valid_days, "--valid-days", 1, 3650)
    _require_different(arguments.runs)

    from tumble.cli.output import print_lines
    from tumble.files.disk import read_bytes, refuse_overwriting, write_text
    from tumble.files.schedule_file import read_schedule
    from tumble.files.stand_file import read_stand, with_set_angles
    from tumble.fixture.learn import FEWEST_RUNS, learnt_table, lines
    from tumble.solving.result import today

    if len(arguments.runs) < FEWEST_RUNS:
        raise UsageError(f"set angles that stay show in {FEWEST_RUNS} runs or more, not in {len(arguments.runs)}")
    refuse_overwriting(arguments.out, arguments.stand, *arguments.runs, file_of(arguments.schedule))
    options.require_ending(arguments.out, "--out", ".toml")
    data = read_bytes(arguments.stand)
    stand_file = read_stand(arguments.stand, data)
    if stand_file.stand.set_angle == 0.0:
        raise BadInput("angle_rad is 0: there is nothing to learn", arguments.stand)
    schedule = None
    if arguments.schedule is not None:
        schedule = read_schedule(arguments.schedule, estimator=arguments.estimator)
        if schedule.data.is_inclined or schedule.data.is_laid_by_hand:
            raise UsageError("--schedule: set angles are learnt on a level table that turns to them")
    views, warnings = _views(arguments, stand_file, schedule, stand_file.delta_g_limit_g or DEFAULT_LIMIT_G)
    hashes = [view.solution.run.sha256 for view in views]
    if len(set(hashes)) < len(hashes):
        raise UsageError("two of the runs are the same, to the byte")
    found = learnt_table([view.solution for view in views], stand_file.stand, today(), days)
    if not found.unfit and found.is_worth_it:
        text = with_set_angles(data.decode("utf-8"), found.table)
        read_stand(arguments.out, text.encode("utf-8"))
        write_text(arguments.out, text)
    warn(warnings)
    print_lines([[(line, "")] for line in lines(found, stand_file.stand)])
    if found.unfit:
        names = listed([file_name(arguments.runs[index]) for index in found.unfit])
        do, show = ("do", "they show") if found.unfit[1:] else ("does", "it shows")
        warn([f"not written: with these set angles {names} {do} not fit the stand; tumble solve says what {show}"])
        return EXIT_LIMITS_FAILED
    if not found.is_worth_it:
        warn(["not written: the set angles do not stay from run to run, less than half of their error would go"])
        return EXIT_LIMITS_FAILED
    return EXIT_PASS


def _require_different(runs: list[str]) -> None:
    """Raise UsageError for a run that is given twice: it would count as two."""
    seen: set[str] = set()
    for run in runs:
        path = os.path.realpath(run)
        if path in seen:
            raise UsageError(f"the run {quoted(run)} is given twice")
        seen.add(path)


def check(arguments: argparse.Namespace) -> int:
    """Check and print. Returns the exit code; raises TumbleError."""
    limit_g = options.parse_limit(arguments.limit)
    confidence = options.parse_number(arguments.confidence, "--confidence", 0.5, 0.9999)
    _require_different(arguments.runs)

    from tumble.core import CoreSchedule, paper_schedule
    from tumble.documents.base import to_json
    from tumble.files.schedule_file import read_schedule
    from tumble.files.stand_file import read_stand
    from tumble.fixture import report
    from tumble.fixture.judge import Judge, Limits

    stand_file = read_stand(arguments.stand)
    schedule = None
    if arguments.schedule is not None:
        schedule = read_schedule(arguments.schedule, estimator=arguments.estimator)
    limit_g = limit_g if limit_g is not None else stand_file.delta_g_limit_g or DEFAULT_LIMIT_G
    views, warnings = _views(arguments, stand_file, schedule, limit_g)
    mountings = len((schedule or CoreSchedule(paper_schedule())).data.fitted_mountings)
    once, combined = _combined(arguments, views, confidence, stand_file.step_v)
    judge = Judge(views, confidence, once)
    needed = _needed(arguments, stand_file, schedule, limit_g, mountings)
    found = report.document(
        stand_file.stand,
        views,
        judge.judge(Limits.declared(stand_file.stand, mountings)),
        None if needed is None else judge.judge_need(needed),
        combined,
        against=arguments.against,
        limit_g=limit_g,
        confidence=confidence,
        levelled=ONCE if once else ANEW,
        warnings=warnings,
    )
    warn(warnings)
    sys.stdout.write(to_json(found) if arguments.json else report.render(found, views))
    return EXIT_PASS if found.passed else EXIT_LIMITS_FAILED


def _combined(
    arguments: argparse.Namespace, views: list[RunView], confidence: float, step_v: PerChannel
) -> tuple[bool, Combined | None]:
    """Was the stand levelled once for all runs, and several runs in one: None of one run.

    Where nobody says, and runs that show the same axis tilt only agree if they were levelled anew, they were: the zero
    of the table angle, which no run shows by itself, must then have moved.
    """
    from tumble.fixture.judge import combine, levelled_once

    solutions = [view.solution for view in views]
    once = levelled_once(views) if arguments.levelled is None else arguments.levelled == ONCE
    if len(views) == 1:
        return once, None
    found = combine(solutions, once, confidence, step_v)
    if arguments.levelled is None and once and not found.consistent:
        anew = combine(solutions, False, confidence, step_v)
        return (False, anew) if anew.consistent else (once, found)
    return once, found


def _views(
    arguments: argparse.Namespace, stand_file: StandFile, schedule: CoreSchedule | None, limit_g: float
) -> tuple[list[RunView], list[str]]:
    """Every run, solved and looked at; and what a person is warned of. Raises TumbleError."""
    from tumble.core import MAX_YAWS, CoreSchedule
    from tumble.files import run_rows
    from tumble.files.run_file import read_measured
    from tumble.fixture.judge import RunView
    from tumble.solving import plausibility
    from tumble.solving.plausibility import contradicted, in_environment, spanned
    from tumble.solving.solution import solve

    planned = schedule or CoreSchedule.built_in("paper")
    if (count := len(planned.data.mountings)) > MAX_YAWS:
        raise BadInput(f"{count} mountings: a run shows the stand in {MAX_YAWS} at most", arguments.schedule)
    views: list[RunView] = []
    warnings: list[str] = []
    for file in arguments.runs:
        run, core_schedule = read_measured(file, planned)
        if views and run.unit != views[0].solution.run.unit:
            raise BadInput(f"outputs in {run.unit}, those of the runs before in {views[0].solution.run.unit}", file)
        odd_rows = run_rows.check_rows(run, core_schedule.data, stand_file, file)
        about_temperature = [contradicted(run, stand_file.environment), spanned(run)]
        run = in_environment(run, stand_file.environment)
        solution = solve(run, core_schedule, arguments.estimator, limit_g, stand_file.stand, file, stand_file.step_v)
        solution = plausibility.with_order_flag(solution, stand_file)
        odd = (*odd_rows, *plausibility.check_k(solution, stand_file, file), *plausibility.unchecked(solution))
        odd += tuple(filter(None, about_temperature))
        warnings += [f"{file_name(file)}: {sentence}" for sentence in odd]
        views.append(RunView.of(solution, file))
    return views, warnings


def _needed(
    arguments: argparse.Namespace, stand_file: StandFile, schedule: CoreSchedule | None, limit_g: float, mountings: int
) -> Limits | None:
    """What the acceptance limit needs of the stand; None where the stand file does not describe the block,
    or nothing can be said.

    Raises BadInput, UsageError where that is what the verdict should go by.
    """
    if stand_file.block is None:
        if arguments.against == "needed":
            raise BadInput("no table [block]: what a limit needs depends on the block", arguments.stand)
        return None
    import numpy as np

    from tumble.fixture.judge import Limits
    from tumble.planning.budget import sources
    from tumble.planning.case import Case
    from tumble.planning.require import allowed
    from tumble.planning.weights import SOURCES
    from tumble.stand import by_channel

    case = Case.of(stand_file, arguments.stand, None if schedule is None else schedule.data)
    try:
        names = sources(case, published=False)
        limits = allowed(case, "derived", arguments.estimator, limit_g, np.ones(len(names))).limits
    except UsageError:
        if arguments.against == "needed":
            raise
        return None
    found = dict(zip(names, limits.tolist()))
    left = found["noise"] ** 2 - by_channel(case.stand.rounding).max() ** 2  # of a mean, beside rounding
    found["noise"] = math.sqrt(max(left, 0.0) * stand_file.stand.samples)
    five = [found[name] for name in SOURCES]
    return Limits.needed(five, stand_file.stand.remounting, mountings, found.get("seat", 0.0))
