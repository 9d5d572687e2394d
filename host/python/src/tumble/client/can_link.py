"""The link over CAN: python-canopen with the EDS files that come with the package."""

from __future__ import annotations

import contextlib
import errno
import os
import random
import struct
import sys
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, TypeGuard, TypeVar

from tumble import data
from tumble.client import link as links, names
from tumble.errors import NotInstalled, Skipped, UsageError, needing

if TYPE_CHECKING:
    import can

T = TypeVar("T")
EXTRA = "client"
SERVERS = {1: (0x600, 0x580), 2: (0x400, 0x380)}  # identifiers of request and response, to which the node is added
NEWS_S = 0.05  # between two looks at the node: a status takes 22 frames, so 440 a second, a tenth of 500 kbit/s
NO_VALUE = (links.NO_DATA, links.DEVICE_STATE, links.NO_SUCH_OBJECT, links.NO_SUCH_SUBINDEX)
_SIGNS_OF_ANOTHER = ("Unexpected response", "Node returned a value", "Toggle bit mismatch")  # python-canopen's words
_ASKED_AGAIN, _PAUSE_S = 20, 0.05
_TIMES_SILENT = 3  # before a node counts as silent: an answer may be lost where machines are busy
_ANSWERED_IN_VAIN = (0x05040000,)


def open_bus(where: str) -> can.BusABC:
    """A bus of python-can: an interface of Linux, KIND@CHANNEL for any other that python-can knows, or tumble@SCENARIO
    for a simulated world, whose time is the calling thread's until it is closed. Raises NotInstalled, Skipped where the
    kernel has no CAN or a driver is missing, UsageError."""
    with needing("a node on CAN", "python-can", extra=EXTRA):
        import can
    links.keep_quiet("can")
    kind, at, channel = where.rpartition("@")
    if not channel or (at and kind not in ("tumble", *can.VALID_INTERFACES)):
        raise UsageError(f"can:{where} is neither can:INTERFACE nor can:KIND@CHANNEL with a kind that python-can knows")
    try:
        if kind == "tumble":
            from tumble.world.virtual_bus import VirtualBus

            return VirtualBus(channel, script_time=True)
        return can.Bus(interface=kind or "socketcan", channel=channel)
    except (can.CanInterfaceNotImplementedError, AttributeError) as error:  # the latter: a Python without socket.AF_CAN
        raise Skipped(f"can:{where}: {error}") from None
    except (can.CanError, OSError, ValueError) as error:
        number = getattr(error, "errno", None)
        if number in (errno.EAFNOSUPPORT, errno.EPROTONOSUPPORT):
            raise Skipped(f"can:{where}: this kernel has no CAN ({os.strerror(number)})") from None
        if number in (errno.ENODEV, errno.ENXIO):
            raise UsageError(f"can:{where}: there is no CAN interface of this name") from None
        raise UsageError(f"can:{where} cannot be opened: {error}") from None


def is_bus(link: object) -> TypeGuard[can.BusABC]:
    """Whether it is one of python-can, which is loaded then."""
    can = sys.modules.get("can")
    return can is not None and isinstance(link, can.BusABC)


class _Disturbed(links.CommunicationError):
    """The answer belongs to the request of another client."""


class _Unanswered(links.CommunicationError):
    """No answer came in time."""


