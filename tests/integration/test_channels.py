"""Channels that differ: noise, drift, scale and range as one number or three, and blocks of mixed signs.

The exact oracle is a change of unit. Outputs of a channel in another unit are another channel: with its noise, drift
and scale in that unit too, K, U0 and their uncertainties follow, and everything that has no unit stays as it is.
"""

import argparse
import dataclasses
import json

import calibrations
import gain_record
import numpy as np
import pytest
from blocks import NOMINAL_K
from conftest import EXAMPLES
from core_functions import gains_of
from test_plausibility import block, declared, examined

import tumble as package
from tumble import core
from tumble.cli.commands import import_recording
from tumble.distributions import chi_squared_above
from tumble.documents.base import written
from tumble.errors import BadInput
from tumble.files.run_file import NO_BLOCKS, Run
from tumble.files.stand_file import read_stand
from tumble.model import Propagation, WholeModel, built_in, by_coefficient, optimal_covariance
from tumble.model.errors import exact_outputs, sources
from tumble.model.optimal import optimal_table
from tumble.planning import require
from tumble.planning.budget import budget
from tumble.planning.case import Case
from tumble.solving import optimal_run
from tumble.solving.computation import estimator_for
from tumble.solving.result import declared_stand, stand_of, step_of
from tumble.solving.solution import solve
from tumble.stand import Stand

pytestmark = pytest.mark.python
PAPER = built_in("paper")
SCALE = np.array([0.3, -2.0, 10.0])
NOISE = (4.5e-5, 3e-4, 1.5e-3)  # as many g in each channel
TUNED = 2.0 / SCALE  # the unit in which each of these channels has 2 V/g
DRIFT = (1e-5, 0.0, 4e-4)
ALIKE = Stand(2e-5, 2e-5, 4e-4, 4e-5, 3e-4, 50, "sigma1")
UNEQUAL = dataclasses.replace(ALIKE, noise=NOISE, drift=DRIFT)
ESTIMATORS = ("averaged", "refined", "least_squares", "optimal")
SAMPLES = 8
TEXT = (EXAMPLES / "paper_stand.toml").read_text()
TEXT = TEXT.replace("misalignment_rad = 0.02", "misalignment_rad = 0.02\nconverter_bits = 24\nrange_v = 10.0")


def sampled(seed, stand, k, u0):
    """A run of SAMPLES at each position on the exact geometry, with volts as the unit."""
    rng, lone = np.random.default_rng(seed), np.ones(18, dtype=int)
    errors = sources(PAPER, k, dataclasses.replace(stand, noise=0.0), lone)
    means = exact_outputs(
        PAPER, k, u0, errors, rng.standard_normal((1, sum(len(one.sigma) for one in errors.values())))
    )
    rows = means[0][:, None] + rng.standard_normal((18, SAMPLES, 3)) * stand.sigmas("noise")
    return rows


def run_of(rows):
    counts = np.full(len(rows), SAMPLES)
    return Run(counts, rows.mean(axis=1), rows.std(axis=1, ddof=1), "V", {}, blocks=NO_BLOCKS)


def in_units(stand, factors):
    noise, drift = (tuple((np.abs(factors) * stand.sigmas(name)).tolist()) for name in ("noise", "drift"))
    return dataclasses.replace(stand, noise=noise, drift=drift)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_channel_in_another_unit_is_the_same_run(estimator):
    k, u0 = SCALE[:, None] * NOMINAL_K / 2.0, np.array([0.01, 0.2, -0.3])
    rows = sampled(1, UNEQUAL, k, u0)
    schedule = core.CoreSchedule.built_in("paper")
    as_it_is = solve(run_of(rows), schedule, estimator, 3e-4, UNEQUAL, "run")
    turned = solve(run_of(rows * TUNED), schedule, estimator, 3e-4, in_units(UNEQUAL, TUNED), "run")
    assert turned.found.k == pytest.approx(as_it_is.found.k * TUNED[:, None], rel=1e-9)
    assert turned.u_k == pytest.approx(as_it_is.u_k * np.abs(TUNED)[:, None], rel=1e-9)
    assert turned.u_u0 == pytest.approx(as_it_is.u_u0 * np.abs(TUNED), rel=1e-9)
    assert turned.fit.chi_squared == pytest.approx(as_it_is.fit.chi_squared, rel=1e-9)
    assert turned.u_norm.worst_g == pytest.approx(as_it_is.u_norm.worst_g, rel=1e-9)
    for name, one in as_it_is.stand_seen.angles.items():
        assert turned.stand_seen.angles[name].value == pytest.approx(one.value, abs=1e-12)
        assert turned.stand_seen.augmented[name].u == pytest.approx(as_it_is.stand_seen.augmented[name].u, rel=1e-9)


