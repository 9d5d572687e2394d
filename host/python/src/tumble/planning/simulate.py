"""Runs on a simulated stand: position means of the exact geometry, thousands at a time."""

from __future__ import annotations

import numpy as np

from tumble import reference
from tumble.arrays import Floats
from tumble.planning.case import Case
from tumble.reference.uncertainty import course, encoder_waves
from tumble.solving.gains import mean_sigma, shared_sigmas, yaws_of
from tumble.solving.monte_carlo import unit_draws

U0_V = (0.01, -0.02, 0.03)  # of the simulated block: linear estimators do not care


def position_means(case: Case, k: Floats, runs: int, rng: np.random.Generator) -> Floats:
    """Means (runs, positions, 3) in V of a block of sensitivity `k` (V/g) and offsets U0_V.

    The stand's errors are drawn anew for every run: normal, or uniform where the stand declares half-widths. The noise
    of a mean is normal, of the stand's noise or the converter's rounding, whichever is larger.
    """
    stand, geometry = case.stand, reference.Geometry(case.schedule)
    mountings, positions = len(case.schedule.mountings), len(case.schedule.positions)
    sigma = shared_sigmas(case.schedule, stand)
    shared = unit_draws(rng, stand.limits, (runs, len(sigma))) * sigma
    seats_from = 2 + yaws_of(case.fitted, stand)
    waves_from = seats_from + (1 + 2 * mountings if stand.declares_seat else 0)
    drifts_from = waves_from + (4 if stand.encoder > 0.0 else 0)
    alpha1, alpha2, yaws, seats, waves, drifts = np.split(shared, [1, 2, seats_from, waves_from, drifts_from], axis=1)
    errors = {"alpha1": alpha1, "alpha2": alpha2, "alpha3": np.broadcast_to(yaws, (runs, mountings))}
    if stand.declares_seat:
        platform, leaning, turned = np.split(seats, [1, 1 + mountings], axis=1)
        errors |= {"seat_h": platform + leaning, "seat_n": turned}
    errors["delta"] = unit_draws(rng, stand.limits, (runs, positions)) * stand.sigma("angle")
    if stand.encoder > 0.0:
        errors["delta"] = errors["delta"] + waves @ encoder_waves(case.schedule)
    outputs = geometry.outputs(k, np.array(U0_V), **errors)
    if stand.drift > 0.0:
        outputs = outputs + course(case.schedule)[:, None] * drifts[:, None]
    noise = mean_sigma(k, stand, case.step_v, stand.samples)[0]
    return outputs + noise * rng.standard_normal(outputs.shape)
