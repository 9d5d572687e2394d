"""What an import tells: as text of 80 columns, as a document of schema tumble.import/1, and as the run file itself.

Recipes: what an import was told and found out about the layout, as TOML, to do the same with the next recording.

[import]      schedule, order, signs ("++-"), repeats, tolerance_deg, rate_hz, time_unit
[layout]      delimiter, decimal, unit
[columns]     ux, uy, uz, time, mounting, position, angle, number, temperature: names in the file
[thresholds]  window_s, min_rest_s, window_samples, min_rest_samples, still, drift
[mountings]   numbers by name
[can]         dbc, identifier, channel, v_per_count: of CAN logs

Rests to leave out or to take belong to one recording and are not in it.
"""

from __future__ import annotations

import json
import math
import os
import re
import textwrap
from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np

from tumble._version import __version__
from tumble.arrays import Floats
from tumble.errors import BadInput, quoted
from tumble.files.run_layout import TEMPERATURE, Wishes
from tumble.files.toml import Table, read_toml
from tumble.importing.attitudes import Signs
from tumble.importing.can_bus import Bus
from tumble.importing.clock import UNITS
from tumble.importing.match import JOINED, LEFT_OUT, NOWHERE, OFF, REPEATED, REPEATS, TAKEN, Claims
from tumble.importing.order import ANY, NONE, SCHEDULE
from tumble.importing.pipeline import Imported, Settings
from tumble.importing.recording import COLUMNS, Timing
from tumble.importing.rests import Thresholds

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
    taken = int(done.rests.samples[done.matched.positions != NONE].sum())
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
    rests, matched = done.rests, done.matched
    columns = zip(rests.begin, rests.end, matched.positions, matched.states, matched.off)
    for number, (begin, end, position, state, off) in enumerate(columns, 1):
        label = "-" if position == NONE else done.schedule.positions[position].label
        if done.seconds is None:
            span = f"{done.line(begin):>10} {done.line(end - 1):>10}"
        else:
            span = f"{done.seconds[begin]:>10.2f} {done.seconds[end - 1]:>10.2f}"
        remark = _REMARKS[state]
        lines.append(f"{number:>4} {label:>8} {span} {end - begin:>8} {1e3 * off:>9.2f}  {remark}".rstrip()[:WIDTH])
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
    begin, end = int(done.rests.begin[index]), int(done.rests.end[index])
    position, seconds = int(done.matched.positions[index]), done.seconds
    place = None if position == NONE else done.schedule.positions[position]
    return {
        "file": int(done.file_of_row[begin]) + 1,
        "first_row": done.line(begin),
        "last_row": done.line(end - 1),
        "from_s": None if seconds is None else float(seconds[begin]),
        "to_s": None if seconds is None else float(seconds[end - 1]),
        "samples": end - begin,
        "mounting": None if place is None else place.mounting,
        "position": None if place is None else place.number,
        "state": done.matched.states[index],
        "off_rad": float(done.matched.off[index]),
        "mean": done.rests.means[index].tolist(),
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
    for begin, end, position in zip(done.rests.begin, done.rests.end, done.matched.positions):
        if position == NONE:
            continue
        place, rows = done.schedule.positions[position], slice(begin, end)
        fields = [map(written, values[rows].tolist()) for _, values, written in columns]
        lines += [f"{place.mounting},{place.number},{','.join(row)}" for row in zip(*fields)]
    return "\n".join(lines) + "\n"


def _numbers(done: Imported) -> Floats:
    """The number of the rest that a row is in."""
    found = np.zeros(len(done.outputs))
    for number, (begin, end) in enumerate(zip(done.rests.begin, done.rests.end), 1):
        found[begin:end] = number
    return found


def _known(value: float) -> str:
    """Nothing for what is not known."""
    return "" if math.isnan(value) else repr(value)


_LARGEST = 1e6


def read(file: str) -> Settings:
    """The settings of a recipe. Raises BadInput with file and row."""
    top = read_toml(file)
    top.only("import", "layout", "columns", "thresholds", "mountings", "can")
    main = (top.table("import") or Table(file, {}, ("import",), {})).only(
        "schedule", "order", "signs", "repeats", "tolerance_deg", "rate_hz", "time_unit"
    )
    layout = (top.table("layout") or Table(file, {}, ("layout",), {})).only("delimiter", "decimal", "unit")
    columns = (top.table("columns") or Table(file, {}, ("columns",), {})).only(*COLUMNS)
    mountings, can = top.table("mountings"), top.table("can")
    tolerance = main.number("tolerance_deg", 0.01, 45.0, default=None)
    claims = Claims(
        signs=parse_signs(main.text("signs", default=None), file),
        order=main.choice("order", (SCHEDULE, ANY), default=SCHEDULE),
        repeats=main.choice("repeats", REPEATS, default=None),
    )
    return Settings(
        schedule=main.text("schedule", default=None),
        wishes=Wishes(
            columns={key: columns.text(key) for key in sorted(columns.keys)},
            delimiter=layout.text("delimiter", default=None),
            decimal=layout.choice("decimal", (".", ","), default=None),
            unit=layout.text("unit", default=None),
        ),
        timing=Timing(
            rate_hz=main.number("rate_hz", 1.0 / _LARGEST, _LARGEST, default=None),
            unit=main.choice("time_unit", tuple(UNITS), default=None),
        ),
        thresholds=_toml_thresholds(top.table("thresholds")),
        claims=claims if tolerance is None else replace(claims, tolerance=math.radians(tolerance)),
        mountings={} if mountings is None else {k: mountings.integer(k, 1, 255) for k in sorted(mountings.keys)},
        bus=Bus() if can is None else _bus(can),
    )


def _bus(table: Table) -> Bus:
    table.only("dbc", "identifier", "channel", "v_per_count")
    return Bus(
        dbc=table.text("dbc", default=None),
        identifier=table.integer("identifier", 0, 0x7FF, default=None),
        channel=table.text("channel", default=None),
        v_per_count=table.number("v_per_count", 0.0, _LARGEST, default=0.0),
    )


def _toml_thresholds(table: Table | None) -> Thresholds:
    if table is None:
        return Thresholds()
    table.only(*(one.name for one in fields(Thresholds)))
    found: dict[str, object] = {f"{name}_samples": None for name in ("window", "min_rest") if f"{name}_s" in table.keys}
    for one in fields(Thresholds):
        if one.name in table.keys:
            whole = one.name.endswith("_samples")
            found[one.name] = table.integer(one.name, 1, 10**6) if whole else table.number(one.name, 1e-6, _LARGEST)
    return Thresholds(**found)  # type: ignore[arg-type] # of each field its own kind


def parse_signs(text: str | None, file: str) -> Signs | None:
    """Of three signs, such as "++-". Raises BadInput."""
    if text is None:
        return None
    if not re.fullmatch(r"[+-]{3}", text):
        raise BadInput(f"signs {quoted(text)} are not three of + and -, of x, y and z", file)
    x, y, z = (1 if sign == "+" else -1 for sign in text)
    return x, y, z


def to_toml(settings: Settings) -> str:
    """A recipe's text, which reads back as the same settings but for rests that are left out or taken."""
    claims, timing, wishes = settings.claims, settings.timing, settings.wishes
    signs = None if claims.signs is None else "".join("+" if sign > 0 else "-" for sign in claims.signs)
    tables: dict[str, dict[str, object]] = {
        "import": {
            "schedule": settings.schedule_name,
            "order": claims.order,
            "signs": signs,
            "repeats": claims.repeats,
            "tolerance_deg": round(math.degrees(claims.tolerance), 9),
            "rate_hz": timing.rate_hz,
            "time_unit": timing.unit,
        },
        "layout": {"delimiter": wishes.delimiter, "decimal": wishes.decimal, "unit": wishes.unit},
        "columns": dict(wishes.columns),
        "thresholds": {one.name: getattr(settings.thresholds, one.name) for one in fields(Thresholds)},
        "mountings": {json.dumps(key): number for key, number in settings.mountings.items()},
        "can": {key: value or None for key, value in vars(settings.bus).items()},
    }
    return "\n".join(filter(None, (_as_toml(name, values) for name, values in tables.items())))


def _as_toml(name: str, values: dict[str, object]) -> str:
    lines = [f"{key} = {_written(value)}" for key, value in values.items() if value is not None]
    return "\n".join([f"[{name}]", *lines, ""]) if lines else ""


def _written(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)
