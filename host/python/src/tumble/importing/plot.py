"""A recording as a picture: the outputs over time, rests in colour, with the number of the position of each.

Needs matplotlib, which is loaded here alone.
"""

from __future__ import annotations

import io
import os
from typing import Any

import numpy as np

from tumble.errors import Skipped, UsageError, quoted
from tumble.importing.match import NOWHERE, OFF, REPEATED
from tumble.importing.order import NONE
from tumble.importing.pipeline import Imported

FORMATS = (".png", ".svg", ".pdf")
_MOST_POINTS = 20000
_PLACED, _NOT_PLACED = "tab:green", "tab:orange"


def require_format(file: str) -> None:
    """Raises UsageError for a file that is not of FORMATS, Skipped where matplotlib is not there."""
    if os.path.splitext(file)[1].lower() not in FORMATS:
        raise UsageError(f"--plot: {quoted(file)} does not end in {', '.join(FORMATS[:-1])} or {FORMATS[-1]}")
    try:
        import matplotlib  # type: ignore[import-not-found, unused-ignore] # noqa: F401
    except ImportError:
        raise Skipped("--plot needs matplotlib: pip install 'tumble[plot]'") from None


def picture(done: Imported, file: str) -> bytes:
    """The picture, in the format that the file's name says."""
    from matplotlib.figure import Figure  # type: ignore[import-not-found, unused-ignore]

    figure: Any = Figure(figsize=(12, 6), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True)
    rows = np.arange(len(done.outputs)) if done.seconds is None else done.seconds
    thinned = slice(None, None, max(1, len(rows) // _MOST_POINTS))
    unit = f" [{done.unit}]" if done.unit_told else ""
    for axis, channel, name in zip(axes, done.outputs.T, ("ux", "uy", "uz")):
        axis.plot(rows[thinned], channel[thinned], linewidth=0.6, color="tab:gray")
        axis.set_ylabel(name + unit)
        for rest, position, state in zip(done.rests, done.matched.positions, done.matched.states):
            if position == NONE and state not in (NOWHERE, OFF, REPEATED):
                continue
            colour = _NOT_PLACED if position == NONE else _PLACED
            axis.axvspan(rows[rest.begin], rows[rest.end - 1], color=colour, alpha=0.35, linewidth=0)
    for number, (rest, position) in enumerate(zip(done.rests, done.matched.positions), 1):
        label = f"({number})" if position == NONE else done.schedule.positions[position].label
        middle = (rows[rest.begin] + rows[rest.end - 1]) / 2
        axes[0].annotate(
            label, (middle, 1.02), xycoords=("data", "axes fraction"), ha="center", fontsize=8, rotation=60
        )
    axes[-1].set_xlabel("row" if done.seconds is None else "time [s]")
    target = io.BytesIO()
    kind = os.path.splitext(file)[1][1:].lower()
    figure.savefig(target, format=kind, dpi=120, metadata={"Date": None} if kind == "svg" else None)
    return target.getvalue()
