"""Thousands of runs on one schedule at once: drawn, solved by the core, and held against what a result states.

A seed means one stream, whoever draws from it. Normal numbers take from it as many bits as they happen to need, so
where a later chunk begins is known only to whoever has drawn all before: whoever cuts the stream draws as well, and
leaves what is computed from the numbers to others.

Monte Carlo of one result, after supplement 1 of the GUM (JCGM 101:2008): are its uncertainties, which are linear,
those of the exact geometry?

Runs are drawn from the declared stand at the coefficients found, and each is solved by the same estimator. An interval
of 95 % is what the errors of the runs leave of the value. It is held against the value -+ 1.96 u by the rule of clause
8.1: the ends may differ by half a unit of the first digit of u. The ends of the simulated one are known as far as their
runs go; where that leaves the outcome open, it says so.

Tables of the optimal estimator for many runs at once, each at its own K: optimal_table in stacks.

The system is the one of model.optimal but for the errors of the set angles. Each of these moves the three outputs of
its own position alone, along d = sigma4 K f', so it needs no column: the reflection that turns d to the first axis
leaves noise of sqrt(sigma^2 + |d|^2) along that axis and of sigma on the other two, and dividing the first row by
their ratio makes all noise alike. Exact, and as well conditioned as the whole system. Every run is reckoned by itself,
so numbers do not depend on how many runs are in a stack.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from tumble import core
from tumble.arrays import Floats
from tumble.core import CoreRefusal
from tumble.core.binding import GainRecord, Gains, estimate_runs, optimal_each, optimal_runs
from tumble.errors import UsageError
from tumble.estimators import COEFFICIENTS, OPTIMAL
from tumble.model.errors import Draws, by_gains, exact_outputs, unit_effect
from tumble.model.estimators import design
from tumble.model.optimal import (
    LARGEST_LOSS,
    UNEQUAL,
    by_mounting,
    by_table,
    channel_weights,
    mean_sigma,
    optimal_table,
    require_drift,
    shared_errors,
)
from tumble.model.propagation import ManyRuns, Propagation
from tumble.schedule import Schedule
from tumble.solving import further
from tumble.solving.optimal_run import record_of, to_bytes
from tumble.stand import SIGMA, PerChannel, Stand, by_channel
from tumble.workers.over import ALONE, Piece, Progress, Result, Team, over

_AT_ONCE = 50  # runs: what a stack of them takes stays in a processor's second cache


def solve(schedule: Schedule, means: Floats, stand: Stand, step: PerChannel, samples: float) -> tuple[Floats, Floats]:
    """Coefficients (runs, 12) by the core, with weights made at each run's first estimate, from means (runs, positions,
    3) of a schedule that has fit positions alone; and standard uncertainties (runs, 12) at the K found. `step` as in
    optimal_table; `samples`: of a mean, for the weights; uncertainties are for the stand's own.

    Raises CoreRefusal; UsageError where weights cannot be made.
    """
    system = _System(schedule, stand, step)
    opened = core.CoreSchedule(schedule)
    first = estimate_runs(opened, means, "least_squares")[:, :9].reshape(-1, 3, 3)
    table = optimal_table(schedule, first[0], stand, step, samples)
    record = GainRecord(opened, to_bytes(record_of(table, schedule)))
    found, u = np.empty((2, len(means), 12))
    for part in _parts(len(means)):
        found[part] = optimal_each(record, means[part], system.weights(first[part], samples))
        u[part] = system.uncertainties(found[part, :9].reshape(-1, 3, 3))
    return found, u


def _parts(runs: int) -> Iterator[slice]:
    for start in range(0, runs, _AT_ONCE):
        yield slice(start, min(start + _AT_ONCE, runs))


class _Mirror:
    """Makes the noise of outputs alike: for positions whose angle's error moves them by `along` (runs, P, 3), beside
    noise `sigma` (runs,). The reflection is I - v w^T, with v along the sum of d/|d| and the first axis, both taken to
    one side, so that nothing cancels."""

    def __init__(self, along: Floats, sigma: Floats):
        size = np.linalg.norm(along, axis=2, keepdims=True)
        anywhere = np.broadcast_to(np.eye(3)[0], along.shape).copy()
        self.v = np.divide(along, size, out=anywhere, where=size > 0.0)
        self.v[..., 0] += np.where(self.v[..., 0] < 0.0, -1.0, 1.0)
        self.w = self.v / np.abs(self.v[..., :1])
        self.ratio = sigma[:, None] / np.hypot(size[..., 0], sigma[:, None])

    def of(self, outputs: Floats) -> Floats:
        """Of columns (runs, P, 3, n) of outputs."""
        across = _dot(np.swapaxes(outputs, 2, 3), self.w[:, :, None])
        turned: Floats = outputs - self.v[..., None] * across[:, :, None]
        turned[:, :, 0] *= self.ratio[..., None]
        return turned

    def back(self, rows: Floats) -> Floats:
        """Gains (runs, n, 3P) of what `of` made, as gains of the outputs."""
        by_position = rows.reshape(*rows.shape[:2], -1, 3).copy()
        by_position[..., 0] *= self.ratio[:, None]
        across = _dot(by_position, self.v[:, None])
        turned: Floats = by_position - across[..., None] * self.w[:, None]
        return turned.reshape(rows.shape)


@dataclass(frozen=True)
class _Whitened:
    """Runs with noise alike in all rows: `rows` (runs, 3P + shared, shared + 12), the prior's behind the outputs'. What
    they came from: outputs `by_shared` (runs, P, 3, shared), in units of the prior, and `by_angle` (runs, P, 3);
    `mirror`; `sigma` (runs, 3) of a mean, and the `weights` (runs, 1, 3) that make channels alike."""

    rows: Floats
    by_shared: Floats
    by_angle: Floats
    mirror: _Mirror
    sigma: Floats
    weights: Floats


class _System:
    """What the runs of a stand and a schedule share."""

    def __init__(self, schedule: Schedule, stand: Stand, step: PerChannel):
        self.schedule, self.stand, self.step = schedule, stand, step
        self.errors = shared_errors(schedule, np.eye(3), stand)
        self.shared = np.concatenate([source.sigma for source in self.errors.values()])
        self.design = design(schedule).reshape(-1, 3, 12)
        by_shared = np.concatenate([source.derivative for source in self.errors.values()])
        self.by_shared = np.moveaxis(by_shared, 0, 2) * self.shared
        self.angles = len(self.shared) - (3 if "drift" in self.errors else 0)  # the others do not depend on K
        self.by_angle = unit_effect(schedule, "alpha4").derivative(np.eye(3)).sum(axis=0) * stand.sigma("angle")

    def whiten(self, k: Floats, samples: float) -> _Whitened:
        """For blocks of sensitivity `k` (runs, 3, 3)."""
        runs, positions, shared = len(k), len(self.design), len(self.shared)
        sigma = mean_sigma(k, self.stand, self.step, samples)[0]
        require_drift(self.stand.sigmas("drift") / sigma)
        weights, largest = channel_weights(sigma)[:, None], sigma.max(axis=1)
        by_shared, by_angle = self._turned(k), self.by_angle @ np.swapaxes(k, 1, 2)
        outputs = np.empty((runs, positions, 3, shared + 12))
        outputs[..., :shared], outputs[..., shared:] = by_shared, self.design
        outputs *= weights[..., None]
        mirror = _Mirror(by_angle * weights, largest)
        prior = largest[:, None, None] * np.eye(shared, shared + 12)
        rows = np.concatenate([mirror.of(outputs).reshape(runs, -1, shared + 12), prior], axis=1)
        return _Whitened(rows, by_shared, by_angle, mirror, sigma, weights)

    def _turned(self, k: Floats) -> Floats:
        """`by_shared`, which is for K = 1, for the K of every run."""
        by_channel = k @ np.swapaxes(self.by_shared, 0, 1).reshape(3, -1)
        turned = np.swapaxes(by_channel.reshape(len(k), 3, *self.by_shared.shape[::2]), 1, 2).copy()
        turned[..., self.angles :] = self.by_shared[..., self.angles :]
        of_runs: Floats = turned
        return of_runs

    def weights(self, k: Floats, samples: float) -> Gains:
        """For each run. Raises UsageError where numbers are beyond any stand."""
        system, shared = self.whiten(k, samples), len(self.shared)
        q, r = np.linalg.qr(system.rows)
        data = np.swapaxes(q[:, : 3 * len(self.design)], 1, 2)
        with np.errstate(all="ignore"):
            beta = np.linalg.solve(r[:, shared:, shared:], data[:, shared:])
            left = data[:, :shared] - r[:, :shared, shared:] @ beta
            prior = self.shared[:, None] * np.linalg.solve(r[:, :shared, :shared], left)
            by_channel = np.tile(system.weights, len(self.design))
            beta, prior = system.mirror.back(beta) * by_channel, system.mirror.back(prior) * by_channel
            sound = self._is_sound(beta, _deviations(r[:, shared:, shared:], system.sigma), system)
        if not (np.isfinite(prior).all() and sound):
            raise UsageError(UNEQUAL)
        return Gains(
            k,
            system.sigma.max(axis=1),
            system.weights[:, 0],
            beta,
            by_mounting(prior, self.errors, self.schedule, self.stand),
        )

    def uncertainties(self, k: Floats) -> Floats:
        """What the runs state (runs, 12): of the estimates, for blocks of sensitivity `k`."""
        system, shared = self.whiten(k, self.stand.samples), len(self.shared)
        r = np.asarray(np.linalg.qr(system.rows, mode="r"))
        u, rounding = _deviations(r[:, shared:, shared:], system.sigma), by_channel(self.stand.rounding)
        if not rounding.any():
            return u
        gains_of_runs = self.weights(k, self.stand.samples).gains
        by_rounding = (gains_of_runs**2).reshape(len(k), 12, -1, 3).sum(axis=2) @ rounding**2
        together: Floats = np.sqrt(u**2 + by_rounding)
        return together

    def _is_sound(self, beta: Floats, u: Floats, system: _Whitened) -> bool:
        """As optimal_table: the gains give back the coefficients, and their spread is the one that QR says."""
        lost = np.abs(beta @ self.design.reshape(-1, 12) - np.eye(12)).max()
        by_shared = beta @ system.by_shared.reshape(*beta.shape[::2], -1)
        by_angle = _dot(beta.reshape(*beta.shape[:2], -1, 3), system.by_angle[:, None])
        noise = _dot((beta**2).reshape(*beta.shape[:2], -1, 3).sum(axis=2), system.sigma[:, None] ** 2)
        claimed = np.sqrt((by_shared**2).sum(axis=2) + (by_angle**2).sum(axis=2) + noise)
        return bool(lost < LARGEST_LOSS and (np.abs(claimed - u) < LARGEST_LOSS * u).all())


def _dot(one: Floats, other: Floats) -> Floats:
    """Over a last axis of three, which a sum of numpy takes several times as long for."""
    product: Floats = one[..., 0] * other[..., 0] + one[..., 1] * other[..., 1] + one[..., 2] * other[..., 2]
    return product


def _deviations(r: Floats, sigma: Floats) -> Floats:
    deviations: Floats = sigma.max(axis=1)[:, None] * np.sqrt((np.linalg.inv(r) ** 2).sum(axis=2))
    return deviations


Sources: TypeAlias = dict[str, Draws]
Chunk: TypeAlias = "tuple[int, dict[str, Any]]"  # runs, and the state of the stream where they begin
_RUNS = 2000  # at a time: part of what a seed means


def chunks(errors: Sources, limits: str, runs: int, seed: int) -> Iterator[Piece]:
    """Of a campaign of `runs`, each a Chunk that `stream_of` goes on with."""
    rng = np.random.default_rng(seed)
    for start in range(0, runs, _RUNS):
        if start:
            _draws(errors, limits, _RUNS, rng)
        count = min(_RUNS, runs - start)
        yield Piece(f"runs {start} to {start + count - 1}", (count, rng.bit_generator.state), count)


def stream_of(chunk: Chunk) -> np.random.Generator:
    """Random numbers from the beginning of a chunk on."""
    rng = np.random.default_rng(0)
    rng.bit_generator.state = chunk[1]
    return rng


def drawn_outputs(
    schedule: Schedule, k: Floats, u0: Floats, errors: Sources, limits: str, runs: int, rng: np.random.Generator
) -> Floats:
    """Outputs (runs, positions, 3) of the exact geometry, every error drawn anew for every run: by a uniform law where
    the stand's `limits` are half-widths, but noise, which is normal, by a normal one."""
    return exact_outputs(schedule, k, u0, errors, np.concatenate(_draws(errors, limits, runs, rng), axis=1))


