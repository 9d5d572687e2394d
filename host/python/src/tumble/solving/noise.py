"""The noise of a run: how much its samples show, where that counts beside the declared one, and which patterns of a
run that does not fit its stand they show by themselves.

The standard error of a mean comes from blocks of consecutive samples, channel by channel, pooled over the positions.
The energy of a block length m is the mean of (A - B)^2 / 2m over neighbouring blocks with the sums A and B. White noise
has the variance of a sample at every length; noise that hangs together has more at the lengths that matter to a mean.
The variance of block means, times m, is the pooled energy of all lengths from m on. Where it is more than the scatter
beyond chance (99 %), the length counts; of these the one where it is largest. Where none is, the scatter counts, and
never less than that, so noise that alternates stays conservative. If it is the longest blocks that count, the noise has
not come to an end within them: the straight line through the energies of the last two lengths is carried on to the
length of the position. The line is flat for white noise, and goes through the origin for 1/f noise; steeper ones are
cut to that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Flags, Floats, Integers
from tumble.distributions import chi_squared_log_above, f_cdf
from tumble.files.run_file import Run
from tumble.model.fit import NOISE_V, Sampled
from tumble.model.stand_seen import Estimate, averaged_over, own_variance
from tumble.stand import PerChannel, Stand, by_channel, rounding_of, rounds_alike
from tumble.units import noise_unit, volts_per

_ROUNDING = 1e-12  # of the largest output
CHANCE_SIGMAS = 4.2  # one-sided, 1.3e-5: for three channels and twenty lengths below 1e-3
_GROWN_SIGMAS = 2.33  # 99 %


@dataclass(frozen=True)
class MeasuredNoise:
    """By channel (3,): `scatter`, standard deviation of a sample within positions; `length` of the blocks where the
    standard error is largest, with `freedom` degrees of freedom; `variance` of a sample that these show, `line` what
    each further length of the longest block adds to it. `pooled` (lengths, 3): variance by block length, with
    `pooled_freedom` (lengths,)."""

    scatter: Floats
    length: Integers
    freedom: Integers
    variance: Floats
    line: Floats
    longest: int
    pooled: Floats
    pooled_freedom: Integers

    def mean_variance(self, samples: Integers | Floats) -> Floats:
        """Of the means of `samples` (positions,) each: (positions, 3)."""
        further = np.maximum(samples / self.longest - 1.0, 0.0)
        of_a_sample: Floats = self.variance + further[:, None] * self.line
        return of_a_sample / np.maximum(samples, 1)[:, None]

    def exceeds(self, sigma: Floats | float) -> Flags:
        """Is it more than white noise with the standard deviation `sigma` of a sample shows by chance? (3,)"""
        limits = chance_limit(self.pooled_freedom, CHANCE_SIGMAS)[:, None] * np.square(sigma)
        return np.asarray((self.pooled > limits).any(axis=0))


def measured_noise(samples: Integers, scatter: Floats, squares: Floats, shortest: int = 1) -> MeasuredNoise | None:
    """None where no position has two samples. `samples` (positions,), `scatter` (positions, 3), `squares` (lengths,
    positions, 3) as in files.run_file.Blocks; of these, those from index `shortest` on are looked at beside the
    scatter."""
    several = samples > 1
    if not several.any():
        return None
    freedom = int((samples[several] - 1).sum())
    variance = ((samples[several] - 1)[:, None] * scatter[several] ** 2).sum(axis=0) / freedom
    pairs = np.array([(samples >> (level + 1)).sum() for level in range(len(squares))], dtype=int)
    energies = squares.sum(axis=1) / pairs[:, None]
    levels = range(shortest, len(squares))
    of_all = [(energies[level:] * pairs[level:, None]).sum(axis=0) / pairs[level:].sum() for level in levels]
    pooled = np.array([variance, *of_all])
    freedoms = np.array([freedom, *(pairs[level:].sum() for level in levels)])
    lengths = np.array([1, *(1 << level for level in levels)])
    grown = pooled > chance_limit(freedoms, _GROWN_SIGMAS)[:, None] * variance
    largest = np.where(grown, pooled, 0.0).argmax(axis=0)
    line = np.zeros(3)
    if len(levels) > 0:
        steepest = np.clip(2.0 * (energies[-1] - energies[-2]), 0.0, energies[-1])
        line = np.where(largest == len(levels), steepest, 0.0)
    found = pooled[largest, np.arange(3)]
    longest = 1 << max(len(pairs) - 1, 0)
    return MeasuredNoise(np.sqrt(variance), lengths[largest], freedoms[largest], found, line, longest, pooled, freedoms)


def chance_limit(freedom: Integers | Floats, sigmas: float) -> Floats:
    """What chi-squared over its degrees of freedom exceeds as seldom as a normal number exceeds `sigmas` (Wilson and
    Hilferty)."""
    ninth = 2.0 / (9.0 * np.asarray(freedom, dtype=float))
    limit: Floats = (1.0 - ninth + sigmas * np.sqrt(ninth)) ** 3
    return limit


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


def estimate_noise(run: Run, stand: Stand | None, step: PerChannel, shortest: int | None = None) -> Noise:
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
    given, shown = by_channel(step), np.where(np.isfinite(run.blocks.resolution), run.blocks.resolution, 0.0)
    steps = np.where(given > 0.0, given, shown)
    exceeds = undithered = np.zeros(3, dtype=bool)
    variance = np.zeros((len(samples), 3))
    if measured is not None:
        exceeds = np.ones(3, dtype=bool)
        if declared is not None:  # the steps of the converter and rounding are no noise
            rounded = _ROUNDING * np.nanmax(np.abs(run.means))
            exceeds = measured.exceeds(np.hypot(declared, given / 2.0 + rounded))
        # is it under half a step? rounding adds a twelfth of a step's square to a scatter
        undithered = np.asarray((measured.scatter**2 < steps**2 / 3.0) | (measured.scatter == 0.0))
        variance = measured.mean_variance(samples) * exceeds
    elif declared is not None:
        undithered = rounds_alike(declared, steps)
    rounding = np.where(undithered, rounding_of(steps), 0.0)
    by_samples, white = variance, np.zeros(3) if declared is None else declared**2
    variance = np.where(undithered, np.maximum(variance, white / samples[:, None]) + rounding**2, variance)
    known = run.measured[:, None]
    return Noise(measured, exceeds, undithered, rounding, variance * known, by_samples * known)


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
    found, unit, volts = [], noise_unit(run.unit), volts_per(run.unit)
    if pooled is not None:  # rounding by half a step counts as noise
        expected = stand.weights * np.hypot(stand.sigmas("noise"), by_channel(step) / 2.0)
        declared, log_p = float(expected.max()), 0.0
        if pooled.value > declared:
            freedom = 3 * int((run.samples[run.samples > 1] - 1).sum())
            log_p = chi_squared_log_above(freedom * (pooled.value / declared) ** 2, freedom) if declared else -math.inf
        alike = own_variance(pooled, run.samples[run.measured], stand)
        assert alike is not None  # of pooled noise it is known
        variance = alike[:, None] / stand.weights**2
        found.append(Sampled(NOISE_V, log_p, pooled.value * volts, pooled.u * volts, unit, "", variance))
    seen = noise.measured
    if seen is not None and len(seen.pooled) > 1 and noise.exceeds.any():
        # in the channel that shows it most, of those whose means it makes worse than declared
        log_p_by_channel = np.where(noise.exceeds, log_p_if_white(seen), 0.0)
        worst = int(log_p_by_channel.argmin())
        size = float(of_means(seen, run.samples)[worst]) * volts
        u_size = size / math.sqrt(2.0 * int(seen.freedom[worst]))
        alike = (noise.mean_variance[run.measured] * stand.weights**2).max(axis=1)
        variance, log_p = alike[:, None] / stand.weights**2, float(log_p_by_channel[worst])
        found.append(Sampled(CORRELATED, log_p, size, u_size, unit, "xyz"[worst], variance))
    return found


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
