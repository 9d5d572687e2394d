"""Seats and platform: what a tilt of the block against the axis costs, and when nobody can know."""

import dataclasses
import json

import gain_record
import jsonschema
import numpy as np
import pytest
from blocks import (
    NOMINAL_K,
    gains_of,
    random_block,
    random_rotation,
    standard_deviations,
    usable_schedule,
    write_run,
)
from conftest import EXAMPLES, ROOT
from core_functions import estimate_optimal, stand_gains_of

import tumble as package
from tumble import core, model
from tumble.core import GainRecord, estimate_runs, optimal_runs, uncertainties
from tumble.estimators import COEFFICIENTS, LINEAR
from tumble.files.stand_file import read_stand
from tumble.model.errors import sources
from tumble.model.estimators import design
from tumble.model.optimal import optimal_table
from tumble.schedule import Mounting, Position, Schedule
from tumble.solving import optimal_run
from tumble.stand import PAPER_STAND, Stand

PAPER = model.built_in("paper")
NAMES = np.array(COEFFICIENTS[:9]).reshape(3, 3)
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
        k, u0 = model.estimate(schedule, source.derivative, estimator)
        rows.append(source.sigma[:, None] * np.concatenate([k.reshape(-1, 9), u0], axis=1))
    draws = np.concatenate(rows)
    return draws.T @ draws


@pytest.mark.parametrize(("name", "seat"), REFINED)
def test_what_a_seat_costs_the_paper_s_schedule(name, seat):
    declared, expected = stand(*STANDS[name], seat=seat), REFINED[name, seat]
    witness, _ = model.by_coefficient(model.Propagation(PAPER, NOMINAL_K, declared, LONE_ROWS, "refined").covariance())
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
        given = model.Propagation(schedule.data, k, declared, samples, "least_squares")
        witness = model.by_coefficient(given.covariance())
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
    found = model.Geometry(schedule).force(seat_h=lean, seat_n=turn, alpha3=yaw)[0]
    assert found == pytest.approx(matrix @ about_v @ about_h @ f, abs=1e-15)


@pytest.mark.parametrize("estimator", LINEAR)
def test_two_mountings_see_nothing_of_a_platform_off_square(estimator):
    """2 mrad move K_yz by as much of K_yy; check positions, residuals and the gravity check stay as they are."""
    k, u0 = NOMINAL_K, np.array([0.1, -0.2, 0.3])
    paper = core.CoreSchedule(PAPER)
    means = model.Geometry(PAPER).outputs(k, u0, seat_h=2e-3)
    found_k, found_u0 = core.estimate(paper, means, None, estimator)
    moved = found_k - k
    assert moved[1, 2] == pytest.approx(2e-3 * k[1, 1], rel=1e-3)
    assert moved[2, 1] == pytest.approx(2e-3 * k[2, 2], rel=1e-3)
    assert found_u0 == pytest.approx(u0, abs=1e-12)
    assert model.residual_rms(PAPER, means, found_k, found_u0) == pytest.approx(0.0, abs=1e-12)
    norms = np.linalg.norm(np.linalg.solve(found_k, k @ np.array([0, 1, 1]) / 2**0.5))
    assert abs(norms - 1.0) == pytest.approx(2e-3, rel=0.05)
    assert model.seat_is_unseen(PAPER, found_k)


def test_a_third_mounting_shows_it():
    assert not model.seat_is_unseen(THREE, NOMINAL_K)
    for tilt in (10.0, 45.0):
        mountings = tuple(Mounting(mounting.number, mounting.matrix, tilt) for mounting in PAPER.mountings)
        assert model.seat_is_unseen(Schedule(mountings, PAPER.positions), NOMINAL_K)


@pytest.mark.parametrize("estimator", LINEAR)
@pytest.mark.parametrize("source", ["seat", "platform"])
def test_what_a_seat_brings_is_what_a_declared_one_does(source, estimator):
    stand = PAPER_STAND.with_sigma(source, 1e-4)
    samples = np.full(18, 50)
    plain, more = (
        np.diag(model.Propagation(PAPER, NOMINAL_K, one, samples, estimator).covariance())
        for one in (PAPER_STAND, stand)
    )
    moved = model.moved_by_a_seat(PAPER, NOMINAL_K, estimator)[source]
    assert more - plain == pytest.approx((1e-4 * moved) ** 2, abs=1e-6 * more.max())


