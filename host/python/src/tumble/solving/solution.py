"""Solve a run: the core computes, the numpy witness confirms, and only then is there a solution."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from tumble import core
from tumble.arrays import Floats, Integers
from tumble.defaults import DEFAULT_COVERAGE_FACTOR
from tumble.documents.result import Truth, WorstNorm
from tumble.errors import BadInput
from tumble.estimators import INCLINATIONS, INCLINED, LEAST_SQUARES, NORM, OPTIMAL
from tumble.files.run_file import Run
from tumble.model import inclined, norm
from tumble.model.coefficients import (
    IntrinsicUncertainties,
    NotSolvable,
    by_intrinsic,
    intrinsic_uncertainties,
    worst_norm,
)
from tumble.model.fit import CONFIDENCE, Fit, WholeModel, judge, variance_of_means
from tumble.model.geometry import built_in
from tumble.model.inclined import EQUAL, Inclinations
from tumble.model.optimal import OptimalEstimate, optimal_estimate
from tumble.model.propagation import Propagation, SecondOrder, second_order
from tumble.model.reliability import Reliability, reliability
from tumble.model.stand_seen import (
    ANGLES,
    ChannelNoise,
    RunSeen,
    StandSeen,
    estimate_stand_errors,
    pooled_noise,
    stand_for_estimate,
    weights_of,
)
from tumble.schedule import Schedule
from tumble.solving import optimal_run
from tumble.solving.computation import (
    LARGEST_MISFIT,
    Comparison,
    Computation,
    compare,
    compare_inclinations,
    compute,
    estimate_inclinations,
    estimator_or_linear,
    magnified_angles,
    require_told_apart,
)
from tumble.solving.many_runs import MonteCarlo, simulate
from tumble.solving.noise import NO_STAND, Noise, estimate_noise, sampled_patterns
from tumble.solving.prior import PriorOutcome
from tumble.solving.uncertainty import Coverage, ExtendedTerms, Uncertainties, confirmed, coverage
from tumble.stand import PerChannel, SetAngles, Stand, over
from tumble.terms import Terms
from tumble.units import volts_per
from tumble.workers.over import ALONE, Progress, Team


@dataclass(frozen=True)
class Solution:
    """Everything known after a run: one row per position of `schedule`, in its order.

    `found`: by the core; `comparison`: with the witness; `stand`: the declared one; `stand_seen`: the stand as the run
    shows it, in the unit of the run; `noise`: what the samples show of it; `propagation`: how errors reach the
    estimate, those of the declared stand, in the unit of the run, or of none; `fit`: whether the run fits the declared
    stand; `stated`: the uncertainties, None without a declared stand; `scatter_alone`: without one, those that the
    noise of the samples leaves if the stand has no errors at all, None where it is not known; `truth`: None for a run
    that was measured; `step`: of the converter, in the unit of the run, 0: unknown; `monte_carlo`: None where nobody
    asked for it; `extended_terms`: terms of the model beside the twelve coefficients, None where nobody asked for any;
    `is_out_of_order`: axes or signs of K are those of an exchange or reversal, and no block is declared to have them;
    `knows_signs`: a block is declared, with the signs of its scales;
    `set_angles`: what the means were corrected by, None where they were not;
    `coverage_factor`: how many u(|a|) must be within the limit; `inclinations`: as the run shows them, of a block that
    is bolted on once; `brought_stand`: the schedule brought the stand, nobody declared one.
    """

    schedule: Schedule
    run: Run
    limit_g: float
    found: Computation
    comparison: Comparison
    stand: Stand | None
    stand_seen: StandSeen
    noise: Noise
    propagation: Propagation
    fit: Fit | None = None
    stated: Uncertainties | None = None
    scatter_alone: Uncertainties | None = None
    truth: Truth | None = None
    step: PerChannel = 0.0
    monte_carlo: MonteCarlo | None = None
    extended_terms: ExtendedTerms | None = None
    is_out_of_order: bool = False
    knows_signs: bool = False
    coverage_factor: float = DEFAULT_COVERAGE_FACTOR
    inclinations: Inclinations | None = None
    brought_stand: bool = False
    set_angles: SetAngles | None = None
    prior: PriorOutcome | None = None

    @cached_property
    def u_inclinations(self) -> Floats | None:
        """Standard uncertainties (inclinations,) of their angles, rad; None where there are none, or no stand."""
        if self.stand is None or self.inclinations is None:
            return None
        return self.propagation.u_inclinations(self.mean_variance)

    @property
    def u_k(self) -> Floats | None:
        """Standard uncertainties of K (3, 3); None without a declared stand."""
        return None if self.stated is None else self.stated.u_k

    @property
    def u_u0(self) -> Floats | None:
        """Standard uncertainties of U0 (3,); None without a declared stand."""
        return None if self.stated is None else self.stated.u_u0

    @property
    def covariance(self) -> Floats | None:
        """Of K row by row and U0 (12, 12); None without a declared stand."""
        return None if self.stated is None else self.stated.covariance[:12, :12]

    @property
    def measured_schedule(self) -> Schedule:
        """The schedule without the positions that the run does not have, at the inclinations that it shows."""
        return self.propagation.schedule

    @property
    def declared(self) -> Stand:
        """What is declared of the errors that are no unknowns, in the unit of the run. Only where there is a stand."""
        assert self.stand is not None
        return self.stand.without(self.found.terms).in_unit(self.run.unit)

    @property
    def mean_variance(self) -> Floats:
        """Of the means by the noise (measured positions, 3)."""
        return self.noise.mean_variance[self.run.measured]

    @cached_property
    def second_order(self) -> SecondOrder | None:
        """Whether the declared stand is good enough for the linear theory of uncertainties; None without a stand, and
        with a prior."""
        if self.stand is None or self.propagation.prior is not None:
            return None
        return second_order(self.propagation, self._u, estimator_or_linear(self.propagation))

    @cached_property
    def reliability(self) -> Reliability | None:
        """What the run could not have shown, whatever it shows; None without a declared stand."""
        if self.fit is None:
            return None
        return reliability(self.propagation, self.fit.confidence, self.noise.rounding)

    @cached_property
    def coverage(self) -> Coverage | None:
        """How well the uncertainties are known, of a stand or by scatter alone; None where there are none."""
        if self.u_k is None and self.scatter_alone is None:
            return None
        by_twelve = by_intrinsic(self.found.k, self.found.u0)
        return coverage(self.noise, self.run.measured, self.propagation, by_twelve)

    def simulated(self, runs: int, seed: int, team: Team = ALONE, progress: Progress = lambda runs: None) -> Solution:
        """This solution with its `monte_carlo`, by a team; it has a declared stand. Raises UsageError."""
        given = self.propagation, self.found.u0, self._u, runs, seed, self.mean_variance
        return replace(self, monte_carlo=simulate(*given, team, progress))

    @property
    def drawn_from(self) -> dict[str, Any]:
        """All that its simulated runs depend on, beside their seed. Only where there is a stand."""
        given = {one.name: getattr(self.propagation, one.name) for one in fields(self.propagation)}
        return {**given, "u0": self.found.u0, "u": self._u, "mean_variance": self.mean_variance}

    @property
    def channel_noise(self) -> ChannelNoise | None:
        """What the samples show, channel by channel, where the stand declares it so."""
        stand, seen, samples = self.stand, self.noise.measured, self.run.samples
        if stand is None or seen is None or not isinstance(stand.noise, tuple):
            return None
        freedom = int((samples[samples > 1] - 1).sum())
        return ChannelNoise(seen.scatter * volts_per(self.run.unit), freedom, stand.sigmas("noise"))

    @property
    def _u(self) -> Floats:
        """Standard uncertainties (12,), where there are any."""
        assert self.stated is not None
        return np.concatenate([self.stated.u_k.ravel(), self.stated.u_u0])

    @cached_property
    def u_norm(self) -> WorstNorm | None:
        """Where the calibrated block shows the length of gravity worst; None without a stand."""
        if self.extended_terms is not None:
            return self.extended_terms.worst_norm
        return None if self.covariance is None else worst_norm(self.found.k, self.covariance)

    @property
    def u_intrinsic(self) -> IntrinsicUncertainties | None:
        """Of the intrinsic parameters; None without a stand."""
        if self.covariance is None:
            return None
        return intrinsic_uncertainties(self.found.k, self.found.u0, self.covariance)

    @property
    def lone(self) -> list[str]:
        """Positions with a single row where others have many: one sample each."""
        alone = (self.run.samples == 1) & (self.run.samples.max() > 1)
        return [position.label for position, one in zip(self.schedule.positions, alone.tolist()) if one]

    @property
    def worst_position(self) -> int:
        """Index of the position with the largest gravity error."""
        return int(np.nanargmax(np.abs(self.found.gravity.delta_g)))


def solve(
    run: Run,
    schedule: core.CoreSchedule | None,
    estimator: str,
    limit_g: float,
    stand: Stand | None,
    file: str,
    step_v: PerChannel = 0.0,
    known: optimal_run.Known | None = None,
    confidence: float = CONFIDENCE,
    terms: Terms = (),
    coverage_factor: float = DEFAULT_COVERAGE_FACTOR,
    signs: Floats = EQUAL,
) -> Solution:
    """Solve a run on a schedule (None: the paper's).

    `file` names the run in errors. The optimal estimator needs a `stand`; `step_v` is its converter's step, 0 if
    unknown, and `known` what its table was made for, None if it is to be made for this run. `confidence`: at which the
    run must fit the stand. `terms`: further ones of the model, in the order of TERMS, for one of EXTENDABLE.
    `coverage_factor`: of the decision rule; `signs` (3,) of the scales, which `norm` cannot show. Raises BadInput where
    the core refuses the run, Disagreement where the witness does not confirm it.
    """
    step = over(step_v, volts_per(run.unit))
    in_unit = None if stand is None else _counted(stand, estimator, terms).in_unit(run.unit)
    declared = None if in_unit is None else in_unit.with_step(step)  # with the rounding of its converter
    planned = schedule or core.CoreSchedule.built_in("paper")
    means, samples = run.means[run.measured], run.samples[run.measured]
    noise = estimate_noise(run, in_unit, step)
    variance = noise.mean_variance[run.measured]
    noted = declared or NO_STAND
    place = _place_of(planned, run, estimator, _Left(noted, samples, step, variance), signs, file)
    core_schedule, witness_schedule = place.schedule, place.witness_schedule

    # The core computes.
    weighting = model = optimal = None
    if estimator == OPTIMAL and declared is not None:
        is_set = place.inclinations is not None and math.isfinite(declared.inclination)
        weighting = optimal_run.Weighting(declared, run.samples, step, known, planned if is_set else None)
    found = _by_core(core_schedule, witness_schedule, run, estimator, limit_g, weighting, terms, file, place.closed)

    # The witness confirms.
    if declared is not None:
        of_means = variance_of_means(declared, run.samples, noise.rounding)[run.measured]
        model = WholeModel(witness_schedule, means, of_means, declared, terms)
        if weighting is not None:
            optimal = _by_numpy(model, place, means, samples, weighting, variance, file)
    linear, delta_g = found.linear[run.measured], found.gravity.delta_g[run.measured]
    comparison = compare(found, witness_schedule, means, linear, delta_g, optimal, noted.weights * signs)

    # Uncertainties: of the declared stand, or of the scatter alone.
    uncertainties = None
    propagation = Propagation(witness_schedule, found.k, noted, samples, estimator, step, terms)
    if declared is not None or noise.is_known:
        uncertainties = confirmed(propagation, core_schedule, run.measured, variance, optimal, file)
    stated = None if stand is None else uncertainties
    of_terms = (None, None) if stated is None else (stated.covariance, stated.without)

    # The stand as the run shows it, and whether it is the declared one.
    alike = None if declared is None else stand_for_estimate(declared, found.k)
    seen, fit = _stand_seen(place, run, found, linear, alike, variance), None
    if alike is not None and model is not None:
        fit = judge(model, confidence, seen, sampled_patterns(noise, run, seen.noise, alike, step))
    return Solution(
        schedule=core_schedule.data if estimator == NORM else planned.data,
        run=run,
        limit_g=limit_g,
        found=found,
        comparison=comparison,
        stand=stand,
        stand_seen=replace(seen, alpha4=None, alpha4_freedom=0.0) if terms else seen,
        noise=noise,
        propagation=propagation,
        fit=fit,
        stated=stated,
        scatter_alone=uncertainties if stand is None else None,
        step=step,
        extended_terms=ExtendedTerms(terms, found.k, found.sizes, comparison.sizes, *of_terms) if terms else None,
        coverage_factor=coverage_factor,
        inclinations=place.inclinations,
    )


@dataclass(frozen=True)
class _Place:
    """Where a run was made: the `schedule` of the core, and of numpy the part that was measured, also as it was
    `planned`. Of a block that is bolted on once `inclinations` are what the run shows, the schedules are at these, and
    `closed` (12,) are the coefficients that come with them by the core's closed form; else both are None."""

    schedule: core.CoreSchedule
    witness_schedule: Schedule
    planned: Schedule
    closed: Floats | None = None
    inclinations: Inclinations | None = None


@dataclass(frozen=True)
class _Left:
    """What inclinations that hardly differ leave of u(|a|), for refusals: the `stand`, NO_STAND where none is declared,
    in the unit of the run; of the means measured the `samples` (positions,) and the `variance` (positions, 3)."""

    stand: Stand
    samples: Integers
    step: PerChannel
    variance: Floats

    def told(self, part: Schedule, means: Floats) -> str:
        """Of a run on `part`; nothing where that is not known."""
        if self.stand is NO_STAND and not (self.variance > 0.0).all():
            return ""
        at, k = inclined.supposed(part, means)
        try:
            covariance = Propagation(at, k, self.stand, self.samples, INCLINED, self.step).covariance(self.variance)
            u_norm_g = worst_norm(k, covariance).worst_g
        except (inclined.NotShown, np.linalg.LinAlgError):
            u_norm_g = math.inf
        return f", which leaves u(|a|) of up to {u_norm_g:.2g} g" if u_norm_g < 1.0 else ", which leaves |a| unknown"


def _counted(stand: Stand, estimator: str, terms: Terms) -> Stand:
    """What of a declared stand counts beside the unknowns."""
    return stand.of_any_pose if estimator == NORM else stand.without(terms)


def _place_of(planned: core.CoreSchedule, run: Run, estimator: str, left: _Left, signs: Floats, file: str) -> _Place:
    """The place of a run that was `planned` so: as it is planned, or as the run shows it. Raises as the two below."""
    if estimator != NORM:
        return _at_inclinations(planned, run, estimator, left, file)
    of_means = np.maximum(left.stand.mean_variance(left.samples), left.variance)
    return _at_directions(planned, run, left.stand.weights * signs, of_means, file)


def _at_inclinations(planned: core.CoreSchedule, run: Run, estimator: str, left: _Left, file: str) -> _Place:
    """The place of a run that was `planned` so. Raises BadInput where it shows no inclinations, or the estimator does
    not find them; Disagreement where numpy sees others."""
    own = planned.data if planned.name is None else built_in(planned.name)  # of the witness
    if estimator != INCLINED and not planned.data.is_inclined:
        return _Place(planned, own.part(run.measured), own.part(run.measured))
    if estimator not in (INCLINED, OPTIMAL):
        raise BadInput(f"{estimator} takes inclinations as exact, but none is measured; inclined finds them", file)
    part, means, weights = own.part(run.measured), run.means[run.measured], left.stand.weights
    if (same := inclined.alike(part, means, weights)) is not None:
        raise BadInput(f"{same}{left.told(part, means)}; {_THREE_DIFFER}", file)
    try:
        closed, seen = estimate_inclinations(planned, run.means, run.measured, weights)
    except core.CoreRefusal as refusal:
        lacking = _missing(planned.data, run)
        if refusal.name == "TUMBLE_E_NOT_INCLINED" and lacking:
            raise BadInput(f"{estimator} needs {INCLINATIONS}; missing {lacking}", file) from None
        if refusal.name == "TUMBLE_E_ONE_SIDE":  # numpy says at which angles
            _inclinations_by_numpy(part, means, weights, file)
        if refusal.name == "TUMBLE_E_ALIKE":
            raise BadInput(f"{refusal}{left.told(part, means)}; {_THREE_DIFFER}", file) from None
        raise BadInput(_explained(refusal, estimator), file) from None
    k, of_witness = _inclinations_by_numpy(part, means, weights, file)
    witness_schedule = inclined.as_seen(part, of_witness)
    compare_inclinations(seen, of_witness, magnified_angles(witness_schedule, means, k, weights))
    at_seen = core.CoreSchedule(inclined.as_seen(planned.data, seen))
    return _Place(at_seen, witness_schedule, part, closed, seen)


def _at_directions(planned: core.CoreSchedule, run: Run, weights: Floats, of_means: Floats, file: str) -> _Place:
    """The place of a run whose poses nobody knows: at the directions that numpy finds, on which the core solves it by
    least squares. `of_means` (poses, 3): variance by their noise, 0: unknown. Raises BadInput where they do not show
    the nine."""
    rough, size = norm.roughly(run.means, weights)
    sigma_g = float(np.sqrt((of_means * weights**2).mean())) / size or None
    lacking = norm.unshown(rough, sigma_g)
    try:
        if lacking is None:
            directions = norm.solve(run.means, weights)[2]
            lacking = norm.unshown(directions, sigma_g)
    except norm.NotShown as error:
        lacking = str(error)
    if lacking is not None:
        raise BadInput(lacking, file)
    schedule = core.CoreSchedule(norm.as_seen(planned.data, directions))
    try:
        found = np.concatenate([one.ravel() for one in core.estimate(schedule, run.means, run.measured, LEAST_SQUARES)])
    except core.CoreRefusal as refusal:
        raise BadInput(_explained(refusal, NORM), file) from None
    found[list(norm.TURNED)] = 0.0  # but for rounding they are
    return _Place(schedule, schedule.data, planned.data, found)


def _inclinations_by_numpy(part: Schedule, means: Floats, weights: Floats, file: str) -> tuple[Floats, Inclinations]:
    """With K. Raises BadInput where the run contradicts its schedule."""
    try:
        k, _, found = inclined.solve(part, means, weights)
    except inclined.NotShown as error:
        raise BadInput(str(error), file) from None
    return k, found


def _missing(schedule: Schedule, run: Run) -> str:
    """The fit positions that a run lacks, in words."""
    return ", ".join(schedule.positions[index].label for index in schedule.fit_indices if not run.measured[index])


def _stand_seen(
    place: _Place, run: Run, found: Computation, linear: Floats, alike: Stand | None, variance: Floats
) -> StandSeen:
    """By the means `linear` in the force, of those measured, and their `variance`; `alike`: the stand to look with."""
    weights, samples = weights_of(alike), run.samples[run.measured]
    shown = RunSeen(place.witness_schedule, linear, found.k, place.schedule.data, weights)
    noise = pooled_noise(samples, run.scatter[run.measured] * weights)
    seen = estimate_stand_errors(shown, noise, samples, alike, True, variance)
    return without_angles(seen) if found.terms else seen


def without_angles(seen: StandSeen) -> StandSeen:
    """Further terms have much in common with the angles of a stand: beside them a run does not tell these any more. The
    error of a set angle is still asked for by `judge`."""
    none = dict.fromkeys(ANGLES)
    return replace(seen, angles=none, augmented=none, other_yaw_changes={}, source=None)


def _by_core(
    schedule: core.CoreSchedule,
    witness_schedule: Schedule,
    run: Run,
    estimator: str,
    limit_g: float,
    weighting: optimal_run.Weighting | None,
    terms: Terms,
    file: str,
    closed: Floats | None = None,
) -> Computation:
    """What the core finds. Raises BadInput where it refuses the run, or a run does not determine its further terms: in
    terms of what the user gave."""
    try:
        if terms:
            schedule.identify(run.measured)
            require_told_apart(witness_schedule, terms, file)
        return compute(schedule, run.means, run.measured, estimator, limit_g, weighting, terms, closed)
    except NotSolvable as error:
        raise BadInput(str(error), file) from None
    except core.CoreRefusal as refusal:
        raise BadInput(_explained(refusal, estimator), file) from None


_THREE_DIFFER = "three must differ by tens of degrees (+-20 deg leave five times the uncertainty of +-45 deg)"


def _explained(refusal: core.CoreRefusal, estimator: str) -> str:
    """A refusal in terms of what the user gave."""
    missing, lost = (", ".join(refusal.details.get(key, ())) for key in ("missing", "unidentified"))
    explained = {
        "TUMBLE_E_MISSING_POSITION": f"{estimator} needs every fit position: measure it, or solve without it by"
        " --estimator least_squares, or optimal with --stand; another schedule: --schedule;"
        f" missing {missing}",
        "TUMBLE_E_NOT_HARMONIC": f"the schedule lacks positions that {estimator} needs; least_squares solves any"
        " schedule",
        # only for want of room: the record was made for this run
        "TUMBLE_E_GAIN_RECORD": f"more than {core.MAX_YAWS} mountings, which optimal takes at most; least_squares"
        " solves any schedule",
        "TUMBLE_E_NOT_INCLINED": f"{estimator} needs {INCLINATIONS}",
        "TUMBLE_E_RANK": f"these positions cannot identify {lost}",
        "TUMBLE_E_SINGULAR": f"{refusal}, or the table turned the other way in one mounting, or one attitude was"
        " measured twice",
    }
    return explained.get(refusal.name, str(refusal))


def _by_numpy(
    model: WholeModel,
    place: _Place,
    means: Floats,
    samples: Integers,
    weighting: optimal_run.Weighting,
    variance: Floats,
    file: str,
) -> OptimalEstimate:
    """The optimal estimator from the data, without a table: on the schedule that `weighting` is for, as it was planned
    or seen. Raises BadInput for a run that cannot have come from such a stand: weights made for errors that are not
    there would mislead."""
    misfit = math.sqrt(model.chi_squared / max(1, model.freedom))
    if not misfit <= LARGEST_MISFIT:
        raise BadInput(f"residuals {misfit:.2g} times what the stand declares: no optimal weights for it", file)
    k, of_means = (None, None) if weighting.known is None else (weighting.known.k, weighting.known.samples)
    seen = place.witness_schedule
    given = seen if weighting.schedule is None else place.planned, means, weighting.stand, samples, weighting.step
    return optimal_estimate(*given, k, of_means, variance, model.terms, seen)
