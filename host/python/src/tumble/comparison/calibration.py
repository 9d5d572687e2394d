"""One of two calibrations that are compared: its coefficients, and the parameters that stay when the block turns.

A block that sits turned by a small vector phi has K (I + [phi]x) in place of K: the lengths of K's rows, the angles
between them and U0 stay. These nine, and three angles of the seat, are the twelve coefficients in other words.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Floats
from tumble.model.norm import PAIRS, by_intrinsic
from tumble.solving.si import POWERS_OF_TWELVE
from tumble.terms import POWERS, Terms, names

NAMES = (
    *(f"scale_{axis}" for axis in "xyz"),
    *(f"angle_{pair}" for pair in ("xy", "xz", "yz")),
    *(f"bias_{axis}" for axis in "xyz"),
)
UNITS = ("ppm",) * 3 + ("urad",) * 3 + ("ug",) * 3
_UNITS_OF_TERMS = {"k2": "ug/g^2", "k3": "ug/g^3"}


@dataclass(frozen=True)
class Calibration:
    """`values` (12 + 3 x terms,): K row by row, U0, then K2 and K3 as far as they are in `terms`, in the unit of the
    outputs and g. Their `covariance`, None where it is unknown: all of it, or without `in_common`, (draws, 12 + 3 x
    terms): errors that the other calibration has as well, draw by draw, one standard deviation of each."""

    values: Floats
    covariance: Floats | None
    terms: Terms = ()
    in_common: Floats | None = None

    @property
    def k(self) -> Floats:
        """K (3, 3)."""
        return self.values[:9].reshape(3, 3)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Of `parameters`."""
        return NAMES + names(self.terms)

    @property
    def parameter_units(self) -> tuple[str, ...]:
        """Of a millionth of each parameter."""
        return UNITS + tuple(_UNITS_OF_TERMS[term] for term in self.terms for _ in "xyz")

    @property
    def parameters(self) -> Floats:
        """What does not depend on the seat (9 + 3 x terms,): the logarithms of the lengths of K's rows, so that a
        difference is a relative one, the angles between the rows xy, xz, yz in rad, U0 over the lengths in g; K2 and
        K3."""
        length = np.linalg.norm(self.k, axis=1)
        axis = self.k / length[:, None]
        angles = [np.arctan2(np.linalg.norm(np.cross(axis[i], axis[j])), axis[i] @ axis[j]) for i, j in PAIRS]
        return np.concatenate([np.log(length), angles, self.values[9:12] / length, self.values[12:]])

    @property
    def by_values(self) -> Floats:
        """Derivatives of `parameters` by `values`, (9 + 3 x terms, 12 + 3 x terms)."""
        found = np.zeros((len(self.values) - 3, len(self.values)))
        found[:9, :12] = by_intrinsic(self.k, self.values[9:12])
        found[:3] /= np.linalg.norm(self.k, axis=1)[:, None]
        found[9:, 12:] = np.eye(len(self.values) - 12)
        return found

    def reduced(self, terms: Terms) -> Calibration:
        """With these of its terms alone."""
        kept = [*range(12), *(12 + 3 * self.terms.index(term) + axis for term in terms for axis in range(3))]
        covariance = None if self.covariance is None else self.covariance[np.ix_(kept, kept)]
        in_common = None if self.in_common is None else self.in_common[:, kept]
        return Calibration(self.values[kept], covariance, terms, in_common)

    def at_gravity(self, ratio: float) -> Calibration:
        """For accelerations in units of another gravity, so many times that of its own place."""
        factor = ratio**self.powers
        covariance = None if self.covariance is None else factor[:, None] * self.covariance * factor
        in_common = None if self.in_common is None else self.in_common * factor
        return replace(self, values=self.values * factor, covariance=covariance, in_common=in_common)

    @property
    def powers(self) -> Floats:
        """Of the gravity in `values`."""
        return np.concatenate([POWERS_OF_TWELVE, np.repeat([POWERS[term] - 1.0 for term in self.terms], 3)])
