"""The states of a run with all ways between them, and the bus: as the firmware's own tables have them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tumble.firmware_tables import CONSUMER_MS, HEARTBEAT_MS, NODES, PROCESS_DATA, SAMPLES, STATES, WAYS
from tumble.pictures import canvas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MIDDLE: dict[str, Any] = {"ha": "center"}
_BOLD: dict[str, Any] = {"ha": "center", "fontweight": "bold"}

# The run, mm: boxes in columns and rows.
_COLUMNS, _ROWS, _WIDE, _HIGH = (4.0, 44.0, 84.0, 124.0), (13.0, 50.0, 87.0, 124.0), 32.0, 27.0
_NAMES = "IDLE PREFLIGHT WARM_UP NEXT FAULT MOVE HOME WAIT_MOUNTING ABORT SETTLE AVERAGE - DONE PROPOSE VERIFY SOLVE"
_PLACES = dict(zip(_NAMES.split(), ((x, y) for y in _ROWS for x in _COLUMNS)))
_AT_REST = ("IDLE", "DONE", "FAULT", "ABORT")
_RUNS_ON = ("done", "other")  # ways that a run takes by itself, drawn as arrows; the others are letters in the box
_FIRST = ("IDLE", "START")  # has an arrow as well: where one begins to read
_SIGNS = {  # letter and what it is called
    "START": ("S", "START"),
    "RESUME": ("U", "RESUME"),
    "CONFIRM": ("C", "CONFIRM_MOUNTING"),
    "REPEAT": ("P", "REPEAT_POSITION, REPEAT_MOUNTING"),
    "ABORT": ("A", "ABORT"),
    "fault": ("F", "a fault, or a time that has run out"),
}
_ROUND: dict[tuple[str, str], tuple[str, tuple[float, float], str]] = {  # way round, mm; place and side of its words
    ("AVERAGE", "NEXT"): ("116,100.5 161,100.5 161,26.5 156,26.5", (0.0, 0.0), "left"),
    ("NEXT", "SOLVE"): ("156,21.5 165.5,21.5 165.5,137.5 156,137.5", (164.0, 115.0), "right"),
    ("SETTLE", "SETTLE"): ("50,114 50,119.5 40.5,119.5 40.5,100.5 44,100.5", (39.5, 119.0), "right"),
    ("AVERAGE", "SETTLE"): ("100,114 100,119.5 66,119.5 66,114", (68.0, 118.0), "left"),
}


@canvas.picture
def states() -> Figure:
    """The state diagram of a run. Arrows: where it goes by itself; letters: commands, and faults."""
    about = [f"{name}: {sentence}." for name, sentence in STATES.items()]
    about += [f"{begin} to {end} by {by}{f' ({note})' if note else ''}." for begin, end, by, note in WAYS]
    page = canvas.sheet("states", "The states of a run", " ".join(about))
    for begin, end, by, note in WAYS:
        if by in _RUNS_ON or (begin, by) == _FIRST:
            path, (x, y), side = _ROUND.get((begin, end), (_straight(begin, end), (0.0, 0.0), "left"))
            places = [[float(one) for one in place.split(",")] for place in path.split()]
            style: Any = "-" if by in _RUNS_ON else (0.0, (2.4, 1.8))
            canvas.arrow(page, places, linestyle=style, label=f"{begin} {end} {by}")
            for index, line in enumerate(canvas.wrapped(note, 34.0)):
                page.text(x, y + 3.6 * index, line, ha=side)
    for name, sentence in STATES.items():
        x, y = _PLACES[name]
        canvas.box(page, x, y, _WIDE, _HIGH, facecolor=canvas.PLATE if name in _AT_REST else "white", label=name)
        page.text(x + _WIDE / 2, y + 4.2, name, **_BOLD)
        for index, line in enumerate(canvas.wrapped(sentence, _WIDE - 1.5)):
            page.text(x + _WIDE / 2, y + 8.4 + 3.6 * index, line, color=canvas.SOFT, **_MIDDLE)
        leaving = [(end, by) for begin, end, by, _ in WAYS if begin == name and by not in _RUNS_ON]
        for index, (end, by) in enumerate(leaving):
            _sign(page, x + 3.2 + 5.2 * index, y + _HIGH - 2.9, by, f"{name} {end} {by}")
    return canvas.cut(page, _legend(page, _ROWS[3] + _HIGH + 8.0))


def _straight(begin: str, end: str) -> str:
    """From the edge of a box to that of its neighbour in the same row or column."""
    (x, y), (to_x, to_y) = _PLACES[begin], _PLACES[end]
    if y == to_y:
        left, right = (x + _WIDE, to_x) if to_x > x else (x, to_x + _WIDE)
        return f"{left},{y + _HIGH / 2} {right},{y + _HIGH / 2}"
    return f"{x + _WIDE / 2},{y + _HIGH} {x + _WIDE / 2},{to_y}"  # downwards: none goes up


def _sign(page: Axes, x: float, y: float, by: str, label: str) -> None:
    """A letter in a circle; that of a fault is dark."""
    fill, ink = (canvas.RED, "white") if by == "fault" else ("white", canvas.BLACK)
    circle = {
        "boxstyle": "circle,pad=0.16",
        "facecolor": fill,
        "edgecolor": canvas.RED if by == "fault" else canvas.BLACK,
    }
    bbox: dict[str, Any] = {**circle, "linewidth": 0.85}
    page.text(x, y, _SIGNS[by][0], va="center_baseline", bbox=bbox, color=ink, label=label, **_BOLD)


def _legend(page: Axes, y: float) -> float:
    said = "Arrows: where a run goes by itself (dashed: when it is started). Letters: what else leaves a state."
    page.text(_COLUMNS[0], y, said, fontweight="bold")
    for by, (_, name) in _SIGNS.items():
        y += canvas.LINE + 1.2
        _sign(page, _COLUMNS[0] + 2.4, y - 1.0, by, "")
        page.text(_COLUMNS[0] + 7.0, y, f"{name}: {_goals(by)}")
    at_rest = "Grey: no run is on, or it waits to be mended; the table is at rest."
    page.text(_COLUMNS[0], y + canvas.LINE + 2.0, at_rest, color=canvas.SOFT)
    return y + 2 * canvas.LINE + 2.0


def _goals(by: str) -> str:
    """Where a command leads, and from where, if that makes a difference."""
    goals: dict[str, list[str]] = {}
    for begin, end, its, _ in WAYS:
        if its == by:
            goals.setdefault(end, []).append(begin)
    if len(goals) == 1:
        return f"to {next(iter(goals))}"
    return ", ".join(f"from {' and '.join(begins)} to {end}" for end, begins in goals.items())


# The bus, mm.
_TERMINATOR_OHM, _KBIT_S = 120, 500
_CAN_H, _CAN_L, _LEFT, _RIGHT = 49.0, 53.0, 14.0, 156.0
_TOP, _TALL, _BROAD = 66.0, 43.0, 46.0  # of the nodes' boxes
_CENTRES = {1: 34.0, 2: 85.0, 3: 136.0}
_CALLED = {  # by the node's name in its table: what it is called, and what it is
    "navcomp": ("navigation computer", "leads the run"),
    "drive": ("drive of the stand", "turns the table"),
    "block": ("accelerometer block", "turns with the table"),
}


@canvas.picture
def wiring() -> Figure:
    """The line with its two ends, the three nodes, gateway and host."""
    line = f"One line, CAN_H and CAN_L, {_KBIT_S} kbit/s, with {_TERMINATOR_OHM} ohm at each end and nowhere else."
    nodes = [f"Node {one}: {_CALLED[name][0]}, {', '.join(_identifiers(one, *rest))}." for one, name, *rest in NODES]
    about = [line, *nodes, "A gateway to Modbus, or a host, may listen on the line and ask node 1."]
    page = canvas.sheet("wiring", "The bus: three nodes, a gateway, a host", " ".join(about), "On the bus")
    _line(page)
    for x, name, does in ((54.0, "gateway", "asks node 1 by SDO"), (118.0, "host", "listens; asks node 1")):
        _stub(page, x, 36.0)
        canvas.box(page, x - 23.0, 22.0, 46.0, 14.0, label=name)
        page.text(x, 28.0, name, fontsize=canvas.LARGE_PT, **_BOLD)
        page.text(x, 33.0, does, color=canvas.SOFT, **_MIDDLE)
    page.plot([54.0, 54.0], [22.0, 16.0], color=canvas.BLACK, linewidth=1.1, linestyle=(0.0, (4.0, 2.7)))
    page.text(54.0, 14.0, "Modbus, TCP or serial: PLC, scripts", color=canvas.SOFT, **_MIDDLE)
    page.text(118.0, 19.5, "a laptop, a logger", color=canvas.SOFT, **_MIDDLE)
    for number, name, *services in NODES:
        x, (called, does) = _CENTRES[number], _CALLED[name]
        _stub(page, x, _TOP)
        canvas.box(page, x - _BROAD / 2, _TOP, _BROAD, _TALL, facecolor=canvas.PLATE, label=f"node {number}")
        page.text(x, _TOP + 5.0, f"node {number}", fontsize=canvas.LARGE_PT, **_BOLD)
        page.text(x, _TOP + 10.0, called, **_BOLD)
        page.text(x, _TOP + 14.5, does, color=canvas.SOFT, **_MIDDLE)
        for index, said in enumerate(_identifiers(number, *services)):
            page.text(x - _BROAD / 2 + 2.5, _TOP + 21.0 + index * canvas.LINE, said)
    y = _TOP + _TALL + 7.0
    for text in (
        f"{_KBIT_S} kbit/s, one line, short stubs, a common ground. {_TERMINATOR_OHM} Ω at the two ends of the line and"
        f" nowhere else: {_TERMINATOR_OHM // 2} Ω between CAN_H and CAN_L with everything switched off.",
        f"Node 1 starts and stops the others (000h). All send a heartbeat every {HEARTBEAT_MS} ms; where one fails for"
        f" {CONSUMER_MS} ms, node 1 or the drive stops the table. The emergency stop cuts the drive's power and does"
        " not use this bus.",
        "The drive's process data are those of its profile; the usual ones are shown.",
    ):
        y = canvas.paragraph(page, canvas.MARGIN, y, text, canvas.WIDTH_MM - 2 * canvas.MARGIN) + 0.8
    return canvas.cut(page, y)


def _identifiers(number: int, emergency: int, answer: int, request: int, heartbeat: int) -> list[str]:
    """What a node sends and hears, a line each."""
    hears, sends = PROCESS_DATA[number]
    samples = SAMPLES if number == 3 else ()
    lines = [f"heartbeat {heartbeat:03X}h", f"emergency {emergency:03X}h", f"SDO {request:03X}h, answer {answer:03X}h"]
    listed = (("sends", sends), ("hears", hears), ("samples", samples))
    return lines + [f"{what} {', '.join(f'{one:03X}h' for one in several)}" for what, several in listed if several]


def _line(page: Axes) -> None:
    """CAN_H and CAN_L, with a resistor between them at both ends."""
    for y, name, below in ((_CAN_H, "CAN_H", -1.4), (_CAN_L, "CAN_L", 4.0)):
        page.plot([_LEFT - 5.0, _RIGHT + 5.0], [y, y], color=canvas.BLACK, linewidth=1.7)
        page.text(_LEFT + 4.0, y + below, name)
    for x, to_word in ((_LEFT - 5.0, 1.0), (_RIGHT + 5.0, -1.0)):
        canvas.box(page, x - 1.3, _CAN_H - 0.8, 2.6, _CAN_L - _CAN_H + 1.6)
        page.text(x + to_word, _CAN_L + 9.0, f"{_TERMINATOR_OHM} Ω", label="terminator", **_BOLD)


def _stub(page: Axes, x: float, y: float) -> None:
    """Two wires from the line to a box above or below it."""
    for place, wire in ((x - 1.2, _CAN_H), (x + 1.2, _CAN_L)):
        page.plot(
            [place, place], [wire, y], color=canvas.BLACK, linewidth=1.1, marker="o", markersize=3.6, markevery=[0]
        )
