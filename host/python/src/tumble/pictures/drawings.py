"""What one does with one's hands: the stand, how the block sits in each mounting, how the stand is inclined for it, the
angles of a mounting.

Every line follows from the schedule's matrices and angles (tumble.poses). Three projections: an oblique one that leaves
the front as it is, where what is away goes up to the right, at a fixed part of its length; and the views from the front
and from the right.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tumble import poses
from tumble.arrays import Floats
from tumble.errors import UsageError
from tumble.pictures.canvas import (
    BLACK,
    FONT_PT,
    FRAME,
    LARGE_PT,
    LINE,
    MARGIN,
    PLATE,
    PLATE_SIDE,
    POINTS,
    RED,
    SOFT,
    TALLEST,
    WIDTH_MM,
    arrow,
    axes_over,
    box,
    cut,
    paragraph,
    picture,
    sheet,
    width_of,
    wrapped,
)
from tumble.schedule import FIT, Mounting, Position, Schedule

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

OBLIQUE = ((1.0, 0.6, 0.0), (0.0, 0.4, 1.0))  # right and up on the page, of one unit to the right, away and up
FRONT = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
SIDE = ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
HALF = 0.42  # of the block's edge
REACH = 1.5  # of the arrows of its axes, from its centre
DIAL = 2.1  # radius of the circle of angles, seen from the front
TOGETHER_DEG = 3.0  # marks that are nearer to each other share a label

_FACES = ("#fff6e0", "#f0dfb8", "#dcc690")  # of the block: from the lightest to the darkest
_PLATES = (PLATE, PLATE_SIDE, PLATE_SIDE)
_STEEL = (PLATE, PLATE_SIDE, "#b9c2cc")
_LIGHT = np.array([0.25, -0.45, 0.86])  # where it comes from
_SEEN = 1e-9
_SIDE_MM, _TURNED = 7.0, 2.7  # from the right: size of a unit; radius of the arc of an inclination
_LABEL = {"ha": "center", "va": "center_baseline", "fontsize": LARGE_PT, "fontweight": "bold"}
_PLACARD = {"boxstyle": "circle,pad=0", "facecolor": "white", "edgecolor": "none"}  # no line runs through it
_TITLE: dict[str, Any] = {"ha": "center", "fontweight": "bold"}
_DISC, _THICK, _RADIUS, _FLOOR = 0.85, 0.14, 1.3, -2.0  # the table: face, thickness, size; the floor of the room
_BASE, _STAND, _DRIVE = (
    ([-1.1, 0.4, _FLOOR - 0.12], [1.1, 2.7, _FLOOR]),
    ([-0.35, 1.5, _FLOOR], [0.35, 2.3, -0.6]),
    ([-0.6, 1.3, -0.6], [0.6, 2.5, 0.6]),
)


@picture
def stand(schedule: Schedule) -> Figure:
    """The stand at table angle 0 in an oblique view, and from the front with the schedule's angles."""
    angles_deg = sorted({round(one.angle_deg % 360.0, 6) % 360.0 for one in schedule.positions})
    about = (
        "The axis of the stand is horizontal. Seen from the front, where the block is, the table is behind the block."
        " The table's frame turns with it: h points to the right at angle 0, n away along the axis, v up at angle 0. A"
        " positive angle raises h and tips v to the left, counterclockwise. Gravity points down. Angles of this"
        f" schedule, in degrees: {', '.join(f'{angle:g}' for angle in angles_deg)}."
    )
    page = sheet("stand", "A block on a rotary stand with one horizontal axis", about, "The stand")
    page.text(54.0, 14.0, "at table angle 0", **_TITLE)
    page.text(126.0, 14.0, "seen from the front, along +n", **_TITLE)
    _whole_stand(View(page, OBLIQUE, (48.0, 53.0), 15.0))
    front = View(page, FRONT, (126.0, 51.0), 11.0)
    front.dial()
    front.block(np.eye(3), HALF)
    front.arrows(np.eye(3), "hnv", FRAME, 1.3)
    for angle in angles_deg:
        front.mark(angle, f"mark {angle:g}")
    apart = [angle for angle, _ in _gathered((one, "") for one in angles_deg)]
    front.label_marks([(angle, f"{angle:g}°") for angle in apart], farthest=4.0, leave_out=True)
    for x, y in ((12.0, 34.0), (161.5, 67.0)):
        arrow(page, [(x, y), (x, y + 14.0)], RED, 2.3, label="gravity")
        page.text(x, y + 17.4, "gravity", ha="center", color=RED)
    y = 92.0
    for text in (
        "h, n, v turn with the table: h across the axis, n along it towards the table, v up at angle 0.",
        "Positive angle: h rises and v tips to the left, counterclockwise as seen from the front.",
        "Gravity points straight down. An axis that points up feels +1 g.",
        *(f"Mounting {one.number}: {poses.tilt(one)}." for one in schedule.mountings if one.tilt_deg),
    ):
        y = paragraph(page, MARGIN, y, text, WIDTH_MM - 2 * MARGIN) + 0.6
    return cut(page, y)


