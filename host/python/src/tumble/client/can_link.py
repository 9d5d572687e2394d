"""The link over CAN: python-canopen with the EDS files that come with the package."""

from __future__ import annotations

import contextlib
import errno
import logging
import random
import struct
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from tumble import data
from tumble.client import names
from tumble.client.errors import (
    DEVICE_STATE,
    NO_DATA,
    NO_SUCH_OBJECT,
    NO_SUCH_SUBINDEX,
    OUT_OF_RANGE,
    CommunicationError,
    Refused,
)
from tumble.client.link import RUN, TIMES_READ, Link, Value
from tumble.errors import NotInstalled, Skipped, UsageError

if TYPE_CHECKING:
    import can

T = TypeVar("T")
EXTRA = "client"
SERVERS = {1: (0x600, 0x580), 2: (0x400, 0x380)}  # identifiers of request and response, to which the node is added
NEWS_S = 0.05  # between two looks at the node: a status takes 22 frames, so 440 a second, a tenth of 500 kbit/s
NO_VALUE = (NO_DATA, DEVICE_STATE, NO_SUCH_OBJECT, NO_SUCH_SUBINDEX)
_SIGNS_OF_ANOTHER = ("Unexpected response", "Node returned a value", "Toggle bit mismatch")  # python-canopen's words
_ASKED_AGAIN, _PAUSE_S = 20, 0.05
_TIMES_SILENT = 3  # before a node counts as silent: an answer may be lost where machines are busy
_ANSWERED_IN_VAIN = (0x05040000,)


def open_bus(where: str) -> can.BusABC:
    """A bus of python-can: an interface of Linux, or KIND@CHANNEL for any other that python-can knows. Raises
    NotInstalled, Skipped where the kernel has no CAN, UsageError."""
    try:
        import can
    except ModuleNotFoundError:
        raise NotInstalled("a node on CAN", "python-can", extra=EXTRA) from None
    kind, _, channel = where.rpartition("@")
    try:
        if kind == "tumble":
            from tumble.canbus import TumbleBus

            return TumbleBus(channel)
        return can.Bus(interface=kind or "socketcan", channel=channel)
    except OSError as error:
        if error.errno in (errno.ENODEV, errno.ENXIO):
            raise UsageError(f"can:{where}: there is no CAN interface of this name") from None
        raise Skipped(f"can:{where}: this kernel has no CAN ({error.strerror})") from None
    except (can.CanError, AttributeError) as error:  # AttributeError: a Python without socket.AF_CAN
        raise Skipped(f"can:{where}: {error}") from None


class _Disturbed(CommunicationError):
    """The answer was to a question of somebody else's."""


class _Unanswered(CommunicationError):
    """No answer came in time."""


