"""Linear gains of every estimator on a schedule: coefficients = gains times position means.

Gains have the shape (12, 3 x fit positions): rows K row by row, then U0; one column per fit position and channel, in
the schedule's order, the channel running fastest. K in V/g (or any unit of the outputs per g); a stand's noise is in
that unit too.

The optimal estimator is generalised least squares of the outputs, linearised at a known K,

    y = A beta + J s + D delta + e

in which beta are the twelve coefficients, s = (alpha1, alpha2, alpha3 of each mounting, or one alpha3 for all; where
seats are declared, theta_h of the platform, then theta_h and theta_n of each mounting; the four numbers of the encoder
and the drift of each channel, where these are declared) and
delta the errors of the set angles, with the stand's variances as their prior, and e the noise of the means. It is
solved by QR of the whitened system, augmented by the prior: no covariance matrix is ever inverted, so sources may be
zero or large.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from tumble import reference
from tumble.arrays import Floats, Integers
from tumble.errors import UsageError
from tumble.estimators import HARMONIC, OPTIMAL
from tumble.reference.estimators import circles, fit_indices, unidentified
from tumble.schedule import Schedule
from tumble.stand import COMMON, PerChannel, Stand, by_channel, rounding_of

NOISE_FLOOR_G = 1e-9  # times the largest element of K: the noise of a mean never counts as less
UNEQUAL = "no optimal weights: the stand's errors are too large, or too unequal, to compute with"
_LARGEST_SIGMA = 1e100
_LARGEST_DRIFT = 1e12  # times the noise of a mean: weights let a drift through by some 1e-16 of it, their rounding
_REMEMBERED = 64  # schedules: a plan asks for the same one thousands of times
LARGEST_LOSS = 1e-5  # of bias and of spread to rounding, before weights are refused


@dataclass(frozen=True)
class Linearised:
    """The outputs of the fit positions to first order: ideal force and its derivatives in g, (P, 3) each.

    `alpha3` and `theta_h` are the derivatives by the yaw and the seat of a position's own mounting; `delta` also those
    by alpha2 and by theta_n. `waves` (P, 4): what a unit of each number of the encoder adds to the table angle;
    `course` (P,): how far the run has come, -1/2 to 1/2. `mounting` (P,): index of each position's mounting, of so many
    `mountings`.
    """

    force: Floats
    alpha1: Floats
    alpha3: Floats
    theta_h: Floats
    delta: Floats
    waves: Floats
    course: Floats
    mounting: Integers
    mountings: int


@dataclass(frozen=True)
class OptimalTable:
    """The optimal estimator of a stand, for a block of sensitivity `k` (3, 3).

    `gains` (12, 3P), with further rows if it was made with further columns; `nuisance_gains` (2 + `yaws` + 2 `seats` +
    `waves` + `drifts`, 3P): alpha1, alpha2, alpha3..., and where seats are declared theta_h of each mounting, the
    platform's in it, then theta_n of each, then the numbers of the encoder, then drifts; `sigma_shared`, as
    shared_sigmas has it, and `sigma_angle`: the prior, radians; `sigma_mean`: noise of a mean of the noisiest
    channel, and of the others over their `weights` (3,); `u`: standard deviations of the estimate, which are the
    Cramer-Rao bound; `floored`: some noise is the floor and not the stand's.
    """

    k: Floats
    gains: Floats
    nuisance_gains: Floats
    yaws: int
    seats: int
    waves: int
    drifts: int
    sigma_shared: Floats
    sigma_angle: float
    sigma_mean: float
    weights: Floats
    u: Floats
    floored: bool


def gains(schedule: Schedule, estimator: str, k: Floats, stand: Stand, step: PerChannel = 0.0) -> Floats:
    """Gains (12, 3P) of an estimator; `k`, `stand` and `step` (see `optimal_table`) matter to optimal alone."""
    return optimal_table(schedule, k, stand, step).gains if estimator == OPTIMAL else linear_gains(schedule, estimator)


@lru_cache(_REMEMBERED)
def linear_gains(schedule: Schedule, estimator: str) -> Floats:
    """Gains (12, 3P) of a linear estimator. Raises UsageError where the schedule does not allow that estimator."""
    if estimator in HARMONIC and circles(schedule) is None:
        raise UsageError(f"the schedule lacks positions that {estimator} needs; least_squares solves any schedule")
    _require_rank(schedule)
    positions = len(schedule.positions)
    k, u0 = reference.estimate(schedule, np.eye(3 * positions).reshape(-1, positions, 3), estimator)
    columns = np.concatenate([k.reshape(-1, 9), u0], axis=1).reshape(positions, 3, 12)[fit_indices(schedule)]
    return columns.reshape(-1, 12).T.copy()


def optimal_table(
    schedule: Schedule,
    k: Floats,
    stand: Stand,
    step: PerChannel = 0.0,
    samples: float | None = None,
    further: Floats | None = None,
) -> OptimalTable:
    """The optimal estimator. `step`: of the converter, in the outputs' unit, 0 if unknown; `samples`: in a mean, the
    stand's unless given; `further` (3P, n): outputs by unknowns beside the twelve, which the positions determine.

    Raises UsageError where the schedule cannot identify all coefficients, or the numbers are beyond any stand.
    """
    _require_rank(schedule)
    k = np.asarray(k, dtype=float)
    sigma, floored = mean_sigma(k, stand, step, stand.samples if samples is None else samples)
    sigma_mean, weights = float(sigma.max()), channel_weights(sigma)
    require_drift(stand.sigmas("drift") / sigma)
    shared, angle = shared_sigmas(schedule, stand), stand.sigma("angle")
    model = linearise(schedule)
    by_unknown = design(model) if further is None else np.hstack([design(model), further])
    system = _augmented(by_unknown, model, k, stand, shared, angle, sigma)
    nuisances = len(shared) + len(model.force)
    q, r = np.linalg.qr(system)
    by_column = np.tile(weights, len(model.force))
    data = q[: 3 * len(model.force)].T
    with np.errstate(all="ignore"):
        beta = np.linalg.solve(r[nuisances:, nuisances:], data[nuisances:])
        prior = np.linalg.solve(r[:nuisances, :nuisances], data[:nuisances] - r[:nuisances, nuisances:] @ beta)
        u = sigma_mean * np.sqrt((np.linalg.inv(r[nuisances:, nuisances:]) ** 2).sum(axis=1))
        beta, prior = beta * by_column, prior * by_column
        lost = np.abs(beta @ by_unknown - np.eye(len(beta))).max()
        claimed = standard_deviations(schedule, beta, k, stand, sigma)
    if not (np.isfinite(prior).all() and lost < LARGEST_LOSS and (np.abs(claimed - u) < LARGEST_LOSS * u).all()):
        raise UsageError(UNEQUAL)
    nuisance_gains = by_mounting(shared[:, None] * prior[: len(shared)], schedule, stand)
    seats = len(schedule.mountings) if stand.declares_seat else 0
    counts = yaws_of(schedule, stand), seats, *_waves_and_drifts(stand)
    return OptimalTable(k, beta, nuisance_gains, *counts, shared, angle, sigma_mean, weights, u, floored)


def channel_weights(sigma: Floats) -> Floats:
    """What makes channels of noise `sigma` (..., 3) alike: outputs times these (..., 3) have that of the noisiest."""
    weights: Floats = sigma.max(axis=-1, keepdims=True) / sigma
    return weights


def require_drift(sizes: Floats) -> None:
    """Raise UsageError for a drift of more than so many times the noise of a mean."""
    if not (sizes <= _LARGEST_DRIFT).all():
        said = f"drift_v is {sizes.max():.2g} times the noise of a mean, above {_LARGEST_DRIFT:g}"
        raise UsageError(f"no optimal weights: {said}")


def standard_deviations(
    schedule: Schedule, weights: Floats, k: Floats, stand: Stand, sigma_mean: float | Floats
) -> Floats:
    """Standard deviations (rows,) of an estimate with gains `weights` (rows, 3P), for a block of sensitivity `k` and
    means with noise `sigma_mean`, of each channel or of all."""
    model, shared = linearise(schedule), shared_sigmas(schedule, stand)
    by_shared = weights @ (shared_derivatives(model, k, stand) * shared)
    by_angle = np.einsum("cpi,pi->cp", weights.reshape(len(weights), -1, 3), model.delta @ k.T) * stand.sigma("angle")
    by_noise = (weights**2).reshape(len(weights), -1, 3).sum(axis=1) @ by_channel(sigma_mean) ** 2
    sigmas: Floats = np.sqrt((by_shared**2).sum(axis=1) + (by_angle**2).sum(axis=1) + by_noise)
    return sigmas


def yaws_of(schedule: Schedule, stand: Stand) -> int:
    """How many yaws there are: one for each mounting, or for all."""
    return 1 if stand.remounting == COMMON else len(schedule.mountings)


def shared_sigmas(schedule: Schedule, stand: Stand) -> Floats:
    """Standard deviations of what positions share: alpha1, alpha2, then alpha3 of each mounting or of all; where seats
    are declared theta_h of the platform, then theta_h and theta_n of each mounting; then the encoder's numbers and the
    channels' drifts, each where it is declared."""
    angles = [stand.sigma("axis_tilt"), stand.sigma("level"), *[stand.sigma("remount")] * yaws_of(schedule, stand)]
    seats = [stand.sigma("platform"), *[stand.sigma("seat")] * (2 * len(schedule.mountings))]
    waves, drifts = _waves_and_drifts(stand)
    course = [stand.sigma("encoder")] * waves + stand.sigmas("drift").tolist()[:drifts]
    return np.array(angles + (seats if stand.declares_seat else []) + course)


