"""Coefficients in units of the SI, with the uncertainty of the local gravity; covariances in exports."""

import csv
import io
import json
import shutil
import subprocess

import numpy as np
import pytest
from blocks import random_block
from conftest import EXAMPLES
from documents import NO_GRAVITY, paper_stand, valid
from hypothesis import given, settings, strategies as st

from tumble.estimators import COEFFICIENTS
from tumble.solving.coefficients import POWERS_OF_TWELVE, covariance_in_si, si_of

pytestmark = pytest.mark.python
G, U_G = 9.8106, 2e-3
HERE = f"[environment]\ngravity_m_s2 = {G}\n"


def solve(tumble, folder, environment=HERE + f"u_gravity_m_s2 = {U_G}\n", *options):
    """Result file and document of the paper's example, solved where the environment is so."""
    file = folder / "result.json"
    stand = paper_stand(folder, environment)
    done = tumble("solve", EXAMPLES / "paper_stand.csv", "--unit", "V", "--stand", stand, "--out", file, *options)
    assert (done.returncode, done.stderr) == (0, "")
    return file, valid(file.read_text())


def test_a_result_has_them_where_gravity_is_told(tumble, tmp_path):
    _, result = solve(tumble, tmp_path)
    k, u_k, in_si = np.array(result["K"]), np.array(result["u_K"]), result["si"]
    assert (in_si["gravity_m_s2"], in_si["u_gravity_m_s2"]) == (G, U_G)
    assert in_si["units"] == {"K": "V/(m/s^2)", "bias": "m/s^2"}
    assert np.array(in_si["K"]) == pytest.approx(k / G, rel=1e-14)
    assert np.array(in_si["u_K"]) == pytest.approx(np.hypot(u_k / G, k / G * U_G / G), rel=1e-8)
    bias, u_bias = np.array(result["intrinsic"]["bias_g"]), np.array(result["u_intrinsic"]["bias_g"])
    assert in_si["bias"] == pytest.approx(bias * G, rel=1e-14)
    assert in_si["u_bias"] == pytest.approx(np.hypot(u_bias * G, bias * U_G), rel=1e-8)


def test_an_uncertainty_that_is_not_told_leaves_theirs_unknown(tumble, tmp_path):
    _, result = solve(tumble, tmp_path, HERE)
    assert result["si"]["u_gravity_m_s2"] is result["si"]["u_K"] is result["si"]["u_bias"] is None
    assert np.array(result["si"]["K"]) == pytest.approx(np.array(result["K"]) / G, rel=1e-14)
    assert solve(tumble, tmp_path, "")[1]["si"] is None


@pytest.mark.parametrize(
    ("lines", "complaint"),
    [
        ("u_gravity_m_s2 = 1e-3\n", "u_gravity_m_s2 needs gravity_m_s2"),
        ("gravity_m_s2 = 9.81\nu_gravity_m_s2 = 1\n", "u_gravity_m_s2 must be 0 to 0.2"),
        ("gravity_m_s2 = 9.81\nu_gravity_m_s2 = -1e-3\n", "u_gravity_m_s2 must be 0 to 0.2"),
    ],
)
def test_what_cannot_be_is_refused(lines, complaint, refused, tmp_path):
    stand = paper_stand(tmp_path, f"[environment]\n{lines}")
    assert complaint in refused("solve", EXAMPLES / "paper_stand.csv", "--stand", stand)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=50)
def test_they_follow_by_differences(seed):
    """All twelve in SI as functions of the twelve in g and of gravity, and the biases; by differences."""
    rng = np.random.default_rng(seed)
    k, u0 = random_block(rng)
    size = np.abs(k).max()
    draws = rng.normal(size=(12, 12)) * size * 1e-4
    covariance, u_gravity = draws.T @ draws, 10.0 ** rng.uniform(-6, -1)

    def in_si(x):
        k_g, u0_v, gravity = x[:9].reshape(3, 3), x[9:12], x[12]
        return np.concatenate([x[:9] / gravity, u0_v, u0_v / np.linalg.norm(k_g, axis=1) * gravity])

    at, steps = np.concatenate([k.ravel(), u0, [G]]), 1e-6 * np.repeat([size, 1.0], [12, 1])
    jacobian = np.array([(in_si(at + h) - in_si(at - h)) / (2 * h.sum()) for h in np.diag(steps)]).T
    whole = np.zeros((13, 13))
    whole[:12, :12], whole[12, 12] = covariance, u_gravity**2
    expected = jacobian @ whole @ jacobian.T
    environment = {"gravity_m_s2": G, "u_gravity_m_s2": u_gravity}
    found = si_of(k, u0, covariance, environment, "V")
    joint = covariance_in_si(at[:12], POWERS_OF_TWELVE, covariance, G, u_gravity)
    scale = np.sqrt(np.diag(expected))
    assert joint / np.outer(scale, scale)[:12, :12] == pytest.approx(
        expected[:12, :12] / np.outer(scale, scale)[:12, :12], abs=1e-6
    )
    assert found.u_K.ravel() == pytest.approx(scale[:9], rel=1e-6)
    assert found.u_bias == pytest.approx(scale[12:], rel=1e-6)


