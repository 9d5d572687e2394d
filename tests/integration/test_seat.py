"""Seats and platform: what a tilt of the block against the axis costs, and when nobody can know."""

import json

import numpy as np
import pytest
from blocks import NOMINAL_K, random_block, random_rotation, usable_schedule
from conftest import EXAMPLES

from tumble import core, reference
from tumble.core.uncertainty import uncertainties
from tumble.estimators import LINEAR
from tumble.reference.uncertainty import sources
from tumble.schedule import Mounting, Position, Schedule
from tumble.stand import Stand

PAPER = reference.paper_schedule()
H, N, V = (tuple(row) for row in np.eye(3).tolist())
THIRD = Mounting(3, (N, V, H))
THREE = Schedule(
    (*PAPER.mountings, THIRD), PAPER.positions + tuple(Position(3, turn, 45.0 * (turn - 1)) for turn in range(1, 10))
)
LONE_ROWS = np.ones(18, dtype=int)


def stand(axis_tilt, level, remount, angle, noise_of_mean, **seats):
    noise = noise_of_mean * 50**0.5
    return Stand(axis_tilt, level, remount, angle, noise, 50, "sigma1", **seats)


STANDS = {
    "paper": (2e-5, 2e-5, 4e-4, 4e-5, 3e-4 / 50**0.5),
    "angle": (2e-5, 2e-5, 4e-4, 2e-4, 3e-5),
    "lab": (2e-4, 5e-4, 2e-3, 2e-4, 1e-4),
}

# K_xx; K_yy, K_zz; K_xy, K_xz; K_yx, K_zx; K_yz, K_zy over the scale, ppm; worst u of the norm of a, ug
REFINED = {
    ("paper", 0.0): (11.8, 14.1, 27.4, 29.6, 9.9, 20.3),
    ("paper", 2e-5): (11.8, 14.1, 33.9, 35.7, 22.3, 24.6),
    ("paper", 1e-4): (11.8, 14.4, 103.7, 104.3, 100.5, 73.4),
    ("paper", 1e-3): (18.4, 31.6, 1000.6, 1000.4, 1000.2, 707),
    ("angle", 1e-4): (36.2, 50.6, 129.2, 134.2, 100.3, 84.4),
    ("lab", 1e-4): (48.6, 56.2, 516.5, 519.4, 103.2, 166),
}
SHOWN = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 0), (2, 0), (1, 2), (2, 1))
COLUMN = (0, 1, 1, 2, 2, 3, 3, 4, 4)


def worst_of_norm(k, covariance):
    """Largest standard uncertainty of |a| over attitudes a degree apart: d|a| = -a^T K^-1 (dK a + dU0)."""
    polar, around = np.meshgrid(np.radians(np.arange(181)), np.radians(np.arange(360)))
    sine = np.sin(polar)
    a = np.stack([sine * np.cos(around), sine * np.sin(around), np.cos(polar)], axis=-1).reshape(-1, 3)
    row = a @ np.linalg.inv(k)
    gains = np.concatenate([(row[:, :, None] * a[:, None]).reshape(-1, 9), row], axis=1)
    return float(np.sqrt(np.einsum("pi,ij,pj->p", gains, covariance, gains).max()))


def covariance_of(schedule, declared, estimator):
    """Of the twelve, K row by row, then U0."""
    rows = []
    for source in sources(schedule, NOMINAL_K, declared, np.ones(len(schedule.positions), dtype=int)).values():
        k, u0 = reference.estimate(schedule, source.derivative, estimator)
        rows.append(source.sigma[:, None] * np.concatenate([k.reshape(-1, 9), u0], axis=1))
    draws = np.concatenate(rows)
    return draws.T @ draws


@pytest.mark.parametrize(("name", "seat"), REFINED)
def test_what_a_seat_costs_the_paper_s_schedule(name, seat):
    declared, expected = stand(*STANDS[name], seat=seat), REFINED[name, seat]
    witness, _ = reference.standard_uncertainties(PAPER, NOMINAL_K, declared, LONE_ROWS, "refined")
    found, _ = uncertainties(core.CoreSchedule(PAPER), NOMINAL_K, declared, LONE_ROWS, "refined")
    for u in (witness, found):
        shown = [u[place] / 2.0 * 1e6 for place in SHOWN]
        assert shown == pytest.approx([expected[column] for column in COLUMN], rel=0.01)
    norm = worst_of_norm(NOMINAL_K, covariance_of(PAPER, declared, "refined"))
    assert norm * 1e6 == pytest.approx(expected[5], rel=0.01)


def test_core_and_numpy_agree_on_any_schedule():
    rng = np.random.default_rng(901)
    for _ in range(40):
        schedule = usable_schedule(rng)
        k, _ = random_block(rng)
        seats = dict(zip(("seat", "platform"), rng.uniform(0, 1e-3, 2)))
        declared = Stand(*rng.uniform(0, 1e-3, 5), 5, "sigma1", **seats)
        samples = rng.integers(1, 9, len(schedule.data.positions))
        witness = reference.standard_uncertainties(schedule.data, k, declared, samples, "least_squares")
        found = uncertainties(schedule, k, declared, samples, "least_squares")
        for mine, other in zip(found, witness):
            assert mine == pytest.approx(other, rel=1e-9)


