"""Schedules by name: built-in ones, and files of mountings and test positions (TOML).

[[mounting]]   number, matrix (3 x 3, rows = block axes x, y, z in the table frame h, n, v), axis_tilt_deg, bolting
[[position]]   mounting, position, angle_deg, use = "fit" or "check"
"""

from __future__ import annotations

import os
from contextlib import suppress
from functools import lru_cache
from typing import Any

import numpy as np

from tumble.core import MAX_MOUNTINGS, MAX_POSITIONS, MAX_YAWS, CoreRefusal, CoreSchedule, estimate_runs
from tumble.defaults import DEFAULT_ESTIMATOR, DEFAULT_INCLINED
from tumble.errors import BadInput, UsageError, quoted
from tumble.estimators import HARMONIC, INCLINATIONS, INCLINED, LEAST_SQUARES, NORM, OPTIMAL
from tumble.files.toml import Table, read_toml
from tumble.messages import tell
from tumble.schedule import ANY_POSE, BUILT_IN, CHECK, FIT, Mounting, Position, Schedule

_LARGEST_NUMBER = 255
_LARGEST_ANGLE_DEG = 3600.0
_LARGEST_TILT_DEG = 89.0
_EXACT = 1e-9  # of a rotation's rows and columns; what the core accepts
_CIRCLES = tuple(45.0 * turn for turn in (1, 3, 5, 7)), tuple(45.0 * turn for turn in range(9))  # of closed forms, deg
_TYPED = 2e-5  # of a rotation typed to five decimals


def read_schedule(file: str, data: bytes | None = None, estimator: str | None = None) -> CoreSchedule:
    """The built-in schedule of that name, or a schedule file, which identifies all coefficients and has what an
    `estimator` needs, if one is named. `data`: what is in it, if that has been read. Raises BadInput with file, row and
    table."""
    if file in BUILT_IN:
        return _built_in(file, estimator)
    if file == ANY_POSE:
        raise BadInput(f"has no positions but those of a run, which {NORM} solves: it is for solve and import", file)
    schedule = _read(file, data)
    _require_solvable(schedule, estimator, file, tells=True)
    return schedule


@lru_cache
def _built_in(name: str, estimator: str | None) -> CoreSchedule:
    schedule = CoreSchedule.built_in(name)
    _require_solvable(schedule, estimator, name, tells=True)
    return schedule


def schedule_of(schedule: Any, estimator: str | None = None) -> CoreSchedule:
    """By name, from a file, or as an object; with the positions that an `estimator` needs. Raises BadInput,
    UsageError."""
    if isinstance(schedule, (str, os.PathLike)):
        return read_schedule(os.fspath(schedule), estimator=estimator)
    if not isinstance(schedule, Schedule):
        kind = type(schedule).__name__
        raise UsageError(f"schedule: a {kind} is neither a name nor the path of a schedule file nor a tumble.Schedule")
    try:
        core_schedule = CoreSchedule(schedule)
    except CoreRefusal as refusal:
        raise BadInput(f"is refused: {refusal}", "schedule") from None
    except (TypeError, ValueError, OverflowError, AttributeError) as error:
        raise BadInput(f"cannot be used: {quoted(error, 80)}", "schedule") from None
    _require_identifying(core_schedule, "schedule")
    _require_solvable(core_schedule, estimator, "schedule")
    return core_schedule


def default_estimator(schedule: CoreSchedule) -> str:
    """What solves a schedule where nobody says: a closed form, where there is one for it."""
    if schedule.data.is_inclined:
        return DEFAULT_INCLINED
    try:
        schedule.harmonic()
    except CoreRefusal:
        return LEAST_SQUARES
    return DEFAULT_ESTIMATOR


def planned_with(schedule: Any, estimator: str | None) -> tuple[CoreSchedule, str]:
    """A schedule as `schedule_of` takes it, and the `estimator`; None: that of the schedule. Raises as
    `schedule_of`."""
    planned = schedule_of(schedule, estimator)
    if estimator is None:
        estimator, is_named = default_estimator(planned), isinstance(schedule, (str, os.PathLike))
        _require_solvable(planned, estimator, os.fspath(schedule) if is_named else "schedule", is_named)
    return planned, estimator


