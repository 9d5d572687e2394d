"""What is known of further terms of the model, and what they cost the twelve coefficients.

Further terms beside the twelve coefficients (tumble.terms), which the core does not know, by its least squares.

Sizes are found by elimination: the core solves the outputs, and the column of every term, for the twelve; what it
leaves of both has only the terms in common. The outputs without them then have the twelve of all unknowns together,
whose normal equations are the same.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import core
from tumble.arrays import Floats
from tumble.core.binding import estimate_runs as core_runs
from tumble.errors import BadInput, UsageError
from tumble.model import estimators
from tumble.model.coefficients import WorstNorm, worst_norm
from tumble.model.estimators import columns_at
from tumble.model.geometry import ideal_force
from tumble.schedule import Schedule
from tumble.terms import POWERS, Terms


@dataclass(frozen=True)
class Without:
    """Standard uncertainties of the same run, stand and estimator without the further terms: `u_k` (3, 3), `u_u0` (3,);
    `worst`: of |a|."""

    u_k: Floats
    u_u0: Floats
    worst: WorstNorm


@dataclass(frozen=True)
class Further:
    """`sizes` (terms, 3) of `terms` beside `k` (3, 3), in the unit of the outputs, and these less the witness's
    (`difference`); `covariance` of K row by row, U0 and the sizes, and what uncertainties would be `without` the terms:
    None without a declared stand."""

    terms: Terms
    k: Floats
    sizes: Floats
    difference: Floats
    covariance: Floats | None = None
    without: Without | None = None

    @property
    def values(self) -> Floats:
        """K2 in 1/g, K3 in 1/g^2, the drift over the run in the unit of the outputs: (terms, 3)."""
        return self.sizes * self.factors

    @property
    def factors(self) -> Floats:
        """Of the values, times the sizes: (terms, 3)."""
        return np.array([1.0 / np.diag(self.k) if term in POWERS else np.ones(3) for term in self.terms])

    @property
    def of_values(self) -> Floats | None:
        """Covariance of K row by row, U0 and the values."""
        if self.covariance is None:
            return None
        by_size = np.diag(np.concatenate([np.ones(12), self.factors.ravel()]))
        for row, (value, factor) in enumerate(zip(self.values.ravel(), self.factors.ravel())):
            if self.terms[row // 3] in POWERS:
                by_size[12 + row, 4 * (row % 3)] = -value * factor  # by K_ii
        found: Floats = by_size @ self.covariance @ by_size.T
        return (found + found.T) / 2.0

    @property
    def u(self) -> Floats | None:
        """Standard uncertainties of `values` (terms, 3)."""
        joint = self.of_values
        return None if joint is None else np.sqrt(np.diag(joint)[12:]).reshape(-1, 3)

    @property
    def worst_norm(self) -> WorstNorm | None:
        """Where the block shows the length of gravity worst, K2 and K3 applied."""
        return None if self.covariance is None else worst_norm(self.k, self.covariance, self.terms)

    @property
    def worst_norm_of_twelve(self) -> WorstNorm | None:
        """The same by what the uncertainties of K and U0 alone bring."""
        return None if self.covariance is None else worst_norm(self.k, self.covariance[:12, :12])


def confused(schedule: Schedule, terms: Terms) -> str | None:
    """What the fit positions cannot tell apart, in words; None where they can."""
    found = [f"{', '.join(them[:-1])} and {them[-1]}" for them in estimators.confused(schedule, terms)]
    return f"these positions cannot tell apart {', nor '.join(found)}" if found else None


def require_told_apart(schedule: Schedule, terms: Terms, file: str = "") -> None:
    """Raise BadInput of the run in `file`, UsageError before there is one, where the fit positions do not determine the
    terms."""
    found = confused(schedule, terms) if terms else None
    if found is not None:
        said = f"--model {','.join(terms)}: {found}"
        raise BadInput(said, file) if file else UsageError(said)


def without(means: Floats, sizes: Floats, schedule: Schedule, terms: Terms) -> Floats:
    """Means (runs, positions, 3) of a whole run without terms of these `sizes` (runs, 3 x terms) on the ideal stand."""
    freed: Floats = means - np.tensordot(sizes, columns_at(ideal_force(schedule), terms), axes=1)
    return freed


def eliminated(schedule: core.CoreSchedule, means: Floats, terms: Terms) -> Floats:
    """Sizes (runs, 3 x terms) by least squares, of means (runs, positions, 3), all measured. Raises CoreRefusal."""
    force, fit = ideal_force(schedule.data), schedule.data.fit_indices

    def left(outputs: Floats) -> Floats:
        twelve = core_runs(schedule, outputs, "least_squares")
        rest = outputs - force @ np.swapaxes(twelve[:, :9].reshape(-1, 3, 3), 1, 2) - twelve[:, None, 9:]
        return rest[:, fit].reshape(len(outputs), -1)

    shown, rest = left(columns_at(force, terms)), left(means)
    return np.linalg.lstsq(shown.T, rest.T, rcond=None)[0].T.astype(float)


def least_squares(schedule: core.CoreSchedule, means: Floats, terms: Terms) -> Floats:
    """K row by row, U0 and the sizes (runs, 12 + 3 x terms). Raises CoreRefusal."""
    sizes = eliminated(schedule, means, terms)
    twelve = core_runs(schedule, without(means, sizes, schedule.data, terms), "least_squares")
    return np.concatenate([twelve, sizes], axis=1)
