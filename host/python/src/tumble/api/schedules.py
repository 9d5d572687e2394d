"""The built-in schedules, by their names.

>>> import tumble
>>> len(tumble.schedules.diagonal.positions), tumble.schedules.any_pose
(12, 'any_pose')
"""

from __future__ import annotations

from tumble.model.geometry import built_in
from tumble.schedule import ANY_POSE, BUILT_IN, Schedule

any_pose = ANY_POSE  # a name alone: its poses are those of a run


def __getattr__(name: str) -> Schedule:
    if name not in BUILT_IN:
        raise AttributeError(f"no built-in schedule {name!r}: there are {', '.join((*BUILT_IN, ANY_POSE))}")
    return built_in(name)


def __dir__() -> list[str]:
    return [*BUILT_IN, "any_pose"]
