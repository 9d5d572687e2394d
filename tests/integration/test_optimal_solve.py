"""`--estimator optimal`: a run weighed by its stand, confirmed by the witness, with the uncertainties it deserves."""

import dataclasses
import json

import core_functions
import numpy as np
import pytest
from blocks import NOMINAL_K, random_means, write_run
from conftest import EXAMPLES
from documents import paper_stand

from tumble import core, model
from tumble.cli.main import main
from tumble.model import Geometry
from tumble.model.optimal import optimal_table
from tumble.solving import optimal_run, solution
from tumble.stand import COMMON, PAPER_STAND

PAPER = core.CoreSchedule(model.built_in("paper"))
LONE, ALL = np.ones(18, dtype=int), np.ones(18, dtype=bool)
U0 = np.array([0.01, -0.02, 0.03])


def solve(tumble, *arguments, cwd=EXAMPLES):
    unit = [] if "--unit" in arguments else ["--unit", "V"]
    done = tumble("solve", *arguments, *unit, "--estimator", "optimal", "--json", cwd=cwd)
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout), done.stderr


@pytest.mark.parametrize("name", ["paper_stand", "angle_stand", "lab_stand"])
def test_the_examples_come_out_nearer_than_refined_claims(name, tumble):
    result, warnings = solve(tumble, f"{name}.csv", "--stand", f"{name}.toml")
    refined = json.loads(tumble("solve", f"{name}.csv", "--stand", f"{name}.toml", "--json", cwd=EXAMPLES).stdout)
    truth = json.loads((EXAMPLES / f"{name}.truth.json").read_text())
    assert warnings == "" and result["estimator"] == "optimal"
    assert (np.array(result["u_K"]) < np.array(refined["u_K"])).all()
    assert (np.array(result["u_U0"]) < np.array(refined["u_U0"])).all()
    for key in ("K", "U0"):
        scores = (np.array(result[key]) - np.array(truth[key])) / np.array(result[f"u_{key}"])
        assert np.abs(scores).max() < 4
    assert 0.5 < result["misfit"] < 1.5 and refined["misfit"] == result["misfit"]
    assert not result["second_order"]["matters"]


def test_it_needs_a_stand(refused):
    error = refused("solve", EXAMPLES / "paper_stand.csv", "--estimator", "optimal")
    assert error == "tumble: --estimator optimal weighs the means by the stand's errors: it needs --stand FILE\n"


def test_check_positions_and_positions_left_out(tumble, tmp_path):
    checks, _ = solve(tumble, "with_checks.csv", "--schedule", "with_checks.toml", "--stand", "paper_stand.toml")
    assert checks["verification"]["max_abs_delta_g_check_g"] is not None
    rows = (EXAMPLES / "paper_stand.csv").read_text().splitlines()
    kept = [row for row in rows if not row.startswith(("1,4,", "2,9,"))]
    (tmp_path / "run.csv").write_text("\n".join(kept) + "\n")
    whole, _ = solve(tumble, "paper_stand.csv", "--stand", "paper_stand.toml")
    fewer, _ = solve(tumble, tmp_path / "run.csv", "--stand", "paper_stand.toml")
    assert (np.array(fewer["u_K"]) > np.array(whole["u_K"])).all()


def test_the_unit_of_the_outputs_does_not_matter(tumble, tmp_path):
    volts, _ = solve(tumble, "paper_stand.csv", "--stand", "paper_stand.toml")
    header, *rows = (EXAMPLES / "paper_stand.csv").read_text().splitlines()
    table = np.array([row.split(",") for row in rows], dtype=float) * [1, 1, 1e3, 1e3, 1e3]
    lines = [f"{int(m)},{int(p)}," + ",".join(f"{u:.17g}" for u in outputs) for m, p, *outputs in table]
    (tmp_path / "run.csv").write_text("\n".join([header, *lines]) + "\n")
    millivolts, _ = solve(tumble, tmp_path / "run.csv", "--unit", "mV", "--stand", "paper_stand.toml")
    assert np.array(millivolts["K"]) == pytest.approx(1e3 * np.array(volts["K"]), rel=1e-9, abs=1e-7)
    assert np.array(millivolts["u_K"]) == pytest.approx(1e3 * np.array(volts["u_K"]), rel=1e-9)


def test_six_faces_gain_too(tumble):
    result, _ = solve(tumble, "six_faces.csv", "--schedule", "six_faces.toml", "--stand", "paper_stand.toml")
    assert result["verification"]["pass"]


@pytest.mark.parametrize("noise", ["0.0", "1e-7"])
def test_a_run_that_contradicts_its_stand_is_refused(noise, refused, tmp_path):
    paper_stand(tmp_path, noise_v=noise)
    error = refused("solve", EXAMPLES / "paper_stand.csv", "--stand", tmp_path / "stand.toml", "--estimator", "optimal")
    assert "times what the stand declares: no optimal weights for it" in error