def test_a_seat_turns_the_block_and_leaves_lengths():
    """By a rotation of its own about each axis of the table frame, one after the other."""
    rng = np.random.default_rng(902)
    lean, turn, yaw = rng.uniform(-0.5, 0.5, (3, 1))
    matrix = np.array(random_rotation(rng))
    schedule = Schedule((Mounting(1, tuple(map(tuple, matrix)), 20.0),), (Position(1, 1, 70.0),))
    angle, tilt = np.radians(70.0) + turn[0], np.radians(20.0)
    f = np.array([np.cos(tilt) * np.sin(angle), np.sin(tilt), np.cos(tilt) * np.cos(angle)])
    about_h = np.array([[1, 0, 0], [0, np.cos(lean[0]), np.sin(lean[0])], [0, -np.sin(lean[0]), np.cos(lean[0])]])
    about_v = np.array([[np.cos(yaw[0]), np.sin(yaw[0]), 0], [-np.sin(yaw[0]), np.cos(yaw[0]), 0], [0, 0, 1]])
    found = reference.Geometry(schedule).force(seat_h=lean, seat_n=turn, alpha3=yaw)[0]
    assert found == pytest.approx(matrix @ about_v @ about_h @ f, abs=1e-15)


@pytest.mark.parametrize("estimator", LINEAR)
def test_two_mountings_see_nothing_of_a_platform_off_square(estimator):
    """2 mrad move K_yz by as much of K_yy; check positions, residuals and the gravity check stay as they are."""
    k, u0 = NOMINAL_K, np.array([0.1, -0.2, 0.3])
    paper = core.CoreSchedule(PAPER)
    means = reference.Geometry(PAPER).outputs(k, u0, seat_h=2e-3)
    found_k, found_u0 = core.estimate(paper, means, None, estimator)
    moved = found_k - k
    assert moved[1, 2] == pytest.approx(2e-3 * k[1, 1], rel=1e-3)
    assert moved[2, 1] == pytest.approx(2e-3 * k[2, 2], rel=1e-3)
    assert found_u0 == pytest.approx(u0, abs=1e-12)
    assert reference.residual_rms(PAPER, means, found_k, found_u0) == pytest.approx(0.0, abs=1e-12)
    norms = np.linalg.norm(np.linalg.solve(found_k, k @ np.array([0, 1, 1]) / 2**0.5))
    assert abs(norms - 1.0) == pytest.approx(2e-3, rel=0.05)
    assert np.argwhere(reference.unseen_tilt(PAPER, found_k, estimator)).tolist() == [[1, 2], [2, 1]]


def test_a_third_mounting_shows_it():
    assert reference.unseen_tilt(THREE, NOMINAL_K, "least_squares") is None
    for tilt in (10.0, 45.0):
        mountings = tuple(Mounting(mounting.number, mounting.matrix, tilt) for mounting in PAPER.mountings)
        marked = reference.unseen_tilt(Schedule(mountings, PAPER.positions), NOMINAL_K, "least_squares")
        assert marked is not None and marked[1, 2] and marked[2, 1]


def with_keys(tmp_path, **keys):
    lines = (EXAMPLES / "paper_stand.toml").read_text().splitlines()
    place = lines.index("[stand]") + 1
    path = tmp_path / "stand.toml"
    path.write_text("\n".join([*lines[:place], *(f"{key} = {value}" for key, value in keys.items()), *lines[place:]]))
    return path


@pytest.mark.parametrize("key", ["seat_rad", "platform_rad"])
def test_who_declares_either_is_told_of_no_assumption(key, tmp_path, tumble):
    run = EXAMPLES / "paper_stand.csv"
    plain = tumble("solve", run, "--stand", EXAMPLES / "paper_stand.toml").stdout
    assert plain.splitlines()[-1].startswith("PASS, assuming a square seat: ")
    assert plain.count("*") == 3  # two coefficients, and what is said of them
    declared = with_keys(tmp_path, **{key: 1e-4})
    text = tumble("solve", run, "--stand", declared).stdout
    assert text.splitlines()[-1].startswith("PASS: ") and "*" not in text
    result = json.loads(tumble("solve", run, "--stand", declared, "--json").stdout)
    assert (result["assumes"], result["assumed_for"]) == ([], {})
    assert result["u_K"][1][2] == pytest.approx(1.005e-4 * 2, rel=0.01)


@pytest.mark.parametrize("key", ["seat_rad", "platform_rad"])
@pytest.mark.parametrize("value", ["-1e-4", "0.6", "true"])
def test_a_seat_that_is_none_is_refused(key, value, tmp_path, refused):
    message = refused("solve", EXAMPLES / "paper_stand.csv", "--stand", with_keys(tmp_path, **{key: value}))
    assert key in message
