"""One interface to the node, whatever the link: objects are read and written by name, commands are given.

A name is that of the EDS file and of docs/modbus.csv: "State", "Progress: Actual angle", "Active set: K: K_xx".
"""

from __future__ import annotations

import logging
from abc import ABC, abstractmethod
from collections.abc import Callable
from numbers import Real
from typing import TypeVar

from tumble.errors import UsageError, quoted

T = TypeVar("T")
Value = int | float | str | None
RUN = "Run number"
TIMES_READ = 5  # until what takes several requests is of one run, or of one snapshot


_QUIET = logging.NullHandler()


def keep_quiet(*libraries: str) -> None:
    """What they say of a fault the exception says; whoever sets logging up sees it still."""
    for name in libraries:
        logging.getLogger(name).addHandler(_QUIET)


class Link(ABC):
    """Everything raises CommunicationError when nobody answers in time, and UsageError once the link is closed."""

    closed = False

    def require_open(self) -> None:
        """Before anything is asked: a library may open again what was closed."""
        if self.closed:
            raise UsageError("the link has been closed; connect anew")

    @abstractmethod
    def has(self, name: str) -> bool:
        """Whether the link offers this object."""

    @abstractmethod
    def read_together(self, *names: str) -> list[Value]:
        """Of objects, in this order, and of one run, of one moment where the link has such; None where the node has no
        value, or none now. Raises Refused."""

    @abstractmethod
    def write(self, name: str, value: float) -> None:
        """Into an object that is no command. Raises Refused."""

    @abstractmethod
    def command(self, number: int, argument: int = 0, angle_deg: float | None = None, proposal: int = 0) -> None:
        """Argument, angle and proposal first, then the command. What is read afterwards is newer. Raises Refused."""

    @abstractmethod
    def wait_for_news(self) -> None:
        """Return when what is read may be another than before."""

    @abstractmethod
    def close(self) -> None:
        """Leave the link."""

    def read(self, name: str) -> Value:
        """Of one object."""
        return self.read_together(name)[0]

    def of_one_moment(self, read: Callable[[], T]) -> T:
        """What `read` makes of several readings: all of one moment, where the link has such and is fast enough. It may
        be called several times for that."""
        return read()

    def fresh(self) -> None:  # noqa: B027 - nothing to do where nothing is kept
        """Return when what is read from now on is from after this call."""

    def step(self, _name: str, _value: float) -> float:
        """The least difference that the link itself lets be told about a value of an object; 0: none to speak of."""
        return 0.0


def require_number(what: str, value: object) -> None:
    """Raises UsageError."""
    if not isinstance(value, Real):
        raise UsageError(f"{what}: {quoted(value)} is no number")


def whole(value: float) -> int:
    """Raises ValueError, OverflowError for a number that is not."""
    if value != int(value):
        raise ValueError(f"{value} is no whole number")
    return int(value)


def number(value: Value) -> int | float:
    """Of an object that holds one, where the node has it; 0 where it has none."""
    return 0 if value is None or isinstance(value, str) else value