def test_every_channel_of_a_closed_form_has_its_own_noise_and_drift():
    for channel in range(3):
        alone = dataclasses.replace(ALIKE, noise=NOISE[channel], drift=DRIFT[channel])
        mine, other = (
            by_coefficient(Propagation(PAPER, NOMINAL_K, s, np.ones(18, dtype=int), "refined").covariance())
            for s in (UNEQUAL, alone)
        )
        assert mine[0][channel] == pytest.approx(other[0][channel], rel=1e-12)
        assert mine[1][channel] == pytest.approx(other[1][channel], rel=1e-12)


def figures(runs, fitted, seed):
    """Stated u over the spread of errors (estimators, 12), by runs of a block of mixed signs; and how often a run is
    said not to fit, of so many that are `fitted`."""
    rng, lone = np.random.default_rng(seed), np.ones(18, dtype=int)
    signs = np.where(rng.random((3, 3)) < 0.5, -1.0, 1.0)
    k = np.diag(SCALE) + 0.02 * np.abs(SCALE)[:, None] * signs * (1.0 - np.eye(3))
    u0, errors = 0.01 * SCALE, sources(PAPER, k, UNEQUAL, lone)
    draws = rng.standard_normal((runs, sum(len(one.sigma) for one in errors.values())))
    means = exact_outputs(PAPER, k, u0, errors, draws)
    ratios = []
    for estimator in ESTIMATORS:
        off = estimator_for(Propagation(PAPER, k, UNEQUAL, lone, estimator))(means) - np.concatenate([k.ravel(), u0])
        if estimator == "optimal":
            stated = optimal_covariance(PAPER, k, UNEQUAL, lone, 0.0)
        else:
            stated = Propagation(PAPER, k, UNEQUAL, lone, estimator).covariance()
        ratios.append(np.sqrt(np.diag(stated) / (off**2).mean(axis=0)))
    models = (WholeModel(PAPER, one, UNEQUAL.mean_variance(lone), UNEQUAL) for one in means[:fitted])
    p = [chi_squared_above(model.chi_squared, model.freedom) for model in models]
    return np.array(ratios), float((np.array(p) < 1e-3).mean())


def test_what_is_stated_is_true():
    ratios, alarms = figures(6000, 150, 5)
    assert (np.abs(ratios - 1.0) < 0.05).all()
    assert alarms <= 0.01


@pytest.mark.full
def test_what_is_stated_is_true_at_length(fresh_seed):
    ratios, alarms = figures(100000, 20000, fresh_seed)
    assert (np.abs(ratios - 1.0) < 0.02).all()
    assert alarms < 3e-3


def with_three(text):
    for key, value in {
        "noise_v = 3e-4": NOISE,
        "scale_v_per_g = 2.0": tuple(SCALE),
        "range_v = 10.0": (1.0, 5, 20),
    }.items():
        assert text.count(key) == 1
        text = text.replace(key, f"{key.split()[0]} = {list(map(float, value))}")
    return text[: text.index("[block.true]")] + text[text.index("[accept]") :]


def read(tmp_path, text):
    (tmp_path / "stand.toml").write_text(text)
    return read_stand(str(tmp_path / "stand.toml"))


