"""`tumble fixture learn`, and `tumble solve` on a stand whose set angles are known."""

import dataclasses
import json
import re

import numpy as np
import pytest
from blocks import NOMINAL_K, write_run
from conftest import EXAMPLES
from documents import schema
from jsonschema import validate

import tumble
from tumble import core, pictures
from tumble.cli.main import main
from tumble.distributions import chi_squared_above
from tumble.files.stand_file import read_stand, with_set_angles
from tumble.model import Geometry, Propagation, WholeModel
from tumble.model.coefficients import norm_gradient, spread_attitudes, worst_norm
from tumble.model.set_angles import LearningRun, learn, turned_back
from tumble.schedule import mark_of
from tumble.solving import uncertainty
from tumble.solving.computation import estimator_for
from tumble.stand import SetAngles

pytestmark = pytest.mark.python
PAPER = core.built_in("paper")
STAND = EXAMPLES / "angle_stand.toml"
ANGLE = 2e-4
U0 = np.array([0.02, -0.01, 0.03])
PLACE = [int(position.mark / 45.0) for position in PAPER.positions]
DAY = {"SOURCE_DATE_EPOCH": "1796000000"}  # 2026-11-30
TODAY = "2026-11-30"
ESTIMATORS = ("refined", "optimal")


def declared():
    return read_stand(str(STAND)).stand


def table_of(rng, marks=8):
    return rng.normal(size=marks) * ANGLE


def drawn(rng, table, anew=1e-5, k=NOMINAL_K, place=PLACE, schedule=PAPER):
    """Means of a run on the angle-dominated stand, on the exact geometry."""
    stand, positions = declared(), len(schedule.positions)
    errors = {
        "alpha1": rng.normal() * stand.axis_tilt,
        "alpha2": rng.normal() * stand.level,
        "alpha3": rng.normal(size=len(schedule.mountings)) * stand.remount,
        "delta": table[place] + rng.normal(size=positions) * anew,
    }
    noise = rng.normal(size=(positions, 3)) * stand.noise / np.sqrt(stand.samples)
    return Geometry(schedule).force(**errors) @ k.T + U0 + noise


def as_learnt(means):
    variance = declared().mean_variance(np.full(len(means), 25))
    return LearningRun(PAPER, means, variance, declared())


def by_brute_force(runs, anew):
    """The table and its covariance by one dense problem of all unknowns, its derivatives by differences: of every run
    the twelve, its tilt, level, yaws, and the error of each position beside its mark's."""
    stand, count, own = declared(), len(runs), 12 + 4 + 18
    sigma = np.concatenate([[stand.axis_tilt, stand.level], np.full(2, stand.remount), np.full(18, anew)])
    noise = stand.noise / np.sqrt(stand.samples)

    def rows(x):
        table, left = x[:8], []
        for index, means in enumerate(runs):
            part = x[8 + own * index : 8 + own * (index + 1)]
            errors = part[12:] * sigma
            force = Geometry(PAPER).force(
                alpha1=errors[0], alpha2=errors[1], alpha3=errors[2:4], delta=ANGLE * table[PLACE] + errors[4:]
            )
            left += [((means - force @ part[:9].reshape(3, 3).T - part[9:12]) / noise).ravel(), -part[12:]]
        return np.concatenate([*left, -table])

    x = np.concatenate([np.zeros(8), np.tile(np.concatenate([NOMINAL_K.ravel(), U0, np.zeros(22)]), count)])
    for _ in range(3):
        steps = np.where(np.arange(len(x)) < 8, 1e-3, 1e-6)
        slope = np.array([(rows(x + h * one) - rows(x - h * one)) / (2 * h) for h, one in zip(steps, np.eye(len(x)))]).T
        x = x - np.linalg.lstsq(slope, rows(x), rcond=None)[0]
    covariance = np.linalg.inv(slope.T @ slope)[:8, :8] * ANGLE**2
    centred = np.eye(8) - 1 / 8
    return centred @ x[:8] * ANGLE, np.sqrt(np.diag(centred @ covariance @ centred))