def _whole_stand(room: View) -> None:
    """Back to front: base, drive, table, block; then the frame, what turns, and the names of the parts."""
    for low, high in (_BASE, _STAND, _DRIVE):
        room.box(np.eye(3), low, high, _STEEL)
    room.table()
    room.block(np.eye(3), HALF)
    room.axis(-HALF, -2.3)
    room.arrows(np.eye(3), "hnv", FRAME)
    room.sense(_RADIUS - 0.12, 32.0, 70.0, _DISC)
    top = room.at([0.0, _DISC + _THICK, _RADIUS + 0.08])
    room.axes.text(*top, "0°", ha="center")
    for name, part, place, side in (
        ("drive", [0.6, 1.9, 0.3], (2.35, 1.8), "left"),
        ("table", [0.9, _DISC, 0.8], (2.05, 2.15), "left"),
        ("block", [-0.35, -HALF, 0.3], (-1.1, 0.2), "right"),
        ("platform", [-0.6, -0.7, -0.47], (-1.6, -1.5), "right"),
        ("axis, horizontal", [0.0, -2.3, 0.0], (-1.5, -1.0), "right"),
    ):
        leader = {"arrowstyle": "-", "color": SOFT, "linewidth": 0.7, "shrinkA": 1.0, "shrinkB": 0.0}
        leader["relpos"] = (0.0 if side == "left" else 1.0, 0.4)
        room.axes.annotate(name, room.at(part), place, ha=side, va="center", color=SOFT, arrowprops=leader)


