"""Runs of samples whose noise is not what the model takes it for: judged by the noise that each run itself shows."""

import numpy as np
from core_chi_squared import chi_squared
from violation_rows import U0, K

from tumble.files.run_file import Run, blocks_of, facts_of
from tumble.model.fit import variance_of_means
from tumble.model.propagation import Propagation
from tumble.solving import noise

_CHUNK = 250


class NoisyRuns:
    """Runs of a `row` on the stand and schedule of a `case`: `means` (runs, positions, 3), `squares` (runs,), whether
    the noise is `told` of, and what it adds to the variance of every mean, `excess` (runs, positions, 3)."""

    def __init__(self, case, row, runs):
        world = case.world(runs)
        outputs, sigma = world.force() @ K.T + U0, case.stand.sigma("noise")
        self._case, self._step = case, row.step * sigma
        self._declared = self._step if row.declares else 0.0
        found = []
        for start in range(0, runs, _CHUNK):
            chunk = outputs[start : start + _CHUNK, :, None]
            shape = (len(chunk), chunk.shape[1], case.stand.samples, 3)
            samples = chunk + sigma * row.noise(world.rng, shape)
            samples = np.round(samples / self._step) * self._step if self._step else samples
            found += [self._judge(one) for one in samples]
        means, squares, told, excess = zip(*found)
        self.means, self.squares, self.told = np.array(means), np.array(squares), np.array(told)
        self.excess = np.array(excess)

    def _judge(self, samples):
        case = self._case
        scatter = samples.std(axis=1, ddof=1)
        facts = [facts_of(np.column_stack((rows, np.arange(len(rows))))) for rows in samples]
        run = Run(case.samples, samples.mean(axis=1), scatter, "V", {}, blocks=blocks_of(facts))
        seen = noise.estimate_noise(run, case.stand, self._declared)
        stand = case.stand.with_step(self._declared)
        variance = variance_of_means(stand, run.samples, float(seen.rounding.max()))
        square = chi_squared(case.schedule, run.means, run.measured, variance, stand)[0]
        counted = stand.sigma("noise") ** 2 / run.samples[:, None]
        excess = np.maximum(seen.mean_variance, counted) - case.white
        return run.means, square, bool(seen.exceeds.any() or seen.undithered.any()), excess

    def u(self, estimator, declared):
        """Standard uncertainties (runs, 12), from those of white noise, `declared` (12,)."""
        case = self._case
        weights = Propagation(case.schedule.data, K, case.stand, case.samples, estimator).gains
        return np.sqrt(declared**2 + self.excess.reshape(len(self.excess), -1) @ (weights**2).T)
