"""The simulation's random numbers, generated anew here from their description in host/simulation/random.h."""

import sys
from statistics import NormalDist

import numpy as np
import pytest
from conftest import ROOT
from simulated_bench import bench

from tumble.world.setup import scenario_text

sys.path.insert(0, str(ROOT / "tests/benchmark"))

import campaign

TILT, LEVEL, REMOUNT, ANGLE, NOISE = 1, 2, 3, 4, 6  # causes
STREAMS = [(TILT, 0), (LEVEL, 0), (REMOUNT, 1), (REMOUNT, 2)]
STREAMS += [(ANGLE, index) for index in range(18)] + [(NOISE, index) for index in range(3)]
U64 = np.uint64


def finalize(z):
    """The finalizer of splitmix64."""
    z = (z ^ (z >> U64(30))) * U64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> U64(27))) * U64(0x94D049BB133111EB)
    return z ^ (z >> U64(31))


def uniforms(seeds, cause, index, count=1):
    """The first `count` numbers in (0, 1) of the stream (seed, cause, index), for every seed: (count, seeds)."""
    golden, numbers = U64(0x9E3779B97F4A7C15), []
    with np.errstate(over="ignore"):
        start = finalize((finalize(np.atleast_1d(np.asarray(seeds, U64)) + golden) ^ U64(cause << 32 | index)) + golden)
        s = [finalize(start + golden * U64(i)) for i in (1, 2, 3, 4)]
        for _ in range(count):
            product = s[1] * U64(5)
            bits = (product << U64(7) | product >> U64(57)) * U64(9)
            numbers.append(((bits >> U64(12)).astype(float) + 0.5) * 2.0**-52)
            shifted = s[1] << U64(17)
            s[2], s[3] = s[2] ^ s[0], s[3] ^ s[1]
            s[1], s[0] = s[1] ^ s[2], s[0] ^ s[3]
            s[2], s[3] = s[2] ^ shifted, s[3] << U64(45) | s[3] >> U64(19)
    return np.array(numbers)


def normals(seeds, cause, index, count=1):
    """The same as standard normal deviates."""
    numbers = uniforms(seeds, cause, index, count)
    return np.fromiter(map(NormalDist().inv_cdf, numbers.ravel()), float, numbers.size).reshape(numbers.shape)


@pytest.mark.parametrize("seed", [1, 2, 2**32 - 1, 2**63])
def test_a_stand_is_what_the_description_makes_of_its_seed(seed):
    setup = campaign.stand_of("lab_stand")
    stand, truth = setup.stand, bench(scenario_text(setup).splitlines(), seed)["truth"]

    def drawn(cause, index, limit, before=0):
        return pytest.approx(normals(seed, cause, index, before + 1)[before].item() * limit, rel=1e-13)

    assert truth["alpha1_rad"] == drawn(TILT, 0, stand.sigma("axis_tilt"))
    assert truth["alpha2_rad"] == drawn(LEVEL, 0, stand.sigma("level"))
    assert truth["alpha3_rad"] == [drawn(REMOUNT, number, stand.sigma("remount")) for number in (1, 2)]
    angle = stand.sigma("angle")  # the first angle is where homing ends: reached twice
    assert truth["alpha4_rad"] == [drawn(ANGLE, 0, angle, 1), *(drawn(ANGLE, index, angle) for index in range(1, 18))]


def deviations(seeds, block=1000):
    """Standard normal numbers, if the streams are sound: of every stream's first three draws, by blocks of seeds, mean,
    mean square, and how both scatter from block to block; equal cells; correlations between streams, and between seeds
    up to 8 apart, of the draws and of their squares."""
    first = []
    for cause, index in STREAMS:
        z = normals(seeds, cause, index, 3)
        blocks = z.reshape(3, -1, block)
        count = blocks.shape[1]
        means, squares = blocks.sum(axis=2) / block**0.5, ((blocks**2).sum(axis=2) - block) / (2.0 * block) ** 0.5
        for number in (means, squares):
            yield from number.sum(axis=1) / count**0.5
            yield from ((number**2).sum(axis=1) - count) / (2.0 * count) ** 0.5
        cells = np.bincount((uniforms(seeds, cause, index)[0] * 1024).astype(int), minlength=1024)
        expected = len(seeds) / 1024
        yield (((cells - expected) ** 2 / expected).sum() - 1023) / (2.0 * 1023) ** 0.5
        first.append(z[0])
    for values in (np.array(first), (np.array(first) ** 2 - 1.0) / 2.0**0.5):
        for lag in range(9):
            product = values[:, lag:] @ values[:, : len(seeds) - lag].T / (len(seeds) - lag) ** 0.5
            yield from product[np.tril_indices(len(values), -1)] if lag == 0 else product.ravel()


@pytest.mark.full
@pytest.mark.parametrize("start", ["the first seeds", "elsewhere"])
def test_streams_of_consecutive_seeds_are_independent_and_normal(start, fresh_seed):
    """200,000 of them; some 11,000 numbers, so that 6 standard deviations are passed once in 40,000 times."""
    begin = 1 if start == "the first seeds" else fresh_seed << 20
    seeds = U64(begin) + np.arange(200_000, dtype=U64)
    found = np.array(list(deviations(seeds)))
    assert np.abs(found).max() < 6.0
    assert (found**2).mean() == pytest.approx(1.0, abs=5.0 * (2.0 / len(found)) ** 0.5 + 0.01)


@pytest.mark.full
def test_shares_of_passes_are_those_of_independent_runs():
    """50 campaigns on the lab stand: their shares scatter as the binomial law says, about the predicted share."""
    runs, blocks = 1000, 50
    setup = campaign.stand_of("lab_stand")
    lines = campaign.calibrated(setup, runs * blocks)
    passed = np.array([line["pass"] for line in lines]).reshape(blocks, runs).sum(axis=1)
    share, uncertainty = campaign.predicted_share(setup, 200_000)
    variance = share * (1.0 - share)
    assert abs(passed.mean() / runs - share) < 5.0 * (variance / (runs * blocks) + uncertainty**2) ** 0.5
    scatter = ((passed - runs * share) ** 2 / (runs * variance)).sum()
    assert abs(scatter - blocks) < 5.0 * (2.0 * blocks) ** 0.5
