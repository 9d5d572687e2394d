"""Campaigns on the example stands: numpy never disagrees, errors are as large as predicted."""

import sys

import numpy as np
import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests/benchmark"))

import campaign

PREDICTED = {"paper_stand": 1.0, "angle_stand": None, "lab_stand": 0.93}


@pytest.mark.parametrize("runs", [60, pytest.param(1000, marks=pytest.mark.full)])
@pytest.mark.parametrize("name", campaign.STANDS)
def test_errors_are_as_predicted(name, runs):
    """The firmware and numpy agree in every run; mean, rms and the share of passes are as predicted, within 5 sigma."""
    found = campaign.measure(name, runs)
    assert (found.runs, found.finished, found.disagreements) == (runs, runs, 0)
    mean, rms = found.errors.mean(axis=0), np.sqrt((found.errors**2).mean(axis=0))
    assert np.abs(mean).max() < 5.0 / np.sqrt(runs)
    assert np.abs(rms - 1.0).max() < 5.0 / np.sqrt(2.0 * runs)
    if PREDICTED[name] is not None:
        assert abs(found.predicted - PREDICTED[name]) < 0.02
    spread = np.sqrt(found.predicted * (1.0 - found.predicted) / runs)
    assert abs(found.passed - found.predicted) <= 5.0 * spread + 1.0 / runs


def test_a_wrong_coefficient_is_a_disagreement():
    """The comparison can fail: the tenth digit of one coefficient of one run, changed."""
    setup = campaign.stand_of("paper_stand")
    lines = campaign.calibrated(setup, 3)
    means = np.array([line["means"] for line in lines]).reshape(3, -1, 3)
    assert campaign.compare(lines, campaign.coefficients(lines), means, setup.limit_g)[0] == 0
    wrong = campaign.coefficients(lines)
    wrong[1, 4] *= 1 + 1e-10
    assert campaign.compare(lines, wrong, means, setup.limit_g)[0] == 1
    lines[2]["pass"] = not lines[2]["pass"]
    assert campaign.compare(lines, wrong, means, setup.limit_g)[0] == 2
