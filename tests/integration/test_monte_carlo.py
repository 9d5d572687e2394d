"""`solve --monte-carlo`: simulated runs confirm the uncertainties of a result, or say where they do not."""

import dataclasses
import json

import numpy as np
import pytest
from blocks import NOMINAL_K
from conftest import EXAMPLES
from documents import paper_stand, valid

from tumble import model
from tumble.estimators import COEFFICIENTS
from tumble.model.errors import exact_outputs, sources
from tumble.planning.validate import U0_V
from tumble.solving.many_runs import NORMAL_COVERAGE, Verdict, compare, simulate
from tumble.stand import COMMON, INDEPENDENT, PAPER_STAND, Stand

pytestmark = pytest.mark.python
PAPER = model.built_in("paper")
ONES = np.ones(18, dtype=int)


def normal_errors(runs):
    """The quantiles of a normal law, as runs that are not random: by bisection of its own integral."""
    share = (np.arange(runs) + 0.5) / runs
    places = np.linspace(-6, 6, 20001)
    density = np.exp(-(places**2) / 2)
    below = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) / 2)])
    return np.tile(np.interp(share, below / below[-1], places)[:, None], 12)


def test_what_is_as_stated_agrees():
    value, u = np.arange(12.0), np.full(12, 0.35)
    found = compare(0.35 * normal_errors(100_000), value, u, 1, 1e-12)
    assert found.agrees and found.where(Verdict.AGREES) == list(COEFFICIENTS)
    assert found.low == pytest.approx(value - NORMAL_COVERAGE * u, abs=1e-4)
    assert found.high == pytest.approx(value + NORMAL_COVERAGE * u, abs=1e-4)
    assert (found.shift, found.u) == (pytest.approx(np.zeros(12), abs=1e-9), pytest.approx(u, rel=1e-3))
    assert found.tolerance == pytest.approx(np.full(12, 0.05))


@pytest.mark.parametrize(
    ("u", "tolerance"), [(0.35, 0.05), (9.4e-6, 0.5e-6), (9.6e-6, 0.5e-5), (1.0, 0.5), (2.5e-7, 0.5e-7), (0.0, 1e-12)]
)
def test_the_tolerance_is_half_a_unit_of_the_first_digit(u, tolerance):
    found = compare(np.zeros((1000, 12)), np.ones(12), np.full(12, u), 1, 1e-12)
    assert found.tolerance == pytest.approx(np.full(12, tolerance), rel=1e-12)


@pytest.mark.parametrize(("shift", "verdict"), [(0.1, "agrees"), (0.14, "cannot tell"), (0.2, "differs")])
def test_a_shift_is_told_as_far_as_the_runs_go(shift, verdict):
    """Of 0.35 the tolerance is 0.05, which is a shift of 0.143; 100,000 runs know an end to 0.028."""
    found = compare(0.35 * (normal_errors(100_000) + shift), np.ones(12), np.full(12, 0.35), 1, 1e-12)
    assert {one.value for one in found.verdicts} == {verdict}
    assert found.agrees is {"agrees": True, "cannot tell": None, "differs": False}[verdict]


def test_few_runs_cannot_tell():
    found = compare(0.35 * normal_errors(1000), np.ones(12), np.full(12, 0.35), 1, 1e-12)
    assert found.agrees is None and found.where(Verdict.CANNOT_TELL) == list(COEFFICIENTS)


def test_an_estimate_that_comes_out_low_leaves_the_coefficient_above_it():
    errors = -np.abs(normal_errors(10_000))
    found = compare(errors, np.zeros(12), np.ones(12), 1, 1e-12)
    assert (found.low > 0).all() and found.high == pytest.approx(np.full(12, 2.2414), abs=1e-2)
    assert found.agrees is False


