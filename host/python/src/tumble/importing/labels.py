"""Recordings whose rows say where they were taken: position, angle or running number; mountings by number or by name.

What the labels say is held against gravity. Where mountings have names, every way of giving them the schedule's numbers
is tried, and the one is taken that gives a block whose channels feel their own axes; two that do are refused.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import quoted
from tumble.importing import attitudes
from tumble.importing.hypotheses import Claims, Doubtful
from tumble.importing.match import TAKEN, Matched
from tumble.importing.rests import Rest
from tumble.schedule import Schedule

_NEAR_DEG = 3.0  # of a set angle, what a table shows may be off
_CROSS = 0.5  # of a channel's own axis, what it may feel of another


@dataclass(frozen=True)
class Group:
    """Rows `begin` to `end` (exclusive) with the same labels, `file` (from 0) they are in; texts None where there is no
    such column."""

    begin: int
    end: int
    file: int
    mounting: str | None
    position: str | None
    angle: str | None
    number: str | None


def groups_of(labels: dict[str, list[str]], file_of_row: Integers) -> list[Group]:
    """Rows in a row with the same labels."""
    rows = list(zip(file_of_row.tolist(), *(labels[name] for name in sorted(labels))))
    begins = [0, *(row for row in range(1, len(rows)) if rows[row] != rows[row - 1]), len(rows)]
    return [
        Group(begin, end, int(file_of_row[begin]), *(
            labels[name][begin] if name in labels else None for name in ("mounting", "position", "angle", "number")
        ))
        for begin, end in itertools.pairwise(begins)
    ]  # fmt: skip


def match(
    groups: Sequence[Group], rests: Sequence[Rest], schedule: Schedule, claims: Claims, named: dict[str, int]
) -> Matched:
    """The position of every group, whose rows are the rest of the same index. `named`: numbers of mountings by name, as
    far as the user says. Raises Doubtful."""
    keys = _mounting_keys(groups, schedule)
    means = np.array([rest.mean for rest in rests])
    fits, faults = [], []
    for numbers in _ways(list(dict.fromkeys(keys)), schedule, named):
        try:
            positions = np.array([_position(g, numbers[key], schedule) for g, key in zip(groups, keys)])
            off, fit = _held_against_gravity(positions, means, schedule, claims, groups)
        except Doubtful as fault:
            faults.append(str(fault))
            continue
        fits.append((numbers, positions, off, fit))
    if not fits:
        raise Doubtful(min(faults, key=len) if faults else "the labels name more mountings than the schedule has")
    if len(fits) > 1:
        both = " and ".join(_told(numbers) for numbers, *_ in fits[:3])
        raise Doubtful(f"the mountings fit {len(fits)} ways, {both}: --mountings says which")
    numbers, positions, off, fit = fits[0]
    spread = float(np.sqrt((off**2).mean()))
    notes = [f"positions: by the labels of the rows, which gravity confirms; mountings {_told(numbers)}"]
    present = set(positions.tolist())
    missing = [place.label for index, place in enumerate(schedule.positions) if index not in present]
    notes += [f"no rows at {', '.join(missing)}"] if missing else []
    return Matched(positions, (TAKEN,) * len(groups), off, spread, fit, tuple(notes))


def _told(numbers: dict[str, int]) -> str:
    return ",".join(f"{key}={number}" for key, number in numbers.items())


def _mounting_keys(groups: Sequence[Group], schedule: Schedule) -> list[str]:
    """What tells the mountings of groups apart: their column, the file, or that positions begin anew."""
    if groups[0].mounting is not None:
        return [str(group.mounting) for group in groups]
    if groups[0].number is not None or _has_running_numbers(groups, schedule):
        return ["all"] * len(groups)
    if len({group.file for group in groups}) > 1:
        return [f"file{group.file + 1}" for group in groups]
    keys, part, before = [], 1, -np.inf
    for group in groups:
        value = _value(group.position or group.angle or "")
        if value is not None and value < before:
            part += 1
        before = -np.inf if value is None else value
        keys.append(f"part{part}")
    return keys


def _has_running_numbers(groups: Sequence[Group], schedule: Schedule) -> bool:
    """Are positions numbered through all mountings?"""
    values = [_value(group.position) for group in groups if group.position is not None]
    most = max((place.number for place in schedule.positions), default=0)
    return bool(values) and max(value or 0 for value in values) > most


def _ways(keys: list[str], schedule: Schedule, named: dict[str, int]) -> Iterator[dict[str, int]]:
    """Numbers of mountings by key: what is said, else the schedule's own numbers, else every way."""
    numbers = [mounting.number for mounting in schedule.mountings]
    if keys == ["all"]:
        yield {"all": 0}
        return
    own = {key: int(key) for key in keys if re.fullmatch(r"\d{1,3}", key) and int(key) in numbers}
    if set(own) == set(keys) and not named:
        yield own
        return
    fixed = {key: named[key] for key in keys if key in named}
    open_keys = [key for key in keys if key not in fixed]
    free = [number for number in numbers if number not in fixed.values()]
    for choice in itertools.permutations(free, len(open_keys)):
        yield {key: {**fixed, **dict(zip(open_keys, choice))}[key] for key in keys}


