"""Blocks, schedules and runs for the tests, random or stated."""

import numpy as np

from tumble.core import CoreRefusal, CoreSchedule
from tumble.model import Geometry, Propagation
from tumble.model.errors import NOISE, by_gains, covariance_of, declared, of_stand
from tumble.schedule import CHECK, FIT, Mounting, Position, Schedule
from tumble.stand import by_channel

NOMINAL_K = np.full((3, 3), 0.04) + 1.96 * np.eye(3)  # scale 2 V/g, every misalignment +0.02


def random_block(rng, misalignment=0.1):
    """K and U0 of any size and sign: scale 1e-3 to 1e6, axes flipped at will, |U0| up to max|K|."""
    scale = 10.0 ** rng.uniform(-3, 6)
    k = scale * (np.diag(rng.uniform(0.8, 1.2, 3) * rng.choice([-1, 1], 3)) + rng.uniform(-1, 1, (3, 3)) * misalignment)
    return k, rng.uniform(-1, 1, 3) * np.abs(k).max()


def random_rotation(rng):
    """A proper rotation, uniform over all of them (from a unit quaternion)."""
    w, x, y, z = (q := rng.normal(size=4)) / np.linalg.norm(q)
    matrix = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return tuple(map(tuple, np.array(matrix)))


def random_schedule(rng):
    """One to six mountings, up to 36 positions, some of them to check only, some axes tilted, any angles."""
    mountings = tuple(
        Mounting(number + 1, random_rotation(rng), rng.choice([0.0, rng.uniform(-60, 60)]))
        for number in range(rng.integers(1, 7))
    )
    positions = tuple(
        Position(
            int(rng.integers(1, len(mountings) + 1)),
            number + 1,
            float(rng.choice([rng.uniform(-720, 720), 22.5 * rng.integers(-16, 17)])),
            CHECK if rng.random() < 0.2 else FIT,
        )
        for number in range(rng.integers(4, 37))
    )
    return Schedule(mountings, positions)


def usable_schedule(rng):
    """A random schedule that the rank check accepts, as the core holds it."""
    while True:
        schedule = CoreSchedule(random_schedule(rng))
        try:
            schedule.identify()
        except CoreRefusal as refusal:
            assert refusal.name == "TUMBLE_E_RANK"
        else:
            return schedule


def random_errors(rng, schedule, size):
    """Errors of a stand of the given size in radians, as keywords for Geometry."""
    return {
        "alpha1": rng.normal() * size,
        "alpha2": rng.normal() * size,
        "alpha3": rng.normal(size=len(schedule.mountings)) * size,
        "delta": rng.normal(size=len(schedule.positions)) * size,
    }


def random_means(rng, schedule, k, u0, size=1e-3, noise=1e-4):
    """Mean outputs of a block on a stand with errors."""
    ideal = Geometry(schedule).outputs(k, u0, **random_errors(rng, schedule, size))
    return ideal + rng.normal(size=ideal.shape) * noise * np.abs(k).max()


def write_run(path, schedule, means, digits=17):
    """A run file of one row a position."""
    rows = [
        f"{position.mounting},{position.number}," + ",".join(f"{u:.{digits}g}" for u in mean)
        for position, mean in zip(schedule.positions, means)
    ]
    path.write_text("mounting,position,ux [V],uy [V],uz [V]\n" + "\n".join(rows) + "\n")
    return path


def gains_of(schedule, estimator, k, stand, step=0.0):
    """Gains (12, 3 x fit positions) of an estimator for means of so many samples as the stand says."""
    return Propagation(schedule, k, stand, np.ones(len(schedule.positions), dtype=int), estimator, step).gains


def standard_deviations(schedule, gains, k, stand, sigma_mean):
    """Of an estimate with `gains` (rows, 3P), for means with noise `sigma_mean`, of each channel or of all."""
    errors = of_stand(schedule.fitted, k, stand, [name for name in declared(stand, schedule) if name != NOISE])
    by_noise = (gains**2).reshape(len(gains), -1, 3).sum(axis=1) @ by_channel(sigma_mean) ** 2
    return np.sqrt(np.diag(covariance_of(by_gains(schedule.fitted, gains), errors)) + by_noise)
