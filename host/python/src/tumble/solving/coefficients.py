"""The coefficients of a result as whoever uses them needs them: in g or in m/s^2, with their covariance, and K^-1.

Coefficients in units of the SI: responses to an acceleration in m/s^2 in place of g.

K is in the unit of the outputs per g; with the local gravity G, known to u(G), it is K/G per m/s^2. An error of G is
common to all nine, so they are correlated by it. A bias in m/s^2 is that in g times G.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tumble.arrays import Floats
from tumble.documents.result import Result, Si, SiUnits
from tumble.estimators import COEFFICIENTS
from tumble.model.coefficients import Force, by_intrinsic, variances
from tumble.terms import POWERS, UNITS_OF_VALUES, Terms, expanded, names
from tumble.units import per_g, per_m_s2

POWERS_OF_TWELVE = np.repeat([1.0, 0.0], [9, 3])  # of the gravity in their units


def covariance_in_si(values: Floats, powers: Floats, covariance: Floats, gravity: float, u_gravity: float) -> Floats:
    """Covariance of `values` over these powers of gravity; that in g is `covariance`."""
    factor = gravity**-powers
    by_gravity = -powers * values / gravity ** (powers + 1.0) * u_gravity
    in_si: Floats = factor[:, None] * covariance * factor + np.outer(by_gravity, by_gravity)
    return in_si


def si_of(k: Floats, u0: Floats, covariance: Floats | None, environment: dict[str, Any] | None, unit: str) -> Si | None:
    """As it stands in a result, of coefficients that were found in g; None where the environment names no gravity."""
    gravity, u_gravity = gravity_of(environment)
    if gravity is None:
        return None
    scale = np.linalg.norm(k, axis=1)
    bias = u0 / scale
    found = Si(
        gravity_m_s2=gravity,
        u_gravity_m_s2=u_gravity,
        units=SiUnits(per_m_s2(unit), "m/s^2"),
        K=k / gravity,
        scale=scale / gravity,
        bias=bias * gravity,
    )
    if covariance is not None and u_gravity is not None:
        in_si = covariance_in_si(np.concatenate([k.ravel(), u0]), POWERS_OF_TWELVE, covariance, gravity, u_gravity)
        of_scale, _, of_bias = np.split(variances(by_intrinsic(k, u0), covariance), 3)
        found.u_K = np.sqrt(np.diag(in_si)[:9]).reshape(3, 3)
        found.u_scale = np.sqrt(of_scale + (scale * u_gravity / gravity) ** 2) / gravity
        found.u_bias = np.sqrt(of_bias * gravity**2 + (bias * u_gravity) ** 2)
    return found


def gravity_of(environment: dict[str, Any] | None) -> tuple[float | None, float | None]:
    """Local gravity and its standard uncertainty, m/s^2; None for what is not told."""
    told = environment or {}
    gravity, u_gravity = told.get("gravity_m_s2"), told.get("u_gravity_m_s2")
    return None if gravity is None else float(gravity), None if u_gravity is None else float(u_gravity)


@dataclass(frozen=True)
class Coefficients:
    """What is used: the twelve in the order of COEFFICIENTS, then those of further terms of the model, each with its
    unit and its standard uncertainty, and their covariance (None: unknown), for accelerations in `force_unit`, "g" or
    "m/s2". `terms`: of POWERS, those of the model."""

    values: Floats
    units: list[str]
    covariance: Floats | None
    uncertainties: list[float] | None
    force_unit: str
    terms: Terms

    @classmethod
    def of(cls, result: Result, force_unit: str = "g") -> Coefficients:
        """Of a result. Raises ValueError for m/s2 where its environment names no gravity, and for a singular K."""
        extended, joint = result.extended, result.covariance
        terms: Terms = ()
        further: list[Floats] = []
        u_further: list[Floats] | None = []
        if extended is not None:
            terms = tuple(term for term in expanded(extended.terms) if term in POWERS)  # a drift is the last of them
            joint, further, u_further = extended.covariance, extended.values, extended.u_values
        values = np.concatenate([result.K.ravel(), result.U0, *further[: len(terms)]])
        powers = np.concatenate([POWERS_OF_TWELVE, np.repeat([POWERS[term] - 1.0 for term in terms], 3)])
        joint = None if joint is None else joint[: len(values), : len(values)]
        stated = None
        if result.u_K is not None and result.u_U0 is not None and u_further is not None:
            stated = np.concatenate([result.u_K.ravel(), result.u_U0, *u_further[: len(terms)]]).tolist()
        unit, is_g = result.unit, force_unit == "g"
        force = "g" if is_g else "(m/s^2)"
        units = [per_g(unit) if is_g else per_m_s2(unit)] * 9 + [unit] * 3
        units += [UNITS_OF_VALUES[term].replace("g", force) for term in terms for _ in "xyz"]
        if not is_g:
            gravity, u_gravity = gravity_of(result.environment)
            if gravity is None:
                raise ValueError(
                    "no coefficients in m/s2: its environment has no gravity_m_s2; write the local gravity, such as "
                    "gravity_m_s2 = 9.81, under [environment] of the stand file, and solve again"
                )
            if joint is not None:
                joint = None if u_gravity is None else covariance_in_si(values, powers, joint, gravity, u_gravity)
            stated = None if joint is None else np.sqrt(np.diag(joint)).tolist()
            values = values / gravity**powers
        if not np.isfinite(np.linalg.cond(values[:9].reshape(3, 3))):
            raise ValueError("K is singular: it tells no acceleration")
        return cls(values, units, joint, stated, force_unit, terms)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all."""
        return COEFFICIENTS + names(self.terms)

    @property
    def force(self) -> Force:
        """What outputs become by them."""
        return Force(self.values, self.terms, self.covariance)

    @property
    def inverse(self) -> Floats:
        """K^-1 (3, 3)."""
        inverse: Floats = np.linalg.inv(self.values[:9].reshape(3, 3)).astype(float)
        return inverse

    @property
    def inverse_unit(self) -> str:
        """Of its elements."""
        unit = f"({self.units[9]})" if "/" in self.units[9] else self.units[9]
        return f"{'g' if self.force_unit == 'g' else '(m/s^2)'}/{unit}"

    @property
    def u_inverse(self) -> Floats | None:
        """Standard uncertainties of K^-1 (3, 3): it changes by - K^-1 dK K^-1."""
        if self.covariance is None:
            return None
        by_k = np.kron(self.inverse, self.inverse.T)
        u: Floats = np.sqrt(np.diag(by_k @ self.covariance[:9, :9] @ by_k.T)).reshape(3, 3)
        return u
