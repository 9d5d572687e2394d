"""Thousands of calibrations on the example stands: the firmware against numpy, the truth, and the stand's prediction.

    tools/benchmark campaign [--runs N] [--seed N] [--jobs N] [STAND...]

For every stand: how many simulated runs numpy disagrees with; mean and root mean square of (estimate - truth)/u
by coefficient; the share of runs that pass the gravity check, beside the share that a Monte Carlo of the exact geometry
in numpy predicts, and how probable it is to be that far off by chance. Needs the package to be importable, as
in the tests.
"""

import argparse
import math
import os
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tumble import core, model
from tumble.files.stand_file import read_stand
from tumble.workers.crews import Processes
from tumble.workers.over import ALONE, Team
from tumble.world.setup import Setup, scenario_text, setup_of

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/lib"))

from simulated_bench import runs  # noqa: E402

STANDS = ("paper_stand", "angle_stand", "lab_stand")
NAMES = [f"K_{row}{column}" for row in "xyz" for column in "xyz"] + [f"U0_{row}" for row in "xyz"]
ESTIMATOR = "refined"
RELATIVE_LIMIT = 1e-12
DRAWS = 100_000
CHUNK = 20_000


@dataclass
class Campaign:
    """What a campaign showed. `errors` (runs, 12): (estimate - truth)/u; `passed`, `predicted`: shares of runs;
    `predicted_error`: standard error of the latter."""

    runs: int
    finished: int
    disagreements: int
    largest_difference: float
    errors: np.ndarray
    passed: float
    predicted: float
    predicted_error: float


def stand_of(name: str) -> Setup:
    """An example stand as `tumble bench --stand` takes it."""
    file = read_stand(str(ROOT / f"examples/{name}.toml"))
    return setup_of(1, file, core.CoreSchedule(core.paper_schedule()), estimator=ESTIMATOR)


def calibrated(setup: Setup, count: int, first_seed: int = 1, team: Team = ALONE) -> list[dict]:
    """The lines of so many runs."""
    return runs(scenario_text(setup).splitlines(), count, first_seed, team=team)


def measure(name: str, count: int, first_seed: int = 1, team: Team = ALONE) -> Campaign:
    """Run a campaign on an example stand and judge it."""
    setup = stand_of(name)
    lines = calibrated(setup, count, first_seed, team)
    finished = [line for line in lines if line["K"] is not None]
    found, truth = coefficients(finished), coefficients([line["truth"] for line in finished])
    means = np.array([line["means"] for line in finished]).reshape(len(finished), -1, 3)
    disagreements, largest = compare(finished, found, means, setup.limit_g)
    predicted, predicted_error = predicted_share(setup)
    return Campaign(
        runs=len(lines),
        finished=len(finished),
        disagreements=disagreements,
        largest_difference=largest,
        errors=(found - truth) / uncertainties(setup, found),
        passed=sum(line["pass"] for line in lines) / len(lines),
        predicted=predicted,
        predicted_error=predicted_error,
    )


def coefficients(lines: list[dict]) -> np.ndarray:
    """K and U0 of every line: (lines, 12)."""
    return np.array([line["K"] + line["U0"] for line in lines])


def witness(means: np.ndarray) -> np.ndarray:
    """What numpy makes of means (runs, positions, 3): (runs, 12)."""
    k, u0 = model.estimate(model.built_in("paper"), means, ESTIMATOR)
    return np.concatenate([k.reshape(-1, 9), u0], axis=1)


def largest_delta_g(found: np.ndarray, means: np.ndarray) -> np.ndarray:
    """Largest gravity error of every run, g."""
    inverse = np.linalg.inv(found[:, :9].reshape(-1, 3, 3))
    force = np.einsum("rij,rpj->rpi", inverse, means - found[:, None, 9:])
    return np.abs((force**2).sum(axis=2) - 1.0).max(axis=1) / 2.0


def compare(lines: list[dict], found: np.ndarray, means: np.ndarray, limit_g: float) -> tuple[int, float]:
    """Runs whose coefficients or verdict numpy does not confirm, and the largest difference over max|K|."""
    confirmed = witness(means)
    difference = np.abs(found - confirmed).max(axis=1) / np.abs(confirmed[:, :9]).max(axis=1)
    delta_g = largest_delta_g(confirmed, means)
    told = np.array([line["max_abs_delta_g_g"] for line in lines])
    verdicts = np.array([line["pass"] for line in lines])
    wrong = (difference > RELATIVE_LIMIT) | (np.abs(delta_g - told) > 1e-11) | ((delta_g <= limit_g) != verdicts)
    return int(wrong.sum()), float(difference.max())


