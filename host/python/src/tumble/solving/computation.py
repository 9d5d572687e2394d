"""What the firmware core makes of a run (`compute`): coefficients, checks, and what follows from them; held against the
numpy model (`compare`): a result that the model does not confirm is not given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats
from tumble.errors import Disagreement
from tumble.model import coefficients
from tumble.model.coefficients import linear_outputs
from tumble.model.estimators import columns_at, magnification, unknowns
from tumble.model.optimal import OptimalEstimate, by_table
from tumble.schedule import Schedule
from tumble.solving import further, optimal_run
from tumble.terms import Terms


@dataclass(frozen=True)
class Computation:
    """Results of the core. Arrays as in tumble.core.binding.

    `closure`: by mounting number, for mountings that came back to an attitude. `residual_rms`: None with fewer than
    five fit positions. `sizes` (terms, 3) of further `terms` (tumble.terms); `linear` (positions, 3): the means without
    them, which is what the gravity check and all others look at.
    """

    estimator: str
    k: Floats
    u0: Floats
    gravity: core.GravityCheck
    intrinsic: core.Intrinsic
    closure: dict[int, Floats]
    residual_rms: Floats | None
    terms: Terms
    sizes: Floats
    linear: Floats


def compute(
    schedule: core.CoreSchedule,
    means: Floats,
    measured: Flags,
    estimator: str,
    limit_g: float,
    weighting: optimal_run.Weighting | None = None,
    terms: Terms = (),
) -> Computation:
    """Let the core estimate and verify. `weighting`: of the optimal estimator, which alone needs it.

    Raises CoreRefusal; DeadChannels where a channel does not feel gravity; NotSolvable.
    """
    sizes, linear = np.zeros((0, 3)), means
    if terms:
        found = _with_terms(schedule, means, measured, weighting, terms)
        k, u0, sizes = found[:9].reshape(3, 3), found[9:12], found[12:].reshape(-1, 3)
    elif weighting is None:
        k, u0 = core.estimate(schedule, means, measured, estimator)
    else:
        one = optimal_run.estimate(schedule, means, measured, weighting)
        k, u0 = one.k, one.u0
    _require_response(k, means[measured])
    calibration = core.Calibration(k, u0)
    if terms:
        linear = means.copy()
        linear[measured] = linear_outputs(means[measured], k, u0, sizes, terms)
    return Computation(
        estimator=estimator,
        k=k,
        u0=u0,
        gravity=core.gravity_check(schedule, linear, measured, calibration, limit_g),
        intrinsic=core.intrinsic(k, u0),
        closure=_closures(schedule, means, measured),
        residual_rms=_residual_rms(schedule, linear, measured, k, u0, len(terms)),
        terms=terms,
        sizes=sizes,
        linear=linear,
    )


def _with_terms(
    schedule: core.CoreSchedule,
    means: Floats,
    measured: Flags,
    weighting: optimal_run.Weighting | None,
    terms: Terms,
) -> Floats:
    """K row by row, U0 and the sizes (12 + 3 x terms,): by a table of gains where there are weights, else by the
    core's least squares."""
    part, lone = schedule.part(measured), means[None, measured]
    if weighting is None:
        found = further.least_squares(part, lone, terms)
    else:
        table = optimal_run.make_table(schedule, means, measured, weighting, terms)
        found = by_table(table, part.data, weighting.stand, terms, lone)
    return found.ravel()


def _residual_rms(
    schedule: core.CoreSchedule, means: Floats, measured: Flags, k: Floats, u0: Floats, terms: int
) -> Floats | None:
    """The core's, which is over the positions less four, over those less all unknowns of a channel."""
    rms = core.residual_rms(schedule, means, measured, k, u0)
    left = len(schedule.data.part(measured).fit_indices) - 4
    if rms is None or left <= terms:
        return None
    found: Floats = rms * (left / (left - terms)) ** 0.5
    return found


class DeadChannels(Exception):
    """K is singular, and one can say why: `channels`, such as ["ux"], do not respond to gravity."""

    def __init__(self, channels: list[str]):
        super().__init__(f"no response to gravity in channel {' and '.join(channels)}: K is singular")


_ROUNDING = 1e-13  # of the outputs: a response below it is what summing them leaves, whatever the core makes of it


def _require_response(k: Floats, outputs: Floats) -> None:
    response = np.linalg.norm(k, axis=1)
    dead = response <= np.maximum(core.MIN_ROW_RATIO * response.max(), _ROUNDING * np.abs(outputs).max(axis=0))
    if dead.any():
        raise DeadChannels([f"u{axis}" for axis, is_dead in zip(core.AXES, dead) if is_dead])


def _closures(schedule: core.CoreSchedule, means: Floats, measured: Flags) -> dict[int, Floats]:
    numbers = [mounting.number for mounting in schedule.data.mountings]
    differences = {number: core.closure(schedule, means, measured, number) for number in numbers}
    return {number: difference for number, difference in differences.items() if difference is not None}


