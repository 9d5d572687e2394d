"""Calibrations over temperature on board: the firmware's arithmetic against the package's, and factory sets."""

from fractions import Fraction

import core_functions
import numpy as np
import pytest
from msgspec.structs import replace as changed
from test_store_golden import firmware, run_of_page  # noqa: F401
from test_thermal_exports import result_of

from tumble import core
from tumble.api.thermal import ThermalResult
from tumble.errors import BadInput
from tumble.model.thermal import Polynomials
from tumble.store import codec
from tumble.store.factory import factory_set

LIMIT = 1e-12  # of the largest term of a coefficient
SLOPE = 1e-4 * np.array([[1.0, 0.3, 0.0], [0.2, -0.8, 0.1], [0.0, 0.1, 0.5]])


def random_polynomials(rng, degree=2):
    size = np.array([1.0, 1e-4, 1e-6])[: degree + 1, None, None]
    k = np.concatenate([np.eye(3)[None], np.zeros((degree, 3, 3))]) + size * rng.normal(size=(degree + 1, 3, 3)) / 10.0
    return Polynomials(rng.uniform(-20.0, 50.0), k, size[..., 0] * rng.normal(size=(degree + 1, 3)) / 10.0)


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_coefficients_at_any_temperature_agree(degree):
    rng = np.random.default_rng(40 + degree)
    for _ in range(1000):
        polynomials, at = random_polynomials(rng, degree), rng.uniform(-64.0, 64.0)
        expected, found = polynomials.at(at), core_functions.thermal_at(polynomials, (-64.0, 64.0), at)
        powers = np.abs(at - polynomials.reference_c) ** np.arange(degree + 1.0)
        for one, other, by_power in zip(found, expected, (polynomials.k, polynomials.u0)):
            assert (np.abs(one - other) <= LIMIT * np.tensordot(powers, np.abs(by_power), axes=1)).all()


def test_force_at_a_temperature_agrees():
    rng, worst = np.random.default_rng(43), 0.0
    for _ in range(1000):
        polynomials, at, outputs = random_polynomials(rng), rng.uniform(-40.0, 60.0), rng.normal(size=3)
        k, u0 = polynomials.at(at)
        found = core_functions.thermal_apply(polynomials, (-64.0, 64.0), at, outputs)
        worst = max(worst, np.abs(found - np.linalg.solve(k, outputs - u0)).max() / np.linalg.cond(k))
    assert worst < LIMIT


@pytest.mark.parametrize(
    ("range_c", "at", "status"),
    [
        ((-40.0, 60.0), 60.5, "TUMBLE_E_ARGUMENT"),
        ((-40.0, 60.0), float("nan"), "TUMBLE_E_NOT_FINITE"),
    ],
)
def test_what_cannot_be_evaluated_is_refused(range_c, at, status):
    with pytest.raises(core.CoreRefusal) as refused:
        core_functions.thermal_at(random_polynomials(np.random.default_rng(1)), range_c, at)
    assert refused.value.name == status


def test_an_update_is_least_squares_with_the_polynomials_as_prior():
    """By rational numbers: the two rows (c + move - prior) / u and (c + move - run) / u_run, no root but that of u."""
    rng = np.random.default_rng(44)
    for _ in range(200):
        polynomials, at = random_polynomials(rng), rng.uniform(-40.0, 60.0)
        u, growth, u_run = (10.0 ** rng.uniform(-6, -3, 12) for _ in range(3))
        k, u0 = core_functions.thermal_at(polynomials, (-64.0, 64.0), at)
        there = np.append(k, u0)
        run = there + rng.normal(size=12) * 1e-4
        moved, u_moved = core_functions.thermal_update(polynomials, (-64.0, 64.0), u, growth, at, run, u_run)
        assert (moved.k[1:] == polynomials.k[1:]).all() and (moved.u0[1:] == polynomials.u0[1:]).all()
        before, after = (np.append(one.k[0], one.u0[0]) for one in (polynomials, moved))
        for c in range(12):
            prior = Fraction(u[c]) ** 2 + Fraction(growth[c]) ** 2
            weight = prior / (prior + Fraction(u_run[c]) ** 2)
            move = weight * (Fraction(run[c]) - Fraction(there[c]))
            rounding = Fraction(2**-52) * (1 + abs(Fraction(before[c])))
            assert abs(Fraction(after[c]) - Fraction(before[c]) - move) < rounding
            bound = float(1 - weight) * float(prior) ** 0.5 + float(weight) * u_run[c]
            assert u_moved[c] == pytest.approx(bound, rel=1e-13)


