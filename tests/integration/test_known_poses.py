"""Known poses: 24 free attitudes, each a mounting with one position, as published sets have them."""

import json
from fractions import Fraction

import numpy as np
import pytest
from blocks import NOMINAL_K, random_block, write_run

from tumble import core, model
from tumble.schedule import Mounting, Position, Schedule

POSES = 24
U0 = np.array([0.05, -0.03, 0.02])
SIGMAS = {"axis_tilt_rad": 2e-5, "level_rad": 3e-5, "remount_rad": 4e-4, "angle_rad": 4e-5, "noise_v": 3e-4}
SEAT, SAMPLES = 5e-5, 50
STAND = "".join(f"{name} = {value}\n" for name, value in {**SIGMAS, "seat_rad": SEAT, "samples": SAMPLES}.items())
TOO_MANY = "has 24 mountings, optimal takes 6; least_squares solves any schedule\n"


def rotation(w, x, y, z):
    """Of a quaternion of whole numbers: a rotation in fractions."""
    n = Fraction(w * w + x * x + y * y + z * z)
    rows = [
        [n - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), n - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), n - 2 * (x * x + y * y)],
    ]
    return [[element / n for element in row] for row in rows]


def poses(count=POSES):
    """Exact rotations that turn gravity into so many directions of the block."""
    rng, found = np.random.default_rng(81), {}
    while len(found) < count:
        matrix = rotation(*(int(part) for part in rng.integers(1, 9, 4) * rng.choice([-1, 1], 4)))
        found.setdefault(tuple(row[2] for row in matrix), matrix)
    return list(found.values())


def schedule_of(matrices):
    """Of each pose a mounting with one position at angle 0."""
    floats = [tuple(tuple(map(float, row)) for row in matrix) for matrix in matrices]
    mountings = tuple(Mounting(number, matrix) for number, matrix in enumerate(floats, 1))
    return Schedule(mountings, tuple(Position(one.number, 1, 0.0) for one in mountings))


def schedule_text(matrices, decimals=17):
    """A schedule file of these poses."""
    text = ""
    for number, matrix in enumerate(matrices, 1):
        rows = [[float(f"{float(element):.{decimals}f}") for element in row] for row in matrix]
        text += f"[[mounting]]\nnumber = {number}\nmatrix = {rows}\n"
        text += f"[[position]]\nmounting = {number}\nposition = 1\nangle_deg = 0.0\n"
    return text


def gravity(matrices):
    """Specific force in each pose (poses, 3), in fractions: what was the table's v, on the block's axes."""
    return [[row[2] for row in matrix] for matrix in matrices]


def exact_least_squares(force, outputs):
    """K (3, 3) and U0 (3,) by normal equations in fractions, with no rounding at all."""
    rows = [[*one, Fraction(1)] for one in force]
    normal = [[sum(row[i] * row[j] for row in rows) for j in range(4)] for i in range(4)]
    right = [[sum(row[i] * Fraction(u[c]) for row, u in zip(rows, outputs.tolist())) for c in range(3)]
             for i in range(4)]  # fmt: skip
    for i in range(4):
        pivot = normal[i][i]  # of a positive definite matrix, so never 0
        for other in range(4):
            factor = normal[other][i] / pivot if other != i else 0
            normal[other] = [a - factor * b for a, b in zip(normal[other], normal[i])]
            right[other] = [a - factor * b for a, b in zip(right[other], right[i])]
    found = np.array([[float(right[i][c] / normal[i][i]) for i in range(4)] for c in range(3)])
    return found[:, :3], found[:, 3]


@pytest.mark.parametrize("count", [6, POSES, core.MAX_POSITIONS])
def test_any_outputs_are_solved_as_in_exact_arithmetic(count):
    rng, matrices = np.random.default_rng(82), poses(count)
    schedule = schedule_of(matrices)
    for _ in range(5):
        outputs = rng.uniform(-4, 4, (count, 3))
        expected_k, expected_u0 = exact_least_squares(gravity(matrices), outputs)
        for k, u0 in (core.estimate(core.CoreSchedule(schedule), outputs, estimator="least_squares"),
                      model.estimate(schedule, outputs, "least_squares")):  # fmt: skip
            np.testing.assert_allclose(k, expected_k, rtol=0, atol=1e-13)
            np.testing.assert_allclose(u0, expected_u0, rtol=0, atol=1e-13)


