"""Runs on a simulated stand: position means of the exact geometry, thousands at a time."""

from __future__ import annotations

import numpy as np

from tumble.arrays import Floats
from tumble.model.errors import sources
from tumble.planning.case import Case
from tumble.solving.drawn_runs import Sources, drawn_outputs

U0_V = (0.01, -0.02, 0.03)  # of the simulated block: linear estimators do not care


def position_means(case: Case, k: Floats, runs: int, rng: np.random.Generator) -> Floats:
    """Means (runs, positions, 3) in V of a block of sensitivity `k` (V/g) and offsets U0_V.

    The stand's errors are drawn anew for every run: normal, or uniform where the stand declares half-widths. The noise
    of a mean is normal, of the stand's noise or the converter's rounding, whichever is larger.
    """
    return drawn_outputs(case.schedule, k, np.array(U0_V), errors_of(case, k), case.stand.limits, runs, rng)


def errors_of(case: Case, k: Floats) -> Sources:
    """What is drawn of a case's stand."""
    return sources(case.schedule, k, case.stand, np.ones(len(case.schedule.positions), dtype=int))
