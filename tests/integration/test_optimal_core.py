"""The core's stand-optimal estimator against the numpy witness, which solves from the data and uses no table."""

from dataclasses import replace

import core_functions
import gain_record
import numpy as np
import pytest
from blocks import NOMINAL_K, random_block, usable_schedule

from tumble import core
from tumble.core import CoreRefusal
from tumble.estimators import LINEAR
from tumble.model import Geometry, estimate, optimal_estimate
from tumble.model.coefficients import spread_attitudes
from tumble.model.errors import by_gains, covariance_of, sources
from tumble.model.estimators import unidentified
from tumble.model.geometry import built_in
from tumble.model.optimal import CORRECTIONS, Whitened, mean_sigma, optimal_table, samples_in_a_mean
from tumble.schedule import BUILT_IN, Position, Schedule
from tumble.solving import optimal_run
from tumble.stand import COMMON, INDEPENDENT, PAPER_STAND, Stand

LIMIT = 1e-6  # of each coefficient's standard uncertainty
ROUNDING = 1e-12  # of max|K|, as for every estimator: all that counts where u is below a millionth of K
SINGLE = 2.0**-24  # of the second order, about the square of the largest angle: the core keeps it as float
LARGE_RAD = 0.09  # where the core may call an angle, or its curvature, too large: TUMBLE_MAX_STAND_ERROR_RAD is 0.1
PAPER = core.CoreSchedule(core.paper_schedule())


def random_stand(rng, largest_output):
    """Errors from a millionth of a radian to 15 mrad, one in seven absent; noise from 1e-7 to 1e-3 of the outputs."""
    angles = 10.0 ** rng.uniform(-6, -1.8, 4) * (rng.random(4) < 6 / 7)
    noise = largest_output * 10.0 ** rng.uniform(-7, -3)
    remounting = COMMON if rng.random() < 0.5 else INDEPENDENT
    return Stand(*angles, noise, int(rng.integers(1, 100)), "sigma1", remounting)


def run_on(rng, schedule, k, u0, stand):
    """Means of a block on one stand drawn from what `stand` declares."""
    yaws = 1 if stand.remounting == COMMON else len(schedule.mountings)
    errors = {
        "alpha1": rng.normal() * stand.axis_tilt,
        "alpha2": rng.normal() * stand.level,
        "alpha3": rng.normal(size=yaws) * stand.remount,
        "delta": rng.normal(size=len(schedule.positions)) * stand.angle,
    }
    if schedule.is_inclined:
        beta, tau = rng.normal(size=(2, len(schedule.mountings))) * stand.inclination
        tau[[bolting[0] for bolting in schedule.boltings]] = 0.0
        alone = [bolting[0] for bolting in schedule.boltings if len(bolting) == 1]
        beta[alone] = 0.0
        errors |= {"alpha1": errors["alpha1"] + beta, "seat_n": tau}
        errors["alpha3"] = np.resize(errors["alpha3"], len(schedule.mountings))
        for bolting in schedule.boltings:
            errors["alpha3"][list(bolting)] = errors["alpha3"][bolting[0]]
    means = Geometry(schedule).outputs(k, u0, **errors)
    return means + rng.normal(size=means.shape) * stand.noise / stand.samples**0.5


def record_for(schedule, k, stand):
    return optimal_run.to_bytes(optimal_run.record_of(optimal_table(schedule, k, stand), schedule))


def largest_angle(schedule, k, stand, means):
    """Of all that the witness takes for an error of the stand on its way, and what the second order changes in it."""
    samples = samples_in_a_mean(schedule, stand, np.ones(len(schedule.positions)))
    problem = Whitened(schedule, k, stand, mean_sigma(k, stand, 0.0, samples)[0], ())
    measured = means[schedule.fit_indices].reshape(1, -1)
    x, largest, turns = problem.solve(measured.T).T, 0.0, 0.0
    for _ in range(CORRECTIONS + 1):
        sizes = problem.sizes(x)
        angles = {name: found[0] for name, found in problem.errors.arguments(sizes).items()}
        curved, turns = angles["delta"] - turns, angles["delta"]
        seen = [*angles["alpha1"], *angles["alpha3"], *(angles["alpha2"] + turns), *curved]
        largest = max(largest, np.abs(seen).max())
        exact = problem.errors.outputs(x[:, -12:-3].reshape(1, 3, 3), x[:, -3:], sizes)
        x = problem.solve((measured - (exact.reshape(1, -1) - x @ problem.model.T)).T).T
    return largest