def _draws(errors: Sources, limits: str, runs: int, rng: np.random.Generator) -> list[Floats]:
    laws = [(SIGMA if source.normal else limits, len(source.sigma)) for source in errors.values()]
    return [unit_draws(rng, law, (runs, count)) for law, count in laws]


def unit_draws(rng: np.random.Generator, limits: str, shape: tuple[int, int]) -> Floats:
    """Numbers of mean 0 and variance 1; of a uniform law where the stand declares half-widths."""
    return rng.uniform(-(3.0**0.5), 3.0**0.5, shape) if limits == "uniform" else rng.standard_normal(shape)


def estimator_for(given: Propagation) -> ManyRuns:
    """From means (runs, positions, 3), all measured, to K row by row, U0 and the sizes of further terms (runs, 12 + 3 x
    terms). `optimal` has weights made at the `k` given: its second order makes up for those of each run's own K. What
    is returned raises CoreRefusal."""
    schedule, terms = core.CoreSchedule(given.schedule), given.terms
    if given.estimator != OPTIMAL:
        if terms:
            return lambda means: further.least_squares(schedule, means, terms)
        return lambda means: estimate_runs(schedule, means, given.estimator)
    if terms:
        return lambda means: by_table(given.table, given.schedule, given.stand, terms, means)
    record = GainRecord(schedule, to_bytes(record_of(given.table, given.schedule)))
    return lambda means: optimal_runs(record, means)[0]


