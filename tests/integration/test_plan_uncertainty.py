"""Standard uncertainties of the core against numpy: any block, stand, schedule, estimator, and positions missing."""

import json

import numpy as np
import pytest
from blocks import NOMINAL_K, random_block, random_means, usable_schedule
from conftest import EXAMPLES
from documents import paper_stand
from hypothesis import given, settings, strategies as st

from tumble import core, model
from tumble.cli.main import main
from tumble.core import uncertainties, uncertainties_of_gains
from tumble.model.errors import brought, sources
from tumble.model.propagation import Propagation
from tumble.schedule import CHECK, FIT, Position, Schedule
from tumble.solving import uncertainty
from tumble.stand import COMMON, INDEPENDENT, LIMIT_KINDS, Stand

PAPER = model.built_in("paper")
AGREEMENT = 1e-9
ROUNDING = 1e-14
seeds = st.integers(0, 2**32 - 1)


def random_stand(rng):
    """Each source from 0 to large, of any kind of limits."""
    sizes = rng.choice([0.0, 1.0], 5, p=[0.2, 0.8]) * 10.0 ** rng.uniform(-7, -1, 5)
    sizes[4] *= 10.0 ** rng.uniform(-3, 6)
    remounting = INDEPENDENT if rng.random() < 0.5 else COMMON
    return Stand(*sizes.tolist(), int(rng.integers(1, 1000)), rng.choice(LIMIT_KINDS), remounting)


def random_samples(rng, schedule):
    """Lone rows, which are means, among positions of many rows."""
    return rng.choice([1, 2, 50, 100000], len(schedule.positions))


def measured_part(schedule, measured):
    """The schedule without what is not measured, as the witness takes it."""
    return Schedule(schedule.mountings, tuple(p for p, flag in zip(schedule.positions, measured) if flag))


def assert_agreement(found, expected):
    """To 1e-9 of each of the twelve. Where a source of huge effect cancels out of one, its rounding remains, and adds
    in quadrature to what is left: a coefficient that is 1e12 times as certain as another one shows it.
    """
    found, expected = (np.concatenate([part.ravel() for part in pair]) for pair in (found, expected))
    apart, largest = np.abs(found - expected), expected.max()
    assert apart.max(initial=0.0, where=expected > 0) <= AGREEMENT * largest
    told = expected > 1e-12 * largest
    allowed = AGREEMENT * expected[told] + (ROUNDING * largest) ** 2 / expected[told]
    assert np.all(apart[told] <= allowed)


@given(seeds)
def test_least_squares_on_any_schedule(seed):
    rng = np.random.default_rng(seed)
    schedule, (k, _), stand = usable_schedule(rng), random_block(rng), random_stand(rng)
    samples, measured = random_samples(rng, schedule.data), rng.random(len(schedule)) < 0.9
    part = measured_part(schedule.data, measured)
    try:
        found = uncertainties(schedule, k, stand, samples, "least_squares", measured)
    except core.CoreRefusal as refusal:
        assert refusal.name == "TUMBLE_E_RANK"
        assert refusal.details["unidentified"]
        return
    covariance = model.Propagation(part, k, stand, samples[measured], "least_squares").covariance()
    assert_agreement(found, model.by_coefficient(covariance))


def extended(rng):
    """The paper's positions shuffled among others, some of them check positions."""
    others = [
        Position(int(rng.integers(1, 3)), 100 + n, float(rng.uniform(-360, 360)), str(rng.choice([FIT, CHECK])))
        for n in range(rng.integers(0, 10))
    ]
    positions = [*PAPER.positions, *others]
    return Schedule(PAPER.mountings, tuple(positions[index] for index in rng.permutation(len(positions))))


@given(seeds, st.sampled_from(["averaged", "refined", "least_squares"]))
def test_every_estimator_on_the_papers_positions_and_more(seed, estimator):
    rng = np.random.default_rng(seed)
    schedule, (k, _), stand = extended(rng), random_block(rng), random_stand(rng)
    samples = random_samples(rng, schedule)
    found = uncertainties(core.CoreSchedule(schedule), k, stand, samples, estimator)
    given = model.Propagation(schedule, k, stand, samples, estimator)
    assert_agreement(found, model.by_coefficient(given.covariance()))


@given(seeds)
def test_any_gain_table(seed):
    rng = np.random.default_rng(seed)
    schedule, (k, _), stand = usable_schedule(rng), random_block(rng), random_stand(rng)
    samples, fit = random_samples(rng, schedule.data), schedule.data.fit_indices
    gains = rng.normal(size=(12, 3 * len(fit))) * 10.0 ** rng.uniform(-3, 3, (12, 1))
    found = uncertainties_of_gains(schedule, k, stand, samples, gains)

    def rows(means):
        return means[:, fit].reshape(len(means), -1) @ gains.T

    draws = brought(rows, sources(schedule.data, k, stand, samples))
    parts = {name: np.linalg.norm(one, axis=0) for name, one in draws.items()}
    total = np.sqrt(sum(part**2 for part in parts.values()))
    assert_agreement(found, (total[:9], total[9:]))


