"""The core against its numpy witness. A result that the witness does not confirm is not given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble import reference
from tumble.computation import Computation
from tumble.errors import Disagreement
from tumble.schedule import Schedule

RELATIVE_LIMIT = 1e-12
_LAST_BITS = 16 * np.finfo(float).eps
_MAGNIFIED_BITS = 2 * np.finfo(float).eps
_DERIVED = 10.0


@dataclass(frozen=True)
class Comparison:
    """Core less witness: `k` (3, 3), `u0` (3,), in the unit of the outputs (per g)."""

    k: np.ndarray
    u0: np.ndarray


def compare(found: Computation, schedule: Schedule, means: np.ndarray, delta_g: np.ndarray) -> Comparison:
    """Compute all of it again and compare. Raises Disagreement, naming the quantity that differs.

    `schedule`, `means` (positions, 3) and the core's `delta_g` (positions,) hold the measured positions only.

    Coefficients may differ by 1e-12 of max|K|, or where that is coarser by 16 times the last bit of the largest output
    (offsets of hundreds of g), or by twice that bit as a weak schedule magnifies it. What follows from the coefficients may differ by ten times that, times
    the condition of K where K is inverted or its rows are compared.
    """
    k, u0 = reference.estimate(schedule, means, found.estimator)
    largest_k = np.abs(k).max()
    bits = max(_LAST_BITS, _MAGNIFIED_BITS * reference.magnification(schedule))
    relative = max(RELATIVE_LIMIT, bits * np.abs(means).max() / largest_k)
    _require("K", found.k, k, relative * largest_k)
    _require("U0", found.u0, u0, relative * largest_k)

    follows = _DERIVED * relative
    conditioned = follows * largest_k * np.linalg.norm(np.linalg.inv(k), 2)
    largest_force = np.abs(np.linalg.solve(k, (means - u0).T)).max()
    _require("delta_g", delta_g, reference.gravity_errors(means, k, u0), conditioned * max(1.0, largest_force**2))
    scale, angles, bias = reference.intrinsic(k, u0)
    _require("intrinsic scale", found.intrinsic.scale, scale, follows * largest_k)
    _require("intrinsic angle_rad", found.intrinsic.angles, angles, conditioned)
    _require("intrinsic bias_g", found.intrinsic.bias, bias, conditioned * (1.0 + np.abs(bias).max()))
    rms = reference.residual_rms(schedule, means, k, u0)
    _require_same("residual_rms", found.residual_rms, rms, follows * largest_k)
    for mounting in schedule.mountings:
        closure = reference.closure(schedule, means, mounting.number)
        _require_same(f"closure of mounting {mounting.number}", found.closure.get(mounting.number), closure, 0.0)
    return Comparison(found.k - k, found.u0 - u0)


def _require_same(name: str, core: np.ndarray | None, witness: np.ndarray | None, limit: float) -> None:
    if (core is None) != (witness is None):
        raise Disagreement(f"the C core and numpy disagree: only one of them gives {name}; no result is given")
    if core is not None:
        _require(name, core, witness, limit)


def _require(name: str, core: np.ndarray, witness: np.ndarray, limit: float) -> None:
    difference = np.abs(core - witness).max()
    if not difference <= limit:
        raise Disagreement(
            f"the C core and numpy disagree: {name} differs by {difference:.2g}, allowed is {limit:.2g};"
            " no result is given"
        )
