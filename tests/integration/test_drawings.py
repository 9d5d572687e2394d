"""`tumble draw`: what is drawn is what the matrices, the angles and the tables say, legibly.

The projection and the way of a pose are worked out here once more, by other means. What a shape means is its label.
"""

import functools
import itertools
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import ROOT
from drawn_schedules import SCHEDULES, rotations, turned_somehow
from matplotlib import colors
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from tumble import pictures
from tumble.errors import UsageError
from tumble.model import Geometry
from tumble.schedule import Mounting, Position, Schedule

pytestmark = pytest.mark.python

SVG = "{http://www.w3.org/2000/svg}"
AWAY = np.array([0.6, 0.4])  # where a unit away from the eye goes in the oblique view
PAPER, DIAL = "#eef1f4", 2.1
PAGES = [("states",), ("wiring",)]
PAGES += [(subject, name) for subject in ("stand", "mountings") for name in SCHEDULES]
STEEP = tuple(Mounting(number, turned_somehow(2), tilt_deg, 9)
              for number, tilt_deg in ((5, 80.0), (6, -80.0), (77, 12.5), (200, -0.5), (255, 0.0)))  # fmt: skip
SCHEDULES = {**SCHEDULES, "steep": Schedule(STEEP, tuple(Position(one.number, 1, 30.0) for one in STEEP))}
INCLINED = ("inclined", "inclined_closed", "steep")
PAGES += [("inclinations", name) for name in INCLINED]
PAGES += [("angles", name, SCHEDULES[name].mountings[index].number) for name in SCHEDULES for index in (0, -1)]


def name_of(page):
    return "-".join(map(str, page))


@functools.cache
def draw(subject, name=None, *rest):
    return getattr(pictures, subject)(*([] if name is None else [SCHEDULES[name]]), *rest)


def all_of(figure, kind):
    """The `kind` (lines, patches, texts) of all its axes."""
    return [one for axes in figure.axes for one in getattr(axes, kind)]


def labelled(figure, kind, label):
    return [one for one in all_of(figure, kind) if one.get_label() == label]


def written(figure):
    """The texts that can be read; the others are arrows."""
    return [one for one in all_of(figure, "texts") if one.get_text()]


def said(figure):
    return " ".join(one.get_text() for one in written(figure))


def box_of(text):
    """Of a text: what its letters take of its line."""
    box = Text.get_window_extent(text)  # of a note without its leader
    return Bbox.from_extents(box.x0, box.y0 + 0.15 * box.height, box.x1, box.y1 - 0.15 * box.height)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_a_page_is_well_formed_white_narrow_and_says_what_it_shows(page):
    figure = draw(*page)
    text = pictures.svg(figure)
    root = ElementTree.fromstring(text)
    width, height = (root.get(key).removesuffix("pt") for key in ("width", "height"))
    assert float(width) / 72.0 * 25.4 <= 170.01 and root.get("viewBox") == f"0 0 {width} {height}"
    title, about = list(root)[:2]
    assert (title.tag, about.tag) == (SVG + "title", SVG + "desc") and len(about.text) > 80 and title.text
    assert root.get("role") == "img" and figure.patch.get_visible()
    assert figure.get_facecolor() == colors.to_rgba("white")
    assert not re.search(r"\bnan|\binf\b|<image", text)
    assert sorted(one.text for one in root.iter(SVG + "text")) == sorted(one.get_text() for one in written(figure))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_no_text_is_smaller_than_eight_points_and_nothing_leaves_the_page(page):
    figure = draw(*page)
    figure.draw_without_rendering()  # arrows have their ends from then on
    assert min(one.get_fontsize() for one in written(figure)) >= 8.0
    low, high = figure.bbox.min - 0.1, figure.bbox.max + 0.1
    arrows = [one.arrow_patch for one in all_of(figure, "texts") if getattr(one, "arrow_patch", None)]
    for one in (*all_of(figure, "lines"), *all_of(figure, "patches"), *arrows, *written(figure)):
        box = one.get_window_extent()
        assert (box.min >= low).all() and (box.max <= high).all(), one


