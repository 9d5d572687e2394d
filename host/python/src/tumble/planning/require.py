"""Requirements, inverse to the budget: how bad each source of a stand may be for a limit of the gravity check.

By (10), (13) and (14) the six scale factors and biases, and the noise of a mean on its own, may each take a third of
the limit. In each of these rows the sources that enter it share that third; a source's requirement is what the
strictest row allows it. `derived`: worst signs of the misalignments, sizes as standard deviations. The optimal
estimator's weights follow the stand, so its requirements are those of a stand for which it was made: a fixed point.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from tumble.core_averaging import MAX_SAMPLES
from tumble.errors import UsageError
from tumble.planning import weights
from tumble.planning.case import Case
from tumble.planning.gains import linearise
from tumble.planning.published import NAMES, SOURCES
from tumble.stand import COMMON, Stand

ROWS = ("K_xx", "K_yy", "K_zz", "a0_x", "a0_y", "a0_z", "noise")
CEILING_RAD = 0.01  # beyond it nobody has tried the optimal estimator: what it bears up to here limits nothing
_ROW_INDICES = [NAMES.index(name) for name in ROWS[:-1]]
_NOISE = SOURCES.index("noise")
_NEGLIGIBLE = 1e-3  # of a row's limit, by a source at the ceiling: takes less than a millionth of the row's square
_TIE = 1e-9
_MOST_ROUNDS = 400
_SETTLED = 1e-9


@dataclass(frozen=True)
class Requirements:
    """Per source (5,): `limits`, infinite where nothing limits; `set_by`, the row that does, or None. Per row (7, 5):
    `weights`, and `shares` of the row's limit. `samples`: the fewest that bring the noise of a mean under its limit."""

    limits: np.ndarray
    set_by: tuple[str | None, ...]
    samples: int
    weights: np.ndarray
    shares: np.ndarray


def requirements(case: Case, which: str, estimator: str, limit_g: float, split: np.ndarray) -> Requirements:
    """What a limit in g asks of the stand. `split` (5,): how the sources of a row share it, as parts of its square.

    Raises UsageError where weights do not exist or no number of samples suffices.
    """
    share_of = _Shares(limit_g / 3.0, split)
    if which == "published":
        gamma = with_noise_row(case, weights.published(case, estimator, weights.WORST))
        found = share_of.requirements(gamma, gamma > 0.0)
    elif estimator == "optimal":
        found = _fixed_point(case, share_of)
    else:
        gamma = worst_weights(case, estimator)
        found = share_of.requirements(gamma, gamma > 0.0)
    noise = case.stand.noise if which == "published" else case.stand.sigma("noise")
    return replace(found, samples=samples_for(noise, found.limits[_NOISE]))


def samples_for(noise_v: float, limit_v: float) -> int:
    """The fewest samples whose mean is as quiet as required. Raises UsageError beyond what a position can hold."""
    wanted = (noise_v / limit_v) ** 2
    if not wanted <= MAX_SAMPLES:
        raise UsageError(
            f"unreachable: the noise of a mean must be under {limit_v:.3g} V, which would take {wanted:.3g} samples of"
            f" {noise_v:.3g} V at each position; at most {MAX_SAMPLES} fit"
        )
    return max(1, math.ceil(wanted * (1.0 - _TIE)))


def worst_weights(case: Case, estimator: str) -> np.ndarray:
    """Weights (7, 5) of ROWS, each under the signs of the misalignments that are worst for it."""
    return weights_by_pattern(case, estimator, sign_patterns()).max(axis=0)


def weights_by_pattern(case: Case, estimator: str, patterns: np.ndarray) -> np.ndarray:
    """Weights (n, 7, 5) of ROWS for choices of the misalignments' signs, `patterns` (n, 3, 3)."""
    model, common = linearise(case.fitted), case.stand.remounting == COMMON
    fixed = None if estimator == "optimal" else weights.estimator_gains(case, estimator, case.nominal_k())
    found = []
    for pattern in patterns:
        k = case.nominal_k(pattern)
        gain_rows = weights.estimator_gains(case, estimator, k) if fixed is None else fixed
        gamma = weights.absolute_weights(model, common, k, gain_rows) / weights.reference_values(k)[:, None]
        found.append(with_noise_row(case, gamma))
    return np.array(found)


