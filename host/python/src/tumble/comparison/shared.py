"""One of two calibrations that are compared: its coefficients, and the parameters that stay when the block turns.

A block that sits turned by a small vector phi has K (I + [phi]x) in place of K: the lengths of K's rows, the angles
between them and U0 stay. These nine, and three angles of the seat, are the twelve coefficients in other words.

What two calibrations have in common by the stand that both were measured on.

A result states the covariance of all errors together. The declared stand tells them apart, and fixture.combination
which of them return with every run; they are propagated as the solve did it, on the schedule of each result. Stand and
schedule are not taken on trust: all sources together must give the covariance that the result states.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Floats
from tumble.core import MAX_SAMPLES, CoreRefusal, CoreSchedule
from tumble.defaults import ONCE
from tumble.documents.result import Result
from tumble.errors import UsageError
from tumble.estimators import ESTIMATORS
from tumble.fixture.judge import repeats
from tumble.model.coefficients import PAIRS, by_intrinsic
from tumble.model.propagation import Propagation
from tumble.schedule import Schedule
from tumble.solving.coefficients import POWERS_OF_TWELVE
from tumble.solving.result import schedule_of
from tumble.stand import SOURCES, PerChannel, Stand, over
from tumble.terms import POWERS, Terms, names
from tumble.units import volts_per

NAMES = (
    *(f"scale_{axis}" for axis in "xyz"),
    *(f"angle_{pair}" for pair in ("xy", "xz", "yz")),
    *(f"bias_{axis}" for axis in "xyz"),
)
UNITS = ("ppm",) * 3 + ("urad",) * 3 + ("ug",) * 3
_UNITS_OF_TERMS = {"k2": "ug/g^2", "k3": "ug/g^3"}


@dataclass(frozen=True)
class Calibration:
    """`values` (12 + 3 x terms,): K row by row, U0, then K2 and K3 as far as they are in `terms`, in the unit of the
    outputs and g. Their `covariance`, None where it is unknown: all of it, or without `in_common`, (draws, 12 + 3 x
    terms): errors that the other calibration has as well, draw by draw, one standard deviation of each."""

    values: Floats
    covariance: Floats | None
    terms: Terms = ()
    in_common: Floats | None = None

    @property
    def k(self) -> Floats:
        """K (3, 3)."""
        return self.values[:9].reshape(3, 3)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Of `parameters`."""
        return NAMES + names(self.terms)

    @property
    def parameter_units(self) -> tuple[str, ...]:
        """Of a millionth of each parameter."""
        return UNITS + tuple(_UNITS_OF_TERMS[term] for term in self.terms for _ in "xyz")

    @property
    def parameters(self) -> Floats:
        """What does not depend on the seat (9 + 3 x terms,): the logarithms of the lengths of K's rows, so that a
        difference is a relative one, the angles between the rows xy, xz, yz in rad, U0 over the lengths in g; K2 and
        K3."""
        length = np.linalg.norm(self.k, axis=1)
        axis = self.k / length[:, None]
        angles = [np.arctan2(np.linalg.norm(np.cross(axis[i], axis[j])), axis[i] @ axis[j]) for i, j in PAIRS]
        return np.concatenate([np.log(length), angles, self.values[9:12] / length, self.values[12:]])

    @property
    def by_values(self) -> Floats:
        """Derivatives of `parameters` by `values`, (9 + 3 x terms, 12 + 3 x terms)."""
        found = np.zeros((len(self.values) - 3, len(self.values)))
        found[:9, :12] = by_intrinsic(self.k, self.values[9:12])
        found[:3] /= np.linalg.norm(self.k, axis=1)[:, None]
        found[9:, 12:] = np.eye(len(self.values) - 12)
        return found

    def reduced(self, terms: Terms) -> Calibration:
        """With these of its terms alone."""
        kept = [*range(12), *(12 + 3 * self.terms.index(term) + axis for term in terms for axis in range(3))]
        covariance = None if self.covariance is None else self.covariance[np.ix_(kept, kept)]
        in_common = None if self.in_common is None else self.in_common[:, kept]
        return Calibration(self.values[kept], covariance, terms, in_common)

    def at_gravity(self, ratio: float) -> Calibration:
        """For accelerations in units of another gravity, so many times that of its own place."""
        factor = ratio**self.powers
        covariance = None if self.covariance is None else factor[:, None] * self.covariance * factor
        in_common = None if self.in_common is None else self.in_common * factor
        return replace(self, values=self.values * factor, covariance=covariance, in_common=in_common)

    @property
    def powers(self) -> Floats:
        """Of the gravity in `values`."""
        return np.concatenate([POWERS_OF_TWELVE, np.repeat([POWERS[term] - 1.0 for term in self.terms], 3)])


_AGREEMENT = 1e-5  # of the standard uncertainties, in any direction: more than two computations differ by
_SAME = 1e-9  # relative: two ways of writing one standard deviation differ by less


