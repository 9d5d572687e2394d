"""What an accuracy asks of a stand, and how much room a declared one has.

Requirements, inverse to the budget: how bad each source of a stand may be for a limit of the gravity check.

By (10), (13) and (14) the six scale factors and biases, and the noise of a mean on its own, may each take a third of
the limit. In each of these rows the sources that enter it share that third; a source's requirement is what the
strictest row allows it. `derived`: worst signs of the misalignments, sizes as standard deviations. The optimal
estimator's weights follow the stand, so its requirements are those of a stand for which it was made, with full rows.

Headroom of a declared stand: how much worse its sources may become before a row of the requirements is exceeded.

`alone`: the largest size of one source while the others stay as declared. `margin`: the factor by which all may grow
together. The optimal estimator is made anew for every stand that is tried.

How good a stand must be to be just enough: the requirements, scaled until the probability that the user asks for is
reached, of passing the gravity check and of |a| within the limit at every attitude.

The requirements' own rule, a third of the limit for each row, promises no probability. It says here how the sources
compare; one factor for all of them sets the probability. Sources that no row limits stay as the stand has them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import UNSET, UnsetType

from tumble.arrays import Flags, Floats
from tumble.core import MAX_SAMPLES
from tumble.documents import result
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
from tumble.errors import UsageError
from tumble.model.estimators import circles
from tumble.planning import weights
from tumble.planning.budget import (
    ALPHAS,
    by_key,
    notes,
    numbers_are,
    size_keys,
    sizes,
    sizes as declared_sizes,
    sources,
    unit,
)
from tumble.planning.case import Case
from tumble.planning.model_cost import model_cost_part
from tumble.planning.promise import ON_A_SEAT, growing_promise
from tumble.planning.weights import EQUATION_18, EQUATION_19, NAMES, SOURCES, evaluate, symbols
from tumble.solving.decision import UNCERTAINTY, Decision, Question, in_words
from tumble.solving.uncertainty import Further
from tumble.stand import COMMON, Stand, by_channel, per_channel

if TYPE_CHECKING:
    from rich.console import Console


CEILING_RAD = 0.01  # beyond it nobody has tried the optimal estimator: what it bears up to here limits nothing
_ROW_INDICES = [NAMES.index(name) for name in ROWS[:-1]]
_NOISE = SOURCES.index("noise")
_TIE = 1e-9
_FULL = 1e-8
_BISECTIONS = 50


@dataclass(frozen=True)
class Requirements:
    """Per source: `limits`, infinite where nothing limits; `set_by`, the row that does, or None. Per row (7, sources):
    `weights`, and `shares` of the row's limit. `samples`: the fewest that bring the noise of a mean under its limit;
    None where rounding alone is above it."""

    limits: Floats
    set_by: tuple[str | None, ...]
    samples: int | None
    weights: Floats
    shares: Floats


def requirements(case: Case, which: str, estimator: str, limit_g: float, split: Floats) -> Requirements:
    """What a limit in g asks of the stand. `split` (sources,): how those of a row share it, as parts of its square.

    Raises UsageError where weights do not exist or no number of samples suffices.
    """
    found = allowed(case, which, estimator, limit_g, split)
    factor = case.stand.limits_over_sigma if which == "published" else 1.0
    return replace(found, samples=samples_on(case.stand, found.limits[_NOISE], factor))


def allowed(case: Case, which: str, estimator: str, limit_g: float, split: Floats) -> Requirements:
    """The same, without asking how many samples it takes. Raises UsageError where weights do not exist."""
    share_of = _Shares(limit_g / 3.0, split)
    if which == "published":
        gamma = with_noise_row(case, weights.published(case, estimator, weights.WORST))
    elif estimator == "optimal":
        return _grown(case, share_of)
    else:
        gamma = worst_weights(case, estimator)
    return share_of.requirements(gamma, gamma > 0.0)


def samples_on(stand: Stand, limit_v: float, factor: float = 1.0) -> int | None:
    """The fewest samples whose means are as quiet as required on a stand: `limit_v` is that of the channel that has
    most, in `factor` standard deviations, the others' in proportion. None where rounding alone leaves more. Raises
    UsageError as samples_for."""
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


def worst_weights(case: Case, estimator: str) -> Floats:
    """Weights (7, sources) of ROWS, each under the signs of the misalignments that are worst for it."""
    worst: Floats = weights_by_pattern(case, estimator, sign_patterns()).max(axis=0)
    return worst


def weights_by_pattern(case: Case, estimator: str, patterns: Floats) -> Floats:
    """Weights (n, 7, sources) of ROWS for choices of the misalignments' signs, `patterns` (n, 3, 3)."""
    schedule, common = case.fitted, case.stand.remounting == COMMON
    fixed = None if estimator == "optimal" else weights.estimator_gains(case, estimator, case.nominal_k())
    found = []
    for pattern in patterns:
        k = case.nominal_k(pattern)
        gain_rows = weights.estimator_gains(case, estimator, k) if fixed is None else fixed
        gamma = weights.absolute_weights(schedule, common, k, gain_rows, weights.sources_of(case.stand), case.stand)
        found.append(with_noise_row(case, gamma / weights.reference_values(k)[:, None]))
    return np.array(found)