def test_the_table_is_that_of_one_dense_problem():
    rng = np.random.default_rng(3)
    table = table_of(rng)
    runs = [drawn(rng, table, 2e-5) for _ in range(3)]
    found = learn([as_learnt(means) for means in runs], ANGLE)
    errors, u = by_brute_force(runs, found.repeatability)
    assert found.marks == tuple(45.0 * np.arange(8))
    assert found.u == pytest.approx(u, rel=2e-3)
    assert np.abs(found.errors - errors).max() < 0.02 * u.min()
    assert found.errors.sum() == pytest.approx(0.0, abs=1e-18)


def test_its_uncertainties_are_true():
    """Blocks differ from run to run; tables, yaws and levels too."""
    rng, ratios, anew = np.random.default_rng(4), [], []
    for _ in range(25):
        table = table_of(rng)
        runs = [drawn(rng, table, 2e-5, NOMINAL_K + rng.normal(size=(3, 3)) * 0.02) for _ in range(3)]
        found = learn([as_learnt(means) for means in runs], ANGLE)
        ratios.append((found.errors - table + table.mean()) / found.u)
        anew.append((found.repeatability - 2e-5) / found.u_repeatability)
        assert min(found.p) > 1e-4
    assert np.std(ratios) == pytest.approx(1.0, abs=4.0 / np.sqrt(2 * 7 * 25))
    assert abs(np.mean(anew)) < 4.0 / np.sqrt(25) and np.std(anew) < 1.6


def test_the_errors_of_an_encoder_are_in_the_table():
    """As large as declared, they are not drawn to 0 by a small `angle_rad`."""
    rng, angle = np.random.default_rng(13), 2.0 * np.pi / 8.0 * np.arange(8)
    table = 3e-4 * (np.sin(angle) + np.cos(2.0 * angle))
    stand = dataclasses.replace(declared(), angle=1e-5, encoder=3e-4)
    assert stand.set_angle == pytest.approx(np.sqrt(1e-5**2 + 2 * 3e-4**2))
    runs = [dataclasses.replace(as_learnt(drawn(rng, table)), stand=stand) for _ in range(3)]
    found = learn(runs, stand.set_angle)
    assert np.abs((found.errors - table) / found.u).max() < 4.0
    assert TABLE.left_on(stand, 2).encoder == 0.0


def test_angles_are_turned_back_exactly():
    rng = np.random.default_rng(5)
    errors = rng.normal(size=18) * 1e-3
    means = Geometry(PAPER).force(delta=errors) @ NOMINAL_K.T + U0
    ideal = Geometry(PAPER).force() @ NOMINAL_K.T + U0
    assert np.abs(turned_back(PAPER, means, errors) - ideal).max() < 1e-11


def test_a_known_k_turns_back_what_the_positions_do_not_identify():
    part = PAPER.part(np.arange(18) < 9)
    errors = np.random.default_rng(6).normal(size=9) * 1e-3
    means, ideal = (Geometry(part).force(delta=delta) @ NOMINAL_K.T + U0 for delta in (errors, 0.0 * errors))
    assert np.abs(turned_back(part, means, errors, NOMINAL_K) - ideal).max() < 1e-15
    assert turned_back(part, means, errors) is means


def run_files(tmp_path, rng, table, count, first=0, **how):
    return [write_run(tmp_path / f"run{first + i}.csv", PAPER, drawn(rng, table, **how)) for i in range(count)]


def learnt(tmp_path, runs, stand=STAND, name="learnt.toml"):
    """Exit code, and the new file."""
    out = tmp_path / name
    return main(["fixture", "learn", "--stand", str(stand), *map(str, runs), "--out", str(out)]), out


def solved(capsys, run, *options):
    capsys.readouterr()
    code = main(["solve", str(run), "--json", *map(str, options)])
    captured = capsys.readouterr()
    return code, json.loads(captured.out) if captured.out else None, captured.err


