"""Stand files: what a stand, its block and its limits are declared to be (TOML).

[stand]        name, axis_tilt_rad, level_rad, remount_rad, angle_rad, noise_v, samples, limits, remount,
               seat_rad, platform_rad, encoder_rad, drift_v, inclination_rad
[block]        scale_v_per_g, misalignment_rad, serial, converter_bits, range_v, sample_rate_hz
[block.true]   K, U0                                               this block's own, for simulation and to recognise it
[motion]       velocity_deg_per_s, acceleration_deg_per_s2, settling_s
[item]         labels of your own: serial numbers, operator, date; carried into the result
[environment]  gravity_m_s2 with its standard uncertainty u_gravity_m_s2, temperature_c, pressure_hpa, humidity_percent,
               and texts; carried into the result
[accept]       delta_g_limit_g, coverage_factor                   how many u(|a|) must be within the limit
[set_angles]   learned, expires, runs, angles_deg, errors_rad, u_rad, repeatability_rad, u_repeatability_rad: what the
               table is known to be off by, as `tumble fixture learn` writes it

noise_v, drift_v, scale_v_per_g and range_v are one number for all channels, or an array of three, of x, y and z.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import date
from numbers import Integral, Real
from typing import Any

import numpy as np

from tumble.core import MAX_POSITIONS, MAX_SAMPLES
from tumble.defaults import DEFAULT_COVERAGE_FACTOR
from tumble.errors import BadInput, UsageError, quoted
from tumble.files.rows import HIGHEST_C, LOWEST_C
from tumble.files.toml import Table, read_toml
from tumble.schedule import mark_of
from tumble.stand import (
    COMMON,
    INDEPENDENT,
    LARGEST_ERROR_RAD,
    LIMIT_KINDS,
    SOURCES,
    PerChannel,
    SetAngles,
    Source,
    Stand,
    by_channel,
    over,
)

SERIALS = ("serial", "serial_number")  # what [item] may call it
TWO_SERIALS = "[block] and [item] of the stand file have different serial numbers: a certificate takes that of [block]"
SET_ANGLES = "set_angles"
_ANEW = ("repeatability_rad", "u_repeatability_rad")
_MOST_RUNS = 10000
_LARGEST_ANGLE_RAD = 0.5
_COVERAGE_FACTORS = (1.0, 10.0)
_LARGEST_V = 1e9  # far beyond any block, and far from where squares overflow
_ENVIRONMENT_RANGES = {
    "gravity_m_s2": (9.7, 9.9),
    "u_gravity_m_s2": (0.0, 0.2),
    "temperature_c": (LOWEST_C, HIGHEST_C),
    "pressure_hpa": (0.0, 2000.0),
    "humidity_percent": (0.0, 100.0),
}


def plain_key(key: str) -> str:
    """A label's name, however it is spelled: "Serial number" is serial_number."""
    return key.strip().lower().replace(" ", "_").replace("-", "_")


@dataclass(frozen=True)
class StandFile:
    """A stand file's contents. `block`, `truth`, `motion`: the tables' numbers and texts by key; `item` and
    `environment` as they go into the result. Whatever the file does not have is None."""

    stand: Stand
    block: dict[str, Any] | None = None
    truth: dict[str, Any] | None = None
    motion: dict[str, float] | None = None
    item: dict[str, Any] | None = None
    environment: dict[str, Any] | None = None
    delta_g_limit_g: float | None = None
    coverage_factor: float | None = None
    set_angles: SetAngles | None = None

    @property
    def serial(self) -> str | None:
        """Of the block; None if unknown."""
        return None if self.block is None else self.block.get("serial")

    @property
    def has_two_serials(self) -> bool:
        """Whether [item] has another than [block]."""
        labels = {plain_key(key): str(text).strip() for key, text in (self.item or {}).items()}
        labelled = next((labels[key] for key in SERIALS if labels.get(key)), None)
        return None not in (self.serial, labelled) and labelled != str(self.serial).strip()

    @property
    def step_v(self) -> PerChannel:
        """Size of a count of the block's converter, whose range is from -range_v to +range_v; 0 if unknown."""
        return 0.0 if self.block is None else converter_step_v(self.block)

    @property
    def decided_by(self) -> float:
        """The coverage factor of the decision rule."""
        return DEFAULT_COVERAGE_FACTOR if self.coverage_factor is None else self.coverage_factor


def read_stand(file: str, data: bytes | None = None) -> StandFile:
    """Read a stand file.

    Parameters
    ----------
    file : path
        TOML.
    data : bytes, optional
        What is in it, if that has been read.

    Returns
    -------
    StandFile

    Raises
    ------
    BadInput
        With file and row.
    """
    return _parsed(read_toml(file, data), file)


