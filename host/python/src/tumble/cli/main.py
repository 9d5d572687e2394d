"""The command line: `tumble COMMAND ...`. One line on stderr for whatever goes wrong, and a documented exit code."""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
import traceback
from collections.abc import Sequence
from typing import Any, NoReturn

from tumble import __version__, interruption
from tumble.cli import completion
from tumble.cli.commands import (
    apply,
    bench,
    compare,
    draw,
    export,
    fixture,
    import_recording,
    plan,
    replay,
    report,
    solve,
    store,
    uml,
    watch,
)
from tumble.errors import EXIT_BAD_INPUT, EXIT_DISAGREEMENT, EXIT_PASS, Interrupted, TumbleError, UsageError
from tumble.files.disk import reason
from tumble.messages import tell

_COMMANDS = (
    *(solve, import_recording, apply, compare, bench, watch, replay, plan, fixture, draw, export, report, store),
    uml,
)
_NEGATIVE = re.compile(r"-(\.?\d|[+-]{2}$)")  # or three signs, of --signs


class _Parser(argparse.ArgumentParser):
    """argparse, but an error is one line, and no option may be shortened."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **{**options, "allow_abbrev": False})
        self._negative_number_matcher = _NEGATIVE  # argparse's own, before Python 3.14, takes -1e-4 for an option

    def parse_known_args(  # type: ignore[override] # argparse declares it by overloads; this takes what they take
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[Any, list[str]]:
        """As argparse's, but a command complains itself of what it does not know, so that its own help is named."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown and self._subparsers is None:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return found, unknown

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message} (see {self.prog} --help)")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="tumble",
        description="Calibrate a three-axis block of accelerometers on a single-axis rotary stand.",
    )
    parser.add_argument("--version", action="version", version=f"tumble {__version__}")
    completion.add_to(parser)
    subparsers = parser.add_subparsers(metavar="COMMAND")
    for command in _COMMANDS:
        command.add_to(subparsers)
    parser.set_defaults(run_command=lambda _: _help(parser))
    return parser


def _help(parser: argparse.ArgumentParser) -> int:
    """What `tumble` alone says."""
    parser.print_help()
    return EXIT_PASS


def _complain(message: str) -> None:
    """Whatever is in it, a message is one line. Where nobody can read it, the exit code alone has to tell."""
    tell("tumble: " + message.replace("\r", "\\r").replace("\n", "\\n"))


def _prepare_output() -> None:
    """What the output's encoding does not have is escaped instead of failing in the middle. A standard stream that is
    closed does not become one of our files."""
    for stream in range(3):
        try:
            os.fstat(stream)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    if sys.stdout is None:
        raise UsageError("standard output is closed")
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def main(argv: list[str] | None = None, *, interruptible: bool = False) -> int:
    """Run one command. Returns the exit code; never raises, except SystemExit for --help and --version.

    `interruptible`: this process is the command's own, and signals that end it are to be handled from here on.
    """
    try:
        if interruptible:
            interruption.watch()
        _prepare_output()
        arguments = _parser().parse_args(argv)
        code: int = arguments.run_command(arguments)
        sys.stdout.flush()
        return code
    except Interrupted as error:
        _complain(str(error))
        return interruption.exit_code()
    except TumbleError as error:
        _complain(str(error))
        return error.exit_code
    except KeyboardInterrupt:
        _complain("interrupted")
        return interruption.exit_code()
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
        if interruption.has_come() and _is_of_an_interrupt(error):
            _complain("interrupted")
            return interruption.exit_code()
        if os.environ.get("TUMBLE_TRACEBACK"):
            traceback.print_exc()
        _complain(f"fault in tumble itself: {error!r} (TUMBLE_TRACEBACK=1 shows where)")
        return EXIT_DISAGREEMENT


def _is_of_an_interrupt(error: Exception) -> bool:
    """What an import makes of one: numpy an ImportError,
    Python 3.11 a RuntimeError that a class half made has caused."""
    causes: list[BaseException] = [error]
    while (cause := causes[-1].__cause__ or causes[-1].__context__) is not None and cause not in causes:
        causes.append(cause)
    return isinstance(error, ImportError) or any(isinstance(cause, KeyboardInterrupt) for cause in causes)


def _discard_output() -> None:
    """Let nothing more be written at exit to an output that is gone."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