def _waves_and_drifts(stand: Stand) -> tuple[int, int]:
    """How many numbers of an encoder are declared, and how many drifts."""
    return 4 if stand.encoder > 0.0 else 0, 3 if stand.declares_drift else 0


def mean_sigma(k: Floats, stand: Stand, step: PerChannel, samples: float) -> tuple[Floats, bool]:
    """Standard deviation (..., 3) of a position's mean, by channel, for blocks of sensitivity `k` (..., 3, 3), and
    whether any is only the floor, NOISE_FLOOR_G of max|K|."""
    floor = NOISE_FLOOR_G * np.abs(k).max(axis=(-2, -1))[..., None]
    sigma = np.maximum(stand.sigmas("noise"), rounding_of(step)) / samples**0.5
    larger: Floats = np.maximum(sigma, floor)
    if not ((larger > 0.0) & (larger < _LARGEST_SIGMA)).all():
        raise UsageError("no optimal weights: K is zero, or the noise beyond any number of volts")
    return larger, bool((sigma < floor).any())


@lru_cache(_REMEMBERED)
def linearise(schedule: Schedule) -> Linearised:
    """Forces and derivatives at zero error, from the geometry differentiated by hand."""
    fit = [schedule.positions[index] for index in fit_indices(schedule)]
    numbers = [mounting.number for mounting in schedule.mountings]
    mounting = np.array([numbers.index(position.mounting) for position in fit])
    rotation = np.array([m.matrix for m in schedule.mountings], dtype=float)[mounting]
    tilt = np.deg2rad([schedule.mountings[index].tilt_deg for index in mounting])
    phi = np.deg2rad([position.angle_deg for position in fit])
    s, c, sine, cosine, zero = np.sin(phi), np.cos(phi), np.sin(tilt), np.cos(tilt), np.zeros(len(fit))

    def on_block(*table_axes: Floats) -> Floats:
        forces: Floats = np.einsum("pij,pj->pi", rotation, np.stack(table_axes, axis=-1))
        return forces

    return Linearised(
        force=on_block(cosine * s, sine, cosine * c),
        alpha1=on_block(-sine * s, cosine, -sine * c),
        alpha3=on_block(sine, -cosine * s, zero),
        theta_h=on_block(zero, cosine * c, -sine),
        delta=on_block(cosine * c, zero, -cosine * s),
        waves=np.column_stack([s, c, 2.0 * s * c, c**2 - s**2]),
        course=np.arange(len(fit)) / max(1, len(fit) - 1) - 0.5,
        mounting=mounting,
        mountings=len(schedule.mountings),
    )


