"""What a stand is declared to be, as plain data."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from typing import Any

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.schedule import mark_of
from tumble.terms import DRIFT, Terms
from tumble.units import volts_per

INDEPENDENT = "independent"
COMMON = "common"

SIGMA = "sigma1"  # of `limits`: standard deviations
_SIGMAS_PER_LIMIT = {SIGMA: 1.0, "sigma3": 3.0, "uniform": math.sqrt(3.0)}
LIMIT_KINDS = tuple(_SIGMAS_PER_LIMIT)


LARGEST_ERROR_RAD = 0.1  # beyond it nothing is linear
MOST_YAWS = 6  # mountings, where each has unknowns of its own; both as the core has them

PerChannel = float | tuple[float, float, float]  # one number for all channels, or one for each

ALWAYS, LEVELLED = "always", "levelled"  # an error returns with every run, or until the stand is levelled anew


@dataclass(frozen=True)
class Source:
    """A source of error that a stand declares: `attribute` of Stand, `key` of a stand file and of documents, `words`
    for people. `required`: every stand file has it. `returns`: when an error comes back in the next run; None: each run
    has its own. `identifies`: two declarations that differ by it are of two stands. `patterns`: of a run that does not
    fit, those that it takes upon itself. `of_inclinations`: only a block that is bolted on once and inclined feels it;
    where nothing is declared it may have any size."""

    attribute: str
    key: str
    words: str
    required: bool = False
    returns: str | None = None
    identifies: bool = False
    patterns: tuple[str, ...] = ()
    of_inclinations: bool = False

    @property
    def undeclared(self) -> float:
        """What a stand has that does not declare it."""
        return math.inf if self.of_inclinations else 0.0

    @property
    def is_angle(self) -> bool:
        """In radians, and not as outputs are."""
        return self.key.endswith("_rad")


SOURCES = {  # by name, as documents have it, in the order in which random numbers are drawn for them
    "alpha1": Source("axis_tilt", "axis_tilt_rad", "Axis not level", True, LEVELLED, identifies=True),
    "alpha2": Source("level", "level_rad", "Zero of the table angle", True, LEVELLED, identifies=True),
    "alpha3": Source("remount", "remount_rad", "Yaw of the block, in a mounting", True),
    "alpha4": Source("angle", "angle_rad", "A set table angle", True, identifies=True),
    "noise": Source("noise", "noise_v", "Noise of one sample", True),
    "seat": Source("seat", "seat_rad", "Seat not square, in a mounting", patterns=("seat",)),
    "platform": Source("platform", "platform_rad", "Platform not square", False, ALWAYS, True, ("seat",)),
    "encoder": Source(
        *("encoder", "encoder_rad", "Encoder, once and twice per turn", False, ALWAYS, True),
        patterns=("once_per_turn", "twice_per_turn"),
    ),
    "drift": Source("drift", "drift_v", "Drift over a run", patterns=("drift",)),
    "inclination": Source(
        *("inclination", "inclination_rad", "A set inclination"), patterns=("inclination_rad",), of_inclinations=True
    ),
}
PER_CHANNEL = tuple(one.attribute for one in SOURCES.values() if not one.is_angle)
_LEAST_NOISE = 1e-4  # of the largest: a channel without noise has a weight too, and not one that hides the others


def by_channel(value: PerChannel | Sequence[float] | Floats) -> Floats:
    """What each channel has (3,)."""
    return np.broadcast_to(np.asarray(value, dtype=float), 3).copy()


def per_channel(values: Floats) -> PerChannel:
    """The shortest form of what each channel has (3,): one number if they are alike."""
    x, y, z = values.tolist()
    return x if x == y == z else (x, y, z)


def over(value: PerChannel, divisor: float) -> PerChannel:
    """The value in another unit."""
    return per_channel(by_channel(value) / divisor)


def rounding_of(step: PerChannel | Floats) -> Floats:
    """Standard deviations (3,) that rounding to a `step` leaves of one sample."""
    rounding: Floats = np.abs(by_channel(step)) / math.sqrt(12.0)
    return rounding


def rounds_alike(noise: Floats, step: PerChannel | Floats) -> Flags:
    """In which channels (3,) all samples of a position round alike, so that no averaging helps: `noise`, standard
    deviations, is under half a `step` of the converter."""
    alike: Flags = noise < np.abs(by_channel(step)) / 2.0
    return alike


@dataclass(frozen=True)
class Stand:
    """Errors of a stand as declared: angles in radians, noise of one sample and drift in V or as `in_unit` made them,
    all >= 0; noise and drift are one number for all channels, or three. 0: not declared, but for inclinations.

    Parameters
    ----------
    axis_tilt : float
        The axis is not level (alpha1).
    level : float
        Zero of the table angle (alpha2).
    remount : float
        Yaw of the block on the platform (alpha3).
    angle : float
        Error of a set table angle (alpha4).
    noise : float or three
        Of one sample.
    samples : int
        How many samples a mean has when a run gives only the mean.
    limits : str
        What the numbers are, one of LIMIT_KINDS: standard deviations, three of them, or half-widths of a uniform law.
    remounting : str, optional
        Key remount: is the yaw drawn anew in every mounting ("independent"), or "common" to all?
    name : str, optional
        For people.
    seat : float, optional
        How far each mounting tilts the block against the axis, and adds to the table angle.
    platform : float, optional
        How far the platform tilts it against the axis, the same in all mountings and runs.
    encoder : float, optional
        Of the table angle, by its sine, cosine, and sine and cosine of its double, four numbers of this size for the
        stand.
    drift : float or three, optional
        Of every channel, from the first fitted position of a run to the last.
    inclination : float, optional
        Of a set inclination, and of the zero of the table angle with it; infinite: nobody knows, and a run finds them.
    rounding : float or three, optional
        Standard deviation, whatever `limits` says, that a converter leaves in every mean, however many its samples; a
        plan knows it, a run shows it.
    """

    axis_tilt: float
    level: float
    remount: float
    angle: float
    noise: PerChannel
    samples: int
    limits: str
    remounting: str = INDEPENDENT
    name: str = ""
    seat: float = 0.0
    platform: float = 0.0
    encoder: float = 0.0
    drift: PerChannel = 0.0
    inclination: float = math.inf
    rounding: PerChannel = 0.0

    @property
    def limits_over_sigma(self) -> float:
        """What the numbers are in standard deviations."""
        return _SIGMAS_PER_LIMIT[self.limits]

    @property
    def declares_seat(self) -> bool:
        """Whether anything is said of how square the block sits."""
        return self.seat > 0.0 or self.platform > 0.0

    @property
    def declares_drift(self) -> bool:
        """Whether any channel may drift."""
        return bool(by_channel(self.drift).any())

    @property
    def weights(self) -> Floats:
        """What makes the noise of every channel as large as the largest (3,): outputs times these are those of channels
        that are alike. 1 where they are."""
        noise = by_channel(self.noise)
        largest = noise.max()
        return largest / np.maximum(noise, _LEAST_NOISE * largest) if largest > 0.0 else np.ones(3)

    def profile(self, source: str) -> Floats:
        """How "noise", of a mean, or "drift" of the channels (3,) compares with that of the channel that has most."""
        sigmas = self.mean_sigma(self.samples) if source == "noise" else self.sigmas(source)
        largest = sigmas.max()
        return sigmas / largest if largest > 0.0 else np.ones(3)

    def in_unit(self, unit: str) -> Stand:
        """This stand with its noise and drift in the unit of a run's outputs."""
        volts = volts_per(unit)
        by_unit: dict[str, Any] = {name: over(getattr(self, name), volts) for name in (*PER_CHANNEL, "rounding")}
        return replace(self, **by_unit)

    def without(self, terms: Terms) -> Stand:
        """This stand without what further `terms` of a model have as unknowns, whatever its size: its drift."""
        return replace(self, drift=0.0) if DRIFT in terms else self

    @property
    def of_any_pose(self) -> Stand:
        """This stand where nobody knows how the block lies: of its angles nothing is known, in any pose."""
        none: dict[str, Any] = {one.attribute: 0.0 for one in SOURCES.values() if one.is_angle}
        return replace(self, **{**none, "inclination": math.inf, "seat": math.inf})

    def with_step(self, step: PerChannel) -> Stand:
        """This stand with the noise that one sample really has: no less than a converter of this `step` (0: unknown),
        in the unit of the noise, leaves by rounding; step/sqrt(12) as a standard deviation."""
        noise, rounding = by_channel(self.noise), rounding_of(step) * _SIGMAS_PER_LIMIT[self.limits]
        return self if (noise >= rounding).all() else replace(self, noise=per_channel(np.maximum(noise, rounding)))

    def planned_with(self, step: PerChannel) -> Stand:
        """The same before a run: where samples will round alike, rounding counts undivided beside the noise, as a run
        that shows it counts it."""
        alike = rounds_alike(self.sigmas("noise"), step)
        return replace(self.with_step(step), rounding=per_channel(np.where(alike, rounding_of(step), 0.0)))

    def mean_sigma(self, samples: float | Integers) -> Floats:
        """Standard deviations (..., 3) of means of so many `samples` (...) by noise and rounding."""
        by_noise = self.sigmas("noise") / np.sqrt(np.asarray(samples))[..., None]
        sigmas: Floats = np.hypot(by_noise, by_channel(self.rounding))
        return sigmas

    def mean_variance(self, rows: Integers) -> Floats:
        """Variance (positions, 3) of the mean of each position of a run by the noise, as averaged_over takes `rows`."""
        variance: Floats = self.sigmas("noise") ** 2 / self.averaged_over(rows)[:, None]
        return variance + by_channel(self.rounding) ** 2

    def averaged_over(self, rows: Integers) -> Integers:
        """How many samples the mean of each position of a run has, by its `rows`. If no position has more than one, the
        rows are means of the stand's `samples`; a lone row among many is one sample."""
        return np.where(rows > 1, rows, self.samples if rows.max(initial=0) <= 1 else 1)

    @property
    def set_angle(self) -> float:
        """Standard deviation of the angle at a mark, with the errors of the encoder: two waves, of two numbers each."""
        return math.hypot(self.sigma("angle"), math.sqrt(2.0) * self.sigma("encoder"))

    def sigma(self, source: str) -> float:
        """Standard deviation of an angle, named by its attribute, such as "axis_tilt"."""
        limit: float = getattr(self, source)
        return limit / _SIGMAS_PER_LIMIT[self.limits]

    def sigmas(self, source: str) -> Floats:
        """Standard deviations (3,) of "noise" or "drift", by channel."""
        sigmas: Floats = by_channel(getattr(self, source)) / _SIGMAS_PER_LIMIT[self.limits]
        return sigmas

    def with_sigma(self, source: str, sigma: PerChannel) -> Stand:
        """This stand with another standard deviation of a source."""
        limit = per_channel(by_channel(sigma) * _SIGMAS_PER_LIMIT[self.limits])
        changed: dict[str, Any] = {source: limit}
        return replace(self, **changed)