def estimator_by_name(name: str | None) -> str:
    """The same of a built-in schedule or of a file; whatever is wrong with one is told where it is used."""
    if name in BUILT_IN:
        return default_estimator(CoreSchedule.built_in(name))
    if name == ANY_POSE:
        return NORM
    if name is not None and os.path.isfile(name):
        with suppress(BadInput, CoreRefusal):
            return default_estimator(CoreSchedule(parse_schedule(name)))
    return DEFAULT_ESTIMATOR


def _require_solvable(schedule: CoreSchedule, estimator: str | None, file: str, tells: bool = False) -> None:
    """Raise BadInput for a schedule, called `file`, that lacks what an estimator needs; where it `tells`, positions
    that are not needed are named on stderr."""
    if any(one[-1] - one[0] >= len(one) for one in schedule.data.boltings):
        raise BadInput("mountings of one bolting must follow one another: a block is bolted on once", file)
    inclined, of_inclinations = schedule.data.is_inclined, estimator in (INCLINED, OPTIMAL)
    if inclined and estimator is not None and not of_inclinations:
        raise BadInput(
            f"{estimator} takes its inclinations as exact, but they are not measured; inclined estimates them", file
        )
    if estimator in HARMONIC:
        try:
            schedule.harmonic()
        except CoreRefusal:
            raise BadInput(f"lacks positions that {estimator} needs; least_squares solves any schedule", file) from None
        if tells:
            _tell_of_left_out(schedule, estimator, file)
    if estimator == INCLINED or (inclined and estimator == OPTIMAL):
        try:
            schedule.inclinations()
        except CoreRefusal:
            raise BadInput(f"lacks what {estimator} needs: {INCLINATIONS}", file) from None
    if estimator == OPTIMAL and (count := len(schedule.data.mountings)) > MAX_YAWS:
        raise BadInput(f"has {count} mountings, optimal takes {MAX_YAWS}; least_squares solves any schedule", file)


def parse_schedule(file: str) -> Schedule:
    """As a schedule file has it, not judged: what it must have depends on what it is for. Raises BadInput."""
    top = read_toml(file)
    return Schedule(tuple(map(_mounting, top.tables("mounting"))), tuple(map(_position, top.tables("position"))))


def _read(file: str, data: bytes | None) -> CoreSchedule:
    if data is None and not os.path.exists(file):
        import difflib

        close = difflib.get_close_matches(file.lower().replace("-", "_"), BUILT_IN, n=1, cutoff=0.7)
        meant = f"; is {close[0]} meant?" if close else ""
        raise BadInput(f"no such file or folder, nor a built-in schedule: these are {', '.join(BUILT_IN)}{meant}", file)
    top = read_toml(file, data)
    if "stand" in top.keys:
        raise BadInput("is a stand file (--stand), not a schedule file", file)
    top.only("mounting", "position")
    mountings, positions = top.tables("mounting"), top.tables("position")
    schedule = Schedule(tuple(map(_mounting, mountings)), tuple(map(_position, positions)))
    try:
        core_schedule = CoreSchedule(schedule)
    except CoreRefusal as refusal:
        raise _table_at_fault(refusal, schedule, mountings, positions).refuse(f"is refused: {refusal}") from None
    _require_identifying(core_schedule, file)
    given = [table.matrix("matrix") for table in mountings]
    off = {one.number: np.abs(np.subtract(one.matrix, matrix)).max() for one, matrix in zip(schedule.mountings, given)}
    changed = [number for number, by in off.items() if by > 0.0]
    if changed:
        which = f"matrix of mounting {changed[0]}" if len(changed) == 1 else f"matrices of {len(changed)} mountings"
        tell(f"tumble: notice: {file}: {which} made orthonormal, by {max(off.values()):.1g}")
    return core_schedule


def _require_identifying(schedule: CoreSchedule, file: str) -> None:
    """Raise BadInput for a schedule, called `file`, that does not identify all coefficients."""
    try:
        schedule.identify()
    except CoreRefusal as refusal:
        raise BadInput(f"these positions cannot identify {', '.join(refusal.details['unidentified'])}", file) from None


