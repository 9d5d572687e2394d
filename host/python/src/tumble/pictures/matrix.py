"""How the errors of the coefficients go together."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.arrays import Floats
from tumble.estimators import COEFFICIENTS
from tumble.pictures.canvas import FONT_PT, MINUS, blank
from tumble.pictures.facts import Facts

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = 41  # so few that matplotlib draws their key with lines, and not with dots
_TO_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # WCAG 2.2
_EVEN = 0.179  # luminance on which black and white stand out alike


def correlation(facts: Facts) -> Figure:
    """C_ij / (u_i u_j) of the result's covariance C (12, 12), in figures and in colour."""
    import matplotlib

    found = correlations(np.array(facts.document["covariance"]))
    figure = blank("correlation", 144.0)
    axes = figure.subplots()
    steps = matplotlib.colormaps["RdBu"].resampled(_COLOURS)
    mesh = axes.pcolormesh(found, cmap=steps, vmin=-1.0, vmax=1.0, edgecolors="white", linewidth=0.5)
    inks = np.where(_luminance(steps((found + 1.0) / 2.0)) < _EVEN, "white", "black")
    for (i, j), value in np.ndenumerate(found):
        style: dict[str, Any] = {"color": str(inks[i, j]), "fontsize": FONT_PT}
        axes.text(j + 0.5, i + 0.5, figure_of(value), ha="center", va="center", **style)
    places = np.arange(len(found)) + 0.5
    axes.set_xticks(places, COEFFICIENTS)
    axes.set_yticks(places, COEFFICIENTS)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.invert_yaxis()
    axes.set_aspect("equal")
    for spine in axes.spines.values():
        spine.set_visible(False)
    bar = figure.colorbar(mesh, ax=axes, shrink=0.8, aspect=30)
    bar.set_label("correlation")
    return figure


def _luminance(colours: Floats) -> Floats:
    """Of colours (..., 4) from 0 to 1."""
    shown = colours[..., :3]
    linear = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    found: Floats = linear @ _TO_LUMINANCE
    return found


def correlations(covariance: Floats) -> Floats:
    """Of a covariance; NaN for what has no uncertainty."""
    u = np.sqrt(np.diag(covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        found: Floats = covariance / np.outer(u, u)
    return found


def figure_of(value: float) -> str:
    """With its sign, for the colour may not be seen."""
    if np.isnan(value):
        return "?"
    rounded = f"{value:+.2f}"
    return {"+1.00": "1", "-0.00": "0", "+0.00": "0"}.get(rounded, rounded).replace("-", MINUS)
