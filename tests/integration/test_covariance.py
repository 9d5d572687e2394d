"""The covariance of the coefficients, and what follows from it: against the core, closed forms, brute force, runs."""

import dataclasses

import numpy as np
import pytest
from blocks import NOMINAL_K, random_block, usable_schedule
from conftest import EXAMPLES
from documents import document_of
from hypothesis import given, settings, strategies as st
from test_crosscheck import plant, solve_with_defect
from test_plan_uncertainty import random_samples, random_stand

from tumble import core, model
from tumble.core import estimate_runs, uncertainties_of_gains
from tumble.estimators import LINEAR
from tumble.files.stand_file import read_stand
from tumble.model.coefficients import intrinsic_uncertainties, norm_uncertainty, worst_norm
from tumble.model.estimators import linear_gains
from tumble.model.optimal import optimal_table
from tumble.model.propagation import Propagation
from tumble.planning.case import Case
from tumble.planning.validate import U0_V, position_means
from tumble.stand import Stand

pytestmark = pytest.mark.python
PAPER = model.built_in("paper")
ONES = np.ones(18, dtype=int)
NOTHING = Stand(axis_tilt=0.0, level=0.0, remount=0.0, angle=0.0, noise=0.0, samples=1, limits="sigma1")
WORST_UG = {"refined": (20.3, 61.1, 149.6), "optimal": (14.6, 11.1, 36.7)}  # worked out by an independent program
STANDS = ("paper", "angle", "lab")
seeds = st.integers(0, 2**32 - 1)


def case_of(name):
    return Case.of(read_stand(str(EXAMPLES / f"{name}_stand.toml")), name, None)


def of_paper(estimator, k=NOMINAL_K, **sources):
    return model.Propagation(PAPER, k, dataclasses.replace(NOTHING, **sources), ONES, estimator).covariance()


def of_optimal(case, k, samples=ONES):
    means = model.Geometry(case.fitted).outputs(k, np.array(U0_V))
    return model.optimal_estimate(case.fitted, means, case.stand, samples, case.step_v).covariance


def random_covariance(rng, rank):
    """Of coefficients of size 1; with a rank of 1 it is as peaked as can be."""
    draws = rng.normal(size=(rank, 12)) * 10.0 ** rng.uniform(-3, 0, 12)
    return draws.T @ draws


def assert_core_confirms(schedule, k, stand, samples, weights, covariance, agreement):
    """The core's uncertainties of any mixtures of the coefficients show all that is off the diagonal."""
    mixtures = np.random.default_rng(7).normal(size=(12, 12)) / np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    stated = np.concatenate(
        [u.ravel() for u in uncertainties_of_gains(schedule, k, stand, samples, mixtures @ weights)]
    )
    expected = np.sqrt(np.einsum("mi,ij,mj->m", mixtures, covariance, mixtures))
    assert stated == pytest.approx(expected, rel=agreement)


@given(seeds)
@settings(max_examples=100)
def test_the_core_confirms_all_of_it(seed):
    rng = np.random.default_rng(seed)
    schedule, (k, _) = usable_schedule(rng), random_block(rng)
    stand = dataclasses.replace(random_stand(rng), noise=1e-4 * np.abs(k).max())
    samples = random_samples(rng, schedule.data)
    covariance = model.Propagation(schedule.data, k, stand, samples, "least_squares").covariance()
    weights = linear_gains(schedule.data, "least_squares")
    assert_core_confirms(schedule, k, stand, samples, weights, covariance, 1e-8)


@pytest.mark.parametrize("name", STANDS)
@pytest.mark.parametrize("estimator", ["averaged", "refined", "optimal"])
def test_the_core_confirms_that_of_every_estimator(name, estimator):
    case, schedule = case_of(name), core.CoreSchedule(PAPER)
    k = case.nominal_k()
    if estimator == "optimal":
        covariance, weights = of_optimal(case, k), optimal_table(PAPER, k, case.stand, case.step_v).gains
    else:
        covariance = model.Propagation(PAPER, k, case.stand, ONES, estimator).covariance()
        weights = linear_gains(PAPER, estimator)
    assert_core_confirms(schedule, k, case.stand, ONES, weights, covariance, 1e-7)


