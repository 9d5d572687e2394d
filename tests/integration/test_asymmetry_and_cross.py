"""`tumble solve --model asymmetry,cross`: a scale that differs by sign, and products of two axes."""

import json
import shutil
import subprocess
from fractions import Fraction

import numpy as np
import pytest
from blocks import NOMINAL_K, random_block, random_errors, write_run
from conftest import EXAMPLES
from documents import schema
from jsonschema import validate
from test_foreign_exports import Matlab
from test_further_terms import STAND, U0, solved, stand_named

import tumble
from tumble import core
from tumble.cli.main import main
from tumble.model import Geometry, Propagation
from tumble.model.coefficients import Force, norm_uncertainty
from tumble.model.estimators import confused, unknowns
from tumble.solving import computation, uncertainty
from tumble.solving.computation import estimator_for
from tumble.terms import KEYS, expanded, names, parse

pytestmark = pytest.mark.python
THREE = core.built_in("three_mountings")
ASYMMETRY = np.array([2.0, -1.0, 1.5]) * 1e-4
CROSS = {"xy": 1e-4, "yz": -2e-4, "zx": 5e-5, "xz": -1e-4, "yx": 1.5e-4, "zy": 3e-5}  # of the channel, the other axis
VALUES = np.array([ASYMMETRY, [CROSS["xy"], CROSS["yz"], CROSS["zx"]], [CROSS["xz"], CROSS["yx"], CROSS["zy"]]])
TERMS = parse("asymmetry,cross", None)


def outputs_of(force, k, u0, asymmetry=ASYMMETRY, cross=CROSS):
    """Of one force, channel by channel, in whatever numbers they are given as."""
    shown = []
    for i, axis in enumerate("xyz"):
        products = sum(cross[axis + other] * force[i] * force["xyz".index(other)] for other in "xyz" if other != axis)
        linear = sum(k[i][j] * force[j] for j in range(3))
        shown.append(u0[i] + linear + k[i][i] * (asymmetry[i] * abs(force[i]) + products))
    return shown


def run_of(schedule, k=NOMINAL_K, u0=U0, **errors):
    return np.array([outputs_of(force, k, u0) for force in Geometry(schedule).force(**errors)])


def given(schedule, estimator, terms=TERMS):
    samples = np.full(len(schedule.positions), 50)
    return Propagation(schedule, NOMINAL_K, stand_named("paper"), samples, estimator, terms=terms)


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
@pytest.mark.parametrize("model", ["asymmetry,cross", "k2,k3,asymmetry,cross,drift"])
def test_a_run_without_errors_gives_them_exactly(estimator, model):
    terms = parse(model, estimator)
    found = estimator_for(given(THREE, estimator, terms))(run_of(THREE)[None])[0]
    sizes = dict(zip(TERMS, VALUES * np.diag(NOMINAL_K)))
    expected = [NOMINAL_K.ravel(), U0, *(sizes.get(term, np.zeros(3)) for term in terms)]
    assert np.abs(found - np.concatenate(expected)).max() < 1e-12


@pytest.mark.parametrize("seed", range(6))
def test_elimination_agrees_with_the_dense_problem(seed):
    rng = np.random.default_rng(seed)
    name, model = [("three_mountings", "k2,asymmetry,cross"), ("diagonal", "cross,drift"), ("paper", "asymmetry")][
        seed % 3
    ]
    schedule, terms = core.CoreSchedule.built_in(name), parse(model, None)
    k, u0 = random_block(rng)
    means = run_of(schedule.data, k, u0, **random_errors(rng, schedule.data, 1e-3))
    by_core = computation.least_squares(schedule, means[None], terms)[0]
    assert np.abs(by_core - unknowns(schedule.data, means, "least_squares", terms)).max() < 1e-11 * np.abs(k).max()


