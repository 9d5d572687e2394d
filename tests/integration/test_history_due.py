"""Due dates of `tumble history`: against the uncertainty that a result states, grown by hand, and against what
simulated blocks do until then."""

import json

import numpy as np
import pytest
from blocks import NOMINAL_K
from calibrations import result
from documents import valid
from fleets import TRUTH, fleet, forecast_of, off_when_due, rows_of

from tumble.errors import BadInput
from tumble.history import History, due, trend
from tumble.history.calibrations import PARAMETERS, numbers_of, row_of, unpacked
from tumble.history.due import Forecast, norm_gradients, worst_changes
from tumble.model.coefficients import by_intrinsic, worst_norm

pytestmark = pytest.mark.python
U0 = np.array([0.01, -0.02, 0.03])


def random_forecast(rng, rate=0.0):
    """Of one block, and its K, U0 and covariance (12, 12)."""
    k = np.diag([2.0, 1.5, -2.5]) @ (np.eye(3) + 0.05 * rng.normal(size=(3, 3)))
    u0 = 0.02 * rng.normal(size=3)
    spread = 5e-6 * rng.normal(size=(12, 12))
    row = numbers_of(k, u0, spread.T @ spread)
    angles, bias = (np.array([[row[name] for name in PARAMETERS[at : at + 3]]]) for at in (3, 6))
    linear, square = rng.uniform(0.0, 1e-12, (2, 1, 9)) * np.array([1.0, 1e-3])[:, None, None]
    return Forecast(angles, bias, unpacked([row["covariance"]]), np.full((1, 9), rate), linear, square), k, u0, spread


def test_the_uncertainty_is_that_of_the_result():
    """Of K and U0 with all they have in common: the worst attitude is as the result has it, on every seat."""
    rng = np.random.default_rng(1)
    for _ in range(5):
        forecast, k, _, spread = random_forecast(rng)

        def u(attitudes, forecast=forecast):
            g = norm_gradients(forecast.angles, forecast.bias, attitudes)
            return np.sqrt(np.einsum("bni,bij,bnj->bn", g, forecast.covariance, g))

        assert due.largest_over_attitudes(u, 1)[0] == pytest.approx(worst_norm(k, spread.T @ spread).worst_g, rel=1e-9)


def test_the_day_is_where_the_grown_uncertainty_reaches_the_limit():
    """By worst_norm of K, U0 and their covariance with the growth in it: just before it is within, just behind not."""
    rng = np.random.default_rng(2)
    for _ in range(5):
        forecast, k, u0, spread = random_forecast(rng)
        days = float(forecast.days(1e-4, 2.0)[0])
        by_block = by_intrinsic(k, u0)
        by_block[:3] /= np.linalg.norm(k, axis=1)[:, None]
        back = np.linalg.pinv(by_block)
        reach = []
        for at in (days * (1 - 1e-6), days * (1 + 1e-6)):
            grown = forecast.linear[0] * at + forecast.square[0] * at**2
            reach.append(2.0 * worst_norm(k, spread.T @ spread + back @ np.diag(grown) @ back.T).worst_g)
        assert 0.0 < days < 1e6 and reach[0] < 1e-4 < reach[1]


def test_an_expected_drift_counts_in_full():
    """Of a known block that only drifts, in bias x by b a day: the limit over b."""
    zero = np.zeros((1, 9))
    rate = zero.copy()
    rate[0, 6] = 1e-7
    known = Forecast(np.full((1, 3), np.pi / 2), np.zeros((1, 3)), np.zeros((1, 9, 9)), rate, zero, zero)
    assert known.days(1e-4, 3.0)[0] == pytest.approx(1000.0, rel=1e-6)
    assert np.isinf(Forecast(known.angles, known.bias, known.covariance, zero, zero, zero).days(1e-4, 3.0)[0])


def test_a_change_shows_at_its_worst_attitude():
    """A scale and an angle of a right-angled block: d at its axis; half of it between the axes of an angle."""
    changes = np.zeros((2, 9))
    changes[0, 0], changes[1, 3] = 1e-5, 1e-5
    found = worst_changes(np.full((2, 3), np.pi / 2), np.zeros((2, 3)), changes)
    assert found == pytest.approx([1e-5, 0.5e-5], rel=1e-6)


