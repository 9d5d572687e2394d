"""At which attitude the calibrated block shows the length of gravity worst."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.arrays import Floats
from tumble.pictures.canvas import BLACK, MINUS, VERMILLION, blank
from tumble.pictures.facts import MICRO, Facts, three_figures
from tumble.solving.coefficients import Coefficients

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_AZIMUTH_DEG, _ELEVATION_DEG = np.linspace(-180.0, 180.0, 145), np.linspace(-90.0, 90.0, 73)
_FACES = {
    "+x": (0, 0),
    f"{MINUS}x": (180, 0),
    "+y": (90, 0),
    f"{MINUS}y": (-90, 0),
    "+z": (0, 90),
    f"{MINUS}z": (0, -90),
}
_PLATE = {"boxstyle": "round,pad=0.15", "facecolor": "white", "edgecolor": "none"}
_LEVELS = 8
_FLAT = 1e-9  # of the largest
_MARGIN_DEG = np.array([15.0, 5.0])  # half a label, at most
_PALEST_TO_DARKEST = ("#FFFFFF", "#6BAED6")  # under black lines and numbers


def attitude(facts: Facts) -> Figure:
    """u(|a|), ug, over all directions of the specific force on the block's axes: u^2 = g^T C g with C the covariance of
    the result and g the derivatives of |a| by the coefficients (model.force). The worst is that of `u_norm_g`."""
    from matplotlib.colors import LinearSegmentedColormap
    from matplotlib.ticker import MaxNLocator

    u = MICRO * uncertainties(facts.document, directions(_AZIMUTH_DEG[None, :], _ELEVATION_DEG[:, None]))
    worst = facts.document["u_norm_g"]
    figure = blank("attitude", 100.0)
    axes = figure.subplots()
    ramp = LinearSegmentedColormap.from_list("pale", _PALEST_TO_DARKEST)
    if np.ptp(u) > _FLAT * u.max():  # else there is no line to draw
        squares = u**2  # a polynomial, which straight lines between the points come closer to
        levels = np.square(MaxNLocator(_LEVELS).tick_values(u.min(), u.max()))
        axes.contourf(_AZIMUTH_DEG, _ELEVATION_DEG, squares, levels, cmap=ramp)
        lines = axes.contour(_AZIMUTH_DEG, _ELEVATION_DEG, squares, levels, colors=BLACK, linewidths=0.6)
        _without_the_cut(axes.clabel(lines, fmt=lambda square: f"{square**0.5:.9g}", inline_spacing=2))
    azimuth, elevation = angles_deg(np.array(worst["attitude"]))
    label = f"worst: {three_figures(MICRO * worst['worst_g'])} µg"
    star: dict[str, Any] = {"markersize": 13, "markeredgecolor": BLACK, "markeredgewidth": 0.8, "clip_on": False}
    axes.plot([azimuth], [elevation], "*", color=VERMILLION, label=label, linestyle="none", **star)
    for face, place in _FACES.items():
        axes.annotate(face, place, ha="center", va="center", bbox=_PLATE, annotation_clip=False)
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


def directions(azimuth_deg: Floats, elevation_deg: Floats) -> Floats:
    """Unit vectors (..., 3) on the block's axes."""
    azimuth, elevation = np.broadcast_arrays(np.deg2rad(azimuth_deg), np.deg2rad(elevation_deg))
    level = np.cos(elevation)
    return np.stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)], axis=-1)


def angles_deg(direction: Floats) -> tuple[float, float]:
    """Azimuth and elevation of a unit vector."""
    x, y, z = direction.tolist()
    return float(np.rad2deg(np.arctan2(y, x))), float(np.rad2deg(np.arctan2(z, np.hypot(x, y))))


def uncertainties(document: dict[str, object], attitudes: Floats) -> Floats:
    """Standard uncertainty (...), g, of the length that the block shows of a specific force of 1 g along `attitudes`
    (..., 3)."""
    force = Coefficients.of(document).force
    found: Floats = force.uncertainty(attitudes.reshape(-1, 3))[:, 3].reshape(attitudes.shape[:-1])
    return found
