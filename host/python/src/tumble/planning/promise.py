"""What a stand promises: the probabilities that a run passes the gravity check, and that |a| is within the limit at
every attitude.

The errors that a stand leaves, of the gravity check at every position and of |a| at every attitude, are taken to first
order (`ErrorField`). All are linear in independent draws of unit variance, one for each error of the stand and of its
noise. The estimator sees the same draws as the check: on fitted positions the check judges residuals.

The error of |a| at a unit attitude a is a'S a + b'a: `forms` holds S by its six elements, then b. (8) is its exact
counterpart, (|a|^2 - 1)/2. A block whose further terms are found and applied adds their errors to it, which are of
higher order in a.

The errors are jointly normal, to first order. A normal vector is a length, whose law is chi, times a direction, all of
which are alike; and what is asked for, the largest of its errors, grows with the length in proportion. So

    P(largest <= limit) = mean over directions of F_chi(limit / largest of the direction)

and the same directions serve every limit. They are drawn once, from a fixed seed; the standard error of the mean is
given with each probability.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache

import numpy as np
from msgspec import structs

from tumble.arrays import Floats
from tumble.documents.plan import GrowingPromise, Promise
from tumble.errors import UsageError
from tumble.model.coefficients import climbed, norm_gradient, spread_attitudes, worst_norm
from tumble.planning.case import Case
from tumble.planning.tables import percent
from tumble.planning.weights import estimators_of
from tumble.solving.decision import ASSUMPTIONS, is_shown, rests_on_a_seat
from tumble.terms import POWERS, Terms

_ROWS, _COLUMNS = np.triu_indices(3)
_EIGEN_BISECTIONS = 26
_START = 1000  # attitudes
_ROUNDS = 12


@dataclass(frozen=True)
class ErrorField:
    """`gravity` (draws, positions): errors of the check, g. `forms` (draws, 9): errors of |a|, g, by K and U0 alone.
    `unknowns` (draws, 12 + 3 x terms): K row by row, V/g, U0, V, and sizes of the extended terms, V."""

    gravity: Floats
    forms: Floats
    unknowns: Floats

    @property
    def covariance(self) -> Floats:
        """The covariance of the unknowns."""
        found: Floats = self.unknowns.T @ self.unknowns
        return found


def error_field(case: Case, estimator: str, k: Floats) -> ErrorField:
    """The error field of an estimator for a block of sensitivity `k` (V/g). Raises UsageError where the schedule does
    not allow it."""
    given = case.propagation(estimator, k)
    outputs = np.concatenate([one.derivative * one.sigma[:, None, None] for one in given.errors().values()])
    found, _, gravity = given.of_means(outputs)
    to_g = np.linalg.inv(k)
    forms = norm_forms(-to_g @ found[:, :9].reshape(-1, 3, 3), -found[:, 9:12] @ to_g.T)
    return ErrorField(gravity, forms, found)


def norm_forms(matrix: Floats, vector: Floats) -> Floats:
    """The forms (n, 9) of a'M a + v'a for M (n, 3, 3) and v (n, 3)."""
    symmetric = (matrix + np.swapaxes(matrix, 1, 2)) / 2.0
    return np.hstack([symmetric[:, _ROWS, _COLUMNS], vector])


def largest_with_terms(errors: Floats, k: Floats, terms: Terms) -> Floats:
    """The largest error of |a| over all attitudes, g, unsigned (n,), for errors (n, 12 + 3 x terms) of the unknowns of
    a block of sensitivity `k`. Refined from the largest of a thousand attitudes to a thousandth of the value."""
    start = spread_attitudes(_START)
    at_start = np.abs(errors @ norm_gradient(k, start, terms).T)

    def heights(attitudes: Floats) -> Floats:
        found: Floats = np.abs(np.einsum("nam,nm->na", norm_gradient(k, attitudes, terms), errors, optimize=True))
        return found

    return climbed(heights, start[at_start.argmax(axis=1)], at_start.max(axis=1), _ROUNDS)[1]


def largest_over_attitudes(forms: Floats) -> Floats:
    """The largest |a'S a + b'a| over all unit a, for forms (n, 9): (n,)."""
    s = np.empty((len(forms), 3, 3))
    s[:, _ROWS, _COLUMNS] = s[:, _COLUMNS, _ROWS] = forms[:, :6]
    values, axes = np.linalg.eigh(s)
    half_b = np.einsum("nij,ni->nj", axes, forms[:, 6:]) / 2.0
    return np.maximum(_maximum(values, half_b), _maximum(-values[:, ::-1], half_b[:, ::-1]))


def _maximum(values: Floats, half_b: Floats) -> Floats:
    """Of a'S a + b'a on the unit sphere, in the axes of S, by its eigenvalues in rising order. A maximum has
    (lambda - S) a = b/2 with lambda beyond all eigenvalues, where such an a has length 1. The length falls with lambda,
    so bisection finds it; the value is then right to 1e-8 of b at least."""
    top = values[:, 2]
    low, high = top + np.abs(half_b[:, 2]), top + np.linalg.norm(half_b, axis=1)

    def gaps(lam: Floats) -> Floats:
        """Lambda less each eigenvalue; a gap is 0 only where b is 0 to rounding, and is replaced by a tiny number."""
        return np.maximum(lam[:, None] - values, np.finfo(float).tiny ** 0.5)

    for _ in range(_EIGEN_BISECTIONS):
        middle = (low + high) / 2.0
        short = ((half_b / gaps(middle)) ** 2).sum(axis=1) < 1.0
        low, high = np.where(short, low, middle), np.where(short, middle, high)
    lengthwise = np.minimum(half_b**2 / gaps(high), np.abs(half_b))  # no component of a is longer than 1
    found: Floats = high + lengthwise.sum(axis=1)
    return found


ON_A_SEAT = f"Assuming {ASSUMPTIONS['seat'].phrase}: {ASSUMPTIONS['seat'].why}."
_SEED = 1
_DIRECTIONS = {"positions": 32768, "attitudes": 8192}
_LIMIT_BISECTIONS = 6
_STEPS = 50
_SETTLED = 1e-11  # of a probability
_TINY = 1e-300
_FAR = 37.0  # standard deviations: beyond them nothing is left in a double


@dataclass(frozen=True)
class Law:
    """The law of a largest error: `sizes` (directions,), g, of unit draws in `freedom` dimensions, an even number."""

    sizes: Floats
    freedom: int

    @classmethod
    def of(cls, draws: Floats, directions: int, largest: Callable[[Floats], Floats]) -> Law:
        """`draws` (n, m): m errors by independent draws of unit variance; `largest`: from (directions, m) to
        (directions,). The symmetric root of the errors' covariance changes no more than the errors do, so near stands
        have near probabilities."""
        _, singular, axes = np.linalg.svd(draws, full_matrices=False)
        root = axes.T * singular @ axes
        unit = _unit_vectors(directions, len(root) + len(root) % 2)  # one more that does nothing: even laws are sums
        return cls(largest(unit[:, : len(root)] @ root), unit.shape[1])

    def chance(self, limit_g: float) -> tuple[float, float]:
        """The probability that the largest error is within a limit, and its standard error."""
        half = np.minimum(limit_g / np.maximum(self.sizes, _TINY), _FAR) ** 2 / 2.0
        term = np.exp(-half)
        beyond = term.copy()
        for index in range(1, self.freedom // 2):
            term *= half / index
            beyond += term
        return float(1.0 - beyond.mean()), float(beyond.std() / len(beyond) ** 0.5)

    def limit(self, probability: float) -> float:
        """The limit, g, that is kept with a given probability: by bisection until the law is no longer flat, then by
        false position with the Illinois rule."""
        low, high = 0.0, float(self.sizes.max()) * _FAR
        for _ in range(_LIMIT_BISECTIONS):
            middle = (low + high) / 2.0
            low, high = (low, middle) if self.chance(middle)[0] >= probability else (middle, high)
        below, above = (self.chance(limit)[0] - probability for limit in (low, high))
        moved = 0
        for _ in range(_STEPS):
            if above < _SETTLED:
                break
            at = high - (high - low) * above / (above - below)
            found = self.chance(at)[0] - probability
            if found >= 0.0:
                high, above, below, moved = at, found, below / (2.0 if moved > 0 else 1.0), 1
            else:
                low, below, above, moved = at, found, above / (2.0 if moved < 0 else 1.0), -1
        return high


@cache
def _unit_vectors(count: int, dimensions: int) -> Floats:
    normal = np.random.default_rng(_SEED).standard_normal((count, dimensions))
    unit: Floats = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    return unit


def promise(case: Case, estimator: str, k: Floats | None = None) -> Promise:
    """The promise of the stand and limit of a case, for a block of sensitivity `k` (V/g), by default the nominal one.
    Raises UsageError where the schedule does not allow the estimator."""
    return _promise(case, estimator, case.nominal_k() if k is None else k)[0]


def growing_promise(case: Case, estimator: str, probability: float) -> GrowingPromise:
    """The promise for the nominal block, and the factor by which errors may grow for a given `probability`."""
    found, check, norm = _promise(case, estimator, case.nominal_k())
    needed = max(check.limit(probability), norm.limit(probability), case.coverage_factor * found.u_norm_worst_g)
    growth = case.limit_g / needed if needed > 0.0 else np.inf
    return GrowingPromise(**structs.asdict(found), growth=growth if np.isfinite(growth) else None)


def _promise(case: Case, estimator: str, k: Floats) -> tuple[Promise, Law, Law]:
    """The promise with the laws of the gravity check and of |a|, for which further terms need more than a quadratic
    form."""
    field, count = error_field(case, estimator, k), _DIRECTIONS["attitudes"]
    check = Law.of(field.gravity, _DIRECTIONS["positions"], lambda errors: np.abs(errors).max(axis=1))
    if set(case.terms) & set(POWERS):
        norm = Law.of(field.unknowns, count, lambda errors: largest_with_terms(errors, k, case.terms))
    else:
        norm = Law.of(field.forms, count, largest_over_attitudes)
    u_norm_g, bolted_once = worst_norm(k, field.covariance, case.terms).worst_g, len(case.fitted.boltings) == 1
    (passes, u_passes), (everywhere, u_everywhere) = check.chance(case.limit_g), norm.chance(case.limit_g)
    found = Promise(
        limit_g=case.limit_g,
        passes=passes,
        u_passes=u_passes,
        every_attitude=everywhere,
        u_every_attitude=u_everywhere,
        u_norm_worst_g=u_norm_g,
        coverage_factor=case.coverage_factor,
        shown=is_shown(case.limit_g, case.coverage_factor, u_norm_g),
        # of one bolting the seat turns all attitudes alike: no length feels it
        assumes=("seat",) if not bolted_once and rests_on_a_seat(case.fitted, k, case.stand, case.terms) else (),
    )
    return found, check, norm


def sentence(found: Promise) -> str:
    """The promise for people, in two lines, and its conditions."""
    return (
        f"A run passes the gravity check of {found.limit_g:g} g with a probability of {percent(found.passes)};\n"
        f"|a| is within that limit at every attitude with {percent(found.every_attitude)}.{condition(found)}"
    )


def condition(found: Promise) -> str:
    """The conditions of the promise as a further line; empty if there are none."""
    return f"\n{ON_A_SEAT}" if found.assumes else ""


def promises(case: Case, probability: float) -> dict[str, GrowingPromise]:
    """The promise of every estimator that the schedule allows."""
    found = {}
    for estimator in estimators_of(case):
        with suppress(UsageError):  # the schedule lacks positions that it needs
            found[estimator] = growing_promise(case, estimator, probability)
    return found