def estimator_or_linear(given: Propagation) -> ManyRuns:
    """The same, of the twelve alone; beyond 0.1 rad, where `optimal` gives no result, its linear part, whose bias says
    enough."""
    estimate = estimator_for(given)

    def of(means: Floats) -> Floats:
        try:
            return estimate(means)[:, :12]
        except core.CoreRefusal:
            if given.estimator != OPTIMAL:
                raise
            return by_gains(given.schedule, given.gains[:12])(means)

    return of


COVERAGE = 0.95
LEVEL = 0.999  # of the range in which an end of a simulated interval lies
NORMAL_COVERAGE = 1.959963984540054
_NORMAL_LEVEL = 3.2905267314919255
_ROUNDING = 1e-12  # of max|K|


class Verdict(Enum):
    """On one coefficient."""

    AGREES = "agrees"
    DIFFERS = "differs"
    CANNOT_TELL = "cannot tell"


@dataclass(frozen=True)
class MonteCarlo:
    """All (12,), in the coefficients' units: `shift`: mean error of an estimate; `u`: its standard deviation; `low` and
    `high`: the interval of the coefficient; `linear_low`, `linear_high`: that of the stated u; `tolerance` for the
    difference of their ends, which is `least` to `most`."""

    runs: int
    seed: int
    shift: Floats
    u: Floats
    low: Floats
    high: Floats
    linear_low: Floats
    linear_high: Floats
    tolerance: Floats
    least: Floats
    most: Floats

    @property
    def verdicts(self) -> list[Verdict]:
        """One for each coefficient."""
        agrees, differs = self.most <= self.tolerance, self.least > self.tolerance
        told = {True: Verdict.AGREES, False: Verdict.CANNOT_TELL}
        return [Verdict.DIFFERS if far else told[near] for near, far in zip(agrees.tolist(), differs.tolist())]

    @property
    def agrees(self) -> bool | None:
        """Whether all do; None where it cannot be told."""
        verdicts = self.verdicts
        if Verdict.DIFFERS in verdicts:
            return False
        return None if Verdict.CANNOT_TELL in verdicts else True

    def where(self, verdict: Verdict) -> list[str]:
        """Names of the coefficients with this verdict."""
        return [name for name, own in zip(COEFFICIENTS, self.verdicts) if own is verdict]


