"""The budget: what every source of error of the stand has in the variance of every coefficient."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.estimators import COEFFICIENTS
from tumble.pictures.canvas import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILLION,
    YELLOW,
    blank,
)
from tumble.pictures.facts import Facts, small, three_figures
from tumble.units import per_g

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SOURCES = {  # of solving.expected: name for people, colour, hatch of lines (dots make large files)
    "alpha1": ("axis tilt α₁", SKY, ""),
    "alpha2": ("level α₂", YELLOW, "----"),
    "alpha3": ("yaw α₃", BLUE, "////"),
    "alpha4": ("set angles α₄", ORANGE, "\\\\\\\\"),
    "noise": ("noise", "#FFFFFF", ""),
    "seat": ("seat", GREEN, "xxxx"),
    "platform": ("platform", PURPLE, "++++"),
    "encoder": ("encoder", VERMILLION, "||||"),
    "drift": ("drift", GREY, "/"),
}
_PERCENT = 100.0


def budget(facts: Facts) -> Figure:
    """Shares of the variance u^2 of every coefficient, percent: the squares of what each source of the declared stand
    brings (solving.expected), over their sum, which is the diagonal of the result's covariance. On the right u."""
    assert facts.expected is not None  # as the caller has seen to
    variances = {name: u**2 for name, u in facts.expected.coefficients.items()}
    total = np.array(sum(variances.values()))
    figure = blank("budget", 105.0)
    axes = figure.subplots()
    places, left = np.arange(len(COEFFICIENTS)), np.zeros(len(COEFFICIENTS))
    for name, variance in variances.items():
        if not variance.any():  # a source of size 0
            continue
        title, colour, hatch = SOURCES[name]
        share = _PERCENT * np.divide(variance, total, out=np.zeros(len(total)), where=total > 0.0)
        look: dict[str, Any] = {"color": colour, "hatch": hatch, "edgecolor": BLACK, "linewidth": 0.5}
        axes.barh(places, share, 0.72, left, label=title, **look)
        left = left + share
    u = np.sqrt(total)
    for place, text in enumerate(_sizes(u, facts.unit)):
        axes.annotate(text, (1.01, place), xycoords=("axes fraction", "data"), va="center")
    axes.annotate("u", (1.01, -0.9), xycoords=("axes fraction", "data"), va="center", style="italic")
    axes.set_yticks(places, COEFFICIENTS)
    axes.set_ylim(len(places) - 0.4, -0.6)
    axes.set_xlim(0.0, _PERCENT)
    axes.set_xlabel("share of the variance / %")
    figure.legend(loc="outside upper left", ncol=5, handlelength=2.4, handleheight=1.2)
    return figure


def _sizes(u: np.ndarray, unit: str) -> list[str]:
    """Of K, then of U0, in one multiple of the unit."""
    factor, shown = small(unit, u)
    return [f"{three_figures(factor * one)} {per_g(shown) if place < 9 else shown}" for place, one in enumerate(u)]