CROSS = ["K_xy", "K_xz", "K_yx", "K_yz", "K_zx", "K_zy"]
MARKED = {("paper", "refined"): CROSS, ("paper", "optimal"): CROSS, ("lab", "refined"): ["K_yz", "K_zy"]}


@pytest.mark.parametrize("stand, estimator", MARKED)
def test_every_coefficient_is_marked_whose_uncertainty_a_seat_would_raise(stand, estimator):
    """By a tenth, of 1e-4 rad. On `lab` the yaw hides it in all but two."""
    run, file = (EXAMPLES / f"{stand}_stand.{kind}" for kind in ("csv", "toml"))
    found = package.solve(run, stand=file, estimator=estimator).document
    assert found["assumed_for"]["seat"] == MARKED[stand, estimator]
    declared = read_stand(str(file))
    for source in ("seat", "platform"):
        more = dataclasses.replace(declared, stand=declared.stand.with_sigma(source, 1e-4))
        raised = np.array(package.solve(run, stand=more, estimator=estimator).document["u_K"]) / found["u_K"]
        if estimator != "optimal":  # which weighs anew for a stand that has a seat
            assert (raised[~np.isin(NAMES, found["assumed_for"]["seat"])] < 1.1).all()
    if stand == "paper" and estimator == "refined":
        assert (raised[np.isin(NAMES, ["K_yz", "K_zy"])] > 5.0).all()


def with_keys(tmp_path, **keys):
    lines = (EXAMPLES / "paper_stand.toml").read_text().splitlines()
    place = lines.index("[stand]") + 1
    path = tmp_path / "stand.toml"
    path.write_text("\n".join([*lines[:place], *(f"{key} = {value}" for key, value in keys.items()), *lines[place:]]))
    return path


@pytest.mark.parametrize("key", ["seat_rad", "platform_rad"])
def test_who_declares_either_is_told_of_no_assumption(key, tmp_path, tumble):
    run = EXAMPLES / "paper_stand.csv"
    plain = tumble("solve", run, "--unit", "V", "--stand", EXAMPLES / "paper_stand.toml").stdout
    assert plain.splitlines()[0].startswith("PASS, assuming a square seat and one temperature: ")
    assert plain.count("*") == 7  # six coefficients, and what is said of them
    declared = with_keys(tmp_path, **{key: 5e-5})
    text = tumble("solve", run, "--unit", "V", "--stand", declared).stdout
    assert text.splitlines()[0].startswith("PASS, assuming one temperature: ") and "*" not in text
    result = json.loads(tumble("solve", run, "--unit", "V", "--stand", declared, "--json").stdout)
    assert (result["assumes"], result["assumed_for"]) == (["temperature"], {"temperature": []})
    assert result["u_K"][1][2] == pytest.approx(5.1e-5 * 2, rel=0.01)


@pytest.mark.parametrize("key", ["seat_rad", "platform_rad"])
@pytest.mark.parametrize("value", ["-1e-4", "0.6", "true"])
def test_a_seat_that_is_none_is_refused(key, value, tmp_path, refused):
    message = refused("solve", EXAMPLES / "paper_stand.csv", "--stand", with_keys(tmp_path, **{key: value}))
    assert key in message


# Worst u of the norm of a with optimal weights, ug: two mountings, three; seat 0, 1e-4, 1e-3
BOUNDS = {
    "paper": ((14.6, 72.0, 707), (12.5, 13.4, 13.4)),
    "angle": ((11.1, 71.4, 707), (9.7, 10.4, 10.4)),
    "lab": ((36.7, 79.1, 707), (31.6, 33.6, 34.0)),
}
SEATS = (0.0, 1e-4, 1e-3)


@pytest.mark.parametrize("name", BOUNDS)
def test_a_third_mounting_frees_the_norm_of_the_seat(name):
    """The bound by numpy's dense covariance; the table's own rows of gains reach it."""
    for schedule, expected in zip((PAPER, THREE), BOUNDS[name]):
        found = []
        for seat in SEATS:
            declared = stand(*STANDS[name], seat=seat)
            table = optimal_table(schedule, NOMINAL_K, declared)
            covariance = bound(schedule, declared)
            assert table.u == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-6)
            found.append(worst_of_norm(NOMINAL_K, covariance) * 1e6)
        assert found == pytest.approx(expected, rel=0.01)


