"""Where the uncertainty of a result comes from, how it goes together, at which attitude it is largest."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.estimators import COEFFICIENTS
from tumble.pictures import canvas
from tumble.pictures.result import Facts
from tumble.solving.coefficients import Coefficients
from tumble.units import per_g

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SOURCES = {  # of solving.expected: name for people, colour, hatch of lines (dots make large files)
    "alpha1": ("axis tilt α₁", canvas.SKY, ""),
    "alpha2": ("level α₂", canvas.YELLOW, "----"),
    "alpha3": ("yaw α₃", canvas.BLUE, "////"),
    "alpha4": ("set angles α₄", canvas.ORANGE, "\\\\\\\\"),
    "noise": ("noise", "#FFFFFF", ""),
    "seat": ("seat", canvas.GREEN, "xxxx"),
    "platform": ("platform", canvas.PURPLE, "++++"),
    "encoder": ("encoder", canvas.VERMILLION, "||||"),
    "drift": ("drift", canvas.GREY, "/"),
}
_TO_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # WCAG 2.2
_EVEN = 0.179  # luminance on which black and white stand out alike

_AZIMUTH_DEG, _ELEVATION_DEG = np.linspace(-180.0, 180.0, 145), np.linspace(-90.0, 90.0, 73)
_FACES = dict(zip(("+x", "-x", "+y", "-y", "+z", "-z"), ((0, 0), (180, 0), (90, 0), (-90, 0), (0, 90), (0, -90))))
_PLATE = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none"}
_FLAT = 1e-9  # of the largest
_MARGIN_DEG = np.array([15.0, 5.0])  # half a label, at most


@canvas.picture
def budget(facts: Facts) -> Figure:
    """Shares of the variance u^2 of every coefficient, percent: the squares of what each source of the declared stand
    brings (solving.expected), over their sum, which is the diagonal of the result's covariance. On the right u."""
    assert facts.expected is not None  # as the caller has seen to
    variances = {name: u**2 for name, u in facts.expected.coefficients.items()}
    total = np.array(sum(variances.values()))
    figure = canvas.blank("budget", 105.0, "Sources of the uncertainty")
    axes = figure.subplots()
    places, left = np.arange(len(COEFFICIENTS)), np.zeros(len(COEFFICIENTS))
    for name, variance in variances.items():
        if not variance.any():  # a source of size 0
            continue
        title, colour, hatch = SOURCES.get(name, (name, canvas.GREY, ".."))
        share = 100.0 * np.divide(variance, total, out=np.zeros(len(total)), where=total > 0.0)
        look: dict[str, Any] = {"color": colour, "hatch": hatch, "edgecolor": canvas.BLACK, "linewidth": 0.5}
        axes.barh(places, share, 0.72, left, label=title, **look)
        left = left + share
    factor, unit = canvas.small(facts.unit, np.sqrt(total))
    for place, u in enumerate(factor * np.sqrt(total)):
        text = f"{canvas.three_figures(u)} {per_g(unit) if place < 9 else unit}"  # of K, then of U0
        axes.annotate(text, (1.01, place), xycoords=("axes fraction", "data"), va="center")
    axes.annotate("u", (1.01, -0.9), xycoords=("axes fraction", "data"), va="center", style="italic")
    axes.set_yticks(places, COEFFICIENTS)
    axes.set_ylim(len(places) - 0.4, -0.6)
    axes.set_xlim(0.0, 100.0)
    axes.set_xlabel("share of the variance / %")
    figure.legend(loc="outside upper left", ncol=5, handlelength=2.4, handleheight=1.2)
    return figure


