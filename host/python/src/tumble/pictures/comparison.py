"""Two calibrations of one block: every difference in units of its standard uncertainty."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

from tumble.messages import signed
from tumble.pictures.canvas import BLACK, BLUE, MINUS, PALE, VERMILLION, blank, legend_above, picture
from tumble.units import rounded

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tumble.documents.comparison import Comparison, OfCoefficient, OfParameter, OfSeat

    Row = OfParameter | OfSeat | OfCoefficient

_ROW_MM, _FRAME_MM = 4.8, 28.0
_BANDS = ((3.0, PALE, "\u00b13 u"), (2.0, "#C8C8C8", "\u00b12 u"))  # the inner one over the outer one
_SAME, _CHANGED = BLUE, VERMILLION  # the markers differ too
_LEAST, _MOST = 5.0, 10.0  # of the axis, in u; what is beyond stands at its edge, as an arrow with its size
_GROUPS = (("parameters", "the block"), ("seat", "its seat"), ("coefficients", "coefficients"))
_TITLES = {
    "unchanged": "Unchanged",
    "seat": "Only the seat has changed",
    "block": "The block has changed",
}


@picture
def comparison(document: Comparison) -> Figure:
    """A picture of a document of schema tumble.comparison/1: B less A in units of the standard uncertainty of the
    difference, with bands of 2 and 3. Parameters that have changed are diamonds; a difference that is beyond the axis
    is an arrow at its edge. What has no uncertainty has no marker."""
    rows = [(group, row) for group, _ in _GROUPS for row in getattr(document, group)]
    figure = blank("comparison", _FRAME_MM + _ROW_MM * (len(rows) + 2), "Two calibrations of one block")
    axes = figure.subplots()
    largest = max((abs(row.in_u) for _, row in rows if row.in_u is not None), default=0.0)
    reach = min(_MOST, max(_LEAST, 1.1 * largest))  # half of the axis, in u
    for half, colour, label in _BANDS:
        axes.axvspan(-half, half, color=colour, linewidth=0, label=label, zorder=0)
    axes.axvline(0.0, color=BLACK, linewidth=0.6)
    heights = [0.0]  # of the rows, from the top down, with room between the groups
    for (one, _), (other, _) in pairwise(rows):
        heights.append(heights[-1] - (1.0 if one == other else 2.0))
    for height, (_, row) in zip(heights, rows):
        _mark(axes, height, row, reach)
    _label(axes, heights, rows, reach)
    if document.verdict in _TITLES:
        axes.set_title(f"{_TITLES[document.verdict]} ({100 * document.confidence:.6g} %)")
    else:
        why = "no uncertainties" if document.tests is None else "a result failed its check"
        axes.set_title(f"Nobody can tell: {why}")
    legend_above(axes, len(_BANDS))
    return figure


def _mark(axes: Any, height: float, row: Row, reach: float) -> None:
    size, has_changed = row.in_u, getattr(row, "changed", False)
    colour = _CHANGED if has_changed else _SAME
    if size is not None and abs(size) > reach:
        edge, arrow, side = (reach, ">", "right") if size > 0 else (-reach, "<", "left")
        axes.plot([edge], [height], arrow, color=colour, markersize=6, clip_on=False, gid=row.name)
        axes.text(0.94 * edge, height, f"{size:+.3g} u".replace("-", MINUS), ha=side, va="center")
    elif size is not None:
        axes.plot([size - 1.0, size + 1.0], [height, height], color=colour)
        axes.plot([size], [height], "D" if has_changed else "o", color=colour, gid=row.name)


def _label(axes: Any, heights: list[float], rows: list[tuple[str, Row]], reach: float) -> None:
    """Names to the left, sizes with their uncertainties to the right, and the groups' names above."""
    axes.set_xlim(-reach, reach)
    axes.set_ylim(min(heights) - 0.7, 1.6)
    axes.set_yticks(heights, [row.name for _, row in rows])
    sizes = axes.secondary_yaxis("right")
    sizes.set_yticks(heights, [_sized(row) for _, row in rows])
    sizes.tick_params(length=0)
    firsts = {group: height for height, (group, _) in reversed(list(zip(heights, rows)))}
    for group, title in _GROUPS:
        if group in firsts:
            axes.text(-0.97 * reach, firsts[group] + 0.85, title, style="italic", va="center")
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel("B less A, in units of the standard uncertainty u of the difference")
    axes.spines["left"].set_visible(False)
    sizes.spines["right"].set_visible(False)


def _sized(row: Row) -> str:
    size, u = rounded(row.difference, row.u)
    shown = [size, *([] if row.u is None else ["\u00b1", u])]
    return " ".join([*(one.replace("-", MINUS) for one in shown), signed(row.unit)])
