"""Standard uncertainties by propagation: every source of error of the declared stand, through the estimator in use.

The outputs' derivatives with respect to each source come from the exact geometry by complex steps; the estimator, being
linear, maps them to derivatives of the coefficients. Sources are independent; their contributions add in quadrature.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats, Integers
from tumble.reference.estimators import estimate
from tumble.reference.geometry import Geometry
from tumble.schedule import FIT, Schedule
from tumble.stand import COMMON, Stand

SOURCES = ("alpha1", "alpha2", "alpha3", "alpha4", "noise")


@dataclass(frozen=True)
class Source:
    """Independent draws of one kind: `sigma` (draws,) standard deviations, `derivative` (draws, positions, 3) of the
    outputs with respect to each draw, `errors`: a unit of each draw as Geometry.force takes it; none where the outputs
    are linear in it, as in noise and drift. `normal`: whatever law the stand declares."""

    sigma: Floats
    derivative: Floats
    errors: tuple[dict[str, Floats], ...] = ()
    normal: bool = False


def sources(
    schedule: Schedule, k: Floats, stand: Stand, samples: Integers, mean_variance: Floats | None = None
) -> dict[str, Source]:
    """Every source of error, by name as in SOURCES; `seat`, `platform`, `encoder` and `drift` where the stand declares
    them.

    `k` (3, 3): the block's sensitivity. `samples` (positions,): rows of the run at each position, as
    Stand.averaged_over takes them. `mean_variance` (positions, 3): by the noise, as it was measured; it counts
    where it is larger than what the stand declares.
    """
    geometry = Geometry(schedule)
    positions, mountings = len(schedule.positions), len(schedule.mountings)
    yaws = np.ones((1, mountings)) if stand.remounting == COMMON else np.eye(mountings)
    noise = stand.mean_sigma(stand.averaged_over(samples))
    if mean_variance is not None:
        noise = np.maximum(noise, np.sqrt(mean_variance))

    def angles(source: str, **units: Floats) -> Source:
        """`units`: by the name that Geometry.force has for it, a unit of each draw."""
        by_draw = np.concatenate([geometry.derivative(k, **{name: unit}) for name, unit in units.items()])
        draws = tuple({name: one} for name, unit in units.items() for one in unit)
        return Source(np.full(len(draws), stand.sigma(source)), by_draw, draws)

    one = np.ones((1, 1))
    found = {
        "alpha1": angles("axis_tilt", alpha1=one),
        "alpha2": angles("level", alpha2=one),
        "alpha3": angles("remount", alpha3=yaws),
        "alpha4": angles("angle", delta=np.eye(positions)),
        "noise": Source(
            noise.ravel(),
            np.eye(3 * positions).reshape(-1, positions, 3),
            normal=True,
        ),
    }
    if stand.seat > 0.0:
        found["seat"] = angles("seat", seat_h=np.eye(mountings), seat_n=np.eye(mountings))
    if stand.platform > 0.0:
        found["platform"] = angles("platform", seat_h=one)
    if stand.encoder > 0.0:
        found["encoder"] = angles("encoder", delta=encoder_waves(schedule))
    if stand.declares_drift:
        drifts = course(schedule)[:, None] * np.eye(3)[:, None]
        found["drift"] = Source(stand.sigmas("drift"), drifts)
    return found


def encoder_waves(schedule: Schedule) -> Floats:
    """What one unit of each number of the encoder adds to the table angle (4, positions): the sine and the cosine of
    the angle, and of its double."""
    turned = np.exp(1j * np.deg2rad([position.angle_deg for position in schedule.positions]))
    return np.array([turned.imag, turned.real, (turned**2).imag, (turned**2).real])


def course(schedule: Schedule) -> Floats:
    """How far the run has come (positions,): from -1/2 at the first fit position to 1/2 at the last, by the same step
    from each to the next. A check position is half a step beyond the fit position before it."""
    fitted = np.array([position.use == FIT for position in schedule.positions])
    place = np.cumsum(fitted) - np.where(fitted, 1.0, 0.5)
    far: Floats = place / max(1, fitted.sum() - 1) - 0.5
    return far


def exact_outputs(schedule: Schedule, k: Floats, u0: Floats, errors: dict[str, Source], draws: Floats) -> Floats:
    """Outputs (runs, positions, 3) of the exact geometry for `draws` (runs, all draws of the sources in their order),
    in units of their standard deviations."""
    given: dict[str, Floats] = {}
    linear, start = np.zeros((len(draws), len(schedule.positions), 3)), 0
    for source in errors.values():
        sizes = draws[:, start : start + len(source.sigma)] * source.sigma
        start += len(source.sigma)
        for one, size in zip(source.errors, sizes.T):
            for name, unit in one.items():
                given[name] = given.get(name, np.zeros(1)) + size[:, None] * np.atleast_1d(unit)
        if not source.errors:
            linear += np.tensordot(sizes, source.derivative, axes=1)
    return Geometry(schedule).outputs(k, u0, **given) + linear


def contributions(of: Callable[[Floats], Floats], errors: dict[str, Source]) -> dict[str, Floats]:
    """Standard uncertainty that each source brings to a linear function of the means.

    `of` maps (draws, positions, 3) to (draws, n); the result has an array (n,) for every source.
    """
    return {
        name: np.sqrt(((of(source.derivative) * source.sigma[:, None]) ** 2).sum(axis=0))
        for name, source in errors.items()
    }


def joint(of: Callable[[Floats], Floats], errors: dict[str, Source]) -> Floats:
    """Covariance (n, n) that all sources together bring to a linear function of the means, as in `contributions`."""
    draws = np.concatenate([of(source.derivative) * source.sigma[:, None] for source in errors.values()])
    product: Floats = draws.T @ draws
    return (product + product.T) / 2.0


def covariance(
    schedule: Schedule,
    k: Floats,
    stand: Stand,
    samples: Integers,
    estimator: str,
    mean_variance: Floats | None = None,
) -> Floats:
    """Covariance (12, 12) of an estimate, K row by row, then U0, in its units. Arguments as of `sources`; `k` is the
    solved K."""

    def coefficients(means: Floats) -> Floats:
        found_k, found_u0 = estimate(schedule, means, estimator)
        return np.concatenate([found_k.reshape(-1, 9), found_u0], axis=1)

    return joint(coefficients, sources(schedule, k, stand, samples, mean_variance))


def by_coefficient(covariance: Floats) -> tuple[Floats, Floats]:
    """u_K (3, 3) and u_U0 (3,) of a covariance of the twelve coefficients, and of further unknowns behind them."""
    u = np.sqrt(np.diag(covariance))
    return u[:9].reshape(3, 3), u[9:12]
