"""The stand-optimal estimator: generalised least squares of the outputs, linearised at a known K,

    y = D beta + J s + e

in which beta are the coefficients, and further terms of the model, s the errors of the stand, with their variances as
prior, and e the noise of the means. The system is whitened and augmented by the prior: no covariance matrix is ever
inverted, so sources may be zero or large. What the exact geometry gives beyond its linearisation is taken out of the
outputs, twice.

It is solved in two ways. `optimal_table` makes gains by QR, which the core evaluates, on board and in a solve;
`optimal_estimate` solves the run itself by singular values, and no table of gains takes part. Its uncertainties are
those of the same problem linearised at the K that came out: gains made at a K that is far off still give a good
estimate, after the second order is taken out, but their own propagation would overstate what they leave.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.errors import UsageError
from tumble.model.errors import (
    Draws,
    Errors,
    by_coefficient,
    by_gains,
    covariance_of,
    declared,
    free,
    of_stand,
    places,
    sources,
)
from tumble.model.estimators import design, require_rank, unknowns
from tumble.schedule import Schedule
from tumble.stand import COMMON, PerChannel, Stand, rounding_of
from tumble.terms import Terms

CORRECTIONS = 2
CORRECTIONS_INCLINED = 4  # inclinations may be off by more than any other error
NOISE_FLOOR_G = 1e-9  # times the largest element of K: the noise of a mean never counts as less
UNEQUAL = "no optimal weights: the stand's errors are too large, or too unequal, to compute with"
LARGEST_LOSS = 1e-5  # of bias and of spread to rounding, before weights are refused
_LARGEST_SIGMA = 1e100
_LARGEST_DRIFT = 1e12  # times the noise of a mean: weights let a drift through by some 1e-16 of it, their rounding
_SHARED = ("alpha1", "alpha2", "alpha3", "platform", "seat", "encoder", "drift", "inclination")  # as records go


def mean_sigma(k: Floats, stand: Stand, step: PerChannel, samples: float) -> tuple[Floats, bool]:
    """Standard deviation (..., 3) of a position's mean, by channel, for blocks of sensitivity `k` (..., 3, 3), and
    whether any is only the floor, NOISE_FLOOR_G of max|K|."""
    floor = NOISE_FLOOR_G * np.abs(k).max(axis=(-2, -1))[..., None]
    sigma = np.maximum(stand.sigmas("noise"), rounding_of(step)) / samples**0.5
    larger: Floats = np.maximum(sigma, floor)
    if not ((larger > 0.0) & (larger < _LARGEST_SIGMA)).all():
        raise UsageError("no optimal weights: K is zero, or the noise beyond any number of volts")
    return larger, bool((sigma < floor).any())


def channel_weights(sigma: Floats) -> Floats:
    """What makes channels of noise `sigma` (..., 3) alike: outputs times these (..., 3) have that of the noisiest."""
    weights: Floats = sigma.max(axis=-1, keepdims=True) / sigma
    return weights


def require_drift(sizes: Floats) -> None:
    """Raise UsageError for a drift of more than so many times the noise of a mean."""
    if not (sizes <= _LARGEST_DRIFT).all():
        said = f"drift_v is {sizes.max():.2g} times the noise of a mean, above {_LARGEST_DRIFT:g}"
        raise UsageError(f"no optimal weights: {said}")


def samples_in_a_mean(schedule: Schedule, stand: Stand, samples: Integers) -> float:
    """As many samples in every fitted mean as give the same noise on the average; `samples` (positions,) as
    Stand.averaged_over takes them."""
    return float(1.0 / (1.0 / stand.averaged_over(samples)[schedule.fit_indices]).mean())


def shared_errors(schedule: Schedule, k: Floats, stand: Stand) -> dict[str, Draws]:
    """The errors that positions share, on a schedule of fit positions: in the order in which records have them."""
    named = {*declared(stand, schedule), *free(stand, schedule)}
    return of_stand(schedule, k, stand, [name for name in _SHARED if name in named])


@dataclass(frozen=True)
class OptimalTable:
    """The optimal estimator of a stand, for a block of sensitivity `k` (3, 3).

    `gains` (12, 3P), with further rows if it was made with further terms; `nuisance_gains` (2 + `yaws` + 2 `seats` +
    `waves` + `drifts` + 2 `inclinations`, 3P): alpha1, alpha2, alpha3..., and where seats are declared theta_h of each
    mounting, the platform's in it, then theta_n of each, then the numbers of the encoder, then drifts, then of
    inclinations beta of each mounting and tau of each; `sigma` (4,) of alpha1 to alpha4, `sigma_inclination` of beta
    and tau, radians, 0 where they may have any size: then they bring nothing to the coefficients; `sigma_mean`: noise
    of a mean of the noisiest channel, and of the others over their `weights` (3,); `u`: standard deviations of the
    estimate, which are the Cramer-Rao bound; `floored`: some noise is the floor and not the stand's.
    """

    k: Floats
    gains: Floats
    nuisance_gains: Floats
    yaws: int
    seats: int
    waves: int
    drifts: int
    inclinations: int
    sigma: Floats
    sigma_inclination: float
    sigma_mean: float
    weights: Floats
    u: Floats
    floored: bool


class Whitened:
    """The problem of a schedule's fit positions, linearised at one K: unknowns are the errors of the stand, over their
    sigma, then the `count` coefficients and sizes. `rows` (n, count): what else is known of these, each of variance 1.
    All rows are scaled to the noise of the noisiest channel."""

    def __init__(
        self, schedule: Schedule, k: Floats, stand: Stand, sigma: Floats, terms: Terms, rows: Floats | None = None
    ):
        self.schedule, self.design, largest = schedule.fitted, design(schedule, terms), float(sigma.max())
        self.found = shared_errors(self.schedule, k, stand) | of_stand(self.schedule, k, stand, ["alpha4"])
        self.errors, self.count = Errors(self.schedule, self.found), self.design.shape[1]
        derivative = np.concatenate([source.derivative for source in self.found.values()])
        self.by_error = derivative.reshape(len(derivative), -1).T * self.errors.sigma
        self.model = np.hstack([self.by_error, self.design])
        self.expected = derivative.reshape(len(derivative), -1).T @ self.errors.mean
        self.corrections = CORRECTIONS_INCLINED if "inclination" in self.found else CORRECTIONS
        self.weights = np.tile(channel_weights(sigma), len(self.design) // 3)
        prior = largest * np.eye(self.by_error.shape[1], self.model.shape[1])
        self._rows = np.zeros((0, self.count)) if rows is None else rows
        known = largest * np.hstack([np.zeros((len(self._rows), self.by_error.shape[1])), self._rows])
        self._known = largest * np.eye(len(self._rows))
        self.system = np.vstack([self.model * self.weights[:, None], prior, known])

    @cached_property
    def _length(self) -> Floats:
        length: Floats = np.sqrt((self.system**2).sum(axis=0))
        return length

    def solve(self, outputs: Floats, known: Floats | None = None) -> Floats:
        """Best estimate of all unknowns, for outputs (3 x fit positions, any number of columns), by singular values;
        `known` (n, as many columns): what the rows are known to be, 0 unless given."""
        right = np.zeros((len(self.system), outputs.shape[1]))
        right[: len(outputs)] = outputs * self.weights[:, None]
        if known is not None:
            right[len(right) - len(known) :] = self._known @ known
        solution = np.linalg.lstsq(self.system / self._length, right, rcond=None)[0] / self._length[:, None]
        residual = right - self.system.astype(np.longdouble) @ solution
        better = np.linalg.lstsq(self.system / self._length, residual.astype(float), rcond=None)[0]
        solved: Floats = solution + better / self._length[:, None]
        return solved

    def sizes(self, x: Floats) -> Floats:
        """Every error, rad or as outputs are, of unknowns (runs, n)."""
        sizes: Floats = x[:, : -self.count] * self.errors.sigma
        return sizes

    def solve_exactly(self, measured: Floats, known: Floats | None = None) -> tuple[Floats, Floats]:
        """All unknowns (runs, n) on the exact geometry, from `measured` (runs, fit positions, 3); and the outputs
        (runs, 3 x fit positions) without what this has beyond its linearisation, and without what the declared means of
        the errors add. `known` (n,): of the rows, alike in all runs."""
        corrected = measured = measured.reshape(len(measured), -1) - self.expected
        of_rows = None if known is None else np.repeat(known[:, None], len(measured), axis=1)
        x = self.solve(measured.T, of_rows).T
        for _ in range(self.corrections):
            found, sizes = x[:, -self.count :], self.sizes(x) + self.errors.mean
            exact = self.errors.outputs(found[:, :9].reshape(-1, 3, 3), found[:, 9:12], sizes)
            further = found[:, 12:] @ self.design[:, 12:].T
            corrected = measured - (exact.reshape(measured.shape) + further - x @ self.model.T - self.expected)
            x = self.solve(corrected.T, of_rows).T
        return x, corrected

    @cached_property
    def gains(self) -> Floats:
        """Of the coefficients and sizes (count, 3 x fit positions)."""
        return self.solve(np.eye(len(self.design)))[-self.count :]

    @cached_property
    def gains_of_rows(self) -> Floats:
        """Of the coefficients and sizes (count, n), by what the rows are known to be."""
        count = len(self._rows)
        return self.solve(np.zeros((len(self.design), count)), np.eye(count))[-self.count :]


def optimal_table(
    schedule: Schedule,
    k: Floats,
    stand: Stand,
    step: PerChannel = 0.0,
    samples: float | None = None,
    terms: Terms = (),
) -> OptimalTable:
    """The optimal estimator. `step`: of the converter, in the outputs' unit, 0 if unknown; `samples`: in a mean, the
    stand's unless given; `terms`: further unknowns, which the positions determine.

    Raises UsageError where the schedule cannot identify all coefficients, or the numbers are beyond any stand.
    """
    require_rank(schedule)
    k = np.asarray(k, dtype=float)
    sigma, floored = mean_sigma(k, stand, step, stand.samples if samples is None else samples)
    require_drift(stand.sigmas("drift") / sigma)
    whitened = Whitened(schedule, k, stand, sigma, terms)
    errors, outputs = len(whitened.errors.sigma), len(whitened.design)
    q, r = np.linalg.qr(whitened.system)
    data = q[:outputs].T
    with np.errstate(all="ignore"):
        beta = np.linalg.solve(r[errors:, errors:], data[errors:])
        prior = np.linalg.solve(r[:errors, :errors], data[:errors] - r[:errors, errors:] @ beta)
        u = float(sigma.max()) * np.sqrt((np.linalg.inv(r[errors:, errors:]) ** 2).sum(axis=1))
        beta, prior = beta * whitened.weights, prior * whitened.weights
        lost = np.abs(beta @ whitened.design - np.eye(len(beta))).max()
        claimed = _deviations(beta, whitened.by_error, sigma)
    if not (np.isfinite(prior).all() and lost < LARGEST_LOSS and (np.abs(claimed - u) < LARGEST_LOSS * u).all()):
        raise UsageError(UNEQUAL)
    mountings, named = len(schedule.mountings), declared(stand, schedule)
    yaws = 1 if stand.remounting == COMMON or len(schedule.boltings) == 1 else mountings
    seats = mountings if stand.declares_seat else 0
    counts = yaws, seats, 4 if "encoder" in named else 0, 3 if "drift" in named else 0
    inclined, sigma_inclination = "inclination" in whitened.found, stand.sigma("inclination")
    nuisance = by_mounting(prior * whitened.errors.sigma[:, None], whitened.found, whitened.schedule, stand)
    sigmas = np.array([stand.sigma(name) for name in ("axis_tilt", "level", "remount", "angle")])
    of_inclinations = mountings if inclined else 0, sigmas, sigma_inclination if "inclination" in named else 0.0
    return OptimalTable(
        *(k, beta, nuisance, *counts, *of_inclinations), float(sigma.max()), channel_weights(sigma), u, floored
    )


def by_mounting(found: Floats, errors: dict[str, Draws], schedule: Schedule, stand: Stand) -> Floats:
    """Gains (..., rows, 3P) of what positions share, as a table has them: that of the platform is in the seat of each
    mounting. `found` (..., draws, 3P): of `errors`."""
    of, boltings = places(errors), schedule.boltings
    bolted = [next(b for b, one in enumerate(boltings) if m in one) for m in range(len(schedule.mountings))]
    rows = [found[..., of[name], :] for name in ("alpha1", "alpha2", "alpha3")]
    if rows[2].shape[-2] > 1:
        rows[2] = rows[2][..., bolted, :]
    if stand.declares_seat:
        none = np.zeros((*found.shape[:-2], 2 * len(boltings), found.shape[-1]))
        seats = found[..., of["seat"], :] if "seat" in of else none
        leaning, turned = (one[..., bolted, :] for one in np.split(seats, 2, axis=-2))
        rows += [leaning + (found[..., of["platform"], :] if "platform" in of else 0.0), turned]
    rows += [found[..., of[name], :] for name in ("encoder", "drift") if name in of]
    if "inclination" in of:
        units = errors["inclination"].units
        rows += [units[argument].T @ found[..., of["inclination"], :] for argument in ("alpha1", "seat_n")]
    return np.concatenate(rows, axis=-2)


def _deviations(weights: Floats, by_error: Floats, sigma_mean: Floats) -> Floats:
    by_noise = (weights**2).reshape(len(weights), -1, 3).sum(axis=1) @ sigma_mean**2
    deviations: Floats = np.sqrt(((weights @ by_error) ** 2).sum(axis=1) + by_noise)
    return deviations


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


def optimal_estimate(
    schedule: Schedule,
    means: Floats,
    stand: Stand,
    samples: Integers,
    step: PerChannel = 0.0,
    known_k: Floats | None = None,
    known_samples: float | None = None,
    mean_variance: Floats | None = None,
    terms: Terms = (),
    seen: Schedule | None = None,
) -> OptimalEstimate:
    """Solve one run. `means` (positions, 3), `samples` (positions,) as in `errors.sources`; `step` of the
    converter in the outputs' unit, 0 where unknown; `known_k`: linearise there instead of at a first estimate. Weights
    take the noise of all means as equal, with the average of 1/N, or with N = `known_samples`. `mean_variance` as in
    `errors.sources`: of the uncertainties alone. `terms`: further unknowns. `seen`: the schedule with the inclinations
    that the run shows, which the uncertainties are for."""
    first = unknowns(schedule, means, "least_squares")[:9].reshape(3, 3) if known_k is None else known_k
    number = samples_in_a_mean(schedule, stand, samples) if known_samples is None else known_samples
    whitened = Whitened(schedule, first, stand, mean_sigma(first, stand, step, number)[0], terms)
    x, _ = whitened.solve_exactly(means[None, schedule.fit_indices])
    found, angles = x[0, -whitened.count :], whitened.errors.arguments(whitened.sizes(x)[0])
    tilts = [angles[name] for name in ("alpha1", "alpha3", "seat_h", "seat_n") if name in angles]
    k = found[:9].reshape(3, 3)
    covariance = optimal_covariance(seen or schedule, k, stand, samples, step, mean_variance, terms)
    return OptimalEstimate(
        *(k, found[9:12], found[12:].reshape(-1, 3), covariance, float(angles["alpha1"][0])),
        *(float(angles["alpha2"][0]), np.resize(angles["alpha3"], len(schedule.mountings))),
        magnification=float(np.abs(whitened.gains).sum(axis=1).max()),
        largest_angle=float(np.abs(np.concatenate([angles["alpha2"] + angles["delta"], *tilts])).max()),
    )


def by_table(table: OptimalTable, schedule: Schedule, stand: Stand, terms: Terms, means: Floats) -> Floats:
    """All unknowns (runs, 12 + 3 x terms) of means (runs, positions, 3) by the gains of a table that was made with
    further `terms`, which the core does not evaluate."""
    whitened = Whitened(schedule, table.k, stand, table.sigma_mean / table.weights, terms)
    corrected = whitened.solve_exactly(means[:, schedule.fit_indices])[1]
    found: Floats = corrected @ table.gains.T
    return found


def optimal_covariance(
    schedule: Schedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    step: PerChannel,
    mean_variance: Floats | None = None,
    terms: Terms = (),
    known_samples: float | None = None,
) -> Floats:
    """Covariance (12, 12), with `terms` also of their sizes, of `optimal` for a block that has this `k`: with each
    position's own noise. Arguments as of `optimal`; `mean_variance` (positions, 3): what the noise of a mean counts at
    least."""
    number = samples_in_a_mean(schedule, stand, samples) if known_samples is None else known_samples
    whitened = Whitened(schedule, k, stand, mean_sigma(k, stand, step, number)[0], terms)
    least = (NOISE_FLOOR_G * np.abs(k).max()) ** 2
    variance = np.maximum(0.0 if mean_variance is None else mean_variance, least)
    errors = sources(schedule, k, stand.with_step(step), samples, variance)
    return covariance_of(by_gains(schedule, whitened.gains), errors)
