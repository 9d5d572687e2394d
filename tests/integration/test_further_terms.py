"""`tumble solve --model`: K2, K3 and drift beside the twelve coefficients, what they cost, and what is refused."""

import json

import numpy as np
import pytest
from blocks import NOMINAL_K, random_block, random_errors, usable_schedule, write_run
from conftest import EXAMPLES
from core_chi_squared import compare_fit, least_chi_squared
from documents import schema
from jsonschema import validate
from test_crosscheck import plant

from tumble import core
from tumble.cli.main import main
from tumble.files.stand_file import read_stand
from tumble.model import Geometry, Propagation, WholeModel, gravity_errors, optimal_estimate
from tumble.model.coefficients import linear_outputs, worst_norm
from tumble.model.estimators import columns_at, confused, unknowns
from tumble.schedule import Position, Schedule
from tumble.solving import computation, uncertainty
from tumble.solving.computation import estimator_for
from tumble.terms import names

pytestmark = pytest.mark.python
PAPER = core.built_in("paper")
ALL = ("k2", "k3", "drift")
U0 = np.array([0.02, -0.01, 0.03])
VALUES = np.array([[1.0, -1.0, 0.7], [-0.8, 1.0, 1.0], [1.0, 0.9, -1.0]]) * 1e-4  # K2 in 1/g, K3 in 1/g^2, drift in g


def stand_named(name):
    return read_stand(str(EXAMPLES / f"{name}_stand.toml")).stand


def outputs_of(force, k, u0, values):
    """Outputs (..., positions, 3) of a block that has K2, K3 and a drift, in g."""
    time = np.linspace(-0.5, 0.5, force.shape[-2])[:, None]
    scale = np.diag(k)
    return force @ k.T + u0 + scale * (values[0] * force**2 + values[1] * force**3 + values[2] * time)


def perfect(schedule, values=VALUES, k=NOMINAL_K):
    return outputs_of(Geometry(schedule).force(), k, U0, values)


def solved(capsys, run, *options):
    """Exit code, document (None for none) and stderr of `tumble solve --json` in this process."""
    code = main(["solve", str(run), "--json", *map(str, options)])
    captured = capsys.readouterr()
    return code, json.loads(captured.out) if captured.out else None, captured.err


WORST_UG = {  # by an independent program; of K and U0 alone
    ("paper", ()): 14.6,
    ("paper", ("k2",)): 20.6,
    ("paper", ("k2", "drift")): 21.0,
    ("paper", ("k2", "k3")): 48.5,
    ("three_mountings", ()): 12.5,
    ("three_mountings", ("k2",)): 17.0,
    ("three_mountings", ("k2", "drift")): 17.2,
    ("three_mountings", ("k2", "k3")): 32.8,
}


@pytest.mark.parametrize(("name", "terms"), WORST_UG)
def test_what_further_terms_cost(name, terms):
    schedule, stand = core.built_in(name), stand_named("paper")
    samples = np.full(len(schedule.positions), 50)
    found = optimal_estimate(schedule, perfect(schedule, 0 * VALUES), stand, samples, terms=terms)
    alone = worst_norm(NOMINAL_K, found.covariance[:12, :12]).worst_g * 1e6
    applied = worst_norm(NOMINAL_K, found.covariance, terms).worst_g * 1e6
    u = np.round(found.u_sizes / 2e-6, 1).tolist()
    print(f"{name} {terms}: {alone:.2f} ug, applied {applied:.2f}; u(U0) {found.u_u0 / 2e-6}, of the terms {u}")
    assert alone == pytest.approx(WORST_UG[name, terms], rel=0.01)
    if terms == ("k2",):
        assert found.u_sizes.max() / 2e-6 == pytest.approx(20.0 if name == "paper" else 14.5, rel=0.02)
        assert found.u_u0.max() / 2e-6 == pytest.approx(14.3 if name == "paper" else 9.7, rel=0.01)


def given(schedule, stand, estimator):
    """Of a run with every further term, of 50 samples a position."""
    samples = np.full(len(schedule.positions), 50)
    return Propagation(schedule, NOMINAL_K, stand, samples, estimator, terms=ALL)


