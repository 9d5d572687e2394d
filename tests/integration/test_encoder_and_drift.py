"""The encoder's errors and the drift of a run, where a stand declares them: what they do to results, and that they are
counted wherever an error of the stand counts."""

import dataclasses
import json
import re

import gain_record
import numpy as np
import pytest
from blocks import NOMINAL_K, gains_of, random_block, standard_deviations, usable_schedule
from conftest import EXAMPLES
from core_chi_squared import chi_squared, compare_fit
from core_functions import apply_table, stand_gains_of
from documents import valid
from test_seat import with_keys

from tumble import core, model
from tumble.core import GainRecord, estimate_runs, optimal_runs, uncertainties
from tumble.estimators import LINEAR
from tumble.files.run_file import Run
from tumble.fixture.judge import covariances
from tumble.model.errors import course, encoder_waves, exact_outputs, sources
from tumble.model.estimators import design
from tumble.model.fit import WholeModel
from tumble.model.optimal import optimal_table
from tumble.schedule import CHECK, Schedule
from tumble.solving import optimal_run
from tumble.solving.optimal_run import Weighting, make_table
from tumble.solving.solution import solve
from tumble.stand import Stand

PAPER = model.built_in("paper")
LONE = np.ones(18, dtype=int)
U0 = np.array([0.1, -0.2, 0.3])
STAND = Stand(2e-5, 2e-5, 4e-4, 4e-5, 3e-4, 50, "sigma1")
BOTH = dataclasses.replace(STAND, encoder=1e-4, drift=5e-4)


def by_hand(schedule, k, stand):
    """Covariance of the outputs of the fit positions (3P, 3P) that encoder and drift bring, as docs/method.md has it,
    by differences of the exact geometry."""
    fit = [place for place, position in enumerate(schedule.positions) if position.use != CHECK]
    step, columns = 1e-4, []
    for wave in (np.sin, np.cos, lambda t: np.sin(2 * t), lambda t: np.cos(2 * t)):
        delta = np.array([wave(np.radians(position.angle_deg)) for position in schedule.positions])
        above, below = (model.Geometry(schedule).outputs(k, U0, delta=size * delta) for size in (step, -step))
        columns.append((stand.sigma("encoder") * (above - below) / (2 * step))[fit].ravel())
    for channel in range(3):
        drift = np.zeros((len(fit), 3))
        drift[:, channel] = stand.sigma("drift") * (np.arange(len(fit)) / (len(fit) - 1) - 0.5)
        columns.append(drift.ravel())
    return np.array(columns).T @ np.array(columns)


def random_stand(rng, **changes):
    limits = ("sigma1", "sigma3", "uniform")[rng.integers(3)]
    sizes = dict(zip(("encoder", "drift", "seat", "platform"), rng.uniform(0, 1e-3, 4)))
    return Stand(*rng.uniform(1e-5, 1e-3, 5), 5, limits, **{**sizes, **changes})


@pytest.mark.parametrize("estimator", LINEAR)
@pytest.mark.parametrize("limits", ["sigma1", "uniform"])
def test_core_and_numpy_state_what_follows_by_hand(estimator, limits):
    declared, plain = (dataclasses.replace(one, limits=limits) for one in (BOTH, STAND))
    rows = gains_of(PAPER, estimator, NOMINAL_K, STAND)
    extra = np.diag(rows @ by_hand(PAPER, NOMINAL_K, declared) @ rows.T)
    schedule = core.CoreSchedule(PAPER)
    for by in (
        lambda stand: uncertainties(schedule, NOMINAL_K, stand, LONE, estimator),
        lambda stand: model.by_coefficient(model.Propagation(PAPER, NOMINAL_K, stand, LONE, estimator).covariance()),
    ):
        with_both, without = (np.concatenate([part.ravel() for part in by(stand)]) for stand in (declared, plain))
        assert with_both**2 - without**2 == pytest.approx(extra, rel=1e-5, abs=1e-16)


