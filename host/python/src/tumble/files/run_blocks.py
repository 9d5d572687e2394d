"""How the samples of a run move together: differences of the sums of neighbouring blocks, and the steps of values.

Rows of a position are taken for consecutive samples, in the order of the file.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tumble.arrays import Floats


@dataclass(frozen=True)
class Blocks:
    """`squares` (lengths, positions, 3): of blocks of 1, 2, 4, ... samples, the sum over neighbouring pairs of
    (A - B)^2 / 2m, with A and B the sums of m samples each; a position of N samples has N / 2m pairs, rounded down. Of
    white noise each pair's expectation is the variance of a sample, whatever m is. `resolution` (3,): the smallest
    difference between two values of a channel at one position; infinite where there is none."""

    squares: Floats
    resolution: Floats


NO_BLOCKS = Blocks(np.zeros((0, 0, 3)), np.full(3, np.inf))


def blocks_of(positions: list[Floats]) -> Blocks:
    """Of the rows (samples, 3) of every position."""
    lengths = max(len(rows) for rows in positions).bit_length() - 1
    squares, resolution = np.zeros((lengths, len(positions), 3)), np.full(3, np.inf)
    for index, rows in enumerate(positions):
        if len(rows) > 1:
            squares[: len(rows).bit_length() - 1, index] = _squares(rows)
            resolution = np.minimum(resolution, [smallest_step(channel) for channel in rows.T])
    return Blocks(squares, resolution)


def _squares(rows: Floats) -> list[Floats]:
    found, sums, length = [], rows - rows[0], 1
    while len(sums) > 1:
        paired = sums[: len(sums) // 2 * 2]
        first, second = paired[0::2], paired[1::2]
        found.append(((first - second) ** 2).sum(axis=0) / (2 * length))
        sums, length = first + second, 2 * length
    return found


def smallest_step(values: Floats) -> float:
    """Between two values of a channel: the converter's, where it is coarse; infinite where there is one value alone."""
    steps = np.diff(np.unique(values))
    return float(steps.min(initial=np.inf))
