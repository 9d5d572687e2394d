"""Further terms beside the twelve coefficients (tumble.terms), for many runs at once.

Least squares is done by elimination: the core solves the outputs, and the column of every further term, for the twelve;
what it leaves of both has only the terms in common. `optimal` is a table of gains made with these columns, evaluated as
the core does it: linearly, then twice with what the exact geometry has beyond its linearisation taken out. The witness
solves all unknowns in one dense problem.
"""

from __future__ import annotations

import numpy as np

from tumble import core, reference
from tumble.arrays import Floats
from tumble.core.optimal import estimate_runs as core_runs, require_small
from tumble.errors import BadInput, UsageError
from tumble.reference.estimators import fit_indices
from tumble.schedule import Schedule
from tumble.solving.gains import Linearised, OptimalTable, exact_force, linearise
from tumble.terms import DRIFT, POWERS, Terms

_CORRECTIONS = 2
_STEPS = 200
_ROUNDED = 1e-12  # of the largest component
_LEAST_OWN = 0.1  # of the length of a row of K


class NotSolvable(Exception):
    """Of outputs from which further terms do not let a specific force be found; says why."""


def columns(schedule: core.CoreSchedule, terms: Terms) -> Floats:
    """Outputs by the size of every term, by term and channel: (3 x terms, positions, 3)."""
    return columns_at(schedule.attitudes(), terms)


def columns_at(force: Floats, terms: Terms) -> Floats:
    """The same at specific forces (positions, 3), in the order of the run."""
    count = len(force)
    felt = {term: force**power for term, power in POWERS.items()}
    felt[DRIFT] = np.repeat(_time(count), 3, axis=1)
    found = [felt[term] * np.eye(3)[i] for term in terms for i in range(3)]
    return np.array(found).reshape(-1, count, 3)


def fitted_columns(schedule: core.CoreSchedule, terms: Terms) -> Floats:
    """Of the fit positions: (3 x fit positions, 3 x terms)."""
    fit = fit_indices(schedule.data)
    return columns(schedule, terms)[:, fit].reshape(3 * len(terms), 3 * len(fit)).T


def _time(count: int) -> Floats:
    """Of the positions, which take equally long: (positions, 1)."""
    return np.arange(count)[:, None] / max(1, count - 1) - 0.5


def confused(schedule: Schedule, terms: Terms) -> str | None:
    """What the fit positions cannot tell apart, in words; None where they can."""
    found = [f"{', '.join(them[:-1])} and {them[-1]}" for them in reference.confused(schedule, terms)]
    return f"these positions cannot tell apart {', nor '.join(found)}" if found else None


def require_told_apart(schedule: Schedule, terms: Terms, file: str = "") -> None:
    """Raise BadInput of the run in `file`, UsageError before there is one, where the fit positions do not determine the
    terms."""
    found = confused(schedule, terms) if terms else None
    if found is not None:
        said = f"--model {','.join(terms)}: {found}"
        raise BadInput(said, file) if file else UsageError(said)


def estimate_runs(schedule: core.CoreSchedule, means: Floats, terms: Terms, table: OptimalTable | None) -> Floats:
    """K row by row, U0 and the sizes (runs, 12 + 3 x terms) of means (runs, positions, 3), all measured: by a `table`
    made for these terms, or by least squares. Raises CoreRefusal."""
    if table is None:
        return least_squares(schedule, means, terms)
    return optimal(schedule.data, table, columns(schedule, terms), means)


def least_squares(schedule: core.CoreSchedule, means: Floats, terms: Terms) -> Floats:
    """As estimate_runs."""
    force, further = schedule.attitudes(), columns(schedule, terms)
    fit = fit_indices(schedule.data)

    def eliminated(outputs: Floats) -> tuple[Floats, Floats]:
        twelve = core_runs(schedule, outputs, "least_squares")
        left = outputs - force @ np.swapaxes(twelve[:, :9].reshape(-1, 3, 3), 1, 2) - twelve[:, None, 9:]
        return twelve, left[:, fit].reshape(len(outputs), -1)

    alone, shown = eliminated(further)
    twelve, rest = eliminated(means)
    sizes = np.linalg.lstsq(shown.T, rest.T, rcond=None)[0].T
    return np.concatenate([twelve - sizes @ alone, sizes], axis=1)