def _parsed(top: Table, file: str) -> StandFile:
    if top.keys and top.keys <= {"mounting", "position"}:
        raise BadInput("is a schedule file (--schedule), not a stand file", file)
    top.only("stand", "block", "motion", "item", "environment", "accept", SET_ANGLES)
    stand, block, motion = top.table("stand"), top.table("block"), top.table("motion")
    item, environment, accept = top.table("item"), top.table("environment"), top.table("accept")
    set_angles = top.table(SET_ANGLES)
    if stand is None:
        raise top.refuse("no table [stand]")
    return StandFile(
        stand=_stand(stand),
        block=None if block is None else _block(block),
        truth=None if block is None else _truth(block),
        motion=None if motion is None else _motion(motion),
        item=None if item is None else item.labels(),
        environment=None if environment is None else _environment(environment),
        delta_g_limit_g=None if accept is None else _limit(accept),
        coverage_factor=None if accept is None else accept.number("coverage_factor", *_COVERAGE_FACTORS, default=None),
        set_angles=None if set_angles is None else _set_angles(set_angles),
    )


def stand_file_of(stand: Any) -> StandFile:
    """What is declared of a stand: by a file, by what was read of one, by a mapping of its tables or of the keys of
    [stand], or by a Stand alone. Raises BadInput, UsageError."""
    if isinstance(stand, Mapping):
        tables = dict(stand) if "stand" in stand else {"stand": dict(stand)}
        return _parsed(Table("stand", tables, (), {}), "stand")
    if isinstance(stand, StandFile):
        require_stand(stand.stand, "stand")
        return stand
    if isinstance(stand, Stand):
        require_stand(stand, "stand")
        return StandFile(stand)
    if isinstance(stand, (str, os.PathLike)):
        return read_stand(os.fspath(stand))
    raise UsageError(f"stand: a {type(stand).__name__} is neither the path of a stand file nor a tumble.Stand")


def _set_angles(table: Table) -> SetAngles:
    table.only("learned", "expires", "runs", "angles_deg", "errors_rad", "u_rad", *_ANEW)
    learned, expires = (table.text(key) for key in ("learned", "expires"))
    for key, day in (("learned", learned), ("expires", expires)):
        if not is_day(day):
            raise table.refuse(f"must be a day such as 2026-11-30, not {quoted(day)}", key)
    angles = table.numbers("angles_deg", 2, MAX_POSITIONS)
    if len(set(map(mark_of, angles))) < len(angles):
        raise table.refuse("has an angle twice", "angles_deg")
    errors = table.vector("errors_rad", len(angles))
    if max(map(abs, errors)) > LARGEST_ERROR_RAD:
        raise table.refuse(f"must be {-LARGEST_ERROR_RAD:g} to {LARGEST_ERROR_RAD:g}", "errors_rad")
    u = table.vector("u_rad", len(angles))
    if not all(0.0 <= one <= _LARGEST_ANGLE_RAD for one in u):
        raise table.refuse(f"must be 0 to {_LARGEST_ANGLE_RAD:g}", "u_rad")
    repeatability, u_repeatability = (table.number(key, 0.0, _LARGEST_ANGLE_RAD) for key in _ANEW)
    runs = table.integer("runs", 2, _MOST_RUNS)
    return SetAngles(learned, expires, runs, angles, errors, u, repeatability, u_repeatability)


def is_day(text: str) -> bool:
    """Of the calendar, as 2026-11-30."""
    try:
        return date.fromisoformat(text).isoformat() == text
    except ValueError:
        return False


def with_set_angles(text: str, found: SetAngles) -> str:
    """The text of a stand file with these in place of any that it has."""
    kept = re.sub(rf"(?ms)^[ \t]*\[{SET_ANGLES}\].*?(?=^[ \t]*\[|\Z)", "", text).rstrip()

    def array(values: Iterable[float]) -> str:
        numbers = [repr(one) for one in values]
        lines = [", ".join(numbers[start : start + 4]) for start in range(0, len(numbers), 4)]
        return "[\n  " + ",\n  ".join(lines) + ",\n]"

    own = [
        f"[{SET_ANGLES}]",
        f'learned = "{found.learned}"',
        f'expires = "{found.expires}"',
        f"runs = {found.runs}",
        f"angles_deg = {array(found.angles_deg)}",
        f"errors_rad = {array(found.errors)}",
        f"u_rad = {array(found.u)}",
        f"repeatability_rad = {found.repeatability!r}",
        f"u_repeatability_rad = {found.u_repeatability!r}",
    ]
    return "\n".join([kept, "", *own, ""])


def converter_step_v(block: dict[str, Any]) -> PerChannel:
    """Size of a count of a block's converter; 0 if unknown."""
    if block["converter_bits"] is None or block["range_v"] is None:
        return 0.0
    return over(block["range_v"], math.ldexp(1.0, block["converter_bits"] - 1))


def read_block(file: str, data: bytes | None = None) -> tuple[dict[str, Any], dict[str, Any] | None]:
    """Read a file of [block] and [block.true] alone, which overrides a stand file's. `data`: as for `read_stand`.
    Raises BadInput."""
    top = read_toml(file, data)
    block = top.table("block")
    if block is None:
        raise top.refuse("no table [block]: a block file holds [block] and [block.true] alone")
    try:
        top.only("block")
    except BadInput as error:
        raise BadInput(f"{error.fault}: a block file holds [block] and [block.true] alone", file, error.row) from None
    return _block(block), _truth(block)