def contrast(one, other):
    """Of WCAG 2.2."""
    shades = []
    for colour in (one, other):
        rgb = np.array(colors.to_rgb(colour))
        linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
        shades.append(float(linear @ (0.2126, 0.7152, 0.0722)) + 0.05)
    return max(shades) / min(shades)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_text_stands_out_in_grey(page):
    """At 4.5 : 1 at least, on white and on what is grey; and white letters on the dark circle that they stand in."""
    for one in written(draw(*page)):
        behind = one.get_bbox_patch()
        assert contrast(one.get_color(), PAPER if behind is None else behind.get_facecolor()) >= 4.5, one


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_no_text_runs_into_another_or_off_the_page(page):
    figure = draw(*page)
    figure.draw_without_rendering()  # a note has its place from then on
    placed = sorted(((*box_of(one).extents, one.get_text()) for one in written(figure)), key=lambda one: one[0])
    for index, one in enumerate(placed):
        assert one[0] >= 0.0 and one[2] <= figure.bbox.x1, one
        for other in placed[index + 1 :]:
            if other[0] >= one[2]:
                break
            assert not (one[1] < other[3] and other[1] < one[3]), (one, other)


# Inclinations.


@pytest.mark.parametrize("name", INCLINED)
def test_the_stand_is_drawn_inclined_as_the_schedule_has_it(name):
    """Seen from the right: what points away is drawn to the right, what points up upwards, what points at you a dot."""
    figure, text = draw("inclinations", name), said(draw("inclinations", name))
    for one in SCHEDULES[name].mountings:
        tilt = np.deg2rad(one.tilt_deg)
        axis, across = np.array([np.cos(tilt), np.sin(tilt)]), np.array([-np.sin(tilt), np.cos(tilt)])
        for letter, (_, n, v) in zip("xyz", one.matrix):
            arrows = labelled(figure, "texts", f"mounting {one.number}: {letter}")
            assert len(arrows) == (np.hypot(n, v) > 0.15)
            for arrow in arrows:
                assert arrow.xy == pytest.approx(1.5 * (n * axis + v * across), abs=1e-9)
        arcs = labelled(figure, "texts", f"inclination {one.number}")
        assert len(arcs) == (one.tilt_deg != 0.0) and all(arc.xy == pytest.approx(2.7 * axis) for arc in arcs)
        assert (f"{one.tilt_deg:+g}°" if one.tilt_deg else " 0°") in text and f"mounting {one.number} " in text
    assert text.count("far end raised") == sum(one.tilt_deg > 0.0 for one in SCHEDULES[name].mountings)
    assert text.count("near end raised") == sum(one.tilt_deg < 0.0 for one in SCHEDULES[name].mountings)


def test_mountings_of_boltings_of_their_own_are_no_inclinations():
    mountings = [Mounting(number, STEEP[0].matrix, 10.0, number) for number in (1, 2)]
    alone = Schedule(tuple(mountings), tuple(Position(one.number, 1, 0.0) for one in mountings))
    for schedule in (alone, SCHEDULES["paper"]):
        with pytest.raises(UsageError, match=r"^no mountings of this schedule share a bolting"):
            pictures.inclinations(schedule)


# Mountings.


def projected(row):
    h, n, v = row
    return np.array([h, v]) + n * AWAY


