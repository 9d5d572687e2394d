"""The numpy witness: the whole computation a second time, by other means than the firmware core.

Exact geometry of the stand, the paper's formulas written out as printed, dense least squares, singular values, complex
steps. This package neither imports nor calls the core, and the core knows nothing of it: their agreement, checked in
every solve, means something only as long as that holds.
"""

from tumble.reference.estimators import estimate, magnification
from tumble.reference.extended import confused
from tumble.reference.fit import WholeModel
from tumble.reference.geometry import Geometry
from tumble.reference.noise import MeasuredNoise, measured_noise
from tumble.reference.optimal import OptimalEstimate, optimal, optimal_covariance, optimal_uncertainties
from tumble.reference.schedules import built_in, paper_schedule
from tumble.reference.seat import is_unseen, moved_by_a_seat
from tumble.reference.stand_seen import RunSeen, pooled_noise
from tumble.reference.uncertainty import by_coefficient, covariance
from tumble.reference.unseen import unseen_patterns
from tumble.reference.verification import closure, gravity_errors, intrinsic, residual_rms

__all__ = [
    "Geometry",
    "MeasuredNoise",
    "OptimalEstimate",
    "RunSeen",
    "WholeModel",
    "built_in",
    "by_coefficient",
    "closure",
    "confused",
    "covariance",
    "estimate",
    "gravity_errors",
    "intrinsic",
    "is_unseen",
    "magnification",
    "measured_noise",
    "moved_by_a_seat",
    "optimal",
    "optimal_covariance",
    "optimal_uncertainties",
    "paper_schedule",
    "pooled_noise",
    "residual_rms",
    "unseen_patterns",
]
