"""Averaging as long as needed: what it saves where noise differs, and that stopping early spoils nothing."""

import json
import math

import gain_record
import numpy as np
import pytest
from simulated_bench import bench, runs

QUIET_V, NOISY_V = 3e-4, 9e-4  # mounting 1, mounting 2
SCENARIO = f"""
block.noise_v = {QUIET_V} {QUIET_V} {QUIET_V}
stand.axis_tilt_rad = 0
stand.level_rad = 0
stand.remount_rad = 0
stand.angle_rad = 0
block.scale_v_per_g = 2
block.k = 2 0.04 0.04 0.04 2 0.04 0.04 0.04 2
block.u0 = 0.02 -0.01 0.03
procedure.warm_up_samples = 0
averaging.stillness_ratio = 10
fault = noisy at=2.1 phase=mount channels=xyz value={math.sqrt(NOISY_V**2 - QUIET_V**2)!r}
"""
TRUTH = np.array([2, 0.04, 0.04, 0.04, 2, 0.04, 0.04, 0.04, 2, 0.02, -0.01, 0.03])


def campaign(count, *lines):
    """Means (runs, 18, 3), coefficients (runs, 12), and virtual seconds (runs,) of runs with these lines added."""
    rows = runs([*SCENARIO.splitlines(), *lines], count)
    assert {row["exit"] for row in rows} <= {0, 1} and len(rows) == count
    means = np.array([row["means"] for row in rows], dtype=float).reshape(count, 18, 3)
    return means, np.array([row["K"] + row["U0"] for row in rows]), np.array([row["virtual_s"] for row in rows])


@pytest.mark.slow
def test_what_it_saves_and_that_it_spoils_nothing():
    """A fixed number must serve the noisiest position: 500 samples. With the standard error that these give as the
    budget, the quiet mounting takes a ninth of them. No mean is worse than its budget, no coefficient is biased."""
    count, budget = 100, NOISY_V / math.sqrt(500)
    _, fixed, fixed_s = campaign(count, "procedure.samples = 500")
    means, found, found_s = campaign(count, "procedure.samples = 2000", f"procedure.error_budget_v = {budget}")
    saved_s = fixed_s.mean() - found_s.mean()
    averaging_s = 18 * 500 * 0.01
    scatter = means.std(axis=0, ddof=1)
    print(f"time {fixed_s.mean():.1f} s, {found_s.mean():.1f} s: {saved_s / fixed_s.mean():.1%} of the whole saved,")
    print(f"{saved_s / averaging_s:.1%} of the averaging; scatter of means over budget {scatter.mean() / budget:.3f}")
    assert saved_s > 0.25 * fixed_s.mean() and saved_s > 0.35 * averaging_s
    assert np.sqrt((scatter**2).mean()) < budget
    z = (found.mean(axis=0) - TRUTH) / found.std(axis=0, ddof=1) * math.sqrt(count)
    assert np.abs(z).max() < 4.5
    assert found.std(axis=0).max() < 1.35 * fixed.std(axis=0).max()


def test_with_the_same_noise_everywhere_it_saves_nothing():
    """The first look at which every channel is within the budget comes a little late, not early."""
    same = "fault = noisy at=1.1 phase=mount channels=x value=1e-9"
    lines = [line for line in SCENARIO.splitlines() if not line.startswith("fault")]
    lines += [same, "procedure.samples = 1000", f"procedure.error_budget_v = {QUIET_V / math.sqrt(100)}"]
    taken = [mean["samples"] for mean in bench(lines)["means"]]
    assert 95 <= np.mean(taken) <= 130 and min(taken) >= 80


def test_the_reason_when_it_is_never_enough():
    found = bench([*SCENARIO.splitlines(), "procedure.samples = 100", "procedure.error_budget_v = 4e-5"])
    assert (found["exit"], found["reason"]) == (3, "TUMBLE_REASON_UNCERTAIN")
    assert found["reason_sentence"] == "a mean is too noisy for its budget even with the most samples allowed"
    assert [mean["samples"] < 100 for mean in found["means"]] == [True] * 9  # mounting 1; of mounting 2 nothing is kept
    assert found["table"]["at_rest"] is True


def test_from_the_command_line(tumble, tmp_path):
    """The witness confirms a run with a number of samples of its own at every position; u follows these numbers."""
    options = ("--seed", 1, "--samples", 200, "--json")
    done = tumble("bench", *options, "--error-budget", "6e-5", "--out", tmp_path / "adaptive")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    samples = [mean["samples"] for mean in found["means"]]
    assert 16 <= min(samples) and max(samples) < 80
    for mean in found["means"]:
        assert max(mean["scatter"]) / math.sqrt(mean["samples"]) <= 6e-5 * (1 + 1e-6)
    fixed = json.loads(tumble("bench", *options, "--out", tmp_path / "fixed").stdout)
    assert {mean["samples"] for mean in fixed["means"]} == {200}
    assert np.all(np.array(found["u_K"]) > np.array(fixed["u_K"]))


@pytest.mark.parametrize("text", ["0", "-1e-5", "nan", "inf", "1e-5V", "1e10", ""])
def test_a_budget_must_be_a_size(text, refused):
    assert f"--error-budget: '{text}' is not a number of volts above 0" in refused("bench", f"--error-budget={text}")


@pytest.mark.parametrize("budget, most", [("2e-4", 20000), ("2e-4", 1048576), ("4e-5", 2000)])
def test_optimal_weighs_the_samples_that_there_will_be(budget, most, tumble, tmp_path):
    """Not those asked for at most: no false misfit, and a record for means as noisy as the budget, or as the least
    number of samples leaves them."""
    options = ("--estimator", "optimal", "--samples", most, "--error-budget", budget, "--json", "--out", "run")
    done = tumble("bench", *options, cwd=tmp_path)
    assert done.returncode == 0 and "residuals" not in done.stderr, done.stderr
    assert 0.4 < json.loads(done.stdout)["misfit"] < 1.7
    made = gain_record.from_bytes((tmp_path / "run/inputs/gains.bin").read_bytes())
    assert made.sigma_mean == pytest.approx(min(float(budget), 3e-4 / 4))
