"""The stand as the run shows it, against what is declared of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tumble.fixture.judge import Limits
from tumble.model.explanations import SYSTEMATIC
from tumble.model.stand_seen import NAMES
from tumble.pictures.by_position import BAND
from tumble.pictures.canvas import BLACK, BLUE, GREY, PALE, VERMILLION, blank
from tumble.pictures.facts import MICRO, Facts
from tumble.units import noise_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SYMBOLS = {
    "alpha1_rad": "axis tilt α₁",
    "alpha2_plus_alpha3_rad": "level + yaw α₂ + α₃",
    "alpha3_difference_rad": "yaw change",
    "alpha4_rad": "set angles α₄",
    "noise_v": "noise of a sample",
}
_ROW_MM = 17.0


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

    @property
    def is_drawn_once(self) -> bool:
        """An angle of the whole run, as against a standard deviation of many."""
        return self.key in SYSTEMATIC


def rows(facts: Facts) -> list[Row]:
    """One for each thing that the run shows."""
    seen, fine = facts.document["stand_seen"], facts.document["stand_seen"].get("augmented") or {}
    mountings = sorted({one["mounting"] for one in facts.document["means"] if one["use"] == "fit"})
    declared = {} if facts.stand is None else Limits.declared(facts.stand, len(mountings)).sigma
    found = []
    for key, title in _SYMBOLS.items():
        unit, factor = _unit_of(key, facts)
        found.append(Row(key, title, unit, factor, _pair(seen, key), _pair(fine, key), declared.get(key)))
    if len(mountings) > 1:
        found[2] = _renamed(found[2], mountings[0], mountings[1])
    for other in fine.get("other_yaw_changes", []):
        row = Row(found[2].key, "", "µrad", MICRO, None, _pair(other, found[2].key), found[2].declared)
        found.insert(len(found) - 2, _renamed(row, mountings[0], other["mounting"]))
    return [row for row in found if row.closed is not None or row.augmented is not None]


def stand_seen(facts: Facts) -> Figure:
    """Every thing on an axis of its own: seen, with +-2 standard uncertainties, and where the stand is told the range
    of +-2 declared standard deviations, of what is a standard deviation itself a line at the declared one."""
    shown = rows(facts)
    figure = blank("stand_seen", 12.0 + _ROW_MM * len(shown))
    panels = figure.subplots(len(shown), 1, squeeze=False)[:, 0]
    for axes, row in zip(panels, shown):
        _draw(axes, row)
    handles = {label: one for axes in panels for one, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(handles.values(), handles.keys(), loc="outside upper left", ncol=4)
    return figure


def _draw(axes: Axes, row: Row) -> None:
    if row.declared is not None:
        _draw_declared(axes, row.factor * row.declared, row.is_drawn_once)
    several = row.augmented is not None and row.closed is not None
    for one, height, marker, colour, label in (
        (row.closed, 0.3 if several else 0.0, "o", BLUE, "seen"),
        (row.augmented, -0.3 if several else 0.0, "s", VERMILLION, "seen by least squares"),
    ):
        if one is not None:
            value, u = one
            bar = None if u is None else [BAND * row.factor * u]
            label += "" if u is None else ", ±2 u"
            axes.errorbar([row.factor * value], [height], xerr=bar, fmt=marker, color=colour, capsize=3.0, label=label)
    if row.is_drawn_once:
        axes.axvline(0.0, color=BLACK, linewidth=0.5)
        largest = max(abs(end) for end in axes.get_xlim())
        axes.set_xlim(-largest, largest)
    else:
        axes.set_xlim(0.0, 1.05 * axes.get_xlim()[1])
    axes.set_ylim(-0.9, 0.9)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.set_title(f"{row.title} / {row.unit}", fontsize="medium")


def _draw_declared(axes: Axes, sigma: float, is_drawn_once: bool) -> None:
    if is_drawn_once:
        look: dict[str, Any] = {"facecolor": PALE, "edgecolor": GREY, "hatch": "///", "linewidth": 0.4}
        axes.axvspan(-BAND * sigma, BAND * sigma, label="declared, ±2 u", **look)
    else:
        axes.axvline(sigma, color=BLACK, linestyle="--", label="declared u")


def _unit_of(key: str, facts: Facts) -> tuple[str, float]:
    if key != "noise_v":
        return "µrad", MICRO
    unit = noise_unit(facts.unit)
    return ("µV", MICRO) if unit == "V" else (unit, 1.0)


def _pair(seen: dict[str, Any], key: str) -> tuple[float, float | None] | None:
    return None if seen.get(key) is None else (seen[key], seen[f"u_{key}"])


def _renamed(row: Row, first: int, other: int) -> Row:
    """A change of the yaw, by its two mountings."""
    title = f"{NAMES[row.key]}, mounting {first} less {other}"
    return Row(row.key, title, row.unit, row.factor, row.closed, row.augmented, row.declared)
