"""Requirements: the budget at them meets every share, and a little more breaks one; brute force over the signs."""

import json
import re
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from conftest import EXAMPLES
from documents import paper_stand
from test_plan_budget import plan

from tumble.files.stand_file import read_stand
from tumble.planning import weights
from tumble.planning.budget import budget
from tumble.planning.case import Case
from tumble.planning.require import CEILING_RAD, ROWS, headroom, requirements, samples_for, stand_of
from tumble.planning.weights import NAMES

pytestmark = pytest.mark.python

PAPER = Case.of(None, None, None)
EQUAL = np.ones(5)
LIMIT_G = 3e-4
SIZE_KEYS = ("alpha1_rad", "alpha2_rad", "alpha3_rad", "alpha4_rad", "noise_v")
LINEAR = ("averaged", "refined", "least_squares")
EXACT = 1e-6


def worst_terms(case, estimator, sizes):
    """Terms (7, 5) of the rows on a stand of these sizes, by budgets for all 64 blocks: each the largest of them."""
    stand, worst = stand_of(case, sizes), np.zeros((7, 5))
    for signs in product((1.0, -1.0), repeat=6):
        pattern = np.eye(3)
        pattern[~np.eye(3, dtype=bool)] = signs
        terms = weights.derived(stand, estimator, stand.nominal_k(pattern)) * sizes
        rows = [terms[NAMES.index(name)] for name in ROWS[:-1]]
        worst = np.maximum(worst, [*rows, [0, 0, 0, 0, sizes[4] / abs(case.scale)]])
    return worst


def stands():
    for name, remounting in (("angle", "independent"), ("lab", "common")):
        file = EXAMPLES / f"{name}_stand.toml"
        case = Case.of(read_stand(file), file, None)
        yield replace(case, stand=replace(case.stand, remounting=remounting))


@pytest.mark.parametrize("estimator", LINEAR)
@pytest.mark.parametrize("split", [(1, 1, 1, 1, 1), (5, 1, 0.2, 1, 3)])
def test_at_the_requirements_every_share_is_met_and_each_source_exhausts_one(estimator, split):
    for case in stands():
        found = requirements(case, "derived", estimator, LIMIT_G, np.array(split))
        terms = worst_terms(case, estimator, found.limits)
        assert (terms <= found.shares * (1 + EXACT)).all()
        for source, name in enumerate(found.set_by):
            row = ROWS.index(name)
            assert terms[row, source] == pytest.approx(found.shares[row, source], rel=EXACT)
            more = np.where(np.arange(5) == source, found.limits * (1 + 1e-5), found.limits)
            assert (worst_terms(case, estimator, more) > found.shares * (1 + EXACT)).any()
        counted = found.shares > 0
        assert (np.linalg.norm(found.shares, axis=1) == pytest.approx(LIMIT_G / 3, rel=1e-12)) and counted.any(
            axis=1
        ).all()
        parts = np.where(counted, split, 0.0)
        assert found.shares**2 * parts.sum(axis=1, keepdims=True) == pytest.approx(parts * (LIMIT_G / 3) ** 2, rel=1e-9)


@pytest.mark.toolchain
@pytest.mark.parametrize("misalignment, split", [(0.02, EQUAL), (0.1, np.array([1, 1, 1, 4, 0.1]))])
@pytest.mark.parametrize("remounting", ["independent", "common"])
def test_requirements_of_the_optimal_estimator_fill_the_rows_and_are_never_stricter(misalignment, split, remounting):
    """With weights made for the very stand that the requirements describe; brute force over all blocks."""
    case = replace(PAPER, misalignment=misalignment, stand=replace(PAPER.stand, remounting=remounting))
    found = requirements(case, "derived", "optimal", LIMIT_G, split)
    refined = requirements(case, "derived", "refined", LIMIT_G, split)
    assert (found.limits >= refined.limits * (1 - EXACT)).all()
    ceiling = np.array([CEILING_RAD] * 4 + [case.scale])
    sizes = np.minimum(found.limits, ceiling)
    totals = row_totals(case, sizes)
    assert totals.max() == pytest.approx(LIMIT_G / 3, rel=EXACT)
    assert np.linalg.norm(found.shares, axis=1) == pytest.approx(totals, rel=EXACT)
    for source, name in enumerate(found.set_by):
        assert (name is None) == np.isinf(found.limits[source])
        if name is not None:
            assert totals[ROWS.index(name)] == pytest.approx(LIMIT_G / 3, rel=EXACT)
            more = np.where(np.arange(5) == source, sizes * 1.001, sizes)
            assert row_totals(case, more).max() > LIMIT_G / 3 * (1 + EXACT)


