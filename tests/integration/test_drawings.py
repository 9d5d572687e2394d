"""`tumble draw` and the drawings of a terminal: what is drawn is what the matrices, the angles and the tables say.

The projection, the words and the way of a pose are worked out here once more, by other means.
"""

import functools
import itertools
import math
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import ROOT
from drawn_schedules import SCHEDULES, rotations

from tumble import drawings
from tumble.errors import UsageError
from tumble.model import Geometry
from tumble.schedule import Mounting, Position, Schedule

pytestmark = pytest.mark.python

NAME = "{http://www.w3.org/2000/svg}"
FRONT_CORNER = np.array([0.6, -0.4])  # where a unit away from the eye goes in the oblique view; page y is down
PAGES = [("states",), ("wiring",)]
PAGES += [(subject, name) for subject in ("stand", "mountings") for name in SCHEDULES]
PAGES += [("angles", name, SCHEDULES[name].mountings[index].number) for name in SCHEDULES for index in (0, -1)]


def name_of(page):
    return "-".join(map(str, page))


def draw(subject, name=None, *rest):
    return getattr(drawings, subject)(*([] if name is None else [SCHEDULES[name]]), *rest)


def read(text):
    return ElementTree.fromstring(text)


def found(page, tag, **data):
    """The elements with these data."""
    keys = {f"data-{key}": str(value) for key, value in data.items()}
    return [one for one in page.iter(NAME + tag) if all(one.get(key) == value for key, value in keys.items())]


def points(element):
    return np.array([[float(one) for one in pair.split(",")] for pair in element.get("points").split()])


def tip(group):
    """Of the arrow in a group."""
    return points(next(group.iter(NAME + "polygon")))[0]


def text_of(element):
    return " ".join(element.itertext()).strip()


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_a_page_is_well_formed_white_narrow_and_says_what_it_shows(page):
    text = draw(*page)
    assert text == draw(*page)
    root = read(text)
    width, height = (root.get(key).removesuffix("mm") for key in ("width", "height"))
    assert float(width) <= 170.0 and root.get("viewBox") == f"0 0 {width} {height}"
    title, about, paper = list(root)[:3]
    assert (title.tag, about.tag) == (NAME + "title", NAME + "desc") and len(about.text) > 80 and title.text
    assert dict(paper.attrib) == {"width": width, "height": height, "fill": "#ffffff"}
    assert not re.search(r"nan|inf|-0[ ,\"]|\bid=|<image|<style|href", text)
    assert root.get("role") == "img"


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_no_text_is_smaller_than_eight_points_and_nothing_leaves_the_page(page):
    root = read(draw(*page))
    sizes = [float(one.get("font-size")) for one in root.iter() if one.get("font-size")]
    assert min(sizes) * 72.0 / 25.4 >= 8.0
    height = float(root.get("height").removesuffix("mm"))
    for one in root.iter():
        if one.get("points"):
            assert (points(one) >= -0.01).all() and (points(one) <= [170.01, height + 0.01]).all(), one.attrib


def luminance(colour):
    channels = [int(colour[place : place + 2], 16) / 255.0 for place in (1, 3, 5)]
    linear = [one / 12.92 if one <= 0.04045 else ((one + 0.055) / 1.055) ** 2.4 for one in channels]
    return float(np.dot(linear, (0.2126, 0.7152, 0.0722)))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_text_stands_out_in_grey(page):
    """At 4.5 : 1 at least, on white and on what is grey; and white letters on the dark circle that they stand in."""
    root = read(draw(*page))
    for one in root.iter(NAME + "text"):
        ink = luminance(one.get("fill", root.get("fill")))
        if one.get("fill") != "#ffffff":
            assert (luminance("#eef1f4") + 0.05) / (ink + 0.05) >= 4.5
    for group in root.iter(NAME + "g"):
        if any(one.get("fill") == "#ffffff" for one in group.findall(NAME + "text")):
            assert 1.05 / (luminance(group.find(NAME + "circle").get("fill")) + 0.05) >= 4.5


@functools.cache
def font_named(name):
    """The one that the drawings ask for first, as matplotlib brings it; 72 pixels an em."""
    data = pytest.importorskip("matplotlib").get_data_path()
    font = pytest.importorskip("matplotlib.ft2font").FT2Font(f"{data}/fonts/ttf/{name}.ttf")
    font.set_size(72.0, 72)
    return font


