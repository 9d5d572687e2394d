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
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np

from tumble.arrays import Floats
from tumble.core import CoreRefusal
from tumble.errors import UsageError
from tumble.estimators import COEFFICIENTS
from tumble.model.errors import Draws, exact_outputs
from tumble.model.propagation import ManyRuns, Propagation
from tumble.schedule import Schedule
from tumble.solving.computation import estimator_for
from tumble.workers.over import ALONE, Piece, Progress, Result, Team, over

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
    """Numbers of mean 0 and variance 1; of a uniform law where the stand declares half-widths."""
    drawn = []
    for source in errors.values():
        shape = runs, len(source.sigma)
        is_uniform = limits == "uniform" and not source.normal
        drawn.append(rng.uniform(-(3.0**0.5), 3.0**0.5, shape) if is_uniform else rng.standard_normal(shape))
    return drawn


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
    errors, k = given.simulated(mean_variance), given.k
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
    ends = []
    for share in (1.0 - tail, tail):
        places = np.clip(np.rint(share * runs + np.array([-known, 0.0, known])), 1, runs).astype(int) - 1
        ends.append(value - ordered[places])
    linear = [value - NORMAL_COVERAGE * u, value + NORMAL_COVERAGE * u]
    # how far a linear end is from the range (3, 12) of a simulated one, which is 0 within it
    outside = [np.maximum(one.min(axis=0) - end, end - one.max(axis=0)) for one, end in zip(ends, linear)]
    # half a unit of the first digit of u (clause 7.9.2, one digit)
    tolerance = [0.5 * 10.0 ** int(f"{one:.0e}".partition("e")[2]) if one > 0.0 else 0.0 for one in u.tolist()]
    return MonteCarlo(
        runs=runs,
        seed=seed,
        shift=errors.mean(axis=0),
        u=errors.std(axis=0, ddof=1),
        low=ends[0][1],
        high=ends[1][1],
        linear_low=linear[0],
        linear_high=linear[1],
        tolerance=np.maximum(tolerance, rounding),
        least=np.maximum(np.max(outside, axis=0), 0.0),
        most=np.max([np.abs(one - end).max(axis=0) for one, end in zip(ends, linear)], axis=0),
    )


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
