"""Gravity check, closure, residuals and intrinsic parameters, by other means than the core's."""

from __future__ import annotations

import numpy as np

from tumble.arrays import Floats
from tumble.model.geometry import ideal_force
from tumble.schedule import Schedule

_SAME_ATTITUDE = 1e-12


def gravity_errors(means: Floats, k: Floats, u0: Floats) -> Floats:
    """Formula (8) in g at every position: (|a|^2 - 1)/2 with K a = U - U0 solved. means (positions, 3)."""
    force = np.linalg.solve(k, (means - u0).T)
    errors: Floats = ((force**2).sum(axis=0) - 1.0) / 2.0
    return errors


def intrinsic(k: Floats, u0: Floats) -> tuple[Floats, Floats, Floats]:
    """Lengths of the rows of K (3,), angles between the rows xy, xz, yz in radians (3,), biases over lengths (3,)."""
    scale = np.linalg.norm(k, axis=1)
    pairs = [(0, 1), (0, 2), (1, 2)]
    angles = [np.arctan2(np.linalg.norm(np.cross(k[i], k[j])), k[i] @ k[j]) for i, j in pairs]
    return scale, np.array(angles), u0 / scale


def closure(schedule: Schedule, means: Floats, mounting: int) -> Floats | None:
    """Output at the last position of a mounting whose attitude came before, less the first such one's; None if none."""
    own = [index for index, position in enumerate(schedule.positions) if position.mounting == mounting]
    force = ideal_force(schedule)
    pairs = [
        (late, early)
        for late in own
        for early in own
        if early < late and np.abs(force[late] - force[early]).max() < _SAME_ATTITUDE
    ]
    if not pairs:
        return None
    late = max(late for late, _ in pairs)
    early = min(early for other, early in pairs if other == late)
    difference: Floats = means[late] - means[early]
    return difference


def residual_rms(schedule: Schedule, means: Floats, k: Floats, u0: Floats, unknowns: int = 4) -> Floats | None:
    """Root mean square of U - U0 - K a over the fit positions, less the `unknowns` of a channel: (3,); None where there
    are no more positions than that."""
    fit = schedule.fit_indices
    if len(fit) <= unknowns:
        return None
    residuals = (means - ideal_force(schedule) @ k.T - u0)[fit]
    rms: Floats = np.sqrt((residuals**2).sum(axis=0) / (len(fit) - unknowns))
    return rms