def simulate(
    given: Propagation,
    u0: Floats,
    u: Floats,
    runs: int,
    seed: int,
    mean_variance: Floats | None = None,
    team: Team = ALONE,
    progress: Progress = lambda runs: None,
) -> MonteCarlo:
    """Of an estimate as `given`, with `u0` (3,) and stated uncertainties `u` (12,); `mean_variance` (positions, 3): by
    the noise as measured. The same seed gives the same numbers, whatever the `team`. `progress` is told of runs done.

    Raises UsageError where a run on such a stand cannot be solved.
    """
    errors, k = given.errors(mean_variance), given.k
    pieces = chunks(errors, given.stand.limits, runs, seed)
    found = [one["found"] for one in over(pieces, _Estimates(given, u0, errors), team, progress)]
    value = np.concatenate([k.ravel(), u0])
    return compare(np.concatenate(found).reshape(-1, 12) - value, value, u, seed, _ROUNDING * float(np.abs(k).max()))


def compare(errors: Floats, value: Floats, u: Floats, seed: int, rounding: float) -> MonteCarlo:
    """`errors` (runs, 12) of simulated estimates, beside `value` and stated `u` (12,)."""
    ordered, runs = np.sort(errors, axis=0), len(errors)
    tail = (1.0 - COVERAGE) / 2.0
    known = _NORMAL_LEVEL * (runs * tail * (1.0 - tail)) ** 0.5
    # what lies above the truth by an error makes the coefficient lie below the estimate by it
    ends = {}
    for name, share in (("low", 1.0 - tail), ("high", tail)):
        places = np.clip(np.rint(share * runs + np.array([-known, 0.0, known])), 1, runs).astype(int) - 1
        ends[name] = value - ordered[places]
    linear = {"low": value - NORMAL_COVERAGE * u, "high": value + NORMAL_COVERAGE * u}
    least, most = (np.max([bound(ends[name], linear[name]) for name in ends], axis=0) for bound in (_least, _most))
    tolerance = np.maximum([_tolerance(one) for one in u.tolist()], rounding)
    return MonteCarlo(
        *(runs, seed, errors.mean(axis=0), errors.std(axis=0, ddof=1), ends["low"][1], ends["high"][1]),
        *(linear["low"], linear["high"], tolerance, least, most),
    )