def exact_force(schedule: Schedule, alpha1: Floats, turn: Floats, lean: Floats, yaw: Floats) -> Floats:
    """Force (..., P, 3), g, on a stand with errors (..., P) at the fit positions: `turn` is all that adds to the table
    angle, `lean` theta_h, `yaw` alpha3. Two axes at a time are turned as a complex number."""
    fit = [schedule.positions[index] for index in fit_indices(schedule)]
    mountings = {mounting.number: mounting for mounting in schedule.mountings}
    rotation = np.array([mountings[position.mounting].matrix for position in fit], dtype=float)
    tilt = np.deg2rad([mountings[position.mounting].tilt_deg for position in fit]) + alpha1
    phi = np.deg2rad([position.angle_deg for position in fit]) + turn
    across = np.cos(tilt) * np.exp(1j * phi)  # v + i h
    leaning = (np.sin(tilt) + 1j * across.real) * np.exp(-1j * lean)  # n + i v
    yawed = (across.imag + 1j * leaning.real) * np.exp(-1j * yaw)  # h + i n
    on_table = np.stack([yawed.real, yawed.imag, leaning.imag], axis=-1)
    force: Floats = np.einsum("pij,...pj->...pi", rotation, on_table)
    return force


def design(model: Linearised) -> Floats:
    """A (3P, 12): outputs by coefficients."""
    with_bias = np.column_stack([model.force, np.ones(len(model.force))])
    by_channel = np.einsum("pj,ic->picj", with_bias, np.eye(3))
    return np.concatenate([by_channel[..., :3].reshape(-1, 9), by_channel[..., 3].reshape(-1, 3)], axis=1)