def test_the_force_is_the_one_whose_outputs_they_are():
    """By exact fractions: the outputs of the force that is found are those that were given."""
    rng, values = np.random.default_rng(4), 30.0 * VALUES
    asymmetry, cross = 30.0 * ASYMMETRY, {pair: 30.0 * size for pair, size in CROSS.items()}
    truth = np.concatenate([rng.uniform(-2.0, 2.0, (50, 3)), np.eye(3), -np.eye(3)])
    outputs = np.array([outputs_of(force, NOMINAL_K, U0, asymmetry, cross) for force in truth])
    found = Force(np.concatenate([NOMINAL_K.ravel(), U0, values.ravel()]), TERMS).of(outputs)
    assert np.abs(found - truth).max() < 1e-14
    exact = [[Fraction(one) for one in row] for row in NOMINAL_K.tolist()]
    bias, sizes = [Fraction(one) for one in U0.tolist()], [Fraction(one) for one in asymmetry.tolist()]
    products = {pair: Fraction(size) for pair, size in cross.items()}
    for force, shown in zip(found.tolist(), outputs.tolist()):
        again = outputs_of([Fraction(one) for one in force], exact, bias, sizes, products)
        assert max(abs(one - Fraction(other)) for one, other in zip(again, shown)) < Fraction(1, 10**14)


def test_the_uncertainty_of_the_force_is_that_of_disturbed_coefficients():
    """Against differences: each coefficient moved by its share of the root of a covariance."""
    rng, values = np.random.default_rng(8), np.concatenate([NOMINAL_K.ravel(), U0, 30.0 * VALUES.ravel()])
    root = rng.normal(size=(21, 21)) * 1e-6
    force = rng.normal(size=(5, 3))
    force /= np.linalg.norm(force, axis=1)[:, None]
    known = Force(values, TERMS, root @ root.T)
    outputs = np.array(
        [outputs_of(one, NOMINAL_K, U0, 30.0 * ASYMMETRY, {p: 30.0 * s for p, s in CROSS.items()}) for one in force]
    )
    moved = np.array([Force(values + column, TERMS).of(outputs) - force for column in root.T])
    length = np.array([np.linalg.norm(force + one, axis=1) - 1.0 for one in moved])
    expected = np.column_stack([np.sqrt((moved**2).sum(axis=0)), np.sqrt((length**2).sum(axis=0))])
    assert known.uncertainty(force) == pytest.approx(expected, rel=1e-4)
    by_k = np.diag(np.concatenate([np.ones(12), np.tile(np.diag(NOMINAL_K), 3)]))  # sizes, in the unit of outputs
    plain = Force(np.concatenate([values[:12], np.zeros(9)]), TERMS, root @ root.T).uncertainty(force)[:, 3]
    assert norm_uncertainty(NOMINAL_K, by_k @ root @ root.T @ by_k.T, force, TERMS) == pytest.approx(plain, rel=1e-12)


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
@pytest.mark.parametrize(
    ("name", "model"), [("paper", "asymmetry"), ("three_mountings", "asymmetry,cross"), ("diagonal", "cross")]
)
def test_two_standard_uncertainties_hold_the_truth_in_95_percent(name, model, estimator):
    """2,000 runs on the exact geometry, of one block."""
    rng, runs, terms = np.random.default_rng(12), 2000, parse(model, None)
    schedule, stand = core.built_in(name), stand_named("paper")
    positions, mountings = len(schedule.positions), len(schedule.mountings)
    errors = {
        "alpha1": rng.normal(size=(runs, 1)) * stand.sigma("axis_tilt"),
        "alpha2": rng.normal(size=(runs, 1)) * stand.sigma("level"),
        "alpha3": rng.normal(size=(runs, mountings)) * stand.sigma("remount"),
        "delta": rng.normal(size=(runs, positions)) * stand.sigma("angle"),
    }
    asymmetry = ASYMMETRY if "asymmetry" in terms else 0.0 * ASYMMETRY
    cross = {pair: size * ("cross_next" in terms) for pair, size in CROSS.items()}
    force = np.moveaxis(Geometry(schedule).force(**errors), -1, 0)
    means = np.stack(outputs_of(force, NOMINAL_K, U0, asymmetry, cross), axis=-1)
    means += rng.normal(size=means.shape) * stand.sigma("noise") / np.sqrt(50)
    run = given(schedule, estimator, terms)
    found = estimator_for(run)(means)
    sizes = dict(zip(TERMS, VALUES * np.diag(NOMINAL_K)))
    truth = np.concatenate([NOMINAL_K.ravel(), U0, *(sizes[term] for term in terms)])
    u = uncertainty.standard_uncertainties(run, core.CoreSchedule(schedule), np.ones(positions, dtype=bool))
    coverage = (np.abs(found - truth) < 2.0 * u).mean(axis=0)
    print(f"{name} {model} {estimator}: {coverage.min():.4f} to {coverage.max():.4f}, mean {coverage.mean():.4f}")
    assert np.abs(coverage - 0.9545).max() < 4.0 * np.sqrt(0.9545 * 0.0455 / runs)