@picture
def mountings(schedule: Schedule) -> Figure:
    """Every mounting with its block axes as the matrix has them, at table angle 0, in an oblique view; of a schedule
    that is laid by hand without axis and table."""
    is_laid, count = schedule.is_laid_by_hand, len(schedule.mountings)
    level = [replace(one, tilt_deg=0.0) for one in schedule.mountings]  # what a person sees who seats the block
    heading = "How the block lies" if is_laid else "How the block sits on the table"
    seen = "Seen from the front, where the block is, along the axis of the stand, with the table at angle 0."
    about = ["Laid by hand, seen from the front." if is_laid else seen]
    about += [f"Mounting {one.number}: {', '.join(poses.axes(one, 0.0))}." for one in level]
    title = f"{heading}: {count} mounting{'s' if count > 1 else ''}"
    page = sheet("mountings", title, " ".join(about), heading)
    before_you = "Table at angle 0. You stand in front: the block is before you, the table behind it."
    before_you = "Laid by hand, on something level. You stand in front." if is_laid else before_you
    paragraph(page, MARGIN, 12.5, before_you, 108.0, color=SOFT)
    _frame(View(page, OBLIQUE, (137.0, 15.5), 6.0))
    columns = min(3, count)
    width = (WIDTH_MM - 2 * MARGIN) / columns
    said = [[*poses.axes(one, 0.0), poses.tilt(real)] for one, real in zip(level, schedule.mountings)]
    captions = [[line for one in words for line in wrapped(one, width - 8.0)] for words in said]
    y = 20.0
    for first in range(0, count, columns):
        row = range(first, min(first + columns, count))
        # Where the words under a picture begin, mm: clear of the labels of axes that come down towards one.
        lowest = min(float((np.array(level[i].matrix) @ np.array(OBLIQUE)[1]).min()) for i in row)
        below = max(51.0, 32.0 - 12.5 * REACH * lowest + 8.5)
        height = below - 1.0 + LINE * max(len(captions[index]) for index in row)
        for index in row:
            middle = MARGIN + (index - first + 0.5) * width
            box(page, middle - width / 2 + 0.5, y, width - 1.0, height, edgecolor=SOFT)
            page.text(middle, y + 5.0, f"mounting {level[index].number}", fontsize=LARGE_PT, **_TITLE)
            room, pose = View(page, OBLIQUE, (middle, y + 32.0), 12.5), poses.pose(level[index], 0.0)
            if not is_laid:
                room.table()
            room.block(pose, HALF * float(np.abs(pose[:, poses.UP]).sum()))
            if not is_laid:
                room.axis(-HALF, -2.3)
            room.arrows(pose, "xyz", label=f"mounting {level[index].number}: ")
            for place, line in enumerate(captions[index]):
                page.text(middle, y + below + place * LINE, line, ha="center")
        y += height + MARGIN
    return cut(page, y)


def _frame(room: View) -> None:
    """Which way the frame of the table points."""
    for name, axis, where, place, side in (
        ("h", [1.5, 0.0, 0.0], "right", (0.2, 0.0), "left"),
        ("n", [0.0, 1.5, 0.0], "away", (0.2, 0.05), "left"),
        ("v", [0.0, 0.0, 1.5], "up", (-0.2, -0.2), "right"),
    ):
        tip = room.at(axis)
        arrow(room.axes, [(0.0, 0.0), tip], FRAME, 1.1)
        room.axes.text(*(tip + place), f"{name}: {where}", ha=side, va="center", color=FRAME)


@picture
def inclinations(schedule: Schedule) -> Figure:
    """From the right, the stand as it is inclined for each mounting that shares its bolting with others. Raises
    UsageError where the schedule has none."""
    boltings = [one.bolting for one in schedule.mountings]
    bolted = [one for one in schedule.mountings if one.bolting is not None and boltings.count(one.bolting) > 1]
    if not bolted:
        raise UsageError("no mountings of this schedule share a bolting, as those of inclined do")
    told = [f"Mounting {one.number}: {poses.tilt(one) or 'axis level'}." for one in bolted]
    about = "Seen from the right, with the table at angle 0: the block is at the left, on the near end of the axis."
    heading = "How the stand is inclined, the block bolted on once"
    page = sheet("inclinations", heading, " ".join([about, *told]), heading)
    paragraph(
        page, MARGIN, 12.5, f"{about} Each angle is set approximately and locked, not measured.", 162.0, color=SOFT
    )
    columns = min(3, len(bolted))
    width = (WIDTH_MM - 2 * MARGIN) / columns
    floor = 12.0
    for index, one in enumerate(bolted):
        if index % columns == 0:
            row = bolted[index : index + columns]
            tops = [max(REACH + 0.4, float(_corners(other)[:, poses.UP].max())) for other in row]
            floor += _SIDE_MM * max(top - _bottom(other) for top, other in zip(tops, row)) + 9.0
        middle = MARGIN + (index % columns + 0.5) * width
        page.plot([middle - 0.46 * width, middle + 0.46 * width], [floor, floor], color=SOFT, linewidth=0.85)
        _inclined(View(page, SIDE, (middle - 0.8 * _SIDE_MM, floor + _bottom(one) * _SIDE_MM), _SIDE_MM), one)
        page.text(middle, floor + 5.0, f"mounting {one.number}", fontsize=LARGE_PT, **_TITLE)
        raised = "far end raised" if one.tilt_deg > 0.0 else "near end raised" if one.tilt_deg else "axis level"
        page.text(middle, floor + 5.0 + LINE, raised, ha="center")
        floor += 5.0 + 2 * LINE if index % columns == columns - 1 else 0.0
    below = floor if len(bolted) % columns == 0 else floor + 5.0 + 2 * LINE
    return cut(page, below)


