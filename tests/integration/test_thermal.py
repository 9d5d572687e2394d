"""Calibration over temperature: K(T) and U0(T) of runs at several temperatures."""

import json
from dataclasses import replace

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble as package
from tumble.api.thermal import load_thermal, solve_thermal
from tumble.files.stand_file import read_stand
from tumble.model.coefficients import Force, spread_attitudes
from tumble.model.errors import NOISE, exact_outputs, sources
from tumble.model.fit import WholeModel
from tumble.model.geometry import built_in, ideal_force
from tumble.model.thermal import NotShown, ThermalRun, fit
from tumble.solving.coefficients import covariance_in_si

pytestmark = pytest.mark.python

STAND = read_stand(str(EXAMPLES / "paper_stand.toml")).stand
SAMPLES = 50
AT_C = (-40.0, -10.0, 15.0, 45.0, 70.0)
T0 = 15.0
K0 = np.array([[2.0, 0.002, -0.003], [0.001, 2.01, 0.004], [-0.002, 0.001, 1.99]])
U0 = np.array([0.01, -0.02, 0.005])
SQUARES = np.array([[3.0, -0.4, 0.2], [0.1, -2.0, 0.3], [-0.5, 0.2, 1.0]]) * 1e-7
TRUE_K = np.array([K0, 1e-4 * K0 + 2e-6, SQUARES])  # 1e-4 per K of scale
TRUE_U0 = np.array([U0, [1e-4, -8e-5, 9e-5], [1e-6, 2e-6, -1e-6]])  # 50 ug per K


def true_at(temperature_c, degree=2):
    powers = (np.asarray(temperature_c)[..., None] - T0) ** np.arange(degree + 1)
    return np.tensordot(powers, TRUE_K[: degree + 1], axes=1), np.tensordot(powers, TRUE_U0[: degree + 1], axes=1)


def found_of(schedule, k, stand=STAND):
    return sources(schedule, k, stand, np.full(len(schedule.positions), SAMPLES))


def runs_of(rng, schedule, at_c=AT_C, degree=2, kept=(), stand=STAND):
    """Drawn from all that the stand declares; the sources in `kept` once."""
    runs, once = [], {}
    for t in at_c:
        k, u0 = true_at(t, degree)
        found = found_of(schedule, k, stand)
        draws = {name: rng.standard_normal(len(one.sigma)) for name, one in found.items()}
        once = once or {name: draws[name] for name in kept}
        drawn = np.concatenate(list((draws | once).values()))
        means = exact_outputs(schedule, k, u0, found, drawn[None])[0]
        runs.append(ThermalRun(schedule, means, np.full(len(means), t), found))
    return runs


def coefficients(fitted):
    return np.concatenate([np.append(k.ravel(), u0) for k, u0 in zip(fitted.polynomials.k, fitted.polynomials.u0)])


TRUE = np.concatenate([np.append(k.ravel(), u0) for k, u0 in zip(TRUE_K, TRUE_U0)])


def test_exact_runs_give_the_block_to_rounding():
    schedule = built_in("three_mountings")
    runs = [replace(one, means=ideal_force(schedule) @ true_at(t)[0].T + true_at(t)[1])
            for t, one in zip(AT_C, runs_of(np.random.default_rng(1), schedule))]  # fmt: skip
    found = fit(runs, 2, T0)
    scale = np.repeat(55.0 ** -np.arange(3.0), 12)  # what counts at the ends of the range
    assert (np.abs(coefficients(found) - TRUE) < 1e-13 * scale).all() and found.chi_squared < 1e-12


