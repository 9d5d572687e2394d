"""What a run cannot show: a tilt of the block against the axis that is common to all mountings, and those of the
block's own patterns, such as a third order, that lie in the span of the coefficients."""

from __future__ import annotations

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.model.errors import brought, by_gains, of_stand, unit_effect
from tumble.model.estimators import design, linear_gains
from tumble.model.patterns import BLOCK, PATTERNS, Scene
from tumble.schedule import Schedule
from tumble.stand import Stand
from tumble.terms import Terms

_SEEN = 1e-6  # of the effect, left by what explains it: rounding leaves 1e-14, any position that shows it a tenth
_COUNTS = 0.1  # of the largest change: less is the block's misalignment and no doubt worth a mark
_UNIT_SEAT = Stand(0.0, 0.0, 0.0, 0.0, 0.0, 1, "sigma1", seat=1.0, platform=1.0)


def seat_is_unseen(schedule: Schedule, k: Floats, terms: Terms = ()) -> bool:
    """Whether the fit positions show nothing of a common tilt of the block against the axis, beside coefficients, all
    other angles that positions share, and further `terms` of the model."""
    fitted, mountings = schedule.fitted, len(schedule.mountings)
    angles = [unit_effect(fitted, name).derivative(k) for name in ("alpha1", "alpha2", "alpha3")]
    angles.append(unit_effect(fitted, "seat").derivative(k)[mountings:])
    others = np.concatenate(angles)
    explaining = np.column_stack([design(fitted, terms), others.reshape(len(others), -1).T])
    return _is_hidden(unit_effect(fitted, "platform").derivative(k).reshape(1, -1).T, explaining)


def moved_by_a_seat(schedule: Schedule, k: Floats, estimator: str) -> dict[str, Floats]:
    """Standard deviations (12,) of K row by row and U0 that a seat of one radian would bring, drawn in every mounting,
    and a platform of one radian, to first order. `estimator`: one of estimators.LINEAR."""
    fitted = schedule.fitted
    errors = of_stand(fitted, k, _UNIT_SEAT, ("seat", "platform"))
    moved = brought(by_gains(fitted, linear_gains(fitted, estimator)), errors)
    return {name: np.linalg.norm(draws, axis=0) for name, draws in moved.items()}


def unseen_patterns(schedule: Schedule, k: Floats, estimator: str) -> dict[str, Flags]:
    """By name of a pattern of the block that no fit position shows: the elements of K (3, 3) that it moves, where it
    moves any. `estimator`: one of estimators.LINEAR."""
    fitted, found = schedule.fitted, {}
    for pattern in (one for one in PATTERNS if one.whose == BLOCK):
        columns = np.array(list(pattern.columns(Scene(fitted, k))[0].values()))
        if columns.any() and _is_hidden(columns.reshape(len(columns), -1).T, design(fitted)):
            moved = np.abs(linear_gains(fitted, estimator)[:9] @ columns.sum(axis=0).ravel()).reshape(3, 3)
            if moved.max() > _SEEN * np.abs(columns).max():  # else it is a bias
                found[pattern.name] = moved > _COUNTS * moved.max()
    return found


def _is_hidden(effect: Floats, explaining: Floats) -> bool:
    """Whether the columns of an effect lie in the span of others."""
    left = effect - explaining @ np.linalg.lstsq(explaining, effect, rcond=None)[0]
    return bool(np.linalg.norm(left, axis=0).max() <= _SEEN * np.linalg.norm(effect))