@canvas.picture
def correlation(facts: Facts) -> Figure:
    """C_ij / (u_i u_j) of the result's covariance C (12, 12), in figures and in colour."""
    import matplotlib

    covariance = np.array(facts.result.covariance)
    u = np.sqrt(np.diag(covariance))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = covariance / np.outer(u, u)  # NaN for what has no uncertainty
    figure = canvas.blank("correlation", 144.0, "Correlation of the coefficients")
    axes = figure.subplots()
    steps = matplotlib.colormaps["RdBu"].resampled(41)  # so few that their key is drawn with lines, and not with dots
    mesh = axes.pcolormesh(found, cmap=steps, vmin=-1.0, vmax=1.0, edgecolors="white", linewidth=0.5)
    shades = steps((found + 1.0) / 2.0)[..., :3]
    luminance = np.where(shades <= 0.04045, shades / 12.92, ((shades + 0.055) / 1.055) ** 2.4) @ _TO_LUMINANCE
    for (i, j), value in np.ndenumerate(found):
        ink = "white" if luminance[i, j] < _EVEN else "black"
        sign = "?" if np.isnan(value) else f"{value:+.2f}"  # for the colour may not be seen
        sign = {"+1.00": "1", "-0.00": "0", "+0.00": "0"}.get(sign, sign).replace("-", canvas.MINUS)
        axes.text(j + 0.5, i + 0.5, sign, ha="center", va="center", color=ink)
    places = np.arange(len(found)) + 0.5
    axes.set_xticks(places, COEFFICIENTS)
    axes.set_yticks(places, COEFFICIENTS)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.invert_yaxis()
    axes.set_aspect("equal")
    for spine in axes.spines.values():
        spine.set_visible(False)
    figure.colorbar(mesh, ax=axes, shrink=0.8, aspect=30, label="correlation")
    return figure


@canvas.picture
def attitude(facts: Facts) -> Figure:
    """u(|a|), ug, over all directions of the specific force on the block's axes: u^2 = g^T C g with C the covariance of
    the result and g the derivatives of |a| by the coefficients. The worst is that of `u_norm_g`."""
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.ticker import MaxNLocator

    azimuth, elevation = np.meshgrid(np.deg2rad(_AZIMUTH_DEG), np.deg2rad(_ELEVATION_DEG))
    level = np.cos(elevation)
    along = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1).reshape(-1, 3)
    u = canvas.MICRO * Coefficients.of(facts.result).force.uncertainty(along)[:, 3].reshape(level.shape)
    worst = facts.result.u_norm_g
    assert worst is not None  # as the caller has seen to
    figure = canvas.blank("attitude", 100.0, "Uncertainty of the length of the specific force by attitude")
    axes = figure.subplots()
    ramp = LinearSegmentedColormap.from_list("pale", ("#FFFFFF", "#6BAED6"))  # under black lines and numbers
    if np.ptp(u) > _FLAT * u.max():  # else there is no line to draw
        squares = u**2  # a polynomial, which straight lines between the points come closer to
        levels = np.square(MaxNLocator(8).tick_values(u.min(), u.max()))
        axes.contourf(_AZIMUTH_DEG, _ELEVATION_DEG, squares, levels, cmap=ramp)
        lines = axes.contour(_AZIMUTH_DEG, _ELEVATION_DEG, squares, levels, colors=canvas.BLACK, linewidths=0.6)
        _without_the_cut(axes.clabel(lines, fmt=lambda square: f"{square**0.5:.9g}", inline_spacing=2))
    x, y, z = worst.attitude
    place = np.rad2deg([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))])
    label = f"worst: {canvas.three_figures(canvas.MICRO * worst.worst_g)} µg"
    star: dict[str, Any] = {"markersize": 13, "markeredgecolor": canvas.BLACK, "markeredgewidth": 0.8, "clip_on": False}
    axes.plot(*place[:, None], "*", color=canvas.VERMILLION, label=label, linestyle="none", **star)
    for face, middle in _FACES.items():
        axes.annotate(
            face.replace("-", canvas.MINUS), middle, ha="center", va="center", bbox=_PLATE, annotation_clip=False
        )
    axes.set_xticks(range(-180, 181, 45))
    axes.set_yticks(range(-90, 91, 30))
    axes.set_xlabel("azimuth of the specific force, from x to y / deg")
    axes.set_ylabel("elevation towards z / deg")
    axes.set_title("u(|a|) / µg")
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2)
    return figure


def _without_the_cut(labels: list[Any]) -> None:
    """Take away the labels of lines that the edges of the map would cut, or the names of the faces hide."""
    corner, faces = np.array([180.0, 90.0]), np.array(list(_FACES.values()))
    for label in labels:
        place = np.array(label.get_position())
        hidden = (np.abs(faces - place) < _MARGIN_DEG).all(axis=1)
        if (np.abs(place) > corner - _MARGIN_DEG).any() or hidden.any():
            label.remove()