def test_a_run_that_fits_its_stand_badly_is_warned_of(tumble, tmp_path):
    paper_stand(tmp_path, noise_v="3e-5")
    result, warnings = solve(tumble, "paper_stand.csv", "--stand", tmp_path / "stand.toml")
    assert result["misfit"] > 2 and "the run does not fit the stand file: noise 3.0e-04 V" in warnings
    assert "noise above the declared 3.0e-05 V: 2.9e-04 V in ux" in warnings and warnings.count("\n") == 2


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares"])
def test_a_large_yaw_is_flagged_but_not_for_optimal(estimator, tumble, tmp_path):
    paper_stand(tmp_path, remount_rad="15e-3")
    arguments = ["solve", EXAMPLES / "paper_stand.csv", "--stand", tmp_path / "stand.toml", "--json", "--unit", "V"]
    done = tumble(*arguments, "--estimator", estimator)
    second_order = json.loads(done.stdout)["second_order"]
    assert second_order["matters"] and second_order["bias_K_xx_relative"] == pytest.approx(15e-3**2 / 2)
    assert [(shift["source"], shift["coefficient"]) for shift in second_order["shifts"]] == [("alpha3", "K_xx")]
    complaint = "tumble: warning: large yaw: second order shifts K_xx by 0.00011, more than 0.2 u(K_xx)/K_xx = "
    assert done.stderr.startswith(complaint) and done.stderr.count("\n") == 1
    taken_out = tumble(*arguments, "--estimator", "optimal")
    assert taken_out.stderr == "" and not json.loads(taken_out.stdout)["second_order"]["matters"]


def test_an_impossible_stand_error_is_bad_input(refused, tmp_path):
    """A block that was mounted a third of a radian off, on a stand that would allow it."""
    paper_stand(tmp_path, remount_rad="0.5")
    means = Geometry(PAPER.data).outputs(NOMINAL_K, U0, alpha3=[0.3, -0.3])
    run = write_run(tmp_path / "run.csv", PAPER.data, means)
    error = refused("solve", run, "--stand", tmp_path / "stand.toml", "--estimator", "optimal")
    assert "an error of the stand came out larger than any stand can have" in error


@pytest.mark.parametrize(("excess", "code"), [(0.5, 0), (2.0, 3)])
def test_the_witness_must_confirm_within_a_millionth_of_u(excess, code, monkeypatch, capsys):
    sound = core.optimal_runs

    def spoilt(*arguments):
        found, stand = sound(*arguments)
        return found + excess * 1e-6 * 2.12e-5 * np.eye(12)[4], stand

    monkeypatch.setattr(optimal_run, "optimal_runs", spoilt)
    stand = str(EXAMPLES / "paper_stand.toml")
    arguments = ["solve", str(EXAMPLES / "paper_stand.csv"), "--stand", stand, "--estimator", "optimal", "--json"]
    assert main(arguments) == code
    captured = capsys.readouterr()
    assert (captured.out == "") == (code == 3)
    assert ("the C core and numpy disagree: K differs by" in captured.err) == (code == 3)


def test_a_witness_that_is_no_number_confirms_nothing(monkeypatch, capsys):
    sound = solution.optimal_estimate
    monkeypatch.setattr(solution, "optimal_estimate", lambda *a: dataclasses.replace(sound(*a), u0=np.full(3, np.nan)))
    stand = str(EXAMPLES / "paper_stand.toml")
    assert main(["solve", str(EXAMPLES / "paper_stand.csv"), "--stand", stand, "--estimator", "optimal"]) == 3
    assert "U0 differs by nan" in capsys.readouterr().err


def test_weights_of_the_wrong_schedule_are_refused():
    table = optimal_table(PAPER.data, NOMINAL_K, PAPER_STAND)
    turned = dataclasses.replace(PAPER.data.positions[3], angle_deg=136.0)
    other = dataclasses.replace(
        PAPER.data, positions=(*PAPER.data.positions[:3], turned, *PAPER.data.positions[4:])
    )
    record = optimal_run.to_bytes(optimal_run.record_of(table, other))
    with pytest.raises(core.CoreRefusal) as refusal:
        core_functions.optimal(record, PAPER, np.zeros((18, 3)))
    assert refusal.value.name == "TUMBLE_E_GAIN_TABLE"


