"""What the firmware core makes of a run (`compute`): coefficients, checks, and what follows from them; held against the
numpy model (`compare`): a result that the model does not confirm is not given.

Further terms of the model (tumble.terms), which the core does not know, are found by its least squares
(`least_squares`), and by `optimal` by a table that the core does not evaluate; many runs at once by any estimator
(`estimator_for`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats
from tumble.core import GainRecord, estimate_runs as core_runs, inclined_runs, optimal_runs
from tumble.errors import BadInput, Disagreement, UsageError, listed
from tumble.estimators import INCLINED, NORM, OPTIMAL
from tumble.model import coefficients, estimators
from tumble.model.coefficients import NotSolvable, linear_outputs
from tumble.model.errors import by_gains
from tumble.model.estimators import columns_at, magnification, unknowns
from tumble.model.geometry import built_in, ideal_force
from tumble.model.inclined import EQUAL, Inclinations, as_set, gains, gains_of_inclinations
from tumble.model.optimal import OptimalEstimate, by_table
from tumble.model.propagation import ManyRuns, Propagation
from tumble.schedule import BUILT_IN, Schedule
from tumble.solving import optimal_run
from tumble.solving.optimal_run import record_of, to_bytes
from tumble.terms import Terms, model_of


@dataclass(frozen=True)
class Computation:
    """Results of the core. Arrays as in tumble.core.

    `closure`: by mounting number, for mountings that came back to an attitude. `residual_rms`: None with fewer than
    five fit positions. `sizes` (terms, 3) of further `terms` (tumble.terms); `linear` (positions, 3): the means without
    them, which is what the gravity check and all others look at. `inclinations`: as the closed form sees them, of a
    block that is bolted on once.
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
    inclinations: Inclinations | None = None


def estimate_inclinations(
    schedule: core.CoreSchedule, means: Floats, measured: Flags, weights: Floats = EQUAL
) -> tuple[Floats, Inclinations]:
    """Coefficients (12,) and inclinations by the core's closed form; `weights` (3,) of the channels, best in proportion
    to 1 / noise. Raises CoreRefusal."""
    part = schedule.part(measured)
    found, beta, tau = inclined_runs(part, means[None, measured], weights)
    numbers = tuple(one.number for one in part.data.fitted_mountings)
    return found[0], Inclinations(numbers, beta[0], tau[0])


def compute(
    schedule: core.CoreSchedule,
    means: Floats,
    measured: Flags,
    estimator: str,
    limit_g: float,
    weighting: optimal_run.Weighting | None = None,
    terms: Terms = (),
    inclined: Floats | None = None,
) -> Computation:
    """Let the core estimate and verify. `weighting`: of the optimal estimator, which alone needs it; `inclined` (12,):
    what the closed form has found already, with the inclinations that the schedule now has.

    Raises CoreRefusal; NotSolvable, also where a channel does not feel gravity.
    """
    lone = means[None, measured]
    if weighting is not None:
        weighed = schedule if weighting.schedule is None else weighting.schedule
        table = optimal_run.make_table(weighed, means, measured, weighting, terms)
        if terms:  # of which the core knows no gains
            found = by_table(table, weighed.data.part(measured), weighting.stand, terms, lone)[0]
        else:
            found = optimal_run.apply_table(table, weighed.part(measured), lone[0])
    elif terms:
        found = least_squares(schedule.part(measured), lone, terms)[0]
    elif inclined is not None:
        found = inclined
    else:
        found = np.concatenate([one.ravel() for one in core.estimate(schedule, means, measured, estimator)])
    return computation_of(schedule, means, measured, estimator, limit_g, found, terms)


