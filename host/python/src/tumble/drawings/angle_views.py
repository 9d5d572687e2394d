"""The table angles of a mounting's positions, and the direction of gravity on the block's axes at each."""

from __future__ import annotations

import numpy as np

from tumble.drawings import dial, words
from tumble.drawings.poses import RIGHT, UP, gravity, table
from tumble.drawings.svg import INK, LARGE, LINE, PLATE, RED, SOFT, WIDTH, Page
from tumble.drawings.views import FRONT, View, draw_axes, draw_block, draw_platform, lowest
from tumble.errors import UsageError
from tumble.schedule import FIT, Mounting, Position, Schedule

_MARGIN = 4.0
_RADIUS = 23.0
_LEFT, _RIGHT = (46.0, 51.0), (124.0, 51.0)  # centres of the two circles
_TABLE_TOP = 92.0
_COLUMNS = (20.0, 36.0, 40.0, 70.0, 83.0, 96.0, 101.0)  # number, angle, use, x, y, z, up


def angles(schedule: Schedule, mounting: int) -> str:
    """SVG: round the axis, where the table stands at each position of the mounting of that number; and round the block,
    where gravity points. Raises UsageError where the schedule has no such mounting."""
    found = [one for one in schedule.mountings if one.number == mounting]
    if not found:
        known = ", ".join(str(one.number) for one in schedule.mountings)
        raise UsageError(f"no mounting {mounting} in this schedule, which has {known}")
    positions = [one for one in schedule.positions if one.mounting == mounting]
    page = Page(f"The angles of mounting {mounting}", _about(found[0], positions))
    page.text((_MARGIN, 7.0), f"The angles of mounting {mounting}", size=LARGE + 0.6, bold=True)
    page.text((_LEFT[0], 14.0), "the table, seen from the front", "middle", bold=True)
    page.text((_LEFT[0], 18.2), "where the mark of angle 0 goes", "middle", colour=SOFT)
    page.text((_RIGHT[0], 14.0), "the block, kept still", "middle", bold=True)
    page.text((_RIGHT[0], 18.2), "where gravity points, by position", "middle", colour=SOFT)
    below = max(draw(page, found[0], positions) for draw in (_turning_table, _turning_gravity))
    return page.document(_list(page, found[0], positions, max(_TABLE_TOP, below + 13.0)))


def _about(mounting: Mounting, positions: list[Position]) -> str:
    told = [f"{one.number}: {one.angle_deg:g} deg, {words.line(mounting, one.angle_deg)}." for one in positions]
    return " ".join(["Seen from the front, along the axis; positive is counterclockwise. Positions:", *told])


def _turning_table(page: Page, mounting: Mounting, positions: list[Position]) -> float:
    """The circle with the block as it sits at angle 0. Returns the y below it."""
    page.circle(_LEFT, _RADIUS, PLATE, SOFT, 0.35)
    view = View(FRONT, _LEFT, _RADIUS / 2.1)
    _block(page, view, mounting)
    for position in positions:
        ends = [dial.on(_LEFT, radius, position.angle_deg) for radius in (_RADIUS - 2.5, _RADIUS)]
        page.line(ends, INK, 0.5, position=position.number)
    dial.sense(page, _LEFT, _RADIUS - 4.0, 12.0, 42.0)
    return dial.labels(page, _LEFT, _RADIUS, [(one.angle_deg, str(one.number)) for one in positions])


def _block(page: Page, view: View, mounting: Mounting) -> None:
    axes = np.array(mounting.matrix) @ table(0.0)
    draw_platform(page, view, lowest(axes))
    draw_block(page, view, axes)
    draw_axes(page, view, axes, "xyz", reach=1.1, mounting=mounting.number)


def _turning_gravity(page: Page, mounting: Mounting, positions: list[Position]) -> float:
    """Arrows of gravity in the plane of the picture; what a tilted axis takes out of it makes them shorter. Returns the
    y below them."""
    view = View(FRONT, _RIGHT, _RADIUS / 2.1)
    for position in positions:
        along = gravity(mounting, position.angle_deg) @ np.array(mounting.matrix)  # in h, n, v: right, away, up
        flat = np.array([along[RIGHT], -along[UP]]) * _RADIUS
        inner, outer = np.array(_RIGHT) + 0.75 * flat, np.array(_RIGHT) + flat
        page.arrow([inner, outer], RED, 0.6, gravity=position.number)
    axes = np.array(mounting.matrix) @ table(0.0)
    draw_block(page, view, axes)
    draw_axes(page, view, axes, "xyz", reach=0.95)
    marks = [(180.0 - one.angle_deg, str(one.number)) for one in positions]
    return dial.labels(page, _RIGHT, _RADIUS, marks)


def _list(page: Page, mounting: Mounting, positions: list[Position], y: float) -> float:
    """The table of positions, from y on. Returns the height of the page."""
    heads = zip(_COLUMNS, ("position", "angle", "use", "x", "y", "z", "up"))
    page.text(((_COLUMNS[3] + _COLUMNS[5]) / 2 - 5.0, y - LINE), "gravity on the axes, g", "middle", bold=True)
    for x, name in heads:
        page.text((x, y), name, "start" if name in ("use", "up") else "end", bold=True)
    page.line([(_MARGIN, y + 1.4), (WIDTH - _MARGIN, y + 1.4)], SOFT, 0.25)
    for position in positions:
        y += LINE + 0.4
        _row(page, mounting, position, y)
    y += 2 * LINE
    said = "An axis that points up feels +1 g, the opposite of gravity."
    if tilted := words.tilt(mounting):
        said += f" {tilted.capitalize()}."
    return page.paragraph((_MARGIN, y), said, WIDTH - 2 * _MARGIN, SOFT)


def _row(page: Page, mounting: Mounting, position: Position, y: float) -> None:
    felt = [f"{round(float(one), 3) + 0.0:+.3f}" for one in gravity(mounting, position.angle_deg)]
    felt = ["0" if float(one) == 0.0 else one for one in felt]
    with page.group(position=position.number):
        page.text((_COLUMNS[0], y), str(position.number), "end")
        page.text((_COLUMNS[1], y), f"{position.angle_deg:g}°", "end")
        page.text((_COLUMNS[2], y), "fit" if position.use == FIT else "check only")
        for x, one in zip(_COLUMNS[3:6], felt):
            page.text((x, y), one, "end", colour=INK if one != "0" else SOFT)
        page.text((_COLUMNS[6], y), words.face_up(mounting, position.angle_deg))