def test_core_and_numpy_agree_on_any_schedule():
    rng = np.random.default_rng(911)
    for _ in range(40):
        schedule = usable_schedule(rng)
        k, _ = random_block(rng)
        declared = random_stand(rng)
        samples = rng.integers(1, 9, len(schedule.data.positions))
        given = model.Propagation(schedule.data, k, declared, samples, "least_squares")
        witness = model.by_coefficient(given.covariance())
        found = uncertainties(schedule, k, declared, samples, "least_squares")
        for mine, other in zip(found, witness):
            assert mine == pytest.approx(other, rel=1e-9)


def test_a_position_that_was_not_measured_takes_no_time():
    """Course and uncertainties are those of the schedule without it."""
    measured = np.ones(18, dtype=bool)
    measured[[0, 7, 12]] = False
    whole = core.CoreSchedule(PAPER)
    found = uncertainties(whole, NOMINAL_K, BOTH, LONE, "least_squares", measured)
    part = model.Propagation(PAPER.part(measured), NOMINAL_K, BOTH, LONE[:15], "least_squares").covariance()
    for mine, other in zip(found, model.by_coefficient(part)):
        assert mine == pytest.approx(other, rel=1e-9)


def test_optimal_weights_reach_the_bound_of_the_dense_covariance():
    rng = np.random.default_rng(912)
    for _ in range(10):
        schedule, k = usable_schedule(rng).data, NOMINAL_K * rng.uniform(0.5, 1.5, (3, 3))
        declared = random_stand(rng)
        table, positions = optimal_table(schedule, k, declared), len(schedule.positions)
        lone = np.ones(positions, dtype=int)
        plain = dataclasses.replace(declared, encoder=0.0, drift=0.0)
        fit = schedule.fit_indices
        draws = [
            source.sigma[:, None] * source.derivative[:, fit].reshape(len(source.sigma), -1)
            for source in sources(schedule, k, plain, lone).values()
        ]
        covariance = sum(part.T @ part for part in draws) + by_hand(schedule, k, declared)
        dense = design(schedule)
        bound = np.linalg.inv(dense.T @ np.linalg.solve(covariance, dense))
        assert table.u == pytest.approx(np.sqrt(np.diag(bound)), rel=1e-5)
        assert standard_deviations(schedule, table.gains, k, declared, table.sigma_mean) == pytest.approx(table.u)


def test_a_check_position_is_beyond_the_fit_position_before_it():
    checks = dict(zip((0, 4, 17), (True,) * 3))
    positions = tuple(
        dataclasses.replace(position, use=CHECK) if place in checks else position
        for place, position in enumerate(PAPER.positions)
    )
    found = 14 * (course(Schedule(PAPER.mountings, positions)) + 0.5)
    assert found == pytest.approx([-0.5, 0, 1, 2, 2.5, *range(3, 15), 14.5])


def drawn(rng, schedule, k, declared):
    lone = np.ones(len(schedule.positions), dtype=int)
    errors = sources(schedule, k, declared, lone)
    draws = rng.standard_normal((1, sum(len(source.sigma) for source in errors.values())))
    return exact_outputs(schedule, k, U0, errors, draws)[0]


def test_optimal_agrees_with_its_witness_on_coarse_stands():
    """The second order takes the encoder's errors with it, as a turn of the table, and drift, which is none."""
    rng = np.random.default_rng(914)
    for _ in range(10):
        schedule, k = usable_schedule(rng), NOMINAL_K * rng.uniform(0.5, 1.5, (3, 3))
        declared = dataclasses.replace(BOTH, encoder=5e-3, drift=1e-2, remount=5e-3, noise=3e-3)
        means, lone = drawn(rng, schedule.data, k, declared), np.ones(len(schedule), dtype=int)
        measured = np.ones(len(schedule), dtype=bool)
        table = make_table(schedule, means, measured, Weighting(declared, lone))
        found = apply_table(table, schedule, means)
        witness = model.optimal_estimate(schedule.data, means, declared, lone)
        assert (np.abs(found.k - witness.k) < 1e-6 * witness.u_k).all()
        assert (np.abs(found.u0 - witness.u0) < 1e-6 * witness.u_u0).all()


