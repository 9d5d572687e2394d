"""The sheet of a drawing: matplotlib's axes over a whole figure, in millimetres; and what stands on it.

What a shape means is its label (`get_label()`), which is not drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.arrays import Floats
from tumble.pictures.canvas import BLACK, MM_PER_INCH, WIDTH_MM, blank

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MARGIN, LINE = 4.0, 4.2  # mm: from the edge; from one line of text to the next
LARGE_PT, HEADING_PT = 10.0, 12.0
SOFT, FRAME, RED = "#55606c", "#0b5394", "#a8320a"  # words besides, the table's frame, gravity and faults
PLATE, PLATE_SIDE = "#eef1f4", "#d3d9e0"
POINTS = 72.0 / MM_PER_INCH  # of a millimetre

_TALLEST = 2000.0


def sheet(key: str, title: str, about: str, heading: str = "") -> Axes:
    """A white page with its heading, in mm from its upper left corner, y down. `cut` it when its height is known."""
    figure = blank(key, _TALLEST, title, about)
    figure.set_layout_engine("none")
    page = _axes_over(figure, (0.0, WIDTH_MM), (_TALLEST, 0.0))
    page.text(MARGIN, 7.0, heading or title, fontsize=HEADING_PT, fontweight="bold")
    return page


def view(page: Axes, origin: tuple[float, float], scale: float) -> Axes:
    """Axes over the whole page with their origin at a place of it, y up, whose unit is so many mm."""
    x, y = origin
    ends = ((0.0 - x) / scale, (WIDTH_MM - x) / scale), ((y - _TALLEST) / scale, y / scale)
    return _axes_over(page.figure, *ends)


def _axes_over(figure: Any, x: tuple[float, float], y: tuple[float, float]) -> Axes:
    axes: Axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=x, ylim=y)
    axes.set_axis_off()
    return axes


def cut(page: Any, height: float) -> Figure:
    """The figure, so high; of all that is drawn on some axes, the later lies over the earlier."""
    figure: Figure = page.figure
    for axes in figure.axes:
        bottom, top = axes.get_ylim()
        axes.set_ylim(top + (bottom - top) * height / _TALLEST, top)
        for artist in (*axes.patches, *axes.lines, *axes.texts):
            artist.set_zorder(1)
    figure.set_figheight(height / MM_PER_INCH)
    return figure


def paragraph(page: Axes, x: float, y: float, text: str, width: float, **look: Any) -> float:
    """Lines no wider than that, the first on the base line y. Returns that of the line behind them."""
    for line in wrapped(text, width):
        page.text(x, y, line, **look)
        y += LINE
    return y


def wrapped(text: str, width: float) -> list[str]:
    """The text in lines no wider than so many mm, where its words allow it."""
    lines: list[str] = []
    for word in text.split():
        if lines and width_of(f"{lines[-1]} {word}") <= width:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines


def width_of(text: str) -> float:
    """Of a line in FONT_PT, mm."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    points: float = text_to_path.get_text_width_height_descent(text, FontProperties(), ismath=False)[0]
    return points / POINTS


def arrow(axes: Any, points: Sequence[Any] | Floats, colour: str = BLACK, width: float = 1.5, **look: Any) -> None:
    """From point to point; its tip is the last one. `look`: of matplotlib's lines."""
    *way, tip = map(np.asarray, points)
    neck = 0.4 * way[-1] + 0.6 * tip  # from here on it is solid, its head above all
    axes.plot(*np.transpose([*way, neck]), color=colour, linewidth=width, **look)
    head = {
        "arrowstyle": "-|>,head_length=0.66,head_width=0.23",
        "mutation_scale": 10.0,
        "shrinkA": 0.0,
        "shrinkB": 0.0,
    }
    pen = {"color": colour, "linewidth": width, "joinstyle": "miter"}
    axes.annotate("", tip, neck, label=look.get("label"), annotation_clip=False, arrowprops={**head, **pen})


def box(page: Axes, x: float, y: float, width: float, height: float, **look: Any) -> None:
    """A rectangle by its upper left corner, its corners rounded."""
    from matplotlib.patches import FancyBboxPatch

    pen = {"facecolor": "white", "edgecolor": BLACK, "linewidth": 0.85, "boxstyle": "round,pad=0,rounding_size=1"}
    page.add_patch(FancyBboxPatch((x, y), width, height, **{**pen, **look}))
