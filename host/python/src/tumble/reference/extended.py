"""Further terms beside the twelve coefficients (tumble.terms): one dense problem for all of them.

Unknowns are K column by column, U0, then the sizes of the terms, by term and channel; what is returned has K row by
row. The terms are those of the ideal stand.
"""

from __future__ import annotations

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.reference.estimators import SENSITIVITY, dense_design, fit_indices, solved
from tumble.reference.patterns import BY_NAME, Scene
from tumble.reference.uncertainty import joint, sources
from tumble.schedule import Schedule
from tumble.stand import Stand
from tumble.terms import DRIFT, POWERS, Terms, names

_MILLIONTH = 1e-6
_TOUCHED = 1e-3
_NEWTON_STEPS = 30
_ROW_ORDER = np.arange(9).reshape(3, 3).T.ravel()  # K row by row, of K column by column


def columns(schedule: Schedule, terms: Terms) -> Floats:
    """Outputs by the size of every term: (3 x positions, 3 x terms)."""
    scene = Scene(schedule, np.eye(3))
    outputs = [column.ravel() / _MILLIONTH for term in terms for column in BY_NAME[term].columns(scene)[0].values()]
    return np.array(outputs).reshape(3 * len(terms), 3 * len(schedule.positions)).T


def fitted_columns(schedule: Schedule, terms: Terms) -> Floats:
    """Those of the fit positions."""
    count, fit = 3 * len(terms), fit_indices(schedule)
    return columns(schedule, terms).reshape(len(schedule.positions), 3, count)[fit].reshape(3 * len(fit), count)


def _design(schedule: Schedule, terms: Terms) -> Floats:
    return np.hstack([dense_design(schedule), fitted_columns(schedule, terms)])


def least_squares(schedule: Schedule, means: Floats, terms: Terms) -> Floats:
    """K row by row, U0 and the sizes (..., 12 + 3 x terms) of means (..., positions, 3)."""
    observed = means[..., fit_indices(schedule), :]
    x = solved(_design(schedule, terms), observed.reshape(-1, 3 * observed.shape[-2]).T).T
    found = np.concatenate([x[:, _ROW_ORDER], x[:, 9:]], axis=1)
    return found.reshape(*observed.shape[:-2], -1)


def covariance(
    schedule: Schedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    terms: Terms,
    mean_variance: Floats | None = None,
) -> Floats:
    """Of what `least_squares` finds; arguments as of reference.covariance."""
    errors = sources(schedule, k, stand, samples, mean_variance)
    return joint(lambda means: least_squares(schedule, means, terms), errors)


def magnification(schedule: Schedule, terms: Terms) -> float:
    """How much larger than the rounding of the outputs that of an unknown may be, as reference.magnification."""
    return float(np.abs(np.linalg.pinv(_design(schedule, terms))).sum(axis=1).max())


def confused(schedule: Schedule, terms: Terms) -> list[list[str]]:
    """Sets of coefficients that the fit positions cannot tell apart, each with a further one in it; the threshold is
    that of `unidentified`. The schedule identifies the twelve."""
    design = _design(schedule, terms)
    design = design[:, np.concatenate([_ROW_ORDER, np.arange(9, design.shape[1])])]
    all_names = [*(f"K_{i}{j}" for i in "xyz" for j in "xyz"), *(f"U0_{i}" for i in "xyz"), *names(terms)]
    return [found for found in (_alike(design, all_names, channel) for channel in "xyz") if found]


def _alike(design: Floats, all_names: list[str], channel: str) -> list[str]:
    """Those of one channel: no term is felt by two."""
    own = [index for index, name in enumerate(all_names) if name.partition("_")[2].startswith(channel)]
    own.sort(key=lambda index: index < 12)
    _, singular, directions = np.linalg.svd(design[:, own])
    strength = np.zeros(len(own))
    strength[: len(singular)] = singular
    null_space = directions[strength <= SENSITIVITY * np.sqrt(len(design) / 3)]
    return [all_names[index] for index, part in zip(own, null_space.T) if np.linalg.norm(part) > _TOUCHED]


def linear_outputs(means: Floats, k: Floats, u0: Floats, sizes: Floats, terms: Terms) -> Floats:
    """What the outputs (positions, 3), of all positions of a run, are without the further terms, at the specific force
    that they show: U0 + K a. By Newton's way, from the force that K and U0 alone show."""
    size = dict(zip(terms, sizes))
    time = np.linspace(-0.5, 0.5, len(means))[:, None]
    still = means - time * size.get(DRIFT, np.zeros(3))
    powers = [(power, size[term]) for term, power in POWERS.items() if term in size]
    force = np.linalg.solve(k, (still - u0).T).T
    for _ in range(_NEWTON_STEPS):
        beyond = sum((q * force**power for power, q in powers), np.zeros_like(force))
        slope = sum((power * q * force ** (power - 1) for power, q in powers), np.zeros_like(force))
        jacobian = k + slope[:, :, None] * np.eye(3)
        force = force - np.linalg.solve(jacobian, (u0 + force @ k.T + beyond - still)[:, :, None])[:, :, 0]
    linear: Floats = still - sum((q * force**power for power, q in powers), np.zeros_like(force))
    return linear
