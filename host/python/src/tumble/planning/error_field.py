"""The errors that a stand leaves, to first order: of the gravity check at every position, of |a| at every attitude.

All are linear in independent draws of unit variance, one for each error of the stand and of its noise. The estimator
sees the same draws as the check: on fitted positions the check judges residuals.

The error of |a| at a unit attitude a is a'S a + b'a: `forms` holds S by its six elements, then b. (8) is its exact
counterpart, (|a|^2 - 1)/2. A block whose K2 and K3 are found and applied adds their errors to it, which are of higher
order in a.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.model.errors import by_gains
from tumble.model.estimators import columns_at
from tumble.model.geometry import ideal_force
from tumble.model.norm import climbed, norm_gradient, spread_attitudes
from tumble.planning.case import Case
from tumble.terms import Terms

_ROWS, _COLUMNS = np.triu_indices(3)
_BISECTIONS = 26
_START = 1000  # attitudes
_ROUNDS = 12


@dataclass(frozen=True)
class ErrorField:
    """`gravity` (draws, positions): of the check, g; `forms` (draws, 9): of |a|, g, by K and U0 alone; `unknowns`
    (draws, 12 + 3 x terms): K row by row, V/g, U0, V, and the sizes of the case's further terms, V."""

    gravity: Floats
    forms: Floats
    unknowns: Floats


def error_field(case: Case, estimator: str, k: Floats) -> ErrorField:
    """Of an estimator, for a block of sensitivity `k` (V/g). Raises UsageError where the schedule does not allow it."""
    given = case.propagation(estimator, k)
    outputs = np.concatenate([one.derivative * one.sigma[:, None, None] for one in given.errors().values()])
    found = by_gains(case.schedule, given.gains)(outputs)
    found_k, found_u0 = found[:, :9].reshape(-1, 3, 3), found[:, 9:12]

    force, to_g = ideal_force(case.schedule), np.linalg.inv(k)
    left = outputs - force @ np.swapaxes(found_k, 1, 2) - found_u0[:, None]
    left = left - np.tensordot(found[:, 12:], columns_at(force, case.terms), axes=1)
    gravity = np.einsum("dpi,pi->dp", left @ to_g.T, force)
    return ErrorField(gravity, norm_forms(-to_g @ found_k, -found_u0 @ to_g.T), found)


def norm_forms(matrix: Floats, vector: Floats) -> Floats:
    """Forms (n, 9) of a'M a + v'a for M (n, 3, 3) and v (n, 3)."""
    symmetric = (matrix + np.swapaxes(matrix, 1, 2)) / 2.0
    return np.hstack([symmetric[:, _ROWS, _COLUMNS], vector])


def largest_with_terms(errors: Floats, k: Floats, terms: Terms) -> Floats:
    """The largest error of |a| over all attitudes, g, without sign, by errors (n, 12 + 3 x terms) of the unknowns of a
    block of sensitivity `k`: (n,). Climbed from the largest of a thousand attitudes, to a thousandth of the value."""
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
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2.0
        short = ((half_b / _gaps(middle, values)) ** 2).sum(axis=1) < 1.0
        low, high = np.where(short, low, middle), np.where(short, middle, high)
    lengthwise = np.minimum(half_b**2 / _gaps(high, values), np.abs(half_b))  # no component of a is longer than 1
    found: Floats = high + lengthwise.sum(axis=1)
    return found


def _gaps(lam: Floats, values: Floats) -> Floats:
    """lambda less each eigenvalue; not 0, where only a b of 0 to rounding leads."""
    return np.maximum(lam[:, None] - values, np.finfo(float).tiny ** 0.5)
