"""The stand as a run shows it: what the outputs tell about the fixture itself.

The closed form, of the paper's positions alone:

    v = K^-1 (U1_0 - U2_0)          alpha1 = (v_y - v_z)/2
    w = K^-1 (K2_.x - K1_.x)        w_y = alpha2 + alpha3 of mounting 1,  w_z = alpha2 + alpha3 of mounting 2

and, of any positions, dense least squares for coefficients, angles and the error of every set angle together, the
latter
with their variance as prior. alpha2 and alpha3 cannot be told apart in the paper's mountings: alpha2 = -alpha3 is a
rotation of the block's own frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.reference.estimators import dense_design, fit_indices, functionals, paper_slots
from tumble.reference.geometry import Geometry
from tumble.schedule import Schedule

ANGLES = ("alpha1", "alpha2_plus_alpha3", "alpha3_difference")
_NULL = 1e-12
_INESTIMABLE = 1e-6
_SMALLEST_NOISE = 1e-7
_Name = TypeVar("_Name", str, int)


@dataclass(frozen=True)
class Estimate:
    """A quantity with its standard uncertainty."""

    value: float
    u: float


@dataclass(frozen=True)
class AngleError:
    """alpha4 as a run shows it (None where it cannot tell), and the degrees of freedom of that."""

    seen: Estimate | None
    freedom: float


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


class Model:
    """The outputs of all positions, linear in everything: `design` (3P, 14 + mountings) for coefficients, alpha1,
    alpha2, alpha3 by mounting; `by_set_angle` (P, 3P), their derivative with respect to each set angle; P positions."""

    def __init__(self, schedule: Schedule, k: Floats):
        geometry, positions, mountings = Geometry(schedule), len(schedule.positions), len(schedule.mountings)
        one = np.ones((1, 1))
        by_angle = [geometry.derivative(k, alpha1=one), geometry.derivative(k, alpha2=one)]
        by_angle += [geometry.derivative(k, alpha3=np.eye(mountings))]
        self.design = np.column_stack([dense_design(schedule), np.concatenate(by_angle).reshape(2 + mountings, -1).T])
        self.by_set_angle = geometry.derivative(k, delta=np.eye(positions)).reshape(positions, -1)
        used = [schedule.mountings.index(mounting) for mounting in schedule.fitted_mountings]
        mean, one = np.zeros(mountings), np.eye(mountings)
        mean[used] = 1 / len(used)
        changes = {schedule.mountings[other].number: one[used[0]] - one[other] for other in used[1:]}
        self.yaw_changes = {number: np.array([0.0, 0.0, *change]) for number, change in changes.items()}
        self.combinations = {
            "alpha1": np.array([1.0, 0.0, *np.zeros(mountings)]),
            "alpha2_plus_alpha3": np.array([0.0, 1.0, *mean]),
            "alpha3_difference": next(iter(self.yaw_changes.values()), None),
        }


class RunSeen:
    """What one run shows of the stand: `means` (positions, 3) of a schedule, and the `k` found from them; `whole`: that
    schedule with the positions that were not measured, where some were not. Every `variance` (positions,) is that of
    each mean by its noise, every `alpha4` the standard deviation of a set angle. `weights` (3,) make channels alike
    that differ: every variance is then of outputs times these."""

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
        self.mountings = len(schedule.mountings)
        self._fit = fit_indices(schedule)
        self._fitted = Schedule(schedule.mountings, tuple(schedule.positions[index] for index in self._fit))
        self._scale = np.abs(k).max()
        self._means, self._k = means[self._fit] / self._scale, k / self._scale
        self._model = Model(self._fitted, self._k)
        self._slots = self._paper_slots(whole or schedule)

    def _paper_slots(self, whole: Schedule) -> Integers | None:
        """Among the fitted positions; a circle of the schedule is one, whether all of it was measured or not."""
        measured = {(one.mounting, one.number): place for place, one in enumerate(self._fitted.positions)}
        slots = paper_slots(whole)
        if slots is None:
            return None
        names = [(whole.positions[slot].mounting, whole.positions[slot].number) for slot in slots.ravel()]
        return np.array([measured[name] for name in names]).reshape(2, 9) if measured.keys() >= set(names) else None

    @property
    def has_turns(self) -> bool:
        """Are there mountings with more than one fit position?"""
        return len(self._fitted.fitted_mountings) < len(self._fit)

    @property
    def largest_force(self) -> float:
        """The largest output, as a specific force in g."""
        return float(np.abs(np.linalg.solve(self._k, self._means.T)).max())

    @property
    def departure(self) -> float:
        """Rms of what least squares on the ideal stand leaves of the outputs, in the channel that has most, over
        max|K|: about an angle in rad."""
        freedom = len(self._fit) - 4
        squares = (self._left().reshape(-1, 3) ** 2).sum(axis=0)
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
            moved = self._model.by_set_angle.reshape(count, count, 3)
            noise = np.eye(3 * count).reshape(-1, count, 3) * np.sqrt(variance[self._fit])[:, None] / self._scale
            draws = np.concatenate([alpha4 * moved, noise])
            u = np.sqrt((closed_form(slots, self._k, draws) ** 2).sum(axis=0))
        values = closed_form(slots, self._k, self._means)
        return {name: Estimate(*pair) for name, pair in zip(ANGLES, zip(values.tolist(), u.tolist()))}

    def fit(self, alpha4: float, variance: Floats) -> dict[str, Estimate | None]:
        """The angles by least squares for everything at once, each None where these positions cannot tell it."""
        return self._combined(self._model.combinations, alpha4, variance)

    def other_yaw_changes(self, alpha4: float, variance: Floats) -> dict[int, Estimate | None]:
        """By mounting, from the third on, the yaw of the first less that of this one, likewise."""
        others = list(self._model.yaw_changes.items())[1:]
        return self._combined(dict(others), alpha4, variance) if others else {}

    def _combined(
        self, combinations: Mapping[_Name, Floats | None], alpha4: float, variance: Floats
    ) -> dict[_Name, Estimate | None]:
        design, by_set_angle, right = self._whitened(variance)
        count, unknowns = by_set_angle.shape[1], design.shape[1]
        prior = np.hstack([np.zeros((count, unknowns)), np.eye(count)])
        whole = np.vstack([np.hstack([design, alpha4 * by_set_angle]), prior])
        left, singular, directions = np.linalg.svd(whole)
        rank = int((singular > _NULL * singular[0]).sum())
        inverse = (directions[:rank].T / singular[:rank]) @ left[:, :rank].T
        found: dict[_Name, Estimate | None] = dict.fromkeys(combinations)
        for name, combination in combinations.items():
            row = np.zeros(unknowns + count)
            if combination is not None:
                row[12:unknowns] = combination
                if np.abs(directions[rank:] @ row).max(initial=0.0) < _INESTIMABLE:
                    gains = row @ inverse
                    found[name] = Estimate(float(gains[: len(right)] @ right), float(np.linalg.norm(gains)))
        return found

    def angle_error(self, variance: Floats) -> AngleError:
        """alpha4 such that chi-squared is what it should be (Paule and Mandel). None where there is no excess."""
        values, gains = self._components(variance)
        count = len(values)
        if count == 0 or (values**2).sum() <= count:
            return AngleError(None, 0.0)
        low, high = 0.0, float((values**2 / gains).sum())
        while low < (middle := (low + high) / 2) < high and high - low > 1e-15 * high:
            too_small = (values**2 / (1 + middle * gains)).sum() > count
            low, high = (middle, high) if too_small else (low, middle)
        share = (high * gains / (1 + high * gains)).sum()
        freedom, alpha4 = float(share**2 / count), float(np.sqrt(high))
        return AngleError(Estimate(alpha4, float(alpha4 / np.sqrt(2 * freedom))), freedom)

    def angle_chi_squared(self, alpha4: float, variance: Floats) -> tuple[float, int]:
        """Chi-squared of the residuals that errors of set angles move, and its degrees of freedom."""
        values, gains = self._components(variance)
        return float((values**2 / (1 + alpha4**2 * gains)).sum()), len(values)

    def misfit(self, variance: Floats) -> float:
        """Rms of what no coefficient and no angle explains, in units of the noise: about 1 where that is the truth."""
        design, by_set_angle, right = self._whitened(variance)
        left, singular, _ = np.linalg.svd(np.hstack([design, by_set_angle]), full_matrices=False)
        explaining = left[:, singular > _NULL * singular[0]]
        rest = right - explaining @ (explaining.T @ right)
        return float(np.linalg.norm(rest) / np.sqrt(max(1, len(right) - explaining.shape[1])))

    def _whitened(self, variance: Floats) -> tuple[Floats, Floats, Floats]:
        """Design, derivatives by the set angles, and what an ideal stand leaves of the outputs, in units of the
        noise."""
        noise = np.maximum(np.sqrt(np.repeat(variance[self._fit], 3)) / self._scale, _SMALLEST_NOISE)
        return self._model.design / noise[:, None], self._model.by_set_angle.T / noise[:, None], self._left() / noise

    def _left(self) -> Floats:
        """What an ideal stand leaves of the outputs, over max|K|."""
        ideal, outputs = dense_design(self._fitted), self._means.ravel()
        left: Floats = outputs - ideal @ np.linalg.lstsq(ideal, outputs, rcond=None)[0]
        return left

    def _components(self, variance: Floats) -> tuple[Floats, Floats]:
        """The residuals that errors of set angles move, as independent components: their values, in units of the noise,
        and the variance that a set angle of standard deviation 1 rad gives each."""
        design, by_set_angle, right = self._whitened(variance)
        left, singular, _ = np.linalg.svd(design)
        rest = left[:, int((singular > _NULL * singular[0]).sum()) :]
        directions, size, _ = np.linalg.svd(rest.T @ by_set_angle)
        seen = int((size > _INESTIMABLE * size.max(initial=0.0)).sum())
        return directions[:, :seen].T @ (rest.T @ right), size[:seen] ** 2
