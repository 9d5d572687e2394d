"""Calibration over temperature of a block that is bolted on once and inclined: nobody measured the inclinations of any
run, and the polynomials are found with the uncertainties that are stated."""

import numpy as np
import pytest
from conftest import EXAMPLES
from test_thermal import AT_C, T0, TRUE, true_at

import tumble as package
from tumble.api.thermal import solve_thermal
from tumble.files.stand_file import read_stand
from tumble.model import thermal
from tumble.model.coefficients import spread_attitudes
from tumble.model.errors import of_stand, sources
from tumble.model.geometry import Geometry, built_in
from tumble.model.inclined import as_seen, solve
from tumble.model.thermal import ThermalFit, ThermalRun, fit
from tumble.solving.thermal import BOLTING_KEPT, STAND_KEPT

pytestmark = pytest.mark.python
STAND = read_stand(str(EXAMPLES / "inclined_stand.toml"))
THREE_C = (-40.0, T0, 70.0)
SET_TO = 1e-2  # rad: how far an inclination, and the zero of the table angle with it, is off; undeclared


def runs_of(rng, name, at_c=AT_C, bolted_once=False):
    """Means of runs by the exact geometry. The axis is out of level alike in all; the bolting is another in each, or
    one."""
    schedule, stand, tables = built_in(name), STAND.stand, []
    geometry, count, positions = Geometry(schedule), len(schedule.mountings), len(schedule.positions)
    level = stand.axis_tilt * rng.standard_normal()
    bolting = None
    for t in at_c:
        if bolting is None or not bolted_once:
            bolting = stand.level * rng.standard_normal(), stand.remount * rng.standard_normal()
            bolting += tuple(stand.seat * rng.standard_normal(2))
        alpha2, yaw, lean, turn = bolting
        off, zero = SET_TO * rng.standard_normal((2, count))
        force = geometry.force(
            alpha1=level + off, alpha2=alpha2, alpha3=yaw, seat_h=lean, seat_n=turn + np.append(0.0, zero[1:]),
            delta=stand.angle * rng.standard_normal(positions))  # fmt: skip
        k, u0 = true_at(t)
        means = force @ k.T + u0 + stand.noise / stand.samples**0.5 * rng.standard_normal((positions, 3))
        table = {"mounting": [one.mounting for one in schedule.positions]}
        table |= {"position": [one.number for one in schedule.positions], "temperature": np.full(positions, t)}
        tables.append(table | {f"u{axis} [V]": means[:, i] for i, axis in enumerate("xyz")})
    return tables


def fit_of(tables, name, kept):
    """As the command fits them: on the schedule of each run as it shows it, without the rest of a solve."""
    planned, runs = built_in(name), []
    for table in tables:
        means = np.column_stack([table[f"u{axis} [V]"] for axis in "xyz"])
        k, _, seen = solve(planned, means)
        schedule, own = as_seen(planned, seen).fitted, planned.fit_indices
        lone = np.ones(len(own), dtype=int)
        found = sources(schedule, k, STAND.stand, lone) | of_stand(schedule, k, STAND.stand, ("inclination",))
        runs.append(ThermalRun(schedule, means[own], table["temperature"][own], found))
    return fit(runs, 2, T0, kept)


def outcome(found, chance):
    """Errors of coefficients and of |a| over attitudes at three temperatures, in their standard uncertainties."""
    n, norms = spread_attitudes(60), []
    for t in THREE_C:
        k, u0 = true_at(t)
        force = found.of(n @ k.T + u0, np.full(len(n), t))
        norms.append((np.linalg.norm(force, axis=1) - 1.0) / found.uncertainty(force, np.full(len(n), t))[:, 3])
    by_power = [np.append(k.ravel(), u0) for k, u0 in zip(found.polynomials.k, found.polynomials.u0)]
    return (np.concatenate(by_power) - TRUE) / np.sqrt(np.diag(found.covariance)), np.array(norms), chance


@pytest.mark.parametrize(("name", "bolted_once"), [("inclined", False), ("inclined_closed", True)])
def test_two_standard_uncertainties_cover_95_percent(name, bolted_once, request):
    """Chi-squared has its degrees of freedom, too."""
    rng, count = np.random.default_rng(21), 1000 if request.config.getoption("--full") else 200
    kept, found = (*STAND_KEPT, *(BOLTING_KEPT if bolted_once else ())), []
    for _ in range(count):
        one = fit_of(runs_of(rng, name, THREE_C, bolted_once), name, kept)
        found.append(outcome(one, one.p))
    in_u, norms, chances = (np.array(one) for one in zip(*found))
    covered, of_norm = (np.abs(in_u) < 1.96).mean(axis=0), (np.abs(norms) < 1.96).mean()
    print(f"{name}: coefficients {covered.min():.3f} to {covered.max():.3f}, |a| {of_norm:.3f}")
    assert abs(covered.mean() - 0.95) < 0.8 / count**0.5
    assert (np.abs(covered - 0.95) < 4.5 * (0.95 * 0.05 / count) ** 0.5).all()
    assert abs(of_norm - 0.95) < 0.6 / count**0.5
    assert abs(chances.mean() - 0.5) < 4 * (1 / 12 / count) ** 0.5


@pytest.mark.parametrize("bolted_once", [False, True])
@pytest.mark.parametrize("name", ["inclined", "inclined_closed"])
def test_the_command_finds_the_same_as_the_fit(name, bolted_once):
    """Inclinations off by 10 mrad, another in every run: the verdict is a PASS, and |a| is right within its u."""
    tables = runs_of(np.random.default_rng(5), name, bolted_once=bolted_once)
    given = {"temperature": "quadratic", "stand": STAND, "schedule": name, "bolted_once": bolted_once}
    found = solve_thermal(tables, **given)
    told = found.checked
    assert found.passed and {one.estimator for one in told.runs} == {"inclined"} and told.fit.p > 0.001
    expected = fit_of(tables, name, told.kept)
    assert told.fit.dof == expected.freedom and told.fit.chi2 == pytest.approx(expected.chi_squared, rel=1e-4)
    u = np.sqrt(np.diag(expected.covariance))
    by_power = [np.append(k.ravel(), u0) for k, u0 in zip(told.K, told.U0)]
    of_fit = [np.append(k.ravel(), u0) for k, u0 in zip(expected.polynomials.k, expected.polynomials.u0)]
    assert np.abs((np.concatenate(by_power) - np.concatenate(of_fit)) / u).max() < 1e-2
    assert np.sqrt(np.diag(told.covariance)) == pytest.approx(u, rel=1e-3)
    assert max(one.worst_g for one in told.u_norm_g) < 4e-5
    _, norms, _ = outcome(ThermalFit(expected.polynomials, told.covariance, 0.0, 0), None)
    assert np.abs(norms).max() < 4.0


def test_a_fit_that_does_not_settle_says_so(monkeypatch):
    monkeypatch.setattr(thermal, "_PASSES", 2)
    given = {"temperature": "linear", "stand": STAND, "schedule": "inclined"}
    with pytest.raises(package.UsageError, match=r"the runs and their stand have no common solution$"):
        solve_thermal(runs_of(np.random.default_rng(5), "inclined", THREE_C), **given)
