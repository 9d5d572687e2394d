"""`tumble solve --prior`: the last calibration of a block in the least squares of its run, and what is refused."""

import json
import sys
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from blocks import NOMINAL_K, write_run
from calibrations import result
from conftest import EXAMPLES, ROOT
from documents import valid
from fleets import fleet, rows_of

import tumble as package
from tumble.documents.labels import iso
from tumble.documents.result import parse_result
from tumble.errors import BadInput, UsageError
from tumble.files.stand_file import read_stand
from tumble.history import History
from tumble.history.calibrations import row_of, seconds_of
from tumble.model import WholeModel, built_in
from tumble.model.coefficients import NotSolvable, worst_norm
from tumble.model.errors import exact_outputs, sources
from tumble.model.geometry import ideal_force
from tumble.model.optimal import mean_sigma, optimal_covariance, optimal_estimate, samples_in_a_mean
from tumble.model.prior import (
    Given,
    Growth,
    LastCalibration,
    Prior,
    Run,
    by_parameters,
    difference_test,
    estimate_with_prior,
    parameters,
)
from tumble.stand import SOURCES, Stand

sys.path.insert(0, str(ROOT / "tests/benchmark"))
import prior as campaign

pytestmark = pytest.mark.python
PAPER, SIX = built_in("paper"), built_in("six_faces")
STAND = read_stand(str(EXAMPLES / "paper_stand.toml")).stand
U0 = np.array([0.02, -0.01, 0.03])
GROWTH = Growth.declared(50e-6, 20e-6, 50e-6)
JOINT = np.eye(12) * 1e-10
TIME = "2026-03-01T12:00:00Z"


def prior_of(k, u0, covariance, days=365.25, growth=GROWTH):
    by, grown = by_parameters(k, u0), growth.after(days)
    joint = by @ covariance @ by.T + np.diag(grown**2)
    return Prior(parameters(k, u0), joint, k, u0, "last.json", TIME, days, grown, np.zeros(9), "declared")


def given_of(schedule, stand=STAND):
    return Given(schedule, stand, np.full(len(schedule.positions), stand.samples))


def simulated(schedule, k, u0, stand=STAND, seed=1, size=1.0):
    found = sources(schedule, k, stand, np.full(len(schedule.positions), stand.samples))
    draws = np.random.default_rng(seed).standard_normal((1, sum(len(one.sigma) for one in found.values())))
    return exact_outputs(schedule, k, u0, found, size * draws)[0]


def calibrated(seed=3, k=NOMINAL_K, u0=U0):
    found = optimal_estimate(PAPER, simulated(PAPER, k, u0, seed=seed), STAND, np.full(18, STAND.samples))
    return prior_of(found.k, found.u0, found.covariance)


ONE = PAPER.part(np.arange(18) < 9)


def test_weights_are_those_of_two_means_of_one_number():
    """A stand without errors, six faces, a block without misalignment: K_ii by its pair, U0_i by all six."""
    k, s, r = Fraction(2), Fraction(1, 1000), Fraction(1, 2000)  # V/g, V of a mean, relative and g
    stand = Stand(0.0, 0.0, 0.0, 0.0, float(s), 1, "sigma1")
    diagonal = np.diag([float(k)] * 3)
    told = Prior(
        np.concatenate([np.log([2.0] * 3), [np.pi / 2] * 3, np.zeros(3)]), np.eye(9) * float(r) ** 2,
        diagonal, np.zeros(3), "", TIME, 0.0, np.zeros(9), np.zeros(9), "declared",
    )  # fmt: skip
    added = 0.002
    means = ideal_force(SIX) @ (diagonal + added * np.eye(3)).T + added
    found = estimate_with_prior(given_of(SIX, stand), means, told)
    variance_of_pair, variance_of_six, of_prior = s**2 / 2, s**2 / 6, (r * k) ** 2
    share, share_u0 = of_prior / (of_prior + variance_of_pair), of_prior / (of_prior + variance_of_six)
    assert np.diag(found.k) == pytest.approx(2.0 + added * float(share), abs=2e-6)  # the logarithm bends by its square
    assert found.u0 == pytest.approx(added * float(share_u0), rel=2e-3)
    joint = float(of_prior * variance_of_pair / (of_prior + variance_of_pair))
    assert np.diag(found.covariance)[[0, 4, 8]] == pytest.approx(joint, rel=2e-3)
    assert found.test.freedom == 9