def computation_of(
    schedule: core.CoreSchedule,
    means: Floats,
    measured: Flags,
    estimator: str,
    limit_g: float,
    found: Floats,
    terms: Terms = (),
) -> Computation:
    """What follows from coefficients and sizes `found` (12 + 3 x terms,), as `compute` has it."""
    linear = means
    k, u0, sizes = found[:9].reshape(3, 3), found[9:12], found[12:].reshape(-1, 3)
    response, rounding = np.linalg.norm(k, axis=1), _ROUNDING * np.abs(means[measured]).max(axis=0)
    dead = response <= np.maximum(core.MIN_ROW_RATIO * response.max(), rounding)
    if dead.any():
        channels = [f"u{axis}" for axis, is_dead in zip(core.AXES, dead) if is_dead]
        raise NotSolvable(f"no response to gravity in channel {' and '.join(channels)}: K is singular")
    calibration = core.Calibration(k, u0)
    if terms:
        linear = means.copy()
        linear[measured] = linear_outputs(means[measured], k, u0, sizes, terms)
    rms, left = core.residual_rms(schedule, linear, measured, k, u0), len(schedule.data.part(measured).fit_indices) - 4
    if terms and rms is not None:  # that of the core is over the positions less four, not less all unknowns
        rms = None if left <= len(terms) else rms * (left / (left - len(terms))) ** 0.5
    numbers = [mounting.number for mounting in schedule.data.mountings]
    differences = {number: core.closure(schedule, means, measured, number) for number in numbers}
    return Computation(
        estimator=estimator,
        k=k,
        u0=u0,
        gravity=core.gravity_check(schedule, linear, measured, calibration, limit_g),
        intrinsic=core.intrinsic(k, u0),
        closure={number: difference for number, difference in differences.items() if difference is not None},
        residual_rms=rms,
        terms=terms,
        sizes=sizes,
        linear=linear,
    )


_ROUNDING = 1e-13  # of the outputs: a response below it is what summing them leaves, whatever the core makes of it
RELATIVE_LIMIT = 1e-12
OPTIMAL_LIMIT_U = 1e-6
UNCERTAINTY_LIMIT = 1e-9
_ROUNDED_U = 1e-13
LARGEST_MISFIT = 100.0  # of a run on its stand, before optimal weights are refused
_LAST_BITS = 16 * np.finfo(float).eps
_MAGNIFIED_BITS = 2 * np.finfo(float).eps
_SOLVED_BITS = 64 * _MAGNIFIED_BITS  # numpy's normal equations of a parabola square its condition
_SINGLE_BIT = 2.0**-24  # the core keeps the second order of table angles, about their square, in single precision
_DERIVED = 10.0
_SAME_ANGLE = 1e-12


@dataclass(frozen=True)
class Comparison:
    """Core less numpy: `k` (3, 3), `u0` (3,) and `sizes` (terms, 3), in the unit of the outputs (per g)."""

    k: Floats
    u0: Floats
    sizes: Floats


def compare(
    found: Computation,
    schedule: Schedule,
    means: Floats,
    linear: Floats,
    delta_g: Floats,
    optimal: OptimalEstimate | None = None,
    weights: Floats = EQUAL,
) -> Comparison:
    """Compute all of it again and compare. Raises Disagreement, naming the quantity that differs.

    `schedule`, `means` (positions, 3) and the core's `delta_g` (positions,) hold the measured positions only; `linear`:
    the means without further terms.
    `optimal`: what the witness of the optimal estimator found, where that is the one in use. `weights` (3,) of the
    channels, as `inclined` has them.

    Coefficients may differ by 1e-12 of max|K|, or where that is coarser by 16 times the last bit of the largest output
    (offsets of hundreds of g), or by twice that bit as a weak schedule magnifies it, and 64 times as inclinations that
    hardly differ do; those of the optimal estimator by 1e-6 of their standard uncertainty, or by that bit as its
    weights magnify it. What follows from the coefficients may differ by ten times that, times the condition of K where
    K is inverted or its rows are compared.
    """
    largest = np.abs(means).max()
    if optimal is not None:
        k, u0, sizes = optimal.k, optimal.u0, optimal.sizes
        magnified = _MAGNIFIED_BITS + _SINGLE_BIT * optimal.largest_angle**2
        bits = max(_LAST_BITS, magnified * optimal.magnification) * largest
        u_of_all = optimal.u_k, optimal.u_u0, optimal.u_sizes
        allowed_k, allowed_u0, allowed_sizes = (np.maximum(OPTIMAL_LIMIT_U * u, bits) for u in u_of_all)
    else:
        numbers = unknowns(schedule, means, found.estimator, found.terms, weights)
        k, u0, sizes = numbers[:9].reshape(3, 3), numbers[9:12], numbers[12:].reshape(-1, 3)
        bits = max(_LAST_BITS, _MAGNIFIED_BITS * magnification(schedule, found.terms)) * float(largest)
        if found.estimator == INCLINED:
            bits = max(bits, float(_magnified(gains(schedule, k, weights), means).max()))
        allowed_k = allowed_u0 = np.array(max(RELATIVE_LIMIT * np.abs(k).max(), bits))
        allowed_sizes = np.broadcast_to(allowed_k, sizes.shape)
    _require("K", found.k, k, allowed_k)
    _require("U0", found.u0, u0, allowed_u0)
    for term, computed, witness, allowed in zip(found.terms, found.sizes, sizes, allowed_sizes):
        _require(term, computed, witness, allowed)

    largest_k = np.abs(k).max()
    relative = max(allowed_k.max(), allowed_u0.max(), allowed_sizes.max(initial=0.0)) / largest_k
    follows = _DERIVED * relative
    conditioned = follows * largest_k * np.linalg.norm(np.linalg.inv(k), 2)
    force: Floats = np.linalg.solve(k, (linear - u0).T).T.astype(float)
    largest_force = np.abs(force).max()
    if found.terms:  # found step by step, they add up in one
        added = np.tensordot(found.sizes.ravel(), columns_at(force, found.terms), axes=1)
        _require("U with further terms", linear + added, means, conditioned * largest_k)
    _require("delta_g", delta_g, coefficients.gravity_errors(linear, k, u0), conditioned * max(1.0, largest_force**2))
    scale, angles, bias = coefficients.intrinsic(k, u0)
    _require("intrinsic scale", found.intrinsic.scale, scale, follows * largest_k)
    _require("intrinsic angle_rad", found.intrinsic.angles, angles, conditioned)
    _require("intrinsic bias_g", found.intrinsic.bias, bias, conditioned * (1.0 + np.abs(bias).max()))
    rms = coefficients.residual_rms(schedule, linear, k, u0, 4 + len(found.terms))
    _require("residual_rms", found.residual_rms, rms, follows * largest_k)
    for mounting in schedule.mountings:
        closure = coefficients.closure(schedule, means, mounting.number)
        _require(f"closure of mounting {mounting.number}", found.closure.get(mounting.number), closure, 0.0)
    return Comparison(found.k - k, found.u0 - u0, found.sizes - sizes)


