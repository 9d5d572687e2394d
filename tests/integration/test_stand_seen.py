"""The stand seen in the data: do its numbers lie where they say, on the exact geometry and on all example stands?"""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import core_stand_seen as stand_seen
import numpy as np
import pytest
from blocks import random_block, random_means, usable_schedule
from documents import paper_stand

from tumble import core, model
from tumble.distributions import f_cdf
from tumble.errors import Disagreement
from tumble.files.stand_file import read_stand
from tumble.model.stand_seen import estimate_stand_errors
from tumble.schedule import CHECK, Position, Schedule

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
STANDS = ("paper", "angle", "lab")
PAPER = model.built_in("paper")
NOMINAL_K = np.full((3, 3), 0.04) + 1.96 * np.eye(3)
U0 = np.array([0.02, -0.01, 0.03])
RUNS = 10000


def stand_named(name):
    return read_stand(str(EXAMPLES / f"{name}_stand.toml")).stand


def simulated(rng, stand, runs):
    """Of each run means, scatter, and what the angles are."""
    alpha1, alpha2 = (rng.normal(size=(runs, 1)) * stand.sigma(source) for source in ("axis_tilt", "level"))
    alpha3, delta = (rng.normal(size=(runs, n)) * stand.sigma(source) for n, source in ((2, "remount"), (18, "angle")))
    means = model.Geometry(PAPER).outputs(NOMINAL_K, U0, alpha1=alpha1, alpha2=alpha2, alpha3=alpha3, delta=delta)
    noise, n = stand.sigma("noise"), stand.samples
    means += rng.normal(size=means.shape) * noise / math.sqrt(n)
    scatter = noise * np.sqrt(rng.chisquare(n - 1, size=means.shape) / (n - 1))
    truth = np.column_stack([alpha1, alpha2[:, 0] + alpha3.mean(axis=1), alpha3[:, 0] - alpha3[:, 1]])
    return [(*run, dict(zip(stand_seen.ANGLES, angles))) for *run, angles in zip(means, scatter, truth.tolist())]


@cache
def scores(name):
    """z-scores of RUNS runs of a stand, by quantity; of alpha4 its chi-squared, less its mean, over its deviation."""
    stand, rng = stand_named(name), np.random.default_rng(81 + STANDS.index(name))
    schedule, samples, measured = core.CoreSchedule(PAPER), np.full(18, stand.samples), np.ones(18, bool)
    variance, alpha4 = np.full(18, stand.sigma("noise") ** 2 / stand.samples), stand.sigma("angle")
    rows = []
    for means, scatter, truth in simulated(rng, stand, RUNS):
        k, u0 = core.estimate(schedule, means)
        seen = stand_seen.RunSeen(schedule, means, measured, k, u0)
        closed, sharp = seen.angles(alpha4, variance), seen.fit(alpha4, variance)
        noise = stand_seen.noise(samples, scatter)
        chi_squared, freedom = seen.angle_chi_squared(alpha4, variance)
        row = {key: (closed[key].value - value) / closed[key].u for key, value in truth.items()}
        row |= {f"augmented {key}": (sharp[key].value - value) / sharp[key].u for key, value in truth.items()}
        row["noise"] = (noise.value - stand.sigma("noise")) / noise.u
        row["alpha4"] = (chi_squared - freedom) / math.sqrt(2 * freedom)
        rows.append(row)
    return {key: np.array([row[key] for row in rows]) for key in rows[0]}


@pytest.mark.toolchain
@pytest.mark.slow
@pytest.mark.parametrize("name", STANDS)
def test_what_is_seen_lies_where_its_uncertainty_says(name):
    """Mean 0 and rms 1 within 5 % each: 10,000 runs know them to 1 % and 0.7 %."""
    for key, z in scores(name).items():
        mean, rms = z.mean(), math.sqrt((z**2).mean())
        print(f"{name:6} {key:32} mean {mean:+.4f}  rms {rms:.4f}")
        assert abs(mean) < 0.05, key
        assert abs(rms - 1) < 0.05, key


