"""How many residuals errors of set angles move: the core's count, by its Givens rotations, against exact arithmetic.

Attitudes at quarter turns and K of few bits are rational, and so is all that the rank depends on. Poses that are laid
by hand are the hard case: their equations are dependent in many ways, and what is left of them is rounding.
"""

import itertools
from fractions import Fraction

import numpy as np
import pytest
from conftest import EXAMPLES
from core_stand_seen import RunSeen

from tumble import core
from tumble.files.schedule_file import read_schedule
from tumble.schedule import Mounting, Position, Schedule

pytestmark = pytest.mark.python
QUARTERS = {0.0: (0, 1), 90.0: (1, 0), 180.0: (0, -1), 270.0: (-1, 0)}  # sine and cosine
ROTATIONS = [
    signed
    for order in itertools.permutations(range(3))
    for signs in itertools.product((1, -1), repeat=3)
    if round(np.linalg.det(signed := np.eye(3, dtype=int)[list(order)] * np.array(signs)[:, None])) == 1
]


def rank(rows):
    """By elimination without rounding."""
    rows, found = [list(row) for row in rows], 0
    for column in range(len(rows[0])):
        pivot = next((row for row in rows[found:] if row[column]), None)
        if pivot is None:
            continue
        rows.remove(pivot)
        rows.insert(found, pivot)
        found += 1
        for row in rows[found:]:
            if row[column]:
                by = row[column] / pivot[column]
                row[:] = [one - by * other for one, other in zip(row, pivot)]
    return found


def exact_freedom(schedule, k):
    """By how much the rank grows when every position's set angle is one more unknown."""
    numbers = [mounting.number for mounting in schedule.mountings]
    design, with_angles = [], []
    for place, position in enumerate(schedule.positions):
        mounting = numbers.index(position.mounting)
        matrix = np.array(schedule.mountings[mounting].matrix, dtype=int)
        sine, cosine = QUARTERS[position.angle_deg]
        force, by_alpha1 = matrix @ [sine, 0, cosine], matrix @ [0, 1, 0]
        by_alpha3, by_angle = matrix @ [0, -sine, 0], matrix @ [cosine, 0, -sine]
        for channel in range(3):
            row = [Fraction(0)] * (12 + 2 + len(numbers))
            row[4 * channel : 4 * channel + 4] = [*(Fraction(int(one)) for one in force), Fraction(1)]
            moved = [sum(Fraction(float(k[channel, j])) * int(by[j]) for j in range(3))
                     for by in (by_alpha1, by_angle, by_alpha3)]  # fmt: skip
            row[12], row[13], row[14 + mounting] = moved
            design.append(row)
            own = [moved[1] if one == place else Fraction(0) for one in range(len(schedule.positions))]
            with_angles.append(row + own)
    return rank(with_angles) - rank(design)


def core_freedom(schedule, k, variance):
    count = len(schedule.positions)
    seen = RunSeen(core.CoreSchedule(schedule), np.zeros((count, 3)), np.ones(count, dtype=bool), k, np.zeros(3))
    return seen.angle_chi_squared(1e-4, variance)[1]


def drawn(rng):
    """K of few bits, near a diagonal or not; a variance of means."""
    k = np.eye(3) * 2.0 + rng.integers(-32, 33, (3, 3)) / rng.choice([64.0, 4096.0])
    return k, 10.0 ** rng.uniform(-12, -6)


def poses(rng, turns):
    """Mountings of faces; each at one quarter turn, or with `turns` at several."""
    count = int(rng.integers(4, 7))
    chosen = [ROTATIONS[one] for one in rng.choice(len(ROTATIONS), count, replace=False)]
    mountings = [Mounting(n, tuple(map(tuple, matrix.tolist()))) for n, matrix in enumerate(chosen, 1)]
    positions = [
        Position(mounting.number, number, float(angle))
        for mounting in mountings
        for number, angle in enumerate(rng.choice(list(QUARTERS), rng.integers(1, 4) if turns else 1, replace=False), 1)
    ]
    return Schedule(tuple(mountings), tuple(positions))


@pytest.mark.parametrize("name", ["hand_laid_faces.toml", "six_faces.toml"])
def test_faces_laid_by_hand_have_the_rank_that_they_have(name):
    rng = np.random.default_rng(5)
    schedule = read_schedule(str(EXAMPLES / name)).data
    for _ in range(5):
        k, variance = drawn(rng)
        expected = exact_freedom(schedule, k)
        assert core_freedom(schedule, k, np.full(len(schedule.positions), variance)) == expected


def test_random_poses_that_turn_have_the_rank_that_they_have():
    """Of means that are equally noisy, as those of equally many samples are."""
    rng, found = np.random.default_rng(7), set()
    for _ in range(12):
        schedule, (k, variance) = poses(rng, True), drawn(rng)
        expected = exact_freedom(schedule, k)
        assert core_freedom(schedule, k, np.full(len(schedule.positions), variance)) == expected, (schedule, k.tolist())
        found.add(expected)
    assert len(found) > 2


MAGNIFIED = {  # by seed: do they turn, by what factor may variances differ
    5030: (False, 1.0),  # 6 of 200 such; model.stand_seen asks about none of them
    1037: (True, 100.0),
}


@pytest.mark.parametrize("seed", MAGNIFIED)
@pytest.mark.xfail(reason="what a small pivot magnifies exceeds TINY of stand_fit.c: one residual too many is counted")
def test_known_poses_whose_rank_the_core_miscounts(seed):
    turns, factor = MAGNIFIED[seed]
    rng = np.random.default_rng(seed)
    schedule, (k, variance) = poses(rng, turns), drawn(rng)
    variances = variance * factor ** rng.uniform(0.0, 1.0, len(schedule.positions))
    assert core_freedom(schedule, k, variances) == exact_freedom(schedule, k)
