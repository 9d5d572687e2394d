"""Further terms of the model before a run and on the bench: what they cost, and whether that comes true."""

import json
from dataclasses import replace

import numpy as np
import pytest
from conftest import EXAMPLES
from documents import paper_stand
from test_further_terms import WORST_UG
from test_plan_budget import plan

from tumble import model
from tumble.files.stand_file import read_stand
from tumble.model import Propagation, built_in
from tumble.model.coefficients import norm_gradient
from tumble.planning import validate
from tumble.planning.case import Case
from tumble.planning.promise import error_field, growing_promise, largest_over_attitudes, largest_with_terms
from tumble.planning.schedule_search import NormSpread, worst_norm_of
from tumble.schedule import CHECK, Position, Schedule

pytestmark = pytest.mark.python

MODELS = [("k2",), ("k2", "drift"), ("k2", "k3"), ("drift",)]
CHANCE = 4.0  # standard errors


def case_of(name, terms, schedule=None):
    file = EXAMPLES / f"{name}_stand.toml"
    return replace(Case.of(read_stand(file), file, schedule), terms=terms)


def with_checks(schedule):
    """A check position in the middle of the run, and one at its end: a drift goes on there."""
    first, *rest = schedule.positions
    checks = Position(1, 40, 22.5, CHECK), Position(2, 40, 67.5, CHECK)
    return Schedule(schedule.mountings, (first, checks[0], *rest, checks[1]))


@pytest.mark.parametrize(("name", "terms"), [key for key in WORST_UG if key[1]])
def test_the_cost_is_the_one_stated(name, terms, tumble):
    """Of K and U0 alone, by an independent program."""
    found = plan(tumble, "budget", "--estimator", "optimal", "--schedule", name, "--model", ",".join(terms))
    assert 1e6 * found["extended"]["u_norm_of_K_U0_g"] == pytest.approx(WORST_UG[name, terms], rel=0.01)
    assert 1e6 * found["extended"]["without"]["u_norm_g"] == pytest.approx(WORST_UG[name, ()], rel=0.01)
    assert found["extended"]["u_k3_per_g2"] is None or "k3" in terms


@pytest.mark.parametrize("terms", MODELS)
@pytest.mark.parametrize("checked", [False, True])
def test_core_and_numpy_plan_the_same(terms, checked):
    """The dense problem of numpy, on positions some of which are only checked."""
    schedule = with_checks(built_in("paper")) if checked else built_in("paper")
    case = case_of("lab", terms, schedule)
    k, lone = case.nominal_k(), np.ones(len(schedule.positions), dtype=int)
    unknowns = error_field(case, "least_squares", k).unknowns
    witness = Propagation(schedule, k, case.stand, lone, "least_squares", terms=terms).covariance()
    assert np.sqrt(np.diag(unknowns.T @ unknowns)) == pytest.approx(np.sqrt(np.diag(witness)), rel=1e-8)
    unknowns = error_field(case, "optimal", k).unknowns
    means = model.Geometry(schedule).outputs(k, np.zeros(3))
    found = model.optimal_estimate(
        schedule, means, case.stand, lone, known_k=k, known_samples=case.stand.samples, terms=terms
    )
    assert np.sqrt(np.diag(unknowns.T @ unknowns)) == pytest.approx(np.sqrt(np.diag(found.covariance)), rel=1e-6)


@pytest.mark.parametrize("terms", MODELS)
@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
def test_a_schedule_is_worth_what_its_own_gains_say(terms, estimator):
    """Information that adds up, against the gains: of the whole exactly, of subsets without a drift, which goes by the
    order of all candidates there."""
    case, whole = case_of("paper", terms), built_in("three_mountings")
    quiet, rng = replace(case.stand, samples=20), np.random.default_rng(2)
    spread = NormSpread(case, whole, estimator)
    subsets = [np.ones(27, dtype=bool)]
    subsets += [] if "drift" in terms else [rng.permutation(np.arange(27) < 22) for _ in range(2)]
    for subset in subsets:
        alone = worst_norm_of(replace(case, own_schedule=whole.part(subset), stand=quiet), estimator).worst_g
        assert spread.exact(subset, 20) == pytest.approx(alone, rel=1e-5)
        assert alone * 0.95 <= spread.worst(subset[None], 20)[0] <= alone * (1 + 1e-9)


def test_the_worst_attitude_by_brute_force():
    rng = np.random.default_rng(4)
    k = 2.0 * np.eye(3) + 0.04
    at = rng.standard_normal((200_000, 3))
    at /= np.linalg.norm(at, axis=1, keepdims=True)
    for terms in ((), *MODELS):
        errors = rng.standard_normal((30, 12 + 3 * len(terms)))
        brute = np.abs(errors @ norm_gradient(k, at, terms).T).max(axis=1)
        found = largest_with_terms(errors, k, terms)
        assert (found > brute * (1 - 1e-4)).all() and found == pytest.approx(brute, rel=5e-3)


@pytest.mark.parametrize("terms", [(), ("drift",)])
def test_where_no_order_is_high_both_ways_find_the_same(terms):
    field = error_field(case_of("lab", terms), "optimal", case_of("lab", ()).nominal_k())
    climbed = largest_with_terms(field.unknowns, case_of("lab", ()).nominal_k(), terms)
    assert climbed == pytest.approx(largest_over_attitudes(field.forms), rel=1e-3, abs=1e-12)


