"""A Monte Carlo campaign: the firmware core on thousands of simulated runs, against what is claimed of it.

The runs are position means of the exact geometry. Every run states its own uncertainties, at its own K, as a solve
does, or those of its gain record, as the firmware does; they are judged by how far off the run was. What was counted is
held against what was claimed with room for chance.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from msgspec import UNSET

from tumble import core
from tumble.arrays import Floats, Integers
from tumble.defaults import UNDECLARED_RAD
from tumble.documents.plan import Covered, FigureLimits, Figures, Promise, Shares, Validation
from tumble.errors import UsageError
from tumble.estimators import COEFFICIENTS, INCLINED, OPTIMAL
from tumble.model.coefficients import spread_attitudes
from tumble.model.errors import OF_OUTPUTS, course, declared, free, of_stand, sources
from tumble.model.estimators import columns_at
from tumble.model.inclined import as_seen
from tumble.model.optimal import by_table, optimal_covariance, samples_in_a_mean
from tumble.planning import tables
from tumble.planning.case import Case
from tumble.planning.promise import condition, largest_over_attitudes, norm_forms, promise
from tumble.planning.weights import estimator_gains
from tumble.solving import optimal_run
from tumble.solving.computation import estimate_inclinations, estimator_for
from tumble.solving.many_runs import Chunk, Sources, chunks, drawn_outputs, stream_of
from tumble.terms import POWERS, Terms, model_of
from tumble.workers.over import ALONE, Progress, Result, Team, over

U0_V = (0.01, -0.02, 0.03)  # of the simulated block: linear estimators do not care


def position_means(case: Case, k: Floats, runs: int, rng: np.random.Generator) -> Floats:
    """Means (runs, positions, 3) in V of a block of sensitivity `k` (V/g) and offsets U0_V.

    The stand's errors are drawn anew for every run: normal, or uniform where the stand declares half-widths. The noise
    of a mean is normal, of the stand's noise or the converter's rounding, whichever is larger.
    """
    return drawn_outputs(case.schedule, k, np.array(U0_V), errors_of(case, k), case.stand.limits, runs, rng)


def errors_of(case: Case, k: Floats) -> Sources:
    """What is drawn of a case's stand; inclinations that nobody declares err by 5 mrad."""
    undeclared = free(case.stand, case.schedule)
    stand = case.stand.with_sigma("inclination", UNDECLARED_RAD) if undeclared else case.stand
    return sources(case.schedule, k, stand, np.ones(len(case.schedule.positions), dtype=int))


