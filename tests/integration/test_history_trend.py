"""Growth and control charts of `tumble history`: against normal distributions in all their dimensions, and against what
was simulated."""

import itertools
import json
import warnings

import numpy as np
import pytest
from fleets import TRUTH, U, fleet, rows_of

from tumble.documents.base import written
from tumble.history import History, trend
from tumble.history.calibrations import OF_BLOCK, PARAMETERS
from tumble.history.trend import DRIFT, IN_ORDER, JUMP, OPEN, OUTLIER, Growth, Series, filtered, growth_of

pytestmark = pytest.mark.python
LIMIT = trend.control_limit(0.9973)


def covariance(days, variances, spread, walk):
    """Of y against its first value, with the drift of the block and its walk in it."""
    since = days - days[0]
    return (
        np.diag(variances) + spread**2 * np.outer(since, since) + walk**2 * np.minimum.outer(since, since)
    )


def contrasts(count):
    """Rows that the unknown first value is not in."""
    return np.eye(count)[1:] - np.eye(count)[:1]


def log_density(days, values, variances, drift, spread, walk):
    """Of the differences to the first calibration."""
    rows = contrasts(len(days))
    joint = rows @ covariance(days, variances, spread, walk) @ rows.T
    left = rows @ (values - drift * (days - days[0]))
    return -0.5 * (np.linalg.slogdet(joint)[1] + left @ np.linalg.solve(joint, left))


def small(seed=3, blocks=4, each=6):
    """Some blocks, of which calibrations and single values are missing."""
    found = fleet(blocks, each, seed).series
    rng = np.random.default_rng(seed)
    found.variances[:] *= rng.uniform(0.3, 3.0, found.variances.shape)
    found.values[1, 4:], found.days[1, 4:], found.rows[1, 4:] = np.nan, np.nan, -1
    found.values[2, 2, 5] = np.nan
    return found


def test_innovations_are_those_of_conditional_distributions():
    """Of every calibration, by all that came before it: generalised least squares over all values at once."""
    series = small()
    found = filtered(series, TRUTH, LIMIT, known=np.zeros(series.values.shape, dtype=int))
    for block, place in itertools.product(range(4), range(12)):
        there = np.flatnonzero(np.isfinite(series.values[block, :, place]))
        days, values = series.days[block, there], series.values[block, there, place]
        joint = covariance(days, series.variances[block, there, place], TRUTH.spread[place], TRUTH.walk[place])
        centred = values - TRUTH.drift[place] * (days - days[0])
        for k in range(1, len(there)):
            inverse, ones = np.linalg.inv(joint[:k, :k]), np.ones(k)
            u2 = 1.0 / (ones @ inverse @ ones)
            level = u2 * (ones @ inverse @ centred[:k])
            with_past = joint[k, :k] @ inverse
            mean = level + with_past @ (centred[:k] - level)
            s = joint[k, k] - with_past @ joint[:k, k] + (1.0 - with_past @ ones) ** 2 * u2
            assert found.size[block, there[k], place] == pytest.approx(centred[k] - mean, rel=1e-6, abs=1e-14)
            assert found.logs[block, there[k], place] == pytest.approx(np.log(s), rel=1e-9)
            assert found.z[block, there[k], place] == pytest.approx((centred[k] - mean) / np.sqrt(s), rel=1e-6)


def test_the_state_at_the_end_is_that_of_the_joint_distribution():
    """Last value and rate of a block, by one least squares problem."""
    series = small()
    last = filtered(series, TRUTH, LIMIT, known=np.zeros(series.values.shape, dtype=int)).last
    for place in range(12):
        days, values = series.days[0] - series.days[0, 0], series.values[0, :, place]
        spread, walk = TRUTH.spread[place] or 1e-30, TRUTH.walk[place] or 1e-30
        count = len(days)
        # unknowns: first value, rate, steps of the walk
        sum_of_steps = np.tril(np.ones((count, count)), 0)[:, 1:]
        design = np.column_stack([np.ones(count), days, sum_of_steps])
        prior = np.diag([0.0, spread**-2, *1.0 / (walk**2 * np.diff(days))])
        weight = np.diag(1.0 / series.variances[0, :, place])
        joint = np.linalg.inv(design.T @ weight @ design + prior)
        means = joint @ (design.T @ weight @ values + prior @ np.array([0.0, TRUTH.drift[place], *np.zeros(count - 1)]))
        to_end = np.stack([design[-1], np.eye(count + 1)[1]])
        assert [last.x[0, place], last.rate[0, place]] == pytest.approx(to_end @ means, rel=1e-6, abs=1e-16)
        ends = to_end @ joint @ to_end.T
        assert last.p_xx[0, place] == pytest.approx(ends[0, 0], rel=1e-6)
        assert last.p_xr[0, place] == pytest.approx(ends[0, 1], rel=1e-6, abs=1e-25)
        assert last.p_rr[0, place] == pytest.approx(ends[1, 1], rel=1e-6, abs=1e-25)


