"""The noise of a run: how much, where it counts, and what the samples show that the residuals do not.

The noise that a run itself shows, beside the declared one, and which of the two its uncertainties are made from.

The patterns of a run that does not fit its stand which its samples show by themselves, and not its residuals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.distributions import chi_squared_log_above, f_cdf
from tumble.files.run_file import Run
from tumble.model.fit import NOISE_V, Sampled
from tumble.model.noise import MeasuredNoise, measured_noise
from tumble.model.stand_seen import Estimate, averaged_over, own_variance
from tumble.stand import PerChannel, Stand, by_channel, rounding_of, rounds_alike
from tumble.units import noise_unit, volts_per

_ROUNDING = 1e-12  # of the largest output
CHANNELS = np.array(["ux", "uy", "uz"])
NO_STAND = Stand(0.0, 0.0, 0.0, 0.0, 0.0, 1, "sigma1")


@dataclass(frozen=True)
class Noise:
    """`measured`: by the samples, None where no position has two; `exceeds` (3,): that is more than declared, beyond
    chance; `undithered` (3,): all samples of a position round alike, by `rounding` (3,), a standard deviation, 0 where
    the step of the converter is not known. `mean_variance` (positions, 3): what uncertainties must count at least; 0
    where the declared noise is right; `by_samples` (positions, 3): what of it the samples say. None of it is known
    without samples and a stand."""

    measured: MeasuredNoise | None
    exceeds: Flags
    undithered: Flags
    rounding: Floats
    mean_variance: Floats
    by_samples: Floats

    @property
    def is_known(self) -> bool:
        """Whether the samples give every mean a standard error."""
        return bool((self.mean_variance.max(axis=0) > 0.0).all())


def look(run: Run, stand: Stand | None, step: PerChannel, shortest: int | None = None) -> Noise:
    """`stand` (None: nothing is declared) and the `step` of the converter (0: not known) in the unit of the run. All
    lengths of blocks are looked at; with `shortest` only blocks of so many samples and of twice as many, as on board,
    and with 0 none."""
    squares, first = run.blocks.squares, 1
    if shortest is not None:
        first = max(shortest.bit_length() - 1, 1)
        squares = squares[: first + 2 if shortest > 0 else 1]
    measured = measured_noise(run.samples, run.scatter, squares, first)
    declared = None if stand is None else stand.sigmas("noise")
    samples = np.where(run.measured, averaged_over(run.samples, stand), 1)
    exceeds = _exceeds(measured, declared, run, step)
    given, shown = by_channel(step), np.where(np.isfinite(run.blocks.resolution), run.blocks.resolution, 0.0)
    steps = np.where(given > 0.0, given, shown)
    undithered = _undithered(measured, declared, steps)
    rounding = np.where(undithered, rounding_of(steps), 0.0)
    variance = np.zeros((len(samples), 3)) if measured is None else measured.mean_variance(samples) * exceeds
    by_samples, white = variance, np.zeros(3) if declared is None else declared**2
    variance = np.where(undithered, np.maximum(variance, white / samples[:, None]) + rounding**2, variance)
    known = run.measured[:, None]
    return Noise(measured, exceeds, undithered, rounding, variance * known, by_samples * known)


def _exceeds(measured: MeasuredNoise | None, declared: Floats | None, run: Run, step: PerChannel) -> Flags:
    """The steps of the converter and rounding are no noise."""
    if measured is None:
        return np.zeros(3, dtype=bool)
    if declared is None:
        return np.ones(3, dtype=bool)
    rounded = _ROUNDING * np.nanmax(np.abs(run.means))
    return measured.exceeds(np.hypot(declared, by_channel(step) / 2.0 + rounded))


def _undithered(measured: MeasuredNoise | None, declared: Floats | None, steps: Floats) -> Flags:
    """Is the noise of a sample under half a step? Rounding adds a twelfth of a step's square to a scatter."""
    if measured is not None:
        return np.asarray((measured.scatter**2 < steps**2 / 3.0) | (measured.scatter == 0.0))
    return np.zeros(3, dtype=bool) if declared is None else rounds_alike(declared, steps)


def notice(noise: Noise, stand: Stand, samples: Integers, unit: str) -> str | None:
    """That uncertainties are made from the noise measured and not from that of `stand`, in `unit`; None if not."""
    if noise.measured is None or not noise.exceeds.any():
        return None
    sizes, length = of_means(noise.measured, samples)[noise.exceeds], noise.measured.length[noise.exceeds]
    named = [f"{size:.1e} {unit} in {name}" for size, name in zip(sizes, CHANNELS[noise.exceeds])]
    blocks = f"blocks of {length.max()} samples" if length.max() > 1 else "the scatter of samples"
    declared = sorted({f"{sigma:.1e}" for sigma in stand.sigmas("noise")[noise.exceeds].tolist()}, key=float)
    return f"noise above the declared {', '.join(declared)} {unit}: {', '.join(named)} by {blocks}"


def of_means(seen: MeasuredNoise, samples: Integers) -> Floats:
    """As much noise of a sample (3,) as would give the means their standard errors, were it white."""
    several = samples[samples > 1]
    found: Floats = np.sqrt((seen.mean_variance(several) * several[:, None]).mean(axis=0))
    return found


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
    return Sampled(NOISE_V, log_p, pooled.value * volts, pooled.u * volts, noise_unit(run.unit), "", by_channels)


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
