"""What a run cannot show of how square the block sits: a tilt of the block against the axis, common to all mountings.

Its effect on the outputs, and those of every other angle of the stand, come from the exact geometry by complex steps.
"""

from __future__ import annotations

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.reference.estimators import dense_design, estimate
from tumble.reference.geometry import Geometry
from tumble.schedule import FIT, Schedule

_SEEN = 1e-6  # of the effect, left by coefficients and other angles: rounding leaves 1e-14, a third mounting a half
_COUNTS = 0.1  # of the largest change: less is the block's misalignment and no doubt worth a mark


def unseen_tilt(schedule: Schedule, k: Floats, estimator: str) -> Flags | None:
    """Which elements of K (3, 3) a common tilt of the block against the axis moves; None where the fit positions show
    it. `estimator`: one of estimators.LINEAR."""
    fitted = Schedule(schedule.mountings, tuple(position for position in schedule.positions if position.use == FIT))
    geometry, mountings = Geometry(fitted), np.eye(len(fitted.mountings))
    angles = [geometry.derivative(k, alpha1=1.0), geometry.derivative(k, alpha2=1.0)]
    angles += [geometry.derivative(k, **{name: one}) for name in ("alpha3", "seat_n") for one in mountings]
    explaining = np.column_stack([dense_design(fitted), *(angle.ravel() for angle in angles)])
    tilt = geometry.derivative(k, seat_h=1.0)
    left = tilt.ravel() - explaining @ np.linalg.lstsq(explaining, tilt.ravel(), rcond=None)[0]
    if np.linalg.norm(left) > _SEEN * np.linalg.norm(tilt):
        return None
    moved = np.abs(estimate(fitted, tilt, estimator)[0])
    marked: Flags = moved > _COUNTS * moved.max()
    return marked
