"""K and U0 as polynomials of the block's temperature, from runs at several temperatures.

    U_rp = U0(T_rp) + K(T_rp) f_rp(s_r) + noise,   K(T) = sum over m of K_m (T - T0)^m,   U0(T) likewise

with r a run, p a position of it, T_rp the temperature there and s_r the errors of the stand in that run. Unknown are
the 12 (degree + 1) coefficients and all errors, each of these with its declared variance as prior; an error that stays
from run to run is one unknown for all of them. The smallest sum of squares, outputs and errors in units of their
standard deviations, is found by Gauss-Newton on the exact geometry. With degree 0 it is that of model.fit.

Where it is linear, the coefficients are those of generalised least squares: beta = (D^T C^-1 D)^-1 D^T C^-1 U, with
C = J S J^T + N over all runs.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats
from tumble.distributions import chi_squared_above
from tumble.model.coefficients import outputs_by_coefficient, with_length
from tumble.model.errors import NOISE, Draws, Errors
from tumble.model.geometry import STEP, ideal_force
from tumble.schedule import Schedule

_PASSES = 30  # each leaves a tenth or less of the change before it
_SETTLED = 1e-12  # of the largest coefficient
_WEAK = 1e-6  # singular value of the design over its largest, columns of length 1
_AT_ONCE = 1 << 14  # samples: what an uncertainty needs for one is 200 numbers
_LEAST_SINGULAR = 0.02  # of powers of the scaled temperatures, over the root of their number: two runs show no parabola


class NotShown(ValueError):
    """The runs do not show all coefficients."""


class TooAlike(NotShown):
    """Their positions and temperatures would not, whatever the outputs."""


@dataclass(frozen=True)
class Polynomials:
    """`k` (degree + 1, 3, 3) and `u0` (degree + 1, 3) by power of (T - `reference_c`) / 1 K."""

    reference_c: float
    k: Floats
    u0: Floats

    def at(self, temperature_c: float | Floats) -> tuple[Floats, Floats]:
        """K (..., 3, 3) and U0 (..., 3) at temperatures (...)."""
        powers = _powers(np.asarray(temperature_c) - self.reference_c, len(self.k))
        return np.tensordot(powers, self.k, axes=1), np.tensordot(powers, self.u0, axes=1)


@dataclass(frozen=True)
class ThermalRun:
    """`means` (positions, 3) on a `schedule`, at `temperature_c` (positions,); `found`: every source of error of its
    stand, the noise of the means among them."""

    schedule: Schedule
    means: Floats
    temperature_c: Floats
    found: Mapping[str, Draws]


@dataclass(frozen=True)
class ThermalFit:
    """`covariance` (n, n) of the coefficients: by power, K row by row, then U0. `chi_squared` with so many degrees of
    `freedom`."""

    polynomials: Polynomials
    covariance: Floats
    chi_squared: float
    freedom: int

    @property
    def p(self) -> float:
        """Probability of a chi-squared at least as large."""
        return chi_squared_above(self.chi_squared, self.freedom) if self.freedom else 1.0

    def of(self, outputs: Floats, temperature_c: Floats) -> Floats:
        """The force (samples, 3) of `outputs` (samples, 3) at temperatures (samples,)."""
        k, u0 = self.polynomials.at(temperature_c)
        force: Floats = np.asarray(np.linalg.solve(k, (outputs - u0)[..., None])[..., 0], dtype=float)
        return force

    def uncertainty(self, force: Floats, temperature_c: Floats) -> Floats:
        """Standard uncertainties (samples, 4) of the components of a `force` (samples, 3) at temperatures (samples,),
        and of its length, as model.coefficients.Force has them."""
        found = [np.zeros((0, 4))]
        for start in range(0, len(force), _AT_ONCE):
            own = slice(start, start + _AT_ONCE)
            to_force: Floats = np.asarray(np.linalg.inv(self.polynomials.at(temperature_c[own])[0]), dtype=float)
            by_row = with_length(to_force, force[own]) @ outputs_by_coefficient(force[own])
            powers = _powers(temperature_c[own] - self.polynomials.reference_c, len(self.polynomials.k))
            gradient = np.einsum("nm,nic->nimc", powers, by_row).reshape(len(by_row), 4, -1)
            variance = ((gradient @ self.covariance) * gradient).sum(axis=2)
            found.append(np.sqrt(np.maximum(variance, 0.0)))
        return np.concatenate(found)

    def covariance_at(self, temperature_c: float) -> Floats:
        """Of K row by row and U0 at a temperature: (12, 12)."""
        at = temperature_c - self.polynomials.reference_c
        by = np.hstack([at**power * np.eye(12) for power in range(len(self.covariance) // 12)])
        found: Floats = by @ self.covariance @ by.T
        return (found + found.T) / 2.0


def fit(runs: Sequence[ThermalRun], degree: int, reference_c: float, kept: Collection[str] = ()) -> ThermalFit:
    """Fit all runs at once; the errors of sources named in `kept` stay from run to run. Raises NotShown."""
    scale = max(float(np.abs(one.temperature_c - reference_c).max()) for one in runs) or 1.0
    system = System(runs, degree, [(one.temperature_c - reference_c) / scale for one in runs], kept)
    beta, sizes = system.start(), np.zeros(system.count)
    for _ in range(_PASSES):
        rows, left = system.linearised(beta, sizes)
        length = np.sqrt((rows**2).sum(axis=0))
        q, r = np.linalg.qr(rows / length)
        change = np.linalg.solve(r, q.T @ left) / length
        beta, sizes = beta + change[: len(beta)], sizes + change[len(beta) :]
        if np.abs(change[: len(beta)]).max() <= _SETTLED * np.abs(beta).max():
            break
    else:
        raise NotShown("the runs and their stand have no common solution")
    left = system.linearised(beta, sizes)[1]
    root = np.linalg.inv(r)[: len(beta)] / length[: len(beta), None]
    back = np.repeat(scale ** -np.arange(degree + 1.0), 12)  # to powers of kelvins
    coefficients, root = (beta * back).reshape(degree + 1, 12), root * back[:, None]
    polynomials = Polynomials(reference_c, coefficients[:, :9].reshape(-1, 3, 3), coefficients[:, 9:])
    outputs = 3 * sum(len(one.means) for one in runs)
    freedom = outputs - len(beta) - system.free
    return ThermalFit(polynomials, root @ root.T, float(left @ left), freedom)


def _powers(at: Floats, count: int) -> Floats:
    """(..., count)."""
    found: Floats = np.asarray(at)[..., None] ** np.arange(count)
    return found


class System:
    """The equations of all runs. Unknowns: coefficients of powers of the scaled temperatures `at`, then `count` errors
    over their sigma, of which `free` have no prior."""

    def __init__(self, runs: Sequence[ThermalRun], degree: int, at: Sequence[Floats], kept: Collection[str]):
        self._runs, self._powers = runs, [_powers(one, degree + 1) for one in at]
        others = [{name: one for name, one in run.found.items() if name != NOISE} for run in runs]
        self._errors = [Errors(run.schedule, found) for run, found in zip(runs, others)]
        self._sigma = [run.found[NOISE].sigma for run in runs]
        self._places: list[np.ndarray] = []
        first: dict[str, np.ndarray] = {}
        sigma: list[float] = []
        priors: list[bool] = []
        for errors in self._errors:
            place = np.zeros(len(errors.sigma), dtype=int)
            for name, own in errors.of.items():
                count = own.stop - own.start
                if name in kept and name in first and len(first[name]) != count:
                    raise NotShown(f"runs on different schedules have no {name} in common")
                if name not in kept or name not in first:
                    first[name] = np.arange(len(sigma), len(sigma) + count)
                    sigma += errors.sigma[own].tolist()
                    priors += (~errors.free[own]).tolist()
                place[own] = first[name]
            self._places.append(place)
        self.count, self._priors = len(sigma), np.flatnonzero(priors)
        self.free = self.count - len(self._priors)

    def start(self) -> Floats:
        """The coefficients on the ideal stand. Raises NotShown."""
        rows = [self._design(run, ideal_force(one.schedule)) for run, one in enumerate(self._runs)]
        sigma = np.concatenate(self._sigma)
        design = np.concatenate(rows) / sigma[:, None]
        length = np.sqrt((design**2).sum(axis=0))
        singular = np.linalg.svd(design / np.maximum(length, 1e-300), compute_uv=False)
        powers = np.concatenate(self._powers)
        apart = np.linalg.svd(powers, compute_uv=False)[-1] / len(powers) ** 0.5
        if len(design) < design.shape[1] or singular[-1] < _WEAK * singular[0] or apart < _LEAST_SINGULAR:
            raise TooAlike("these positions and temperatures do not show all coefficients")
        means = np.concatenate([one.means.ravel() for one in self._runs]) / sigma
        found: Floats = np.linalg.lstsq(design / length, means, rcond=None)[0] / length
        return found

    def _design(self, run: int, force: Floats) -> Floats:
        """Outputs by coefficients (3 x positions, n) at forces (positions, 3)."""
        felt = np.zeros((len(force), 3, 12))
        for channel in range(3):
            felt[:, channel, 3 * channel : 3 * channel + 3] = force
            felt[:, channel, 9 + channel] = 1.0
        by_power: Floats = np.einsum("pm,pcn->pcmn", self._powers[run], felt)
        return by_power.reshape(3 * len(force), -1)

    def linearised(self, beta: Floats, sizes: Floats) -> tuple[Floats, Floats]:
        """Rows of the system and what is left of them, in units of their standard deviations."""
        blocks, left = [], []
        for run, (errors, place, sigma) in enumerate(zip(self._errors, self._places, self._sigma)):
            x, each = sizes[place] * errors.sigma, np.eye(len(place))
            force, k = errors.force(x), self._k(run, beta)
            by_force = np.imag(errors.force(x + 1j * STEP * each)) / STEP
            by_error = np.einsum("dpj,pij->dpi", by_force, k) + errors.added(each)
            block = np.zeros((3 * len(force), len(beta) + self.count))
            block[:, : len(beta)] = self._design(run, force)
            block[:, len(beta) + place] = by_error.reshape(len(place), -1).T * errors.sigma
            blocks.append(block / sigma[:, None])
            left.append(self._left(run, beta, x) / sigma)
        prior = np.zeros((len(self._priors), len(beta) + self.count))
        prior[np.arange(len(prior)), len(beta) + self._priors] = 1.0
        return np.concatenate([*blocks, prior]), np.concatenate([*left, -(sizes - self._means())[self._priors]])

    def _means(self) -> Floats:
        """Of the priors (errors,), over their sigma."""
        found = np.zeros(self.count)
        for errors, place in zip(self._errors, self._places):
            found[place] = np.divide(errors.mean, errors.sigma, out=np.zeros(len(place)), where=errors.sigma > 0.0)
        return found

    def _k(self, run: int, beta: Floats) -> Floats:
        """At every position (positions, 3, 3)."""
        found: Floats = np.tensordot(self._powers[run], beta.reshape(-1, 12)[:, :9].reshape(-1, 3, 3), axes=1)
        return found

    def _left(self, run: int, beta: Floats, x: Floats) -> Floats:
        """Outputs measured less those of the model (3 x positions,)."""
        errors, means = self._errors[run], self._runs[run].means
        found: Floats = (means - errors.added(x)).ravel() - self._design(run, errors.force(x)) @ beta
        return found
