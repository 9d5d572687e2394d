"""Estimator `norm`, schedule `any_pose`: still poses that nobody knows, by the length of gravity alone."""

import json
import shlex

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT

import tumble as package
from tumble.errors import BadInput, UsageError
from tumble.estimators import COEFFICIENTS
from tumble.model import norm
from tumble.model.norm import NINE

pytestmark = pytest.mark.python

RUNS = 5000
EQUAL = np.ones(3)
SIGMA = 5e-4  # of a mean, V
K = np.array([[2.02, 0.05, -0.03], [-0.04, 1.97, 0.02], [0.03, -0.06, 2.01]])
U0 = np.array([0.11, -0.04, 0.07])
LOWER = np.linalg.cholesky(K @ K.T)  # the same block in a frame of its own: the rotation that |a| does not feel
TWELVE = np.concatenate([LOWER.ravel(), U0])
STAND = package.Stand(axis_tilt=0, level=0, remount=0, angle=0, noise=SIGMA, samples=1, limits="sigma1")


def around(count):
    """So many directions all round (count, 3)."""
    z, turn = 1.0 - (2.0 * np.arange(count) + 1.0) / count, np.pi * (1.0 + 5.0**0.5) * np.arange(count)
    return np.column_stack([np.cos(turn) * (1 - z**2) ** 0.5, np.sin(turn) * (1 - z**2) ** 0.5, z])


def run_of(means, unit=" [V]"):
    columns = {f"u{axis}{unit}": means[:, i] for i, axis in enumerate("xyz")}
    return {"mounting": np.arange(1, len(means) + 1), "position": np.ones(len(means), dtype=int), **columns}


POSES = around(14)
MEANS = POSES @ K.T + U0


def noisy(rng, *shape):
    return MEANS + SIGMA * rng.standard_normal((*shape, *MEANS.shape))


def test_exact_means_give_the_block_to_rounding():
    k, u0, n = norm.solve(MEANS, EQUAL)
    assert np.abs(k - LOWER).max() < 1e-14 and np.abs(u0 - U0).max() < 1e-14
    assert np.abs(n @ k.T + u0 - MEANS).max() < 1e-14 and (k[np.triu_indices(3, 1)] == 0.0).all()
    k, _, _ = norm.solve(MEANS * [-1, 1, -1], np.array([-1.0, 1.0, -1.0]))
    assert (np.sign(np.diag(k)) == [-1, 1, -1]).all()


@pytest.mark.parametrize("weights", [EQUAL, np.array([1.0, 3.0, 0.2])])
def test_brute_force_finds_the_same(weights):
    """By scipy, on K^-1 upper triangular with angles for every pose: another parametrisation of the same sum."""
    optimize = pytest.importorskip("scipy.optimize", reason="scipy is not installed")
    means = noisy(np.random.default_rng(5))

    def left(x):
        inverse, angles = np.zeros((3, 3)), x[9:].reshape(2, -1)
        inverse[np.tril_indices(3)] = x[:6]
        up, turn = angles
        n = np.column_stack([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)])
        return (weights * (means - x[6:9] - n @ np.linalg.inv(inverse).T)).ravel() / SIGMA

    angles = np.arcsin(POSES[:, 2]), np.arctan2(POSES[:, 1], POSES[:, 0])
    start = np.concatenate([0.5 * np.eye(3)[np.tril_indices(3)], np.zeros(3), *angles])
    brute = optimize.least_squares(left, start, xtol=1e-15, ftol=1e-15, gtol=1e-12)
    inverse = np.zeros((3, 3))
    inverse[np.tril_indices(3)] = brute.x[:6]
    k, u0, _ = norm.solve(means, weights)
    assert np.abs(k - np.linalg.inv(inverse)).max() < 1e-3 * SIGMA and np.abs(u0 - brute.x[6:9]).max() < 1e-3 * SIGMA
    if weights is EQUAL:
        result = package.solve(run_of(means), estimator="norm", stand=STAND)
        assert result.document["fit"]["chi2"] == pytest.approx(2.0 * brute.cost, rel=1e-6)
        assert result.document["fit"]["dof"] == len(POSES) - 9
        assert np.abs(result.K - k).max() < 1e-12


