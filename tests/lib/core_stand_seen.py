"""The core's account of the stand that a run shows, beside numpy's. Arrays as in tumble.core."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from _tumble_core import ffi, lib

from tumble import model
from tumble.arrays import Flags, Floats, Integers
from tumble.core import (
    Calibration,
    CoreRefusal,
    CoreSchedule,
    estimate,
    pack,
    require_ok,
    residual_rms,
)
from tumble.model.stand_seen import ANGLES, Estimate, StandSeen, estimate_stand_errors, own_variance, weights_of
from tumble.schedule import FIT, Schedule
from tumble.solving.computation import _LAST_BITS, _require
from tumble.stand import LARGEST_ERROR_RAD, MOST_YAWS, Stand

if TYPE_CHECKING:
    from _tumble_core import CData

SEEN_LIMIT_U = 1e-6
_ROUNDED_RAD = 1e-11
_SUMMED = 100.0


@dataclass(frozen=True)
class Seen:
    """A quantity with its standard uncertainty."""

    value: float
    u: float


def _seen(struct: CData) -> Seen | None:
    return Seen(struct.value, struct.u) if struct.known else None


def _angles(struct: CData) -> dict[str, Seen | None]:
    return {name: _seen(getattr(struct, name)) for name in ANGLES}


def _errors(alpha4: float, variance: Floats) -> CData:
    """`alpha4` standard deviation, rad; `variance` (positions,) of a mean by its noise."""
    struct = ffi.new("tumble_random_errors_t *", {"angle_rad": alpha4})
    values = np.ascontiguousarray(variance, dtype=float)
    ffi.memmove(struct.mean_variance_v2, ffi.from_buffer(values), values.nbytes)
    return struct


def noise(samples: Integers, scatter: Floats) -> Seen | None:
    """Standard deviation of one sample, pooled; None where no position has two. `samples` (positions,), `scatter`
    (positions, 3)."""
    counts, rows = np.ascontiguousarray(samples, dtype=np.uint32), np.ascontiguousarray(scatter, dtype=float)
    pointers = ffi.from_buffer("uint32_t[]", counts), ffi.cast("double (*)[3]", ffi.from_buffer(rows))
    return _seen(lib.tumble_seen_noise(*pointers, len(counts)))


class RunSeen:
    """What one run shows of the stand: `schedule`, its `means`, which of them are `measured`, and coefficients `k`,
    `u0` found from them. `weights` (3,) make channels alike that differ: every variance is then of outputs times these.
    `alpha4` and `variance` as given are those that the uncertainties come from."""

    def __init__(
        self,
        schedule: CoreSchedule,
        means: Floats,
        measured: Flags,
        k: Floats,
        u0: Floats,
        weights: Floats | None = None,
    ):
        if weights is not None:
            means, k, u0 = means * weights, k * weights[:, None], u0 * weights
        self._schedule, self._given = schedule, (means, measured, k, u0)
        self._means = schedule.means(means, measured)
        self._calibration = Calibration(k, u0)
        self._coefficients = pack(k, u0)
        self._work = ffi.new("tumble_fit_work_t *")

    @property
    def shows_angles(self) -> bool:
        """Does the table turn in any mounting, from one fit position to another, of so many mountings as there are yaws
        for, with outputs that small angles may explain?"""
        positions = [place for place in self._schedule.data.part(self._given[1]).positions if place.use == FIT]
        has_turns = len({place.mounting for place in positions}) < len(positions)
        few = len(self._schedule.data.mountings) <= MOST_YAWS
        return few and has_turns and self.departure <= LARGEST_ERROR_RAD

    @property
    def departure(self) -> float:
        """Rms of what least squares on the ideal stand leaves of the outputs, in the channel that has most, over
        max|K|: about an angle in rad. 0 with fewer than five fit positions."""
        means, measured, k, _ = self._given
        ideal = estimate(self._schedule, means, measured, "least_squares")
        rms = residual_rms(self._schedule, means, measured, *ideal)
        return 0.0 if rms is None else float(rms.max() / np.abs(k).max())

    def angles(self, alpha4: float | None, variance: Floats) -> dict[str, Seen | None]:
        """The angles by the closed form, each None where the run lacks positions of the paper. Without an `alpha4` the
        uncertainties are 0."""
        found = ffi.new("tumble_seen_angles_t *")
        errors = ffi.NULL if alpha4 is None else _errors(alpha4, variance)
        calibration = self._calibration.struct
        try:
            require_ok(lib.tumble_seen_angles(self._schedule.struct, self._means, calibration, errors, found))
        except CoreRefusal as refusal:
            if refusal.name not in ("TUMBLE_E_NOT_HARMONIC", "TUMBLE_E_MISSING_POSITION"):
                raise
        return _angles(found)

    def fit(self, alpha4: float, variance: Floats) -> dict[str | int, Seen | None]:
        """The angles by generalised least squares; None where the positions cannot tell. And by mounting, from the
        third on, the yaw of the first less that of this one: as if it were the second."""
        seen = ffi.new("tumble_seen_angles_t *")
        require_ok(lib.tumble_seen_fit(*self._fit_arguments(alpha4, variance), seen))
        found: dict[str | int, Seen | None] = {**_angles(seen)}
        whole, measured = self._schedule.data, self._given[1]
        first, *others = whole.part(measured).fitted_mountings
        for one in others[1:]:
            order = (first, one, *(other for other in whole.mountings if other not in (first, one)))
            as_second = RunSeen(CoreSchedule(Schedule(order, whole.positions)), *self._given)
            require_ok(lib.tumble_seen_fit(*as_second._fit_arguments(alpha4, variance), seen))
            found[one.number] = _angles(seen)["alpha3_difference"]
        return found

    def angle_error(self, variance: Floats) -> tuple[Seen | None, float]:
        """alpha4 from the residuals beyond the noise (None: it cannot tell), and the degrees of freedom of that."""
        found, freedom = ffi.new("tumble_seen_t *"), ffi.new("double *")
        require_ok(lib.tumble_seen_angle_error(*self._fit_arguments(0.0, variance), found, freedom))
        return _seen(found), freedom[0]

    def angle_chi_squared(self, alpha4: float, variance: Floats) -> tuple[float, int]:
        """How large the residuals are that errors of set angles move, if these had the standard deviation `alpha4`:
        chi-squared, and its degrees of freedom."""
        square, freedom = ffi.new("double *"), ffi.new("uint8_t *")
        require_ok(lib.tumble_seen_angle_chi_squared(*self._fit_arguments(alpha4, variance), square, freedom))
        return square[0], freedom[0]

    def _fit_arguments(self, alpha4: float, variance: Floats) -> tuple[CData, ...]:
        errors = _errors(alpha4, variance)
        return self._schedule.struct, self._means, self._coefficients, errors, self._work


def compare_seen(
    found: StandSeen,
    run: model.RunSeen,
    samples: Integers,
    scatter: Floats,
    stand: Stand | None,
    trust_stand: bool = True,
    mean_variance: Floats | None = None,
) -> None:
    """Look at the stand again, through the witness. Raises Disagreement.

    Values may differ by 1e-6 of their standard uncertainty, or where that is less by 1e-11 rad or by what rounding
    leaves of the largest output; uncertainties likewise; alpha4 by its square. Where the outputs fit worse than the
    noise allows, as behind a coarse converter, the uncertainty is that which they show: times their misfit.
    """
    seen = model.pooled_noise(samples, scatter * weights_of(stand))
    rounded = max(_ROUNDED_RAD, _LAST_BITS * _SUMMED * float(np.abs(np.linalg.solve(run._k, run._means.T)).max()))
    witness = estimate_stand_errors(run, seen, samples, stand, trust_stand, mean_variance)
    variances = [
        own_variance(one, samples, stand, mean_variance) for one in (seen, None)
    ]  # by the run and by the stand
    misfit = max([1.0, *(_misfit(run, variance) for variance in variances if variance is not None)])
    _require_seen("noise", found.noise, witness.noise, 0.0)
    _require_alpha4(found.alpha4, witness.alpha4, rounded, misfit)
    for name in ANGLES:
        _require_seen(name, found.angles[name], witness.angles[name], rounded, misfit)
        _require_seen(f"augmented {name}", found.augmented[name], witness.augmented[name], rounded, misfit)
    for mounting, change in found.other_yaw_changes.items():
        _require_seen(f"yaw change {mounting}", change, witness.other_yaw_changes[mounting], rounded, misfit)


def _misfit(run: model.RunSeen, variance: Floats) -> float:
    """Rms of what no coefficient and no angle explains, in units of the noise: about 1 where that is the truth."""
    explained, by_set_angle, right = run._whitened(variance)
    left, singular, _ = np.linalg.svd(np.hstack([explained, by_set_angle]), full_matrices=False)
    explaining = left[:, singular > 1e-12 * singular[0]]
    rest = right - explaining @ (explaining.T @ right)
    return float(np.linalg.norm(rest) / np.sqrt(max(1, len(right) - explaining.shape[1])))


def _require_seen(
    name: str, core: Estimate | None, witness: Estimate | None, rounded: float, misfit: float = 1.0
) -> None:
    if core is None or witness is None:
        _require(f"{name} of the stand seen", core, witness, 0.0)
        return
    allowed = max(SEEN_LIMIT_U * misfit * witness.u, rounded)
    _require(f"{name} of the stand seen", core.value, witness.value, allowed)
    _require(f"u of {name} of the stand seen", core.u, witness.u, allowed)


def _require_alpha4(core: Estimate | None, witness: Estimate | None, rounded: float, misfit: float) -> None:
    """By its square and the uncertainty of that, which are what is estimated: where the set angles are hardly worse
    than the noise, the root of a small number and its uncertainty magnify what rounding leaves of the square."""
    if core is None or witness is None:
        _require("alpha4 of the stand seen", core, witness, 0.0)
        return
    squares = [Estimate(one.value**2, 2.0 * one.value * one.u) for one in (core, witness)]
    _require_seen("alpha4 squared", squares[0], squares[1], 2.0 * witness.value * rounded, misfit)
