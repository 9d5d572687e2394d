"""Simulated fleets: blocks that drift, walk and jump and are calibrated, as arrays and as rows of a history."""

from dataclasses import dataclass

import numpy as np

from tumble.history.calibrations import OF_BLOCK, PARAMETERS, packed
from tumble.history.due import Forecast, norm_gradients
from tumble.history.trend import DAY_S, Growth, Series, filtered
from tumble.model.coefficients import spread_attitudes

U = np.array([5e-6] * 3 + [8e-6] * 3 + [6e-6] * 3 + [20e-6] * 3)
BASE = np.array([2.0, 1.9, 2.1, np.pi / 2 + 0.01, np.pi / 2, np.pi / 2 - 0.02, 0.01, -0.02, 0.005, 0.0, 0.0, 0.0])
TRUTH = Growth(
    drift=np.array([1e-8] * 3 + [0.0] * 3 + [-2e-8] * 3 + [0.0] * 3),
    spread=np.array([2e-8] * 3 + [5e-9] * 3 + [1e-8] * 3 + [0.0] * 3),
    walk=np.array([4e-7] * 3 + [3e-7] * 3 + [6e-7] * 3 + [0.0] * 3),
)
SEAT_RAD = 3e-4  # of a seat that was exchanged
_FIRST_S = 1_400_000_000


@dataclass
class Fleet:
    """What was measured, and what is so: `truth` (blocks, each, 12) and `rates` (blocks, 12); which calibrations are
    jumps and outliers of which parameter, and of which block the `seats` were exchanged then (blocks, each)."""

    series: Series
    truth: np.ndarray
    rates: np.ndarray
    jumps: np.ndarray
    outliers: np.ndarray
    seats: np.ndarray


def fleet(blocks, each, seed, *, jumps=0.0, outliers=0.0, seats=0.0, size=12.0, growth=TRUTH, days=180.0):
    """Calibrations about every so many `days`. `jumps`, `outliers`: their share of all values; `seats`: of all
    calibrations; `size`: of these in standard deviations of an innovation."""
    rng = np.random.default_rng(seed)
    tau = days * rng.uniform(0.6, 1.4, (blocks, each))
    tau[:, 0] = 0.0
    at = np.round(_FIRST_S / DAY_S + np.cumsum(tau, axis=1), 3)
    rates = growth.drift + growth.spread * rng.normal(size=(blocks, 12))
    steps = growth.walk * np.sqrt(tau)[..., None] * rng.normal(size=(blocks, each, 12))
    scale = size * np.sqrt(2.0 * U**2 + growth.walk**2 * days + (growth.spread * days) ** 2)
    sign = rng.choice([-1.0, 1.0], (2, blocks, each, 12))
    jump, outlier = rng.random((2, blocks, each, 12)) < np.array([jumps, outliers])[:, None, None, None]
    jump[:, 0] = outlier[:, 0] = False
    jump[..., OF_BLOCK:] = outlier[..., OF_BLOCK:] = False
    seat = rng.random((blocks, each)) < seats
    seat[:, 0] = False
    steps += jump * sign[0] * scale
    turn = rng.normal(size=(blocks, each, 3))
    steps[..., OF_BLOCK:] += seat[..., None] * SEAT_RAD * turn / np.linalg.norm(turn, axis=-1, keepdims=True)
    truth = rates[:, None] * (at - at[:, :1])[..., None] + np.cumsum(steps, axis=1)
    values = truth + U * rng.normal(size=truth.shape) + outlier * sign[1] * scale
    serials = [f"B{number:06d}" for number in range(blocks)]
    variances = np.broadcast_to(U**2, values.shape).copy()
    rows = np.arange(blocks * each).reshape(blocks, each)
    series = Series(serials, at, values, variances, np.zeros((blocks, each), dtype=bool), rows)
    return Fleet(series, truth, rates, jump, outlier, seat)


def rows_of(series, kind="T", stand="S"):
    """For `History.add_rows`, without documents."""
    covariance = packed(np.diag(U[:OF_BLOCK] ** 2))
    about = {"type": kind, "stand": stand, "passed": True, "believed": True, "estimator": "refined", "limit_g": 3e-4}
    about |= {f"u_{name}": float(u) for name, u in zip(PARAMETERS, U)} | {"covariance": covariance}
    values = series.values + BASE
    values[..., :3] = BASE[:3] * np.exp(series.values[..., :3])
    found, seconds = [], (series.days * DAY_S).round().astype(int).tolist()
    for serial, days, of_block in zip(series.serials, seconds, values.tolist()):
        for k, (at, numbers) in enumerate(zip(days, of_block)):
            found.append({**about, "serial": serial, "created_s": at, "sha256": f"{kind}-{serial}-{k}",
                          **dict(zip(PARAMETERS, numbers))})  # fmt: skip
    return found


def forecast_of(series, growth, limit=np.inf):
    """Of all blocks at their last calibrations."""
    shape = len(series.serials), 3
    covariance = np.broadcast_to(np.diag(U[:OF_BLOCK] ** 2), (shape[0], 9, 9))
    angles, bias = np.broadcast_to(BASE[3:6], shape), np.broadcast_to(BASE[6:9], shape)
    return Forecast.of(angles, bias, covariance, filtered(series, growth, limit).last, growth.walk)


def off_when_due(found, forecast, days, limit_g, coverage, seed, growth=TRUTH):
    """By how much |a| is off after so many days (blocks,), with the coefficients of the last calibration, at the
    attitude that was foreseen as the worst: the truth goes on as it did."""
    rng = np.random.default_rng(seed)
    steps = growth.walk * np.sqrt(days)[:, None] * rng.normal(size=found.rates.shape)
    errors = (found.truth[:, -1] + found.rates * days[:, None] + steps - found.series.values[:, -1])[:, :OF_BLOCK]
    attitudes, off = spread_attitudes(500), []
    for at in range(0, len(days), 100):
        part = forecast.part(slice(at, at + 100))
        soonest = part.days_at(limit_g, coverage, np.broadcast_to(attitudes, (len(part.rate), 500, 3))).argmin(axis=1)
        gradients = norm_gradients(part.angles, part.bias, attitudes[soonest][:, None])
        off.append(np.abs(np.einsum("bni,bi->bn", gradients, errors[at : at + 100])[:, 0]))
    return np.concatenate(off)