@pytest.mark.toolchain
@pytest.mark.slow
@pytest.mark.parametrize("name", STANDS)
def test_the_runs_own_alpha4_and_student(name):
    """alpha4 from the run: its square is unbiased, its freedom that of its scatter. With it the angles' intervals by
    Student's t hold 95 % at least: a part of their uncertainty is the noise, which is known better than alpha4."""
    stand, rng, runs = stand_named(name), np.random.default_rng(84), 1500
    schedule, samples, measured = core.CoreSchedule(PAPER), np.full(18, stand.samples), np.ones(18, bool)
    sigma = stand.sigma("angle")
    squares, freedoms, inside = [], [], dict.fromkeys(stand_seen.ANGLES, 0)
    for means, scatter, truth in simulated(rng, stand, runs):
        k, u0 = core.estimate(schedule, means)
        seen = stand_seen.RunSeen(schedule, means, measured, k, u0)
        variance = stand_seen.noise(samples, scatter).value ** 2 / samples
        error, freedom = seen.angle_error(variance)
        squares.append(0.0 if error is None else error.value**2)
        freedoms.append(freedom)
        alpha4 = math.sqrt(squares[-1])
        for key, angle in seen.angles(alpha4, variance).items():
            inside[key] += f_cdf(((angle.value - truth[key]) / angle.u) ** 2, 1.0, max(freedom, 1.0)) <= 0.95
    squares = np.array(squares) / sigma**2
    share = {key: count / runs for key, count in inside.items()}
    print(f"{name:6} alpha4^2 {squares.mean():.3f}, freedom by scatter {2 / squares.var():.1f},", end=" ")
    print(f"stated {np.mean(freedoms):.1f}; {share}")
    assert squares.mean() == pytest.approx(1.0, abs=4 * math.sqrt(squares.var() / runs))
    assert np.mean(freedoms) == pytest.approx(2 / squares.var(), rel=0.2)
    assert all(0.94 <= value <= 0.99 for value in share.values())


def test_core_and_numpy_see_the_same_on_any_schedule():
    """Random schedules, blocks of any size and sign, positions left out: 1e-6 of u, and the same things unknown."""
    rng, known, unknown = np.random.default_rng(85), 0, 0
    for _ in range(150):
        schedule = usable_schedule(rng)
        k, u0 = random_block(rng)
        means = random_means(rng, schedule.data, k, u0)
        variance = (np.abs(k).max() * 10.0 ** rng.uniform(-6, -3, len(schedule))) ** 2
        core_eye = stand_seen.RunSeen(schedule, means, np.ones(len(schedule), bool), k, u0)
        numpy_eye = model.RunSeen(schedule.data, means, k)
        alpha4 = 10.0 ** rng.uniform(-6, -2)
        pairs = [(core_eye.angle_error(variance)[0], numpy_eye.angle_error(variance)[0])]
        found, expected = core_eye.fit(alpha4, variance), numpy_eye.fit(alpha4, variance)
        pairs += [(found[name], expected[name]) for name in found]
        assert list(found) == list(expected)
        for mine, other in pairs:
            assert (mine is None) == (other is None), schedule.data
            known, unknown = known + (mine is not None), unknown + (mine is None)
            if mine is not None:
                assert mine.value == pytest.approx(other.value, abs=1e-6 * other.u + 1e-12)
                assert mine.u == pytest.approx(other.u, rel=1e-6)
        square, freedom = core_eye.angle_chi_squared(alpha4, variance)
        expected_square, expected_freedom = numpy_eye.angle_chi_squared(alpha4, variance)
        assert freedom == expected_freedom
        assert square == pytest.approx(expected_square, rel=1e-6, abs=1e-6)
    assert known > 200 and unknown > 50


def test_a_run_without_noise_or_errors_is_no_trouble():
    """Weights have a floor: 1e-7 of max|K| in a mean."""
    schedule, measured = core.CoreSchedule(PAPER), np.ones(18, bool)
    means = model.Geometry(PAPER).outputs(NOMINAL_K, U0)
    k, u0 = core.estimate(schedule, means)
    seen = stand_seen.RunSeen(schedule, means, measured, k, u0)
    assert seen.angle_error(np.zeros(18))[0] is None
    for angle in seen.fit(0.0, np.zeros(18)).values():
        assert abs(angle.value) < 1e-12 and 0 < angle.u < 1e-6
    delta = np.zeros(18)
    delta[4] = 1e-4
    one = model.Geometry(PAPER).outputs(NOMINAL_K, U0, delta=delta)
    k, u0 = core.estimate(schedule, one)
    found, freedom = stand_seen.RunSeen(schedule, one, measured, k, u0).angle_error(np.zeros(18))
    assert 1e-5 < found.value < 5e-5 and freedom == pytest.approx(16, rel=1e-3)


