"""Recipes: what an import was told and found out about the layout, as TOML, to do the same with the next recording.

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
import re
from dataclasses import fields, replace

from tumble.errors import BadInput, quoted
from tumble.files.run_layout import Wishes
from tumble.files.toml import Table, read_toml
from tumble.importing.attitudes import Signs
from tumble.importing.can_bus import Bus
from tumble.importing.clock import UNITS
from tumble.importing.hypotheses import REPEATS, Claims
from tumble.importing.order import ANY, SCHEDULE
from tumble.importing.pipeline import Settings
from tumble.importing.recording import COLUMNS, Timing
from tumble.importing.rests import Thresholds

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
        thresholds=_thresholds(top.table("thresholds")),
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


def _thresholds(table: Table | None) -> Thresholds:
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
    return "\n".join(filter(None, (_table(name, values) for name, values in tables.items())))


def _table(name: str, values: dict[str, object]) -> str:
    lines = [f"{key} = {_written(value)}" for key, value in values.items() if value is not None]
    return "\n".join([f"[{name}]", *lines, ""]) if lines else ""


def _written(value: object) -> str:
    return json.dumps(value, ensure_ascii=False)