def bound(schedule, declared):
    """Cramer and Rao: (A^T C^-1 A)^-1, C of all sources."""
    lone = np.ones(len(schedule.positions), dtype=int)
    draws = [
        source.sigma[:, None] * source.derivative.reshape(len(source.sigma), -1)
        for source in sources(schedule, NOMINAL_K, declared, lone).values()
    ]
    covariance = sum(part.T @ part for part in draws)
    dense = design(schedule)
    return np.linalg.inv(dense.T @ np.linalg.solve(covariance, dense))


@pytest.mark.parametrize("schedule", [PAPER, THREE], ids=["two", "three"])
@pytest.mark.parametrize("seats", [{"seat": 3e-3}, {"platform": 3e-3}, {"seat": 2e-3, "platform": 4e-3}], ids=str)
def test_optimal_takes_seats_among_its_unknowns(schedule, seats):
    """Core and witness agree within 1e-6 u on runs of the exact geometry, where the second order matters."""
    rng = np.random.default_rng(903)
    declared = stand(2e-4, 5e-4, 1e-2, 2e-4, 3e-5, **seats)
    core_schedule, positions = core.CoreSchedule(schedule), len(schedule.positions)
    lone, all_measured = np.ones(positions, dtype=int), np.ones(positions, dtype=bool)
    for _ in range(2):
        means = simulated(rng, schedule, declared, 1)[0]
        witness = model.optimal_estimate(schedule, means, declared, lone)
        found = estimate_optimal(core_schedule, means, all_measured, optimal_run.Weighting(declared, lone))
        assert (np.abs(found.k - witness.k) < 1e-6 * witness.u_k).all()
        assert (np.abs(found.u0 - witness.u0) < 1e-6 * witness.u_u0).all()
        assert found.alpha3 == pytest.approx(witness.alpha3, abs=1e-9)


def simulated(rng, schedule, declared, runs, platform=0.0):
    """Means (runs, positions, 3) on the exact geometry; `platform`: what it is in all of them."""
    mountings, positions = len(schedule.mountings), len(schedule.positions)
    shared, seats = rng.normal(size=(3, runs, 1)), rng.normal(size=(3, runs, mountings))
    outputs = model.Geometry(schedule).outputs(
        NOMINAL_K,
        np.array([0.1, -0.2, 0.3]),
        alpha1=shared[0] * declared.axis_tilt,
        alpha2=shared[1] * declared.level,
        alpha3=seats[0] * declared.remount,
        delta=rng.normal(size=(runs, positions)) * declared.angle,
        seat_h=seats[1] * declared.seat + shared[2] * declared.platform + platform,
        seat_n=seats[2] * declared.seat,
    )
    return outputs + rng.normal(size=outputs.shape) * declared.noise / np.sqrt(declared.samples)


def test_a_record_without_seats_is_as_it_was():
    table = optimal_table(PAPER, NOMINAL_K, stand(*STANDS["lab"]))
    plain = optimal_run.to_bytes(optimal_run.record_of(table, PAPER))
    assert plain[13:16] == bytes(3) and len(plain) == gain_record.size_of(18, 2)
    table = optimal_table(PAPER, NOMINAL_K, stand(*STANDS["lab"], platform=1e-3))
    data = optimal_run.to_bytes(optimal_run.record_of(table, PAPER))
    assert data[13] == 2 and len(data) == len(plain) + 8 * 54 * 4
    opened = GainRecord(core.CoreSchedule(PAPER), data)
    assert np.array_equal(stand_gains_of(opened), table.nuisance_gains)
    assert np.array_equal(table.nuisance_gains[4], table.nuisance_gains[5])  # of the platform, in either mounting
    assert not table.nuisance_gains[6:].any()
    again = gain_record.from_bytes(data)
    assert (again.seats, optimal_run.to_bytes(again)) == (2, data)


@pytest.mark.parametrize("seats", [1, 3, 255])
def test_a_record_of_another_number_of_seats_is_refused(seats):
    table = optimal_table(PAPER, NOMINAL_K, stand(*STANDS["lab"], seat=1e-3))
    record = optimal_run.record_of(table, PAPER)
    rows = np.zeros((4 + 2 * seats, 54))
    data = optimal_run.to_bytes(dataclasses.replace(record, seats=seats, nuisance_gains=rows))
    with pytest.raises(gain_record.BadRecord):
        gain_record.from_bytes(data)
    with pytest.raises(core.CoreRefusal) as refusal:
        GainRecord(core.CoreSchedule(PAPER), data)
    assert refusal.value.name == "TUMBLE_E_GAIN_RECORD"