@settings(max_examples=60)
@given(seeds)
def test_optimal_as_its_witness_down_to_no_noise(seed):
    """Weights made at one K by each side, the floor of the noise included; 1e-6 is what a solve allows."""
    rng = np.random.default_rng(seed)
    schedule, (k, u0), stand = usable_schedule(rng), random_block(rng, 0.05), random_stand(rng)
    samples, measured = random_samples(rng, schedule.data), np.ones(len(schedule), dtype=bool)
    means = random_means(rng, schedule.data, k, u0, size=1e-6, noise=1e-7)
    witness = model.optimal_estimate(schedule.data, means, stand, samples)
    run = Propagation(schedule.data, witness.k, stand, samples, "optimal")
    found, other = uncertainty.standard_uncertainties(run, schedule, measured), [*witness.u_k.ravel(), *witness.u_u0]
    assert found == pytest.approx(np.array(other), rel=1e-6, abs=1e-13 * max(other))


@pytest.mark.parametrize("estimator", ["averaged", "refined"])
def test_a_missing_position_is_refused_as_by_the_estimator(estimator):
    schedule, measured = core.CoreSchedule(PAPER), np.arange(18) != 12
    stand = Stand(1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1, "sigma1")
    with pytest.raises(core.CoreRefusal) as refused:
        uncertainties(schedule, NOMINAL_K, stand, np.ones(18, int), estimator, measured)
    assert (refused.value.name, refused.value.details["missing"]) == ("TUMBLE_E_MISSING_POSITION", ["2.4"])


def test_a_gain_table_needs_every_fit_position_and_its_own_size():
    schedule, stand = core.CoreSchedule(PAPER), Stand(1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1, "sigma1")
    for columns, measured, name in [
        (54, np.arange(18) != 3, "TUMBLE_E_MISSING_POSITION"),
        (51, None, "TUMBLE_E_GAIN_TABLE"),
    ]:
        with pytest.raises(core.CoreRefusal) as refused:
            uncertainties_of_gains(schedule, NOMINAL_K, stand, np.ones(18, int), np.ones((12, columns)), measured)
        assert refused.value.name == name


def test_a_stand_out_of_range_is_refused():
    schedule = core.CoreSchedule(PAPER)
    for stand in [
        Stand(-1e-9, 0, 0, 0, 0, 1, "sigma1"),
        Stand(0, 1.5, 0, 0, 0, 1, "sigma1"),
        Stand(0, 0, float("nan"), 0, 0, 1, "sigma1"),
        Stand(0, 0, 0, 0, float("inf"), 1, "sigma1"),
        Stand(0, 0, 0, 0, 0, 0, "sigma1"),
    ]:
        with pytest.raises(core.CoreRefusal) as refused:
            uncertainties(schedule, NOMINAL_K, stand, np.zeros(18, int), "refined")
        assert refused.value.name == "TUMBLE_E_ARGUMENT"


def test_a_k_that_is_no_number_is_refused():
    stand = Stand(1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1, "sigma1")
    with pytest.raises(core.CoreRefusal) as refused:
        uncertainties(core.CoreSchedule(PAPER), np.full((3, 3), np.nan), stand, np.ones(18, int), "refined")
    assert refused.value.name == "TUMBLE_E_NOT_FINITE"


SOLVE = ["solve", str(EXAMPLES / "paper_stand.csv"), "--stand", str(EXAMPLES / "paper_stand.toml"), "--json"]
SOLVE += ["--limit", "1e-3"]


@pytest.mark.parametrize("estimator", ["averaged", "refined", "least_squares", "optimal"])
def test_solve_states_what_the_core_finds(estimator, capsys, monkeypatch):
    """The core's bits, and not the witness's."""
    given, sound = [], uncertainty.standard_uncertainties
    monkeypatch.setattr(uncertainty, "standard_uncertainties", lambda *a: given.append(sound(*a)) or given[-1])
    assert main([*SOLVE, "--estimator", estimator]) == 0
    result = json.loads(capsys.readouterr().out)
    assert [*np.ravel(result["u_K"]), *result["u_U0"]] == given[0].tolist()


@pytest.mark.parametrize(
    ("estimator", "too_far"), [("refined", 1.2e-9), ("least_squares", 1.2e-9), ("optimal", 1.2e-6)]
)
@pytest.mark.parametrize("index", [0, 1])
def test_a_disagreement_of_the_uncertainties_ends_in_exit_3(estimator, too_far, index, capsys, monkeypatch):
    sound = uncertainty.standard_uncertainties

    def spoilt(factor):
        def spoil(*arguments):
            return sound(*arguments) * np.where(np.arange(12) // 9 == index, factor, 1.0)

        return spoil

    for off, code in ((0.8 * too_far, 0), (-0.8 * too_far, 0), (too_far, 3), (-too_far, 3)):
        monkeypatch.setattr(uncertainty, "standard_uncertainties", spoilt(1.0 + off))
        assert main([*SOLVE, "--estimator", estimator]) == code
        captured = capsys.readouterr()
        if code:
            assert captured.out == "" and captured.err.count("\n") == 1
            assert f"{('u_K', 'u_U0')[index]} differs" in captured.err and "no result is given" in captured.err


def test_a_stand_beyond_all_numbers_is_bad_input(refused, tmp_path):
    stand = paper_stand(tmp_path, noise_v="1e200")
    said = refused("solve", EXAMPLES / "paper_stand.csv", "--stand", stand)
    assert "[stand] noise_v must be 0 to 1e+09" in said
