"""Does a run fit the stand that is declared for it? If it does not, the uncertainties made from the declaration mean
nothing, and whoever reads them has to know.

The tests are those of the fixture check against what the stand file declares, at a confidence so high that an honest
run is hardly ever blamed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tumble.core import CoreSchedule
from tumble.fixture import Judge, Limits, RunView, Verdict
from tumble.solving.solution import Solution
from tumble.solving.stand_seen import NAMES
from tumble.stand import Stand, noise_unit, volts_per

CONFIDENCE = 0.999
_ROUNDING_RAD = 1e-9
_ROUNDING = 1e-12
_SECOND_ORDER = 1.2  # of an angle squared: 0.11 of the squares' difference of two yaws, at 3.3 sigma each


@dataclass(frozen=True)
class Doubt:
    """A source that the run shows to be larger than declared: `source` as in fixture.SOURCES; `value` seen, and the
    `declared` standard deviation, in `unit`."""

    source: str
    value: float
    declared: float
    unit: str

    def __str__(self) -> str:
        return f"{NAMES[self.source]} {abs(self.value):.1e} {self.unit} (declared {self.declared:.1e})"


def look_for_doubts(solution: Solution, schedule: CoreSchedule, step_v: float) -> Solution:
    """The solution with its `doubts`; as it is where no stand was declared. `step_v`: of the converter, 0: unknown."""
    if solution.stand is None:
        return solution
    stand = solution.stand
    mountings = len(solution.measured_schedule.fitted_mountings)
    told = Limits.declared(stand, mountings).sigma
    allowed = Limits.of(_allowed(solution, step_v), stand.remounting, mountings)
    view = RunView.by_core(solution, schedule)
    judged = Judge([view], CONFIDENCE, levelled_once=True, ranges=False).judge(allowed)
    doubts = []
    for source, one in judged.items():
        if one.verdict is Verdict.DOES_NOT_MEET:
            shown = solution.stand_seen.angles.get(source.removesuffix("_rad"))  # as it stands in the result
            unit = noise_unit(solution.run.unit) if source == "noise_v" else "rad"
            doubts.append(Doubt(source, one.value if shown is None else shown.value, told[source], unit))
    return replace(solution, doubts=tuple(doubts))


def _allowed(solution: Solution, step_v: float) -> np.ndarray:
    """The declared standard deviations and, in quadrature, what is no fault of the stand: rounding, the steps of the
    converter, and in the set angles the second order of the others, which the linear fit takes for them."""
    stand, factor = solution.stand, volts_per(solution.run.unit)
    declared = _sigmas(stand)
    scale = float(np.linalg.norm(solution.found.k, axis=1).min()) * factor
    angle = _ROUNDING_RAD + step_v / scale
    second = _SECOND_ORDER * float((declared[:3] ** 2).sum())
    outputs = float(np.nanmax(np.abs(solution.run.means))) * factor
    return np.hypot(declared, [angle, angle, angle, angle + second, step_v / 2 + _ROUNDING * outputs])


def _sigmas(stand: Stand) -> np.ndarray:
    return np.array([stand.sigma(source) for source in ("axis_tilt", "level", "remount", "angle", "noise")])


def complaint(solution: Solution) -> str | None:
    """What is wrong, for people; None where there is nothing to doubt."""
    if not solution.doubts:
        return None
    return f"the run does not fit the stand file: {', '.join(map(str, solution.doubts))}"
