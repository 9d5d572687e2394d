"""Solve a run: the core computes, the numpy witness confirms, and only then is there a solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import core, reference
from tumble.computation import Computation, DeadChannels, compute
from tumble.crosscheck import Comparison, compare
from tumble.errors import BadInput
from tumble.runfile import Run
from tumble.schedule import Schedule
from tumble.stand import Stand, volts_per


@dataclass(frozen=True)
class Truth:
    """What a simulated run was made of: `k` (3, 3), `u0` (3,); the stand's errors in radians, `alpha3` by mounting and
    `alpha4` by position."""

    k: np.ndarray
    u0: np.ndarray
    alpha1: float
    alpha2: float
    alpha3: tuple[float, ...]
    alpha4: tuple[float, ...]


@dataclass(frozen=True)
class Solution:
    """Everything known after a run: one row per position of `schedule`, in its order.

    `found`: by the core; `comparison`: with the witness; `u_k` (3, 3), `u_u0` (3,): standard uncertainties, None
    without a declared stand; `stand`: that one; `stand_seen`: the stand as the run shows it; `truth`: None for a run
    that was measured.
    """

    schedule: Schedule
    run: Run
    limit_g: float
    found: Computation
    comparison: Comparison
    u_k: np.ndarray | None
    u_u0: np.ndarray | None
    stand: Stand | None
    stand_seen: dict[str, float | None]
    truth: Truth | None = None

    @property
    def worst_position(self) -> int:
        """Index of the position with the largest gravity error."""
        return int(np.nanargmax(np.abs(self.found.gravity.delta_g)))


def solve(
    run: Run, schedule: core.CoreSchedule | None, estimator: str, limit_g: float, stand: Stand | None, file: str
) -> Solution:
    """Solve a run on a schedule (None: the paper's). `file` names the run in errors.

    Raises BadInput where the core refuses the run, Disagreement where the witness does not confirm the core.
    """
    declared = None if stand is None else stand.in_unit(run.unit)
    core_schedule = schedule or core.CoreSchedule(core.paper_schedule())
    try:
        found = compute(core_schedule, run.means, run.measured, estimator, limit_g)
    except core.CoreRefusal as refusal:
        raise BadInput(_explain(refusal, estimator), file) from None
    except DeadChannels as error:
        raise BadInput(str(error), file) from None
    witnessed = _measured_part(reference.paper_schedule() if schedule is None else schedule.data, run.measured)
    means, samples, scatter = (rows[run.measured] for rows in (run.means, run.samples, run.scatter))
    comparison = compare(found, witnessed, means, found.gravity.delta_g[run.measured])
    u_k = u_u0 = None
    if declared is not None:
        u_k, u_u0 = reference.standard_uncertainties(witnessed, found.k, declared, samples, estimator)
    seen = reference.stand_seen(witnessed, means, found.k, samples, scatter, declared)
    seen = _noise_in_volts(seen, run.unit)
    return Solution(core_schedule.data, run, limit_g, found, comparison, u_k, u_u0, stand, seen)


def _noise_in_volts(seen: dict[str, float | None], unit: str) -> dict[str, float | None]:
    """`noise_v` and its twin in volts, for outputs in a multiple of the volt."""
    noise = {name: seen[name] for name in ("noise_v", "u_noise_v")}
    return {**seen, **{name: None if value is None else value * volts_per(unit) for name, value in noise.items()}}


def _measured_part(schedule: Schedule, measured: np.ndarray) -> Schedule:
    """The schedule without the positions that a run does not have."""
    positions = tuple(position for position, is_measured in zip(schedule.positions, measured) if is_measured)
    return Schedule(schedule.mountings, positions)


def _explain(refusal: core.CoreRefusal, estimator: str) -> str:
    """A refusal of the core, in terms of what the user gave."""
    if refusal.name == "TUMBLE_E_MISSING_POSITION":
        return f"{estimator} needs all 2 x 9 positions; missing {', '.join(refusal.details['missing'])}"
    if refusal.name == "TUMBLE_E_NOT_HARMONIC":
        return f"the schedule lacks positions that {estimator} needs; least_squares solves any schedule"
    if refusal.name == "TUMBLE_E_RANK":
        return f"these positions cannot identify {', '.join(refusal.details['unidentified'])}"
    return str(refusal)
