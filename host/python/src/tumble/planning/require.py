"""What an accuracy asks of a stand, and how much room a declared one has.

`requirements`, inverse to the budget: how bad each source of a stand may be for a limit of the gravity check. By (10),
(13) and (14) the six scale factors and biases, and the noise of a mean on its own, may each take a third of the limit.
In each of these rows the sources that enter it share that third; a source's requirement is what the strictest row
allows it. `derived`: worst signs of the misalignments, sizes as standard deviations. The optimal estimator's weights
follow the stand, so its requirements are those of a stand for which it was made, with full rows.

`headroom`: how much worse the sources of a declared stand may become before a row is exceeded.

`enough`: the requirements, scaled until the probability that the user asks for is reached, of passing the gravity check
and of |a| within the limit at every attitude. A third of the limit for each row promises no probability: it says how
the sources compare, and one factor for all of them sets the probability. Sources that no row limits stay as declared.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from msgspec import UNSET, UnsetType
from rich.console import Console

from tumble.arrays import Flags, Floats
from tumble.core import MAX_SAMPLES
from tumble.documents.plan import (
    ROWS,
    Enough,
    Equation18,
    GrowingPromise,
    OfSources,
    Require,
    Row,
    Rule,
    SourceLimits,
    SourceSizes,
    Weights,
)
from tumble.errors import UsageError, listed
from tumble.estimators import INCLINED, OPTIMAL
from tumble.model.estimators import circles
from tumble.planning import tables, weights
from tumble.planning.budget import (
    ALPHAS,
    by_key,
    notes,
    numbers_are,
    size_keys,
    sizes as declared_sizes,
    sources,
    unit,
)
from tumble.planning.case import Case
from tumble.planning.model_cost import model_cost, model_cost_part, sentence
from tumble.planning.promise import ON_A_SEAT, growing_promise, promises
from tumble.planning.weights import EQUATION_18, EQUATION_19, NAMES, SOURCES, evaluate, symbols
from tumble.solving.decision import UNCERTAINTY, Decision, Question, remedies_text
from tumble.stand import COMMON, Stand, by_channel, per_channel

CEILING_RAD = 0.01  # beyond it nobody has tried the optimal estimator: what it bears up to here limits nothing
_ROW_INDICES = [NAMES.index(name) for name in ROWS[:-1]]
_NOISE = SOURCES.index("noise")
_TIE = 1e-9
_FULL = 1e-8
_BISECTIONS = 50
_LEAST = 1e-9  # of the ceiling: the smallest size that is tried


@dataclass(frozen=True)
class Requirements:
    """Per source: `limits`, infinite where nothing limits; `set_by`, the row that limits, or None. Per row (7,
    sources): `weights`, and `shares` of the row's limit. `samples`: the fewest that bring the noise of a mean under its
    limit; None where rounding alone exceeds it."""

    limits: Floats
    set_by: tuple[str | None, ...]
    samples: int | None
    weights: Floats
    shares: Floats


def requirements(case: Case, which: str, estimator: str, limit_g: float, split: Floats) -> Requirements:
    """What a limit in g requires of the stand. `split` (sources,): how the sources of a row share it, as parts of its
    square. Raises UsageError where weights do not exist or no number of samples suffices."""
    found = allowed(case, which, estimator, limit_g, split)
    factor = case.stand.limits_over_sigma if which == "published" else 1.0
    return replace(found, samples=samples_on(case.stand, found.limits[_NOISE], factor))


def allowed(case: Case, which: str, estimator: str, limit_g: float, split: Floats) -> Requirements:
    """The requirements without the number of samples. Raises UsageError where weights do not exist."""
    if which == "published":
        gamma = _with_noise_row(case, weights.published(case, estimator, weights.WORST))
    elif estimator == "optimal":
        return _grown(case, limit_g / 3.0, split)
    else:
        gamma = _by_pattern(case, estimator, _sign_patterns()).max(axis=0)
    return _requirements_by_shares(gamma, limit_g / 3.0, split)


def _requirements_by_shares(gamma: Floats, row_limit: float, split: Floats) -> Requirements:
    """The strictest row for every source, by weights (7, sources) that do not depend on the stand. The sources of a row
    share its `row_limit` (g, or relative), with `split` as proportions of its square."""
    counted = gamma > 0.0
    proportions = np.where(counted, split, 0.0)
    shares = row_limit * np.sqrt(proportions / proportions.sum(axis=1, keepdims=True))
    with np.errstate(divide="ignore"):
        by_row = np.divide(shares, gamma, out=np.full(gamma.shape, np.inf), where=counted)
    limits = by_row.min(axis=0)
    strictest = [int(np.argmax(column <= limit * (1.0 + _TIE))) for column, limit in zip(by_row.T, limits)]
    set_by = tuple(ROWS[row] if np.isfinite(limit) else None for row, limit in zip(strictest, limits))
    return Requirements(limits, set_by, 1, gamma, shares)


def samples_on(stand: Stand, limit_v: float, factor: float = 1.0) -> int | None:
    """The fewest samples whose means are as quiet as required on a stand. `limit_v`: of the worst channel, in `factor`
    standard deviations, with the others in proportion. None where rounding alone leaves more. Raises UsageError as
    samples_for does."""
    noise, rounding = factor * stand.sigmas("noise"), factor * by_channel(stand.rounding)
    left = (limit_v * stand.profile("noise")) ** 2 - rounding**2
    if ((rounding > 0.0) & (left <= 0.0)).any():
        return None
    loudest_first = [channel for channel in np.argsort(-noise) if noise[channel] > 0.0]
    return max((samples_for(noise[channel], math.sqrt(left[channel])) for channel in loudest_first), default=1)


def samples_for(noise_v: float, limit_v: float) -> int:
    """The fewest samples whose mean is as quiet as required. Raises UsageError beyond what a position can hold."""
    wanted = (noise_v / limit_v) ** 2
    if not wanted <= MAX_SAMPLES:
        raise UsageError(
            f"unreachable: the noise of a mean must be under {limit_v:.3g} V, which would take {wanted:.3g} samples of"
            f" {noise_v:.3g} V at each position; at most {MAX_SAMPLES} fit"
        )
    return max(1, math.ceil(wanted * (1.0 - _TIE)))


def _by_pattern(case: Case, estimator: str, patterns: Floats) -> Floats:
    """Weights (n, 7, sources) of ROWS for choices of the misalignments' signs, `patterns` (n, 3, 3)."""
    schedule, common = case.fitted, case.stand.remounting == COMMON
    fixed = None if estimator in (INCLINED, OPTIMAL) else weights.estimator_gains(case, estimator, case.nominal_k())
    found = []
    for pattern in patterns:
        k = case.nominal_k(pattern)
        gain_rows = weights.estimator_gains(case, estimator, k) if fixed is None else fixed
        gamma = weights.absolute_weights(schedule, common, k, gain_rows, weights.sources_of(case), case.stand)
        found.append(_with_noise_row(case, gamma / weights.reference_values(k)[:, None]))
    return np.array(found)


