"""A converter that no noise dithers, in plans: what rounding leaves of a mean by brute force, and what `solve` says of
simulated runs that were rounded sample by sample."""

import json
from dataclasses import replace

import numpy as np
import pytest
from conftest import EXAMPLES

from tumble import core, model
from tumble.core import estimate_runs
from tumble.files.run_file import NO_BLOCKS, Run
from tumble.files.stand_file import read_stand
from tumble.model.errors import exact_outputs, sources
from tumble.planning.budget import by_key, notes
from tumble.planning.case import Case
from tumble.planning.promise import error_field, promise
from tumble.planning.require import requirements, samples_on, stand_of
from tumble.planning.schedule_search import NormSpread, worst_norm_of
from tumble.planning.validate import KNOWN, RUN, U0_V, judge, largest_gravity_errors, validate
from tumble.solving import optimal_run
from tumble.solving.decision import UNCERTAINTY, decide, would_show
from tumble.solving.solution import solve
from tumble.stand import PAPER_STAND, Stand

pytestmark = pytest.mark.python
PAPER = model.built_in("paper")
LONE = np.ones(18, dtype=int)
SEES_NOISE = [0, 4, 5, 7, 8, 9, 10, 11]  # K_xx, K_yy, K_yz, K_zy, K_zz and U0: little else
STEP = 20.0 / 2**15
LEFT = STEP / 12**0.5
SAMPLES = 50
TEXT = (EXAMPLES / "paper_stand.toml").read_text().replace("noise_v = 3e-4", "noise_v = 1e-5")
CONVERTER = "misalignment_rad = 0.02\nconverter_bits = {}\nrange_v = 20.0"


@pytest.fixture
def stand_with(tmp_path):
    """A file of the paper's stand with less noise, and a converter of so many bits."""

    def write(bits, limit_g=3e-4):
        file = tmp_path / f"{bits}_bits.toml"
        text = TEXT.replace("misalignment_rad = 0.02", CONVERTER.format(bits)) if bits else TEXT
        file.write_text(text.replace("delta_g_limit_g = 3e-4", f"delta_g_limit_g = {limit_g}"))
        return str(file)

    return write


def case_of(file):
    return Case.of(read_stand(file), file, None)


ROUNDED = Case(replace(PAPER_STAND, noise=1e-5).planned_with(STEP), 2.0, 0.02, STEP, None, 3e-4)
BLIND = replace(ROUNDED, stand=replace(ROUNDED.stand, rounding=0.0))


def rounded_rows(case, runs, seed, samples=SAMPLES):
    """Samples (runs, 18, samples, 3), each rounded to the step, and what is true of the blocks (runs, 12). No block is
    quite like another, so that their outputs round in other ways."""
    rng, k, still = np.random.default_rng(seed), case.nominal_k(), replace(case.stand, noise=0.0, rounding=0.0)
    errors = sources(PAPER, k, still, LONE)
    draws = rng.standard_normal((runs, sum(len(one.sigma) for one in errors.values())))
    other_k, other_u0 = rng.normal(0.0, 1e-3, (runs, 3, 3)), rng.normal(0.0, 1e-3, (runs, 3))
    means = exact_outputs(PAPER, k, np.zeros(3), errors, draws)
    means += model.Geometry(PAPER).force() @ np.swapaxes(other_k, 1, 2) + other_u0[:, None]
    rows = np.round((means[:, :, None] + 1e-5 * rng.standard_normal((runs, 18, samples, 3))) / STEP) * STEP
    return rows, np.hstack([(k + other_k).reshape(runs, 9), other_u0])


def solved(case, rows, estimator):
    run = Run(np.full(18, rows.shape[1]), rows.mean(axis=1), rows.std(axis=1, ddof=1), "V", {}, blocks=NO_BLOCKS)
    declared = replace(PAPER_STAND, noise=1e-5)
    return solve(run, core.CoreSchedule.built_in("paper"), estimator, case.limit_g, declared, "run", STEP)


@pytest.mark.parametrize("samples", [1, 50, 2000])
def test_what_rounding_leaves_of_a_mean_by_brute_force(samples):
    rng, declared = np.random.default_rng(1), replace(PAPER_STAND, noise=(0.002, 0.3, 0.6))
    planned = declared.planned_with(1.0)
    assert planned.rounding == pytest.approx((12**-0.5, 12**-0.5, 0.0))
    true = rng.random((4000, 3))
    noise = declared.sigmas("noise") * rng.standard_normal((samples, *true.shape))
    off = (np.round(true + noise).mean(axis=0) - true).std(axis=0)
    ratio = planned.mean_sigma(samples) / off
    assert ratio[0] == pytest.approx((1.0 + 1.0 / samples) ** 0.5, rel=0.05)  # the stand's own noise once more
    assert ratio[1] > 1.0  # partly dithered: never less than what is left
    dithered = (1.0 + 1.0 / 12.0 / 0.6**2) ** 0.5
    assert ratio[2] == pytest.approx(1.0 / dithered, rel=0.05)  # as a run's: noise alone, being more than the rounding
    rows = np.array([samples, 7])
    assert planned.mean_variance(rows) == pytest.approx(planned.mean_sigma(rows) ** 2)