def outputs_of(matrices, k, u0, errors=None):
    """Outputs on an ideal stand (poses, 3); or with gravity seen along h and n by small `errors` (poses, 2)."""
    table = np.zeros((len(matrices), 3))
    table[:, :2] = 0.0 if errors is None else errors
    table[:, 2] = np.sqrt(1.0 - (table[:, :2] ** 2).sum(axis=1))
    return np.einsum("ij,pjt,pt->pi", k, np.array(matrices, dtype=float), table) + u0


def solved(tumble, tmp_path, text, means, *options):
    (tmp_path / "poses.toml").write_text(text)
    run = write_run(tmp_path / "run.csv", schedule_of(poses()), means)
    taken = "--schedule", tmp_path / "poses.toml", "--estimator", "least_squares"
    done = tumble("solve", run, *taken, "--json", *options)
    return done, json.loads(done.stdout) if done.stdout else None


def test_a_published_set_of_poses_is_solved(tumble, tmp_path):
    k, u0 = random_block(np.random.default_rng(83))
    done, result = solved(tumble, tmp_path, schedule_text(poses()), outputs_of(poses(), k, u0))
    assert (done.returncode, done.stderr) == (0, "")
    assert np.array(result["K"]) == pytest.approx(k, abs=1e-13 * np.abs(k).max())
    assert np.array(result["U0"]) == pytest.approx(u0, abs=1e-13 * np.abs(k).max())
    assert result["stand_seen"]["alpha1_rad"] is None and result["stand_seen"]["augmented"] is None


def test_one_notice_tells_of_all_matrices_typed_to_five_decimals(tumble, tmp_path):
    means = outputs_of(poses(), NOMINAL_K, U0)
    done, result = solved(tumble, tmp_path, schedule_text(poses(), decimals=5), means)
    assert done.returncode == 0 and done.stderr.count("\n") == 1
    assert ": matrices of 24 mountings made orthonormal, by " in done.stderr
    assert np.array(result["K"]) == pytest.approx(NOMINAL_K, abs=1e-5)


def covariance_of_outputs(matrices, k):
    """Of all outputs (3 poses, 3 poses): to first order alpha1 and theta_h turn gravity towards n, alpha2, theta_n and
    the error of the set angle towards h, and a yaw turns nothing, as gravity lies along v."""
    towards = np.einsum("ij,pjt->pit", k, np.array(matrices, dtype=float)[:, :, :2])
    h, n = towards[:, :, 0], towards[:, :, 1]
    total = SIGMAS["noise_v"] ** 2 / SAMPLES * np.eye(3 * len(matrices))
    for shared, direction in ((SIGMAS["level_rad"], h), (SIGMAS["axis_tilt_rad"], n)):
        total += shared**2 * np.outer(direction, direction)
    for each, direction in ((np.hypot(SIGMAS["angle_rad"], SEAT), h), (SEAT, n)):
        for pose, vector in enumerate(direction):
            block = slice(3 * pose, 3 * pose + 3)
            total[block, block] += each**2 * np.outer(vector, vector)
    return total