def test_the_likelihood_is_that_of_all_values_at_once_and_is_greatest():
    """By its own formula; and no drift, spread or walk beside those found is likelier."""
    series = fleet(60, 6, 8).series
    growth = growth_of([series], np.inf)

    def total(place, drift, spread, walk):
        return sum(
            log_density(series.days[b], series.values[b, :, place], series.variances[b, :, place], drift, spread, walk)
            for b in range(60)
        )

    known = np.zeros(series.values.shape, dtype=int)
    for place in (0, 4, 8):
        found = [getattr(growth, name)[place] for name in ("drift", "spread", "walk")]
        best = total(place, *found)
        others = [Growth(TRUTH.drift, s * growth.spread, w * growth.walk) for s, w in ((1, 1), (0.5, 1.2))]
        heights = [trend._log_likelihood([series], [known], one) for one in others]
        mine = heights[1][0][place] - heights[0][0][place]
        theirs = total(place, heights[1][1].drift[place], found[1] * 0.5, found[2] * 1.2) - best
        assert mine == pytest.approx(theirs, rel=1e-6)
        for which, step in itertools.product(range(3), (-1.0, 1.0)):
            beside = list(found)
            beside[which] += step * 0.3 * [growth.u_drift, growth.u_spread, growth.u_walk][which][place]
            assert total(place, *beside) < best + 1e-3
        assert growth.u_drift[place] ** -2 == pytest.approx(
            -(total(place, found[0] + 1e-9, *found[1:]) - 2 * best + total(place, found[0] - 1e-9, *found[1:])) / 1e-18,
            rel=1e-3,
        )


def test_growth_is_found_within_its_uncertainty(cases):
    """Drift, spread and walk of simulated types: pulls of mean 0 and size 1. Where the truth is 0, spread and walk are
    of a distribution that ends there; they are no larger than three of their uncertainties."""
    pulls = []
    for seed in range(cases(24)):
        growth = growth_of([fleet(150, 8, 100 + seed).series], LIMIT)
        pulls.append([(getattr(growth, n) - getattr(TRUTH, n)) / getattr(growth, f"u_{n}") for n in ("drift", "walk")])
        assert (np.abs(growth.ratio - 1.0) < 0.1).all()
    pulls = np.array(pulls)[:, :, :OF_BLOCK]
    count = pulls[:, 0].size
    for of_one in (pulls[:, 0], pulls[:, 1]):
        assert abs(of_one.mean()) < 4.0 / np.sqrt(count)
        assert of_one.std() == pytest.approx(1.0, abs=4.0 / np.sqrt(2 * count))


def test_jumps_leave_growth_as_it_is():
    """Of one calibration of twenty."""
    calm, shaken = (growth_of([fleet(400, 8, 5, jumps=share).series], LIMIT) for share in (0.0, 0.005))
    for name in ("drift", "spread", "walk"):
        moved = np.abs(getattr(shaken, name) - getattr(calm, name))[:OF_BLOCK]
        assert (moved < 2.0 * getattr(calm, f"u_{name}")[:OF_BLOCK]).all(), name


def test_false_alarms_are_as_stated():
    """Of 0.27 % at most, by Bonferroni's bound: not far below either, for the charts are nearly independent."""
    found = fleet(3000, 9, 21)
    kinds = filtered(found.series, TRUTH, LIMIT).kinds
    share = (kinds[:, 1:] > IN_ORDER).any(axis=2).mean()
    assert 0.0015 < share < 0.0027 + 3.0 * np.sqrt(0.0027 / (3000 * 8))
    of_one = filtered(found.series, TRUTH, trend.control_limit(0.95)).kinds
    assert 0.03 < (of_one[:, 1:] > IN_ORDER).any(axis=2).mean() < 0.05 + 3.0 * np.sqrt(0.05 / (3000 * 8))


