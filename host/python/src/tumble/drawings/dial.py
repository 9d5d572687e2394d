"""The circle of table angles as seen from the front: angle 0 at the top, positive counterclockwise."""

from __future__ import annotations

import math
from collections.abc import Iterable

from tumble.drawings.svg import INK, RED, SIZE, SOFT, Page, text_width

TOGETHER_DEG = 3.0  # marks that are nearer to each other share a label
_GAP = 1.2  # mm, round a label
_STEP = 0.8  # by which a label that has no room is moved outwards, mm
_FARTHEST = 15.0  # beyond its place, mm
_NEAR = 4.0  # a label farther out than this gets a line to its mark, mm

Box = tuple[float, float, float, float]  # left, top, right, bottom


def towards(angle_deg: float) -> tuple[float, float]:
    """The direction of a table angle on the page: 0 is up, 90 is to the left."""
    angle = math.radians(math.fmod(angle_deg, 360.0))
    return -math.sin(angle), -math.cos(angle)


def on(centre: tuple[float, float], radius: float, angle_deg: float) -> tuple[float, float]:
    """The point of a circle at a table angle."""
    x, y = towards(angle_deg)
    return centre[0] + radius * x, centre[1] + radius * y


def labels(
    page: Page,
    centre: tuple[float, float],
    radius: float,
    marks: Iterable[tuple[float, str]],
    farthest: float = _FARTHEST,
    is_left_out: bool = False,
) -> float:
    """The names of angles (degrees, name) round a circle, where they do not run into each other: as far out as they
    need, up to `farthest`. `is_left_out`: what has no room then. Returns the y below all of them."""
    taken: list[Box] = []
    for angle_deg, text in _gathered(marks):
        x, y = towards(angle_deg)
        width, height = text_width(text), SIZE
        out = radius + _GAP + 0.5 * (abs(x) * width + abs(y) * height)
        end = out + farthest
        while (crowded := _meets(_box(on(centre, out, angle_deg), width, height), taken)) and out < end:
            out += _STEP
        if crowded and is_left_out:
            continue
        place = on(centre, out, angle_deg)
        taken.append(_box(place, width, height))
        if out - radius - 0.5 * width * abs(x) > _NEAR:
            page.line([on(centre, radius, angle_deg), on(centre, out - 2.2, angle_deg)], SOFT, 0.2)
        page.text((place[0], place[1] + 0.36 * SIZE), text, "middle", angle=f"{angle_deg:g}")
    return max((box[3] for box in taken), default=0.0)


def _gathered(marks: Iterable[tuple[float, str]]) -> list[tuple[float, str]]:
    """Marks in the order of their angles from 0 to 360; those that lie together are one."""
    found: list[tuple[float, list[str]]] = []
    turns = [(round(angle % 360.0, 6) % 360.0, text) for angle, text in marks]
    for angle_deg, text in sorted(turns, key=lambda mark: mark[0]):
        if found and angle_deg - found[-1][0] < TOGETHER_DEG:
            found[-1][1].append(text)
        else:
            found.append((angle_deg, [text]))
    if len(found) > 1 and found[0][0] + 360.0 - found[-1][0] < TOGETHER_DEG:
        found[0][1].extend(found.pop()[1])
    return [(angle_deg, ", ".join(dict.fromkeys(texts))) for angle_deg, texts in found]


def _box(centre: tuple[float, float], width: float, height: float) -> Box:
    x, y = centre
    return x - width / 2 - _GAP / 2, y - height / 2 - 0.3, x + width / 2 + _GAP / 2, y + height / 2 + 0.3


def _meets(one: Box, others: list[Box]) -> bool:
    return any(one[0] < o[2] and o[0] < one[2] and one[1] < o[3] and o[1] < one[3] for o in others)


def sense(page: Page, centre: tuple[float, float], radius: float, begin_deg: float, end_deg: float) -> None:
    """The way in which a positive angle turns, with its sign at the tip."""
    steps = [begin_deg + (end_deg - begin_deg) * step / 12 for step in range(13)]
    page.arrow([on(centre, radius, angle) for angle in steps], INK, 0.6, sense="positive")
    x, y = on(centre, radius, end_deg + 9.0)
    page.text((x, y + 1.2), "+", "middle", 4.0, bold=True)


def gravity_arrow(page: Page, top: tuple[float, float], length: float) -> None:
    """Straight down the page."""
    page.arrow([top, (top[0], top[1] + length)], RED, 0.8, gravity="down")
    page.text((top[0], top[1] + length + 3.4), "gravity", "middle", colour=RED)