def boxes(root):
    """(left, top, right, bottom, text) of every text."""
    for one in root.iter(NAME + "text"):
        font = font_named("DejaVuSans-Bold" if one.get("font-weight") == "bold" else "DejaVuSans")
        font.set_text(one.text, 0.0)
        size = float(one.get("font-size", root.get("font-size")))
        width = font.get_width_height()[0] / 64.0 / 72.0 * size
        left = float(one.get("x")) - {"start": 0.0, "middle": 0.5, "end": 1.0}[one.get("text-anchor", "start")] * width
        base = float(one.get("y"))
        yield left, base - 0.72 * size, left + width, base, one.text


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_no_text_runs_into_another_or_off_the_page(page):
    placed = sorted(boxes(read(draw(*page))))
    for index, one in enumerate(placed):
        assert one[0] >= 0.0 and one[2] <= 170.0, one
        for other in placed[index + 1 :]:
            if other[0] >= one[2] - 0.05:
                break
            assert not (one[1] < other[3] - 0.05 and other[1] < one[3] - 0.05), (one, other)


# Mountings.


@pytest.mark.parametrize("name", SCHEDULES)
def test_the_axes_of_every_mounting_end_where_the_matrix_has_them(name):
    root = read(draw("mountings", name))
    cells = [one for one in root.iter(NAME + "g") if one.get("data-mounting")]
    assert [int(one.get("data-mounting")) for one in cells] == [one.number for one in SCHEDULES[name].mountings]
    for cell, mounting in zip(cells, SCHEDULES[name].mountings):
        origin = np.array([float(one) for one in cell.get("data-origin").split()])
        drawn = []
        for axis, row in zip("xyz", mounting.matrix):
            group = found(cell, "g", axis=axis)[0]
            h, n, v = row
            expected = origin + float(cell.get("data-scale")) * 1.5 * (np.array([h, -v]) + n * FRONT_CORNER)
            arrows = found(group, "g", tip=axis)
            if arrows:
                assert np.abs(tip(arrows[0]) - expected).max() < 2e-3
                label = next(group.iter(NAME + "text"))
                beyond = np.array([float(label.get("x")), float(label.get("y")) - 0.36 * 3.6]) - origin
                assert label.text == axis
                assert beyond @ (expected - origin) > 0.99 * np.hypot(*beyond) * np.hypot(*(expected - origin))
                drawn.append(axis)
            else:
                assert np.hypot(*(expected - origin)) < 1.51
        assert len(drawn) >= 2  # of three at right angles no two point at the eye


def towards_the_eye(row):
    """Above 0: the axis comes out of a face that is seen. The line of sight, in h, n, v, holds all places that fall
    onto one point of the page."""
    sight = np.array([FRONT_CORNER[0], -1.0, -FRONT_CORNER[1]])
    assert np.abs(np.array([sight[0], -sight[2]]) + sight[1] * FRONT_CORNER).max() < 1e-12
    return float(np.dot(row, sight))


@pytest.mark.parametrize("name", SCHEDULES)
def test_an_axis_out_of_a_hidden_face_is_dashed_within_the_block_and_the_others_are_not(name):
    root = read(draw("mountings", name))
    for mounting in SCHEDULES[name].mountings:
        cell = found(root, "g", mounting=mounting.number)[0]
        for axis, row in zip("xyz", mounting.matrix):
            group = found(cell, "g", axis=axis)[0]
            dashed = [one for one in group.iter(NAME + "polyline") if one.get("stroke-dasharray")]
            if abs(towards_the_eye(row)) > 1e-6 and found(group, "g", tip=axis):
                assert len(dashed) == (towards_the_eye(row) < 0.0)


@pytest.mark.parametrize("matrix", [*rotations()])
def test_all_right_angled_mountings_are_drawn_proper(matrix):
    """Of the three drawn axes the third is where the first two, right-handed, put it."""
    schedule = Schedule((Mounting(1, matrix),), (Position(1, 1, 0.0),))
    cell = found(read(drawings.mountings(schedule)), "g", mounting=1)[0]
    origin = np.array([float(one) for one in cell.get("data-origin").split()])
    page = {"h": np.array([1.0, 0.0]), "n": FRONT_CORNER, "v": np.array([0.0, -1.0])}
    seen = {}
    for axis in "xyz":
        way = (tip(found(cell, "g", tip=axis)[0]) - origin) / 1.5 / float(cell.get("data-scale"))
        for frame, onto in page.items():
            for sign in (1, -1):
                if np.abs(way - sign * onto).max() < 1e-3:
                    seen[axis] = sign * np.eye(3)["hnv".index(frame)]
    assert np.array_equal(np.cross(seen["x"], seen["y"]), seen["z"])


# Angles.