def compare_uncertainties(stated: Floats, by_numpy: Floats, optimal: bool) -> None:
    """Standard uncertainties (n,) of K row by row, U0 and further sizes by the core and by numpy. Raises Disagreement.

    They may differ by 1e-9, relative; those of the optimal estimator, whose weights both make on their own, by 1e-6.
    Below 1e-13 of the largest one, all is rounding.
    """
    limits = np.maximum((OPTIMAL_LIMIT_U if optimal else UNCERTAINTY_LIMIT) * by_numpy, _ROUNDED_U * by_numpy.max())
    for name, part in (("u_K", slice(9)), ("u_U0", slice(9, 12)), ("u of further terms", slice(12, None))):
        _require(name, stated[part], by_numpy[part], limits[part])


def magnified_angles(schedule: Schedule, means: Floats, k: Floats, weights: Floats = EQUAL) -> Floats:
    """By how much the angles of inclinations, every beta, then every tau, may differ for the last bits of the outputs:
    arguments as of `compare`, the `schedule` at the inclinations that the run shows."""
    return _magnified(gains_of_inclinations(schedule, k, weights), means)


def _magnified(gains: Floats, means: Floats) -> Floats:
    bits: Floats = _SOLVED_BITS * np.abs(gains).sum(axis=1) * np.abs(means).max()
    return bits


def compare_inclinations(found: Inclinations, witness: Inclinations, magnified: Floats) -> None:
    """Raise Disagreement where core and numpy see others: angles in rad, 1e-12 of one allowed, or what `magnified`
    says."""
    of_beta, of_tau = np.maximum(_SAME_ANGLE, magnified).reshape(2, -1)
    _require("an inclination", found.beta, witness.beta, of_beta)
    _require("the zero of the table angle at an inclination", found.tau, witness.tau, of_tau)


def _require(name: str, core: Floats | float | None, witness: Floats | float | None, limit: Floats | float) -> None:
    if core is None or witness is None:
        if core is not None or witness is not None:
            raise Disagreement(f"the C core and numpy disagree: only one of them gives {name}; no result is given")
        return
    difference, limit = np.broadcast_arrays(np.abs(core - witness), limit)
    if not (difference <= limit).all():
        worst = int(np.argmin(limit - difference))  # the first that is not a number, if there is one
        raise Disagreement(
            f"the C core and numpy disagree: {name} differs by {difference.flat[worst]:.2g},"
            f" allowed is {limit.flat[worst]:.2g};"
            " no result is given"
        )