KNOWN = "known"  # optimal weights for the block's true K, as a last known one
RUN = "run"  # for each run's own first estimate of K, as in a solve
COVERAGE_FACTORS = (1, 2, 3)
_ATTITUDES = 2000
_SUMS = ("within", "histograms", "total", "squares")  # arrays of a tally
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
        counts = {f"{name} counts": np.array([self.runs, self.passed, self.everywhere])}
        return counts | {f"{name} {part}": getattr(self, part).ravel() for part in _SUMS}

    def take(self, result: Result, name: str) -> None:
        """Add what another tally was, of later runs: sums depend on their order."""
        runs, passed, everywhere = result[f"{name} counts"].tolist()
        self.runs, self.passed, self.everywhere = self.runs + runs, self.passed + passed, self.everywhere + everywhere
        for part in _SUMS:
            so_far = getattr(self, part)
            setattr(self, part, so_far + result[f"{name} {part}"].reshape(so_far.shape))

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

    def planned(estimator: str) -> Floats:
        return case.spread(estimator_gains(case, estimator, k), k)

    bound = planned(OPTIMAL)
    return [
        Validated(estimator, tallies[estimator], planned(estimator), bound, promise(case, estimator))
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
    block with `k` and U0_V; beside further terms, at two thousand of them."""
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


Solver = Callable[[Floats], tuple[Floats, Floats]]


def _solver(case: Case, estimator: str, k: Floats, table: str) -> Solver:
    """From means (runs, positions, 3) to coefficients, with the sizes of further terms behind, and stated uncertainties
    (runs, 12), by the core."""
    if estimator == OPTIMAL and free(case.stand, case.schedule):
        return _at_inclinations(case)
    if estimator == OPTIMAL and table == RUN and not case.terms:
        fitted, indices = case.fitted, case.schedule.fit_indices
        samples = samples_in_a_mean(fitted, case.stand, np.ones(len(fitted.positions), dtype=int))
        return lambda means: optimal_run.solve_each(fitted, means[:, indices], case.stand, case.step_v, samples)
    estimate, weights = estimator_for(case.propagation(estimator, k)), estimator_gains(case, estimator, k)
    if estimator == OPTIMAL:
        u = case.spread(weights, k)
        return lambda means: (estimate(means), np.broadcast_to(u, (len(means), 12)))
    state = _stated(case, weights, ("alpha1",) if estimator == INCLINED else ())

    def solved(means: Floats) -> tuple[Floats, Floats]:
        found = estimate(means)
        return found, state(found[:, :9])

    return solved


def _at_inclinations(case: Case) -> Solver:
    """`optimal` of runs whose inclinations nobody declares, as solves of their own."""
    fitted, indices, stand = core.CoreSchedule(case.fitted), case.schedule.fit_indices, case.stand
    lone = np.ones(len(fitted), dtype=int)
    weighting, measured = optimal_run.Weighting(stand, lone, case.step_v), lone > 0

    def solved(means: Floats) -> tuple[Floats, Floats]:
        found, u = [], []
        for run in means[:, indices]:
            _, seen = estimate_inclinations(fitted, run, measured, stand.weights)
            at = core.CoreSchedule(as_seen(fitted.data, seen))
            table = optimal_run.make_table(at, run, measured, weighting, case.terms)
            if case.terms:  # which no gain record has
                found.append(by_table(table, at.data, stand, case.terms, run[None])[0])
            else:
                found.append(optimal_run.apply_table(table, at, run))
            k = found[-1][:9].reshape(3, 3)
            u.append(np.sqrt(np.diag(optimal_covariance(at.data, k, stand, lone, case.step_v))[:12]))
        return np.array(found), np.array(u)

    return solved


def _stated(case: Case, weights: Floats, without: tuple[str, ...] = ()) -> Callable[[Floats], Floats]:
    """The uncertainties (runs, 12) that runs state at their own K (runs, 9), for fixed gains; `without` sources that
    would bring nothing by the gains at that K.

    What an error of the stand brings to a coefficient is linear in K; what noise and drift bring does not depend on it.
    """
    names = [name for name in declared(case.stand, case.schedule) if name not in (*OF_OUTPUTS, "inclination", *without)]
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


CHANCE_SIGMAS = 4.0  # room for chance; about 300 figures are judged, and 1 in 16,000 lies further out
LARGEST_BIAS_U = 0.2
TOLERANCE = 0.02  # of a spread over what was planned, and of the bound over a spread
COVERAGE_LIMITS = {1: (0.6727, 0.6927), 2: (0.945, 0.965), 3: (0.9953, 0.9993)}


def tolerance(runs: int) -> float:
    """How far a ratio of spreads may be from 1: 2 %, or what chance does to the spread of so few runs."""
    return max(TOLERANCE, CHANCE_SIGMAS / math.sqrt(2.0 * runs))


def bias_limit(runs: int) -> float:
    """The largest bias over u."""
    return LARGEST_BIAS_U + CHANCE_SIGMAS / math.sqrt(runs)


def binomial_limits(count: Integers, runs: int) -> tuple[Floats, Floats]:
    """Wilson's interval for a probability of which `count` of `runs` were seen, CHANCE_SIGMAS wide to each side."""
    seen, z = np.asarray(count) / runs, CHANCE_SIGMAS
    middle = seen + z**2 / (2 * runs)
    half = z * np.sqrt(seen * (1 - seen) / runs + z**2 / (4 * runs**2))
    low, high = (middle - half) / (1 + z**2 / runs), (middle + half) / (1 + z**2 / runs)
    return np.clip(low, 0.0, 1.0), np.clip(high, 0.0, 1.0)


def judge(found: Validated) -> Figures:
    """Every figure, and those outside their limits."""
    tally, runs = found.tally, found.tally.runs
    low, high = binomial_limits(tally.within, runs)
    judged = Figures(
        u=found.u,
        bound=found.bound,
        bias_over_u=tally.bias / found.u,
        spread_over_u=tally.spread / found.u,
        efficiency=found.bound / tally.spread,
        coverage={
            str(factor): Covered(tally.within[row] / runs, low[row], high[row])
            for row, factor in enumerate(COVERAGE_FACTORS)
        },
        outside=(),
        promise=found.promise,
        simulated=Shares(passes=tally.passed / runs, every_attitude=tally.everywhere / runs),
    )
    room, complaints = tolerance(runs), []
    figures = zip(COEFFICIENTS, judged.bias_over_u, judged.spread_over_u, judged.efficiency)
    for index, (name, bias, spread, efficiency) in enumerate(figures):
        if not abs(bias) <= bias_limit(runs):
            complaints.append(f"{name} bias {bias:+.2f} u, limit {bias_limit(runs):.2f}")
        if not abs(spread - 1.0) <= room:
            complaints.append(f"{name} spread {spread:.3f} of the planned u, limit 1 +- {room:.3f}")
        if found.estimator == OPTIMAL and not efficiency >= 1.0 - room:
            complaints.append(f"{name} efficiency {efficiency:.3f}, limit {1.0 - room:.3f}")
        for factor, one in judged.coverage.items():
            least, most = COVERAGE_LIMITS[int(factor)]
            if one.high[index] < least or one.low[index] > most:
                limits = f"limits {100 * least:.2f} to {100 * most:.2f}"
                complaints.append(f"{name} k = {factor} covers {100 * one.covered[index]:.2f} %, {limits}")
    judged.outside = tuple(complaints)
    return judged


def document(case: Case, found: dict[str, Figures], runs: int, seed: int, table: str) -> Validation:
    """The campaign for JSON, by estimator."""
    return Validation(
        stand=case.stand.name,
        block=case.block,
        runs=runs,
        seed=seed,
        table=table,
        model=model_of(case.terms) or UNSET,
        names=COEFFICIENTS,
        limits=FigureLimits(
            bias_over_u=bias_limit(runs),
            spread_over_u=np.array([1.0 - tolerance(runs), 1.0 + tolerance(runs)]),
            efficiency_of_optimal=1.0 - tolerance(runs),
            coverage={str(factor): np.array(limits) for factor, limits in COVERAGE_LIMITS.items()},
            binomial_sigmas=CHANCE_SIGMAS,
        ),
        estimators=found,
        passed=not any(one.outside for one in found.values()),
    )


def show(plan: Validation) -> None:
    """Print the campaign on standard output."""
    out = tables.console()
    out.print(tables.heading(f"Monte Carlo: {plan.runs} runs of the firmware's estimators, seed {plan.seed}"))
    out.print(f"Stand: {plan.stand or 'without a name'}")
    if plan.model:
        out.print(f"Beside the twelve coefficients each run finds {', '.join(plan.model)}")
    headings = ("", "u planned", "bias/u", "spread/u", "bound/spread", "k = 1", "k = 2", "k = 3")
    for estimator, one in plan.estimators.items():
        out.print(tables.heading(f"\n{estimator}"))
        numbers = zip(one.u, one.bias_over_u, one.spread_over_u, one.efficiency)
        covered = zip(*(of.covered for of in one.coverage.values()))
        rows = [
            (
                name,
                f"{u:.3e}",
                f"{bias:+.3f}",
                f"{spread:.4f}",
                f"{best:.4f}",
                *(f"{100 * share:.2f}" for share in shares),
            )
            for name, (u, bias, spread, best), shares in zip(COEFFICIENTS, numbers, covered)
        ]
        out.print(tables.table(headings, rows))
        promised, shares = one.promise, (one.simulated.passes, one.simulated.every_attitude)
        passes, everywhere = (f"{100 * p:.1f} +- {100 * (p * (1 - p) / plan.runs) ** 0.5:.1f} %" for p in shares)
        check = f"passes the gravity check {tables.percent(promised.passes)} (seen {passes})"
        out.print(f"{promised.limit_g:g} g: {check},")
        norm = f"at every attitude {tables.percent(promised.every_attitude)} (seen {everywhere})"
        out.print(f"|a| within it {norm}{condition(promised)}")
        for complaint in one.outside:
            out.print(f"Outside: {complaint}", style="red")
    out.print("k = 1, 2, 3: % of runs within k of their own stated standard uncertainties")
    outside = sum(len(one.outside) for one in plan.estimators.values())
    if outside:
        out.print(f"FAIL: {outside} figures lie outside their limits", style="red bold")
    else:
        out.print("PASS: the stated uncertainties hold: every figure is within its limits.", style="green bold")
        out.print("Is the stand good enough for a limit? Ask tumble plan require.", style="green bold")