def ceilings(case: Case) -> Floats:
    """The largest sizes that are tried (sources,): of angles CEILING_RAD, of outputs 1 g."""
    return np.array([case.full_scale.get(name, CEILING_RAD) for name in weights.sources_of(case.stand)])


def sign_patterns() -> Floats:
    """All 64 choices of signs of the misalignments: (64, 3, 3), ones on the diagonal."""
    patterns = np.ones((64, 3, 3))
    patterns[:, ~np.eye(3, dtype=bool)] = list(product((1.0, -1.0), repeat=6))
    return patterns


def with_noise_row(case: Case, gamma: Floats) -> Floats:
    """Weights (12, sources) of all coefficients to those (7, sources) of ROWS."""
    noise_alone = np.zeros(gamma.shape[1])
    noise_alone[_NOISE] = 1.0 / case.full_scale["noise"]
    return np.vstack([gamma[_ROW_INDICES], noise_alone])


@dataclass(frozen=True)
class _Shares:
    """How the sources share a row of size `row_limit` (g, or relative): `split` (5,) as proportions of its square."""

    row_limit: float
    split: Floats

    def shares(self, counted: Flags) -> Floats:
        """What each source may take of each row (7, 5); 0 where it is not counted."""
        proportions = np.where(counted, self.split, 0.0)
        sizes: Floats = self.row_limit * np.sqrt(proportions / proportions.sum(axis=1, keepdims=True))
        return sizes

    def requirements(self, gamma: Floats, counted: Flags) -> Requirements:
        """The strictest row for every source."""
        shares = self.shares(counted)
        with np.errstate(divide="ignore"):
            allowed = np.divide(shares, gamma, out=np.full(gamma.shape, np.inf), where=counted)
        limits = allowed.min(axis=0)
        strictest = [int(np.argmax(column <= limit * (1.0 + _TIE))) for column, limit in zip(allowed.T, limits)]
        set_by = tuple(ROWS[row] if np.isfinite(limit) else None for row, limit in zip(strictest, limits))
        return Requirements(limits, set_by, 1, gamma, shares)


def stand_of(case: Case, sizes: Floats) -> Case:
    """The case on a stand with these standard deviations; the noise is that of a mean, and rounding has the part of it
    that it has on the case's own."""
    axis_tilt, level, remount, angle, size, *rest = map(float, sizes)
    of_means, total = size * case.stand.profile("noise"), case.stand.mean_sigma(case.stand.samples)
    part = np.divide(by_channel(case.stand.rounding), total, out=np.zeros(3), where=total > 0.0)
    noise, rounding = (per_channel(of_means * share) for share in (np.sqrt(1.0 - part**2), part))
    further: Any = dict(zip(weights.sources_of(case.stand)[len(SOURCES) :], rest))
    if "drift" in further:
        further["drift"] = per_channel(further["drift"] * case.stand.profile("drift"))
    further |= {"remounting": case.stand.remounting, "rounding": rounding}
    stand = Stand(axis_tilt, level, remount, angle, noise, 1, "sigma1", **further)
    return replace(case, stand=stand, step_v=0.0)


