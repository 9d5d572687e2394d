"""Rests between long handling: they are found, and the noise is theirs, not that of the hands."""

import numpy as np
import pytest

from tumble.importing.rests import Thresholds, find_rests

pytestmark = pytest.mark.python

RATE_HZ, NOISE_G = 100, 1e-3
FACES = np.vstack([np.eye(3), -np.eye(3)])


def held(rng, rows, one, other):
    """The block in somebody's hand, as steadily as hands are."""
    part = 0.5 - 0.5 * np.cos(np.linspace(0, np.pi, rows))[:, None]
    return one + part * (other - one) + 0.3 * np.sin(np.pi * part) * rng.normal(size=3) + rng.normal(0, 0.05, (rows, 3))


def swung(rng, rows, one, other):
    """It sways at a few Hz."""
    swaying = 0.2 * np.sin(2 * np.pi * rng.uniform(1, 4) * np.arange(rows) / RATE_HZ)[:, None] * rng.normal(size=3)
    return held(rng, rows, one, other) + swaying


def shaken(rng, rows, one, other):
    return other + rng.normal(0, 1.0, (rows, 3))


@pytest.mark.parametrize("rest_s", [1.5, 3.0])
@pytest.mark.parametrize("handling_s", [2.0, 10.0, 30.0])
@pytest.mark.parametrize("handled", [held, swung, shaken])
@pytest.mark.parametrize("seed", range(3))
def test_rests_are_found_however_long_the_handling(handled, handling_s, rest_s, seed):
    rng = np.random.default_rng(seed)
    rows, handling = int(rest_s * RATE_HZ), int(handling_s * RATE_HZ)
    felt, truth = [], []
    for place, (one, other) in enumerate(zip(np.roll(FACES, 1, axis=0), FACES)):
        felt += [handled(rng, handling, one, other), np.tile(other, (rows, 1))]
        truth += [np.full(handling, -1), np.full(rows, place)]
    felt, truth = np.concatenate(felt), np.concatenate(truth)
    found = find_rests(
        felt + rng.normal(0, NOISE_G, felt.shape), np.zeros(0, dtype=int), 1 / RATE_HZ, Thresholds()
    )
    assert [set(truth[begin:end]) for begin, end in zip(found.rests.begin, found.rests.end)] == [{i} for i in range(6)]
    assert found.noise == pytest.approx(NOISE_G, rel=0.25)


def test_windows_that_are_quiet_by_chance_are_no_rests():
    """A third of the windows quieter than the others in no order, and none for long: the noise is that of the many."""
    rng = np.random.default_rng(4)
    rows = 100 * RATE_HZ
    size = np.where(np.repeat(rng.random(rows // 50) < 0.03, 50), 0.1, 1.0)[:, None] * NOISE_G
    outputs = np.repeat(FACES[:1], rows, axis=0) + rng.normal(size=(rows, 3)) * size
    found = find_rests(outputs, np.zeros(0, dtype=int), 1 / RATE_HZ, Thresholds())
    assert len(found.rests) == 1 and found.noise == pytest.approx(NOISE_G, rel=0.3)
