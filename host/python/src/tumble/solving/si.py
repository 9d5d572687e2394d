"""Coefficients in units of the SI: responses to an acceleration in m/s^2 in place of g.

K is in the unit of the outputs per g; with the local gravity G, known to u(G), it is K/G per m/s^2. An error of G is
common to all nine, so they are correlated by it. A bias in m/s^2 is that in g times G.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.documents.result import Si, SiUnits
from tumble.model.norm import by_intrinsic, variances
from tumble.units import per_m_s2

POWERS_OF_TWELVE = np.repeat([1.0, 0.0], [9, 3])  # of the gravity in their units


@dataclass(frozen=True)
class SiCoefficients:
    """`k` (3, 3) in the outputs' unit per m/s^2, `scale` (3,) the lengths of its rows, `bias` (3,): U0 over the length
    of its row, in m/s^2; `covariance` (12, 12) of K row by row and U0, `u_scale`, `u_bias` (3,), None where the
    coefficients' or gravity's uncertainty is unknown."""

    k: Floats
    scale: Floats
    bias: Floats
    covariance: Floats | None
    u_scale: Floats | None
    u_bias: Floats | None

    @property
    def u_k(self) -> Floats | None:
        """Standard uncertainties of `k` (3, 3)."""
        return None if self.covariance is None else np.sqrt(np.diag(self.covariance)[:9]).reshape(3, 3)


def converted(
    k: Floats, u0: Floats, covariance: Floats | None, gravity: float, u_gravity: float | None
) -> SiCoefficients:
    """Coefficients that were found in g; `gravity` in m/s^2 with its standard uncertainty, None where unknown."""
    scale = np.linalg.norm(k, axis=1)
    bias = u0 / scale
    if covariance is None or u_gravity is None:
        return SiCoefficients(k / gravity, scale / gravity, bias * gravity, None, None, None)
    in_si = joint(np.concatenate([k.ravel(), u0]), POWERS_OF_TWELVE, covariance, gravity, u_gravity)
    of_scale, _, of_bias = np.split(variances(by_intrinsic(k, u0), covariance), 3)
    u_scale = np.sqrt(of_scale + (scale * u_gravity / gravity) ** 2) / gravity
    u_bias = np.sqrt(of_bias * gravity**2 + (bias * u_gravity) ** 2)
    return SiCoefficients(k / gravity, scale / gravity, bias * gravity, in_si, u_scale, u_bias)


def joint(values: Floats, powers: Floats, covariance: Floats, gravity: float, u_gravity: float) -> Floats:
    """Covariance of `values` over these powers of gravity; that in g is `covariance`."""
    factor = gravity**-powers
    by_gravity = -powers * values / gravity ** (powers + 1.0) * u_gravity
    in_si: Floats = factor[:, None] * covariance * factor + np.outer(by_gravity, by_gravity)
    return in_si


def of_result(
    k: Floats, u0: Floats, covariance: Floats | None, environment: dict[str, Any] | None, unit: str
) -> Si | None:
    """As it stands in a result; None where the environment names no gravity."""
    gravity, u_gravity = gravity_of(environment)
    if gravity is None:
        return None
    found = converted(k, u0, covariance, gravity, u_gravity)
    return Si(
        gravity_m_s2=gravity,
        u_gravity_m_s2=u_gravity,
        units=SiUnits(per_m_s2(unit), "m/s^2"),
        K=found.k,
        u_K=found.u_k,
        scale=found.scale,
        u_scale=found.u_scale,
        bias=found.bias,
        u_bias=found.u_bias,
    )


def gravity_of(environment: dict[str, Any] | None) -> tuple[float | None, float | None]:
    """Local gravity and its standard uncertainty, m/s^2; None for what is not told."""
    told = environment or {}
    gravity, u_gravity = told.get("gravity_m_s2"), told.get("u_gravity_m_s2")
    return None if gravity is None else float(gravity), None if u_gravity is None else float(u_gravity)
