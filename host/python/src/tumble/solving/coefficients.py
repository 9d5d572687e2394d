"""The coefficients of a result as whoever uses them needs them: in g or in m/s^2, with their covariance, and K^-1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.documents.result import Result
from tumble.estimators import COEFFICIENTS
from tumble.model.force import Force
from tumble.solving import si
from tumble.terms import KEYS, POWERS, Terms, names
from tumble.units import per_g, per_m_s2


@dataclass(frozen=True)
class Coefficients:
    """What is used: the twelve in the order of COEFFICIENTS, then K2 and K3 if the model has them, each with its unit
    and its standard uncertainty, and their covariance (None: unknown), for accelerations in `force_unit`, "g" or
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
        if extended is not None:
            terms, joint = tuple(term for term in extended.terms if term in POWERS), extended.covariance
        values = np.concatenate([result.K.ravel(), result.U0, *(getattr(extended, KEYS[term]) for term in terms)])
        powers = np.concatenate([si.POWERS_OF_TWELVE, np.repeat([POWERS[term] - 1.0 for term in terms], 3)])
        joint = None if joint is None else joint[: len(values), : len(values)]
        stated = None
        if result.u_K is not None and result.u_U0 is not None:
            further = (getattr(extended, f"u_{KEYS[term]}") for term in terms)
            stated = np.concatenate([result.u_K.ravel(), result.u_U0, *further]).tolist()
        unit, is_g = result.unit, force_unit == "g"
        force = "g" if is_g else "(m/s^2)"
        units = [per_g(unit) if is_g else per_m_s2(unit)] * 9 + [unit] * 3
        units += [f"1/{force}" + ("" if POWERS[term] == 2 else "^2") for term in terms for _ in "xyz"]
        if not is_g:
            gravity, u_gravity = si.gravity_of(result.environment)
            if gravity is None:
                raise ValueError(
                    "no coefficients in m/s2: its environment has no gravity_m_s2; write the local gravity, such as "
                    "gravity_m_s2 = 9.81, under [environment] of the stand file, and solve again"
                )
            if joint is not None:
                joint = None if u_gravity is None else si.joint(values, powers, joint, gravity, u_gravity)
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
        return f"{'g' if self.force_unit == 'g' else '(m/s^2)'}/{self.units[9]}"

    @property
    def u_inverse(self) -> Floats | None:
        """Standard uncertainties of K^-1 (3, 3): it changes by - K^-1 dK K^-1."""
        if self.covariance is None:
            return None
        by_k = np.kron(self.inverse, self.inverse.T)
        u: Floats = np.sqrt(np.diag(by_k @ self.covariance[:9, :9] @ by_k.T)).reshape(3, 3)
        return u