def shared_derivatives(model: Linearised, k: Floats, stand: Stand) -> Floats:
    """J (3P, shared): outputs by what positions share, in the order of shared_sigmas."""
    one, each = np.ones((len(model.force), 1)), np.eye(model.mountings)[model.mounting]
    errors = [(one, model.alpha1), (one, model.delta), (one if stand.remounting == COMMON else each, model.alpha3)]
    if stand.declares_seat:
        errors += [(one, model.theta_h), (each, model.theta_h), (each, model.delta)]
    waves, drifts = _waves_and_drifts(stand)
    if waves:
        errors.append((model.waves, model.delta))
    force = np.concatenate([draws[..., None] * by_error[:, None] for draws, by_error in errors], axis=1)
    by_angles = np.swapaxes(force @ k.T, 1, 2).reshape(3 * len(force), -1)
    by_drift = np.kron(model.course[:, None], np.eye(3)[:, :drifts])
    return np.hstack([by_angles, by_drift])


def by_mounting(found: Floats, schedule: Schedule, stand: Stand) -> Floats:
    """Gains (..., rows, 3P) of what positions share, with that of the platform in the seat of each mounting, where it
    is felt."""
    if not stand.declares_seat:
        return found
    angles, mountings = 2 + yaws_of(schedule, stand), len(schedule.mountings)
    platform, leaning, others = np.split(found[..., angles:, :], [1, 1 + mountings], axis=-2)
    return np.concatenate([found[..., :angles, :], platform + leaning, others], axis=-2)


def _augmented(
    by_unknown: Floats, model: Linearised, k: Floats, stand: Stand, shared: Floats, angle: float, sigma: Floats
) -> Floats:
    """[J S, D sigma4, A] over the prior's rows, all times the noise of the noisiest channel: unknowns of the prior have
    unit variance."""
    positions = len(model.force)
    by_angle = np.zeros((positions, 3, positions))
    by_angle[np.arange(positions), :, np.arange(positions)] = angle * model.delta @ k.T
    errors = np.column_stack([shared_derivatives(model, k, stand) * shared, by_angle.reshape(-1, positions)])
    data = np.column_stack([errors, by_unknown])
    weighted = data * np.tile(channel_weights(sigma), positions)[:, None]
    return np.vstack([weighted, sigma.max() * np.eye(errors.shape[1], data.shape[1])])


@lru_cache(_REMEMBERED)
def _require_rank(schedule: Schedule) -> None:
    lost = unidentified(schedule)
    if lost:
        raise UsageError(f"these positions cannot identify {', '.join(lost)}")
