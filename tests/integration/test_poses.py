"""The words and signs by which a person at a terminal seats the block, against poses worked out by hand and by brute
force."""

import io
import math
import os
import re
import sys
from dataclasses import replace

import numpy as np
import pytest
from drawn_schedules import SCHEDULES, rotations, turned_somehow

from tumble import poses
from tumble.model import Geometry
from tumble.model.geometry import built_in
from tumble.schedule import Mounting, Position, Schedule
from tumble.world.progress import Progress

pytestmark = pytest.mark.python

# Where the table's axes point after each quarter turn, by hand: h rises, v tips to the left, n stays.
QUARTERS = [
    {"h": "to the right", "n": "away from you", "v": "up"},
    {"h": "up", "n": "away from you", "v": "to the left"},
    {"h": "to the left", "n": "away from you", "v": "down"},
    {"h": "down", "n": "away from you", "v": "to the right"},
]
OPPOSITE = {"up": "down", "to the right": "to the left", "away from you": "towards you"}
OPPOSITE |= {other: one for one, other in OPPOSITE.items()}
VECTORS = {"up": (0, 0, 1), "down": (0, 0, -1), "to the right": (1, 0, 0), "to the left": (-1, 0, 0),
           "away from you": (0, 1, 0), "towards you": (0, -1, 0)}  # fmt: skip
SIDES = {"up": "up", "down": "down", "the right": "to the right", "the left": "to the left",
         "the back": "away from you", "the front": "towards you"}  # fmt: skip
LEVEL = Mounting(1, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))


def by_hand(matrix, quarter):
    """Where x, y, z of a right-angled mounting point."""
    pointing = []
    for row in matrix:
        axis = int(np.flatnonzero(row)[0])
        word = QUARTERS[quarter]["hnv"[axis]]
        pointing.append(word if row[axis] > 0.0 else OPPOSITE[word])
    return pointing


def face_of(pointing):
    """Which face has come up."""
    return f"face {'+' if 'up' in pointing else '-'}{'xyz'[pointing.index('up' if 'up' in pointing else 'down')]}"


@pytest.mark.parametrize("quarter", range(-5, 9))
@pytest.mark.parametrize("matrix", [*rotations()])
def test_right_angled_poses_have_exact_words(matrix, quarter):
    pointing = by_hand(matrix, quarter % 4)
    mounting = Mounting(1, matrix)
    assert poses.axes(mounting, 90.0 * quarter) == [f"{axis} {word}" for axis, word in zip("xyz", pointing)]
    if "up" in pointing or "down" in pointing:
        up = face_of(pointing)
        assert poses.face_up(mounting, 90.0 * quarter) == up
        told = ", ".join(f"{axis} {word}" for axis, word in zip("xyz", pointing))
        assert poses.line(mounting, 90.0 * quarter) == f"{told}; up: {up}"


def test_there_are_24_and_all_are_told_apart():
    assert len({poses.line(Mounting(1, matrix), 0.0) for matrix in rotations()}) == 24


def told_vector(text):
    """The direction that words mean, in (right, away, up)."""
    if text in VECTORS:
        return np.array(VECTORS[text], float)
    said = re.fullmatch(r"([\d.]+) deg from (up|down|the \w+) towards (up|down|the \w+)(?:, ([\d.]+) deg towards "
                        r"(up|down|the \w+))?", text)  # fmt: skip
    turned, lifted = math.radians(float(said[1])), math.radians(float(said[4] or 0.0))
    first, second = (np.array(VECTORS[SIDES[said[place]]], float) for place in (2, 3))
    third = np.array(VECTORS[SIDES[said[5]]], float) if said[5] else np.zeros(3)
    return math.cos(lifted) * (math.cos(turned) * first + math.sin(turned) * second) + math.sin(lifted) * third


