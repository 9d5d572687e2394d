"""A solution as a document of schema tumble.result/1, part by part (`document_of`), and what others need of a document
again: its stand, its schedule, the step of its converter. documents.result says what every key means; where the names
of the code are other than the keys, this module is where they meet.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from datetime import datetime, timezone
from typing import Any

import numpy as np
from msgspec import UNSET, UnsetType

from tumble._version import __version__
from tumble.arrays import Floats
from tumble.core import CoreRefusal, CoreSchedule, built_in
from tumble.distributions import student_quantile
from tumble.documents import result as doc
from tumble.documents.further import Extended
from tumble.documents.prior import Change, OfParameters, Prior
from tumble.documents.result import Result
from tumble.errors import BadInput, UsageError, quoted
from tumble.estimators import COEFFICIENTS
from tumble.model import reliability
from tumble.model.fit import Fit
from tumble.model.inclined import Inclinations, as_seen
from tumble.model.propagation import SecondOrder
from tumble.model.stand_seen import ANGLES, ChannelNoise, Estimate, StandSeen
from tumble.schedule import BUILT_IN, Mounting, Position, Schedule
from tumble.solving.coefficients import si_of
from tumble.solving.decision import assumed, decide, would_show
from tumble.solving.many_runs import COVERAGE, LEVEL, MonteCarlo
from tumble.solving.noise import CHANNELS, of_means
from tumble.solving.prior import PriorOutcome, unit_of
from tumble.solving.solution import Solution
from tumble.solving.uncertainty import PROBABILITY, Coverage, ExtendedTerms, effective, factors_of
from tumble.stand import SOURCES, PerChannel, SetAngles, Stand, by_channel, per_channel
from tumble.terms import DRIFT, KEYS, model_of, names
from tumble.units import per_g, volts_per

_LARGEST = 1e9  # of an error of a stand, as stand files have it


def stand_of(result: Result, name: str) -> Stand | None:
    """The declared stand of a result, which messages call `name`; None where it tells of none. Raises BadInput."""
    told = result.stand
    if told is None:
        return None
    said = {source: getattr(told, source.key) for source in SOURCES.values()}
    errors = {source.attribute: size for source, size in said.items() if size is not UNSET}
    if any((by_channel(size) >= _LARGEST).any() for size in errors.values()):
        raise BadInput("its stand is not as tumble solve writes it", name)
    sizes: dict[str, Any] = {name: per_channel(by_channel(one)) for name, one in errors.items()}
    kinds: dict[str, Any] = {"limits": told.limits, "remounting": told.remount}
    return Stand(**sizes, **kinds, name=told.name or "", samples=told.samples)


def step_of(result: Result) -> PerChannel:
    """Of the converter of its block, in V; 0 where it is not known."""
    step = 0.0 if result.stand is None else result.stand.step_v or 0.0
    return per_channel(by_channel(step))


def schedule_of(result: Result, name: str) -> CoreSchedule | None:
    """The schedule of a result, which messages call `name`; None where it tells of none. Raises BadInput."""
    told = result.schedule
    if told is None:
        return None
    matrices = (tuple(map(tuple, one.matrix.tolist())) for one in told.mounting)
    mountings = (
        Mounting(one.number, matrix, one.axis_tilt_deg, one.bolting or None)
        for one, matrix in zip(told.mounting, matrices)
    )
    positions = (Position(one.mounting, one.position, one.angle_deg, one.use) for one in told.position)
    try:
        return CoreSchedule(Schedule(tuple(mountings), tuple(positions)))
    except (CoreRefusal, ValueError):
        raise BadInput("its schedule is not as tumble solve writes it", name) from None


_LATEST = 253402300799  # the last second of the year 9999


def created(clock: bool = True) -> str | None:
    """Now, UTC, in the form of ISO 8601, or the second that SOURCE_DATE_EPOCH names where it is set. Without `clock`,
    as for a run in virtual time, which has no date, None unless it is set.

    Raises UsageError for a SOURCE_DATE_EPOCH that is no whole number of seconds.
    """
    told = os.environ.get("SOURCE_DATE_EPOCH")
    if told is None and not clock:
        return None
    if told is not None and (not re.fullmatch(r"[0-9]{1,12}", told, re.ASCII) or int(told) > _LATEST):
        raise UsageError(f"SOURCE_DATE_EPOCH: {quoted(told)} is not a whole number of seconds since 1970")
    moment = datetime.now(timezone.utc) if told is None else datetime.fromtimestamp(int(told), timezone.utc)
    return f"{moment:%Y-%m-%dT%H:%M:%SZ}"


def today() -> str:
    """The day of `created`, as 2026-11-30."""
    moment = created()
    assert moment is not None  # of a clock
    return moment[:10]


def document_of(
    solution: Solution,
    item: dict[str, Any] | None,
    environment: dict[str, Any] | None,
    serial: str | None = None,
    run_file: str | None = None,
    created: str | None = None,
    warnings: Sequence[str] = (),
) -> Result:
    """The result of a solve. `serial`: of the block; `run_file`: name of what was solved; `created`: when, None where
    no clock was looked at; `warnings`: sentences that a person is told beside it."""
    unit, rests_on, decision, fit = solution.run.unit, assumed(solution), decide(solution), solution.fit
    volts, temperature, alone = volts_per(unit), solution.run.temperature, solution.scatter_alone
    found, difference = solution.found, solution.comparison
    return Result(
        created=created,
        tumble=__version__,
        run_file=run_file,
        run_sha256=solution.run.sha256 or None,
        serial=serial,
        stand=None if solution.stand is None else declared_stand(solution.stand, by_channel(solution.step) * volts),
        schedule=schedule_part(solution.schedule),
        estimator=found.estimator,
        unit=unit,
        units=doc.Units(K=per_g(unit), U0=unit, u_K=per_g(unit), u_U0=unit),
        K=found.k,
        U0=found.u0,
        u_K=solution.u_k,
        u_U0=solution.u_u0,
        covariance=solution.covariance,
        u_norm_g=solution.u_norm,
        extended=None if solution.extended_terms is None else extended(solution.extended_terms, volts),
        second_order=None if solution.second_order is None else second_order_of(solution.second_order),
        monte_carlo=None if solution.monte_carlo is None else _monte_carlo(solution.monte_carlo),
        misfit=None if fit is None else fit.misfit,
        fit=None if fit is None else fit_of(fit),
        stand_doubts=None if fit is None else fit.stand_doubts,
        reliability=None if solution.reliability is None else unseen(solution.reliability),
        reliability_norm_g=None if solution.reliability is None else reliability.largest(solution.reliability),
        passed=decision.passed,
        pass_reason=" and ".join(decision.failures) or None,
        decision=doc.Decision(decision.coverage_factor, decision.u_norm_g, decision.limit_g, decision.scope),
        would_show=tuple(would_show(solution)) if decision.is_not_shown else None,
        assumes=tuple(rests_on),
        assumed_for={name: tuple(coefficients) for name, coefficients in rests_on.items()},
        warnings=tuple(warnings),
        noise=_noise(solution),
        scatter_alone=None if alone is None else doc.ScatterAlone(alone.u_k, alone.u_u0),
        coverage=None if solution.coverage is None else coverage_of(solution.coverage),
        verification=_verification(solution),
        stand_seen=stand_seen(solution.stand_seen, volts, solution.channel_noise),
        **_inclined(solution),
        intrinsic=_of_block(found.intrinsic.scale, found.intrinsic.angles, found.intrinsic.bias),
        si=si_of(found.k, found.u0, solution.covariance, environment, unit),
        u_intrinsic=None if (u := solution.u_intrinsic) is None else _of_block(u.scale, u.angles, u.bias),
        reference=doc.Reference(
            max_abs_difference_K=float(np.abs(difference.k).max()),
            max_abs_difference_U0=float(np.abs(difference.u0).max()),
            difference_K=difference.k,
            difference_U0=difference.u0,
        ),
        means=_means(solution),
        counters=solution.run.counters,
        item=item,
        environment=environment,
        temperature=None if (t := temperature) is None else doc.Temperature(t.low_c, t.high_c, t.source),
        set_angles=UNSET if (table := solution.set_angles) is None else set_angles_part(table),
        prior=UNSET if solution.prior is None else prior_part(solution.prior),
    )


def prior_part(outcome: PriorOutcome) -> Prior:
    """What became of a prior."""
    prior, test = outcome.prior, outcome.test
    growth, drift = (OfParameters(*one.reshape(3, 3)) for one in (prior.growth, prior.drift))
    return Prior(
        source=prior.source,
        created=prior.created,
        days=prior.days,
        growth=growth,
        growth_by="history" if prior.growth_by == "history" else "declared",
        drift=drift,
        chi2=test.chi_squared,
        dof=test.freedom,
        p=test.p,
        used=outcome.used,
        changes=tuple(Change(one.parameter, one.size * 1e6, one.u * 1e6, unit_of(one)) for one in test.changes),
        undetermined=outcome.undetermined,
        u_norm_worst_without_g=outcome.u_norm_alone_g,
        u_norm_worst_alone_g=prior.worst_norm.worst_g,
    )


def set_angles_part(table: SetAngles) -> doc.SetAngles:
    """What means were corrected by."""
    worst = max(table.u)
    return doc.SetAngles(table.learned, table.expires, table.runs, worst, table.repeatability, table.u_repeatability)


def inclinations_of(solution: Solution) -> tuple[doc.Inclination, ...] | UnsetType:
    """What a run says of them, of a block that is inclined."""
    seen, u = solution.inclinations, solution.u_inclinations
    if seen is None:
        return UNSET
    deg, zeros = np.rad2deg([seen.beta, seen.tau]).tolist()
    u_deg = [None] * len(deg) if u is None else np.rad2deg(u).tolist()
    return tuple(map(doc.Inclination, seen.numbers, deg, u_deg, zeros))


def _inclined(solution: Solution) -> dict[str, Any]:
    """The same, and the level of the axis: the first inclination that was to be level."""
    told = inclinations_of(solution)
    if isinstance(told, UnsetType):
        return {}
    to_be_level = [one.number for one in solution.schedule.mountings if one.tilt_deg == 0.0]
    levels = ((math.radians(one.deg), one.u_deg) for one in told if one.mounting in to_be_level)
    level, u_deg = next(levels, (UNSET, UNSET))
    u_level = math.radians(u_deg) if isinstance(u_deg, float) else u_deg
    return {"inclinations": told, "level_rad": level, "u_level_rad": u_level}


def as_shown(schedule: Schedule, result: Result) -> Schedule:
    """A schedule at the inclinations that a result on it tells; else as it is."""
    if isinstance(result.inclinations, UnsetType):
        return schedule
    numbers, deg, zeros = zip(*((one.mounting, one.deg, one.zero_deg) for one in result.inclinations))
    return as_seen(schedule, Inclinations(numbers, np.deg2rad(deg), np.deg2rad(zeros)))


def declared_stand(stand: Stand, step_v: Floats) -> doc.DeclaredStand:
    """With the keys and numbers of [stand]. `step_v` (3,): of the converter of its block, 0 where it is unknown."""
    sizes = {source: getattr(stand, source.attribute) for source in SOURCES.values()}
    errors: dict[str, Any] = {
        one.key: UNSET if one.of_inclinations and size == one.undeclared else size for one, size in sizes.items()
    }
    step = per_channel(step_v) if step_v.any() else None
    labels = stand.name or None, stand.limits, stand.remounting, int(stand.samples)
    return doc.DeclaredStand(*labels, **errors, step_v=step)


def schedule_part(schedule: Schedule) -> doc.Schedule:
    """With the name of a built-in one, else None, and the tables of a schedule file."""
    mountings = (
        doc.Mounting(one.number, np.array(one.matrix), one.tilt_deg, one.bolting or UNSET) for one in schedule.mountings
    )
    positions = (doc.Position(int(one.mounting), int(one.number), one.angle_deg, one.use) for one in schedule.positions)
    name = next((name for name in BUILT_IN if built_in(name) == schedule), None)
    return doc.Schedule(name, tuple(mountings), tuple(positions))


def _measured(solution: Solution) -> list[tuple[int, tuple[int, int, str]]]:
    """Index of every position that was measured, and which it is."""
    samples, positions = solution.run.samples, solution.schedule.positions
    return [(i, (int(one.mounting), int(one.number), one.use)) for i, one in enumerate(positions) if samples[i] > 0]


def extended(extended_terms: ExtendedTerms, volts_per_unit: float) -> Extended:
    """With the drift in volts."""
    scale = [volts_per_unit if term == DRIFT else 1.0 for term in extended_terms.terms]
    size, u = extended_terms.values, extended_terms.u
    by_term: dict[str, Any] = {
        KEYS[term]: size for term, size in extended_terms.by_term(size * np.array(scale)[:, None]).items()
    }
    u_by_term: dict[str, Any] = {f"u_{key}": None for key in by_term}
    if u is not None:
        u_by_term = {f"u_{KEYS[term]}": u for term, u in extended_terms.by_term(u * np.array(scale)[:, None]).items()}
    scales = np.concatenate([np.ones(12), np.repeat(scale, 3)])
    joint, alone = extended_terms.of_values, extended_terms.worst_norm_of_twelve
    return Extended(
        model_of(extended_terms.terms),
        **by_term,
        **u_by_term,
        names=names(extended_terms.terms),
        covariance=None if joint is None else scales[:, None] * joint * scales,
        u_norm_of_K_U0_g=None if alone is None else alone.worst_g,
        without=extended_terms.without,
        max_abs_difference=float(np.abs(extended_terms.difference).max()),
    )


def second_order_of(found: SecondOrder) -> doc.SecondOrder:
    """The bias that the linear theory leaves out."""
    return doc.SecondOrder(
        bias_K_xx_relative=found.yaw**2 / 2.0,
        limit=found.limit(0),
        matters=found.matters,
        shifts=tuple(found.shifts),
        bias=doc.Bias(found.bias[:9].reshape(3, 3), found.bias[9:]),
    )


def _monte_carlo(found: MonteCarlo) -> doc.MonteCarlo:
    ends, linear = np.stack([found.low, found.high], axis=1), np.stack([found.linear_low, found.linear_high], axis=1)
    rows = zip(
        *(COEFFICIENTS, found.shift.tolist(), found.u.tolist(), ends, linear),
        *(np.abs(ends - linear).max(axis=1).tolist(), found.tolerance.tolist()),
        (verdict.value for verdict in found.verdicts),
    )
    coefficients = tuple(doc.Simulated(*row) for row in rows)
    return doc.MonteCarlo(found.runs, found.seed, COVERAGE, LEVEL, found.agrees, coefficients)


def fit_of(fit: Fit) -> doc.Fit:
    """Whether a run fits its stand."""
    return doc.Fit(fit.chi_squared, fit.freedom, fit.p, fit.fits, fit.confidence, fit.explanations)


def unseen(found: reliability.Reliability) -> tuple[doc.Unseen, ...]:
    """What a run would not have shown, by pattern."""
    return tuple(doc.Unseen(one.pattern.name, one.size, one.pattern.unit, one.norm_g) for one in found)


def _noise(solution: Solution) -> doc.Noise:
    noise, seen = solution.noise, solution.noise.measured
    return doc.Noise(
        scatter=None if seen is None else seen.scatter,
        of_means=None if seen is None else of_means(seen, solution.run.samples),
        block_samples=None if seen is None else tuple(seen.length.tolist()),
        freedom=None if seen is None else tuple(seen.freedom.tolist()),
        above_declared=tuple(CHANNELS[noise.exceeds].tolist()),
        undithered=tuple(CHANNELS[noise.undithered].tolist()),
    )


def coverage_of(found: Coverage) -> doc.Coverage:
    """A freedom of null is infinite."""
    freedom, k = _finite(found.freedom), found.factors.tolist()
    intrinsic, k_intrinsic = _finite(found.intrinsic), factors_of(found.intrinsic).tolist()
    return doc.Coverage(
        probability=PROBABILITY,
        freedom_K=(freedom[0:3], freedom[3:6], freedom[6:9]),
        freedom_U0=freedom[9:],
        k_K=(k[0:3], k[3:6], k[6:9]),
        k_U0=k[9:],
        freedom_intrinsic=_of_block(intrinsic[:3], intrinsic[3:6], intrinsic[6:]),
        k_intrinsic=_of_block(k_intrinsic[:3], k_intrinsic[3:6], k_intrinsic[6:]),
    )


def _finite(freedom: Floats) -> Any:
    return tuple(None if math.isinf(one) else one for one in freedom.tolist())


def _of_block(scale: Any, angles: Any, bias: Any) -> doc.OfBlock[Any, Any, Any]:
    return doc.OfBlock(scale, doc.Angles(*(float(one) if one is not None else None for one in angles)), bias)


def _verification(solution: Solution) -> doc.Verification:
    gravity, by_noise = solution.found.gravity, _gravity_uncertainty(solution)
    judged = [largest for largest in (gravity.max_abs_fit, gravity.max_abs_check) if largest is not None]
    return doc.Verification(
        delta_g_g=tuple(
            doc.DeltaG(*place, float(gravity.delta_g[index]), *by_noise.get(index, ()))
            for index, place in _measured(solution)
        ),
        max_abs_delta_g_g=max(judged),
        max_abs_delta_g_fit_g=gravity.max_abs_fit,
        max_abs_delta_g_check_g=gravity.max_abs_check,
        limit_g=solution.limit_g,
        passed=gravity.passed,
        closure=tuple(doc.Closure(*one) for one in solution.found.closure.items()),
        residual_rms=solution.found.residual_rms,
    )


def _gravity_uncertainty(solution: Solution) -> dict[int, tuple[float, float]]:
    """How well the gravity check knows its errors, delta_g = (|a|^2 - 1)/2 with a = K^-1 (U - U0): by position their
    standard uncertainty, g, and its coverage factor for PROBABILITY; NaN where it was not measured, nothing where no
    noise is known. The coefficients are those found, and the length of gravity is 1 g at every attitude, so that no
    error of the stand is in delta_g: the noise of the position's mean alone makes it uncertain, d delta_g = a K^-1 dU;
    the declared or the measured one, whichever counts in the other uncertainties."""
    noise, run = solution.noise, solution.run
    if solution.stand is None and not noise.is_known:
        return {}
    stand = solution.propagation.stand
    declared = np.broadcast_to(stand.mean_variance(run.samples), noise.mean_variance.shape)
    inverse = np.linalg.inv(solution.found.k)
    force = (run.means - solution.found.u0) @ inverse.T
    weights = (force @ inverse) ** 2
    variance = (weights * np.maximum(declared, noise.mean_variance)).sum(axis=1)
    freedom = np.full(len(variance), np.inf)
    if noise.measured is not None:
        measured = np.where(noise.by_samples >= declared, noise.by_samples, 0.0)
        freedom = effective(variance, (weights * measured).T, noise.measured.freedom)
    factors = [student_quantile(PROBABILITY, one) for one in freedom.tolist()]
    return dict(enumerate(zip(np.sqrt(variance).tolist(), factors)))


def stand_seen(seen: StandSeen, volts: float, channels: ChannelNoise | None) -> doc.StandSeen:
    """Every quantity with its standard uncertainty. `volts`: in a unit of the outputs; `channels`: of a stand that
    declares three."""
    has_u, noise, alpha4 = seen.source is not None, seen.noise, seen.alpha4
    angles = {name: (seen.angles[name], has_u) for name in ANGLES} | {"alpha4": (alpha4, True)}
    told, augmented = _by_key(angles), _by_key({name: (one, True) for name, one in seen.augmented.items()})
    others = tuple(doc.YawChange(mounting, *_pair(one)) for mounting, one in seen.other_yaw_changes.items())
    return doc.StandSeen(
        **told,
        noise_v=None if noise is None else noise.value * volts,
        u_noise_v=None if noise is None else noise.u * volts,
        noise_v_by_channel=None if channels is None else channels.values,
        u_noise_v_by_channel=None if channels is None else channels.u,
        u_from=seen.source,
        u_freedom=seen.freedom,
        alpha4_freedom=None if alpha4 is None else seen.alpha4_freedom,
        augmented=None if set(augmented.values()) == {None} else doc.Augmented(**augmented, other_yaw_changes=others),
    )


def _by_key(seen: Mapping[str, tuple[Estimate | None, bool]]) -> dict[str, Any]:
    """What is seen of each angle, and its standard uncertainty, if that is known."""
    pairs = {name: _pair(*one) for name, one in seen.items()}
    return {f"{u}{name}_rad": told for name, pair in pairs.items() for u, told in zip(("", "u_"), pair)}


def _pair(seen: Estimate | None, has_u: bool = True) -> tuple[float | None, float | None]:
    return (None, None) if seen is None else (seen.value, seen.u if has_u else None)


def _means(solution: Solution) -> tuple[doc.Mean, ...]:
    run = solution.run
    return tuple(
        doc.Mean(*place, int(run.samples[i]), run.means[i], run.scatter[i] if run.samples[i] > 1 else None)
        for i, place in _measured(solution)
    )
