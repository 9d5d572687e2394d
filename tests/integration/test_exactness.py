"""Exact oracles: what should come out exactly, or correctly rounded, does."""

import math

import mpmath
import numpy as np
import pytest
import sympy

from tumble import core, model
from tumble.estimators import LINEAR
from tumble.model import estimators

PAPER = core.CoreSchedule(core.paper_schedule())


def exact_attitudes():
    """The paper's attitudes to 40 digits: rows of three mpmath numbers."""
    with mpmath.workdps(40):
        turns = [mpmath.mpf(turn) / 4 for turn in range(9)]
        one = [(mpmath.sinpi(turn), mpmath.mpf(0), mpmath.cospi(turn)) for turn in turns]
        return one + [(-h, v, n) for h, n, v in one]


def rounded_outputs(k, u0, attitudes):
    """Outputs of a perfect block on a perfect stand, each rounded once."""
    with mpmath.workdps(40):
        return np.array(
            [
                [float(mpmath.mpf(u0[i]) + mpmath.fdot(map(mpmath.mpf, k[i].tolist()), a)) for i in range(3)]
                for a in attitudes
            ]
        )


def worst_noise_free_error(rng, blocks, estimator):
    """Largest error of a coefficient over max|K|, for random blocks of any size with |U0| <= max|K|."""
    attitudes, worst = exact_attitudes(), 0.0
    for _ in range(blocks):
        k = rng.uniform(-1, 1, (3, 3)) * 10.0 ** rng.uniform(-6, 6)
        u0 = rng.uniform(-1, 1, 3) * np.abs(k).max()
        found_k, found_u0 = core.estimate(PAPER, rounded_outputs(k, u0, attitudes), None, estimator)
        error = max(np.abs(found_k - k).max(), np.abs(found_u0 - u0).max())
        worst = max(worst, error / np.abs(k).max())
    return worst


@pytest.mark.slow
@pytest.mark.parametrize("estimator", LINEAR)
def test_noise_free_runs_are_exact(estimator):
    assert worst_noise_free_error(np.random.default_rng(41), 500, estimator) <= 1e-15


@pytest.mark.full
@pytest.mark.parametrize("estimator", LINEAR)
def test_noise_free_runs_are_exact_at_length(estimator, fresh_seed):
    assert worst_noise_free_error(np.random.default_rng(fresh_seed), 20_000, estimator) <= 1e-15


@pytest.mark.parametrize("mounting", [1, 2])
def test_functionals_give_the_coefficients_symbolically(mounting, monkeypatch):
    """c, s, b of U0 + K a on the exact geometry are K_iz (or K_iy), K_ix (or -K_ix) and U0_i, to the last symbol."""
    monkeypatch.setattr(estimators, "_SQRT2", sympy.sqrt(2))
    k_x, k_y, k_z, u0 = sympy.symbols("K_ix K_iy K_iz U0_i")
    outputs = []
    for turn in range(9):
        h, v = sympy.sin(turn * sympy.pi / 4), sympy.cos(turn * sympy.pi / 4)
        a = (h, 0, v) if mounting == 1 else (-h, v, 0)
        outputs.append([u0 + k_x * a[0] + k_y * a[1] + k_z * a[2]])
    found = [sympy.simplify(value[0]) for value in estimators.functionals(np.array(outputs))]
    assert found == ([k_z, k_x, u0] if mounting == 1 else [k_y, -k_x, u0])


@pytest.mark.parametrize("quarter_turn", [-8, -1, 0, 1, 2, 3, 7])
def test_sine_and_cosine_are_correctly_rounded_at_30_and_45(quarter_turn):
    for angle in (0, 30, 45, 60, 90):
        degrees = 90 * quarter_turn + angle
        with mpmath.workdps(40):
            turn = mpmath.mpf(degrees) / 180
            expected = float(mpmath.sinpi(turn)), float(mpmath.cospi(turn))
        assert core.sine_cosine(float(degrees)) == expected


def test_sine_and_cosine_of_any_angle():
    rng = np.random.default_rng(42)
    for degrees in rng.uniform(-3600, 3600, 2000):
        with mpmath.workdps(40):
            turn = mpmath.mpf(degrees) / 180
            expected = float(mpmath.sinpi(turn)), float(mpmath.cospi(turn))
        assert core.sine_cosine(degrees) == pytest.approx(expected, abs=2.3e-16, rel=0)


def test_whole_turns_change_no_bit():
    for degrees in (0.125, 22.5, 45.0, 100.25, 359.75):
        assert core.sine_cosine(degrees) == core.sine_cosine(degrees - 360.0 * math.ceil(degrees / 360.0) + 720.0)


def test_witness_is_exact_too():
    rng, attitudes = np.random.default_rng(43), exact_attitudes()
    for estimator in LINEAR:
        for _ in range(50):
            k, u0 = rng.uniform(-1, 1, (3, 3)), rng.uniform(-1, 1, 3) * 0.1
            found_k, found_u0 = model.estimate(PAPER.data, rounded_outputs(k, u0, attitudes), estimator)
            assert max(np.abs(found_k - k).max(), np.abs(found_u0 - u0).max()) < 5e-15 * np.abs(k).max()