@pytest.mark.parametrize("changes", [{"encoder": 1e-3}, {"drift": 1e-3}, {"encoder": 1e-3, "drift": 1e-3}])
def test_a_gain_record_has_rows_for_what_is_declared(changes):
    declared = dataclasses.replace(STAND, **changes)
    table = optimal_table(PAPER, NOMINAL_K, declared)
    data = optimal_run.to_bytes(optimal_run.record_of(table, PAPER))
    opened = GainRecord(core.CoreSchedule(PAPER), data)
    assert np.array_equal(stand_gains_of(opened), table.nuisance_gains)
    assert len(stand_gains_of(opened)) == 4 + (4 if "encoder" in changes else 0) + (3 if "drift" in changes else 0)
    assert (data[14], data[15]) == (4 if "encoder" in changes else 0, 3 if "drift" in changes else 0)
    again = gain_record.from_bytes(data)
    assert (again.waves, again.drifts) == (data[14], data[15])


def test_optimal_finds_the_errors_themselves():
    declared = dataclasses.replace(STAND, noise=1e-6, angle=0.0, encoder=1e-3, drift=1e-3)
    numbers, drifts = np.array([1e-3, -5e-4, 7e-4, 9e-4]), np.array([1e-3, -2e-3, 5e-4])
    delta = numbers @ encoder_waves(PAPER)
    means = model.Geometry(PAPER).outputs(NOMINAL_K, U0, delta=delta)
    means = means + drifts * (np.arange(18)[:, None] / 17 - 0.5)
    table = optimal_table(PAPER, NOMINAL_K, declared)
    record = GainRecord(core.CoreSchedule(PAPER), optimal_run.to_bytes(optimal_run.record_of(table, PAPER)))
    by_gains = stand_gains_of(record) @ means.ravel()
    assert by_gains[-3:] == pytest.approx(drifts, abs=2e-5)
    assert by_gains[6:8] == pytest.approx(numbers[2:], abs=2e-4)


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares", "optimal"])
def test_stated_uncertainties_hold_by_simulation(estimator):
    """Errors and stated u of 4000 runs on the exact geometry: their ratio is 1 within 5 standard errors of a spread."""
    rng, runs = np.random.default_rng(915), 4000
    declared = dataclasses.replace(BOTH, encoder=3e-4, drift=2e-3)
    errors = sources(PAPER, NOMINAL_K, declared, LONE)
    draws = rng.standard_normal((runs, sum(len(source.sigma) for source in errors.values())))
    means, schedule = exact_outputs(PAPER, NOMINAL_K, U0, errors, draws), core.CoreSchedule(PAPER)
    if estimator == "optimal":
        table = optimal_table(PAPER, NOMINAL_K, declared)
        record = GainRecord(schedule, optimal_run.to_bytes(optimal_run.record_of(table, PAPER)))
        found, u = optimal_runs(record, means)[0], table.u
    else:
        found = estimate_runs(schedule, means, estimator)
        u = np.concatenate([one.ravel() for one in uncertainties(schedule, NOMINAL_K, declared, LONE, estimator)])
    scores = (found - np.concatenate([NOMINAL_K.ravel(), U0])) / u
    assert scores.std(axis=0) == pytest.approx(np.ones(12), abs=5 / np.sqrt(2 * runs))
    rows = gains_of(PAPER, estimator, NOMINAL_K, declared)
    without = dataclasses.replace(declared, encoder=0.0, drift=0.0)
    if estimator == "optimal":
        rows = gains_of(PAPER, estimator, NOMINAL_K, without)
    plain = standard_deviations(PAPER, rows, NOMINAL_K, without, 3e-4 / 50**0.5)
    assert (u / plain).max() > 1.2  # else it would prove nothing