@pytest.mark.toolchain
@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
@pytest.mark.parametrize("terms", [MODELS[0], *(pytest.param(terms, marks=pytest.mark.full) for terms in MODELS[1:])])
def test_runs_turn_out_as_promised(terms, estimator):
    """At a limit that a third of them fail."""
    runs, case = 2000, case_of("lab", terms, with_checks(built_in("paper")))
    growth = growing_promise(case, estimator, 0.7).growth
    found = validate.validate(replace(case, limit_g=case.limit_g / growth), (estimator,), runs, 3)[0]
    shares = found.tally.passed / runs, found.tally.everywhere / runs
    told = found.promise
    for chance, u, share in zip((told.passes, told.every_attitude), (told.u_passes, told.u_every_attitude), shares):
        by_chance = np.hypot(np.sqrt(chance * (1 - chance) / runs), u)
        assert share == pytest.approx(chance, abs=CHANCE * by_chance + 1 / runs)
    assert found.tally.spread == pytest.approx(found.u, rel=CHANCE / np.sqrt(2 * runs))


@pytest.mark.toolchain
def test_every_plan_says_what_the_terms_cost(tumble):
    found_soon = ["--norm", "4e-5", "--angles", "45", "--mountings", "2", "--inclination", "0"]
    for subject in ("budget", "require", "schedule"):
        options = ["--estimator", "optimal", "--model", "k2"] + (found_soon if subject == "schedule" else [])
        told = plan(tumble, subject, *options)["extended"]
        assert told["terms"] == ["k2"] and told["u_norm_g"] > told["without"]["u_norm_g"]
        done = tumble("plan", subject, *options)
        assert "with k2 in the model: " in done.stdout and max(map(len, done.stdout.splitlines()[:-1])) <= 80
    assert sorted(plan(tumble, "validate", "--runs", "200", "--model", "k2")["estimators"]) == [
        "least_squares",
        "optimal",
    ]


@pytest.mark.parametrize("goal", [("--norm", "1e-4"), pytest.param(("--limit", "3e-4"), marks=pytest.mark.full)])
def test_a_built_in_schedule_that_does_not_tell_is_out_of_reach(goal, tumble):
    """The diagonals have no cube; what is found tells it, with six residuals left."""
    found = plan(tumble, "schedule", "--model", "k3", *goal)
    assert found["beside"]["diagonal"] is None and found["beside"]["paper"] is not None
    count = found["schedule"]["positions"]
    assert found["schedule"]["freedom"] == 3 * count - 15 and count >= 7
    assert found["extended"]["u_norm_g"] == pytest.approx(found["u_norm_g"]["worst_g"], rel=1e-6)


REFUSED = {
    (
        "plan",
        "optimize",
        "--model",
        "k2",
    ): "the firmware's gains are for twelve coefficients; further terms are for other plans",
    ("plan", "paper", "--model", "k2"): "the paper's model has twelve coefficients; further terms are for other plans",
    ("plan", "budget", "--model", "k2"): "refined is a closed form of twelve coefficients; use --estimator"
    " least_squares, or optimal with --stand FILE",
    ("plan", "require", "--model", "k4"): "'k4' is not one of k2, k3, asymmetry, cross, drift, once each",
    ("plan", "schedule", "--model", "k2,k2"): "'k2' is not one of k2, k3, asymmetry, cross, drift, once each",
    ("bench", "--model", "k2"): "refined is a closed form of twelve coefficients; use --estimator least_squares, or"
    " optimal with --stand FILE",
    ("plan", "budget", "--model", "k2", "--weights", "published", "--estimator", "averaged"): "the paper's weights are"
    " for twelve coefficients (--weights derived)",
}


@pytest.mark.parametrize("command", REFUSED)
def test_where_it_makes_no_sense(command, refused):
    assert refused(*command) == f"tumble: --model: {REFUSED[command]}\n"


@pytest.mark.parametrize("command", [("plan", "budget"), ("plan", "validate"), ("bench", "--out", "made")])
def test_a_schedule_that_does_not_tell_them(command, refused, tmp_path):
    words = [tmp_path / word if word == "made" else word for word in command]
    line = refused(*words, "--schedule", "diagonal", "--model", "k3", "--estimator", "optimal")
    assert line == (
        "tumble: --model k3: these positions cannot tell apart K3_x and K_xx, nor K3_y and K_yy, nor K3_z and K_zz;"
        " the schedule paper or three_mountings does\n"
    )
    assert not (tmp_path / "made").exists()


def test_weights_for_each_run_are_not_for_further_terms(refused):
    line = refused("plan", "validate", "--model", "k2", "--table", "run")
    assert line.startswith("tumble: --table run: not with --model")


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
def test_the_bench_finds_what_solve_finds(estimator, tumble, tmp_path):
    stand = paper_stand(tmp_path)
    options = ("--stand", stand, "--estimator", estimator, "--model", "k2,drift", "--limit", "1e-3", "--json")
    done = tumble("bench", "--seed", "5", "--out", tmp_path / "run", *options)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    solved = json.loads(tumble("solve", tmp_path / "run" / "run.csv", *options).stdout)
    assert found["extended"]["terms"] == ["k2", "drift"] and found["truth"] is not None
    for key in ("K", "U0", "u_K", "u_U0"):
        assert np.ravel(found[key]) == pytest.approx(np.ravel(solved[key]), rel=1e-9, abs=1e-12)
    for key in ("k2_per_g", "u_k2_per_g", "drift_v", "u_drift_v"):
        assert found["extended"][key] == pytest.approx(solved["extended"][key], rel=1e-6)
    assert json.loads((tmp_path / "run" / "result.json").read_text()) == found
    assert (np.abs(found["extended"]["k2_per_g"]) < 4 * np.array(found["extended"]["u_k2_per_g"])).all()
