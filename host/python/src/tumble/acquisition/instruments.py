"""Instruments that speak lines of text: rotary tables, multimeters, converters, inertial units, through PyVISA or a
serial port; and the file that describes them (TOML, docs/first-calibration.md).

A port whose name has "::" is a VISA resource, such as TCPIP0::192.0.2.7::inst0::INSTR; any other is one of pyserial,
such as /dev/ttyUSB0, COM3 or socket://192.0.2.7:4001.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, Protocol

from tumble.acquisition.run import (
    DEFAULT_REST_TIMEOUT_S,
    DEFAULT_SAMPLES,
    FEWEST_SAMPLES,
    MOST_SAMPLES,
    Drive,
)
from tumble.defaults import DEFAULT_SCHEDULE
from tumble.errors import BenchFault, TumbleError, needing, quoted
from tumble.files.toml import Table, read_toml
from tumble.units import is_unit, spelled

_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_UNFINISHED = 3  # lines of an instrument that sends by itself: the first may be the end of one
_ANY_DEG = 3600.0


class _Line(Protocol):
    """What PyVISA has of an instrument, and pyserial is given here."""

    def write(self, line: str) -> object: ...

    def read(self) -> str: ...

    def close(self) -> object: ...


class _Serial:
    """A serial port, line by line."""

    def __init__(self, port: str, baud: int, timeout_s: float):
        with needing(f"{port}: a serial port", "pyserial", extra="acquire"):
            import serial
        self._port = serial.serial_for_url(port, baudrate=baud, timeout=timeout_s, write_timeout=timeout_s)

    def write(self, line: str) -> object:
        return self._port.write(line.encode("ascii") + b"\r\n")

    def read(self) -> str:
        line: bytes = self._port.read_until(b"\n")
        if not line.endswith(b"\n"):
            raise TimeoutError("no answer" if not line else f"only {quoted(line)} of an answer")
        return line.decode("ascii", errors="replace").strip()

    def forget(self) -> None:
        """What came while nobody read."""
        self._port.reset_input_buffer()

    def close(self) -> object:
        return self._port.close()


class Instrument:
    """One, at the `port` of its table in the file. Raises BenchFault, naming the port; NotInstalled."""

    def __init__(self, table: Table):
        self.port = table.text("port")
        baud, timeout_s = table.integer("baud", 50, 4_000_000, 115200), table.number("answer_s", 0.01, 60.0, 2.0)
        self.is_serial = "::" not in self.port
        with self._named():
            self._line: _Line = (
                _Serial(self.port, baud, timeout_s)
                if self.is_serial
                else _visa(self.port, baud, timeout_s, table.text("visa", "@py"))
            )

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Whatever a library or the system says of it."""
        try:
            yield
        except TumbleError:
            raise
        except Exception as error:
            raise BenchFault(f"{self.port}: {quoted(error or type(error).__name__, 120)}") from None

    def tell(self, command: str) -> None:
        """Send a line."""
        with self._named():
            self._line.write(command)

    def numbers(self, question: str | None = None) -> list[float]:
        """All in the next line that it sends, or in its answer to a question."""
        with self._named():
            if question is not None:
                self._line.write(question)
            return [float(one) for one in _NUMBER.findall(self._line.read())]

    def forget(self) -> None:
        """What a serial port has received while nobody read."""
        if isinstance(self._line, _Serial):
            with self._named():
                self._line.forget()

    def close(self) -> None:
        """The port is free again."""
        with self._named():
            self._line.close()


def _visa(resource: str, baud: int, timeout_s: float, library: str) -> Any:
    with needing(f"{resource}: a VISA resource", "pyvisa", "pyvisa-py", extra="acquire"):
        import pyvisa
    options: dict[str, Any] = {"read_termination": "\n", "write_termination": "\n", "timeout": 1000.0 * timeout_s}
    if resource.upper().startswith("ASRL"):
        options["baud_rate"] = baud
    return pyvisa.ResourceManager(library).open_resource(resource, **options)


