"""A recording as a picture: the outputs over time, rests in colour (hatched: at no position), with the number of the
position of each."""

from __future__ import annotations

from typing import Any

import numpy as np

from tumble.importing.match import NOWHERE, OFF, REPEATED
from tumble.importing.order import NONE
from tumble.importing.pipeline import Imported
from tumble.pictures.canvas import thinned, written

_MOST_POINTS = 20000
_PLACED: dict[str, Any] = {"facecolor": "#8FD0B8"}
_NOT_PLACED: dict[str, Any] = {"facecolor": "#FFF1D6", "edgecolor": "#B07000", "hatch": "///"}  # told apart in grey too


def picture(done: Imported, file: str) -> bytes:
    """The picture, in the format that the file's name says, which canvas.require_format has looked at."""
    from matplotlib.figure import Figure

    figure: Any = Figure(figsize=(12, 6), layout="constrained")
    figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 0.985))  # room above the names
    axes = figure.subplots(3, 1, sharex=True)
    rows = np.arange(len(done.outputs)) if done.seconds is None else done.seconds
    kept = thinned(done.outputs, _MOST_POINTS)
    unit = f" [{done.unit}]" if done.unit_told else ""
    for axis, channel, name in zip(axes, done.outputs.T, ("ux", "uy", "uz")):
        axis.plot(rows[kept], channel[kept], linewidth=0.6, color="black")
        axis.set_ylabel(name + unit)
        for rest, position, state in zip(done.rests, done.matched.positions, done.matched.states):
            if position == NONE and state not in (NOWHERE, OFF, REPEATED):
                continue
            look = _NOT_PLACED if position == NONE else _PLACED
            axis.axvspan(rows[rest.begin], rows[rest.end - 1], linewidth=0, **look)
    for number, (rest, position) in enumerate(zip(done.rests, done.matched.positions), 1):
        label = f"({number})" if position == NONE else done.schedule.positions[position].label
        middle = (rows[rest.begin] + rows[rest.end - 1]) / 2
        axes[0].annotate(
            label, (middle, 1.02), xycoords=("data", "axes fraction"), ha="center", fontsize=8, rotation=60
        )
    axes[-1].set_xlabel("row" if done.seconds is None else "time [s]")
    return written(figure, file)