def optimal(schedule: Schedule, table: OptimalTable, further: Floats, means: Floats) -> Floats:
    """As estimate_runs; `further` as `columns` gives them."""
    model, fit = linearise(schedule), fit_indices(schedule)
    outputs = left = means[:, fit]
    for step in range(_CORRECTIONS + 1):
        by_gains = left.reshape(len(means), -1)
        found, stand = by_gains @ table.gains.T, by_gains @ table.nuisance_gains.T
        if step < _CORRECTIONS:
            unexplained = left - np.tensordot(found[:, 12:], further[:, fit], axes=1)
            left = outputs - _beyond(schedule, model, table, found, stand, unexplained)
    return found


def _beyond(
    schedule: Schedule, model: Linearised, table: OptimalTable, found: Floats, stand: Floats, left: Floats
) -> Floats:
    """What the exact outputs have beyond the linear ones, at the errors of the `stand` and those of the set angles that
    `left` of the outputs show: (runs, positions, 3)."""
    k, u0 = found[:, :9].reshape(-1, 3, 3), found[:, None, 9:12]
    errors = _by_position(stand, model, table)
    turn = errors["turn"]
    drift = stand[:, len(table.nuisance_gains) - table.drifts :] if table.drifts else np.zeros((1, 3))
    left = left - model.course[:, None] * drift[:, None]
    change = errors["alpha1"][..., None] * model.alpha1 + errors["yaw"][..., None] * model.alpha3
    change = change + errors["lean"][..., None] * model.theta_h + turn[..., None] * model.delta
    linear = model.force @ np.swapaxes(k, 1, 2) + change @ table.k.T
    by_angle = model.delta @ table.k.T
    variance = table.sigma_angle**2
    weighted = by_angle * table.weights**2
    gain = variance / (table.sigma_mean**2 + variance * (weighted * by_angle).sum(axis=1))
    delta = gain * ((left - u0 - linear) * weighted).sum(axis=2)
    errors["turn"] = turn + delta
    require_small(np.concatenate(list(errors.values())))
    exact = exact_force(schedule, **errors) @ np.swapaxes(k, 1, 2)
    beyond: Floats = exact - linear - delta[..., None] * by_angle
    return beyond


def _by_position(stand: Floats, model: Linearised, table: OptimalTable) -> dict[str, Floats]:
    """Every error at every fit position (runs, positions), from what the runs found of the stand."""
    ends = np.cumsum([1, 1, table.yaws, table.seats, table.seats, table.waves])
    alpha1, alpha2, yaws, lean, turned, waves, _ = np.split(stand, ends, axis=1)
    mountings = np.zeros((len(stand), model.mountings))
    found = {
        name: (mountings + (one if one.size else 0.0))[:, model.mounting]
        for name, one in (("yaw", yaws), ("lean", lean), ("turn", turned))
    }
    found["turn"] = found["turn"] + alpha2 + waves @ model.waves[:, : table.waves].T
    return {**found, "alpha1": np.broadcast_to(alpha1, found["turn"].shape)}


def linear_outputs(means: Floats, k: Floats, u0: Floats, sizes: Floats, terms: Terms) -> Floats:
    """What the outputs (positions, 3), of all positions of a run, are without the further terms: U0 + K a.

    The terms are those of the specific force that the outputs show, found step by step; every step is closer by about
    2 K2 + 3 K3. Raises NotSolvable.
    """
    if (np.abs(np.diag(k)) < _LEAST_OWN * np.linalg.norm(k, axis=1)).any() and set(terms) & set(POWERS):
        raise NotSolvable("a channel does not measure along its own axis, of which K2 and K3 are: channels exchanged?")
    size, calibration = dict(zip(terms, sizes)), core.Calibration(k, u0)
    still = means - _time(len(means)) * size.get(DRIFT, np.zeros(3))
    powers = [(power, size[term]) for term, power in POWERS.items() if term in size]
    force, linear, moved, last = np.zeros_like(still), still, np.inf, np.inf
    for _ in range(_STEPS):
        before, force = force, np.array([calibration.apply(one) for one in linear])
        last, moved = moved, float(np.abs(force - before).max())
        if not moved < last:
            break
        linear = still - sum((q * force**power for power, q in powers), np.zeros(3))
    if not moved <= _ROUNDED * np.abs(force).max():
        raise NotSolvable("K2 or K3 comes out so large that the outputs do not tell the acceleration")
    return np.asarray(linear)


def gains(schedule: core.CoreSchedule, terms: Terms) -> Floats:
    """Of least squares: (12 + 3 x terms, 3 x fit positions)."""
    count, fit = len(schedule), fit_indices(schedule.data)
    rows = least_squares(schedule, np.eye(3 * count).reshape(-1, count, 3), terms).reshape(count, 3, -1)
    return rows[fit].reshape(3 * len(fit), -1).T.copy()
