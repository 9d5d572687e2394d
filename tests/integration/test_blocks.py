"""The core's blocks of samples: exact sums against fractions, the rule against numpy, coverage on raw counts."""

from fractions import Fraction

import numpy as np
import pytest
from _tumble_core import ffi, lib
from core_averaging import MAX_DEVIATION_COUNTS, Averaging
from hypothesis import given, strategies as st
from test_noise import autoregressive

from tumble.core import CoreRefusal, require_ok
from tumble.solving.noise import CHANCE_SIGMAS, chance_limit

V_PER_COUNT = 1e-5
MOST = 2**63 - 1


class Blocks:
    """Blocks beside the averaging of a run."""

    def __init__(self, samples):
        self.state, self.averaging = ffi.new("tumble_blocks_t *"), Averaging()
        require_ok(lib.tumble_blocks_init(self.state, samples))

    def take(self, index, rows, finish=True):
        self.averaging.begin(index)
        lib.tumble_blocks_begin(self.state)
        for counter, row in enumerate(rows):
            self.averaging.add(row, counter % 65536)
            lib.tumble_blocks_add(self.state, row)
        if finish:
            self.averaging.finish()
            lib.tumble_blocks_finish(self.state)

    def noise(self, noise_counts, v_per_count=V_PER_COUNT):
        found = ffi.new("tumble_noise_t *")
        stand = ffi.new("tumble_stand_record_t *", {"noise_v": noise_counts * V_PER_COUNT, "samples": 1})
        require_ok(lib.tumble_blocks_noise(self.state, self.averaging._state, stand, v_per_count, found))
        return found

    def excess(self, noise_counts, samples):
        """(3,): of the mean of so many samples."""
        noise, declared = self.noise(noise_counts), (noise_counts * V_PER_COUNT) ** 2 / samples
        return np.array([lib.tumble_noise_excess(noise, i, samples, declared) for i in range(3)])

    @property
    def sums(self):
        return [list(level) for level in self.state.square_sum], list(self.state.pairs)


