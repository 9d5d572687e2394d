"""Faces laid by hand as people come with them: a schedule by its name, no stand file, no estimator."""

import json
import shlex

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble as package
from tumble.core import CoreSchedule
from tumble.files.schedule_file import default_estimator, read_schedule
from tumble.model import Geometry, built_in
from tumble.schedule import BUILT_IN, Mounting, Position, Schedule
from tumble.solving.hands import HANDS, LIMIT_G

pytestmark = pytest.mark.python

RECORDING = (EXAMPLES / "hand_held_session.csv", "--unit", "m/s^2", "--rate", "102.4")
LAID = built_in("hand_laid")
UP = Geometry(LAID).force()


def rows(means, samples, noise, rng, unit=""):
    """A run of every face `samples` times, for the package."""
    outputs = np.repeat(means, samples, axis=0)
    outputs = outputs + noise * rng.standard_normal(outputs.shape)
    columns = {f"u{axis}{unit}": outputs[:, i] for i, axis in enumerate("xyz")}
    return {"mounting": np.repeat(np.arange(1, 7), samples), "position": np.ones(len(outputs), dtype=int), **columns}


def test_the_built_in_faces_are_those_of_the_example():
    assert read_schedule(str(EXAMPLES / "hand_laid_faces.toml")).data == LAID and LAID.is_laid_by_hand
    assert (UP == [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]).all()


def test_what_import_prints_as_next_passes(tumble, tmp_path):
    """The whole way of a sensor without a stand; the numbers are those of the example's stand file."""
    run = tmp_path / "run.csv"
    done = tumble("import", *RECORDING, "--schedule", "hand_laid", "--signs=+++", "--repeats", "first", "--out", run)
    advised = shlex.split(done.stdout.partition("\nNext:\n")[2].replace("\\\n", ""))
    assert advised == ["tumble", "solve", str(run), "--schedule", "hand_laid", "--out", str(tmp_path / "result.json")]
    done = tumble(*advised[1:], "--json")
    assert (done.returncode, done.stderr) == (0, "")
    result = json.loads(done.stdout)
    files = ("--schedule", EXAMPLES / "hand_laid_faces.toml", "--stand", EXAMPLES / "hand_laid.toml")
    files += ("--estimator", "optimal")
    by_file = json.loads(tumble("solve", run, *files, "--json").stdout)
    assert np.abs(np.subtract(result["K"], by_file["K"]) / by_file["u_K"]).max() < 0.05  # their noise differs a bit
    assert result["estimator"] == by_file["estimator"] == "optimal"
    assert result["pass"] and result["decision"]["limit_g"] == by_file["decision"]["limit_g"] == LIMIT_G
    assert result["u_norm_g"]["worst_g"] == pytest.approx(by_file["u_norm_g"]["worst_g"], rel=1e-2)
    assert "hands" in result["assumes"] and "hands" not in by_file["assumes"]
    # of the run: the noise that its samples show, and 1 mg of drift in each channel's own scale
    stand, scale = result["stand"], np.linalg.norm(result["K"], axis=1)
    assert stand["seat_rad"] == HANDS.seat and stand["drift_v"] == pytest.approx(HANDS.drift * scale, rel=1e-4)
    assert stand["noise_v"] == pytest.approx([0.0149, 0.0136, 0.0183], abs=1e-4)


@pytest.mark.parametrize(("unit", "scale"), [(" [V]", -2.0), (" [m/s^2]", 9.81), (" [mV]", 300.0), (" [g]", 1.0)])
def test_the_stand_is_that_of_any_sensor(unit, scale):
    """In whatever unit and scale: the same uncertainties, over 1 g, and the same limit."""
    run = rows(scale * UP + 0.01 * scale, 200, 2e-3 * abs(scale), np.random.default_rng(7), unit)
    result = package.solve(run, schedule="hand_laid")
    assert result.passed and not any("noise_v" in one for one in result.warnings)
    assert result.u_K / abs(scale) == pytest.approx(package.solve(run, schedule=LAID).u_K / abs(scale))
    worst = result.document["u_norm_g"]["worst_g"]
    assert worst == pytest.approx(1.77e-3, rel=0.01)
    means = package.solve(rows(scale * UP, 1, 0.0, np.random.default_rng(7), unit), schedule="hand_laid")
    assert means.document["u_norm_g"]["worst_g"] == pytest.approx(worst, rel=0.02) and means.passed


def test_a_face_that_slipped_does_not_pass():
    outputs = UP.copy()
    outputs[2] = [0.0, np.cos(0.2), np.sin(0.2)]  # 0.2 rad off
    result = package.solve(rows(outputs, 200, 2e-3, np.random.default_rng(8), " [g]"), schedule="hand_laid")
    assert not result.passed and "fit" in result.document["pass_reason"]