def test_two_standard_uncertainties_cover_95_percent():
    """Of 5,000 runs; and the statistic of the fit is chi-squared with n - 9 degrees of freedom."""
    rng = np.random.default_rng(11)
    means = noisy(rng, RUNS)
    k, u0, n = norm.solve(means, EQUAL)
    result = package.solve(run_of(MEANS), estimator="norm", stand=STAND)
    u = np.concatenate([result.u_K.ravel(), result.u_U0])
    errors = np.concatenate([k.reshape(RUNS, 9), u0], axis=1) - TWELVE
    found = [COEFFICIENTS.index(name) for name in NINE]
    within = (np.abs(errors) <= 2.0 * u).mean(axis=0)[found]
    assert ((within >= 0.94) & (within <= 0.97)).all(), within
    left = means - u0[:, None] - n @ np.swapaxes(k, 1, 2)
    chi2 = (left**2).sum(axis=(1, 2)) / SIGMA**2
    assert chi2.mean() == pytest.approx(len(POSES) - 9, abs=4 * (10 / RUNS) ** 0.5)
    assert chi2.var() == pytest.approx(2 * (len(POSES) - 9), rel=0.1)
    # lengths do not depend on the frame: u(|a|) at the attitude where it is worst
    one = result.document["u_norm_g"]
    attitude = np.array(one["attitude"])
    outputs = LOWER @ attitude + U0
    lengths = np.linalg.norm(np.linalg.solve(k, (outputs - u0)[:, :, None])[..., 0], axis=1)
    assert lengths.std() == pytest.approx(one["worst_g"], rel=0.04)


def test_gains_are_the_derivatives():
    result = package.solve(run_of(MEANS), estimator="norm", stand=STAND)
    seen = norm.as_seen(norm.of_poses([(i, 1) for i in range(1, 15)]), norm.solve(MEANS, EQUAL)[2])
    gains, step = norm.gains(seen, LOWER, EQUAL), 1e-6
    for column in (0, 17, 41):
        moved = MEANS.copy().ravel()
        moved[column] += step
        k, u0, _ = norm.solve(moved.reshape(MEANS.shape), EQUAL)
        assert np.abs((np.concatenate([k.ravel(), u0]) - TWELVE) / step - gains[:, column]).max() < 1e-4
    assert np.sqrt((gains**2).sum(axis=1)) * SIGMA == pytest.approx([*result.u_K.ravel(), *result.u_U0])


def test_what_a_frame_does_not_change_is_that_of_known_directions(tumble):
    """The 27 positions of three mountings, with their directions and without: scales, biases and angles of the block
    agree within their uncertainties, and the result says which rotation nobody knows."""
    files = EXAMPLES / "three_mountings_stand.csv", "--stand", EXAMPLES / "paper_stand.toml"
    norm_of, known = (json.loads(tumble("solve", *files, *more, "--json").stdout)
                      for more in (("--estimator", "norm"), ("--schedule", "three_mountings")))  # fmt: skip
    for name in ("scale", "bias_g"):
        apart = np.subtract(norm_of["intrinsic"][name], known["intrinsic"][name])
        assert (np.abs(apart) < 4 * np.array(norm_of["u_intrinsic"][name])).all()
    assert norm_of["K"][0][1:] == [0.0, 0.0] and norm_of["K"][1][2] == 0.0
    assert "frame" in norm_of["assumes"] and "seat" not in norm_of["assumes"] and norm_of["pass"]
    assert norm_of["fit"]["dof"] == 27 - 9 and norm_of["schedule"]["name"] is None


