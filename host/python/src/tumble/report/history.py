"""The history of a block as a section of a report, and all blocks of a history as a page of `tumble watch`.

They say what `tumble history trend` and `due` say, by documents of schema tumble.history/1.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any
from urllib.parse import quote

from tumble.documents.history import Alarm, Due, DueBlock, Trend
from tumble.report import pages
from tumble.report.source import Fixed, Table, readable

WHY = {
    "growth": "on that day the uncertainty reaches the limit",
    "interval": "by the last interval",
    "alarm": "the last calibration is beyond its control limit",
    "not shown": "the limit is not kept even at once",
    "no growth known": "too few calibrations of its type show how it grows",
    "one calibration": "an interval needs two calibrations a day apart",
}
MOST_BLOCKS = 500  # of a page


def section(trend: Trend, due: Due) -> dict[str, Any]:
    """What history.html.j2 says of the one block that both are of."""
    from markupsafe import Markup

    from tumble.pictures import control_chart, svg, trend as over_time

    (block,) = due.blocks
    measured = sorted({one.measured for one in trend.points})
    drawn = {"trend": over_time(trend), "control_chart": control_chart(trend)} if measured else {}
    return {
        "serial": readable(block.serial),
        "facts": [
            (Fixed("Calibrations that count"), Fixed(_counted(measured))),
            (Fixed("Next calibration"), Fixed(_when(block))),
            (Fixed("Limit"), Fixed(_rule(due))),
        ],
        "alarms": _alarms(trend.alarms) if trend.alarms else None,
        "control_limit": f"{trend.control_limit:.2f}",
        "figures": [(name, Markup(svg(figure))) for name, figure in drawn.items()],
    }


def page(trend: Trend, due: Due, today: str) -> str:
    """HTML of the blocks of a history on a day, the one that is due first, first; of one block, with its points in
    `trend`, what a report says of it."""
    from markupsafe import Markup

    has_alarm = {one.serial for one in trend.alarms if one.kind == "open"}
    return pages.filled(
        pages.HISTORY_PAGE,
        {
            "style": Markup(pages.own(pages.STYLE).replace("NUMBER", pages.css_string(""))),
            "name": readable(due.history.rpartition("/")[2]),
            "rule": _rule(due),
            "limit": f"{due.limit_g:g}",
            "blocks": [_line(one, today, one.serial in has_alarm) for one in due.blocks[:MOST_BLOCKS]],
            "reasons": {one.why: WHY[one.why] for one in due.blocks},
            "more": max(len(due.blocks) - MOST_BLOCKS, 0),
            "history": section(trend, due) if trend.points else None,
        },
    )


def _line(block: DueBlock, today: str, has_alarm: bool) -> dict[str, Any]:
    is_over = block.due is not None and block.due[:10] < today
    due = f"{_day(block.due)}{', overdue' if is_over else ''}"
    alarm = "last calibration" if has_alarm else "none"
    cells = due, readable(block.type or "-"), _day(block.last), block.why, alarm
    return {"query": f"serial={quote(block.serial, safe='')}", "serial": readable(block.serial), "cells": cells}


def _alarms(alarms: Iterable[Alarm]) -> Table:
    columns = ("Day", "Parameter", "Alarm", "Size", "In standard deviations")
    rows = []
    for one in alarms:
        kind = "seat" if one.of_seat else one.kind
        cells = _day(one.measured), one.parameter, kind, f"{float(f'{one.size:.3g}'):+g} {one.unit}", f"{one.z:+.1f}"
        rows.append(tuple(map(Fixed, cells)))
    return Table(columns, rows, left=(1, 2))


def _counted(measured: list[str]) -> str:
    return f"{len(measured)}, {_day(measured[0])} to {_day(measured[-1])}" if measured else "none"


def _when(block: DueBlock) -> str:
    return f"{'due ' + _day(block.due) if block.due else 'no day known'}: {WHY[block.why]}"


def _rule(due: Due) -> str:
    return f"{due.coverage_factor:g} u(|a|) within {due.limit_g:g} g"


def _day(time: str | None) -> str:
    return "-" if time is None else time[:10]