@pytest.mark.slow
@pytest.mark.parametrize("schedule", [PAPER, THREE], ids=["two", "three"])
@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
def test_as_many_runs_are_within_2u_as_should_be(schedule, estimator):
    """4,000 runs of the exact geometry: 95.45 % within four standard errors, 1.3 points."""
    declared = stand(*STANDS["paper"], seat=3e-4, platform=2e-4)
    means = simulated(np.random.default_rng(904), schedule, declared, 4000)
    truth = np.concatenate([NOMINAL_K.ravel(), [0.1, -0.2, 0.3]])
    core_schedule = core.CoreSchedule(schedule)
    if estimator == "optimal":
        table = optimal_table(schedule, NOMINAL_K, declared)
        record = GainRecord(core_schedule, optimal_run.to_bytes(optimal_run.record_of(table, schedule)))
        found, u = optimal_runs(record, means)[0], table.u
    else:
        found = estimate_runs(core_schedule, means, estimator)
        lone = np.ones(len(schedule.positions), dtype=int)
        u_k, u_u0 = uncertainties(core_schedule, NOMINAL_K, declared, lone, estimator)
        u = np.concatenate([u_k.ravel(), u_u0])
    within = (np.abs(found - truth) <= 2.0 * u).mean(axis=0)
    assert within == pytest.approx(0.9545, abs=0.0132)


SCHEMA = {
    kind: json.loads((ROOT / f"docs/schemas/tumble.{kind}-1.schema.json").read_text()) for kind in ("plan", "result")
}


@pytest.mark.parametrize("seats", [("seat",), ("platform",), ("seat", "platform")], ids=str)
@pytest.mark.parametrize("estimator", ["refined", "optimal"])
def test_a_budget_has_a_term_for_each(seats, estimator, tmp_path, tumble):
    """Seat and platform after the five; all of them make up what the estimator's gains leave."""
    declared = with_keys(tmp_path, **{f"{name}_rad": 2e-4 for name in seats})
    done = tumble("plan", "budget", "--stand", declared, "--estimator", estimator, "--json")
    plan = json.loads(done.stdout)
    jsonschema.validate(plan, SCHEMA["plan"])
    assert list(plan["sources"])[5:-1] == [f"{name}_rad" for name in seats]
    assert all(len(row) == 5 + len(seats) for row in plan["terms"].values())
    expected = dict.fromkeys(("K_yz", "K_zy"), [2e-4 / 0.02] * len(seats))
    for name, terms in expected.items():
        assert plan["terms"][name][5:] == pytest.approx(terms, rel=1e-3)
    case = stand(*STANDS["paper"], **dict.fromkeys(seats, 2e-4))
    weights = gains_of(PAPER, estimator, NOMINAL_K, case)
    u = standard_deviations(PAPER, weights, NOMINAL_K, case, STANDS["paper"][4])
    assert np.ravel(plan["u_K"]) == pytest.approx(u[:9], rel=1e-3)


def test_published_weights_know_five_sources(tmp_path, tumble):
    declared = with_keys(tmp_path, seat_rad=1e-4)
    plan = json.loads(tumble("plan", "budget", "--stand", declared, "--weights", "published", "--json").stdout)
    assert all(len(row) == 5 for row in plan["terms"].values()) and "seat_rad" not in plan["sources"]


@pytest.mark.parametrize("estimator", ["refined", "optimal"])
def test_requirements_of_a_seat(estimator, tmp_path, tumble):
    """A seat enters the scale factors by misalignments: sqrt(2) a_ij of K_yy, both of its turns in quadrature."""
    declared = with_keys(tmp_path, seat_rad=1e-4, platform_rad=2e-4)
    done = tumble("plan", "require", "--stand", declared, "--estimator", estimator, "--json")
    plan = json.loads(done.stdout)
    jsonschema.validate(plan, SCHEMA["plan"])
    assert (plan["declared"]["seat_rad"], plan["declared"]["platform_rad"]) == (1e-4, 2e-4)
    names = {"alpha1", "alpha2", "alpha3", "alpha4", "noise", "seat", "platform"}
    assert set(plan["set_by"]) == set(plan["split"]) == names
    if estimator == "refined":
        assert plan["seat_rad"] == pytest.approx(1e-4 / 5**0.5 / (0.02 * 2**0.5), rel=0.01)
        assert plan["set_by"]["seat"] == "K_yy"
    message = tumble("plan", "require", "--stand", EXAMPLES / "paper_stand.toml", "--split", "seat=2")
    assert (message.returncode, message.stdout) == (2, "") and "seat=2" in message.stderr


