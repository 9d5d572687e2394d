"""What a result rests on and repeats: the stand as its file declares it, the schedule that the run was measured on.

Results of other versions, and what other programs write, may lack them; whoever needs them says what then.

When, by what and from what a result was made.
"""

from __future__ import annotations

import os
import re
from datetime import datetime, timezone
from typing import Any

from tumble.core import CoreRefusal, CoreSchedule
from tumble.documents.result import Result
from tumble.errors import BadInput, UsageError, quoted
from tumble.schedule import Mounting, Position, Schedule
from tumble.stand import SOURCES, PerChannel, Stand, by_channel, per_channel

_LARGEST = 1e9  # of an error of a stand, as stand files have it


def stand_of(result: Result, name: str) -> Stand | None:
    """The declared stand of a result, which messages call `name`; None where it tells of none. Raises BadInput."""
    told = result.stand
    if told is None:
        return None
    errors = {source.attribute: getattr(told, source.key) for source in SOURCES.values()}
    if any((by_channel(size) >= _LARGEST).any() for size in errors.values()):
        raise BadInput("its stand is not as tumble solve writes it", name)
    sizes: dict[str, Any] = {name: per_channel(by_channel(one)) for name, one in errors.items()}
    kinds: dict[str, Any] = {"limits": told.limits, "remounting": told.remount}
    return Stand(**sizes, **kinds, name=told.name or "", samples=told.samples)


def step_of(result: Result) -> PerChannel:
    """Of the converter of its block, in V; 0 where it is not known."""
    step = 0.0 if result.stand is None else result.stand.step_v or 0.0
    return per_channel(by_channel(step))


def schedule_of(result: Result, name: str) -> CoreSchedule | None:
    """The schedule of a result, which messages call `name`; None where it tells of none. Raises BadInput."""
    told = result.schedule
    if told is None:
        return None
    matrices = (tuple(map(tuple, one.matrix.tolist())) for one in told.mounting)
    mountings = (Mounting(one.number, matrix, one.axis_tilt_deg) for one, matrix in zip(told.mounting, matrices))
    positions = (Position(one.mounting, one.position, one.angle_deg, one.use) for one in told.position)
    try:
        return CoreSchedule(Schedule(tuple(mountings), tuple(positions)))
    except (CoreRefusal, ValueError):
        raise BadInput("its schedule is not as tumble solve writes it", name) from None


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