class RotaryTable:
    """Turned by lines of text; asked where it is, while it turns and when it is there. Its table in the file:

    limits_deg [low, high]; move, such as "POS {angle_deg:.4f}"; stop; angle, a question; tolerance_deg (0.01);
    timeout_s (120), for one motion; poll_s (0.2)
    """

    def __init__(self, table: Table):
        table.only(
            *("port", "baud", "answer_s", "visa", "limits_deg", "move", "stop", "angle"),
            *("tolerance_deg", "timeout_s", "poll_s"),
        )
        self._low, self._high = table.vector("limits_deg", 2)
        self._move, self._stop, self._angle = table.text("move"), table.text("stop"), table.text("angle")
        self._tolerance_deg = table.number("tolerance_deg", 1e-6, 10.0, 0.01)
        self._timeout_s = table.number("timeout_s", 0.1, 3600.0, 120.0)
        self._poll_s = table.number("poll_s", 0.0, 10.0, 0.2)
        try:
            told = {self._move.format(angle_deg=angle) for angle in (-_ANY_DEG, _ANY_DEG)}
        except (LookupError, ValueError, AttributeError):
            told = set()
        if len(told) < 2:
            raise table.refuse('must say where to, such as "POS {angle_deg:.4f}"', "move")
        if not self._low < self._high:
            raise table.refuse("must be the lowest and the highest angle", "limits_deg")
        self.instrument = Instrument(table)

    @property
    def drive(self) -> Drive:
        """As a run takes it."""
        return Drive(self.turn, lambda: self.instrument.tell(self._stop), (self._low, self._high))

    def turn(self, angle_deg: float) -> None:
        """To an angle within the limits; returns when it is there. Raises BenchFault where it says that it is beyond
        the limits, and where it does not come."""
        self.instrument.tell(self._move.format(angle_deg=angle_deg))
        end = time.monotonic() + self._timeout_s
        while True:
            answer = self.instrument.numbers(self._angle)
            if not answer:
                raise BenchFault(f"{self.instrument.port}: no number answers {quoted(self._angle)}")
            at_deg = answer[0]
            if abs((at_deg - angle_deg + 180.0) % 360.0 - 180.0) <= self._tolerance_deg:
                return
            told = f"{self.instrument.port}: the table is at {at_deg:g} deg"
            if not self._low - self._tolerance_deg <= at_deg <= self._high + self._tolerance_deg:
                raise BenchFault(f"{told}, beyond its limits, {self._low:g} to {self._high:g} deg")
            if time.monotonic() >= end:
                raise BenchFault(f"{told} after {self._timeout_s:g} s, and should be at {angle_deg:g} deg")
            time.sleep(self._poll_s)


class Block:
    """Three outputs, asked for one after another or together, or sent by themselves. Its table in the file:

    unit; ask, a question or three (none: it sends lines by itself, on a serial port); values, the places of ux, uy, uz
    among the numbers of a line ([1, 2, 3]; of one of three answers [1, 1, 1]); factor (1), of every number
    """

    def __init__(self, table: Table):
        table.only("port", "baud", "answer_s", "visa", "unit", "ask", "values", "factor")
        self.unit = spelled(table.text("unit"))
        if not is_unit(self.unit):
            raise table.refuse("must be the name of a unit, such as V or m/s^2", "unit")
        self._questions = table.texts("ask")
        if len(self._questions) not in (0, 1, 3):
            raise table.refuse("must be a question or three", "ask")
        places = table.vector("values", 3) if "values" in table.keys else (1.0, 2.0, 3.0)
        if len(self._questions) == 3 and "values" not in table.keys:
            places = (1.0, 1.0, 1.0)
        if not all(one == int(one) and 1 <= one <= 100 for one in places):
            raise table.refuse("must be three places, from 1", "values")
        self._places = [int(one) - 1 for one in places]
        self._factor = table.number("factor", default=1.0)
        if not self._questions and "::" in table.text("port"):
            raise table.refuse("is missing: only a serial port may send lines by itself", "ask")
        self.instrument = Instrument(table)

    def read(self) -> list[float]:
        """One sample, in `unit`. Raises BenchFault."""
        if len(self._questions) == 3:
            lines = [self.instrument.numbers(one) for one in self._questions]
            if all(len(line) > place for line, place in zip(lines, self._places)):
                return [self._factor * line[place] for line, place in zip(lines, self._places)]
        for _ in range(_UNFINISHED):
            line = self.instrument.numbers(*self._questions[:1])
            if len(line) > max(self._places):
                return [self._factor * line[place] for place in self._places]
        needed = max(self._places) + 1
        raise BenchFault(f"{self.instrument.port}: a line has fewer numbers than {needed}, which `values` needs")


@dataclass(frozen=True)
class Bench:
    """What a file describes: `schedule`, a built-in one's name or a file; `samples` at a position; `drive`, None where
    the table is turned by hand; `read`, which gives a sample in `unit`; `forget`, what came while nobody read."""

    schedule: str
    samples: int
    rest_timeout_s: float
    drive: Drive | None
    read: Callable[[], list[float]]
    forget: Callable[[], None]
    unit: str


@contextmanager
def opened(file: str) -> Iterator[Bench]:
    """The bench that a file describes, its ports open meanwhile. Raises BadInput with its row, BenchFault,
    NotInstalled."""
    top = read_toml(file).only("schedule", "samples", "rest_timeout_s", "table", "block")
    by_name = {name: top.table(name) for name in ("table", "block")}
    if by_name["block"] is None:
        raise top.refuse("no [block], which says how its outputs are read")
    schedule = top.text("schedule", DEFAULT_SCHEDULE)
    samples = top.integer("samples", FEWEST_SAMPLES, MOST_SAMPLES, DEFAULT_SAMPLES)
    rest_timeout_s = top.number("rest_timeout_s", 1.0, 3600.0, DEFAULT_REST_TIMEOUT_S)
    with ExitStack() as stack:
        block = Block(by_name["block"])
        stack.callback(block.instrument.close)
        table = None if by_name["table"] is None else RotaryTable(by_name["table"])
        if table is not None:
            stack.callback(table.instrument.close)
        drive = None if table is None else table.drive
        yield Bench(schedule, samples, rest_timeout_s, drive, block.read, block.instrument.forget, block.unit)
