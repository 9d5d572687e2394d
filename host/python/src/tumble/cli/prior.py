"""`tumble solve --prior`: the last calibration of the block, from a file or from the history."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tumble.errors import UsageError

if TYPE_CHECKING:
    from tumble.api.recording import Recording
    from tumble.model.prior import LastCalibration

HISTORY = "history"
_DB = "history.db"


def add_options(parser: argparse.ArgumentParser) -> None:
    """--prior, --growth, --db."""
    group = parser.add_argument_group("with the last calibration of the block")
    group.add_argument(
        "--prior",
        metavar=f"RESULT.json|{HISTORY}",
        help="let it enter the least squares of optimal, if the run does not contradict it; needs --stand with the"
        " serial of the block",
    )
    group.add_argument(
        "--growth",
        metavar="SCALE,ANGLE,BIAS",
        help="standard deviations of what changes in a year, such as 50,20,50: scales in ppm, angles between axes in"
        f" urad, biases in ug; default: those of its type in the {HISTORY}",
    )
    group.add_argument("--db", metavar="FILE|URL", help=f"of the {HISTORY}; default: {_DB}")


def file_of(arguments: argparse.Namespace) -> str | None:
    """The file that is read, if it is one."""
    return None if arguments.prior == HISTORY else arguments.prior


def require_options(arguments: argparse.Namespace) -> None:
    """Raise UsageError for options that contradict each other."""
    if arguments.db is not None and arguments.prior != HISTORY:
        raise UsageError(f"--db is for --prior {HISTORY}")
    if arguments.growth is not None and arguments.prior is None:
        raise UsageError("--growth: without --prior there is nothing that grows")
    if arguments.prior is None:
        return
    if arguments.stand is None:
        raise UsageError("--prior needs --stand FILE: without uncertainties nothing can be weighed")
    if arguments.monte_carlo is not None:
        raise UsageError("--monte-carlo draws runs alone, without a prior: leave out --prior")


def last_calibration(arguments: argparse.Namespace, recording: Recording) -> LastCalibration | None:
    """What the options name. Raises TumbleError."""
    from tumble.api import solving

    if arguments.prior != HISTORY:
        return solving.last_calibration(arguments.prior, arguments.growth)

    from tumble.documents.labels import iso
    from tumble.history import History

    facts = solving.facts_of(arguments.stand, recording.sha256)
    if facts.serial is None:
        raise UsageError("--prior: this run names no block: write serial under [block] of the stand file")
    declared = None if arguments.growth is None else solving.growth_of(arguments.growth)
    with History(_DB if arguments.db is None else arguments.db) as history:
        day = iso(facts.measured_s)[:10]
        return history.prior(facts.serial, on=day, other_than_run=recording.sha256, growth=declared)
