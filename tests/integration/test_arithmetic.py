"""The operations of a formula, which tools/benchmark cortex_m4 multiplies by what each costs: counts, and values."""

import sys

import numpy as np
import pytest
from conftest import ROOT

from tumble import core, model
from tumble.model import Geometry
from tumble.model.estimators import circles

sys.path.insert(0, str(ROOT / "tests/benchmark"))

import arithmetic
from arithmetic import counted


def test_each_operation_counts_once():
    done, (found,) = counted(lambda rows: [-(a * 3.0 + b - 1.5) / c * 0.25 for a, b, c in rows], [[5.0, 7.0, 2.0]])
    assert found == -(5.0 * 3.0 + 7.0 - 1.5) / 2.0 * 0.25
    assert done == {"multiplication": 1, "addition": 2, "division": 1}


@pytest.mark.parametrize(("factor", "free"), [(2.0, True), (-0.125, True), (1.0, True), (3.0, False), (0.1, False)])
def test_a_power_of_two_is_free(factor, free):
    done, (found,) = counted(lambda rows: [rows[0][0] * factor], [[7.0]])
    assert found == 7.0 * factor and done == ({} if free else {"multiplication": 1})


def test_means_take_a_division_and_a_scale_each():
    done, found = counted(arithmetic.means, [[100.0, 8.0, 2.5]] * 54)
    assert done == {"division": 54, "multiplication": 54} and found == [31.25] * 54


def test_gains_take_a_product_for_each_that_is_not_zero():
    gains = [[3.0, 0.0, 5.0], [0.0, 7.0, 0.1]]
    done, found = counted(arithmetic.linear(gains), [[1.0], [10.0], [100.0]])
    assert done == {"multiplication": 4, "addition": 2} and found == [503.0, 80.0]


@pytest.mark.parametrize(("name", "expected"), [
    # a circle of nine: 6 + 5 + 5 additions for c, s, b of a channel, 2 products; then the sums over circles
    ("paper", {"addition": 6 * 16 - 2 * 5 + 4, "multiplication": 6 * 2 - 2}),
    ("three_mountings", {"addition": 6 * 16 + 3 * 8 + 3 + 6, "multiplication": 6 * 2 + 3}),
    # of four: 2 + 3 for b and differences, 1 each for c and s, which take a product each
    ("diagonal", {"addition": 6 * 7 + 3 * 3 + 3 + 6, "multiplication": 6 * 2 + 3}),
])
def test_the_closed_form_counted_by_hand_and_right(name, expected):
    schedule = core.built_in(name)
    rng = np.random.default_rng(4)
    k, u0 = np.eye(3) * 2.0 + 0.1 * rng.normal(size=(3, 3)), 0.02 * rng.normal(size=3)
    u = Geometry(schedule).outputs(k, u0) + 1e-3 * rng.normal(size=(len(schedule.positions), 3))
    done, found = counted(arithmetic.refined(circles(schedule)), u.tolist())
    true_k, true_u0 = model.estimate(schedule, u, "refined")
    assert np.abs(found - np.concatenate([true_k.ravel(), true_u0])).max() < 1e-14
    assert done == expected