def test_the_whole_model_agrees_with_its_witness_on_any_run():
    rng = np.random.default_rng(916)
    for _ in range(20):
        schedule, (k, _) = usable_schedule(rng), random_block(rng)
        declared = random_stand(rng)
        means = drawn(rng, schedule.data, k, declared)
        variance = np.full(len(schedule), declared.sigma("noise") ** 2 / 5)
        measured = np.ones(len(schedule), dtype=bool)
        found = chi_squared(schedule, means, measured, variance, declared)
        compare_fit(found, WholeModel(schedule.data, means, variance, declared))


def test_runs_that_drift_and_turn_as_declared_fit():
    """Chi-squared of 400 such runs, by the core, has the mean and the spread of its law; undeclared they misfit."""
    rng, runs, schedule = np.random.default_rng(917), 400, core.CoreSchedule(PAPER)
    declared = dataclasses.replace(BOTH, encoder=3e-4, drift=2e-3)
    variance, measured = np.full(18, declared.noise**2 / 50), np.ones(18, dtype=bool)
    squares, undeclared = [], []
    for _ in range(runs):
        means = drawn(rng, PAPER, NOMINAL_K, declared)
        square, freedom = chi_squared(schedule, means, measured, variance, declared)
        squares.append(square)
        undeclared.append(chi_squared(schedule, means, measured, variance, STAND)[0])
        assert freedom == 42
    assert np.mean(squares) == pytest.approx(42, abs=5 * np.sqrt(84 / runs))
    assert np.std(squares) == pytest.approx(np.sqrt(84), rel=0.2)
    assert np.mean(undeclared) > 420


@pytest.mark.parametrize("key", ["encoder_rad", "drift_v"])
@pytest.mark.parametrize("value", ["-1e-4", "2e9", "true"])
def test_a_size_that_is_none_is_refused(key, value, tmp_path, refused):
    message = refused("solve", EXAMPLES / "paper_stand.csv", "--stand", with_keys(tmp_path, **{key: value}))
    assert key in message


RUN = (EXAMPLES / "paper_stand.csv", "--unit", "V", "--json")


def solved(tumble, stand, *more):
    return json.loads(tumble("solve", *RUN, "--stand", stand, *more).stdout)


@pytest.mark.parametrize("estimator", ["refined", "optimal"])
def test_zero_leaves_every_number_as_it_is(estimator, tmp_path, tumble):
    zero = solved(tumble, with_keys(tmp_path, encoder_rad=0.0, drift_v=0), "--estimator", estimator)
    absent = solved(tumble, EXAMPLES / "paper_stand.toml", "--estimator", estimator)
    for result in (zero, absent):
        result.pop("created")
    assert zero == absent


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares", "optimal"])
def test_a_solve_confirmed_by_numpy_states_more(estimator, tmp_path, tumble):
    declared = solved(tumble, with_keys(tmp_path, encoder_rad=3e-4, drift_v=2e-3), "--estimator", estimator)
    absent = solved(tumble, EXAMPLES / "paper_stand.toml", "--estimator", estimator)
    assert (np.array(declared["u_K"]) > np.array(absent["u_K"])).all()
    assert (np.array(declared["u_U0"]) > np.array(absent["u_U0"])).all()
    assert declared["fit"]["chi2"] < absent["fit"]["chi2"]


