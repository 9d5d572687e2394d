"""Schedules that are hard to draw: all right-angled poses, odd ones, tilted axes, crowded circles."""

import itertools

import numpy as np

from tumble.model.geometry import built_in
from tumble.schedule import BUILT_IN, CHECK, FIT, Mounting, Position, Schedule


def rotations():
    """The 24 in which every block axis lies along an axis of the table."""
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1.0, -1.0), repeat=3):
            matrix = np.zeros((3, 3))
            matrix[range(3), order] = signs
            if np.linalg.det(matrix) > 0.0:
                yield tuple(map(tuple, matrix.tolist()))


def turned_somehow(seed):
    """A rotation that no axis of which lies along anything."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return tuple(map(tuple, (q * np.linalg.det(q)).tolist()))


def odd_schedule():
    """Six mountings, tilted and in odd poses, 36 positions at odd angles."""
    numbers = (1, 3, 7, 20, 200, 255)
    mountings = [Mounting(number, turned_somehow(number), 12.5 * (number % 3 - 1)) for number in numbers]
    angles = np.random.default_rng(5).uniform(-700.0, 700.0, 36).round(2).tolist()
    positions = [Position(mountings[index % 6].number, index + 1, angle, CHECK if index % 5 == 0 else FIT)
                 for index, angle in enumerate(angles)]  # fmt: skip
    return Schedule(tuple(mountings), tuple(positions))


def crowded_schedule():
    """All 36 positions in one mounting, ten degrees apart."""
    return Schedule((Mounting(4, turned_somehow(4)),),
                    tuple(Position(4, number, 10.0 * (number - 1)) for number in range(1, 37)))  # fmt: skip


def thirty_six_poses():
    """As a publication of known poses gives them."""
    mountings = tuple(Mounting(number, turned_somehow(number)) for number in range(1, 37))
    return Schedule(mountings, tuple(Position(one.number, 1, 0.0) for one in mountings))


SCHEDULES = {name: built_in(name) for name in BUILT_IN}
SCHEDULES |= {"odd": odd_schedule(), "crowded": crowded_schedule(), "poses": thirty_six_poses()}
