"""A Monte Carlo campaign as a picture (SVG): how the errors, over their stated uncertainties, are distributed."""

from __future__ import annotations

import math
from html import escape

import numpy as np

from tumble.arrays import Integers
from tumble.estimators import COEFFICIENTS
from tumble.planning.validate import HISTOGRAM, Validated

_CELL = (150, 84)
_PLOT = (134, 58)
_MARGIN = (54, 48)


def render(found: list[Validated], title: str) -> str:
    """One column for each estimator, one row for each coefficient: bars of what was counted, a line where the standard
    normal distribution would be."""
    width = _MARGIN[0] + _CELL[0] * len(found) + 8
    height = _MARGIN[1] + _CELL[1] * len(COEFFICIENTS) + 8
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}"'
        ' font-family="sans-serif" font-size="11">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
        f'<text x="8" y="18" font-size="13">{escape(title, quote=False)}</text>',
    ]
    for column, one in enumerate(found):
        left = _MARGIN[0] + _CELL[0] * column
        parts.append(f'<text x="{left}" y="{_MARGIN[1] - 8}" font-weight="bold">{one.estimator}</text>')
        for row, counts in enumerate(one.tally.histograms):
            parts.append(_cell(left, _MARGIN[1] + _CELL[1] * row, counts, one.tally.runs))
    for row, name in enumerate(COEFFICIENTS):
        parts.append(f'<text x="8" y="{_MARGIN[1] + _CELL[1] * row + 32}">{name}</text>')
    return "\n".join([*parts, "</svg>"]) + "\n"


def _cell(left: float, top: float, counts: Integers, runs: int) -> str:
    low, high, bins = HISTOGRAM
    step = (high - low) / bins
    density = counts / (runs * step)
    highest = max(0.45, float(density.max()) * 1.05)
    wide, tall = _PLOT

    def at(score: float, value: float) -> str:
        return f"{left + wide * (score - low) / (high - low):.1f},{top + tall * (1 - value / highest):.1f}"

    outline = [at(low, 0.0)]
    for index, value in enumerate(density):
        outline += [at(low + index * step, value), at(low + (index + 1) * step, value)]
    outline.append(at(high, 0.0))
    normal = [at(score, math.exp(-(score**2) / 2) / math.sqrt(2 * math.pi)) for score in np.linspace(low, high, 81)]
    ticks = "".join(
        f'<text x="{left + wide * (score - low) / (high - low):.1f}" y="{top + tall + 12}" text-anchor="middle"'
        f' font-size="9">{score}</text>'
        for score in (-4, -2, 0, 2, 4)
    )
    return (
        f'<polygon points="{" ".join(outline)}" fill="#9ec5e8"/>'
        f'<polyline points="{" ".join(normal)}" fill="none" stroke="#b03030"/>'
        f'<line x1="{left}" y1="{top + tall}" x2="{left + wide}" y2="{top + tall}" stroke="black"/>{ticks}'
    )