def test_a_uniform_law_by_hand():
    """A level alone, uniform, moves K_xy of an orthogonal block by itself times K_xx: 95 % of it lie within 0.95 of its
    half-width, where the linear theory says 1.96 u."""
    stand = Stand(0.0, 3e-4, 0.0, 0.0, 1e-9, 1, "uniform")
    given = model.Propagation(PAPER, 2 * np.eye(3), stand, ONES, "refined")
    found = simulate(given, np.zeros(3), np.sqrt(np.diag(given.covariance())), 50_000, 4)
    assert found.u[1] == pytest.approx(2 * 3e-4 / 3**0.5, rel=0.01)
    assert [found.low[1], found.high[1]] == pytest.approx([-0.95 * 6e-4, 0.95 * 6e-4], rel=0.01)
    assert found.verdicts[1] is Verdict.DIFFERS


@pytest.mark.parametrize("remounting", [INDEPENDENT, COMMON])
def test_draws_of_the_exact_geometry_are_those_of_the_geometry(remounting):
    """Every source by itself, and all together, with two runs at once."""
    stand = dataclasses.replace(PAPER_STAND, remount=0.02, remounting=remounting)
    errors = sources(PAPER, NOMINAL_K, stand, ONES)
    rng, u0 = np.random.default_rng(5), np.array(U0_V)
    yaws = 1 if remounting == COMMON else 2
    x = rng.normal(size=(2, 2 + yaws + 18 + 54))
    found = exact_outputs(PAPER, NOMINAL_K, u0, errors, x)
    for run, draws in zip(found, x):
        angles, noise = draws[: 20 + yaws], draws[20 + yaws :]
        expected = model.Geometry(PAPER).outputs(
            NOMINAL_K,
            u0,
            alpha1=2e-5 * angles[0],
            alpha2=2e-5 * angles[1],
            alpha3=0.02 * np.broadcast_to(angles[2 : 2 + yaws], 2),
            delta=4e-5 * angles[2 + yaws :],
        )
        assert run == pytest.approx(expected + 3e-4 / 50**0.5 * noise.reshape(18, 3), abs=1e-15)


def solve(tumble, *arguments, cwd=EXAMPLES):
    done = tumble("solve", *arguments, "--json", cwd=cwd)
    assert done.returncode in (0, 1), done.stderr
    return valid(done.stdout), done.stderr


@pytest.mark.parametrize("estimator", ["refined", "least_squares", "optimal"])
@pytest.mark.parametrize("name", ["paper_stand", "lab_stand"])
def test_the_examples_differ_nowhere(name, estimator, tumble):
    arguments = [f"{name}.csv", "--stand", f"{name}.toml", "--estimator", estimator, "--monte-carlo", "20000"]
    found, _ = solve(tumble, *arguments)
    told = found["monte_carlo"]
    assert (told["runs"], told["seed"]) == (20000, 1) and told["agrees"] is not False
    stated = [*np.ravel(found["u_K"]), *found["u_U0"]]
    assert [one["name"] for one in told["coefficients"]] == list(COEFFICIENTS)
    for one, u, value in zip(told["coefficients"], stated, [*np.ravel(found["K"]), *found["U0"]]):
        assert one["u"] == pytest.approx(u, rel=0.03) and abs(one["shift"]) < 0.08 * u
        assert one["linear_interval"] == pytest.approx([value - 1.959964 * u, value + 1.959964 * u], rel=1e-8)


def test_a_large_yaw_differs_and_not_for_optimal(tumble, tmp_path):
    stand = paper_stand(tmp_path, remount_rad="15e-3")
    arguments = [EXAMPLES / "paper_stand.csv", "--stand", stand, "--monte-carlo", "50000", "--estimator"]
    found, told = solve(tumble, *arguments, "refined")
    verdicts = {one["name"]: one["verdict"] for one in found["monte_carlo"]["coefficients"]}
    assert found["monte_carlo"]["agrees"] is False and verdicts["K_xx"] == "differs"
    assert "tumble: warning: Monte Carlo differs from the uncertainties of K_xx" in told
    found, told = solve(tumble, *arguments, "optimal")
    assert found["monte_carlo"]["agrees"] is not False and "differs" not in told