def row_totals(case, sizes):
    """Of the rows (7,) on a stand of these sizes, each for the worst of all 64 blocks."""
    stand, totals = stand_of(case, sizes), np.zeros(7)
    for signs in product((1.0, -1.0), repeat=6):
        pattern = np.eye(3)
        pattern[~np.eye(3, dtype=bool)] = signs
        terms = weights.derived(stand, "optimal", stand.nominal_k(pattern)) * sizes
        rows = [np.linalg.norm(terms[NAMES.index(name)]) for name in ROWS[:-1]]
        totals = np.maximum(totals, [*rows, sizes[4] / abs(case.scale)])
    return totals


def test_a_coarse_converter_is_noise_in_every_plan(tumble, tmp_path):
    """A stand of 1 uV behind 12 bits of 10 V: 1.4 mV of rounding, in every sample and once more in every mean, as
    samples round alike. Weights do not know that, those of a solve neither."""
    stand = ("--stand", paper_stand(tmp_path, block="converter_bits = 12\nrange_v = 10.0\n", noise_v="1e-6"))
    rounding = 20.0 / 2**12 / 12**0.5
    optimize = plan(tumble, "optimize", *stand)
    budgets = {name: plan(tumble, "budget", *stand, "--estimator", name) for name in ("refined", "optimal")}
    assert budgets["refined"]["sources"]["noise_v"] == pytest.approx(rounding * (1.0 + 1.0 / 50) ** 0.5)
    assert np.array(budgets["optimal"]["u_K"]) == pytest.approx(np.array(optimize["u_K"]), rel=1e-6)
    diagonal = [np.diag(np.array(one["u_K"])) for one in (optimize, budgets["refined"])]
    assert (np.array(diagonal) > 0.3 * rounding).all()
    assert plan(tumble, "require", *stand)["samples"] is None


@pytest.mark.slow
@pytest.mark.parametrize("estimator", ["refined", "optimal"])
def test_one_source_alone_and_all_together(estimator):
    """At `alone`, and at `margin` times the declared stand, the strictest row is exactly at its limit."""
    for case in stands():
        room = headroom(case, "derived", estimator, LIMIT_G)
        declared = np.array([case.stand.sigma(n) for n in ("axis_tilt", "level", "remount", "angle", "noise")])
        declared[4] /= case.stand.samples**0.5

        def worst(sizes, case=case):
            return np.linalg.norm(worst_terms(case, estimator, sizes), axis=1).max() / (LIMIT_G / 3)

        assert worst(room.margin * declared) == pytest.approx(1.0, rel=EXACT)
        for source, limit in enumerate(room.alone):
            alone = np.where(np.arange(5) == source, min(limit, CEILING_RAD), declared)
            if limit == 0.0:
                assert worst(alone) > 1.0
            elif np.isinf(limit):
                assert worst(alone) <= 1.0
            elif estimator == "optimal":
                assert worst(alone) == pytest.approx(1.0, rel=EXACT)
            else:
                # the worst signs of each source need not go together, so the sum of worst terms may be a little more
                assert 1.0 - EXACT <= worst(alone) < 1.01


def test_published_has_the_printed_formulas_and_the_rule(tumble):
    found = plan(tumble, "require", "--weights", "published")
    assert [found[key] for key in SIZE_KEYS] == pytest.approx([3e-4 / 2.6, 3e-4 / 5.2 / 0.02, 15e-3, 3e-4 / 0.8, 2e-4])
    rule = [3e-4 / (3 * 3**0.5 * 0.5), 3e-4 / 6 / 0.02, 3e-4 / 6 / 0.02, 3e-4 / (3 * 3**0.5 * 0.4), 2e-4]
    assert [found["rule"][key] for key in SIZE_KEYS] == pytest.approx(rule)
    assert list(found["rule"]["set_by"].values()) == ["a0_y", "K_xx", "K_xx", "a0_x", "noise"]
    of_k_yy = [3e-4 / 5.2 / 0.02, 3e-4 / 0.8, 3e-4 * 2 / 1.6]
    assert list(found["equation_18"].values()) == pytest.approx(of_k_yy)
    assert found["samples"] == found["rule"]["samples"] == 3


def test_derived_by_hand(tumble):
    """gamma1 = (1 + a)/2 for a0_y with three sources; gamma3 = a sqrt(2)/2 for K_xx with four."""
    found = plan(tumble, "require")
    assert found["alpha1_rad"] == pytest.approx(1e-4 / 3**0.5 / 0.51, rel=1e-9)
    assert found["alpha2_rad"] == pytest.approx(1e-4 / 2 / 0.02, rel=1e-9)
    assert found["alpha3_rad"] == pytest.approx(1e-4 / 2 / (0.02 / 2**0.5), rel=1e-9)
    assert found["noise_v"] == pytest.approx(2e-4, rel=1e-9)
    assert list(found["set_by"].values()) == ["a0_y", "K_xx", "K_xx", "K_yy", "noise"]