def _value(text: str | None) -> float | None:
    """The number that a label begins or ends with, such as 3 of "Pos 3" and 45 of "45°"."""
    found = re.search(r"-?\d+(?:[.,]\d+)?", text or "")
    return float(found[0].replace(",", ".")) if found else None


def _position(group: Group, mounting: int, schedule: Schedule) -> int:
    """Index of a group's position. Raises Doubtful."""
    if mounting == 0:
        return _running(group, schedule)
    if group.position is None and group.number is not None:
        return _running(group, schedule)
    inside = [index for index, place in enumerate(schedule.positions) if place.mounting == mounting]
    if group.position is not None:
        value = _value(group.position)
        found = [index for index in inside if schedule.positions[index].number == value]
        what = f"position {quoted(group.position)}"
    else:
        value = _value(group.angle)
        off = {
            index: abs(schedule.positions[index].angle_deg - (np.inf if value is None else value)) for index in inside
        }
        found = [index for index in sorted(inside, key=off.__getitem__)[:1] if off[index] <= _NEAR_DEG]
        what = f"angle {quoted(group.angle)}"
    if not found:
        raise Doubtful(f"the schedule has no {what} in mounting {mounting}; another one? (--schedule)")
    return found[0]


def _running(group: Group, schedule: Schedule) -> int:
    text = group.number if group.number is not None else group.position
    value = _value(text)
    if value is None or value != int(value) or not 1 <= value <= len(schedule.positions):
        raise Doubtful(
            f"{quoted(text)} is no running number of the schedule's {len(schedule.positions)} positions, from 1; "
            "another schedule? (--schedule)"
        )
    return int(value) - 1


def _held_against_gravity(
    positions: Integers, means: Floats, schedule: Schedule, claims: Claims, groups: Sequence[Group]
) -> tuple[Floats, attitudes.Fit]:
    """How far off its position each group is, rad. Raises Doubtful where labels and gravity disagree."""
    known = attitudes.attitudes_of(schedule)
    forces = known.forces[known.of_position[positions]]
    fit = attitudes.fitted(forces, means)
    if fit is None:
        raise Doubtful(
            f"{len(set(positions.tolist()))} positions do not show scale and bias of every channel: give the "
            "recordings of all mountings together"
        )
    signs = claims.signs or tuple(1 if own >= 0 else -1 for own in np.diag(fit.k))
    own = np.diag(fit.k) * np.array(signs)
    cross = np.abs(fit.k - np.diag(np.diag(fit.k))).max(axis=1)
    if not (own > 0.0).all() or not (cross <= _CROSS * own).all():
        raise Doubtful(
            "as the rows are labelled, channels feel other axes than their own, or with other signs than told: are "
            "mountings or positions exchanged, or columns (--columns ux=...)? "
        )
    off = np.linalg.norm(fit.attitudes(means) - forces, axis=1)
    worst = int(off.argmax())
    if off[worst] > min(claims.tolerance, 0.4 * known.apart):
        label = schedule.positions[positions[worst]].label
        raise Doubtful(
            f"group {worst + 1} is labelled {label}, and gravity is {np.rad2deg(off[worst]):.3g} deg off there: "
            "correct its label, or delete its rows"
        )
    return off, fit
