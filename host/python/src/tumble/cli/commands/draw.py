"""`tumble draw`: pictures of what one does with one's hands, and of the run and the bus, as SVG."""

from __future__ import annotations

import argparse
import sys

from tumble.cli import options
from tumble.errors import EXIT_PASS, UsageError
from tumble.schedule import file_of

_LARGEST_NUMBER = 255
_SUBJECTS = {
    "stand": "the stand: axis, table, gravity, where its angle begins and how it counts",
    "mountings": "how the block sits on the table in each mounting",
    "inclinations": "how the stand is inclined for a block that is bolted on once",
    "angles": "the table angles of a mounting's positions, and gravity on the block's axes",
    "states": "the states of a run, and what leads from one to another",
    "wiring": "the bus: nodes, identifiers, terminators",
}
_OF_A_SCHEDULE = ("stand", "mountings", "inclinations", "angles")


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Draw, as SVG, at most 170 mm wide. Exit codes: 0 done, 2 bad input, 77 matplotlib is not there, 130"
        " interrupted."
    )
    subjects = parser.add_subparsers(metavar="SUBJECT", required=True)
    for name, picture in _SUBJECTS.items():
        subject = subjects.add_parser(name, help=picture, description=f"Draw {picture}.")
        if name in _OF_A_SCHEDULE:
            options.add(subject, "--schedule")
        if name == "angles":
            subject.add_argument("--mounting", metavar="N", help="its number; default: the schedule's first")
        subject.add_argument("--out", metavar="FILE.svg", help="default: standard output, unless that is a terminal")
        subject.set_defaults(run_command=run, subject=name)


def run(arguments: argparse.Namespace) -> int:
    """Draw and write. Returns the exit code; raises TumbleError."""
    from tumble.files.disk import refuse_overwriting, write_text
    from tumble.pictures import require

    if arguments.out is not None:
        refuse_overwriting(arguments.out, file_of(getattr(arguments, "schedule", None)))
        options.require_ending(arguments.out, "--out", ".svg")
    elif sys.stdout.isatty():
        raise UsageError("a picture is no text for a terminal: --out FILE.svg")
    require("draw")
    text = _drawn(arguments)
    if arguments.out is None:
        sys.stdout.write(text)
    else:
        write_text(arguments.out, text)
    return EXIT_PASS


def _drawn(arguments: argparse.Namespace) -> str:
    from tumble import pictures
    from tumble.files.schedule_file import read_schedule

    if arguments.subject not in _OF_A_SCHEDULE:
        return pictures.svg(pictures.states() if arguments.subject == "states" else pictures.wiring())
    wanted = getattr(arguments, "mounting", None)
    number = None if wanted is None else options.parse_whole(wanted, "--mounting", 1, _LARGEST_NUMBER)
    schedule = read_schedule(arguments.schedule or "paper").data
    if arguments.subject == "angles":
        return pictures.svg(pictures.angles(schedule, schedule.mountings[0].number if number is None else number))
    of_schedule = {"stand": pictures.stand, "mountings": pictures.mountings, "inclinations": pictures.inclinations}
    return pictures.svg(of_schedule[arguments.subject](schedule))