class CanLink(links.Link):
    """A node over SDO. `bus` stays open on close if `owned` is False. `server`: the SDO server of the node to use."""

    def __init__(self, bus: can.BusABC, node: int = 1, server: int = 1, answer_s: float = 2.0, owned: bool = True):
        try:
            import canopen
        except ModuleNotFoundError:
            if owned:
                bus.shutdown()
            raise NotInstalled("a node on CAN", "python-canopen", extra=EXTRA) from None
        self._abort, self._silence = canopen.SdoAbortedError, canopen.SdoCommunicationError
        self._real = canopen.objectdictionary.datatypes.FLOAT_TYPES
        self._misfit = (struct.error, ValueError, canopen.ObjectDictionaryError)
        links.keep_quiet("can", "canopen")
        self._owned, self._answer_s = owned, answer_s
        self.network = canopen.Network(bus)
        self.network.NOTIFIER_CYCLE = 0.01
        self._sdo = self.add_node(node, "navcomp", server)
        try:
            self.network.connect()
        except ValueError:
            raise UsageError("the bus has a client, or another Notifier of python-can, already") from None
        assert self.network.notifier is not None
        self.network.notifier.add_listener(_patience(self.network.notifier))

    def add_node(self, number: int, name: str, server: int = 1) -> Any:
        """Add the SDO client of another node on the same bus. `name`: of its EDS file."""
        node: Any = self.network.add_node(number, str(data.file(f"eds/tumble_{name}.eds")))  # add_sdo has no types
        request, response = SERVERS[server]
        sdo = node.sdo if server == 1 else node.add_sdo(request + number, response + number)
        sdo.network, sdo.RESPONSE_TIMEOUT = self.network, self._answer_s
        return sdo

    def has(self, name: str) -> bool:
        return _has(self._sdo, name)

    def read_together(self, *names: str) -> list[links.Value]:
        """Read several objects between two equal readings of the run number. Raises Refused, CommunicationError."""
        if len(names) == 1:
            return [self.ask(self._sdo, names[0])]
        others = [name for name in names if name != links.RUN]
        run = self.ask(self._sdo, links.RUN)
        for _ in range(links.TIMES_READ):
            found = {links.RUN: run, **{name: self.ask(self._sdo, name) for name in others}}
            run = self.ask(self._sdo, links.RUN)
            if run == found[links.RUN]:
                return [found[name] for name in names]
        raise links.CommunicationError("runs begin faster than the node can be read")

    def ask(self, sdo: Any, name: str) -> links.Value:
        """Of a node's object."""
        return _repeated(lambda: self._ask_once(sdo, name))

    def _ask_once(self, sdo: Any, name: str) -> links.Value:
        what = f"reading {name}"
        try:
            with self._transfer(sdo, what):
                value: links.Value = _entry(sdo, name, what).raw
                return value
        except links.Refused as refusal:
            if _has(sdo, name) and refusal.code in NO_VALUE:
                return None
            raise

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
        links.require_number(what, value)
        entry = _entry(self._sdo, name, what)
        try:
            data = entry.od.encode_raw(value if entry.od.data_type in self._real else links.whole(value))
        except (struct.error, ValueError, OverflowError):
            raise links.Refused(what, links.OUT_OF_RANGE) from None
        with self._transfer(self._sdo, what):
            entry.data = data

    @contextlib.contextmanager
    def _transfer(self, sdo: Any, what: str) -> Iterator[None]:
        """Make one SDO transfer. Turns whatever the libraries raise into errors of the client."""
        from can import CanError

        self.require_open()
        try:
            yield
        except self._abort as error:
            if error.code in _ANSWERED_IN_VAIN:
                raise _silent(sdo, error) from None
            raise links.Refused(what, error.code) from None
        except self._silence as error:
            raise _silent(sdo, error) from None
        except (CanError, OSError) as error:
            raise links.CommunicationError(f"the bus takes no request: {error}") from None
        except self._misfit as error:
            raise links.CommunicationError(f"node {sdo.rx_cobid & 0x7F}, {what}: {error}") from None

    def wait_for_news(self) -> None:
        time.sleep(NEWS_S)

    def close(self) -> None:
        import can

        self.closed = True
        bus, self.network.bus = self.network.bus, None  # canopen would shut down what is not ours
        with contextlib.suppress(can.CanError):  # the bus has gone before us
            self.network.disconnect()
        if self._owned and bus is not None:
            bus.shutdown()


def _repeated(act: Callable[[], T]) -> T:
    """Retry a call that is safe to repeat: while answers to another SDO client, such as a gateway, interfere, and a few
    times when no answer comes."""
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


def _has(sdo: Any, name: str) -> bool:
    """Whether the EDS file has this entry. A record as a whole is not an entry."""
    parent, child = _split(name)
    if parent not in sdo.od:
        return False
    entries = getattr(sdo.od[parent], "names", None)
    return not child if entries is None else child in entries


def _entry(sdo: Any, name: str, what: str) -> Any:
    if not _has(sdo, name):
        raise links.Refused(what, links.NO_SUCH_OBJECT)
    parent, child = _split(name)
    return sdo[parent][child] if child else sdo[parent]


def _patience(notifier: can.Notifier) -> can.Listener:
    """Keep python-canopen running over errors of the bus. Without this, its first error ends its thread, and the link
    does not recover when the bus comes back."""
    import can

    class Patience(can.Listener):
        def on_message_received(self, msg: can.Message) -> None:
            pass

        def on_error(self, _exc: Exception) -> None:
            notifier.exception = None
            time.sleep(_PAUSE_S)

    return Patience()


def _silent(sdo: Any, error: Exception) -> links.CommunicationError:
    number = sdo.rx_cobid & 0x7F
    if any(sign in str(error) for sign in _SIGNS_OF_ANOTHER):
        return _Disturbed(f"node {number} answers another SDO client as well, say a gateway: {error}")
    return _Unanswered(f"node {number} does not answer: {error}")
