"""What can go wrong, as the user is told: one line, and an exit code.

0 pass   1 limits failed   2 usage or bad input   3 fault of the bench, disagreement with numpy   77 skipped: what it
needs is not there   130 interrupted
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

EXIT_PASS = 0
EXIT_LIMITS_FAILED = 1
EXIT_BAD_INPUT = 2
EXIT_DISAGREEMENT = 3
EXIT_SKIPPED = 77
EXIT_INTERRUPTED = 130

_LONGEST_QUOTE = 40
_CHECKOUT = Path(__file__).parents[4]  # if this is one
_PROFILES = {"plot": "plot", "report": "report", "watch": "watch", "client": "watch"}  # of tools/setup, by extra
_ON_PYPI = {  # where more is to be installed than the one that was missed
    "can": "python-can cantools",
    "acquire": "pyvisa pyvisa-py pyserial",
    "ros": "rosbags mcap",
}


def listed(words: Sequence[object], last: str = "and") -> str:
    """Such as "a, b and c"; at least one."""
    *others, end = map(str, words)
    return f"{', '.join(others)} {last} {end}" if others else end


def quoted(text: object, longest: int = _LONGEST_QUOTE) -> str:
    """Foreign text, made fit for one line of a message: quoted, escaped, cut to `longest` characters."""
    text = str(text)
    return ascii(text if len(text) <= longest else text[: longest - 3] + "...")


def file_name(path: str | os.PathLike[str]) -> str:
    """A path as it may stand in a one-line message."""
    text = os.fspath(path)
    return text if text.isprintable() else ascii(text)


class Remedy(NamedTuple):
    """What may cure a refusal: `options` by name as they are typed, None: left out; and the `condition` under which
    that is right, empty: none."""

    options: Mapping[str, str | None]
    condition: str = ""


ErrorT = TypeVar("ErrorT", bound="TumbleError")


class TumbleError(Exception):
    """An outcome that ends the command with one line on stderr and `exit_code`. Of a recording that cannot be imported,
    `assumed`: what was taken for granted so far; `remedies`: what is worth a try, likeliest first; `remedy`: lines with
    the command that has been tried and works."""

    exit_code = EXIT_BAD_INPUT
    assumed: tuple[str, ...] = ()
    remedies: tuple[Remedy, ...] = ()
    remedy = ""

    def advising(self: ErrorT, *remedies: Remedy) -> ErrorT:
        """The same with these remedies."""
        self.remedies = remedies
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """From process to process as it is; those with a constructor of their own are made without it."""
        return _again, (type(self), self.args, self.__dict__)


def _again(kind: type[TumbleError], args: tuple[Any, ...], state: dict[str, Any]) -> TumbleError:
    error = kind.__new__(kind, *args)
    error.__dict__.update(state)
    return error


class UsageError(TumbleError, ValueError):
    """A caller, or the command line, asks for something that is not there."""


class BadInput(TumbleError, ValueError):
    """A file or a table cannot be used. Says which, and where known in which row (line number, from 1) and column or
    key."""

    def __init__(self, message: str, file: str | os.PathLike[str], row: int | None = None, column: str | None = None):
        place = [] if row is None else [f"row {row}"]
        place += [] if column is None else [f"column {column}"]
        self.fault = message
        self.row = row
        self.column = column
        super().__init__(": ".join([file_name(file), *([", ".join(place)] if place else []), message]))


class BenchFault(TumbleError):
    """A run on the bench that failed: a fault of the stand, of the block, of the bus, or of the bench itself."""

    exit_code = EXIT_DISAGREEMENT


class Skipped(TumbleError):
    """This machine lacks something that the command needs. Says what to install."""

    exit_code = EXIT_SKIPPED


class NotInstalled(Skipped, ImportError):
    """A Python package that only some inputs need is not there. Says how to get it: by tools/setup in a checkout, by
    its pip what that does not bring; elsewhere, where the package itself is installed already, by its extra, or by the
    packages of `debian`, if it is a library that no pip brings."""

    def __init__(self, needed_for: str, *packages: str, extra: str, debian: str = ""):
        listed = " or ".join(packages)
        if (remedy := set_up(_PROFILES.get(extra, ""))) is None:
            remedy = f"sudo apt-get install {debian}" if debian else f"{_pip()} install 'tumble[{extra}]'"
        elif extra not in _PROFILES:
            remedy = f"{file_name(_shorter(_CHECKOUT / '.venv/bin/pip'))} install {_ON_PYPI.get(extra, packages[0])}"
        super().__init__(f"{needed_for} needs {listed}: {remedy}")


def set_up(profile: str) -> str | None:
    """The command that sets a checkout up for a profile, from where this one works; None where this is none."""
    setup = _CHECKOUT / "tools/setup"
    return f"{file_name(_shorter(setup))} {profile}" if setup.exists() else None


def _pip() -> str:
    """How the pip of this environment is called, which need not be the one that is found by its name."""
    from shutil import which

    own = Path(sys.executable).with_name("pip")
    return "pip" if which("pip") == os.fspath(own) else f"{file_name(_shorter(Path(sys.executable)))} -m pip"


@contextmanager
def needing(needed_for: str, *packages: str, extra: str) -> Iterator[None]:
    """What is imported within has to be there. Raises NotInstalled; without `packages` it names the one that is
    missing."""
    try:
        yield
    except ImportError as error:
        raise NotInstalled(needed_for, *(packages or (error.name or "a package",)), extra=extra) from None


def _shorter(path: Path) -> str:
    """From the working directory, if the path lies below it."""
    try:
        return os.fspath(path.relative_to(Path.cwd()))
    except (ValueError, OSError):
        return os.fspath(path)


class Interrupted(TumbleError):
    """The user did not want to wait for the end; the table was stopped first."""

    exit_code = EXIT_INTERRUPTED


class Disagreement(BenchFault):
    """The firmware core and the numpy witness do not agree: one of them is wrong, so neither result is given."""
