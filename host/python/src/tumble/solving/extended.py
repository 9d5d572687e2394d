"""Further terms beside the twelve coefficients (tumble.terms), which the core does not know, by its least squares.

Sizes are found by elimination: the core solves the outputs, and the column of every term, for the twelve; what it
leaves of both has only the terms in common. The outputs without them then have the twelve of all unknowns together,
whose normal equations are the same.
"""

from __future__ import annotations

import numpy as np

from tumble import core
from tumble.arrays import Floats
from tumble.core.optimal import estimate_runs as core_runs
from tumble.errors import BadInput, UsageError
from tumble.model import estimators
from tumble.model.estimators import columns_at
from tumble.model.geometry import ideal_force
from tumble.schedule import Schedule
from tumble.terms import Terms


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
