"""What a schedule cannot show of the block's own patterns, such as a third order: those that lie in the span of the
coefficients."""

from __future__ import annotations

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.reference.estimators import dense_design, estimate
from tumble.reference.patterns import BLOCK, PATTERNS, Scene
from tumble.schedule import FIT, Schedule

_SEEN = 1e-6  # of the effect, left by the coefficients: rounding leaves 1e-15, any position that shows it a tenth
_COUNTS = 0.1  # of the largest change: less is the block's misalignment and no doubt worth a mark


def unseen_patterns(schedule: Schedule, k: Floats, estimator: str) -> dict[str, Flags]:
    """By name of a pattern of the block that no fit position shows: the elements of K (3, 3) that it moves.
    `estimator`: one of estimators.LINEAR."""
    fitted = Schedule(schedule.mountings, tuple(position for position in schedule.positions if position.use == FIT))
    design, found = dense_design(fitted), {}
    for pattern in (one for one in PATTERNS if one.whose == BLOCK):
        columns = np.array(list(pattern.columns(Scene(fitted, k))[0].values()))
        effect = columns.reshape(len(columns), -1).T
        left = effect - design @ np.linalg.lstsq(design, effect, rcond=None)[0]
        hidden = np.linalg.norm(left, axis=0).max() <= _SEEN * np.linalg.norm(effect)
        if hidden and effect.any():
            moved = np.abs(estimate(fitted, columns.sum(axis=0), estimator)[0])
            found[pattern.name] = moved > _COUNTS * moved.max()
    return found
