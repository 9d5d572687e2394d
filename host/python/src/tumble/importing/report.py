"""What an import tells: as text of 80 columns, as a document of schema tumble.import/1, and as the run file itself."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Callable
from typing import Any

import numpy as np

from tumble._version import __version__
from tumble.arrays import Floats
from tumble.files.run_layout import TEMPERATURE
from tumble.importing.match import JOINED, LEFT_OUT, NOWHERE, OFF, REPEATED, TAKEN
from tumble.importing.order import NONE
from tumble.importing.pipeline import Imported

SCHEMA = "tumble.import/1"
WIDTH = 80
_REMARKS = {
    TAKEN: "",
    JOINED: "joined to the next",
    REPEATED: "left out: comes again",
    OFF: "left out: is off",
    NOWHERE: "left out: nowhere",
    LEFT_OUT: "left out as told",
}


def text(done: Imported) -> str:
    """For people."""
    files = ", ".join(os.path.basename(one.file) for one in done.recordings)
    rows = len(done.outputs)
    taken = sum(rest.samples for rest, position in zip(done.rests, done.matched.positions) if position != NONE)
    placed = set(done.matched.positions.tolist()) - {NONE}
    lines = [
        *_wrapped(f"import of {files}"),
        "",
        f"{rows} rows, {taken} of them at {len(placed)} of {len(done.schedule.positions)} positions"
        f" of {os.path.basename(done.settings.schedule_name)}",
        "",
        *_table(done),
        "",
        *(line for note in (*_thresholds(done), *done.notes) for line in _wrapped(note, "- ")),
    ]
    return "\n".join(lines) + "\n"


def _wrapped(line: str, mark: str = "") -> list[str]:
    return textwrap.wrap(line, WIDTH, initial_indent=mark, subsequent_indent=" " * len(mark)) or [""]


def _table(done: Imported) -> list[str]:
    timed = done.seconds is not None
    heading = f"{'rest':>4} {'position':>8} {'from s' if timed else 'from row':>10} {'to s' if timed else 'to row':>10}"
    lines = [f"{heading} {'samples':>8} {'off mrad':>9}  remark"]
    for number, (rest, position, state, off) in enumerate(
        zip(done.rests, done.matched.positions, done.matched.states, done.matched.off), 1
    ):
        label = "-" if position == NONE else done.schedule.positions[position].label
        if done.seconds is None:
            span = f"{done.line(rest.begin):>10} {done.line(rest.end - 1):>10}"
        else:
            span = f"{done.seconds[rest.begin]:>10.2f} {done.seconds[rest.end - 1]:>10.2f}"
        remark = _REMARKS[state]
        lines.append(f"{number:>4} {label:>8} {span} {rest.samples:>8} {1e3 * off:>9.2f}  {remark}".rstrip()[:WIDTH])
    return lines


def _thresholds(done: Imported) -> list[str]:
    if done.labelled and done.seconds is None:
        return []
    limits, found = done.settings.thresholds, done.found
    noise = " ".join(f"{one:.3g}" for one in found.noise)
    unit = f" {done.unit}" if done.unit_told else ""
    length = (
        f"--window {limits.window_s:g} s, --min-rest {limits.min_rest_s:g} s"
        if done.seconds is not None
        else f"windows of {limits.window_samples} samples, rests of {limits.min_rest_samples} or more"
    )
    return [
        f"rests: {len(done.rests)}; noise of a sample, x y z: {noise}{unit}; still: scatter below --still "
        f"{limits.still:g} times that, block means within --drift {limits.drift:g} of theirs; {length}",
        f"matched within --tolerance {_degrees(done):g} deg; usual distance {1e3 * done.matched.spread:.3g} mrad",
    ]


def _degrees(done: Imported) -> float:
    return round(math.degrees(done.settings.claims.tolerance), 6)


def document(done: Imported) -> dict[str, Any]:
    """Of schema tumble.import/1."""
    limits = done.settings.thresholds
    timed = done.seconds is not None
    return {
        "schema": SCHEMA,
        "tumble": __version__,
        "recordings": [
            {"file": os.path.basename(one.file), "sha256": digest, "rows": len(one.outputs)}
            for one, digest in zip(done.recordings, done.sha256())
        ],
        "schedule": os.path.basename(done.settings.schedule_name),
        "unit": done.unit if done.unit_told else None,
        "order": done.settings.claims.order,
        "signs": None if done.settings.claims.signs is None else list(done.settings.claims.signs),
        "by_labels": done.labelled,
        "thresholds": {
            "window_s": limits.window_s if timed else None,
            "min_rest_s": limits.min_rest_s if timed else None,
            "window_samples": None if timed else limits.window_samples,
            "min_rest_samples": None if timed else limits.min_rest_samples,
            "still": limits.still,
            "drift": limits.drift,
            "tolerance_deg": _degrees(done),
        },
        "noise": done.found.noise.tolist(),
        "rests": [_rest(done, index) for index in range(len(done.rests))],
        "missing": _missing(done),
        "K": done.matched.fit.k.tolist(),
        "U0": done.matched.fit.u0.tolist(),
        "spread_rad": done.matched.spread,
        "assumed": list(done.notes),
    }


def _missing(done: Imported) -> list[dict[str, int]]:
    present = set(done.matched.positions.tolist())
    return [
        {"mounting": place.mounting, "position": place.number}
        for index, place in enumerate(done.schedule.positions)
        if index not in present
    ]


def _rest(done: Imported, index: int) -> dict[str, Any]:
    rest, position = done.rests[index], int(done.matched.positions[index])
    place = None if position == NONE else done.schedule.positions[position]
    seconds = done.seconds
    return {
        "file": int(done.file_of_row[rest.begin]) + 1,
        "first_row": done.line(rest.begin),
        "last_row": done.line(rest.end - 1),
        "from_s": None if seconds is None else float(seconds[rest.begin]),
        "to_s": None if seconds is None else float(seconds[rest.end - 1]),
        "samples": rest.samples,
        "mounting": None if place is None else place.mounting,
        "position": None if place is None else place.number,
        "state": done.matched.states[index],
        "off_rad": float(done.matched.off[index]),
        "mean": rest.mean.tolist(),
    }


def run_csv(done: Imported) -> str:
    """The run file: the samples at positions, in the order in which they were measured."""
    files = ", ".join(ascii(os.path.basename(one.file))[1:-1] for one in done.recordings)
    unit = f" [{done.unit}]" if done.unit_told else ""
    columns: list[tuple[str, Floats, Callable[[float], str]]]
    columns = [(f"u{axis}{unit}", done.outputs[:, place], repr) for place, axis in enumerate("xyz")]
    columns += [] if done.seconds is None else [("time_s", done.seconds, "{:.6f}".format)]
    columns += [("rest", _numbers(done), "{:.0f}".format)]
    columns += [] if done.temperatures_c is None else [(TEMPERATURE, done.temperatures_c, _known)]
    lines = [
        f"# tumble import {__version__} of {files}; schedule {os.path.basename(done.settings.schedule_name)}",
        ",".join(["mounting", "position", *(name for name, *_ in columns)]),
    ]
    for rest, position in zip(done.rests, done.matched.positions):
        if position == NONE:
            continue
        place, rows = done.schedule.positions[position], slice(rest.begin, rest.end)
        fields = [map(written, values[rows].tolist()) for _, values, written in columns]
        lines += [f"{place.mounting},{place.number},{','.join(row)}" for row in zip(*fields)]
    return "\n".join(lines) + "\n"


def _numbers(done: Imported) -> Floats:
    """The number of the rest that a row is in."""
    found = np.zeros(len(done.outputs))
    for number, rest in enumerate(done.rests, 1):
        found[rest.begin : rest.end] = number
    return found


def _known(value: float) -> str:
    """Nothing for what is not known."""
    return "" if math.isnan(value) else repr(value)