@pytest.mark.parametrize("off, factor", [(0.0, 1.25), (0.79, 1.25), (0.81, 1.0), (1.0, 1.0), (1.01, 0.5)])
def test_the_staircase_has_three_steps(off, factor):
    assert due.staircase(np.array([200.0]), np.array([off * 1e-4]), 1e-4) == pytest.approx([200.0 * factor])


LIMIT_G, COVERAGE = 6e-5, 2.0


@pytest.mark.parametrize("each", [3, 10])
def test_blocks_are_within_the_limit_as_often_as_their_coverage_says(each):
    """On the day when they are due, with the growth that was estimated from them. An expected drift adds to the
    uncertainty, so that it is 95.4 % at least and 97.7 % at most."""
    found = fleet(1500, each, 31 + each)
    growth = trend.growth_of([found.series], trend.control_limit(0.9973))
    forecast = forecast_of(found.series, growth)
    days = forecast.days(LIMIT_G, COVERAGE)
    within = (off_when_due(found, forecast, days, LIMIT_G, COVERAGE, each) <= LIMIT_G).mean()
    assert 0.9545 - 3.0 * np.sqrt(0.0455 * 0.9545 / 1500) < within < 0.9772 + 3.0 * np.sqrt(0.0228 * 0.977 / 1500)


def test_due_days_are_those_of_the_true_growth():
    """Of an estimated growth they differ from those of the true one by some per cent."""
    found = fleet(500, 10, 41)
    estimated = trend.growth_of([found.series], trend.control_limit(0.9973))
    days = [forecast_of(found.series, growth).days(LIMIT_G, COVERAGE) for growth in (TRUTH, estimated)]
    assert np.abs(days[1] / days[0] - 1.0).max() < 0.1


