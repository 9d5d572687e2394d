"""The stand-optimal estimator, from the data: one whitened least-squares problem, solved by singular values.

Unknown are the twelve coefficients and every error of the stand, each with its variance as prior. Outputs are
linearised by complex steps through the exact geometry at a first least-squares estimate of K; what the exact geometry
then gives beyond its linearisation is taken out of the outputs, twice. No table of gains takes part. The uncertainties
are those of the same problem linearised at the K that came out: gains made at a K that is far off still give a good
estimate, after the second order is taken out, but their own propagation would overstate what they leave.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.reference.estimators import dense_design, fit_indices, least_squares
from tumble.reference.extended import fitted_columns
from tumble.reference.geometry import Geometry
from tumble.reference.uncertainty import by_coefficient, course, encoder_waves, joint, sources
from tumble.schedule import Schedule
from tumble.stand import PerChannel, Stand, by_channel
from tumble.terms import Terms

CORRECTIONS = 2
_FLOOR_G = 1e-9
_ROW_ORDER = np.arange(9).reshape(3, 3).T.ravel()  # K row by row, of K column by column


@dataclass(frozen=True)
class OptimalEstimate:
    """What the run says: `k` (3, 3), `u0` (3,), `sizes` (terms, 3) of further terms, their `covariance`, K row by row,
    then U0, then the sizes; `alpha1`, `alpha2`, `alpha3` (one per mounting), radians; `magnification`: by how much the
    rounding of a mean may be larger in a coefficient; `largest_angle`: of all errors found, table angles with alpha2,
    radians."""

    k: Floats
    u0: Floats
    sizes: Floats
    covariance: Floats
    alpha1: float
    alpha2: float
    alpha3: Floats
    magnification: float
    largest_angle: float

    @property
    def u_k(self) -> Floats:
        """Standard uncertainties of K (3, 3)."""
        return by_coefficient(self.covariance)[0]

    @property
    def u_u0(self) -> Floats:
        """Standard uncertainties of U0 (3,)."""
        return by_coefficient(self.covariance)[1]

    @property
    def u_sizes(self) -> Floats:
        """Standard uncertainties of the sizes (terms, 3)."""
        u: Floats = np.sqrt(np.diag(self.covariance)[12:]).reshape(-1, 3)
        return u


def optimal(
    schedule: Schedule,
    means: Floats,
    stand: Stand,
    samples: Integers,
    step: PerChannel = 0.0,
    known_k: Floats | None = None,
    known_samples: float | None = None,
    mean_variance: Floats | None = None,
    terms: Terms = (),
) -> OptimalEstimate:
    """Solve one run. `means` (positions, 3), `samples` (positions,) as in `uncertainty.sources`; `step` of the
    converter in the outputs' unit, 0 where unknown; `known_k`: linearise there instead of at a first estimate. Weights
    take the noise of all means as equal, with the average of 1/N, or with N = `known_samples`. `mean_variance` as in
    `uncertainty.sources`: of the uncertainties alone. `terms`: further unknowns."""
    k = least_squares(schedule, means)[0] if known_k is None else known_k
    return _Whitened(schedule, k, stand, samples, step, known_samples, terms).solve(means, mean_variance)


def optimal_covariance(
    schedule: Schedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    step: PerChannel,
    mean_variance: Floats | None = None,
    terms: Terms = (),
) -> Floats:
    """Covariance (12, 12), with `terms` also of their sizes, of `optimal` for a block that has this `k`. Arguments as
    of `optimal`."""
    return _Whitened(schedule, k, stand, samples, step, terms=terms).covariance(mean_variance)


def optimal_uncertainties(
    schedule: Schedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    step: PerChannel,
    known_samples: float,
    mean_variance: Floats | None = None,
) -> tuple[Floats, Floats]:
    """u_K (3, 3) and u_U0 (3,) of weights made at `k` for `known_samples`, on a block that has this `k`. Arguments as
    of `optimal`; `mean_variance` (positions, 3): what the noise of a mean counts at least."""
    return by_coefficient(_Whitened(schedule, k, stand, samples, step, known_samples).covariance(mean_variance))


class _Whitened:
    """The problem linearised at one K: unknowns K column by column, U0 and the sizes of further terms, `count` in all,
    then errors in units of their sigma."""

    def __init__(
        self,
        schedule: Schedule,
        k: Floats,
        stand: Stand,
        samples: Integers,
        step: PerChannel,
        known_samples: float | None = None,
        terms: Terms = (),
    ):
        self.terms, self.count = terms, 12 + 3 * len(terms)
        self.schedule, self.stand, self.samples, self.step = schedule, stand, samples, step
        self.fit = fit_indices(schedule)
        self.geometry = Geometry(schedule)
        self.errors = sources(schedule, k, stand, samples)
        angles = {name: source for name, source in self.errors.items() if name != "noise"}
        self.draws = {name: len(source.sigma) for name, source in angles.items()}
        self.waves, self.course = encoder_waves(schedule), course(schedule)[self.fit]
        self.sigma = np.concatenate([source.sigma for source in angles.values()])
        derivative = np.concatenate([source.derivative for source in angles.values()])[:, self.fit]
        by_error = self.sigma * derivative.reshape(len(self.sigma), -1).T
        self.further = fitted_columns(schedule, terms)
        self.model = np.hstack([dense_design(schedule), self.further, by_error])
        self.averaged_over = stand.averaged_over(samples)
        self.one_sample = np.maximum(stand.sigmas("noise"), np.abs(by_channel(step)) / np.sqrt(12.0))
        self.floor = _FLOOR_G * np.abs(k).max()
        inverse_samples = 1.0 / (self.averaged_over[self.fit] if known_samples is None else np.array([known_samples]))
        by_channels = np.maximum(self.one_sample * np.sqrt(inverse_samples.mean()), self.floor)
        self.noise = np.tile(by_channels, len(self.fit))[:, None]
        prior = np.eye(len(self.sigma), self.model.shape[1], self.count)
        self.system = np.vstack([self.model / self.noise, prior])

    def unknowns(self, outputs: Floats) -> Floats:
        """Best estimate of all unknowns, for outputs (3 x fit positions, any number of columns)."""
        right = np.vstack([outputs / self.noise, np.zeros((len(self.sigma), outputs.shape[1]))])
        length = np.sqrt((self.system**2).sum(axis=0))
        solution = np.linalg.lstsq(self.system / length, right, rcond=None)[0] / length[:, None]
        residual = right - self.system.astype(np.longdouble) @ solution
        correction = np.linalg.lstsq(self.system / length, residual.astype(float), rcond=None)[0]
        solved: Floats = solution + correction / length[:, None]
        return solved

    def solve(self, means: Floats, mean_variance: Floats | None = None) -> OptimalEstimate:
        """Apply the linear solution, and again to what the second order leaves of the outputs."""
        measured = means[self.fit].reshape(-1, 1)
        x = self.unknowns(measured)
        for _ in range(CORRECTIONS):
            x = self.unknowns(measured - (self._exact(x) - self.model @ x))
        k, u0 = _coefficients(x[:12, 0])
        at_k = _Whitened(self.schedule, k, self.stand, self.samples, self.step, terms=self.terms)
        covariance, sizes = at_k.covariance(mean_variance), x[12 : self.count, 0].reshape(-1, 3)
        angles = self._stand(x)
        largest = float(np.abs(self.unknowns(np.eye(len(measured)))[: self.count]).sum(axis=1).max())
        shared = float(angles["alpha1"]), float(angles["alpha2"]), angles["alpha3"]
        return OptimalEstimate(k, u0, sizes, covariance, *shared, largest, _largest_angle(angles))

    def _noise_of_means(self) -> Floats:
        by_noise = np.maximum(self.one_sample / np.sqrt(self.averaged_over)[:, None], self.floor)
        noise: Floats = np.hypot(by_noise, by_channel(self.stand.rounding))
        return noise

    def covariance(self, mean_variance: Floats | None = None) -> Floats:
        """Of an estimate, K row by row, that is linearised here: with each position's own noise."""
        noise = self._noise_of_means().ravel()
        if mean_variance is not None:
            noise = np.maximum(noise, np.sqrt(mean_variance).ravel())
        errors = {**self.errors, "noise": replace(self.errors["noise"], sigma=noise)}
        return joint(self._linear, errors)

    def _linear(self, means: Floats) -> Floats:
        """Coefficients, K row by row, of (draws, positions, 3)."""
        x = self.unknowns(means[:, self.fit].reshape(len(means), -1).T)[: self.count].T
        return np.concatenate([x[:, _ROW_ORDER], x[:, 9:]], axis=1)

    def _found(self, x: Floats) -> dict[str, Floats]:
        """Every error by its source, rad or as outputs are."""
        parts = np.split(self.sigma * x[self.count :, 0], np.cumsum(list(self.draws.values()))[:-1])
        return dict(zip(self.draws, parts))

    def _stand(self, x: Floats) -> dict[str, Floats]:
        """Every error as `Geometry.force` has it: alpha1, alpha2, then one per mounting, delta per position."""
        errors, mountings = self._found(x), len(self.schedule.mountings)
        seat = errors.get("seat", np.zeros(2 * mountings))
        return {
            "alpha1": errors["alpha1"][0],
            "alpha2": errors["alpha2"][0],
            "alpha3": np.resize(errors["alpha3"], mountings),
            "delta": errors["alpha4"] + errors.get("encoder", np.zeros(4)) @ self.waves,
            "seat_h": seat[:mountings] + errors.get("platform", np.zeros(1)),
            "seat_n": seat[mountings:],
        }

    def _exact(self, x: Floats) -> Floats:
        """Outputs (3 x fit positions, 1) on the exact geometry."""
        k, u0 = _coefficients(x[:12, 0])
        outputs = self.geometry.outputs(k, u0, **self._stand(x))[self.fit]
        outputs = outputs + self.course[:, None] * self._found(x).get("drift", np.zeros(3))
        return outputs.reshape(-1, 1) + self.further @ x[12 : self.count]


def _largest_angle(angles: dict[str, Floats]) -> float:
    turns = angles["alpha2"] + angles["delta"]
    tilts = [np.atleast_1d(angles[name]) for name in ("alpha1", "alpha3", "seat_h", "seat_n")]
    return float(np.abs(np.concatenate([turns, *tilts])).max())


def _coefficients(x: Floats) -> tuple[Floats, Floats]:
    return x[:9].reshape(3, 3).T, x[9:]
