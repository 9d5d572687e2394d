"""Headroom of a declared stand: how much worse its sources may become before a row of the requirements is exceeded.

`alone`: the largest size of one source while the others stay as declared. `margin`: the factor by which all may grow
together. The optimal estimator is made anew for every stand that is tried.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.errors import UsageError
from tumble.planning import weights
from tumble.planning.budget import sizes as declared_sizes
from tumble.planning.case import Case
from tumble.planning.require import ceilings, sign_patterns, stand_of, weights_by_pattern, with_noise_row

_STEPS = 50


@dataclass(frozen=True)
class Headroom:
    """`alone` (sources,): infinite where nothing limits, 0 where the others take all; `margin`: below 1 on a stand that
    fails; infinite for a stand without errors."""

    alone: Floats
    margin: float


def headroom(case: Case, which: str, estimator: str, limit_g: float) -> Headroom:
    """Of the case's stand, against a third of the limit in every row, for the worst signs of the misalignments."""
    row_limit, sizes = limit_g / 3.0, declared_sizes(case, which == "published")
    gamma = _weights(case, which, estimator, sizes)
    if estimator == "optimal":
        declared = stand_of(case, sizes)
        alone = np.array([_bisect(declared, sizes, source, row_limit) for source in range(len(sizes))])
    else:
        alone = _closed_form(gamma, sizes, row_limit)
    return Headroom(alone, _margin(gamma, sizes, row_limit))


def margins(case: Case, limit_g: float) -> dict[str, float]:
    """The margin of the case's stand with every estimator that its schedule allows, derived weights."""
    sizes, found = declared_sizes(case, False), {}
    for estimator in weights.estimators_of(case):
        with suppress(UsageError):  # the schedule lacks positions that it needs
            found[estimator] = _margin(_weights(case, "derived", estimator, sizes), sizes, limit_g / 3.0)
    return found


def _weights(case: Case, which: str, estimator: str, sizes: Floats) -> Floats:
    """Weights (patterns, 7, 5)."""
    if which == "published":
        return with_noise_row(case, weights.published(case, estimator, weights.WORST))[None]
    return weights_by_pattern(stand_of(case, sizes), estimator, sign_patterns())


def _margin(gamma: Floats, sizes: Floats, row_limit: float) -> float:
    largest = np.linalg.norm(gamma * sizes, axis=2).max()
    return float(row_limit / largest) if largest > 0.0 else np.inf


def _closed_form(gamma: Floats, sizes: Floats, row_limit: float) -> Floats:
    """What each source may be where the weights (patterns, 7, 5) do not depend on the stand."""
    terms = (gamma * sizes) ** 2
    left = row_limit**2 - (terms.sum(axis=2, keepdims=True) - terms)
    rest = np.sqrt(np.maximum(left, 0.0))
    allowed = np.divide(rest, gamma, out=np.where(left >= 0.0, np.inf, 0.0), where=gamma > 0.0)
    smallest: Floats = allowed.min(axis=(0, 1))
    return smallest


def _bisect(case: Case, sizes: Floats, source: int, row_limit: float) -> float:
    """The same for the optimal estimator, whose uncertainties grow with every source. Signs that are worst at the size
    found are added until none is worse."""
    every = sign_patterns()
    chosen: list[int] = []

    def worst(size: float, patterns: Floats) -> tuple[float, int]:
        tried = np.where(np.arange(len(sizes)) == source, size, sizes)
        gamma = weights_by_pattern(stand_of(case, tried), "optimal", patterns)
        totals = np.linalg.norm(gamma * tried, axis=2).max(axis=1)
        return float(totals.max()), int(totals.argmax())

    ceiling = float(ceilings(case)[source])
    while True:
        size = _largest(lambda size: worst(size, every[chosen])[0] <= row_limit, ceiling) if chosen else ceiling
        total, pattern = worst(size, every)
        if total <= row_limit or pattern in chosen or size == 0.0:
            return np.inf if size == ceiling else size
        chosen.append(pattern)


def _largest(fits: Callable[[float], bool], ceiling: float) -> float:
    """The largest size that fits, found in logarithms: 0 if none does, the ceiling if all do."""
    low, high = 1e-9 * ceiling, ceiling
    if fits(high):
        return high
    if not fits(low):
        return 0.0
    for _ in range(_STEPS):
        middle = (low * high) ** 0.5
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low
