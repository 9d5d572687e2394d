"""The numpy model of a calibration: everything after the means, by other means than the firmware core.

This package neither imports nor calls the core, and the core knows nothing of it: their agreement on K, U0 and their
uncertainties, checked in every solve, means something only as long as that holds.

    geometry      the specific force on a stand with errors; the built-in schedules
    errors        the table of a stand's errors, and what they do to the outputs
    estimators    closed forms and least squares, their gains; what a schedule cannot identify
    further       terms of the model beside the twelve coefficients
    inclined      the closed form of a block that is bolted on once, and inclined with its stand
    norm          any still poses, by |a| alone: nine coefficients
    optimal       generalised least squares: from the data, and as a table of gains
    prior         the last calibration of a block beside its run, and whether the two agree
    propagation   how errors reach an estimate: gains, covariance, what each source brings; what is left out
    coefficients  what follows from them: specific force, |a| and its uncertainty, intrinsic parameters, gravity check
    fit           chi-squared of a run on its stand; of a misfit, what explains it (patterns)
    patterns      what a run that does not fit may show instead: a table
    stand_seen    the stand as a run shows it
    reliability   what a run, or a kind of run, cannot show
    set_angles    what the marks of a table are off by: learnt from several runs, taken out of another
    thermal       K and U0 as polynomials of the temperature, of runs at several
    thermal_reliability    what these runs cannot show, all together
"""

from tumble.model.coefficients import closure, gravity_errors, intrinsic, residual_rms
from tumble.model.errors import by_coefficient
from tumble.model.estimators import confused, estimate, magnification
from tumble.model.fit import WholeModel
from tumble.model.geometry import Geometry, built_in
from tumble.model.optimal import OptimalEstimate, optimal_covariance, optimal_estimate
from tumble.model.propagation import Propagation
from tumble.model.reliability import moved_by_a_seat, seat_is_unseen, unseen_patterns
from tumble.model.stand_seen import RunSeen, pooled_noise

__all__ = [
    "Geometry",
    "OptimalEstimate",
    "Propagation",
    "RunSeen",
    "WholeModel",
    "built_in",
    "by_coefficient",
    "closure",
    "confused",
    "estimate",
    "gravity_errors",
    "intrinsic",
    "magnification",
    "moved_by_a_seat",
    "optimal_covariance",
    "optimal_estimate",
    "pooled_noise",
    "residual_rms",
    "seat_is_unseen",
    "unseen_patterns",
]