def _sign_patterns() -> Floats:
    """All 64 choices of signs of the misalignments: (64, 3, 3), ones on the diagonal."""
    patterns = np.ones((64, 3, 3))
    patterns[:, ~np.eye(3, dtype=bool)] = list(product((1.0, -1.0), repeat=6))
    return patterns


def _with_noise_row(case: Case, gamma: Floats) -> Floats:
    """Weights (12, sources) of all coefficients to those (7, sources) of ROWS."""
    noise_alone = np.zeros(gamma.shape[1])
    noise_alone[_NOISE] = 1.0 / case.full_scale["noise"]
    return np.vstack([gamma[_ROW_INDICES], noise_alone])


def stand_of(case: Case, sizes: Floats) -> Case:
    """The case on a stand with these standard deviations. The noise is that of a mean; rounding keeps its share of
    it."""
    axis_tilt, level, remount, angle, size, *rest = map(float, sizes)
    of_means, total = size * case.stand.profile("noise"), case.stand.mean_sigma(case.stand.samples)
    part = np.divide(by_channel(case.stand.rounding), total, out=np.zeros(3), where=total > 0.0)
    noise, rounding = (per_channel(of_means * share) for share in (np.sqrt(1.0 - part**2), part))
    further: Any = dict(zip(weights.sources_of(case)[len(SOURCES) :], rest))
    if "drift" in further:
        further["drift"] = per_channel(further["drift"] * case.stand.profile("drift"))
    further |= {"remounting": case.stand.remounting, "rounding": rounding}
    stand = Stand(axis_tilt, level, remount, angle, noise, 1, "sigma1", **further)
    return replace(case, stand=stand, step_v=0.0)


