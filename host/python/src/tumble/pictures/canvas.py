"""What all pictures share: matplotlib, where it is there; sizes and colours; files and SVG to stand in a page; and the
sheet of a drawing, matplotlib's axes over a whole figure, in millimetres. What a shape on it means is its label
(`get_label()`), which is not drawn.

matplotlib is loaded by these functions alone, never by importing this module, and its settings are changed only while a
picture is made or written: whoever draws with it beside finds it as it was.
"""

from __future__ import annotations

import functools
import hashlib
import io
import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from html import escape
from typing import TYPE_CHECKING, Any, ParamSpec

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import UsageError, listed, needing, quoted
from tumble.units import volts_per

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

P = ParamSpec("P")

FORMATS = (".png", ".svg", ".pdf")
WIDTH_MM = 170.0  # of the text of a page of A4
FONT_PT = 8.0
MM_PER_INCH = 25.4
_PNG_DPI = 150

# Okabe and Ito: told apart by all eyes. None tells a thing by its colour alone: markers, lines and hatches differ too.
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILLION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY, PALE = "#7F7F7F", "#E6E6E6"
MINUS = "\u2212"  # a minus sign
MICRO = 1e6  # of a g, of a radian
_PREFIXES = ((1.0, ""), (1e3, "m"), (1e6, "µ"))

_SETTINGS: dict[str, Any] = {
    "font.family": ["sans-serif"],
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Helvetica", "Arial"],  # the first comes with matplotlib
    "font.size": FONT_PT,
    **dict.fromkeys(("axes.labelsize", "xtick.labelsize", "ytick.labelsize", "legend.fontsize"), FONT_PT),
    "axes.titlesize": FONT_PT + 1.0,
    "axes.titlelocation": "left",
    "axes.linewidth": 0.6,
    "axes.formatter.useoffset": False,
    "axes.formatter.use_locale": False,
    "axes.formatter.limits": (-9, 9),
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.linewidth": 0.4,
    "grid.color": "#D0D0D0",
    "hatch.linewidth": 0.5,
    "lines.linewidth": 0.9,
    "lines.markersize": 4.5,
    "legend.frameon": False,
    "svg.hashsalt": "tumble",
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}


def require(needed_for: str) -> None:
    """Raises NotInstalled where matplotlib is not there; says what it is `needed_for`."""
    with needing(needed_for, "matplotlib", extra="plot"):
        import matplotlib  # noqa: F401


def require_format(file: str, option: str) -> None:
    """Raises UsageError for a file that is not of FORMATS, NotInstalled where matplotlib is not there. `option`: what
    the user calls it."""
    if not file.lower().endswith(FORMATS):
        raise UsageError(f"{option}: {quoted(file)} does not end in {listed(FORMATS, 'or')}")
    require(option)


@contextmanager
def settings() -> Iterator[None]:
    """matplotlib as pictures have it, whatever the user has set; afterwards as it was."""
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_SETTINGS)
        yield


def picture(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Have a function draw with the settings of all pictures, and everything where it is to stay: to lay a figure out
    once more moves it by a little. Raises NotInstalled where matplotlib is not there."""

    @functools.wraps(draw)
    def drawn(*arguments: P.args, **options: P.kwargs) -> Figure:
        require("a picture")
        with settings():
            figure = draw(*arguments, **options)
            if figure.get_constrained_layout():
                figure.draw_without_rendering()
            figure.set_layout_engine("none")
        return figure

    return drawn


def blank(
    key: str, height_mm: float, title: str, about: str = "", *, width_mm: float = WIDTH_MM, room_above: float = 0.0
) -> Figure:
    """A figure. `key`: its name among the pictures. `title`, and what it is `about`: in words, for whoever cannot see
    it. `room_above`: share of the height that is left free."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_mm / MM_PER_INCH, height_mm / MM_PER_INCH), layout="constrained")
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0.0, 0.0, 1.0, 1.0 - room_above))
    figure.set_label(key)
    vars(figure).update(words=(title, about))
    return figure


def legend_above(axes: Axes, columns: int) -> None:
    """Beside the title, at the upper right, over the axes."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=columns, borderaxespad=0.2, handlelength=1.8)


def written(figure: Figure, file: str) -> bytes:
    """The picture in the format that the file's name says, the same bytes every time on one machine."""
    kind = os.path.splitext(file)[1][1:].lower()
    no_dates = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    target = io.BytesIO()
    with settings():
        figure.savefig(target, format=kind, dpi=_PNG_DPI, metadata=no_dates)
    return target.getvalue()


