"""Fit positions that averaged and refined take nothing from are named, with the reason."""

import json
from dataclasses import replace

import numpy as np
import pytest
from blocks import NOMINAL_K, write_run

from tumble import core
from tumble.files.schedule_file import to_toml
from tumble.model import Geometry
from tumble.schedule import CHECK, Position, Schedule

pytestmark = pytest.mark.python

DIAGONAL = core.built_in("diagonal")
TWO = core.built_in("paper")


def with_third(change):
    """`diagonal`, with a change of the positions of its third mounting."""
    third = [change(one) if one.mounting == 3 else one for one in DIAGONAL.positions]
    return Schedule(DIAGONAL.mountings, tuple(one for one in third if one is not None))


def with_angle(number, angle_deg):
    return with_third(lambda one: replace(one, angle_deg=angle_deg) if one.number == number else one)


TILTED = Schedule((*DIAGONAL.mountings[:2], replace(DIAGONAL.mountings[2], tilt_deg=10.0)), DIAGONAL.positions)
SCHEDULES = {  # a schedule; what is said of it
    "a diagonal missing": (
        with_third(lambda one: None if one.number == 4 else one),
        "positions 3.1, 3.2, 3.3 (mounting 3 lacks 315 deg)",
    ),
    "one to check only": (
        with_third(lambda one: replace(one, use=CHECK) if one.number == 2 else one),
        "positions 3.1, 3.3, 3.4 (mounting 3 lacks 135 deg)",
    ),
    "an angle that is 5 deg off": (
        with_angle(2, 140.0),
        "positions 3.1, 3.2, 3.3, 3.4 (mounting 3 lacks 0, 90, 135, 180, 270, 360 deg)",
    ),
    "a position more": (
        Schedule(TWO.mountings, (*TWO.positions, Position(2, 10, 22.5))),
        "position 2.10 (mounting 2 has its circle without)",
    ),
    "tilted": (TILTED, "positions 3.1, 3.2, 3.3, 3.4 (no block axis of mounting 3 lies along the level axis)"),
}


@pytest.mark.parametrize("estimator", ["averaged", "refined"])
@pytest.mark.parametrize("name", SCHEDULES)
def test_it_is_named_and_has_no_part_in_the_result(name, estimator, tumble, tmp_path):
    schedule, said = SCHEDULES[name]
    file, rng = tmp_path / "schedule.toml", np.random.default_rng(1)
    file.write_text(to_toml(schedule))
    means = Geometry(schedule).outputs(NOMINAL_K, [0.1, 0.2, 0.3]) + 1e-5 * rng.normal(
        size=(len(schedule.positions), 3)
    )
    command = ("solve", write_run(tmp_path / "run.csv", schedule, means), "--schedule", file, "--json")
    done = tumble(*command, "--estimator", estimator)
    line = f"tumble: warning: {file}: {estimator} leaves out fit {said}; least_squares takes all\n"
    assert done.returncode == 0 and line in done.stderr
    labels = said.partition(" ")[2].partition(" (")[0].split(", ")
    moved = means + [[0.1] if position.label in labels else [0.0] for position in schedule.positions]
    write_run(tmp_path / "run.csv", schedule, moved)
    again = tumble(*command, "--estimator", estimator)
    assert json.loads(again.stdout)["K"] == json.loads(done.stdout)["K"]
    assert "leaves out" not in tumble(*command, "--estimator", "least_squares").stderr


def test_a_plan_names_it_too(tumble, tmp_path):
    file = tmp_path / "schedule.toml"
    file.write_text(to_toml(SCHEDULES["a diagonal missing"][0]))
    done = tumble("plan", "budget", "--schedule", file)
    said = "positions 3.1, 3.2, 3.3 (mounting 3 lacks 315 deg)"
    assert done.returncode == 0
    assert done.stderr == f"tumble: warning: {file}: refined leaves out fit {said}; least_squares takes all\n"


@pytest.mark.parametrize("name", ["paper", "three_mountings", "diagonal", "diagonal_closed"])
def test_built_in_schedules_leave_out_nothing(name, tumble, tmp_path):
    file = tmp_path / "schedule.toml"
    file.write_text(to_toml(core.built_in(name)))
    assert tumble("plan", "budget", "--schedule", file).stderr == ""