def room_axes(mounting, angle_deg):
    """Rows x, y, z in (right, away, up), by turning the table step by step about its axis, and the axis about h."""
    turn, tilt = math.radians(angle_deg), math.radians(mounting.tilt_deg)
    about_axis = np.array([[math.cos(turn), 0, math.sin(turn)], [0, 1, 0], [-math.sin(turn), 0, math.cos(turn)]])
    about_right = np.array([[1, 0, 0], [0, math.cos(tilt), math.sin(tilt)], [0, -math.sin(tilt), math.cos(tilt)]])
    return np.array(mounting.matrix) @ about_axis @ about_right


def apart_deg(one, other):
    return math.degrees(2.0 * math.asin(min(1.0, np.linalg.norm(one - other) / 2.0)))


@pytest.mark.parametrize("seed", range(40))
def test_words_of_any_pose_lead_back_to_it(seed):
    random = np.random.default_rng(seed)
    mounting = Mounting(1, turned_somehow(seed), random.uniform(-80.0, 80.0))
    angle_deg = random.uniform(-3600.0, 3600.0)
    for axis, told in zip(room_axes(mounting, angle_deg), poses.axes(mounting, angle_deg)):
        assert apart_deg(axis, told_vector(told[2:])) < (1.0 if told[2:] in VECTORS else 0.1), told


@pytest.mark.parametrize(("angle_deg", "told"), [
    (0.9, "z up"), (-0.9, "z up"), (1.1, "z 1.1 deg from up towards the left"), (359.1, "z up"),
    (-1.1, "z 1.1 deg from up towards the right"), (45.0, "z 45 deg from up towards the left"),
    (22.5, "z 22.5 deg from up towards the left"), (67.5, "z 22.5 deg from the left towards up"),
    (225.0, "z 45 deg from down towards the right"), (90.99, "z to the left"),
])  # fmt: skip
def test_a_degree_makes_the_difference(angle_deg, told):
    assert poses.axes(LEVEL, angle_deg)[2] == told


@pytest.mark.parametrize(("angle_deg", "up"), [
    (0.0, "face +z"), (0.9, "face +z"), (10.0, "face +z, 10 deg off"), (45.0, "the edge of faces +x and +z"),
    (135.0, "the edge of faces +x and -z"), (270.0, "face -x"), (315.0, "the edge of faces -x and +z"),
])  # fmt: skip
def test_what_is_up(angle_deg, up):
    assert poses.face_up(LEVEL, angle_deg) == up


def test_a_corner_may_be_up():
    third, half, sixth = (math.sqrt(1.0 / n) for n in (3.0, 2.0, 6.0))
    standing = Mounting(1, ((half, sixth, third), (-half, sixth, third), (0.0, -2.0 * sixth, third)))
    assert poses.face_up(standing, 0.0) == "the corner of faces +x, +y and +z"


@pytest.mark.parametrize("name", SCHEDULES)
def test_what_is_up_feels_most_by_the_reference(name):
    schedule = SCHEDULES[name]
    for position, force in zip(schedule.positions, Geometry(schedule).force()):
        mounting = next(one for one in schedule.mountings if one.number == position.mounting)
        told = poses.face_up(mounting, position.angle_deg)
        faces = re.findall(r"([+-])([xyz])", told)
        normal = np.zeros(3)
        for sign, axis in faces:
            normal["xyz".index(axis)] = 1.0 if sign == "+" else -1.0
        off = re.search(r"([\d.]+) deg off", told)
        away = apart_deg(normal / math.sqrt(len(faces)), force)
        assert abs(away - float(off[1])) < 0.06 if off else away <= 1.0
        assert np.abs(force).argmax() in ["xyz".index(axis) for _, axis in faces]


@pytest.mark.parametrize(("tilt_deg", "raised", "away"), [(10.0, "far", 1), (-10.0, "near", -1)])
def test_the_end_of_a_tilted_axis_that_is_raised(tilt_deg, raised, away):
    """By the reference: y lies along the axis, leading away; it feels more than 0 where the far end is up."""
    tilted = Mounting(1, LEVEL.matrix, tilt_deg)
    assert poses.tilt(tilted) == f"axis tilted by 10 deg, its {raised} end raised" and poses.tilt(LEVEL) == ""
    assert np.sign(Geometry(Schedule((tilted,), (Position(1, 1, 30.0),))).force()[0][1]) == away