def test_of_noise_by_hand():
    """With c, s, b of the paper's formulas: the squares of their weights are 14, 16 and 7.5 of 64, c times b is -1."""
    expected = np.zeros((12, 12))
    for i in range(3):
        x, y, z, u0 = 3 * i, 3 * i + 1, 3 * i + 2, 9 + i
        expected[x, x] = 8 / 64 if i == 0 else 16 / 64
        expected[y, y] = expected[z, z] = 14 / 64
        expected[u0, u0] = 3.75 / 64
        expected[[y, z, u0, u0], [u0, u0, y, z]] = -0.5 / 64
    assert of_paper("refined", noise=1.0) == pytest.approx(expected, abs=1e-15)


def test_of_a_level_by_hand():
    """A level turns mounting 1 about y, mounting 2 about z; one error, so the covariance is of rank one."""
    k = NOMINAL_K + np.arange(9).reshape(3, 3) / 100
    moved = np.zeros((3, 3))
    moved[:, 1], moved[:, 2] = -k[:, 0], k[:, 0]
    moved[:, 0] = (k[0, 1] - k[0, 2]) / 2, k[1, 1], -k[2, 2]
    by_level = np.concatenate([moved.ravel(), np.zeros(3)])
    assert of_paper("refined", k, level=1e-3) == pytest.approx(1e-6 * np.outer(by_level, by_level), abs=1e-18)


def test_a_rotation_of_the_block_leaves_the_length_alone():
    """`refined` sees a level as a rotation of an orthogonal block. `averaged` mixes two rotations: by hand the length
    is off by n_x (n_z - n_y)/2 of the level, sqrt(2)/4 at most."""
    assert worst_norm(2 * np.eye(3), of_paper("refined", 2 * np.eye(3), level=1e-3)).worst_g < 1e-12
    worst = worst_norm(2 * np.eye(3), of_paper("averaged", 2 * np.eye(3), level=1e-3))
    assert worst.worst_g == pytest.approx(2**0.5 / 4 * 1e-3, rel=1e-12)
    assert np.abs(worst.attitude) == pytest.approx([0.5**0.5, 0.5, 0.5], abs=1e-6)


def test_a_bias_alone_is_as_bad_everywhere():
    covariance = np.zeros((12, 12))
    covariance[9:, 9:] = 4e-10 * np.eye(3)
    assert worst_norm(2 * np.eye(3), covariance).worst_g == pytest.approx(1e-5, rel=1e-12)
    everywhere = np.random.default_rng(1).normal(size=(50, 3))
    everywhere /= np.linalg.norm(everywhere, axis=1)[:, None]
    assert norm_uncertainty(-2 * np.eye(3), covariance, everywhere) == pytest.approx(np.full(50, 1e-5), rel=1e-12)


@pytest.mark.parametrize("estimator", WORST_UG)
@pytest.mark.parametrize("name", STANDS)
def test_worst_length_of_the_example_stands(name, estimator):
    case = case_of(name)
    k = case.nominal_k()
    linear = estimator in LINEAR
    given = model.Propagation(PAPER, k, case.stand, ONES, estimator)
    covariance = given.covariance() if linear else of_optimal(case, k)
    expected = WORST_UG[estimator][STANDS.index(name)]
    assert worst_norm(k, covariance).worst_g * 1e6 == pytest.approx(expected, rel=0.01)


@given(seeds)
@settings(max_examples=25)
def test_no_attitude_is_worse(seed):
    """Brute force: 200,000 attitudes at random, and then 20,000 around the worst of them."""
    rng = np.random.default_rng(seed)
    k, _ = random_block(rng)
    covariance = random_covariance(rng, int(rng.integers(1, 13))) * np.abs(k).max() ** 2
    worst = worst_norm(k, covariance)
    assert norm_uncertainty(k, covariance, worst.attitude) == pytest.approx(worst.worst_g, rel=1e-12)
    assert np.linalg.norm(worst.attitude) == pytest.approx(1.0, abs=1e-12)
    anywhere = rng.normal(size=(200_000, 3))
    anywhere /= np.linalg.norm(anywhere, axis=1)[:, None]
    found = norm_uncertainty(k, covariance, anywhere)
    around = anywhere[found.argmax()] + 0.01 * rng.uniform(-1, 1, (20_000, 3))
    around /= np.linalg.norm(around, axis=1)[:, None]
    highest = norm_uncertainty(k, covariance, around).max()
    assert highest <= worst.worst_g * (1 + 1e-12)
    assert worst.worst_g <= highest * (1 + 1e-3)