@pytest.mark.parametrize("name", SCHEDULES)
def test_the_axes_of_every_mounting_end_where_the_matrix_has_them(name):
    figure = draw("mountings", name)
    for mounting in SCHEDULES[name].mountings:
        drawn = []
        for axis, row in zip("xyz", mounting.matrix):
            expected = 1.5 * projected(row)
            arrows = labelled(figure, "texts", f"mounting {mounting.number}: {axis}")
            if arrows:
                (arrow,) = arrows
                assert arrow.xy == pytest.approx(expected, abs=1e-9)
                (label,) = (one for one in arrow.axes.texts if one.get_text() == axis)
                beyond = np.array(label.get_position())
                assert beyond @ expected > 0.99 * np.hypot(*beyond) * np.hypot(*expected)
                assert np.hypot(*beyond) > np.hypot(*expected) and arrow.get_label() not in drawn
                drawn.append(arrow.get_label())
                (number,) = (one for one in written(figure) if one.get_text() == f"mounting {mounting.number}")
                origin = arrow.axes.transData.transform((0.0, 0.0))  # below the number of the mounting
                assert number.get_window_extent().x0 < origin[0] < number.get_window_extent().x1
                assert 0.0 < (number.get_window_extent().y0 - origin[1]) / figure.dpi * 25.4 < 30.0
            else:
                assert np.hypot(*expected) * 12.5 < 1.51
        assert len(drawn) >= 2  # of three at right angles no two point at the eye
    numbers = [int(text[9:]) for text in (one.get_text() for one in written(figure)) if re.match(r"mounting \d", text)]
    assert numbers == [one.number for one in SCHEDULES[name].mountings]


def towards_the_eye(row):
    """Above 0: the axis comes out of a face that is seen. The line of sight, in h, n, v, holds all places that fall
    onto one point of the page."""
    sight = np.array([AWAY[0], -1.0, AWAY[1]])
    assert np.abs(projected(sight)).max() < 1e-12
    return float(np.dot(row, sight))


@pytest.mark.parametrize("name", SCHEDULES)
def test_an_axis_out_of_a_hidden_face_is_dashed_within_the_block_and_the_others_are_not(name):
    figure = draw("mountings", name)
    for mounting in SCHEDULES[name].mountings:
        for axis, row in zip("xyz", mounting.matrix):
            label = f"mounting {mounting.number}: {axis}"
            dashed = labelled(figure, "lines", f"{label} hidden")
            assert all(one.is_dashed() for one in dashed)
            if abs(towards_the_eye(row)) > 1e-6 and labelled(figure, "texts", label):
                assert len(dashed) == (towards_the_eye(row) < 0.0)


@pytest.mark.parametrize("matrix", [*rotations()])
def test_all_right_angled_mountings_are_drawn_proper(matrix):
    """Of the three drawn axes the third is where the first two, right-handed, put it."""
    figure = pictures.mountings(Schedule((Mounting(1, matrix),), (Position(1, 1, 0.0),)))
    page = {"h": np.array([1.0, 0.0]), "n": AWAY, "v": np.array([0.0, 1.0])}
    seen = {}
    for axis in "xyz":
        (arrow,) = labelled(figure, "texts", f"mounting 1: {axis}")
        for frame, onto in page.items():
            for sign in (1, -1):
                if np.abs(np.array(arrow.xy) / 1.5 - sign * onto).max() < 1e-3:
                    seen[axis] = sign * np.eye(3)["hnv".index(frame)]
    assert np.array_equal(np.cross(seen["x"], seen["y"]), seen["z"])


@pytest.mark.parametrize("name", SCHEDULES)
def test_mountings_are_told_in_words_too(name):
    text, schedule = said(draw("mountings", name)), SCHEDULES[name]
    assert ("Laid by hand" in text) == schedule.is_laid_by_hand
    assert ("table behind it" in text) != schedule.is_laid_by_hand
    assert {"h: right", "n: away", "v: up"} <= {one.get_text() for one in written(draw("mountings", name))}
    tilted = [one for one in schedule.mountings if one.tilt_deg]
    assert text.count("axis tilted by") == len(tilted)


# Angles.


def from_the_top(place):
    """Degrees from up towards the left."""
    return np.rad2deg(np.arctan2(-place[0], place[1])) % 360.0


def rows_of(figure):
    """The lines of text of the page, each from left to right."""
    rows = {}
    for text in figure.axes[0].texts:
        rows.setdefault(round(text.get_position()[1], 6), []).append(text)
    return [[one.get_text() for one in sorted(row, key=lambda one: one.get_position()[0])] for row in rows.values()]