def _corners(mounting: Mounting) -> Floats:
    """Of base and drive of the stand that is inclined for a mounting: (corners, 3)."""
    sides = [[low, high] for low, high in (_BASE, _DRIVE)]
    places = [[x[0], y[1], z[2]] for ends in sides for x in ends for y in ends for z in ends]
    corners: Floats = np.array([*places, [0.0, _DISC, _RADIUS]]) @ poses.table(0.0, mounting.tilt_deg)
    return corners


def _bottom(mounting: Mounting) -> float:
    """Where the floor is: below the stand, and below the block on its near end."""
    return min(-REACH - 0.5, float(_corners(mounting)[:, poses.UP].min()))


def _inclined(room: View, mounting: Mounting) -> None:
    """The stand on its wedge, the block on its table, and the angle of the axis, with its sign."""
    frame, tilt_deg = poses.table(0.0, mounting.tilt_deg), mounting.tilt_deg
    low, high = np.array(_BASE[0]), np.array(_BASE[1])
    under = np.array([[0.0, low[1], low[2]], [0.0, high[1], low[2]]]) @ frame
    feet = under.copy()
    feet[:, poses.UP] = _bottom(mounting)
    room.face([*under, *feet[::-1]], PLATE, SOFT)  # the wedge
    for part in (_BASE, _STAND, _DRIVE, ([-_RADIUS, _DISC, -_RADIUS], [_RADIUS, _DISC + _THICK, _RADIUS])):
        room.box(frame, *part, _STEEL)
    pose = poses.pose(mounting, 0.0)
    below = HALF * float(np.abs(np.array(mounting.matrix)[:, 2]).sum())
    room.box(frame, [-0.8, -HALF, -below - 0.1], [0.8, _DISC, -below], _PLATES)
    room.box(pose, [-HALF] * 3, [HALF] * 3)
    room.line([[0.0, 0.0, 0.0], [0.0, _TURNED + 0.4, 0.0]], SOFT, 0.7, (0.0, (2.6, 2.0)))
    room.line(np.array([[0.0, -1.3, 0.0], [0.0, _TURNED + 0.4, 0.0]]) @ frame, SOFT, 0.85, (0.0, (10.0, 2.7, 2.0, 2.7)))
    turned = np.deg2rad(np.linspace(0.0, tilt_deg, 16))
    if tilt_deg:
        curve = np.stack([0.0 * turned, np.cos(turned), np.sin(turned)], axis=1)
        arrow(room.axes, room.at(_TURNED * curve), BLACK, 1.3, label=f"inclination {mounting.number}")
    half = np.deg2rad(0.5 * tilt_deg)
    place = (_TURNED + 0.75) * np.array([0.0, np.cos(half), np.sin(half)])
    said = f"{tilt_deg:+g}°" if tilt_deg else "0°"
    room.axes.text(*room.at(place), said, ha="center", va="center", fontweight="bold")
    room.arrows(pose, "xyz", label=f"mounting {mounting.number}: ")