def _optimal_terms(case: Case, sizes: Floats, patterns: Floats) -> Floats:
    """Terms (n, 7, sources) of the rows with optimal weights for a stand of these sizes, for choices of the
    misalignments' signs."""
    return _by_pattern(stand_of(case, sizes), "optimal", patterns) * sizes


def _ceilings(case: Case) -> Floats:
    """The largest sizes to try (sources,): CEILING_RAD for angles, 1 g for outputs."""
    return np.array([case.full_scale.get(name, CEILING_RAD) for name in weights.sources_of(case)])


def _grown(case: Case, row_limit: float, split: Floats) -> Requirements:
    """Requirements of the optimal estimator, whose weights follow the stand. It is never worse than a linear one, so
    the limits of a linear one are allowed. From there, every angle that fits goes to the ceiling, least influential
    first; the others grow in proportion until the rows are full."""

    def worst_terms(sizes: Floats) -> tuple[Floats, Floats]:
        """Terms (7, sources) and total (7,) of every row, under the signs that are worst for its total."""
        found = _optimal_terms(case, sizes, _sign_patterns())
        totals = np.linalg.norm(found, axis=2)
        worst, rows = totals.argmax(axis=0), np.arange(len(ROWS))
        return found[worst, rows], totals[worst, rows]

    def fit(sizes: Floats) -> bool:
        return bool(worst_terms(sizes)[1].max() <= row_limit * (1.0 + _FULL))

    linear = "least_squares" if case.terms or circles(case.fitted) is None else "refined"
    start = _requirements_by_shares(_by_pattern(case, linear, _sign_patterns()).max(axis=0), row_limit, split)
    ceiling = _ceilings(case)
    sizes = np.minimum(start.limits, ceiling)
    if not fit(sizes):
        raise UsageError("unreachable: no optimal weights can be made for noise as low as this limit asks for")
    angles = np.flatnonzero(np.arange(len(sizes)) != _NOISE)
    raised = [np.where(np.arange(len(sizes)) == angle, ceiling, sizes) for angle in angles]
    for angle in angles[np.argsort([worst_terms(one)[1].max() for one in raised])]:
        tried = np.where(np.arange(len(sizes)) == angle, ceiling, sizes)
        sizes = tried if fit(tried) else sizes
    set_by: list[str | None] = [None] * len(sizes)
    growing = sizes < ceiling
    while growing.any():

        def grown(factor: float, sizes: Floats = sizes, growing: Flags = growing) -> Floats:
            return np.where(growing, np.minimum(sizes * factor, ceiling), sizes)

        most = float((ceiling / sizes)[growing].max())
        sizes = grown(_largest(case, grown, 1.0, most, row_limit, row_limit * (1.0 + _FULL)))
        terms, totals = worst_terms(sizes)
        full = totals >= row_limit * (1.0 - _FULL)
        stopped = growing & (terms[full] > 0.0).any(axis=0)
        for source in np.flatnonzero(stopped):
            set_by[source] = ROWS[int(np.argmax(np.where(full, terms[:, source], -1.0)))]
        growing = growing & ~stopped & (sizes < ceiling)
    limits = np.where([name is None for name in set_by], np.inf, sizes)
    return Requirements(limits, tuple(set_by), 1, np.divide(terms, sizes), terms)


def _largest(
    case: Case, sizes_at: Callable[[float], Floats], least: float, most: float, row_limit: float, full: float
) -> float:
    """The largest factor from `least` to `most` with which no row of the optimal estimator exceeds `row_limit`, by
    bisection of its logarithm; `least` if there is none. Sign patterns that are worst at the solution are added until
    none makes a row exceed `full`."""
    every = _sign_patterns()
    chosen: list[int] = []

    def totals(factor: float, patterns: Floats) -> Floats:
        """Totals of the worst row, for each choice of signs."""
        largest: Floats = np.linalg.norm(_optimal_terms(case, sizes_at(factor), patterns), axis=2).max(axis=1)
        return largest

    while True:
        low, high = least, most
        if chosen and totals(high, every[chosen]).max() > row_limit:
            for _ in range(_BISECTIONS):
                middle = (low * high) ** 0.5
                low, high = (middle, high) if totals(middle, every[chosen]).max() <= row_limit else (low, middle)
            high = low
        found = totals(high, every)
        pattern = int(found.argmax())
        if found.max() <= full or pattern in chosen or high == least:
            return high
        chosen.append(pattern)