@pytest.mark.parametrize(("name", "number"), [page[1:] for page in PAGES if page[0] == "angles"])
def test_gravity_is_where_the_reference_has_it(name, number):
    schedule = SCHEDULES[name]
    felt = Geometry(schedule).force()
    matrix = np.array(next(one.matrix for one in schedule.mountings if one.number == number))
    root = read(draw("angles", name, number))
    rows = 0
    for position, force in zip(schedule.positions, felt):
        if position.mounting != number:
            continue
        arrow = points(next(found(root, "g", gravity=position.number)[0].iter(NAME + "polygon")))[0] - [124.0, 51.0]
        in_table = -force @ matrix  # along h, n, v; the block is drawn as it sits at angle 0
        assert np.abs(arrow - 23.0 * np.array([in_table[0], -in_table[2]])).max() < 2e-3
        row = [text_of(one) for one in found(root, "g", position=position.number)[0].iter(NAME + "text")]
        assert row[:2] == [str(position.number), f"{position.angle_deg:g}°"]
        assert row[2] == {"fit": "fit", "check": "check only"}[position.use]
        assert np.abs(np.array([float(one) for one in row[3:6]]) + force).max() < 6e-4
        rows += 1
    assert rows == len([one for one in root.iter(NAME + "g") if one.get("data-position")]) > 0


@pytest.mark.parametrize(("name", "number"), [page[1:] for page in PAGES if page[0] == "angles"])
def test_the_marks_stand_at_the_angles_counterclockwise_from_the_top(name, number):
    root = read(draw("angles", name, number))
    for position in SCHEDULES[name].positions:
        if position.mounting == number:
            end = points(found(root, "polyline", position=position.number)[0])[-1] - [46.0, 51.0]
            angle = math.degrees(math.atan2(-end[0], -end[1])) % 360.0  # from up towards the left
            assert abs((angle - position.angle_deg + 180.0) % 360.0 - 180.0) < 0.01
            assert abs(np.hypot(*end) - 23.0) < 2e-3


def test_the_marks_of_the_paper_have_their_numbers():
    root = read(drawings.angles(SCHEDULES["paper"], 1))
    labels = [(one.get("data-angle"), one.text) for one in root.iter(NAME + "text") if one.get("data-angle")]
    numbers = ["1, 9", "2", "3", "4", "5", "6", "7", "8"]
    angles = [f"{angle:g}" for angle in range(0, 360, 45)]
    assert labels[:8] == list(zip(angles, numbers))
    # Gravity turns the other way, from the bottom: at 90 degrees h is up, so gravity is where -h is, on the left.
    assert {text: angle for angle, text in labels[8:]}["3"] == "90" and labels[8:][4] == ("180", "1, 9")


def test_a_mounting_that_is_not_there_is_named():
    with pytest.raises(UsageError, match="no mounting 3 in this schedule, which has 1, 2"):
        drawings.angles(SCHEDULES["paper"], 3)


@pytest.mark.parametrize("name", SCHEDULES)
def test_the_stand_has_a_mark_at_each_angle_and_its_sense_raises_h(name):
    root = read(draw("stand", name))
    marks = {float(one.get("data-mark")) for one in root.iter(NAME + "polyline") if one.get("data-mark")}
    wanted = {round(one.angle_deg % 360.0, 6) % 360.0 for one in SCHEDULES[name].positions}
    assert sorted(marks) == pytest.approx(sorted(wanted), abs=1e-3)
    for mark in root.iter(NAME + "polyline"):
        if mark.get("data-mark"):
            outer = points(mark)[-1] - [126.0, 51.0]
            angle = math.degrees(math.atan2(-outer[0], -outer[1])) % 360.0
            assert abs((angle - float(mark.get("data-mark")) + 180.0) % 360.0 - 180.0) < 0.01
    h, v = (tip(found(root, "g", tip=axis)[-1]) - [126.0, 51.0] for axis in "hv")
    assert h[0] > 1.0 and abs(h[1]) < 1e-6 and v[1] < -1.0 and abs(v[0]) < 1e-6
    for group in found(root, "g", sense="positive"):
        path = points(next(group.iter(NAME + "polyline")))
        assert path[-1][0] < path[0][0] and path[-1][1] > path[0][1]  # from the top to the left, as h turns upwards
    assert len(found(root, "g", gravity="down")) == 2
    for group in found(root, "g", gravity="down"):
        begin, end = points(next(group.iter(NAME + "polyline")))
        assert begin[0] == end[0] and end[1] > begin[1]


# The run and the bus.