def difference(rng, schedule):
    """Largest difference of a coefficient from the witness, of one random block on one random stand: over its u,
    and over what is allowed."""
    k, u0 = random_block(rng)
    stand = random_stand(rng, np.abs(k).max())
    if schedule.data.is_inclined:
        stand = replace(stand, inclination=10.0 ** rng.uniform(-5, -2))
    if unidentified(schedule.data):  # by a hair: the core judges by pivots, the plan by singular values
        return 0.0, 0.0
    means = run_on(rng, schedule.data, k, u0, stand)
    first_k = estimate(schedule.data, means, "least_squares")[0]
    table = record_for(schedule.data, first_k, stand)
    witness = optimal_estimate(schedule.data, means, stand, np.ones(len(schedule)))
    try:
        found = core_functions.optimal(table, schedule, means)
    except CoreRefusal as refusal:  # positions that hardly tell an angle, on a stand of milliradians
        assert refusal.name == "TUMBLE_E_STAND_ERROR"
        assert largest_angle(schedule.data, first_k, stand, means) > LARGE_RAD
        return 0.0, 0.0
    # An angle that the positions hardly tell comes out as 0 times a large number: by its declared error, as K by its u.
    for name, declared in (("alpha1", stand.axis_tilt), ("alpha2", stand.level), ("alpha3", stand.remount)):
        if name == "alpha1" and schedule.data.is_inclined:
            continue  # the witness has it with the first inclination's own error
        allowed = max(1e-9, LIMIT * declared)
        assert getattr(found, name) == pytest.approx(getattr(witness, name), abs=allowed), name
    apart = np.abs([*(found.k - witness.k).ravel(), *(found.u0 - witness.u0)])
    u = np.array([*witness.u_k.ravel(), *witness.u_u0])
    rounded = max(ROUNDING, SINGLE * witness.largest_angle**2 * witness.magnification) * np.abs(k).max()
    return (apart / u).max(), (apart / np.maximum(LIMIT * u, rounded)).max()


def worst_difference(rng, cases):
    schedules = (PAPER if case % 2 else usable_schedule(rng) for case in range(cases))
    of_u, of_allowed = np.array([difference(rng, schedule) for schedule in schedules]).max(axis=0)
    print(f"worst difference {of_u:.1e} u, {of_allowed:.2g} of what is allowed")
    return of_allowed


def test_random_stands_schedules_and_blocks_agree(cases):
    """200 with --full."""
    assert worst_difference(np.random.default_rng(60), cases(200)) <= 1.0


def two_boltings():
    """Of three inclinations and of two, the second time as in the paper's mounting 2, and a mounting for itself."""
    one, *others = built_in("inclined").mountings
    turned = replace(PAPER.data.mountings[1], bolting=7)
    mountings = (one, *others, replace(turned, number=11), replace(turned, number=12, tilt_deg=30.0),
                 replace(PAPER.data.mountings[0], number=13))  # fmt: skip
    angles = (0.0, 90.0, 180.0, 270.0)
    places = [(mounting.number, turn, angle) for mounting in mountings for turn, angle in enumerate(angles, 1)]
    return core.CoreSchedule(Schedule(mountings, tuple(Position(*place) for place in places)))


INCLINED = {name: core.CoreSchedule.built_in(name) for name in ("inclined", "inclined_closed")}
INCLINED["two boltings"] = two_boltings()


@pytest.mark.parametrize("name", INCLINED)
def test_random_inclined_stands_agree(name, cases):
    """30 with --full. Inclinations declared to 10 mrad, and off by as much, with all other errors of a stand."""
    rng = np.random.default_rng(65)
    found = np.array([difference(rng, INCLINED[name]) for _ in range(cases(30))]).max(axis=0)
    print(f"{name}: worst difference {found[0]:.1e} u, {found[1]:.2g} of what is allowed")
    assert found[1] <= 1.0


def largest_norm_error(found, k, u0):
    """Of |a|, g, over attitudes all over the sphere."""
    felt = np.linalg.solve(found.k, (spread_attitudes(2000) @ k.T + u0 - found.u0).T)
    return np.abs(np.linalg.norm(felt, axis=0) - 1.0).max()


@pytest.mark.parametrize(("off", "left_g"), [(1e-2, 4e-8), (2e-2, 4e-8), (5e-2, 2e-7)])
def test_inclinations_that_are_off_converge_to_the_exact_geometry(off, left_g):
    """Without noise. What is left is the pull of the prior; with a pass less it is 1.5 ug at 50 mrad."""
    schedule, k, u0 = INCLINED["inclined"], NOMINAL_K @ (np.eye(3) + 0.01), np.array([0.05, -0.08, 0.02])
    stand = replace(PAPER_STAND, inclination=max(off, 1e-2))
    errors = {"alpha1": off * np.array([1.0, -1.0, 1.0]), "seat_n": off * np.array([0.0, 1.0, -1.0])}
    means = Geometry(schedule.data).outputs(k, u0, **errors)
    found = core_functions.optimal(record_for(schedule.data, NOMINAL_K, stand), schedule, means)
    assert largest_norm_error(found, k, u0) < left_g


