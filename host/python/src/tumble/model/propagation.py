"""How the errors of a stand and the noise of the means reach an estimate, to first order.

An estimator is linear in the means, with gains G, and the errors add J s to these: so they add G J s to the
coefficients, and each source its part of the covariance.

What this leaves out (`second_order`) is the bias that squares of a stand's errors leave in an estimate.

A mean over errors of a normal law is a sum over nodes (McNamee and Stenger): none, one, or two of the errors are off by
sqrt(3) standard deviations, in either direction, the others zero. It is exact for polynomials of degree five, so it has
all half squares, and the products of two squares, which are what the optimal estimator leaves of the second order. The
outputs come from the exact geometry and go through the estimator itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.documents.result import Shift
from tumble.estimators import COEFFICIENTS, OPTIMAL
from tumble.model import inclined
from tumble.model.errors import Draws, brought, by_gains, covariance_of, exact_outputs, free, sources
from tumble.model.estimators import columns_at, gains_at
from tumble.model.geometry import ideal_force
from tumble.model.optimal import OptimalTable, optimal_covariance, optimal_table, samples_in_a_mean
from tumble.model.prior import Given, Prior
from tumble.schedule import Schedule
from tumble.stand import PerChannel, Stand
from tumble.terms import Terms

SHOWN = ("alpha1", "inclination")  # sources that a run shows of a block that is inclined as it is bolted on


@dataclass(frozen=True)
class Propagation:
    """Of an estimate on a `schedule`, all of it measured, of a block of sensitivity `k` (3, 3), with `samples`
    (positions,): rows of each, as Stand.averaged_over takes them. `stand` and the converter's `step` (0: unknown) in
    the outputs' unit; `terms`: further unknowns of the model; `prior`: what the estimate rests on beside the run, and
    the U0 (3,) that it came to. Methods raise UsageError where the schedule does not allow the estimator."""

    schedule: Schedule
    k: Floats
    stand: Stand
    samples: Integers
    estimator: str
    step: PerChannel = 0.0
    terms: Terms = ()
    prior: tuple[Prior, Floats] | None = None

    @property
    def weights(self) -> Floats:
        """Of the channels (3,), where the estimator is not told more of the stand."""
        return self.stand.weights

    @cached_property
    def table(self) -> OptimalTable:
        """The weights of `optimal`, made at `k`."""
        number = samples_in_a_mean(self.schedule, self.stand, self.samples)
        return optimal_table(self.schedule, self.k, self.stand, self.step, number, self.terms)

    @cached_property
    def gains(self) -> Floats:
        """By which the estimator finds K row by row, U0 and the sizes of further terms (12 + 3 x terms, 3 x fit
        positions)."""
        if self.prior is not None:
            return self._given.gains(self.k, self.prior[1], self.prior[0])[0]
        if self.estimator == OPTIMAL:
            return self.table.gains
        return gains_at(self.schedule, self.k, self.estimator, self.terms, self.weights)

    @property
    def _given(self) -> Given:
        return Given(self.schedule, self.stand, self.samples, self.step)

    def of_means(self, means: Floats) -> tuple[Floats, Floats, Floats]:
        """What errors of the means (draws, positions, 3) do, with D the derivatives of the outputs by the unknowns: to
        the unknowns (draws, 12 + 3 x terms), to the residuals r = dU - D G dU (draws, positions, 3), and to delta_g =
        a K^-1 r (draws, positions), g."""
        force, found = ideal_force(self.schedule), by_gains(self.schedule, self.gains)(means)
        explained = force @ np.swapaxes(found[:, :9].reshape(-1, 3, 3), 1, 2) + found[:, None, 9:12]
        left = means - explained - np.tensordot(found[:, 12:], columns_at(force, self.terms), axes=1)
        return found, left, (left * (force @ np.linalg.inv(self.k))).sum(axis=2)

    def covariance_of_inclinations(self, variance: Floats | None = None) -> Floats:
        """Of the angles at which the block was inclined, then of the zeros of the table angle there, rad, by the closed
        form: an error of the axis is what they tell."""
        by_means = inclined.gains_of_inclinations(self.schedule, self.k, self.weights)
        others = {name: one for name, one in self.errors(variance).items() if name not in SHOWN}
        return covariance_of(by_gains(self.schedule, by_means), others)

    def u_inclinations(self, variance: Floats | None = None) -> Floats:
        """Standard uncertainties (inclinations,) of those angles."""
        variances = np.diag(self.covariance_of_inclinations(variance))
        u: Floats = np.sqrt(variances[: len(variances) // 2])
        return u

    def errors(self, variance: Floats | None = None) -> dict[str, Draws]:
        """Every source of error; `variance` (positions, 3): of the means by the noise as measured, where it counts for
        more than the stand's."""
        return sources(self.schedule, self.k, self.stand.with_step(self.step), self.samples, variance)

    def simulated(self, variance: Floats | None = None) -> dict[str, Draws]:
        """Those that can be drawn for runs on this schedule. Where inclinations are not declared, `optimal` is
        linearised at those that a run shows, so what moves these is no error of a run at them."""
        follows = self.estimator == OPTIMAL and free(self.stand, self.schedule)
        shown = SHOWN if follows else ()
        return {name: one for name, one in self.errors(variance).items() if name not in shown}

    def brought(self, variance: Floats | None = None) -> dict[str, Floats]:
        """What one standard deviation of each draw brings to the unknowns: by source, (draws, 12 + 3 x terms)."""
        return brought(by_gains(self.schedule, self.gains), self.errors(variance))

    def covariance(self, variance: Floats | None = None) -> Floats:
        """Of the unknowns. That of `optimal` needs no table."""
        if self.prior is not None:
            return self._given.covariance(self.k, self.prior[1], self.prior[0], variance)
        if self.estimator == OPTIMAL:
            given = self.schedule, self.k, self.stand, self.samples
            return optimal_covariance(*given, self.step, variance, self.terms)
        return covariance_of(by_gains(self.schedule, self.gains), self.errors(variance))


