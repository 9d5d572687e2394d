"""What gravity says of a block at rest: its scales and biases, and from these the attitude of every rest.

At rest an accelerometer block measures a unit vector (g). So the outputs of all rests lie on an ellipsoid, which for a
block whose channels lie nearly along its axes has nearly the axes of the outputs: six unknowns, linear in the squares.
That leaves open which way round each channel is, and which channel belongs to which axis: a view. For each view the
attitudes are held against those of the schedule, and K and U0 are fitted, all twelve of them.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.model.geometry import Geometry
from tumble.schedule import Schedule

AXES = "xyz"
_SAME = 1e-6  # rad: attitudes closer than this are one
_LEAST_SINGULAR = 1e-2  # of the largest: below, the rests do not show scale and bias of every channel
_ROUGH = 0.45  # of the smallest angle between attitudes: how far off a first guess may be
_ROUNDS = 12
_SQUARES = 6  # unknowns of an ellipsoid along the axes
_CROSS = 0.5  # of a channel's own axis: what it may feel of another
_RANK = 4  # of the unit attitudes with a column of ones: K and U0 need as much

Channels = tuple[int, int, int]
Signs = tuple[int, int, int]
STRAIGHT: Channels = (0, 1, 2)


@dataclass(frozen=True)
class Attitudes:
    """Those of a schedule: `forces` (attitudes, 3), unit vectors on the block's axes; `of_position` (positions,): which
    of them each position has; `apart`: the smallest angle between two, rad."""

    forces: Floats
    of_position: Integers
    apart: float


@dataclass(frozen=True)
class View:
    """Which channel is along which axis (`channels`, of x, y and z), and which way round (`signs`)."""

    channels: Channels = STRAIGHT
    signs: Signs = (1, 1, 1)


@dataclass(frozen=True)
class Fit:
    """K (3, 3) and U0 (3,) of outputs at known attitudes, and `inverse` (4, 4) of the normal
    equations, by which leverage is told."""

    k: Floats
    u0: Floats
    inverse: Floats

    def attitudes(self, means: Floats) -> Floats:
        """What the block feels where it gives `means` (n, 3): (n, 3), g."""
        felt = np.linalg.solve(self.k, (means - self.u0).T).T
        return np.asarray(felt, dtype=np.float64)

    def leverage(self, forces: Floats) -> Floats:
        """How much of its own error an attitude takes into the fit."""
        design = _design(forces)
        found: Floats = np.einsum("ni,ij,nj->n", design, self.inverse, design)
        return found


@dataclass(frozen=True)
class Seen:
    """The rests in one view: `nearest` (rests,), index of the attitude that each is near to, -1 for none; `off`
    (rests,): how far, rad."""

    view: View
    fit: Fit
    nearest: Integers
    off: Floats


def attitudes_of(schedule: Schedule) -> Attitudes:
    """Those that a schedule has, each once."""
    ideal = Geometry(schedule).force()
    forces: list[Floats] = []
    of_position = []
    for force in ideal:
        same = [index for index, known in enumerate(forces) if np.linalg.norm(known - force) < _SAME]
        of_position.append(same[0] if same else len(forces))
        if not same:
            forces.append(force)
    stacked = np.array(forces)
    distances = np.linalg.norm(stacked[:, None] - stacked, axis=-1) + 4.0 * np.eye(len(stacked))
    return Attitudes(stacked, np.array(of_position), float(2 * np.arcsin(min(distances.min(), 2.0) / 2)))


def views(signs: Signs | None, channels: bool) -> Iterator[View]:
    """All views of these signs, None: any; with the channels exchanged in every way, or not."""
    for order in itertools.permutations(STRAIGHT) if channels else (STRAIGHT,):
        for way in [signs] if signs is not None else itertools.product((1, -1), repeat=3):
            yield View(order, way)  # type: ignore[arg-type] # three of them


def scale_and_bias(means: Floats) -> tuple[Floats, Floats] | None:
    """Size of the scale (3,) and bias (3,) of each channel, as if it felt its own axis alone; None where the rests do
    not show them."""
    if len(means) < _SQUARES:
        return None
    middle = (means.max(axis=0) + means.min(axis=0)) / 2
    half = (means.max(axis=0) - means.min(axis=0)) / 2
    if not (half > 0.0).all():
        return None
    unit = (means - middle) / half
    design = np.hstack([unit**2, unit])
    left, singular, right = np.linalg.svd(design, full_matrices=False)
    if singular[-1] < _LEAST_SINGULAR * singular[0]:
        return None
    square, linear = np.split(right.T @ ((left.T @ np.ones(len(unit))) / singular), 2)
    if not (square > 0.0).all():
        return None
    centre = -linear / (2 * square)
    size = np.sqrt((1.0 + (square * centre**2).sum()) / square)
    return half * size, middle + half * centre


def see(means: Floats, rough: tuple[Floats, Floats], view: View, attitudes: Attitudes, tolerance: float) -> Seen | None:
    """The rests in a view; None where they cannot be seen so: too few near attitudes, or another K comes out."""
    scale, bias = rough
    felt = ((means - bias) / scale)[:, list(view.channels)] * view.signs
    allowed = max(tolerance, _ROUGH * attitudes.apart)
    nearest, off = _nearest(felt, attitudes, allowed)
    fit = None
    for _ in range(_ROUNDS):
        near = nearest >= 0
        usual = max(float(np.median(off[near])), 1e-6) if near.any() else 1.0
        weights = 1.0 / np.sqrt(1.0 + (off[near] / (3.0 * usual)) ** 2)  # far off where others are near counts little
        fit = fitted(attitudes.forces[nearest[near]], means[near], weights)
        if fit is None or not is_view_of(view, fit.k):
            return None
        before = nearest
        nearest, off = _nearest(fit.attitudes(means), attitudes, allowed)
        if (before == nearest).all() and allowed == tolerance:
            break
        allowed = tolerance
    return None if fit is None else Seen(view, fit, nearest, off)


def fitted(forces: Floats, means: Floats, weights: Floats | None = None) -> Fit | None:
    """K and U0 by least squares, from outputs (n, 3) at attitudes (n, 3); None where these do not tell them."""
    design = _design(forces)
    weighted = design if weights is None else design * weights[:, None]
    if len(design) < _RANK or np.linalg.matrix_rank(weighted, tol=1e-3 * len(design) ** 0.5) < _RANK:
        return None
    scaled = means if weights is None else means * weights[:, None]
    solution = np.linalg.lstsq(weighted, scaled, rcond=None)[0]
    k = solution[:3].T
    if abs(np.linalg.det(k)) < 1e-6 * np.linalg.norm(k) ** 3:
        return None
    inverse = np.linalg.inv(weighted.T @ weighted)
    return Fit(*(np.asarray(one, dtype=np.float64) for one in (k, solution[3], inverse)))


def _design(forces: Floats) -> Floats:
    return np.hstack([forces, np.ones((len(forces), 1))])


def _nearest(felt: Floats, attitudes: Attitudes, allowed: float) -> tuple[Integers, Floats]:
    distances = np.linalg.norm(felt[:, None] - attitudes.forces, axis=-1)
    off = distances.min(axis=1)
    return np.where(off <= allowed, distances.argmin(axis=1), -1), off


def is_view_of(view: View, k: Floats) -> bool:
    """Does each channel feel its own axis most, and that way round?"""
    own = np.array([k[channel, axis] * sign for axis, (channel, sign) in enumerate(zip(view.channels, view.signs))])
    ordered = np.abs(k[list(view.channels)])
    np.fill_diagonal(ordered, 0.0)
    return bool((own > 0.0).all() and (ordered.max(axis=1) <= _CROSS * own).all())