@pytest.mark.parametrize(("name", "number"), [page[1:] for page in PAGES if page[0] == "angles"])
def test_gravity_and_outputs_are_as_the_reference_has_them(name, number):
    schedule, figure = SCHEDULES[name], draw("angles", name, number)
    matrix = np.array(next(one.matrix for one in schedule.mountings if one.number == number))
    rows = {int(row[0]): row for row in rows_of(figure) if row[0].isdigit() and len(row) == 7}
    forces = Geometry(schedule).force()
    mine = [(one, force) for one, force in zip(schedule.positions, forces) if one.mounting == number]
    for position, force in mine:
        (arrow,) = labelled(figure, "texts", f"gravity {position.number}")
        in_table = -force @ matrix  # along h, n, v; the block is drawn as it sits at angle 0
        assert arrow.xy == pytest.approx(DIAL * in_table[[0, 2]], abs=1e-9)
        row = rows.pop(position.number)
        assert row[1:3] == [f"{position.angle_deg:g}°", {"fit": "fit", "check": "check only"}[position.use]]
        assert np.abs(np.array([float(one) for one in row[3:6]]) - force).max() < 6e-4
        assert re.match(r"face [+-][xyz]|the edge of|the corner of", row[6])
    assert not rows and mine


@pytest.mark.parametrize(("name", "number"), [page[1:] for page in PAGES if page[0] == "angles"])
def test_the_marks_stand_at_the_angles_counterclockwise_from_the_top(name, number):
    figure = draw("angles", name, number)
    for position in SCHEDULES[name].positions:
        if position.mounting == number:
            (mark,) = labelled(figure, "lines", f"position {position.number}")
            end = mark.get_xydata()[-1]
            assert abs((from_the_top(end) - position.angle_deg + 180.0) % 360.0 - 180.0) < 1e-6
            assert np.hypot(*end) == pytest.approx(DIAL)
    named = [one for one in written(figure) if one.get_label().startswith("angle ")]
    shown = [int(number) for one in named for number in one.get_text().split(", ")]
    assert sorted(shown) == sorted(2 * [one.number for one in SCHEDULES[name].positions if one.mounting == number])


def test_the_marks_of_the_paper_have_their_numbers():
    named = [one for one in written(draw("angles", "paper", 1)) if one.get_label().startswith("angle ")]
    labels = [(one.get_label().removeprefix("angle "), one.get_text()) for one in named]
    assert all(from_the_top(one.get_position()) == pytest.approx(float(one.get_label()[6:])) for one in named)
    numbers = ["1, 9", "2", "3", "4", "5", "6", "7", "8"]
    angles = [f"{angle:g}" for angle in range(0, 360, 45)]
    assert labels[:8] == list(zip(angles, numbers))
    # Gravity turns the other way, from the bottom: at 90 degrees h is up, so gravity is where -h is, on the left.
    assert {text: angle for angle, text in labels[8:]}["3"] == "90" and labels[8:][4] == ("180", "1, 9")


def test_a_mounting_that_is_not_there_is_named():
    with pytest.raises(UsageError, match="no mounting 3 in this schedule, which has 1, 2"):
        pictures.angles(SCHEDULES["paper"], 3)


@pytest.mark.parametrize("name", SCHEDULES)
def test_the_stand_has_a_mark_at_each_angle_and_its_sense_raises_h(name):
    figure = draw("stand", name)
    marks = {float(one.get_label()[5:]): one for one in all_of(figure, "lines") if one.get_label().startswith("mark ")}
    wanted = {round(one.angle_deg % 360.0, 6) % 360.0 for one in SCHEDULES[name].positions}
    assert sorted(marks) == pytest.approx(sorted(wanted), abs=1e-3)
    for angle, mark in marks.items():
        assert abs((from_the_top(mark.get_xydata()[-1]) - angle + 180.0) % 360.0 - 180.0) < 0.01
    front = next(iter(marks.values())).axes
    h, v = (next(np.array(one.xy) for one in front.texts if one.get_label() == axis) for axis in "hv")
    assert h == pytest.approx([1.3, 0.0]) and v == pytest.approx([0.0, 1.3])
    senses = labelled(figure, "lines", "positive")
    assert len(senses) == 2
    for line in senses:
        (x, y), (end_x, end_y) = line.get_xydata()[[0, -1]]
        assert end_x < x and end_y < y  # from the top to the left, as h turns upwards
    pulls = labelled(figure, "texts", "gravity")
    assert len(pulls) == 2 and said(figure).count("gravity") == 2
    for arrow in pulls:
        (x, y), (tip_x, tip_y) = (arrow.axes.transData.transform(one) for one in (arrow.xyann, arrow.xy))
        assert x == tip_x and tip_y < y
    named = {one.get_text() for one in written(figure)}
    assert {"drive", "table", "block", "platform", "axis, horizontal", "0°"} <= named