@pytest.mark.parametrize("name", ["paper", "diagonal", "three_mountings"])
def test_rows_in_the_same_least_squares_are_the_two_estimates_weighed(name):
    """Of a run that determines all: by the estimate and covariance of `optimal`, dense and without any row of means."""
    schedule, told = built_in(name), calibrated()
    means, samples = simulated(schedule, NOMINAL_K, U0, seed=5), np.full(len(schedule.positions), STAND.samples)
    found = estimate_with_prior(given_of(schedule), means, told)
    own = optimal_estimate(schedule, means, STAND, samples)
    beta = at = np.concatenate([own.k.ravel(), own.u0])
    covariance = optimal_covariance(schedule, found.k, STAND, samples, 0.0)  # linearised where it ends
    for _ in range(5):
        k, u0 = beta[:9].reshape(3, 3), beta[9:]
        rows = by_parameters(k, u0)
        information = np.linalg.inv(covariance) + rows.T @ np.linalg.inv(told.covariance) @ rows
        pull = np.linalg.inv(covariance) @ (at - beta)
        pull += rows.T @ np.linalg.inv(told.covariance) @ (told.values - parameters(k, u0))
        beta = beta + np.linalg.solve(information, pull)
    u = np.sqrt(np.diag(found.covariance))
    assert np.abs(np.concatenate([found.k.ravel(), found.u0]) - beta).max() < (1e-3 * u).max()
    assert found.covariance == pytest.approx(np.linalg.inv(information), abs=1e-6 * (u**2).max())
    rows, difference = by_parameters(own.k, own.u0), told.values - parameters(own.k, own.u0)
    joint = rows @ covariance @ rows.T + told.covariance
    assert found.test.chi_squared == pytest.approx(difference @ np.linalg.solve(joint, difference), rel=1e-3)
    of_difference = difference_test(told, own.k, own.u0, covariance)
    assert of_difference.chi_squared == pytest.approx(difference @ np.linalg.solve(joint, difference), rel=1e-9)
    assert of_difference.change == pytest.approx(found.test.change, abs=(0.03 * found.test.u_change).max())
    assert of_difference.u_change == pytest.approx(found.test.u_change, rel=1e-3)
    assert found.test.freedom == 9


@pytest.mark.parametrize("schedule", [PAPER, ONE], ids=["both mountings", "one mounting"])
def test_it_is_what_the_whole_model_finds_and_pays_for(schedule):
    """By QR at the errors found: the estimate, and by how much the prior raises chi-squared, with what freedom."""
    told, means, given = calibrated(), simulated(schedule, NOMINAL_K, U0, seed=6), given_of(schedule)
    found = estimate_with_prior(given, means, told)
    sigma = mean_sigma(found.k, STAND, 0.0, samples_in_a_mean(schedule, STAND, given.samples))[0]
    variance, at = np.broadcast_to(sigma**2, means.shape), (found.k, found.u0)
    both = WholeModel(schedule, means, variance, STAND, (), at, told)
    alone = WholeModel(schedule, means, variance, STAND, (), at)
    u = np.sqrt(np.diag(found.covariance))
    off = np.concatenate([(found.k - both.k).ravel(), found.u0 - both.u0])
    assert np.abs(off / u).max() < 5e-3
    assert found.test.chi_squared == pytest.approx(both.chi_squared - alone.chi_squared, abs=0.01)
    assert found.test.freedom == both.freedom - alone.freedom == (9 if schedule is PAPER else 6)
    assert alone.freedom == 3 * len(schedule.positions) - (12 if schedule is PAPER else 9)


def test_the_whole_model_of_a_run_that_determines_all_begins_anywhere():
    means, variance = simulated(PAPER, NOMINAL_K, U0), np.full(18, STAND.noise**2 / STAND.samples)
    begun = None, (NOMINAL_K * 1.001, U0 + 0.01)
    own, moved = (WholeModel(PAPER, means, variance, STAND, known=one) for one in begun)
    assert moved.chi_squared == pytest.approx(own.chi_squared, rel=1e-9) and moved.freedom == own.freedom == 42


