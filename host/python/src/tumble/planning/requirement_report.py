"""Requirements as a JSON document and as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import UNSET, UnsetType

from tumble.arrays import Floats
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
from tumble.planning.budget import ALPHAS, by_key, notes, numbers_are, size_keys, sizes, sources, unit
from tumble.planning.case import Case
from tumble.planning.model_cost import model_cost_part
from tumble.planning.promise import ON_A_SEAT
from tumble.planning.published import EQUATION_18, EQUATION_19, evaluate
from tumble.planning.require import CEILING_RAD, Headroom, Requirements
from tumble.planning.weights import symbols
from tumble.solving.decision import UNCERTAINTY, Decision, Question, in_words
from tumble.solving.further import Further
from tumble.stand import by_channel

if TYPE_CHECKING:
    from rich.console import Console

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
