"""Three mountings: the built-in schedules, the closed forms on them, and that neither seat nor yaw changes the norm."""

import json
from fractions import Fraction
from math import isqrt

import numpy as np
import pytest
from blocks import NOMINAL_K, random_block, write_run
from conftest import EXAMPLES

from tumble import core, model
from tumble.model import Geometry
from tumble.schedule import BUILT_IN

SQRT2 = Fraction(isqrt(2 * 10**80), 10**40)
CLOSED = ("diagonal", "three_mountings")
NO_ROTATION = "[[mounting]] is refused: a mounting matrix is not a proper rotation\n"


@pytest.mark.parametrize("name", BUILT_IN)
def test_core_and_witness_have_the_same_schedules(name):
    assert core.built_in(name) == model.built_in(name)


def test_the_schedules_are_what_their_names_say():
    assert [len(core.built_in(name).positions) for name in BUILT_IN] == [18, 27, 12, 15, 6, 6, 27, 36]
    force = Geometry(model.built_in("six_faces")).force()
    faces = [[0, 0, 1], [1, 0, 0], [0, 0, -1], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]
    np.testing.assert_allclose(force, faces, atol=1e-15)


def harmonics(means):
    """c, s, b of one channel on one circle, exactly: of four means as on the diagonals, of nine as in formula (3)."""
    u = [None, *means]
    if len(means) == 4:
        root8 = 2 * SQRT2
        return (u[1] - u[2] - u[3] + u[4]) / root8, (u[1] + u[2] - u[3] - u[4]) / root8, sum(means) / 4
    c = (u[1] + u[9] - 2 * u[5] + SQRT2 * (u[2] + u[8] - u[4] - u[6])) / 8
    s = (2 * (u[3] - u[7]) + SQRT2 * (u[2] + u[4] - u[6] - u[8])) / 8
    return c, s, ((u[1] + u[9]) / 2 + sum(means[1:8])) / 8


def by_definition(means, refined):
    """The twelve coefficients of three circles by exact fractions: means (3 n, 3), K (3, 3) and U0 (3,)."""
    each = len(means) // 3
    rows = [[Fraction(value) for value in row] for row in means.tolist()]
    circles = [rows[m : m + each] for m in range(0, 3 * each, each)]
    of = [[harmonics([row[i] for row in circle]) for i in range(3)] for circle in circles]  # of[mounting][channel]
    c, s, b = ([[channel[which] for channel in circle] for circle in of] for which in range(3))
    k = [[(s[0][i] - s[1][i]) / 2, (c[1][i] + c[2][i]) / 2, (c[0][i] + s[2][i]) / 2] for i in range(3)]
    if refined:
        k[0][2], k[2][0] = c[0][0], s[0][2]
        k[0][1], k[1][0] = c[1][0], -s[1][1]
        k[1][2], k[2][1] = s[2][1], c[2][2]
    return np.array(k, dtype=float), np.array([(b[0][i] + b[1][i] + b[2][i]) / 3 for i in range(3)], dtype=float)


@pytest.mark.parametrize("estimator", ["averaged", "refined"])
@pytest.mark.parametrize("name", CLOSED)
def test_the_closed_forms_are_the_formulas_on_any_data(name, estimator):
    rng, schedule = np.random.default_rng(71), core.CoreSchedule.built_in(name)
    for _ in range(20):
        means = rng.uniform(-4, 4, (len(schedule), 3))
        expected_k, expected_u0 = by_definition(means, estimator == "refined")
        for k, u0 in (core.estimate(schedule, means, estimator=estimator),
                      model.estimate(model.built_in(name), means, estimator)):  # fmt: skip
            np.testing.assert_allclose(k, expected_k, rtol=0, atol=4e-15)
            np.testing.assert_allclose(u0, expected_u0, rtol=0, atol=4e-15)


