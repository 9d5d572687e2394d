"""`tumble campaign ...`: thousands of simulated runs of the firmware, or the fault campaign, on many processors."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from tumble.cli import options
from tumble.errors import EXIT_PASS, UsageError
from tumble.messages import tell

if TYPE_CHECKING:
    from tumble.world.campaigns import Runs

_MOST = 1_000_000_000
_DEFAULT = "1000"


def describe(parser: argparse.ArgumentParser) -> None:
    subjects = parser.add_subparsers(metavar="SUBJECT", required=True)
    runs = subjects.add_parser(
        "runs",
        help="calibrations, each of its own seed: one JSON line each",
        description="Calibrations on a simulated stand, each of its own seed: a line of JSON each.",
        epilog="Exit codes: 0 all passed, 1 a gravity check failed, 2 bad input, 3 a run ended in a fault, 130"
        " interrupted.",
    )
    runs.add_argument("scenario", nargs="?", metavar="SCENARIO", help="scenario file; default: the paper's stand")
    runs.add_argument("--runs", metavar="N", default=_DEFAULT, help=f"default: {_DEFAULT}")
    told = runs.add_mutually_exclusive_group()
    told.add_argument("--means", action="store_true", help="with the means of all positions in every line")
    told.add_argument("--summary", action="store_true", help="instead of the lines one document: statistics and speed")
    lives = subjects.add_parser(
        "lives",
        help="fault campaign: random faults, commands, forged frames, losses of power",
        description="The fault campaign: simulated runs (lives) with faults, each of its own seed; one JSON document.",
        epilog="Exit codes: 0 all rules held, 2 bad input, 3 one was violated, 130 interrupted.",
    )
    lives.add_argument("-v", "--verbose", action="store_true", help="print a minimal set of events for each violation")
    lives.add_argument("--lives", metavar="N", default=_DEFAULT, help=f"default: {_DEFAULT}")
    for subject, run in ((runs, run_runs), (lives, run_lives)):
        options.add(subject, "--seed", remark=", of the first")
        options.add(subject, *options.WORKERS)
        subject.set_defaults(run_command=run)


def run_runs(arguments: argparse.Namespace) -> int:
    """Calibrate, and print lines as they come. Returns the exit code; raises TumbleError."""
    seed, count = seeds(arguments, "--runs", arguments.runs)

    from tumble.files.disk import read_bytes
    from tumble.world import campaigns

    scenario = None if arguments.scenario is None else read_bytes(arguments.scenario)
    job = campaigns.of_runs(scenario, arguments.scenario or "the defaults", arguments.means)
    return print_runs(arguments, job, seed, count)


def print_runs(arguments: argparse.Namespace, job: Runs, seed: int, count: int) -> int:
    """Lines as they come, or what they have in common. Returns the exit code; raises TumbleError."""
    from tumble.documents.base import to_json
    from tumble.world import campaigns

    code = EXIT_PASS
    summary = campaigns.Summary(seed, options.workers_of(arguments)) if arguments.summary else None
    with (
        options.team_of(arguments, "campaign runs", job=job) as team,
        options.progress_bar("calibrating", count) as progress,
    ):
        for ended in campaigns.ended(job, seed, count, team, progress):
            if summary is None:
                sys.stdout.write(ended.output)
            else:
                summary.add(ended)
            code = campaigns.worse(code, ended.code)
    if summary is not None:
        sys.stdout.write(to_json(summary.document()))
    return code


def run_lives(arguments: argparse.Namespace) -> int:
    """Live, tell of violations as they come, print the document. Returns the exit code; raises TumbleError."""
    seed, count = seeds(arguments, "--lives", arguments.lives)

    from tumble.documents import bench
    from tumble.documents.base import to_json
    from tumble.world import campaigns

    documents, code, job = [], EXIT_PASS, campaigns.FaultCampaignJob()
    with options.team_of(arguments, "campaign lives") as team, options.progress_bar("runs", count) as progress:
        for ended in campaigns.ended(job, seed, count, team, progress):
            for line in ended.said.splitlines():
                tell(line)
            documents.append(ended.output)
            code = campaigns.worse(code, ended.code)
    found = campaigns.merged(seed, documents)
    for one in found.first if arguments.verbose else ():
        for line in (one.world, *one.events, f"with these alone: {one.what}"):
            tell(f"  {line}")
    sys.stdout.write(to_json(bench.written(found)))
    return code


def seeds(arguments: argparse.Namespace, option: str, text: str) -> tuple[int, int]:
    """The first, and how many. Raises UsageError."""
    seed, count = options.parse_seed(arguments.seed), options.parse_whole(text, option, 1, _MOST)
    if seed + count - 1 > options.LARGEST_SEED:
        raise UsageError(f"{option}: the seeds would go beyond 2^64 - 1")
    return seed, count
