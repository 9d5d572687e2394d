"""Monte Carlo: the firmware core on thousands of simulated runs, against what is claimed of it.

Every run states its own uncertainties, at its own K, as a solve does, or those of its gain record, as the firmware
does; they are judged by how far off the run was.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from tumble import core
from tumble.arrays import Floats, Integers
from tumble.errors import UsageError
from tumble.estimators import OPTIMAL
from tumble.model.errors import OF_OUTPUTS, course, declared, of_stand
from tumble.model.estimators import columns_at
from tumble.model.norm import spread_attitudes
from tumble.model.optimal import samples_in_a_mean, standard_deviations
from tumble.planning.case import Case
from tumble.planning.error_field import largest_over_attitudes, norm_forms
from tumble.planning.promise import Promise, promise
from tumble.planning.simulate import U0_V, errors_of, position_means
from tumble.planning.weights import estimator_gains
from tumble.solving import tables_of_runs
from tumble.solving.drawn_runs import Chunk, chunks, stream_of
from tumble.solving.many_runs import estimator_for
from tumble.terms import POWERS, Terms
from tumble.workers.kept import Result
from tumble.workers.over import ALONE, Progress, Team, over

KNOWN = "known"  # optimal weights for the block's true K, as a last known one
RUN = "run"  # for each run's own first estimate of K, as in a solve
COVERAGE_FACTORS = (1, 2, 3)
_ATTITUDES = 2000
HISTOGRAM = (-5.0, 5.0, 50)  # of error over u: from, to, bins


@dataclass
class Tally:
    """What is kept of an estimator's runs: sums over `runs` of the errors (12,) and their squares, how many errors were
    within k u (3, 12), and histograms (12, bins) of error over u; how many `passed` the gravity check,
    and how many have |a| within its limit `everywhere`."""

    runs: int = 0
    passed: int = 0
    everywhere: int = 0
    total: Floats = field(default_factory=lambda: np.zeros(12))
    squares: Floats = field(default_factory=lambda: np.zeros(12))
    within: Integers = field(default_factory=lambda: np.zeros((len(COVERAGE_FACTORS), 12), dtype=int))
    histograms: Integers = field(default_factory=lambda: np.zeros((12, HISTOGRAM[2]), dtype=int))

    def add(self, errors: Floats, u: Floats) -> None:
        """Errors and stated standard uncertainties (runs, 12)."""
        low, high, bins = HISTOGRAM
        self.runs += len(errors)
        self.total += errors.sum(axis=0)
        self.squares += (errors**2).sum(axis=0)
        within = [(np.abs(errors) <= factor * u).sum(axis=0) for factor in COVERAGE_FACTORS]
        self.within = self.within + np.array(within)
        scores = np.clip(errors / u, low, np.nextafter(high, low))
        self.histograms = self.histograms + np.array([np.histogram(score, bins, (low, high))[0] for score in scores.T])

    def judge(self, check: Floats, everywhere: Floats, limit_g: float) -> None:
        """The largest errors (runs,) of the gravity check, and of (|a|^2 - 1)/2 over all attitudes."""
        self.passed += int((check <= limit_g).sum())
        self.everywhere += int((everywhere <= limit_g).sum())

    def result(self, name: str) -> Result:
        """For `take`, under a name of its own."""
        counts = np.array([self.runs, self.passed, self.everywhere])
        sums = {"counts": counts, "within": self.within.ravel(), "histograms": self.histograms.ravel()}
        return {f"{name} {part}": one for part, one in {**sums, "total": self.total, "squares": self.squares}.items()}

    def take(self, result: Result, name: str) -> None:
        """Add what another tally was, of later runs: sums depend on their order."""
        runs, passed, everywhere = result[f"{name} counts"].tolist()
        self.runs, self.passed, self.everywhere = self.runs + runs, self.passed + passed, self.everywhere + everywhere
        self.total += result[f"{name} total"]
        self.squares += result[f"{name} squares"]
        self.within = self.within + result[f"{name} within"].reshape(self.within.shape)
        self.histograms = self.histograms + result[f"{name} histograms"].reshape(self.histograms.shape)

    @property
    def bias(self) -> Floats:
        """Mean error (12,)."""
        return self.total / self.runs

    @property
    def spread(self) -> Floats:
        """Standard deviation of the errors (12,)."""
        return np.sqrt((self.squares - self.runs * self.bias**2) / (self.runs - 1))


@dataclass(frozen=True)
class Validated:
    """One estimator's tally beside what was claimed: `u` (12,) as planned, `bound` (12,) what optimal weights leave,
    the least possible where rounding averages out, `promise` of the gravity check."""

    estimator: str
    tally: Tally
    u: Floats
    bound: Floats
    promise: Promise


def validate(
    case: Case,
    estimators: tuple[str, ...],
    runs: int,
    seed: int,
    table: str = KNOWN,
    progress: Progress = lambda runs: None,
    team: Team = ALONE,
) -> list[Validated]:
    """Let every estimator solve the same `runs` runs of the nominal block, whatever the `team`. `progress` is told of
    runs done.

    Raises UsageError where the schedule, or a run on such a stand, cannot be solved.
    """
    k = case.nominal_k()
    tallies = {estimator: Tally() for estimator in estimators}
    pieces = chunks(errors_of(case, k), case.stand.limits, runs, seed)
    for result in over(pieces, _Tallied(case, estimators, table), team, progress):
        for estimator, tally in tallies.items():
            tally.take(result, estimator)
    bound = _planned(case, OPTIMAL, k)
    return [
        Validated(estimator, tallies[estimator], _planned(case, estimator, k), bound, promise(case, estimator))
        for estimator in estimators
    ]


@dataclass(frozen=True)
class _Tallied:
    """A job: the tallies of a chunk of runs."""

    case: Case
    estimators: tuple[str, ...]
    table: str

    def __call__(self, chunk: Chunk) -> Result:
        case, k, result = self.case, self.case.nominal_k(), Result()
        means, truth = position_means(case, k, chunk[0], stream_of(chunk)), np.concatenate([k.ravel(), U0_V])
        for estimator, solver in self._solvers.items():
            tally = Tally()
            try:
                found, u = solver(means)
            except core.CoreRefusal as refusal:
                raise UsageError(f"a run on such a stand cannot be solved by {estimator}: {refusal}") from None
            tally.add(found[:, :12] - truth, u)
            check = largest_gravity_errors(means, found, case.terms)
            tally.judge(check, _everywhere(found, k, case.terms), case.limit_g)
            result |= tally.result(estimator)
        return result

    @cached_property
    def _solvers(self) -> dict[str, Solver]:
        k = self.case.nominal_k()
        return {estimator: _solver(self.case, estimator, k, self.table) for estimator in self.estimators}


def largest_gravity_errors(means: Floats, found: Floats, terms: Terms = ()) -> Floats:
    """Of (8) over the positions, without sign: (runs,). `means` (runs, positions, 3), `found` (runs, 12), with the
    sizes of further `terms` behind, which are so small that once is enough."""
    k, u0 = found[:, :9].reshape(-1, 3, 3), found[:, None, 9:12]
    force = np.linalg.solve(k, np.swapaxes(means - u0, 1, 2))
    if terms:
        shown = zip(found[:, 12:], np.swapaxes(force, 1, 2))
        further = np.array([np.tensordot(sizes, columns_at(one, terms), axes=1) for sizes, one in shown])
        force = force - np.linalg.solve(k, np.swapaxes(further, 1, 2))
    largest: Floats = np.abs((force**2).sum(axis=1) - 1.0).max(axis=1) / 2.0
    return largest


def _everywhere(found: Floats, k: Floats, terms: Terms) -> Floats:
    """The largest of (8) over all attitudes at rest, without noise, for runs that found (runs, 12 + 3 x terms) of a
    block with `k` and U0_V; beside K2 and K3, at two thousand of them."""
    if set(terms) & set(POWERS):
        still = found.copy()
        for index, term in enumerate(terms):
            if term not in POWERS:
                still[:, 12 + 3 * index : 15 + 3 * index] = 0.0  # a drift was the run's and is over
        at_rest = np.array(U0_V) + spread_attitudes(_ATTITUDES) @ k.T
        return np.concatenate([largest_gravity_errors(at_rest[None], run[None], terms) for run in still])
    turned = np.linalg.solve(found[:, :9].reshape(-1, 3, 3), np.broadcast_to(k, (len(found), 3, 3)))
    shift = np.linalg.solve(found[:, :9].reshape(-1, 3, 3), (np.array(U0_V) - found[:, 9:12])[..., None])
    transposed = np.swapaxes(turned, 1, 2)
    constant = ((shift**2).sum(axis=(1, 2)) - 1.0)[:, None, None] * np.eye(3)
    forms = norm_forms((transposed @ turned + constant) / 2.0, (transposed @ shift)[..., 0])
    return largest_over_attitudes(forms)


def _planned(case: Case, estimator: str, k: Floats) -> Floats:
    weights = estimator_gains(case, estimator, k)
    return standard_deviations(case.fitted, weights, k, case.stand, case.mean_sigma(k))


Solver = Callable[[Floats], tuple[Floats, Floats]]


def _solver(case: Case, estimator: str, k: Floats, table: str) -> Solver:
    """From means (runs, positions, 3) to coefficients, with the sizes of further terms behind, and stated uncertainties
    (runs, 12), by the core."""
    if estimator == OPTIMAL and table == RUN and not case.terms:
        return lambda means: _weighted_anew(case, means[:, case.schedule.fit_indices])
    estimate, u = estimator_for(case.propagation(estimator, k)), _planned(case, estimator, k)
    if estimator == OPTIMAL:
        return lambda means: (estimate(means), np.broadcast_to(u, (len(means), 12)))
    state = _stated(case, estimator_gains(case, estimator, k))
    return lambda means: _with(state, estimate(means))


def _with(state: Callable[[Floats], Floats], found: Floats) -> tuple[Floats, Floats]:
    return found, state(found[:, :9])


def _stated(case: Case, weights: Floats) -> Callable[[Floats], Floats]:
    """The uncertainties (runs, 12) that runs state at their own K (runs, 9), for fixed gains.

    What an error of the stand brings to a coefficient is linear in K; what noise and drift bring does not depend on it.
    """
    names = [name for name in declared(case.stand) if name not in OF_OUTPUTS]
    by_error = []
    for one in np.eye(9).reshape(9, 3, 3):
        found = of_stand(case.fitted, one, case.stand, names).values()
        draws = np.concatenate([source.derivative * source.sigma[:, None, None] for source in found])
        by_error.append(weights @ draws.reshape(len(draws), -1).T)
    stand_only = np.stack(by_error)
    noise = (weights**2).reshape(12, -1, 3).sum(axis=1) @ case.mean_sigma(case.nominal_k()) ** 2
    by_drift = np.einsum("cpi,p->ci", weights.reshape(12, -1, 3), course(case.fitted)) * case.stand.sigmas("drift")
    fixed = noise + (by_drift**2).sum(axis=1)
    return lambda k: np.sqrt((np.einsum("rm,mce->rce", k, stand_only) ** 2).sum(axis=2) + fixed)


def _weighted_anew(case: Case, means: Floats) -> tuple[Floats, Floats]:
    """As a solve: weights for each run's own K."""
    samples = samples_in_a_mean(case.fitted, case.stand, np.ones(len(case.fitted.positions), dtype=int))
    return tables_of_runs.solve(case.fitted, means, case.stand, case.step_v, samples)
