"""The noise of a run as the firmware looks at it: its uncertainties are those of `solve` on the same samples, and a
firmware that states others, or another noise, is not believed."""

import json

import numpy as np
import pytest
from simulated_bench import bench, scenario

from tumble.core import CoreSchedule
from tumble.files.run_file import read_run
from tumble.files.run_layout import LayoutOptions
from tumble.solving.noise import of_means
from tumble.solving.solution import solve
from tumble.stand import Stand

STAND = Stand(2e-5, 2e-5, 4e-4, 4e-5, 3e-4, 50, "sigma1")  # of a scenario that says nothing else
STEP_V = 10.0 * 2.0**-23


def ran(folder, **keys):
    """What the firmware found, and `solve` from the samples recorded."""
    document = bench(keys, out=folder)
    assert document["exit"] in (0, 1)  # 1: it fails the gravity check
    run = read_run(str(folder / "run.csv"), CoreSchedule.built_in("paper").data, LayoutOptions(unit="V"))
    return document, solve(run, None, document["estimator"], 1e-3, STAND, "run.csv", step_v=STEP_V)


def u_of(document):
    return np.array([*document["u_K"], document["u_U0"]])


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares"])
def test_correlated_noise_counts_as_in_solve(estimator, tmp_path):
    """AR(1) of 0.9 and 0.5; the third channel is white. Blocks of 16 samples show the most: the firmware has these."""
    rho = {"block__noise_correlation": "0.9 0 0.5", "procedure__estimator": estimator}
    document, solution = ran(tmp_path / "run", **rho)
    assert solution.noise.measured.length.tolist() == [16, 1, 16]
    assert document["noise"]["block_samples"] == 8
    assert document["noise"]["above_declared"] == ["x", "z"]
    noise_v = of_means(solution.noise.measured, solution.run.samples)
    assert document["noise"]["noise_v"] == pytest.approx(noise_v.tolist(), rel=1e-6)
    np.testing.assert_allclose(u_of(document), np.vstack([solution.u_k, solution.u_u0]), rtol=1e-6)
    white = bench({"procedure.estimator": estimator})
    assert document["u_U0"][0] > 2.0 * white["u_U0"][0] and document["u_U0"][2] > 1.2 * white["u_U0"][2]
    assert document["u_U0"][1] == pytest.approx(white["u_U0"][1], rel=1e-4)


def test_more_white_noise_than_declared_counts_by_its_scatter(tmp_path):
    """A single-precision number on board: 6e-8 of it."""
    loud = {"fault": "noisy at=1.1 phase=mount channels=y value=1e-3", "averaging__stillness_ratio": "30"}
    document, solution = ran(tmp_path / "run", **loud)
    assert solution.noise.measured.length[1] == 1 and document["noise"]["above_declared"] == ["y"]
    np.testing.assert_allclose(u_of(document), np.vstack([solution.u_k, solution.u_u0]), rtol=1e-6)


def test_white_noise_changes_nothing(tmp_path):
    document, solution = ran(tmp_path / "run")
    assert document["noise"]["above_declared"] == [] and not solution.noise.exceeds.any()
    np.testing.assert_allclose(u_of(document), np.vstack([solution.u_k, solution.u_u0]), rtol=1e-9)
    assert document["noise"]["declared_v"] == 3e-4


@pytest.fixture
def correlated(tmp_path):
    """Options of a run with such noise."""
    path = scenario(tmp_path, block__noise_correlation="0.9 0 0.5")
    return "--scenario", str(path), "--out", str(tmp_path / "run")


def test_the_bench_confirms_it(tumble, correlated, tmp_path):
    done = tumble("bench", *correlated)
    result = json.loads((tmp_path / "run/result.json").read_text())
    assert done.returncode in (0, 1), done.stderr  # the fit may tell of it
    assert result["noise"]["above_declared"] == ["ux", "uz"]


@pytest.mark.parametrize(
    ("forge", "words"),
    [
        (lambda d: d["u_U0"].__setitem__(0, d["u_U0"][0] * (1 + 1e-8)), "u_U0 differs"),
        (lambda d: d["noise"]["noise_v"].__setitem__(2, d["noise"]["noise_v"][2] * (1 - 1e-8)), "the noise differs"),
        (lambda d: d["noise"].__setitem__("block_samples", 4), "the noise differs"),
    ],
)
def test_a_noise_that_is_not_confirmed_is_not_given(forge, words, forged, correlated):
    code, out, err = forged(forge, *correlated)
    assert (code, out) == (3, "")
    assert words in err.splitlines()[-1]