def _tell_of_left_out(schedule: CoreSchedule, estimator: str, file: str) -> None:
    """Name the fit positions that a closed form takes nothing from, and why."""
    fit = [position for position in schedule.data.positions if position.use == FIT]
    unit = np.eye(3 * len(schedule)).reshape(-1, len(schedule), 3)
    taken = np.abs(estimate_runs(schedule, unit, estimator)).reshape(len(schedule), -1).max(axis=1) > 0.0
    out = [one for one, used in zip(schedule.data.positions, taken.tolist()) if not used and one.use == FIT]
    if out:
        numbers = dict.fromkeys(position.mounting for position in out)
        why = "; ".join(_why_left_out([p for p in fit if p.mounting == one], one, out) for one in numbers)
        labels = ", ".join(position.label for position in out)
        noun = "position" if len(out) == 1 else "positions"
        tell(f"tumble: warning: {file}: {estimator} leaves out fit {noun} {labels} ({why}); least_squares takes all")


def _why_left_out(fit: list[Position], number: int, out: list[Position]) -> str:
    """Of the mounting `number` with these `fit` positions, some of which are `out`."""
    angles = {position.angle_deg for position in fit}
    circle = next(one for one in _CIRCLES if one is _CIRCLES[-1] or angles <= set(one))
    lacking = [f"{angle:g}" for angle in circle if angle not in angles]
    if any(position not in out for position in fit):
        return f"mounting {number} has its circle without"
    if lacking:
        return f"mounting {number} lacks {', '.join(lacking)} deg"
    return f"no block axis of mounting {number} lies along the level axis"


def _mounting(table: Table) -> Mounting:
    table.only("number", "matrix", "axis_tilt_deg", "bolting")
    tilt_deg = table.number("axis_tilt_deg", -_LARGEST_TILT_DEG, _LARGEST_TILT_DEG, default=0.0)
    number, matrix = table.integer("number", 1, _LARGEST_NUMBER), _rotation(table.matrix("matrix"))
    return Mounting(number, matrix, tilt_deg, table.integer("bolting", 1, _LARGEST_NUMBER, default=None))


def _rotation(given: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
    """The matrix as it is given; where it was typed to a few decimals the nearest rotation. One that is farther off, or
    a reflection, is left for the core to refuse."""
    left, _, right = np.linalg.svd(np.array(given))
    nearest = left @ right
    exact = np.abs(np.array(given) @ np.transpose(given) - np.eye(3)).max() <= _EXACT
    typed = np.abs(nearest - given).max() <= _TYPED and np.linalg.det(nearest) > 0.0
    return tuple(map(tuple, nearest.tolist())) if typed and not exact else given


def _position(table: Table) -> Position:
    table.only("mounting", "position", "angle_deg", "use")
    return Position(
        table.integer("mounting", 1, _LARGEST_NUMBER),
        table.integer("position", 1, _LARGEST_NUMBER),
        table.number("angle_deg", -_LARGEST_ANGLE_DEG, _LARGEST_ANGLE_DEG),
        table.choice("use", (FIT, CHECK), default=FIT),
    )


def _table_at_fault(refusal: CoreRefusal, schedule: Schedule, mountings: list[Table], positions: list[Table]) -> Table:
    """The table that the core complains of: sizes are judged first, then mountings, then positions."""
    if refusal.name == "TUMBLE_E_SCHEDULE_SIZE":
        return mountings[MAX_MOUNTINGS] if len(mountings) > MAX_MOUNTINGS else positions[MAX_POSITIONS]
    numbers = [mounting.number for mounting in schedule.mountings]
    same_mounting = refusal.name == "TUMBLE_E_SCHEDULE_DUPLICATE" and len(set(numbers)) < len(numbers)
    tables = mountings if same_mounting or refusal.name == "TUMBLE_E_SCHEDULE_ROTATION" else positions
    where: int = refusal.details["where"]
    return tables[where]


def to_toml(schedule: Schedule) -> str:
    """A schedule file's text, which reads back as the same schedule."""
    tables = []
    for one in schedule.mountings:
        rows = ", ".join(f"[{', '.join(map(repr, row))}]" for row in one.matrix)
        tilt = f"axis_tilt_deg = {one.tilt_deg!r}\n" if one.tilt_deg else ""
        bolting = f"bolting = {one.bolting}\n" if one.bolting else ""
        tables.append(f"[[mounting]]\nnumber = {one.number}\nmatrix = [{rows}]\n{tilt}{bolting}")
    for place in schedule.positions:
        numbers = f"mounting = {place.mounting}\nposition = {place.number}\n"
        tables.append(f'[[position]]\n{numbers}angle_deg = {place.angle_deg!r}\nuse = "{place.use}"\n')
    return "\n".join(tables)