def test_a_stand_file_says_one_number_or_three(tmp_path):
    file = read(tmp_path, with_three(TEXT).replace("[block]", "drift_v = [1e-5, 0, 4e-4]\n[block]", 1))
    assert file.stand.noise == NOISE and file.stand.drift == DRIFT
    assert file.block["scale_v_per_g"] == tuple(SCALE) and file.block["range_v"] == (1.0, 5.0, 20.0)
    assert file.step_v == tuple(2.0 * r / 2**24 for r in (1.0, 5.0, 20.0))
    alike = read(tmp_path, TEXT.replace("noise_v = 3e-4", "noise_v = [3e-4, 3e-4, 3e-4]"))
    assert alike == read(tmp_path, TEXT)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("noise_v = 3e-4", "noise_v = [3e-4, 3e-4]", "noise_v must be a number or three of them"),
        ("noise_v = 3e-4", 'noise_v = [3e-4, "x", 3e-4]', "noise_v must be a number or three of them"),
        ("noise_v = 3e-4", "noise_v = [3e-4, -1e-4, 3e-4]", "noise_v must be 0 to 1e+09 in each channel"),
        ("level_rad = 2e-5", "level_rad = [2e-5, 2e-5, 2e-5]", "level_rad must be a number"),
        ("scale_v_per_g = 2.0", "scale_v_per_g = [2.0, 0, 2.0]", "scale_v_per_g must not be 0"),
        ("range_v = 10.0", "range_v = [10, 10, 1e12]", "range_v must be of a size from 1e-09 to 1e+09"),
    ],
)
def test_what_is_no_such_number_is_refused(tmp_path, old, new, said):
    with pytest.raises(BadInput, match="row ") as refused:
        read(tmp_path, TEXT.replace(old, new))
    assert said in str(refused.value)


@pytest.mark.parametrize("unit", ["V", "counts"])
def test_what_is_seen_of_them_fits_a_terminal(unit, tmp_path, tumble):
    noise = TEXT[: TEXT.index("[block]")].replace("noise_v = 3e-4", "noise_v = [3e-4, 3e-4, 3.1e-4]")
    (tmp_path / "stand.toml").write_text(noise)
    given = (EXAMPLES / "paper_stand.csv", "--unit", unit, "--stand", tmp_path / "stand.toml")
    done = tumble("solve", *given, "--details")
    said = done.stdout[done.stdout.index("Stand seen:") :].partition("\n\n")[0]
    noise, several = np.loadtxt(EXAMPLES / "paper_stand.csv", delimiter=",", skiprows=1), []
    for place in np.unique(noise[:, :2], axis=0):
        several.append(noise[(noise[:, :2] == place).all(axis=1), 2:])
    freedom = sum(len(rows) - 1 for rows in several)
    seen = np.sqrt(sum(((rows - rows.mean(axis=0)) ** 2).sum(axis=0) for rows in several) / freedom)
    of_each = ", ".join(f"{axis} {value:.2e}" for axis, value in zip("xyz", seen))
    percent = f"{100.0 / np.sqrt(2 * freedom):.2g}"
    told = f"noise {of_each} {unit}, each +- {percent} %; declared 3.00e-04, 3.00e-04, 3.10e-04"
    assert told in " ".join(said.split())
    assert max(map(len, said.splitlines())) <= 80
    given = ("solve", EXAMPLES / "paper_stand.csv", "--unit", unit, "--stand", tmp_path / "stand.toml", "--json")
    result = json.loads(tumble(*given).stdout)["stand_seen"]
    assert result["noise_v_by_channel"] == pytest.approx(seen, rel=1e-12)
    assert result["u_noise_v_by_channel"] == pytest.approx(seen / np.sqrt(2 * freedom), rel=1e-12)
    weights = 3.1e-4 / np.array([3e-4, 3e-4, 3.1e-4])
    assert result["noise_v"] == pytest.approx(np.sqrt(((seen * weights) ** 2).mean()), rel=1e-12)