@pytest.mark.parametrize("schedule", [PAPER, ONE], ids=["both mountings", "one mounting"])
def test_how_the_block_sat_in_its_last_calibration_does_not_matter(schedule):
    told, means = calibrated(), simulated(schedule, NOMINAL_K, U0, seed=7)
    turn = np.linalg.qr(np.eye(3) + 0.02 * np.array([[0, -1, 2], [1, 0, -3], [-2, 3, 0]]))[0]
    turned = replace(told, k=told.k @ (turn * np.sign(np.diag(turn))))
    assert parameters(turned.k, turned.u0) == pytest.approx(parameters(told.k, told.u0), abs=1e-12)
    one, other = (estimate_with_prior(given_of(schedule), means, prior) for prior in (told, turned))
    u = np.sqrt(np.diag(one.covariance))
    assert np.abs(one.k - other.k).max() < 1e-4 * u.min() and np.abs(one.u0 - other.u0).max() < 1e-4 * u.min()
    assert one.test.chi_squared == pytest.approx(other.test.chi_squared, abs=1e-4)
    assert turned.worst_norm.worst_g == pytest.approx(told.worst_norm.worst_g, rel=1e-6)


def test_exact_outputs_give_back_the_block():
    told = prior_of(NOMINAL_K, U0, np.eye(12) * 1e-10)
    means = ideal_force(ONE) @ NOMINAL_K.T + U0
    found = estimate_with_prior(given_of(ONE), means, replace(told, k=NOMINAL_K * 1.001, u0=U0 + 1e-3))
    assert found.k == pytest.approx(NOMINAL_K, abs=1e-9) and found.u0 == pytest.approx(U0, abs=1e-9)
    assert found.test.chi_squared < 1e-9 and found.test.p > 0.999 and found.test.changes == ()


def test_both_are_worth_more_than_each():
    told, samples = prior_of(NOMINAL_K, U0, np.eye(12) * 1e-10), np.full(18, STAND.samples)
    alone = worst_norm(NOMINAL_K, optimal_covariance(PAPER, NOMINAL_K, STAND, samples, 0.0)).worst_g
    of_one, of_both = (
        worst_norm(NOMINAL_K, given_of(one).covariance(NOMINAL_K, U0, told, None)).worst_g for one in (ONE, PAPER)
    )
    assert of_both < min(alone, told.worst_norm.worst_g) and of_one < told.worst_norm.worst_g


@pytest.mark.parametrize("place, size", [(0, 3e-4), (4, -2e-4), (6, 3e-4), (8, -3e-4)])
def test_a_change_is_found_with_its_size_and_sign(place, size):
    """Without noise: the one parameter that has changed explains all of it."""
    changed = parameters(NOMINAL_K, U0)
    changed[place] += size
    k, u0 = campaign.block(changed, campaign.turn_of(NOMINAL_K))
    told = prior_of(NOMINAL_K, U0, np.eye(12) * 1e-10, 30.0)
    test = estimate_with_prior(given_of(PAPER), ideal_force(PAPER) @ k.T + u0, told).test
    found = test.changes[0]
    assert found.parameter == row_names()[place] and found.size == pytest.approx(size, rel=5e-3) and test.p < 1e-6
    assert (found.size / found.u) ** 2 == pytest.approx(test.chi_squared, rel=0.02)


def row_names():
    from tumble.history.calibrations import PARAMETERS

    return PARAMETERS[:9]


def test_what_a_run_does_not_show_of_a_change_has_no_size():
    told = prior_of(NOMINAL_K, U0, np.eye(12) * 1e-10)
    test = estimate_with_prior(given_of(ONE), ideal_force(ONE) @ np.diag([2.0] * 3), replace(told, k=NOMINAL_K)).test
    assert np.isfinite(test.u_change[[0, 2, 6, 8]]).all() and (test.u_change > 0.0).all()


def test_run_and_prior_that_have_nothing_in_common_give_no_estimate():
    told = prior_of(NOMINAL_K, U0, np.eye(12) * 1e-16, 0.0)
    with pytest.raises(NotSolvable, match="no coefficients in common"):
        estimate_with_prior(given_of(ONE), np.zeros((9, 3)), told)


# What a last calibration is on the day of a run.

RUN = Run("A-1", "V", seconds_of("2026-03-31", ""), None, STAND, None)


def last(growth=GROWTH, name="last.json", covariance=JOINT, **more):
    document = result(NOMINAL_K, U0, covariance, **{"created": TIME, "serial": "A-1", **more})
    return LastCalibration.of(parse_result(json.dumps(document).encode(), name), name, growth)


def test_a_prior_has_grown_and_drifted_by_its_day():
    growth = Growth(np.arange(1, 10) * 1e-6, np.arange(9) * 1e-7, np.full(9, 2e-7), "history")
    now, days = last(growth).at(RUN), 29.5
    by = by_parameters(NOMINAL_K, U0)
    assert now.days == days and now.created == TIME and now.growth_by == "history"
    assert now.values == pytest.approx(parameters(NOMINAL_K, U0) + days * np.arange(9) * 1e-7, rel=1e-12)
    grown = np.arange(1, 10) ** 2 * 1e-12 * days + (2e-7 * days) ** 2
    assert now.covariance == pytest.approx(by @ (np.eye(12) * 1e-10) @ by.T + np.diag(grown), rel=1e-12, abs=1e-24)


