"""Pictures of one result by position, by sample and by what the run shows of its stand; and what all pictures of a
result are made from."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from msgspec import UnsetType

from tumble.arrays import Floats, Integers
from tumble.documents.result import Result, StandSeen
from tumble.errors import UsageError
from tumble.estimators import NORM
from tumble.fixture.judge import Limits
from tumble.model.fit import SYSTEMATIC
from tumble.model.inclined import parabola
from tumble.model.stand_seen import NAMES
from tumble.pictures import canvas
from tumble.pictures.canvas import BLACK, BLUE, GREY, MICRO, PALE, VERMILLION, picture
from tumble.schedule import CHECK, FIT, Schedule
from tumble.solving.expected import Expected, residuals as residuals_of
from tumble.stand import Stand
from tumble.units import noise_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BAND = 2.0  # standard deviations: 95 % of what is normal

_MOST_UPRIGHT = 20  # labels of positions, side by side
_MOST_POINTS = 2000
_FEW = 100  # rows that are drawn as dots
_MOST_WINDOWS = 72  # that are shaded and named: two visits to each position of the longest schedule
_SAME = 1e-9  # of the largest mean


class Recorded(Protocol):
    """What `tumble.read` returns, as far as it is drawn."""

    @property
    def mounting(self) -> Integers: ...
    @property
    def position(self) -> Integers: ...
    @property
    def outputs(self) -> Floats: ...


@dataclass(frozen=True)
class Facts:
    """A `result`, and None for whatever is not known: the `run` that was solved, the
    `schedule` of its measured positions, the `stand` that was declared and what is `expected` of it."""

    result: Result
    run: Recorded | None
    schedule: Schedule | None
    stand: Stand | None
    expected: Expected | None

    @property
    def unit(self) -> str:
        """Of the outputs."""
        return self.result.unit


@picture
def gravity_check(facts: Facts) -> Figure:
    """delta_g at every position, ug: `verification.delta_g_g` of the result, with its limit; where the stand is told,
    with +-2 standard deviations of it that the declared errors leave (solving.expected)."""
    check = facts.result.verification
    delta_g = MICRO * np.array([one.delta_g_g for one in check.delta_g_g])
    limit = MICRO * check.limit_g
    figure = canvas.blank("gravity_check", 75.0, "Gravity check")
    axes = figure.subplots()
    if facts.expected is not None:
        _band(axes, MICRO * facts.expected.delta_g, "±2 u, declared stand")
    axes.axhline(limit, color=BLACK, linestyle="--", label=f"limit ±{limit:.9g} µg")
    axes.axhline(-limit, color=BLACK, linestyle="--")
    _dots(axes, delta_g, facts)
    largest = 1.12 * max(limit, float(np.abs(delta_g).max()))
    axes.set_ylim(-largest, largest)
    axes.set_ylabel("Δg / µg")
    axes.set_title(f"Gravity check {'passed' if check.passed else 'FAILED'}")
    _positions(axes, facts)
    canvas.legend_above(axes, 4)
    return figure


@picture
def residuals(facts: Facts) -> Figure:
    """U - U0 - K a of every channel on the ideal schedule (solving.expected.residuals), which must be known. The band
    is +-2 standard deviations of a residual by all errors that the stand declares; where it is not told, +-2 standard
    errors of a mean by the noise of the samples alone (`noise.of_means` of the result)."""
    assert facts.schedule is not None  # as the caller has seen to
    left = residuals_of(facts.result, facts.schedule)
    sigma, label = None, ""
    if facts.expected is not None:
        sigma, label = facts.expected.residuals, "±2 u, declared stand"
    elif (noise := facts.result.noise) is not None and noise.of_means is not None:
        samples = np.array([one.samples for one in facts.result.means])
        sigma, label = noise.of_means / np.sqrt(samples)[:, None], "±2 u, noise of the samples alone"
    factor, unit = canvas.small(facts.unit, left)
    figure = canvas.blank("residuals", 120.0, "Residuals")
    panels = figure.subplots(3, 1, sharex=True)
    for i, axes in enumerate(panels):
        if sigma is not None:
            _band(axes, factor * sigma[:, i], label)
        axes.axhline(0.0, color=BLACK, linewidth=0.5)
        _dots(axes, factor * left[:, i], facts)
        axes.margins(y=0.1)
        axes.set_ylabel(f"{'xyz'[i]} channel / {unit}")
        _positions(axes, facts, "mounting.position" if i == 2 else "")
    panels[0].set_title("Residuals")
    canvas.legend_above(panels[0], 3)
    return figure


def _band(axes: Axes, sigma: Floats, label: str) -> None:
    """As wide as a position, from one to the next."""
    edges, heights = np.arange(len(sigma) + 1) - 0.5, BAND * sigma
    axes.use_sticky_edges = False  # a margin around the band
    look: dict[str, Any] = {"facecolor": PALE, "edgecolor": GREY, "linewidth": 0.4}
    axes.stairs(heights, edges, baseline=-heights, fill=True, label=label, **look)


def _dots(axes: Axes, values: Floats, facts: Facts) -> None:
    """Full circles for what was fitted, open diamonds for what was only checked."""
    is_check = np.array([one.use == CHECK for one in facts.result.means])
    places = np.arange(len(values))
    axes.vlines(places, 0.0, values, color=GREY, linewidth=0.6)
    axes.plot(places[~is_check], values[~is_check], "o", color=BLUE, label="fit")
    if is_check.any():
        look: dict[str, Any] = {"markerfacecolor": "white", "markeredgecolor": VERMILLION, "markeredgewidth": 1.2}
        axes.plot(places[is_check], values[is_check], "D", label="check", **look)


def _positions(axes: Axes, facts: Facts, title: str = "mounting.position") -> None:
    """The axis of the measured positions, named as "2.7", with a line wherever the block was mounted anew."""
    means = facts.result.means
    labels = [f"{one.mounting}.{one.position}" for one in means]
    axes.set_xticks(range(len(labels)), labels, rotation=90 if len(labels) > _MOST_UPRIGHT else 0)
    axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.set_xlabel(title)
    for index, (before, one) in enumerate(pairwise(means)):
        if before.mounting != one.mounting:
            axes.axvline(index + 0.5, color=GREY, linewidth=0.6, linestyle=":")


@picture
def samples(facts: Facts) -> Figure:
    """The outputs by the number of their row, from 1; every second stretch of a position is shaded, and all are named
    above. A run with more stretches than a schedule has positions, whose samples alternate, has neither. Of many rows
    the lowest and highest of every stretch are drawn."""
    run = facts.run
    assert run is not None  # as the caller has seen to
    outputs, kept = run.outputs, canvas.thinned(run.outputs, _MOST_POINTS)
    begins = [0, *(np.flatnonzero(np.diff(256 * run.mounting + run.position)) + 1).tolist()]
    windows = [*zip(begins, [*begins[1:], len(outputs)])] if len(begins) <= _MOST_WINDOWS else []
    figure = canvas.blank("samples", 110.0, "Samples of the run", room_above=0.02)
    panels = figure.subplots(3, 1, sharex=True)
    look: dict[str, Any] = {"linestyle": "none", "marker": "."} if len(outputs) <= _FEW else {"linewidth": 0.6}
    for i, axes in enumerate(panels):
        for begin, end in windows[::2]:
            axes.axvspan(begin + 0.5, end + 0.5, color=PALE, linewidth=0, label="_averaged")
        axes.plot(kept + 1, outputs[kept, i], color=BLUE, label="_outputs", **look)
        axes.set_ylabel(f"u{'xyz'[i]} / {facts.unit}")
    above: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "ha": "center", "va": "bottom"}
    above["rotation"] = 90 if len(windows) > _MOST_UPRIGHT else 0
    for begin, end in windows:
        name = f"{run.mounting[begin]}.{run.position[begin]}"
        panels[0].annotate(name, ((begin + end + 1) / 2, 1.03), **above)
    panels[-1].set_xlim(0.5, len(outputs) + 0.5)
    panels[-1].set_xlabel("number of the sample" if len(outputs) > len(begins) else "number of the mean")
    return figure


def require_same_run(result: Result, run: Recorded) -> None:
    """Raise UsageError where the means of a run are not those of the result."""
    means = np.array([one.mean for one in result.means])
    largest = float(np.abs(means).max())
    numbers = [(one.mounting, one.position) for one in result.means]
    if result.estimator == NORM:  # whose poses may have been numbered anew, in the order of the run
        numbers = [*dict.fromkeys(zip(run.mounting.tolist(), run.position.tolist())), *numbers][: len(numbers)]
    for one, mean, (mounting, position) in zip(result.means, means, numbers):
        here = (run.mounting == mounting) & (run.position == position)
        if here.sum() != one.samples or np.abs(run.outputs[here].mean(axis=0) - mean).max() > _SAME * largest:
            place = f"{one.mounting}.{one.position}"
            raise UsageError(f"run: not that of the result, which has another mean at position {place}")


@dataclass(frozen=True)
class Row:
    """What is seen of one thing: `key` of the result, `title`, `unit` in which the values are drawn, `factor` to it.
    `closed` and `augmented`: value and u by the closed form and by least squares for everything at once, None where
    there is none; u None where it is not known. `declared`: a standard deviation, None: it is not told."""

    key: str
    title: str
    unit: str
    factor: float
    closed: tuple[float, float | None] | None
    augmented: tuple[float, float | None] | None
    declared: float | None


def rows(facts: Facts) -> list[Row]:
    """One for each thing that the run shows."""
    seen = facts.result.stand_seen
    fine = seen.augmented if isinstance(seen, StandSeen) else None
    mountings = sorted({one.mounting for one in facts.result.means if one.use == FIT})
    declared = {} if facts.stand is None else Limits.declared(facts.stand, len(mountings)).sigma

    def row(key: str, title: str, augmented: Any, closed: Any, unit: str = "µrad") -> Row:
        values = [(getattr(one, key, None), getattr(one, f"u_{key}", None)) for one in (closed, augmented)]
        pairs = [None if value is None else (value, u) for value, u in values]
        return Row(key, title, unit, MICRO if unit[0] == "µ" else 1.0, pairs[0], pairs[1], declared.get(key))

    def change(other: int) -> str:
        return f"{NAMES[yaw]}, mounting {mountings[0]} less {other}"

    yaw, noise = "alpha3_difference_rad", noise_unit(facts.unit)
    others = () if fine is None else fine.other_yaw_changes
    found = [
        row("alpha1_rad", "axis tilt α₁", fine, seen),
        row("alpha2_plus_alpha3_rad", "level + yaw α₂ + α₃", fine, seen),
        row(yaw, change(mountings[1]) if len(mountings) > 1 else "yaw change", fine, seen),
        *(row(yaw, change(other.mounting), other, None) for other in others),
        row("alpha4_rad", "set angles α₄", fine, seen),
        row("noise_v", "noise of a sample", fine, seen, "µV" if noise == "V" else noise),
    ]
    return [one for one in found if one.closed is not None or one.augmented is not None]


@picture
def stand_seen(facts: Facts) -> Figure:
    """Every thing on an axis of its own: seen, with +-2 standard uncertainties, and where the stand is told the range
    of +-2 declared standard deviations, of what is a standard deviation itself a line at the declared one."""
    shown = rows(facts)
    figure = canvas.blank("stand_seen", 12.0 + 17.0 * len(shown), "The stand seen in the run")
    panels = figure.subplots(len(shown), 1, squeeze=False)[:, 0]
    for axes, row in zip(panels, shown):
        _draw(axes, row)
    handles = {label: one for axes in panels for one, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(handles.values(), handles.keys(), loc="outside upper left", ncol=4)
    return figure


def _draw(axes: Axes, row: Row) -> None:
    is_systematic = row.key in SYSTEMATIC  # an angle of the whole run, as against a standard deviation of many
    if row.declared is not None and is_systematic:
        ends = -BAND * row.factor * row.declared, BAND * row.factor * row.declared
        axes.axvspan(*ends, label="declared, ±2 u", facecolor=PALE, edgecolor=GREY, hatch="///", linewidth=0.4)
    elif row.declared is not None:
        axes.axvline(row.factor * row.declared, color=BLACK, linestyle="--", label="declared u")
    apart = 0.3 if row.augmented is not None and row.closed is not None else 0.0
    for one, height, marker, colour, label in (
        (row.closed, apart, "o", BLUE, "seen"),
        (row.augmented, -apart, "s", VERMILLION, "seen by least squares"),
    ):
        if one is not None:
            value, u = one
            bar = None if u is None else [BAND * row.factor * u]
            label += "" if u is None else ", ±2 u"
            axes.errorbar([row.factor * value], [height], xerr=bar, fmt=marker, color=colour, capsize=3.0, label=label)
    if is_systematic:
        axes.axvline(0.0, color=BLACK, linewidth=0.5)
    largest = max(abs(end) for end in axes.get_xlim())
    axes.set(xlim=(-largest, largest) if is_systematic else (0.0, 1.05 * axes.get_xlim()[1]), ylim=(-0.9, 0.9))
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.set_title(f"{row.title} / {row.unit}", fontsize="medium")


@picture
def inclinations(facts: Facts) -> Figure:
    """The parabola of docs/never-remounted.md, of a run's own means: of each inclination the squared amplitude of the
    part of the outputs that turns with the table, over how far the other part has moved since the first."""
    schedule, told = facts.schedule, facts.result.inclinations
    assert schedule is not None and not isinstance(told, UnsetType)  # as the caller has seen to
    weights = np.ones(3) if facts.stand is None else facts.stand.weights
    found = parabola(schedule, np.array([one.mean for one in facts.result.means]), weights)
    level, largest = float(found.level[0]), float(found.largest[0])
    figure = canvas.blank("inclinations", 90.0, "Inclinations, and the level axis")
    axes = figure.subplots()
    margin = 0.12 * float(np.ptp(found.along))
    along = np.linspace(float(found.along.min()) - margin, float(found.along.max()) + margin, 200)
    axes.plot(along, found.p + found.q * along + found.r * along**2, color=GREY, label="parabola through them")
    axes.axvline(level, color=BLACK, linestyle="--", label="level")
    axes.plot(found.along, found.across, "o", color=BLUE, label="inclinations")
    axes.plot([level], [largest], "*", color=VERMILLION, markersize=11, label="all of gravity across the axis")
    for one, x, y in zip(told, found.along, found.across):
        inwards, side = (-8, "right") if x > level + 0.1 * float(np.ptp(found.along)) else (8, "left")
        name = f"{one.deg:+.2f}°".replace("-", canvas.MINUS)
        axes.annotate(name, (x, y), (inwards, -12), textcoords="offset points", ha=side)
    axes.set_ylim(0.0, 1.12 * largest)
    axes.set_xlabel(f"part of the outputs that does not turn, since the first inclination / {facts.unit}")
    axes.set_ylabel(f"turning part, squared / {facts.unit}²")
    canvas.legend_above(axes, 4)
    return figure
