"""The stand: its axis, the table and its frame h, n, v, gravity, where the table's angle begins and how it counts."""

from __future__ import annotations

import numpy as np

from tumble.drawings import dial, words
from tumble.drawings.svg import BLUE, INK, LARGE, PLATE, PLATE_SIDE, SOFT, WIDTH, Page
from tumble.drawings.views import (
    DISC,
    FRONT,
    HALF,
    OBLIQUE,
    RADIUS,
    THICK,
    View,
    arc,
    draw_axes,
    draw_axis_in_front,
    draw_block,
    draw_box,
    draw_platform,
    draw_table,
)
from tumble.schedule import Schedule

_MARGIN = 4.0
_OBLIQUE = View(OBLIQUE, (48.0, 53.0), 15.0)
_FRONT = View(FRONT, (126.0, 51.0), 11.0)
_RADIUS = 23.0
_NOTES = 92.0
_FLOOR = -2.0  # of the room, in units of the drawing
_STEEL = (PLATE, PLATE_SIDE, "#b9c2cc")


def stand(schedule: Schedule) -> str:
    """SVG: the stand at table angle 0 in an oblique view, and from the front with the schedule's angles."""
    page = Page("A block on a rotary stand with one horizontal axis", _about(schedule))
    page.text((_MARGIN, 7.0), "The stand", size=LARGE + 0.6, bold=True)
    page.text((_OBLIQUE.origin[0] + 6.0, 14.0), "at table angle 0", "middle", bold=True)
    page.text((_FRONT.origin[0], 14.0), "seen from the front, along +n", "middle", bold=True)
    _body(page)
    lowest = _from_the_front(page, schedule)
    return page.document(_notes(page, schedule, max(_NOTES, lowest + 6.0)))


def _angles(schedule: Schedule) -> list[float]:
    """All that occur, each once a turn, from 0 on."""
    return sorted({round(one.angle_deg % 360.0, 6) % 360.0 for one in schedule.positions})


def _about(schedule: Schedule) -> str:
    listed = ", ".join(f"{angle:g}" for angle in _angles(schedule))
    return (
        "The axis of the stand is horizontal. Seen from the front, where the block is, the table is behind the block."
        " The table's frame turns with it: h points to the right at angle 0, n away along the axis, v up at angle 0. A"
        " positive angle raises h and tips v to the left, counterclockwise. Gravity points down. Angles of this"
        f" schedule, in degrees: {listed}."
    )


def _body(page: Page) -> None:
    """Back to front: base, drive, table, block; then the frame and what turns."""
    view, room = _OBLIQUE, np.eye(3)
    draw_box(page, view, room, [-1.1, 0.4, _FLOOR - 0.12], [1.1, 2.7, _FLOOR], _STEEL)
    draw_box(page, view, room, [-0.35, 1.5, _FLOOR], [0.35, 2.3, -0.6], _STEEL)
    draw_box(page, view, room, [-0.6, 1.3, -0.6], [0.6, 2.5, 0.6], _STEEL)
    draw_table(page, view, HALF)
    draw_block(page, view, room)
    draw_axis_in_front(page, view)
    draw_axes(page, view, room, "hnv", BLUE)
    turning = view.path(arc(RADIUS - 0.12, 32.0, 70.0, DISC))
    page.arrow(turning, INK, 0.6, sense="positive")
    page.text(view.at(arc(RADIUS - 0.12, 79.0, 79.0, DISC)[0]) + np.array([0, 1.3]), "+", "middle", 4.0, bold=True)
    dial.gravity_arrow(page, (12.0, 34.0), 14.0)
    _names(page, view)


def _names(page: Page, view: View) -> None:
    """What the parts are called, with lines to them."""
    for name, part, place, anchor in (
        ("drive", [0.6, 1.9, 0.3], (84.0, 26.5), "start"),
        ("table", [0.9, DISC, 0.8], (79.0, 21.0), "start"),
        ("block", [-0.35, -HALF, 0.3], (31.0, 51.0), "end"),
        ("platform", [-0.6, -0.7, -0.47], (24.0, 76.0), "end"),
        ("axis, horizontal", [0.0, -2.3, 0.0], (25.0, 69.0), "end"),
    ):
        side = 0.8 if anchor == "end" else -0.8
        page.line([(place[0] + side, place[1] - 1.0), view.at(part)], SOFT, 0.25)
        page.text(place, name, anchor, colour=SOFT)
    page.text(view.at([0.0, DISC + THICK, RADIUS + 0.08]), "0°", "middle")


def _from_the_front(page: Page, schedule: Schedule) -> float:
    """The circle of the schedule's angles. Returns the y below it."""
    centre, room = _FRONT.origin, np.eye(3)
    page.circle(centre, _RADIUS, PLATE, SOFT, 0.35)
    draw_platform(page, _FRONT, HALF)
    draw_block(page, _FRONT, room)
    draw_axes(page, _FRONT, room, "hnv", BLUE, reach=1.3)
    for angle in _angles(schedule):
        page.line([dial.on(centre, radius, angle) for radius in (_RADIUS - 2.5, _RADIUS)], INK, 0.5, mark=f"{angle:g}")
    dial.sense(page, centre, _RADIUS - 4.0, 12.0, 42.0)
    dial.gravity_arrow(page, (161.5, 67.0), 14.0)
    return dial.labels(page, centre, _RADIUS, [(one, f"{one:g}°") for one in _apart(_angles(schedule))], 4.0, True)


def _apart(angles: list[float]) -> list[float]:
    """Those that have room for a label of their own; all have their marks."""
    kept = angles[:1]
    for angle in angles:
        if angle - kept[-1] >= dial.TOGETHER_DEG:
            kept.append(angle)
    return kept


def _notes(page: Page, schedule: Schedule, y: float) -> float:
    """Below the pictures, from y on. Returns the height of the page."""
    for text in (
        "h, n, v turn with the table: h across the axis, n along it towards the table, v up at angle 0.",
        "Positive angle: h rises and v tips to the left, counterclockwise as seen from the front.",
        "Gravity points straight down. An axis that points up feels +1 g.",
        *(f"Mounting {one.number}: {words.tilt(one)}." for one in schedule.mountings if one.tilt_deg),
    ):
        y = page.paragraph((_MARGIN, y), text, WIDTH - 2 * _MARGIN) + 0.6
    return y