def test_without_a_stand_the_noise_is_the_runs_own(tumble, tmp_path):
    """The whole way: solve by the schedule's name, apply, export and report take the result."""
    rng, run, out = np.random.default_rng(12), tmp_path / "run.csv", tmp_path / "result.json"
    rows = np.repeat(9.81 * MEANS / 2, 100, axis=0) + 0.02 * rng.standard_normal((1400, 3))
    lines = [f"1,{place // 100 + 1},{x:.6f},{y:.6f},{z:.6f}" for place, (x, y, z) in enumerate(rows)]
    run.write_text("\n".join(["mounting,position,ux [m/s^2],uy [m/s^2],uz [m/s^2]", *lines]) + "\n")
    done = tumble("solve", run, "--schedule", "any_pose", "--out", out)
    assert done.returncode == 0 and done.stdout.startswith("PASS, assuming a frame of the block's own")
    result = package.load(out)
    assert result.estimator == "norm" and result.document["stand"]["seat_rad"] == 0.0
    assert result.document["stand"]["noise_v"] == pytest.approx([0.02] * 3, rel=0.1)
    assert (np.abs(result.K - 9.81 / 2 * LOWER) < 4 * result.u_K + 1e-12).all()
    lengths = np.linalg.norm(result.apply(rows.reshape(14, 100, 3).mean(axis=1)), axis=1)
    assert np.abs(lengths - 1.0).max() < 1e-3
    for words in (("apply", out, run, "--out", tmp_path / "a.csv"), ("export", out, "--format", "c"),
                  ("report", out, "--run", run, "--out", tmp_path / "a.html"), ("compare", out, out)):  # fmt: skip
        assert tumble(*words).returncode == 0, words
    assert "frame of the block" in (tmp_path / "a.html").read_text()