def confused(schedule: Schedule, terms: Terms) -> str | None:
    """What the fit positions cannot tell apart, in words; None where they can."""
    found = estimators.confused(schedule, terms)
    if not found:
        return None
    unseen, alike = [them[0] for them in found if len(them) == 1], [listed(them) for them in found if len(them) > 1]
    said = [f"do not show {listed(unseen, 'or')}"] if unseen else []
    said += [f"cannot tell apart {', nor '.join(alike)}"] if alike else []
    others = [name for name in BUILT_IN if not (own := built_in(name)).is_inclined and not own.is_laid_by_hand]
    able = [name for name in others if not estimators.confused(built_in(name), terms)]
    return f"these positions {' and '.join(said)}" + (f"; the schedule {listed(able, 'or')} does" if able else "")


def require_told_apart(schedule: Schedule, terms: Terms, file: str = "") -> None:
    """Raise BadInput of the run in `file`, UsageError before there is one, where the fit positions do not determine the
    terms."""
    found = confused(schedule, terms) if terms else None
    if found is not None:
        said = f"--model {','.join(model_of(terms))}: {found}"
        raise BadInput(said, file) if file else UsageError(said)


def least_squares(schedule: core.CoreSchedule, means: Floats, terms: Terms) -> Floats:
    """K row by row, U0 and the sizes of further terms (runs, 12 + 3 x terms) of means (runs, positions, 3), all
    measured, by the core's least squares, which does not know the terms. Raises CoreRefusal.

    Sizes are found by elimination: the core solves the outputs, and the column of every term, for the twelve; what it
    leaves of both has only the terms in common. The outputs without them then have the twelve of all unknowns together,
    whose normal equations are the same.
    """
    force, fit = ideal_force(schedule.data), schedule.data.fit_indices
    columns = columns_at(force, terms)

    def left(outputs: Floats) -> Floats:
        twelve = core_runs(schedule, outputs, "least_squares")
        rest = outputs - force @ np.swapaxes(twelve[:, :9].reshape(-1, 3, 3), 1, 2) - twelve[:, None, 9:]
        return rest[:, fit].reshape(len(outputs), -1)

    sizes = np.linalg.lstsq(left(columns).T, left(means).T, rcond=None)[0].T.astype(float)
    twelve = core_runs(schedule, means - np.tensordot(sizes, columns, axes=1), "least_squares")
    return np.concatenate([twelve, sizes], axis=1)


def estimator_for(given: Propagation) -> ManyRuns:
    """From means (runs, positions, 3), all measured, to K row by row, U0 and the sizes of further terms (runs, 12 + 3 x
    terms). `optimal` has weights made at the `k` given: its second order makes up for those of each run's own K. What
    is returned raises CoreRefusal."""
    schedule, terms = core.CoreSchedule(given.schedule), given.terms
    if given.estimator == INCLINED:
        return lambda means: inclined_runs(schedule, means, given.weights)[0]
    if given.estimator == NORM:
        weights = given.weights * np.where(np.diag(given.k) < 0.0, -1.0, 1.0)
        return lambda means: estimators.unknowns(given.schedule, means, NORM, weights=weights)
    if given.estimator != OPTIMAL:
        if terms:
            return lambda means: least_squares(schedule, means, terms)
        return lambda means: core_runs(schedule, means, given.estimator)
    if terms:
        return lambda means: by_table(given.table, as_set(given.schedule), given.stand, terms, means)
    record = GainRecord(schedule, to_bytes(record_of(given.table, given.schedule)))
    return lambda means: optimal_runs(record, means)[0]


def estimator_or_linear(given: Propagation) -> ManyRuns:
    """The same, of the twelve alone; its linear part, whose bias says enough, where a run has no result: beyond 0.1 rad
    by `optimal`, and by `inclined` where errors of the axis are as large as the inclinations."""
    estimate = estimator_for(given)

    def of(means: Floats) -> Floats:
        try:
            return estimate(means)[:, :12]
        except core.CoreRefusal:
            if given.estimator not in (INCLINED, OPTIMAL):
                raise
            return by_gains(given.schedule, given.gains[:12])(means)

    return of
