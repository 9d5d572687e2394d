"""Results with their pictures, and what is read back from these."""

from functools import cache

import numpy as np
from conftest import EXAMPLES

import tumble
from tumble import model

PAPER = model.built_in("paper")
CASES = {
    "paper": ("paper_stand", {}),
    "lab": ("lab_stand", {"estimator": "optimal"}),
    "three_mountings": ("three_mountings_stand", {"schedule": "three_mountings"}),
    "diagonal": ("diagonal_stand", {"schedule": "diagonal", "estimator": "least_squares"}),
    "checks": ("with_checks", {"schedule": EXAMPLES / "with_checks.toml", "stand": EXAMPLES / "paper_stand.toml"}),
    "terms": ("paper_stand", {"estimator": "least_squares", "model": "k2,drift"}),
}
EVERY_ERROR = tumble.Stand(
    axis_tilt=2e-5, level=3e-5, remount=4e-4, angle=4e-5, noise=3e-4, samples=50, limits="sigma1",
    seat=1e-4, platform=5e-5, encoder=3e-5, drift=2e-4,
)
K = np.array([[2.0, 0.03, -0.02], [-0.01, 1.9, 0.04], [0.02, -0.05, 2.1]])
U0 = np.array([0.02, -0.01, 0.03])


@cache
def solved(name):
    """The run, the result, the stand, the pictures."""
    file, options = CASES[name]
    stand = options.get("stand", EXAMPLES / f"{file}.toml")
    run = tumble.read(EXAMPLES / f"{file}.csv")
    result = tumble.solve(run, **{"stand": stand, **options})
    return run, result, stand, result.plot(run=run)


def labelled(axes, label):
    """The one artist that has such a label."""
    found = [artist for artist in axes.get_children() if str(artist.get_label()).startswith(label)]
    assert len(found) == 1, (label, found)
    return found[0]


def dots(axes):
    """Height by place of fit and check positions together."""
    lines = [line for line in axes.lines if line.get_label() in ("fit", "check")]
    places, heights = (np.concatenate([getattr(line, f"get_{one}data")() for line in lines]) for one in "xy")
    return heights[np.argsort(places)]


def rows_of(outputs, schedule=PAPER):
    """A run of means."""
    return np.array([[one.mounting, one.number, *u] for one, u in zip(schedule.positions, outputs)])


def force_of(schedule):
    """Specific force at every ideal position, from the words of the page on the method."""
    matrices = {one.number: np.array(one.matrix) for one in schedule.mountings}
    turned = [(matrices[one.mounting], np.deg2rad(one.angle_deg)) for one in schedule.positions]
    return np.array([matrix @ [np.sin(angle), 0.0, np.cos(angle)] for matrix, angle in turned])


def shares_of(figure):
    """By source: percent of every coefficient."""
    return {bars.get_label(): np.array([bar.get_width() for bar in bars]) for bars in figure.axes[0].containers}