def ideal_means(name, k, u0):
    """Outputs of a block on an ideal stand: exact numbers of the form p + q sqrt2, each rounded once."""
    half = SQRT2 / 2
    sine = {0: Fraction(0), 45: half, 90: Fraction(1), 135: half, 180: Fraction(0)}

    def of(angle):  # sine at any multiple of 45 degrees
        return sine[angle] if (angle := angle % 360) <= 180 else -sine[angle - 180]

    schedule, means = core.built_in(name), []
    for position in schedule.positions:
        matrix = schedule.mountings[position.mounting - 1].matrix
        angle = round(position.angle_deg)
        force = [Fraction(row[0]) * of(angle) + Fraction(row[2]) * of(angle + 90) for row in matrix]
        means.append([float(Fraction(u) + sum(Fraction(x) * f for x, f in zip(row, force))) for row, u in zip(k, u0)])
    return np.array(means)


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares"])
@pytest.mark.parametrize("name", CLOSED)
def test_all_twelve_are_exact_on_an_ideal_stand(name, estimator):
    rng, schedule = np.random.default_rng(72), core.CoreSchedule.built_in(name)
    for _ in range(20):
        k, u0 = random_block(rng)
        means = ideal_means(name, k.tolist(), u0.tolist())
        for found_k, found_u0 in (core.estimate(schedule, means, estimator=estimator),
                                  model.estimate(model.built_in(name), means, estimator)):  # fmt: skip
            np.testing.assert_allclose(found_k, k, rtol=0, atol=2e-15 * np.abs(k).max())
            np.testing.assert_allclose(found_u0, u0, rtol=0, atol=2e-15 * np.abs(k).max())