def test_csv_has_the_covariance(tumble, tmp_path):
    file, result = solve(tumble, tmp_path)
    for unit, covariance in (("g", result["covariance"]), ("m/s2", None)):
        rows = list(csv.DictReader(io.StringIO(tumble("export", file, "--format", "csv", "--unit", unit).stdout)))
        exported = np.array([[float(row[f"covariance_{name}"]) for name in COEFFICIENTS] for row in rows])
        stated = np.array([float(row["standard_uncertainty"]) for row in rows])
        assert np.sqrt(np.diag(exported)) == pytest.approx(stated, rel=1e-9)
        if covariance is not None:
            assert exported.tolist() == covariance
            continue
        assert [row["unit"] for row in rows] == ["V/(m/s^2)"] * 9 + ["V"] * 3
        assert [float(row["value"]) for row in rows[:9]] == np.ravel(result["si"]["K"]).tolist()
        assert stated[:9].tolist() == np.ravel(result["si"]["u_K"]).tolist()
        assert stated[9:] == pytest.approx(result["u_U0"], rel=1e-9)
        # gravity is common to all: what is large and certain is correlated by it, here nearly wholly
        assert exported[0, 4] / stated[0] / stated[4] > 0.99


PROGRAM = """\
#include "coefficients.h"
#include <stdio.h>
static const double covariance[12][12] = TUMBLE_COVARIANCE_INITIALIZER;
int main(void)
{
    for (int i = 0; i < 144; i++) printf("%.17g\\n", covariance[i / 12][i % 12]);
    return 0;
}
"""


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_c_header_has_the_covariance(tumble, tmp_path):
    file, result = solve(tumble, tmp_path)
    header = tumble("export", file, "--format", "c").stdout
    (tmp_path / "coefficients.h").write_text(header)
    (tmp_path / "main.c").write_text(PROGRAM)
    flags = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    subprocess.run(["cc", *flags, "main.c", "-o", "main"], cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True).stdout
    assert [float(line) for line in printed.splitlines()] == np.ravel(result["covariance"]).tolist()
    assert '#define TUMBLE_FORCE_UNIT "g"' in header and "in units of local gravity" in header
    in_si = tumble("export", file, "--format", "c", "--unit", "m/s2").stdout
    assert '#define TUMBLE_FORCE_UNIT "m/s2"' in in_si and "specific force in m/s^2" in in_si
    assert f"#define TUMBLE_K_XX ({result['si']['K'][0][0]:.17g}) /* V/(m/s^2), " in in_si


def test_what_is_unknown_is_left_out(tumble, tmp_path):
    file, _ = solve(tumble, tmp_path, HERE)
    header = tumble("export", file, "--format", "c", "--unit", "m/s2").stdout
    assert "TUMBLE_U_K" not in header and "TUMBLE_COVARIANCE" not in header
    assert "unknown, that of gravity is unknown" in header
    rows = list(csv.DictReader(io.StringIO(tumble("export", file, "--format", "csv", "--unit", "m/s2").stdout)))
    assert {row["standard_uncertainty"] for row in rows} == {row["covariance_K_xx"] for row in rows} == {""}


def test_without_gravity_there_are_none(tumble, refused, tmp_path):
    file, result = solve(tumble, tmp_path, "")
    error = refused("export", file, "--format", "c", "--unit", "m/s2")
    assert error == f"tumble: {file}: {NO_GRAVITY}\n"
    older = {key: value for key, value in result.items() if key not in ("covariance", "si", "environment")}
    file.write_text(json.dumps(older))
    assert "TUMBLE_COVARIANCE" not in tumble("export", file, "--format", "c").stdout


@pytest.mark.parametrize("covariance", [[], [[1.0] * 12] * 11, [["1"] * 12] * 12, "none"])
def test_a_covariance_that_is_none_is_refused(covariance, tumble, refused, tmp_path):
    file, result = solve(tumble, tmp_path)
    file.write_text(json.dumps({**result, "covariance": covariance}))
    assert "covariance is" in refused("export", file, "--format", "csv")


@pytest.mark.parametrize("told", ["9.81", True, None])
def test_a_gravity_that_is_no_number_is_refused(told, tumble, refused, tmp_path):
    file, result = solve(tumble, tmp_path)
    file.write_text(json.dumps({**result, "environment": {"gravity_m_s2": told}}))
    refused("export", file, "--format", "csv", "--unit", "m/s2")
