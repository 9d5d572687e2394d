"""The states of a run and all ways between them, as the firmware's own table has them (tumble.drawings.tables)."""

from __future__ import annotations

from tumble.drawings.svg import INK, LARGE, LINE, PLATE, RED, SIZE, SOFT, WIDTH, Page, Point, wrapped
from tumble.drawings.tables import STATES, WAYS

_COLUMNS = (3.0, 43.0, 83.0, 123.0)  # left edges of the boxes, mm
_ROWS = (13.0, 50.0, 87.0, 124.0)  # top edges
_BOX = (32.0, 27.0)
_PLACES = {  # column, row
    "IDLE": (0, 0),
    "PREFLIGHT": (1, 0),
    "WARM_UP": (2, 0),
    "NEXT": (3, 0),
    "WAIT_MOUNTING": (3, 1),
    "HOME": (2, 1),
    "MOVE": (1, 1),
    "SETTLE": (1, 2),
    "AVERAGE": (2, 2),
    "SOLVE": (3, 3),
    "VERIFY": (2, 3),
    "PROPOSE": (1, 3),
    "DONE": (0, 3),
    "FAULT": (0, 1),
    "ABORT": (0, 2),
}
_RUNS_ON = ("done", "other")  # ways that a run takes by itself, drawn as arrows; the others are letters in the box
_SIGNS = {  # letter and what it is called
    "START": ("S", "START"),
    "RESUME": ("U", "RESUME"),
    "CONFIRM": ("C", "CONFIRM_MOUNTING"),
    "REPEAT": ("P", "REPEAT_POSITION, REPEAT_MOUNTING"),
    "ABORT": ("A", "ABORT"),
    "fault": ("F", "a fault, or a time that has run out"),
}
_FIRST = ("IDLE", "START")  # has an arrow as well: where one begins to read
_AT_REST = ("IDLE", "DONE", "FAULT", "ABORT")


def states() -> str:
    """SVG: the state diagram of a run. Arrows: where it goes by itself; letters: commands, and faults."""
    page = Page("The states of a run", _about())
    page.text((_COLUMNS[0], 7.0), "The states of a run", size=LARGE + 0.6, bold=True)
    for begin, end, by, note in WAYS:
        if by in _RUNS_ON or (begin, by) == _FIRST:
            _arrow(page, begin, end, by, note)
    for name, said in STATES.items():
        _state(page, name, said)
    return page.document(_legend(page))


def _about() -> str:
    said = [f"{name}: {sentence}." for name, sentence in STATES.items()]
    ways = [f"{begin} to {end} by {by}{f' ({note})' if note else ''}." for begin, end, by, note in WAYS]
    return " ".join([*said, *ways])


def _corner(name: str) -> tuple[float, float]:
    column, row = _PLACES[name]
    return _COLUMNS[column], _ROWS[row]


def _state(page: Page, name: str, said: str) -> None:
    x, y = _corner(name)
    with page.group(state=name):
        page.box((x, y), *_BOX, fill=PLATE if name in _AT_REST else "#ffffff")
        page.text((x + _BOX[0] / 2, y + 4.2), name, "middle", bold=True)
        for index, line in enumerate(wrapped(said, _BOX[0] - 1.5)):
            page.text((x + _BOX[0] / 2, y + 8.4 + index * 3.6), line, "middle", colour=SOFT)
    leaving = [(end, by) for begin, end, by, _ in WAYS if begin == name and by not in _RUNS_ON]
    for index, (end, by) in enumerate(leaving):
        _sign(page, (x + 3.2 + index * 5.2, y + _BOX[1] - 2.9), by, begin=name, end=end, by=by)


def _sign(page: Page, centre: Point, what: str, **data: object) -> None:
    """A letter in a circle; that of a fault is dark."""
    dark = what == "fault"
    with page.group(**data):
        page.circle(centre, 2.1, RED if dark else "#ffffff", RED if dark else INK, 0.3)
        place = (centre[0], centre[1] + 1.05)
        page.text(place, _SIGNS[what][0], "middle", SIZE, "#ffffff" if dark else INK, bold=True)