def test_means_that_are_not_measured_are_not_looked_at():
    partial = Schedule(PAPER.mountings, tuple(p for p in PAPER.positions if p.label not in ("1.2", "2.7")))
    rng = np.random.default_rng(86)
    whole = core.CoreSchedule(PAPER)
    means = random_means(rng, PAPER, NOMINAL_K, U0)
    measured = np.array([p.label not in ("1.2", "2.7") for p in PAPER.positions])
    spoilt = np.where(measured[:, None], means, np.nan)
    k, u0 = core.estimate(whole, means, measured, "least_squares")
    variance = np.full(18, 1e-9)
    found = stand_seen.RunSeen(whole, spoilt, measured, k, u0).fit(1e-4, variance)
    expected = model.RunSeen(partial, means[measured], k).fit(1e-4, variance[measured])
    for name, angle in found.items():
        assert angle.value == pytest.approx(expected[name].value, abs=1e-6 * angle.u)
    assert set(stand_seen.RunSeen(whole, spoilt, measured, k, u0).angles(None, variance).values()) == {None}


def test_a_stand_that_declares_no_noise_is_no_disagreement(tumble, tmp_path):
    """Its weights lie as far apart as the floor of the noise lets them."""
    done = tumble("solve", EXAMPLES / "paper_stand.csv", "--stand", paper_stand(tmp_path, noise_v=0))
    assert done.returncode == 1 and "does not fit the stand file: noise" in done.stderr


def drawn_in_three_mountings(schedule):
    """What core and witness tell of a run on a schedule that holds the paper's positions and others."""
    geometry, stand = model.Geometry(schedule), stand_named("paper")
    yaws = [{3: 1e-3, 1: 4e-4, 2: -2e-4}[mounting.number] for mounting in schedule.mountings]
    means = geometry.outputs(NOMINAL_K, U0, alpha1=2e-5, alpha2=1e-5, alpha3=np.array(yaws), delta=0.0)
    measured, variance = np.ones(len(means), bool), np.full(len(means), 1e-9)
    k, u0 = core.estimate(core.CoreSchedule(schedule), means, measured, "least_squares")
    shown = stand_seen.RunSeen(core.CoreSchedule(schedule), means, measured, k, u0)
    return [run.fit(stand.sigma("angle"), variance) for run in (shown, model.RunSeen(schedule, means, k))]