@dataclass(frozen=True)
class Headroom:
    """`alone` (sources,): the largest size of one source while the others stay as declared; infinite where nothing
    limits, 0 where the others use it up. `margin`: the factor by which all may grow together, below 1 on a stand that
    fails, infinite for a stand without errors."""

    alone: Floats
    margin: float


def headroom(case: Case, which: str, estimator: str, limit_g: float) -> Headroom:
    """The headroom of the case's stand for a third of the limit in every row and the worst signs of the misalignments.
    The optimal estimator is recomputed for every stand tried."""
    row_limit, sizes = limit_g / 3.0, declared_sizes(case, which == "published")
    if which == "published":
        gamma = _with_noise_row(case, weights.published(case, estimator, weights.WORST))[None]
    else:
        gamma = _by_pattern(stand_of(case, sizes), estimator, _sign_patterns())
    if estimator == "optimal":  # whose uncertainties grow with every source
        declared, alone = stand_of(case, sizes), np.empty(len(sizes))
        for source, most in enumerate(_ceilings(case).tolist()):
            own, least = np.arange(len(sizes)) == source, _LEAST * most

            def sizes_at(size: float, own: Flags = own) -> Floats:
                return np.where(own, size, sizes)

            size = _largest(declared, sizes_at, least, most, row_limit, row_limit)
            alone[source] = 0.0 if size == least else math.inf if size == most else size
    else:
        terms = (gamma * sizes) ** 2
        left = row_limit**2 - (terms.sum(axis=2, keepdims=True) - terms)
        rest = np.sqrt(np.maximum(left, 0.0))
        possible = np.divide(rest, gamma, out=np.where(left >= 0.0, np.inf, 0.0), where=gamma > 0.0)
        alone = possible.min(axis=(0, 1))
    return Headroom(alone, _margin(gamma, sizes, row_limit))


def margins(case: Case, limit_g: float) -> dict[str, float]:
    """The margin of the case's stand with derived weights, for every estimator that the schedule allows."""
    sizes, found = declared_sizes(case, False), {}
    for estimator in weights.estimators_of(case):
        with suppress(UsageError):  # the schedule lacks positions that it needs
            gamma = _by_pattern(stand_of(case, sizes), estimator, _sign_patterns())
            found[estimator] = _margin(gamma, sizes, limit_g / 3.0)
    return found


def _margin(gamma: Floats, sizes: Floats, row_limit: float) -> float:
    largest = np.linalg.norm(gamma * sizes, axis=2).max()
    return float(row_limit / largest) if largest > 0.0 else np.inf


_SETTLED = 1e-4
_STAND_STEPS = 20


def enough(case: Case, estimator: str, limits: Floats, probability: float) -> Enough | None:
    """The stand that is just good enough: `limits` (one for each source, infinite where no row limits) times a factor;
    None where no factor reaches the probability. Raises UsageError where no number of samples suffices."""
    declared, limited = declared_sizes(case, False), np.isfinite(limits)
    factor = 1.0
    for _ in range(_STAND_STEPS):
        sizes = np.where(limited, factor * limits, declared)
        growth = growing_promise(stand_of(case, sizes), estimator, probability).growth
        growth = math.inf if growth is None else growth
        if abs(growth - 1.0) <= _SETTLED:
            samples = samples_on(case.stand, float(sizes[SOURCES.index("noise")]))
            return Enough(**by_key(case, sources(case, False), sizes), samples=samples, factor=factor)
        factor *= growth
    return None


# Which row each printed formula of (19) comes from; that for alpha3 comes from none.
_PRINTED_FROM: OfSources[str | None] = OfSources("a0_y", "K_yy", None, "K_yy", "noise")


def printed(case: Case, formulas: dict[str, str], limit_g: float) -> dict[str, float]:
    """Values of the paper's formulas by source, for the case's block."""
    values = {name: abs(value) for name, value in symbols(case.nominal_k()).items()}
    values.update({"dg": limit_g, "a_ij": case.misalignment, "K_ii": case.full_scale["noise"]})
    return {source: evaluate(formula, values) for source, formula in formulas.items()}