class CanLink(Link):
    """A node by SDO. `bus`: is left open in the end if `owned` is False; `server`: which of the node's SDO servers."""

    def __init__(self, bus: can.BusABC, node: int = 1, server: int = 1, answer_s: float = 2.0, owned: bool = True):
        try:
            import canopen
        except ModuleNotFoundError:
            if owned:
                bus.shutdown()
            raise NotInstalled("a node on CAN", "python-canopen", extra=EXTRA) from None
        self._abort, self._silence = canopen.SdoAbortedError, canopen.SdoCommunicationError
        logging.getLogger("canopen").addHandler(logging.NullHandler())  # what it says of a lost answer, we say or mend
        self._owned, self._answer_s = owned, answer_s
        self.network = canopen.Network(bus)
        self.network.NOTIFIER_CYCLE = 0.01
        self.network.connect()
        self._sdo = self.add_node(node, "navcomp", server)

    def add_node(self, number: int, name: str, server: int = 1) -> Any:
        """The SDO client of another node on the same bus; `name`: of its EDS file."""
        node: Any = self.network.add_node(number, str(data.file(f"eds/tumble_{name}.eds")))  # add_sdo has no types
        request, response = SERVERS[server]
        sdo = node.sdo if server == 1 else node.add_sdo(request + number, response + number)
        sdo.network, sdo.RESPONSE_TIMEOUT = self.network, self._answer_s
        return sdo

    def has(self, name: str) -> bool:
        parent, child = _split(name)
        entries = self._sdo.od
        return parent in entries and (not child or child in entries[parent])

    def read_together(self, *names: str) -> list[Value]:
        """Between two readings of the run number that are equal. Raises Refused, CommunicationError."""
        if len(names) == 1:
            return [self.ask(self._sdo, names[0])]
        others = [name for name in names if name != RUN]
        run = self.ask(self._sdo, RUN)
        for _ in range(TIMES_READ):
            found = {RUN: run, **{name: self.ask(self._sdo, name) for name in others}}
            run = self.ask(self._sdo, RUN)
            if run == found[RUN]:
                return [found[name] for name in names]
        raise CommunicationError("runs begin faster than the node can be read")

    def ask(self, sdo: Any, name: str) -> Value:
        """Of a node's object."""
        return _repeated(lambda: self._ask_once(sdo, name))

    def _ask_once(self, sdo: Any, name: str) -> Value:
        try:
            value: Value = _entry(sdo, name, f"reading {name}").raw
            return value
        except self._abort as error:
            if error.code in NO_VALUE:
                return None
            raise self._refused(f"reading {name}", sdo, error) from None
        except (self._silence, OSError) as error:
            raise _silent(sdo, error) from None

    def write(self, name: str, value: float) -> None:
        _repeated(lambda: self._tell(name, value, f"writing {name}"))

    def command(self, number: int, argument: int = 0, angle_deg: float | None = None, proposal: int = 0) -> None:
        self.write("Command: Argument", argument)
        if angle_deg is not None:
            self.write("Command: Angle", angle_deg)
        if proposal:
            self.write("Command: Proposal", proposal)
        self._tell("Command: Command", number, names.command(number))

    def _tell(self, name: str, value: float, what: str) -> None:
        entry = _entry(self._sdo, name, what)
        try:
            entry.raw = value
        except self._abort as error:
            raise self._refused(what, self._sdo, error) from None
        except (struct.error, ValueError, OverflowError, TypeError):  # python-canopen's, before anything is sent
            raise Refused(what, OUT_OF_RANGE) from None
        except (self._silence, OSError) as error:
            raise _silent(self._sdo, error) from None

    def _refused(self, what: str, sdo: Any, error: Any) -> CommunicationError | Refused:
        return _silent(sdo, error) if error.code in _ANSWERED_IN_VAIN else Refused(what, error.code)

    def wait_for_news(self) -> None:
        time.sleep(NEWS_S)

    def close(self) -> None:
        import can

        bus, self.network.bus = self.network.bus, None  # canopen would shut down what is not ours
        with contextlib.suppress(can.CanError):  # the bus has gone before us
            self.network.disconnect()
        if self._owned and bus is not None:
            bus.shutdown()


def _repeated(act: Callable[[], T]) -> T:
    """What does no harm if it is done twice: again while the answers to another SDO client, such as a gateway, come
    between, and a few times when there is none."""
    silent = 0
    for _ in range(_ASKED_AGAIN):
        try:
            return act()
        except _Disturbed:
            time.sleep(random.uniform(0.0, _PAUSE_S))
        except _Unanswered:
            silent += 1
            if silent == _TIMES_SILENT:
                raise
    return act()


def _split(name: str) -> tuple[str, str]:
    """Of an object, and of the entry in it."""
    parent, _, child = name.rpartition(": ")
    return (parent, child) if parent else (child, "")


def _entry(sdo: Any, name: str, what: str) -> Any:
    parent, child = _split(name)
    try:
        return sdo[parent][child] if child else sdo[parent]
    except KeyError:
        raise Refused(what, NO_SUCH_OBJECT) from None


def _silent(sdo: Any, error: Exception) -> CommunicationError:
    number = sdo.rx_cobid & 0x7F
    if any(sign in str(error) for sign in _SIGNS_OF_ANOTHER):
        return _Disturbed(f"node {number} answers another SDO client as well, say a gateway: {error}")
    return _Unanswered(f"node {number} does not answer: {error}")
