"""How good a stand must be to be just enough: the requirements, scaled until the probability that the user asks for is
reached, of passing the gravity check and of |a| within the limit at every attitude.

The requirements' own rule, a third of the limit for each row, promises no probability. It says here how the sources
compare; one factor for all of them sets the probability. Sources that no row limits stay as the stand has them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.planning.budget import by_key, sizes as declared_sizes, sources
from tumble.planning.case import Case
from tumble.planning.promise import Promise, promise, promises
from tumble.planning.published import SOURCES
from tumble.planning.require import samples_on, stand_of

_SETTLED = 1e-4
_STEPS = 20


@dataclass(frozen=True)
class Enough:
    """What is just enough for `probability`: `sizes` of the sources by key, `factor` times the rule's, and `samples`;
    None where scaling cannot reach it, or no number of samples. `promises`: of the stand as declared, by estimator."""

    probability: float
    promises: dict[str, Promise]
    sizes: dict[str, Any] | None
    factor: float
    samples: int | None

    def document(self, estimator: str) -> dict[str, Any]:
        """Ready for JSON."""
        of_all = {name: growing(one) for name, one in self.promises.items()}
        sizes = None
        if self.sizes is not None:
            sizes = {**self.sizes, "samples": self.samples, "factor": self.factor}
        return {
            "probability": self.probability,
            "promise": of_all[estimator],
            "promises": of_all,
            "just_enough": sizes,
        }


NOT_PROMISED = dict.fromkeys(
    ("probability", "promise", "promises", "just_enough")
)  # the paper's weights have no joint law


def growing(found: Promise) -> dict[str, Any]:
    """A promise with its growth, ready for JSON."""
    return {**found.document(), "growth": float(found.growth) if np.isfinite(found.growth) else None}


def enough(case: Case, estimator: str, limits: Floats, probability: float) -> Enough:
    """For requirements `limits`, one a source, infinite where no row limits. Raises UsageError where no number of
    samples suffices."""
    declared, limited = declared_sizes(case, False), np.isfinite(limits)
    of_all = promises(case, probability)
    factor = 1.0
    for _ in range(_STEPS):
        sizes = np.where(limited, factor * limits, declared)
        growth = promise(stand_of(case, sizes), estimator, probability).growth
        if abs(growth - 1.0) <= _SETTLED:
            samples = samples_on(case.stand, float(sizes[SOURCES.index("noise")]))
            named = by_key(case, sources(case, False), sizes)
            return Enough(probability, of_all, named, factor, samples)
        factor *= growth
    return Enough(probability, of_all, None, 0.0, 0)