def _stand(table: Table) -> Stand:
    table.only("name", *(source.key for source in SOURCES.values()), "samples", "limits", "remount")
    errors: dict[str, Any] = {source.attribute: _error(table, source) for source in SOURCES.values()}
    return Stand(
        samples=table.integer("samples", 1, MAX_SAMPLES),
        limits=table.choice("limits", LIMIT_KINDS),
        remounting=table.choice("remount", (INDEPENDENT, COMMON), default=INDEPENDENT),
        name=table.text("name", default=""),
        **errors,
    )


def _largest(source: Source) -> float:
    return _LARGEST_ANGLE_RAD if source.is_angle else _LARGEST_V


def _error(table: Table, source: Source) -> PerChannel:
    read = table.number if source.is_angle else table.per_channel
    size = read(source.key, 0.0, _largest(source), **({} if source.required else {"default": source.undeclared}))
    if source.of_inclinations and size == 0.0:
        raise table.refuse("must not be 0: nothing is set exactly; leave it out if it is unknown", source.key)
    return size


def require_stand(stand: Stand, name: str) -> None:
    """Raise BadInput for a stand of the caller's own making that no stand file could declare; `name`: what errors call
    it."""
    for source in SOURCES.values():
        attribute, largest = source.attribute, _largest(source)
        value = getattr(stand, attribute)
        several = not source.is_angle and isinstance(value, tuple) and len(value) == 3
        if source.of_inclinations and value == source.undeclared:
            continue
        if source.of_inclinations and value == 0.0:
            raise BadInput("0 is not above 0: nothing is set exactly", name, column=attribute)
        if not all(isinstance(one, Real) and 0.0 <= float(one) <= largest for one in (value if several else [value])):
            raise BadInput(f"{quoted(value)} is not a number from 0 to {largest:g}", name, column=attribute)
    if not isinstance(stand.samples, Integral) or not 1 <= stand.samples <= MAX_SAMPLES:
        raise BadInput(f"{quoted(stand.samples)} is not a whole number from 1 to {MAX_SAMPLES}", name, column="samples")
    for attribute, choices in (("limits", LIMIT_KINDS), ("remounting", (INDEPENDENT, COMMON))):
        value = getattr(stand, attribute)
        if value not in choices:
            raise BadInput(f"{quoted(value)} is not one of {', '.join(choices)}", name, column=attribute)


def _block(table: Table) -> dict[str, Any]:
    table.only("scale_v_per_g", "misalignment_rad", "serial", "converter_bits", "range_v", "sample_rate_hz", "true")
    block: dict[str, Any] = {
        "scale_v_per_g": table.per_channel("scale_v_per_g"),
        "misalignment_rad": table.number("misalignment_rad", 0.0, _LARGEST_ANGLE_RAD),
        "serial": table.text("serial", default=None),
        "converter_bits": table.integer("converter_bits", 8, 32, default=None),
        "range_v": table.per_channel("range_v", 0.0, default=None),
        "sample_rate_hz": table.number("sample_rate_hz", 0.0, default=None),
    }
    for key in ("scale_v_per_g", "range_v", "sample_rate_hz"):
        if block[key] is not None and not by_channel(block[key]).all():
            raise table.refuse("must not be 0", key)
    for key in ("scale_v_per_g", "range_v"):
        sizes = np.abs(by_channel(1.0 if block[key] is None else block[key]))
        if not ((1.0 / _LARGEST_V <= sizes) & (sizes <= _LARGEST_V)).all():
            raise table.refuse(f"must be of a size from {1.0 / _LARGEST_V:g} to {_LARGEST_V:g}", key)
    return block


def _truth(block: Table) -> dict[str, Any] | None:
    table = block.table("true")
    if table is None:
        return None
    table.only("K", "U0")
    return {"K": table.matrix("K"), "U0": table.vector("U0", 3)}


def _motion(table: Table) -> dict[str, float]:
    keys = ("velocity_deg_per_s", "acceleration_deg_per_s2", "settling_s")
    table.only(*keys)
    return {key: value for key in keys if (value := table.number(key, 0.0, default=None)) is not None}


def _environment(table: Table) -> dict[str, Any]:
    """Texts under any key, but numbers only under keys whose unit and range are known."""
    labels = table.labels()
    for key, label in labels.items():
        if key in _ENVIRONMENT_RANGES:
            table.number(key, *_ENVIRONMENT_RANGES[key])
        elif not isinstance(label, str):
            table.only(*_ENVIRONMENT_RANGES, *(other for other in labels if other != key))
    if "u_gravity_m_s2" in labels and "gravity_m_s2" not in labels:
        raise table.refuse("needs gravity_m_s2", "u_gravity_m_s2")
    return labels


def _limit(table: Table) -> float | None:
    limit = table.only("delta_g_limit_g", "coverage_factor").number("delta_g_limit_g", 0.0, 1.0, default=None)
    if limit == 0.0:
        raise table.refuse("must not be 0", "delta_g_limit_g")
    return limit
