"""From the room onto the page: the oblique view that shows a mounting, and the view from the front.

The oblique view leaves the front as it is, right to the right and up upwards; what is away goes up to the right, at a
fixed part of its length. Lengths are in units of the drawing, which `scale` makes millimetres.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.drawings.svg import FACES, INK, LARGE, PLATE, PLATE_SIDE, SOFT, Page, Point

OBLIQUE = ((1.0, 0.6, 0.0), (0.0, -0.4, -1.0))  # page x and y of one unit to the right, away and up
FRONT = ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0))
HALF = 0.42  # of a block's edge
REACH = 1.5  # of the arrows of its axes, from its centre

_LIGHT = np.array([0.25, -0.45, 0.86])  # where it comes from
_BEYOND = 2.3  # mm, from the tip of an arrow to the middle of its label
_SEEN = 1e-9
_POLE = 1.5  # mm: an arrow that is shorter on the page is seen from its end


@dataclass(frozen=True)
class View:
    """A projection, and where on the page its origin lies."""

    projection: tuple[tuple[float, ...], ...]
    origin: tuple[float, float]
    scale: float

    def at(self, place: Sequence[float] | Floats) -> Floats:
        """A place in (right, away, up) on the page: (2,), mm."""
        onto: Floats = np.array(self.origin) + self.scale * (np.array(self.projection) @ np.asarray(place))
        return onto

    @property
    def eye(self) -> Floats:
        """Towards the eye: the direction that the projection loses, (3,)."""
        across, down = np.array(self.projection)
        lost: Floats = np.cross(across, down)
        return lost if lost[1] < 0.0 else -lost

    def path(self, places: Sequence[Sequence[float] | Floats]) -> list[Floats]:
        """Several places on the page."""
        return [self.at(place) for place in places]


def draw_box(
    page: Page, view: View, axes: Floats, low: Point, high: Point, fills: tuple[str, str, str] = FACES
) -> None:
    """A solid from corner to corner along three axes (rows, of length 1). `fills`: for light, half and dark faces."""
    corners = np.array([low, high])
    for axis, side in ((axis, side) for axis in range(3) for side in (0, 1)):
        outwards = axes[axis] * (2 * side - 1)
        if outwards @ view.eye <= _SEEN:
            continue
        one, other = [number for number in range(3) if number != axis]
        face = []
        for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
            place = np.zeros(3)
            place[axis], place[one], place[other] = corners[side][axis], corners[a][one], corners[b][other]
            face.append(place @ axes)
        bright = float(outwards @ _LIGHT)
        page.polygon(view.path(face), fills[0 if bright > 0.7 else 1 if bright > 0.35 else 2])


def draw_block(page: Page, view: View, axes: Floats) -> None:
    """The block, a cube around the origin."""
    draw_box(page, view, axes, [-HALF] * 3, [HALF] * 3)


def draw_axes(
    page: Page, view: View, axes: Floats, names: str, colour: str = INK, reach: float = REACH, **data: object
) -> None:
    """Arrows of three axes out of the block around the origin, each with its name: over the block where they come out
    of a face that is seen, dashed where it hides them."""
    labels: list[Floats] = []
    for number, name in enumerate(names):
        tip, towards = view.at(reach * axes[number]), float(axes[number] @ view.eye)
        along = tip - np.array(view.origin)
        with page.group(axis=name, **data):
            if float(np.hypot(*along)) < _POLE:
                draw_pole(page, tip, towards < 0.0, colour)
                others = view.at(axes[number - 1] + axes[number - 2]) - np.array(view.origin)
                along, beyond = -others, _BEYOND + 1.3
            else:
                out = min(reach, HALF + _behind(axes @ view.eye, number))
                if out > HALF:
                    page.line(view.path([np.zeros(3), out * axes[number]]), colour, 0.35, "0.9 0.7")
                page.arrow([view.at(out * axes[number]), tip], colour, 0.6, tip=name)
                beyond = _BEYOND
            along = along / np.hypot(*along)
            while any(np.hypot(*(tip + beyond * along - label)) < LARGE for label in labels):
                beyond += 0.5
            label = tip + beyond * along
            labels.append(label)
            page.circle(label, 0.55 * LARGE, "#ffffff", "none")  # so that no line runs through it
            page.text(label + np.array([0.0, 0.36 * LARGE]), name, "middle", LARGE, colour, bold=True)


def _behind(towards: Floats, number: int) -> float:
    """How far an axis of the block runs behind the block, out of a face that is turned away; else 0. `towards`: how
    much each axis points towards the eye."""
    others = max(abs(float(towards[number - 1])), abs(float(towards[number - 2])), _SEEN)
    return HALF * float(-towards[number]) / others if towards[number] < -_SEEN else 0.0


def draw_pole(page: Page, centre: Point, away: bool, colour: str) -> None:
    """The sign for an arrow seen from its end: a cross where it points away, a dot where it points towards one."""
    page.circle(centre, 1.5, "#ffffff", colour, 0.4)
    x, y = centre
    if away:
        page.line([(x - 1.06, y - 1.06), (x + 1.06, y + 1.06)], colour, 0.4)
        page.line([(x - 1.06, y + 1.06), (x + 1.06, y - 1.06)], colour, 0.4)
    else:
        page.circle(centre, 0.4, colour, colour)


def arc(radius: float, begin_deg: float, end_deg: float, away: float = 0.0) -> list[list[float]]:
    """Points of a circle round the axis, from one table angle to another: where the table's up mark goes."""
    steps = max(2, math.ceil(abs(end_deg - begin_deg) / 6.0))
    angles = [math.radians(begin_deg + (end_deg - begin_deg) * step / steps) for step in range(steps + 1)]
    return [[-radius * math.sin(angle), away, radius * math.cos(angle)] for angle in angles]


DISC, THICK, RADIUS = 0.85, 0.14, 1.3  # the table: where its face is, how thick it is, how large


def draw_table(page: Page, view: View, below: float) -> None:
    """The table with its platform `below` the axis, and the axis itself, as at table angle 0."""
    page.line(view.path([[0, 2.3, 0], [0, DISC, 0]]), SOFT, 0.3, "3 0.8 0.6 0.8")
    back, face = (arc(RADIUS, 0.0, 360.0, away) for away in (DISC + THICK, DISC))
    page.polygon(view.path(back), PLATE_SIDE, SOFT)
    page.polygon(view.path(face), PLATE, SOFT)
    page.line(view.path([[0, DISC, RADIUS - 0.18], [0, DISC, RADIUS]]), INK, 0.5)
    draw_platform(page, view, below)


def draw_platform(page: Page, view: View, below: float) -> None:
    """What the block sits on, `below` the axis."""
    plate = (PLATE, PLATE_SIDE, PLATE_SIDE)
    draw_box(page, view, np.eye(3), [-0.8, -0.7, -below - 0.1], [0.8, DISC, -below], plate)


def draw_axis_in_front(page: Page, view: View) -> None:
    """The part of the axis that comes towards one."""
    page.line(view.path([[0, -HALF, 0], [0, -2.3, 0]]), SOFT, 0.3, "3 0.8 0.6 0.8")


def lowest(axes: Floats) -> float:
    """How far below its centre a block in this pose reaches."""
    return HALF * float(np.abs(axes[:, 2]).sum())
