"""The stand as a run shows it: what the outputs tell of its angles and its noise, each with its uncertainty.

The closed form, of the paper's positions alone:

    v = K^-1 (U1_0 - U2_0)          alpha1 = (v_y - v_z)/2
    w = K^-1 (K2_.x - K1_.x)        w_y = alpha2 + alpha3 of mounting 1,  w_z = alpha2 + alpha3 of mounting 2

and, of any positions, dense least squares for coefficients, angles and the error of every set angle together, the
latter with their variance as prior. alpha2 and alpha3 cannot be told apart in the paper's mountings: alpha2 = -alpha3
is a rotation of the block's own frame.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.model.errors import unit_effect
from tumble.model.estimators import design, functionals, paper_slots
from tumble.schedule import Schedule
from tumble.stand import LARGEST_ERROR_RAD, MOST_YAWS, Stand

ANGLES = ("alpha1", "alpha2_plus_alpha3", "alpha3_difference")
_NULL = 1e-12
_INESTIMABLE = 1e-6
_SMALLEST_NOISE = 1e-7
NAMES = {  # of what is seen, for people
    "alpha1_rad": "axis tilt",
    "alpha2_plus_alpha3_rad": "level + yaw",
    "alpha3_difference_rad": "yaw change",
    "alpha4_rad": "set angle",
    "inclination_rad": "inclination",
    "noise_v": "noise",
}
_FARTHEST = 1e5  # rows of K, as their noise makes them alike, from one another


@dataclass(frozen=True)
class Estimate:
    """A quantity with its standard uncertainty."""

    value: float
    u: float


def pooled_noise(samples: Integers, scatter: Floats) -> Estimate | None:
    """Standard deviation of one sample, pooled over positions and channels; None when a run holds only means.

    `samples` (positions,), `scatter` (positions, 3), read where samples > 1.
    """
    several = samples > 1
    freedom = 3 * int((samples[several] - 1).sum())
    if freedom == 0:
        return None
    variance = ((samples[several] - 1)[:, None] * scatter[several] ** 2).sum() / freedom
    return Estimate(float(np.sqrt(variance)), float(np.sqrt(variance / (2 * freedom))))


def closed_form(slots: Integers, k: Floats, means: Floats) -> Floats:
    """The three of ANGLES, alpha3 as mean and as first mounting less second: means (..., P, 3) -> (..., 3)."""
    _, s1, b1 = functionals(means[..., slots[0], :])
    _, s2, b2 = functionals(means[..., slots[1], :])
    v = np.linalg.solve(k, (b1 - b2)[..., None])[..., 0]
    w = np.linalg.solve(k, (-s2 - s1)[..., None])[..., 0]
    return np.stack([(v[..., 1] - v[..., 2]) / 2, (w[..., 1] + w[..., 2]) / 2, w[..., 1] - w[..., 2]], axis=-1)


def _paper_slots(fitted: Schedule, whole: Schedule) -> Integers | None:
    """Among the fitted positions; a circle of the whole schedule is one, whether all of it was measured or not."""
    measured = {(one.mounting, one.number): place for place, one in enumerate(fitted.positions)}
    slots = paper_slots(whole)
    if slots is None:
        return None
    names = [(whole.positions[slot].mounting, whole.positions[slot].number) for slot in slots.ravel()]
    return np.array([measured[name] for name in names]).reshape(2, 9) if measured.keys() >= set(names) else None


class RunSeen:
    """What one run shows of the stand: `means` (positions, 3) of a schedule, and the `k` found from them; `whole`: that
    schedule with the positions that were not measured, where some were not. Every `variance` (positions,) is that of
    each mean by its noise, every `alpha4` the standard deviation of a set angle. `weights` (3,) make channels alike
    that differ: every variance is then of outputs times these.

    `_left` is what an ideal stand leaves of the outputs, over max|K|. The outputs of the P fitted positions are linear
    in everything: `_design` is for coefficients, alpha1, alpha2, alpha3 by bolting, and inclinations where the block is
    inclined, `_by_set_angle` (P, 3P) for each set angle. Of the unknowns behind the coefficients `_combinations` are
    what is told, by name or, of a yaw change from the third on, by mounting."""

    def __init__(
        self,
        schedule: Schedule,
        means: Floats,
        k: Floats,
        whole: Schedule | None = None,
        weights: Floats | None = None,
    ):
        if weights is not None:
            means, k = means * weights, k * weights[:, None]
        self._fit, self._fitted = schedule.fit_indices, schedule.fitted
        self._scale = np.abs(k).max()
        self._means, self._k = means[self._fit] / self._scale, k / self._scale
        ideal, outputs = design(self._fitted), self._means.ravel()
        self._left: Floats = outputs - ideal @ np.linalg.lstsq(ideal, outputs, rcond=None)[0]
        self._slots = _paper_slots(self._fitted, whole or schedule)
        shared = ("alpha1", "alpha2", "alpha3", "inclination")
        by_angle = np.concatenate([unit_effect(self._fitted, name).derivative(self._k) for name in shared])
        self._design = np.column_stack([ideal, by_angle.reshape(len(by_angle), -1).T])
        self._by_set_angle = unit_effect(self._fitted, "alpha4").derivative(self._k).reshape(len(self._fit), -1)
        boltings = [[schedule.mountings[index] for index in bolting] for bolting in schedule.boltings]
        fitted = schedule.fitted_mountings
        used = [index for index, them in enumerate(boltings) if any(mounting in fitted for mounting in them)]
        mean, one = np.zeros(len(boltings)), np.eye(len(boltings))
        mean[used] = 1 / len(used)
        changes: dict[str | int, Floats] = {}
        for other in used[1:]:
            changes[boltings[other][0].number] = np.array([0.0, 0.0, *(one[used[0]] - one[other])])
        second = next(iter(changes), None)
        self._combinations: dict[str | int, Floats | None] = {
            "alpha1": np.array([1.0, 0.0, *np.zeros(len(boltings))]),
            "alpha2_plus_alpha3": np.array([0.0, 1.0, *mean]),
            "alpha3_difference": None if second is None else changes.pop(second),
            **changes,
        }

    @property
    def shows_angles(self) -> bool:
        """Free attitudes do not: poses without a turn of one table, or more mountings than the core has yaws for. Nor
        do outputs so far from those of any stand that no small angles explain them, such as those of exchanged
        mountings: the angles are linear theory, and its figures would be rounding."""
        has_turns = len(self._fitted.fitted_mountings) < len(self._fit)
        return len(self._fitted.mountings) <= MOST_YAWS and has_turns and self.departure <= LARGEST_ERROR_RAD

    @property
    def departure(self) -> float:
        """Rms of what least squares on the ideal stand leaves of the outputs, in the channel that has most, over
        max|K|: about an angle in rad."""
        freedom = len(self._fit) - 4
        squares = (self._left.reshape(-1, 3) ** 2).sum(axis=0)
        return float(np.sqrt(squares.max() / freedom)) if freedom > 0 else 0.0

    def angles(self, alpha4: float | None, variance: Floats) -> dict[str, Estimate | None]:
        """The angles by the closed form: all None where the paper's positions are not all there. Without an `alpha4`
        the uncertainties are 0.

        They come from the random errors alone: to first order alpha1, alpha2 and alpha3 do not disturb each other.
        """
        slots = self._slots
        if slots is None:
            return dict.fromkeys(ANGLES)
        u = np.zeros(3)
        if alpha4 is not None:
            count = len(self._fit)
            moved = self._by_set_angle.reshape(count, count, 3)
            noise = np.eye(3 * count).reshape(-1, count, 3) * np.sqrt(variance[self._fit])[:, None] / self._scale
            draws = np.concatenate([alpha4 * moved, noise])
            u = np.sqrt((closed_form(slots, self._k, draws) ** 2).sum(axis=0))
        values = closed_form(slots, self._k, self._means)
        return {name: Estimate(*pair) for name, pair in zip(ANGLES, zip(values.tolist(), u.tolist()))}

    def fit(self, alpha4: float, variance: Floats) -> dict[str | int, Estimate | None]:
        """By least squares for everything at once, each None where these positions cannot tell it: the angles, and by
        mounting, from the third on, the yaw of the first less that of this one."""
        explained, by_set_angle, right = self._whitened(variance)
        count, unknowns = by_set_angle.shape[1], explained.shape[1]
        prior = np.hstack([np.zeros((count, unknowns)), np.eye(count)])
        whole = np.vstack([np.hstack([explained, alpha4 * by_set_angle]), prior])
        left, singular, directions = np.linalg.svd(whole)
        rank = int((singular > _NULL * singular[0]).sum())
        inverse = (directions[:rank].T / singular[:rank]) @ left[:, :rank].T
        found: dict[str | int, Estimate | None] = dict.fromkeys(self._combinations)
        for name, combination in self._combinations.items():
            row = np.zeros(unknowns + count)
            if combination is not None:
                row[12 : 12 + len(combination)] = combination
                if np.abs(directions[rank:] @ row).max(initial=0.0) < _INESTIMABLE:
                    gains = row @ inverse
                    found[name] = Estimate(float(gains[: len(right)] @ right), float(np.linalg.norm(gains)))
        return found

    def angle_error(self, variance: Floats) -> tuple[Estimate | None, float]:
        """alpha4 such that chi-squared is what it should be (Paule and Mandel), and the degrees of freedom of that.
        None and 0 where there is no excess."""
        values, gains = self._components(variance)
        count = len(values)
        if count == 0 or (values**2).sum() <= count:
            return None, 0.0
        low, high = 0.0, float((values**2 / gains).sum())
        while low < (middle := (low + high) / 2) < high and high - low > 1e-15 * high:
            too_small = (values**2 / (1 + middle * gains)).sum() > count
            low, high = (middle, high) if too_small else (low, middle)
        share = (high * gains / (1 + high * gains)).sum()
        freedom, alpha4 = float(share**2 / count), float(np.sqrt(high))
        return Estimate(alpha4, float(alpha4 / np.sqrt(2 * freedom))), freedom

    def angle_chi_squared(self, alpha4: float, variance: Floats) -> tuple[float, int]:
        """Chi-squared of the residuals that errors of set angles move, and its degrees of freedom."""
        values, gains = self._components(variance)
        return float((values**2 / (1 + alpha4**2 * gains)).sum()), len(values)

    def _whitened(self, variance: Floats) -> tuple[Floats, Floats, Floats]:
        """Design, derivatives by the set angles, and what an ideal stand leaves of the outputs, in units of the
        noise."""
        noise = np.maximum(np.sqrt(np.repeat(variance[self._fit], 3)) / self._scale, _SMALLEST_NOISE)
        return self._design / noise[:, None], self._by_set_angle.T / noise[:, None], self._left / noise

    def _components(self, variance: Floats) -> tuple[Floats, Floats]:
        """The residuals that errors of set angles move, as independent components: their values, in units of the noise,
        and the variance that a set angle of standard deviation 1 rad gives each."""
        explained, by_set_angle, right = self._whitened(variance)
        left, singular, _ = np.linalg.svd(explained)
        rest = left[:, int((singular > _NULL * singular[0]).sum()) :]
        directions, size, _ = np.linalg.svd(rest.T @ by_set_angle)
        seen = int((size > _INESTIMABLE * size.max(initial=0.0)).sum())
        return directions[:, :seen].T @ (rest.T @ right), size[:seen] ** 2


@dataclass(frozen=True)
class StandSeen:
    """Angles in rad, noise of one sample in the unit of the outputs; an entry None is what the run cannot tell. Each
    has `value` and `u`.

    `angles`: by the closed form; `augmented`: by least squares for everything at once; both by name as in ANGLES, with
    the uncertainty of `source` ("stand": as declared; "run": of this run's own scatter and residuals, `freedom`
    degrees of freedom; None: unknown, and u is 0). `other_yaw_changes`: by mounting, from the third on, the yaw of the
    first less that of this one, as `augmented`. `alpha4`: standard deviation of a set angle, with `alpha4_freedom`.
    """

    noise: Estimate | None
    alpha4: Estimate | None
    alpha4_freedom: float
    angles: Mapping[str, Estimate | None]
    augmented: Mapping[str, Estimate | None]
    source: str | None
    other_yaw_changes: Mapping[int, Estimate | None] = field(default_factory=dict)

    @property
    def freedom(self) -> float | None:
        """Degrees of freedom of the angles' uncertainties; None for those of a declared stand."""
        return self.alpha4_freedom if self.source == "run" else None