def pairs_of(rows, m):
    """Differences of the sums of neighbouring blocks of m rows, by channel, in exact arithmetic."""
    blocks = [[sum(row[i] for row in rows[at : at + m]) for i in range(3)] for at in range(0, len(rows) // m * m, m)]
    return [[a - b for a, b in zip(one, other)] for one, other in zip(blocks[0::2], blocks[1::2])]


@st.composite
def positions(draw):
    """Samples of a few positions, anywhere in the range of int32, as far from the first as the core allows."""
    found = []
    for _ in range(draw(st.integers(1, 3))):
        spread = draw(st.sampled_from([1, 100, MAX_DEVIATION_COUNTS]))
        first = draw(st.integers(-(2**31) + 2 + spread, 2**31 - 2 - spread))
        channel = st.integers(first - spread, first + spread)
        rows = draw(st.lists(st.tuples(channel, channel, channel), max_size=70))
        found.append([(first, first, first), *rows])
    return found


@given(positions(), st.integers(8, 100))
def test_sums_are_those_of_exact_arithmetic(taken, planned):
    blocks = Blocks(planned)
    m = blocks.state.block_samples
    assert m == 2 ** ((planned // 4).bit_length() - 1)
    for index, rows in enumerate(taken):
        blocks.take(index, rows)
    for level, (squares, pairs) in enumerate(zip(*blocks.sums)):
        differences = [one for rows in taken for one in pairs_of(rows, m << level)]
        assert pairs == len(differences)
        assert squares == [sum(one[i] ** 2 for one in differences) for i in range(3)]


@pytest.mark.parametrize(("samples", "m"), [(8, 2), (15, 2), (16, 4), (50, 8), (256, 64), (2**20, 64)])
def test_lengths(samples, m):
    assert Blocks(samples).state.block_samples == m


def test_a_position_that_is_not_finished_leaves_nothing():
    blocks, rows = Blocks(16), [(i * i, -i, 7) for i in range(40)]
    blocks.take(0, rows, finish=False)
    blocks.take(1, rows)
    alone = Blocks(16)
    alone.take(1, rows)
    assert blocks.sums == alone.sums and alone.sums[1] == [5, 2]


def test_the_largest_differences_do_not_overflow_and_are_refused_in_the_end():
    """Blocks of 128 as far apart as two samples may be: the sum of squares is exact to its end, and stops there."""
    blocks, half = Blocks(2**20), MAX_DEVIATION_COUNTS
    pair = [(half, -half, 0)] * 128 + [(-half, half, 0)] * 128
    square = (2 * 128 * half) ** 2
    lib.tumble_blocks_begin(blocks.state)
    fits = MOST // square
    for turn in range(fits + 2):
        assert blocks.state.open_square_sum[1][0] == min(turn * square, MOST)
        for row in pair:
            lib.tumble_blocks_add(blocks.state, row)
    lib.tumble_blocks_finish(blocks.state)
    assert blocks.state.square_sum[1][0] == blocks.state.square_sum[1][1] == MOST
    blocks.averaging.begin(0)
    for counter in range(8):
        blocks.averaging.add((counter, 0, 0), counter)
    blocks.averaging.finish()
    with pytest.raises(CoreRefusal) as caught:
        blocks.noise(1.0)
    assert caught.value.name == "TUMBLE_E_DEVIATION"


def expected_excess(taken, m, declared, v):
    """By numpy and fractions, from the definitions. `taken` (positions, samples, 3) integers, `declared` in counts."""
    count, samples, _ = taken.shape
    scatter = np.float32(taken.std(axis=1, ddof=1)).astype(float)
    white, found = (scatter**2).mean(axis=0), np.zeros(3)
    for i in range(3):
        energy, pairs = [], []
        for length in (m, 2 * m):
            differences = [one[i] for rows in taken.tolist() for one in pairs_of(rows, length)]
            pairs.append(len(differences))
            energy.append(float(Fraction(sum(one**2 for one in differences), 2 * length * len(differences))))
        pooled = np.array([white[i], np.average(energy, weights=pairs), energy[1]])
        freedom = np.array([count * (samples - 1), sum(pairs), pairs[1]])
        limit = declared**2 + 0.25
        if not (pooled > chance_limit(freedom, CHANCE_SIGMAS) * limit).any():
            continue
        grown = pooled > chance_limit(freedom, 2.33) * white[i]
        best = int(np.where(grown, pooled, 0.0).argmax())
        line = np.clip(2 * (energy[1] - energy[0]), 0.0, energy[1]) if best == 2 else 0.0
        variance = (pooled[best] + max(samples / (2 * m) - 1, 0) * line) / samples
        found[i] = max(variance - declared**2 / samples, 0.0) * v**2
    return found


@pytest.mark.parametrize("rho", [(0.0, 0.5, 0.9), (-0.7, 0.2, 0.99)])
@pytest.mark.parametrize("samples", [16, 50, 300])
def test_the_rule_is_that_of_the_host(rho, samples):
    """A channel each of white, correlated, and strongly correlated noise; declared right, and by half."""
    rng, sigma = np.random.default_rng(90 + samples), 30.0
    x = np.stack([autoregressive(rng, (6, samples), one) for one in rho], axis=2)
    taken = np.rint(1e6 + sigma * x).astype(int)
    blocks = Blocks(samples)
    for index, rows in enumerate(taken.tolist()):
        blocks.take(index, [tuple(row) for row in rows])
    told = 0
    for declared in (sigma, sigma / 2):
        excess = blocks.excess(declared, samples)
        expected = expected_excess(taken, blocks.state.block_samples, declared, V_PER_COUNT)
        np.testing.assert_allclose(excess, expected, rtol=1e-9, atol=1e-30)
        noise, above = blocks.noise(declared), expected > 0.0
        assert noise.above == above @ [1, 2, 4] and noise.undithered == 0
        shown = np.sqrt((expected / V_PER_COUNT**2 + declared**2 / samples) * samples) * V_PER_COUNT
        assert np.array(list(noise.noise_v))[above] == pytest.approx(shown[above], rel=1e-9)
        told += (expected > 0.0).sum()
    assert told >= 2


def test_the_stated_error_covers():
    """18 positions of 50 samples: k = 2 of a mean in some weight, by excess and declared noise together."""
    rng, sigma, runs, samples = np.random.default_rng(91), 30.0, 120, 50
    weight = np.cos(2 * np.pi * np.arange(18) / 9)
    weight /= np.linalg.norm(weight)
    covered, told = np.zeros(3), np.zeros(3)
    for _ in range(runs):
        x = np.stack([autoregressive(rng, (18, samples), rho) for rho in (0.0, 0.5, 0.9)], axis=2)
        taken = np.rint(sigma * x).astype(int)
        blocks = Blocks(samples)
        for index, rows in enumerate(taken.tolist()):
            blocks.take(index, [tuple(row) for row in rows])
        excess = blocks.excess(sigma, samples) / V_PER_COUNT**2
        error = weight @ taken.mean(axis=1)
        covered += np.abs(error) < 2 * np.sqrt(sigma**2 / samples + excess)
        told += excess > 0.0
    print(f"AR(1) 0, 0.5, 0.9: covered {covered / runs}, told {told / runs}")
    assert (covered / runs > 0.87).all() and told[0] <= 1 and (told[1:] > 0.8 * runs).all()


def refusal_of(status):
    with pytest.raises(CoreRefusal) as caught:
        require_ok(status)
    return caught.value.name


def test_refusals():
    blocks = Blocks(16)
    for state, samples in ((blocks.state, 7), (ffi.NULL, 50)):
        assert refusal_of(lib.tumble_blocks_init(state, samples)) == "TUMBLE_E_ARGUMENT"
    for v_per_count, name in ((1.0, "TUMBLE_E_TOO_FEW"), (0.0, "TUMBLE_E_ARGUMENT"), (np.inf, "TUMBLE_E_ARGUMENT")):
        with pytest.raises(CoreRefusal) as caught:
            blocks.noise(1.0, v_per_count)
        assert caught.value.name == name
    stand, out = ffi.new("tumble_stand_record_t *"), ffi.new("tumble_noise_t *")
    good = [blocks.state, blocks.averaging._state, stand, 1.0, out]
    for place in (0, 1, 2, 4):
        bad = [ffi.NULL if index == place else one for index, one in enumerate(good)]
        assert refusal_of(lib.tumble_blocks_noise(*bad)) == "TUMBLE_E_ARGUMENT"