def noisy(tmp_path, schedule=THREE, seed=6):
    rng, stand = np.random.default_rng(seed), stand_named("paper")
    yaws, angles = (rng.normal(size=n) * s for n, s in ((3, 4e-4), (len(schedule.positions), 4e-5)))
    means = run_of(schedule, alpha3=yaws[: len(schedule.mountings)], delta=angles)
    means += rng.normal(size=means.shape) * stand.sigma("noise") / np.sqrt(50)
    return write_run(tmp_path / "run.csv", schedule, means)


@pytest.mark.parametrize("estimator", ["least_squares", "optimal"])
def test_a_run_that_did_not_fit_does(estimator, tmp_path, capsys):
    run = noisy(tmp_path)
    options = (*STAND, "--schedule", "three_mountings", "--estimator", estimator, "--limit", "1e-3")
    _, plain, _ = solved(capsys, run, *options)
    assert not plain["fit"]["fits"] and plain["extended"] is None
    code, result, err = solved(capsys, run, *options, "--model", "cross,asymmetry")
    validate(result, schema("result"))
    assert (code, err) == (0, "") and (result["fit"]["fits"], result["fit"]["dof"]) == (True, 69 - 9)
    found = result["extended"]
    assert found["terms"] == ["asymmetry", "cross"] and found["k2_per_g"] is None
    expected = ["asymmetry_x", "asymmetry_y", "asymmetry_z", *(f"cross_{pair}" for pair in CROSS)]
    assert found["names"] == expected == list(names(TERMS))
    for key, truth in (("asymmetry", ASYMMETRY), ("cross_per_g", list(CROSS.values()))):
        assert (np.abs(np.array(found[key]) - truth) < 4.0 * np.array(found[f"u_{key}"])).all()
    u = np.sqrt(np.diag(found["covariance"]))
    assert u[12:].tolist() == pytest.approx([*found["u_asymmetry"], *found["u_cross_per_g"]])
    assert result["fit"]["explanations"] == []


def test_terminal_and_python_show_them(tmp_path, capsys):
    run = noisy(tmp_path)
    options = ["--schedule", "three_mountings", "--estimator", "optimal", "--model", "asymmetry,cross"]
    assert main(["solve", str(run), *map(str, STAND), *options, "--limit", "1e-3"]) == 0
    shown = capsys.readouterr().out
    assert "Because of asymmetry and cross: " in shown and " with asymmetry, cross" in shown
    rows = {line.split()[0]: line.split()[2] for line in shown.splitlines() if line[:5] in ("asymm", "cross")}
    assert rows == {**{f"asymmetry_{axis}": "1" for axis in "xyz"}, **{f"cross_{pair}": "1/g" for pair in CROSS}}
    stand = EXAMPLES / "paper_stand.toml"
    result = tumble.solve(
        run, stand=stand, schedule="three_mountings", estimator="optimal", model=["cross", "asymmetry"]
    )
    assert result.document["extended"]["terms"] == ["asymmetry", "cross"]
    force = Geometry(THREE).force()[:5]
    outputs = np.array([outputs_of(one, NOMINAL_K, U0) for one in force])
    assert np.abs(result.apply(outputs) - force).max() < 2e-3  # a yaw of its mounting turns it
    assert np.abs(np.linalg.norm(result.apply(outputs), axis=1) - 1.0).max() < 6e-5