@dataclass(frozen=True)
class SetAngles:
    """What the marks of a table are known to be off by.

    Parameters
    ----------
    learned, expires : str
        Days, as 2026-11-30: until the end of the second the errors count as those of the stand.
    runs : int
        That they were learnt from.
    angles_deg, errors, u : tuple of float
        Of every mark the angle that is set, and the error of the angle that the table comes to, with its standard
        uncertainty, rad.
    repeatability, u_repeatability : float
        Standard deviation with which the table comes to a mark again, and its standard uncertainty, rad.
    """

    learned: str
    expires: str
    runs: int
    angles_deg: tuple[float, ...]
    errors: tuple[float, ...]
    u: tuple[float, ...]
    repeatability: float
    u_repeatability: float

    @property
    def by_mark(self) -> dict[float, float]:
        """The errors, by the mark of the table."""
        return dict(zip(map(mark_of, self.angles_deg), self.errors))

    def left_on(self, stand: Stand, mountings: int) -> Stand:
        """A stand whose set angles are corrected: what is left of their error, and what the marks have in common, which
        adds to the zero of the table angle. A mark's error returns in each of so many `mountings`, so that in the
        worst case it counts as often."""
        anew = math.hypot(self.repeatability, self.u_repeatability)
        left = math.hypot(anew, max(self.u) * math.sqrt(mountings))
        common = stand.set_angle / math.sqrt(len(self.u))
        level = math.hypot(stand.sigma("level"), common)
        return stand.with_sigma("angle", left).with_sigma("encoder", 0.0).with_sigma("level", level)


def _with_keys(plain: Callable[..., None]) -> Callable[..., None]:
    """The constructor, which also takes the keys of stand files, units in their names."""
    attributes = {one.key: one.attribute for one in SOURCES.values()}

    @wraps(plain)
    def init(self: Stand, *args: Any, **given: Any) -> None:
        named = {attributes.get(name, name): value for name, value in given.items()}
        if len(named) < len(given):
            raise TypeError(f"Stand: one of {', '.join(given)} is given twice")
        plain(self, *args, **named)

    return init


Stand.__init__ = _with_keys(Stand.__init__)  # type: ignore[method-assign]

PAPER_STAND = Stand(  # equation (5)
    axis_tilt=2e-5,
    level=2e-5,
    remount=4e-4,
    angle=4e-5,
    noise=3e-4,
    samples=50,
    limits="sigma1",
    name="single-axis rotary stand of the paper",
)