def test_an_inclination_of_another_schedule_is_no_error_of_the_stand():
    schedule = INCLINED["inclined"]
    record = record_for(schedule.data, NOMINAL_K, replace(PAPER_STAND, inclination=1e-2))
    means = Geometry(schedule.data).outputs(NOMINAL_K, np.zeros(3), alpha1=np.array([0.0, 0.12, 0.0]))
    with pytest.raises(CoreRefusal) as refused:
        core_functions.optimal(record, schedule, means)
    assert refused.value.name == "TUMBLE_E_STAND_ERROR"
    apart = tuple(replace(one, bolting=None) for one in schedule.data.mountings)
    with pytest.raises(CoreRefusal) as refused:
        core_functions.optimal(record, core.CoreSchedule(replace(schedule.data, mountings=apart)), means)
    assert refused.value.name == "TUMBLE_E_GAIN_TABLE"


@pytest.mark.parametrize("name", INCLINED)
def test_uncertainties_of_any_table_count_declared_inclinations(name):
    schedule, rng = INCLINED[name], np.random.default_rng(66)
    fitted, lone = schedule.data.fitted, np.ones(len(schedule), dtype=int)
    stand = replace(PAPER_STAND, inclination=2e-3, seat=1e-4, limits="uniform")
    gains, k = rng.normal(size=(12, 3 * len(fitted.positions))), NOMINAL_K + 0.1 * rng.normal(size=(3, 3))
    found = sources(fitted, k, stand, np.ones(len(fitted.positions), dtype=int))
    covariance = covariance_of(by_gains(fitted, gains), found)
    of_core = core.uncertainties_of_gains(schedule, k, stand, lone, gains)
    u = np.concatenate([np.ravel(part) for part in of_core])
    assert u == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-12)
    without = covariance - covariance_of(by_gains(fitted, gains), {"inclination": found["inclination"]})
    assert (u > 1.01 * np.sqrt(np.diag(without))).all()
    for n in spread_attitudes(5):
        weights = np.linalg.solve(k.T, n)
        weights = np.concatenate([np.outer(weights, n).ravel(), weights])
        u_norm = core_functions.worst_norm(schedule, k, stand, lone, None, gains, n)
        assert u_norm == pytest.approx(np.sqrt(weights @ covariance @ weights), rel=1e-12)


@pytest.mark.full
def test_10000_others_agree(fresh_seed):
    assert worst_difference(np.random.default_rng(fresh_seed), 10_000) <= 1.0


def test_the_limit_would_notice_a_missing_correction():
    """The canary of the limit: one correction instead of two, or the linear gains alone, lie far beyond it."""
    rng = np.random.default_rng(61)
    stand = Stand(1e-4, 1e-4, 15e-3, 1e-4, 1e-4, 10, "sigma1")
    means = run_on(rng, PAPER.data, NOMINAL_K, np.zeros(3), stand)
    first_k = estimate(PAPER.data, means, "least_squares")[0]
    opened = core.GainRecord(PAPER, record_for(PAPER.data, first_k, stand))
    linear_k, _ = core_functions.estimate_gains(PAPER, core_functions.gains_of(opened), means)
    witness = optimal_estimate(PAPER.data, means, stand, np.ones(18))
    assert np.abs((linear_k - witness.k) / witness.u_k).max() > 1e4 * LIMIT


def test_many_runs_at_once_are_the_runs_one_by_one():
    rng = np.random.default_rng(62)
    means = np.stack([run_on(rng, PAPER.data, NOMINAL_K, np.zeros(3), PAPER_STAND) for _ in range(20)])
    data = record_for(PAPER.data, NOMINAL_K, PAPER_STAND)
    found, stand = core.optimal_runs(core.GainRecord(PAPER, data), means)
    for run, of_stand, mean in zip(found, stand, means):
        one = core_functions.optimal(data, PAPER, mean)
        assert np.array_equal(run, np.concatenate([one.k.ravel(), one.u0]))
        assert np.array_equal(of_stand, np.concatenate([[one.alpha1, one.alpha2], one.alpha3]))
    for estimator in LINEAR:
        for run, mean in zip(core.estimate_runs(PAPER, means, estimator), means):
            k, u0 = core.estimate(PAPER, mean, None, estimator)
            assert np.array_equal(run, np.concatenate([k.ravel(), u0]))