@pytest.mark.parametrize("unit", ["V", "mV"])
def test_the_channel_that_is_not_as_declared_is_seen(unit, tmp_path, tumble):
    """In solve, in fixture check over two runs, in the report's table; in volts, whatever the unit of the run."""
    k, u0, factor = SCALE[:, None] * NOMINAL_K / 2.0, np.zeros(3), {"V": 1.0, "mV": 1e3}[unit]
    louder = dataclasses.replace(UNEQUAL, noise=(NOISE[0], 2.0 * NOISE[1], NOISE[2]))
    scales = [float(one) for one in SCALE]
    text = TEXT[: TEXT.index("[block.true]")].replace("scale_v_per_g = 2.0", f"scale_v_per_g = {scales}")
    stand, squares = tmp_path / "stand.toml", np.zeros(3)
    text = text.replace("range_v = 10.0", "range_v = 20.0")
    stand.write_text(text.replace("noise_v = 3e-4", f"noise_v = {list(NOISE)}"))
    for seed in (1, 2):
        rows = sampled(seed, louder, k, u0)
        squares += rows.var(axis=1, ddof=1).mean(axis=0) / 2.0
        lines = [f"ux [{unit}],uy [{unit}],uz [{unit}],mounting,position"]
        for place, samples in enumerate(rows * factor):
            lines += [f"{x!r},{y!r},{z!r},{place // 9 + 1},{place % 9 + 1}" for x, y, z in samples.tolist()]
        (tmp_path / f"{seed}.csv").write_text("\n".join(lines) + "\n")
    one = np.sqrt(rows.var(axis=1, ddof=1).mean(axis=0))
    solve_it = ("solve", tmp_path / "2.csv", "--stand", stand)
    seen = json.loads(tumble(*solve_it, "--json").stdout)["stand_seen"]
    assert seen["noise_v_by_channel"] == pytest.approx(one, rel=1e-9)
    assert 1.7 < one[1] / NOISE[1] < 2.3 and (np.abs(one[::2] / np.array(NOISE)[::2] - 1.0) < 0.15).all()
    shown = " ".join(tumble(*solve_it, "--details").stdout.split())
    assert f"y {one[1]:.2e}, z {one[2]:.2e} V, each +- 6.3 %; declared 4.50e-05, 3.00e-04, 1.50e-03" in shown
    checked = tumble("fixture", "check", tmp_path / "1.csv", tmp_path / "2.csv", "--stand", stand)
    both = np.sqrt(squares)
    told = f"by channel x {both[0]:.2e}, y {both[1]:.2e}, z {both[2]:.2e} V, each +- 4.5 %; declared 4.50e-05,"
    assert told in " ".join(checked.stdout.split()) and max(map(len, checked.stdout.splitlines())) <= 80
    tumble(*solve_it, "--out", tmp_path / "result.json")
    report = tmp_path / "report.html"
    assert tumble("report", tmp_path / "result.json", "--out", report).returncode == 0
    html = report.read_text()
    assert html.count("/stand_seen/noise_v_by_channel/") == 3 and 'data-path="/stand_seen/noise_v"' not in html
    assert "Standard deviation of one sample, y; declared " in html


def test_one_declared_noise_is_one_that_is_seen(tumble):
    given = ("solve", EXAMPLES / "paper_stand.csv", "--stand", EXAMPLES / "paper_stand.toml")
    seen = json.loads(tumble(*given, "--json").stdout)["stand_seen"]
    assert seen["noise_v_by_channel"] is seen["u_noise_v_by_channel"] is None and seen["noise_v"] > 0.0
    assert ", declared 3.00e-04" in tumble(*given, "--details").stdout


def test_a_result_repeats_what_was_declared():
    stand = written(declared_stand(UNEQUAL, np.array([1e-7, 2e-7, 3e-7])))
    document = calibrations.result(np.eye(3), np.zeros(3), stand=stand)
    told = package.Result(json.dumps(document)).checked
    assert document["stand"]["noise_v"] == list(NOISE) and document["stand"]["drift_v"] == list(DRIFT)
    assert stand_of(told, "result") == UNEQUAL and step_of(told) == (1e-7, 2e-7, 3e-7)
    stand["level_rad"] = [2e-5] * 3
    with pytest.raises(BadInput, match=r"stand\.level_rad is "):
        package.Result(json.dumps(document))


MIXED = {(1, -1, 1): "[2, -2, 2]", (-1, 1, 1): "[-2, 2, 2]", (-1, -1, 1): "[-2, -2, 2]"}


@pytest.mark.parametrize("signs", MIXED)
def test_a_block_of_mixed_signs_is_refused_with_the_remedy_and_taken_with_it(signs):
    k = block(np.random.default_rng(3), 0.02, signs=signs)
    refused = examined(declared(), k)
    assert refused.refusal.endswith(
        f"; if the block is so, [block] says it per channel: scale_v_per_g = {MIXED[signs]}"
    )
    in_mv = examined(declared(), 1e3 * k, unit="mV")
    assert in_mv.refusal.endswith(MIXED[signs])
    taken = examined(declared(tuple(2.0 * sign for sign in signs)), k)
    assert taken.refusal is None and taken.warnings == ()