# The run and the bus.


def ways_of_the_table():
    """(from, to, by) by a plain look at the rows and the commands, another than the generator's."""
    folder = ROOT / "firmware/procedure"
    table = (folder / "procedure_states.c").read_text().split("tumble_procedure_rows[")[1]
    names = {"IN_MOTION": "COMMAND_ABORT", "AT_REST": "COMMAND_ABORT | COMMAND_REPEAT"}
    for name, meant in names.items():
        assert re.search(rf"#define {name} \(?{re.escape(meant)}\)?\n", (folder / "procedure_states.c").read_text())
    goals = {"START": "PREFLIGHT", "RESUME": "PREFLIGHT", "REPEAT": "PREFLIGHT", "ABORT": "ABORT", "CONFIRM": "NEXT"}
    state = None
    for line in table.splitlines():
        if begun := re.match(r"    \[TUMBLE_STATE_(\w+)\] = ", line):
            state = begun[1]
        for by, goal in re.findall(r"\.(done|other) = TO\((\w+)\)", line):
            yield state, goal, by
        if re.search(r"\.(timeout|watch) = ", line) or state in ("SOLVE", "VERIFY"):
            yield state, "FAULT", "fault"
        if given := re.search(r"\.commands = ([^,]*),", line):
            for word in re.findall(r"\w+", given[1]):
                for command in re.findall(r"COMMAND_(\w+)", names.get(word, word)):
                    yield state, "PREFLIGHT" if (state, command) == ("FAULT", "CONFIRM") else goals[command], command


def boxes_of(figure):
    """Of each state or node: left, top, right, bottom, mm."""
    return {one.get_label(): (one.get_x(), one.get_y(), one.get_x() + one.get_width(), one.get_y() + one.get_height())
            for one in all_of(figure, "patches") if one.get_label()}  # fmt: skip


def within(figure, box):
    left, top, right, bottom = box
    places = ((one, one.get_position()) for one in written(figure))
    return [one for one, (x, y) in places if left <= x <= right and top <= y <= bottom]


def test_every_state_and_every_way_of_the_table_is_drawn():
    figure = draw("states")
    header = (ROOT / "firmware/procedure/states.h").read_text()
    listed = re.findall(r'X\(TUMBLE_STATE_(\w+), "([^"]*)"\)', header)
    shown = {name: " ".join(one.get_text() for one in within(figure, box) if not one.get_label())
             for name, box in boxes_of(figure).items()}  # fmt: skip
    assert shown == {name: f"{name} {sentence}" for name, sentence in listed}
    drawn = {tuple(one.get_label().split()) for one in all_of(figure, "texts") if one.get_label()}
    assert drawn == set(ways_of_the_table()) and len(drawn) > 45
    about = list(ElementTree.fromstring(pictures.svg(figure)))[1].text
    assert all(f"{begin} to {end} by {by}" in about for begin, end, by in drawn)


@pytest.mark.parametrize("page", ["states", "wiring"])
def test_words_of_a_box_stand_within_it(page):
    figure = draw(page)
    for box in boxes_of(figure).values():
        corners = figure.axes[0].transData.transform([(box[0], box[3]), (box[2], box[1])])
        for text in within(figure, box):
            extent = box_of(text)
            assert (extent.min > corners[0]).all() and (extent.max < corners[1]).all(), text


