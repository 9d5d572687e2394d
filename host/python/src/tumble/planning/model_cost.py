"""The cost of extended terms before a run: how well each is found, and what the twelve coefficients lose."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import UNSET, UnsetType

from tumble.documents import plan
from tumble.documents.further import WithoutTerms
from tumble.documents.plan import ModelCost
from tumble.estimators import COEFFICIENTS
from tumble.model.coefficients import worst_norm
from tumble.planning.case import Case
from tumble.planning.promise import error_field
from tumble.solving.uncertainty import ExtendedTerms
from tumble.terms import DRIFT, KEYS, UNITS_OF_VALUES, model_of, names

if TYPE_CHECKING:
    from rich.console import Console


def model_cost(case: Case, estimator: str) -> ExtendedTerms | None:
    """The cost for the nominal block, whose extended terms are 0; None for a model of the twelve coefficients alone."""
    if not case.terms:
        return None
    k = case.nominal_k()
    covariance, twelve = (error_field(one, estimator, k).covariance for one in (case, replace(case, terms=())))
    u = np.sqrt(np.diag(twelve))
    without, none = (
        WithoutTerms(u[:9].reshape(3, 3), u[9:], worst_norm(k, twelve).worst_g),
        np.zeros((len(case.terms), 3)),
    )
    return ExtendedTerms(case.terms, k, none, none, covariance, without)


_ALWAYS = tuple(f"u_{KEYS[term]}" for term in ("k2", "k3", DRIFT))  # written, though not in the model


def model_cost_part(found: ExtendedTerms | None) -> ModelCost | UnsetType:
    """The cost as a part of a plan: `extended` as in a result, without values."""
    if found is None:
        return UNSET
    without, worst, alone = found.without, found.worst_norm, found.worst_norm_of_twelve
    assert without is not None and worst is not None and alone is not None and found.u is not None  # of a planned stand
    u: dict[str, Any] = dict.fromkeys(_ALWAYS)
    u |= {f"u_{KEYS[term]}": size for term, size in found.by_term(found.u).items()}
    return ModelCost(
        terms=model_of(found.terms),
        **u,
        u_norm_of_K_U0_g=alone.worst_g,
        without=plan.WithoutTerms(without.u_K, without.u_U0, without.u_norm_g),
        u_norm_g=worst.worst_g,
    )


def sentence(found: ModelCost) -> str:
    """The cost as a sentence for people."""
    return (
        f"Worst u(|a|) with {', '.join(found.terms)} in the model: {1e6 * found.u_norm_g:.3g} ug, by K and U0 alone"
        f" {1e6 * found.u_norm_of_K_U0_g:.3g} ug;\nwithout: {1e6 * found.without.u_norm_g:.3g} ug"
    )


def show(out: Console, found: ExtendedTerms | None) -> None:
    """Print what the twelve coefficients lose and how well the terms are found; nothing for None."""
    from tumble.planning import tables

    cost = model_cost_part(found)
    if found is None or cost is UNSET:
        return
    without, covariance, of_values = found.without, found.covariance, found.u
    assert without is not None and covariance is not None and of_values is not None
    u, alone = np.sqrt(np.diag(covariance)), np.concatenate([without.u_K.ravel(), without.u_U0])
    rows = [
        (name, "V/g" if name.startswith("K") else "V", f"{now:.3e}", f"{before:.3e}", f"{now / before:.2f}")
        for name, now, before in zip(COEFFICIENTS, u, alone)
    ]
    units = [UNITS_OF_VALUES.get(term, "V") for term in found.terms for _ in "xyz"]
    for name, unit, size in zip(names(found.terms), units, of_values.ravel()):
        rows.append((name, unit, f"{size:.3e}", "", ""))
    out.print(tables.heading(f"With {', '.join(model_of(found.terms))} in the model"))
    out.print(tables.table(("", "unit", "u", "u without", "times"), rows, left=(0, 1)))
    out.print(sentence(cost))
