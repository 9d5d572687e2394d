"""The stand seen in the data: what a run tells about angles and noise of the stand, each with its uncertainty."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.core import MAX_STAND_ERROR_RAD, MAX_YAWS
from tumble.reference.stand_seen import ANGLES, Estimate, RunSeen
from tumble.stand import Stand

NAMES = {  # of what is seen, for people
    "alpha1_rad": "axis tilt",
    "alpha2_plus_alpha3_rad": "level + yaw",
    "alpha3_difference_rad": "yaw change",
    "alpha4_rad": "set angle",
    "noise_v": "noise",
}
_FARTHEST = 1e5  # rows of K, as their noise makes them alike, from one another


Quantity = Estimate  # with its standard uncertainty


@dataclass(frozen=True)
class StandSeen:
    """Angles in rad, noise of one sample in the unit of the outputs; an entry None is what the run cannot tell. Each
    has `value` and `u`.

    `angles`: by the closed form; `augmented`: by least squares for everything at once; both by name as in ANGLES, with
    the uncertainty of `source` ("stand": as declared; "run": of this run's own scatter and residuals, `freedom`
    degrees of freedom; None: unknown, and u is 0). `other_yaw_changes`: by mounting, from the third on, the yaw of the
    first less that of this one, as `augmented`. `alpha4`: standard deviation of a set angle, with `alpha4_freedom`.
    """

    noise: Quantity | None
    alpha4: Quantity | None
    alpha4_freedom: float
    angles: Mapping[str, Quantity | None]
    augmented: Mapping[str, Quantity | None]
    source: str | None
    other_yaw_changes: Mapping[int, Quantity | None] = field(default_factory=dict)

    @property
    def freedom(self) -> float | None:
        """Degrees of freedom of the angles' uncertainties; None for those of a declared stand."""
        return self.alpha4_freedom if self.source == "run" else None


def look(
    run: RunSeen,
    noise: Quantity | None,
    samples: Integers,
    stand: Stand | None,
    trust_stand: bool = True,
    mean_variance: Floats | None = None,
) -> StandSeen:
    """What a `run` shows; `noise`: pooled (None: unknown). `samples` (positions,) of those measured; `stand` in the
    unit of the outputs; `mean_variance` (positions, 3): of the means as their own samples show it, counts where it is
    more than white noise leaves.

    Channels of which the stand declares different noise are made alike by its weights first: `run` was made with these,
    `noise` is that of the noisiest channel, each having been held against its own.

    Free attitudes show the noise alone: poses without a turn of one table, or more mountings than the core has yaws
    for. So do outputs so far from those of any stand that no small angles explain them, such as those of exchanged
    mountings: the angles are linear theory, and its figures would be rounding. A stand that is not to be
    trusted gives no uncertainties, except where the run itself has none to give.
    """
    if run.mountings > MAX_YAWS or not run.has_turns or run.departure > MAX_STAND_ERROR_RAD:
        return StandSeen(noise, None, 0.0, dict.fromkeys(ANGLES), dict.fromkeys(ANGLES), None)
    own = own_variance(noise, samples, stand, mean_variance)
    error = None if own is None else run.angle_error(own)
    alpha4 = None if error is None else error.seen
    if stand is not None and (trust_stand or alpha4 is None):
        source, sigma = "stand", stand.sigma("angle")
        variance = _at_least(_declared(stand, samples), mean_variance, stand)
    elif alpha4 is not None and own is not None:
        source, sigma, variance = "run", alpha4.value, own
    else:
        angles = run.angles(None, np.zeros(len(samples)))
        return StandSeen(noise, None, 0.0, angles, dict.fromkeys(ANGLES), None)
    freedom = 0.0 if error is None or alpha4 is None else error.freedom
    found = run.angles(sigma, variance), run.fit(sigma, variance), source, run.other_yaw_changes(sigma, variance)
    return StandSeen(noise, alpha4, freedom, *found)


def averaged_over(samples: Integers, stand: Stand | None) -> Integers:
    """How many samples each mean has."""
    return np.maximum(samples, 1) if stand is None else stand.averaged_over(samples)


