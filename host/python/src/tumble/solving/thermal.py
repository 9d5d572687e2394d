"""Runs at several temperatures: each is solved alone, then all together by model.thermal, and decided on as one.

The rule is that of one run: the gravity check at every position with the coefficients of its temperature, the fit of
all runs to the declared stand, and the uncertainty of |a| at every attitude and every temperature of the range.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tumble.arrays import Floats
from tumble.documents.result import WorstNorm
from tumble.documents.thermal import Thermal
from tumble.errors import BadInput, UsageError
from tumble.model.coefficients import spread_attitudes, worst_norm
from tumble.model.errors import NOISE, Draws, free, of_stand, sources
from tumble.model.reliability import Reliability
from tumble.model.thermal import NotShown, ThermalFit, ThermalRun, TooAlike, fit
from tumble.model.thermal_reliability import reliability
from tumble.solving.decision import FIT, GRAVITY, UNCERTAINTY, Decision, assumed, is_shown
from tumble.solving.solution import Solution

DEGREES = {"linear": 1, "quadratic": 2}
STAND_KEPT = ("alpha1", "platform", "encoder")  # errors of the stand itself, the same in every run on it
BOLTING_KEPT = ("alpha2", "alpha3", "seat")  # of a block that stays bolted, on a stand that stays level
_LEAST_C = 1.0  # K: within less nobody needs a polynomial, and none is shown
_GRID = 9  # temperatures of the range at which |a| is looked at
_ATTITUDES = 2000


@dataclass(frozen=True)
class Measured:
    """A run that was solved alone, called `name`, and the `temperature_c` (positions,) of each position measured."""

    name: str
    solution: Solution
    temperature_c: Floats

    @property
    def means(self) -> Floats:
        """Of the positions measured (positions, 3)."""
        return self.solution.run.means[self.solution.run.measured]


@dataclass(frozen=True)
class ThermalSolution:
    """`fit`: of all `runs` at once; errors of the sources in `kept` are the same in all; `confidence`: at which the
    runs must fit the stand."""

    runs: tuple[Measured, ...]
    fit: ThermalFit
    kept: tuple[str, ...]
    confidence: float

    @property
    def range_c(self) -> tuple[float, float]:
        """The lowest and the highest temperature of a position."""
        felt = np.concatenate([one.temperature_c for one in self.runs])
        return float(felt.min()), float(felt.max())

    @property
    def has_stand(self) -> bool:
        """Are there uncertainties?"""
        return self._first.stand is not None

    @property
    def _first(self) -> Solution:
        return self.runs[0].solution

    @cached_property
    def delta_g(self) -> list[Floats]:
        """Formula (8), g, of every run at every position measured, with the coefficients of its temperature."""
        found = []
        for one in self.runs:
            k, u0 = self.fit.polynomials.at(one.temperature_c)
            force = np.linalg.solve(k, (one.means - u0)[..., None])[..., 0]
            found.append(((force**2).sum(axis=1) - 1.0) / 2.0)
        return found

    @cached_property
    def u_norms(self) -> list[tuple[float, WorstNorm]]:
        """Temperatures of the range, and where |a| is least certain there; none without a stand."""
        if not self.has_stand:
            return []
        thermal, grid = self.fit, np.linspace(*self.range_c, _GRID).tolist()
        return [(t, worst_norm(thermal.polynomials.at(t)[0], thermal.covariance_at(t))) for t in grid]

    @cached_property
    def decision(self) -> Decision:
        """By the rule above."""
        limit_g, factor = self._first.limit_g, self._first.coverage_factor
        worst = max((one.worst_g for _, one in self.u_norms), default=None)
        good = {
            GRAVITY: max(float(np.abs(one).max()) for one in self.delta_g) <= limit_g,
            FIT: not self.has_stand or self.fit.p >= 1.0 - self.confidence,
            UNCERTAINTY: is_shown(limit_g, factor, worst),
        }
        named = dict.fromkeys(name for one in self.runs for name in assumed(one.solution) if name != "temperature")
        positions = sum(len(one) for one in self.delta_g)
        failures = tuple(name for name, is_good in good.items() if not is_good)
        return Decision(failures, tuple(named), positions, limit_g, factor, worst)

    @cached_property
    def reliability(self) -> Reliability | None:
        """What the runs could not have shown, all together; None without a stand."""
        stand = self._first.propagation.stand
        if not self.has_stand:
            return None
        runs = [thermal_run(one) for one in self.runs]
        return reliability(runs, self.fit.polynomials, self.range_c, stand, self.confidence, self.kept)

    @cached_property
    def at_one_temperature_g(self) -> float:
        """How wrong |a| is, g, at the worst attitude and temperature of the range, with the coefficients of the
        reference temperature alone."""
        polynomials, n = self.fit.polynomials, spread_attitudes(_ATTITUDES)
        k, u0 = polynomials.at(polynomials.reference_c)
        found = []
        for t in np.linspace(*self.range_c, _GRID).tolist():
            warm_k, warm_u0 = polynomials.at(t)
            force = np.linalg.solve(k, (n @ warm_k.T + warm_u0 - u0).T)
            found.append(float(np.abs(np.linalg.norm(force, axis=0) - 1.0).max()))
        return max(found)


def decision_of(told: Thermal) -> Decision:
    """As a document tells it."""
    return Decision(
        tuple((told.pass_reason or "").split(" and ")) if told.pass_reason else (),
        told.assumes,
        sum(one.positions for one in told.runs),
        told.decision.limit_g,
        told.decision.coverage_factor,
        told.decision.u_norm_worst_g,
    )


def verdict_of(told: Thermal) -> tuple[str, str]:
    """Its word, and what stands behind it: the range, and why or under which assumptions."""
    decision, (low, high) = decision_of(told), told.range_c
    return decision.word, f" from {low:.3g} to {high:.3g} deg C{decision.reason}"


def solve_together(runs: Sequence[Measured], degree: int, kept: Collection[str], confidence: float) -> ThermalSolution:
    """Of runs that were solved alone, by one stand and in one unit; T0 is the middle of the range, in whole degrees.
    Raises BadInput, UsageError."""
    units = {one.solution.run.unit for one in runs}
    if len(units) > 1:
        raise BadInput(f"outputs in {' and '.join(sorted(units))}: all runs must have one unit", runs[-1].name)
    felt = np.concatenate([one.temperature_c for one in runs])
    low, high = float(felt.min()), float(felt.max())
    if high - low < _LEAST_C:
        raise UsageError(f"--temperature: all at {low:.4g} to {high:.4g} deg C: runs {_LEAST_C:g} K apart or more")
    prepared = [thermal_run(one) for one in runs]
    if not all((one.found[NOISE].sigma > 0.0).all() for one in prepared):  # nobody knows that of all: they count alike
        prepared = [replace(one, found={**one.found, NOISE: _with_equal_noise(one.found[NOISE])}) for one in prepared]
    try:
        found = fit(prepared, degree, float(np.round((low + high) / 2.0)), kept)
    except NotShown as error:
        span = f"{low:.4g} to {high:.4g} deg C"
        needed = f"; {degree + 1} distinct temperatures or more are needed, these are {span}"
        raise UsageError(f"--temperature: {error}{needed if isinstance(error, TooAlike) else ''}") from None
    return ThermalSolution(tuple(runs), found, tuple(kept), confidence)


def _with_equal_noise(noise: Draws) -> Draws:
    return replace(noise, sigma=np.ones_like(noise.sigma))


def thermal_run(one: Measured) -> ThermalRun:
    """Its fit positions, with the errors of its stand."""
    given, variance = one.solution.propagation, one.solution.mean_variance
    fitted = given.schedule.fit_indices
    schedule = given.schedule.fitted
    stand = given.stand.with_step(given.step)
    found = sources(schedule, given.k, stand, given.samples[fitted], variance[fitted])
    found |= of_stand(schedule, given.k, stand, free(stand, schedule))
    return ThermalRun(schedule, one.means[fitted], one.temperature_c[fitted], found)