def ways_of_the_table():
    """(from, to, by) by a plain look at the rows and the commands, another than the generator's."""
    folder = ROOT / "firmware/procedure"
    table = (folder / "procedure_table.c").read_text().split("tumble_procedure_rows[")[1]
    names = {"IN_MOTION": "COMMAND_ABORT", "AT_REST": "COMMAND_ABORT | COMMAND_REPEAT"}
    for name, meant in names.items():
        assert re.search(rf"#define {name} \(?{re.escape(meant)}\)?\n", (folder / "procedure_table.c").read_text())
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


def test_every_state_and_every_way_of_the_table_is_drawn():
    root = read(drawings.states())
    header = (ROOT / "firmware/procedure/states.h").read_text()
    listed = re.findall(r'X\(TUMBLE_STATE_(\w+), "([^"]*)"\)', header)
    shown = {one.get("data-state"): text_of(one) for one in root.iter(NAME + "g") if one.get("data-state")}
    assert {name: re.sub(r"\s+", " ", text) for name, text in shown.items()} == {
        name: f"{name} {sentence}" for name, sentence in listed
    }
    keys = ("data-begin", "data-end", "data-by")
    drawn = {tuple(one.get(key) for key in keys) for one in root.iter(NAME + "g") if one.get("data-begin")}
    assert drawn == set(ways_of_the_table()) and len(drawn) > 45


def corners(root):
    """Of the box of each state: left, top, right, bottom."""
    for group in root.iter(NAME + "g"):
        if group.get("data-state"):
            box = next(group.iter(NAME + "rect"))
            x, y, width, height = (float(box.get(key)) for key in ("x", "y", "width", "height"))
            yield group.get("data-state"), (x, y, x + width, y + height)


def test_arrows_of_the_run_begin_and_end_at_their_states_and_cross_no_other():
    root = read(drawings.states())
    places = dict(corners(root))
    for group in root.iter(NAME + "g"):
        line = next(group.iter(NAME + "polyline"), None)
        if group.get("data-begin") is None or line is None:
            continue
        path = [*points(line)[:-1], tip(group)]
        for name, place in ((group.get("data-begin"), path[0]), (group.get("data-end"), path[-1])):
            left, top, right, bottom = places[name]
            assert left - 0.01 <= place[0] <= right + 0.01 and top - 0.01 <= place[1] <= bottom + 0.01
            assert min(abs(place[0] - left), abs(place[0] - right), abs(place[1] - top), abs(place[1] - bottom)) < 0.01
        for one, other in itertools.pairwise(path):
            for step in np.linspace(0.02, 0.98, 60):
                x, y = one + step * (other - one)
                assert not any(left + 0.1 < x < right - 0.1 and top + 0.1 < y < bottom - 0.1
                               for left, top, right, bottom in places.values())  # fmt: skip


def test_signs_stand_in_the_box_of_their_state_and_in_the_legend():
    root = read(drawings.states())
    places = dict(corners(root))
    letters = {}
    for group in root.iter(NAME + "g"):
        circle = next(group.iter(NAME + "circle"), None)
        if circle is not None and group.get("data-begin"):
            left, top, right, bottom = places[group.get("data-begin")]
            assert left < float(circle.get("cx")) < right and top < float(circle.get("cy")) < bottom
            letters.setdefault(text_of(group), set()).add(group.get("data-by"))
    assert all(len(meant) == 1 for meant in letters.values()) and len(letters) == 6
    said = " ".join(text_of(one) for one in root.iter(NAME + "text"))
    assert "CONFIRM_MOUNTING: from WAIT_MOUNTING to NEXT, from FAULT to PREFLIGHT" in said


def test_nodes_and_identifiers_are_those_of_the_eds_files_and_the_page_of_the_bus():
    root = read(drawings.wiring())
    page = (ROOT / "docs/bus/README.md").read_text()
    for number, name in ((1, "navcomp"), (2, "drive"), (3, "block")):
        group = found(root, "g", node=number)[0]
        shown = {int(one, 16) for one in re.findall(r"\b([0-9A-F]{3})h", text_of(group))}
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
    said = " ".join(text_of(one) for one in root.iter(NAME + "text"))
    assert [one.text for one in root.iter(NAME + "text") if one.get("data-terminator") == "120"] == ["120 Ω"] * 2
    assert "500 kbit/s" in said and "500 kbit/s" in page and "60 Ω" in said
    assert "bits_per_second = 500000;" in (ROOT / "host/simulation/scenario.c").read_text()
    assert {one.get("data-guest") for one in root.iter(NAME + "g")} >= {"gateway", "host"}
