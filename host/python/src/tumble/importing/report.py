"""What an import tells: as text of 80 columns, as a document of schema tumble.import/1, as the run file, and as a
recipe.

A recipe is what an import was told and found out about the layout, as TOML, to do the same with the next recording.

[import]      schedule, order, signs ("++-"), repeats, tolerance_deg, rate_hz, time_unit
[layout]      delimiter, decimal, unit, rows
[columns]     ux, uy, uz, time, mounting, position, angle, number, temperature: names in the file
[thresholds]  window_s, min_rest_s, window_samples, min_rest_samples, still, drift
[mountings]   numbers by name
[can]         dbc, identifier, channel, v_per_count: of CAN logs

Rests to leave out or to take belong to one recording and are not in it.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import textwrap
from collections.abc import Callable
from dataclasses import fields, replace

import numpy as np

from tumble._version import __version__
from tumble.arrays import Floats
from tumble.documents import importing as doc
from tumble.errors import BadInput, quoted
from tumble.files.run_layout import TEMPERATURE, LayoutOptions
from tumble.files.toml import Table, read_toml
from tumble.importing import match
from tumble.importing.attitudes import Signs
from tumble.importing.can_bus import Bus
from tumble.importing.clocks import UNITS, Timing
from tumble.importing.pipeline import Imported, Settings
from tumble.importing.recording import COLUMNS, Choice
from tumble.importing.rests import Thresholds
from tumble.schedule import ANY_POSE

WIDTH = 80
_REMARKS = {
    match.TAKEN: "",
    match.JOINED: "joined to the next",
    match.REPEATED: "left out: repeated",
    match.OFF: "left out: off its position",
    match.NOWHERE: "left out: at no position",
    match.LEFT_OUT: "left out by --leave-out",
}


def text(found: doc.Import) -> str:
    """For people."""
    rows = sum(one.rows for one in found.recordings)
    placed = [rest for rest in found.rests if rest.position is not None]
    count = len({(rest.mounting, rest.position) for rest in placed})
    lines = [
        *_wrapped(f"import of {', '.join(one.file for one in found.recordings)}"),
        "",
        f"{rows} rows, {sum(rest.samples for rest in placed)} of them at {count} of {count + len(found.missing)}"
        f" positions of {found.schedule}",
        "",
        *_table(found),
        "",
        *(line for note in (*_thresholds(found), *found.assumed) for line in _wrapped(note, "- ")),
    ]
    return "\n".join(lines) + "\n"


def _wrapped(line: str, mark: str = "") -> list[str]:
    return textwrap.wrap(line, WIDTH, initial_indent=mark, subsequent_indent=" " * len(mark)) or [""]


def _table(found: doc.Import) -> list[str]:
    begin, end = ("from row", "to row") if found.thresholds.window_s is None else ("from s", "to s")
    matched = found.schedule != ANY_POSE  # there a rest is at no given attitude
    off = f" {'off mrad':>9}" if matched else ""
    lines = [f"{'rest':>4} {'position':>8} {begin:>10} {end:>10} {'samples':>8}{off}  remark"]
    for number, rest in enumerate(found.rests, 1):
        label = "-" if rest.position is None else f"{rest.mounting}.{rest.position}"
        span = f"{rest.first_row:>10} {rest.last_row:>10}"
        if rest.from_s is not None and rest.to_s is not None:
            span = f"{rest.from_s:>10.2f} {rest.to_s:>10.2f}"
        off = f" {1e3 * rest.off_rad:>9.2f}" if matched else ""
        line = f"{number:>4} {label:>8} {span} {rest.samples:>8}{off}  {_REMARKS[rest.state]}"
        lines.append(line.rstrip()[:WIDTH])
    return lines


def _thresholds(found: doc.Import) -> list[str]:
    limits = found.thresholds
    if found.by_labels and limits.window_s is None:
        return []
    noise = " ".join(f"{one:.3g}" for one in found.noise)
    unit = "" if found.unit is None else f" {found.unit}"
    length = f"windows of {limits.window_samples} samples, rests of {limits.min_rest_samples} or more"
    if limits.window_s is not None:
        length = f"--window {limits.window_s:g} s, --min-rest {limits.min_rest_s:g} s"
    lines = [
        f"rests: {len(found.rests)}; noise of a sample, x y z: {noise}{unit}; at rest: scatter below {limits.still:g} "
        f"times the noise (--still), block means within {limits.drift:g} times their own noise (--drift); {length}"
    ]
    if found.schedule != ANY_POSE:
        distance = f"{1e3 * found.spread_rad:.3g} mrad"
        lines.append(f"matched within --tolerance {limits.tolerance_deg:g} deg; usual distance {distance}")
    return lines


def document(done: Imported) -> doc.Import:
    """All that an import found."""
    user_choices, limits, positions = done.settings.user_choices, done.settings.thresholds, done.schedule.positions
    timed, present = done.seconds is not None, set(done.matched.positions.tolist())
    return doc.Import(
        tumble=__version__,
        recordings=tuple(
            doc.Recording(os.path.basename(one.file), hashlib.sha256(one.data).hexdigest(), len(one.outputs))
            for one in done.recordings
        ),
        schedule=os.path.basename(done.settings.schedule_name),
        unit=done.unit if done.unit_told else None,
        order=user_choices.order,
        signs=user_choices.signs,
        by_labels=done.labelled,
        thresholds=doc.Thresholds(
            window_s=limits.window_s if timed else None,
            min_rest_s=limits.min_rest_s if timed else None,
            window_samples=None if timed else limits.window_samples,
            min_rest_samples=None if timed else limits.min_rest_samples,
            still=limits.still,
            drift=limits.drift,
            tolerance_deg=round(math.degrees(user_choices.tolerance), 6),
        ),
        noise=done.found.noise,
        rests=tuple(_rest(done, index) for index in range(len(done.rests))),
        missing=tuple(doc.Missing(p.mounting, p.number) for index, p in enumerate(positions) if index not in present),
        K=done.matched.fit.k,
        U0=done.matched.fit.u0,
        spread_rad=done.matched.spread,
        assumed=done.notes,
    )


def _rest(done: Imported, index: int) -> doc.Rest:
    begin, end = int(done.rests.begin[index]), int(done.rests.end[index])
    position, seconds = int(done.matched.positions[index]), done.seconds
    place = None if position == match.NONE else done.schedule.positions[position]
    return doc.Rest(
        file=int(done.file_of_row[begin]) + 1,
        first_row=done.line(begin),
        last_row=done.line(end - 1),
        from_s=None if seconds is None else float(seconds[begin]),
        to_s=None if seconds is None else float(seconds[end - 1]),
        samples=end - begin,
        mounting=None if place is None else place.mounting,
        position=None if place is None else place.number,
        state=done.matched.states[index],
        off_rad=float(done.matched.off[index]),
        mean=done.rests.means[index],
    )


def run_csv(done: Imported) -> str:
    """The run file: the samples at positions, in the order in which they were measured."""
    files = ", ".join(ascii(os.path.basename(one.file))[1:-1] for one in done.recordings)
    unit = f" [{done.unit}]" if done.unit_told else ""
    number = np.zeros(len(done.outputs))  # of the rest that a row is in
    for rest, (begin, end) in enumerate(zip(done.rests.begin, done.rests.end), 1):
        number[begin:end] = rest
    columns: list[tuple[str, Floats, Callable[[float], str]]]
    columns = [(f"u{axis}{unit}", done.outputs[:, place], repr) for place, axis in enumerate("xyz")]
    columns += [] if done.seconds is None else [("time_s", done.seconds, "{:.6f}".format)]
    columns += [("rest", number, "{:.0f}".format)]
    if (felt := done.temperatures_c) is not None:
        columns.append((TEMPERATURE, felt, lambda value: "" if math.isnan(value) else repr(value)))
    lines = [
        f"# tumble import {__version__} of {files}; schedule {os.path.basename(done.settings.schedule_name)}",
        ",".join(["mounting", "position", *(name for name, *_ in columns)]),
    ]
    for begin, end, position in zip(done.rests.begin, done.rests.end, done.matched.positions):
        if position == match.NONE:
            continue
        place, rows = done.schedule.positions[position], slice(begin, end)
        fields = [map(written, values[rows].tolist()) for _, values, written in columns]
        lines += [f"{place.mounting},{place.number},{','.join(row)}" for row in zip(*fields)]
    return "\n".join(lines) + "\n"


_LARGEST = 1e6


def read_recipe(file: str) -> Settings:
    """The settings of a recipe. Raises BadInput with file and row."""
    top = read_toml(file).only("import", "layout", "columns", "thresholds", "mountings", "can")

    def table(name: str) -> Table:
        return top.table(name) or Table(file, {}, (name,), {})

    main = table("import").only("schedule", "order", "signs", "repeats", "tolerance_deg", "rate_hz", "time_unit")
    layout = table("layout").only("delimiter", "decimal", "unit", "rows")
    columns, mountings = table("columns").only(*COLUMNS), table("mountings")
    rows = layout.text("rows", default=None)
    tolerance, signs = main.number("tolerance_deg", 0.01, 45.0, default=None), main.text("signs", default=None)
    if signs is not None and parse_signs(signs) is None:
        raise BadInput(f"signs {quoted(signs)} must be three of + and -, for x, y and z", file)
    user_choices = match.UserChoices(
        signs=None if signs is None else parse_signs(signs),
        order=main.choice("order", (match.SCHEDULE, match.ANY), default=match.SCHEDULE),
        repeats=main.choice("repeats", match.REPEATS, default=None),
    )
    return Settings(
        schedule=main.text("schedule", default=None),
        layout=LayoutOptions(
            columns={key: columns.text(key) for key in sorted(columns.keys)},
            delimiter=layout.text("delimiter", default=None),
            decimal=layout.choice("decimal", (".", ","), default=None),
            unit=layout.text("unit", default=None),
        ),
        timing=Timing(
            rate_hz=main.number("rate_hz", 1.0 / _LARGEST, _LARGEST, default=None),
            unit=main.choice("time_unit", tuple(UNITS), default=None),
        ),
        thresholds=_toml_thresholds(table("thresholds")),
        user_choices=user_choices if tolerance is None else replace(user_choices, tolerance=math.radians(tolerance)),
        mountings={name: mountings.integer(name, 1, 255) for name in sorted(mountings.keys)},
        bus=_bus(table("can").only("dbc", "identifier", "channel", "v_per_count")),
        rows=None if rows is None else Choice.parsed(rows),
    )


def _bus(table: Table) -> Bus:
    return Bus(
        dbc=table.text("dbc", default=None),
        identifier=table.integer("identifier", 0, 0x7FF, default=None),
        channel=table.text("channel", default=None),
        v_per_count=table.number("v_per_count", 0.0, _LARGEST, default=0.0),
    )


def _toml_thresholds(table: Table) -> Thresholds:
    table.only(*(one.name for one in fields(Thresholds)))
    found: dict[str, object] = {f"{name}_samples": None for name in ("window", "min_rest") if f"{name}_s" in table.keys}
    for one in fields(Thresholds):
        if one.name in table.keys:
            whole = one.name.endswith("_samples")
            found[one.name] = table.integer(one.name, 1, 10**6) if whole else table.number(one.name, 1e-6, _LARGEST)
    return Thresholds(**found)  # type: ignore[arg-type] # of each field its own kind


def parse_signs(text: str) -> Signs | None:
    """Of three of + and -, such as "++-"; None: it is none."""
    if not re.fullmatch(r"[+-]{3}", text):
        return None
    x, y, z = (1 if sign == "+" else -1 for sign in text)
    return x, y, z


def recipe_text(settings: Settings) -> str:
    """A recipe's text, which reads back as the same settings but for rests that are left out or taken."""
    user_choices, timing, options = settings.user_choices, settings.timing, settings.layout
    signs = None if user_choices.signs is None else "".join("+" if sign > 0 else "-" for sign in user_choices.signs)
    tables: dict[str, dict[str, object]] = {
        "import": {
            "schedule": settings.schedule_name,
            "order": user_choices.order,
            "signs": signs,
            "repeats": user_choices.repeats,
            "tolerance_deg": round(math.degrees(user_choices.tolerance), 9),
            "rate_hz": timing.rate_hz,
            "time_unit": timing.unit,
        },
        "layout": {
            "delimiter": options.delimiter,
            "decimal": options.decimal,
            "unit": options.unit,
            "rows": settings.rows and settings.rows.text,
        },
        "columns": dict(options.columns),
        "thresholds": {one.name: getattr(settings.thresholds, one.name) for one in fields(Thresholds)},
        "mountings": {json.dumps(key): number for key, number in settings.mountings.items()},
        "can": {key: value or None for key, value in vars(settings.bus).items()},
    }
    written = []
    for name, values in tables.items():
        lines = [f"{k} = {json.dumps(v, ensure_ascii=False)}" for k, v in values.items() if v is not None]
        written += ["\n".join([f"[{name}]", *lines, ""])] if lines else []
    return "\n".join(written)