def _grown(case: Case, share_of: _Shares) -> Requirements:
    """Requirements of the optimal estimator, whose weights follow the stand.

    It is never worse than a linear one, so what that one allows is allowed. From there every angle that fits, the least
    felt first, goes to the ceiling; what is left grows in proportion until the rows are full.
    """
    estimator = "least_squares" if case.terms or circles(case.fitted) is None else "refined"
    start = worst_weights(case, estimator)
    ceiling = ceilings(case)
    sizes = np.minimum(share_of.requirements(start, start > 0.0).limits, ceiling)
    rows = _Rows(case, share_of.row_limit)
    if not rows.fit(sizes):
        raise UsageError("unreachable: no optimal weights can be made for noise as low as this limit asks for")
    angles = np.flatnonzero(np.arange(len(sizes)) != _NOISE)
    raised = [np.where(np.arange(len(sizes)) == angle, ceiling, sizes) for angle in angles]
    for angle in angles[np.argsort([rows.terms(one)[1].max() for one in raised])]:
        tried = np.where(np.arange(len(sizes)) == angle, ceiling, sizes)
        sizes = tried if rows.fit(tried) else sizes
    set_by: list[str | None] = [None] * len(sizes)
    growing = sizes < ceiling
    while growing.any():
        sizes = rows.grow(sizes, growing, ceiling)
        terms, totals = rows.terms(sizes)
        full = totals >= share_of.row_limit * (1.0 - _FULL)
        stopped = growing & (terms[full] > 0.0).any(axis=0)
        for source in np.flatnonzero(stopped):
            set_by[source] = ROWS[int(np.argmax(np.where(full, terms[:, source], -1.0)))]
        growing = growing & ~stopped & (sizes < ceiling)
    limits = np.where([name is None for name in set_by], np.inf, sizes)
    return Requirements(limits, tuple(set_by), 1, np.divide(terms, sizes), terms)


@dataclass(frozen=True)
class _Rows:
    """The rows of a case with optimal weights made for the stand that is asked about."""

    case: Case
    row_limit: float

    def by_pattern(self, sizes: Floats, patterns: Floats) -> Floats:
        """Terms (n, 7, 5) for choices of the misalignments' signs."""
        return weights_by_pattern(stand_of(self.case, sizes), "optimal", patterns) * sizes

    def terms(self, sizes: Floats) -> tuple[Floats, Floats]:
        """Terms (7, 5) and total (7,) of every row, under the signs that are worst for its total."""
        found = self.by_pattern(sizes, sign_patterns())
        totals = np.linalg.norm(found, axis=2)
        worst, rows = totals.argmax(axis=0), np.arange(len(ROWS))
        return found[worst, rows], totals[worst, rows]

    def fit(self, sizes: Floats) -> bool:
        """Whether no row is more than full."""
        return bool(self.terms(sizes)[1].max() <= self.row_limit * (1.0 + _FULL))

    def grow(self, sizes: Floats, growing: Flags, ceiling: Floats) -> Floats:
        """The same with some larger by one factor, up to the ceiling, such that a row is full if any can be. Signs that
        are worst at what was found are added until none is worse."""
        every = sign_patterns()
        chosen: list[int] = []
        most = float((ceiling / sizes)[growing].max())

        def grown(factor: float) -> Floats:
            return np.where(growing, np.minimum(sizes * factor, ceiling), sizes)

        def worst(factor: float, patterns: Floats) -> tuple[float, int]:
            totals = np.linalg.norm(self.by_pattern(grown(factor), patterns), axis=2).max(axis=1)
            return float(totals.max()), int(totals.argmax())

        while True:
            low, high = 1.0, most
            if chosen and worst(high, every[chosen])[0] > self.row_limit:
                for _ in range(_BISECTIONS):
                    middle = (low * high) ** 0.5
                    low, high = (middle, high) if worst(middle, every[chosen])[0] <= self.row_limit else (low, middle)
                high = low
            total, pattern = worst(high, every)
            if total <= self.row_limit * (1.0 + _FULL) or pattern in chosen:
                return grown(high)
            chosen.append(pattern)


_STEPS = 50


@dataclass(frozen=True)
class Headroom:
    """`alone` (sources,): infinite where nothing limits, 0 where the others take all; `margin`: below 1 on a stand that
    fails; infinite for a stand without errors."""

    alone: Floats
    margin: float


