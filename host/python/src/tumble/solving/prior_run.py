"""A run with a prior: the last calibration of its block enters the least squares of `optimal` (model.prior).

First run and prior are held against each other, at the confidence of the fit. Where they do not agree the block has
changed, or one of the two is wrong: then the prior is not used, and the solution is that of the run alone. A run that
does not determine all coefficients has none.

The core has no prior: it confirms the run alone, where that has a solution, and computes what follows from the
coefficients. Those are found by numpy twice, by singular values with the derivatives of a stand without errors
(model.prior), and by QR with those at the errors found (model.fit). Both are good to the second order of the angles, so
they may differ by the share of u that such a bias may have.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tumble import core
from tumble.arrays import Floats
from tumble.errors import BadInput, Disagreement
from tumble.estimators import OPTIMAL
from tumble.files.run_file import Run
from tumble.model.coefficients import NotSolvable
from tumble.model.errors import by_coefficient
from tumble.model.estimators import unidentified
from tumble.model.fit import WholeModel, judge, variance_of_means
from tumble.model.optimal import OptimalEstimate, mean_sigma, samples_in_a_mean
from tumble.model.prior import Given, Prior, WithPrior, difference_test, estimate_with_prior
from tumble.model.propagation import SHARE, Propagation
from tumble.model.stand_seen import RunSeen, estimate_stand_errors, pooled_noise, stand_for_estimate, weights_of
from tumble.solving.computation import Comparison, Computation, compare, computation_of
from tumble.solving.noise import estimate_noise, sampled_patterns
from tumble.solving.prior import PriorOutcome
from tumble.solving.solution import Solution, solve
from tumble.solving.uncertainty import Uncertainties
from tumble.stand import PerChannel, Stand, over
from tumble.units import volts_per


@dataclass(frozen=True)
class Rule:
    """Of the decision: the limit of the gravity check, the confidence of the fit, and how many u(|a|) count."""

    limit_g: float
    confidence: float
    coverage_factor: float


def solve_with_prior(
    prior: Prior, run: Run, schedule: core.CoreSchedule, rule: Rule, stand: Stand, file: str, step_v: PerChannel = 0.0
) -> Solution:
    """Solve a run by `optimal` on a schedule without inclinations; arguments as of `solve`. Raises BadInput,
    Disagreement."""
    undetermined = unidentified(schedule.data.part(run.measured))
    if undetermined:
        return _by_prior(prior, undetermined, run, schedule, rule, stand, file, step_v)
    alone = solve(
        *(run, schedule, OPTIMAL, rule.limit_g, stand, file, step_v),
        confidence=rule.confidence,
        coverage_factor=rule.coverage_factor,
    )
    assert alone.covariance is not None  # of a declared stand
    test = difference_test(prior, alone.found.k, alone.found.u0, alone.covariance)
    u_norm_g = None if alone.u_norm is None else alone.u_norm.worst_g
    outcome = PriorOutcome(prior, test, test.p >= 1.0 - rule.confidence, u_norm_g)
    if not outcome.used:
        return replace(alone, prior=outcome)
    given, start = alone.propagation, (alone.found.k, alone.found.u0)
    estimate = _estimate(prior, run, given, alone.mean_variance, file, start)
    joint = _joint(estimate, prior, schedule, run, given, rule.limit_g, file)
    return replace(
        alone,
        found=joint.found,
        comparison=joint.comparison,
        stated=joint.stated,
        propagation=joint.propagation,
        prior=outcome,
    )


def _by_prior(
    prior: Prior,
    undetermined: Sequence[str],
    run: Run,
    planned: core.CoreSchedule,
    rule: Rule,
    stand: Stand,
    file: str,
    step_v: PerChannel,
) -> Solution:
    """Of a run that leaves some coefficients undetermined, which are then those of its prior, as far as a turn of the
    block allows. Its fit and the stand seen rest on the run alone."""
    step = over(step_v, volts_per(run.unit))
    in_unit = stand.in_unit(run.unit)
    declared, noise = in_unit.with_step(step), estimate_noise(run, in_unit, step)
    means, samples = run.means[run.measured], run.samples[run.measured]
    variance = noise.mean_variance[run.measured]
    schedule = planned.data.part(run.measured)
    given = Propagation(schedule, prior.k, declared, samples, OPTIMAL, step)
    estimate = _estimate(prior, run, given, variance, file)
    is_alike = estimate.test.p >= 1.0 - rule.confidence
    outcome = PriorOutcome(prior, estimate.test, is_alike, None, tuple(undetermined))
    if (finding := outcome.finding) is not None:
        lost = ", ".join(undetermined)
        raise BadInput(f"{finding}; these positions without a prior cannot identify {lost}", file)
    joint = _joint(estimate, prior, planned, run, given, rule.limit_g, file)
    found, alike = joint.found, stand_for_estimate(declared, joint.found.k)
    of_means = variance_of_means(declared, run.samples, noise.rounding)[run.measured]
    model = WholeModel(schedule, means, of_means, declared, known=(found.k, found.u0))
    weights = weights_of(alike)
    pooled = pooled_noise(samples, run.scatter[run.measured] * weights)
    shown = RunSeen(schedule, means, found.k, planned.data, weights)
    seen = estimate_stand_errors(shown, pooled, samples, alike, True, variance)
    return Solution(
        schedule=planned.data,
        run=run,
        limit_g=rule.limit_g,
        found=found,
        comparison=joint.comparison,
        stand=stand,
        stand_seen=seen,
        noise=noise,
        propagation=joint.propagation,
        fit=judge(model, rule.confidence, seen, sampled_patterns(noise, run, seen.noise, alike, step)),
        stated=joint.stated,
        step=step,
        coverage_factor=rule.coverage_factor,
        prior=outcome,
    )


@dataclass(frozen=True)
class _Joint:
    """Of run and prior together, as a Solution has it."""

    found: Computation
    comparison: Comparison
    stated: Uncertainties
    propagation: Propagation


def _estimate(
    prior: Prior,
    run: Run,
    given: Propagation,
    variance: Floats,
    file: str,
    start: tuple[Floats, Floats] | None = None,
) -> WithPrior:
    """Of a run whose measured positions are `given`; `variance` (positions measured, 3) of its means by the noise as
    measured; `start` as of estimate_with_prior. Raises BadInput where there is no estimate."""
    rest = Given(given.schedule, given.stand, given.samples, given.step)
    try:
        return estimate_with_prior(rest, run.means[run.measured], prior, variance, start)
    except (NotSolvable, np.linalg.LinAlgError) as error:
        raise BadInput(f"--prior: {error}", file) from None


def _joint(
    estimate: WithPrior,
    prior: Prior,
    schedule: core.CoreSchedule,
    run: Run,
    given: Propagation,
    limit_g: float,
    file: str,
) -> _Joint:
    """What follows from an estimate, on the `schedule` of the run. Raises BadInput for one that no block has;
    Disagreement."""
    twelve = np.concatenate([estimate.k.ravel(), estimate.u0])
    try:
        found = computation_of(schedule, run.means, run.measured, OPTIMAL, limit_g, twelve)
    except NotSolvable as error:
        raise BadInput(f"--prior: {error}", file) from None
    return _Joint(
        found,
        _confirm(estimate, found, prior, given, run.means[run.measured], run),
        Uncertainties(*by_coefficient(estimate.covariance), estimate.covariance),
        replace(given, k=estimate.k, prior=(prior, estimate.u0)),
    )


def _confirm(
    estimate: WithPrior, found: Computation, prior: Prior, given: Propagation, means: Floats, run: Run
) -> Comparison:
    """Raise Disagreement where the other computation finds other coefficients, or the core other consequences."""
    sigma = mean_sigma(
        estimate.k, given.stand, given.step, samples_in_a_mean(given.schedule, given.stand, given.samples)
    )
    equal = np.broadcast_to(sigma[0] ** 2, means.shape)
    other = WholeModel(given.schedule, means, equal, given.stand, (), (estimate.k, estimate.u0), prior)
    u_k, u_u0 = by_coefficient(estimate.covariance)
    of_k, of_u0 = estimate.k - other.k, estimate.u0 - other.u0
    worst = max(float(np.abs(of_k / u_k).max()), float(np.abs(of_u0 / u_u0).max()))
    if not worst <= SHARE:
        raise Disagreement(f"two computations with the prior differ by {worst:.2g} u, allowed is {SHARE:g} u")
    own = OptimalEstimate(
        *(
            estimate.k,
            estimate.u0,
            np.zeros((0, 3)),
            estimate.covariance,
            0.0,
            0.0,
            np.zeros(len(given.schedule.mountings)),
        ),
        magnification=1.0,
        largest_angle=0.0,
    )
    compare(found, given.schedule, means, found.linear[run.measured], found.gravity.delta_g[run.measured], own)
    return Comparison(of_k, of_u0, np.zeros((0, 3)))
