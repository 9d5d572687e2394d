"""Schedules that are valid and yet lead astray: look-alikes of the paper's positions, and weakly tilted axes."""

import json
from argparse import Namespace
from dataclasses import replace

import numpy as np
import pytest
from blocks import write_run
from conftest import EXAMPLES

from tumble.cli import options
from tumble.files.schedule_file import to_toml
from tumble.model import Geometry, built_in
from tumble.schedule import Mounting, Position, Schedule

K = np.array([[2.0, 0.03, -0.02], [-0.04, 1.9, 0.05], [0.01, -0.03, 2.1]])
U0 = np.array([0.1, -0.2, 0.05])


def toml(schedule):
    tables = [
        f"[[mounting]]\nnumber = {m.number}\nmatrix = {json.dumps(m.matrix)}\naxis_tilt_deg = {m.tilt_deg}\n"
        for m in schedule.mountings
    ]
    tables += [
        f"[[position]]\nmounting = {p.mounting}\nposition = {p.number}\nangle_deg = {p.angle_deg}\n"
        for p in schedule.positions
    ]
    return "\n".join(tables)


def solve(tumble, folder, schedule, outputs, estimator, told=""):
    (folder / "schedule.toml").write_text(toml(schedule))
    rows = [
        ",".join([str(p.mounting), str(p.number), *(repr(float(u)) for u in output)])
        for p, output in zip(schedule.positions, outputs)
    ]
    (folder / "run.csv").write_text("\n".join(["mounting,position,ux [V],uy [V],uz [V]", *rows]) + "\n")
    arguments = ["--schedule", "schedule.toml", "--estimator", estimator, "--json"]
    done = tumble("solve", "run.csv", *arguments, cwd=folder)
    assert done.stderr == told
    return json.loads(done.stdout)


@pytest.mark.parametrize("yaw", [90, 180, 270])
@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares"])
def test_a_look_alike_is_not_taken_for_a_position_of_the_paper(yaw, estimator, tumble, tmp_path):
    c, s = round(np.cos(np.deg2rad(yaw))), round(np.sin(np.deg2rad(yaw)))
    paper = built_in("paper")
    turned = Mounting(3, ((c, s, 0), (-s, c, 0), (0, 0, 1)))
    lookalikes = tuple(Position(3, turn, 45.0 * (turn - 1)) for turn in (1, 5, 9))
    schedule = Schedule((turned, *paper.mountings), (*lookalikes, *paper.positions))
    outputs = Geometry(schedule).outputs(K, U0, alpha1=2e-3)
    outputs[:3] += 1e-3  # so that it matters which ones are taken
    left_out = (
        f"tumble: warning: schedule.toml: {estimator} leaves out fit positions 3.1, 3.5, 3.9"
        " (mounting 3 lacks 45, 90, 135, 225, 270, 315 deg); least_squares takes all\n"
    )
    told = "" if estimator == "least_squares" else left_out
    result = solve(tumble, tmp_path, schedule, outputs, estimator, told)
    if estimator != "least_squares":
        plain = solve(tumble, tmp_path, paper, outputs[3:], estimator)
        assert result["K"] == plain["K"] and result["stand_seen"] == plain["stand_seen"]
    assert result["stand_seen"]["alpha1_rad"] == pytest.approx(2e-3, rel=1e-2)


@pytest.mark.parametrize("tilt_deg", [0.2, 0.5, 1.0, 5.0])
def test_a_weak_wedge_under_a_large_offset_is_no_disagreement(tilt_deg, tumble, tmp_path):
    level = built_in("paper").mountings[0]
    mountings = (level, replace(level, number=2, tilt_deg=tilt_deg))
    schedule = Schedule(mountings, tuple(Position(m, turn, 45.0 * (turn - 1)) for m in (1, 2) for turn in range(1, 10)))
    noise = np.random.default_rng(1).normal(0.0, 1e-5, (18, 3))
    outputs = Geometry(schedule).outputs(0.03 * K, U0 + 2.5) + noise
    result = solve(tumble, tmp_path, schedule, outputs, "least_squares")
    assert result["reference"]["max_abs_difference_K"] < 1e-11


def test_a_header_far_into_the_file(tumble, tmp_path):
    write_run(tmp_path / "run.csv", built_in("paper"), Geometry(built_in("paper")).outputs(K, U0))
    text = (tmp_path / "run.csv").read_text()
    (tmp_path / "run.csv").write_text("# a comment that goes on\n" * 6000 + text)
    done = tumble("solve", "run.csv", "--json", cwd=tmp_path)
    assert (done.returncode, json.loads(done.stdout)["counters"]["comment_lines"]) == (0, 6000)


def by_default(text, tmp_path):
    """The estimator of a schedule file where nobody says."""
    file = tmp_path / "own.toml"
    file.write_text(text)
    arguments = Namespace(estimator="by schedule", schedule=str(file))
    options.choose_estimator(arguments)
    return arguments.estimator


def test_the_estimator_goes_by_what_a_schedule_file_says_and_not_by_its_letters(tmp_path, refused):
    inclined, paper = (to_toml(built_in(name)) for name in ("inclined", "paper"))
    quoted = inclined.replace("bolting = ", '"bolting" = ')
    own = paper.replace("number = 1\n", "number = 1\nbolting = 1\n").replace(
        "number = 2\n", "number = 2\nbolting = 2\n"
    )
    assert own.count("bolting") == 2 and quoted != inclined
    for text, expected in ((inclined, "inclined"), (quoted, "inclined"), (paper, "refined"), (own, "refined")):
        assert by_default(text, tmp_path) == expected
    assert by_default(inclined.replace("bolting = 1", "bolting = true"), tmp_path) == "refined"
    message = refused("solve", EXAMPLES / "inclined_stand.csv", "--schedule", tmp_path / "own.toml")
    assert "own.toml: row 4: [[mounting]] bolting must be a whole number, not 'True'" in message