def headroom(case: Case, which: str, estimator: str, limit_g: float) -> Headroom:
    """Of the case's stand, against a third of the limit in every row, for the worst signs of the misalignments."""
    row_limit, sizes = limit_g / 3.0, declared_sizes(case, which == "published")
    gamma = _weights(case, which, estimator, sizes)
    if estimator == "optimal":
        declared = stand_of(case, sizes)
        alone = np.array([_bisect(declared, sizes, source, row_limit) for source in range(len(sizes))])
    else:
        alone = _closed_form(gamma, sizes, row_limit)
    return Headroom(alone, _margin(gamma, sizes, row_limit))


def margins(case: Case, limit_g: float) -> dict[str, float]:
    """The margin of the case's stand with every estimator that its schedule allows, derived weights."""
    sizes, found = declared_sizes(case, False), {}
    for estimator in weights.estimators_of(case):
        with suppress(UsageError):  # the schedule lacks positions that it needs
            found[estimator] = _margin(_weights(case, "derived", estimator, sizes), sizes, limit_g / 3.0)
    return found


def _weights(case: Case, which: str, estimator: str, sizes: Floats) -> Floats:
    """Weights (patterns, 7, 5)."""
    if which == "published":
        return with_noise_row(case, weights.published(case, estimator, weights.WORST))[None]
    return weights_by_pattern(stand_of(case, sizes), estimator, sign_patterns())


def _margin(gamma: Floats, sizes: Floats, row_limit: float) -> float:
    largest = np.linalg.norm(gamma * sizes, axis=2).max()
    return float(row_limit / largest) if largest > 0.0 else np.inf


def _closed_form(gamma: Floats, sizes: Floats, row_limit: float) -> Floats:
    """What each source may be where the weights (patterns, 7, 5) do not depend on the stand."""
    terms = (gamma * sizes) ** 2
    left = row_limit**2 - (terms.sum(axis=2, keepdims=True) - terms)
    rest = np.sqrt(np.maximum(left, 0.0))
    allowed = np.divide(rest, gamma, out=np.where(left >= 0.0, np.inf, 0.0), where=gamma > 0.0)
    smallest: Floats = allowed.min(axis=(0, 1))
    return smallest


def _bisect(case: Case, sizes: Floats, source: int, row_limit: float) -> float:
    """The same for the optimal estimator, whose uncertainties grow with every source. Signs that are worst at the size
    found are added until none is worse."""
    every = sign_patterns()
    chosen: list[int] = []

    def worst(size: float, patterns: Floats) -> tuple[float, int]:
        tried = np.where(np.arange(len(sizes)) == source, size, sizes)
        gamma = weights_by_pattern(stand_of(case, tried), "optimal", patterns)
        totals = np.linalg.norm(gamma * tried, axis=2).max(axis=1)
        return float(totals.max()), int(totals.argmax())

    ceiling = float(ceilings(case)[source])
    while True:
        size = _largest(lambda size: worst(size, every[chosen])[0] <= row_limit, ceiling) if chosen else ceiling
        total, pattern = worst(size, every)
        if total <= row_limit or pattern in chosen or size == 0.0:
            return np.inf if size == ceiling else size
        chosen.append(pattern)


def _largest(fits: Callable[[float], bool], ceiling: float) -> float:
    """The largest size that fits, found in logarithms: 0 if none does, the ceiling if all do."""
    low, high = 1e-9 * ceiling, ceiling
    if fits(high):
        return high
    if not fits(low):
        return 0.0
    for _ in range(_STEPS):
        middle = (low * high) ** 0.5
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low


_SETTLED = 1e-4
_STAND_STEPS = 20


def enough(case: Case, estimator: str, limits: Floats, probability: float) -> Enough | None:
    """What is just enough for requirements `limits`, one a source, infinite where no row limits; None where no factor
    reaches the probability. Raises UsageError where no number of samples suffices."""
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


def _printed_limits(case: Case, formulas: dict[str, str], limit_g: float) -> dict[str, Any]:
    found = printed(case, formulas, limit_g)
    return {key: finite(value) for key, value in zip(size_keys(tuple(found)), found.values())}