@pytest.mark.parametrize("degree", [1, 2])
def test_generalised_least_squares_by_dense_covariances_agree(degree):
    """Another way: C = J S J^T + N over all runs, its inverse, the normal equations; and chi-squared r^T C^-1 r. Errors
    so small that squares of them do not count."""
    schedule, stand = built_in("diagonal"), tiny(STAND)
    runs = runs_of(np.random.default_rng(5), schedule, degree=degree, kept=("alpha1",), stand=stand)
    found, force, count = fit(runs, degree, T0, ("alpha1",)), ideal_force(schedule), 3 * len(schedule.positions)
    covariance, design = np.zeros((count * len(runs), count * len(runs))), []
    for row, one in enumerate(runs):
        own = slice(count * row, count * (row + 1))
        for name, source in one.found.items():
            by = source.derivative.reshape(len(source.sigma), -1) * source.sigma[:, None]
            covariance[own, own] += by.T @ by
            for other_row, other in enumerate(runs):
                if name == "alpha1" and other is not one:
                    its = other.found[name].derivative.reshape(1, -1) * other.found[name].sigma[:, None]
                    covariance[own, count * other_row : count * (other_row + 1)] += by.T @ its
        by_row = [np.kron(force, np.eye(3)[i][:, None]) for i in range(3)]
        felt = np.hstack([*by_row, np.tile(np.eye(3), (len(force), 1))])
        design.append(np.hstack([(AT_C[row] - T0) ** power * felt for power in range(degree + 1)]))
    inverse, d = np.linalg.inv(covariance), np.concatenate(design)
    length = np.linalg.norm(d, axis=0)
    normal = np.linalg.inv((d / length).T @ inverse @ (d / length)) / np.outer(length, length)
    outputs = np.concatenate([one.means.ravel() for one in runs])
    beta = normal @ d.T @ inverse @ outputs
    u = np.sqrt(np.diag(normal))
    assert (np.abs(coefficients(found) - beta) < 1e-3 * u).all()
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx(u, rel=1e-4)
    left = outputs - d @ beta
    assert found.chi_squared == pytest.approx(left @ inverse @ left, rel=1e-4)
    assert found.freedom == len(outputs) - 12 * (degree + 1)


def tiny(stand):
    return replace(stand, **{name: 1e-3 * getattr(stand, name) for name in ("axis_tilt", "level", "remount", "angle")},
                   noise=1e-3 * stand.noise)  # fmt: skip


def test_without_a_slope_it_is_the_whole_model_of_a_run():
    schedule = built_in("paper")
    [run] = runs_of(np.random.default_rng(2), schedule, (T0,), degree=0)
    model = WholeModel(schedule, run.means, (run.found[NOISE].sigma**2).reshape(-1, 3), STAND)
    found = fit([run], 0, T0)
    assert (found.chi_squared, found.freedom) == (pytest.approx(model.chi_squared, rel=1e-9), model.freedom)
    assert np.abs(found.polynomials.k[0] - model.k).max() < 1e-3


@pytest.mark.parametrize("name", ["diagonal", "paper"])
def test_two_standard_uncertainties_cover_95_percent(name, request):
    """Of every coefficient, of K in the middle and at an end; chi-squared has its degrees of freedom."""
    rng, schedule, kept = np.random.default_rng(11), built_in(name), ("alpha1",)
    covered, chances, count = [], [], 1000 if request.config.getoption("--full") else 50
    for _ in range(count):
        found = fit(runs_of(rng, schedule, kept=kept), 2, T0, kept)
        errors = np.concatenate([(coefficients(found) - TRUE) / np.sqrt(np.diag(found.covariance))] + [
            np.append(found.polynomials.at(t)[0] - true_at(t)[0], found.polynomials.at(t)[1] - true_at(t)[1])
            / np.sqrt(np.diag(found.covariance_at(t))) for t in (20.0, 70.0)])  # fmt: skip
        covered.append(np.abs(errors) < 1.96)
        chances.append(found.p)
    print(f"{name}: {np.mean(covered, axis=0).min():.3f} to {np.mean(covered, axis=0).max():.3f}")
    assert abs(np.mean(covered) - 0.95) < 0.55 / count**0.5
    assert (np.abs(np.mean(covered, axis=0) - 0.95) < 4.5 * (0.95 * 0.05 / count) ** 0.5).all()
    assert abs(np.mean(chances) - 0.5) < 4 * (1 / 12 / count) ** 0.5


def test_errors_that_stay_are_one_unknown():
    """The stand is level alike in all runs: that cannot hide in slopes, and averages less."""
    runs = runs_of(np.random.default_rng(3), built_in("paper"))
    together, apart = fit(runs, 2, T0, ("alpha2",)), fit(runs, 2, T0)
    ratio = np.sqrt(np.diag(together.covariance) / np.diag(apart.covariance)).reshape(3, 12)
    assert ratio[0].max() > 1.2 and ratio[1:].max() < 1.0 + 1e-6 and ratio[1:].min() < 0.7
    with pytest.raises(NotShown, match="have no alpha3 in common"):
        fit([runs[0], *runs_of(np.random.default_rng(3), built_in("diagonal"), (0.0, 30.0))], 1, T0, ("alpha3",))