def test_a_declared_growth_is_that_of_a_year():
    assert Growth.declared(3e-5, 1e-5, 2e-5).after(365.25) == pytest.approx(np.repeat([3e-5, 1e-5, 2e-5], 3))
    assert Growth.declared(3e-5, 1e-5, 2e-5).after(365.25 / 4)[0] == pytest.approx(1.5e-5)


def test_local_gravity_is_no_change_of_the_block():
    """K per local g is in proportion to it, a bias in it in inverse proportion."""
    here = replace(RUN, gravity_m_s2=9.83)
    found = last(environment={"gravity_m_s2": 9.78}).at(here)
    then = parameters(NOMINAL_K * 9.83 / 9.78, U0)
    assert found.values == pytest.approx(then, rel=1e-12)
    assert last().at(here).values == pytest.approx(parameters(NOMINAL_K, U0), rel=1e-12)


def test_a_day_has_no_hours():
    assert last().at(replace(RUN, measured_s=seconds_of("2026-03-01", ""))).days == 0.0


FAILED = {"verification": {"pass": False, "max_abs_delta_g_g": 1e-3, "limit_g": 3e-4}}
KINDS = {"name": STAND.name, "limits": "sigma1", "remount": "independent", "samples": 50}
STAND_OF = {"stand": KINDS | {one.key: 0.0 for one in SOURCES.values() if not one.of_inclinations}}


@pytest.mark.parametrize(
    "more, run, why",
    [
        ({"covariance": None}, {}, "has no covariance: a prior needs one; solve its run with a stand file"),
        (FAILED, {}, "failed its gravity check or does not fit its stand: no prior"),
        ({"pass": False, "pass_reason": "fit"}, {}, "failed its gravity check or does not fit its stand: no prior"),
        ({"created": None}, {}, "has no date (key created): nobody knows how much its block has changed"),
        ({"serial": "B-2"}, {}, "is of block 'B-2', this run is of 'A-1'"),
        ({"serial": None}, {}, "names no block, this run is of 'A-1'"),
        ({"unit": "mV"}, {}, "has outputs in mV, this run in V"),
        ({"created": "2026-05-01T00:00:00Z"}, {}, "was measured on 2026-05-01, after this run (2026-03-31)"),
        ({"run_sha256": "0" * 64}, {"sha256": "0" * 64}, "is of this very run: a prior is of an earlier one"),
        (STAND_OF, {"stand": replace(STAND, platform=1e-4, encoder=1e-5)},
         "is of the same stand, which keeps its platform_rad and encoder_rad: the two are not independent"),
    ],
)  # fmt: skip
def test_what_is_no_prior_is_refused(more, run, why):
    with pytest.raises(BadInput) as error:
        last(**more).at(replace(RUN, **run))
    assert str(error.value) == f"last.json: {why}"


def test_another_stand_keeps_what_it_keeps_to_itself():
    kept = replace(STAND, platform=1e-4, name="another")
    assert last(**STAND_OF).at(replace(RUN, stand=kept)).days == 29.5
    assert last().at(replace(RUN, stand=replace(STAND, platform=1e-4))).days == 29.5


def test_labels_name_block_and_day():
    labelled = last(serial=None, created=None, item={"Serial number": "A-1", "date": "2026-03-01"})
    assert labelled.at(RUN).days == 30.0


