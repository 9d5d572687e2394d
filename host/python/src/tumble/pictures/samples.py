"""The samples of a run, channel by channel, with the stretches that are averaged."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.arrays import Integers
from tumble.errors import UsageError
from tumble.pictures.canvas import BLUE, FONT_PT, MOST_UPRIGHT, PALE, blank, thinned
from tumble.pictures.facts import Facts, Recorded

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_POINTS = 2000
_FEW = 100  # rows that are drawn as dots
_MOST_WINDOWS = 72  # that are shaded and named: two visits to each position of the longest schedule
_SAME = 1e-9  # of the largest mean


def samples(facts: Facts) -> Figure:
    """The outputs by the number of their row, from 1; every second stretch of a position is shaded, and all are named
    above. A run with more stretches than a schedule has positions, whose samples alternate, has neither. Of many rows
    the lowest and highest of every stretch are drawn."""
    run = facts.run
    assert run is not None  # as the caller has seen to
    outputs, kept = run.outputs, thinned(run.outputs, _MOST_POINTS)
    figure = blank("samples", 110.0)
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0.0, 0.0, 1.0, 0.98))  # room above the names
    panels = figure.subplots(3, 1, sharex=True)
    windows = _windows(run)
    shown = windows if len(windows) <= _MOST_WINDOWS else []
    style: dict[str, Any] = {"linestyle": "none", "marker": "."} if len(outputs) <= _FEW else {"linewidth": 0.6}
    for i, axes in enumerate(panels):
        for begin, end, _ in shown[::2]:
            axes.axvspan(begin + 0.5, end + 0.5, color=PALE, linewidth=0, label="_averaged")
        axes.plot(kept + 1, outputs[kept, i], color=BLUE, label="_outputs", **style)
        axes.set_ylabel(f"u{'xyz'[i]} / {facts.unit}")
    for begin, end, label in shown:
        place = ((begin + end + 1) / 2, 1.03)
        above: dict[str, Any] = {
            "xycoords": ("data", "axes fraction"),
            "ha": "center",
            "va": "bottom",
            "fontsize": FONT_PT,
        }
        panels[0].annotate(label, place, rotation=90 if len(shown) > MOST_UPRIGHT else 0, **above)
    panels[-1].set_xlim(0.5, len(outputs) + 0.5)
    panels[-1].set_xlabel("number of the sample" if len(outputs) > len(windows) else "number of the mean")
    return figure


def require_same_run(document: dict[str, Any], run: Recorded) -> None:
    """Raise UsageError where the means of a run are not those of the result."""
    means = np.array([one["mean"] for one in document["means"]])
    largest = float(np.abs(means).max())
    for one, mean in zip(document["means"], means):
        here = (run.mounting == one["mounting"]) & (run.position == one["position"])
        if here.sum() != one["samples"] or np.abs(run.outputs[here].mean(axis=0) - mean).max() > _SAME * largest:
            place = f"{one['mounting']}.{one['position']}"
            raise UsageError(f"run: not that of the result, which has another mean at position {place}")


def _windows(run: Recorded) -> list[tuple[int, int, str]]:
    """Index of the first row, of the one behind the last, and name of the position, of every stretch."""
    place: Integers = 256 * run.mounting + run.position
    begins = [0, *(np.flatnonzero(np.diff(place)) + 1).tolist()]
    ends = [*begins[1:], len(place)]
    return [(a, b, f"{run.mounting[a]}.{run.position[a]}") for a, b in zip(begins, ends)]