def require(case: Case, which: Weights, estimator: str, split: Floats, probability: float) -> Require:
    """All that the limit of a case requires of its stand. `split`: as for `requirements`. `published` has (19) as
    printed and the result of the rule. Raises UsageError."""
    published, limit_g = which == "published", case.limit_g
    found, room = requirements(case, which, estimator, limit_g, split), headroom(case, which, estimator, limit_g)
    of_all, just, promised = {estimator: room.margin}, None, None
    if not published:
        of_all, just = margins(case, limit_g), enough(case, estimator, found.limits, probability)
        promised = promises(case, probability)

    def finite(value: float) -> float | None:
        """Null where nothing limits."""
        return float(value) if np.isfinite(value) else None

    def as_printed(formulas: dict[str, str]) -> dict[str, Any]:
        values = printed(case, formulas, limit_g)
        return {key: finite(value) for key, value in zip(size_keys(tuple(values)), values.values())}

    names = sources(case, published)
    limits, set_by = by_key(case, names, found.limits), OfSources(**dict(zip(names, found.set_by)))
    rule: Rule | UnsetType = UNSET
    equation_18: Equation18 | UnsetType = UNSET
    if published:
        rule = Rule(**limits, samples=found.samples, set_by=set_by)
        equation_18 = Equation18(**as_printed(EQUATION_18))
        limits, set_by = as_printed(EQUATION_19), _PRINTED_FROM
    own = None if promised is None else promised[estimator]
    would_show = None
    if own is not None and not own.shown:
        as_declared = np.zeros((len(case.schedule.positions), 3)), by_channel(case.stand.rounding) ** 2
        question = Question(case.propagation(estimator), *as_declared, case.limit_g, case.coverage_factor)
        would_show = tuple(question.answers())
    return Require(
        weights=which,
        estimator=estimator,
        limit_g=limit_g,
        **limits,
        samples=found.samples,
        set_by=set_by,
        rule=rule,
        equation_18=equation_18,
        numbers=numbers_are(which),
        split=OfSources(**dict(zip(names, split.tolist()))),
        rows={
            name: Row(limit_g / 3.0, tuple(weights.tolist()), tuple(shares.tolist()))
            for name, weights, shares in zip(ROWS, found.weights, found.shares)
        },
        declared=SourceSizes(**by_key(case, names, declared_sizes(case, published))),
        alone=SourceLimits(**by_key(case, names, room.alone)),
        margin=finite(room.margin),
        margins={name: finite(margin) for name, margin in of_all.items()},
        probability=None if promised is None else probability,
        promise=own,
        promises=promised,
        just_enough=just,
        would_show=would_show,
        extended=model_cost_part(model_cost(case, estimator)),
    )


_AT_MOST = "at most: all sources at once, each at an equal share of the row named (--split)"
_AT_MOST_OPTIMAL = "at most: all at once; as refined allows, scaled until the named row is full"
_NO_NUMBER = "no number of samples reaches this noise"


def show(plan: Require, case: Case) -> None:
    """Print the requirements for people."""
    published, just = plan.weights == "published", plan.just_enough
    asked = "" if plan.probability is None else f"{100.0 * plan.probability:g} %"
    out = tables.console()
    if plan.promises:
        answer = _answer(plan.estimator, plan.promises)
        out.print(f"Does this stand reach {plan.limit_g:g} g? {answer}.", style="bold")
        out.print()
    out.print(tables.heading(f"Requirements for {plan.limit_g:g} g, {plan.weights} weights, {plan.estimator}"))
    out.print(f"{case.block_sentence}; numbers are {plan.numbers}")
    rule = plan if plan.rule is UNSET else plan.rule
    rows, shown = [], []
    for source, key in zip(sources(case, published), size_keys(sources(case, published))):
        limit, alone, has = (_most(getattr(of, key)) for of in (rule, plan.alone, plan.declared))
        size, has = _most(getattr(plan if published else just, key, None)), has or 0.0
        suffices = "as it is" if not published and limit is None and size is not None else tables.scientific(size)
        cells = [source, unit(source), suffices, _limit(limit), getattr(rule.set_by, source) or "-"]
        within = "within" if limit is None or has <= limit else "over"
        rows.append([*cells, tables.scientific(has), within, _limit(alone)])
        shown += [limit, alone]
    added = "(19)" if published else f"for {asked}"
    headings = ["", "unit", added, "at most", "set by", "stand has", "its share", "alone"]
    out.print(tables.table(headings, rows, left=(0, 1)))
    samples = _NO_NUMBER if plan.samples is None else f"{plan.samples} at least"
    suffice = None if just is None else just.samples or _NO_NUMBER
    samples += "" if suffice in (None, samples) else f", {suffice} for {asked}"
    out.print(f"Samples at each position: {samples}; the stand has {case.stand.samples}")
    out.print(ALPHAS)
    if not published and just is None:
        out.print(f"for {asked}: out of reach while sources without a limit stay as they are")
    elif just is not None:
        out.print(f"for {asked}: {just.factor:.3g} times at most; then run and |a| are within the limit with {asked}")
    optimal = plan.estimator == "optimal"
    out.print(_AT_MOST_OPTIMAL if optimal else _AT_MOST)
    out.print("its share: may be exceeded if others stay below theirs; the last table decides")
    out.print("alone: one source, the others as the stand has them")
    if 0.0 in shown:
        out.print("none left: the others alone exceed the limit already")
    if None in shown:
        up_to = f" up to {CEILING_RAD:g} rad, as far as was tried" if optimal else ""
        out.print(f"no limit: the source limits nothing{up_to}")
    for line in notes(case):
        out.print(line)
    if published:
        out.print("(19): as printed; at most: what its own rule gives (see tumble plan paper)")
    out.print()
    if published:
        _show_margins(out, plan)
    else:
        _show_promises(out, plan, asked)
    if plan.extended is not UNSET:
        out.print(sentence(plan.extended))


