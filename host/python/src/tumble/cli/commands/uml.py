"""`tumble uml`: any command on a machine whose kernel has no CAN, with vcan0."""

from __future__ import annotations

import argparse


def describe(parser: argparse.ArgumentParser) -> None:
    parser.usage = "%(prog)s [-h] [-- COMMAND ...]"
    parser.description = (
        "Run a command inside user-mode Linux, a kernel as an ordinary process, where vcan0 is up. It may"
        " write in the directory it is called in, in the checkout, and in a TMPDIR that is deleted afterwards; its only"
        " networks are vcan0 and 127.0.0.1. All that it started ends with it."
    )
    parser.epilog = (
        "Exit codes: the command's; 3 user-mode Linux does not start or hangs, 77 it is not installed, 130 interrupted."
    )
    parser.add_argument("command", metavar="COMMAND ...", nargs=argparse.REMAINDER, help="default: a shell")
    parser.set_defaults(run_command=run)


def run(arguments: argparse.Namespace) -> int:
    """Run it. Returns its exit code; raises TumbleError."""
    from tumble.world import uml

    command = arguments.command
    return uml.run_command(command[1:] if command[:1] == ["--"] else command)