@pytest.mark.parametrize("name", ["paper", "three_mountings"])
def test_a_run_without_errors_gives_them_exactly(name):
    schedule = core.built_in(name)
    expected = np.concatenate([NOMINAL_K.ravel(), U0, (VALUES * np.diag(NOMINAL_K)).ravel()])
    for estimator in ("least_squares", "optimal"):
        found = estimator_for(given(schedule, stand_named("paper"), estimator))(perfect(schedule)[None])[0]
        assert np.abs(found - expected).max() < 2e-13


@pytest.mark.parametrize("seed", range(12))
def test_elimination_agrees_with_the_dense_problem(seed):
    rng = np.random.default_rng(seed)
    schedule = usable_schedule(rng)
    terms = [ALL, ("k2",), ("k3", "drift")][seed % 3]
    assert not confused(schedule.data, terms)
    k, u0 = random_block(rng)
    force = Geometry(schedule.data).force(**random_errors(rng, schedule.data, 1e-3))
    means = outputs_of(force, k, u0, VALUES)
    core_found = computation.least_squares(schedule, means[None], terms)[0]
    assert np.abs(core_found - unknowns(schedule.data, means, "least_squares", terms)).max() < 1e-11 * np.abs(k).max()


@pytest.mark.parametrize("seat", [0.0, 1e-4])
@pytest.mark.parametrize("name", ["paper", "three_mountings"])
def test_gains_agree_with_singular_values_for_large_yaws(name, seat):
    rng, schedule = np.random.default_rng(5), core.built_in(name)
    stand = stand_named("paper").with_sigma("remount", 0.02).with_sigma("seat", seat)
    force = Geometry(schedule).force(alpha3=np.full(len(schedule.mountings), 0.02), seat_n=seat)
    means = outputs_of(force, NOMINAL_K, U0, VALUES) + rng.normal(size=force.shape) * 4e-5
    samples = np.full(len(schedule.positions), 50)
    witness = optimal_estimate(schedule, means, stand, samples, known_k=NOMINAL_K, terms=ALL)
    found = estimator_for(given(schedule, stand, "optimal"))(means[None])[0]
    values = np.concatenate([witness.k.ravel(), witness.u0, witness.sizes.ravel()])
    assert (np.abs(found - values) < 1e-6 * np.sqrt(np.diag(witness.covariance))).all()


@pytest.mark.parametrize("size", [1e-4, 1e-2, 0.1])
def test_the_force_is_found_by_newton(size):
    values = VALUES / np.abs(VALUES).max() * size
    means, sizes = perfect(PAPER, values), values * np.diag(NOMINAL_K)
    force = Geometry(PAPER).force()
    linear = linear_outputs(means, NOMINAL_K, U0, sizes, ALL)
    assert linear == pytest.approx(force @ NOMINAL_K.T + U0, abs=1e-13)


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
@pytest.mark.parametrize("name", ["paper", "three_mountings"])
def test_two_standard_uncertainties_hold_the_truth_in_95_percent(name, estimator):
    """2,000 runs on the exact geometry, of blocks whose terms have any sign. What no run shows, the common rotation of
    level and yaw, is drawn too."""
    rng, runs = np.random.default_rng(11), 2000
    schedule, stand = core.built_in(name), stand_named("paper")
    positions, mountings = len(schedule.positions), len(schedule.mountings)
    errors = {
        "alpha1": rng.normal(size=(runs, 1)) * stand.sigma("axis_tilt"),
        "alpha2": rng.normal(size=(runs, 1)) * stand.sigma("level"),
        "alpha3": rng.normal(size=(runs, mountings)) * stand.sigma("remount"),
        "delta": rng.normal(size=(runs, positions)) * stand.sigma("angle"),
    }
    values = 1e-4 * rng.choice([-1.0, 1.0], size=(runs, 3, 1, 3))
    means = outputs_of(Geometry(schedule).force(**errors), NOMINAL_K, U0, np.moveaxis(values, 1, 0))
    means += rng.normal(size=means.shape) * stand.sigma("noise") / np.sqrt(50)
    held = core.CoreSchedule(schedule)
    run = given(schedule, stand, estimator)
    found = estimator_for(run)(means)
    sizes = (values[:, :, 0] * np.diag(NOMINAL_K)).reshape(runs, 9)
    truth = np.column_stack([np.tile(np.concatenate([NOMINAL_K.ravel(), U0]), (runs, 1)), sizes])
    u = uncertainty.standard_uncertainties(run, held, np.ones(positions, dtype=bool))
    z = (found - truth) / u
    coverage = (np.abs(z) < 2.0).mean(axis=0)
    print(f"{name} {estimator}: coverage {coverage.min():.4f} to {coverage.max():.4f}, mean {coverage.mean():.4f}")
    assert np.abs(coverage - 0.9545).max() < 4.0 * np.sqrt(0.9545 * 0.0455 / runs)
    assert np.abs(z.mean(axis=0)).max() < 4.5 / np.sqrt(runs)


