"""Pictures with a place for every measured position: the gravity check, and the residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.arrays import Floats
from tumble.pictures.canvas import BLACK, BLUE, FONT_PT, GREY, MOST_UPRIGHT, PALE, VERMILLION, blank, legend_above
from tumble.pictures.facts import MICRO, Facts, small
from tumble.solving.expected import residuals as residuals_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BAND = 2.0  # standard deviations: 95 % of what is normal
_MARGIN = 1.12


def gravity_check(facts: Facts) -> Figure:
    """delta_g at every position, ug: `verification.delta_g_g` of the result, with its limit; where the stand is told,
    with +-2 standard deviations of it that the declared errors leave (solving.expected)."""
    check = facts.document["verification"]
    delta_g = MICRO * np.array([one["delta_g_g"] for one in check["delta_g_g"]])
    limit = MICRO * check["limit_g"]
    figure = blank("gravity_check", 75.0)
    axes = figure.subplots()
    if facts.expected is not None:
        _band(axes, MICRO * facts.expected.delta_g, "±2 u, declared stand")
    for bound in (limit, -limit):
        label = f"limit ±{limit:.9g} µg" if bound > 0 else None
        axes.axhline(bound, color=BLACK, linestyle="--", label=label)
    _dots(axes, delta_g, facts)
    largest = max(limit, float(np.abs(delta_g).max()))
    axes.set_ylim(-_MARGIN * largest, _MARGIN * largest)
    axes.set_ylabel("Δg / µg")
    axes.set_title(f"Gravity check {'passed' if check['pass'] else 'FAILED'}")
    _positions(axes, facts)
    legend_above(axes, 4)
    return figure


def residuals(facts: Facts) -> Figure:
    """U - U0 - K a of every channel on the ideal schedule (solving.expected.residuals), which must be known. The band
    is +-2 standard deviations of a residual by all errors that the stand declares; where it is not told, +-2 standard
    errors of a mean by the noise of the samples alone (`noise.of_means` of the result)."""
    assert facts.schedule is not None  # as the caller has seen to
    left = residuals_of(facts.document, facts.schedule)
    sigma, label = _expected(facts)
    factor, unit = small(facts.unit, left)
    figure = blank("residuals", 120.0)
    panels = figure.subplots(3, 1, sharex=True)
    for i, axes in enumerate(panels):
        if sigma is not None:
            _band(axes, factor * sigma[:, i], label)
        axes.axhline(0.0, color=BLACK, linewidth=0.5)
        _dots(axes, factor * left[:, i], facts)
        axes.margins(y=0.1)
        axes.set_ylabel(f"{'xyz'[i]} channel / {unit}")
    panels[0].set_title("Residuals")
    legend_above(panels[0], 3)
    _positions(panels[-1], facts)
    for axes in panels[:-1]:
        _mountings(axes, facts)
    return figure


def _expected(facts: Facts) -> tuple[Floats | None, str]:
    """Standard deviations of the residuals (positions, 3), and of what; None where nothing is known."""
    if facts.expected is not None:
        return facts.expected.residuals, "±2 u, declared stand"
    of_means = facts.document["noise"]["of_means"]
    if of_means is None:
        return None, ""
    samples = np.array([one["samples"] for one in facts.document["means"]])
    return np.array(of_means) / np.sqrt(samples)[:, None], "±2 u, noise of the samples alone"


def _band(axes: Axes, sigma: Floats, label: str) -> None:
    """As wide as a position, from one to the next."""
    edges = np.arange(len(sigma) + 1) - 0.5
    heights = BAND * sigma
    look: dict[str, Any] = {"facecolor": PALE, "edgecolor": GREY, "linewidth": 0.4}
    axes.use_sticky_edges = False  # a margin around the band
    axes.stairs(heights, edges, baseline=-heights, fill=True, label=label, **look)


def _dots(axes: Axes, values: Floats, facts: Facts) -> None:
    """Full circles for what was fitted, open diamonds for what was only checked."""
    is_check, places = np.array(facts.is_check), np.arange(len(values))
    axes.vlines(places, 0.0, values, color=GREY, linewidth=0.6)
    axes.plot(places[~is_check], values[~is_check], "o", color=BLUE, label="fit")
    if is_check.any():
        style: dict[str, Any] = {"markerfacecolor": "white", "markeredgecolor": VERMILLION, "markeredgewidth": 1.2}
        axes.plot(places[is_check], values[is_check], "D", label="check", **style)


def _positions(axes: Axes, facts: Facts) -> None:
    """The axis of the positions, by their labels."""
    labels = facts.labels
    rotation = 90 if len(labels) > MOST_UPRIGHT else 0
    axes.set_xticks(range(len(labels)), labels, rotation=rotation, fontsize=FONT_PT)
    axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.set_xlabel("mounting.position")
    _mountings(axes, facts)


def _mountings(axes: Axes, facts: Facts) -> None:
    """A line wherever the block was mounted anew."""
    for index in facts.remounted:
        axes.axvline(index - 0.5, color=GREY, linewidth=0.6, linestyle=":")