@pytest.fixture
def today(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", DAY["SOURCE_DATE_EPOCH"])


def test_a_run_on_a_learnt_stand(tmp_path, capsys, today):
    rng = np.random.default_rng(6)
    table = table_of(rng)
    code, out = learnt(tmp_path, run_files(tmp_path, rng, table, 5))
    shown = capsys.readouterr().out
    assert code == 0 and f"Set angles, learnt from 5 runs, {TODAY} to 2027-11-30" in shown
    found = read_stand(str(out)).set_angles
    assert (found.learned, found.expires, found.runs, len(found.u)) == (TODAY, "2027-11-30", 5, 8)
    assert np.abs((np.array(found.errors) - table + table.mean()) / found.u).max() < 4.0
    assert read_stand(str(out)).stand == declared()
    (run,) = run_files(tmp_path, rng, table, 1, first=9)
    for estimator in ("refined", "least_squares", "optimal", "averaged"):
        _, before, _ = solved(capsys, run, "--stand", STAND, "--estimator", estimator)
        code, result, err = solved(capsys, run, "--stand", out, "--estimator", estimator)
        validate(result, schema("result"))
        assert (code, err, result["fit"]["fits"]) == (before["pass"] is False, "", True)
        assert "set_angles" not in before and result["set_angles"]["runs"] == 5
        assert result["set_angles"]["expires"] == "2027-11-30" and result["stand"]["angle_rad"] < 2e-5
        error = np.concatenate([np.array(result["K"]) - NOMINAL_K, [np.array(result["U0"]) - U0]])
        assert (np.abs(error) < 4.5 * np.concatenate([result["u_K"], [result["u_U0"]]])).all()
        if estimator == "refined":
            assert before["u_norm_g"]["worst_g"] == pytest.approx(61.3e-6, rel=0.01)
            assert result["u_norm_g"]["worst_g"] == pytest.approx(16.5e-6, rel=0.03)
    assert main(["solve", str(run), "--stand", str(out)]) == 0
    assert f"Set angles: corrected by the table of {TODAY} (5 runs), to " in capsys.readouterr().out
    with_python = tumble.solve(run, stand=out, estimator="optimal")
    assert with_python["K_xx"] == result_of(capsys, run, out)["K"][0][0]


def result_of(capsys, run, stand):
    return solved(capsys, run, "--stand", stand, "--estimator", "optimal")[1]


def test_a_table_expires(tmp_path, capsys, today, monkeypatch):
    rng = np.random.default_rng(7)
    table = table_of(rng)
    _, out = learnt(tmp_path, run_files(tmp_path, rng, table, 3))
    (run,) = run_files(tmp_path, rng, table, 1, first=9)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", str(1796000000 + 366 * 86400))
    _, result, err = solved(capsys, run, "--stand", out)
    told = f"learnt on {TODAY}, has expired on 2027-11-30, so that angle_rad counts as declared: learn it anew"
    assert err == f"tumble: warning: the table of set angles, {told}\n"
    assert "set_angles" not in result and result["stand"]["angle_rad"] == ANGLE
    assert result["warnings"] == [err.removeprefix("tumble: warning: ").strip()]
    _, plain, _ = solved(capsys, run, "--stand", STAND)
    assert {**result, "warnings": None} == {**plain, "warnings": None}


def test_an_encoder_that_was_mounted_anew_is_told(tmp_path, capsys, today):
    """Its errors come at other marks: of six such runs all are told, of six on the stand as it was none."""
    rng = np.random.default_rng(8)
    table = table_of(rng)
    _, out = learnt(tmp_path, run_files(tmp_path, rng, table, 5))
    (changed,) = run_files(tmp_path, rng, np.roll(table, 1), 1, first=9)
    code, result, err = solved(capsys, changed, "--stand", out)
    assert (code, result["fit"]["fits"]) == (1, False)
    said = f"the run fits the stand, but not with its table of set angles: they have changed since {TODAY}; learn it"
    assert f"tumble: warning: {said} anew\n" in err
    fits = []
    for i in range(6):
        for now in (np.roll(table, 1 + i), table):
            (run,) = run_files(tmp_path, rng, now, 1, first=9)
            fits.append(tumble.solve(run, stand=out, estimator="refined").document["fit"]["fits"])
    assert fits == [False, True] * 6


def test_a_stand_that_changes_between_runs_teaches_nothing(tmp_path, capsys, today):
    rng = np.random.default_rng(9)
    runs = [run_files(tmp_path, rng, table_of(rng), 1, first=i)[0] for i in range(4)]
    code, out = learnt(tmp_path, runs)
    said = "not written: the set angles do not stay from run to run, less than half of their error would go"
    assert (code, out.exists()) == (1, False) and said in capsys.readouterr().err
    drifting = write_run(
        tmp_path / "drift.csv", PAPER, drawn(rng, table := table_of(rng)) + np.linspace(0, 3e-3, 18)[:, None]
    )
    code, out = learnt(tmp_path, [*run_files(tmp_path, rng, table, 4), drifting])
    said = "drift.csv does not fit the stand; tumble solve says what it shows\n"
    assert (code, out.exists()) == (1, False) and said in capsys.readouterr().err


def test_learning_anew_replaces_the_table(tmp_path, today):
    rng = np.random.default_rng(10)
    runs = run_files(tmp_path, rng, table_of(rng), 3)
    _, first = learnt(tmp_path, runs)
    code, second = learnt(tmp_path, runs, first, "again.toml")
    assert code == 0 and first.read_text() == second.read_text()
    assert first.read_text().startswith(STAND.read_text().rstrip())
    moved = first.read_text().replace("[accept]", '[item]\nlabel = "x"\n\n[accept]')
    again = with_set_angles("[set_angles]\nruns = 1\n" + moved, read_stand(str(first)).set_angles)
    assert again.count("[set_angles]") == 1 and "[item]" in again and "[stand]" in again


def test_a_run_of_one_mounting_is_corrected_by_the_k_of_its_prior(tmp_path, capsys, today, monkeypatch):
    """Its result is that of the same run on a table without errors, and the report names the table."""
    rng = np.random.default_rng(15)
    table = table_of(rng)
    _, stand = learnt(tmp_path, run_files(tmp_path, rng, table, 5))
    known = read_stand(str(stand)).set_angles
    stand.write_text(stand.read_text().replace("[block]\n", '[block]\nserial = "A-1"\n'))
    then = stand.with_name("then.toml")
    then.write_text(stand.read_text() + '\n[environment]\ndate = "2026-03-01"\n')
    (last,) = run_files(tmp_path, rng, table, 1, first=8)
    tumble.solve(last, stand=then, estimator="optimal").save(tmp_path / "last.json")
    part = PAPER.part(np.arange(18) < 9)
    noise = rng.normal(size=(9, 3)) * 3e-5
    off = np.array(known.errors)[PLACE[:9]]
    found = []
    zeros = dataclasses.replace(known, errors=(0.0,) * 8)
    (tmp_path / "none.toml").write_text(with_set_angles(stand.read_text(), zeros))
    for name, delta, of in (("off.csv", off, stand), ("exact.csv", 0.0 * off, tmp_path / "none.toml")):
        run = write_run(tmp_path / name, part, Geometry(part).force(delta=delta) @ NOMINAL_K.T + U0 + noise)
        options = ["--prior", tmp_path / "last.json", "--growth", "50,20,50", "--out", tmp_path / "r.json"]
        code, result, err = solved(capsys, run, "--stand", of, *options)
        assert (code, err, result["prior"]["used"], result["fit"]["fits"]) == (0, "", True, True)
        found.append(result)
    for key in ("K", "U0"):
        off, exact = (np.array(result[key]) for result in found)
        assert np.abs(off - exact).max() < 1e-3 * np.min(found[0][f"u_{key}"])
    monkeypatch.setattr(pictures, "figures", lambda told, run=None: {})
    said = plain_report(tumble.load(tmp_path / "r.json"))
    assert f"corrected by the table of {TODAY}, learnt from 5 runs, which expires on 2027-11-30" in said


def plain_report(found):
    text = re.sub(r"(?s)<(style|svg|script).*?</\1>|<[^>]+>", "", found.reported("html").decode("utf-8"))
    return " ".join(text.split())


def test_runs_at_several_temperatures_are_corrected_all_or_none(tmp_path, capsys, today):
    stand = tmp_path / "stand.toml"
    eight = dataclasses.replace(
        TABLE, angles_deg=tuple(45.0 * i for i in range(8)), errors=(1e-5, -1e-5) * 4, u=(1e-6,) * 8
    )
    stand.write_text(with_set_angles(STAND.read_text(), eight))
    runs = run_files(tmp_path, np.random.default_rng(2), np.array(eight.errors), 3, anew=1e-6)
    warm = ["solve", *map(str, runs), "--temperature", "linear", "--at", "0,20,40", "--estimator", "least_squares"]
    assert main([*warm, "--stand", str(stand), "--out", str(tmp_path / "warm.json")]) == 0
    assert f"\nSet angles: corrected by the table of {TODAY} (3 runs)\n" in capsys.readouterr().out
    told = json.loads((tmp_path / "warm.json").read_text())
    validate(told, schema("thermal"))
    assert (told["set_angles"]["runs"], told["set_angles"]["u_rad"]) == (3, 1e-6)
    odd = dataclasses.replace(eight, angles_deg=eight.angles_deg[1::2], errors=(1e-5,) * 4, u=(1e-6,) * 4)
    stand.write_text(with_set_angles(STAND.read_text(), odd))
    few = PAPER.part([position.mark in odd.angles_deg for position in PAPER.positions])
    write_run(runs[1], few, drawn(np.random.default_rng(3), np.zeros(8), schedule=few, place=[0] * 8))
    assert main([*warm, "--stand", str(stand)]) == 2
    why = "cannot be corrected by the table of set angles, as other runs are: leave out this run, or the table"
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", f"tumble: {runs[0]}: {why}\n")


REFUSED = {
    "two runs": (["run0.csv", "run1.csv"], [], "set angles that stay show in 3 runs or more, not in 2"),
    "one twice": (["run0.csv", "run1.csv", "run0.csv"], [], "the run 'run0.csv' is given twice"),
    "one copied": (["run0.csv", "run1.csv", "copy.csv"], [], "two of the runs are the same, to the byte"),
    "days": (["run0.csv", "run1.csv", "run2.csv"], ["--valid-days", "0"], "--valid-days: '0' is not a whole number"),
    "inclined": (
        ["run0.csv", "run1.csv", "run2.csv"],
        ["--schedule", "inclined"],
        "--schedule: set angles are learnt on a level table that turns to them",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused(case, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run_files(tmp_path, np.random.default_rng(1), np.zeros(8), 3)
    (tmp_path / "copy.csv").write_bytes((tmp_path / "run0.csv").read_bytes())
    runs, options, said = REFUSED[case]
    code = main(["fixture", "learn", "--stand", str(STAND), *runs, *options, "--out", "new.toml"])
    captured = capsys.readouterr()
    assert (code, captured.out, (tmp_path / "new.toml").exists()) == (2, "", False)
    assert captured.err.startswith("tumble: ") and captured.err.count("\n") == 1 and said in captured.err


def test_what_cannot_be_written_is_not_printed_either(tmp_path, capsys, today):
    rng = np.random.default_rng(6)
    code, out = learnt(tmp_path, run_files(tmp_path, rng, table_of(rng), 3), name="none/learnt.toml")
    captured = capsys.readouterr()
    assert (code, captured.out) == (2, "")
    assert captured.err == f"tumble: {out}: cannot be written: no such file or folder\n"


def test_several_runs_that_do_not_fit_are_named(tmp_path, capsys, today):
    rng = np.random.default_rng(17)
    table = table_of(rng)
    drift = np.linspace(0, 3e-3, 18)[:, None]
    runs = [write_run(tmp_path / f"bad{i}.csv", PAPER, drawn(rng, table) + drift) for i in range(2)]
    code, out = learnt(tmp_path, [*run_files(tmp_path, rng, table, 5), *runs])
    said = r"bad0\.csv and \S*bad1\.csv do not fit the stand; tumble solve says what they show\n"
    assert (code, out.exists()) == (1, False) and re.search(said, capsys.readouterr().err)


def test_the_stand_file_is_not_replaced(tmp_path, capsys):
    stand = tmp_path / "stand.toml"
    stand.write_text(STAND.read_text())
    runs = run_files(tmp_path, np.random.default_rng(1), np.zeros(8), 3)
    code = main(["fixture", "learn", "--stand", str(stand), *map(str, runs), "--out", str(stand)])
    assert code == 2 and "is an input of this command" in capsys.readouterr().err
    assert stand.read_text() == STAND.read_text()


TABLE = SetAngles(TODAY, "2027-11-30", 3, (0.0, 45.0), (1e-5, -1e-5), (1e-6, 2e-6), 1e-6, 1e-6)
BAD = {
    "no day": (
        'learned = "2026-11-30"',
        'learned = "30.11.2026"',
        "must be a day such as 2026-11-30, not '30.11.2026'",
    ),
    "twice": ("0.0, 45.0", "45.0, 405.0", "angles_deg has an angle twice"),
    "too few": ("1e-05, -1e-05", "1e-05", "errors_rad must be 2 numbers"),
    "too large": ("1e-05, -1e-05", "1e-05, -1.0", "errors_rad must be -0.1 to 0.1"),
    "below 0": ("1e-06, 2e-06", "-1e-06, 2e-06", "u_rad must be 0 to 0.5"),
    "unknown": ("runs = 3", "runs = 3\nrun = 4", "unknown key 'run' in"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_table_is_refused(case, tmp_path):
    old, new, said = BAD[case]
    text = with_set_angles(STAND.read_text(), TABLE)
    assert text.count(old) == 1
    (tmp_path / "stand.toml").write_text(text.replace(old, new))
    with pytest.raises(tumble.BadInput) as refused:
        read_stand(str(tmp_path / "stand.toml"))
    assert said in str(refused.value).replace("[set_angles] ", "")


def test_angles_that_the_table_does_not_have(tmp_path, capsys, today):
    stand = tmp_path / "stand.toml"
    stand.write_text(with_set_angles(STAND.read_text(), TABLE))
    (run,) = run_files(tmp_path, np.random.default_rng(1), np.zeros(8), 1)
    _, result, err = solved(capsys, run, "--stand", stand)
    assert err == (
        f"tumble: warning: the table of set angles, learnt on {TODAY}, has no 90 deg, so that angle_rad counts as"
        " declared\n"
    )
    assert "set_angles" not in result and result["stand"]["angle_rad"] == ANGLE


def test_what_is_left_of_a_stand():
    stand = dataclasses.replace(declared(), limits="sigma3")  # declared limits are three standard deviations
    left = TABLE.left_on(stand, 2)
    assert left.sigma("angle") == pytest.approx(np.sqrt(2 * 2e-6**2 + 2 * 1e-6**2))
    assert left.sigma("level") == pytest.approx(np.sqrt((2e-5 / 3) ** 2 + (2e-4 / 3) ** 2 / 2))
    assert [mark_of(angle) for angle in (360.0, -45.0, 405.0, 1e-9, 22.5)] == [0.0, 315.0, 45.0, 0.0, 22.5]


@pytest.mark.full
@pytest.mark.parametrize("count", [3, 5, 10])
def test_what_a_table_gains(count):
    """200 campaigns of so many runs, and four further runs that are solved with the table: pytest -s prints the figures
    of docs/method.md."""
    rng, schedule = np.random.default_rng(count), core.CoreSchedule(PAPER)
    truth, samples = np.concatenate([NOMINAL_K.ravel(), U0]), np.full(18, 25)
    gradient = norm_gradient(NOMINAL_K, spread_attitudes(2000))
    before, after = {name: [] for name in ESTIMATORS}, {name: [] for name in ESTIMATORS}
    stated, held, off = {name: [] for name in ESTIMATORS}, {name: [] for name in ESTIMATORS}, []
    for _ in range(200):
        table = table_of(rng)
        runs = [drawn(rng, table) for _ in range(count + 4)]
        found = learn([as_learnt(means) for means in runs[:count]], ANGLE)
        off.append(found.u.max())
        numbers = tuple(found.errors), tuple(found.u), found.repeatability, found.u_repeatability
        left = SetAngles(TODAY, TODAY, count, found.marks, *numbers).left_on(declared(), 2)
        later = np.array(runs[count:])
        back = np.array([turned_back(PAPER, means, found.errors[PLACE]) for means in later])
        for name in ESTIMATORS:
            plain, known = (Propagation(PAPER, NOMINAL_K, stand, samples, name) for stand in (declared(), left))
            before[name].append(estimator_for(plain)(later) - truth)
            after[name].append(estimator_for(known)(back) - truth)
            u = uncertainty.standard_uncertainties(known, schedule, np.ones(18, dtype=bool))
            held[name].append(np.abs(after[name][-1]) < 2.0 * u)
            stated[name].append(worst_norm(NOMINAL_K, known.covariance()).worst_g)
    for name in ESTIMATORS:
        rms = [np.sqrt(((np.concatenate(one[name]) @ gradient.T) ** 2).mean(axis=0)).max() for one in (before, after)]
        coverage, claimed = np.concatenate(held[name]).mean(axis=0), np.mean(stated[name])
        gained = f"{1e6 * rms[0]:.1f} -> {1e6 * rms[1]:.1f} ug, stated {1e6 * claimed:.1f}"
        share = f"{100 * coverage.min():.1f} to {100 * coverage.max():.1f} %"
        print(f"{count} runs, u {1e6 * np.mean(off):.1f} urad, {name}: {gained}, coverage {share}")
        assert rms[1] == pytest.approx(claimed, rel=0.1) and coverage.min() > 0.93
        assert name == "optimal" or rms[1] < rms[0] / 3.5


@pytest.mark.full
@pytest.mark.parametrize(
    ("change", "least", "most"), [(0.0, 0.0, 0.02), (2e-5, 0.01, 0.3), (5e-5, 0.7, 0.95), (2e-4, 1.0, 1.0)]
)
def test_how_large_a_change_is_noticed(change, least, most):
    """The share of 300 runs that do not fit, of five runs' tables whose marks have moved by so much since."""
    rng, refused = np.random.default_rng(14), 0
    for _ in range(30):
        table = table_of(rng)
        found = learn([as_learnt(drawn(rng, table)) for _ in range(5)], ANGLE)
        numbers = tuple(found.errors), tuple(found.u), found.repeatability, found.u_repeatability
        left = SetAngles(TODAY, TODAY, 5, found.marks, *numbers).left_on(declared(), 2)
        for _ in range(10):
            means = drawn(rng, table + rng.normal(size=8) * change)
            back = turned_back(PAPER, means, found.errors[PLACE])
            model = WholeModel(PAPER, back, left.mean_variance(np.full(18, 25)), left)
            refused += chi_squared_above(model.chi_squared, model.freedom) < 0.001
    print(f"marks moved by {1e6 * change:.0f} urad: {100 * refused / 300:.0f} % of runs do not fit")
    assert least <= refused / 300 <= most