@picture
def angles(schedule: Schedule, mounting: int) -> Figure:
    """Round the axis, where the table stands at each position of the mounting of that number; and round the block,
    where gravity points. Raises UsageError where the schedule has no such mounting."""
    seat = next((one for one in schedule.mountings if one.number == mounting), None)
    if seat is None:
        known = ", ".join(str(one.number) for one in schedule.mountings)
        raise UsageError(f"no mounting {mounting} in this schedule, which has {known}")
    positions = [one for one in schedule.positions if one.mounting == mounting]
    told = [f"{one.number}: {one.angle_deg:g} deg, {poses.line(seat, one.angle_deg)}." for one in positions]
    about = " ".join(["Seen from the front, along the axis; positive is counterclockwise. Positions:", *told])
    page = sheet("angles", f"The angles of mounting {mounting}", about)
    for x, title, what in (
        (46.0, "the table, seen from the front", "where the mark of angle 0 goes"),
        (124.0, "the block, kept still", "where gravity points, by position"),
    ):
        page.text(x, 14.0, title, **_TITLE)
        page.text(x, 18.2, what, ha="center", color=SOFT)
    pose = poses.pose(replace(seat, tilt_deg=0.0), 0.0)
    table, block = (View(page, FRONT, (x, 51.0), 11.0) for x in (46.0, 124.0))
    table.dial()
    table.block(pose, HALF * float(np.abs(pose[:, poses.UP]).sum()))
    table.arrows(pose, "xyz", reach=1.1)
    for one in positions:
        table.mark(one.angle_deg, f"position {one.number}")
        # In h, n, v, which are right, away and up here. What a tilted axis takes out of the plane makes arrows shorter.
        down = block.at(poses.gravity(seat, one.angle_deg) @ np.array(seat.matrix)) * DIAL
        arrow(block.axes, [0.75 * down, down], RED, 1.7, label=f"gravity {one.number}")
    block.box(pose, [-HALF] * 3, [HALF] * 3)
    block.arrows(pose, "xyz", reach=0.95)
    below = max(
        table.label_marks([(one.angle_deg, str(one.number)) for one in positions]),
        block.label_marks([(180.0 - one.angle_deg, str(one.number)) for one in positions]),
    )
    y = _listed(page, seat, positions, max(92.0, below + 13.0))
    return cut(page, y)


def _listed(page: Axes, mounting: Mounting, positions: list[Position], y: float) -> float:
    """The table of positions, from y on. Returns the y below it."""
    columns = (20.0, 36.0, 40.0, 70.0, 83.0, 96.0, 101.0)
    sides = ("right", "right", "left", "right", "right", "right", "left")
    page.text(78.0, y - LINE, "what the axes read, g", **_TITLE)
    for x, side, name in zip(columns, sides, ("position", "angle", "use", "x", "y", "z", "up")):
        page.text(x, y, name, ha=side, fontweight="bold")
    page.plot([MARGIN, WIDTH_MM - MARGIN], [y + 1.4, y + 1.4], color=SOFT, linewidth=0.7)
    for one in positions:
        y += LINE + 0.4
        feels = [f"{0.0 - round(float(size), 3):+.3f}" for size in poses.gravity(mounting, one.angle_deg)]
        feels = ["0" if float(size) == 0.0 else size for size in feels]
        use = "fit" if one.use == FIT else "check only"
        cells = (str(one.number), f"{one.angle_deg:g}°", use, *feels, poses.face_up(mounting, one.angle_deg))
        for x, side, cell in zip(columns, sides, cells):
            page.text(x, y, cell, ha=side, color=SOFT if cell == "0" else BLACK)
    tilted = poses.tilt(mounting).capitalize()
    note = "Specific force at rest: an axis that points up reads +1 g." + (f" {tilted}." if tilted else "")
    return paragraph(page, MARGIN, y + 2 * LINE, note, WIDTH_MM - 2 * MARGIN, color=SOFT)