def test_jumps_and_outliers_are_found_and_told_apart():
    """Of twelve standard deviations; a last one is open; a seat that was exchanged changes the seat alone."""
    found = fleet(3000, 9, 22, jumps=0.002, outliers=0.002, seats=0.02)
    kinds = filtered(found.series, TRUTH, LIMIT).kinds
    inner = np.zeros(kinds.shape, dtype=bool)
    inner[:, 1:-1] = True
    either = found.jumps | found.outliers
    alone = inner & ~np.roll(either, -1, axis=1) & ~np.roll(either, 1, axis=1)
    jumps, outliers = alone & found.jumps & ~found.outliers, alone & found.outliers & ~found.jumps
    assert jumps.sum() > 100 and (kinds[jumps] == JUMP).mean() > 0.995
    assert outliers.sum() > 100 and (kinds[outliers] == OUTLIER).mean() > 0.995
    ends = either[:, -1]
    assert (kinds[:, -1][ends] == OPEN).mean() > 0.99
    seats = found.seats[:, 1:-1]
    of_seat = (kinds[:, 1:-1, OF_BLOCK:] > IN_ORDER).any(axis=2)
    assert of_seat[seats].mean() > 0.95 and of_seat[~seats].mean() < 0.01
    beside = (kinds[:, 1:-1, :OF_BLOCK] > IN_ORDER).any(axis=2)[seats].mean()
    assert beside < 0.05


def test_a_drift_that_is_slow_is_found_by_the_moving_average():
    """Steps of two standard deviations each time, of a type that does not drift: by EWMA before Shewhart's chart."""
    still = Growth(np.zeros(12), np.zeros(12), TRUTH.walk)
    found = fleet(300, 16, 23, growth=still)
    found.series.values[..., 0] += 2.0 * U[0] * np.arange(16)
    kinds = filtered(found.series, still, LIMIT).kinds[..., 0]
    first = np.where((kinds > IN_ORDER).any(axis=1), (kinds > IN_ORDER).argmax(axis=1), 99)
    assert (first < 16).mean() > 0.9
    assert (kinds[np.arange(300)[first < 16], first[first < 16]] == DRIFT).mean() > 0.8


def test_a_new_stand_begins_the_seat_anew():
    """A turn of the seat from stand to stand is no alarm."""
    found = fleet(50, 6, 24)
    found.series.values[:, 3:, OF_BLOCK:] += 0.01
    assert (filtered(found.series, TRUTH, LIMIT).kinds[:, 3, OF_BLOCK:] == JUMP).all()
    found.series.anew[:, 3] = True
    assert not (filtered(found.series, TRUTH, LIMIT).kinds[:, 3, OF_BLOCK:] > IN_ORDER).any()


def test_a_small_turn_of_the_seat_is_that_of_the_matrices():
    rng = np.random.default_rng(2)
    first, turn = rng.normal(size=(2, 20, 3))
    turn *= 1e-4
    matrices = trend._turns(first) @ trend._turns(turn)
    assert trend._turns(turn) @ np.swapaxes(trend._turns(turn), 1, 2) == pytest.approx(np.eye(3)[None].repeat(20, 0))
    cross = (matrices - np.swapaxes(matrices, 1, 2)) / 2.0
    sine = np.stack([cross[:, 2, 1], cross[:, 0, 2], cross[:, 1, 0]], axis=1)
    length = np.linalg.norm(sine, axis=1)
    angle = np.arctan2(length, (np.trace(matrices, axis1=1, axis2=2) - 1.0) / 2.0)
    then = sine / length[:, None] * angle[:, None]
    assert trend.turned_by(first, then) == pytest.approx(turn, rel=1e-9, abs=1e-14)


def test_growth_of_too_few_is_unknown():
    assert growth_of([fleet(3, 4, 1).series], LIMIT) is None
    assert growth_of([fleet(5, 3, 1).series], LIMIT) is not None


def test_all_parameters_have_names():
    assert len(PARAMETERS) == len(U) == 12 and isinstance(fleet(1, 2, 1).series, Series)


def test_exact_and_simultaneous_calibrations_are_no_numbers_that_are_none(tmp_path):
    """Of a stand without errors, and all of one second."""
    found = fleet(6, 4, 9)
    rows = rows_of(found.series)
    for row in rows:
        row.update({f"u_{name}": 0.0 for name in PARAMETERS}, created_s=rows[0]["created_s"])
    with History(tmp_path / "h.db") as history, warnings.catch_warnings():
        warnings.simplefilter("error")
        history.add_rows(rows)
        told = history.trend()
        json.dumps(written(told), allow_nan=False)
        assert (told.blocks, told.calibrations) == (6, 24)
        json.dumps(written(history.due(1e-4)), allow_nan=False)