def written(folder, runs_c, noise_v=STAND.noise, seed=4, header="ux [V],uy [V],uz [V],temperature"):
    """Run files of the paper's schedule: `runs_c` of each run the temperature of every position."""
    rng, schedule, files = np.random.default_rng(seed), built_in("paper"), []
    for number, felt in enumerate(runs_c):
        felt = np.broadcast_to(felt, len(schedule.positions))
        k, u0 = true_at(felt)
        found = {name: one for name, one in found_of(schedule, K0).items() if name != NOISE}
        drawn = rng.standard_normal((1, sum(len(one.sigma) for one in found.values())))
        force = exact_outputs(schedule, np.eye(3), np.zeros(3), found, drawn)[0]
        means = np.einsum("pij,pj->pi", k, force) + u0
        rows = []
        for p, mean, t in zip(schedule.positions, means, felt):
            for x, y, z in mean + noise_v * rng.standard_normal((SAMPLES, 3)):
                rows.append(f"{p.mounting},{p.number},{x:.9f},{y:.9f},{z:.9f},{t:.2f}")
        files.append(folder / f"run{number}.csv")
        files[-1].write_text("\n".join([f"mounting,position,{header}", *rows]) + "\n")
    return files


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    return written(tmp_path_factory.mktemp("warm"), AT_C)


def worst_norm_error(result, true_of, at_c):
    """Of |a| of a block calibrated by `result`, over attitudes and temperatures, g."""
    n, found = spread_attitudes(500), []
    for t in at_c:
        (k, u0), (true_k, true_u0) = result(t), true_of(t)
        force = np.linalg.solve(k, (n @ true_k.T + true_u0 - u0).T)
        found.append(np.abs(np.linalg.norm(force, axis=0) - 1.0).max())
    return max(found)


def test_from_runs_to_a_verdict_and_calibrated_data(tumble, runs, tmp_path):
    out = tmp_path / "warm.json"
    command = ["solve", *runs, "--temperature", "quadratic", "--stand", EXAMPLES / "paper_stand.toml"]
    done = tumble(*command, "--out", out)
    assert done.returncode == 0 and done.stdout.startswith("PASS from -40 to 70 deg C, assuming a square seat\n")
    assert max(map(len, done.stdout.splitlines())) <= 80
    found = load_thermal(out)
    assert found.passed and found.checked.fit.fits and found.range_c == (-40.0, 70.0)
    u = np.sqrt(np.diag(found.covariance_at(30.0)))
    assert (np.abs(np.append(found.at(30.0)[0] - true_at(30.0)[0], found.at(30.0)[1] - true_at(30.0)[1])) < 4 * u).all()
    grid = np.linspace(-40, 70, 12)
    alone = package.solve(runs[2], stand=EXAMPLES / "paper_stand.toml")
    own, other = (worst_norm_error(one, true_at, grid) for one in (found.at, lambda t: (alone.K, alone.U0)))
    assert own < 6e-5 and other > 5e-3
    assert found.checked.at_one_temperature_g == pytest.approx(other, rel=0.02)
    assert done.stdout.count(" alone, at ") == 5

    n = np.array([0.6, 0.0, 0.8])
    rows = [",".join(f"{one:.9f}" for one in (*(true_at(t)[0] @ n + true_at(t)[1]), t)) for t in (-30.0, 60.0)]
    (tmp_path / "data.csv").write_text("\n".join(["ux,uy,uz,temperature", *rows]) + "\n")
    applied = tumble("apply", out, tmp_path / "data.csv")
    assert applied.returncode == 0
    force = np.array([line.split(",")[-3:] for line in applied.stdout.splitlines()[1:]], dtype=float)
    assert np.abs(force - n).max() < 1e-4
    outputs = np.array([line.split(",")[:3] for line in rows], dtype=float)
    assert np.abs(found.apply(outputs, [-30.0, 60.0]) - force).max() < 1e-8
    table = found.apply({"ux": outputs[:, 0], "uy": outputs[:, 1], "uz": outputs[:, 2], "temperature": [-30.0, 60.0]})
    assert np.abs(np.column_stack([table[one] for one in "xyz"]) - force).max() < 1e-8