def test_simulated_runs_have_the_seats_that_were_declared(tmp_path, tumble):
    declared = with_keys(tmp_path, seat_rad=3e-4, platform_rad=2e-4)
    done = tumble("plan", "validate", "--stand", declared, "--runs", "4000", "--json")
    assert done.returncode == 0
    jsonschema.validate(json.loads(done.stdout), SCHEMA["plan"])


def test_the_bench_draws_seats_and_tells_them(tmp_path, tumble):
    """On the exact geometry: what it told of the stand gives the means again, to their noise."""
    declared = with_keys(tmp_path, seat_rad=3e-3, platform_rad=2e-3)
    result = json.loads(tumble("bench", "--stand", declared, "--seed", "3", "--out", tmp_path / "run", "--json").stdout)
    jsonschema.validate(result, SCHEMA["result"])
    truth = result["truth"]
    assert result["assumes"] == [] and len(set(truth["theta_h_rad"] + truth["theta_n_rad"])) == 4
    outputs = model.Geometry(PAPER).outputs(
        np.array(truth["K"]),
        np.array(truth["U0"]),
        alpha1=truth["alpha1_rad"],
        alpha2=truth["alpha2_rad"],
        alpha3=np.array(truth["alpha3_rad"]),
        delta=np.array(truth["alpha4_rad"]),
        seat_h=np.array(truth["theta_h_rad"]),
        seat_n=np.array(truth["theta_n_rad"]),
    )
    means = np.array([mean["mean"] for mean in result["means"]])
    assert np.abs(means - outputs).max() < 5 * 3e-4 / 50**0.5
    plain = json.loads(tumble("bench", "--seed", "3", "--out", tmp_path / "plain", "--json").stdout)
    assert plain["truth"]["theta_h_rad"] == plain["truth"]["theta_n_rad"] == [0.0, 0.0]
    assert plain["assumes"] == ["seat"]


def test_the_bench_s_firmware_takes_seats_among_its_unknowns(tmp_path, tumble):
    declared = with_keys(tmp_path, seat_rad=1e-3)
    arguments = ("--stand", declared, "--seed", "4", "--estimator", "optimal", "--out", tmp_path / "run", "--json")
    done = tumble("bench", *arguments)
    assert done.returncode in (0, 1), done.stderr  # 3, if the firmware and the witness did not agree
    assert (tmp_path / "run/inputs/gains.bin").read_bytes()[13] == 2


def test_runs_share_the_platform_and_draw_their_seats(tmp_path, tumble):
    """Four runs halve what each draws anew; the platform stays as it is."""
    rng, u = np.random.default_rng(905), {}
    for key in ("seat", "platform"):
        declared, platform = with_keys(tmp_path, **{f"{key}_rad": 1e-3}), 1e-3 * (key == "platform")
        runs = []
        for number in range(4):
            runs.append(tmp_path / f"{key}-{number}.csv")
            drawn = stand(*STANDS["paper"], **({"seat": 1e-3} if key == "seat" else {}))
            write_run(runs[-1], PAPER, simulated(rng, PAPER, drawn, 1, platform)[0])
        done = tumble("fixture", "check", "--stand", declared, "--against", "declared", *runs, "--json")
        u[key] = json.loads(done.stdout)["combined"]["u_K"][1][2]
    assert u["seat"] == pytest.approx(1e-3, rel=0.02)
    assert u["platform"] == pytest.approx(2e-3, rel=0.02)


def test_a_pattern_that_is_a_bias_on_these_positions_marks_no_coefficient():
    """Hysteresis, where every position remembers the same half circle: what it moves of K is rounding. With five faces
    one axis is seen from one side alone, and even orders are not told from its scale."""
    kept = [position.label != "1.7" for position in model.built_in("six_faces").positions]
    unseen = model.unseen_patterns(model.built_in("six_faces").part(kept), NOMINAL_K, "least_squares")
    assert list(unseen) == ["k2", "k3", "asymmetry"]
    assert unseen["k2"].sum() == unseen["asymmetry"].sum() == 1 and unseen["k3"].sum() == 3
