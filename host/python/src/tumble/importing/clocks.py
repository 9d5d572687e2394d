"""The clock of a recording: of a column of numbers in any unit, of dates and times of day, of a rate that is said.

What a header says of the unit is believed unless it is impossible; what it does not say, the numbers show: how
long a sample takes, and all of them. Rows that come in bursts, or share a time stamp, are spread evenly. Neighbouring
rows that have changed places are sorted; a clock that is set back has a gap there.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput, Remedy, quoted

UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86400.0}
CONTRADICTED = "clock: --rate says"
WITHOUT = "--rate HZ reads the recording without it"
NO_CLOCK = Remedy({"columns": "time="}, "its samples are evenly spaced")
ROWS_OF_CLOCK = 5000  # that tell its rate well enough
_IN_NAME = re.compile(
    r"(?:[\[(\s_./]|^t|time|stamp|^)(nsec|nanos|ns|usec|micros|us|µs|\u03bcs|msec|millis|ms|seconds|secs?|s|minutes|min|hours|h"
    r"|days|d)[\])]?\s*$",
    re.IGNORECASE,
)
_WORDS = {
    **dict.fromkeys(("sec", "secs", "seconds"), "s"), **dict.fromkeys(("msec", "millis"), "ms"),
    **dict.fromkeys(("usec", "micros", "µs", "\u03bcs"), "us"), **dict.fromkeys(("nsec", "nanos"), "ns"),
    "minutes": "min", "hours": "h", "days": "d",
}  # fmt: skip
_OF_DAY = re.compile(r"(?:(\d{1,2}):)?(\d{1,2}):(\d{1,2}(?:[.,:]\d+)?)\s*(?:([ap])\.?m\.?)?", re.IGNORECASE)
_DATE = re.compile(r"(\d{1,4})[-/.](\d{1,2})[-/.](\d{1,4})[T ]+(.*)")
_GAP = 5.0  # intervals: a step of the clock beyond is a gap
_BURSTS = 0.02  # of the steps, that are gaps: more, all alike, are the way the rows come
_SAME_RATE = 1.2  # of two rates, a factor
_FEWEST_STEPS = 10
_SLOWEST_S, _SLOWEST_AT_ALL_S = 0.5, 60.0  # between samples of a recording, as they usually are
_QUICKEST_S, _FEWEST_ROWS = 5.0, 50  # nobody has a block at all its positions in less, in more than so many rows
_NEIGHBOURS = 16  # rows further apart than so have not changed places


@dataclass(frozen=True)
class Clock:
    """`seconds` (rows,), from the first row on; `interval_s`: usual, between two rows; `gaps`: rows before which time
    is missing or the clock was set back; `notes`: sentences on what was taken for granted; `order`: rows as they follow
    each other in time, None: as they stand; `unit`: of the numbers, empty: of none; `told` by the user or sure."""

    seconds: Floats
    interval_s: float
    gaps: Integers
    notes: tuple[str, ...]
    order: Integers | None = None
    unit: str = ""
    told: bool = False


@dataclass(frozen=True)
class Timing:
    """What the user says about time: `rate_hz` instead of a clock; `unit` of its numbers, one of UNITS. `files`: how
    many recordings are one run."""

    rate_hz: float | None = None
    unit: str | None = None
    files: int = 1


def of_rate(rows: int, rate_hz: float, *notes: str) -> Clock:
    """Of a rate that somebody says."""
    return Clock(np.arange(rows) / rate_hz, 1.0 / rate_hz, np.zeros(0, dtype=int), notes)


def of_numbers(values: Floats, name: str, timing: Timing, file: str) -> Clock:
    """Of a column of numbers; its unit is the one that the user told, or that its name ends in, if that can be, or that
    the numbers look like. Raises BadInput."""
    steps = np.diff(values)
    if len(steps) and (steps < 0.0).sum() > 0.9 * len(steps):  # newest first
        own = of_numbers(values[::-1], name, timing, file)
        order = np.arange(len(values))[::-1] if own.order is None else len(values) - 1 - own.order
        note = "clock: it runs backwards, so the rows are read from the last to the first"
        return replace(own, notes=(note, *own.notes), order=order)
    forward = steps[steps > 0.0]
    if not len(forward):
        raise BadInput(f"column {quoted(name)} does not increase: {WITHOUT}", file).advising(NO_CLOCK)
    in_name = None if re.fullmatch(r"ts", name, re.IGNORECASE) else _IN_NAME.search(name)
    named = None if in_name is None else _WORDS.get(in_name[1].lower(), in_name[1].lower())
    step, span = float(np.median(forward)), float(forward[forward <= _GAP * np.quantile(forward, 0.99)].sum())
    unit, note = timing.unit, ""
    if unit is None:
        unit = _unit_of(step, span, named, len(values), timing.files)
        if named is None:
            note = f"clock: {quoted(name)} names no unit, its steps of {step:.6g} are read as {unit} (--time-unit)"
        elif unit != named:
            lasts = f"{span * UNITS[named]:.3g} s for {len(values)} rows"
            note = f"clock: {quoted(name)} names {named}, which makes {lasts}: read as {unit} (--time-unit)"
    own = _with_gaps((values - values[0]) * UNITS[unit], [note] if note else [], file, unit)
    return replace(own, told=timing.unit is not None)


def _unit_of(step: float, span: float, named: str | None, rows: int, files: int) -> str:
    """By how long a sample takes, and all of them."""
    quickest = 0.0 if rows < _FEWEST_ROWS else _QUICKEST_S / files
    if named is not None and span * UNITS[named] >= quickest:
        return named
    for slowest in (_SLOWEST_S, _SLOWEST_AT_ALL_S):
        for unit, size in UNITS.items():
            if step * size <= slowest and span * size >= quickest:
                return unit
    return named or "s"


def others(clock: Clock, rows: int, files: int) -> list[str]:
    """Units that the numbers of a clock can have as well, by how long a sample takes and all of them."""
    size, span = UNITS[clock.unit], float(clock.seconds[-1] - clock.seconds[0])
    quickest = 0.0 if rows < _FEWEST_ROWS else _QUICKEST_S / files
    return [
        unit
        for unit, own in UNITS.items()
        if unit != clock.unit and clock.interval_s * own / size <= _SLOWEST_S and span * own / size >= quickest
    ]


def of_texts(texts: list[str], file: str, lines: Integers) -> Clock:
    """Of a column of dates or times of day. Raises BadInput."""
    seconds = []
    for text, line in zip(texts, lines):
        second = _second(text.strip())
        if second is None:
            advice = f"a number, 12:34:56.789 or 2026-05-01T12:34:56.789; {WITHOUT}"
            raise BadInput(f"{quoted(text)} is not a time: {advice}", file, int(line), "time").advising(NO_CLOCK)
        seconds.append(second)
    values = np.array(seconds)
    return _with_gaps(values - values[0], [], file)


def moves_seldom(clock: Clock) -> bool:
    """Does it change at fewer rows than a run has positions, as a temperature may?"""
    return len(clock.seconds) > _FEWEST_ROWS and int((np.diff(clock.seconds) != 0.0).sum()) < _FEWEST_STEPS


def contradiction(own: Clock, rate_hz: float, name: str) -> list[str]:
    """That the file's `own` clock, of the column `name`, has another rate than the one that the user says; nothing
    where they agree, or where the clock has moved on too seldom to tell."""
    seen = 1.0 / own.interval_s
    moved = int((np.diff(own.seconds) > 0.0).sum())
    if moved < _FEWEST_STEPS or seen / _SAME_RATE < rate_hz < seen * _SAME_RATE:
        return []
    return [f"{CONTRADICTED} {rate_hz:g} Hz, but {quoted(name)} advances at {seen:.4g} Hz: which is right?"]


def _second(text: str) -> float | None:
    """Of a time of day, with or without a date before it: of each date only how far it is from another counts."""
    date, day = _DATE.fullmatch(text), 0
    if date is not None:
        parts = [int(part) for part in date.group(1, 2, 3)]
        year, month, at = parts if len(date[1]) > 2 else (parts[2], parts[1], parts[0])
        month, at = (month, at) if month <= 12 else (at, month)  # 11/25/2026
        try:
            day = datetime(year if year > 99 else 2000 + year, month, at).toordinal() - datetime(2000, 1, 1).toordinal()
        except ValueError:
            return None
    clock = text if date is None else re.sub(r"\s*(Z|[+-]\d{2}:?\d{2})$", "", date[4])
    if found := _OF_DAY.fullmatch(clock):
        hours, minutes, seconds, half = found.groups()
        whole, mark, decimals = re.fullmatch(r"(\d+)([.,:]?)(\d*)", seconds).groups()  # type: ignore[union-attr]
        if hours is None and not mark:
            hours, minutes, whole = minutes, whole, "0"  # 12:34
        hour = int(hours or 0) % 12 + 12 * (half.lower() == "p") if half else int(hours or 0)
        return 86400.0 * day + 3600.0 * hour + 60.0 * int(minutes) + float(f"{whole}.{decimals or 0}")
    text = text.replace(",", ".").removesuffix("Z")
    whole, point, decimals = text.partition(".")
    if point and decimals.isdigit():  # with six of them, as older versions of Python want it
        text = f"{whole}.{decimals[:6]:0<6}"
    try:
        moment = datetime.fromisoformat(text)
    except ValueError:
        return None
    return (moment.replace(tzinfo=None) - datetime(2000, 1, 1)).total_seconds()


def _with_gaps(seconds: Floats, notes: list[str], file: str, unit: str = "") -> Clock:
    seconds, order, swapped = _sorted(seconds)
    steps = np.diff(seconds)
    forward = steps[steps > 0.0]
    if not len(forward):
        raise BadInput(f"the clock stands still: {WITHOUT}", file).advising(NO_CLOCK)
    interval = period = float(np.median(forward))
    far = forward[forward > _GAP * interval]
    if len(far) > max(_BURSTS * len(steps), _FEWEST_STEPS) and np.quantile(far, 0.9) < 2.0 * np.quantile(far, 0.1):
        period = float(np.median(far))
    uneven = len(forward) < 0.8 * len(steps) or period > interval
    if uneven:
        near = steps[(steps >= 0.0) & (steps <= _GAP * period)]
        interval = float(near.mean())
        what = f"{len(forward)} of {len(steps)} rows" if period == float(np.median(forward)) else "bursts of rows"
        notes.append(f"clock: it advances at {what}; {1 / max(interval, 1e-9):.4g} Hz on average")
    if swapped:
        notes.append(f"clock: {swapped} rows were out of order and are sorted")
    back = steps < 0.0
    if back.sum() > len(forward):
        raise BadInput(f"the clock runs backwards: {WITHOUT}", file).advising(NO_CLOCK)
    gaps = np.flatnonzero(back | (steps > _GAP * max(interval, period))) + 1
    if back.any():
        notes.append(f"clock: set back {int(back.sum())} times, each step back counts as a gap")
    return Clock(seconds, interval, gaps, tuple(notes), order, unit)


def _sorted(seconds: Floats) -> tuple[Floats, Integers | None, int]:
    """By time where neighbouring rows have changed places, their order, and how many those are; a clock that is set
    back, for longer than a few rows, stays."""
    back = np.flatnonzero(np.diff(seconds) < 0.0)
    if not len(back):
        return seconds, None, 0
    order, begin = np.arange(len(seconds)), 0
    usual = float(np.median(np.abs(np.diff(seconds))))
    far = back[seconds[back] - seconds[back + 1] > _NEIGHBOURS * usual] + 1
    for end in (*far.tolist(), len(seconds)):
        order[begin:end] = begin + np.argsort(seconds[begin:end], kind="stable")
        begin = end
    swapped = len(back) - len(far)
    return (seconds[order], order, swapped) if swapped else (seconds, None, 0)
