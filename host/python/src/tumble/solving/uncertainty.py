"""The standard uncertainties that a result states: by the core, from the declared stand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats, Integers
from tumble.core.uncertainty import uncertainties, uncertainties_of_gains
from tumble.estimators import OPTIMAL
from tumble.solving import optimal_run
from tumble.solving.gains import NOISE_FLOOR_G, optimal_table
from tumble.stand import Stand


def standard_uncertainties(
    schedule: core.CoreSchedule,
    measured: Flags,
    k: Floats,
    stand: Stand,
    samples: Integers,
    estimator: str,
    step: float = 0.0,
    mean_variance: Floats | None = None,
) -> tuple[Floats, Floats]:
    """u_K (3, 3) and u_U0 (3,) of an estimate, in its units; `stand` and the converter's `step` in the outputs' unit.

    `samples` and `measured` (positions,); `mean_variance` (positions, 3): by the noise as measured, where it counts for
    more than the stand's. Those of the optimal estimator are for weights made at the solved `k`: the
    second order, which it takes out, makes up for weights made elsewhere. Raises CoreRefusal.
    """
    if estimator != OPTIMAL:
        return uncertainties(schedule, k, stand, samples, estimator, measured, mean_variance)
    part = schedule.part(measured)
    weighting = optimal_run.Weighting(stand, samples, step)
    averaged_over = optimal_run.samples_in_a_mean(schedule.data, measured, weighting)
    gains = optimal_table(part.data, k, stand, step, averaged_over).gains
    one_sample = max(stand.sigma("noise"), abs(step) / 12**0.5)
    used = replace(
        stand,
        axis_tilt=stand.sigma("axis_tilt"),
        level=stand.sigma("level"),
        remount=stand.sigma("remount"),
        angle=stand.sigma("angle"),
        seat=stand.sigma("seat"),
        platform=stand.sigma("platform"),
        noise=one_sample,
        limits="sigma1",
    )
    least_noise = NOISE_FLOOR_G * float(np.abs(k).max())  # as the weights have it
    variance = None if mean_variance is None else mean_variance[measured]
    return uncertainties_of_gains(
        part, k, used, samples[measured], gains, mean_variance=variance, least_noise=least_noise
    )
