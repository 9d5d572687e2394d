"""The wiring: who is on the bus, with which identifiers, and what ends it."""

from __future__ import annotations

from tumble.drawings.svg import INK, LARGE, LINE, PLATE, SOFT, WIDTH, Page
from tumble.drawings.tables import CONSUMER_MS, HEARTBEAT_MS, NODES, PROCESS_DATA, SAMPLES

TERMINATOR_OHM = 120
_KBIT_S = 500

_MARGIN = 4.0
_HIGH, _LOW = 49.0, 53.0  # the two wires
_ENDS = (14.0, 156.0)
_BOX = (46.0, 43.0)
_TOP = 66.0  # of the nodes' boxes
_CENTRES = {1: 34.0, 2: 85.0, 3: 136.0}
_NAMES = {  # by the node's name in its table: what it is called, and what it is
    "navcomp": ("navigation computer", "leads the run"),
    "drive": ("drive of the stand", "turns the table"),
    "block": ("accelerometer block", "turns with the table"),
}


def wiring() -> str:
    """SVG: the line with its two ends, the three nodes, gateway and host."""
    page = Page("The bus: three nodes, a gateway, a host", _about())
    page.text((_MARGIN, 7.0), "On the bus", size=LARGE + 0.6, bold=True)
    _line(page)
    _host(page)
    for number, name, *services in NODES:
        _node(page, number, name, services)
    return page.document(_notes(page))


def _about() -> str:
    line = f"One line, CAN_H and CAN_L, {_KBIT_S} kbit/s, with {TERMINATOR_OHM} ohm at each end and nowhere else."
    nodes = [f"Node {one}: {_NAMES[name][0]}, {', '.join(_identifiers(one, rest))}." for one, name, *rest in NODES]
    return " ".join([line, *nodes, "A gateway to Modbus, or a host, may listen on the line and ask node 1."])


def _identifiers(number: int, services: list[int]) -> list[str]:
    """What a node sends and hears, a line each."""
    emergency, answer, request, heartbeat = services
    hears, sends = PROCESS_DATA[number]
    samples = SAMPLES if number == 3 else ()
    lines = [f"heartbeat {_hex(heartbeat)}", f"emergency {_hex(emergency)}"]
    lines += [f"SDO {_hex(request)}, answer {_hex(answer)}"]
    lines += [f"sends {', '.join(map(_hex, sends))}"] if sends else []
    lines += [f"hears {', '.join(map(_hex, hears))}"] if hears else []
    return lines + ([f"samples {', '.join(map(_hex, samples))}"] if samples else [])


def _hex(identifier: int) -> str:
    return f"{identifier:03X}h"


def _line(page: Page) -> None:
    """CAN_H and CAN_L, with a resistor between them at both ends."""
    for y, name in ((_HIGH, "CAN_H"), (_LOW, "CAN_L")):
        page.line([(_ENDS[0], y), (_ENDS[1], y)], INK, 0.6, wire=name)
    page.text((_ENDS[0] + 4.0, _HIGH - 1.4), "CAN_H")
    page.text((_ENDS[0] + 4.0, _LOW + 4.0), "CAN_L")
    for x, side in ((_ENDS[0], -1), (_ENDS[1], 1)):
        page.line([(x, _HIGH), (x + side * 5.0, _HIGH), (x + side * 5.0, _LOW), (x, _LOW)], INK, 0.6)
        page.box((x + side * 5.0 - 1.3, _HIGH - 0.8), 2.6, _LOW - _HIGH + 1.6, "#ffffff")
        page.text((x + side * 4.0, _LOW + 9.0), f"{TERMINATOR_OHM} Ω", "middle", bold=True, terminator=TERMINATOR_OHM)


def _stub(page: Page, x: float, y: float) -> None:
    """Two wires from the line to a box above or below it."""
    for shift, wire in ((-1.2, _HIGH), (1.2, _LOW)):
        page.line([(x + shift, wire), (x + shift, y)], INK, 0.4)
        page.circle((x + shift, wire), 0.7, INK)


def _node(page: Page, number: int, name: str, services: list[int]) -> None:
    x = _CENTRES[number]
    called, does = _NAMES[name]
    _stub(page, x, _TOP)
    with page.group(node=number):
        page.box((x - _BOX[0] / 2, _TOP), *_BOX, fill=PLATE)
        page.text((x, _TOP + 5.0), f"node {number}", "middle", LARGE, bold=True)
        page.text((x, _TOP + 10.0), called, "middle", bold=True)
        page.text((x, _TOP + 14.5), does, "middle", colour=SOFT)
        for index, line in enumerate(_identifiers(number, services)):
            page.text((x - _BOX[0] / 2 + 2.5, _TOP + 21.0 + index * LINE), line)


def _host(page: Page) -> None:
    """What has no number: gateway and host, above the line; behind the gateway whoever speaks Modbus."""
    for x, name, does in ((54.0, "gateway", "asks node 1 by SDO"), (118.0, "host", "listens; asks node 1")):
        _stub(page, x, 36.0)
        with page.group(guest=name):
            page.box((x - 23.0, 22.0), 46.0, 14.0, "#ffffff")
            page.text((x, 28.0), name, "middle", LARGE, bold=True)
            page.text((x, 33.0), does, "middle", colour=SOFT)
    page.line([(54.0, 22.0), (54.0, 16.0)], INK, 0.4, "1.5 1")
    page.text((54.0, 14.0), "Modbus, TCP or serial: PLC, scripts", "middle", colour=SOFT)
    page.text((118.0, 19.5), "a laptop, a logger", "middle", colour=SOFT)


def _notes(page: Page) -> float:
    y = _TOP + _BOX[1] + 7.0
    for text in (
        f"{_KBIT_S} kbit/s, one line, short stubs, a common ground. {TERMINATOR_OHM} Ω at the two ends of the line and"
        f" nowhere else: {TERMINATOR_OHM // 2} Ω between CAN_H and CAN_L with everything switched off.",
        f"Node 1 starts and stops the others (000h). All send a heartbeat every {HEARTBEAT_MS} ms; where one fails for"
        f" {CONSUMER_MS} ms, node 1 or the drive stops the table. The emergency stop cuts the drive's power and does"
        " not use this bus.",
        "The drive's process data are those of its profile; the usual ones are shown.",
    ):
        y = page.paragraph((_MARGIN, y), text, WIDTH - 2 * _MARGIN) + 0.8
    return y