def test_drift_is_in_volts_whatever_the_unit_of_the_run(tmp_path, tumble):
    """A run in mV with the same stand has the same relative uncertainties."""
    lines = (EXAMPLES / "paper_stand.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines[1:]]
    columns = [lines[0].split(",").index(name) for name in ("ux", "uy", "uz")]
    for row in rows:
        for column in columns:
            row[column] = repr(float(row[column]) * 1e3)
    path = tmp_path / "millivolts.csv"
    path.write_text("\n".join([lines[0], *(",".join(row) for row in rows)]) + "\n")
    stand = with_keys(tmp_path, drift_v=2e-3)
    milli = json.loads(tumble("solve", path, "--unit", "mV", "--stand", stand, "--json").stdout)
    assert np.array(milli["u_U0"]) == pytest.approx(1e3 * np.array(solved(tumble, stand)["u_U0"]), rel=1e-9)
    assert milli["fit"]["chi2"] == pytest.approx(solved(tumble, stand)["fit"]["chi2"], rel=1e-6)


@pytest.mark.parametrize("estimator", ["refined", "least_squares", "optimal"])
def test_a_budget_has_a_column_for_each(estimator, tmp_path, tumble):
    stand = with_keys(tmp_path, encoder_rad=1e-4, drift_v=5e-4)
    plan = valid(tumble("plan", "budget", "--stand", stand, "--estimator", estimator, "--json").stdout, "plan")
    assert list(plan["sources"])[5:-1] == ["encoder_rad", "drift_v"]
    rows = gains_of(PAPER, estimator, NOMINAL_K, BOTH)
    parts = dataclasses.replace(BOTH, drift=0.0), dataclasses.replace(BOTH, encoder=0.0)
    of_k = np.abs(np.concatenate([NOMINAL_K.ravel(), np.diag(NOMINAL_K)]))
    squares = [np.diag(rows @ by_hand(PAPER, NOMINAL_K, one) @ rows.T) for one in parts]
    expected = np.sqrt(np.maximum(squares, 0.0)) / of_k
    found = np.array(list(plan["terms"].values()))[:, 5:]
    assert found == pytest.approx(expected.T, rel=1e-5, abs=1e-10)
    assert "V, mean" in tumble("plan", "budget", "--stand", stand).stdout


@pytest.mark.toolchain
@pytest.mark.parametrize("estimator", ["refined", "optimal"])
def test_requirements_name_both(estimator, tmp_path, tumble):
    stand = with_keys(tmp_path, encoder_rad=1e-4, drift_v=5e-4)
    plan = valid(tumble("plan", "require", "--stand", stand, "--estimator", estimator, "--json").stdout, "plan")
    assert (plan["declared"]["encoder_rad"], plan["declared"]["drift_v"]) == (1e-4, 5e-4)
    assert {"encoder", "drift"} <= set(plan["set_by"]) == set(plan["split"])
    if estimator == "refined":
        row = plan["rows"][plan["set_by"]["encoder"]]
        column = list(plan["split"]).index("encoder")
        assert row["weights"][column] * plan["encoder_rad"] == pytest.approx(row["shares"][column])
        assert (plan["set_by"]["drift"], plan["drift_v"]) == (None, None)  # it moves cross terms alone


@pytest.mark.parametrize("estimator", ["refined", "optimal"])
def test_simulated_runs_of_a_plan_drift_and_turn(estimator, tmp_path, tumble):
    """They spread as planned: by the law of a spread within 5 standard errors."""
    stand = with_keys(tmp_path, encoder_rad=3e-4, drift_v=2e-3)
    command = ("plan", "validate", "--stand", stand, "--estimator", estimator, "--runs", "4000", "--json")
    done = tumble(*command)
    assert done.returncode == 0, done.stderr
    valid(done.stdout, "plan")


def test_a_schedule_is_planned_for_both(tmp_path, tumble):
    stand = with_keys(tmp_path, encoder_rad=1e-5, drift_v=1e-4)
    done = tumble("plan", "schedule", "--stand", stand, "--norm", "1e-4", "--mountings", "2", "--json")
    assert done.returncode == 0, done.stderr
    assert valid(done.stdout, "plan")["u_norm_g"]["worst_g"] <= 1e-4


def test_the_bench_draws_both_and_tells_them(tmp_path, tumble):
    """On the exact geometry: what it told of the stand gives the means again, to their noise; and it passes."""
    stand = with_keys(tmp_path, encoder_rad=1e-3, drift_v=2e-3)
    done = tumble("bench", "--stand", stand, "--seed", "3", "--out", tmp_path / "run", "--json")
    result = valid(done.stdout)
    truth = result["truth"]
    waves = encoder_waves(PAPER)
    outputs = model.Geometry(PAPER).outputs(
        np.array(truth["K"]),
        np.array(truth["U0"]),
        alpha1=truth["alpha1_rad"],
        alpha2=truth["alpha2_rad"],
        alpha3=np.array(truth["alpha3_rad"]),
        delta=np.array(truth["alpha4_rad"]) + np.array(truth["encoder_rad"]) @ waves,
    )
    outputs = outputs + np.array(truth["drift_v"]) * (np.arange(18)[:, None] / 17 - 0.5)
    means = np.array([mean["mean"] for mean in result["means"]])
    assert np.abs(means - outputs).max() < 5 * 3e-4 / 50**0.5 + 2 * 1e-3 * 2e-4
    assert result["fit"]["fits"]
    plain = json.loads(tumble("bench", "--seed", "3", "--out", tmp_path / "plain", "--json").stdout)
    assert not {"encoder_rad", "drift_v"} & set(plain["truth"])


@pytest.mark.parametrize(("changes", "is_shared"), [({"encoder": 1e-3}, True), ({"drift": 1e-2}, False)])
def test_all_runs_share_the_encoder_and_none_the_drift(changes, is_shared):
    means = drawn(np.random.default_rng(1), PAPER, NOMINAL_K, STAND)
    run = Run(np.full(18, 50), means, np.full((18, 3), 3e-4), "V", {})
    parts = {}
    for declared in (STAND, dataclasses.replace(STAND, **changes)):
        parts[declared] = covariances(solve(run, None, "refined", 1.0, declared, "run.csv"), True)
    (own, shared), (more_own, more_shared) = parts.values()
    assert bool(np.trace(more_shared) > 2 * np.trace(shared)) == is_shared
    assert bool(np.trace(more_own) > 2 * np.trace(own)) != is_shared


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
def test_a_drift_that_is_solved_for_is_none_beside(estimator, tmp_path, tumble):
    """With --model drift it is an unknown: what is declared of it changes nothing."""
    told = ("--estimator", estimator, "--model", "drift")
    declared, absent = (
        solved(tumble, stand, *told) for stand in (with_keys(tmp_path, drift_v=2e-3), EXAMPLES / "paper_stand.toml")
    )
    assert declared["u_U0"] == absent["u_U0"] and declared["fit"] == absent["fit"]


@pytest.mark.parametrize("name", ["paper", "angle", "lab", "diagonal", "three_mountings"])
def test_a_drift_that_is_too_large_for_weights_is_refused(name, tumble, tmp_path):
    """Up to the limit core and witness agree; beyond some 5e12 they did not, and the exit code was 3."""
    run, schedule = EXAMPLES / f"{name}_stand.csv", name if name in ("diagonal", "three_mountings") else "paper"
    text = (EXAMPLES / f"{name}_stand.toml").read_text()
    noise, samples = (float(re.search(rf"^{key} = (\S+)", text, re.MULTILINE)[1]) for key in ("noise_v", "samples"))
    for factor in (1e-3, 0.9, 1.1, 100.0):
        drift = factor * 1e12 * noise / samples**0.5
        declared = tmp_path / "stand.toml"
        declared.write_text(text.replace("[stand]", f"[stand]\ndrift_v = {min(drift, 1e9)!r}"))
        done = tumble("solve", run, "--schedule", schedule, "--stand", declared, "--estimator", "optimal")
        if factor < 1.0:
            assert done.returncode in (0, 1), done.stderr
            continue
        assert (done.returncode, done.stdout) == (2, "")
        ratio = rf"{min(drift, 1e9) * samples**0.5 / noise:.2g}"
        said = f"tumble: no optimal weights: drift_v is {ratio} times the noise of a mean, above 1e+12\n"
        assert done.stderr == said
