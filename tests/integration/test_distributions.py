"""Chi-squared, Student's t and F against mpmath."""

import math

import mpmath
import numpy as np
import pytest
from hypothesis import given, strategies as st

from tumble import distributions

pytestmark = pytest.mark.python

FREEDOM = st.one_of(st.integers(1, 60), st.floats(0.3, 5000.0), st.integers(60, 20000))
mpmath.mp.dps = 30


def exact_chi_squared(x, freedom):
    return mpmath.gammainc(mpmath.mpf(freedom) / 2, 0, mpmath.mpf(x) / 2, regularized=True)


def exact_f(x, freedom, below):
    scaled = mpmath.mpf(freedom) * mpmath.mpf(x)
    halves = mpmath.mpf(freedom) / 2, mpmath.mpf(below) / 2
    try:
        return mpmath.betainc(*halves, 0, scaled / (scaled + below), regularized=True)
    except ValueError:  # its series does not converge: from the other end
        return 1 - mpmath.betainc(*reversed(halves), 0, below / (scaled + below), regularized=True)


@given(FREEDOM, st.floats(-4.0, 4.0))
def test_chi_squared(freedom, sigmas):
    x = freedom * max(1e-6, 1 + sigmas * math.sqrt(2 / freedom))
    assert distributions.chi_squared_cdf(x, freedom) == pytest.approx(float(exact_chi_squared(x, freedom)), abs=2e-11)


@given(FREEDOM, st.floats(0.2, 40.0))
def test_a_small_probability_keeps_its_digits(freedom, times):
    """Also where it is less than the smallest number."""
    x = freedom * times
    exact = mpmath.log(mpmath.gammainc(mpmath.mpf(freedom) / 2, mpmath.mpf(x) / 2, regularized=True))
    assert distributions.chi_squared_log_above(x, freedom) == pytest.approx(float(exact), rel=1e-9, abs=2e-11)


def test_chi_squared_of_no_freedom_is_always_zero():
    assert [distributions.chi_squared_cdf(x, 0) for x in (-1.0, 0.0, 1.0)] == [0.0, 1.0, 1.0]
    assert distributions.chi_squared_quantile(0.95, 0) == 0.0


@given(FREEDOM, st.floats(0.3, 3000.0), st.floats(0.001, 30.0))
def test_f(freedom, below, x):
    assert distributions.f_cdf(x, freedom, below) == pytest.approx(float(exact_f(x, freedom, below)), abs=2e-11)


@given(st.floats(1.0, 40.0), st.floats(3.0, 30.0), st.floats(0.01, 20.0))
def test_f_of_an_angle_that_is_known_far_better_than_its_limit(freedom, decades, x):
    """So many degrees of freedom that the fraction's threshold, rounded, must not send it back and forth."""
    below = 10.0**decades
    exact = exact_chi_squared(x * freedom, freedom) if below > 1e11 else exact_f(x, freedom, below)
    assert distributions.f_cdf(x, freedom, below) == pytest.approx(float(exact), abs=1e-8)


@given(FREEDOM, st.floats(0.001, 0.999))
def test_quantiles_of_chi_squared(freedom, p):
    x = distributions.chi_squared_quantile(p, freedom)
    assert float(exact_chi_squared(x, freedom)) == pytest.approx(p, abs=1e-10)


@given(st.floats(0.5, 300.0), st.floats(0.5, 0.9999))
def test_quantiles_of_student(freedom, p):
    t = distributions.student_quantile(p, freedom)
    density = lambda x: (1 + x * x / freedom) ** (-(freedom + 1) / 2)  # noqa: E731
    beta = mpmath.beta(mpmath.mpf(freedom) / 2, mpmath.mpf(1) / 2) * mpmath.sqrt(freedom)
    assert float(2 * mpmath.quad(density, [0, t]) / beta) == pytest.approx(p, abs=1e-9)


@pytest.mark.parametrize(
    ("function", "arguments", "tabled"),
    [
        (distributions.chi_squared_quantile, (0.95, 1), 3.841459),
        (distributions.chi_squared_quantile, (0.05, 1), 0.00393214),
        (distributions.chi_squared_quantile, (0.95, 16), 26.296228),
        (distributions.chi_squared_quantile, (0.05, 16), 7.961646),
        (distributions.student_quantile, (0.95, 8), 2.306004),
        (distributions.student_quantile, (0.99, 1), 63.656741),
        (distributions.student_quantile, (0.95, math.inf), 1.959964),
        (distributions.f_quantile, (0.95, 3, 10), 3.708265),
    ],
)
def test_the_tables_of_textbooks(function, arguments, tabled):
    assert function(*arguments) == pytest.approx(tabled, rel=1e-6)


@pytest.mark.parametrize("p", [0.0, 1.0, -0.1, 1.5, math.nan])
def test_a_quantile_needs_a_probability(p):
    with pytest.raises(ValueError, match="a probability between 0 and 1"):
        distributions.chi_squared_quantile(p, 3)


def test_hardly_any_freedom_is_answered_too():
    """The freedom of a set angle's error goes to 0 where noise covers it;
    what is beyond all numbers is huge instead."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        freedom, below, p = *10.0 ** rng.uniform(-6, 6, 2), rng.uniform(1e-3, 0.999)
        for value in (distributions.f_quantile(p, freedom, below), distributions.student_quantile(p, freedom)):
            assert 0.0 <= value < math.inf
    assert distributions.student_quantile(0.95, 1e-6) > 1e100