def test_samples_that_differ_between_positions():
    """Weights take an average of 1/N; the uncertainties know every N."""
    rng, samples = np.random.default_rng(81), np.random.default_rng(82).integers(2, 200, 18)
    means = random_means(rng, PAPER.data, NOMINAL_K, U0, 1e-5, 1e-5)
    weighting = optimal_run.Weighting(PAPER_STAND, samples)
    found = core_functions.estimate_optimal(PAPER, means, ALL, weighting)
    witness = model.optimal_estimate(PAPER.data, means, PAPER_STAND, samples)
    assert np.abs((found.k - witness.k) / witness.u_k).max() < 1e-6
    equal = model.optimal_estimate(
        PAPER.data, means, dataclasses.replace(PAPER_STAND, samples=1), LONE, known_k=witness.k
    )
    assert (witness.u_k < equal.u_k).all()


def test_a_table_made_before_the_run_is_witnessed_as_it_was_made():
    """For the nominal K and 50 samples each, whatever the run then has."""
    rng, samples = np.random.default_rng(83), np.random.default_rng(84).integers(2, 50, 18)
    k = NOMINAL_K * np.where(np.eye(3), 1.01, -0.7)
    means = random_means(rng, PAPER.data, k, U0, 1e-4, 1e-5)
    known = optimal_run.Known(NOMINAL_K, 50)
    found = core_functions.estimate_optimal(PAPER, means, ALL, optimal_run.Weighting(PAPER_STAND, samples, 0.0, known))
    witness = model.optimal_estimate(PAPER.data, means, PAPER_STAND, samples, 0.0, known.k, known.samples)
    assert np.abs((found.k - witness.k) / witness.u_k).max() < 1e-6
    other = model.optimal_estimate(PAPER.data, means, PAPER_STAND, samples)
    assert 1e-4 < np.abs((other.k - witness.k) / witness.u_k).max() < 1.0


def errors_over_u(stand, alpha3, alpha1=0.0, alpha2=0.0):
    """Of the optimal estimate and of its linear part, on outputs without noise."""
    means = Geometry(PAPER.data).outputs(NOMINAL_K, U0, alpha1=alpha1, alpha2=alpha2, alpha3=alpha3)
    weighting = optimal_run.Weighting(stand, LONE)
    table = optimal_run.make_table(PAPER, means, ALL, weighting)
    found, truth = core_functions.apply_table(table, PAPER, means), np.concatenate([NOMINAL_K.ravel(), U0])
    linear = table.gains @ means.ravel() - truth
    return (np.concatenate([found.k.ravel(), found.u0]) - truth) / table.u, linear / table.u


@pytest.mark.parametrize("remounting", ["independent", "common"])
def test_second_order_is_taken_out(remounting):
    """A yaw of 15 mrad in both mountings takes alpha3^2/2 off K_xx: thirteen times u, and nothing once corrected."""
    stand = dataclasses.replace(PAPER_STAND, remount=15e-3, remounting=remounting)
    yaw = 15e-3 if remounting == COMMON else np.array([15e-3, 15e-3])
    corrected, linear = errors_over_u(stand, yaw)
    assert -14.0 < linear[0] < -12.0
    assert abs(corrected[0]) < 0.02


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares", "optimal"])
def test_a_coarse_converter_is_noise_that_no_averaging_helps(estimator, tumble, tmp_path):
    """Samples that scatter by less than half its step round alike: a step over root 12 counts for every mean."""
    step, u = 20.0 / 2**12, []
    for block, noise in (("converter_bits = 12\nrange_v = 10.0\n", 1e-6), ("", step * (50 / 12) ** 0.5)):
        paper_stand(tmp_path, block=block, noise_v=repr(noise))
        arguments = (EXAMPLES / "paper_stand.csv", "--stand", tmp_path / "stand.toml", "--estimator", estimator)
        u.append(json.loads(tumble("solve", *arguments, "--json").stdout))
    assert "undithered" in u[0]["assumes"] and u[0]["noise"]["undithered"] == ["ux", "uy", "uz"]
    if estimator != "optimal":  # whose weights are those of the declared noise
        np.testing.assert_allclose(u[0]["u_K"], u[1]["u_K"], rtol=1e-6)
        np.testing.assert_allclose(u[0]["u_U0"], u[1]["u_U0"], rtol=1e-6)
    assert (np.array(u[0]["u_K"]) >= np.array(u[1]["u_K"]) * (1 - 1e-6)).all()


def test_a_large_tilt_is_flagged_for_linear_estimators_alone(tumble, tmp_path):
    paper_stand(tmp_path, axis_tilt_rad="15e-3")
    arguments = (EXAMPLES / "paper_stand.csv", "--stand", tmp_path / "stand.toml")
    done = tumble("solve", *arguments, "--unit", "V", "--json")
    assert {shift["source"] for shift in json.loads(done.stdout)["second_order"]["shifts"]} == {"alpha1"}
    assert done.stderr.startswith("tumble: warning: large axis tilt: second order shifts K_")
    assert done.stderr.count("\n") == 1
    assert solve(tumble, *arguments)[0]["second_order"]["shifts"] == []
