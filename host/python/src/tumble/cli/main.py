"""The command line: `tumble COMMAND ...`. One line on stderr for whatever goes wrong, and a documented exit code."""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn

from tumble import __version__, interruption
from tumble.cli import completion
from tumble.cli.aliases import ALIASES
from tumble.cli.commands import ABOUT, EXAMPLES, adder_of
from tumble.errors import EXIT_BAD_INPUT, EXIT_DISAGREEMENT, EXIT_PASS, Interrupted, TumbleError, UsageError
from tumble.messages import tell

ANSWERED = 10  # of `parse`: it was --help or --version
_UNKNOWN = "unrecognized arguments: "
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
            self.error(f"{_UNKNOWN}{' '.join(unknown)}")
        return found, unknown

    def format_help(self) -> str:
        """As argparse's, and an example."""
        example = EXAMPLES.get(self.prog.partition(" ")[2])
        return super().format_help() + (f"\nExample: {example}\n" if example else "")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """As argparse's, with a guess at what was meant."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            guess = _guess(str(value), map(str, action.choices or ()))
            raise argparse.ArgumentError(action, f"{error.message}{guess}") from None

    def error(self, message: str) -> NoReturn:
        if message.startswith(_UNKNOWN):
            options = [word.partition("=")[0] for word in message[len(_UNKNOWN) :].split() if word.startswith("--")]
            message += "".join(_guess(one, self._option_string_actions) for one in options[:1])
        raise UsageError(f"{message} (see {self.prog} --help)")


def _guess(word: str, known: Iterable[str]) -> str:
    """What a misspelt word may have been; empty where nothing is like it."""
    import difflib

    alike = difflib.get_close_matches(word, list(known), n=1, cutoff=0.7)
    return f"; did you mean {alike[0]}?" if alike else ""


def _named(argv: Sequence[str]) -> str | None:
    """The one command that is needed to parse this; empty for none of them, None for all."""
    if any(word.startswith("--print-completion") for word in argv):
        return None
    names = {name: name for name in ABOUT} | {alias: name for name, others in ALIASES.items() for alias in others}
    return next((names[word] for word in argv if word in names), "")


def _parser(wanted: str | None = None) -> argparse.ArgumentParser:
    """With all commands, or with the one that is `wanted`: of the others the names, and what they are about."""
    parser = _Parser(
        prog="tumble",
        description="Calibrate a three-axis block of accelerometers on a single-axis rotary stand.",
    )
    parser.add_argument("--version", action="version", version=f"tumble {__version__}")
    completion.add_to(parser)
    subparsers = parser.add_subparsers(metavar="COMMAND")
    for name, about in ABOUT.items():
        if wanted in (None, name):
            adder_of(name)(subparsers, about)
        else:
            subparsers.add_parser(name, aliases=ALIASES.get(name, ()), help=about)
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


def parse(words: list[str]) -> int:
    """Everything but the run, for host/python/usage.py, whose exit codes these are."""
    try:
        _prepare_output()
        if not words:
            _help(_parser(""))
            return ANSWERED
        _parser(_named(words)).parse_args(words)
    except SystemExit:
        return ANSWERED
    except UsageError as error:
        _complain(str(error))
        return error.exit_code
    except TumbleError:
        pass  # it wants what only a set-up brings
    return EXIT_PASS


def main(argv: list[str] | None = None, *, interruptible: bool = False) -> int:
    """Run one command. Returns the exit code; never raises, except SystemExit for --help and --version.

    `interruptible`: this process is the command's own, and signals that end it are to be handled from here on.
    """
    try:
        if interruptible:
            interruption.watch()
        _prepare_output()
        words = sys.argv[1:] if argv is None else argv
        arguments = _parser(_named(words)).parse_args(words)
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
        from tumble.files.disk import reason

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
            import traceback

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
