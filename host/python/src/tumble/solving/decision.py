"""The decision rule: may a calibration be called good, and where? (docs/method.md, "The decision rule")

Three questions, each with its own answer: do the measured positions meet the limit, does the run fit the declared
stand, and is the limit met at every attitude, as far as the uncertainties say? PASS needs all that can be asked. Where
the first two are good and the third is not, conformity is not shown, which is no PASS. Without a declared stand nobody
knows an uncertainty: then PASS holds at the measured positions only.

In this order: what a result rests on (ASSUMPTIONS), the decision (decide), and what would show a limit that the
uncertainties do not show (would_show).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tumble import core
from tumble.arrays import Floats
from tumble.defaults import DEFAULT_COVERAGE_FACTOR
from tumble.documents.result import Remedy, Result
from tumble.errors import UsageError, listed
from tumble.estimators import COEFFICIENTS, NORM, OPTIMAL
from tumble.model import norm
from tumble.model.coefficients import worst_norm
from tumble.model.geometry import built_in
from tumble.model.propagation import Propagation
from tumble.model.reliability import moved_by_a_seat, seat_is_unseen, unseen_patterns
from tumble.schedule import Schedule
from tumble.stand import Stand
from tumble.terms import Terms
from tumble.units import on_its_side

if TYPE_CHECKING:  # whoever reads a result solves none
    from tumble.solving.solution import Solution

Coefficients = tuple[str, ...]
NO_UNIT = "the run file names no unit: outputs taken for volts (--unit V, or ux [V] in its header)"
_FEWEST_TO_TEST = 4  # samples: two lengths of blocks
_EXPECTED_RAD = 1e-4  # of a seat or a platform that nobody declares
_RAISED = 1.1  # u is by it, before a coefficient is marked
_COUNTS = 0.1  # of the largest change, where no u is known: less is the block's own misalignment
_ROUNDING = 1e-9  # of the largest change: less is none


@dataclass(frozen=True)
class Assumption:
    """`phrase`: what is assumed, to stand behind "assuming"; `why`: in a few words; `mark`: of a coefficient that rests
    on it; empty where all do."""

    phrase: str
    why: str
    mark: str = ""


ASSUMPTIONS: Mapping[str, Assumption] = {
    "seat": Assumption("a square seat", "no position shows the block's tilt against the axis", "*"),
    "means": Assumption("0.2 mg of noise in each mean", "each has one row, and no noise_v says more (--stand)"),
    "hands": Assumption("faces laid to 3 mrad", "nobody declares how level they lay, nor the drift (--stand)"),
    "frame": Assumption(
        "a frame of the block's own",
        "|a| does not show how x, y, z are turned against its seat: K_xy, K_xz, K_yz are 0 by convention",
    ),
    "growth": Assumption("the stated growth", "the last calibration of the block is in them (--prior)"),
    "linear": Assumption("linearity", "the positions do not show all higher orders of the block", "^"),
    "order": Assumption("nothing exchanged or reversed (it looks so)", "no [block] says that its axes are such"),
    "incline": Assumption(
        "the stated direction of inclination", "no [block] says the sign of the scale that an exchange turns"
    ),
    "unit": Assumption("volts", "the run file names no unit (--unit)"),
    "white_noise": Assumption("white noise", "too few samples at a position to test it"),
    "undithered": Assumption("independent rounding errors", "all samples of a position round alike"),
    "temperature": Assumption("one temperature", "K and U0 hold at that of the run, which is unknown"),
}


def rests_on_a_seat(schedule: Schedule, k: Floats, stand: Stand | None, terms: Terms = ()) -> bool:
    """Whether the stand declares no tilt of the block against the axis, and the fit positions show none. `terms`:
    further ones of the model."""
    return (stand is None or not stand.declares_seat) and seat_is_unseen(schedule, k, terms)


def assumed(solution: Solution) -> dict[str, Coefficients]:
    """What a solution rests on, by name and in the order of ASSUMPTIONS, and the coefficients that do; none where all
    do."""
    found, run, schedule = solution.found, solution.run, solution.measured_schedule
    rests_on: dict[str, Coefficients] = {}
    linear = "least_squares" if found.estimator == OPTIMAL else found.estimator  # what is most like `optimal`
    gains = None if solution.propagation.prior is None else solution.propagation.gains
    if found.estimator != NORM and rests_on_a_seat(schedule, found.k, solution.stand, found.terms):
        # those whose uncertainty an undeclared tilt of a size to be expected would raise by a tenth or more
        stated = solution.stated or solution.scatter_alone
        variance = np.zeros(12) if stated is None else np.diag(stated.covariance)[:12]
        moved = np.array(list(moved_by_a_seat(schedule, found.k, linear, gains).values()))
        least_rad = _EXPECTED_RAD * moved.max() * (_COUNTS if stated is None else _ROUNDING)
        raised = (_EXPECTED_RAD * moved) ** 2 > np.maximum((_RAISED**2 - 1.0) * variance, least_rad**2)
        rests_on["seat"] = tuple(COEFFICIENTS[index] for index in np.flatnonzero(raised.any(axis=0)))
    if unseen := unseen_patterns(schedule, found.k, linear, gains):
        moved_k = np.any(list(unseen.values()), axis=0).ravel()
        rests_on["linear"] = tuple(COEFFICIENTS[index] for index in np.flatnonzero(moved_k))
    whole = {
        "frame": found.estimator == NORM,
        "growth": solution.prior is not None and solution.prior.used,
        "hands": found.estimator != NORM and solution.stand is not None and solution.brought_stand,
        "means": solution.stand is not None and solution.brought_stand and solution.noise.measured is None,
        "order": solution.is_out_of_order,
        "incline": solution.inclinations is not None and not solution.knows_signs,
        "unit": not run.unit_told,
        "white_noise": run.samples.max() < _FEWEST_TO_TEST,
        "undithered": solution.noise.undithered.any(),
        "temperature": run.temperature is None,
    }
    return rests_on | {name: () for name, is_assumed in whole.items() if is_assumed}


def marks(assumes: Mapping[str, Iterable[str]]) -> dict[str, str]:
    """By coefficient, the marks of all that it rests on; `assumes`: as `assumed` gives it, or a document's
    `assumed_for`. Names of a later version have none."""
    found: dict[str, str] = {}
    for name, coefficients in assumes.items():
        for coefficient in coefficients if name in ASSUMPTIONS else ():
            found[coefficient] = found.get(coefficient, "") + ASSUMPTIONS[name].mark
    return found


def phrase(names: Iterable[str]) -> str:
    """Behind a verdict, such as ", assuming a square seat"; empty for none. Names of a later version stay as they
    are."""
    phrases = [ASSUMPTIONS[name].phrase if name in ASSUMPTIONS else name for name in names]
    listed = [*filter(None, [", ".join(phrases[:-1])]), *phrases[-1:]]
    return f", assuming {' and '.join(listed)}" if phrases else ""


GRAVITY, FIT, UNCERTAINTY = "gravity", "fit", "uncertainty"
_NAMES = {GRAVITY: "the gravity check", FIT: "the fit to the declared stand", UNCERTAINTY: "the uncertainty"}
PASS, NOT_SHOWN, FAIL = "PASS", "NOT SHOWN", "FAIL"
EVERYWHERE, AT_POSITIONS = "everywhere", "measured positions"


@dataclass(frozen=True)
class Decision:
    """`failures`: of GRAVITY, FIT and UNCERTAINTY, in this order; `assumes`: what the result rests on, by name;
    `positions`: how many were measured; `u_norm_g`: the worst standard uncertainty of |a|, None without a stand."""

    failures: tuple[str, ...]
    assumes: tuple[str, ...]
    positions: int
    limit_g: float
    coverage_factor: float
    u_norm_g: float | None

    @classmethod
    def of(cls, result: Result) -> Decision:
        """As a document tells it; one that is older than the rule stays as it was."""
        told, worst = result.decision, result.u_norm_g
        reason = result.pass_reason or (None if result.passed else GRAVITY)
        return cls(
            failures=() if reason is None else tuple(reason.split(" and ")),
            assumes=result.assumes,
            positions=len(result.verification.delta_g_g),
            limit_g=result.verification.limit_g,
            coverage_factor=DEFAULT_COVERAGE_FACTOR if told is None else told.coverage_factor,
            u_norm_g=(None if worst is None else worst.worst_g) if told is None else told.u_norm_worst_g,
        )

    @property
    def passed(self) -> bool:
        """Whether nothing fails."""
        return not self.failures

    @property
    def is_not_shown(self) -> bool:
        """Whether nothing but the uncertainty stands in the way."""
        return self.failures == (UNCERTAINTY,)

    @property
    def scope(self) -> str:
        """Where it holds."""
        return AT_POSITIONS if self.u_norm_g is None else EVERYWHERE

    @property
    def word(self) -> str:
        """In capitals."""
        return PASS if self.passed else NOT_SHOWN if self.is_not_shown else FAIL

    @property
    def reason(self) -> str:
        """What stands behind the word, beginning with what separates them; empty for a PASS that rests on nothing."""
        if self.is_not_shown:
            return f": {self.comparison}"
        if not self.passed:
            return f": {listed([_NAMES.get(one, one) for one in self.failures])}"
        rests_on = phrase(self.assumes)
        return f"{self.where};{rests_on.removeprefix(',')}" if self.where and rests_on else self.where + rests_on

    @property
    def where(self) -> str:
        """Behind PASS without a stand; else empty, as it holds everywhere."""
        return f"{self.only}: no stand declared, no uncertainty elsewhere" if self.only else ""

    @property
    def only(self) -> str:
        """Where a PASS holds, in short; empty for everywhere."""
        return "" if self.scope == EVERYWHERE else f" at the {self.positions} measured positions only"

    @property
    def comparison(self) -> str:
        """Of the uncertainty with the limit, such as "3 u(|a|) is up to 0.00045 g, limit 0.0003 g"."""
        if self.u_norm_g is None:
            return "no uncertainty, as no stand is declared"
        reach = self.coverage_factor * self.u_norm_g
        shown = on_its_side(reach, self.limit_g)
        limit = on_its_side(self.limit_g, float(shown), 6)
        return f"{self.coverage_factor:g} u(|a|) is up to {shown} g, limit {limit} g"

    @property
    def sentence(self) -> str:
        """Word and reason, as reports and exports have them; a terminal has them too, unless it is a PASS with figures
        (cli.output._verdict_line)."""
        return self.word + self.reason


def complaints_of_result(result: Result) -> list[str]:
    """Of a result as it is read: what whoever uses its coefficients should know first."""
    found, check = [], result.verification
    if not check.passed:
        sizes = f"largest error {on_its_side(check.max_abs_delta_g_g, check.limit_g)} g, limit {check.limit_g:g} g"
        found.append(f"the gravity check FAILED: {sizes}")
    decision = Decision.of(result)
    if decision.is_not_shown:
        found.append(f"{decision.sentence}: at some attitudes the coefficients may be off by more")
    if result.warnings is not None:
        return found + [one for one in result.warnings if one != NO_UNIT]  # which `assumes` tells
    fit = result.fit  # of a result that is older than its warnings
    if result.stand_doubts or (fit is not None and not fit.fits):
        found.append("the run does not fit the stand file: the uncertainties are too small")
    elif fit is not None and fit.explanations:
        found.append("the run shows what the stand file does not declare: the uncertainties are too small")
    return found


def is_shown(limit_g: float, coverage_factor: float, u_norm_g: float | None) -> bool:
    """Whether the limit is met at every attitude, as far as a worst u(|a|) says; where nobody knows one, nothing is
    claimed."""
    return u_norm_g is None or coverage_factor * u_norm_g <= limit_g


def decide(solution: Solution) -> Decision:
    """By the rule."""
    u_norm_g = None if solution.u_norm is None else solution.u_norm.worst_g
    limit_g, factor = solution.limit_g, solution.coverage_factor
    good = {
        GRAVITY: solution.found.gravity.passed,
        FIT: solution.fit is None or solution.fit.fits,
        UNCERTAINTY: is_shown(limit_g, factor, u_norm_g),
    }
    failures = tuple(name for name, is_good in good.items() if not is_good)
    positions = int((solution.run.samples > 0).sum())
    return Decision(failures, tuple(assumed(solution)), positions, limit_g, factor, u_norm_g)


_THIRD = "three_mountings"
_STEEP_DEG = 45.0
_MOST_TIMES = 1000.0  # as many samples: nobody waits longer
_BISECTIONS = 12
_DRAWS = 10
_ROUNDED = 1.01  # a factor is told with three digits, and rounded up
_NEXT_RUN = 0.9  # of the limit, to be reached by more samples: the noise of another run comes out differently
_BY_HAND = 0.75  # the same of poses that nobody knows: hands spread them otherwise every time, and never evenly
_PHRASES = {
    "inclinations": "inclining further, to {:g} deg either way",
    "estimator": "--estimator {}",
    "samples": "{} samples a position",
    "poses": "{} poses, spread over all directions",
    "mountings": f"a third mounting (--schedule {_THIRD})",
    "stand": "a stand and noise {} times better",
    "converter": "a stand, noise and converter {} times better",
}


@dataclass(frozen=True)
class Question:
    """What would show a limit: other weights for the same run, more samples, a third mounting, a better stand. Each is
    tried on the model of the run and told with what it reaches. Of a run, done or planned: how errors reach its
    estimate, `variance` (positions, 3) of the means by the noise as it was measured (0: as declared), of it `rounding`
    (3,) that no more samples average away, and the rule."""

    given: Propagation
    variance: Floats
    rounding: Floats
    limit_g: float
    coverage_factor: float
    planned: Schedule | None = None  # of a run of inclinations: with those that were set

    def reach_g(self, times: float = 1.0, schedule: Schedule | None = None, estimator: str | None = None) -> float:
        """With so many `times` the samples, other positions that are measured alike, another estimator."""
        given = self.given
        samples, variance = given.stand.averaged_over(given.samples), self.variance
        if schedule is not None:
            count = len(schedule.positions)
            samples, variance = np.full(count, round(samples.mean())), np.tile(variance.mean(axis=0), (count, 1))
        samples = np.maximum(1, np.ceil(times * samples)).astype(int)
        other = replace(
            given,
            schedule=schedule or given.schedule,
            stand=replace(given.stand, samples=1),  # the rows now say of how many a mean is
            samples=samples,
            estimator=estimator or given.estimator,
        )
        covariance = other.covariance((variance - self.rounding) / times + self.rounding)
        return self.coverage_factor * worst_norm(given.k, covariance, given.terms).worst_g

    def answers(self) -> list[Remedy]:
        """What would show it, the cheapest first; a better stand always does."""
        given, limit_g, found = self.given, self.limit_g, []
        if self.planned is not None:
            steeper, deg = _inclined_further(self.planned)
            if (reach_g := self._tried(schedule=steeper)) <= limit_g:
                found.append(Remedy("inclinations", deg, reach_g))
        own = given.estimator in (NORM, OPTIMAL)
        reach_g = np.inf if own else self._tried(estimator=OPTIMAL)
        if reach_g <= limit_g:
            found.append(Remedy("estimator", OPTIMAL, reach_g))
        if given.estimator == NORM and (poses := self._more_poses()) is not None:
            found.append(poses)
        wanted_g = (_BY_HAND if given.estimator == NORM else _NEXT_RUN) * limit_g
        if self._tried(times=_MOST_TIMES) <= wanted_g:
            low, high = 1.0, _MOST_TIMES
            for _ in range(_BISECTIONS):
                middle = (low * high) ** 0.5
                low, high = (low, middle) if self.reach_g(middle) <= wanted_g else (middle, high)
            samples = given.stand.averaged_over(given.samples)
            found.append(Remedy("samples", int(np.ceil(high * samples.max())), self.reach_g(high)))
        reach_g = np.inf if len(given.schedule.mountings) > 2 else self._tried(schedule=built_in(_THIRD))
        if reach_g <= limit_g:
            found.append(Remedy("mountings", 3, reach_g))
        better = self.reach_g() / limit_g * _ROUNDED
        return [*found, Remedy("converter" if self.rounding.any() else "stand", better, limit_g)]

    def _more_poses(self) -> Remedy | None:
        """The fewest that are enough at as many samples, in nine of ten sessions by hand; None where as many as a
        schedule holds are not."""
        rng = np.random.default_rng(0)
        drawn = [_laid_by_hand(rng) for _ in range(_DRAWS)]

        def reach_g(count: int) -> float:
            poses = norm.of_poses([(number, 1) for number in range(1, count + 1)])
            return sorted(self._tried(schedule=norm.as_seen(poses, one[:count])) for one in drawn)[-2]

        low, high = len(self.given.schedule.positions), core.MAX_POSITIONS
        if reach_g(high) > self.limit_g:
            return None
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if reach_g(middle) <= self.limit_g else (middle, high)
        return Remedy("poses", high, reach_g(high))

    def _tried(self, **changes: Any) -> float:
        """Infinite where there is no such estimate."""
        try:
            return self.reach_g(**changes)
        except (UsageError, core.CoreRefusal, np.linalg.LinAlgError):
            return np.inf


def _laid_by_hand(rng: np.random.Generator) -> Floats:
    """Directions (as many as a schedule holds, 3), each the farthest from those before of a few that came to mind."""
    found = np.zeros((core.MAX_POSITIONS, 3))
    for place in range(len(found)):
        few = rng.normal(size=(3, 3))
        few /= np.linalg.norm(few, axis=1, keepdims=True)
        found[place] = few[(few @ found[:place].T).max(axis=1, initial=-1.0).argmin()]
    return found


def would_show(solution: Solution) -> list[Remedy]:
    """Of a solution whose uncertainty is beyond the limit."""
    variance, rounding = solution.mean_variance, solution.noise.rounding**2
    rule = solution.limit_g, solution.coverage_factor
    planned = None if solution.inclinations is None else solution.schedule.part(solution.run.measured)
    return Question(solution.propagation, variance, rounding, *rule, planned).answers()


def _inclined_further(planned: Schedule) -> tuple[Schedule, float]:
    """As `planned`, or further until the steepest inclination is enough for most stands; with its angle, deg."""
    steepest = max(abs(one.tilt_deg) for one in planned.mountings)
    times = max(1.0, _STEEP_DEG / steepest)
    mountings = tuple(replace(one, tilt_deg=times * one.tilt_deg) for one in planned.mountings)
    return replace(planned, mountings=mountings), round(times * steepest, 1)


def remedies_text(remedies: Sequence[Remedy], limit_g: float) -> str:
    """All, such as "It would be shown by --estimator optimal (0.00011 g) or ..."; empty for none. A stand so many times
    better always helps."""
    told = []
    for one in remedies:
        is_better = one.change in ("stand", "converter")
        said = _PHRASES[one.change].format(f"{one.to:.3g}" if is_better else one.to)
        told.append(said if is_better else f"{said} ({on_its_side(one.reach_g, limit_g)} g)")
    return "It would be shown by " + " or ".join(told) if told else ""