def noisy(tmp_path, values=VALUES, schedule=PAPER, seed=3):
    """A run file of a block on the paper's stand."""
    rng, stand = np.random.default_rng(seed), stand_named("paper")
    mountings, positions = len(schedule.mountings), len(schedule.positions)
    yaws, angles = (rng.normal(size=n) * s for n, s in ((mountings, 4e-4), (positions, 4e-5)))
    means = outputs_of(Geometry(schedule).force(alpha3=yaws, delta=angles), NOMINAL_K, U0, values)
    means += rng.normal(size=means.shape) * stand.sigma("noise") / np.sqrt(50)
    return write_run(tmp_path / "run.csv", schedule, means)


STAND = ("--stand", EXAMPLES / "paper_stand.toml")


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
def test_a_run_that_did_not_fit_does(estimator, tmp_path, capsys):
    run = noisy(tmp_path, 3.0 * VALUES)
    options = (*STAND, "--estimator", estimator, "--limit", "1e-3")
    code, plain, _ = solved(capsys, run, *options)
    assert (code, plain["extended"], plain["fit"]["fits"], plain["fit"]["dof"]) == (1, None, False, 42)
    code, result, err = solved(capsys, run, *options, "--model", "drift,k2,k3")
    validate(result, schema("result"))
    assert (code, err) == (0, "") and (result["fit"]["fits"], result["fit"]["dof"]) == (True, 33)
    found = result["extended"]
    assert found["terms"] == list(ALL) and found["names"] == list(names(ALL))
    for key, row, unit in (("k2_per_g", 0, 1.0), ("k3_per_g2", 1, 1.0), ("drift_v", 2, 2.0)):
        error = np.array(found[key]) - 3.0 * VALUES[row] * unit
        assert (np.abs(error) < 4.0 * np.array(found[f"u_{key}"])).all()
    u = np.sqrt(np.diag(found["covariance"]))
    assert u[:12].tolist() == pytest.approx([*np.ravel(result["u_K"]), *result["u_U0"]], rel=1e-6)
    assert u[12:].tolist() == pytest.approx([*found["u_k2_per_g"], *found["u_k3_per_g2"], *found["u_drift_v"]])
    assert (np.array(found["without"]["u_U0"]) < np.array(result["u_U0"])).all()
    assert result["stand_seen"]["alpha1_rad"] is None and result["stand_seen"]["alpha4_rad"] is None


def test_what_is_in_the_model_explains_nothing(tmp_path, capsys):
    run = noisy(tmp_path, 5.0 * VALUES)
    _, result, _ = solved(capsys, run, *STAND, "--estimator", "optimal", "--model", "k2,drift")
    named = {name for explanation in result["fit"]["explanations"] for name in explanation["patterns"]}
    assert result["fit"]["dof"] == 36 and not result["fit"]["fits"]
    assert "k3" in named and not named & {"k2", "drift"}


def test_without_a_stand_there_are_values_alone(tmp_path, capsys):
    run = write_run(tmp_path / "run.csv", PAPER, perfect(PAPER))
    code, result, _ = solved(capsys, run, "--estimator", "least_squares", "--model", "k2")
    validate(result, schema("result"))
    found = result["extended"]
    assert (code, found["u_k2_per_g"], found["covariance"], found["without"]) == (0, None, None, None)
    assert found["k3_per_g2"] is None


def test_the_text_says_what_they_cost(tmp_path, capsys):
    run = noisy(tmp_path)
    assert main(["solve", str(run), *map(str, STAND), "--estimator", "optimal", "--model", "k2,k3,drift"]) == 0
    text = capsys.readouterr().out
    assert "estimator optimal with k2, k3, drift" in text and "\nK2_x " in text and "\ndrift_z " in text
    loss = "Because of k2, k3 and drift: u(K_yy) 10.6 -> 46.7 ppm, u(U0_x) 6.67 -> 14.4 ug,"
    assert f"{loss} worst u(|a|) 14.6 -> 23.3 ug" in text.replace("\n", " ").replace("u(K_zz)", "u(K_yy)")
    assert max(map(len, text.splitlines())) <= 80


