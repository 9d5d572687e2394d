"""One interface to the node for all links: read and write objects by name, give commands.

A name is that of the EDS file and of docs/modbus.csv: "State", "Progress: Actual angle", "Active set: K: K_xx". Every
error is a `tumble.errors.TumbleError` with a text of one line. The register map of docs/modbus.csv is at the end of the
module: where values stand, how they are packed, and their resolution.
"""

from __future__ import annotations

import csv
import functools
import logging
import math
import struct
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import TypeVar

from tumble import data
from tumble.client.names import Reason, abort_code
from tumble.errors import BadInput, BenchFault, UsageError, quoted

NO_SUCH_OBJECT = 0x06020000
NO_SUCH_SUBINDEX = 0x06090011
READ_ONLY = 0x06010002
OUT_OF_RANGE = 0x06090030
NO_DATA = 0x08000024
DEVICE_STATE = 0x08000022
_WORDS = {
    DEVICE_STATE: "the state does not allow it",
    OUT_OF_RANGE: "value out of range",
    0x06090031: "value too high",
    0x06090032: "value too low",
    0x08000020: "the signature is wrong",
    0x06060000: "the memory failed",
    NO_SUCH_OBJECT: "no such object",
    NO_SUCH_SUBINDEX: "no such object",
    READ_ONLY: "it is read only",
}


class CommunicationError(BenchFault):
    """The node or the gateway does not answer, or its answer is not one of Tumble."""


class Refused(BenchFault):
    """The node refuses a request. `what`: the request. `code`: the SDO abort code; the message has it in words if it is
    a common one."""

    def __init__(self, what: str, code: int, hint: str = ""):
        self.what, self.code = what, code
        super().__init__(f"{what} was refused: {_WORDS.get(code, 'abort code')} ({abort_code(code)}){hint}")


class RunFailed(BenchFault):
    """The run has stopped. `state`: FAULT, after which it can be resumed, or ABORT. `reason`: why, and what to do.
    `drive_refusal`: what the drive refused, "" for nothing."""

    def __init__(self, state: str, reason: Reason, drive_refusal: str = ""):
        self.state, self.reason, self.drive_refusal = state, reason, drive_refusal
        super().__init__(f"the run is in {state}: {reason}{drive_refusal and f' ({drive_refusal})'}")


class RunGone(RunFailed):
    """The run that was waited for no longer exists: the node has restarted, or another run has begun. `run`: the number
    of the run. `state`, `reason`: the current ones of the node."""

    def __init__(self, run: int, now: int, state: str, reason: Reason):
        self.run, self.state, self.reason, self.drive_refusal = run, state, reason, ""
        why = "the node has restarted" if now < run else f"run {now} has begun"
        BenchFault.__init__(self, f"run {run} is gone: {why}; the state is {state}")


class TimedOut(BenchFault, TimeoutError):
    """The expected state did not come in time. `state`: the last one seen."""

    def __init__(self, waited_for: str, timeout_s: float, state: str):
        self.state = state
        super().__init__(f"{waited_for} did not come within {timeout_s:g} s; the state is {state}")


class NoResult(BenchFault):
    """The node has no result: no run has finished since power-on, or since the last START."""


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
    """A link to a node. Every method raises CommunicationError when nothing answers in time, and UsageError once the
    link is closed."""

    closed = False

    def require_open(self) -> None:
        """Before anything is asked: a library may open again what was closed."""
        if self.closed:
            raise UsageError("the link is closed; connect again")

    @abstractmethod
    def has(self, name: str) -> bool:
        """Whether the link offers this object."""

    @abstractmethod
    def read_together(self, *names: str) -> list[Value]:
        """Read several objects, in this order, of one run; and of one moment where the link supports that. None where
        the node has no value. Raises Refused."""

    @abstractmethod
    def write(self, name: str, value: float) -> None:
        """Write an object that is not a command. Raises Refused."""

    @abstractmethod
    def command(self, number: int, argument: int = 0, angle_deg: float | None = None, proposal: int = 0) -> None:
        """Write argument, angle and proposal, then the command. Later readings are newer than the command. Raises
        Refused."""

    @abstractmethod
    def wait_for_news(self) -> None:
        """Wait until another reading may differ from the last one."""

    @abstractmethod
    def close(self) -> None:
        """Leave the link."""

    def read(self, name: str) -> Value:
        """Of one object."""
        return self.read_together(name)[0]

    def of_one_moment(self, read: Callable[[], T]) -> T:
        """Call `read`, which makes several readings, so that all of them are of one moment, where the link supports
        that and is fast enough. May call `read` several times."""
        return read()

    def fresh(self) -> None:  # noqa: B027 - nothing to do where nothing is kept
        """Wait until later readings are newer than this call."""

    def step(self, _name: str, _value: float) -> float:
        """The smallest difference of the object that the link can transmit near this value; 0 if negligible."""
        return 0.0


def require_number(what: str, value: object) -> None:
    """Raises UsageError."""
    if not isinstance(value, Real):
        raise UsageError(f"{what}: {quoted(value)} is not a number")