def test_a_comparison_and_a_report_have_them(tmp_path, capsys):
    options = ["--schedule", "three_mountings", "--estimator", "optimal", "--model", "asymmetry,cross"]
    files = []
    for seed in (6, 7):
        files.append(tmp_path / f"{seed}.json")
        solved(capsys, noisy(tmp_path, seed=seed), *STAND, *options, "--out", files[-1])
    capsys.readouterr()
    assert main(["compare", *map(str, files), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    validate(found, schema("comparison"))
    units = {row["name"]: row["unit"] for row in found["parameters"][9:]}
    pairs = [f"cross_{pair}" for pair in CROSS]
    assert units == {**{f"asymmetry_{axis}": "ug/g" for axis in "xyz"}, **dict.fromkeys(pairs, "ug/g^2")}
    assert {row["name"]: row["unit"] for row in found["coefficients"]}["cross_zy"] == "1/g"
    assert main(["report", str(files[0]), "--out", str(tmp_path / "report.html")]) == 0
    text = (tmp_path / "report.html").read_text()
    assert all(name in text for name in ("asymmetry_x", *pairs)) and "g\u207b\u00b9" in text


@pytest.mark.parametrize(
    ("schedule", "model", "told"),
    [
        ("paper", "cross", "do not show cross_yz or cross_zy; the schedule three_mountings or diagonal or"),
        ("diagonal", "k2,asymmetry", "cannot tell apart K2_x and asymmetry_x, nor K2_y and asymmetry_y, nor K2_z and"),
    ],
)
def test_what_positions_do_not_show_is_refused_by_name(schedule, model, told, tmp_path, capsys):
    run = noisy(tmp_path, core.built_in(schedule))
    options = (*STAND, "--schedule", schedule, "--estimator", "optimal", "--model", model)
    code, result, err = solved(capsys, run, *options)
    told = told.replace(" or diagonal or", ", diagonal or diagonal_closed does")
    assert (code, result) == (2, None) and err.startswith("tumble: ") and err.count("\n") == 1
    assert f"run.csv: --model {model}: these positions {told}" in err


def test_what_shows_nothing_is_named_alone():
    assert confused(core.built_in("six_faces"), TERMS[1:]) == [
        [f"cross_{pair}"] for pair in ("xy", "xz", "yz", "yx", "zx", "zy")
    ]


PROGRAM = """
#include "coefficients.h"
#include <stdio.h>
int main(void)
{
    static const double outputs[2][3] = {OUTPUTS};
    for (int n = 0; n < 2; n++) {
        const REAL shown[3] = {(REAL)outputs[n][0], (REAL)outputs[n][1], (REAL)outputs[n][2]};
        REAL force[3];
        tumble_exported_force(shown, force);
        for (int i = 0; i < 3; i++) printf("%.17g\\n", (double)force[i]);
    }
    return 0;
}
"""


def changed(out):
    """The result in a file, with terms that matter."""
    document = json.loads(out.read_text())
    cross = [0.01, 0.02, -0.03, 0.02, -0.01, 0.03]
    document["extended"] |= {"asymmetry": [0.02, -0.01, 0.03], "cross_per_g": cross, "k2_per_g": [0.0] * 3}
    out.write_text(json.dumps(document))
    force = [[0.6, -0.7, 0.9], [-1.0, 0.2, -0.4]]
    of_force = (document["K"], document["U0"], document["extended"]["asymmetry"], dict(zip(CROSS, cross)))
    return force, [outputs_of(one, *of_force) for one in force]


def test_the_script_applies_them(tmp_path, capsys):
    out = tmp_path / "result.json"
    options = ["--schedule", "three_mountings", "--estimator", "least_squares", "--model", "k2,asymmetry,cross"]
    solved(capsys, noisy(tmp_path), *STAND, *options, "--out", out)
    force, outputs = changed(out)
    assert main(["export", str(out), "--format", "matlab"]) == 0
    script = Matlab(capsys.readouterr().out)
    assert np.abs(script.called("tumble.apply", outputs) - force).max() < 1e-13
    assert main(["export", str(out), "--format", "ros", "--unit", "g"]) == 2
    assert "imu_calib holds twelve coefficients, no K2, asymmetry and cross" in capsys.readouterr().err


@pytest.mark.parametrize("number", ["double", "float"])
@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_header_applies_them(number, tmp_path, capsys):
    out = tmp_path / "result.json"
    options = ["--schedule", "three_mountings", "--estimator", "least_squares", "--model", "k2,asymmetry,cross"]
    solved(capsys, noisy(tmp_path), *STAND, *options, "--out", out)
    force, outputs = changed(out)
    assert main(["export", str(out), "--format", "c", "--number", number]) == 0
    (tmp_path / "coefficients.h").write_text(capsys.readouterr().out)
    listed = ", ".join(f"{{{', '.join(map(repr, map(float, row)))}}}" for row in outputs)
    (tmp_path / "main.c").write_text(PROGRAM.replace("OUTPUTS", listed).replace("REAL", number))
    flags = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
    subprocess.run(["cc", *flags, "main.c", "-o", "main"], cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True).stdout.split()
    assert np.array(printed, dtype=float) == pytest.approx(np.ravel(force), abs=1e-13 if number == "double" else 1e-6)


def test_every_term_has_a_key_and_names():
    assert set(KEYS) == {"k2", "k3", "asymmetry", "cross", "drift"} and expanded(["cross"]) == TERMS[1:]
