"""The command line: `tumble COMMAND ...`. One line on stderr for whatever goes wrong, and a documented exit code."""

from __future__ import annotations

import argparse
import io
import os
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from importlib import import_module
from typing import Any, NoReturn

from tumble import __version__, errors, interruption
from tumble.cli.commands import COMMANDS
from tumble.cli.options import choose_estimator
from tumble.messages import tell

ANSWERED = 10  # of `parse`: it was --help or --version
_UNKNOWN = "unrecognized arguments: "
SHELLS = ("bash", "zsh", "tcsh")
_FILES = ("FILE", "RUN", "RESULT", "DATA", "BUS", "IMAGE", "SCHEDULE", "RECORDING")  # how metavars of files begin
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
        """As argparse's, and an example: of several commands, that of the first."""
        examples = (one for command in COMMANDS.values() for one in command.examples)
        example = next(one for one in examples if f"{one} ".startswith(f"{self.prog} "))
        return f"{super().format_help()}\nExample: {example}\n"

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
        raise errors.UsageError(f"{message} (see {self.prog} --help)")


def _guess(word: str, known: Iterable[str]) -> str:
    """What a misspelt word may have been; empty where nothing is like it."""
    import difflib

    alike = difflib.get_close_matches(word, list(known), n=1, cutoff=0.7)
    return f"; did you mean {alike[0]}?" if alike else ""


class _PrintCompletion(argparse.Action):
    """Print a script, made by shtab, with which a shell completes commands, options and names of files; then exit."""

    def __call__(
        self, parser: argparse.ArgumentParser, _namespace: Any, shell: str | Sequence[Any] | None, *_: Any
    ) -> None:
        with errors.needing("--print-completion", "shtab", extra="completion"):
            import shtab
        for action in _actions(parser):
            if action.choices is None and str(action.metavar).startswith(_FILES):
                action.complete = shtab.FILE  # type: ignore[attr-defined] # where shtab looks for it
        print(shtab.complete(parser, shell=str(shell)))
        parser.exit()


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Of a parser and of all commands below it."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)


def _parser(arguments: Sequence[str] | None = None) -> argparse.ArgumentParser:
    """With all commands; or with the one that is among the `arguments`, and of the others the names, and what they are
    about."""
    parser = _Parser(
        prog="tumble",
        description="Calibrate a three-axis block of accelerometers on a single-axis rotary stand.",
    )
    parser.add_argument("--version", action="version", version=f"tumble {__version__}")
    parser.add_argument(
        "--print-completion",
        action=_PrintCompletion,
        choices=SHELLS,
        metavar="SHELL",
        help=f"print what makes {errors.listed(SHELLS, 'or')} complete commands and options, and exit",
    )
    all_of_them = arguments is None or any(word.startswith("--print-completion") for word in arguments)
    names = {name for one, command in COMMANDS.items() for name in (one, *command.aliases)}
    named = next((word for word in arguments or () if word in names), None)
    subparsers = parser.add_subparsers(metavar="COMMAND")
    for name, command in COMMANDS.items():
        description = f"{command.about[0].upper()}{command.about[1:]}."
        one = subparsers.add_parser(name, aliases=command.aliases, help=command.about, description=description)
        if all_of_them or named in (name, *command.aliases):
            import_module(f"tumble.cli.commands.{command.module or name}").describe(one)
    parser.set_defaults(run_command=lambda _: _help(parser))
    return parser


def _help(parser: argparse.ArgumentParser) -> int:
    """What `tumble` alone says."""
    parser.print_help()
    return errors.EXIT_PASS


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
        raise errors.UsageError("standard output is closed")
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")


def parse(arguments: list[str]) -> int:
    """Everything but the run, for host/python/usage.py, whose exit codes these are. A result that is not there is told
    too, before anything is installed for it."""
    try:
        _prepare_output()
        if not arguments:
            _help(_parser(()))
            return ANSWERED
        result = getattr(_parser(arguments).parse_args(arguments), "result", None)
        if isinstance(result, str) and not os.path.exists(result):  # not opened: a pipe can be read once
            raise errors.BadInput("no such file or folder", result)
    except SystemExit:
        return ANSWERED
    except (errors.UsageError, errors.BadInput) as error:
        _complain(str(error))
        return error.exit_code
    except errors.TumbleError:
        pass  # it wants what only a set-up brings
    return errors.EXIT_PASS


def main(argv: list[str] | None = None, *, interruptible: bool = False) -> int:
    """Run one command. Returns the exit code; never raises, except SystemExit for --help and --version.

    `interruptible`: this process is the command's own, and signals that end it are to be handled from here on.
    """
    try:
        if interruptible:
            interruption.watch()
        _prepare_output()
        given = sys.argv[1:] if argv is None else argv
        arguments = _parser(given).parse_args(given)
        choose_estimator(arguments)
        code: int = arguments.run_command(arguments)
        sys.stdout.flush()
        return code
    except errors.Interrupted as error:
        _complain(str(error))
        return interruption.exit_code()
    except errors.TumbleError as error:
        if error.assumed:
            tell("took: " + "; ".join(error.assumed))
        _complain(str(error))
        if error.remedy:
            tell(error.remedy)
        return error.exit_code
    except KeyboardInterrupt:
        _complain("interrupted")
        return interruption.exit_code()
    except BrokenPipeError:
        _discard_output()
        return errors.EXIT_BAD_INPUT
    except OSError as error:
        from tumble.files.disk import reason

        _discard_output()
        _complain(f"standard output cannot be written: {reason(error)}")
        return errors.EXIT_BAD_INPUT
    except MemoryError:
        _complain("not enough memory for this input")
        return errors.EXIT_BAD_INPUT
    except Exception as error:
        if interruption.has_come() and _is_of_an_interrupt(error):
            _complain("interrupted")
            return interruption.exit_code()
        if os.environ.get("TUMBLE_TRACEBACK"):
            import traceback

            traceback.print_exc()
        _complain(f"fault in tumble itself: {error!r} (TUMBLE_TRACEBACK=1 shows where)")
        return errors.EXIT_DISAGREEMENT


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