class View:
    """Block and table from one side: axes on a page, on which places in (right, away, up) are drawn."""

    def __init__(self, page: Axes, projection: tuple[tuple[float, ...], ...], origin: tuple[float, float], mm: float):
        """`origin`: on the page; `mm`: of a unit."""
        (x, y), whole = origin, page.figure
        self.axes: Any = axes_over(whole, ((0.0 - x) / mm, (WIDTH_MM - x) / mm), ((y - TALLEST) / mm, y / mm))
        self._projection, self._mm, self._y = np.array(projection), mm, origin[1]
        across, up = self._projection
        self._eye: Floats = np.cross(across, up)  # towards it: what the projection loses

    def at(self, places: Any) -> Floats:
        """Places (..., 3) on the axes: (..., 2)."""
        onto: Floats = np.asarray(places) @ self._projection.T
        return onto

    def line(self, places: Any, colour: str, width: float, style: Any = "-", label: str = "") -> None:
        self.axes.plot(*self.at(places).T, color=colour, linewidth=width, linestyle=style, label=label)

    def face(self, places: Any, colour: str, edge: str = BLACK) -> None:
        self.axes.fill(*self.at(places).T, facecolor=colour, edgecolor=edge, linewidth=0.7, joinstyle="round")

    def box(self, pose: Floats, low: Any, high: Any, fills: tuple[str, str, str] = _FACES) -> None:
        """A solid from corner to corner along three axes (rows). `fills`: for light, half and dark faces."""
        corners = np.array([low, high])
        for axis, side in np.ndindex(3, 2):
            outwards = pose[axis] * (2 * side - 1)
            if outwards @ self._eye > _SEEN:
                others, face = [axis - 1, axis - 2], np.full((4, 3), corners[side, axis])
                face[:, others] = corners[[[0, 0], [1, 0], [1, 1], [0, 1]], others]
                bright = float(outwards @ _LIGHT)
                self.face(face @ pose, fills[0 if bright > 0.7 else 1 if bright > 0.35 else 2])

    def block(self, pose: Floats, below: float) -> None:
        """The block, a cube around the origin, on its platform so far `below`."""
        self.box(np.eye(3), [-0.8, -0.7, -below - 0.1], [0.8, _DISC, -below], _PLATES)
        self.box(pose, [-HALF] * 3, [HALF] * 3)

    def table(self) -> None:
        """The table at angle 0, with the part of the axis behind it."""
        self.axis(_DISC, 2.3)
        for away, colour in ((_DISC + _THICK, PLATE_SIDE), (_DISC, PLATE)):
            self.face(arc(_RADIUS, 0.0, 360.0, away), colour, SOFT)
        self.line([[0.0, _DISC, _RADIUS - 0.18], [0.0, _DISC, _RADIUS]], BLACK, 1.4)

    def axis(self, begin: float, end: float) -> None:
        """A part of the axis of the stand."""
        self.line([[0.0, begin, 0.0], [0.0, end, 0.0]], SOFT, 0.85, (0.0, (10.0, 2.7, 2.0, 2.7)))

    def arrows(self, pose: Floats, names: str, colour: str = BLACK, reach: float = REACH, label: str = "") -> None:
        """Arrows of three axes out of the block around the origin, each with its name: over the block where they come
        out of a face that is seen, dashed where it hides them; one that points at the eye is a dot, one that points
        away a cross."""
        towards = pose @ self._eye
        placed: list[Floats] = []
        for number, name in enumerate(names):
            tip = self.at(reach * pose[number])
            along, beyond = tip, 2.3
            if np.hypot(*tip) * self._mm < 1.5:
                look: dict[str, Any] = {"color": colour, "markeredgewidth": 1.1, "linestyle": "none"}
                self.axes.plot(*tip, marker="o", markersize=8.0, markerfacecolor="white", **look)
                self.axes.plot(*tip, marker="x" if towards[number] < 0.0 else ".", markersize=5.5, **look)
                along, beyond = -self.at(pose[number - 1] + pose[number - 2]), 3.6
            else:
                others = max(abs(float(towards[number - 1])), abs(float(towards[number - 2])), _SEEN)
                behind = HALF * float(-towards[number]) / others if towards[number] < -_SEEN else 0.0
                out = min(reach - 0.25, HALF + behind)  # so that the head is always seen
                if behind:
                    self.line(
                        [np.zeros(3), out * pose[number]], colour, 1.0, (0.0, (2.6, 2.0)), f"{label}{name} hidden"
                    )
                arrow(self.axes, [self.at(out * pose[number]), tip], colour, 1.7, label=label + name)
            along = along / np.hypot(*along)
            while any(np.hypot(*(tip + beyond / self._mm * along - one)) * self._mm < 3.6 for one in placed):
                beyond += 0.5
            placed.append(tip + beyond / self._mm * along)
            self.axes.text(*placed[-1], name, color=colour, bbox=_PLACARD, **_LABEL)

    def dial(self) -> None:
        """The table from the front, with the way in which a positive angle turns."""
        from matplotlib.patches import Circle

        self.axes.add_patch(Circle((0.0, 0.0), DIAL, facecolor=PLATE, edgecolor=SOFT, linewidth=1.0))
        self.sense(DIAL - 0.36, 12.0, 42.0)

    def sense(self, radius: float, begin_deg: float, end_deg: float, away: float = 0.0) -> None:
        """The way in which a positive angle turns, with its sign at the tip."""
        arrow(self.axes, self.at(arc(radius, begin_deg, end_deg, away)), BLACK, 1.7, label="positive")
        sign = self.at(arc(radius, end_deg + 9.0, end_deg + 9.0, away)[0])
        self.axes.text(*sign, "+", fontsize=11.0, ha="center", va="center", fontweight="bold")

    def mark(self, angle_deg: float, label: str) -> None:
        """Of an angle, on the dial."""
        end = self.at(arc(DIAL, angle_deg, angle_deg)[0])
        self.axes.plot(*np.transpose([0.89 * end, end]), color=BLACK, linewidth=1.4, label=label)

    def label_marks(self, marks: Iterable[tuple[float, str]], farthest: float = 15.0, leave_out: bool = False) -> float:
        """The names of angles (degrees, name) round the dial, where they do not run into each other: as far out as they
        need, up to `farthest` mm. `leave_out`: what has no room then. Returns the y below all of them, mm."""
        from matplotlib.transforms import Bbox

        taken: list[Any] = []
        for angle, text in _gathered(marks):
            way = self.at(arc(1.0, angle, angle)[0])
            size = np.array([width_of(text), FONT_PT / POINTS])
            least = DIAL * self._mm + 1.2 + 0.5 * float(np.abs(way) @ size)
            for out in np.arange(least, least + farthest, 0.8):
                half = 0.5 * size + (0.6, 0.3)
                extent = Bbox([out * way - half, out * way + half])
                if not any(extent.overlaps(one) for one in taken):
                    break
            else:
                if leave_out:
                    continue
            taken.append(extent)
            place = out / self._mm * way
            self.axes.text(*place, text, ha="center", va="center", label=f"angle {angle:g}")
            if out - DIAL * self._mm - 0.5 * size[0] * abs(way[0]) > 4.0:
                self.axes.plot(*np.transpose([DIAL * way, place - 2.2 / self._mm * way]), color=SOFT, linewidth=0.6)
        return self._y - min((one.y0 for one in taken), default=0.0)


def arc(radius: float, begin_deg: float, end_deg: float, away: float = 0.0) -> Floats:
    """Places (n, 3) of a circle round the axis, from one table angle to another: where the table's up mark goes."""
    angle = np.deg2rad(np.linspace(begin_deg, end_deg, max(2, round(abs(end_deg - begin_deg) / 4.0))))
    return np.stack([-radius * np.sin(angle), np.full_like(angle, away), radius * np.cos(angle)], axis=1)


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