def document(
    found: Requirements,
    room: Headroom,
    margins: dict[str, float],
    just: Enough | None,
    promised: dict[str, GrowingPromise] | None,
    case: Case,
    which: Weights,
    estimator: str,
    limit_g: float,
    split: Floats,
    probability: float,
    further: Further | None,
) -> Require:
    """The requirements for JSON. `published` has (19) as printed, and beside it what the rule gives."""
    names, published = sources(case, which == "published"), which == "published"
    limits, set_by = by_key(case, names, found.limits), OfSources(**dict(zip(names, found.set_by)))
    rule: Rule | UnsetType = UNSET
    equation_18: Equation18 | UnsetType = UNSET
    if published:
        rule = Rule(**limits, samples=found.samples, set_by=set_by)
        equation_18 = Equation18(**_printed_limits(case, EQUATION_18, limit_g))
        limits, set_by = _printed_limits(case, EQUATION_19, limit_g), _PRINTED_FROM
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
        declared=SourceSizes(**by_key(case, names, sizes(case, published))),
        alone=SourceLimits(**by_key(case, names, room.alone)),
        margin=finite(room.margin),
        margins={name: finite(margin) for name, margin in margins.items()},
        probability=None if promised is None else probability,
        promise=None if promised is None else promised[estimator],
        promises=promised,
        just_enough=just,
        would_show=None if promised is None or promised[estimator].shown else _would_show(case, estimator),
        extended=model_cost_part(further),
    )


def _would_show(case: Case, estimator: str) -> tuple[result.Remedy, ...]:
    """What would show the limit, where runs on this stand do not."""
    as_declared = np.zeros((len(case.schedule.positions), 3)), by_channel(case.stand.rounding) ** 2
    question = Question(case.propagation(estimator), *as_declared, case.limit_g, case.coverage_factor)
    return tuple(question.answers())


def finite(value: float) -> float | None:
    """A number for JSON: null where nothing limits."""
    return float(value) if np.isfinite(value) else None


def show(plan: Require, case: Case) -> None:
    """Print the requirements for people."""
    from tumble.planning import tables

    published = plan.weights == "published"
    out = tables.console()
    out.print(tables.heading(f"Requirements for {plan.limit_g:g} g, {plan.weights} weights, {plan.estimator}"))
    out.print(f"{case.block_sentence}; numbers are {plan.numbers}")
    rule = plan if plan.rule is UNSET else plan.rule
    added = "(19)" if published else f"for {_asked(plan)}"
    headings = ["", "unit", added, "at most", "set by", "stand has", "its share", "alone"]
    rows, names = [], sources(case, published)
    for key, source in zip(size_keys(names), names):
        limit, alone = (_most(getattr(of, key)) for of in (rule, plan.alone))
        has = _most(getattr(plan.declared, key)) or 0.0
        enough = _most(getattr(plan.just_enough, key, None))
        verdict = "within" if limit is None or has <= limit else "over"
        cells = [source, unit(source)]
        cells += [tables.scientific(getattr(plan, key)) if published else _for_it(enough, limit)]
        cells += [_limit(limit), getattr(rule.set_by, source) or "-"]
        cells += [tables.scientific(has), verdict, _limit(alone)]
        rows.append(cells)
    out.print(tables.table(headings, rows, left=(0, 1)))
    out.print(f"Samples at each position: {_samples(plan)}; the stand has {case.stand.samples}")
    for line in (*_explanations(plan, rule, size_keys(names)), *notes(case)):
        out.print(line)
    if published:
        out.print("(19): as printed; at most: what its own rule gives (see tumble plan paper)")
    out.print()
    if published:
        out.print(_sentence(plan), style="bold")
    else:
        _show_promises(out, plan)


def _most(size: Any) -> float | None:
    """Of the channel that has most, where there are three."""
    largest: float | None = max(size) if isinstance(size, tuple) else size
    return largest


def _for_it(size: float | None, limit: float | None) -> str:
    """For the probability asked for."""
    from tumble.planning import tables

    return "as it is" if limit is None and size is not None else tables.scientific(size)


def _limit(value: float | None) -> str:
    from tumble.planning import tables

    return "no limit" if value is None else "none left" if value == 0.0 else tables.scientific(value)


_AT_MOST = "at most: all sources at once, each at an equal share of the row named (--split)"
_AT_MOST_OPTIMAL = "at most: all at once; as refined allows, scaled until the named row is full"