def test_mistakes_of_a_block_with_channels_that_differ_are_named():
    k = block(np.random.default_rng(3), 0.02) * np.abs(SCALE)[:, None] / 2.0 * np.sign(SCALE)[:, None]
    file = declared(tuple(SCALE))
    assert examined(file, k).refusal is None and examined(file, k).warnings == ()
    assert examined(file, -k).refusal.startswith("all channels look reversed")
    assert "per channel" not in examined(file, -k).refusal
    turned = examined(file, k, change=lambda means: means[:, [1, 0, 2]])
    assert turned.refusal is not None or turned.warnings != ()


def test_weights_that_differ_go_with_the_gain_record():
    k = SCALE[:, None] * NOMINAL_K / 2.0
    table, alike = optimal_table(PAPER, k, UNEQUAL), optimal_table(PAPER, k, dataclasses.replace(UNEQUAL, noise=3e-4))
    data, plain = (optimal_run.to_bytes(optimal_run.record_of(one, PAPER)) for one in (table, alike))
    assert len(data) == len(plain) + 24 == gain_record.size_of(18, 2, drifts=3) + 24
    again = gain_record.from_bytes(data)
    assert again.weights == pytest.approx(1.5e-3 / np.array(NOISE)) and again.sigma_mean == table.sigma_mean
    assert optimal_run.to_bytes(again) == data
    assert gains_of(core.GainRecord(core.CoreSchedule(PAPER), data)).tolist() == table.gains.tolist()
    assert "double weights[3];" in optimal_run.to_c_header(again)
    assert "weights" not in optimal_run.to_c_header(gain_record.from_bytes(plain))


def case_of(stand, scale):
    return Case(stand, scale, 0.02, 0.0, None, 3e-4)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_a_budget_in_other_units_is_the_same(estimator):
    unequal = budget(case_of(dataclasses.replace(UNEQUAL, drift=0.0), tuple(SCALE)), "derived", estimator)
    assert unequal.total == pytest.approx(budget(case_of(ALIKE, 2.0), "derived", estimator).total, rel=1e-9)
    assert unequal.sizes[4] == pytest.approx(1.5e-3 / 50**0.5)


def test_a_budget_counts_the_noise_and_drift_of_each_channel():
    by_channel = [
        budget(case_of(dataclasses.replace(ALIKE, noise=n, drift=d), 2.0), "derived", "refined")
        for n, d in zip(NOISE, DRIFT)
    ]
    found = budget(case_of(UNEQUAL, 2.0), "derived", "refined").total
    for row in range(12):
        channel = row // 3 if row < 9 else row - 9
        assert found[row] == pytest.approx(by_channel[channel].total[row], rel=1e-12)


def test_the_papers_weights_take_the_noise_of_each_channel():
    stand = dataclasses.replace(ALIKE, noise=NOISE)
    found = budget(case_of(stand, 2.0), "published", "refined").total
    for row in range(12):
        channel = row // 3 if row < 9 else row - 9
        alone = budget(case_of(dataclasses.replace(ALIKE, noise=NOISE[channel]), 2.0), "published", "refined")
        assert found[row] == pytest.approx(alone.total[row], rel=1e-12)


def test_requirements_in_other_units_are_the_same():
    share = np.ones(5)
    for which in ("derived", "published"):
        stand = dataclasses.replace(UNEQUAL, drift=0.0)
        found = require.requirements(case_of(stand, tuple(np.abs(SCALE))), which, "refined", 3e-4, share)
        alike = require.requirements(case_of(ALIKE, 2.0), which, "refined", 3e-4, share)
        assert found.limits[:4] == pytest.approx(alike.limits[:4], rel=1e-9)
        assert found.limits[4] == pytest.approx(5.0 * alike.limits[4], rel=1e-9)  # of the channel of 10 V/g
        assert found.samples == alike.samples and found.set_by == alike.set_by


def test_a_plan_says_three_numbers(tmp_path, tumble):
    (tmp_path / "stand.toml").write_text(with_three(TEXT))
    ran = tumble("plan", "require", "--stand", tmp_path / "stand.toml", "--json")
    assert ran.returncode == 0
    plan = json.loads(ran.stdout)
    assert len(plan["noise_v"]) == 3 and plan["noise_v"][2] / plan["noise_v"][0] == pytest.approx(1.5e-3 / 4.5e-5)
    ran = tumble("plan", "budget", "--stand", tmp_path / "stand.toml")
    assert "Block: 0.3, -2, 10 V/g, misalignments 0.02 rad" in ran.stdout
    assert "noise: of the worst channel, the others in proportion" in ran.stdout


