"""What the declared stand makes one expect of a result, source by source: of its coefficients, of its residuals, of its
gravity check.

A result carries its stand and its schedule, one of an earlier version neither: who asks tells both, and they are held
against its residuals and its covariance. Everything is linear (model.propagation.Propagation.of_means).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.documents.result import Result
from tumble.errors import UsageError
from tumble.estimators import COEFFICIENTS, OPTIMAL
from tumble.model import coefficients
from tumble.model.coefficients import linear_outputs
from tumble.model.errors import NOISE
from tumble.model.geometry import built_in, ideal_force
from tumble.model.optimal import NOISE_FLOOR_G
from tumble.model.propagation import SHOWN, Propagation
from tumble.schedule import BUILT_IN, Schedule
from tumble.solving.result import as_shown
from tumble.stand import PerChannel, Stand, by_channel, over, rounding_of
from tumble.terms import POWERS, Terms, expanded
from tumble.units import volts_per

_SAME = 1e-5  # of an uncertainty or of residuals: between the core's and numpy's optimal weights there is less
_ROUNDED = 1e-11  # of the largest element of K


@dataclass(frozen=True)
class Expected:
    """Standard deviations in the unit of the outputs: `coefficients`, by source, each (12,), K row by row, then U0;
    `residuals` (positions, 3); and `delta_g` (positions,), in g."""

    coefficients: dict[str, Floats]
    residuals: Floats
    delta_g: Floats

    @property
    def is_uncertain(self) -> bool:
        """Whether any source brings anything."""
        return any(u.any() for u in self.coefficients.values())


def residuals(result: Result, schedule: Schedule) -> Floats:
    """U - U0 - K a of every measured position on the ideal `schedule` of these, with further terms taken out of the
    outputs: (positions, 3), in their unit."""
    k, u0 = result.K, result.U0
    left: Floats = _linear_means(result) - ideal_force(schedule) @ k.T - u0
    return left


def measured_schedule(result: Result, given: Schedule | None = None) -> Schedule | None:
    """The measured positions of a result, in its order: those of a `given` schedule, else of the built-in one on which
    the result has the residuals that it states; None where it has them on none. Raises UsageError where the given one
    is not the result's."""
    if given is None:
        parts = (_part(result, as_shown(built_in(name), result)) for name in BUILT_IN)
        return next((part for part in parts if part is not None and _has_residuals(result, part)), None)
    part = _part(result, as_shown(given, result))
    if part is None:
        raise UsageError("schedule: not that of the result, whose positions it lacks, or uses otherwise")
    if _has_residuals(result, part) is False:
        raise UsageError("schedule: not that of the result, whose residuals are other ones on it")
    return part


def expected(result: Result, schedule: Schedule, declared: Stand, step_v: PerChannel) -> Expected:
    """On the schedule of the measured positions; `step_v`: of the converter, 0 where it is not known. Raises UsageError
    where the result has other uncertainties than the `declared` stand leaves."""
    if result.covariance is None:
        raise UsageError("stand: the result was solved without one")
    unit, k, estimator, terms = result.unit, result.K, result.estimator, terms_of(result)
    step = over(step_v, volts_per(unit))
    stand = declared.without(terms).in_unit(unit).with_step(step)
    samples = np.array([one.samples for one in result.means])
    variance, is_told = _mean_variance(result, declared.in_unit(unit), samples, step)
    if estimator == OPTIMAL:  # as its weights have it
        variance = np.maximum(variance, (NOISE_FLOOR_G * np.abs(k).max()) ** 2)
    given = Propagation(schedule, k, stand, samples, estimator, step, terms)
    brought = {
        name: [(each.T * one.sigma).T for each in given.of_means(one.derivative)]
        for name, one in given.errors(variance).items()
    }
    coefficients = {name: np.sqrt((found[:, :12] ** 2).sum(axis=0)) for name, (found, *_) in brought.items()}
    stated = np.diag(result.covariance)
    if not is_told:  # the noise is what the other sources leave
        others = sum((u**2 for name, u in coefficients.items() if name != NOISE), np.zeros(12))
        coefficients[NOISE] = np.sqrt(np.maximum(stated - others, 0.0))
    together, u = np.sqrt(sum(u**2 for u in coefficients.values())), np.sqrt(stated)
    wrong = ~np.isclose(together, u, rtol=_SAME, atol=0.0)
    if wrong.any():
        one = int(wrong.argmax())
        has, leaves = f"the result has {u[one]:.4g}", f"this one leaves {together[one]:.4g}"
        raise UsageError(f"stand: not that of the result: of u({COEFFICIENTS[one]}) {has}, {leaves}")
    # residuals of a block that is inclined are those at the inclinations that the run shows
    shown = SHOWN if given.schedule.is_inclined else ()
    parts = [one for name, one in brought.items() if name not in shown]
    of_residuals, of_delta_g = (np.sqrt(sum((part[place] ** 2).sum(axis=0) for part in parts)) for place in (1, 2))
    return Expected(coefficients, of_residuals, of_delta_g)


