"""Limits for a Monte Carlo campaign: what was counted against what was claimed, with room for chance."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.estimators import COEFFICIENTS, OPTIMAL
from tumble.planning.validate import COVERAGE_FACTORS, Validated

CHANCE_SIGMAS = 4.0  # room for chance; about 300 figures are judged, and 1 in 16,000 lies further out
LARGEST_BIAS_U = 0.2
TOLERANCE = 0.02  # of a spread over what was planned, and of the bound over a spread
COVERAGE_LIMITS = {1: (0.6727, 0.6927), 2: (0.945, 0.965), 3: (0.9953, 0.9993)}


@dataclass(frozen=True)
class Judged:
    """Figures by coefficient (12,), `covered`, `low` and `high` by coverage factor too (3, 12); `outside`: in words."""

    bias_over_u: Floats
    spread_over_u: Floats
    efficiency: Floats
    covered: Floats
    low: Floats
    high: Floats
    outside: list[str]


def tolerance(runs: int) -> float:
    """How far a ratio of spreads may be from 1: 2 %, or what chance does to the spread of so few runs."""
    return max(TOLERANCE, CHANCE_SIGMAS / math.sqrt(2.0 * runs))


def bias_limit(runs: int) -> float:
    """The largest bias over u."""
    return LARGEST_BIAS_U + CHANCE_SIGMAS / math.sqrt(runs)


def binomial_limits(count: Integers, runs: int) -> tuple[Floats, Floats]:
    """Wilson's interval for a probability of which `count` of `runs` were seen, CHANCE_SIGMAS wide to each side."""
    seen, z = np.asarray(count) / runs, CHANCE_SIGMAS
    middle = seen + z**2 / (2 * runs)
    half = z * np.sqrt(seen * (1 - seen) / runs + z**2 / (4 * runs**2))
    low, high = (middle - half) / (1 + z**2 / runs), (middle + half) / (1 + z**2 / runs)
    return np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0)


def judge(found: Validated) -> Judged:
    """Every figure, and those outside their limits."""
    runs = found.tally.runs
    low, high = binomial_limits(found.tally.within, runs)
    judged = Judged(
        bias_over_u=found.tally.bias / found.u,
        spread_over_u=found.tally.spread / found.u,
        efficiency=found.bound / found.tally.spread,
        covered=found.tally.within / runs,
        low=low,
        high=high,
        outside=[],
    )
    for index, name in enumerate(COEFFICIENTS):
        judged.outside.extend(f"{name} {what}" for what in _complaints(judged, index, runs, found.estimator))
    return judged


def _complaints(judged: Judged, index: int, runs: int, estimator: str) -> list[str]:
    bias, spread, efficiency = (row[index] for row in (judged.bias_over_u, judged.spread_over_u, judged.efficiency))
    complaints = []
    if not abs(bias) <= bias_limit(runs):
        complaints.append(f"bias {bias:+.2f} u, limit {bias_limit(runs):.2f}")
    if not abs(spread - 1.0) <= tolerance(runs):
        complaints.append(f"spread {spread:.3f} of the planned u, limit 1 +- {tolerance(runs):.3f}")
    if estimator == OPTIMAL and not efficiency >= 1.0 - tolerance(runs):
        complaints.append(f"efficiency {efficiency:.3f}, limit {1.0 - tolerance(runs):.3f}")
    for row, factor in enumerate(COVERAGE_FACTORS):
        least, most = COVERAGE_LIMITS[factor]
        if judged.high[row, index] < least or judged.low[row, index] > most:
            covered = 100 * judged.covered[row, index]
            complaints.append(f"k = {factor} covers {covered:.2f} %, limits {100 * least:.2f} to {100 * most:.2f}")
    return complaints