def test_many_runs_at_once_name_the_run_refused():
    means = np.zeros((5, 18, 3))
    means[3, 7, 1] = np.nan
    opened = core.GainRecord(PAPER, record_for(PAPER.data, NOMINAL_K, PAPER_STAND))
    for call in (
        lambda: core.optimal_runs(opened, means),
        lambda: core.estimate_runs(PAPER, means, "refined"),
    ):
        with pytest.raises(CoreRefusal) as refused:
            call()
        assert (refused.value.name, refused.value.details) == ("TUMBLE_E_NOT_FINITE", {"run": 3})
    with pytest.raises(ValueError, match=r"means must have shape \(runs, 18, 3\), not \(18, 3\)"):
        core.optimal_runs(opened, means[0])


def test_fingerprints_know_boltings_where_there_are_any():
    for name in BUILT_IN:
        schedule = core.CoreSchedule.built_in(name)
        assert core_functions.schedule_crc(schedule) == optimal_run.fingerprint(schedule.data), name
    inclined = built_in("inclined")
    apart = replace(inclined, mountings=tuple(replace(one, bolting=None) for one in inclined.mountings))
    assert optimal_run.fingerprint(apart) != optimal_run.fingerprint(inclined)


def test_writer_and_reader_agree_on_every_number():
    rng = np.random.default_rng(63)
    for _ in range(50):
        schedule = usable_schedule(rng)
        stand = random_stand(rng, 2.0)
        table = optimal_table(schedule.data, NOMINAL_K, stand)
        opened = core.GainRecord(schedule, optimal_run.to_bytes(optimal_run.record_of(table, schedule.data)))
        assert core_functions.schedule_crc(schedule) == optimal_run.fingerprint(schedule.data)
        assert np.array_equal(core_functions.gains_of(opened), table.gains)
        assert np.array_equal(core_functions.stand_gains_of(opened), table.nuisance_gains)
        assert np.array_equal(np.array(list(map(list, opened.struct.k_v_per_g))), NOMINAL_K)
        assert opened.struct.sigma_mean_v == table.sigma_mean
        assert opened.struct.sigma_rad[3] == table.sigma[3]


@pytest.mark.parametrize("name", INCLINED)
def test_a_record_has_rows_for_inclinations(name):
    schedule = INCLINED[name].data
    noise = (1e-4, 2e-4, 1e-4)
    for stand in (PAPER_STAND, replace(PAPER_STAND, seat=1e-4, drift=1e-5, encoder=1e-5, noise=noise)):
        table = optimal_table(schedule, NOMINAL_K, replace(stand, inclination=3e-3))
        data = optimal_run.to_bytes(optimal_run.record_of(table, schedule))
        again, opened = gain_record.from_bytes(data), core.GainRecord(INCLINED[name], data)
        mountings = len(schedule.mountings)
        assert (data[9], again.inclinations, again.sigma_inclination) == (mountings, mountings, 3e-3)
        assert optimal_run.to_bytes(again) == data
        assert np.array_equal(core_functions.stand_gains_of(opened), table.nuisance_gains)
        tau = table.nuisance_gains[-mountings:]
        assert [not row.any() for row in tau] == [m in {b[0] for b in schedule.boltings} for m in range(mountings)]
        undeclared = optimal_run.to_bytes(optimal_run.record_of(optimal_table(schedule, NOMINAL_K, stand), schedule))
        again = gain_record.from_bytes(undeclared)
        assert (again.inclinations, again.sigma_inclination) == (mountings, 0.0)  # they may have any size


@pytest.mark.parametrize("spoil", ["short", "flipped", "foreign"])
def test_a_wrong_record_is_an_exception_and_no_result(spoil):
    data = record_for(PAPER.data, NOMINAL_K, PAPER_STAND)
    if spoil == "foreign":
        data = record_for(usable_schedule(np.random.default_rng(64)).data, NOMINAL_K, PAPER_STAND)
    spoilt = {"short": data[:-8], "flipped": data[:1000] + bytes([data[1000] ^ 1]) + data[1001:], "foreign": data}[
        spoil
    ]
    with pytest.raises(CoreRefusal) as refused:
        core_functions.optimal(spoilt, PAPER, np.zeros((18, 3)))
    expected = {"short": "TUMBLE_E_GAIN_RECORD", "flipped": "TUMBLE_E_CRC", "foreign": "TUMBLE_E_GAIN_TABLE"}
    assert refused.value.name == expected[spoil]
