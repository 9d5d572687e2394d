"""What a result rests on and repeats: the stand as its file declares it, the schedule that the run was measured on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tumble.core import built_in
from tumble.files.stand_file import StandFile
from tumble.schedule import BUILT_IN, Mounting, Position, Schedule
from tumble.stand import Stand

ERRORS = {  # of a stand, by the keys of its file: attribute of Stand
    "axis_tilt_rad": "axis_tilt",
    "level_rad": "level",
    "remount_rad": "remount",
    "angle_rad": "angle",
    "noise_v": "noise",
    "seat_rad": "seat",
    "platform_rad": "platform",
    "encoder_rad": "encoder",
    "drift_v": "drift",
}


def stand_document(stand: Stand | None, step_v: float) -> dict[str, Any] | None:
    """As it stands in a result: the keys and numbers of `[stand]`; None where none is declared. `step_v`: of the
    converter of its block, 0 where it is unknown."""
    if stand is None:
        return None
    errors = {key: float(getattr(stand, attribute)) for key, attribute in ERRORS.items()}
    labels = {
        "name": stand.name or None,
        "limits": stand.limits,
        "remount": stand.remounting,
        "samples": int(stand.samples),
    }
    return {**labels, **errors, "step_v": step_v or None}


def stand_of(document: Mapping[str, Any]) -> StandFile | None:
    """The declared stand of a result, its block by the step of the converter alone; None where it tells of none."""
    told = document.get("stand")
    if told is None:
        return None
    errors: dict[str, Any] = {attribute: float(told[key]) for key, attribute in ERRORS.items()}
    labels = {"name": told["name"] or "", "limits": told["limits"], "remounting": told["remount"]}
    stand = Stand(samples=int(told["samples"]), **labels, **errors)
    block = None if told.get("step_v") is None else {"converter_bits": 1, "range_v": float(told["step_v"])}
    return StandFile(stand, block, None, None, document.get("item"), document.get("environment"), None)


def schedule_document(schedule: Schedule) -> dict[str, Any]:
    """As it stands in a result: the name of a built-in one, else None, and the tables of a schedule file."""
    return {
        "name": next((name for name in BUILT_IN if built_in(name) == schedule), None),
        "mounting": [
            {
                "number": int(one.number),
                "matrix": [[float(value) for value in row] for row in one.matrix],
                "axis_tilt_deg": float(one.tilt_deg),
            }
            for one in schedule.mountings
        ],
        "position": [
            {
                "mounting": int(one.mounting),
                "position": int(one.number),
                "angle_deg": float(one.angle_deg),
                "use": one.use,
            }
            for one in schedule.positions
        ],
    }


def schedule_of(document: Mapping[str, Any]) -> Schedule | None:
    """The schedule of a result; None where it tells of none."""
    told = document.get("schedule")
    if told is None:
        return None
    return Schedule(
        tuple(
            Mounting(one["number"], tuple(map(tuple, one["matrix"])), one["axis_tilt_deg"]) for one in told["mounting"]
        ),
        tuple(Position(one["mounting"], one["position"], one["angle_deg"], one["use"]) for one in told["position"]),
    )