def test_uncertainties_and_fit_are_those_of_the_whole_covariance(tumble, tmp_path):
    """Against dense matrices: least squares propagated, and generalised least squares for chi-squared."""
    rng, matrices = np.random.default_rng(84), poses()
    covariance = covariance_of_outputs(matrices, NOMINAL_K)
    along_h = rng.normal(0, SIGMAS["level_rad"]) + rng.normal(0, np.hypot(SIGMAS["angle_rad"], SEAT), POSES)
    along_n = rng.normal(0, SIGMAS["axis_tilt_rad"]) + rng.normal(0, SEAT, POSES)
    means = outputs_of(matrices, NOMINAL_K, U0, np.column_stack([along_h, along_n]))
    means += rng.normal(0, SIGMAS["noise_v"] / np.sqrt(SAMPLES), means.shape)
    (tmp_path / "stand.toml").write_text('[stand]\nlimits = "sigma1"\n' + STAND)
    done, result = solved(tumble, tmp_path, schedule_text(matrices), means, "--stand", tmp_path / "stand.toml")
    assert (done.returncode, done.stderr) == (0, "")

    force = np.column_stack([np.array(gravity(matrices), dtype=float), np.ones(POSES)])
    design = np.kron(force, np.eye(3))  # unknowns: K_xx, K_yx, K_zx, K_xy, ...
    gains = np.linalg.pinv(design)
    u = np.sqrt(np.diag(gains @ covariance @ gains.T)).reshape(4, 3)
    assert np.array(result["u_K"]) == pytest.approx(u[:3].T, rel=1e-3)  # at the solved K, not at the true one
    assert np.array(result["u_U0"]) == pytest.approx(u[3], rel=1e-3)

    half = np.linalg.inv(np.linalg.cholesky(covariance))
    rest = half @ means.ravel()
    rest -= half @ design @ np.linalg.lstsq(half @ design, rest, rcond=None)[0]
    assert result["fit"]["dof"] == 3 * POSES - 12
    assert result["fit"]["chi2"] == pytest.approx(rest @ rest, rel=1e-3)
    assert result["fit"]["fits"] and 30 < rest @ rest < 95


def test_a_wrong_pose_does_not_fit(tumble, tmp_path):
    means = outputs_of(poses(), NOMINAL_K, U0)
    means[7] += 2e-3 * NOMINAL_K[0]
    (tmp_path / "stand.toml").write_text('[stand]\nlimits = "sigma1"\n' + STAND)
    done, result = solved(tumble, tmp_path, schedule_text(poses()), means, "--stand", tmp_path / "stand.toml")
    assert done.returncode == 1 and not result["fit"]["fits"]
    assert result["fit"]["explanations"][0]["patterns"][0] == "position"


def test_optimal_refuses_and_says_what_to_take_instead(refused, tmp_path):
    (tmp_path / "poses.toml").write_text(schedule_text(poses()))
    (tmp_path / "stand.toml").write_text('[stand]\nlimits = "sigma1"\n' + STAND)
    run = write_run(tmp_path / "run.csv", schedule_of(poses()), outputs_of(poses(), NOMINAL_K, U0))
    options = "--schedule", tmp_path / "poses.toml", "--stand", tmp_path / "stand.toml"
    assert refused("solve", run, *options, "--estimator", "optimal").endswith(TOO_MANY)
    assert refused("plan", "budget", "--schedule", options[1], "--estimator", "optimal").endswith(TOO_MANY)
    line = refused("fixture", "check", run, *options, "--estimator", "least_squares")
    assert line.endswith("24 mountings: a run shows the stand in 6 at most\n")


def test_a_mounting_more_than_positions_is_refused(refused, tmp_path):
    text = schedule_text(poses(core.MAX_MOUNTINGS)) + schedule_text(poses(1)).replace("= 1\n", "= 99\n")
    (tmp_path / "poses.toml").write_text(text)
    (tmp_path / "run.csv").write_text("mounting,position,ux,uy,uz\n")
    line = refused("solve", tmp_path / "run.csv", "--schedule", tmp_path / "poses.toml", "--estimator", "least_squares")
    assert line.endswith("[[mounting]] is refused: the schedule has no positions, or more than fit\n")


def test_the_bench_walks_through_all_poses(tumble, tmp_path):
    (tmp_path / "poses.toml").write_text(schedule_text(poses()))
    options = "--schedule", tmp_path / "poses.toml", "--estimator", "least_squares"
    done = tumble("bench", *options, "--seed", "1", "--json", "--out", tmp_path / "run")
    result = json.loads(done.stdout)
    assert done.returncode == 0 and result["verification"]["pass"]
    assert len(result["truth"]["alpha3_rad"]) == POSES
    errors = np.abs(np.array(result["K"]) - result["truth"]["K"]) / result["u_K"]
    assert errors.max() < 4.0