def turned(vectors, axis, angle):
    """Vectors (positions, 3) of the table frame turned about one of its axes (0 h, 1 n, 2 v)."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    rotation = np.eye(3)
    rotation[[i, j], [i, j]] = np.cos(angle)
    rotation[i, j], rotation[j, i] = -np.sin(angle), np.sin(angle)
    return vectors @ rotation.T


def seated(schedule, seats):
    """Specific force (positions, 3) with the block's seat turned in every mounting: `seats` (mountings, 3) about h, n
    and v."""
    phi = np.deg2rad([position.angle_deg for position in schedule.positions])
    table = np.column_stack([np.sin(phi), np.zeros(len(phi)), np.cos(phi)])
    force = np.empty_like(table)
    for mounting, seat in zip(schedule.mountings, seats):
        here = [position.mounting == mounting.number for position in schedule.positions]
        felt = table[here]
        for axis, angle in enumerate(seat):
            felt = turned(felt, axis, angle)
        force[here] = felt @ np.array(mounting.matrix).T
    return force


@pytest.mark.parametrize("axis", range(3), ids=["theta_h", "theta_n", "yaw"])
@pytest.mark.parametrize("mounting", range(3))
@pytest.mark.parametrize("name", CLOSED)
def test_a_seat_turns_the_block_and_leaves_the_norm_alone(name, mounting, axis):
    """K^-1 K' - 1 of `refined` is a rotation, antisymmetric, but for the second order and for theta times a
    misalignment: theta_n turns the block, theta_h and the yaw do nothing. `averaged` takes these for a stretch."""
    theta, schedule = 1e-4, model.built_in(name)
    seats = np.zeros((3, 3))
    seats[mounting, axis] = theta
    for true_k, small in ((2.0 * np.eye(3), 2 * theta**2), (NOMINAL_K, 0.04 * theta)):
        means = seated(schedule, seats) @ true_k.T
        for estimator in ("refined", "averaged"):
            for k, u0 in (core.estimate(core.CoreSchedule(schedule), means, estimator=estimator),
                          model.estimate(schedule, means, estimator)):  # fmt: skip
                change = np.linalg.solve(true_k, k) - np.eye(3)
                stretch = np.abs(change + change.T).max() / 2
                if estimator == "refined" or axis == 1:
                    assert stretch <= small
                    expected = {"refined": theta, "averaged": theta / 2}[estimator] if axis == 1 else 0.0
                    assert np.abs(change).max() == pytest.approx(expected, abs=small)
                else:
                    assert stretch == pytest.approx(theta / 4, rel=0.05)
                assert np.abs(u0).max() < 1e-12


@pytest.mark.parametrize("name", CLOSED)
def test_two_mountings_feel_a_tilt_of_the_seat(name):
    """The counterpart: without the third mounting a seat of theta_h stretches the block, and no estimator can know."""
    theta, schedule = 1e-4, model.built_in(name)
    two = type(schedule)(schedule.mountings[:2], tuple(p for p in schedule.positions if p.mounting < 3))
    means = seated(two, [[theta, 0, 0]] * 2) @ NOMINAL_K.T
    k, _ = core.estimate(core.CoreSchedule(two), means)
    change = np.linalg.solve(NOMINAL_K, k) - np.eye(3)
    assert np.abs(change + change.T).max() / 2 == pytest.approx(theta, rel=1e-3)


@pytest.mark.parametrize("name", CLOSED)
def test_solve_takes_a_schedule_by_its_name(name, tumble, tmp_path):
    schedule = core.built_in(name)
    run = write_run(tmp_path / "run.csv", schedule, Geometry(schedule).outputs(NOMINAL_K, [0.1, 0.2, 0.3]))
    done = tumble("solve", run, "--schedule", name, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert np.array(json.loads(done.stdout)["K"]) == pytest.approx(NOMINAL_K, abs=1e-14)


def test_a_file_of_a_schedules_name_needs_a_path(tumble, refused, tmp_path):
    (tmp_path / "paper").write_text("no TOML [")
    schedule = core.built_in("paper")
    run = write_run(tmp_path / "run.csv", schedule, Geometry(schedule).outputs(NOMINAL_K, [0.1, 0.2, 0.3]))
    assert tumble("solve", run, "--schedule", "paper", cwd=tmp_path).returncode == 0
    assert "paper: row 1" in refused("solve", run, "--schedule", "./paper", cwd=tmp_path)


def schedule_text(matrix):
    """A schedule file like `diagonal`, its third mounting with this matrix."""
    schedule, lines = core.built_in("diagonal"), []
    for mounting in schedule.mountings:
        rows = matrix if mounting.number == 3 else [list(row) for row in mounting.matrix]
        lines += ["[[mounting]]", f"number = {mounting.number}", f"matrix = {rows}"]
    for one in schedule.positions:
        lines += ["[[position]]", f"mounting = {one.mounting}", f"position = {one.number}"]
        lines += [f"angle_deg = {one.angle_deg}", f'use = "{one.use}"']
    return "\n".join(lines) + "\n"


def rotation_about_x(degrees):
    turn = np.deg2rad(degrees)
    sine, cosine = np.sin(turn), np.cos(turn)
    return np.array([[0, 1, 0], [-sine, 0, cosine], [cosine, 0, sine]])  # of the third mounting


def test_a_matrix_typed_to_five_decimals_is_made_orthonormal(tumble, tmp_path):
    exact = rotation_about_x(37.0)
    file = tmp_path / "typed.toml"
    file.write_text(schedule_text(np.round(exact, 5).tolist()))
    schedule = core.built_in("diagonal")
    turned = type(schedule)(
        (*schedule.mountings[:2], type(schedule.mountings[0])(3, tuple(map(tuple, exact)))), schedule.positions
    )
    run = write_run(tmp_path / "run.csv", turned, Geometry(turned).outputs(NOMINAL_K, [0.1, 0.2, 0.3]))
    done = tumble("solve", run, "--schedule", file, "--json")
    assert done.returncode == 0
    assert done.stderr.startswith(f"tumble: notice: {file}: matrix of mounting 3 made orthonormal, by ")
    assert done.stderr.count("\n") == 1
    assert np.array(json.loads(done.stdout)["K"]) == pytest.approx(NOMINAL_K, abs=2e-5)
    file.write_text(schedule_text(exact.tolist()))
    assert tumble("solve", run, "--schedule", file).stderr == ""


@pytest.mark.parametrize("off", [1e-4, -1e-3, 1.0])
def test_a_matrix_farther_off_is_refused(off, refused, tmp_path):
    matrix = rotation_about_x(37.0)
    matrix[1, 0] += off
    file = tmp_path / "typed.toml"
    file.write_text(schedule_text(matrix.tolist()))
    run = tmp_path / "run.csv"
    run.write_text("mounting,position,ux,uy,uz\n")
    assert refused("solve", run, "--schedule", file).endswith(NO_ROTATION)


def test_a_reflection_is_refused(refused, tmp_path):
    file, run = tmp_path / "typed.toml", tmp_path / "run.csv"
    file.write_text(schedule_text((-np.round(rotation_about_x(37.0), 5)).tolist()))
    run.write_text("mounting,position,ux,uy,uz\n")
    assert refused("solve", run, "--schedule", file).endswith(NO_ROTATION)


def test_diagonal_closed_is_diagonal_and_a_check_of_its_first_angle():
    closed = core.built_in("diagonal_closed")
    assert closed.mountings == core.built_in("diagonal").mountings
    fifths = [position for position in closed.positions if position.number == 5]
    assert tuple(one for one in closed.positions if one not in fifths) == core.built_in("diagonal").positions
    assert [(one.mounting, one.angle_deg, one.use) for one in fifths] == [(m, 45.0, "check") for m in (1, 2, 3)]


def test_a_fifth_position_closes_each_mounting(tumble, tmp_path):
    """The bench measures it, `diagonal` takes the run with it: closure by hand, and the same K and U0 as without it."""
    done = tumble("bench", "--schedule", "diagonal_closed", "--seed", "1", "--json", "--out", tmp_path / "run")
    result = json.loads(done.stdout)
    assert done.returncode == 0 and result["counters"]["positions"] == 15
    run, common = tmp_path / "run" / "run.csv", ("--unit", "V", "--schedule", "diagonal")
    solved = json.loads(tumble("solve", run, *common, "--json").stdout)
    outputs = {f"{one['mounting']}.{one['position']}": np.array(one["mean"]) for one in solved["means"]}
    assert [one["mounting"] for one in solved["verification"]["closure"]] == [1, 2, 3]
    for one in solved["verification"]["closure"]:
        mounting = one["mounting"]
        assert one["difference"] == pytest.approx(outputs[f"{mounting}.5"] - outputs[f"{mounting}.1"], abs=1e-15)
    text = tumble("solve", run, *common, "--details").stdout
    assert "at 15 of 15 positions" in text and text.count("Closure of mounting ") == 3

    rows = run.read_text().splitlines()
    (tmp_path / "four.csv").write_text("\n".join(row for row in rows if row.split(",")[1] != "5") + "\n")
    four = json.loads(tumble("solve", tmp_path / "four.csv", *common, "--json").stdout)
    assert (four["K"], four["U0"], four["verification"]["closure"]) == (solved["K"], solved["U0"], [])
    assert "at 12 of 12 positions" in tumble("solve", tmp_path / "four.csv", *common).stdout


def test_a_sixth_position_is_refused(refused, tmp_path):
    schedule = core.built_in("diagonal_closed")
    run = write_run(tmp_path / "run.csv", schedule, Geometry(schedule).outputs(NOMINAL_K, [0.1, 0.2, 0.3]))
    run.write_text(run.read_text() + "1,6,1.0,1.0,1.0\n")
    line = refused("solve", run, "--schedule", "diagonal")
    assert line.endswith("the schedule has no position 6 in mounting 1; positions are 1 to 5\n")


def test_fixture_check_takes_runs_with_and_without(tumble, tmp_path):
    stand = "--stand", EXAMPLES / "diagonal_stand.toml"
    for name, seed in (("diagonal", 1), ("diagonal_closed", 2)):
        assert tumble("bench", *stand, "--schedule", name, "--seed", seed, "--out", tmp_path / name).returncode == 0
    runs = tmp_path / "diagonal" / "run.csv", tmp_path / "diagonal_closed" / "run.csv"
    done = tumble("fixture", "check", *stand, "--schedule", "diagonal", "--limit", "1e-3", "--json", *runs)
    assert done.returncode == 0 and json.loads(done.stdout)["pass"]


def test_six_faces_is_no_circle(refused, tmp_path):
    schedule = core.built_in("six_faces")
    run = write_run(tmp_path / "run.csv", schedule, Geometry(schedule).outputs(NOMINAL_K, [0.1, 0.2, 0.3]))
    line = refused("solve", run, "--schedule", "six_faces", "--estimator", "refined")
    assert line == "tumble: six_faces: lacks positions that refined needs; least_squares solves any schedule\n"


@pytest.mark.parametrize("name", CLOSED)
def test_a_missing_position_of_the_third_mounting_is_named(name, refused, tmp_path):
    schedule = core.built_in(name)
    measured = np.array([position.label != "3.2" for position in schedule.positions])
    part = schedule.part(measured)
    run = write_run(tmp_path / "run.csv", part, Geometry(part).outputs(NOMINAL_K, [0.1, 0.2, 0.3]))
    assert refused("solve", run, "--schedule", name).endswith("; missing 3.2\n")


@pytest.mark.parametrize("name", CLOSED)
def test_the_bench_runs_it(name, tumble, tmp_path):
    done = tumble("bench", "--schedule", name, "--seed", "1", "--json", "--out", tmp_path / "run")
    result = json.loads(done.stdout)
    assert done.returncode == 0 and result["verification"]["pass"]
    assert result["counters"]["positions"] == len(core.built_in(name).positions)
    errors = np.abs(np.array(result["K"]) - result["truth"]["K"]) / result["u_K"]
    assert errors.max() < 4.0
