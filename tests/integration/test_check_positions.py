"""Check positions: measured and judged, not fitted. They see what a fit on the 45 degree grid makes its own."""

import json
from pathlib import Path

import numpy as np
import pytest
from blocks import NOMINAL_K, write_run

from tumble import core, model
from tumble.estimators import LINEAR
from tumble.files.schedule_file import read_schedule

ROOT = Path(__file__).resolve().parents[2]
SCHEDULE = ROOT / "examples" / "with_checks.toml"
RIPPLE_V = 6e-4
U0 = np.array([0.02, -0.01, 0.03])


def ripple(force):
    """Nonlinearity of seventh order, T7(a) = cos(7 arccos a): at multiples of 45 degrees a change of scale, no more;
    half
    way between them, where cos 7 phi = -cos phi, the opposite change."""
    return RIPPLE_V * np.cos(7 * np.arccos(np.clip(force, -1.0, 1.0)))


@pytest.fixture
def schedule():
    return read_schedule(str(SCHEDULE)).data


def solve(tumble, run, *options):
    done = tumble("solve", run, "--json", *options)
    assert done.returncode in (0, 1), done.stderr
    return done.returncode, json.loads(done.stdout)


def test_the_check_positions_lie_off_the_grid_of_the_fit(schedule):
    checks = [position.angle_deg for position in schedule.positions if position.use == "check"]
    assert len(checks) == 8 and all(angle % 45 == 22.5 for angle in checks)


def test_a_ripple_passes_the_fit_but_not_the_check(schedule, tumble, tmp_path):
    geometry = model.Geometry(schedule)
    linear = geometry.outputs(NOMINAL_K, U0)
    runs = {
        "linear": write_run(tmp_path / "linear.csv", schedule, linear),
        "rippled": write_run(tmp_path / "rippled.csv", schedule, linear + ripple(geometry.force())),
    }
    code, found = solve(tumble, runs["linear"], "--schedule", SCHEDULE)
    assert code == 0 and found["verification"]["max_abs_delta_g_g"] < 1e-12

    code, found = solve(tumble, runs["rippled"], "--schedule", SCHEDULE)
    verification = found["verification"]
    assert code == 1 and verification["pass"] is False
    assert verification["max_abs_delta_g_fit_g"] < 0.1 * verification["limit_g"]
    assert verification["max_abs_delta_g_check_g"] == pytest.approx(2 * RIPPLE_V / 2.0, rel=0.1)
    assert verification["max_abs_delta_g_g"] == verification["max_abs_delta_g_check_g"]

    fit_only = [index for index, position in enumerate(schedule.positions) if position.use == "fit"]
    paper = core.paper_schedule()
    unchecked = write_run(tmp_path / "unchecked.csv", paper, (linear + ripple(geometry.force()))[fit_only])
    code, without = solve(tumble, unchecked)
    assert code == 0 and without["verification"]["pass"] is True
    assert without["verification"]["max_abs_delta_g_check_g"] is None
    assert (without["K"], without["U0"]) == (found["K"], found["U0"])


@pytest.mark.parametrize("estimator", LINEAR)
def test_check_positions_change_no_coefficient(estimator, schedule, tumble, tmp_path):
    """Not a bit of it, and nothing of the stand seen, however wrong they are."""
    outputs = model.Geometry(schedule).outputs(NOMINAL_K, U0, alpha1=1e-4, alpha3=[1e-3, -1e-3])
    outputs += np.random.default_rng(5).normal(size=outputs.shape) * 1e-4
    checks = [position.use == "check" for position in schedule.positions]
    wrong = outputs + np.outer(checks, [0.1, -0.2, 0.3])
    options = ("--schedule", SCHEDULE, "--estimator", estimator, "--stand", ROOT / "examples" / "lab_stand.toml")
    (_, right), (code, spoilt) = (
        solve(tumble, write_run(tmp_path / f"{name}.csv", schedule, rows), *options)
        for name, rows in (("right", outputs), ("spoilt", wrong))
    )
    for key in ("K", "U0", "u_K", "u_U0", "stand_seen"):
        assert spoilt[key] == right[key], key
    assert code == 1
    assert spoilt["verification"]["max_abs_delta_g_fit_g"] == right["verification"]["max_abs_delta_g_fit_g"]


def test_check_positions_on_the_bench(tumble, tmp_path):
    done = tumble("bench", "--seed", 3, "--schedule", SCHEDULE, "--out", tmp_path / "run", "--json")
    assert done.returncode == 0, done.stderr
    verification = json.loads(done.stdout)["verification"]
    uses = [place["use"] for place in verification["delta_g_g"]]
    assert (uses.count("fit"), uses.count("check")) == (18, 8)
    assert 0 < verification["max_abs_delta_g_check_g"] <= verification["max_abs_delta_g_g"] <= 3e-4
