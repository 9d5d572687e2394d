"""Requirements as a JSON document and as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.arrays import Floats
from tumble.documents.base import written
from tumble.documents.result import Remedy
from tumble.planning.budget import ALPHAS, by_key, notes, numbers_are, size_keys, sizes, sources, unit
from tumble.planning.case import SCHEMA, Case
from tumble.planning.promise import ON_A_SEAT
from tumble.planning.published import EQUATION_18, EQUATION_19, evaluate
from tumble.planning.require import CEILING_RAD, NOT_PROMISED, ROWS, Enough, Headroom, Requirements
from tumble.planning.weights import symbols
from tumble.solving.decision import UNCERTAINTY, Decision, Question, in_words
from tumble.stand import by_channel

if TYPE_CHECKING:
    from rich.console import Console

# Which row each printed formula of (19) comes from; that for alpha3 comes from none.
_PRINTED_FROM = {"alpha1": "a0_y", "alpha2": "K_yy", "alpha3": None, "alpha4": "K_yy", "noise": "noise"}


def printed(case: Case, formulas: dict[str, str], limit_g: float) -> dict[str, float]:
    """Values of the paper's formulas by source, for the case's block."""
    values = {name: abs(value) for name, value in symbols(case.nominal_k()).items()}
    values.update({"dg": limit_g, "a_ij": case.misalignment, "K_ii": case.full_scale["noise"]})
    return {source: evaluate(formula, values) for source, formula in formulas.items()}


def document(
    found: Requirements,
    room: Headroom,
    margins: dict[str, float],
    just: Enough | None,
    case: Case,
    which: str,
    estimator: str,
    limit_g: float,
    split: Floats,
) -> dict[str, Any]:
    """The requirements for JSON, schema tumble.plan/1. `published` has (19) as printed, and beside it what
    the rule gives."""
    names = sources(case, which == "published")
    keys = size_keys(names)
    rule = {
        **by_key(case, names, found.limits),
        "samples": found.samples,
        "set_by": dict(zip(names, found.set_by)),
    }
    head = {"schema": SCHEMA, "plan": "require", "weights": which, "estimator": estimator, "limit_g": limit_g}
    if which == "published":
        general, of_k_yy = (printed(case, formulas, limit_g) for formulas in (EQUATION_19, EQUATION_18))
        main: dict[str, Any] = {key: finite(general[source]) for key, source in zip(keys, names)}
        main.update({"samples": found.samples, "set_by": _PRINTED_FROM, "rule": rule})
        main["equation_18"] = {keys[names.index(source)]: finite(limit) for source, limit in of_k_yy.items()}
    else:
        main = rule
    return {
        **head,
        **main,
        "numbers": numbers_are(which),
        "split": dict(zip(names, split.tolist())),
        "rows": {
            name: {"limit": limit_g / 3.0, "weights": weights.tolist(), "shares": shares.tolist()}
            for name, weights, shares in zip(ROWS, found.weights, found.shares)
        },
        "declared": by_key(case, names, sizes(case, which == "published")),
        "alone": by_key(case, names, room.alone),
        "margin": finite(room.margin),
        "margins": {name: finite(margin) for name, margin in margins.items()},
        **(NOT_PROMISED if just is None else just.document(estimator)),
        "would_show": None if just is None or just.promises[estimator].shown else _would_show(case, estimator),
    }


def _would_show(case: Case, estimator: str) -> list[dict[str, Any]]:
    """What would show the limit, where runs on this stand do not."""
    as_declared = np.zeros((len(case.schedule.positions), 3)), by_channel(case.stand.rounding) ** 2
    question = Question(case.propagation(estimator), *as_declared, case.limit_g, case.coverage_factor)
    return [written(one) for one in question.answers()]


def finite(value: float) -> float | None:
    """A number for JSON: null where nothing limits."""
    return float(value) if np.isfinite(value) else None


def show(plan: dict[str, Any], case: Case) -> None:
    """Print a document of `document` for people."""
    from tumble.planning import tables

    published = plan["weights"] == "published"
    out = tables.console()
    out.print(tables.heading(f"Requirements for {plan['limit_g']:g} g, {plan['weights']} weights, {plan['estimator']}"))
    out.print(f"{case.block_sentence}; numbers are {plan['numbers']}")
    rule = plan["rule"] if published else plan
    added = "(19)" if published else f"for {_asked(plan)}"
    headings = ["", "unit", added, "at most", "set by", "stand has", "its share", "alone"]
    rows, enough = [], plan["just_enough"] or {}
    names = sources(case, published)
    for key, source in zip(size_keys(names), names):
        limit, alone, has = _most(rule[key]), _most(plan["alone"][key]), _most(plan["declared"][key]) or 0.0
        verdict = "within" if limit is None or has <= limit else "over"
        cells = [source, unit(source)]
        cells += [tables.scientific(plan[key]) if published else _for_it(_most(enough.get(key)), limit)]
        cells += [_limit(limit), rule["set_by"][source] or "-"]
        cells += [tables.scientific(has), verdict, _limit(alone)]
        rows.append(cells)
    out.print(tables.table(headings, rows, left=(0, 1)))
    out.print(f"Samples at each position: {_samples(plan)}; the stand has {case.stand.samples}")
    for line in (*_explanations(plan, rule), *notes(case)):
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
    largest: float | None = max(size) if isinstance(size, list) else size
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


def _explanations(plan: dict[str, Any], rule: dict[str, Any]) -> list[str]:
    """Of the words in the table."""
    lines = [
        ALPHAS,
        *_for_probability(plan),
        _AT_MOST_OPTIMAL if plan["estimator"] == "optimal" else _AT_MOST,
        "its share: a source may exceed it if others leave room; the end decides",
        "alone: one source, the others as the stand has them",
    ]
    shown = [_most(of[key]) for of in (plan["alone"], rule) for key in plan["declared"]]
    if 0.0 in shown:
        lines.append("none left: the others alone exceed the limit already")
    if None in shown:
        up_to = f" up to {CEILING_RAD:g} rad, as far as was tried" if plan["estimator"] == "optimal" else ""
        lines.append(f"no limit: the source limits nothing{up_to}")
    return lines


def _for_probability(plan: dict[str, Any]) -> list[str]:
    """Of the column that is only there with derived weights."""
    if plan["weights"] == "published":
        return []
    if plan["just_enough"] is None:
        return [f"for {_asked(plan)}: out of reach while sources without a limit stay as they are"]
    times = f"{plan['just_enough']['factor']:.3g} times at most"
    return [f"for {_asked(plan)}: {times}; then run and |a| are within the limit with {_asked(plan)}"]


def _sentence(plan: dict[str, Any]) -> str:
    """Whether the stand will do, by the paper's rule."""
    width = max(map(len, plan["margins"]))
    found = [
        f"  with {name + ':':{width + 1}} " + ("yes (no errors)" if margin is None else _reached(margin))
        for name, margin in plan["margins"].items()
    ]
    meaning = "Margin: the factor by which all its errors may grow until a row is full."
    return "\n".join([f"This stand reaches {plan['limit_g']:g} g", *found, meaning])


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


