"""The quickest schedule for a limit or a worst u(|a|), beside what the built-in schedules take for the same.

A limit is kept when a run passes, and |a| is within the limit at every attitude, with the probability asked for. That
is a worst u(|a|) too, another for each schedule; it is found by trying.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tumble.core import MAX_SAMPLES
from tumble.errors import UsageError
from tumble.model.geometry import built_in
from tumble.model.reliability import Reliability
from tumble.planning.case import Case
from tumble.planning.duration import Pace
from tumble.planning.model_cost import model_cost
from tumble.planning.norm_spread import NormSpread
from tumble.planning.promise import Promise, promise
from tumble.planning.schedule_search import (
    Timed,
    fewest_at_some,
    held_to,
    measured_with,
    quickest,
    worst_norm_of,
)
from tumble.schedule import Schedule
from tumble.solving.extended import confused
from tumble.solving.further import Further
from tumble.workers.over import ALONE, Team

BESIDE = ("paper", "three_mountings", "diagonal")
_STEPS = 8
_PARTS = (1.0, 0.99, 0.95)  # of the goal to search with: what is found for it by a few attitudes may just miss it


@dataclass(frozen=True)
class Goal:
    """What a schedule is for: `norm_g`, a worst u(|a|), or else the case's limit with a `probability`; the
    `estimator`."""

    norm_g: float | None
    probability: float
    estimator: str


@dataclass(frozen=True)
class Planned:
    """`best`, and `beside` it by name; None where a schedule does not get there. Of the best: the worst u(|a|), g, at
    which attitude, the promise, what its runs will not show, and what further terms of the model cost."""

    case: Case
    goal: Goal
    pace: Pace
    best: Timed
    beside: dict[str, Timed | None]
    u_norm_g: float
    attitude: list[float]
    promise: Promise
    unseen: Reliability
    further: Further | None = None


def plan_schedule(
    case: Case,
    goal: Goal,
    pace: Pace,
    step_deg: float,
    most_mountings: int,
    progress: Callable[..., None],
    team: Team = ALONE,
) -> Planned:
    """Whatever the `team`. `progress` as of `quickest`, of which there may be several. Raises UsageError where no
    schedule gets there."""

    def search(norm_g: float) -> Timed | None:
        for part in _PARTS:
            found = quickest(case, goal.estimator, part * norm_g, pace, step_deg, most_mountings, progress, team)
            reached = None if found is None else reaching(case, goal, found.schedule, pace)
            if found is None or reached is not None:
                return reached
        return None

    beside = {name: reaching(case, goal, built_in(name), pace) for name in BESIDE}
    best = search(_first_norm(case, goal, beside))
    if best is not None and goal.norm_g is None:
        again = search(best.norm_g)
        best = again if again is not None and again.duration.total < best.duration.total else best
    if best is None:
        wanted = f"{case.limit_g:g} g" if goal.norm_g is None else f"a worst u(|a|) of {goal.norm_g:g} g"
        why = "" if case.rounding_sentence is None else f". {case.rounding_sentence}"
        raise UsageError(f"unreachable: no schedule of at most {most_mountings} mountings reaches {wanted} here{why}")
    chosen = measured_with(case, best)
    u_norm_g, attitude = worst_norm_of(chosen, goal.estimator)
    promised = promise(chosen, goal.estimator, goal.probability)
    unseen, further = chosen.reliability(goal.estimator), model_cost(chosen, goal.estimator)
    return Planned(case, goal, pace, best, beside, u_norm_g, attitude, promised, unseen, further)


def _first_norm(case: Case, goal: Goal, beside: dict[str, Timed | None]) -> float:
    """To search with: the strictest that a built-in schedule is held to, as a limit asks for about the same of all."""
    if goal.norm_g is not None:
        return goal.norm_g
    return min((timed.norm_g for timed in beside.values() if timed is not None), default=case.limit_g / 3.0)


def reaching(case: Case, goal: Goal, schedule: Schedule, pace: Pace) -> Timed | None:
    """A schedule with the fewest samples that reach the goal; None if none do, or it does not tell further terms."""
    if case.terms and confused(schedule, case.terms) is not None:
        return None
    if goal.norm_g is not None:
        return held_to(case, goal.estimator, schedule, goal.norm_g, pace)
    spread = NormSpread(case, schedule, goal.estimator)
    everything = np.ones(len(schedule.positions), dtype=bool)

    def growth(samples: int) -> float:
        timed = Timed(schedule, samples, 0.0, pace.duration(schedule, samples))
        return promise(measured_with(case, timed), goal.estimator, goal.probability).growth

    samples, room = MAX_SAMPLES, growth(MAX_SAMPLES)
    for _ in range(_STEPS if room >= 1.0 else 0):  # a worst u(|a|) as much larger as the errors have room to grow
        before, norm_g = samples, float(spread.worst(everything[None], samples)[0]) * room
        samples = fewest_at_some(spread, everything, norm_g) or MAX_SAMPLES
        room = growth(samples)
        if samples == before:
            break
    while room < 1.0 and samples < MAX_SAMPLES:
        samples = min(MAX_SAMPLES, samples + 1 + samples // 100)
        room = growth(samples)
    norm_g = spread.exact(everything, samples)
    return Timed(schedule, samples, norm_g, pace.duration(schedule, samples)) if room >= 1.0 else None