def test_nothing_changes_where_the_step_is_unknown_or_the_noise_dithers(stand_with):
    assert case_of(stand_with(None)).stand == replace(PAPER_STAND, noise=1e-5, name=PAPER_STAND.name)
    for bits, left in ((16, LEFT), (20, LEFT / 16), (22, 0.0)):
        stand = case_of(stand_with(bits)).stand
        assert (stand.rounding, stand.noise) == (pytest.approx(left), pytest.approx(max(1e-5, left)))
    in_millivolts = case_of(stand_with(16)).stand.in_unit("mV")
    assert in_millivolts.mean_sigma(50) == pytest.approx(1e3 * case_of(stand_with(16)).stand.mean_sigma(50))


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares", "optimal"])
def test_a_plan_says_what_solve_says(stand_with, estimator):
    """Of the uncertainty, of the verdict, of what no run shows."""
    case = case_of(stand_with(16))
    planned = promise(case, estimator)
    solutions = [solved(case, rows, estimator) for rows in rounded_rows(case, 6, 2)[0]]
    found, unseen = np.array([one.u_norm.worst_g for one in solutions]), case.reliability(estimator)
    assert all(one.noise.undithered.all() for one in solutions)
    assert found == pytest.approx(np.full(6, planned.u_norm_worst_g), rel=0.01)
    reach_g = 3.0 * planned.u_norm_worst_g
    assert promise(BLIND, estimator).u_norm_worst_g < 0.95 * planned.u_norm_worst_g
    for limit_g, shown in ((1.02 * reach_g, True), (0.98 * reach_g, False)):
        one = replace(case, limit_g=limit_g)
        assert promise(one, estimator).shown is shown
        verdicts = [decide(replace(solution, limit_g=limit_g)).failures for solution in solutions]
        assert [UNCERTAINTY not in failures for failures in verdicts] == [shown] * 6
    listed = unseen, solutions[0].reliability
    mine, of_run = ({one.pattern.name: one.norm_g or 0.0 for one in each} for each in listed)
    assert mine == pytest.approx(of_run, rel=0.02)


def test_rounded_runs_are_as_far_off_as_planned():
    """To what two positions of the paper's circles that see the same force, and so round alike, have in common."""
    rows, truth = rounded_rows(ROUNDED, 2000, 3, samples=20)
    means = rows.mean(axis=2)
    found = estimate_runs(core.CoreSchedule(PAPER), means, "refined")
    fields = (error_field(one, "refined", one.nominal_k()) for one in (ROUNDED, BLIND))
    u, blind = (np.linalg.norm(field.unknowns, axis=0) for field in fields)
    spread = (found - truth).std(axis=0)
    assert (np.abs(spread / u - 1.0) < 0.15).all()
    assert (spread > 1.5 * blind)[SEES_NOISE].all()
    limit_g = float(np.quantile(largest_gravity_errors(means, found), 0.9))
    promised, blindly = (promise(replace(one, limit_g=limit_g), "refined").passes for one in (ROUNDED, BLIND))
    assert promised < 0.9 and blindly > 0.999  # a normal law has a longer tail than rounding


def test_what_would_show_it_is_no_number_of_samples(tumble, stand_with):
    file = stand_with(16, 1.5e-4)
    case = case_of(file)
    plan = json.loads(tumble("plan", "require", "--stand", file, "--estimator", "refined", "--json").stdout)
    remedies = would_show(solved(case, rounded_rows(case, 1, 4)[0][0], "refined"))
    assert [one["change"] for one in plan["would_show"]] == [one.change for one in remedies]
    assert [one["reach_g"] for one in plan["would_show"]] == pytest.approx([one.reach_g for one in remedies], rel=0.02)
    assert plan["promise"]["shown"] is False and plan["promise"]["growth"] < 1.0


SENTENCE = (
    "Noise under half a step of the converter (ux, uy, uz): rounding leaves 0.00018 V in the mean of any number of"
    " samples; remedies: dither, more bits, a smaller range"
)


