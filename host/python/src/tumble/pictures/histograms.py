"""A Monte Carlo campaign as a picture: how the errors, over their stated uncertainties, are distributed."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tumble.estimators import COEFFICIENTS
from tumble.pictures.canvas import BLACK, SKY, VERMILLION, blank, picture
from tumble.planning.validate import HISTOGRAM, Validated

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ROW_MM, _FRAME_MM = 19.0, 14.0
_LEAST = 0.45  # of the axis of densities; the normal one reaches 0.4


@picture
def histograms(found: list[Validated], title: str) -> Figure:
    """One column for each estimator, one row for each coefficient: bars of what was counted, a line where the standard
    normal distribution would be."""
    low, high, bins = HISTOGRAM
    edges, scores = np.linspace(low, high, bins + 1), np.linspace(low, high, 81)
    normal = np.exp(-(scores**2) / 2.0) / np.sqrt(2.0 * np.pi)
    figure = blank("histograms", _FRAME_MM + _ROW_MM * len(COEFFICIENTS), title)
    figure.suptitle(title, x=0.01, ha="left")
    panels = figure.subplots(len(COEFFICIENTS), len(found), squeeze=False)
    for column, one in zip(panels.T, found):
        column[0].set_title(one.estimator, fontweight="bold")
        for axes, name, counts in zip(column, COEFFICIENTS, one.tally.histograms):
            density = counts / (one.tally.runs * (high - low) / bins)
            axes.stairs(density, edges, fill=True, color=SKY, label=name)
            axes.plot(scores, normal, color=VERMILLION)
            axes.axhline(0.0, color=BLACK, linewidth=0.6)
            axes.set(xlim=(low, high), ylim=(0.0, max(_LEAST, 1.05 * density.max())), yticks=[], xticks=range(-4, 5, 2))
            axes.spines["left"].set_visible(False)
    for axes, name in zip(panels[:, 0], COEFFICIENTS):
        axes.set_ylabel(name, rotation=0, ha="right", va="center")
    return figure