def test_json_is_of_its_schema(tumble, runs, tmp_path):
    done = tumble("solve", *runs, "--temperature", "linear", "--json", "--stand", EXAMPLES / "paper_stand.toml")
    told = json.loads(done.stdout)
    assert done.returncode == 1 and (told["schema"], told["pass_reason"]) == ("tumble.thermal/1", "gravity and fit")
    assert [len(told[name]) for name in ("K", "U0", "u_K", "covariance")] == [2, 2, 2, 24]


def test_a_block_that_warms_up_within_its_runs(tmp_path):
    """A ramp of 20 K in every run: positions are at temperatures of their own, as the column has them."""
    ramp = np.linspace(-10.0, 10.0, 18)
    files = written(tmp_path, [ramp - 20.0, ramp + 15.0, ramp + 50.0])
    found = solve_thermal(files, temperature="quadratic", stand=EXAMPLES / "paper_stand.toml")
    assert found.passed and found.range_c == (-30.0, 60.0)
    for t in (-25.0, 15.0, 55.0):
        u = np.sqrt(np.diag(found.covariance_at(t)))
        apart = np.append(found.at(t)[0] - true_at(t)[0], found.at(t)[1] - true_at(t)[1])
        assert (np.abs(apart) < 4 * u).all()


def test_temperatures_by_option_and_without_a_stand(tumble, tmp_path):
    files = written(tmp_path, AT_C, header="ux [V],uy [V],uz [V],t")
    at = ",".join(f"{one:g}" for one in AT_C)
    done = tumble("solve", *files, "--temperature", "quadratic", f"--at={at}")
    assert done.returncode == 0 and "PASS from -40 to 70 deg C" in done.stdout and "unknown" in done.stdout


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ([], "5 runs: solve takes one, or several at their temperatures (--temperature)"),
        (["--temperature", "linear", "--at", "20"], "--at: 1 temperatures for 5 runs"),
        (["--temperature", "linear", "--at", "20,20,20,20,20"], "--temperature: all at 20 to 20 deg C: runs 1 K apart"),
        (["--temperature", "quadratic", "--at", "20,20,20,40,40"], "3 distinct temperatures or more are needed"),
        (["--temperature", "quadratic", "--at", "20,20.2,40,40.1,40.2"], "3 distinct temperatures or more are needed"),
        (["--temperature", "linear", "--at", "20,30,40,50,warm"], "--at: 'warm' is no temperature"),
        (["--temperature", "linear", "--at", "20,30,40,50,500"], "--at: 500 is no temperature from -100 to 230 deg C"),
        (["--temperature", "linear", "--model", "k2"], "--model is for one run, not for --temperature"),
        (["--at", "20"], "--at is for --temperature"),
    ],
)
def test_what_is_refused(refused, runs, options, said):
    assert said in refused("solve", *runs, *options)


def test_runs_of_samples_and_runs_of_means_count_alike(tmp_path):
    """Without a stand a run of means has no noise: it is not left out for that."""
    files = written(tmp_path, (0.0, 20.0, 40.0))
    read = [np.genfromtxt(one, delimiter=",", skip_header=1) for one in files]
    tables = [{"mounting": rows[:, 0], "position": rows[:, 1], "temperature": rows[:, 5]} for rows in read]
    for table, rows in zip(tables, read):
        table |= {f"u{axis} [V]": rows[:, 2 + i] for i, axis in enumerate("xyz")}
    means = {name: values.reshape(-1, SAMPLES).mean(axis=1) for name, values in tables[2].items()}
    given, mixed = solve_thermal(tables), solve_thermal([*tables[:2], means])
    assert np.abs(given.at(40.0)[0] - mixed.at(40.0)[0]).max() < 3e-5
    assert mixed.checked.runs[2].max_abs_delta_g_g == pytest.approx(given.checked.runs[2].max_abs_delta_g_g, rel=0.2)


def test_what_python_refuses_and_warns_of(runs):
    for given, said in (([], "runs of several"), ([runs[0], runs[0]], "none of them twice")):
        with pytest.raises(package.UsageError, match=said):
            solve_thermal(given)
    found = solve_thermal(runs[:2])
    with pytest.raises(package.UsageError, match="as many temperatures as outputs"):
        found.apply(np.zeros((5, 3)), [20.0, 21.0])
    with pytest.warns(UserWarning, match="applied at 5e\\+03 deg C, calibrated at -40 to -10 deg C"):
        found.apply([[0.0, 0.0, 2.0]], 5000.0)


