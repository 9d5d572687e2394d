"""What a history tells, as documents of schema tumble.history/1 and as text."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.documents.history import (
    Alarm,
    Calibration,
    Due,
    DueBlock,
    Listing,
    ParameterGrowth,
    Point,
    Trend,
    TypeOfBlock,
)
from tumble.documents.labels import iso
from tumble.errors import listed
from tumble.history import due as dues, trend as trends
from tumble.history.calibrations import OF_BLOCK, PARAMETERS, unpacked
from tumble.history.database import Columns
from tumble.history.trend import DAY_S, Filtered, Growth, Series

UNITS = ("ppm",) * 3 + ("urad",) * 3 + ("ug",) * 3 + ("urad",) * 3
KINDS = {trends.JUMP: "jump", trends.OUTLIER: "outlier", trends.OPEN: "open", trends.DRIFT: "drift"}
YEAR = 365.25  # days
MILLION = 1e6
_FOR_EVER = 100.0 * YEAR
_SAME_C = 1.0  # temperatures that differ by less need no remark
_TAKES_TIME = ("growth", "interval")  # whys of a day that may lie beyond that
_MOST_LINES = 40  # of a list, as text


@dataclass(frozen=True)
class Group:
    """Blocks of one type with about as many calibrations."""

    kind: str
    growth: Growth | None
    series: Series
    found: Filtered


def groups_of(columns: Columns, confidence: float) -> tuple[list[Group], dict[str, int]]:
    """All blocks, filtered by the growth of their types; and how many calibrations are left out, by why."""
    fleet, left_out = trends.fleet_of(columns)
    limit, groups = trends.control_limit(confidence), []
    unknown = Growth(*np.zeros((3, len(PARAMETERS))))
    for kind, them in fleet.items():
        growth = trends.growth_of(them, limit)
        groups += [Group(kind, growth, one, trends.filtered(one, growth or unknown, limit)) for one in them]
    return groups, left_out


def listing(name: str, columns: Columns) -> Listing:
    keys = ("serial", "type", "stand", "schedule", "estimator", "sha256")
    rows = (
        Calibration(
            **{key: columns[key][row] for key in keys},
            measured=iso(columns["created_s"][row]),
            passed=bool(columns["passed"][row]),
            believed=bool(columns["believed"][row]),
            u_norm_g=_known(columns["u_norm_g"][row]),
            temperature_c=_known(columns["temperature_c"][row]),
        )
        for row in range(len(columns["id"]))
    )
    return Listing(history=name, calibrations=tuple(rows))


def trend(name: str, columns: Columns, confidence: float, serial: str | None = None) -> Trend:
    """Growth and alarms. `serial`: of this block the alarms alone, and the points of its charts."""
    groups, left_out = groups_of(columns, confidence)
    types: dict[str, list[Group]] = {}
    for one in groups:
        types.setdefault(one.kind, []).append(one)
    alarms = [alarm for one in groups for alarm in _alarms(one) if serial in (None, alarm.serial)]
    return Trend(
        history=name,
        confidence=confidence,
        control_limit=trends.control_limit(confidence),
        blocks=sum(len(one.series.serials) for one in groups),
        calibrations=sum(int((one.series.rows >= 0).sum()) for one in groups),
        left_out=left_out,
        without_gravity=sum(_without_gravity(one.series, columns) for one in groups),
        temperatures_apart_c=max((_temperatures_apart(one.series, columns) for one in groups), default=0.0),
        types=tuple(_type(kind, them) for kind, them in types.items()),
        alarms=tuple(sorted(alarms, key=lambda one: (one.measured, one.serial))),
        points=tuple(point for one in groups for point in _points(one, serial)),
    )


def _without_gravity(series: Series, columns: Columns) -> int:
    return int((np.isnan(columns["gravity_m_s2"][series.rows]) & (series.rows >= 0)).sum())


def _temperatures_apart(series: Series, columns: Columns) -> float:
    """The largest difference within a block, of those that are known."""
    known = np.where(series.rows >= 0, columns["temperature_c"][series.rows], np.nan)
    highest = np.where(np.isnan(known), -np.inf, known).max(axis=1, initial=-np.inf)
    lowest = np.where(np.isnan(known), np.inf, known).min(axis=1, initial=np.inf)
    return float(np.maximum(highest - lowest, 0.0).max(initial=0.0))


def _type(kind: str, groups: Sequence[Group]) -> TypeOfBlock:
    growth = groups[0].growth
    return TypeOfBlock(
        type=kind,
        blocks=sum(len(one.series.serials) for one in groups),
        calibrations=sum(int((one.series.rows >= 0).sum()) for one in groups),
        intervals=sum(one.series.intervals for one in groups) if growth is None else growth.intervals,
        growth=None if growth is None else tuple(map(_growth, [growth] * len(PARAMETERS), range(len(PARAMETERS)))),
    )


def _growth(growth: Growth, place: int) -> ParameterGrowth:
    year, root = MILLION * YEAR, MILLION * YEAR**0.5
    return ParameterGrowth(
        name=PARAMETERS[place],
        unit=UNITS[place],
        drift=float(growth.drift[place]) * year,
        u_drift=_known(growth.u_drift[place] * year),
        spread=float(growth.spread[place]) * year,
        u_spread=_known(growth.u_spread[place] * year),
        walk=float(growth.walk[place]) * root,
        u_walk=_known(growth.u_walk[place] * root),
        ratio=_known(growth.ratio[place]),
    )


def _alarms(group: Group) -> list[Alarm]:
    """Of a type whose growth is unknown there are none."""
    if group.growth is None:
        return []
    kinds, found = group.found.kinds, []
    of_block: Flags = np.any(kinds[..., :OF_BLOCK] > trends.IN_ORDER, axis=2)
    for block, k, place in np.argwhere(kinds > trends.IN_ORDER).tolist():
        kind = int(kinds[block, k, place])
        shown = group.found.ewma if kind == trends.DRIFT else group.found.z
        found.append(
            Alarm(
                serial=group.series.serials[block],
                type=group.kind,
                measured=iso(group.series.days[block, k] * DAY_S),
                parameter=PARAMETERS[place],
                kind=KINDS[kind],
                size=float(group.found.size[block, k, place]) * MILLION,
                unit=UNITS[place],
                z=float(shown[block, k, place]),
                of_seat=place >= OF_BLOCK and not of_block[block, k],
            )
        )
    return found


def _points(group: Group, serial: str | None) -> list[Point]:
    series, found = group.series, group.found
    if serial not in series.serials:
        return []
    block = series.serials.index(serial)
    return [
        Point(
            measured=iso(series.days[block, k] * DAY_S),
            parameter=PARAMETERS[place],
            value=float(series.values[block, k, place] - series.values[block, 0, place]) * MILLION,
            u=float(np.sqrt(series.variances[block, k, place])) * MILLION,
            unit=UNITS[place],
            z=_known(found.z[block, k, place]),
            ewma=_known(found.ewma[block, k, place]),
        )
        for k in np.flatnonzero(series.rows[block] >= 0).tolist()
        for place in range(len(PARAMETERS))
    ]


def due(
    name: str,
    columns: Columns,
    limit_g: float,
    coverage: float,
    method: str,
    confidence: float,
    serial: str | None = None,
) -> Due:
    """The blocks, or the one of this `serial`, by when they are due."""
    groups, left_out = groups_of(columns, confidence)
    found = [one for group in groups for one in _due_blocks(group, columns, limit_g, coverage, method)]
    found = [one for one in found if serial in (None, one.serial)]
    found.sort(key=lambda one: (one.due or "9999", one.serial))
    return Due(
        history=name,
        method=method,
        limit_g=limit_g,
        coverage_factor=coverage,
        left_out=left_out,
        blocks=tuple(found),
    )


def _due_blocks(group: Group, columns: Columns, limit_g: float, coverage: float, method: str) -> list[DueBlock]:
    series, blocks = group.series, np.arange(len(group.series.serials))
    end = (series.rows >= 0).sum(axis=1) - 1
    rows = series.rows[blocks, end]
    if method == dues.STAIRCASE:
        days, why = _by_staircase(series, columns, rows, end, limit_g)
    else:
        days, why = _by_control_chart(group, columns, rows, limit_g, coverage)
    alarm = (group.found.kinds[blocks, end, :OF_BLOCK] == trends.OPEN).any(axis=1) & (group.growth is not None)
    days, why = np.where(alarm, 0.0, days), np.where(alarm, "alarm", why)
    last = series.days[blocks, end] * DAY_S
    return [
        DueBlock(
            serial=serial,
            type=group.kind,
            last=iso(last[block]),
            days=float(days[block]) if days[block] <= _FOR_EVER else None,
            due=iso(last[block] + days[block] * DAY_S) if days[block] <= _FOR_EVER else None,
            why=str(why[block]),
        )
        for block, serial in enumerate(series.serials)
    ]


def _by_staircase(
    series: Series, columns: Columns, rows: Integers, end: Integers, limit_g: float
) -> tuple[Floats, Integers]:
    """The last interval runs from the last calibration that is at least a day earlier: a run repeated on the same day
    says nothing about intervals."""
    blocks, last = np.arange(len(rows)), series.days[np.arange(len(rows)), end]
    earlier = (series.days <= last[:, None] - 1.0).sum(axis=1)
    before = np.maximum(earlier - 1, 0)
    changes = (series.values[blocks, end] - series.values[blocks, before])[:, :OF_BLOCK]
    off = dues.worst_changes(_of(columns, rows, 3), _of(columns, rows, 6), changes)
    days = dues.staircase(last - series.days[blocks, before], off, limit_g)
    return np.where(earlier > 0, days, np.nan), np.where(earlier > 0, "interval", "one calibration")


def _by_control_chart(
    group: Group, columns: Columns, rows: Integers, limit_g: float, coverage: float
) -> tuple[Floats, Integers]:
    if group.growth is None:
        return np.full(len(rows), np.nan), np.full(len(rows), "no growth known")
    covariance = unpacked(columns["covariance"][rows].tolist())
    angles, bias = _of(columns, rows, 3), _of(columns, rows, 6)
    forecast = dues.Forecast.of(angles, bias, covariance, group.found.last, group.growth.walk)
    days = forecast.days(limit_g, coverage)
    return days, np.where(days > 0.0, "growth", "not shown")


def _of(columns: Columns, rows: Integers, first: int) -> Floats:
    """Three parameters (rows, 3)."""
    return np.stack([columns[name][rows] for name in PARAMETERS[first : first + 3]], axis=1)


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def render_listing(told: Listing) -> str:
    """A line for each calibration."""
    lines = [f"{'measured':17} {'serial':16} {'type':12} {'stand':16} {'verdict':9} {'u(|a|), ug':>10}"]
    for one in told.calibrations:
        verdict = "pass" if one.passed else "not shown" if one.believed else "fail"
        u = "-" if one.u_norm_g is None else f"{one.u_norm_g * MILLION:.3g}"
        day, named = f"{_day(one.measured)} {one.measured[11:16]}", f"{_cut(one.serial)} {_cut(one.type, 12)}"
        lines.append(f"{day}  {named} {_cut(one.stand)} {verdict:9} {u:>10}")
    return "\n".join([*lines, _counted(len(told.calibrations), "calibration"), ""])


def render_trend(told: Trend) -> str:
    """Growth by type, then the alarms."""
    lines = [f"{_sizes(told)}{_left_out(told.left_out)}"]
    if told.without_gravity:
        lines.append(f"Without gravity_m_s2: {told.without_gravity}, taken as measured at their blocks' usual one")
    if told.temperatures_apart_c > _SAME_C:
        apart = f"{told.temperatures_apart_c:.3g} deg C"
        lines.append(f"Temperatures of a block differ by up to {apart}: that counts as a change")
    for kind in told.types:
        lines += ["", f"Type {kind.type or '-'}: {_sizes(kind)}"]
        if kind.growth is None:
            lines.append(f"Growth unknown: {_counted(kind.intervals, 'interval')}, {trends.LEAST_INTERVALS} are needed")
            continue
        lines.append(f"{'':9} {'drift/year':>20} {'spread/year':>20} {'walk/sqrt(year)':>20}  {'unit':5} {'ratio':>5}")
        for one in kind.growth:
            drift = _with_uncertainty(one.drift, one.u_drift, sign="+")
            deviations = [_with_uncertainty(one.spread, one.u_spread), _with_uncertainty(one.walk, one.u_walk)]
            cells = " ".join(f"{cell:>20}" for cell in (drift, *deviations))
            ratio = "-" if one.ratio is None else f"{one.ratio:.2f}"
            lines.append(f"{one.name:9} {cells}  {one.unit:5} {ratio:>5}")
    share = f"{(1.0 - told.confidence) * 100:.3g} %"
    lines += ["", f"Control limit {told.control_limit:.2f}: at most {share} of calibrations in order give an alarm"]
    counts = Counter("seat" if one.of_seat else one.kind for one in told.alarms)
    lines += [f"Alarms: {listed([f'{count} {kind}' for kind, count in sorted(counts.items())]) if counts else 'none'}"]
    for alarm in told.alarms[-_MOST_LINES:]:
        what = f"seat ({alarm.kind})" if alarm.of_seat else alarm.kind
        size = f"{float(f'{alarm.size:.3g}'):+g} {alarm.unit}, {alarm.z:+.1f} sigma"
        lines.append(f"{_day(alarm.measured)} {_cut(alarm.serial)} {what:14} {alarm.parameter:9} {size}")
    if (more := len(told.alarms) - _MOST_LINES) > 0:
        lines.append(f"and {more} older ones (--json)")
    return "\n".join([*lines, ""])


def _with_uncertainty(size: float, u: float | None, sign: str = "") -> str:
    """With as many decimals as the first two digits of its uncertainty have."""
    if not u:
        return f"{size:{sign}.3g} +- {'unknown' if u is None else '0'}"
    decimals = max(0, 1 - math.floor(math.log10(u)))
    return f"{size:{sign}.{decimals}f} +- {u:.{decimals}f}"


def render_due(told: Due) -> str:
    """A line for each block, the one that is due first, first."""
    rule = f"{told.coverage_factor:g} u(|a|)" if told.method == dues.CONTROL_CHART else "staircase"
    lines = [f"Limit {told.limit_g:g} g, {rule}; {_counted(len(told.blocks), 'block')}{_left_out(told.left_out)}"]
    lines.append(f"{'due':10} {'serial':16} {'type':12} {'last':10} {'days':>6}  why")
    for one in told.blocks:
        days = "-" if one.days is None else f"{one.days:.0f}"
        day = "-" if one.due is None else _day(one.due)
        never = one.due is None and one.why in _TAKES_TIME
        why = f"not in {_FOR_EVER / YEAR:g} years" if never else one.why
        lines.append(f"{day:10} {_cut(one.serial)} {_cut(one.type, 12)} {_day(one.last)} {days:>6}  {why}")
    return "\n".join([*lines, ""])


def _left_out(counts: dict[str, int]) -> str:
    return f"; left out: {listed([f'{count} {why}' for why, count in counts.items()])}" if counts else ""


def _sizes(told: Trend | TypeOfBlock) -> str:
    return f"{_counted(told.blocks, 'block')}, {_counted(told.calibrations, 'calibration')}"


def _cut(text: str | None, width: int = 16) -> str:
    """As ASCII, padded or cut to the `width` of a column."""
    shown = (text or "-").encode("ascii", "backslashreplace").decode()
    return f"{shown if len(shown) <= width else shown[: width - 3] + '...':{width}}"


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _day(time: str) -> str:
    return time[:10]