@dataclass(frozen=True)
class OneStand:
    """That both results were measured on: what is declared of it, the step of the converter (None: not known), the
    `schedules` that a result was measured by that does not tell its own, and whether it was `levelled` once for both or
    anew. `label`: what a person calls it. Of its `stand`, what is each run's own is as the result itself declares it,
    where it does."""

    label: str
    stand: Stand
    step_v: PerChannel | None
    schedules: Sequence[CoreSchedule]
    levelled: str


def is_one(a: Stand, b: Stand) -> bool:
    """Whether two declarations may be of one stand: by the standard deviations of its axis and table, however these are
    written (`limits`). How many samples were averaged, noise, drift, and how the block was mounted are of each run and
    its block."""
    told = [source.attribute for source in SOURCES.values() if source.identifies]
    return all(math.isclose(a.sigma(source), b.sigma(source), rel_tol=_SAME) for source in told)


@dataclass(frozen=True)
class Told:
    """A result's own: its `name` and `document`, its `calibration` with K2 and K3, and the `terms` that it was solved
    with, drift among them."""

    name: str
    document: Result
    calibration: Calibration
    terms: Terms


Draws = dict[str, Floats]  # by source: (draws, 12 + 3 x terms), one standard deviation of each


@dataclass(frozen=True)
class Apart:
    """The covariance of a calibration in two: its `own`, and what `returns` with every run."""

    own: Floats
    returns: Draws


def told_apart(told: Told, one_stand: OneStand) -> Apart | None:
    """By the first schedule with which the stand explains the covariance; None where none does. Raises BadInput for a
    result whose own schedule is none."""
    schedule = schedule_of(told.document, told.name)
    for one in one_stand.schedules if schedule is None else [schedule]:
        found = _by_source(told, one_stand, one.data)
        beyond = None if found is None else _beyond(told, found, one_stand.step_v is not None)
        if found is not None and beyond is not None:
            once = one_stand.levelled == ONCE
            returns = {name: draws for name, draws in found.items() if repeats(name, once)}
            own = [draws.T @ draws for name, draws in found.items() if name not in returns]
            return Apart(sum(own, beyond), returns)
    return None


def _by_source(told: Told, one_stand: OneStand, schedule: Schedule) -> Draws | None:
    """None for a schedule that has other positions, or that this estimator cannot solve."""
    unit = told.document.unit
    samples = {(one.mounting, one.position, one.use): one.samples for one in told.document.means}
    places = [(position.mounting, position.number, position.use) for position in schedule.positions]
    if not samples or not samples.keys() <= set(places) or not all(0 < one <= MAX_SAMPLES for one in samples.values()):
        return None
    if told.document.estimator not in ESTIMATORS:
        return None
    part = schedule.part([place in samples for place in places])
    rows = np.array([samples[place] for place in places if place in samples])
    declared = one_stand.stand.beside(told.terms).in_unit(unit)
    step = over(one_stand.step_v or 0.0, volts_per(unit))
    given = Propagation(part, told.calibration.k, declared, rows, told.document.estimator, step, told.terms)
    try:
        return {name: _of_values(told, draws) for name, draws in given.brought().items()}
    except (CoreRefusal, UsageError, np.linalg.LinAlgError):
        return None


def _of_values(told: Told, sizes: Floats) -> Floats:
    """What draws bring to the calibration's values, by what they bring to the coefficients and to the sizes of all
    terms: a size is K_ii times K2. A drift is none of the values."""
    k, found = np.diag(told.calibration.k), [sizes[:, :12]]
    for place, term in enumerate(told.calibration.terms):
        value = told.calibration.values[12 + 3 * place : 15 + 3 * place]
        start = 12 + 3 * told.terms.index(term)
        found.append((sizes[:, start : start + 3] - value * sizes[:, [0, 4, 8]]) / k)
    return np.concatenate(found, axis=1)


def _beyond(told: Told, draws: Draws, knows_step: bool) -> Floats | None:
    """What the covariance that was stated has beyond these draws: noise that the run showed beyond the declared one, or
    steps of a converter that nobody tells. None where these draws cannot make it up."""
    stated = told.calibration.covariance
    assert stated is not None  # as the caller has seen to
    u = np.sqrt(np.diag(stated))
    if not (u > 0.0).all():
        return None
    scaled = np.concatenate(list(draws.values())) / u
    variance, directions = np.linalg.eigh(stated / np.outer(u, u) - scaled.T @ scaled)
    noise = told.document.noise
    is_told = noise is not None and not noise.above_declared and not noise.undithered
    if variance[0] < -_AGREEMENT or (knows_step and is_told and variance[-1] > _AGREEMENT):
        return None
    columns = directions * u[:, None]
    found: Floats = (columns * np.where(variance > _AGREEMENT, variance, 0.0)) @ columns.T
    return found