def test_runs_that_tell_no_temperature(refused, tmp_path):
    files = written(tmp_path, (0.0, 30.0), header="ux [V],uy [V],uz [V],t")
    assert "run0.csv: has no temperature" in refused("solve", *files, "--temperature", "linear")
    out = tmp_path / "t.json"
    out.write_text(solve_thermal(files, at=(0.0, 30.0)).to_json())
    assert "row 2: tells no temperature" in refused("apply", out, files[0])
    pyarrow = pytest.importorskip("pyarrow")
    table = pyarrow.table({"ux": [0.1, 0.1], "uy": [0.1, 0.1], "uz": [2.0, 2.0], "temperature": [20.0, None]})
    pytest.importorskip("pyarrow.parquet").write_table(table, tmp_path / "warm.parquet")
    said = refused("apply", out, tmp_path / "warm.parquet", "--out", tmp_path / "new.parquet")
    why = f"{tmp_path / 'warm.parquet'}: row 2: tells no temperature, which this result needs\n"
    assert said.endswith(why) and not (tmp_path / "new.parquet").exists()


@pytest.fixture(scope="module")
def solved(runs):
    stand = read_stand(str(EXAMPLES / "paper_stand.toml"))
    labels = {**(stand.environment or {}), "gravity_m_s2": 9.8106, "u_gravity_m_s2": 2e-5}
    return solve_thermal(runs, temperature="quadratic", stand=replace(stand, environment=labels))


def test_uncertainties_of_data_are_those_of_its_temperature(tumble, solved, tmp_path):
    """Row by row, those of a result with the coefficients and the covariance of that temperature, in either unit."""
    rng = np.random.default_rng(8)
    force, felt = 1.3 * rng.standard_normal((40, 3)), rng.uniform(-40.0, 70.0, 40)
    k, u0 = true_at(felt)
    outputs = np.einsum("pij,pj->pi", k, force) + u0
    outputs[7] = np.nan
    for unit, gravity, u_gravity in (("g", 1.0, 0.0), ("m/s2", 9.8106, 2e-5)):
        found = solved.apply(outputs, felt, unit=unit, uncertainty=True)
        assert found.shape == (40, 7) and np.isnan(found[7]).all()
        for row in (0, 13, 39):
            values = np.append(*(one.ravel() for one in solved.at(felt[row])))
            covariance, powers = solved.covariance_at(felt[row]), np.repeat([1.0, 0.0], (9, 3))
            covariance = covariance_in_si(values, powers, covariance, gravity, u_gravity)
            alone = Force(values / gravity**powers, (), covariance)
            expected = alone.of(outputs[row][None])
            assert found[row] == pytest.approx(np.append(expected, alone.uncertainty(expected)), rel=1e-9)
    (tmp_path / "warm.json").write_text(solved.to_json())
    rows = [",".join(map(repr, one)) for one in np.column_stack([outputs, felt])[:5].tolist()]
    (tmp_path / "data.csv").write_text("\n".join(["ux,uy,uz,temperature", *rows]) + "\n")
    done = tumble("apply", tmp_path / "warm.json", tmp_path / "data.csv", "--uncertainty", "--unit", "m/s2")
    lines = [line.split(",") for line in done.stdout.splitlines()]
    assert lines[0][4:] == ["u_x", "u_y", "u_z", "u_norm", "x", "y", "z"]
    told = np.array([line[4:] for line in lines[1:]], dtype=float)
    assert told == pytest.approx(np.roll(found[:5], -3, axis=1), rel=1e-4)


def test_coefficients_at_a_temperature_and_beyond_the_range(solved, runs):
    u_k, u_u0 = solved.uncertainty_at(70.5)
    assert np.append(u_k, u_u0) == pytest.approx(np.sqrt(np.diag(solved.covariance_at(70.5))), rel=1e-12)
    for ask in (solved.at, solved.uncertainty_at, solved.covariance_at):
        with pytest.warns(UserWarning, match="extrapolated: the runs were at -40 to 70 deg C"):
            ask(90.0)
    with pytest.warns(UserWarning, match="extrapolated"):
        assert (solved.uncertainty_at(120.0)[0] > 3.0 * u_k).all()
    bare = solve_thermal(runs[:2])
    for ask in (bare.uncertainty_at, bare.covariance_at, lambda t: bare.apply(np.eye(3), t, uncertainty=True)):
        with pytest.raises(package.BadInput, match="no uncertainties: no stand was declared"):
            ask(-20.0)