@pytest.fixture(scope="module")
def result():
    """Of runs from -30 to 70 deg C in volts, with a covariance, which stands for that of a declared stand."""
    told, rng = result_of(SLOPE, "V").checked, np.random.default_rng(45)
    root = rng.normal(size=(36, 36)) * np.repeat([1e-5, 1e-7, 1e-9], 12)[:, None]
    return changed(told, serial="0042", covariance=root @ root.T, passed=True, pass_reason=None)


def test_a_factory_set_is_the_calibration_in_single_precision(firmware, result):
    found = factory_set(result)
    assert (found.serial, found.temperature_c, found.origin) == ("0042", result.reference_c, 1)
    assert found.temperature_range_c == [-30.0, 63.5]  # a block's samples tell no more than that
    record = codec.encode_set(found)
    status, fields, written = firmware("set", record)
    assert (status, written) == (0, record)
    on_board = {name: np.array([float.fromhex(text) for text in fields[name]]) for name in ("k", "u0", "slopes", "u_k")}
    kept = codec.decode_set(record)
    assert [*kept.k, *kept.u0, *sum(kept.slopes, [])] == [*on_board["k"], *on_board["u0"], *on_board["slopes"]]
    single = np.array([np.append(k, u0) for k, u0 in zip(result.K, result.U0)]).astype(np.float32)
    assert np.concatenate([on_board["k"], on_board["u0"], on_board["slopes"]]).tolist() == single.ravel().tolist()
    of_set = Polynomials(kept.temperature_c, single[:, :9].reshape(-1, 3, 3).astype(float), single[:, 9:].astype(float))
    of_result = Polynomials(result.reference_c, np.array(result.K), np.array(result.U0))
    for at in np.arange(-30.0, 64.0, 0.5):
        (k, u0), (k_set, u0_set) = of_result.at(at), of_set.at(at)
        assert max(np.abs(k - k_set).max(), np.abs(u0 - u0_set).max()) < 1e-7  # 0.1 ug at 1 V/g
        by_core = core_functions.thermal_at(of_set, (-30.0, 63.5), at)
        assert max(np.abs(by_core[0] - k_set).max(), np.abs(by_core[1] - u0_set).max()) < LIMIT


def test_its_uncertainties_are_the_largest_over_the_range(result):
    found, each = factory_set(result), []
    for at in np.arange(-30.0, 64.0, 0.5):
        by = np.hstack([(at - result.reference_c) ** power * np.eye(12) for power in range(3)])
        each.append(np.sqrt(np.diag(by @ result.covariance @ by.T)))
    assert np.allclose(found.u_k + found.u_u0, np.max(each, axis=0), rtol=1e-12)
    alone = factory_set(changed(result, covariance=None))
    assert alone.u_k is None and alone.u_u0 is None


def test_millivolts_become_volts(result):
    found, other = factory_set(result), factory_set(changed(result, unit="mV"))
    assert np.allclose(np.array(other.k) * 1e3, found.k) and np.allclose(np.array(other.slopes) * 1e3, found.slopes)
    assert np.allclose(np.array(other.u_u0) * 1e3, found.u_u0)