def _arrow(page: Page, begin: str, end: str, by: str, note: str) -> None:
    """Straight between neighbours; else by one of the ways round that are laid out below."""
    path, place, anchor = _ROUND.get((begin, end), (_straight(begin, end), (0.0, 0.0), "start"))
    page.arrow(path, INK, 0.5, "" if by in _RUNS_ON else "1.2 0.9", begin=begin, end=end, by=by)
    for index, line in enumerate(wrapped(note, 34.0)):
        page.text((place[0], place[1] + index * 3.6), line, anchor)


def _straight(begin: str, end: str) -> list[tuple[float, float]]:
    """From the edge of a box to that of its neighbour in the same row or column."""
    (x, y), (to_x, to_y) = _corner(begin), _corner(end)
    width, height = _BOX
    if y == to_y:
        ends = (x + width, to_x) if to_x > x else (x, to_x + width)
        return [(ends[0], y + height / 2), (ends[1], y + height / 2)]
    ends = (y + height, to_y) if to_y > y else (y, to_y + height)
    return [(x + width / 2, ends[0]), (x + width / 2, ends[1])]


_EDGE = _COLUMNS[3] + _BOX[0]  # right edge of the last column
_MIDDLE = [top + _BOX[1] / 2 for top in _ROWS]
_UNDER = _ROWS[2] + _BOX[1]  # lower edge of SETTLE and AVERAGE
_ROUND: dict[tuple[str, str], tuple[list[tuple[float, float]], tuple[float, float], str]] = {
    ("AVERAGE", "NEXT"): (
        [(_COLUMNS[2] + _BOX[0], _MIDDLE[2]), (_EDGE + 5.0, _MIDDLE[2]), (_EDGE + 5.0, _MIDDLE[0]),
         (_EDGE, _MIDDLE[0])],
        (0.0, 0.0),
        "start",
    ),
    ("NEXT", "SOLVE"): (
        [(_EDGE, _MIDDLE[0] - 5.0), (_EDGE + 9.5, _MIDDLE[0] - 5.0), (_EDGE + 9.5, _MIDDLE[3]), (_EDGE, _MIDDLE[3])],
        (_EDGE + 8.0, _UNDER + 1.0),
        "end",
    ),
    ("SETTLE", "SETTLE"): (
        [(_COLUMNS[1] + 6.0, _UNDER), (_COLUMNS[1] + 6.0, _UNDER + 5.5), (_COLUMNS[1] - 3.5, _UNDER + 5.5),
         (_COLUMNS[1] - 3.5, _MIDDLE[2]), (_COLUMNS[1], _MIDDLE[2])],
        (_COLUMNS[1] - 4.5, _UNDER + 5.0),
        "end",
    ),
    ("AVERAGE", "SETTLE"): (
        [(_COLUMNS[2] + 16.0, _UNDER), (_COLUMNS[2] + 16.0, _UNDER + 5.5), (_COLUMNS[1] + 22.0, _UNDER + 5.5),
         (_COLUMNS[1] + 22.0, _UNDER)],
        (_COLUMNS[1] + 24.0, _UNDER + 4.0),
        "start",
    ),
}  # fmt: skip


def _legend(page: Page) -> float:
    y = _ROWS[3] + _BOX[1] + 8.0
    said = "Arrows: where a run goes by itself (dashed: when it is started). Letters: what else leaves a state."
    page.text((_COLUMNS[0], y), said, bold=True)
    for by, (_, name) in _SIGNS.items():
        y += LINE + 1.2
        _sign(page, (_COLUMNS[0] + 2.4, y - 1.0), by)
        page.text((_COLUMNS[0] + 7.0, y), f"{name}: {_goals(by)}")
    y += LINE + 2.0
    at_rest = "Grey: no run is on, or it waits to be mended; the table is at rest."
    return page.paragraph((_COLUMNS[0], y), at_rest, WIDTH - 2 * _COLUMNS[0], SOFT)


def _goals(by: str) -> str:
    """Where a command leads, and from where, if that makes a difference."""
    goals: dict[str, list[str]] = {}
    for begin, end, its, _ in WAYS:
        if its == by:
            goals.setdefault(end, []).append(begin)
    if len(goals) == 1:
        return f"to {next(iter(goals))}"
    return ", ".join(f"from {' and '.join(begins)} to {end}" for end, begins in goals.items())
