"""The command line: `tumble COMMAND ...`. One line on stderr for whatever goes wrong, and a documented exit code."""

from __future__ import annotations

import argparse
import io
import os
import signal
import sys
import traceback

from tumble import __version__
from tumble.commands import bench, export, fixture, plan, solve
from tumble.errors import EXIT_BAD_INPUT, EXIT_DISAGREEMENT, EXIT_INTERRUPTED, TumbleError, UsageError
from tumble.files import reason

_COMMANDS = (solve, bench, plan, fixture, export)


class _Parser(argparse.ArgumentParser):
    """argparse, but an error is one line, and no option may be shortened."""

    def __init__(self, *args, **options):
        super().__init__(*args, **{**options, "allow_abbrev": False})

    def error(self, message: str):
        raise UsageError(f"{message} (see {self.prog} --help)")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="tumble",
        description="Calibrate a three-axis block of accelerometers on a single-axis rotary stand.",
    )
    parser.add_argument("--version", action="version", version=f"tumble {__version__}")
    subparsers = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in _COMMANDS:
        command.add_to(subparsers)
    return parser


def _complain(message: str) -> None:
    """Whatever is in it, a message is one line. Where nobody can read it, the exit code alone has to tell."""
    try:
        print("tumble: " + message.replace("\r", "\\r").replace("\n", "\\n"), file=sys.stderr or io.StringIO())
    except OSError:
        sys.stderr = None


def _prepare_output() -> None:
    """What the output's encoding does not have is escaped instead of failing in the middle."""
    if sys.stdout is None:
        raise UsageError("standard output is closed")
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def main(argv: list[str] | None = None, interrupt=None) -> int:
    """Run one command. Returns the exit code; never raises, except SystemExit for --help and --version.

    `interrupt`: the handler of SIGINT to take up from here on, if any.
    """
    try:
        if interrupt is not None:
            signal.signal(signal.SIGINT, interrupt)
        _prepare_output()
        arguments = _parser().parse_args(argv)
        code = arguments.run_command(arguments)
        sys.stdout.flush()
        return code
    except TumbleError as error:
        _complain(str(error))
        return error.exit_code
    except KeyboardInterrupt:
        _complain("interrupted")
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        _discard_output()
        return EXIT_BAD_INPUT
    except OSError as error:
        _discard_output()
        _complain(f"standard output cannot be written: {reason(error)}")
        return EXIT_BAD_INPUT
    except MemoryError:
        _complain("not enough memory for this input")
        return EXIT_BAD_INPUT
    except Exception as error:
        if os.environ.get("TUMBLE_TRACEBACK"):
            traceback.print_exc()
        _complain(f"fault in tumble itself: {error!r} (TUMBLE_TRACEBACK=1 shows where)")
        return EXIT_DISAGREEMENT


def _discard_output() -> None:
    """Let nothing more be written at exit to an output that is gone."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
