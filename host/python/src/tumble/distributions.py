"""Chi-squared, Student's t and F: distribution functions and quantiles, from the regularised incomplete gamma and beta
functions (series and continued fractions, to about 1e-13; of F with more than 1e6 degrees of freedom below to 1e-8).
Degrees of freedom are any positive numbers, for F also infinite, for chi-squared also 0: then it is always 0."""

from __future__ import annotations

import math
from collections.abc import Callable

_TINY = 1e-300
_HUGE = 1e300
_SETTLED = 1e-16
_MOST_TERMS = 100000
_BISECTIONS = 200
_AS_GOOD_AS_INFINITE = 1e9
_STIRLING_FROM = 50.0


def chi_squared_cdf(x: float, freedom: float) -> float:
    """Probability of at most `x`."""
    return _gamma_p(freedom / 2, max(x, 0.0) / 2) if freedom > 0.0 else float(x >= 0.0)


def f_cdf(x: float, freedom: float, below: float) -> float:
    """Probability of at most `x`, with `freedom` degrees of freedom over `below`, which may be infinite."""
    if x <= 0.0:
        return 0.0
    if below > _AS_GOOD_AS_INFINITE:
        return chi_squared_cdf(x * freedom, freedom)
    scaled = freedom * x
    if math.isinf(scaled):
        return 1.0
    return _beta_i(freedom / 2, below / 2, scaled / (scaled + below), below / (scaled + below))


def chi_squared_quantile(p: float, freedom: float) -> float:
    """The value that is not exceeded with probability `p`, 0 < p < 1."""
    return _inverse(lambda x: chi_squared_cdf(x, freedom), p) if freedom > 0.0 else 0.0


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
    while cdf(high) < p and high < _HUGE:  # of hardly any freedom it is beyond all numbers
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
        return 1.0 - _beta_fraction(b, a, rest, x)
    return _beta_fraction(a, b, x, rest)


def _beta_fraction(a: float, b: float, x: float, rest: float) -> float:
    """Likewise, where the continued fraction converges fast."""
    if x <= 0.0:
        return 0.0
    if rest <= 0.0:
        return 1.0
    front = math.exp(a * _log(x, rest) + b * _log(rest, x) - _log_beta(a, b))

    def numerator(n: int) -> float:
        half = n // 2
        if n % 2 == 0:
            return half * (b - half) * x / ((a + n - 1) * (a + n))
        return -(a + half) * (a + b + half) * x / ((a + n - 1) * (a + n))

    return front / a * _continued(numerator, lambda n: 1.0)


def _log(x: float, rest: float) -> float:
    """Of a number whose distance from 1 is known as well."""
    return math.log(x) if x < 0.5 else math.log1p(-rest)


def _log_beta(a: float, b: float) -> float:
    """Of the complete beta function. Of a large argument the log-gammas would cancel; Stirling's series do not."""
    small, large = min(a, b), max(a, b)
    if large < _STIRLING_FROM:
        return math.lgamma(a) + math.lgamma(b) - math.lgamma(a + b)
    both = small + large
    rest = _stirling(large) - _stirling(both)
    return math.lgamma(small) + small - small * math.log(both) - (large - 0.5) * math.log1p(small / large) + rest


def _stirling(z: float) -> float:
    """Log-gamma beyond (z - 1/2) log z - z + log(2 pi)/2."""
    return (1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - 1.0 / (1680.0 * z * z)) / (z * z)) / (z * z)) / z


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