def test_check_positions_and_a_seed(tmp_path, capsys):
    """A drift counts at check positions too, and simulated runs have the further unknowns."""
    places = [Position(p.mounting, p.number, p.angle_deg, "check" if p.number == 9 else "fit") for p in PAPER.positions]
    schedule = Schedule(PAPER.mountings, tuple(places))
    assert (Geometry(schedule).force() == Geometry(PAPER).force()).all()
    means = perfect(schedule)
    found = computation.least_squares(core.CoreSchedule(schedule), means[None], ALL)[0]
    linear = linear_outputs(means, found[:9].reshape(3, 3), found[9:12], found[12:].reshape(3, 3), ALL)
    assert np.abs(gravity_errors(linear, found[:9].reshape(3, 3), found[9:12])).max() < 1e-13
    options = (*STAND, "--estimator", "least_squares", "--model", "k2,drift", "--monte-carlo", 2000, "--limit", 1e-3)
    code, result, _ = solved(capsys, noisy(tmp_path, VALUES * [[1], [0], [1]]), *options)
    assert code == 0 and result["monte_carlo"]["agrees"] is not False


REFUSALS = {
    "closed form": (["--model", "k2"], "--model: refined is a closed form of twelve coefficients"),
    "averaged": (["--model", "k2", "--estimator", "averaged"], "use --estimator least_squares, or optimal with"),
    "unknown": (["--model", "k4", "--estimator", "least_squares"], "'k4' is not one of k2, k3, asymmetry, cross"),
    "twice": (["--model", "k2,k2", "--estimator", "least_squares"], "--model: 'k2' is not one of"),
    "none": (["--model", "", "--estimator", "least_squares"], "--model: '' is not one of"),
}


@pytest.mark.parametrize("case", REFUSALS)
def test_options_that_are_refused(case, tmp_path, capsys):
    options, message = REFUSALS[case]
    code, result, err = solved(capsys, write_run(tmp_path / "run.csv", PAPER, perfect(PAPER)), *options)
    assert (code, result) == (2, None) and message in err and err.count("\n") == 1


@pytest.mark.parametrize(("name", "terms"), [("diagonal", "k3"), ("six_faces", "k2,k3"), ("six_faces", "k3,drift")])
@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
def test_a_schedule_that_does_not_tell(name, terms, estimator, tmp_path, capsys):
    """Where the force along an axis takes one size alone, its cube is its multiple; as a prior of the angles tells
    nothing of that, it is refused for both estimators."""
    schedule = core.built_in(name)
    run = write_run(tmp_path / "run.csv", schedule, perfect(schedule, 0 * VALUES))
    options = ("--schedule", name, *STAND, "--estimator", estimator, "--model", terms)
    code, result, err = solved(capsys, run, *options)
    told = "these positions cannot tell apart K3_x and K_xx, nor K3_y and K_yy, nor K3_z and K_zz"
    assert (code, result, err.count("\n")) == (2, None, 1) and told in err


@pytest.mark.parametrize(("off_deg", "told"), [(0.0, False), (0.02, False), (0.5, True)])
def test_a_schedule_that_hardly_tells(off_deg, told):
    """Four angles a mounting near the diagonals."""
    schedule = core.built_in("diagonal")
    places = [Position(p.mounting, p.number, p.angle_deg + off_deg) for p in schedule.positions]
    assert (not confused(Schedule(schedule.mountings, tuple(places)), ("k3",))) == told


def test_too_few_positions(tmp_path, capsys):
    """Five determine the twelve, and no two further terms. Rows of the others are left out of the run."""
    run = write_run(tmp_path / "run.csv", PAPER, perfect(PAPER, 0 * VALUES))
    kept = ("mou", "1,1,", "1,3,", "1,6,", "2,3,", "2,6,")
    run.write_text("".join(line for line in run.read_text().splitlines(True) if line.startswith(kept)))
    assert solved(capsys, run, "--estimator", "least_squares")[0] == 0
    code, result, err = solved(capsys, run, "--estimator", "least_squares", "--model", "k2,drift")
    assert (code, result) == (2, None) and "these positions cannot tell apart K2_x, drift_x" in err


def test_an_order_so_high_that_nothing_tells_the_force(tmp_path, capsys):
    means = perfect(PAPER, VALUES * [[6e3], [0.0], [0.0]])
    code, _, err = solved(capsys, write_run(tmp_path / "run.csv", PAPER, means), "--estimator", "least_squares",
                          "--model", "k2")
    assert code == 2 and "the outputs do not tell the acceleration" in err