def force_covariance(k, covariance, n):
    """Of the specific force that the calibrated block shows at the attitude n: a = n - K^-1 (dK n + dU0)."""
    to_g = np.linalg.inv(k)
    by_coefficient = np.hstack([np.kron(to_g, n), to_g])
    return by_coefficient @ covariance @ by_coefficient.T


@given(seeds)
@settings(max_examples=50)
def test_the_length_is_the_force_along_itself(seed):
    rng = np.random.default_rng(seed)
    k, _ = random_block(rng)
    covariance = random_covariance(rng, 12) * np.abs(k).max() ** 2
    attitude = rng.normal(size=(4, 3))
    attitude /= np.linalg.norm(attitude, axis=1)[:, None]
    along = [np.sqrt(n @ force_covariance(k, covariance, n) @ n) for n in attitude]
    assert norm_uncertainty(k, covariance, attitude) == pytest.approx(along, rel=1e-9)


@given(seeds)
@settings(max_examples=50)
def test_intrinsic_parameters_by_differences(seed):
    rng = np.random.default_rng(seed)
    k, u0 = random_block(rng, misalignment=0.3)
    size = np.abs(k).max()
    covariance = random_covariance(rng, 12) * size**2

    def intrinsic(change):
        return np.concatenate(model.intrinsic(k + change[:9].reshape(3, 3), u0 + change[9:]))

    steps = 1e-6 * size * np.eye(12)
    gradient = np.array([(intrinsic(step) - intrinsic(-step)) / (2e-6 * size) for step in steps]).T
    expected = np.sqrt(np.einsum("ri,ij,rj->r", gradient, covariance, gradient))
    found = intrinsic_uncertainties(k, u0, covariance)
    assert np.concatenate([found.scale, found.angles, found.bias]) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("name", STANDS)
def test_runs_scatter_as_it_says(name):
    """20,000 runs of the core on the exact geometry: covariance, length at the worst attitude, intrinsic parameters."""
    case, runs = case_of(name), 20_000
    k, u0 = case.nominal_k(), np.array(U0_V)
    means = position_means(case, k, runs, np.random.default_rng(3))
    found = estimate_runs(core.CoreSchedule(PAPER), means, "refined")
    covariance = model.Propagation(PAPER, k, case.stand, ONES, "refined").covariance()
    u = np.sqrt(np.diag(covariance))
    assert np.abs(np.cov(found.T) - covariance).max(initial=0.0) <= 5 / runs**0.5 * np.outer(u, u).max()
    assert np.abs((np.cov(found.T) - covariance) / np.outer(u, u)).max() <= 5 * (2 / runs) ** 0.5
    worst = worst_norm(k, covariance)
    shown = np.linalg.solve(found[:, :9].reshape(-1, 3, 3), (k @ worst.attitude + u0 - found[:, 9:])[..., None])
    assert np.linalg.norm(shown[..., 0], axis=1).std() == pytest.approx(worst.worst_g, rel=0.03)
    stated = intrinsic_uncertainties(k, u0, covariance)
    each = [np.concatenate(model.intrinsic(one[:9].reshape(3, 3), one[9:])) for one in found[:4000]]
    expected = np.concatenate([stated.scale, stated.angles, stated.bias])
    assert np.std(each, axis=0) == pytest.approx(expected, rel=0.06)


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares", "optimal"])
def test_a_result_holds_it(estimator, tumble):
    arguments = ["lab_stand.csv", "--stand", "lab_stand.toml", "--estimator", estimator, "--json"]
    result = document_of(tumble("solve", *arguments, "--unit", "V", cwd=EXAMPLES), codes=(0, 1))
    covariance = np.array(result["covariance"])
    stated = np.concatenate([np.ravel(result["u_K"]), result["u_U0"]])
    assert np.sqrt(np.diag(covariance)) == pytest.approx(stated, rel=1e-6 if estimator == "optimal" else 1e-9)
    assert (covariance == covariance.T).all()
    assert np.linalg.eigvalsh(covariance / np.outer(stated, stated)).min() > -1e-12
    norm = result["u_norm_g"]
    found = norm_uncertainty(np.array(result["K"]), covariance, np.array(norm["attitude"]))
    assert found == pytest.approx(norm["worst_g"], rel=1e-12)
    intrinsic = intrinsic_uncertainties(np.array(result["K"]), np.array(result["U0"]), covariance)
    assert result["u_intrinsic"]["scale"] == intrinsic.scale.tolist()
    assert list(result["u_intrinsic"]["angle_rad"].values()) == intrinsic.angles.tolist()
    assert result["u_intrinsic"]["bias_g"] == intrinsic.bias.tolist()