RELATIVE_LIMIT = 1e-12
OPTIMAL_LIMIT_U = 1e-6
UNCERTAINTY_LIMIT = 1e-9
_ROUNDED_U = 1e-13
LARGEST_MISFIT = 100.0  # of a run on its stand, before optimal weights are refused
_LAST_BITS = 16 * np.finfo(float).eps
_MAGNIFIED_BITS = 2 * np.finfo(float).eps
_SINGLE_BIT = 2.0**-24  # the core keeps the second order of table angles, about their square, in single precision
_DERIVED = 10.0


@dataclass(frozen=True)
class Comparison:
    """Core less numpy: `k` (3, 3), `u0` (3,) and `sizes` (terms, 3), in the unit of the outputs (per g)."""

    k: Floats
    u0: Floats
    sizes: Floats


def compare(
    found: Computation,
    schedule: Schedule,
    outputs: Floats,
    means: Floats,
    delta_g: Floats,
    optimal: OptimalEstimate | None = None,
) -> Comparison:
    """Compute all of it again and compare. Raises Disagreement, naming the quantity that differs.

    `schedule`, `outputs` (positions, 3) and the core's `delta_g` (positions,) hold the measured positions only;
    `means`: the outputs without further terms.
    `optimal`: what the witness of the optimal estimator found, where that is the one in use.

    Coefficients may differ by 1e-12 of max|K|, or where that is coarser by 16 times the last bit of the largest output
    (offsets of hundreds of g), or by twice that bit as a weak schedule magnifies it; those of the optimal estimator by
    1e-6 of their standard uncertainty, or by that bit as its weights magnify it. What follows from the coefficients may
    differ by ten times that, times the condition of K where K is inverted or its rows are compared.
    """
    if optimal is not None:
        k, u0, sizes = optimal.k, optimal.u0, optimal.sizes
        allowed_k, allowed_u0, allowed_sizes = _allowed_of_optimal(optimal, outputs)
    else:
        k, u0, sizes = _estimate(schedule, outputs, found)
        allowed_k = allowed_u0 = allowed_sizes = np.array(_allowed(schedule, outputs, np.abs(k).max(), found.terms))
    _require("K", found.k, k, allowed_k)
    _require("U0", found.u0, u0, allowed_u0)
    for term, computed, witness, allowed in zip(
        found.terms, found.sizes, sizes, np.broadcast_to(allowed_sizes, sizes.shape)
    ):
        _require(term, computed, witness, allowed)

    largest_k = np.abs(k).max()
    relative = max(allowed_k.max(), allowed_u0.max(), allowed_sizes.max(initial=0.0)) / largest_k
    follows = _DERIVED * relative
    conditioned = follows * largest_k * np.linalg.norm(np.linalg.inv(k), 2)
    force: Floats = np.linalg.solve(k, (means - u0).T).T.astype(float)
    largest_force = np.abs(force).max()
    if found.terms:  # found step by step, they add up in one
        added = np.tensordot(found.sizes.ravel(), columns_at(force, found.terms), axes=1)
        _require("U with further terms", means + added, outputs, conditioned * largest_k)
    _require("delta_g", delta_g, coefficients.gravity_errors(means, k, u0), conditioned * max(1.0, largest_force**2))
    scale, angles, bias = coefficients.intrinsic(k, u0)
    _require("intrinsic scale", found.intrinsic.scale, scale, follows * largest_k)
    _require("intrinsic angle_rad", found.intrinsic.angles, angles, conditioned)
    _require("intrinsic bias_g", found.intrinsic.bias, bias, conditioned * (1.0 + np.abs(bias).max()))
    rms = coefficients.residual_rms(schedule, means, k, u0, 4 + len(found.terms))
    _require_same("residual_rms", found.residual_rms, rms, follows * largest_k)
    for mounting in schedule.mountings:
        closure = coefficients.closure(schedule, outputs, mounting.number)
        _require_same(f"closure of mounting {mounting.number}", found.closure.get(mounting.number), closure, 0.0)
    return Comparison(found.k - k, found.u0 - u0, found.sizes - sizes)


def _estimate(schedule: Schedule, means: Floats, found: Computation) -> tuple[Floats, Floats, Floats]:
    """K, U0 and the sizes of further terms by numpy, of an estimator that needs no stand."""
    numbers = unknowns(schedule, means, found.estimator, found.terms)
    return numbers[:9].reshape(3, 3), numbers[9:12], numbers[12:].reshape(-1, 3)


def compare_uncertainties(stated: Floats, by_numpy: Floats, optimal: bool) -> None:
    """Standard uncertainties (n,) of K row by row, U0 and further sizes by the core and by numpy. Raises Disagreement.

    They may differ by 1e-9, relative; those of the optimal estimator, whose weights both make on their own, by 1e-6.
    Below 1e-13 of the largest one, all is rounding.
    """
    limits = np.maximum((OPTIMAL_LIMIT_U if optimal else UNCERTAINTY_LIMIT) * by_numpy, _ROUNDED_U * by_numpy.max())
    for name, part in (("u_K", slice(9)), ("u_U0", slice(9, 12)), ("u of further terms", slice(12, None))):
        _require(name, stated[part], by_numpy[part], limits[part])


def _allowed(schedule: Schedule, means: Floats, largest_k: float, terms: Terms) -> float:
    bits = max(_LAST_BITS, _MAGNIFIED_BITS * magnification(schedule, terms))
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
