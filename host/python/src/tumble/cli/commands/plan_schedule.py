"""`tumble plan schedule`: the schedule that reaches an accuracy in the least test time."""

from __future__ import annotations

import argparse

from tumble.cli.commands.plan_options import (
    add_limit_options,
    add_probability,
    add_subject,
    parse_positive,
    parse_probability,
    read_case,
    write_json,
)
from tumble.cli.options import Subparsers, add_model, parse_number, parse_whole
from tumble.cli.working import add_workers, progress_bar, team_of
from tumble.errors import EXIT_PASS, UsageError, quoted

_FEWEST, _MOST = 2, 6
_STEPS = ("15", "22.5", "45")
_LONGEST_S = 1e6


def add_to(subparsers: Subparsers) -> None:
    """Describe the subject to argparse."""
    parser = add_subject(
        subparsers,
        "schedule",
        run,
        help="the quickest schedule: mountings, table angles and samples for a limit",
        description="The mountings, table angles and samples that reach a limit, or a worst standard uncertainty of"
        " |a|, in the least test time found; and what the built-in schedules take for the same.",
    )
    add_limit_options(parser)
    add_model(parser)
    add_probability(parser, "of keeping the limit: of passing the check, and of |a| within it at every attitude")
    parser.add_argument(
        "--norm", metavar="G", help="reach this worst standard uncertainty of |a| over all attitudes, not a limit"
    )
    parser.add_argument(
        "--estimator",
        choices=("least_squares", "optimal"),
        default="optimal",
        metavar="NAME",
        help="least_squares or optimal; default: optimal",
    )
    parser.add_argument(
        "--mountings", metavar="N", default="3", help=f"so many or fewer, {_FEWEST} to {_MOST}; default: 3"
    )
    parser.add_argument(
        "--angles", choices=_STEPS, default="22.5", help="table angles are multiples of so many degrees; default: 22.5"
    )
    parser.add_argument("--remounting", metavar="SECONDS", help="what it takes to mount the block anew; default: 300")
    parser.add_argument("--out", metavar="FILE.toml", help="also write it as a schedule file")
    add_workers(parser)


def run(arguments: argparse.Namespace) -> int:
    """Search and print. Raises TumbleError."""
    if arguments.norm is not None and (arguments.limit is not None or arguments.probability is not None):
        raise UsageError("--norm: a worst u(|a|) takes the place of --limit and --probability")
    if arguments.out is not None and not arguments.out.endswith(".toml"):
        raise UsageError(f"--out: {quoted(arguments.out)} does not end in .toml")
    norm_g = None if arguments.norm is None else parse_positive(arguments.norm, "--norm")
    probability = parse_probability(arguments.probability)
    most = parse_whole(arguments.mountings, "--mountings", _FEWEST, _MOST)
    remounting = _seconds(arguments.remounting)

    from tumble.files.disk import refuse_overwriting, write_text
    from tumble.files.schedule_file import to_toml
    from tumble.files.stand_file import read_stand
    from tumble.planning import schedule_report
    from tumble.planning.schedule_search import DEFAULT_REMOUNT_S, Goal, Pace, plan_schedule

    refuse_overwriting(arguments.out, arguments.stand)
    case = read_case(arguments)
    stand_file = None if arguments.stand is None else read_stand(arguments.stand)
    pace = Pace.of(stand_file, DEFAULT_REMOUNT_S if remounting is None else remounting)
    goal, step_deg = Goal(norm_g, probability, arguments.estimator), float(arguments.angles)
    depends = {"case": case, "goal": goal, "pace": pace, "step_deg": step_deg}
    with team_of(arguments, "plan schedule", **depends) as team, progress_bar("searching") as progress:
        found = plan_schedule(case, goal, pace, step_deg, most, progress, team)
    if arguments.out is not None:
        write_text(arguments.out, to_toml(found.best.schedule))
    if arguments.json:
        write_json(schedule_report.document(found, step_deg))
    else:
        schedule_report.show(found, arguments.out, arguments.stand)
    return EXIT_PASS


def _seconds(text: str | None) -> float | None:
    if text is None:
        return None
    seconds = parse_number(text)
    if not 0.0 <= seconds <= _LONGEST_S:
        raise UsageError(f"--remounting: {quoted(text)} is not a number of seconds from 0 to {_LONGEST_S:g}")
    return seconds
