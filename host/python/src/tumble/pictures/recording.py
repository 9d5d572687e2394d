"""A recording as a picture: the outputs over time, rests in colour (hatched: at no position), with the number of the
position of each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.importing.match import NONE, NOWHERE, OFF, REPEATED
from tumble.importing.pipeline import Imported
from tumble.pictures.canvas import BLACK, blank, picture, thinned

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_POINTS = 20000
_WIDTH_MM, _HEIGHT_MM = 305.0, 152.0  # for a screen
_PLACED: dict[str, Any] = {"facecolor": "#8FD0B8"}
_NOT_PLACED: dict[str, Any] = {"facecolor": "#FFF1D6", "edgecolor": "#B07000", "hatch": "///"}  # told apart in grey too


@picture
def recording(done: Imported) -> Figure:
    """Every rest that has a position, and those that should have one."""
    figure = blank("recording", _HEIGHT_MM, "A recording and its rests", width_mm=_WIDTH_MM, room_above=0.015)
    panels = figure.subplots(3, 1, sharex=True)
    rows = np.arange(len(done.outputs)) if done.seconds is None else done.seconds
    kept = thinned(done.outputs, _MOST_POINTS)
    unit = f" [{done.unit}]" if done.unit_told else ""
    spans = list(zip(rows[done.rests.begin], rows[done.rests.end - 1]))
    positions, states = done.matched.positions, done.matched.states
    for axes, channel, name in zip(panels, done.outputs.T, ("ux", "uy", "uz")):
        axes.plot(rows[kept], channel[kept], linewidth=0.6, color=BLACK)
        axes.set_ylabel(name + unit)
        for span, position, state in zip(spans, positions, states):
            if position != NONE or state in (NOWHERE, OFF, REPEATED):
                axes.axvspan(*span, linewidth=0, **(_NOT_PLACED if position == NONE else _PLACED))
    for number, (span, position) in enumerate(zip(spans, positions), 1):
        label = f"({number})" if position == NONE else done.schedule.positions[position].label
        place: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "ha": "center", "rotation": 60}
        panels[0].annotate(label, (sum(span) / 2.0, 1.02), **place)
    panels[-1].set_xlabel("row" if done.seconds is None else "time [s]")
    return figure