def test_a_run_without_some_positions(tumble, tmp_path):
    rows = (EXAMPLES / "paper_stand.csv").read_text().splitlines()
    (tmp_path / "run.csv").write_text("\n".join(row for row in rows if not row.startswith(("1,4,", "2,9,"))) + "\n")
    arguments = ["run.csv", "--stand", EXAMPLES / "paper_stand.toml", "--estimator", "least_squares"]
    found, _ = solve(tumble, *arguments, "--monte-carlo", "5000", cwd=tmp_path)
    for one, u in zip(found["monte_carlo"]["coefficients"], [*np.ravel(found["u_K"]), *found["u_U0"]]):
        assert one["u"] == pytest.approx(u, rel=0.05)


def test_the_same_seed_gives_the_same_numbers(tumble):
    arguments = ["paper_stand.csv", "--stand", "paper_stand.toml", "--monte-carlo", "2500"]
    first, again, other = (solve(tumble, *arguments, "--seed", seed)[0]["monte_carlo"] for seed in (7, 7, 8))
    assert first == again and first["seed"] == 7
    assert first["coefficients"] != other["coefficients"]
    assert solve(tumble, "paper_stand.csv", "--stand", "paper_stand.toml")[0]["monte_carlo"] is None


def test_text_has_a_row_for_every_coefficient(tumble):
    arguments = ["solve", "lab_stand.csv", "--stand", "lab_stand.toml", "--monte-carlo", "1000"]
    told = json.loads(tumble(*arguments, "--json", cwd=EXAMPLES).stdout)
    lines = tumble(*arguments, cwd=EXAMPLES).stdout.splitlines()
    assert max(map(len, lines)) <= 80
    [start] = [index for index, line in enumerate(lines) if line.startswith("Monte Carlo, 1000 runs, seed 1;")]
    stated = [*np.ravel(told["u_K"]), *told["u_U0"]]
    for line, one, u in zip(lines[start + 2 :], told["monte_carlo"]["coefficients"], stated):
        words = line.split()
        assert words[0] == one["name"] and line.endswith(one["verdict"])
        assert float(words[1]) == pytest.approx(one["shift"] / u, abs=6e-4)
        assert float(words[2]) == pytest.approx(one["u"] / u, abs=6e-4)
    assert lines[start + 14].startswith("too few runs of Monte Carlo to tell of ")


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--monte-carlo", "5000"], "--monte-carlo draws the stand's errors: it needs --stand FILE"),
        (["--monte-carlo", "999", "--stand", "STAND"], "is not a whole number from 1000 to 1000000"),
        (["--monte-carlo", "1e4", "--stand", "STAND"], "is not a whole number from 1000 to 1000000"),
        (["--monte-carlo", "1000001", "--stand", "STAND"], "is not a whole number from 1000 to 1000000"),
        (["--monte-carlo", "5000", "--seed", "-1", "--stand", "STAND"], "--seed: '-1' is not a whole number"),
        (["--seed", "5", "--stand", "STAND"], "--seed: without --monte-carlo there is nothing to draw"),
    ],
)
def test_what_cannot_be_drawn_is_refused(arguments, complaint, refused, tmp_path):
    stand = paper_stand(tmp_path)
    given = [str(stand) if word == "STAND" else word for word in arguments]
    assert complaint in refused("solve", EXAMPLES / "paper_stand.csv", *given)


def test_runs_that_optimal_gives_no_result_for_are_refused(refused, tmp_path):
    stand = paper_stand(tmp_path, remount_rad="0.3")
    arguments = ["--stand", stand, "--estimator", "optimal", "--monte-carlo", "1000"]
    error = refused("solve", EXAMPLES / "paper_stand.csv", *arguments)
    assert error.startswith("tumble: --monte-carlo: a run on such a stand cannot be solved: ")
