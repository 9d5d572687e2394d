"""tumble.thermal/1: a calibration over temperature, U = U0(T) + K(T) a, from runs at several temperatures."""

from __future__ import annotations

from typing import Annotated, Final, Literal

import numpy as np
from msgspec import UNSET, Meta, UnsetType, field

from tumble.documents.base import Document, Matrix, Share, Size, SizeMatrix, Sizes, Square, Vector, exactly, read
from tumble.documents.result import Decision, DeclaredStand, Labels, Name, SetAngles, Unseen, WorstNorm, require_usable
from tumble.units import UNIT

THERMAL: Final = "tumble.thermal/1"
Range = tuple[float, float]


class AtTemperature(WorstNorm, kw_only=True):
    """Where |a| is least certain at a temperature."""

    temperature_c: float


class CoefficientsAt(Document, kw_only=True):
    """At one temperature.

    u_K: Standard uncertainties; null without a stand file; with `u_U0`.
    """

    temperature_c: float
    K: Matrix
    U0: Vector
    u_K: SizeMatrix | None
    u_U0: Sizes | None


class RunAtTemperature(Document, kw_only=True):
    """One of the runs.

    passed: Its own verdict, solved alone; with `pass_reason`.
    K: Solved alone, at its mean temperature; with `U0`.
    u_K: Standard uncertainties of these; null without a stand file; with `u_U0`.
    max_abs_delta_g_g: Largest gravity error of its positions, with the coefficients of their temperature.
    """

    file: str
    sha256: str | None
    range_c: Range
    mean_c: float
    schedule: str | None
    estimator: str
    positions: int
    passed: bool = field(name="pass")
    pass_reason: str | None
    K: Matrix
    U0: Vector
    u_K: SizeMatrix | None = None
    u_U0: Sizes | None = None
    max_abs_delta_g_g: Size


class ThermalFit(Document):
    """Of all runs to the declared stand."""

    chi2: Size
    dof: int
    p: Share
    confidence: Share
    fits: bool


class Thermal(Document, kw_only=True):
    """
    reference_c: T0: coefficients are those of powers of (T - T0) / 1 K.
    range_c: Of the runs. Elsewhere the coefficients are extrapolated.
    K: Matrices of the powers 0, 1 ... `degree`, outputs' unit per g and per K to the power.
    U0: The same, in the outputs' unit.
    u_K: Standard uncertainties, same shape; null without a stand file; with `u_U0`.
    covariance: Of all coefficients, power by power, K row by row and then U0; null without a stand file.
    at: The coefficients at the lowest temperature, at `reference_c` and at the highest.
    u_norm_g: At temperatures of the range, the worst standard uncertainty of |a| over all attitudes.
    kept: Sources of error whose errors are the same in all runs.
    fit: null without a stand file.
    reliability: What all runs together could not have shown, as in a
        [result](method.md#what-a-run-could-not-have-shown): what is the block's is in all of them, anything else in
        one. null without a stand file.
    reliability_norm_g: The largest `norm_error_g` of it; null if none is known.
    max_abs_delta_g_g: Largest gravity error of all positions, with the coefficients of their temperature.
    at_one_temperature_g: Largest error of |a| over the range with the coefficients of `reference_c` alone.
    passed: The decision over the whole range; with `pass_reason`.
    set_angles: The table by which the runs were corrected, as in a result; missing where none was used.
    """

    schema: Literal["tumble.thermal/1"] = THERMAL
    created: str | None = None
    tumble: str | None = None
    serial: str | None = None
    unit: Annotated[str, exactly(UNIT.pattern)]
    degree: Annotated[int, Meta(ge=1, le=2)]
    reference_c: float
    range_c: Range
    K: Annotated[tuple[Matrix, ...], Meta(min_length=2, max_length=3)]
    U0: Annotated[tuple[Vector, ...], Meta(min_length=2, max_length=3)]
    u_K: tuple[SizeMatrix, ...] | None
    u_U0: tuple[Sizes, ...] | None
    covariance: Square | None
    at: tuple[CoefficientsAt, ...] = ()
    u_norm_g: tuple[AtTemperature, ...]
    fit: ThermalFit | None
    reliability: tuple[Unseen, ...] | None = None
    reliability_norm_g: Size | None = None
    max_abs_delta_g_g: Size
    at_one_temperature_g: Size
    passed: bool = field(name="pass")
    pass_reason: str | None
    decision: Decision
    assumes: tuple[Name, ...] = ()
    warnings: tuple[str, ...] = ()
    kept: tuple[Name, ...] = ()
    stand: DeclaredStand | None = None
    set_angles: SetAngles | UnsetType = UNSET
    runs: Annotated[tuple[RunAtTemperature, ...], Meta(min_length=1)] = ()
    item: Labels | None = None
    environment: Labels | None = None

    def __post_init__(self) -> None:
        powers = self.degree + 1
        by_power = [self.K, self.U0, *(one for one in (self.u_K, self.u_U0) if one is not None)]
        if any(len(one) != powers for one in by_power):
            raise ValueError(f"degree {self.degree} needs {powers} powers of K and U0")
        if (self.u_K is None) != (self.u_U0 is None):
            raise ValueError("u_K and u_U0 must be both known or both null")
        if self.covariance is not None and self.covariance.shape != (12 * powers, 12 * powers):
            raise ValueError("a covariance of another size")
        require_usable(self.pass_reason, self.environment)
        if self.passed != (self.pass_reason is None):
            raise ValueError("pass and pass_reason contradict each other")
        if not np.linalg.det(self.K[0]):
            raise ValueError("K cannot be inverted")


def parse_thermal(data: bytes, file: str) -> Thermal:
    """Of what a `file` holds. Raises BadInput."""
    return read(Thermal, THERMAL, data, file)