SHARE = 0.2  # of a standard uncertainty: a larger bias is no longer covered by it
_NODE = 3.0**0.5
_ROUNDING = 1e-12  # of max|K|
_CHUNK = 2000  # pairs at a time
_PLAIN = {"alpha1": "axis tilt", "alpha2": "level error", "alpha3": "yaw", "alpha4": "errors of set angles"}


@dataclass(frozen=True)
class SecondOrder:
    """`bias` (12,): expected of the estimate, less the truth, in its units; `parts`: of each source alone, (12,);
    `u` (12,): what is claimed, NaN where nothing is; `scale` (12,): of each coefficient's row, |K_ii|; `yaw`: the
    declared alpha3, rad."""

    bias: Floats
    parts: dict[str, Floats]
    u: Floats
    scale: Floats
    yaw: float

    @property
    def shifts(self) -> list[Shift]:
        """One for every coefficient whose bias matters."""
        rounding = _ROUNDING * float(self.scale.max())
        with np.errstate(invalid="ignore"):
            matters = np.abs(self.bias) > SHARE * self.u + rounding
        return [
            Shift(
                max(self.parts, key=lambda source: float(abs(self.parts[source][i]))),
                COEFFICIENTS[i],
                float(abs(self.bias[i]) / self.scale[i]),
                self.limit(i),
            )
            for i in np.flatnonzero(matters).tolist()
        ]

    def limit(self, index: int) -> float:
        """Of the bias of a coefficient, over the scale of its row."""
        return float(SHARE * self.u[index] / self.scale[index])

    @property
    def matters(self) -> bool:
        """Whether the linear theory says too little."""
        return bool(self.shifts)

    @property
    def complaints(self) -> list[str]:
        """For people, one for each source that has the largest part in some coefficient's bias."""
        shifts, found = self.shifts, []
        for source in dict.fromkeys(shift.source for shift in shifts):
            own = [shift for shift in shifts if shift.source == source]
            worst = max(own, key=lambda shift: shift.bias_relative / shift.limit if shift.limit else np.inf)
            name, others = worst.coefficient, [shift.coefficient for shift in own if shift is not worst]
            scale = f"K_{name[-2 if name.startswith('K') else -1] * 2}"
            beside = f"0.2 u({name})/{scale} = {worst.limit:.2g}"
            also = f" (also {', '.join(others)})" if others else ""
            found.append(
                f"large {_PLAIN.get(source, source)}: second order shifts {name} by {worst.bias_relative:.2g},"
                f" more than {beside}{also}"
            )
        return found


ManyRuns = Callable[[Floats], Floats]  # from means (runs, positions, 3), all measured, to coefficients (runs, 12)


def second_order(given: Propagation, u: Floats, estimate: ManyRuns) -> SecondOrder:
    """For an `estimate` as `given`, with claimed standard uncertainties `u` (12,)."""
    schedule, k = given.schedule, given.k
    errors = {name: one for name, one in given.simulated().items() if one.units and one.sigma.any()}
    count = sum(len(source.sigma) for source in errors.values())

    def moved(draws: Floats) -> Floats:
        found: Floats = estimate(exact_outputs(schedule, k, np.zeros(3), errors, draws)) - ideal
        return found

    ideal = np.concatenate([k.ravel(), np.zeros(3)])
    lone = _NODE * np.eye(count)
    single = moved(lone) + moved(-lone) if count else np.zeros((0, 12))
    one, other, pairs = *np.triu_indices(count, 1), np.zeros(12)  # over both signs of both
    for start in range(0, len(one), _CHUNK):
        first, second = lone[one[start : start + _CHUNK]], lone[other[start : start + _CHUNK]]
        for both in (first + second, first - second):
            pairs += moved(both).sum(axis=0) + moved(-both).sum(axis=0)
    bias = (4.0 - count) / 18.0 * single.sum(axis=0) + pairs / 36.0
    ends = np.cumsum([len(source.sigma) for source in errors.values()])[:-1]
    parts = {name: part.sum(axis=0) / 6.0 for name, part in zip(errors, np.split(single, ends))}
    scale = np.abs(np.diag(k))
    scale = np.where(scale > 0.0, scale, np.linalg.norm(k, axis=1))
    return SecondOrder(bias, parts, u, np.concatenate([np.repeat(scale, 3), scale]), given.stand.sigma("remount"))
