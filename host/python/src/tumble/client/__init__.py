"""Talk to a navigation computer, over CAN or Modbus: start a run, wait, read its result (docs/client.md).

    import tumble.client

    with tumble.client.connect("can:can0") as node:
        node.start()
        node.wait(until="DONE", timeout=600)
        print(node.result().K)

Needs python-can and python-canopen, or pymodbus: pip install './host/python[client]'. `connect` alone loads them.

    node                    a navigation computer as a script sees it
    link                    objects by name, whatever the link
    can_link, modbus_link   the link over CAN, over Modbus
    names, tables           the firmware's numbers as names; the names of its objects
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from tumble.client.can_link import CanLink, is_bus, open_bus
from tumble.client.link import CommunicationError, Link, NoResult, Refused, RunFailed, RunGone, TimedOut
from tumble.client.modbus_link import ModbusLink
from tumble.client.names import COMMAND, Objection, Reason
from tumble.client.node import Node, Result, Settings, Status
from tumble.errors import UsageError, quoted

if TYPE_CHECKING:
    import can

__all__ = [
    "COMMAND",
    "LINKS",
    "CanLink",
    "CommunicationError",
    "Link",
    "ModbusLink",
    "NoResult",
    "Node",
    "Objection",
    "Reason",
    "Refused",
    "Result",
    "RunFailed",
    "RunGone",
    "Settings",
    "Status",
    "TimedOut",
    "connect",
    "open_link",
]

LINKS = "can:INTERFACE, can:KIND@CHANNEL, modbus:HOST:PORT or modbus-rtu:DEVICE[,BAUD[,PARITY]]"
DEFAULT_BAUD = 19200
PARITIES = ("N", "E", "O")


def connect(link: str | can.BusABC, *, node: int = 1, server: int = 1, unit: int = 1) -> Node:
    """Open a link and return the node on it. Close the node, or use it as a context manager.

    `link`: "can:can0", "can:virtual@test" (any interface of python-can), "modbus:HOST:PORT", "modbus-rtu:/dev/ttyUSB0",
    which may go on with ",19200,E"; or a bus of python-can, which stays open. `node`: the CANopen node number.
    `server`: the node's SDO server to use, 1 or 2. `unit`: the Modbus unit of the gateway.

    Raises UsageError for a link that does not parse or an interface that cannot be opened, NotInstalled, Skipped where
    the kernel has no CAN or a driver is missing, CommunicationError where nothing answers.
    """
    return Node(open_link(link, node, server, unit))


def open_link(link: str | can.BusABC, node: int = 1, server: int = 1, unit: int = 1) -> Link:
    """Open the link alone, to read and write objects by name. Arguments and errors as of `connect`."""
    for name, value, last in (("node", node, 127), ("server", server, 2), ("unit", unit, 255)):
        if not isinstance(value, int) or not 1 <= value <= last:
            raise UsageError(f"{name} {quoted(value)} is not 1 to {last}")
    if is_bus(link):
        return CanLink(link, node, server, owned=False)
    kind, _, where = str(link).partition(":")
    if kind == "can" and where:
        return CanLink(open_bus(where), node, server)
    if kind == "modbus" and where:
        return ModbusLink.tcp(*_host_and_port(where), unit)
    if kind == "modbus-rtu" and where:
        return ModbusLink.rtu(*_serial(where), unit)
    raise UsageError(f"the link {quoted(link)} is not {LINKS}")


def _host_and_port(where: str) -> tuple[str, int]:
    host, _, port = where.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise UsageError(f"the link modbus:{where} has no HOST:PORT")
    return host.strip("[]"), int(port)


def _serial(where: str) -> tuple[str, int, str]:
    device, baud, parity = (*where.split(","), "", "")[:3]
    baud, parity = baud or str(DEFAULT_BAUD), parity or "E"
    if not device or not baud.isdigit() or parity not in PARITIES or where.count(",") > 2:
        raise UsageError(f"the link modbus-rtu:{where} is not DEVICE[,BAUD[,PARITY]] with parity N, E or O")
    return device, int(baud), parity