def own_variance(
    noise: Quantity | None, samples: Integers, stand: Stand | None, mean_variance: Floats | None = None
) -> Floats | None:
    """Variance (positions,) of each mean by the noise that the run shows, else by the declared one, of channels made
    alike; None where neither is known. Arguments as of `look`."""
    if noise is not None:
        return _at_least(noise.value**2 / averaged_over(samples, stand), mean_variance, stand)
    return None if stand is None else _declared(stand, samples)


def weights_of(stand: Stand | None) -> Floats:
    """What makes the channels of a stand alike (3,): outputs and their scatter times these."""
    return np.ones(3) if stand is None else stand.weights


def stand_to_look_with(stand: Stand, k: Floats) -> Stand:
    """The stand, but with the same noise in every channel where its weights leave rows of `k` that are too far apart:
    the outputs are no such channels then, as if one had another unit, and the angles would hang on last bits."""
    rows = np.linalg.norm(k, axis=1) * stand.weights
    return stand if rows.max() <= _FARTHEST * rows.min() else stand.with_sigma("noise", stand.sigmas("noise").max())


def _declared(stand: Stand, samples: Integers) -> Floats:
    variance: Floats = stand.mean_variance(samples).max(axis=1)
    return variance


def _at_least(white: Floats, mean_variance: Floats | None, stand: Stand | None) -> Floats:
    """One variance for all channels of a position, made alike, as the noise is pooled over them."""
    alike = None if mean_variance is None else mean_variance * weights_of(stand) ** 2
    if alike is None or not (alike > white[:, None]).any():
        return white
    both: Floats = np.maximum(white[:, None], alike).mean(axis=1)
    return both


@dataclass(frozen=True)
class ChannelNoise:
    """Of one sample, by channel: standard deviations `values` (3,), of so many degrees of `freedom` each, beside those
    `declared` (3,), all in volts, or in the outputs' own unit where that is no multiple of it."""

    values: Floats
    freedom: int
    declared: Floats

    @property
    def u(self) -> Floats:
        """Standard uncertainties (3,)."""
        return self.values * self._relative_u

    @classmethod
    def pooled(cls, runs: Iterable[ChannelNoise | None]) -> ChannelNoise | None:
        """That of several runs on one stand; None where none shows it."""
        shown = [one for one in runs if one is not None]
        freedom = sum(one.freedom for one in shown)
        squares = sum((one.freedom * one.values**2 for one in shown), np.zeros(3))
        return cls(np.sqrt(squares / freedom), freedom, shown[0].declared) if shown else None

    def sentence(self, unit: str) -> str:
        """For people."""
        seen = ", ".join(f"{axis} {value:.2e}" for axis, value in zip("xyz", self.values))
        declared = ", ".join(f"{sigma:.2e}" for sigma in self.declared)
        return f"{seen} {unit}, each +- {100.0 * self._relative_u:.2g} %; declared {declared}"

    @property
    def _relative_u(self) -> float:
        return float((2.0 * self.freedom) ** -0.5)


def document(seen: StandSeen, volts_per_unit: float, channels: ChannelNoise | None) -> dict[str, Any]:
    """As it stands in a result: every quantity with its `u_` twin. `channels`: where the stand declares three."""
    has_u = seen.source is not None
    augmented = {key: value for name in ANGLES for key, value in _pair(f"{name}_rad", seen.augmented[name]).items()}
    others = [
        {"mounting": mounting, **_pair("alpha3_difference_rad", change)}
        for mounting, change in seen.other_yaw_changes.items()
    ]
    listed = [_pair(f"{name}_rad", seen.angles[name], has_u) for name in ANGLES]
    listed += [_pair("alpha4_rad", seen.alpha4), _pair("noise_v", seen.noise, factor=volts_per_unit)]
    return {
        **{key: value for pair in listed for key, value in pair.items()},
        "noise_v_by_channel": None if channels is None else channels.values.tolist(),
        "u_noise_v_by_channel": None if channels is None else channels.u.tolist(),
        "u_from": seen.source,
        "u_freedom": seen.freedom,
        "alpha4_freedom": None if seen.alpha4 is None else seen.alpha4_freedom,
        "augmented": None if set(augmented.values()) == {None} else {**augmented, "other_yaw_changes": others},
    }


def _pair(name: str, seen: Quantity | None, has_u: bool = True, factor: float = 1.0) -> dict[str, float | None]:
    value, u = (None, None) if seen is None else (seen.value * factor, seen.u * factor)
    return {name: value, f"u_{name}": u if has_u else None}
