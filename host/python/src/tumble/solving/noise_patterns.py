"""The patterns of a run that does not fit its stand which its samples show by themselves, and not its residuals."""

from __future__ import annotations

import math

import numpy as np

from tumble.arrays import Floats
from tumble.distributions import chi_squared_log_above, f_cdf
from tumble.files.run_file import Run
from tumble.model.explanations import NOISE, Sampled
from tumble.model.noise import MeasuredNoise
from tumble.model.stand_seen import Estimate, own_variance
from tumble.solving.noise import Noise, of_means
from tumble.stand import PerChannel, Stand, by_channel
from tumble.units import noise_unit, volts_per

CORRELATED = "correlated_noise"


def sampled_patterns(noise: Noise, run: Run, pooled: Estimate | None, stand: Stand, step: PerChannel) -> list[Sampled]:
    """More noise than declared, and noise that is not white: each if the samples can show it. `pooled` over positions
    and channels, as model.stand_seen has it; `stand` and the converter's `step` (0: unknown) in the unit of the
    outputs."""
    found = []
    if pooled is not None:
        found.append(_more_noise(run, pooled, stand, step))
    if noise.measured is not None and len(noise.measured.pooled) > 1 and noise.exceeds.any():
        found.append(_correlated(noise.measured, noise, run, stand))
    return found


def _more_noise(run: Run, pooled: Estimate, stand: Stand, step: PerChannel) -> Sampled:
    """Rounding by half a step counts as noise."""
    expected = stand.weights * np.hypot(stand.sigmas("noise"), by_channel(step) / 2.0)
    declared, log_p = float(expected.max()), 0.0
    if pooled.value > declared:
        freedom = 3 * int((run.samples[run.samples > 1] - 1).sum())
        log_p = chi_squared_log_above(freedom * (pooled.value / declared) ** 2, freedom) if declared else -math.inf
    variance = own_variance(pooled, run.samples[run.measured], stand)
    assert variance is not None  # of pooled noise it is known
    volts = volts_per(run.unit)
    by_channels = variance[:, None] / stand.weights**2
    return Sampled(NOISE, log_p, pooled.value * volts, pooled.u * volts, noise_unit(run.unit), "", by_channels)


def _correlated(seen: MeasuredNoise, noise: Noise, run: Run, stand: Stand) -> Sampled:
    """In the channel that shows it most, of those whose means it makes worse than declared."""
    log_p = np.where(noise.exceeds, log_p_if_white(seen), 0.0)
    worst = int(log_p.argmin())
    size = float(of_means(seen, run.samples)[worst]) * volts_per(run.unit)
    u_size = size / math.sqrt(2.0 * int(seen.freedom[worst]))
    variance = (noise.mean_variance[run.measured] * stand.weights**2).max(axis=1)[:, None] / stand.weights**2
    return Sampled(CORRELATED, float(log_p[worst]), size, u_size, noise_unit(run.unit), "xyz"[worst], variance)


def log_p_if_white(seen: MeasuredNoise) -> Floats:
    """How often white noise, whatever its size, has blocks of any length that scatter more beside what is shorter: by
    channel (3,), with the number of channels and lengths. The two are independent then, so their ratio is an F."""
    of_all = seen.pooled_freedom[0] * seen.pooled[0]
    least = np.zeros(3)
    for freedom, variance in zip(seen.pooled_freedom[1:].tolist(), seen.pooled[1:]):
        below = int(seen.pooled_freedom[0]) - freedom
        shorter = np.maximum(of_all - freedom * variance, 0.0) / below
        for i in np.flatnonzero(variance > shorter):
            p = f_cdf(float(shorter[i] / variance[i]), below, freedom)
            least[i] = min(least[i], math.log(p) if p > 0.0 else -math.inf)
    chosen_from: Floats = np.minimum(least + math.log(3 * (len(seen.pooled) - 1)), 0.0)
    return chosen_from
