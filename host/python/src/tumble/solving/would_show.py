"""What would show that a limit is met where the uncertainties do not allow it: other weights for the same run, more
samples, a third mounting, a better stand. Each is tried on the model of the run and told with what it reaches."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tumble import core
from tumble.arrays import Floats
from tumble.documents.result import Remedy
from tumble.errors import UsageError
from tumble.estimators import OPTIMAL
from tumble.model.geometry import built_in
from tumble.model.norm import worst_norm
from tumble.model.propagation import Propagation
from tumble.rounding import on_its_side
from tumble.schedule import Schedule
from tumble.solving.solution import Solution

_THIRD = "three_mountings"
_MOST_TIMES = 1000.0  # as many samples: nobody waits longer
_BISECTIONS = 12
_ROUNDED = 1.01  # a factor is told with three digits, and rounded up
_PHRASES = {
    "estimator": "--estimator {}",
    "samples": "{} samples a position",
    "mountings": f"a third mounting (--schedule {_THIRD})",
    "stand": "a stand and noise {} times better",
    "converter": "a stand, noise and converter {} times better",
}


@dataclass(frozen=True)
class Question:
    """Of a run, done or planned: how errors reach its estimate, `variance` (positions, 3) of the means by the noise as
    it was measured (0: as declared), of it `rounding` (3,) that no more samples average away, and the rule."""

    given: Propagation
    variance: Floats
    rounding: Floats
    limit_g: float
    coverage_factor: float

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
        return self.coverage_factor * worst_norm(given.k, covariance, given.terms).worst

    def answers(self) -> list[Remedy]:
        """What would show it, the cheapest first; a better stand always does."""
        told = [one for one in (self._weights(), self._samples(), self._mounting()) if one is not None]
        better = self.reach_g() / self.limit_g * _ROUNDED
        return [*told, Remedy("converter" if self.rounding.any() else "stand", better, self.limit_g)]

    def _weights(self) -> Remedy | None:
        reach_g = np.inf if self.given.estimator == OPTIMAL else self._tried(lambda: self.reach_g(estimator=OPTIMAL))
        return Remedy("estimator", OPTIMAL, reach_g) if reach_g <= self.limit_g else None

    def _samples(self) -> Remedy | None:
        if self._tried(lambda: self.reach_g(_MOST_TIMES)) > self.limit_g:
            return None
        low, high = 1.0, _MOST_TIMES
        for _ in range(_BISECTIONS):
            middle = (low * high) ** 0.5
            low, high = (low, middle) if self.reach_g(middle) <= self.limit_g else (middle, high)
        samples = self.given.stand.averaged_over(self.given.samples)
        return Remedy("samples", int(np.ceil(high * samples.max())), self.reach_g(high))

    def _mounting(self) -> Remedy | None:
        schedule = built_in(_THIRD)
        if len(self.given.schedule.mountings) > 2:
            return None
        reach_g = self._tried(lambda: self.reach_g(schedule=schedule))
        return Remedy("mountings", 3, reach_g) if reach_g <= self.limit_g else None

    def _tried(self, reach: Callable[[], float]) -> float:
        """Infinite where there is no such estimate."""
        try:
            return reach()
        except (UsageError, core.CoreRefusal, np.linalg.LinAlgError):
            return np.inf


def would_show(solution: Solution) -> list[Remedy]:
    """Of a solution whose uncertainty is beyond the limit."""
    variance, rounding = solution.noise.mean_variance[solution.run.measured], solution.noise.rounding**2
    rule = solution.limit_g, solution.coverage_factor
    return Question(solution.propagation, variance, rounding, *rule).answers()


def in_words(remedies: Sequence[Remedy], limit_g: float) -> str:
    """All, such as "It would be shown by --estimator optimal (0.00011 g) or ..."; empty for none."""
    return "It would be shown by " + " or ".join(_told(remedies, limit_g)) if remedies else ""


def _told(remedies: Sequence[Remedy], limit_g: float) -> Iterator[str]:
    """A stand so many times better always helps."""
    for one in remedies:
        is_better = one.change in ("stand", "converter")
        phrase = _PHRASES[one.change].format(f"{one.to:.3g}" if is_better else one.to)
        yield phrase if is_better else f"{phrase} ({on_its_side(one.reach_g, limit_g)} g)"