def _answer(estimator: str, promises: dict[Any, GrowingPromise]) -> str:
    """Whether the stand is good enough for an estimator; else, for which others."""
    others = [name for name, one in promises.items() if _reaches(one)]
    if estimator in others:
        return f"Yes with {estimator}"
    return f"No with {estimator}; yes with --estimator {listed(others, 'or')}" if others else "No, with any estimator"


def _reaches(one: GrowingPromise) -> bool:
    return one.growth is None or one.growth >= 1.0


def _most(size: Any) -> float | None:
    """The worst channel, where there are three."""
    largest: float | None = max(size) if isinstance(size, tuple) else size
    return largest


def _limit(value: float | None) -> str:
    return "no limit" if value is None else "none left" if value == 0.0 else tables.scientific(value)


def _show_margins(out: Console, plan: Require) -> None:
    """Whether the stand is good enough by the paper's rule."""
    width = max(map(len, plan.margins))
    out.print(f"This stand reaches {plan.limit_g:g} g", style="bold")
    for name, margin in plan.margins.items():
        verdict = "yes" if margin is None or margin >= 1.0 else "no"
        reached = "no errors" if margin is None else f"margin {margin:.3g}"
        out.print(f"  with {name + ':':{width + 1}} {verdict} ({reached})", style="bold")
    out.print("Margin: the factor by which all its errors may grow until a row is full.", style="bold")


_PROMISED = """\
passes: probability that a run passes the gravity check; every attitude: that
the error of |a| is within the limit at all of them; both of the nominal block
u(|a|): its largest standard uncertainty; a run whose {factor:g} u(|a|) exceeds the limit is no PASS
may grow: all stand errors may be this many times larger before fewer than {asked}
of runs pass
margin: how far the worst row of errors is from a third of the limit; not a
probability"""


def _show_promises(out: Console, plan: Require, asked: str) -> None:
    """Whether the stand is good enough, with every estimator."""
    own, promises = plan.promise, plan.promises
    assert own is not None and promises is not None  # with derived weights
    out.print(f"Does this stand reach {plan.limit_g:g} g with a probability of {asked}?", style="bold")
    rows = []
    for name, one in promises.items():
        growth, margin = ("no errors" if of is None else f"{of:.3g}" for of in (one.growth, plan.margins[name]))
        reaches = "yes" if _reaches(one) else "no"
        reach = tables.scientific(one.coverage_factor * one.u_norm_worst_g)
        passes, everywhere = tables.percent(one.passes), tables.percent(one.every_attitude)
        rows.append((name, reaches, passes, everywhere, reach, growth, margin))
    headings = ("with", "", "passes", "every attitude", f"{own.coverage_factor:g} u(|a|), g", "may grow", "margin")
    out.print(tables.table(headings, rows, left=(0, 1)))
    out.print(_PROMISED.format(asked=asked, factor=own.coverage_factor))
    if own.assumes:
        out.print(ON_A_SEAT)
    if not own.shown:  # as a run that is solved says it
        rule = own.limit_g, own.coverage_factor, own.u_norm_worst_g
        not_shown = Decision((UNCERTAINTY,), own.assumes, 0, *rule).sentence
        remedies = remedies_text(plan.would_show or (), own.limit_g)
        out.print(f"{plan.estimator}: {not_shown}. {remedies}.", style="bold")