# The command line.


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A stand file, last.json of a block, bent.json with K2, and runs of it: full.csv, one.csv of one mounting;
    changed.csv of both."""
    path = tmp_path_factory.mktemp("prior")
    told = (EXAMPLES / "paper_stand.toml").read_text().replace("[block]\n", '[block]\nserial = "A-1"\n')
    (path / "stand.toml").write_text(told + '\n[environment]\ndate = "2027-03-01"\n')
    (path / "then.toml").write_text(told + '\n[environment]\ndate = "2026-03-01"\n')
    write_run(path / "first.csv", PAPER, simulated(PAPER, NOMINAL_K, U0, seed=11))
    given = {"stand": path / "then.toml", "estimator": "optimal"}
    package.solve(path / "first.csv", **given).save(path / "last.json")
    package.solve(path / "first.csv", **given, model="k2").save(path / "bent.json")
    write_run(path / "full.csv", PAPER, simulated(PAPER, NOMINAL_K, U0, seed=12))
    write_run(path / "one.csv", ONE, simulated(ONE, NOMINAL_K, U0, seed=13))
    changed = U0 + np.array([0.0, 8e-4, 0.0])
    write_run(path / "changed.csv", PAPER, simulated(PAPER, NOMINAL_K, changed, seed=14))
    write_run(path / "changed_one.csv", ONE, simulated(ONE, NOMINAL_K, changed, seed=14))
    return path


def alone(folder, run):
    return ["solve", folder / run, "--stand", folder / "stand.toml", "--estimator", "optimal"]


def options(folder, run, growth="50,20,50"):
    return [*alone(folder, run)[:-2], "--prior", folder / "last.json", "--growth", growth]


def test_a_run_is_solved_with_its_prior(folder, tumble):
    done = tumble(*options(folder, "full.csv"), "--json")
    assert done.returncode == 0, done.stderr
    told = valid(done.stdout)
    without = valid(tumble(*alone(folder, "full.csv"), "--json").stdout)
    prior = told["prior"]
    assert "prior" not in without and told["estimator"] == "optimal" and told["fit"] == without["fit"]
    assert prior["used"] and prior["days"] == 365.0 and prior["dof"] == 9 and prior["created"] == "2026-03-01T00:00:00Z"
    assert prior["source"] == str(folder / "last.json") and prior["growth_by"] == "declared"
    assert prior["growth"]["scale"] == pytest.approx([50e-6 * (365.0 / 365.25) ** 0.5] * 3)
    assert prior["u_norm_worst_without_g"] == without["u_norm_g"]["worst_g"] > told["u_norm_g"]["worst_g"]
    assert prior["u_norm_worst_alone_g"] > told["u_norm_g"]["worst_g"]
    assert prior["changes"] == [] and prior["undetermined"] == []
    assert max(one["norm_error_g"] or 0.0 for one in told["reliability"]) == told["reliability_norm_g"]
    expected = estimate_with_prior(
        given_of(PAPER), simulated(PAPER, NOMINAL_K, U0, seed=12),
        LastCalibration.of(package.load(folder / "last.json").checked, "", GROWTH).at(
            replace(RUN, measured_s=seconds_of("2027-03-01", ""))
        ),
    )  # fmt: skip
    assert told["K"] == pytest.approx(expected.k, abs=1e-9) and told["U0"] == pytest.approx(expected.u0, abs=1e-9)
    assert told["covariance"] == pytest.approx(expected.covariance, rel=1e-6, abs=1e-16)
    text = tumble(*options(folder, "full.csv")).stdout
    assert "Prior: last.json, 365 days earlier, agrees: chi-squared" in text and max(map(len, text.splitlines())) <= 80
    assert f"both {told['u_norm_g']['worst_g'] * 1e6:.3g} ug" in text


def test_one_mounting_is_enough_with_a_prior(folder, tumble, refused):
    said = refused(*alone(folder, "one.csv"))
    assert said == f"tumble: {folder / 'one.csv'}: these positions cannot identify K_xy, K_yy, K_zy\n"
    done = tumble(*options(folder, "one.csv"), "--json")
    told = valid(done.stdout)
    assert done.returncode == 0 and told["prior"]["undetermined"] == ["K_xy", "K_yy", "K_zy"]
    assert told["prior"]["dof"] == 6 and told["fit"]["dof"] == 18 and told["second_order"] is None
    assert told["prior"]["u_norm_worst_without_g"] is None
    assert told["u_norm_g"]["worst_g"] < told["prior"]["u_norm_worst_alone_g"]
    assert np.abs(np.array(told["K"]) - NOMINAL_K).max() < 3.0 * np.max(told["u_K"])
    text = tumble(*options(folder, "one.csv"), "--details").stdout
    assert "The run alone does not determine K_xy, K_yy and K_zy: they rest on the prior\n" in text


def test_a_changed_block_is_not_hidden(folder, tumble):
    """All numbers are those of the run alone, and so is the verdict; the exit code and a warning tell."""
    done = tumble(*options(folder, "changed.csv"), "--json")
    told = valid(done.stdout)
    without = valid(tumble(*alone(folder, "changed.csv"), "--json").stdout)
    assert done.returncode == 1 and not told["prior"]["used"] and told["pass"] and told["pass_reason"] is None
    for key in ("K", "U0", "covariance", "u_norm_g", "fit", "verification", "reliability", "second_order", "reference"):
        assert told[key] == without[key]
    change = told["prior"]["changes"][0]
    assert change["parameter"] == "bias_y" and change["unit"] == "ug"
    assert change["size"] == pytest.approx(400.0, abs=3.0 * change["u"])
    assert told["warnings"][-1].startswith("the block has changed since 2026-03-01, or one of the two runs is wrong: ")
    assert told["warnings"][-1].endswith("; the prior is not used")
    assert done.stderr == f"tumble: warning: {told['warnings'][-1]}\n"
    text = tumble(*options(folder, "changed.csv")).stdout
    assert text.startswith("PASS") and "\nBeware: the block has changed since 2026-03-01" in text
    assert "365 days earlier, NOT USED" in text


def test_another_block_under_the_same_number_is_told(folder, tmp_path, tumble, refused):
    """Changed by 1 %, a thousand u, where nothing is linear: still no disagreement of two computations."""
    other, sizes = NOMINAL_K * 1.01 + np.arange(9).reshape(3, 3) * 2e-3, U0 + 0.05
    write_run(folder / "other.csv", PAPER, simulated(PAPER, other, sizes, seed=15))
    write_run(folder / "other_one.csv", ONE, simulated(ONE, other, sizes, seed=15))
    done = tumble(*options(folder, "other.csv"), "--json")
    told = valid(done.stdout)
    assert done.returncode == 1 and not told["prior"]["used"] and told["prior"]["p"] == 0.0
    assert np.abs(np.array(told["K"]) - other).max() < 4.0 * np.max(told["u_K"])
    assert "the block has changed since 2026-03-01" in refused(*options(folder, "other_one.csv"))


def test_a_changed_block_has_no_result_where_the_run_does_not_determine_it(folder, refused):
    said = refused(*options(folder, "changed_one.csv"))
    assert said.startswith(f"tumble: {folder / 'changed_one.csv'}: the block has changed since 2026-03-01, or one of")
    assert said.endswith("; these positions without a prior cannot identify K_xy, K_yy, K_zy\n")


@pytest.mark.parametrize("confidence, used", [("0.99", True), ("0.9", False)])
def test_the_confidence_decides(folder, tumble, confidence, used):
    """Of a block of a type that is known to change so much."""
    done = tumble(*options(folder, "changed.csv", "50,20,100"), "--json", "--confidence", confidence)
    told = valid(done.stdout)["prior"]
    assert 0.02 < told["p"] < 0.08 and told["used"] == used and done.returncode == (0 if used else 1)


def test_another_temperature_is_no_growth(folder, tmp_path, tumble):
    warm, document = tmp_path / "warm.json", json.loads((folder / "last.json").read_text())
    warm.write_text(json.dumps(document | {"temperature": {"min_c": 39.0, "max_c": 41.0, "source": "run_file"}}))
    text = (folder / "stand.toml").read_text()
    for at, said in ((25, True), (42, False)):
        (tmp_path / "at.toml").write_text(text.replace("[environment]\n", f"[environment]\ntemperature_c = {at}\n"))
        run = ["solve", folder / "full.csv", "--stand", tmp_path / "at.toml"]
        done = tumble(*run, "--prior", warm, "--growth", "50,20,50")
        told = "the prior is of 39 to 41 deg C, the run of 25 deg C: growth counts days, not kelvins"
        assert (f"tumble: warning: {told}\n" == done.stderr) == said and done.returncode == 0


@pytest.mark.parametrize(
    "more, why",
    [
        (["--estimator", "refined"], "--prior enters the least squares of --estimator optimal; refined has none"),
        (["--estimator", "averaged"], "--prior enters the least squares of --estimator optimal; averaged has none"),
        (["--estimator", "optimal", "--model", "k2,drift"],
         "--prior is of the twelve coefficients alone: leave out --model k2,drift"),
        (["--monte-carlo", "1000"], "--monte-carlo draws runs alone, without a prior: leave out --prior"),
        (["--db", "h.db"], "--db is for --prior history"),
        (["--growth", "1,2"], "--growth: '1,2' is not three numbers from 0 to 100000, ppm, urad and ug a year"),
        (["--growth", "1,2,x"], "--growth: '1,2,x' is not three numbers from 0 to 100000, ppm, urad and ug a year"),
        (["--growth", "1,-2,3"], "--growth: '1,-2,3' is not three numbers from 0 to 100000, ppm, urad and ug a year"),
        (["--temperature", "linear"], "--prior is for one run, not for --temperature"),
    ],
)  # fmt: skip
def test_options_that_contradict_each_other_are_refused(folder, refused, more, why):
    assert refused(*options(folder, "full.csv"), *more) == f"tumble: {why}\n"


def test_a_prior_needs_growth_stand_and_serial(folder, tmp_path, refused):
    run, prior = folder / "full.csv", ["--prior", folder / "last.json"]
    stand = ["--stand", folder / "stand.toml"]
    said = refused("solve", run, *stand, *prior)
    assert said == (
        "tumble: --prior: nobody says how much such a block changes: give --growth SCALE,ANGLE,BIAS, in ppm, urad and"
        " ug a year\n"
    )
    growth = ["--growth", "1,1,1"]
    said = refused("solve", run, *prior, *growth)
    assert said == "tumble: --prior needs --stand FILE: without uncertainties nothing can be weighed\n"
    said = refused("solve", run, "--stand", EXAMPLES / "paper_stand.toml", *prior, *growth)
    assert said == "tumble: --prior: this run names no block: write serial under [block] of the stand file\n"
    assert refused("solve", run, *stand, *growth) == "tumble: --growth: without --prior there is nothing that grows\n"
    said = refused("solve", folder / "first.csv", *stand, *prior, *growth)
    assert said == f"tumble: {folder / 'last.json'}: is of this very run: a prior is of an earlier one\n"
    said = refused("solve", run, *stand, *prior, *growth, "--out", folder / "last.json")
    assert said.startswith("tumble: --out: ") and said.endswith(" is an input of this command\n")
    inclined = ["--schedule", "inclined"]
    said = refused("solve", EXAMPLES / "inclined_stand.csv", *stand, *prior, *growth, *inclined)
    assert said == "tumble: --prior takes no block that is inclined with its stand: its run determines all by itself\n"


def test_scripts_give_results(folder):
    given = {"stand": folder / "stand.toml", "growth": (50.0, 20.0, 50.0)}
    by_path = package.solve(folder / "one.csv", prior=folder / "last.json", **given)
    by_result = package.solve(folder / "one.csv", prior=package.load(folder / "last.json"), **given)
    assert by_path.K.tolist() == by_result.K.tolist() and by_path.passed
    assert by_result.document["prior"]["source"] == "prior"
    with pytest.raises(UsageError, match=r"^prior: a int is neither a result nor the path of one$"):
        package.solve(folder / "one.csv", prior=3, **given)
    with pytest.raises(UsageError, match=r"^prior: nobody says .* give growth=\(SCALE, ANGLE, BIAS\), in ppm"):
        package.solve(folder / "one.csv", prior=folder / "last.json", stand=folder / "stand.toml")
    with pytest.raises(UsageError, match=r'^growth: .* is not three numbers'):
        package.solve(folder / "one.csv", prior=folder / "last.json", stand=folder / "stand.toml", growth=(1, 2))
    with pytest.raises(UsageError, match=r'^prior= enters the least squares of estimator="optimal"; refined has none$'):
        package.solve(folder / "one.csv", prior=folder / "last.json", estimator="refined", **given)


# From the history.


@pytest.fixture(scope="module")
def history(folder):
    """A fleet of one type, and the calibration of the block; of the run itself a result, too."""
    path = folder / "history.db"
    with History(path) as opened:
        opened.add_rows(rows_of(fleet(40, 6, 5).series, "T-7"))
        opened.add(folder / "last.json", type="T-7")
    return path


def test_the_history_gives_the_last_calibration_and_the_growth_of_its_type(folder, history, tumble):
    by_history = [*alone(folder, "one.csv"), "--prior", "history", "--db", history, "--json"]
    done = tumble(*by_history)
    assert done.returncode == 0, done.stderr
    prior = valid(done.stdout)["prior"]
    assert prior["growth_by"] == "history" and prior["source"] == f"{history}: A-1 of 2026-03-01"
    with History(history) as opened:
        told = opened.trend(type="T-7").types[0].growth
    years = 365.0 / 365.25
    grown = [1e-6 * (one.walk**2 * years + (one.spread * years) ** 2) ** 0.5 for one in told[:9]]
    drift = [1e-6 * one.drift * years for one in told[:9]]
    of = [*prior["growth"]["scale"], *prior["growth"]["angle_rad"], *prior["growth"]["bias_g"]]
    assert of == pytest.approx(grown, rel=1e-9, abs=1e-15)
    of = [*prior["drift"]["scale"], *prior["drift"]["angle_rad"], *prior["drift"]["bias_g"]]
    assert of == pytest.approx(drift, rel=1e-9, abs=1e-15)
    assert valid(tumble(*by_history, "--growth", "9,9,9").stdout)["prior"]["growth_by"] == "declared"


def test_a_later_calibration_and_the_run_itself_are_passed_over(folder, tmp_path):
    document = json.loads((folder / "last.json").read_text())
    with History(tmp_path / "h.db") as opened:
        for name, day in (("a", "2026-01-05"), ("b", "2026-02-05"), ("c", "2026-03-05")):
            document |= {"environment": {"date": day}, "run_sha256": 64 * name}
            (tmp_path / f"{name}.json").write_text(json.dumps(document))
            opened.add(tmp_path / f"{name}.json")
        of = {"growth": GROWTH}
        assert iso(opened.prior("A-1", **of).measured_s).startswith("2026-03-05")
        assert iso(opened.prior("A-1", on="2026-03-04", **of).measured_s).startswith("2026-02-05")
        assert iso(opened.prior("A-1", on="2026-03-05", **of).measured_s).startswith("2026-03-05")
        assert iso(opened.prior("A-1", other_than_run="c" * 64, **of).measured_s).startswith("2026-02-05")
        with pytest.raises(BadInput, match="no earlier calibration of block 'A-1' that may be a prior"):
            opened.prior("A-1", on="2025-12-31", **of)
        with pytest.raises(BadInput, match="no calibration of block 'Z'"):
            opened.prior("Z", **of)
        with pytest.raises(UsageError, match=r"^growth of type '-' unknown: 2 intervals between calibrations, 10 are"):
            opened.prior("A-1")


def test_a_calibration_with_further_terms_is_passed_over(folder, tmp_path):
    """Its twelve coefficients mean something else."""
    bent = json.loads((folder / "bent.json").read_text()) | {"environment": {"date": "2026-03-05"}}
    (tmp_path / "bent.json").write_text(json.dumps(bent))
    with History(tmp_path / "h.db") as opened:
        opened.add(tmp_path / "bent.json")
        with pytest.raises(BadInput, match="no earlier calibration of block 'A-1' that may be a prior"):
            opened.prior("A-1", growth=GROWTH)
        opened.add(folder / "last.json")
        assert iso(opened.prior("A-1", growth=GROWTH).measured_s).startswith("2026-03-01")


def test_what_rests_on_a_prior_is_no_calibration_of_its_own(folder, tmp_path, tumble, refused):
    """The history would count the earlier one twice. A prior that was not used changes nothing."""
    done = tumble(*options(folder, "one.csv"), "--out", tmp_path / "one.json")
    assert done.returncode == 0
    said = refused("history", "add", tmp_path / "one.json", "--db", tmp_path / "h.db")
    why = "rests on an earlier calibration, which would count twice: solve it without --prior"
    assert said == f"tumble: {tmp_path / 'one.json'}: {why}\n"
    for pair in ((folder / "last.json", tmp_path / "one.json"), (tmp_path / "one.json", folder / "last.json")):
        why = "rests on an earlier calibration, which hides a change: solve it without --prior"
        assert refused("compare", *pair) == f"tumble: {tmp_path / 'one.json'}: {why}\n"
    tumble(*options(folder, "changed.csv"), "--out", tmp_path / "changed.json")
    row = row_of((tmp_path / "changed.json").read_bytes(), "changed.json")
    assert row["serial"] == "A-1" and row["believed"]
    assert "HAS CHANGED" in tumble("compare", folder / "last.json", tmp_path / "changed.json").stdout


# In many runs.


@pytest.mark.parametrize("kind", campaign.POSITIONS)
def test_uncertainties_and_alarms_are_right(kind):
    found = shares(campaign.Blocks("paper", kind, GROWTH, 41), 100)
    assert all(90.0 < one < 99.0 for one in found[:2]) and found[2] <= 2


@pytest.mark.full
@pytest.mark.parametrize("stand", ["paper", "lab"])
@pytest.mark.parametrize("kind", campaign.POSITIONS)
def test_uncertainties_and_alarms_are_right_at_length(stand, kind):
    found = shares(campaign.Blocks(stand, kind, GROWTH, 42), 1000)
    assert all(93.5 < one < 97.0 for one in found[:2]) and found[2] <= 5


def shares(blocks, runs):
    told = campaign.coverage(blocks, runs)
    alarms = int(told["false alarms"].split()[0])
    of_parameters = float(told["parameters within 1.96 u, %"].split()[0])
    return of_parameters, float(told["worst |a| within 1.96 u, %"]), alarms
