"""The clock of a logger: seconds from the texts or numbers of a column, and where time is missing."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import BadInput, quoted

CONTRADICTED = "clock: --rate says"
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_IN_NAME = re.compile(r"(?:[\[(\s_]|^t|time|stamp)(ns|us|µs|ms|s|sec|seconds)[\])]?\s*$", re.IGNORECASE)
_WORDS = {"sec": "s", "seconds": "s", "µs": "us"}
_OF_DAY = re.compile(r"(\d{1,2}):(\d{2}):(\d{2}(?:[.,]\d+)?)")
_GAP = 5.0  # intervals: a step of the clock beyond is a gap
_SAME_RATE = 1.2  # of two rates, a factor
_FEWEST_STEPS = 10
_SLOWEST_S = 0.5  # between samples of a recording: beyond, a column without a unit does not count seconds


@dataclass(frozen=True)
class Clock:
    """`seconds` (rows,), from the first row on; `interval_s`: usual, between two rows; `gaps`: rows before which time
    is missing or the clock was set back; `notes`: sentences on what was taken for granted."""

    seconds: Floats
    interval_s: float
    gaps: Integers
    notes: tuple[str, ...]


def unit_in(name: str) -> str | None:
    """The unit that a column's name ends in, one of UNITS; None: it has none."""
    found = _IN_NAME.search(name)
    return None if found is None else _WORDS.get(found[1].lower(), found[1].lower())


def of_numbers(values: Floats, name: str, told_unit: str | None, file: str) -> Clock:
    """Of a column of numbers; `told_unit`: by the user, one of UNITS. Raises BadInput."""
    unit, notes = told_unit or unit_in(name), []
    steps = np.diff(values)
    forward = steps[steps > 0.0]
    if not len(forward):
        raise BadInput(f"column {quoted(name)} does not count: --rate HZ reads the recording without it", file)
    step = float(np.median(forward))
    if unit is None:
        unit = "s" if step <= _SLOWEST_S else "ms" if step < 1000.0 * _SLOWEST_S else "us"
        notes.append(f"clock: {quoted(name)} names no unit, steps of {step:.6g}: taken for {unit} (--time-unit)")
    return _clock((values - values[0]) * UNITS[unit], notes, file)


def of_texts(texts: list[str], file: str, lines: Integers) -> Clock:
    """Of a column of dates or times of day. Raises BadInput."""
    seconds = []
    for text, line in zip(texts, lines):
        second = _second(text)
        if second is None:
            advice = "a number, 12:34:56.789 or 2026-05-01T12:34:56.789; --rate HZ reads the recording without it"
            raise BadInput(f"{quoted(text)} is no time: {advice}", file, int(line), "time")
        seconds.append(second)
    values = np.array(seconds)
    return _clock(values - values[0], [], file)


def _second(text: str) -> float | None:
    if found := _OF_DAY.fullmatch(text.strip()):
        return 3600.0 * int(found[1]) + 60.0 * int(found[2]) + float(found[3].replace(",", "."))
    try:
        moment = datetime.fromisoformat(_padded(text.strip().replace(",", ".").removesuffix("Z")))
    except ValueError:
        return None
    return (moment.replace(tzinfo=None) - datetime(2000, 1, 1)).total_seconds()


def _padded(text: str) -> str:
    """With six decimals, as older versions of Python want them."""
    whole, point, decimals = text.partition(".")
    return f"{whole}.{decimals[:6]:0<6}" if point and decimals.isdigit() else text


def of_rate(rows: int, rate_hz: float, notes: Sequence[str] = ()) -> Clock:
    """Of so many samples at a rate that the user says."""
    return Clock(np.arange(rows) / rate_hz, 1.0 / rate_hz, np.zeros(0, dtype=int), tuple(notes))


def contradiction(own: Clock, rate_hz: float, name: str) -> list[str]:
    """That the file's `own` clock, of the column `name`, has another rate than the one that the user says; nothing
    where they agree, or where the clock has moved on too seldom to tell."""
    seen = 1.0 / own.interval_s
    moved = int((np.diff(own.seconds) > 0.0).sum())
    if moved < _FEWEST_STEPS or seen / _SAME_RATE < rate_hz < seen * _SAME_RATE:
        return []
    return [f"{CONTRADICTED} {rate_hz:g} Hz, but {quoted(name)} moves on at {seen:.4g} Hz: which is right?"]


def _clock(seconds: Floats, notes: list[str], file: str) -> Clock:
    steps = np.diff(seconds)
    forward = steps[steps > 0.0]
    if not len(forward):
        raise BadInput("the clock stands still: --rate HZ reads the recording without it", file)
    coarse = len(forward) < 0.8 * len(steps)
    interval = float(seconds[-1] - seconds[0]) / len(steps) if coarse else float(np.median(forward))
    if coarse:
        notes.append(
            f"clock: it moves on at {len(forward)} of {len(steps)} rows; {1 / max(interval, 1e-9):.4g} Hz on average"
        )
    if not interval > 0.0:
        raise BadInput("the clock runs backwards: --rate HZ reads the recording without it", file)
    back = steps < 0.0
    gaps = np.flatnonzero(back | (steps > _GAP * max(interval, float(np.median(forward))))) + 1
    if back.any():
        notes.append(f"clock: set back {int(back.sum())} times, taken for gaps")
    return Clock(seconds, interval, gaps, tuple(notes))
