"""Of one block, its calibrations over years: its parameters, and its control charts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.messages import signed
from tumble.pictures.canvas import BLACK, BLUE, GREY, MINUS, ORANGE, VERMILLION, blank, legend_above, picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tumble.documents.history import Point, Trend

_ROWS, _COLUMNS = 4, 3  # scales, angles, biases, seat
_HEIGHT_MM, _CHART_MM = 150.0, 80.0
_CHARTS = ((slice(0, 9), "o", BLUE, "parameters of the block"), (slice(9, 12), "x", ORANGE, "its seat"))


@picture
def trend(document: Trend) -> Figure:
    """A picture of the points of a document of schema tumble.history/1, kind trend: every parameter less its first
    value, with its standard uncertainty. Alarms are diamonds. Raises IndexError without points."""
    series, alarms = _series(document), _alarms(document)
    figure = blank("trend", _HEIGHT_MM, "Parameters of a block over time")
    axes = figure.subplots(_ROWS, _COLUMNS, sharex=True)
    for one, (name, points) in zip(axes.flat, series.items()):
        days, values = _days(points), [point.value for point in points]
        one.axhline(0.0, color=GREY, linewidth=0.5)
        one.errorbar(days, values, [point.u for point in points], fmt="o-", color=BLUE, linewidth=0.6, gid=name)
        beyond = [place for place, point in enumerate(points) if (name, point.measured) in alarms]
        one.plot(
            [days[place] for place in beyond], [values[place] for place in beyond], "D", color=VERMILLION, zorder=3
        )
        one.set_title(f"{name}, {signed(points[0].unit)}")
        _dated(one)
    return figure


@picture
def control_chart(document: Trend) -> Figure:
    """The control charts of the same points: how far every calibration is from what was foreseen, in its standard
    deviations, its moving average as a line, and the control limits. Alarms are diamonds with their names."""
    series, alarms = list(_series(document).items()), _alarms(document)
    figure = blank("control_chart", _CHART_MM, "Control charts of a block", room_above=0.02)
    axes = figure.subplots()
    for some, marker, colour, label in _CHARTS:
        for name, points in series[some]:
            days, z = _days(points), np.array([point.z for point in points], dtype=float)
            average = np.array([point.ewma for point in points], dtype=float)
            shown = label if points is series[some][0][1] else None  # one of them is enough
            axes.plot(days, z, marker, color=colour, markersize=3.5, label=shown, gid=name)
            axes.plot(days, average, color=colour, linewidth=0.4, gid=f"ewma_{name}")
            for day, point, size in zip(days, points, z):
                if (name, point.measured) in alarms:
                    axes.plot([day], [size], "D", color=VERMILLION)
                    axes.annotate(name, (day, size), (4.0, 0.0), textcoords="offset points", va="center")
    for side in (-1.0, 1.0):
        axes.axhline(side * document.control_limit, color=BLACK, linestyle="--", linewidth=0.6)
    axes.set_ylabel("found less foreseen, in its standard deviations".replace("-", MINUS))
    _dated(axes)
    legend_above(axes, len(_CHARTS))
    return figure


def _series(document: Trend) -> dict[str, list[Point]]:
    """By parameter, in the order of time."""
    found: dict[str, list[Point]] = {}
    for point in document.points:
        found.setdefault(point.parameter, []).append(point)
    return found


def _alarms(document: Trend) -> set[tuple[str, str]]:
    return {(one.parameter, one.measured) for one in document.alarms}


def _days(points: list[Point]) -> Any:
    return np.array([point.measured.removesuffix("Z") for point in points], dtype="datetime64[s]")


def _dated(axes: Any) -> None:
    """Few dates, each as short as it can be."""
    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter

    locator = AutoDateLocator(minticks=2, maxticks=6)
    axes.xaxis.set_major_locator(locator)
    axes.xaxis.set_major_formatter(ConciseDateFormatter(locator, show_offset=False))
