"""The errors of a stand: one table of them, and what they do to the outputs of a run.

After the means everything is one linear problem,

    outputs = D beta + J s + noise

in which beta are the coefficients and s the errors of the stand, with the declared variances as their prior. J comes
from the exact geometry by complex steps. Sources are independent; what they bring adds in quadrature.

A new source of error is a row of stand.SOURCES and of EFFECTS, and an argument of Geometry.force if it turns the block
in a way of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.model.geometry import STEP, Geometry, geometry_of
from tumble.schedule import FIT, Schedule
from tumble.stand import COMMON, SOURCES, Stand, by_channel

NOISE = "noise"
OF_OUTPUTS = tuple(name for name, one in SOURCES.items() if not one.is_angle)  # their sizes are as outputs are

Units = Mapping[str, Floats]  # one unit of every draw (draws, ...), by argument of Geometry.force


def encoder_waves(schedule: Schedule) -> Floats:
    """What one unit of each number of the encoder adds to the table angle (4, positions): the sine and the cosine of
    the angle, and of its double."""
    turned = np.exp(1j * geometry_of(schedule).phi)
    return np.array([turned.imag, turned.real, (turned**2).imag, (turned**2).real])


def course(schedule: Schedule) -> Floats:
    """How far the run has come (positions,): from -1/2 at the first fit position to 1/2 at the last, by the same step
    from each to the next. A check position is half a step beyond the fit position before it."""
    fitted = np.array([position.use == FIT for position in schedule.positions])
    place = np.cumsum(fitted) - np.where(fitted, 1.0, 0.5)
    far: Floats = place / max(1, fitted.sum() - 1) - 0.5
    return far


ADDED = (
    "added"  # in place of an argument: what draws add to the outputs (draws, positions, 3), of which these are linear
)


def _each(geometry: Geometry) -> Floats:
    """A draw for every bolting of the block, by mounting."""
    one = np.eye(len(geometry.schedule.mountings))
    return np.array([one[list(bolting)].sum(axis=0) for bolting in geometry.schedule.boltings])


def _inclinations(schedule: Schedule) -> tuple[list[int], list[int]]:
    """Mountings, by their indices, that each have an inclination of their own, and a zero of the table angle that
    differs from that of the first one of their bolting."""
    used = {position.mounting for position in schedule.positions}
    found = ([one for one in bolting if schedule.mountings[one].number in used] for bolting in schedule.boltings)
    inclined = [bolting for bolting in found if len(bolting) > 1]
    return [one for bolting in inclined for one in bolting], [one for bolting in inclined for one in bolting[1:]]


def _by_inclination(geometry: Geometry) -> Units:
    one, (tilted, turned) = np.eye(len(geometry.schedule.mountings)), _inclinations(geometry.schedule)
    return {"alpha1": one[tilted], "seat_n": one[turned]}


def _set_at(schedule: Schedule) -> Floats:
    """Of every draw of `inclination`, where it would be had all been as it was set, rad."""
    tilted, turned = _inclinations(schedule)
    off = np.deg2rad([one.off_deg for one in schedule.mountings])
    at: Floats = -np.concatenate([off[tilted, 0], off[turned, 1]])
    return at


# By name, as stand.SOURCES: units of a source's draws on a schedule, with one yaw common to all mountings or not.
EFFECTS: dict[str, Callable[[Geometry, bool], Units]] = {
    "alpha1": lambda g, common: {"alpha1": np.ones((1, 1))},
    "alpha2": lambda g, common: {"alpha2": np.ones((1, 1))},
    "alpha3": lambda g, common: {"alpha3": np.ones((1, len(g.schedule.mountings))) if common else _each(g)},
    "alpha4": lambda g, common: {"delta": np.eye(len(g.phi))},
    NOISE: lambda g, common: {ADDED: np.eye(3 * len(g.phi)).reshape(-1, len(g.phi), 3)},
    "seat": lambda g, common: {"seat_h": _each(g), "seat_n": _each(g)},
    "platform": lambda g, common: {"seat_h": np.ones((1, 1))},
    "encoder": lambda g, common: {"delta": encoder_waves(g.schedule)},
    "drift": lambda g, common: {ADDED: course(g.schedule)[:, None] * np.eye(3)[:, None]},
    "inclination": lambda g, common: _by_inclination(g),
}


@dataclass(frozen=True)
class Draws:
    """Independent draws of one kind: `sigma` (draws,) standard deviations, `derivative` (draws, positions, 3) of the
    outputs with respect to each draw, `units` of each draw as Geometry.force takes them; none where the outputs
    are linear in it, as in noise and drift. `normal`: whatever law the stand declares. `mean` (draws,): None where it
    is 0. An infinite sigma is that of an unknown of which nothing is known."""

    sigma: Floats
    derivative: Floats
    units: Units = field(default_factory=dict)
    normal: bool = False
    mean: Floats | None = None


@dataclass(frozen=True)
class UnitEffect:
    """One unit of every draw of a source: `units`, and what the block feels of them: `force` (draws, positions, 3), g;
    without units what they add to its outputs."""

    units: Units
    force: Floats

    def derivative(self, k: Floats) -> Floats:
        """Of the outputs of a block of sensitivity `k` (3, 3): (draws, positions, 3)."""
        return self.force @ np.asarray(k).T if self.units else self.force


@lru_cache(512)
def unit_effect(schedule: Schedule, name: str, common: bool = False) -> UnitEffect:
    """What one unit of every draw of a source does, on the ideal stand."""
    geometry = geometry_of(schedule)
    units = EFFECTS[name](geometry, common)
    if ADDED in units:
        return UnitEffect({}, units[ADDED])
    force = np.concatenate([geometry.force_by(**{argument: unit}) for argument, unit in units.items()])
    starts = np.cumsum([0, *(len(unit) for unit in units.values())])
    whole = {}
    for start, (argument, unit) in zip(starts, units.items()):
        whole[argument] = np.zeros((starts[-1], unit.shape[1]))
        whole[argument][start : start + len(unit)] = unit
    return UnitEffect(whole, force)


def _there(stand: Stand, schedule: Schedule) -> dict[str, Floats]:
    """What a stand declares of every source that counts in a run of a schedule, in the order of SOURCES."""
    there = {name: one for name, one in SOURCES.items() if schedule.is_inclined or not one.of_inclinations}
    sizes = {name: by_channel(getattr(stand, one.attribute)) for name, one in there.items()}
    return {name: size for name, size in sizes.items() if there[name].required or size.any()}


def declared(stand: Stand, schedule: Schedule) -> tuple[str, ...]:
    """Names of the sources that uncertainties count, in the order of SOURCES."""
    return tuple(name for name, size in _there(stand, schedule).items() if np.isfinite(size).all())


def free(stand: Stand, schedule: Schedule) -> tuple[str, ...]:
    """Names of those that may have any size: unknowns, which an estimator that is good for them is not moved by."""
    return tuple(name for name, size in _there(stand, schedule).items() if not np.isfinite(size).all())


def sources(
    schedule: Schedule, k: Floats, stand: Stand, samples: Integers, mean_variance: Floats | None = None
) -> dict[str, Draws]:
    """Every source of error of a stand, by name.

    `k` (3, 3): the block's sensitivity. `samples` (positions,): rows of the run at each position, as
    Stand.averaged_over takes them. `mean_variance` (positions, 3): by the noise, as it was measured; it counts
    where it is larger than what the stand declares.
    """
    noise = stand.mean_sigma(stand.averaged_over(samples))
    if mean_variance is not None:
        noise = np.maximum(noise, np.sqrt(mean_variance))
    found = of_stand(schedule, k, stand, declared(stand, schedule))
    return {
        name: replace(one, sigma=noise.ravel(), normal=True) if name == NOISE else one for name, one in found.items()
    }


def of_stand(schedule: Schedule, k: Floats, stand: Stand, names: Iterable[str]) -> dict[str, Draws]:
    """Those of these names, whether declared or not; the noise of one sample."""
    found = {}
    for name in names:
        of = unit_effect(schedule, name, stand.remounting == COMMON)
        derivative, attribute = of.derivative(k), SOURCES[name].attribute
        sigma = stand.sigmas(attribute) if name in OF_OUTPUTS else np.array([stand.sigma(attribute)])
        mean = _set_at(schedule) if SOURCES[name].of_inclinations else None
        found[name] = Draws(np.resize(sigma, len(derivative)), derivative, of.units, mean=mean)
    return found


def places(found: Mapping[str, Draws]) -> dict[str, slice]:
    """Where each source has its draws, side by side in their order."""
    ends = np.cumsum([0, *(len(source.sigma) for source in found.values())])
    return {name: slice(start, end) for name, start, end in zip(found, ends, ends[1:])}


class Errors:
    """All draws of some sources side by side: their sizes are `x` (..., draws), in radians or as outputs are. `sigma`
    (draws,): of those that are `free` a radian, beside which any of them is small; `mean` (draws,)."""

    def __init__(self, schedule: Schedule, found: Mapping[str, Draws]):
        self.geometry, self.of = geometry_of(schedule), places(found)
        sigma = np.concatenate([np.zeros(0), *(source.sigma for source in found.values())])
        means = [np.zeros(len(one.sigma)) if one.mean is None else one.mean for one in found.values()]
        self.free = np.isinf(sigma)
        self.sigma = np.where(self.free, 1.0, sigma)
        self.mean = np.where(self.free, 0.0, np.concatenate([np.zeros(0), *means]))
        self._added = {name: source.derivative for name, source in found.items() if not source.units}
        self._units: dict[str, Floats] = {}
        for argument in dict.fromkeys(argument for source in found.values() for argument in source.units):
            parts = [(self.of[name], one.units[argument]) for name, one in found.items() if argument in one.units]
            self._units[argument] = np.zeros((len(self.sigma), max(unit.shape[1] for _, unit in parts)))
            for place, unit in parts:
                self._units[argument][place] = unit

    def arguments(self, x: Floats) -> dict[str, Floats]:
        """What Geometry.force takes; real or complex."""
        return {argument: x @ unit for argument, unit in self._units.items()}

    def force(self, x: Floats) -> Floats:
        """Specific force on the exact geometry (..., positions, 3), g."""
        return self.geometry.force(**self.arguments(x))

    def added(self, x: Floats) -> Floats | float:
        """What errors add to the outputs (..., positions, 3), of which these are linear."""
        return sum(np.tensordot(x[..., self.of[name]], unit, axes=1) for name, unit in self._added.items())

    def outputs(self, k: Floats, u0: Floats, x: Floats) -> Floats:
        """Outputs (..., positions, 3) of one block, or of each its own: `k` (..., 3, 3), `u0` (..., 3)."""
        outputs: Floats = self.force(x) @ np.swapaxes(k, -1, -2) + u0[..., None, :] + self.added(x)
        return outputs

    def derivative(self, k: Floats, x: Floats) -> Floats:
        """Of the outputs by every error at `x` (draws,): (draws, positions, 3)."""
        each = np.eye(len(x))
        by_error: Floats = np.imag(self.force(x + 1j * STEP * each)) / STEP @ np.asarray(k).T + self.added(each)
        return by_error


def exact_outputs(schedule: Schedule, k: Floats, u0: Floats, found: Mapping[str, Draws], draws: Floats) -> Floats:
    """Outputs (runs, positions, 3) of the exact geometry for `draws` (runs, all draws of the sources in their order),
    in units of their standard deviations."""
    errors = Errors(schedule, found)
    return errors.outputs(np.asarray(k), np.asarray(u0), draws * errors.sigma)


ToUnknowns = Callable[[Floats], Floats]  # what a linear estimate makes of means: (draws, positions, 3) to (draws, n)


def brought(to_unknowns: ToUnknowns, found: Mapping[str, Draws]) -> dict[str, Floats]:
    """What one standard deviation of each draw brings to a linear estimate: by source, rows sigma G J (draws, n)."""
    return {name: to_unknowns(source.derivative) * source.sigma[:, None] for name, source in found.items()}


def covariance_of(to_unknowns: ToUnknowns, found: Mapping[str, Draws]) -> Floats:
    """Covariance (n, n) that all sources together bring to it: G J diag(sigma^2) (G J)^T."""
    draws = np.concatenate(list(brought(to_unknowns, found).values()))
    product: Floats = draws.T @ draws
    return (product + product.T) / 2.0


def by_gains(schedule: Schedule, gains: Floats) -> ToUnknowns:
    """An estimate by gains G (n, 3 x fit positions), of means of all positions of a schedule."""
    fit = schedule.fit_indices

    def to_unknowns(means: Floats) -> Floats:
        found: Floats = means[:, fit].reshape(len(means), -1) @ gains.T
        return found

    return to_unknowns


def by_coefficient(covariance: Floats) -> tuple[Floats, Floats]:
    """u_K (3, 3) and u_U0 (3,) of a covariance of the twelve coefficients, and of further unknowns behind them."""
    u = np.sqrt(np.diag(covariance))
    return u[:9].reshape(3, 3), u[9:12]