def test_without_a_stand_it_is_null(tumble):
    result = document_of(tumble("solve", "paper_stand.csv", "--unit", "V", "--json", cwd=EXAMPLES))
    assert result["covariance"] is result["u_norm_g"] is result["u_intrinsic"] is None


def test_text_shows_what_follows(tumble):
    """The figures of the JSON, rounded; within 80 columns also in another unit."""
    for unit in ("V", "m/s^2"):
        arguments = ["solve", "lab_stand.csv", "--stand", "lab_stand.toml", "--unit", unit]
        result = document_of(tumble(*arguments, "--json", cwd=EXAMPLES), codes=(0, 1)) if unit == "V" else None
        lines = tumble(*arguments, "--details", cwd=EXAMPLES).stdout.splitlines()
        assert max(map(len, lines)) <= 80
        [start] = [index for index, line in enumerate(lines) if line.startswith("Intrinsic:")]
        if result is not None:
            for i, line in enumerate(lines[start + 1 : start + 4]):
                found, u, pair = result["intrinsic"], result["u_intrinsic"], ("xy", "xz", "yz")[i]
                words = line.split()
                assert words[0] == "xyz"[i] and words[1] == f"{found['scale'][i]:#.6g}"
                assert (words[3], words[6]) == (f"{u['scale'][i]:.1e}", f"{u['bias_g'][i]:.1e}")
                assert words[7:] == [pair, f"{found['angle_rad'][pair]:.6f}", "+-", f"{u['angle_rad'][pair]:.1e}"]
            assert lines[start + 4].startswith(f"Worst u(|a|): {result['u_norm_g']['worst_g'] * 1e6:.3g} ug, at ")
    assert "Intrinsic:" not in tumble("solve", "lab_stand.csv", "--details", cwd=EXAMPLES).stdout


@pytest.mark.parametrize("factor", [1e-12, 1e6])
def test_text_fits_with_outputs_of_any_size(factor, tumble, tmp_path):
    """Such as the counts of a converter."""
    head, *rows = (EXAMPLES / "diagonal_stand.csv").read_text().splitlines()
    names = [",".join([*row.split(",")[:2], *(str(float(u) * factor) for u in row.split(",")[2:5])]) for row in rows]
    (tmp_path / "run.csv").write_text("\n".join([head, *names]))
    stand = (EXAMPLES / "diagonal_stand.toml").read_text().partition("[block]")[0]
    (tmp_path / "stand.toml").write_text(stand.replace("noise_v = 3e-4", f"noise_v = {3e-4 * factor}"))
    run = "run.csv", "--schedule", "diagonal", "--stand", "stand.toml", "--unit", "counts"
    done = tumble("solve", *run, cwd=tmp_path)
    assert done.returncode == 0 and max(map(len, done.stdout.splitlines())) <= 80, done.stdout


@pytest.mark.parametrize("place", [0, 4, 11])
def test_a_false_diagonal_is_a_disagreement(place, monkeypatch, capsys, tmp_path):
    def spoil(covariance):
        covariance = covariance.copy()
        covariance[place, place] *= 1 + 4e-9
        return covariance

    plant(monkeypatch, Propagation, "covariance", spoil)
    code, out, err = solve_with_defect(capsys, tmp_path, "--stand", str(EXAMPLES / "paper_stand.toml"))
    assert (code, out) == (3, "") and f"u_{'K' if place < 9 else 'U0'} differs" in err