def _least(ends: Floats, linear: Floats) -> Floats:
    """How far a linear end is from the range (3, 12) of a simulated one: 0 within."""
    least: Floats = np.maximum(np.maximum(ends.min(axis=0) - linear, linear - ends.max(axis=0)), 0.0)
    return least


def _most(ends: Floats, linear: Floats) -> Floats:
    most: Floats = np.abs(ends - linear).max(axis=0)
    return most


def _tolerance(u: float) -> float:
    """Half a unit of the first digit of u (clause 7.9.2, one digit)."""
    return 0.5 * 10.0 ** int(f"{u:.0e}".partition("e")[2]) if u > 0.0 else 0.0


@dataclass(frozen=True)
class _Estimates:
    """A job: the coefficients of a chunk of runs, one after the other. Raises UsageError where they cannot be had."""

    given: Propagation
    u0: Floats
    errors: dict[str, Draws]

    def __call__(self, chunk: Chunk) -> Result:
        given = self.given
        drawn = given.schedule, given.k, self.u0, self.errors, given.stand.limits, chunk[0], stream_of(chunk)
        try:
            return {"found": self._estimate(drawn_outputs(*drawn))[:, :12].ravel()}
        except CoreRefusal as refusal:
            raise UsageError(f"--monte-carlo: a run on such a stand cannot be solved: {refusal}") from None

    @cached_property
    def _estimate(self) -> ManyRuns:
        return estimator_for(self.given)