FACES = np.array([sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)])
CIRCLE = np.array([[np.sin(t), 0.0, np.cos(t)] for t in np.arange(12) * np.pi / 6])
REFUSED = {
    "fewer than nine": (around(8), r"8 poses are fewer than nine coefficients: they do not show K_"),
    "faces alone": (np.concatenate([FACES, FACES]), r"do not show .*K_yx.*; lay the block otherwise too"),
    "one plane": (CIRCLE, r"these poses do not show .*K_yy.*U0_y"),
    "one hemisphere": (around(24)[:12], r"all poses lie in one hemisphere, none has -z up: they hardly show "
                       r"K_zz with U0_z \(u \d.*e?-?\d* g\); turn the block over, too"),
    "far too many": (around(37), "37 poses, at most 36 are solved"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_poses_that_do_not_show_all_nine(case):
    poses, said = REFUSED[case]
    with pytest.raises(BadInput, match=said):
        package.solve(run_of(poses @ K.T + U0), estimator="norm", stand=STAND)


def test_nearly_alike_poses_tell_what_they_would_leave():
    """Faces laid twice, a few mrad otherwise: numbers come out, of which the refusal says how little they are worth."""
    rng = np.random.default_rng(13)
    poses = np.concatenate([FACES, FACES]) + 3e-3 * rng.standard_normal((12, 3))
    poses /= np.linalg.norm(poses, axis=1, keepdims=True)
    with pytest.raises(BadInput, match=r"do not show K_.* \(u 0\.\d+ g\)"):
        package.solve(run_of(poses @ K.T + U0), estimator="norm", stand=STAND)


def test_a_block_that_bends_does_not_fit():
    bent = MEANS + 2e-2 * (POSES**2 - 0.3)
    result = package.solve(run_of(bent), estimator="norm", stand=STAND)
    assert not result.passed and "fit" in result.document["pass_reason"]


def test_it_needs_no_direction_and_takes_none():
    run = run_of(MEANS)
    with pytest.raises(UsageError, match="knows no directions"):
        package.solve(run, schedule="paper", estimator="norm")
    with pytest.raises(UsageError, match="tells no directions, which refined needs"):
        package.solve(run, schedule="any_pose", estimator="refined")
    with pytest.raises(UsageError, match="norm finds nine coefficients of poses that nobody knows"):
        package.solve(run, schedule="any_pose", model="k2")
    with pytest.raises(BadInput, match="no positions but those of a run"):
        package.World(1, schedule="any_pose")


def recording_of(tmp_path, poses):
    """A logger's, of a block that rests 3 s in each pose and is moved about for 0.6 s between two."""
    rng = np.random.default_rng(14)
    parts = [9.81 / 2 * (n @ K.T + U0) + sigma * rng.standard_normal((rows, 3))
             for n in poses for rows, sigma in ((300, 0.02), (60, 4.0))]  # fmt: skip
    lines = [f"{row / 100:.2f},{x:.5f},{y:.5f},{z:.5f}" for row, (x, y, z) in enumerate(np.concatenate(parts))]
    log = tmp_path / "log.csv"
    log.write_text("\n".join(["time [s],ux [m/s^2],uy [m/s^2],uz [m/s^2]", *lines]) + "\n")
    return log


def test_a_recording_of_poses_leads_to_a_verdict(tumble, tmp_path):
    """Nobody says how the block lay: what import prints as Next solves it."""
    run = tmp_path / "run.csv"
    done = tumble("import", recording_of(tmp_path, POSES), "--schedule", "any_pose", "--leave-out", "3", "--out", run)
    assert done.returncode == 0 and "at 13 of 13 positions of any_pose" in done.stdout, done.stderr
    command = shlex.split(done.stdout.partition("\nNext:\n")[2].replace("\\\n", ""))
    assert command[1:5] == ["solve", str(run), "--schedule", "any_pose"]
    solved = tumble(*command[1:])
    assert solved.returncode == 0 and "13 of 13 positions, estimator norm" in solved.stdout
    result = package.load(tmp_path / "result.json")
    assert (np.abs(result.K - 9.81 / 2 * LOWER) < 4 * result.u_K + 1e-12).all()


def test_more_rests_than_are_solved_are_refused_with_the_shortest_left_out(tumble, tmp_path):
    log = recording_of(tmp_path, around(38))
    short = [line for row, line in enumerate(log.read_text().splitlines()) if not 9 * 360 < row <= 9 * 360 + 60]
    log.write_text("\n".join(short) + "\n")
    done = tumble("import", log, "--schedule", "any_pose", "--leave-out", "4", "--out", tmp_path / "run.csv")
    assert done.returncode == 2 and "37 rests, at most 36 poses are solved: --leave-out" in done.stderr
    command = shlex.split(done.stderr.partition("matter least:\n")[2].replace("\\\n", ""))
    assert command[command.index("--leave-out") + 1] == "4,10"
    assert tumble(*command[1:]).returncode == 0


def test_a_public_set_agrees_with_imu_tk_and_with_its_maker():
    """An Xsens MTi in 36 poses (Tedaldi, Pretto and Menegatti 2014). imu_tk, built from its sources, finds its own
    rests in the same recording, and K^-1 in a frame of its own: upper triangular. Its gravity is 9.81744 m/s^2. The
    maker's scales, offsets and angles stand rounded in the authors' MATLAB scripts."""
    result = package.solve(ROOT / "tests/data/xsens_mti_poses.csv", schedule="any_pose")
    scales = np.array([0.00241301830043, 0.00242699636947, 0.00241184303409])  # m/s^2 per count
    turns = np.array([[1, -0.00339262387534, -0.00929640746681], [0, 1, -0.0213672272494], [0, 0, 1]])
    theirs = 9.81744 * np.linalg.inv(turns @ np.diag(scales))
    apart = result.K - np.linalg.cholesky(theirs @ theirs.T)
    assert (np.abs(apart[norm.ROWS, norm.COLUMNS]) < result.u_K[norm.ROWS, norm.COLUMNS]).all()
    assert (np.abs(result.U0 - [33123.8382825, 33275.163011, 32364.4945761]) < result.u_U0).all()
    rows = result.K / np.linalg.norm(result.K, axis=1)[:, None]
    assert np.abs(np.linalg.norm(result.K, axis=1) / 9.81744 - [415, 413, 415]).max() < 1.0
    assert np.abs(result.U0 - [33123, 33276, 32360]).max() < 5.0
    assert np.abs([rows[0] @ rows[1], rows[0] @ rows[2], rows[1] @ rows[2]] - np.array([0.01, 0.01, 0.02])).max() < 0.01


def test_labels_tell_poses_apart_and_nothing_of_how_they_lie(tumble, tmp_path):
    """Rows that somebody numbered: `position` and `mounting` name no attitudes of a schedule here."""
    head, *rows = recording_of(tmp_path, POSES).read_text().splitlines()
    numbered = [f"{min(row // 360 + 1, len(POSES))},{text}" for row, text in enumerate(rows)]
    for name in ("position", "mounting"):
        (tmp_path / "numbered.csv").write_text("\n".join([f"{name},{head}", *numbered]) + "\n")
        done = tumble("import", tmp_path / "numbered.csv", "--schedule", "any_pose", "--json")
        assert (done.returncode, done.stderr) == (0, "")
        assert len(json.loads(done.stdout)["rests"]) == len(POSES)
