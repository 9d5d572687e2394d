"""`tumble replay`: a recorded bus log through the firmware again, here or on the emulated board; same bits."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from tumble.cli import options
from tumble.errors import EXIT_LIMITS_FAILED, EXIT_PASS, UsageError
from tumble.estimators import COEFFICIENTS

if TYPE_CHECKING:
    from tumble.documents.bench import Replay


def describe(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Feed a recorded bus log, in order and at its recorded times, to the firmware of node 1 and ignore"
        " what it sends: the coefficients come out with the same bits as in the run, on every processor."
    )
    parser.epilog = (
        "Exit codes: 0 pass, 1 gravity check failed, 2 bad input, 3 the run does not come to a result, 77 the"
        " emulator or what reads such logs is not there, 130 interrupted."
    )
    parser.add_argument(
        "log",
        metavar="BUS.log",
        nargs="?",
        help="of a run folder or of any interface: candump -L, ASC, BLF, TRC, MF4, CSV of python-can",
    )
    options.add(parser, "--firmware")
    parser.add_argument(
        "--scenario",
        metavar="FILE",
        help="of the recorded run; default: inputs/scenario.txt beside the log, else the paper's stand",
    )
    parser.add_argument(
        "--recording", metavar="FILE", help="replay nothing: write the log in the form that a board replays"
    )
    parser.add_argument(
        "--commissioning",
        metavar="FILE",
        help="replay nothing: write a record of the stand and block of --scenario for the board zcu102",
    )
    options.add(parser, "--json")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Replay, print. Returns the exit code; raises TumbleError."""
    import json

    from tumble.documents.bench import written
    from tumble.world import replay

    if arguments.commissioning is not None:
        if arguments.log is not None:
            raise UsageError("--commissioning: takes no BUS.log; --scenario gives the contents of the record")
        return _write(arguments, "commissioning", replay.commissioning(arguments.scenario))
    if arguments.log is None:
        raise UsageError("the following arguments are required: BUS.log")
    scenario = arguments.scenario or replay.default_scenario(arguments.log)
    if arguments.recording is not None:
        return _write(arguments, "recording", replay.recording(replay.read(arguments.log), scenario))
    found = replay.replay(arguments.log, scenario, arguments.firmware)
    if arguments.json:
        print(json.dumps(written(found), allow_nan=False))
    else:
        _print(found)
    return EXIT_PASS if found.passed else EXIT_LIMITS_FAILED


def _write(arguments: argparse.Namespace, option: str, data: bytes) -> int:
    from tumble.files.disk import refuse_overwriting, write_bytes

    file = getattr(arguments, option)
    refuse_overwriting(file, arguments.log, arguments.scenario, option=f"--{option}")
    write_bytes(file, data)
    return EXIT_PASS


def _print(found: Replay) -> None:
    verdict, counters = "passes" if found.passed else "FAILS", found.counters
    print(f"{found.log} on {found.firmware}: {verdict} the gravity check;", end=" ")
    print(f"{counters.received} frames, {counters.averaged} samples averaged, {counters.lost} lost")
    if found.time_step_us is not None:  # another program has rounded its times
        rounded = "" if found.time_step_us == 1 else f", whose times are multiples of {found.time_step_us} us here"
        print(f"  read as {found.format}{rounded}")
    numbers = [*found.K.ravel().tolist(), *found.U0.tolist()]
    for name, number, bits in zip(COEFFICIENTS, numbers, found.bits, strict=True):
        print(f"  {name:4}  {number:+.17g}  {'V/g' if name[0] == 'K' else 'V  '}  {bits}")
    sys.stdout.flush()