def bench_stand(tmp_path):
    text = with_three(TEXT).replace("range_v = [1.0, 5.0, 20.0]", "range_v = 20.0")
    (tmp_path / "stand.toml").write_text(text.replace("[block]", "drift_v = [1e-5, 0, 4e-4]\n[block]", 1))
    return tmp_path / "stand.toml"


@pytest.mark.parametrize("estimator", ["refined", "optimal"])
def test_the_firmware_takes_each_channel_by_its_own(tmp_path, tumble, estimator):
    stand, folder = bench_stand(tmp_path), tmp_path / "run"
    ran = tumble("bench", "--seed", 3, "--stand", stand, "--estimator", estimator, "--out", folder, "--json")
    assert ran.returncode == 0, ran.stderr  # as numpy confirms what it states
    result = json.loads(ran.stdout)
    assert result["pass"] is True and result["stand"]["noise_v"] == list(NOISE)
    assert np.sign(np.diag(result["K"])).tolist() == np.sign(SCALE).tolist()
    off = np.array(result["K"]) - result["truth"]["K"]
    assert (np.abs(off) < 4.0 * np.array(result["u_K"])).all()
    ran = tumble("report", folder / "result.json", "--out", tmp_path / "report.html")
    assert ran.returncode == 0, ran.stderr


@pytest.fixture
def recorded(tmp_path, tumble):
    """A run of the bench on channels that differ, as text, and its stand file."""
    stand = bench_stand(tmp_path)
    assert tumble("bench", "--seed", 3, "--stand", stand, "--out", tmp_path / "run").returncode == 0
    return (tmp_path / "run/run.csv").read_text(), stand


def test_a_fixture_is_checked_by_channels_that_differ(recorded, tumble, tmp_path):
    """The witness once had no weights, and disagreed."""
    ran = tumble("fixture", "check", "--stand", recorded[1], tmp_path / "run/run.csv", "--json")
    assert ran.returncode == 0, ran.stderr
    found = json.loads(ran.stdout)["sources"]["noise_v"]
    assert found["value"] == pytest.approx(NOISE[2], rel=0.1)


@pytest.mark.parametrize("least", ["0", "1e-300"])
def test_a_channel_without_noise_hides_no_other(least, recorded, tumble, tmp_path):
    """Weights of 1e9 once made K look singular: exit code 3."""
    text = recorded[1].read_text().replace(str(NOISE[0]), least)
    (tmp_path / "other.toml").write_text(text)
    ran = tumble("solve", tmp_path / "run/run.csv", "--stand", tmp_path / "other.toml", "--json")
    assert ran.returncode == 1, ran.stderr  # its noise is more than declared
    assert json.loads(ran.stdout)["noise"]["above_declared"] == ["ux"]


def test_a_channel_in_millionths_is_no_fault(recorded, tumble, tmp_path):
    """The angles then hang on the last bits, and core and numpy once disagreed."""
    rows = [line.split(",") for line in recorded[0].splitlines()]
    at = next(i for i, name in enumerate(rows[0]) if name.startswith("ux"))
    scaled = [[*row[:at], f"{float(row[at]) * 1e6:.9g}", *row[at + 1 :]] for row in rows[1:]]
    (tmp_path / "scaled.csv").write_text("\n".join(map(",".join, [rows[0], *scaled])) + "\n")
    lines = recorded[1].read_text().splitlines()
    kept = [line for line in lines if "bits" not in line and "range" not in line]
    (tmp_path / "other.toml").write_text("\n".join(kept))
    ran = tumble("solve", tmp_path / "scaled.csv", "--stand", tmp_path / "other.toml", "--json")
    assert ran.returncode == 1, ran.stderr
    assert "fit" in json.loads(ran.stdout)["pass_reason"]


def test_a_bench_takes_one_range(tmp_path, tumble):
    (tmp_path / "stand.toml").write_text(with_three(TEXT))
    ran = tumble("bench", "--stand", tmp_path / "stand.toml", "--out", tmp_path / "run")
    assert ran.returncode == 2 and ran.stdout == ""
    assert "[block] range_v must be one number on the bench" in ran.stderr


def test_an_import_takes_the_sign_of_each_channel(tmp_path):
    given = argparse.Namespace(stand=str(bench_stand(tmp_path)), signs=None)
    assert import_recording._told_signs(given)[0] == (1, -1, 1)
