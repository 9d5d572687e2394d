"""What a result rests on and repeats: the stand as its file declares it, the schedule that the run was measured on.

Results of other versions, and what other programs write, may lack them; whoever needs them says what then.

When, by what and from what a result was made.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from datetime import datetime, timezone
from typing import Any

import numpy as np

from tumble.core import CoreRefusal, CoreSchedule, built_in
from tumble.errors import BadInput, UsageError, quoted
from tumble.schedule import BUILT_IN, CHECK, FIT, Mounting, Position, Schedule
from tumble.stand import COMMON, INDEPENDENT, LIMIT_KINDS, SOURCES, PerChannel, Stand, by_channel, per_channel

_MALFORMED = (KeyError, TypeError, ValueError, OverflowError)
_LARGEST = 1e9  # of an error of a stand, as stand files have it


def stand_document(stand: Stand | None, step_v: PerChannel) -> dict[str, Any] | None:
    """As it stands in a result: the keys and numbers of `[stand]`; None where none is declared. `step_v`: of the
    converter of its block, 0 where it is unknown."""
    if stand is None:
        return None
    errors = {source.key: _plain(getattr(stand, source.attribute)) for source in SOURCES.values()}
    labels = {
        "name": stand.name or None,
        "limits": stand.limits,
        "remount": stand.remounting,
        "samples": int(stand.samples),
    }
    known = bool(by_channel(step_v).any())
    return {**labels, **errors, "step_v": _plain(step_v) if known else None}


def _plain(value: PerChannel) -> float | list[float]:
    """One number or three, as JSON has them."""
    plain: float | list[float] = np.asarray(value, dtype=float).tolist()
    return plain


def _read(told: Any) -> PerChannel:
    """The same again. Raises TypeError, ValueError."""
    return per_channel(by_channel(told)) if isinstance(told, list) else float(told)


def stand_of(document: Mapping[str, Any], name: str) -> Stand | None:
    """The declared stand of a result, which messages call `name`; None where it tells of none. Raises BadInput."""
    if (told := document.get("stand")) is None:
        return None
    try:
        errors: dict[str, Any] = {
            source.attribute: float(told[source.key]) if source.is_angle else _read(told[source.key])
            for source in SOURCES.values()
        }
        labels = {"name": told["name"] or "", "limits": told["limits"], "remounting": told["remount"]}
        stand = Stand(samples=int(told["samples"]), **labels, **errors)
        small = all((0.0 <= by_channel(size)).all() and (by_channel(size) < _LARGEST).all() for size in errors.values())
        if small and stand.limits in LIMIT_KINDS and stand.remounting in (INDEPENDENT, COMMON) and stand.samples > 0:
            return stand
    except _MALFORMED:
        pass
    raise BadInput("its stand is not as tumble solve writes it", name)


def step_of(document: Mapping[str, Any]) -> PerChannel:
    """Of the converter of its block, in V; 0 where it is not known."""
    return _read((document.get("stand") or {}).get("step_v") or 0.0)


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


def schedule_of(document: Mapping[str, Any], name: str) -> CoreSchedule | None:
    """The schedule of a result, which messages call `name`; None where it tells of none. Raises BadInput."""
    if (told := document.get("schedule")) is None:
        return None
    try:
        mountings = tuple(
            Mounting(one["number"], tuple(map(tuple, one["matrix"])), one["axis_tilt_deg"]) for one in told["mounting"]
        )
        positions = tuple(
            Position(one["mounting"], one["position"], one["angle_deg"], _use(one)) for one in told["position"]
        )
        return CoreSchedule(Schedule(mountings, positions))
    except (*_MALFORMED, CoreRefusal):
        raise BadInput("its schedule is not as tumble solve writes it", name) from None


def _use(position: Mapping[str, Any]) -> str:
    """Raises ValueError for what is none."""
    return (FIT, CHECK)[(FIT, CHECK).index(position["use"])]


_LATEST = 253402300799  # the last second of the year 9999


def created(clock: bool = True) -> str | None:
    """Now, UTC, in the form of ISO 8601, or the second that SOURCE_DATE_EPOCH names where it is set. Without `clock`,
    as for a run in virtual time, which has no date, None unless it is set.

    Raises UsageError for a SOURCE_DATE_EPOCH that is no whole number of seconds.
    """
    told = os.environ.get("SOURCE_DATE_EPOCH")
    if told is not None:
        if not re.fullmatch(r"[0-9]{1,12}", told, re.ASCII) or int(told) > _LATEST:
            raise UsageError(f"SOURCE_DATE_EPOCH: {quoted(told)} is not a whole number of seconds since 1970")
        return _written(datetime.fromtimestamp(int(told), timezone.utc))
    return _written(datetime.now(timezone.utc)) if clock else None


def _written(moment: datetime) -> str:
    return f"{moment:%Y-%m-%dT%H:%M:%SZ}"
