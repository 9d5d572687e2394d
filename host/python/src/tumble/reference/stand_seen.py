"""The stand as a run shows it: what the two mountings of the paper's schedule tell about the fixture itself.

    v = K^-1 (U1_0 - U2_0)          alpha1 = (v_y - v_z)/2
    w = K^-1 (K2_.x - K1_.x)        w_y = alpha2 + alpha3 of mounting 1,  w_z = alpha2 + alpha3 of mounting 2

alpha2 and alpha3 cannot be told apart: alpha2 = -alpha3 is a rotation of the block's own frame.
"""

from __future__ import annotations

import numpy as np

from tumble.reference.estimators import functionals, paper_slots
from tumble.reference.uncertainty import SOURCES, contributions, sources
from tumble.schedule import Schedule
from tumble.stand import Stand

_ANGLES = ("alpha1_rad", "alpha2_plus_alpha3_rad", "alpha3_difference_rad")
_SEEN_ITSELF = {
    "alpha1_rad": {"alpha1"},
    "alpha2_plus_alpha3_rad": {"alpha2", "alpha3"},
    "alpha3_difference_rad": {"alpha3"},
}


def _angles(slots: np.ndarray, k: np.ndarray, means: np.ndarray) -> np.ndarray:
    """The three of _ANGLES, alpha3 as mean and as first mounting less second: means (..., P, 3) -> (..., 3)."""
    _, s1, b1 = functionals(means[..., slots[0], :])
    _, s2, b2 = functionals(means[..., slots[1], :])
    v = np.linalg.solve(k, (b1 - b2)[..., None])[..., 0]
    w = np.linalg.solve(k, (-s2 - s1)[..., None])[..., 0]
    return np.stack([(v[..., 1] - v[..., 2]) / 2, (w[..., 1] + w[..., 2]) / 2, w[..., 1] - w[..., 2]], axis=-1)


def pooled_noise(samples: np.ndarray, scatter: np.ndarray) -> tuple[float | None, float | None]:
    """Standard deviation of one sample, pooled over positions and channels, and its standard uncertainty.

    `samples` (positions,), `scatter` (positions, 3), read where samples > 1. None, None when a run holds only means.
    """
    several = samples > 1
    freedom = 3 * int((samples[several] - 1).sum())
    if freedom == 0:
        return None, None
    variance = ((samples[several] - 1)[:, None] * scatter[several] ** 2).sum() / freedom
    return float(np.sqrt(variance)), float(np.sqrt(variance / (2 * freedom)))


def stand_seen(
    schedule: Schedule,
    means: np.ndarray,
    k: np.ndarray,
    samples: np.ndarray,
    scatter: np.ndarray,
    stand: Stand | None,
) -> dict[str, float | None]:
    """Angles and noise of the stand with their standard uncertainties (`u_` twins); None where a run cannot tell.

    An angle's uncertainty comes from the declared stand without the source that is being seen; None without a stand.
    alpha4 is None: telling it from the noise needs the residuals' own budget.
    """
    noise, u_noise = pooled_noise(samples, scatter)
    seen = {name: None for angle in (*_ANGLES, "alpha4_rad") for name in (angle, f"u_{angle}")}
    slots = paper_slots(schedule)
    if slots is not None:
        seen.update(zip(_ANGLES, _angles(slots, k, means).tolist()))
    if slots is not None and stand is not None:
        parts = contributions(lambda m: _angles(slots, k, m), sources(schedule, k, stand, samples))
        for column, angle in enumerate(_ANGLES):
            others = [parts[name][column] for name in SOURCES if name not in _SEEN_ITSELF[angle]]
            seen[f"u_{angle}"] = float(np.sqrt(sum(part**2 for part in others)))
    return {**seen, "noise_v": noise, "u_noise_v": u_noise}
