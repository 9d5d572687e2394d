"""The error budget, forward: what a stand leaves of the accuracy of every coefficient.

Each of the twelve has five terms, gamma times the size of the source, as in equation (2), and derived ones for seat,
platform, encoder and drift where the stand declares them; their signs being unknown, they add in quadrature. `derived`
works in standard deviations, `published` with the numbers as the stand file has them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.documents import plan
from tumble.documents.plan import Promise
from tumble.model.errors import OF_OUTPUTS
from tumble.model.propagation import SecondOrder, second_order
from tumble.model.reliability import Reliability, largest
from tumble.planning import weights
from tumble.planning.case import Case
from tumble.planning.model_cost import model_cost_part
from tumble.planning.weights import NAMES, SOURCES
from tumble.solving.computation import estimator_or_linear
from tumble.solving.result import second_order_of, unseen as unseen_of
from tumble.solving.uncertainty import ExtendedTerms
from tumble.stand import SIGMA, SOURCES as DECLARED

ALPHAS = "alpha1 axis tilt, alpha2 level, alpha3 yaw of the block, alpha4 set angles"


@dataclass(frozen=True)
class Budget:
    """An error budget. `sizes` (sources,): the noise is that of a position's mean. `terms` (12, sources) and `total`
    (12,): relative to `reference` (12,), V/g; of a bias in g; NaN where a coefficient is zero. `second_order`: whether
    the angles shift a coefficient by more than a linear budget may neglect."""

    weights: str
    estimator: str
    sources: tuple[str, ...]
    sizes: Floats
    terms: Floats
    reference: Floats
    second_order: SecondOrder

    @property
    def total(self) -> Floats:
        """The terms of each coefficient, added in quadrature."""
        total: Floats = np.sqrt((self.terms**2).sum(axis=1))
        return total


def sources(case: Case, published: bool) -> tuple[str, ...]:
    """Names of the sources that count; the paper has no seat."""
    return SOURCES if published else weights.sources_of(case)


def size_keys(names: tuple[str, ...]) -> tuple[str, ...]:
    """Keys of the sources in documents."""
    return tuple(f"{name}_v" if name in OF_OUTPUTS else f"{name}_rad" for name in names)


def by_key(case: Case, names: tuple[str, ...], sizes: Floats) -> dict[str, Any]:
    """Sizes of the sources for documents: None where infinite, three numbers where the channels differ."""
    found: dict[str, Any] = {}
    for key, name, size in zip(size_keys(names), names, sizes.tolist()):
        found[key] = size if np.isfinite(size) else None
        if np.isfinite(size) and name in OF_OUTPUTS and _differs(case, name):
            found[key] = tuple((size * case.stand.profile(name)).tolist())
    return found


def _differs(case: Case, name: str) -> bool:
    """Whether the channels differ: in declared noise, or in what rounding leaves of a mean."""
    three = isinstance(getattr(case.stand, name), tuple)
    return three or (name == "noise" and isinstance(case.stand.rounding, tuple))


def notes(case: Case) -> list[str]:
    """Notes for people: the sizes of outputs where the channels differ, and rounding that does not average out."""
    differ = [name for name in OF_OUTPUTS if _differs(case, name)]
    said = [f"{' and '.join(differ)}: of the worst channel, the others in proportion"] if differ else []
    return said + ([] if case.rounding_sentence is None else [case.rounding_sentence])


def unit(name: str) -> str:
    """The unit of a source's size, for people."""
    return "V, mean" if name == "noise" else "V" if name in OF_OUTPUTS else "rad"


def sizes(case: Case, published: bool) -> Floats:
    """Sizes of the sources: as declared, or as standard deviations. The noise is that of a mean; noise and drift are
    those of the worst channel."""
    stand, names = case.stand, sources(case, published)
    of = {name: stand.sigmas(DECLARED[name].attribute) for name in names}
    of["noise"] = stand.mean_sigma(stand.samples)
    found: Floats = np.array([of[name].max() for name in names])
    return found * stand.limits_over_sigma if published else found


def budget(case: Case, which: str, estimator: str) -> Budget:
    """Compute the budget of a case with published or derived weights. Raises UsageError where these do not exist."""
    published, k = which == "published", case.nominal_k()
    gamma = weights.published(case, estimator) if published else weights.derived(case, estimator, k)
    found = sizes(case, published)
    terms, reference = gamma * found, weights.reference_values(k)
    stand = replace(case.stand, limits=SIGMA) if published else case.stand
    u = np.sqrt((terms**2).sum(axis=1)) * np.abs(reference)
    given = case.propagation(estimator, k, fitted=not case.terms)  # a drift goes on where a position is only checked
    given = replace(given, stand=stand)
    beyond = second_order(given, u, estimator_or_linear(given))
    return Budget(which, estimator, sources(case, published), found, terms, reference, beyond)


def document(
    found: Budget, case: Case, promised: Promise | None, unseen: Reliability | None, further: ExtendedTerms | None
) -> plan.Budget:
    """The budget for JSON. The paper's weights promise nothing."""
    total, absolute = found.total, found.total * found.reference
    return plan.Budget(
        weights=found.weights,
        estimator=found.estimator,
        numbers=numbers_are(found.weights),
        block=case.block,
        sources=plan.MeanSizes(**by_key(case, found.sources, found.sizes), samples=case.stand.samples),
        u_K_relative=known(total[:9].reshape(3, 3)),
        u_a0_g=total[9:],
        u_K=known(absolute[:9].reshape(3, 3)),
        u_U0=absolute[9:],
        terms=dict(zip(NAMES, known(found.terms))),
        second_order=second_order_of(found.second_order),
        promise=promised,
        reliability=None if unseen is None else unseen_of(unseen),
        reliability_norm_g=None if unseen is None else largest(unseen),
        extended=model_cost_part(further),
    )


def numbers_are(which: str) -> plan.Numbers:
    """What the numbers of a plan mean."""
    return "standard deviations" if which == "derived" else "as declared"


def known(values: Floats) -> Any:
    """A table of numbers for JSON, with null for those that do not exist."""
    return tuple(tuple(None if np.isnan(value) else value for value in row) for row in values.tolist())