def test_a_requirement_that_no_samples_meet_says_what_limits(tumble, stand_with):
    file = stand_with(16, 1e-4)
    done = tumble("plan", "require", "--stand", file)
    words = " ".join(done.stdout.split())
    assert done.returncode == 0 and SENTENCE in words
    assert "Samples at each position: no number of samples reaches this noise; the stand has 50" in words
    assert max(map(len, done.stdout.splitlines())) <= 80
    plan = json.loads(tumble("plan", "require", "--stand", file, "--json").stdout)
    assert plan["samples"] is plan["just_enough"]["samples"] is None
    assert plan["noise_v"] < LEFT < plan["declared"]["noise_v"]
    for subject in ("budget", "optimize"):
        done = tumble("plan", subject, "--stand", file)
        assert done.returncode == 0 and SENTENCE in " ".join(done.stdout.split())
    budget = json.loads(tumble("plan", "budget", "--stand", file, "--json").stdout)
    assert budget["sources"]["noise_v"] == pytest.approx(LEFT * (1.0 + 1.0 / 50) ** 0.5)
    assert "half a step" not in tumble("plan", "require", "--stand", stand_with(None)).stdout


def test_a_schedule_that_no_samples_make_good_enough_says_so(tumble, stand_with):
    limited = ("plan", "schedule", "--angles", "45", "--mountings", "2", "--stand", stand_with(16, 1e-5))
    done = tumble(*limited)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "tumble: unreachable: no schedule of at most 2 mountings, or inclined to at most 60 deg,"
            " reaches 1e-05 g here. " + SENTENCE + "\n"
    )


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
def test_a_schedule_is_sought_for_the_uncertainty_that_a_run_states(stand_with, estimator):
    case = case_of(stand_with(16))
    spread = NormSpread(case, PAPER, estimator)
    assert spread.exact(np.ones(18, dtype=bool), 50) == pytest.approx(worst_norm_of(case, estimator).worst_g, rel=1e-6)


@pytest.mark.parametrize("table", [KNOWN, RUN])
def test_a_campaign_is_as_planned(stand_with, table):
    """Drawn rounding is normal, as large as planned; weights do not know it, as those of a solve."""
    case = case_of(stand_with(16))
    for one in validate(case, ("refined", "optimal"), 3000, 5, table):
        assert judge(one).outside == ()
    k = case.nominal_k()
    means = model.Geometry(PAPER).outputs(k, np.array(U0_V))
    u = optimal_run.solve_each(PAPER, means[None], case.stand, case.step_v, 50)[1][0]
    witness = model.optimal_covariance(PAPER, k, case.stand, LONE, case.step_v)
    assert u == pytest.approx(np.sqrt(np.diag(witness)), rel=1e-6)


def test_requirements_count_rounding_by_channel():
    """Samples for the noise beside it; a stand of just such sizes has means of just such noise."""
    stand = Stand(2e-5, 2e-5, 4e-4, 4e-5, (1e-4, 1e-5, 1e-3), 50, "sigma1").planned_with((0.0, 1e-3, 1e-3))
    left = 1e-3 / 12**0.5
    assert stand.rounding == (0.0, pytest.approx(left), 0.0) and stand.noise == (1e-4, pytest.approx(left), 1e-3)
    limit = 2.0 * stand.mean_sigma(50).max()
    samples = samples_on(stand, limit)
    limits = limit * stand.profile("noise") * (1.0 + 1e-9)
    assert [(stand.mean_sigma(n) <= limits).all() for n in (samples - 1, samples)] == [False, True]
    assert samples_on(stand, 0.99 * left) is None
    case = Case(stand, 2.0, 0.02, (0.0, 1e-3, 1e-3), None, 3e-4)
    sizes = requirements(case, "derived", "refined", 3e-4, np.ones(5)).limits
    asked = stand_of(case, sizes).stand
    assert asked.mean_sigma(1) == pytest.approx(sizes[4] * stand.profile("noise"), rel=1e-12)
    assert asked.rounding[1] / asked.mean_sigma(1)[1] == pytest.approx(left / stand.mean_sigma(50)[1], rel=1e-12)
    assert asked.rounding[::2] == (0.0, 0.0)
    alike = Case(replace(stand, noise=1e-3), 2.0, 0.02, 0.0, None, 3e-4)  # but for what rounding leaves
    assert by_key(alike, ("noise",), np.array([2.0]))["noise_v"] == tuple((2.0 * alike.stand.profile("noise")).tolist())
    assert notes(alike)[0].startswith("noise: of the worst channel") and "(uy)" in notes(alike)[1]
