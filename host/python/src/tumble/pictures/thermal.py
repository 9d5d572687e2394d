"""Pictures of a calibration over temperature: every coefficient, what the runs leave of it, the uncertainty of |a|."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tumble.arrays import Floats
from tumble.documents.thermal import Thermal
from tumble.errors import UsageError, quoted
from tumble.estimators import COEFFICIENTS
from tumble.model.coefficients import worst_norm
from tumble.model.thermal import Polynomials, ThermalFit
from tumble.pictures import canvas
from tumble.pictures.canvas import BLACK, BLUE, GREY, MICRO, PALE, VERMILLION, picture
from tumble.pictures.result import BAND

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROWS, _COLUMNS = 4, 3
_HEIGHT_MM, _CURVE_MM = 115.0, 75.0
_OUTSIDE = 0.12  # of the range, on either side: extrapolated
_POINTS, _NORMS = 121, 25
_UNITS = tuple("ppm" if place in (0, 4, 8) else "µrad" if place < 9 else "µg" for place in range(12))
_SIZES = "in parts per million of the sensitivity of its channel (elements of K), or in µg (U0)"
CAPTIONS = {
    "coefficients": f"How every coefficient changes from its value at the reference temperature, {_SIZES}. The grey"
    " band holds ±2 standard uncertainties; the points are the runs, each solved alone, with ±2 of its own. Where the"
    " background is grey and the line dashed, no run was measured: there the polynomials are extrapolated.",
    "residuals": f"The runs, each solved alone, less the polynomials of all together, {_SIZES}, with ±2 standard"
    " uncertainties of the run and, as a band, of the polynomials.",
    "uncertainty": "The standard uncertainty of the length of the calibrated acceleration at the worst attitude, over"
    " temperature. It must stay below the limit over the coverage factor; where the background is grey, no run was"
    " measured.",
}


def figures(told: Thermal, kind: str | None = None) -> dict[str, Figure]:
    """All pictures by name, or that of this `kind`; "uncertainty" only with a stand. Raises UsageError."""
    if kind is not None and kind not in CAPTIONS:
        raise UsageError(f"kind: {quoted(kind)} is not one of {', '.join(CAPTIONS)}")
    if kind == "uncertainty" and told.covariance is None:
        raise UsageError("kind: uncertainty needs runs that were solved with a stand")
    drawn = {"coefficients": coefficients, "residuals": residuals}
    if told.covariance is not None:
        drawn["uncertainty"] = uncertainty
    return {name: draw(told) for name, draw in drawn.items() if kind in (None, name)}


@picture
def coefficients(told: Thermal) -> Figure:
    """Every coefficient less its value at the reference temperature, as CAPTIONS has it."""
    polynomials = _polynomials(told)
    zero = _row(*polynomials.at(told.reference_c))
    figure = canvas.blank("coefficients", _HEIGHT_MM, "Coefficients over temperature")
    return _panels(figure, told, lambda t: _row(*polynomials.at(t)) - zero, lambda t: zero)


@picture
def residuals(told: Thermal) -> Figure:
    """Every run alone less the polynomials, as CAPTIONS has it."""
    polynomials = _polynomials(told)
    figure = canvas.blank("residuals", _HEIGHT_MM, "Runs alone less the polynomials")
    return _panels(figure, told, lambda t: np.zeros((len(t), 12)), lambda t: _row(*polynomials.at(t)))


@picture
def uncertainty(told: Thermal) -> Figure:
    """The worst u(|a|), ug, over temperature."""
    polynomials, fit = _polynomials(told), _fit(told)
    figure = canvas.blank("uncertainty", _CURVE_MM, "Uncertainty of |a| over temperature", room_above=0.02)
    axes = figure.subplots()

    def worst(temperature_c: float) -> float:
        return MICRO * worst_norm(polynomials.at(temperature_c)[0], fit.covariance_at(temperature_c)).worst_g

    for t, look in _stretches(told, _NORMS):
        axes.plot(t, [worst(one) for one in t.tolist()], **look)
    at = [one.temperature_c for one in told.u_norm_g]
    axes.plot(at, [MICRO * one.worst_g for one in told.u_norm_g], "o", color=BLUE, label="judged")
    axes.set_ylim(0.0, 1.15 * axes.get_ylim()[1])
    limit, factor = MICRO * told.decision.limit_g, told.decision.coverage_factor
    above = "" if limit / factor <= axes.get_ylim()[1] else " (above)"
    label = f"limit {limit:.9g} µg over {factor:g}{above}"
    axes.axhline(limit / factor, color=VERMILLION, linestyle="-.", label=label)
    _outside(axes, told)
    axes.set_xlabel("temperature / °C")
    axes.set_ylabel("worst u(|a|) / µg")
    canvas.legend_above(axes, 4)
    return figure


def _panels(figure: Figure, told: Thermal, line: Any, zero: Any) -> Figure:
    """One for each coefficient: a `line` (temperatures, 12), and the runs less `zero` of their temperature (12,)."""
    k, _ = _polynomials(told).at(told.reference_c)
    size = MICRO / np.append(np.repeat(np.linalg.norm(k, axis=1), 3), np.linalg.norm(k, axis=1))
    runs, fit = told.runs, None if told.covariance is None else _fit(told)
    panels = figure.subplots(_ROWS, _COLUMNS, sharex=True).ravel()
    for t, look in _stretches(told, _POINTS):
        values = line(t) * size
        u = None if fit is None else [np.sqrt(np.diag(fit.covariance_at(one))) * size for one in t.tolist()]
        for place, axes in enumerate(panels):
            axes.plot(t, values[:, place], **look)
            if u is not None:
                half = BAND * np.array(u)[:, place]
                band: dict[str, Any] = {"facecolor": "#C8C8C8", "edgecolor": GREY, "linewidth": 0.4, "zorder": 1}
                label = "_band" if look["label"].startswith("_") else f"±{BAND:g} u"
                axes.fill_between(t, values[:, place] - half, values[:, place] + half, label=label, **band)
    at = np.array([one.mean_c for one in runs])
    spans = np.abs(np.array([one.range_c for one in runs]).T - at)
    found = np.array([(_row(one.K, one.U0) - zero(one.mean_c)) * size for one in runs])
    bars = np.zeros((len(runs), 12))
    for bar, one in zip(bars, runs):
        if one.u_K is not None and one.u_U0 is not None:
            bar[:] = BAND * _row(one.u_K, one.u_U0) * size
    for place, (axes, name) in enumerate(zip(panels, COEFFICIENTS)):
        look = {"fmt": "o", "color": BLUE, "markersize": 3.5, "elinewidth": 0.8, "capsize": 2.0, "zorder": 3}
        axes.errorbar(at, found[:, place], bars[:, place], spans, label="run alone", gid=name, **look)
        _outside(axes, told)
        axes.set_title(f"{name} / {_UNITS[place]}", fontsize="medium")
    for axes in panels[-_COLUMNS:]:
        axes.set_xlabel("temperature / °C")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncol=5)
    return figure


def _stretches(told: Thermal, points: int) -> list[tuple[Floats, dict[str, Any]]]:
    """Temperatures below, within and above the range of the runs, and how a line looks there."""
    low, high = told.range_c
    margin = _OUTSIDE * (high - low)
    few = max(2, round(_OUTSIDE * points))
    beyond: dict[str, Any] = {"color": BLACK, "linestyle": "--", "zorder": 2}
    return [
        (np.linspace(low, high, points), {"color": BLACK, "label": "all runs", "zorder": 2}),
        (np.linspace(high, high + margin, few), {**beyond, "label": "_beyond"}),
        (np.linspace(low - margin, low, few), {**beyond, "label": "_beyond"}),
    ]


def _outside(axes: Axes, told: Thermal) -> None:
    """Shade what is extrapolated."""
    low, high = told.range_c
    margin = _OUTSIDE * (high - low)
    for begin, end, label in ((low - margin, low, "extrapolated"), (high, high + margin, "_extrapolated")):
        axes.axvspan(begin, end, color=PALE, linewidth=0, label=label, zorder=0)
    axes.set_xlim(low - margin, high + margin)


def _row(k: Floats, u0: Floats) -> Floats:
    """K row by row and U0: (..., 12)."""
    k, u0 = np.asarray(k), np.asarray(u0)
    return np.concatenate([k.reshape(*k.shape[:-2], 9), u0], axis=-1)


def _polynomials(told: Thermal) -> Polynomials:
    return Polynomials(told.reference_c, np.array(told.K), np.array(told.U0))


def _fit(told: Thermal) -> ThermalFit:
    assert told.covariance is not None  # as the caller has seen to
    return ThermalFit(_polynomials(told), told.covariance, 0.0, 0)