def test_channels_that_are_exchanged(tmp_path, capsys):
    run = write_run(tmp_path / "run.csv", PAPER, perfect(PAPER)[:, [1, 0, 2]])
    assert solved(capsys, run, "--estimator", "least_squares", "--model", "drift")[0] == 0
    code, result, err = solved(capsys, run, "--estimator", "least_squares", "--model", "k3")
    assert (code, result) == (2, None) and "a channel does not measure along its own axis" in err


def test_outputs_in_millivolts_and_of_any_sign(tmp_path, capsys):
    """Values are those in volts; K2 and K3 have no sign of K."""
    run = write_run(tmp_path / "run.csv", PAPER, -1e3 * perfect(PAPER))
    run.write_text(run.read_text().replace(" [V]", ""))
    options = ("--unit", "mV", "--estimator", "optimal", "--model", "k2,k3,drift")
    (tmp_path / "stand.toml").write_text((EXAMPLES / "paper_stand.toml").read_text().replace("= 2.0", "= -2.0"))
    code, result, _ = solved(capsys, run, "--stand", tmp_path / "stand.toml", *options)
    found = result["extended"]
    assert code == 0 and found["k2_per_g"] == pytest.approx(VALUES[0], abs=1e-12)
    assert found["drift_v"] == pytest.approx(-2.0 * VALUES[2], abs=1e-12)
    assert found["u_drift_v"] == pytest.approx([4.56e-5, 6.7e-5, 6.7e-5], rel=0.01)


def off_by(index, by):
    """Spoil one element of an array."""

    def spoil(found):
        found = np.array(found)
        found.reshape(-1)[index] += by
        return found

    return spoil


DEFECTS = {
    "K2 of the core": (computation, "least_squares", off_by(12, 5e-12), "least_squares", "k2 differs"),
    "drift of the core": (computation, "least_squares", off_by(17, 5e-12), "least_squares", "drift differs"),
    "K2 of numpy": (computation, "unknowns", off_by(12, 5e-12), "least_squares", "k2 differs"),
    "K2 of optimal": (computation, "by_table", off_by(12, 1e-10), "optimal", "k2 differs"),
    "uncertainties": (uncertainty, "standard_uncertainties", off_by(13, 1e-9), "optimal", "u of further terms differs"),
    "the force": (computation, "linear_outputs", off_by(0, 1e-8), "least_squares", "U with further terms differs"),
}


@pytest.mark.parametrize("terms", [("k2",), ("k2", "k3"), ("k2", "drift")])
def test_core_and_numpy_find_the_same_chi_squared(terms):
    """Of noisy runs with such terms, by ways that have little in common."""
    rng = np.random.default_rng(930)
    declared, measured = read_stand(str(EXAMPLES / "paper_stand.toml")).stand.without(terms), np.ones(18, dtype=bool)
    schedule, variance = core.CoreSchedule.built_in("paper"), np.full((18, 3), declared.noise**2 / 50)
    for _ in range(5):
        sizes = 1e-4 * rng.normal(size=(len(terms), 3))
        delta = 1e-5 * rng.normal(size=18)
        ideal = Geometry(schedule.data).outputs(2.0 * np.eye(3) + 0.02, np.zeros(3), delta=delta)
        means = ideal + np.tensordot(sizes.ravel(), columns_at(Geometry(schedule.data).force(), terms), axes=1)
        means = means + np.sqrt(variance) * rng.normal(size=(18, 3))
        model = WholeModel(schedule.data, means, variance, declared, terms)
        given = schedule, means, measured, variance, declared, terms
        compare_fit(least_chi_squared(*given, sizes), model)
        assert model.freedom == 42 - 3 * len(terms)


@pytest.mark.parametrize("case", DEFECTS)
def test_planted_defects_end_in_exit_3(case, monkeypatch, tmp_path, capsys):
    module, name, spoil, estimator, message = DEFECTS[case]
    plant(monkeypatch, module, name, spoil)
    options = (*STAND, "--estimator", estimator, "--model", "k2,drift")
    code, result, err = solved(capsys, noisy(tmp_path, VALUES * [[1], [0], [1]]), *options)
    assert (code, result) == (3, None) and message in err and "no result is given" in err
