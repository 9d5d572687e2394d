"""What runs at several temperatures could not have shown, against one run alone and against runs solved again."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import EXAMPLES

from tumble.distributions import noncentrality
from tumble.files.stand_file import read_stand
from tumble.model import thermal_reliability
from tumble.model.coefficients import spread_attitudes
from tumble.model.errors import sources
from tumble.model.geometry import built_in, ideal_force
from tumble.model.patterns import PATTERNS, Scene
from tumble.model.propagation import Propagation
from tumble.model.reliability import FOUND, reliability as of_one_run
from tumble.model.thermal import Polynomials, ThermalRun, fit
from tumble.model.thermal_reliability import reliability

pytestmark = pytest.mark.python
STAND = read_stand(str(EXAMPLES / "paper_stand.toml")).stand
SAMPLES = 50
K = np.array([[2.0, 0.002, -0.003], [0.001, 2.01, 0.004], [-0.002, 0.001, 1.99]])
U0 = np.array([0.01, -0.02, 0.005])
BLOCK = Polynomials(15.0, np.array([K, 1e-4 * K]), np.array([U0, [1e-4, -8e-5, 9e-5]]))


def run_at(schedule, temperature_c, block=BLOCK):
    k, u0 = block.at(temperature_c)
    means = ideal_force(schedule) @ k.T + u0
    found = sources(schedule, k, STAND, np.full(len(means), SAMPLES))
    return ThermalRun(schedule, means, np.full(len(means), temperature_c), found)


def test_of_one_run_it_is_that_of_a_run(monkeypatch):
    monkeypatch.setattr(thermal_reliability, "_ATTITUDES", 2500)
    schedule = built_in("three_mountings").fitted
    alone = Polynomials(15.0, K[None], U0[None])
    counts = np.full(len(schedule.positions), SAMPLES)
    expected = {one.pattern.name: one for one in of_one_run(Propagation(schedule, K, STAND, counts, "optimal"))}
    runs = [run_at(schedule, 15.0, alone)]
    found = {one.pattern.name: one for one in reliability(runs, alone, (15.0, 15.0), STAND, 0.999)}
    assert set(found) == set(expected) and len(found) > 8
    for name, one in found.items():
        other = expected[name]
        assert (one.size is None) == (other.size is None), name
        if one.size is not None:
            assert one.size == pytest.approx(other.size, rel=1e-6), name
            assert one.norm_g == pytest.approx(other.norm_g, rel=1e-6), name


@pytest.mark.parametrize("kept", [(), ("alpha1", "platform", "encoder")])
def test_runs_with_an_error_of_that_size_show_it_as_foreseen(kept):
    """Solved again: chi-squared rises to its noncentrality, and |a| is wrong by so much at the worst attitude and
    temperature, and by no more anywhere."""
    schedule, at_c = built_in("diagonal").fitted, (-30.0, 20.0, 60.0)
    runs = [run_at(schedule, t) for t in at_c]
    found = [one for one in reliability(runs, BLOCK, (-30.0, 60.0), STAND, 0.999, kept) if one.size is not None]
    assert len(found) > 8
    for one in found:
        parts = 1e-3 * one.outputs.reshape(len(runs), -1, 3)  # where squares do not count
        solved = fit([replace(run, means=run.means + part) for run, part in zip(runs, parts)], 1, 15.0, kept)
        places = len(one.pattern.columns(Scene(schedule, K))) * (1 if one.pattern.whose == "block" else len(runs))
        of_ranks = [noncentrality(rank, 1e-3 / (len(PATTERNS) + 1) / places, FOUND) for rank in range(1, 7)]
        assert any(solved.chi_squared * 1e6 == pytest.approx(one, rel=1e-3) for one in of_ranks), one.pattern.name
        if not one.pattern.lasts:
            assert wrong_by(solved.polynomials) * 1e3 == pytest.approx(one.norm_g, rel=1e-3), one.pattern.name


def wrong_by(found):
    """The largest error of |a|, g, at the attitudes and temperatures that are looked at."""
    errors = []
    for t in np.linspace(-30.0, 60.0, 5):
        (k, u0), (true_k, true_u0) = found.at(t), BLOCK.at(t)
        force = np.linalg.solve(k, (spread_attitudes(500) @ true_k.T + true_u0 - u0).T)
        errors.append(np.abs(np.linalg.norm(force, axis=0) - 1.0).max())
    return max(errors)