def test_a_linear_calibration_has_zeros_above(result):
    linear = changed(result, degree=1, K=result.K[:2], U0=result.U0[:2], covariance=None)
    assert factory_set(linear).slopes[1] == [0.0] * 12
    assert codec.degree_of(codec.decode_set(codec.encode_set(factory_set(linear))).slopes) == 1


def test_the_factory_set_of_the_page_is_one(tumble, tmp_path, result):
    ThermalResult(result).save(tmp_path / "warm.json")
    run_of_page("    from tumble import load_thermal", tmp_path)
    assert (tmp_path / "nv.bin").stat().st_size == 65536
    active = tumble("store", "dump", tmp_path / "nv.bin").stdout.splitlines()[0]
    assert active.startswith("active (the factory set): sequence 0, factory, block '0042', ")
    said = "degree 2 over -30 to 63.5 deg C about 20 deg C, slopes of K_xx, K_yy, K_zz 0.0001, -8e-05, 5e-05 V/g/K, "
    assert said in active


@pytest.mark.parametrize(
    ("changes", "serial", "message"),
    [
        ({"passed": False, "pass_reason": "gravity"}, None, "the calibration: it did not pass: gravity"),
        ({"unit": "g"}, None, "the calibration: its outputs are in g, and a set is in volts"),
        (
            {"serial": None},
            None,
            "the calibration: names no block: write serial under [block] of the stand file, or give it",
        ),
        ({}, "x" * 25, "the calibration: a set names its block by a serial of at most 24 bytes"),
        (
            {"range_c": (64.0, 80.0)},
            None,
            "the calibration: its range, 64 to 80 deg C, has no half degree from -64 to 63.5 deg C",
        ),
    ],
)
def test_what_makes_no_factory_set_is_refused(result, changes, serial, message):
    with pytest.raises(BadInput) as refused:
        factory_set(changed(result, **changes), serial)
    assert str(refused.value) == message


def test_a_recalibration_at_one_temperature_serves_the_whole_range():
    """A block that has changed by 200 ppm and 200 ug, the same at all temperatures; a run at 35 deg C of 10 ppm."""
    rng, axes = np.random.default_rng(46), np.vstack([np.eye(3), -np.eye(3), np.ones((1, 3)) / 3.0**0.5])
    k, u0 = np.array([np.eye(3), SLOPE, SLOPE / 300.0]), np.array([[0.01, -0.02, 0.0], [5e-5] * 3, [1e-7] * 3])
    factory = Polynomials(20.0, k, u0)
    changed_k, changed_u0 = 2e-4 * np.eye(3), np.full(3, 2e-4)
    now = Polynomials(20.0, k + np.array([changed_k, 0 * k[0], 0 * k[0]]), u0 + np.outer([1.0, 0.0, 0.0], changed_u0))
    u_run = np.full(12, 1e-5)
    there = np.concatenate([np.ravel(one) for one in now.at(35.0)]) + u_run * rng.normal(size=12)
    growth = np.full(12, 2e-4)  # that of two months, of 1e-4 a month
    updated, u = core_functions.thermal_update(factory, (-40.0, 60.0), u_run, growth, 35.0, there, u_run)
    alone = Polynomials(20.0, there[None, :9].reshape(1, 3, 3), there[None, 9:])

    def worst_g(held):
        found = []
        for at in np.arange(-40.0, 61.0, 5.0):
            (k_at, u0_at), (k_held, u0_held) = now.at(at), held.at(at)
            force = np.linalg.solve(k_held, (axes @ k_at.T + u0_at - u0_held).T)
            found.append(np.abs(np.linalg.norm(force, axis=0) - 1.0).max())
        return max(found)

    before, after, single = worst_g(factory), worst_g(updated), worst_g(alone)
    print(f"worst |a|: {1e6 * before:.0f} ug before, {1e6 * after:.0f} after; of the run alone {1e6 * single:.0f}")
    assert before > 500e-6 and after < 20e-6 and single > 9e-3
    assert (u < 1.05e-5).all() and (u > 0.95e-5).all()