def _show_promises(out: Console, plan: dict[str, Any]) -> None:
    """Whether the stand will do, with every estimator."""
    from tumble.planning import tables

    asked = _asked(plan)
    out.print(f"Does this stand reach {plan['limit_g']:g} g with a probability of {asked}?", style="bold")
    rows = [
        (
            name,
            "yes" if one["growth"] is None or one["growth"] >= 1.0 else "no",
            tables.percent(one["passes"]),
            tables.percent(one["every_attitude"]),
            tables.scientific(one["coverage_factor"] * one["u_norm_worst_g"]),
            _factor(one["growth"]),
            _factor(plan["margins"][name]),
        )
        for name, one in plan["promises"].items()
    ]
    reach = f"{plan['promise']['coverage_factor']:g} u(|a|), g"
    out.print(tables.table(("with", "", "passes", "every attitude", reach, "may grow", "margin"), rows, left=(0, 1)))
    for line in _PROMISED:
        out.print(line.format(asked=asked, factor=plan["promise"]["coverage_factor"]))
    if plan["promise"]["assumes"]:
        out.print(ON_A_SEAT)
    if not plan["promise"]["shown"]:
        out.print(f"{plan['estimator']}: {_not_shown(plan)}", style="bold")


def _not_shown(plan: dict[str, Any]) -> str:
    """As a run that is solved says it."""
    told, remedies = plan["promise"], [Remedy(**one) for one in plan["would_show"]]
    decision = Decision(
        (UNCERTAINTY,), tuple(told["assumes"]), 0, told["limit_g"], told["coverage_factor"], told["u_norm_worst_g"]
    )
    return f"{decision.sentence}. {in_words(remedies, decision.limit_g)}."


def _asked(plan: dict[str, Any]) -> str:
    """As 95 %."""
    return f"{100.0 * plan['probability']:g} %"


def _factor(value: float | None) -> str:
    return "no errors" if value is None else f"{value:.3g}"


def _samples(plan: dict[str, Any]) -> str:
    """How many it takes."""
    rule = _NO_NUMBER if plan["samples"] is None else f"{plan['samples']} at least"
    enough = None if plan["just_enough"] is None else plan["just_enough"]["samples"] or _NO_NUMBER
    return rule if enough in (None, rule) else f"{rule}, {enough} for {_asked(plan)}"


_NO_NUMBER = "no number brings such a noise"
