"""Is a stand what it is declared to be, and good enough? Its sources of error as runs show them, against limits.

Every source is judged by how likely its limit makes what was seen. A limit is a standard deviation sigma:

- of angles that one run shows once (systematic): with x of standard uncertainty u, x^2 / (sigma^2 + u^2) is
  chi-squared, one degree of freedom for each independent draw; as u^2 is itself estimated from the run, an F takes its
  place;
- of the set angles: chi-squared of the residuals that they move;
- of the noise: chi-squared of the pooled scatter.

Above the quantile at the confidence p of one verdict the source does not meet its limit, below the one at 1 - p it
meets it, between them this much data cannot tell. One draw can hardly ever show that a limit is met, and it says so.
The confidence asked for is that of the whole check: p is its fifth root, so that a stand which is just what it is
declared to be fails by chance in one check of twenty at 95 %, and not in one of twenty for each of the five sources.

What the acceptance limit needs of a stand is a statement on the errors that it has now: for systematic angles the
interval x +- t u (Student) against three times the required sigma, because the acceptance limit is one of three sigma.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum

import numpy as np

from tumble import reference
from tumble.core import CoreSchedule
from tumble.core.stand_seen import RunSeen, noise as pooled_noise
from tumble.distributions import chi_squared_quantile, f_quantile, student_quantile
from tumble.solving.crosscheck import compare_seen
from tumble.solving.solution import Solution
from tumble.solving.stand_seen import StandSeen, look, own_variance
from tumble.stand import COMMON, Stand, volts_per

SYSTEMATIC = ("alpha1_rad", "alpha2_plus_alpha3_rad", "alpha3_difference_rad")
SOURCES = (*SYSTEMATIC, "alpha4_rad", "noise_v")
NEED_SIGMAS = 3.0  # a requirement is a standard deviation; the acceptance limit allows three of them
_SMALLEST = 1e-15
_DOUBT = 0.999
_CLOSE = 1e-4


class Verdict(str, Enum):
    """What the runs say about a source and its limit."""

    MEETS = "meets"
    DOES_NOT_MEET = "does not meet"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True)
class Judgement:
    """One source. `value` and `u` as the runs show it (None: they do not); `limit`: a standard deviation, None:
    nothing is asked; `low`, `high`: the standard deviations that what was seen is compatible with, two-sided."""

    value: float | None
    u: float | None
    limit: float | None
    verdict: Verdict
    chi_squared: float | None = None
    freedom: float | None = None
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class RunView:
    """One run, solved, and the stand as it shows it by itself: the declared stand's word is not taken."""

    file: str
    solution: Solution
    seen: StandSeen
    shown: RunSeen
    variance: np.ndarray  # of each mean by its noise, in the unit of the outputs squared

    @classmethod
    def of(cls, solution: Solution, schedule: CoreSchedule, file: str) -> RunView:
        """Look at a solved run, core and witness. Raises Disagreement."""
        view, run = cls.by_core(solution, schedule, file), solution.run
        witness = reference.RunSeen(solution.measured_schedule, run.means[run.measured], solution.found.k)
        seen_by_both = run.samples[run.measured], run.scatter[run.measured], solution.stand.in_unit(run.unit)
        compare_seen(view.seen, witness, *seen_by_both, trust_stand=False)
        return view

    @classmethod
    def by_core(cls, solution: Solution, schedule: CoreSchedule, file: str = "") -> RunView:
        """Likewise, by the core alone."""
        run, found = solution.run, solution.found
        stand = solution.stand.in_unit(run.unit)
        shown = RunSeen(schedule, run.means, run.measured, found.k, found.u0)
        noise = pooled_noise(run.samples, run.scatter)
        seen = look(shown, noise, run.samples, stand, trust_stand=False)
        return cls(file, solution, seen, shown, own_variance(noise, run.samples, stand))

    def angle(self, source: str):
        """A systematic angle with its standard uncertainty; None where the run cannot tell."""
        return self.seen.augmented[source.removesuffix("_rad")]

    @property
    def noise_freedom(self) -> int:
        """Degrees of freedom of the pooled noise."""
        samples = self.solution.run.samples
        return 3 * int((samples[samples > 1] - 1).sum())


