"""Schedule files: mountings and test positions (TOML).

[[mounting]]   number, matrix (3 x 3, rows = block axes x, y, z in the table frame h, n, v), axis_tilt_deg
[[position]]   mounting, position, angle_deg, use = "fit" or "check"
"""

from __future__ import annotations

from tumble.core import MAX_MOUNTINGS, MAX_POSITIONS, CoreRefusal, CoreSchedule
from tumble.errors import BadInput
from tumble.estimators import PAPER
from tumble.files.toml import Table, read_toml
from tumble.schedule import CHECK, FIT, Mounting, Position, Schedule

_LARGEST_NUMBER = 255
_LARGEST_ANGLE_DEG = 3600.0
_LARGEST_TILT_DEG = 89.0


def read_schedule(file: str, data: bytes | None = None, estimator: str | None = None) -> CoreSchedule:
    """Read a schedule file that identifies all coefficients and has what an `estimator` needs, if one is named. `data`:
    what is in it, if that has been read. Raises BadInput with file, row and table."""
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
    try:
        core_schedule.identify()
    except CoreRefusal as refusal:
        raise BadInput(f"these positions cannot identify {', '.join(refusal.details['unidentified'])}", file) from None
    if estimator in PAPER:
        _require_positions(core_schedule, estimator, file)
    return core_schedule


def _require_positions(schedule: CoreSchedule, estimator: str, file: str) -> None:
    try:
        schedule.harmonic()
    except CoreRefusal:
        raise BadInput(f"lacks positions that {estimator} needs; least_squares solves any schedule", file) from None


def _mounting(table: Table) -> Mounting:
    table.only("number", "matrix", "axis_tilt_deg")
    tilt_deg = table.number("axis_tilt_deg", -_LARGEST_TILT_DEG, _LARGEST_TILT_DEG, default=0.0)
    return Mounting(table.integer("number", 1, _LARGEST_NUMBER), table.matrix("matrix"), tilt_deg)


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