def test_blocks_are_listed_by_their_days(tumble, tmp_path):
    """The command says what the door for scripts does; an alarm of the last calibration makes a block due at once."""
    found = fleet(30, 6, 51)
    found.series.values[7, -1, 6] += 1e-3
    with History(tmp_path / "history.db") as history:
        history.add_rows(rows_of(found.series))
        told = history.due(1e-4)
    assert [one.due for one in told.blocks] == sorted(one.due for one in told.blocks)
    assert {one.serial: one.why for one in told.blocks}["B000007"] == "alarm"
    assert {one.why for one in told.blocks if one.serial != "B000007"} == {"growth"}
    done = tumble("history", "due", "--limit", "1e-4", "--on", "2000-01-01", "--json", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert valid(done.stdout, "history")["blocks"][0]["serial"] == told.blocks[0].serial
    never = tumble("history", "due", "--limit", "1", "--serial", "B000003", cwd=tmp_path)
    assert never.stdout.splitlines()[-1].endswith(" -  not in 100 years")
    late = tumble("history", "due", "--limit", "1e-4", "--on", "2100-01-01", "--serial", "B000003", cwd=tmp_path)
    assert late.returncode == 1
    assert late.stdout.splitlines()[0] == "Limit 0.0001 g, 3 u(|a|); 1 block"
    one = next(one for one in told.blocks if one.serial == "B000003")
    assert late.stdout.splitlines()[2].split() == [
        one.due[:10], "B000003", "T", one.last[:10], f"{one.days:.0f}", "growth",
    ]  # fmt: skip


def test_the_trend_tells_growth_and_alarms(tumble, tmp_path):
    found = fleet(30, 6, 51)
    found.series.values[7, -1, 6] += 1e-3
    found.series.values[8, 3:, 9] += 3e-3
    with History(tmp_path / "history.db") as history:
        history.add_rows(rows_of(found.series))
    done = tumble("history", "trend", "--json", cwd=tmp_path)
    told = valid(done.stdout, "history")
    assert (done.returncode, told["blocks"], told["calibrations"]) == (1, 30, 180)
    shown = {(one["serial"], one["parameter"]): (one["kind"], one["of_seat"]) for one in told["alarms"]}
    assert shown["B000007", "bias_x"] == ("open", False) and shown["B000008", "seat_x"] == ("jump", True)
    (kind,) = told["types"]
    assert kind["intervals"] == 150 and [one["name"] for one in kind["growth"]] == list(PARAMETERS)
    text = tumble("history", "trend", "--serial", "B000008", cwd=tmp_path).stdout
    assert "Alarms: 1 seat\n" in text and text.splitlines()[-1].split()[1:5] == ["B000008", "seat", "(jump)", "seat_x"]
    done = tumble("history", "trend", "--serial", "B000008", "--json", cwd=tmp_path)
    points = valid(done.stdout, "history")["points"]
    assert len(points) == 72 and points[0]["value"] == 0.0 and points[0]["z"] is None


def test_what_does_not_count_is_told(tumble, tmp_path):
    """A result without uncertainties, one that failed, and the first solution of a run that was solved twice."""
    joint = np.eye(12) * 1e-10
    failed = {"verification": {"pass": False, "max_abs_delta_g_g": 1e-2, "limit_g": 3e-4}, "pass_reason": "gravity"}
    more = [({"covariance": None}, "01"), ({"covariance": joint, **failed}, "02")]
    more += [({"covariance": joint, "run_sha256": "a" * 64}, day) for day in ("03", "04")]
    for keys, day in more:
        document = result(NOMINAL_K, U0, serial="A-1", created=f"2026-03-{day}T00:00:00Z", **keys)
        (tmp_path / f"{day}.json").write_text(json.dumps(document))
    assert tumble("history", "add", *(f"{day}.json" for _, day in more), cwd=tmp_path).stdout == "4 added\n"
    said = tumble("history", "trend", cwd=tmp_path).stdout.splitlines()
    assert said[0] == "1 block, 1 calibration; left out: 1 without uncertainties, 1 failed and 1 solved again"
    assert "Growth unknown: 0 intervals, 10 are needed" in said
    staircase = tumble("history", "due", "--limit", "1e-4", "--method", "staircase", cwd=tmp_path).stdout
    assert staircase.splitlines()[-1].split()[-2:] == ["one", "calibration"]


def test_a_stand_elsewhere_has_another_gravity(tmp_path):
    """K in V per local g: of one block at two places it is one block, where both tell their gravity."""
    rows = []
    for day, gravity in (("01", 9.78), ("02", 9.83)):
        ratio = gravity / 9.78
        document = result(NOMINAL_K * ratio, U0, np.eye(12) * 1e-10, serial="A-1", created=f"2026-03-{day}T00:00:00Z",
                          environment={"gravity_m_s2": gravity})  # fmt: skip
        rows.append(row_of(json.dumps(document).encode(), "r"))
    with History(tmp_path / "h.db") as history:
        history.add_rows(rows)
        fleet_, _ = trend.fleet_of(history.columns())
    values = fleet_[""][0].values[0]
    assert values[1] == pytest.approx(values[0], abs=1e-12)


def test_a_block_is_of_the_type_of_its_last_calibration(tumble, tmp_path):
    """With all its calibrations, whatever types they name: block B000000 was without one until its fifth."""
    rows = rows_of(fleet(3, 6, 61).series)
    for row in rows[:4]:
        row["type"] = ""
    with History(tmp_path / "history.db") as history:
        history.add_rows(rows)
        told = [history.trend(), history.trend("B000000"), history.trend(type="T")]
        assert [(one.blocks, one.calibrations) for one in told] == [(3, 18)] * 3
        assert len(history.trend("B000000").points) == 6 * 12
        assert [len(history.due(1e-4, **one).blocks) for one in ({}, {"serial": "B000000"}, {"type": "T"})] == [3, 1, 3]
        assert [len(history.show(type="T").calibrations), len(history.columns("B000000", type="T")["id"])] == [18, 6]
        with pytest.raises(BadInput, match="no calibration of type ''"):
            history.show(type="")
        with pytest.raises(BadInput, match="no calibration of block 'B000000' of type 'X'"):
            history.trend("B000000", type="X")
    told = valid(tumble("history", "trend", "--type", "T", "--json", cwd=tmp_path).stdout, "history")
    assert (told["blocks"], told["calibrations"]) == (3, 18)


def test_a_last_calibration_that_does_not_count_names_the_type_too(tmp_path):
    rows = rows_of(fleet(1, 3, 62).series)
    rows[2].update({f"u_{name}": None for name in PARAMETERS}, type="X")
    with History(tmp_path / "history.db") as history:
        history.add_rows(rows)
        told = [history.trend(), history.trend("B000000"), history.trend(type="X")]
    assert [[(one.type, one.calibrations) for one in of.types] for of in told] == [[("X", 2)]] * 3


def test_a_calibration_without_gravity_was_made_at_the_usual_one(tumble, tmp_path):
    """The growth of blocks whose first calibration states none, between two places: as if it stated it."""
    rows = rows_of(fleet(6, 4, 63).series)
    for place, row in enumerate(rows):
        row["gravity_m_s2"] = gravity = (9.7803, 9.7803, 9.8322, 9.7803)[place % 4]
        for axis in "xyz":
            row[f"scale_{axis}"] *= gravity / 9.80665
            row[f"bias_{axis}"] /= gravity / 9.80665
    told = []
    for name in ("stated", "history"):
        with History(tmp_path / f"{name}.db") as history:
            history.add_rows(rows)
            told.append(history.trend())
        for row in rows[::4]:
            row["gravity_m_s2"] = None
    assert told[0].types == told[1].types and told[0].types[0].growth[0].walk < 50.0
    assert [one.without_gravity for one in told] == [0, 6]
    assert tumble("history", "trend", cwd=tmp_path).stdout.splitlines()[1] == (
        "Without gravity_m_s2: 6, taken as measured at their blocks' usual one"
    )


@pytest.mark.parametrize(
    ("temperatures", "apart"), [((20.0, None, 21.0, 20.5), 1.0), ((20.0, 25.5, None, 20.0), 5.5), ((None,) * 4, 0.0)]
)
def test_temperatures_of_a_block_that_differ_are_told(temperatures, apart, tumble, tmp_path):
    """Not those of different blocks, which may be measured at different ones."""
    rows = rows_of(fleet(6, 4, 64).series)
    for place, row in enumerate(rows):
        row.update(temperature_c=temperatures[place % 4], gravity_m_s2=9.80665)
    if apart == 1.0:
        for row in rows[:4]:
            row["temperature_c"] = 60.0
    with History(tmp_path / "history.db") as history:
        history.add_rows(rows)
        assert history.trend().temperatures_apart_c == apart
    second = tumble("history", "trend", cwd=tmp_path).stdout.splitlines()[1]
    assert second == ("Temperatures of a block differ by up to 5.5 deg C: that counts as a change" if apart > 1 else "")


def test_the_usual_gravity_is_a_median():
    none = np.nan
    stated = np.array([[none, none, none], [none, 9.8, none], [9.9, none, 9.7], [9.7, 9.9, 9.8]])
    assert trend.relative_gravity(stated) * 9.80665 == pytest.approx(
        np.array([[9.80665] * 3, [9.8] * 3, [9.9, 9.7, 9.7], [9.7, 9.9, 9.8]]), rel=1e-15
    )


def test_the_error_of_the_last_calibration_is_as_uncertain_as_forecast():
    """Of a parameter, some days on: about the rate that the filter knows it scatters by v + (walk^2 + 2 c) tau + p
    tau^2, though the filter knows the value itself better than the last calibration does."""
    found, tau = fleet(3000, 6, 64), 200.0
    last = trend.filtered(found.series, TRUTH).last
    walk = TRUTH.walk * np.sqrt(tau) * np.random.default_rng(65).normal(size=found.rates.shape)
    error = found.truth[:, -1] + found.rates * tau + walk - found.series.values[:, -1]
    stated = found.series.variances[:, -1] + (TRUTH.walk**2 + 2.0 * last.p_xr) * tau + last.p_rr * tau**2
    z = ((error - last.rate * tau) / np.sqrt(stated))[:, :9]
    assert np.abs(z.mean(axis=0)).max() < 4.0 / np.sqrt(3000)
    assert np.abs((z**2).mean(axis=0) - 1.0).max() < 4.0 * np.sqrt(2.0 / 3000)


@pytest.mark.parametrize("days, interval", [
    ((0, 200, 200), 250.0), ((0, 200, 200.4), 250.5), ((0, 100, 100, 300), 250.0), ((0, 0), None), ((5,), None),
])  # fmt: skip
def test_the_staircase_passes_over_a_repeated_run(tmp_path, days, interval):
    """Of a block that does not change the interval grows by a quarter: that to the last calibration of another day."""
    found = fleet(1, len(days), 66)
    found.series.values[:] = 0.0
    found.series.days[:] = np.array(days) + 16000.0
    with History(tmp_path / "history.db") as history:
        history.add_rows(rows_of(found.series))
        (told,) = history.due(1e-4, method="staircase").blocks
    assert told.days == (interval and pytest.approx(interval, abs=1e-4))
    assert told.why == ("one calibration" if interval is None else "interval")