@dataclass(frozen=True)
class Limits:
    """Standard deviations by source as in SOURCES; noise in volts, infinite: no limit. `shared`: of a systematic
    source, the part of its variance that is the same in all runs of a stand that was levelled once for all."""

    sigma: dict[str, float]
    shared: dict[str, float]

    @classmethod
    def declared(cls, stand: Stand, mountings: int) -> Limits:
        """What a stand file declares, for a schedule with fit positions in so many mountings."""
        sources = ("axis_tilt", "level", "remount", "angle", "noise")
        return cls.of([stand.sigma(source) for source in sources], stand.remounting, mountings)

    @classmethod
    def needed(cls, sigma: Iterable[float], remounting: str, mountings: int) -> Limits:
        """What an acceptance limit needs, of the same five. Nothing of the yaws' difference where they are declared
        common: whether they are is asked of the declaration."""
        limits = cls.of(sigma, remounting, mountings)
        if remounting != COMMON:
            return limits
        return cls({**limits.sigma, "alpha3_difference_rad": math.inf}, limits.shared)

    @classmethod
    def of(cls, sigma: Iterable[float], remounting: str, mountings: int) -> Limits:
        """Of what can be seen, from those of alpha1, alpha2, alpha3, alpha4 and noise."""
        alpha1, alpha2, alpha3, alpha4, noise = map(float, sigma)
        yaw = alpha3 if remounting == COMMON else alpha3 / math.sqrt(mountings)
        both = math.hypot(alpha2, yaw)
        seen = {
            "alpha1_rad": alpha1,
            "alpha2_plus_alpha3_rad": both,
            "alpha3_difference_rad": 0.0 if remounting == COMMON else math.sqrt(2.0) * alpha3,
            "alpha4_rad": alpha4,
            "noise_v": noise,
        }
        level = alpha2**2 / both**2 if 0.0 < both < math.inf else 1.0
        return cls(seen, {"alpha1_rad": 1.0, "alpha2_plus_alpha3_rad": level, "alpha3_difference_rad": 0.0})


@dataclass(frozen=True)
class Draws:
    """A systematic angle in every run: values `x`, standard uncertainties `u`, and the degrees of freedom of these."""

    x: np.ndarray
    u: np.ndarray
    freedom: float
    shared: float

    def chi_squared(self, sigma: float) -> float:
        """Of the angles, if their standard deviation were this; one degree of freedom for each."""
        covariance = sigma**2 * ((1 - self.shared) * np.eye(len(self.x)) + self.shared) + np.diag(self.u**2)
        return float(self.x @ np.linalg.pinv(covariance, hermitian=True) @ self.x)

    def below(self, sigma: float) -> float:
        """Degrees of freedom under the F that takes the place of chi-squared, because u is estimated.

        After Welch and Satterthwaite.
        """
        return self.freedom * float((1 + (sigma / self.u) ** 2).mean()) ** 2 if (self.u > 0.0).all() else math.inf


