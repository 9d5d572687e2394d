"""A page of SVG, written by code: lines, arrows and words in millimetres, and the same bytes wherever it is drawn.

Coordinates are mm from the upper left corner, y down. The page is white whatever lies behind it, so that it reads the
same on a light and on a dark screen. What a shape means stands in its data-... attributes, for tests and scripts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from xml.sax.saxutils import escape, quoteattr

from tumble.arrays import Floats

Point = Sequence[float] | Floats

WIDTH = 170.0  # mm, of every page
SIZE = 2.9  # of text, mm: 8.2 pt, the smallest there is
LARGE = 3.6
LINE = 4.2  # from one line of text to the next

INK, SOFT = "#1b2530", "#55606c"  # told apart by how dark they are; SOFT on white has a contrast of 6.4
BLUE, RED = "#0b5394", "#a8320a"  # the table's frame, gravity: each also has its label and its kind of line
FACES = ("#fff6e0", "#f0dfb8", "#dcc690")  # of a block: from the lightest to the darkest
PLATE, PLATE_SIDE = "#eef1f4", "#d3d9e0"

_FAMILY = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif"
_HEAD, _HALF_HEAD = 2.6, 0.95  # of an arrow: its length, half its width
_NARROW, _WIDE = frozenset("iIjlrtf.,:;|!'()[]/ -°"), frozenset("mwMWOQGDNHUCKABRXY_@%+=<>Ω")


def text_width(text: str, size: float = SIZE, bold: bool = False) -> float:
    """How wide a line of text is at most, mm, in the fonts that are asked for."""
    ems = sum(0.41 if sign in _NARROW else 0.86 if sign in _WIDE else 0.65 for sign in text)
    return ems * size * (1.13 if bold else 1.0)


def wrapped(text: str, width: float, size: float = SIZE) -> list[str]:
    """The text in lines that are no wider, where its words allow it."""
    lines: list[str] = []
    for word in text.split():
        if lines and text_width(f"{lines[-1]} {word}", size) <= width:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines


def number(value: float) -> str:
    """To a thousandth of a millimetre; rounded twice, so that the last bit of a sine makes no difference."""
    text = f"{round(float(value), 9):.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


class Page:
    """A drawing as it is made. Later shapes lie over earlier ones."""

    def __init__(self, title: str, about: str):
        """`about`: the drawing in words, for whoever cannot see it."""
        self._title, self._about = title, about
        self._parts: list[str] = []

    def document(self, height: float) -> str:
        """The whole file."""
        size = f'viewBox="0 0 {number(WIDTH)} {number(height)}" width="{number(WIDTH)}mm" height="{number(height)}mm"'
        font = f'font-family="{_FAMILY}" font-size="{number(SIZE)}"'
        head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} {font} role="img" fill="{INK}">'
        said = f"<title>{escape(self._title)}</title>\n<desc>{escape(self._about)}</desc>"
        paper = f'<rect width="{number(WIDTH)}" height="{number(height)}" fill="#ffffff"/>'
        return "\n".join([head, said, paper, *self._parts, "</svg>", ""])

    @contextmanager
    def group(self, **data: object) -> Iterator[None]:
        """What is drawn within belongs together."""
        self._parts.append(f"<g{_data(data)}>")
        yield
        self._parts.append("</g>")

    def line(
        self, points: Sequence[Point], colour: str = INK, width: float = 0.35, dash: str = "", **data: object
    ) -> None:
        """From point to point."""
        dashes = f' stroke-dasharray="{dash}"' if dash else ""
        pen = f'fill="none" stroke="{colour}" stroke-width="{number(width)}"{dashes}'
        self._parts.append(f'<polyline points="{_points(points)}" {pen}{_data(data)}/>')

    def polygon(
        self, points: Sequence[Point], fill: str, stroke: str = INK, width: float = 0.25, **data: object
    ) -> None:
        """A face. `stroke` "none": without an edge."""
        edge = f'stroke="{stroke}" stroke-width="{number(width)}" stroke-linejoin="round"'
        self._parts.append(f'<polygon points="{_points(points)}" fill="{fill}" {edge}{_data(data)}/>')

    def circle(self, centre: Point, radius: float, fill: str, stroke: str = INK, width: float = 0.25) -> None:
        """A disc with an edge."""
        place = f'cx="{number(centre[0])}" cy="{number(centre[1])}" r="{number(radius)}"'
        self._parts.append(f'<circle {place} fill="{fill}" stroke="{stroke}" stroke-width="{number(width)}"/>')

    def box(self, corner: Point, width: float, height: float, fill: str, stroke: str = INK) -> None:
        """A rectangle by its upper left corner."""
        place = f'x="{number(corner[0])}" y="{number(corner[1])}" width="{number(width)}" height="{number(height)}"'
        self._parts.append(f'<rect {place} rx="1" fill="{fill}" stroke="{stroke}" stroke-width="0.3"/>')

    def arrow(
        self, points: Sequence[Point], colour: str = INK, width: float = 0.5, dash: str = "", **data: object
    ) -> None:
        """From point to point; its tip is the last one. One that is too short for a shaft is a head alone."""
        (x, y), (end_x, end_y) = points[-2], points[-1]
        length = math.hypot(end_x - x, end_y - y)
        along = ((end_x - x) / length, (end_y - y) / length) if length > 1e-9 else (0.0, 0.0)
        neck = (end_x - _HEAD * along[0], end_y - _HEAD * along[1])
        wings = [(neck[0] + side * along[1], neck[1] - side * along[0]) for side in (_HALF_HEAD, -_HALF_HEAD)]
        with self.group(**data):
            if length > _HEAD or len(points) > 2:
                self.line([*points[:-1], neck], colour, width, dash)
            self.polygon([points[-1], *wings], colour, colour, 0.1)

    def text(
        self,
        place: Point,
        text: str,
        anchor: str = "start",
        size: float = SIZE,
        colour: str = INK,
        bold: bool = False,
        **data: object,
    ) -> None:
        """A line of text whose left end, middle or end is at the place, on its base line."""
        style = f' font-size="{number(size)}"' if size != SIZE else ""
        style += ' font-weight="bold"' if bold else ""
        style += f' fill="{colour}"' if colour != INK else ""
        style += f' text-anchor="{anchor}"' if anchor != "start" else ""
        where = f'x="{number(place[0])}" y="{number(place[1])}"'
        self._parts.append(f"<text {where}{style}{_data(data)}>{escape(text)}</text>")

    def paragraph(self, place: Point, text: str, width: float, colour: str = INK) -> float:
        """Lines no wider than that, the first at the place. Returns the y of the line behind them."""
        lines = wrapped(text, width)
        for index, line in enumerate(lines):
            self.text((place[0], place[1] + index * LINE), line, colour=colour)
        return place[1] + len(lines) * LINE


def _points(points: Sequence[Point]) -> str:
    return " ".join(f"{number(x)},{number(y)}" for x, y in points)


def _data(data: dict[str, object]) -> str:
    return "".join(f" data-{key.replace('_', '-')}={quoteattr(str(value))}" for key, value in data.items())