def svg(figure: Figure) -> str:
    """A picture as an <svg> element, a file of its own or to stand in a page of HTML: without prolog, with its title
    and what it is about. Whatever has a name in it, its style too, is the picture's own: others of the same page have
    other names. The same text every time on one machine."""
    text = written(figure, "picture.svg").decode("utf-8")
    title, about = map(escape, getattr(figure, "words", ("Figure", "")))
    words = f"\n <title>{title}</title>" + (f"\n <desc>{about}</desc>" if about else "")
    text = re.sub(r"\s*<metadata>.*?</metadata>", lambda _: words, text[text.index("<svg") :], count=1, flags=re.DOTALL)
    own = f"{figure.get_label()}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
    text = re.sub(r'\bid="([^"]*)"', rf'id="{own}-\1"', text)
    text = re.sub(r'href="#([^"]*)"', rf'href="#{own}-\1"', text)
    text = re.sub(r"url\(#([^)]*)\)", rf"url(#{own}-\1)", text)
    text = re.sub(r"(<style[^>]*>)\s*\*\s*\{", rf"\1#{own} *{{", text)
    return text.replace("<svg ", f'<svg id="{own}" role="img" ', 1)


def thinned(values: Floats, most: int) -> Integers:
    """Indices of rows to draw of `values` (rows, channels): of about so many stretches the first row, and the lowest
    and the highest of every channel, so that no peak is lost. All rows where they are not more."""
    if len(values) <= most:
        return np.arange(len(values))
    bounds = np.linspace(0, len(values), most // (2 * values.shape[1] + 1) + 1).astype(int)
    kept: list[Integers] = [bounds[:-1], np.array([len(values) - 1])]
    for begin, end in zip(bounds[:-1].tolist(), bounds[1:].tolist()):
        piece = values[begin:end]
        kept += [begin + piece.argmin(axis=0), begin + piece.argmax(axis=0)]
    return np.unique(np.concatenate(kept))


def three_figures(value: float) -> str:
    """Of a size, never with an exponent for a large one."""
    return f"{value:.0f}" if value >= 99.95 else f"{value:#.3g}"


def small(unit: str, values: Floats) -> tuple[float, str]:
    """Factor and unit that make numbers of the largest of `values`, in the `unit` of the outputs: multiples of the volt
    have smaller ones, others stay as they are."""
    largest = float(np.abs(values).max(initial=0.0))
    if volts_per(unit) == 1.0 and unit != "V":
        return 1.0, unit
    volts = volts_per(unit)
    factor, prefix = next((one for one in _PREFIXES if largest * volts * one[0] >= 1.0), _PREFIXES[-1])
    return volts * factor, f"{prefix}V"


MARGIN, LINE = 4.0, 4.2  # mm: from the edge; from one line of text to the next
LARGE_PT, HEADING_PT = 10.0, 12.0
SOFT, FRAME, RED = "#55606c", "#0b5394", "#a8320a"  # words besides, the table's frame, gravity and faults
PLATE, PLATE_SIDE = "#eef1f4", "#d3d9e0"
POINTS = 72.0 / MM_PER_INCH  # of a millimetre

TALLEST = 2000.0


def sheet(key: str, title: str, about: str, heading: str = "") -> Axes:
    """A white page with its heading, in mm from its upper left corner, y down. `cut` it when its height is known."""
    figure = blank(key, TALLEST, title, about)
    figure.set_layout_engine("none")
    page = axes_over(figure, (0.0, WIDTH_MM), (TALLEST, 0.0))
    page.text(MARGIN, 7.0, heading or title, fontsize=HEADING_PT, fontweight="bold")
    return page


def axes_over(figure: Any, x: tuple[float, float], y: tuple[float, float]) -> Axes:
    """Axes over all of it, with these ends."""
    axes: Axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=x, ylim=y)
    axes.set_axis_off()
    return axes


def cut(page: Any, height: float) -> Figure:
    """The figure, so high; of all that is drawn on some axes, the later lies over the earlier."""
    figure: Figure = page.figure
    for axes in figure.axes:
        bottom, top = axes.get_ylim()
        axes.set_ylim(top + (bottom - top) * height / TALLEST, top)
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
