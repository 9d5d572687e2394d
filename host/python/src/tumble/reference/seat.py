"""What a run cannot show of how square the block sits: a tilt of the block against the axis, common to all mountings.

Its effect on the outputs, and those of every other angle of the stand, come from the exact geometry by complex steps.
"""

from __future__ import annotations

import numpy as np

from tumble.arrays import Floats
from tumble.reference.estimators import dense_design, estimate
from tumble.reference.extended import fitted_columns
from tumble.reference.geometry import Geometry
from tumble.schedule import FIT, Schedule
from tumble.terms import Terms

_SEEN = 1e-6  # of the effect, left by coefficients and other angles: rounding leaves 1e-14, a third mounting a half


def is_unseen(schedule: Schedule, k: Floats, terms: Terms = ()) -> bool:
    """Whether the fit positions show nothing of a common tilt of the block against the axis. `terms`: further unknowns
    of the model."""
    fitted = _fitted(schedule)
    geometry, mountings = Geometry(fitted), np.eye(len(fitted.mountings))
    angles = [geometry.derivative(k, alpha1=1.0), geometry.derivative(k, alpha2=1.0)]
    angles += [geometry.derivative(k, **{name: one}) for name in ("alpha3", "seat_n") for one in mountings]
    unknown = [dense_design(fitted), fitted_columns(schedule, terms)]
    explaining = np.column_stack([*unknown, *(angle.ravel() for angle in angles)])
    tilt = geometry.derivative(k, seat_h=1.0)
    left = tilt.ravel() - explaining @ np.linalg.lstsq(explaining, tilt.ravel(), rcond=None)[0]
    return bool(np.linalg.norm(left) <= _SEEN * np.linalg.norm(tilt))


def moved_by_a_seat(schedule: Schedule, k: Floats, estimator: str) -> dict[str, Floats]:
    """Standard deviations (12,) of K row by row and U0 that a seat of one radian would bring, drawn in every mounting,
    and a platform of one radian, to first order. `estimator`: one of estimators.LINEAR."""
    fitted = _fitted(schedule)
    geometry, mountings = Geometry(fitted), np.eye(len(fitted.mountings))
    seats = [geometry.derivative(k, **{name: mountings}) for name in ("seat_h", "seat_n")]
    draws = {"seat": np.concatenate(seats), "platform": geometry.derivative(k, seat_h=np.ones((1, 1)))}
    found = {}
    for name, outputs in draws.items():
        moved_k, moved_u0 = estimate(fitted, outputs, estimator)
        found[name] = np.linalg.norm(np.concatenate([moved_k.reshape(-1, 9), moved_u0], axis=1), axis=0)
    return found


def _fitted(schedule: Schedule) -> Schedule:
    return Schedule(schedule.mountings, tuple(position for position in schedule.positions if position.use == FIT))