def whole(value: float) -> int:
    """Raises ValueError, OverflowError for a number that is not."""
    if value != int(value):
        raise ValueError(f"{value} is not a whole number")
    return int(value)


def number(value: Value) -> int | float:
    """Of an object that holds one, where the node has it; 0 where it has none."""
    return 0 if value is None or isinstance(value, str) else value


MOST_WORDS = 125  # of one request
OF_SCALED = " (scaled)"  # the name of a number that is also there in floating point
_FORMS = {"u16": ">H", "i16": ">h", "u32": ">I", "i32": ">i", "f32": ">f", "u64": ">Q", "i64": ">q", "f64": ">d"}
_SINGLE_BITS, _SINGLE_LEAST = 24, -149  # of an f32: bits of its fraction, exponent of the least number


@dataclass(frozen=True)
class Register:
    """A row of the register map: `words` registers, starting at `at`. `valid`: register and bit that mark the value as
    valid."""

    at: int
    words: int
    type: str
    scale: float | None
    valid: tuple[int, int] | None

    def number(self, words: Sequence[int]) -> int | float | str:
        """Decode registers, the high word first."""
        packed = struct.pack(f">{len(words)}H", *words)
        if self.type == "text":
            return packed.rstrip(b"\0").decode("latin-1")
        number: int | float = struct.unpack(_FORMS[self.type], packed)[0]
        return number if self.scale is None else number * self.scale

    def pack(self, value: float) -> list[int]:
        """Encode a number. Raises ValueError, OverflowError, struct.error for a number that does not fit."""
        if self.type in ("f32", "f64"):
            number = value
        else:
            number = whole(value) if self.scale is None else round(value / self.scale)
        return list(struct.unpack(f">{self.words}H", struct.pack(_FORMS[self.type], number)))

    def step(self, value: float) -> float:
        """The distance between neighbouring numbers near a value; 0 if every number can be represented."""
        if self.type != "f32":
            return self.scale or 0.0
        return math.ldexp(1.0, max(math.frexp(value)[1] - _SINGLE_BITS, _SINGLE_LEAST)) if value else 2.0**_SINGLE_LEAST

    @property
    def needs(self) -> list[tuple[int, int]]:
        """The registers to read for the value: (first register, count) of each."""
        return [(self.at, self.words)] + ([] if self.valid is None else [(self.valid[0], 1)])


@dataclass(frozen=True)
class RegisterMap:
    """Registers by name. `input`: the registers of a value, which may exist as floating point and scaled. `holding`:
    writable registers. `settings`: their numbers. `kinds`: unit and type of the settings."""

    input: dict[str, list[Register]]
    holding: dict[str, Register]
    settings: dict[str, int]
    kinds: dict[str, tuple[str, str]]


@functools.cache
def read_map(file: Path | None = None) -> RegisterMap:
    """Read a register map. `file`: None for the one of the package. Raises BadInput."""
    found, objects = RegisterMap({}, {}, {}, {}), dict[tuple[str, str], str]()
    path = file or data.file("docs/modbus.csv")
    try:
        with open(path, encoding="utf-8", newline="") as lines:
            for row in csv.DictReader(lines):
                _take(found, objects, row)
    except (OSError, KeyError, ValueError) as error:
        raise BadInput(f"no register map: {error}", path) from None
    return found


def _take(found: RegisterMap, objects: dict[tuple[str, str], str], row: Mapping[str, str]) -> None:
    """Registers of one object go by the name of the first of them."""
    name, at = row["name"], int(row["register"])
    if row["table"] == "setting":
        found.settings[name], found.kinds[name] = at, (row["unit"], row["type"])
        return
    valid = (int(row["valid_register"]), int(row["valid_bit"])) if row["valid_register"] else None
    scale = float(row["scale"]) if row["scale"] else None
    register = Register(at, int(row["words"]), row["type"], scale, valid)
    if row["table"] == "holding":
        found.holding[name] = register
    else:
        name = name.removesuffix(OF_SCALED)
        name = objects.setdefault((row["index"], row["subindex"]), name) if row["index"] else name
        found.input.setdefault(name, []).append(register)


def requests(wanted: Sequence[Register]) -> list[tuple[int, int]]:
    """The fewest requests that read all of these registers, in rising order: (first register, count)."""
    made: list[tuple[int, int]] = []
    for at, words in sorted(need for register in wanted for need in register.needs):
        if made and at + words - made[-1][0] <= MOST_WORDS:
            made[-1] = made[-1][0], max(made[-1][1], at + words - made[-1][0])
        else:
            made.append((at, words))
    return made


def finest(found: Sequence[Register], words: Mapping[int, int]) -> Value:
    """The value of a name from its valid register with the best resolution; None if none is valid."""
    best: tuple[float, Value] = (math.inf, None)
    for register in found:
        if register.valid is None or words[register.valid[0]] >> register.valid[1] & 1:
            value = register.number([words[register.at + place] for place in range(register.words)])
            step = register.step(value) if len(found) > 1 and not isinstance(value, str) else 0.0
            best = min(best, (step, value), key=lambda one: one[0])
    return best[1]