def sign_patterns() -> np.ndarray:
    """All 64 choices of signs of the misalignments: (64, 3, 3), ones on the diagonal."""
    patterns = np.ones((64, 3, 3))
    patterns[:, ~np.eye(3, dtype=bool)] = list(product((1.0, -1.0), repeat=6))
    return patterns


def with_noise_row(case: Case, gamma: np.ndarray) -> np.ndarray:
    """Weights (12, 5) of all coefficients to those (7, 5) of ROWS."""
    noise_alone = np.zeros(len(SOURCES))
    noise_alone[_NOISE] = 1.0 / abs(case.scale)
    return np.vstack([gamma[_ROW_INDICES], noise_alone])


@dataclass(frozen=True)
class _Shares:
    """How the sources share a row of size `row_limit` (g, or relative): `split` (5,) as proportions of its square."""

    row_limit: float
    split: np.ndarray

    def shares(self, counted: np.ndarray) -> np.ndarray:
        """What each source may take of each row (7, 5); 0 where it is not counted."""
        proportions = np.where(counted, self.split, 0.0)
        return self.row_limit * np.sqrt(proportions / proportions.sum(axis=1, keepdims=True))

    def requirements(self, gamma: np.ndarray, counted: np.ndarray) -> Requirements:
        """The strictest row for every source."""
        shares = self.shares(counted)
        with np.errstate(divide="ignore"):
            allowed = np.divide(shares, gamma, out=np.full(gamma.shape, np.inf), where=counted)
        limits = allowed.min(axis=0)
        strictest = [int(np.argmax(column <= limit * (1.0 + _TIE))) for column, limit in zip(allowed.T, limits)]
        set_by = tuple(ROWS[row] if np.isfinite(limit) else None for row, limit in zip(strictest, limits))
        return Requirements(limits, set_by, 1, gamma, shares)


def stand_of(case: Case, sizes: np.ndarray) -> Case:
    """The case on a stand with these standard deviations; the noise is that of a mean."""
    stand = Stand(*map(float, sizes), samples=1, limits="sigma1", remounting=case.stand.remounting)
    return replace(case, stand=stand, step_v=0.0)


def _fixed_point(case: Case, share_of: _Shares) -> Requirements:
    """Requirements on a stand for which the optimal gains are made: each source as large as its shares allow there.

    Searched for with the patterns of signs that were worst so far, confirmed with all of them.
    """
    every = sign_patterns()
    ceiling = np.array([CEILING_RAD] * _NOISE + [abs(case.scale)])
    start = worst_weights(case, "least_squares")
    sizes = np.minimum(share_of.requirements(start, start > 0.0).limits, ceiling)
    chosen: set[int] = set()
    while True:
        by_pattern = weights_by_pattern(stand_of(case, sizes), "optimal", every)
        worst = set(by_pattern.reshape(len(every), -1).argmax(axis=0).tolist())
        if worst <= chosen:
            break
        chosen |= worst
        sizes = _settle(case, share_of, sizes, every[sorted(chosen)], ceiling)
    gamma = by_pattern.max(axis=0)
    found = share_of.requirements(gamma, _counted(gamma, ceiling, share_of))
    unlimited = sizes >= ceiling
    set_by = tuple(None if free else name for free, name in zip(unlimited, found.set_by))
    return replace(found, limits=np.where(unlimited, np.inf, found.limits), set_by=set_by)


def _settle(case: Case, share_of: _Shares, sizes: np.ndarray, patterns: np.ndarray, ceiling: np.ndarray) -> np.ndarray:
    """Sizes that reproduce themselves as requirements. Raises UsageError if there are none."""
    for _ in range(_MOST_ROUNDS):
        gamma = weights_by_pattern(stand_of(case, sizes), "optimal", patterns).max(axis=0)
        allowed = share_of.requirements(gamma, _counted(gamma, ceiling, share_of)).limits
        better = np.sqrt(sizes * np.minimum(allowed, ceiling))
        if np.abs(better / sizes - 1.0).max() < _SETTLED:
            return np.where(better > ceiling * (1.0 - 1e-6), ceiling, better)
        sizes = better
    raise UsageError("no requirements found: the optimal weights do not settle; try another split or limit")


def _counted(gamma: np.ndarray, ceiling: np.ndarray, share_of: _Shares) -> np.ndarray:
    """Which sources enter which row: at the ceiling they could take more than a negligible part of it."""
    return gamma * ceiling > _NEGLIGIBLE * share_of.row_limit
