"""The standard error of a mean as the samples themselves show it: from blocks of consecutive samples, channel by
channel, pooled over the positions.

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

from dataclasses import dataclass

import numpy as np

from tumble.arrays import Flags, Floats, Integers

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
    pooled = np.array([variance, *(_pooled(energies[level:], pairs[level:]) for level in levels)])
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


def _pooled(energies: Floats, pairs: Integers) -> Floats:
    of_all: Floats = (energies * pairs[:, None]).sum(axis=0) / pairs.sum()
    return of_all


def chance_limit(freedom: Integers | Floats, sigmas: float) -> Floats:
    """What chi-squared over its degrees of freedom exceeds as seldom as a normal number exceeds `sigmas` (Wilson and
    Hilferty)."""
    ninth = 2.0 / (9.0 * np.asarray(freedom, dtype=float))
    limit: Floats = (1.0 - ninth + sigmas * np.sqrt(ninth)) ** 3
    return limit