@pytest.mark.parametrize("first", [False, True])
@pytest.mark.parametrize("checks", [0, 1])
def test_a_mounting_without_fit_positions_takes_no_part(first, checks):
    """It has a yaw, but nothing to show it by: that must not hide those of the others."""
    third = replace(PAPER.mountings[0], number=3)
    mountings = (third, *PAPER.mountings) if first else (*PAPER.mountings, third)
    schedule = Schedule(mountings, PAPER.positions + (Position(3, 1, 20.0, CHECK),) * checks)
    assert len(schedule.fitted_mountings) == 2
    for found in drawn_in_three_mountings(schedule):
        for name, value in {"alpha1": 2e-5, "alpha2_plus_alpha3": 1.1e-4, "alpha3_difference": 6e-4}.items():
            assert found[name].value == pytest.approx(value, abs=3e-6)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_coarse_converter_is_no_disagreement(seed, tumble, tmp_path):
    """Steps of 4.9 mV under a noise of 1 uV: residuals are 10,000 times what the noise allows."""
    converter = "converter_bits = 12\nrange_v = 10.0\n"
    stand = paper_stand(tmp_path, block=converter, noise_v="1e-6", delta_g_limit_g=0.01)
    done = tumble("bench", "--stand", stand, "--seed", str(seed), "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr


def test_a_run_of_another_schedule_is_no_disagreement(tumble):
    """Taken for positions 45 degrees off, its set angles come out at 2 rad."""
    run = EXAMPLES / "diagonal_stand.csv", "--stand", EXAMPLES / "diagonal_stand.toml"
    done = tumble("solve", *run, "--schedule", "three_mountings", "--estimator", "least_squares")
    assert done.returncode == 1 and "FAIL" in done.stdout, done.stderr


@pytest.mark.parametrize("spread", [5e-3, 1e-4, 1e-6])
@pytest.mark.parametrize("noise", [1e-6, 1e-9])
def test_core_and_witness_agree_far_beyond_the_noise(noise, spread):
    rng, schedule = np.random.default_rng(87), core.CoreSchedule(PAPER)
    stand, samples, scatter = replace(stand_named("paper"), noise=noise), np.full(18, 50), np.full((18, 3), noise)
    for drawn, _, _ in simulated(rng, stand, 10):
        means = drawn + rng.normal(size=(18, 3)) * spread
        k, u0 = core.estimate(schedule, means)
        shown = stand_seen.RunSeen(schedule, means, np.ones(18, bool), k, u0)
        for trust in (True, False):
            seen = estimate_stand_errors(shown, stand_seen.noise(samples, scatter), samples, stand, trust)
            stand_seen.compare_seen(seen, model.RunSeen(PAPER, means, k), samples, scatter, stand, trust)


@pytest.mark.parametrize("name", ["three_mountings", "diagonal"])
def test_three_mountings_show_the_yaw_of_each(name):
    """Small yaws without any other error, to first order exact; the second order is some 1e-11."""
    schedule, yaws = model.built_in(name), np.array([3e-6, -1e-6, 2e-6])
    k, u0 = np.array([[2.0, 0.03, 0.02], [-0.01, 1.9, 0.04], [0.05, -0.02, 2.1]]), np.array([0.1, 0.2, -0.1])
    means = model.Geometry(schedule).outputs(k, u0, alpha3=yaws)
    measured, variance = np.ones(len(means), bool), np.full(len(means), 1e-10)
    for seen in (stand_seen.RunSeen(core.CoreSchedule(schedule), means, measured, k, u0),
                 model.RunSeen(schedule, means, k)):  # fmt: skip
        changes = {one: change for one, change in seen.fit(1e-5, variance).items() if one not in stand_seen.ANGLES}
        assert list(changes) == [3] and changes[3].value == pytest.approx(yaws[0] - yaws[2], abs=1e-10)
        assert seen.fit(1e-5, variance)["alpha3_difference"].value == pytest.approx(yaws[0] - yaws[1], abs=1e-10)
        assert changes[3].u > 0.0


def test_two_mountings_have_no_other_yaw():
    means = model.Geometry(PAPER).outputs(np.eye(3), np.zeros(3))
    seen = stand_seen.RunSeen(core.CoreSchedule(PAPER), means, np.ones(18, bool), np.eye(3), np.zeros(3))
    assert set(seen.fit(1e-5, np.full(18, 1e-10))) == set(stand_seen.ANGLES)


def test_people_read_the_yaw_of_each_mounting(tumble):
    common = "--schedule", "three_mountings", "--stand", EXAMPLES / "three_mountings_stand.toml"
    shown = tumble("solve", EXAMPLES / "three_mountings_stand.csv", *common, "--details").stdout
    lines = shown[shown.index("Stand seen:") :].splitlines()[:6]
    names = ["axis tilt", "level + yaw", "yaw 1 - 2", "yaw 1 - 3", "set angle", "noise"]
    assert [line[12:24].strip() for line in lines] == names


def hardly_any_set_angles(rng, above):
    """A run whose noise leaves so much of chi-squared `above` its degrees of freedom, relative to them."""
    schedule, samples, measured = core.CoreSchedule(PAPER), np.full(18, 5), np.ones(18, bool)
    k, u0 = random_block(rng)
    means = model.Geometry(PAPER).outputs(k, u0) + 1e-4 * np.abs(k).max() * rng.normal(size=(18, 3))
    k, u0 = core.estimate(schedule, means)
    shown = stand_seen.RunSeen(schedule, means, measured, k, u0)
    chi_squared, freedom = shown.angle_chi_squared(0.0, np.ones(18))
    scatter = np.full((18, 3), math.sqrt(5 * chi_squared / freedom / (1 + above)))
    return shown, model.RunSeen(PAPER, means, k), samples, scatter


@pytest.mark.parametrize("above", [1e-3, 1e-5, 1e-7, 1e-9])
def test_set_angles_hardly_worse_than_the_noise_are_no_disagreement(above):
    """What rounding leaves of the square of alpha4 its root magnifies, and the uncertainty of that even more."""
    rng = np.random.default_rng(84)
    for _ in range(20):
        shown, witness, samples, scatter = hardly_any_set_angles(rng, above)
        found = estimate_stand_errors(shown, stand_seen.noise(samples, scatter), samples, None)
        assert found.alpha4 is not None and found.alpha4.u > 10 * found.alpha4.value
        stand_seen.compare_seen(found, witness, samples, scatter, None)
        with pytest.raises(Disagreement, match="alpha4 squared"):
            larger = replace(found.alpha4, u=found.alpha4.u * (1 + 1e-5))
            stand_seen.compare_seen(replace(found, alpha4=larger), witness, samples, scatter, None)
