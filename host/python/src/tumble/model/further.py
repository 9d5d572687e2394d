"""What a channel feels of the further terms that go by the specific force (tumble.terms.POWERS), and its slope."""

from __future__ import annotations

import numpy as np

from tumble.arrays import Floats
from tumble.terms import ASYMMETRY, CROSS_LAST, CROSS_NEXT, POWERS

_OTHER = {CROSS_NEXT: np.array([1, 2, 0]), CROSS_LAST: np.array([2, 0, 1])}  # axis of x, y and z


def felt(term: str, force: Floats) -> Floats:
    """What a size of one adds to each channel's output, at a `force` (..., 3)."""
    if term in _OTHER:
        return force * force[..., _OTHER[term]]
    return np.abs(force) if term == ASYMMETRY else force ** POWERS[term]


def slope(term: str, force: Floats) -> Floats:
    """Its derivatives (..., 3, 3): of channel i by the force along axis j."""
    found, own = np.zeros((*force.shape, 3)), np.arange(3)
    if term in _OTHER:
        other = _OTHER[term]
        found[..., own, own], found[..., own, other] = force[..., other], force
    elif term == ASYMMETRY:
        found[..., own, own] = np.sign(force)
    else:
        found[..., own, own] = POWERS[term] * force ** (POWERS[term] - 1)
    return found