# Signs.


def places(lines):
    """Of each letter in the drawing: columns to the right of the o and rows above it."""
    drawn = [line[:29].ljust(29) for line in lines]
    ((row, column),) = [(r, c) for r, line in enumerate(drawn) for c, sign in enumerate(line) if sign == "o"]
    return {sign: (c - column, row - r) for r, line in enumerate(drawn) for c, sign in enumerate(line) if sign in "xyz"}


@pytest.mark.parametrize("quarter", range(4))
@pytest.mark.parametrize("matrix", [*rotations()])
def test_the_drawing_of_a_right_angled_pose(matrix, quarter):
    pointing = dict(zip("xyz", by_hand(matrix, quarter)))
    lines = poses.sketch(Mounting(1, matrix), 90.0 * quarter)
    drawn = places(lines)
    for axis, word in pointing.items():
        right, _, up = VECTORS[word]
        assert (right, up) == ((0, 0) if axis not in drawn else tuple(np.sign(drawn[axis])))
        if axis not in drawn:
            assert f"o: {axis} points {word}" in "\n".join(lines)
    assert len(drawn) == 2


@pytest.mark.parametrize("name", SCHEDULES)
def test_drawings_fit_a_terminal_and_lie_along_their_axes(name):
    schedule = SCHEDULES[name]
    for position in schedule.positions:
        mounting = next(one for one in schedule.mountings if one.number == position.mounting)
        lines = poses.sketch(mounting, position.angle_deg)
        assert max(map(len, lines)) <= 80 and "\n".join(lines).isascii() and len(lines) <= 12
        for axis, (right, up) in places(lines).items():
            row = room_axes(mounting, position.angle_deg)["xyz".index(axis)]
            drawn = math.degrees(math.atan2(2.0 * up if right else up, right))  # a row is as high as two columns
            real = math.degrees(math.atan2(row[2], row[0]))
            assert abs((drawn - real + 180.0) % 360.0 - 180.0) <= 40.0


def asked(schedule, monkeypatch, capsys, measured=None, **event):
    """What a person is asked, after the mounting `measured`."""
    monkeypatch.setattr(sys, "stdin", io.StringIO("\n"))
    progress = Progress(schedule, True)
    if measured is not None:
        place = {"mounting": measured, "finished": 0, "count": 9, "virtual_s": 1.0}
        assert progress({"event": "state", "state": "TUMBLE_STATE_AVERAGE", **place}) is None
        capsys.readouterr()
    assert progress({"event": "question", **event}) == "done"
    return capsys.readouterr().err.splitlines()


def test_the_prompt_for_a_mounting_draws_it_and_lists_its_positions(monkeypatch, capsys):
    paper = SCHEDULES["paper"]
    said = asked(paper, monkeypatch, capsys, kind="mounting", mounting=2)
    assert said[0].startswith("Mount the block as mounting 2 says: x along -h")
    drawing = poses.sketch(paper.mountings[1], 0.0)
    assert "\n".join(drawing) in "\n".join(said) and max(map(len, said)) <= 80
    assert "y up" in drawing[1] and said[-1] == "[Enter or done: it is done; leave: do nothing; abort: stop here]"
    listed = [line for line in said if line.startswith("  position ")]
    assert len(listed) == 9 and listed[1] == "  position 2,  45 deg, up: the edge of faces -x and +y"


INCLINED = [  # mounting that was measured before, the one that is asked for, what is said
    (None, 1, "Mount the block as mounting 1 says: x along +h (horizontal, across the axis); y along +n (along the "
              "axis); z along +v (up at table angle 0). Incline the stand to about 0 deg, lock it, and confirm."),
    (1, 2, "The block stays bolted on as it is. Incline the stand to about +45 deg, the far end of its axis up, lock "
           "it, and confirm."),
    (2, 3, "The block stays bolted on as it is. Incline the stand to about -45 deg, the near end of its axis up, lock "
           "it, and confirm."),
    (3, 4, "The block stays bolted on as it is. Incline the stand to about 0 deg, lock it, and confirm."),
    (2, 2, "The block stays bolted on as it is. Incline the stand to about +45 deg"),  # to be repeated
]  # fmt: skip


