"""What a result tells of further terms of its model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import numpy as np
from msgspec import UNSET, Meta, UnsetType

from tumble.arrays import Floats
from tumble.documents.base import Document, Matrix, Six, SixSizes, Size, Sizes, Square, Vector, exactly
from tumble.terms import KEYS, TERMS, expanded

if TYPE_CHECKING:  # a type checker takes no names that are made
    Term: TypeAlias = str
else:
    Term = Literal[TERMS]
OF_FORCE = "(K2|K3|asymmetry)_[xyz]|cross_(xy|yz|zx|xz|yx|zy)"  # what a pattern has of their names


class WithoutTerms(Document):
    u_K: Matrix
    u_U0: Sizes
    u_norm_g: Size


class Extended(Document):
    """Further terms: U_i += K_ii (K2_i a_i^2 + K3_i a_i^3 + asymmetry_i |a_i| + sum_j cross_ij a_i a_j)
    + drift_i (t - 1/2), j another axis than i, t from 0 at the first position of the run to 1 at the last. Three
    numbers are those of the channels x, y, z; null or absent for a term that is not in the model, and uncertainties
    without a declared stand. U0 is that of the middle of the run.

    asymmetry: Half the difference of the scales for force along the axis and against it, over the scale.
    cross_per_g: Of channel and the other axis: xy, yz, zx, xz, yx, zy, as names lists them.

    drift_v: From the first position to the last, in volts for outputs in V, mV, uV or kV, else in the unit of the
        outputs.
    names: Of the terms by channel, in the order that covariance has them.
    covariance: Of K row by row, U0, and what names lists, in the products of their units.
    u_norm_of_K_U0_g: What u_norm_g.worst_g would be by the uncertainties of K and U0 alone; u_norm_g has those of the
        terms of the force too, and what they have in common.
    without: The uncertainties of the same run without the further terms.
    max_abs_difference: Core less numpy, of K_ii K2_i and so on, and of the drift, in the unit of the outputs.
    """

    terms: Annotated[tuple[Term, ...], Meta(min_length=1, extra_json_schema={"uniqueItems": True})]
    k2_per_g: Vector | None = None
    u_k2_per_g: Sizes | None = None
    k3_per_g2: Vector | None = None
    u_k3_per_g2: Sizes | None = None
    asymmetry: Vector | UnsetType = UNSET
    u_asymmetry: Sizes | UnsetType | None = UNSET
    cross_per_g: Six | UnsetType = UNSET
    u_cross_per_g: SixSizes | UnsetType | None = UNSET
    drift_v: Vector | None = None
    u_drift_v: Sizes | None = None
    names: tuple[Annotated[str, exactly(f"({OF_FORCE}|drift_[xyz])")], ...] = ()
    covariance: Square | None = None
    u_norm_of_K_U0_g: Size | None = None
    without: WithoutTerms | None = None
    max_abs_difference: Size | None = None

    def __post_init__(self) -> None:
        size = 12 + 3 * len(expanded(self.terms))
        found = [getattr(self, KEYS[term]) for term in self.terms]
        if len(set(self.terms)) < len(self.terms) or any(isinstance(one, None | UnsetType) for one in found):
            raise ValueError("terms without their sizes")
        if self.covariance is not None and self.covariance.shape != (size, size):
            raise ValueError("a covariance of another size")

    @property
    def values(self) -> list[Floats]:
        """Those of terms.expanded, three each."""
        return [np.array(three) for term in self.terms for three in np.reshape(getattr(self, KEYS[term]), (-1, 3))]

    @property
    def u_values(self) -> list[Floats] | None:
        """Their standard uncertainties; None where they are unknown."""
        found = [getattr(self, f"u_{KEYS[term]}") for term in self.terms]
        if any(isinstance(one, None | UnsetType) for one in found):
            return None
        return [np.array(three) for one in found for three in np.reshape(one, (-1, 3))]
