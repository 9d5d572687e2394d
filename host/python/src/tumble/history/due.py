"""When a block is to be calibrated again, so that the length |a| that it shows stays within a limit at every attitude.

By its control chart (ILAC-G24 / OIML D 10:2022, method 2): with the coefficients of its last calibration a block shows
at the attitude n, tau days later, a length that is off by m on average, with a variance about it:

    m = g r tau,    variance = g C g + sum over parameters of g^2 (walk^2 tau + 2 c tau + p tau^2)

Here are g the derivatives of |a| by the parameters, C the covariance of the calibration, r the rate of the block as
its filter knows it, p the variance of r, and c its covariance with the last value. r and p are those of its type while
the block has few calibrations. The block is due where |m| + coverage factor x standard uncertainty reaches the limit,
which is a quadratic equation in tau, at the attitude where that is soonest.

The filter's mean x differs from the last calibration y. That difference is not in m but in C: the variance of y about
the truth is that of the filter plus that of x - y, and its covariance with the rate is c. So the limit holds for the
stated share of all blocks, not of those with the same x - y. At tau = 0 the uncertainty is then the one that the result
states, with its correlations; the filter, which takes one parameter at a time, does not know them. Where y is too far
from x, that is an alarm.

By the staircase (method 1 there) nothing but the last interval counts, from the last calibration that is a day earlier
at least: where the last calibration found |a| off by at most KEPT of the limit, the next interval is LONGER times as
long, within the limit it stays, else it is SHORTER.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from tumble.arrays import Floats
from tumble.history.calibrations import OF_BLOCK
from tumble.history.trend import State
from tumble.model.coefficients import climbed, spread_attitudes

CONTROL_CHART, STAIRCASE = METHODS = ("control-chart", "staircase")
KEPT, LONGER, SHORTER = 0.8, 1.25, 0.5
_ATTITUDES, _ROUNDS, _AT_ONCE = 200, 20, 1000


@dataclass(frozen=True)
class Forecast:
    """Of blocks, at their last calibrations: `angles` (blocks, 3) between the axes and `bias` (blocks, 3) in g;
    `covariance` (blocks, 9, 9), `rate` (blocks, 9) per day; `linear` and `square` (blocks, 9): growth of the variances
    of the parameters by tau and by its square."""

    angles: Floats
    bias: Floats
    covariance: Floats
    rate: Floats
    linear: Floats
    square: Floats

    @classmethod
    def of(cls, angles: Floats, bias: Floats, covariance: Floats, last: State, walk: Floats) -> Forecast:
        """By what a filter knows at the end."""
        rate, p_xr, p_rr = (one[:, :OF_BLOCK] for one in (last.rate, last.p_xr, last.p_rr))
        return cls(angles, bias, covariance, rate, walk[:OF_BLOCK] ** 2 + 2.0 * p_xr, p_rr)

    def part(self, blocks: slice) -> Forecast:
        """Some of them."""
        return Forecast(*(one[blocks] for one in vars(self).values()))

    def days_at(self, limit_g: float, coverage: float, attitudes: Floats) -> Floats:
        """After how many days the limit is reached at `attitudes` (blocks, n, 3): (blocks, n), infinite where it never
        is."""
        g = norm_gradients(self.angles, self.bias, attitudes)
        at_once = coverage**2 * np.einsum("bni,bij,bnj->bn", g, self.covariance, g)
        linear, square = (coverage**2 * np.einsum("bni,bi->bn", g**2, one) for one in (self.linear, self.square))
        drift = np.abs(np.einsum("bni,bi->bn", g, self.rate))
        # (limit - drift tau)^2 = at_once + linear tau + square tau^2, the smaller root
        a, b, c = drift**2 - square, 2.0 * limit_g * drift + linear, limit_g**2 - at_once
        with np.errstate(divide="ignore", invalid="ignore"):
            found = 2.0 * c / (b + np.sqrt(np.maximum(b**2 - 4.0 * a * c, 0.0)))
        return np.where(c <= 0.0, 0.0, np.where(np.isnan(found), np.inf, found))

    def days(self, limit_g: float, coverage: float) -> Floats:
        """The same at the attitude where it is soonest: (blocks,)."""
        found = np.zeros(len(self.rate))
        for at in range(0, len(found), _AT_ONCE):
            part = self.part(slice(at, at + _AT_ONCE))
            inverse_days = partial(_inverse_days, part, limit_g, coverage)
            with np.errstate(divide="ignore"):
                found[at : at + _AT_ONCE] = 1.0 / largest_over_attitudes(inverse_days, len(part.rate))
        return found


def _inverse_days(forecast: Forecast, limit_g: float, coverage: float, attitudes: Floats) -> Floats:
    with np.errstate(divide="ignore"):
        found: Floats = 1.0 / forecast.days_at(limit_g, coverage, attitudes)
    return found


def worst_changes(angles: Floats, bias: Floats, changes: Floats) -> Floats:
    """By how much |a| is off, g, at the worst attitude, for `changes` (blocks, 9) of the parameters: (blocks,)."""

    def off(some: slice, attitudes: Floats) -> Floats:
        gradients = norm_gradients(angles[some], bias[some], attitudes)
        found: Floats = np.abs(np.einsum("bni,bi->bn", gradients, changes[some]))
        return found

    parts = [slice(at, at + _AT_ONCE) for at in range(0, len(changes), _AT_ONCE)]
    largest = (largest_over_attitudes(partial(off, one), len(changes[one])) for one in parts)
    return np.concatenate([np.zeros(0), *largest])


def staircase(interval_days: Floats, found_g: Floats, limit_g: float) -> Floats:
    """The next interval, after one in which |a| was found to be off by so much."""
    factor = np.where(found_g <= KEPT * limit_g, LONGER, np.where(found_g <= limit_g, 1.0, SHORTER))
    return interval_days * factor


def largest_over_attitudes(values: Callable[[Floats], Floats], blocks: int) -> Floats:
    """The largest of the `values` (blocks, n) of every block at attitudes (blocks, n, 3): (blocks,)."""
    start = np.broadcast_to(spread_attitudes(_ATTITUDES), (blocks, _ATTITUDES, 3))
    seen = values(start)
    best = seen.argmax(axis=1)
    return climbed(values, start[np.arange(blocks), best], seen[np.arange(blocks), best], _ROUNDS)[1]


def norm_gradients(angles: Floats, bias: Floats, attitudes: Floats) -> Floats:
    """Derivatives (blocks, n, 9) of how much |a| falls short, by the logarithms of the scales, the angles and the
    biases, at `attitudes` (blocks, n, 3). With K = S M, rows of M of length 1, and h = n M^-1 they are h (M n + bias),
    h dM n and h."""
    axes = sensitive_axes(angles)
    shown = np.einsum("bij,bnj->bni", axes, attitudes)
    h = np.einsum("bnj,bji->bni", attitudes, np.linalg.inv(axes))
    step = 1e-30
    by_angle = [sensitive_axes(angles + 1j * step * unit).imag / step for unit in np.eye(3)]
    turned = [(h * np.einsum("bij,bnj->bni", one, attitudes)).sum(axis=2) for one in by_angle]
    return np.concatenate([h * (shown + bias[:, None]), np.stack(turned, axis=2), h], axis=2)


def sensitive_axes(angles: Floats) -> Floats:
    """Unit vectors, the rows of (blocks, 3, 3), with these angles xy, xz, yz between them; x first, y in the plane of
    x and y."""
    xy, xz, yz = np.cos(angles).T
    sine = np.sin(angles[:, 0])
    middle = (yz - xz * xy) / sine
    zero, one = np.zeros_like(xy), np.ones_like(xy)
    rows = [one, zero, zero, xy, sine, zero, xz, middle, np.sqrt(1.0 - xz**2 - middle**2)]
    return np.stack(rows, axis=-1).reshape(-1, 3, 3)