def test_arrows_of_the_run_begin_and_end_at_their_states_and_cross_no_other():
    figure = draw("states")
    places = boxes_of(figure)
    lines = [one for one in all_of(figure, "lines") if len(one.get_label().split()) == 3]
    assert len(lines) == 1 + len([by for _, _, by in ways_of_the_table() if by in ("done", "other")])
    for line in lines:
        begin, end, by = line.get_label().split()
        (head,) = (one for one in labelled(figure, "texts", line.get_label()) if not one.get_text())
        path = [*line.get_xydata()[:-1], np.array(head.xy)]
        assert line.is_dashed() == (by not in ("done", "other"))
        for name, place in ((begin, path[0]), (end, path[-1])):
            left, top, right, bottom = places[name]
            assert left - 0.01 <= place[0] <= right + 0.01 and top - 0.01 <= place[1] <= bottom + 0.01
            assert min(abs(place[0] - left), abs(place[0] - right), abs(place[1] - top), abs(place[1] - bottom)) < 0.01
        for one, other in itertools.pairwise(path):
            for step in np.linspace(0.02, 0.98, 60):
                x, y = one + step * (other - one)
                assert not any(left + 0.1 < x < right - 0.1 and top + 0.1 < y < bottom - 0.1
                               for left, top, right, bottom in places.values())  # fmt: skip


def test_signs_stand_in_the_box_of_their_state_and_in_the_legend():
    figure = draw("states")
    letters = {}
    for name, box in boxes_of(figure).items():
        for one in within(figure, box):
            if one.get_label():
                assert one.get_label().split()[0] == name
                letters.setdefault(one.get_text(), set()).add(one.get_label().split()[2])
    assert all(len(meant) == 1 for meant in letters.values()) and len(letters) == 6
    legend = [one.get_text() for one in written(figure) if one.get_bbox_patch() and not one.get_label()]
    assert sorted(legend) == sorted(letters)
    assert "CONFIRM_MOUNTING: from WAIT_MOUNTING to NEXT, from FAULT to PREFLIGHT" in said(figure)
    assert {"another attempt", "nothing is left to", "measure"} <= {one.get_text() for one in written(figure)}


def test_nodes_and_identifiers_are_those_of_the_eds_files_and_the_page_of_the_bus():
    figure = draw("wiring")
    page = (ROOT / "docs/bus/README.md").read_text()
    boxes = boxes_of(figure)
    for number, name in ((1, "navcomp"), (2, "drive"), (3, "block")):
        text = " ".join(one.get_text() for one in within(figure, boxes[f"node {number}"]))
        shown = {int(one, 16) for one in re.findall(r"\b([0-9A-F]{3})h", text)}
        services = {0x080 + number, 0x580 + number, 0x600 + number, 0x700 + number}
        own = {1: {0x181, 0x681, 0x6C1}, 2: {0x182, 0x202}, 3: {0x683, 0x693}}[number]
        assert shown == services | own
        for one in own:
            assert f"`0x{one:03X}`" in page
        eds = (ROOT / f"docs/eds/tumble_{name}.eds").read_text()
        for one in own - {0x683, 0x693}:
            base = {0x182: 0x180, 0x202: 0x200, 0x181: 0x180, 0x681: 0x680}.get(one, one)
            given = re.findall(r"DefaultValue=\$NODEID\+(0x[0-9A-Fa-f]+)|DefaultValue=(0x[0-9A-Fa-f]+)", eds)
            assert base in {int(relative or fixed, 16) for relative, fixed in given}, hex(one)
    assert [one.get_text() for one in labelled(figure, "texts", "terminator")] == ["120 Ω"] * 2
    assert "500 kbit/s" in said(figure) and "500 kbit/s" in page and "60 Ω" in said(figure)
    assert "bits_per_second = 500000;" in (ROOT / "host/simulation/scenario.c").read_text()
    assert {"gateway", "host"} <= set(boxes)
