"""What a recording is not as it was measured, and how that shows: counts without their sign, stretches in which the
sensor did not measure, channels that are one or dead."""

from __future__ import annotations

import math

import numpy as np

from tumble.arrays import Flags, Floats
from tumble.errors import quoted
from tumble.files.run_rows import chance_of_a_value

_BITS = (8, 10, 12, 14, 16, 18, 20, 24, 32)  # of a converter
_TRAVELS = 1.05  # times as far, as numbers that have lost their sign
_DEAD, STUCK = 4, 12  # rows, at least, of zeros and of any other value
_REPEATS = 0.01  # of rows: a converter of which more are as the row before is coarse
_CHANCE = 1e-9  # that an honest rest repeats itself so
_CLEAR = 3.0  # times their noise, that two sources are apart


def signed(outputs: Floats) -> tuple[Floats, list[str]]:
    """Outputs (rows, 3), with their sign where they are two's complement that was written without it; a sentence on
    that. They are so if the channels travel a shorter way with it."""
    if len(outputs) < 2 or outputs.min() < 0.0 or (outputs != np.floor(outputs)).any():
        return outputs, []
    full = next((float(1 << bits) for bits in _BITS if outputs.max() < 1 << bits), None)
    if full is None or outputs.max() < full / 2:
        return outputs, []
    own = np.where(outputs < full / 2, outputs, outputs - full)
    way, own_way = (np.abs(np.diff(one, axis=0)).sum(axis=0) for one in (outputs, own))
    if not (way > _TRAVELS * own_way).any() or (own_way > _TRAVELS * way).any():
        return outputs, []
    return own, [f"outputs: unsigned counts; those from {full / 2:.0f} up are negative (two's complement)"]


def same_runs(outputs: Floats, least: int) -> list[tuple[int, int]]:
    """Rows, from one to another (exclusive), of stretches of so many rows that are equal in all channels."""
    same = np.concatenate([[False], (np.diff(outputs, axis=0) == 0.0).all(axis=1), [False]])
    edges = np.flatnonzero(np.diff(same.astype(int)))
    return [(int(first), int(last) + 1) for first, last in edges.reshape(-1, 2) if last - first + 1 >= least]


def zeros(outputs: Floats) -> Flags:
    """Rows (rows,) of stretches of nothing but zeros: a sensor feels 1 g, so it did not measure."""
    found = np.zeros(len(outputs), dtype=bool)
    for first, last in same_runs(outputs, _DEAD):
        found[first:last] = not outputs[first].any()
    return found


def stuck(outputs: Floats, noise: Floats, step: Floats) -> Flags:
    """Rows (rows,) of stretches that repeat one value where this `noise` (3,) would have changed it. None where rows
    repeat themselves now and then all over the recording, as those of a coarse converter do, even if a calibration has
    mixed its channels so that their `step` (3,) looks fine."""
    found = np.zeros(len(outputs), dtype=bool)
    likely = chance_of_a_value(float((noise / np.where(step > 0.0, step, np.inf)).max()))
    for first, last in same_runs(outputs, STUCK):
        found[first:last] = (last - first) * math.log(likely) < math.log(_CHANCE)
    others = np.diff(outputs[~found], axis=0) == 0.0
    return found & (len(others) > 0 and bool(others.all(axis=1).mean() <= _REPEATS))


def about_channels(outputs: Floats, names: dict[str, str]) -> str | None:
    """That a channel is dead, or that two are one; None: they are three."""
    own = [names.get(f"u{axis}", f"u{axis}") for axis in "xyz"]
    for channel in range(3):
        if len(outputs) > 1 and np.ptp(outputs[:, channel]) == 0.0:
            return f"{quoted(own[channel])} is {outputs[0, channel]:.6g} in every row: a dead channel"
        if len(outputs) > 1 and (outputs[:, channel] == outputs[:, channel - 1]).all():
            return f"{quoted(own[channel - 1])} and {quoted(own[channel])} are equal in every row: one channel twice"
    return None


def turns(outputs: Floats, source: list[str], rests: list[tuple[int, int]]) -> bool:
    """Are rows at rest of several sources, which the texts of `source` (rows,) tell apart?"""
    texts = np.array(source)
    values = list(dict.fromkeys(source))
    within, between, freedom = np.zeros(3), np.zeros(3), 0
    for begin, end in rests:
        parts = [outputs[begin:end][texts[begin:end] == value] for value in values]
        parts = [part for part in parts if len(part) > 1]
        if len(parts) < 2:
            continue
        within += np.sum([((part - part.mean(axis=0)) ** 2).sum(axis=0) for part in parts], axis=0)
        freedom += sum(len(part) - 1 for part in parts)
        between += np.var([part.mean(axis=0) for part in parts], axis=0)
    noise = within / max(freedom, 1)
    return bool(freedom and (between / max(len(rests), 1) > _CLEAR**2 * np.maximum(noise, 1e-300)).any())