def terms_of(result: Result) -> Terms:
    """The further terms of a result's model."""
    return () if result.extended is None else expanded(result.extended.terms)


def _part(result: Result, schedule: Schedule) -> Schedule | None:
    """The measured positions alone; None where the schedule lacks one of them, or has them in another order or use."""
    measured = [(one.mounting, one.position, one.use) for one in result.means]
    part = schedule.part((one.mounting, one.number, one.use) in measured for one in schedule.positions)
    return part if [(one.mounting, one.number, one.use) for one in part.positions] == measured else None


def _has_residuals(result: Result, part: Schedule) -> bool | None:
    """Whether the result's are those that it states; None where it states none."""
    stated, k = result.verification.residual_rms, result.K
    if stated is None:
        return None
    unknowns = 4 + len(terms_of(result))
    found = coefficients.residual_rms(part, _linear_means(result), k, result.U0, unknowns)
    close = _ROUNDED * float(np.abs(k).max())
    return found is not None and bool(np.allclose(found, stated, rtol=_SAME, atol=close))


def _linear_means(result: Result) -> Floats:
    """What the outputs (positions, 3) are without the further terms: U0 + K a."""
    means, terms = np.array([one.mean for one in result.means]), terms_of(result)
    if not terms:
        return means
    k, volts = result.K, volts_per(result.unit)
    factors = {term: np.diag(k) if term in POWERS else np.ones(3) / volts for term in terms}
    assert result.extended is not None
    sizes = np.array([of * factors[term] for term, of in zip(terms, result.extended.values)])
    return linear_outputs(means, k, result.U0, sizes, terms)


def _mean_variance(result: Result, stand: Stand, samples: Integers, step: PerChannel) -> tuple[Floats, bool]:
    """Of the means by the noise as measured (positions, 3), where it counts for more than what `stand` declares, as
    solving.noise has it; and whether the result tells that of every single mean: that of means of unequal length it
    tells on the average, and a step that only the samples show it does not tell."""
    noise, averaged = result.noise, stand.averaged_over(samples)[:, None]
    assert noise is not None  # as every result with uncertainties tells it
    exceeds, undithered = (
        [f"u{axis}" in named for axis in "xyz"] for named in (noise.above_declared, noise.undithered)
    )
    of_means = np.zeros(3) if noise.of_means is None else noise.of_means
    by_samples = of_means**2 / averaged * exceeds
    beside = np.maximum(by_samples, stand.mean_variance(samples)) + rounding_of(step) ** 2
    knows_step = bool((by_channel(step) > 0.0).all())
    is_told = (not any(exceeds) or len(set(samples.tolist())) == 1) and (not any(undithered) or knows_step)
    return np.where(undithered, beside, by_samples), is_told
