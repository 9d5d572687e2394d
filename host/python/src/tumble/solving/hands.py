"""The stand that a block has which is laid by hand, where nobody declares one: a level table, and hands.

Its sizes are those of examples/hand_laid.toml, in g, for a sensor of any unit and scale: docs/schedules.md says what
they come from.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.core import CoreSchedule
from tumble.errors import BadInput
from tumble.estimators import LEAST_SQUARES
from tumble.files.run_file import Run
from tumble.files.stand_file import StandFile
from tumble.model import norm
from tumble.model.estimators import estimate, unidentified
from tumble.model.geometry import built_in
from tumble.schedule import WITH_STAND, Schedule
from tumble.solving import noise
from tumble.stand import SIGMA, Stand, per_channel
from tumble.units import volts_per

LIMIT_G = 7e-3  # three standard uncertainties of |a| come to 6 mg with faces that lie so
_NOISE_G, _DRIFT_G = 2e-3, 1e-3
HANDS = Stand(  # of a block that gives 1 V at 1 g
    axis_tilt=0.0,
    level=0.0,
    remount=0.0,
    angle=0.0,
    noise=_NOISE_G,
    samples=100,
    limits=SIGMA,
    name="laid by hand on a level table",
    seat=3e-3,
    drift=_DRIFT_G,
)


STILL = replace(HANDS, seat=0.0, name="still in poses that nobody knows")  # how they lie does not matter


def brings_stand(schedule: Any) -> bool:
    """Whether a schedule, by name or as an object, brings a stand for whoever declares none."""
    if isinstance(schedule, Schedule):
        return schedule == built_in("hand_laid")
    return isinstance(schedule, str) and schedule in WITH_STAND


def as_measured(schedule: CoreSchedule, mounting: Integers, position: Integers) -> CoreSchedule:
    """A schedule of faces with its positions in the order in which a run comes to them, which a drift follows.
    `mounting`, `position` (rows,): where each row of the run was measured."""
    planned, visited = schedule.data, dict.fromkeys(zip(mounting.tolist(), position.tolist()))
    order = {place: index for index, place in enumerate(visited)}
    positions = tuple(sorted(planned.positions, key=lambda one: order.get((one.mounting, one.number), len(order))))
    if positions == planned.positions:
        return schedule
    numbers = [one.mounting for one in positions]
    mountings = tuple(sorted(planned.mountings, key=lambda one: numbers.index(one.number)))
    return CoreSchedule(replace(planned, mountings=mountings, positions=positions))


def faces(run: Run, schedule: Schedule, file: str) -> StandFile:
    """As a run on a schedule of faces shows the scale of its block, and, where it has samples, their noise. Raises
    BadInput of the run in `file` where it does not show the coefficients."""
    part, means = schedule.part(run.measured), run.means[run.measured]
    if lost := unidentified(part):
        raise BadInput(f"these positions cannot identify {', '.join(lost)}", file)
    return _scaled(HANDS, run, np.linalg.norm(estimate(part, means, LEAST_SQUARES)[0], axis=1))


def poses(run: Run) -> StandFile:
    """The same of poses that nobody knows; where they do not show a scale, of one that is roughly theirs."""
    try:
        scale = np.linalg.norm(norm.solve(run.means, np.ones(3))[0], axis=1)
    except (norm.NotShown, np.linalg.LinAlgError):
        scale = np.full(3, np.ptp(run.means, axis=0).max() / 2.0)
    return _scaled(STILL, run, scale)


def _scaled(stand: Stand, run: Run, scale: Floats) -> StandFile:
    """For a block whose channels have this `scale` (3,), in the unit of the run per g."""
    seen, volts = noise.estimate_noise(run, None, 0.0).measured, volts_per(run.unit)
    of_a_sample = _NOISE_G * scale if seen is None else noise.of_means(seen, run.samples)
    sizes: dict[str, Any] = {"noise": per_channel(of_a_sample * volts), "drift": per_channel(_DRIFT_G * scale * volts)}
    return StandFile(replace(stand, **sizes), delta_g_limit_g=LIMIT_G)
