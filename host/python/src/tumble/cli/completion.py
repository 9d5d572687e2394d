"""`tumble --print-completion SHELL`: what makes the shell complete commands, options and names of files, by shtab."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from typing import Any

from tumble.errors import NotInstalled

SHELLS = ("bash", "zsh", "tcsh")
_FILES = ("FILE", "RUN", "RESULT", "DATA", "BUS", "IMAGE", "SCHEDULE", "RECORDING")  # how metavars of files begin


class _Print(argparse.Action):
    """Print the script and end, as --help does."""

    def __call__(
        self, parser: argparse.ArgumentParser, _namespace: Any, shell: str | Sequence[Any] | None, *_: Any
    ) -> None:
        try:
            import shtab
        except ImportError:
            raise NotInstalled("--print-completion", "shtab", extra="completion") from None
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


def add_to(parser: argparse.ArgumentParser) -> None:
    """--print-completion."""
    parser.add_argument(
        "--print-completion",
        action=_Print,
        choices=SHELLS,
        metavar="SHELL",
        help=f"print what makes {', '.join(SHELLS[:-1])} or {SHELLS[-1]} complete commands and options, and exit",
    )
