"""Chi-squared, Student's t and F: distribution functions and quantiles, from the regularised incomplete gamma and beta
functions (series and continued fractions, to about 1e-13). Degrees of freedom are any positive numbers, for F also
infinite."""

from __future__ import annotations

import math
from collections.abc import Callable

_TINY = 1e-300
_SETTLED = 1e-16
_MOST_TERMS = 100000
_BISECTIONS = 200


def chi_squared_cdf(x: float, freedom: float) -> float:
    """Probability of at most `x`."""
    return _gamma_p(freedom / 2, max(x, 0.0) / 2)


def f_cdf(x: float, freedom: float, below: float) -> float:
    """Probability of at most `x`, with `freedom` degrees of freedom over `below`, which may be infinite."""
    if x <= 0.0:
        return 0.0
    if math.isinf(below):
        return chi_squared_cdf(x * freedom, freedom)
    scaled = freedom * x
    return _beta_i(freedom / 2, below / 2, scaled / (scaled + below), below / (scaled + below))


def chi_squared_quantile(p: float, freedom: float) -> float:
    """The value that is not exceeded with probability `p`, 0 < p < 1."""
    return _inverse(lambda x: chi_squared_cdf(x, freedom), p)


def f_quantile(p: float, freedom: float, below: float) -> float:
    """Likewise, of F."""
    return _inverse(lambda x: f_cdf(x, freedom, below), p)


def student_quantile(p: float, freedom: float) -> float:
    """The value that Student's t exceeds in size, on either side, with probability 1 - p: its square is an F."""
    return math.sqrt(f_quantile(p, 1.0, freedom))


def _inverse(cdf: Callable[[float], float], p: float) -> float:
    """Where a distribution function of positive numbers reaches p: bisection, by powers of two first."""
    if not 0.0 < p < 1.0:
        raise ValueError(f"a probability between 0 and 1, not {p}")
    low, high = 0.5, 1.0
    while cdf(low) > p and low > _TINY:
        low, high = low / 2, low
    while cdf(high) < p:
        low, high = high, high * 2
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        if not low < middle < high:
            break
        low, high = (middle, high) if cdf(middle) < p else (low, middle)
    return (low + high) / 2


def _gamma_p(a: float, x: float) -> float:
    """The regularised lower incomplete gamma function: series below the mean, Legendre's continued fraction above."""
    if x <= 0.0:
        return 0.0
    front = math.exp(a * math.log(x) - x - math.lgamma(a))
    if x >= a + 1.0:
        return 1.0 - front * _continued(lambda n: -n * (n - a), lambda n: x + 2 * n + 1 - a)
    term = total = 1.0 / a
    for n in range(1, _MOST_TERMS):
        term *= x / (a + n)
        total += term
        if term < total * _SETTLED:
            break
    return front * total


def _beta_i(a: float, b: float, x: float, rest: float) -> float:
    """The regularised incomplete beta function of x; `rest` is 1 - x, given apart so that neither loses digits."""
    if x > (a + 1.0) / (a + b + 2.0):
        return 1.0 - _beta_i(b, a, rest, x)
    log_beta = math.lgamma(a) + math.lgamma(b) - math.lgamma(a + b)
    front = math.exp(a * math.log(x) + b * math.log(rest) - log_beta) if x > 0.0 else 0.0

    def numerator(n: int) -> float:
        half = n // 2
        if n % 2 == 0:
            return half * (b - half) * x / ((a + n - 1) * (a + n))
        return -(a + half) * (a + b + half) * x / ((a + n - 1) * (a + n))

    return front / a * _continued(numerator, lambda n: 1.0)


def _continued(numerator: Callable[[int], float], denominator: Callable[[int], float]) -> float:
    """1 / (d0 + n1 / (d1 + n2 / (d2 + ...))), by Lentz's method in the form of Thompson and Barnett."""
    value = denominator(0) or _TINY
    c, d = value, 0.0
    for n in range(1, _MOST_TERMS):
        d = 1.0 / ((denominator(n) + numerator(n) * d) or _TINY)
        c = (denominator(n) + numerator(n) / c) or _TINY
        value *= c * d
        if abs(c * d - 1.0) < 4 * _SETTLED:
            break
    return 1.0 / value
