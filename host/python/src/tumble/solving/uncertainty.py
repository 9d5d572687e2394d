"""The standard uncertainties that a result states: by the core, from the declared stand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tumble import core
from tumble.arrays import Flags, Floats, Integers
from tumble.core.uncertainty import uncertainties, uncertainties_of_gains
from tumble.estimators import OPTIMAL
from tumble.reference.estimators import fit_indices
from tumble.reference.uncertainty import sources
from tumble.schedule import Schedule
from tumble.solving import extended
from tumble.solving.gains import NOISE_FLOOR_G, linear_gains
from tumble.solving.many_runs import table_at
from tumble.stand import PerChannel, Stand, per_channel, rounding_of
from tumble.terms import Terms


def standard_uncertainties(
    schedule: core.CoreSchedule,
    measured: Flags,
    k: Floats,
    stand: Stand,
    samples: Integers,
    estimator: str,
    step: PerChannel = 0.0,
    mean_variance: Floats | None = None,
) -> tuple[Floats, Floats]:
    """u_K (3, 3) and u_U0 (3,) of an estimate, in its units; `stand` and the converter's `step` in the outputs' unit.

    `samples` and `measured` (positions,); `mean_variance` (positions, 3): by the noise as measured, where it counts for
    more than the stand's. Those of the optimal estimator are for weights made at the solved `k`: the
    second order, which it takes out, makes up for weights made elsewhere. Raises CoreRefusal.
    """
    if estimator != OPTIMAL:
        return uncertainties(schedule, k, stand, samples, estimator, measured, mean_variance)
    u = _of_optimal(schedule, measured, k, stand, samples, step, (), mean_variance)
    return u[:9].reshape(3, 3), u[9:]


def extended_uncertainties(
    schedule: core.CoreSchedule,
    measured: Flags,
    k: Floats,
    stand: Stand,
    samples: Integers,
    estimator: str,
    step: PerChannel,
    terms: Terms,
    mean_variance: Floats | None = None,
) -> Floats:
    """Of K row by row, U0 and the sizes of further `terms` (12 + 3 x terms,); the rest as of standard_uncertainties."""
    if estimator == OPTIMAL:
        return _of_optimal(schedule, measured, k, stand, samples, step, terms, mean_variance)
    part, variance = schedule.part(measured), None if mean_variance is None else mean_variance[measured]
    gains = gains_of_run(part, k, stand, samples[measured], estimator, step, terms)
    return _of_gains(part, k, stand, samples[measured], gains, variance, 0.0)


def gains_of_run(
    part: core.CoreSchedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    estimator: str,
    step: PerChannel = 0.0,
    terms: Terms = (),
) -> Floats:
    """By which an estimator finds K row by row, U0 and the sizes of further terms (12 + 3 x terms, 3 x fit positions)
    of a run with the positions of `part` and their `samples`: those of optimal for weights made at `k`."""
    if estimator == OPTIMAL:
        return table_at(part.data, k, stand, samples, step, terms).gains
    return extended.gains(part, terms) if terms else linear_gains(part.data, estimator)


def brought(
    schedule: Schedule,
    k: Floats,
    stand: Stand,
    estimator: str,
    samples: Integers,
    step: PerChannel = 0.0,
    terms: Terms = (),
) -> dict[str, Floats]:
    """What every source of error of the stand brings to the coefficients and the sizes of further `terms`, to first
    order: by name as in reference.uncertainty.sources, (draws, 12 + 3 x terms), one standard deviation of each draw.
    Arguments as of gains_of_run. Raises CoreRefusal."""
    gains = gains_of_run(core.CoreSchedule(schedule), k, stand, samples, estimator, step, terms)
    fit, errors = fit_indices(schedule), sources(schedule, k, stand.with_step(step), samples)
    return {
        name: source.sigma[:, None] * (source.derivative[:, fit].reshape(len(source.derivative), -1) @ gains.T)
        for name, source in errors.items()
    }


def _of_optimal(
    schedule: core.CoreSchedule,
    measured: Flags,
    k: Floats,
    stand: Stand,
    samples: Integers,
    step: PerChannel,
    terms: Terms,
    mean_variance: Floats | None,
) -> Floats:
    part = schedule.part(measured)
    gains = gains_of_run(part, k, stand, samples[measured], OPTIMAL, step, terms)
    one_sample = np.maximum(stand.sigmas("noise"), rounding_of(step))
    used = replace(
        stand,
        axis_tilt=stand.sigma("axis_tilt"),
        level=stand.sigma("level"),
        remount=stand.sigma("remount"),
        angle=stand.sigma("angle"),
        seat=stand.sigma("seat"),
        platform=stand.sigma("platform"),
        encoder=stand.sigma("encoder"),
        drift=per_channel(stand.sigmas("drift")),
        noise=per_channel(one_sample),
        limits="sigma1",
    )
    least_noise = NOISE_FLOOR_G * float(np.abs(k).max())  # as the weights have it
    variance = None if mean_variance is None else mean_variance[measured]
    return _of_gains(part, k, used, samples[measured], gains, variance, least_noise)


def _of_gains(
    part: core.CoreSchedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    gains: Floats,
    mean_variance: Floats | None,
    least_noise: float,
) -> Floats:
    """One for each row of gains: the core takes twelve at a time."""
    found = []
    for start in range(0, len(gains), 12):
        rows = gains[start : start + 12]
        table = np.vstack([rows, np.zeros((12 - len(rows), gains.shape[1]))])
        u_k, u_u0 = uncertainties_of_gains(
            part, k, stand, samples, table, mean_variance=mean_variance, least_noise=least_noise
        )
        found.append(np.concatenate([u_k.ravel(), u_u0])[: len(rows)])
    return np.concatenate(found)
