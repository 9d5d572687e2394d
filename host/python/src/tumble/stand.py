"""What a stand is declared to be, as plain data."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

INDEPENDENT = "independent"
COMMON = "common"
OPTIMAL = "optimal"  # the one estimator that needs a stand

_SIGMAS_PER_LIMIT = {"sigma1": 1.0, "sigma3": 3.0, "uniform": math.sqrt(3.0)}
LIMIT_KINDS = tuple(_SIGMAS_PER_LIMIT)


_VOLTS_PER_UNIT = {"V": 1.0, "mV": 1e-3, "uV": 1e-6, "µV": 1e-6, "kV": 1e3}


def volts_per(unit: str) -> float:
    """Size in volts of a unit of the outputs; 1 for a unit that is no multiple of the volt, which takes the volt's
    place in the stand file and in the result."""
    return _VOLTS_PER_UNIT.get(unit, 1.0)


def noise_unit(unit: str) -> str:
    """The unit that noise is declared and reported in, for outputs in `unit`."""
    return "V" if unit in _VOLTS_PER_UNIT else unit


@dataclass(frozen=True)
class Stand:
    """Errors of a stand as declared: angles in radians, noise of one sample in V or as `in_unit` made it, all >= 0.

    `axis_tilt`: the axis is not level (alpha1). `level`: zero of the table angle (alpha2). `remount`: yaw of the block
    on the platform (alpha3). `angle`: error of a set table angle (alpha4). `samples`: how many samples a mean has when
    a run gives only the mean. `limits`: what the numbers are, one of LIMIT_KINDS: standard deviations, three of them,
    or half-widths of a uniform law. `remounting`: is the yaw drawn anew in every mounting, or common to all?
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

    def in_unit(self, unit: str) -> Stand:
        """This stand with its noise in the unit of a run's outputs."""
        return replace(self, noise=self.noise / volts_per(unit))

    def sigma(self, source: str) -> float:
        """Standard deviation of a source, named by its attribute, such as "axis_tilt"."""
        return getattr(self, source) / _SIGMAS_PER_LIMIT[self.limits]


@dataclass(frozen=True)
class SecondOrder:
    """Is a stand good enough for the linear theory of uncertainties? A yaw alpha3 takes `bias`, alpha3^2/2, off K_xx,
    which that theory does not know; `limit` is a fifth of the relative standard uncertainty of K_xx."""

    bias: float
    limit: float

    @classmethod
    def of(cls, stand: Stand, k_xx: float, u_k_xx: float) -> SecondOrder:
        """For a block and what is claimed of it; 0 is allowed for both."""
        return cls(stand.sigma("remount") ** 2 / 2.0, 0.2 * u_k_xx / abs(k_xx) if k_xx else 0.0)

    @property
    def matters(self) -> bool:
        """Whether the linear theory says too little."""
        return self.bias > self.limit

    @property
    def warning(self) -> str:
        """What to say where it does."""
        return f"large yaw: alpha3^2/2 = {self.bias:.2g} exceeds 0.2 u(K_xx)/K_xx = {self.limit:.2g}"

    def document(self) -> dict[str, float | bool]:
        """Ready for JSON."""
        return {"bias_K_xx_relative": self.bias, "limit": self.limit, "matters": self.matters}


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
