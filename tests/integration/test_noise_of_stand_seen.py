"""The stand that a run shows, from means whose noise is correlated: set angles and angles by the measured noise."""

import core_stand_seen as stand_seen
import numpy as np
import pytest
from test_noise import autoregressive, run_of
from test_stand_seen import stand_named

from tumble import core, model
from tumble.model.stand_seen import estimate_stand_errors
from tumble.solving import noise

pytestmark = pytest.mark.python

SCHEDULE = core.CoreSchedule.built_in("paper")
K, U0 = 2.0 * np.eye(3) + 0.04, np.zeros(3)
MEASURED = np.ones(18, dtype=bool)
SAMPLES = 64


def runs(rho, count, alpha4, seed):
    """Runs of SAMPLES samples with AR(1) noise, on a stand with errors of set angles and of its level alone, and what
    level + yaw is of each."""
    rng, stand = np.random.default_rng(seed), stand_named("paper")
    for _ in range(count):
        level = 1e-4 * rng.normal()
        delta = alpha4 * rng.normal(size=18)
        ideal = model.Geometry(SCHEDULE.data).outputs(K, U0, alpha2=level, delta=delta)
        x = np.moveaxis(autoregressive(rng, (18, 3, SAMPLES), rho), 1, 2)
        yield run_of(ideal[:, None, :] + stand.noise * x), level


def seen(run, stand, counted, trust_stand=False):
    """By both implementations, which agree. `counted`: whether the noise of means is taken as measured."""
    variance = noise.estimate_noise(run, stand, 0.0).mean_variance if counted else None
    k, u0 = core.estimate(SCHEDULE, run.means)
    shown, white = stand_seen.RunSeen(SCHEDULE, run.means, MEASURED, k, u0), stand_seen.noise(run.samples, run.scatter)
    found = estimate_stand_errors(shown, white, run.samples, stand, trust_stand, variance)
    witness = model.RunSeen(SCHEDULE.data, run.means, k)
    stand_seen.compare_seen(found, witness, run.samples, run.scatter, stand, trust_stand, variance)
    return found


def squares(rho, counted, alpha4=4e-5):
    """Mean of alpha4 squared over its truth, 0 where a run shows none; and its standard error."""
    stand = stand_named("paper")
    found = [seen(run, stand, counted).alpha4 for run, _ in runs(rho, 150, alpha4, 7)]
    values = np.array([0.0 if one is None else one.value**2 for one in found]) / alpha4**2
    return values.mean(), values.std() / np.sqrt(len(values))


@pytest.mark.toolchain
@pytest.mark.parametrize("rho", [0.5, 0.9])
def test_set_angles_are_not_blamed_for_noise_that_hangs_together(rho):
    """By the scatter over root N they are; by the measured noise the square of alpha4 is about the truth."""
    blamed, _ = squares(rho, counted=False)
    mean, error = squares(rho, counted=True)
    print(
        f"AR(1) {rho}: alpha4 squared {blamed:.2f} of the truth by scatter over root N, {mean:.2f} +- {error:.2f} as is"
    )
    assert blamed > (1.4 if rho == 0.5 else 5.0)
    assert mean == pytest.approx(1.0, abs=0.35)


@pytest.mark.toolchain
@pytest.mark.parametrize("trust_stand", [False, True], ids=["run", "stand"])
def test_angles_lie_where_their_uncertainty_says(trust_stand):
    """AR(1) of 0.9 on a stand whose set angles are exact: rms of the error over u, of level + yaw."""
    declared = stand_named("paper").with_sigma("angle", 0.0)
    of_white, as_measured = [], []
    for run, truth in runs(0.9, 150, 0.0, 8):
        for scores, counted in ((of_white, False), (as_measured, True)):
            found = seen(run, declared, counted, trust_stand).augmented["alpha2_plus_alpha3"]
            scores.append((found.value - truth) / found.u)
    rms = {name: float(np.sqrt(np.mean(np.square(z)))) for name, z in (("white", of_white), ("measured", as_measured))}
    print(f"trust_stand={trust_stand}: {rms}")
    assert rms["measured"] < 1.25
    assert rms["white"] > (1.5 if not trust_stand else 3.0)  # of the run: alpha4 takes the blame, and widens u


def test_white_noise_changes_nothing():
    stand = stand_named("paper")
    for run, _ in runs(0.0, 20, 4e-5, 9):
        assert seen(run, stand, True, True) == seen(run, stand, False, True)
