"""How the samples of a run move together: differences of the sums of neighbouring blocks, and the steps of values.

Rows of a position are taken for consecutive samples, in the order of the file.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tumble.arrays import Floats
from tumble.files.run_facts import PositionFacts, smallest_step_of
from tumble.records import dataclass


@dataclass(frozen=True)
class Blocks:
    """`squares` (lengths, positions, 3): of blocks of 1, 2, 4, ... samples, the sum over neighbouring pairs of
    (A - B)^2 / 2m, with A and B the sums of m samples each; a position of N samples has N / 2m pairs, rounded down. Of
    white noise each pair's expectation is the variance of a sample, whatever m is. `resolution` (3,): the smallest
    difference between two values of a channel at one position; infinite where there is none."""

    squares: Floats
    resolution: Floats


NO_BLOCKS = Blocks(np.zeros((0, 0, 3)), np.full(3, np.inf))


def blocks_of(positions: Sequence[PositionFacts]) -> Blocks:
    """Of all positions."""
    lengths = max(len(one.squares) for one in positions)
    squares, resolution = np.zeros((lengths, len(positions), 3)), np.full(3, np.inf)
    for index, one in enumerate(positions):
        squares[: len(one.squares), index] = one.squares
        resolution = np.minimum(resolution, [channel.resolution for channel in one.channels] or np.inf)
    return Blocks(squares, resolution)


def smallest_step(values: Floats) -> float:
    """Between two values of a channel: the converter's, where it is coarse; infinite where there is one value alone."""
    return smallest_step_of(np.sort(values))