def estimate_stand_errors(
    run: RunSeen,
    noise: Estimate | None,
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

    A stand that is not to be trusted gives no uncertainties, except where the run itself has none to give.
    """
    nothing = dict.fromkeys(ANGLES)
    if not run.shows_angles:
        return StandSeen(noise, None, 0.0, nothing, nothing, None)
    own = own_variance(noise, samples, stand, mean_variance)
    alpha4, freedom = (None, 0.0) if own is None else run.angle_error(own)
    if stand is not None and (trust_stand or alpha4 is None):
        source, sigma = "stand", stand.sigma("angle")
        variance = _at_least(stand.mean_variance(samples).max(axis=1), mean_variance, stand)
    elif alpha4 is not None and own is not None:
        source, sigma, variance = "run", alpha4.value, own
    else:
        return StandSeen(noise, None, 0.0, run.angles(None, np.zeros(len(samples))), nothing, None)
    found = run.fit(sigma, variance)
    augmented = {name: found[name] for name in ANGLES}
    others = {int(name): one for name, one in found.items() if name not in ANGLES}
    return StandSeen(noise, alpha4, freedom, run.angles(sigma, variance), augmented, source, others)


def averaged_over(samples: Integers, stand: Stand | None) -> Integers:
    """How many samples each mean has."""
    return np.maximum(samples, 1) if stand is None else stand.averaged_over(samples)


def own_variance(
    noise: Estimate | None, samples: Integers, stand: Stand | None, mean_variance: Floats | None = None
) -> Floats | None:
    """Variance (positions,) of each mean by the noise that the run shows, else by the declared one, of channels made
    alike; None where neither is known. Arguments as of `look`."""
    if noise is not None:
        return _at_least(noise.value**2 / averaged_over(samples, stand), mean_variance, stand)
    return None if stand is None else np.asarray(stand.mean_variance(samples).max(axis=1))


def weights_of(stand: Stand | None) -> Floats:
    """What makes the channels of a stand alike (3,): outputs and their scatter times these."""
    return np.ones(3) if stand is None else stand.weights


def stand_for_estimate(stand: Stand, k: Floats) -> Stand:
    """The stand, but with the same noise in every channel where its weights leave rows of `k` that are too far apart:
    the outputs are no such channels then, as if one had another unit, and the angles would hang on last bits."""
    rows = np.linalg.norm(k, axis=1) * stand.weights
    return stand if rows.max() <= _FARTHEST * rows.min() else stand.with_sigma("noise", stand.sigmas("noise").max())


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
        return self.values * float((2.0 * self.freedom) ** -0.5)

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
        return f"{seen} {unit}, each +- {100.0 * (2.0 * self.freedom) ** -0.5:.2g} %; declared {declared}"
