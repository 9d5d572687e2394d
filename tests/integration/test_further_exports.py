"""Exports of a result with further terms: the header applies them, the table has them, K^-1, date and version."""

import csv
import io
import json
import shutil
import subprocess

import numpy as np
import pytest
from conftest import EXAMPLES
from test_further_terms import STAND, VALUES, noisy, solved

from tumble.cli.main import main

pytestmark = pytest.mark.python

PROGRAM = """
#include "coefficients.h"
#include <stdio.h>
int main(void)
{
    const double outputs[3] = {OUTPUTS};
    static const double covariance[18][18] = TUMBLE_COVARIANCE_INITIALIZER;
    double force[3];
    tumble_exported_force(outputs, force);
    for (int i = 0; i < 3; i++) printf("%.17g\\n", force[i]);
    printf("%.17g\\n%.17g\\n", TUMBLE_K3_Z, covariance[17][17]);
    return 0;
}
"""


@pytest.mark.parametrize("unit", ["g", "m/s2"])
@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_header_applies_them(unit, tmp_path, capsys):
    run, out = noisy(tmp_path, 30.0 * VALUES), tmp_path / "result.json"
    gravity = "[environment]\ngravity_m_s2 = 9.81\nu_gravity_m_s2 = 1e-5\n"
    (tmp_path / "stand.toml").write_text((EXAMPLES / "paper_stand.toml").read_text() + gravity)
    options = ["--stand", tmp_path / "stand.toml", "--estimator", "least_squares", "--model", "k2,k3,drift"]
    solved(capsys, run, *options, "--out", out)
    assert main(["export", str(out), "--format", "c", "--unit", unit]) == 0
    header = capsys.readouterr().out
    (tmp_path / "coefficients.h").write_text(header)
    result = json.loads(out.read_text())
    k, u0, found = np.array(result["K"]), np.array(result["U0"]), result["extended"]
    force = np.array([0.6, -0.7, 0.9])
    outputs = u0 + k @ force + np.diag(k) * (found["k2_per_g"] * force**2 + found["k3_per_g2"] * force**3)
    (tmp_path / "main.c").write_text(PROGRAM.replace("OUTPUTS", ", ".join(map(repr, outputs.tolist()))))
    flags = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]
    subprocess.run(["cc", *flags, "main.c", "-o", "main"], cwd=tmp_path, check=True)
    printed = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True).stdout.split()
    factor = 1.0 if unit == "g" else 9.81
    assert [float(one) for one in printed[:3]] == pytest.approx((force * factor).tolist(), rel=1e-13)
    assert float(printed[3]) == pytest.approx(found["k3_per_g2"][2] / factor**2, rel=1e-15)
    variance = found["u_k3_per_g2"][2] ** 2 / factor**4
    assert float(printed[4]) == pytest.approx(variance, rel=1e-4)
    assert "U0 is that of the middle of the run" in header


def test_the_table_has_them_and_the_inverse(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    run, out = noisy(tmp_path), tmp_path / "result.json"
    solved(capsys, run, *STAND, "--estimator", "optimal", "--model", "k2,drift", "--out", out)
    assert main(["export", str(out), "--format", "csv"]) == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    result = json.loads(out.read_text())
    assert [row["coefficient"] for row in rows][12:] == ["K2_x", "K2_y", "K2_z"]
    assert [float(row["value"]) for row in rows[12:]] == result["extended"]["k2_per_g"]
    assert {row["unit"] for row in rows[12:]} == {"1/g"}
    assert float(rows[12]["covariance_K2_x"]) == pytest.approx(float(rows[12]["standard_uncertainty"]) ** 2)
    k = np.array(result["K"])
    inverse = np.array([float(row["inverse"]) for row in rows[:9]]).reshape(3, 3)
    assert inverse @ k == pytest.approx(np.eye(3), abs=1e-14) and {row["inverse_unit"] for row in rows[:9]} == {"g/V"}
    draws = k + np.random.default_rng(1).multivariate_normal(
        np.zeros(9), np.array(result["covariance"])[:9, :9], 4000).reshape(-1, 3, 3)
    spread = np.linalg.inv(draws).std(axis=0).ravel()
    assert [float(row["inverse_standard_uncertainty"]) for row in rows[:9]] == pytest.approx(spread, rel=0.06)
    assert {row["inverse"] for row in rows[9:]} == {""}
    assert {(row["created"], row["tumble"]) for row in rows} == {("2001-09-09T01:46:40Z", result["tumble"])}


BAD = {
    "no list": {"extended": 1},
    "unknown term": {"extended": {"terms": ["k9"]}},
    "no values": {"extended": {"terms": ["k2"], "k2_per_g": None}},
    "two values": {"extended": {"terms": ["k2"], "k2_per_g": [0.0, 0.0]}},
    "a small covariance": {"extended": {"terms": ["k2"], "k2_per_g": [0.0] * 3, "covariance": [[1.0]]}},
    "a singular K": {"K": [[1.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 1.0]]},
}


@pytest.mark.parametrize("case", BAD)
def test_results_that_are_no_results(case, tmp_path, capsys):
    run, out = noisy(tmp_path, 0 * VALUES), tmp_path / "result.json"
    solved(capsys, run, "--out", out)
    out.write_text(json.dumps({**json.loads(out.read_text()), **BAD[case]}))
    assert main(["export", str(out), "--format", "c"]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and captured.err.count("\n") == 1