def test_optimal_asks_less(tumble):
    refined, optimal = (plan(tumble, "require", "--estimator", name) for name in ("refined", "optimal"))
    for key in ("alpha1_rad", "alpha4_rad"):
        assert refined[key] is not None and optimal[key] is None
    for key in ("alpha2_rad", "alpha3_rad"):
        assert optimal[key] > 1.1 * refined[key]
    assert all(optimal["alone"][key] is None for key in SIZE_KEYS[:4])
    assert optimal["set_by"] == {"alpha1": None, "alpha2": "K_xx", "alpha3": "K_xx", "alpha4": None, "noise": "noise"}


@pytest.mark.parametrize(
    "arguments, complaint",
    [
        (["--limit", "-1e-4"], "--limit: '-1e-4' is not a number of g above 0"),
        (["--limit=-1e-4"], "--limit: '-1e-4' is not a number of g above 0"),
        (["--split", "alpha1=1,alpha1=3"], "--split: alpha1 is given twice"),
        (["--estimator", "optimal", "--limit", "1e-12"], "unreachable: "),
    ],
)
def test_bad_options_are_said(arguments, complaint, refused):
    assert complaint in refused("plan", "require", *arguments)


def test_the_limit_is_the_options_or_the_stand_files(tumble, tmp_path):
    stand = paper_stand(tmp_path, delta_g_limit_g="6e-4")
    ordinary, wide = plan(tumble, "require"), plan(tumble, "require", "--stand", stand)
    assert wide["alpha1_rad"] == pytest.approx(2 * ordinary["alpha1_rad"])
    narrow = plan(tumble, "require", "--stand", stand, "--limit", "3e-4")
    assert narrow == {**ordinary, "limit_g": 3e-4}


def test_a_split_moves_the_requirements(tumble):
    equal, quiet = plan(tumble, "require"), plan(tumble, "require", "--split", "noise=4, alpha4=0.5")
    assert quiet["split"] == {"alpha1": 1, "alpha2": 1, "alpha3": 1, "alpha4": 0.5, "noise": 4}
    assert quiet["alpha4_rad"] < equal["alpha4_rad"]
    assert quiet["alpha4_rad"] == pytest.approx(
        1e-4 * (0.5 / 5.5) ** 0.5 / quiet["rows"]["K_yy"]["weights"][3], rel=1e-9
    )


def test_any_estimator_and_schedule(tumble):
    found = plan(tumble, "require", "--schedule", EXAMPLES / "six_faces.toml", "--estimator", "least_squares", "--json")
    assert json.dumps(found)
    assert all(found[key] > 0 for key in SIZE_KEYS)


def test_the_sign_of_the_scale_does_not_matter():
    turned = replace(PAPER, scale=-2.0)
    for which, estimator in (("published", "refined"), ("derived", "refined")):
        one, other = (requirements(case, which, estimator, LIMIT_G, EQUAL) for case in (PAPER, turned))
        assert other.limits == pytest.approx(one.limits, rel=1e-12)
    assert budget(turned, "derived", "optimal").total == pytest.approx(
        budget(PAPER, "derived", "optimal").total, rel=1e-6
    )


def test_the_fewest_samples():
    assert [samples_for(3e-4, limit) for limit in (1.0, 3e-4, 2.999e-4, 1.5e-4, 1e-4)] == [1, 1, 2, 4, 9]
    assert samples_for(0.0, 1e-9) == 1


@pytest.mark.toolchain
def test_the_last_words_say_whether_the_stand_will_do(tumble):
    """The lab's stand: too poor for the paper's estimators, good enough for the optimal one."""
    arguments = ("plan", "require", "--stand", EXAMPLES / "lab_stand.toml")
    margins = plan(tumble, *arguments[1:])["margins"]
    assert list(margins) == ["averaged", "refined", "least_squares", "optimal"]
    assert margins["refined"] < 1.0 < margins["optimal"]
    shown = tumble(*arguments).stdout
    assert max(map(len, shown.splitlines())) <= 80
    assert "none left: the others alone exceed the limit already" in shown and "no limit" not in shown
    words = " ".join(shown.split("\n\n")[-1].split())
    assert words.startswith("Does this stand reach 0.0003 g with a probability of 95 %? ")
    for name, verdict in (("averaged", "no"), ("refined", "no"), ("least_squares", "no"), ("optimal", "yes")):
        assert re.search(rf"\b{name} {verdict} .*? {margins[name]:.3g} ", words), name
    assert "alpha3 yaw of the block" in shown
    optimal = tumble(*arguments, "--estimator", "optimal").stdout
    assert "no limit: the source limits nothing up to 0.01 rad, as far as was tried" in optimal
    assert "none left" not in optimal


def test_a_schedule_that_an_estimator_cannot_use_has_no_margin_with_it(tumble):
    arguments = ("require", "--schedule", EXAMPLES / "six_faces.toml", "--estimator", "least_squares")
    assert list(plan(tumble, *arguments)["margins"]) == ["least_squares", "optimal"]