def test_whoever_declares_a_stand_or_a_limit_is_heard(tumble, tmp_path):
    run = rows(UP, 200, 2e-3, np.random.default_rng(9), " [g]")
    exact = package.Stand(axis_tilt=0, level=0, remount=0, angle=0, noise=2e-3, samples=200, limits="sigma1", seat=1e-3)
    declared = package.solve(run, schedule="hand_laid", stand=exact)
    assert declared.document["stand"]["seat_rad"] == 1e-3 and "hands" not in declared.assumes
    assert declared.document["decision"]["limit_g"] == 3e-4
    assert package.solve(run, schedule="hand_laid", limit_g=2e-3).document["pass_reason"] == "uncertainty"
    optimal = package.solve(run, schedule="hand_laid", estimator="optimal")  # by the stand that the schedule brings
    assert optimal.passed and optimal.estimator == "optimal"


def test_a_drift_follows_the_order_in_which_the_faces_were_laid():
    """As the rows come, whatever the numbers are: the same run, with its positions numbered in the order of its rows,
    has the same uncertainties; and faces that follow one another share their drift."""
    order, rng = [4, 5, 0, 1, 2, 3], np.random.default_rng(8)
    run = rows(9.81 * UP, 100, 0.02, rng, " [m/s^2]")
    mounting = np.repeat(order, 100)
    kept = np.concatenate([np.arange(100 * face, 100 * face + 100) for face in order])
    laid = {name: values[kept] for name, values in run.items()}
    found = package.solve(laid, schedule="hand_laid")
    u = dict(zip("xyz", found.u_U0))
    first = dict(zip("xyz", package.solve(run, schedule="hand_laid").u_U0))
    assert laid["mounting"].tolist() == (mounting + 1).tolist()
    # the axis whose faces lie in the middle of the run feels the least of a drift
    assert min(first, key=first.get) == "y" and min(u, key=u.get) == "x"
    assert u["x"] == pytest.approx(first["y"], rel=0.05) and u["y"] == pytest.approx(first["z"], rel=0.05)


def test_means_of_which_nobody_knows_the_noise_say_what_is_assumed():
    means = package.solve(rows(UP, 1, 0.0, np.random.default_rng(7), " [g]"), schedule="hand_laid")
    assert "means" in means.assumes and "0.2 mg of noise in each mean" in means.summary()
    samples = package.solve(rows(UP, 50, 2e-3, np.random.default_rng(7), " [g]"), schedule="hand_laid")
    assert "means" not in samples.assumes


def test_faces_in_any_order_are_the_first_remedy(tumble, tmp_path):
    """Not an exchange of wires that would fit as well."""
    rng = np.random.default_rng(3)
    order = [4, 5, 0, 1, 2, 3]
    parts = [9.81 * UP[face] + 0.02 * rng.standard_normal((300, 3)) for face in order]
    moved = [5.0 * rng.standard_normal((60, 3)) for _ in order]
    all_rows = np.concatenate([one for pair in zip(parts, moved) for one in pair])
    lines = [f"{i / 100:.2f},{x:.4f},{y:.4f},{z:.4f}" for i, (x, y, z) in enumerate(all_rows)]
    (tmp_path / "log.csv").write_text("\n".join(["time [s],ux,uy,uz", *lines]) + "\n")
    options = ("--schedule", "hand_laid", "--unit", "m/s^2", "--out", tmp_path / "run.csv")
    done = tumble("import", tmp_path / "log.csv", *options)
    remedy = done.stderr.partition("remedy")[2]
    assert done.returncode == 2 and "--order any" in remedy and "--columns" not in remedy


def test_three_faces_are_refused():
    run = {name: one[:600] for name, one in rows(UP, 200, 2e-3, np.random.default_rng(9), " [g]").items()}
    with pytest.raises(package.BadInput, match="these positions cannot identify K_x"):
        package.solve(run, schedule="hand_laid")


def test_the_schedule_chooses_the_estimator():
    inclined = {"inclined", "inclined_closed"}
    for name in BUILT_IN:
        wanted = "least_squares" if name in ("six_faces", "hand_laid") else "refined"
        wanted = "inclined" if name in inclined else wanted
        assert default_estimator(CoreSchedule.built_in(name)) == wanted
    poses = Schedule((Mounting(1, built_in("paper").mountings[0].matrix), *built_in("paper").mountings[1:]),
                     tuple(Position(m, i, 40.0 * i) for m in (1, 2) for i in range(1, 8)))  # fmt: skip
    assert default_estimator(CoreSchedule(poses)) == "least_squares"
    world = package.World(1, schedule="six_faces", samples=10).run()
    assert world.result.estimator == "least_squares"
