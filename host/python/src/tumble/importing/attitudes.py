"""What gravity says of a block at rest: its scales and biases, and from these the attitude of every rest.

At rest an accelerometer block measures a unit vector (g). So the outputs of all rests lie on an ellipsoid, which for a
block whose channels lie nearly along its axes has nearly the axes of the outputs: six unknowns, linear in the squares.
That leaves open which way round each channel is, and which channel belongs to which axis: a view. For each view the
attitudes are held against those of the schedule, and K and U0 are fitted, all twelve of them.

Nobody measures how far a block that is bolted on once is inclined, nor where the table has its zero then. So the
attitudes of one inclination move together to where the rests show them: two more unknowns each, fitted with the twelve.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.model.geometry import STEP, Geometry, geometry_of
from tumble.model.inclined import Inclinations
from tumble.schedule import Schedule

AXES = "xyz"
_SAME = 1e-6  # rad: attitudes closer than this are one
_LEAST_SINGULAR = 1e-2  # of the largest: below, the rests do not show it
_ROUGH = 0.45  # of the smallest angle between attitudes: how far off a first guess may be
_ROUNDS = 12
_SETTLED = 1e-9  # rad: inclinations that move less stay
_SQUARES = 6  # unknowns of an ellipsoid along the axes
_CROSS = 0.5  # of a channel's own axis: what it may feel of another
TWELVE = 12  # coefficients
_RANK = 4  # of the unit attitudes with a column of ones: K and U0 need as much

Channels = tuple[int, int, int]
Signs = tuple[int, int, int]
STRAIGHT: Channels = (0, 1, 2)


@dataclass(frozen=True)
class Attitudes:
    """Those of a schedule: `schedule` with a position for each; `forces` (attitudes, 3), unit vectors on the block's
    axes; `of_position` (positions,): which of them each position has; `apart`: the smallest angle between two, rad."""

    schedule: Schedule
    forces: Floats
    of_position: Integers
    apart: float

    def of_positions(self, schedule: Schedule) -> Attitudes:
        """The same with an attitude for each position of the schedule: two inclinations that should be alike are set
        each for itself."""
        return Attitudes(schedule, Geometry(schedule).force(), np.arange(len(schedule.positions)), self.apart)


@dataclass(frozen=True)
class View:
    """Which channel is along which axis (`channels`, of x, y and z), and which way round (`signs`)."""

    channels: Channels = STRAIGHT
    signs: Signs = (1, 1, 1)


@dataclass(frozen=True)
class Fit:
    """K (3, 3) and U0 (3,) of outputs at attitudes. `forces` (attitudes, 3): these, on the `inclinations` that were
    fitted as well, if any. `leverage` (attitudes,): how much of its own error a rest there takes into the fit, which
    has so many `unknowns`."""

    k: Floats
    u0: Floats
    forces: Floats
    leverage: Floats
    unknowns: int = TWELVE
    inclinations: Inclinations | None = None

    def attitudes(self, means: Floats) -> Floats:
        """What the block feels where it gives `means` (n, 3): (n, 3), g."""
        felt = np.linalg.solve(self.k, (means - self.u0).T).T
        return np.asarray(felt, dtype=np.float64)

    def at(self, attitudes: Integers) -> Fit:
        """The same at some of the attitudes, or at some of them more than once."""
        return replace(self, forces=self.forces[attitudes], leverage=self.leverage[attitudes])


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
    of_position, is_first = [], []
    for force in ideal:
        same = [index for index, known in enumerate(forces) if np.linalg.norm(known - force) < _SAME]
        of_position.append(same[0] if same else len(forces))
        is_first.append(not same)
        if not same:
            forces.append(force)
    stacked = np.array(forces)
    distances = np.linalg.norm(stacked[:, None] - stacked, axis=-1) + 4.0 * np.eye(len(stacked))
    apart = float(2 * np.arcsin(min(distances.min(), 2.0) / 2))
    return Attitudes(schedule.part(is_first), stacked, np.array(of_position), apart)


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
    nearest, off = _nearest(felt, attitudes.forces, allowed)
    fit = None
    for _ in range(_ROUNDS):
        near = nearest >= 0
        usual = max(float(np.median(off[near])), 1e-6) if near.any() else 1.0
        weights = 1.0 / np.sqrt(1.0 + (off[near] / (3.0 * usual)) ** 2)  # far off where others are near counts little
        fit = fitted(attitudes, nearest[near], means[near], weights)
        if fit is None or not is_view_of(view, fit.k):
            return None
        before = nearest
        nearest, off = _nearest(fit.attitudes(means), fit.forces, allowed)
        if (before == nearest).all() and allowed == tolerance:
            break
        allowed = tolerance
    return None if fit is None else Seen(view, fit, nearest, off)


def fitted(attitudes: Attitudes, at: Integers, means: Floats, weights: Floats | None = None) -> Fit | None:
    """K and U0 by least squares, from outputs (n, 3) at the attitudes `at` (n,), inclinations moved to where these show
    them; None where they do not tell K and U0."""
    root = np.ones(len(at)) if weights is None else weights
    plain = _linear(attitudes.forces, at, means, root)
    present = {attitudes.schedule.positions[one].mounting for one in at.tolist()}
    numbers = tuple(number for number in inclinations_of(attitudes.schedule) if number in present)
    if plain is None or not numbers:
        return plain
    tilts = np.deg2rad([one.tilt_deg for one in attitudes.schedule.mountings if one.number in numbers])
    moved, fit = np.zeros((2, len(numbers))), plain
    for _ in range(_ROUNDS):  # by Gauss and Newton
        found = Inclinations(numbers, tilts + moved[0], moved[1])
        inclined = _inclined(attitudes.schedule, found, moved, at, means, root)
        if inclined is None:
            return plain
        fit, step = inclined
        moved = moved + step
        if np.abs(moved).max() > _ROUGH * attitudes.apart:
            return plain  # as far off as another attitude: none of the schedule's inclinations
        if np.abs(step).max() < _SETTLED:
            break
    return fit


def _inclined(
    schedule: Schedule, found: Inclinations, moved: Floats, at: Integers, means: Floats, root: Floats
) -> tuple[Fit, Floats] | None:
    """The fit on these inclinations, which are `moved` from the schedule's, and how far they have to move on: (2,
    inclinations), beta and tau, rad; None where the rests do not tell K and U0 there. What they do not show stays: the
    zero of all angles together, which is in K, and inclinations where only two are."""
    geometry = geometry_of(schedule)
    by_mounting = np.array([[one.number == number for number in found.numbers] for one in schedule.mountings])
    of = by_mounting[geometry.mounting_index]
    steps = 1j * STEP * np.eye(2)[:, :, None]
    forces = geometry.force(alpha1=by_mounting @ moved[0] + steps[:, 0], delta=of @ moved[1] + steps[:, 1])
    fit = _linear(np.real(forces[0]), at, means, root)
    if fit is None:
        return None
    beta, tau = (by[:, :, None] * of[:, None, :] for by in np.imag(forces) / STEP)
    columns = np.concatenate([beta, tau], axis=2)  # (attitudes, 3, unknowns)
    design, weights = _design(fit.forces), root[:, None, None]
    explained = np.tensordot(np.linalg.pinv(root[:, None] * design[at]), weights * columns[at], 1)
    columns = columns - np.tensordot(design, explained, 1)  # by K and U0
    left, singular, right = np.linalg.svd((weights * columns[at]).reshape(3 * len(at), -1), full_matrices=False)
    shown = singular > _LEAST_SINGULAR * singular[0]
    inverse = right[shown].T / singular[shown]
    off = root[:, None] * (fit.attitudes(means) - fit.forces[at])
    step = (inverse @ (left[:, shown].T @ off.ravel())).reshape(2, -1)
    leverage = fit.leverage + ((columns @ inverse) ** 2).sum(axis=(1, 2)) / 3.0
    unknowns = TWELVE + int(shown.sum())
    return replace(fit, leverage=leverage, unknowns=unknowns, inclinations=found), step


def inclinations_of(schedule: Schedule) -> tuple[int, ...]:
    """The mountings that share a bolting with another one."""
    bolted = [one for one in schedule.mountings if one.bolting is not None]
    shared = Counter(one.bolting for one in bolted)
    return tuple(one.number for one in bolted if shared[one.bolting] > 1)


def _linear(forces: Floats, at: Integers, means: Floats, root: Floats) -> Fit | None:
    """K and U0 at known `forces`; each row weighs by its `root`."""
    design = _design(forces)
    weighted = design[at] * root[:, None]
    solution, _, _, singular = np.linalg.lstsq(weighted, means * root[:, None], rcond=None)
    if np.count_nonzero(singular > 1e-3 * len(weighted) ** 0.5) < _RANK:
        return None
    k = solution[:3].T
    if abs(np.linalg.det(k)) < 1e-6 * np.linalg.norm(k) ** 3:
        return None
    inverse = np.linalg.inv(weighted.T @ weighted)
    leverage: Floats = np.einsum("ni,ij,nj->n", design, inverse, design)
    return Fit(np.asarray(k, dtype=np.float64), np.asarray(solution[3], dtype=np.float64), forces, leverage)


def _design(forces: Floats) -> Floats:
    return np.hstack([forces, np.ones((len(forces), 1))])


def _nearest(felt: Floats, forces: Floats, allowed: float) -> tuple[Integers, Floats]:
    distances = np.linalg.norm(felt[:, None] - forces, axis=-1)
    off = distances.min(axis=1)
    return np.where(off <= allowed, distances.argmin(axis=1), -1), off


def is_view_of(view: View, k: Floats) -> bool:
    """Does each channel feel its own axis most, and that way round?"""
    own = np.array([k[channel, axis] * sign for axis, (channel, sign) in enumerate(zip(view.channels, view.signs))])
    ordered = np.abs(k[list(view.channels)])
    np.fill_diagonal(ordered, 0.0)
    return bool((own > 0.0).all() and (ordered.max(axis=1) <= _CROSS * own).all())
