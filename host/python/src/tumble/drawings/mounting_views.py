"""Each mounting of a schedule on the table, so that a person can seat the block."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tumble.drawings import words
from tumble.drawings.poses import table
from tumble.drawings.svg import BLUE, LARGE, LINE, SIZE, SOFT, WIDTH, Page, wrapped
from tumble.drawings.views import (
    OBLIQUE,
    REACH,
    View,
    draw_axes,
    draw_axis_in_front,
    draw_block,
    draw_platform,
    draw_table,
    lowest,
)
from tumble.schedule import Mounting, Schedule

_MOST_COLUMNS = 3
_MARGIN, _HEADER = 4.0, 20.0
_SCALE = 12.5  # mm of a unit
_PICTURE = 51.0  # height of a cell's picture, mm, at least
_CENTRE = (0.0, 32.0)  # of the block in a cell: from its middle, from its top


def mountings(schedule: Schedule) -> str:
    """SVG: every mounting with its block axes as the matrix has them, at table angle 0, in an oblique view; of a
    schedule that is laid by hand without axis and table."""
    columns = min(_MOST_COLUMNS, len(schedule.mountings))
    width = (WIDTH - 2 * _MARGIN) / columns
    page = Page(_title(schedule), _about(schedule))
    _header(page, schedule)
    y = _HEADER
    for first in range(0, len(schedule.mountings), columns):
        row = schedule.mountings[first : first + columns]
        picture = max(_picture_height(mounting) for mounting in row)
        height = picture - 1.0 + LINE * max(len(_caption(mounting, width)) for mounting in row)
        for column, mounting in enumerate(row):
            left = _MARGIN + column * width
            page.box((left + 0.5, y), width - 1.0, height, "#ffffff", SOFT)
            _cell(page, mounting, (left + width / 2, y), schedule.is_laid_by_hand)
            for index, line in enumerate(_caption(mounting, width)):
                page.text((left + width / 2, y + picture + index * LINE), line, "middle", SIZE)
        y += height + _MARGIN
    return page.document(y)


def _title(schedule: Schedule) -> str:
    count = len(schedule.mountings)
    return f"{_heading(schedule)}: {count} mounting{'s' if count > 1 else ''}"


def _heading(schedule: Schedule) -> str:
    return "How the block lies" if schedule.is_laid_by_hand else "How the block sits on the table"


def _about(schedule: Schedule) -> str:
    told = [f"Mounting {one.number}: {', '.join(words.axes(_on_table(one), 0.0))}." for one in schedule.mountings]
    seen = "Seen from the front, where the block is, along the axis of the stand, with the table at angle 0."
    seen = "Laid by hand, seen from the front." if schedule.is_laid_by_hand else seen
    return " ".join([seen, *told])


def _header(page: Page, schedule: Schedule) -> None:
    page.text((_MARGIN, 7.0), _heading(schedule), size=LARGE + 0.6, bold=True)
    seen = "Table at angle 0. You stand in front: the block is before you, the table behind it."
    seen = "Laid by hand, on something level. You stand in front." if schedule.is_laid_by_hand else seen
    page.paragraph((_MARGIN, 12.5), seen, 108.0, SOFT)
    frame = View(OBLIQUE, (137.0, 15.5), 6.0)
    for name, axis, label in zip("hnv", np.eye(3), ("right", "away", "up")):
        tip = frame.at(1.5 * axis)
        page.arrow([frame.at([0, 0, 0]), tip], BLUE, 0.4)
        shift = {"h": (1.2, 1.0), "n": (1.2, 0.2), "v": (-1.2, 1.6)}[name]
        anchor = "end" if name == "v" else "start"
        page.text(tip + np.array(shift), f"{name}: {label}", anchor, colour=BLUE)


def _on_table(mounting: Mounting) -> Mounting:
    """The mounting on a level stand: what a person sees who seats the block."""
    return replace(mounting, tilt_deg=0.0)


def _caption(mounting: Mounting, width: float) -> list[str]:
    said = words.axes(_on_table(mounting), 0.0)
    said.append(words.tilt(mounting))
    return [line for one in said for line in wrapped(one, width - 10.0)]


def _picture_height(mounting: Mounting) -> float:
    """So that the labels of axes that come down towards one do not run into the words below, mm."""
    tips = np.array(mounting.matrix) @ np.array(OBLIQUE)[1]
    return max(_PICTURE, _CENTRE[1] + _SCALE * REACH * float(tips.max()) + 8.5)


def _cell(page: Page, mounting: Mounting, top: tuple[float, float], is_laid: bool) -> None:
    """The picture of one mounting; `top`: of its middle."""
    middle, upper = top
    view = View(OBLIQUE, (middle + _CENTRE[0], upper + _CENTRE[1]), _SCALE)
    axes = np.array(mounting.matrix) @ table(0.0)
    page.text((middle, upper + 5.0), f"mounting {mounting.number}", "middle", LARGE, bold=True)
    with page.group(mounting=mounting.number, origin=f"{view.origin[0]:.3f} {view.origin[1]:.3f}", scale=_SCALE):
        if is_laid:
            draw_platform(page, view, lowest(axes))
            draw_block(page, view, axes)
        else:
            draw_table(page, view, lowest(axes))
            draw_block(page, view, axes)
            draw_axis_in_front(page, view)
        draw_axes(page, view, axes, "xyz")