@pytest.mark.parametrize(("before", "asked_for", "says"), INCLINED)
def test_a_block_that_is_bolted_on_stays_while_the_stand_is_inclined(monkeypatch, capsys, before, asked_for, says):
    schedule = built_in("inclined_closed")
    said = asked(schedule, monkeypatch, capsys, before, kind="mounting", mounting=asked_for)
    assert " ".join(" ".join(said).split()).startswith(says)
    assert "\n".join(poses.sketch(schedule.mountings[asked_for - 1], 0.0)) in "\n".join(said)
    assert max(map(len, said)) <= 80


def test_a_block_that_is_bolted_on_a_steep_stand_is_mounted_and_then_inclined(monkeypatch, capsys):
    """Mounting 2 first, or after a mounting of another bolting: both are asked for."""
    inclined = built_in("inclined")
    others = replace(inclined, mountings=(*inclined.mountings[:2], replace(inclined.mountings[2], bolting=None)))
    for schedule, before in ((inclined, None), (others, 3)):
        said = " ".join(" ".join(asked(schedule, monkeypatch, capsys, before, kind="mounting", mounting=2)).split())
        assert said.startswith("Mount the block as mounting 2 says: x along +h")
        assert "Incline the stand to about +45 deg" in said and "stays" not in said
    said = " ".join(asked(others, monkeypatch, capsys, 2, kind="mounting", mounting=3))
    assert said.startswith("Mount the block as mounting 3 says") and "Incline" not in said  # its tilt is known


@pytest.mark.skipif(not hasattr(os, "openpty"), reason="no terminals here")
def test_what_was_typed_before_a_question_answers_nothing(monkeypatch, capsys):
    """Somebody may be at the stand when the next question comes, and has not read it."""
    here, there = os.openpty()

    class Typing(Progress):
        def say(self, line):
            super().say(line)
            if line.startswith("["):
                os.write(here, b" Repeat  mounting 2\n")

    with os.fdopen(there, encoding="ascii") as terminal:
        monkeypatch.setattr(sys, "stdin", terminal)
        os.write(here, b"\n\ndone\n")
        question = {"event": "question", "kind": "mounting", "mounting": 2}
        assert Typing(SCHEDULES["paper"], True)(question) == "repeat mounting 2"
    os.close(here)


def test_the_prompt_for_an_angle_draws_the_block_there(monkeypatch, capsys):
    paper = SCHEDULES["paper"]
    said = asked(paper, monkeypatch, capsys, kind="angle", mounting=1, angle_deg=90.0)
    assert said[:2] == ["Turn the table to 90 degrees.",
                        "At table angle 90 deg, seen from the front (positive: counterclockwise):"]  # fmt: skip
    assert said[2:-1] == poses.sketch(paper.mountings[0], 90.0)
    before = asked(paper, monkeypatch, capsys, kind="angle", mounting=0, angle_deg=0.0)  # homing, nothing mounted yet
    assert len(before) == 2


def test_a_fault_is_asked_as_it_was(monkeypatch, capsys):
    said = asked(SCHEDULES["paper"], monkeypatch, capsys, kind="fault", mounting=1, sentence="it went wrong")
    assert said[0] == "Fault: it went wrong." and said[1].startswith("[Enter or done: mended") and len(said) == 3


@pytest.mark.parametrize("name", SCHEDULES)
def test_every_prompt_fits_eighty_columns(name, monkeypatch, capsys):
    schedule = Schedule(SCHEDULES[name].mountings, (*SCHEDULES[name].positions, Position(1, 255, -3599.975)))
    for mounting in schedule.mountings:
        said = asked(schedule, monkeypatch, capsys, kind="mounting", mounting=mounting.number)
        said += asked(schedule, monkeypatch, capsys, kind="angle", mounting=mounting.number, angle_deg=-3599.975)
        assert max(map(len, said)) <= 80
