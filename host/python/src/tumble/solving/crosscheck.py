"""The core against its numpy witness. A result that the witness does not confirm is not given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import reference
from tumble.arrays import Floats, Integers
from tumble.errors import Disagreement
from tumble.reference.extended import least_squares, linear_outputs, magnification
from tumble.reference.optimal import OptimalEstimate
from tumble.reference.stand_seen import Estimate
from tumble.schedule import Schedule
from tumble.solving.computation import Computation
from tumble.solving.stand_seen import ANGLES, Quantity, StandSeen, look, own_variance, weights_of
from tumble.stand import Stand
from tumble.terms import Terms

RELATIVE_LIMIT = 1e-12
OPTIMAL_LIMIT_U = 1e-6
UNCERTAINTY_LIMIT = 1e-9
_ROUNDED_U = 1e-13
SEEN_LIMIT_U = 1e-6
FIT_LIMIT = 1e-6
LARGEST_MISFIT = 100.0  # of a run on its stand, before optimal weights are refused
_ROUNDED_RAD = 1e-11
_SUMMED = 100.0
_LAST_BITS = 16 * np.finfo(float).eps
_MAGNIFIED_BITS = 2 * np.finfo(float).eps
_SINGLE_BIT = 2.0**-24  # the core keeps the second order of table angles, about their square, in single precision
_DERIVED = 10.0


@dataclass(frozen=True)
class Comparison:
    """Core less witness: `k` (3, 3), `u0` (3,) and `sizes` (terms, 3), in the unit of the outputs (per g); `linear`
    (positions, 3): the means without further terms, by the witness."""

    k: Floats
    u0: Floats
    sizes: Floats
    linear: Floats


def compare(
    found: Computation,
    schedule: Schedule,
    means: Floats,
    delta_g: Floats,
    optimal: OptimalEstimate | None = None,
) -> Comparison:
    """Compute all of it again and compare. Raises Disagreement, naming the quantity that differs.

    `schedule`, `means` (positions, 3) and the core's `delta_g` (positions,) hold the measured positions only.
    `optimal`: what the witness of the optimal estimator found, where that is the one in use.

    Coefficients may differ by 1e-12 of max|K|, or where that is coarser by 16 times the last bit of the largest output
    (offsets of hundreds of g), or by twice that bit as a weak schedule magnifies it; those of the optimal estimator by
    1e-6 of their standard uncertainty, or by that bit as its weights magnify it. What follows from the coefficients may
    differ by ten times that, times the condition of K where K is inverted or its rows are compared.
    """
    if optimal is not None:
        k, u0, sizes = optimal.k, optimal.u0, optimal.sizes
        allowed_k, allowed_u0, allowed_sizes = _allowed_of_optimal(optimal, means)
    else:
        k, u0, sizes = _estimate(schedule, means, found)
        allowed_k = allowed_u0 = allowed_sizes = np.array(_allowed(schedule, means, np.abs(k).max(), found.terms))
    _require("K", found.k, k, allowed_k)
    _require("U0", found.u0, u0, allowed_u0)
    for term, core, witness, allowed in zip(
        found.terms, found.sizes, sizes, np.broadcast_to(allowed_sizes, sizes.shape)
    ):
        _require(term, core, witness, allowed)

    largest_k = np.abs(k).max()
    relative = max(allowed_k.max(), allowed_u0.max(), allowed_sizes.max(initial=0.0)) / largest_k
    outputs, means = means, linear_outputs(means, k, u0, sizes, found.terms) if found.terms else means
    follows = _DERIVED * relative
    conditioned = follows * largest_k * np.linalg.norm(np.linalg.inv(k), 2)
    largest_force = np.abs(np.linalg.solve(k, (means - u0).T)).max()
    _require("delta_g", delta_g, reference.gravity_errors(means, k, u0), conditioned * max(1.0, largest_force**2))
    scale, angles, bias = reference.intrinsic(k, u0)
    _require("intrinsic scale", found.intrinsic.scale, scale, follows * largest_k)
    _require("intrinsic angle_rad", found.intrinsic.angles, angles, conditioned)
    _require("intrinsic bias_g", found.intrinsic.bias, bias, conditioned * (1.0 + np.abs(bias).max()))
    rms = reference.residual_rms(schedule, means, k, u0, 4 + len(found.terms))
    _require_same("residual_rms", found.residual_rms, rms, follows * largest_k)
    for mounting in schedule.mountings:
        closure = reference.closure(schedule, outputs, mounting.number)
        _require_same(f"closure of mounting {mounting.number}", found.closure.get(mounting.number), closure, 0.0)
    return Comparison(found.k - k, found.u0 - u0, found.sizes - sizes, means)


def _estimate(schedule: Schedule, means: Floats, found: Computation) -> tuple[Floats, Floats, Floats]:
    """K, U0 and the sizes of further terms by numpy, of an estimator that needs no stand."""
    if not found.terms:
        return *reference.estimate(schedule, means, found.estimator), found.sizes
    unknowns = least_squares(schedule, means, found.terms)
    return unknowns[:9].reshape(3, 3), unknowns[9:12], unknowns[12:].reshape(-1, 3)


def compare_seen(
    found: StandSeen,
    run: reference.RunSeen,
    samples: Integers,
    scatter: Floats,
    stand: Stand | None,
    trust_stand: bool = True,
    mean_variance: Floats | None = None,
) -> None:
    """Look at the stand again, through the witness. Raises Disagreement.

    Values may differ by 1e-6 of their standard uncertainty, or where that is less by 1e-11 rad or by what rounding
    leaves of the largest output; uncertainties likewise; alpha4 by its square. Where the outputs fit worse than the
    noise allows, as behind a coarse converter, the uncertainty is that which they show: times their misfit.
    """
    noise, u_noise = reference.pooled_noise(samples, scatter * weights_of(stand))
    rounded = max(_ROUNDED_RAD, _LAST_BITS * _SUMMED * run.largest_force)
    seen = None if noise is None or u_noise is None else Estimate(noise, u_noise)
    witness = look(run, seen, samples, stand, trust_stand, mean_variance)
    variances = [
        own_variance(one, samples, stand, mean_variance) for one in (seen, None)
    ]  # by the run and by the stand
    misfit = max([1.0, *(run.misfit(variance) for variance in variances if variance is not None)])
    _require_seen("noise", found.noise, witness.noise, 0.0)
    _require_alpha4(found.alpha4, witness.alpha4, rounded, misfit)
    for name in ANGLES:
        _require_seen(name, found.angles[name], witness.angles[name], rounded, misfit)
        _require_seen(f"augmented {name}", found.augmented[name], witness.augmented[name], rounded, misfit)
    for mounting, change in found.other_yaw_changes.items():
        _require_seen(f"yaw change {mounting}", change, witness.other_yaw_changes[mounting], rounded, misfit)


def compare_uncertainties(stated: tuple[Floats, ...], witness: tuple[Floats, ...], optimal: bool) -> None:
    """Standard uncertainties of K, U0 and further sizes by the core and by numpy. Raises Disagreement.

    They may differ by 1e-9, relative; those of the optimal estimator, whose weights both make on their own, by 1e-6.
    Below 1e-13 of the largest one, all is rounding.
    """
    rounded = _ROUNDED_U * max(part.max() for part in witness)
    for name, mine, other in zip(("u_K", "u_U0", "u of further terms"), stated, witness):
        _require(name, mine, other, np.maximum((OPTIMAL_LIMIT_U if optimal else UNCERTAINTY_LIMIT) * other, rounded))


def compare_fit(found: tuple[float, int], witness: reference.WholeModel) -> None:
    """Chi-squared of all residuals and its degrees of freedom, by the core and by numpy. Raises Disagreement.

    They may differ by 1e-6, relative and absolute. Beyond a misfit of 100 both must find one: there the problem is not
    nearly linear any more, and nobody needs the figure.
    """
    square, freedom = found
    _require("degrees of freedom of the fit", float(freedom), float(witness.freedom), 0.0)
    far = LARGEST_MISFIT**2 * max(1, freedom)
    if not min(square, witness.chi_squared) > far:
        _require("chi-squared of the fit", square, witness.chi_squared, FIT_LIMIT * max(1.0, witness.chi_squared))


def _require_seen(
    name: str, core: Quantity | None, witness: Quantity | None, rounded: float, misfit: float = 1.0
) -> None:
    if core is None or witness is None:
        _require_both(f"{name} of the stand seen", core, witness)
        return
    allowed = max(SEEN_LIMIT_U * misfit * witness.u, rounded)
    _require(f"{name} of the stand seen", core.value, witness.value, allowed)
    _require(f"u of {name} of the stand seen", core.u, witness.u, allowed)


def _require_alpha4(core: Quantity | None, witness: Quantity | None, rounded: float, misfit: float) -> None:
    """By its square and the uncertainty of that, which are what is estimated: where the set angles are hardly worse
    than the noise, the root of a small number and its uncertainty magnify what rounding leaves of the square."""
    if core is None or witness is None:
        _require_both("alpha4 of the stand seen", core, witness)
        return
    squares = [Estimate(one.value**2, 2.0 * one.value * one.u) for one in (core, witness)]
    _require_seen("alpha4 squared", squares[0], squares[1], 2.0 * witness.value * rounded, misfit)


def _allowed(schedule: Schedule, means: Floats, largest_k: float, terms: Terms) -> float:
    magnified = magnification(schedule, terms) if terms else reference.magnification(schedule)
    bits = max(_LAST_BITS, _MAGNIFIED_BITS * magnified)
    return max(RELATIVE_LIMIT * largest_k, bits * float(np.abs(means).max()))


def _allowed_of_optimal(optimal: OptimalEstimate, means: Floats) -> tuple[Floats, Floats, Floats]:
    magnified = _MAGNIFIED_BITS + _SINGLE_BIT * optimal.largest_angle**2
    bits = max(_LAST_BITS, magnified * optimal.magnification) * np.abs(means).max()
    k, u0, sizes = (np.maximum(OPTIMAL_LIMIT_U * u, bits) for u in (optimal.u_k, optimal.u_u0, optimal.u_sizes))
    return k, u0, sizes


def _require_same(name: str, core: Floats | None, witness: Floats | None, limit: float) -> None:
    _require_both(name, core, witness)
    if core is not None and witness is not None:
        _require(name, core, witness, limit)


def _require_both(name: str, core: object, witness: object) -> None:
    if (core is None) != (witness is None):
        raise Disagreement(f"the C core and numpy disagree: only one of them gives {name}; no result is given")


def _require(name: str, core: Floats | float, witness: Floats | float, limit: Floats | float) -> None:
    difference, limit = np.broadcast_arrays(np.abs(core - witness), limit)
    if not (difference <= limit).all():
        worst = int(np.argmin(limit - difference))  # the first that is not a number, if there is one
        raise Disagreement(
            f"the C core and numpy disagree: {name} differs by {difference.flat[worst]:.2g},"
            f" allowed is {limit.flat[worst]:.2g};"
            " no result is given"
        )