def _explanations(plan: Require, rule: Require | Rule, keys: tuple[str, ...]) -> list[str]:
    """Of the words in the table."""
    lines = [
        ALPHAS,
        *_for_probability(plan),
        _AT_MOST_OPTIMAL if plan.estimator == "optimal" else _AT_MOST,
        "its share: a source may exceed it if others leave room; the end decides",
        "alone: one source, the others as the stand has them",
    ]
    shown = [_most(getattr(of, key)) for of in (plan.alone, rule) for key in keys]
    if 0.0 in shown:
        lines.append("none left: the others alone exceed the limit already")
    if None in shown:
        up_to = f" up to {CEILING_RAD:g} rad, as far as was tried" if plan.estimator == "optimal" else ""
        lines.append(f"no limit: the source limits nothing{up_to}")
    return lines


def _for_probability(plan: Require) -> list[str]:
    """Of the column that is only there with derived weights."""
    if plan.weights == "published":
        return []
    if plan.just_enough is None:
        return [f"for {_asked(plan)}: out of reach while sources without a limit stay as they are"]
    times = f"{plan.just_enough.factor:.3g} times at most"
    return [f"for {_asked(plan)}: {times}; then run and |a| are within the limit with {_asked(plan)}"]


def _sentence(plan: Require) -> str:
    """Whether the stand will do, by the paper's rule."""
    width = max(map(len, plan.margins))
    found = [
        f"  with {name + ':':{width + 1}} " + ("yes (no errors)" if margin is None else _reached(margin))
        for name, margin in plan.margins.items()
    ]
    meaning = "Margin: the factor by which all its errors may grow until a row is full."
    return "\n".join([f"This stand reaches {plan.limit_g:g} g", *found, meaning])


def _reached(margin: float) -> str:
    return f"{'yes' if margin >= 1.0 else 'no'} (margin {margin:.3g})"


_PROMISED = (
    "passes: probability that a run passes the gravity check; every attitude: that",
    "the error of |a| is within the limit at all of them; both of the nominal block",
    "u(|a|): its largest standard uncertainty; a run whose {factor:g} u(|a|) exceeds the limit is no PASS",
    "may grow: factor for all errors of the stand until the lower of these is {asked},",
    "or until such runs are no PASS any more",
    "margin: factor until a third of the limit is the standard deviation of a row of",
    "scale factors, biases or noise; at 1 it promises no probability",
)


def _show_promises(out: Console, plan: Require) -> None:
    """Whether the stand will do, with every estimator."""
    from tumble.planning import tables

    asked, own, promises = _asked(plan), plan.promise, plan.promises
    assert own is not None and promises is not None  # with derived weights
    out.print(f"Does this stand reach {plan.limit_g:g} g with a probability of {asked}?", style="bold")
    rows = [
        (
            name,
            "yes" if one.growth is None or one.growth >= 1.0 else "no",
            tables.percent(one.passes),
            tables.percent(one.every_attitude),
            tables.scientific(one.coverage_factor * one.u_norm_worst_g),
            _factor(one.growth),
            _factor(plan.margins[name]),
        )
        for name, one in promises.items()
    ]
    reach = f"{own.coverage_factor:g} u(|a|), g"
    out.print(tables.table(("with", "", "passes", "every attitude", reach, "may grow", "margin"), rows, left=(0, 1)))
    for line in _PROMISED:
        out.print(line.format(asked=asked, factor=own.coverage_factor))
    if own.assumes:
        out.print(ON_A_SEAT)
    if not own.shown:
        out.print(f"{plan.estimator}: {_not_shown(plan)}", style="bold")


def _not_shown(plan: Require) -> str:
    """As a run that is solved says it."""
    told, remedies = plan.promise, plan.would_show or ()
    assert told is not None  # with derived weights
    rule = told.limit_g, told.coverage_factor, told.u_norm_worst_g
    decision = Decision((UNCERTAINTY,), told.assumes, 0, *rule)
    return f"{decision.sentence}. {in_words(remedies, decision.limit_g)}."


def _asked(plan: Require) -> str:
    """As 95 %."""
    assert plan.probability is not None  # with derived weights
    return f"{100.0 * plan.probability:g} %"


def _factor(value: float | None) -> str:
    return "no errors" if value is None else f"{value:.3g}"


def _samples(plan: Require) -> str:
    """How many it takes."""
    rule = _NO_NUMBER if plan.samples is None else f"{plan.samples} at least"
    enough = None if plan.just_enough is None else plan.just_enough.samples or _NO_NUMBER
    return rule if enough in (None, rule) else f"{rule}, {enough} for {_asked(plan)}"


_NO_NUMBER = "no number brings such a noise"
