"""What a stand is declared to be, as plain data."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from tumble.estimators import OPTIMAL
from tumble.units import volts_per

INDEPENDENT = "independent"
COMMON = "common"

_SIGMAS_PER_LIMIT = {"sigma1": 1.0, "sigma3": 3.0, "uniform": math.sqrt(3.0)}
LIMIT_KINDS = tuple(_SIGMAS_PER_LIMIT)

_K_II = ("K_xx", "K_yy", "K_zz")
_LARGE = {"alpha1": "axis tilt", "alpha2": "level error", "alpha3": "yaw"}


@dataclass(frozen=True)
class Stand:
    """Errors of a stand as declared: angles in radians, noise of one sample in V or as `in_unit` made it, all >= 0.

    `axis_tilt`: the axis is not level (alpha1). `level`: zero of the table angle (alpha2). `remount`: yaw of the block
    on the platform (alpha3). `angle`: error of a set table angle (alpha4). `samples`: how many samples a mean has when
    a run gives only the mean. `limits`: what the numbers are, one of LIMIT_KINDS: standard deviations, three of them,
    or half-widths of a uniform law. `remounting`: is the yaw drawn anew in every mounting, or common to all?
    `seat`: how far each mounting tilts the block against the axis, and adds to the table angle. `platform`: how far the
    platform tilts it against the axis, the same in all mountings and runs. 0: not declared.
    """

    axis_tilt: float
    level: float
    remount: float
    angle: float
    noise: float
    samples: int
    limits: str
    remounting: str = INDEPENDENT
    name: str = ""
    seat: float = 0.0
    platform: float = 0.0

    @property
    def declares_seat(self) -> bool:
        """Whether anything is said of how square the block sits."""
        return self.seat > 0.0 or self.platform > 0.0

    def in_unit(self, unit: str) -> Stand:
        """This stand with its noise in the unit of a run's outputs."""
        return replace(self, noise=self.noise / volts_per(unit))

    def with_step(self, step: float) -> Stand:
        """This stand with the noise that one sample really has: no less than a converter of this `step` (0: unknown),
        in the unit of the noise, leaves by rounding; step/sqrt(12) as a standard deviation."""
        rounding = abs(step) / math.sqrt(12.0) * _SIGMAS_PER_LIMIT[self.limits]
        return self if self.noise >= rounding else replace(self, noise=rounding)

    @property
    def shared_angles(self) -> tuple[float, float, float]:
        """Standard deviations of alpha1, alpha2, alpha3."""
        return self.sigma("axis_tilt"), self.sigma("level"), self.sigma("remount")

    def sigma(self, source: str) -> float:
        """Standard deviation of a source, named by its attribute, such as "axis_tilt"."""
        limit: float = getattr(self, source)
        return limit / _SIGMAS_PER_LIMIT[self.limits]


@dataclass(frozen=True)
class Shift:
    """What a second order takes off a coefficient, relative: `bias`, beside the `limit` that a fifth of its standard
    uncertainty is. `source` and `coefficient` such as "alpha3", "K_xx"."""

    source: str
    coefficient: str
    bias: float
    limit: float

    @property
    def matters(self) -> bool:
        """Whether the linear theory says too little."""
        return self.bias > self.limit

    def __str__(self) -> str:
        name, beside = _LARGE[self.source], f"0.2 u({self.coefficient})/{self.coefficient}"
        return f"large {name}: {self.source}^2/2 = {self.bias:.2g} exceeds {beside} = {self.limit:.2g}"


@dataclass(frozen=True)
class SecondOrder:
    """Is a stand good enough for the linear theory of uncertainties, which does not know what an angle takes off the
    scale factors, half its square? A yaw (alpha3) shortens K_xx, which both mountings see across the axis; an axis tilt
    (alpha1) and a level (alpha2) shorten all three.

    `yaw`: of K_xx, whatever the estimator; `others`: for each other angle the scale factor where it matters most, none
    for the optimal estimator, which takes them out.
    """

    yaw: Shift
    others: tuple[Shift, ...] = ()

    @classmethod
    def of(cls, angles: Iterable[float], k_ii: Iterable[float], u_k_ii: Iterable[float], estimator: str) -> SecondOrder:
        """For alpha1 to alpha3, rad, and what is claimed of the scale factors; 0 is allowed for all of them."""
        halves = [float(angle) ** 2 / 2.0 for angle in angles]
        limits = [0.2 * float(u / abs(k)) if k else 0.0 for k, u in zip(k_ii, u_k_ii)]
        worst = min(range(3), key=limits.__getitem__)
        linear = () if estimator == OPTIMAL else zip(("alpha1", "alpha2"), halves)
        others = tuple(Shift(source, _K_II[worst], half, limits[worst]) for source, half in linear)
        return cls(Shift("alpha3", _K_II[0], halves[2], limits[0]), others)

    @property
    def shifts(self) -> list[Shift]:
        """Those that matter."""
        return [shift for shift in (*self.others, self.yaw) if shift.matters]

    @property
    def matters(self) -> bool:
        """Whether the linear theory says too little."""
        return bool(self.shifts)

    def document(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {
            "bias_K_xx_relative": self.yaw.bias,
            "limit": self.yaw.limit,
            "matters": self.matters,
            "shifts": [
                {"source": one.source, "coefficient": one.coefficient, "bias_relative": one.bias, "limit": one.limit}
                for one in self.shifts
            ],
        }


PAPER_STAND = Stand(  # equation (5)
    axis_tilt=2e-5,
    level=2e-5,
    remount=4e-4,
    angle=4e-5,
    noise=3e-4,
    samples=50,
    limits="sigma1",
    name="single-axis rotary stand of the paper",
)
