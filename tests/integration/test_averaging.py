"""The core's averaging against Python's exact fractions."""

import math
from fractions import Fraction

import pytest
from core_averaging import MAX_DEVIATION_COUNTS, Averaging, AveragingConfig
from hypothesis import given, strategies as st

from tumble.core import MAX_SAMPLES, CoreRefusal

LARGEST = 2**31 - 1


@st.composite
def channels(draw):
    """Samples of one channel: anywhere in the range of int32, as far from the first as the core allows."""
    first = draw(st.integers(-LARGEST + 1, LARGEST - 1))
    spread = draw(st.sampled_from([0, 1, 100, MAX_DEVIATION_COUNTS]))
    low, high = max(-LARGEST + 1, first - spread), min(LARGEST - 1, first + spread)
    return [first, *draw(st.lists(st.integers(low, high), min_size=0, max_size=40))]


@st.composite
def positions(draw):
    """Samples of three channels, equally many."""
    three = [draw(channels()) for _ in range(3)]
    return list(zip(*three))


def averaged(samples, config=None):
    averaging = Averaging(config)
    averaging.begin(7)
    for counter, counts in enumerate(samples):
        averaging.add(counts, counter % 65536)
    return averaging


def exact_variance(values):
    mean = Fraction(sum(values), len(values))
    return sum((value - mean) ** 2 for value in values) / (len(values) - 1)


@given(positions())
def test_mean_is_the_correctly_rounded_quotient_of_exact_numbers(samples):
    averaging = averaged(samples)
    averaging.finish()
    mean, _ = averaging.mean(7)
    assert mean.tolist() == [float(Fraction(sum(channel), len(channel))) for channel in zip(*samples)]


@st.composite
def quotients(draw):
    """Samples of a position and their sum: any that samples can have, and those whose mean is next to halfway between
    two doubles."""
    samples = draw(st.one_of(st.integers(1, 200), st.integers(1, MAX_SAMPLES), st.just(MAX_SAMPLES)))
    bits = draw(st.integers(1, 51))
    total = draw(st.integers(0, 2**bits))
    if draw(st.booleans()):
        total = hard_sum(samples, draw(st.integers(2**52, 2**53 - 1))) + draw(st.integers(-1, 1))
    return samples, total * draw(st.sampled_from([-1, 1]))


def hard_sum(samples, digits):
    """The largest sum below 2^53 of which the mean, times a power of two, is nearly `digits` and a half."""
    wanted = samples * (2 * digits + 1)
    return wanted >> (wanted.bit_length() - 53)


@given(st.lists(st.tuples(quotients(), quotients(), quotients()), min_size=1, max_size=36))
def test_means_of_any_sums_are_correctly_rounded(run):
    averaging, expected = Averaging(), []
    for index, three in enumerate(run):
        average = averaging.state.averages[index]
        average.samples = three[0][0]
        average.sum_counts = [total for _, total in three]
        expected.append([float(Fraction(total, three[0][0])) for _, total in three])
    found, measured = averaging.means(1.0, len(run))
    assert measured.all() and found.tolist() == expected
    assert averaging.mean(0)[0].tolist() == expected[0]


@given(positions())
def test_running_error_is_that_of_the_exact_scatter(samples):
    averaging = averaged(samples)
    if len(samples) < 2:
        with pytest.raises(CoreRefusal) as caught:
            averaging.running()
        assert caught.value.name == "TUMBLE_E_TOO_FEW"
        return
    mean, error = averaging.running()
    assert mean.tolist() == [float(Fraction(sum(channel), len(channel))) for channel in zip(*samples)]
    for found, channel in zip(error, zip(*samples)):
        variance = exact_variance(channel)
        about_first = sum((value - channel[0]) ** 2 for value in channel)
        lost = 4 * 2.3e-16 * about_first / max(float(variance) * (len(channel) - 1), 1e-300)
        assert found == pytest.approx(math.sqrt(variance / len(channel)), rel=1e-14 + lost, abs=1e-300)


@given(positions(), st.randoms(use_true_random=False))
def test_order_of_samples_changes_no_bit(samples, random):
    shuffled = samples[1:]
    random.shuffle(shuffled)
    one, two = averaged(samples), averaged([samples[0], *shuffled])
    assert len(samples) < 2 or [row.tolist() for row in one.running()] == [row.tolist() for row in two.running()]


def test_means_in_volts():
    averaging = averaged([(1, 2, 3), (2, 4, -6)])
    averaging.finish()
    means, measured = averaging.means(0.25, 18)
    assert means[7].tolist() == [0.375, 0.75, -0.375]
    assert measured.tolist() == [index == 7 for index in range(18)]


def refusal_of(samples, config, counters=None):
    """Name of the status that ends these samples, and of what is counted then."""
    averaging = Averaging(config)
    averaging.begin(0)
    names = []
    for index, counts in enumerate(samples):
        try:
            averaging.add(counts, counters[index] if counters else index)
        except CoreRefusal as refusal:
            names.append(refusal.name)
    try:
        averaging.finish()
    except CoreRefusal as refusal:
        names.append(refusal.name)
    return names, {name: count for name, count in averaging.counters.items() if count}


@pytest.mark.parametrize(
    ("samples", "config", "counters", "names", "counted"),
    [
        ([(0, 0, 500)], AveragingConfig(saturation_counts=500), None, ["TUMBLE_E_SATURATED"] * 2, {"saturated": 1}),
        ([(0, 0, 0), (0, 1 << 22, 0)], AveragingConfig(), None, ["TUMBLE_E_DEVIATION"] * 2, {"deviating": 1}),
        ([(0, 0, 0)] * 2, AveragingConfig(), [9, 9], ["TUMBLE_E_REPEATED"], {"repeated": 1}),
        ([(0, 0, 0)] * 2, AveragingConfig(), [9, 8], ["TUMBLE_E_REORDERED"], {"reordered": 1}),
        ([(0, 0, 0)] * 2, AveragingConfig(), [9, 12], ["TUMBLE_E_LOST"], {"lost": 2}),
        ([(0, 0, 0)] * 2, AveragingConfig(max_lost=2), [9, 12], [], {"lost": 2}),
        ([(0, 0, 0)] * 2, AveragingConfig(), [65535, 0], [], {}),
        ([(0, 0, 0)], AveragingConfig(min_samples=2), None, ["TUMBLE_E_TOO_FEW"], {}),
        ([(1, 2, 3)] * 4, AveragingConfig(stuck_run=4), None, ["TUMBLE_E_STUCK"], {}),
        ([(0, 0, 0), (9, 9, 9)], AveragingConfig(noise_counts=1.0), None, ["TUMBLE_E_NOT_STILL"], {}),
    ],
)
def test_gates_refuse_and_count(samples, config, counters, names, counted):
    assert refusal_of(samples, config, counters) == (names, counted)


@pytest.mark.slow
def test_a_position_takes_so_many_samples_and_no_more():
    averaging = Averaging()
    averaging.begin(0)
    for sample in range(MAX_SAMPLES):
        averaging.add((LARGEST - 1, -LARGEST + 1, sample), sample & 0xFFFF)
    with pytest.raises(CoreRefusal) as caught:
        averaging.add((0, 0, 0), MAX_SAMPLES & 0xFFFF)
    assert caught.value.name == "TUMBLE_E_FULL"
    averaging.finish()
    mean, _ = averaging.mean(0)
    assert mean.tolist() == [LARGEST - 1, -LARGEST + 1, (MAX_SAMPLES - 1) / 2]