def uncertainties(setup: Setup, found: np.ndarray) -> np.ndarray:
    """Standard uncertainties of every run, propagated with the coefficients it found: (runs, 12)."""
    schedule = model.built_in("paper")
    samples = np.full(len(schedule.positions), setup.samples)
    parts = [
        model.by_coefficient(
            model.Propagation(schedule, row[:9].reshape(3, 3), setup.stand, samples, ESTIMATOR).covariance()
        )
        for row in found
    ]
    return np.array([np.concatenate([u_k.ravel(), u_u0]) for u_k, u_u0 in parts])


def predicted_share(setup: Setup, draws: int = DRAWS, seed: int = 2026) -> tuple[float, float]:
    """Share of passed gravity checks, and its standard error, by Monte Carlo: exact geometry, normal errors, the stand
    file's block, means of as many samples as the stand file says."""
    rng, passed = np.random.default_rng(seed), 0
    for begin in range(0, draws, CHUNK):
        means = imagined_means(setup, min(CHUNK, draws - begin), rng)
        passed += int((largest_delta_g(witness(means), means) <= setup.limit_g).sum())
    share = passed / draws
    return share, math.sqrt(share * (1.0 - share) / draws)


def imagined_means(setup: Setup, runs: int, rng: np.random.Generator) -> np.ndarray:
    """Means of so many imagined runs of the default schedule, two mountings of nine angles: (runs, 18, 3)."""
    sigma = {name: setup.stand.sigma(name) for name in ("axis_tilt", "level", "remount", "angle", "noise")}
    tilt, level = (rng.normal(size=(runs, 1)) * sigma[name] for name in ("axis_tilt", "level"))
    mountings = []
    for _ in range(2):
        p = np.deg2rad(45.0 * np.arange(9)) + level + rng.normal(size=(runs, 9)) * sigma["angle"]
        yaw = rng.normal(size=(runs, 1)) * sigma["remount"]
        h, n, v = np.cos(tilt) * np.sin(p), np.sin(tilt), np.cos(tilt) * np.cos(p)
        mountings.append((h * np.cos(yaw) + n * np.sin(yaw), n * np.cos(yaw) - h * np.sin(yaw), v))
    (h1, n1, v1), (h2, n2, v2) = mountings
    force = np.concatenate([np.stack([h1, n1, v1], axis=2), np.stack([-h2, v2, n2], axis=2)], axis=1)
    means = force @ np.array(setup.truth["K"]).T + setup.truth["U0"]
    return means + rng.normal(size=means.shape) * sigma["noise"] / np.sqrt(setup.samples)


def chance(passed: int, runs: int, share: float) -> float:
    """Probability that of independent runs at least as many, or as few, pass as did: twice the binomial tail."""
    if not 0.0 < share < 1.0:
        return float(passed == runs * share)
    log_share, log_rest = math.log(share), math.log1p(-share)
    tail = range(passed + 1) if passed < runs * share else range(passed, runs + 1)
    ways = (math.lgamma(runs + 1) - math.lgamma(k + 1) - math.lgamma(runs - k + 1) for k in tail)
    return min(1.0, 2.0 * sum(math.exp(way + k * log_share + (runs - k) * log_rest) for k, way in zip(tail, ways)))


def show(name: str, campaign: Campaign) -> None:
    """Print one campaign."""
    print(f"{name}: {campaign.runs} runs, {campaign.finished} finished")
    print(f"  disagreements with numpy: {campaign.disagreements}")
    print(f"  largest difference from numpy, over max|K|: {campaign.largest_difference:.1e}")
    print(f"  gravity check passed: {campaign.passed:.1%}, predicted {campaign.predicted:.2%}", end="")
    probability = chance(round(campaign.passed * campaign.runs), campaign.runs, campaign.predicted)
    print(f" +- {campaign.predicted_error:.2%}; that far off by chance: {probability:.2g}")
    print(f"  {'(estimate - truth)/u':>20}  {'mean':>6}  {'rms':>6}")
    mean, rms = campaign.errors.mean(axis=0), np.sqrt((campaign.errors**2).mean(axis=0))
    for row, coefficient in enumerate(NAMES):
        print(f"  {coefficient:>20}  {mean[row]:+6.3f}  {rms[row]:6.3f}")
    print(f"  largest |error| {np.abs(campaign.errors).max():.2f} u")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Campaigns on the example stands.")
    parser.add_argument("stands", nargs="*", default=STANDS, metavar="STAND", help=f"default: {' '.join(STANDS)}")
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1, help="of the first run")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes; default: all processors")
    arguments = parser.parse_args()
    for name in arguments.stands:
        with Team(Processes(arguments.jobs)) as team:
            show(name, measure(name, arguments.runs, arguments.seed, team))


if __name__ == "__main__":
    main()