@dataclass(frozen=True)
class Judge:
    """Judges runs of one stand. `levelled_once`: the axis tilt is the same in all runs, and the zero of the table
    angle; else each run has its own. `ranges`: are the standard deviations that fit wanted? They take most of the
    time."""

    views: list[RunView]
    confidence: float
    levelled_once: bool
    ranges: bool = True

    @property
    def verdict_confidence(self) -> float:
        """Of one verdict, so that all of them together have `confidence`."""
        return self.confidence ** (1 / len(SOURCES))

    def judge(self, limits: Limits) -> dict[str, Judgement]:
        """Every source against a standard deviation."""
        judged = {source: self._systematic(source, limits) for source in SYSTEMATIC}
        angle, noise = self._set_angle(limits.sigma["alpha4_rad"]), self._noise(limits.sigma["noise_v"])
        return {**judged, "alpha4_rad": angle, "noise_v": noise}

    def judge_need(self, limits: Limits) -> dict[str, Verdict]:
        """Every source against what the acceptance limit needs of it, as errors that the stand has now."""
        needs = {}
        for source, limit in limits.sigma.items():
            if math.isinf(limit):
                needs[source] = Verdict.MEETS
            elif source in SYSTEMATIC:
                needs[source] = self._interval(source, NEED_SIGMAS * limit)
            else:
                needs[source] = (self._set_angle if source == "alpha4_rad" else self._noise)(limit).verdict
        return needs

    def _draws(self, source: str, shared: float) -> Draws | None:
        """What the runs show of a systematic angle. One that all runs share is one draw, known from their mean."""
        told = [(view.angle(source), view.seen.freedom) for view in self.views if view.angle(source) is not None]
        if not told:
            return None
        x, u = (np.array([getattr(angle, name) for angle, _ in told]) for name in ("value", "u"))
        freedom = sum(math.inf if own is None else own for _, own in told)
        if self.levelled_once and shared == 1.0:
            weights = 1.0 / u**2 if (u > 0.0).all() else np.ones(len(u))
            weights /= weights.sum()
            x, u = np.array([weights @ x]), np.array([math.sqrt(weights**2 @ u**2)])
        return Draws(x, u, freedom, shared if self.levelled_once else 0.0)

    def _systematic(self, source: str, limits: Limits) -> Judgement:
        limit, draws = limits.sigma[source], self._draws(source, limits.shared[source])
        if draws is None:
            return Judgement(None, None, limit, Verdict.CANNOT_TELL)
        count, square, below = len(draws.x), draws.chi_squared(limit), draws.below(limit)
        verdict = self._verdict(square, lambda p: count * f_quantile(p, count, below))
        # one draw is shown as it is, several as their root mean square
        value = float(draws.x[0]) if count == 1 else float(np.sqrt((draws.x**2).mean()))
        u = float(draws.u[0]) if count == 1 else float(np.linalg.norm(draws.x * draws.u)) / (count * (value or 1.0))
        return Judgement(value, u, limit, verdict, square, count, *self._range(draws.chi_squared, count))

    def _range(self, chi_squared: Callable[[float], float], freedom: int) -> tuple[float | None, float | None]:
        """The standard deviations that what was seen is compatible with."""
        if not self.ranges:
            return None, None
        tails = ((1 + self.confidence) / 2, (1 - self.confidence) / 2)
        low, high = (_sigma_at(chi_squared, chi_squared_quantile(p, freedom)) for p in tails)
        return low, high

    def _verdict(self, square: float, quantile) -> Verdict:
        if square > quantile(self.verdict_confidence):
            return Verdict.DOES_NOT_MEET
        return Verdict.MEETS if square < quantile(1 - self.verdict_confidence) else Verdict.CANNOT_TELL

    def _angle_chi_squared(self, sigma: float) -> tuple[float, int]:
        parts = [view.shown.angle_chi_squared(sigma, view.variance) for view in self.views]
        return sum(square for square, _ in parts), sum(freedom for _, freedom in parts)

    def _set_angle(self, limit: float) -> Judgement:
        square, freedom = self._angle_chi_squared(limit)
        if freedom == 0:
            return Judgement(None, None, limit, Verdict.CANNOT_TELL)
        seen = [view.seen for view in self.views if view.seen.alpha4 is not None]
        told = [(own.alpha4.value, own.alpha4_freedom) for own in seen]
        value = u = None
        if told:
            values, freedoms = map(np.array, zip(*told))
            value = float(np.sqrt((freedoms * values**2).sum() / freedoms.sum()))
            u = value / math.sqrt(2 * freedoms.sum())
        verdict = self._verdict(square, lambda p: chi_squared_quantile(p, freedom))
        between = self._range(lambda sigma: self._angle_chi_squared(sigma)[0], freedom)
        return Judgement(value, u, limit, verdict, square, freedom, *between)

    def _noise(self, limit: float) -> Judgement:
        told = [(view.seen.noise, view) for view in self.views if view.seen.noise is not None]
        if not told:
            return Judgement(None, None, limit, Verdict.CANNOT_TELL)
        freedoms = np.array([view.noise_freedom for _, view in told])
        values = np.array([noise.value * volts_per(view.solution.run.unit) for noise, view in told])
        square_sum, freedom = float((freedoms * values**2).sum()), int(freedoms.sum())
        value = math.sqrt(square_sum / freedom)
        square = _ratio(square_sum, limit**2)
        verdict = self._verdict(square, lambda p: chi_squared_quantile(p, freedom))
        between = self._range(lambda sigma: _ratio(square_sum, sigma**2), freedom)
        reported = square if math.isfinite(square) else None
        return Judgement(value, value / math.sqrt(2 * freedom), limit, verdict, reported, freedom, *between)

    def _interval(self, source: str, limit: float) -> Verdict:
        """Is the angle that every run has within the limit? Student's interval of the worst run decides."""
        verdicts = set()
        for view in self.views:
            angle = view.angle(source)
            if angle is None:
                return Verdict.CANNOT_TELL
            reach = student_quantile(self.verdict_confidence, view.seen.freedom or math.inf) * angle.u
            outside = abs(angle.value) - reach > limit
            inside = abs(angle.value) + reach <= limit
            verdicts.add(Verdict.DOES_NOT_MEET if outside else Verdict.MEETS if inside else Verdict.CANNOT_TELL)
        return next(v for v in (Verdict.DOES_NOT_MEET, Verdict.CANNOT_TELL, Verdict.MEETS) if v in verdicts)


def levelled_once(views: list[RunView]) -> bool:
    """Do all runs show the same axis tilt, as if the stand had not been levelled between them? In doubt they do: then a
    combined result claims less."""
    told = [view.angle("alpha1_rad") for view in views if view.angle("alpha1_rad") is not None]
    x, u = (np.array([getattr(angle, name) for angle in told]) for name in ("value", "u"))
    if len(x) < 2 or not (u > 0.0).all():
        return True
    mean = (x / u**2).sum() / (1 / u**2).sum()
    freedom = sum(view.seen.freedom or math.inf for view in views)
    square = float((((x - mean) / u) ** 2).sum())
    return square <= (len(x) - 1) * f_quantile(_DOUBT, len(x) - 1, freedom)


def _ratio(square: float, variance: float) -> float:
    if variance > 0.0:
        return square / variance
    return 0.0 if square == 0.0 else math.inf


def _sigma_at(chi_squared: Callable[[float], float], square: float) -> float:
    """The standard deviation at which a falling chi-squared has this value; 0 where it is less from the start."""
    low, high = 0.0, 1.0
    if chi_squared(low) <= square:
        return 0.0
    while chi_squared(high) > square:
        low, high = high, 8 * high
    while high - low > _CLOSE * high:
        middle = (low + high) / 2 if low > high / 16 else high / 8
        low, high = (middle, high) if chi_squared(middle) > square else (low, middle)
        if high < _SMALLEST:
            return 0.0
    return high
