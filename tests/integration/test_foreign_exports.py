"""Exports for other programs: each is applied by that program's own formula, and gives the result's force."""

import itertools
import json
import os
import re
import shutil
import subprocess
from fractions import Fraction

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT
from documents import NO_GRAVITY
from test_apply import exact_force, outputs_exactly

import tumble
from tumble.api.result import Result
from tumble.cli.main import main
from tumble.report import thermal
from tumble.report.coefficients import FORMATS

pytestmark = pytest.mark.python
with_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")

GRAVITY = 9.8067
OUTPUTS = [[0.0, 0.0, 2.0], [-1.2, 0.7, 1.4], [5.0, -3.25, 0.125]]
FLAGS = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Werror"]


def test_a_format_is_a_row_and_a_template():
    templates = (ROOT / "host/python/src/tumble/report/exports").iterdir()
    warm = [f"{name}_thermal.j2" for name in thermal.FORMATS]
    assert sorted(path.name for path in templates) == sorted([*(f"{name}.j2" for name in FORMATS), *warm])


@pytest.fixture(scope="module")
def result():
    """Of the paper's stand, where the local gravity is known; with a serial that is to stay in its comment."""
    found = tumble.solve(EXAMPLES / "paper_stand.csv", stand=EXAMPLES / "paper_stand.toml").document
    environment = {"gravity_m_s2": GRAVITY, "u_gravity_m_s2": 1e-5}
    return Result(json.dumps({**found, "environment": environment, "serial": "SN\n7: % */ [é"}))


@pytest.fixture
def exported(result, tmp_path, capsys):
    """The text of an export, with these options."""

    def export(*options, code=0, of=result):
        of.save(tmp_path / "result.json")
        assert main(["export", str(tmp_path / "result.json"), *map(str, options)]) == code
        printed = capsys.readouterr()
        return printed.err if code else printed.out

    return export


def numbers(program, folder, *headers, flags=FLAGS):
    """What a C program prints."""
    for name, text in headers:
        (folder / name).write_text(text)
    (folder / "main.c").write_text(program)
    environment = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
    subprocess.run(["cc", *flags, "main.c", "-o", "main"], cwd=folder, check=True, env=environment)
    printed = subprocess.run([folder / "main"], check=True, capture_output=True, text=True, env=environment)
    return [float(one) for one in printed.stdout.split()]


FLOAT = """
#include "c.h"
#include <stdio.h>
int main(void)
{
    static const float outputs[3][3] = {OUTPUTS};
    static const tumble_exported_t coefficients = TUMBLE_COEFFICIENTS_INITIALIZER;
    static const float inverse[3][3] = TUMBLE_K_INVERSE_INITIALIZER;
    for (int i = 0; i < 3; i++) {
        float force[3];
        tumble_exported_force(outputs[i], force);
        printf("%.17g %.17g %.17g\\n", (double)force[0], (double)force[1], (double)force[2]);
    }
    for (int i = 0; i < 9; i++) printf("%.17g\\n", (double)coefficients.k[i / 3][i % 3]);
    for (int i = 0; i < 3; i++) printf("%.17g\\n", (double)coefficients.u0[i]);
    for (int i = 0; i < 9; i++) printf("%.17g\\n", (double)inverse[i / 3][i % 3]);
    return 0;
}
""".replace("OUTPUTS", ", ".join("{" + ", ".join(f"{one!r}f" for one in row) + "}" for row in OUTPUTS))


@with_compiler
def test_c_in_single_precision(result, exported, tmp_path):
    """The constants are the nearest floats; the force is right to what floats hold. Nothing is double."""
    printed = numbers(FLOAT, tmp_path, ("c.h", exported("--format", "c", "--number", "float")))
    assert np.reshape(printed[:9], (3, 3)) == pytest.approx(result.apply(OUTPUTS), rel=0, abs=3e-6)
    inverse = np.linalg.inv(result.K)
    expected = np.concatenate([result.K.ravel(), result.U0, inverse.ravel()]).astype(np.float32)
    assert printed[9:] == expected.tolist()


FIXED = """
#include "c.h"
#include <stdio.h>
int main(void)
{
    static const int32_t counts[][3] = {COUNTS};
    for (unsigned i = 0; i < sizeof counts / sizeof counts[0]; i++) {
        int32_t force[3];
        tumble_exported_force_fixed(counts[i], force);
        printf("%d %d %d\\n", (int)force[0], (int)force[1], (int)force[2]);
    }
    printf("%.17g %d\\n", TUMBLE_COUNT_SIZE, TUMBLE_FIXED_SHIFT);
    return 0;
}
"""
LARGEST = 2**31 - 1


@with_compiler
@pytest.mark.parametrize("step", [1.2e-6, 3e-9, 0.02])
@pytest.mark.parametrize("unit", ["g", "m/s2"])
def test_c_in_fixed_point(step, unit, result, exported, tmp_path):
    """Within half a step, and what the rounding of its factors adds; counts of all sizes, under the sanitizer."""
    random, limit = np.random.default_rng(3), min(LARGEST, round(20.0 / step))
    counts = np.rint(random.uniform(-limit, limit, (200, 3))).astype(int).tolist()
    counts += [[0, 0, 0], [1, -1, 1], [LARGEST] * 3, [-LARGEST - 1] * 3, [LARGEST, -LARGEST, LARGEST]]
    listed = ", ".join("{" + ", ".join(f"(int32_t){one}LL" for one in row) + "}" for row in counts)
    header = exported("--format", "c", "--number", "fixed", "--step", step, "--unit", unit)
    flags = [*FLAGS, "-fsanitize=undefined", "-fno-sanitize-recover=all"]
    printed = numbers(FIXED.replace("COUNTS", listed), tmp_path, ("c.h", header), flags=flags)
    assert printed[-2] == step
    scale, size = Fraction(GRAVITY) if unit == "m/s2" else Fraction(1), Fraction(step)
    for row, found in zip(counts, np.reshape(printed[:-2], (-1, 3)).tolist()):
        force = exact_force(result.K, result.U0, [one * size for one in row])
        by_factors = (sum(map(abs, row)) + 2 + abs(3 / size)) / Fraction(2) ** (int(printed[-1]) + 1)
        for one, expected in zip(found, (part * scale * 10**6 for part in force)):
            bound = Fraction(1, 2) + by_factors + abs(expected) / 10**13
            assert abs(Fraction(one) - max(min(expected, LARGEST), -LARGEST)) <= bound


def test_what_fixed_point_cannot_hold(exported, refused, result, tmp_path):
    for options, said in (
        (["--number", "fixed", "--step", "1e4"], "--step 10000: a count is too large for a force in steps of 1e-6"),
        (["--number", "fixed", "--step", "1e-12"], "--step 1e-12: U0 has more counts than 32 bits hold"),
        (["--number", "fixed"], "--number fixed and --step SIZE belong together: a count of the outputs has a size"),
        (["--step", "1"], "--number fixed and --step SIZE belong together: a count of the outputs has a size"),
        (["--number", "fixed", "--step", "-1"], "--step: '-1' is not a size above 0"),
    ):
        assert exported("--format", "c", *options, code=2).endswith(f"{said}\n")
    assert "--number float: is for --format c" in exported("--format", "csv", "--number", "float", code=2)


def yaml(text):
    """Of a file of comments and flat lists."""
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    return {key: json.loads(value) for key, value in (line.split(": ", 1) for line in lines)}


def test_the_yaml_of_imu_calib(result, exported):
    """corrected = SM raw - bias, as accel_calib.cpp has it; m/s^2 as sensor_msgs/Imu."""
    text = exported("--format", "ros")
    found = yaml(text)
    assert set(found) == {"SM", "bias"} and len(found["SM"]) == 9 and len(found["bias"]) == 3
    corrected = [np.reshape(found["SM"], (3, 3)) @ raw - found["bias"] for raw in OUTPUTS]
    assert np.array(corrected) == pytest.approx(result.apply(OUTPUTS, unit="m/s2"), rel=0, abs=1e-13)
    assert yaml(exported("--format", "ros", "--unit", "g"))["SM"] == np.linalg.inv(result.K).ravel().tolist()
    [bias] = [json.loads(line.split(": ")[1]) for line in text.splitlines() if line.startswith("# U0, V: ")]
    assert bias == result.U0.tolist() and text.isascii()


def test_the_json_of_imucal(result, exported):
    """acc = R_a^-1 K_a^-1 (raw - b_a); every key is a field of its FerrarisCalibrationInfo, and the rotation's rows are
    of length 1."""
    for unit, name in (("m/s2", "m/s^2"), ("g", "g")):
        found = json.loads(exported("--format", "imucal", *(["--unit", "g"] if unit == "g" else [])))
        r, k, b = (np.array(found[key]) for key in ("R_a", "K_a", "b_a"))
        acc = (np.linalg.inv(r) @ np.linalg.inv(k) @ (np.array(OUTPUTS) - b).T).T
        assert acc == pytest.approx(result.apply(OUTPUTS, unit=unit), rel=0, abs=1e-13)
        assert np.linalg.norm(r, axis=1) == pytest.approx(1.0) and b.tolist() == result.U0.tolist()
        assert np.count_nonzero(k - np.diag(np.diag(k))) == 0
        assert (found.pop("cal_type"), found.pop("_format_version")) == ("Ferraris", "2.0.0")
        assert (found["acc_unit"], found["from_acc_unit"]) == (name, "V")
        fields = "acc_unit gyr_unit from_acc_unit from_gyr_unit comment K_a R_a b_a K_g R_g K_ga b_g"
        assert list(found) == fields.split()
        assert found["K_g"] == found["R_g"] == np.eye(3).tolist() and found["b_g"] == [0, 0, 0]


class Matlab:
    """As much of the language as the script uses: numbers, matrices, and its one-line functions by their text."""

    def __init__(self, text):
        self.values, self.functions = {}, {}
        for line in text.splitlines():
            if line and not line.startswith("%"):
                name, value = re.fullmatch(r"(\w+(?:\.\w+)?) = (.*);", line).groups()
                self.values[name] = value

    def matrix(self, name):
        text = self.values[f"tumble.{name}"]
        return np.array([[float(one) for one in row.split()] for row in text[1:-1].split(";")])

    def called(self, name, *arguments):
        """A function, as Python has it: its text, rewritten sign by sign."""
        if name not in self.functions:
            parameters, body = re.fullmatch(r"@\(([\w, ]+)\) (.*)", self.values[name]).groups()
            self.functions[name] = parameters.split(", "), compile(self.rewritten(body), name, "eval")
        parameters, body = self.functions[name]
        given = dict(zip(parameters, (np.asarray(one, dtype=float) for one in arguments), strict=True))
        return eval(body, {"np": np, "self": self, "dot": dot, "cross": cross, **given})

    def rewritten(self, body):
        body = re.sub(r"\[(.*)\] \./", r"np.hstack([\1]) /", body)
        body = body.replace("((1:3) == j)", "(np.arange(1, 4) == j)")
        body = re.sub(r"\(\[(\d) (\d) (\d)\] == j\)", r"(np.array([[\1, \2, \3]]) == j)", body)
        body = re.sub(r"a\(:, \[(\d) (\d) (\d)\]\)", r"a[:, np.array([\1, \2, \3]) - 1]", body)
        body = body.replace("abs(a)", "np.abs(a)").replace("sign(a)", "np.sign(a)")
        body = re.sub(r"tumble\.(\w+)\(:, j\)'", r"self.matrix('\1')[:, int(j) - 1][None]", body)
        body = re.sub(r"tumble\.(\w+)('?)", lambda m: f"self.matrix('{m[1]}'){'.T' if m[2] else ''}", body)
        body = re.sub(r"(tumble_\w+)\(", r"self.called('\1', ", body)
        body = re.sub(r"diag\((.*?)\)'", r"np.diag(\1)[None]", body)
        body = body.replace(".^", "**").replace(".*", "\0")
        return re.sub(r"(?<!\.)(?<!\*)\*(?!\*)", "@", body.replace("**", "\1")).replace("\0", "*").replace("\1", "**")


def dot(one, other, dimension):
    assert dimension == 2 and one.shape == other.shape
    return (one * other).sum(axis=1, keepdims=True)


def cross(one, other, dimension):
    assert dimension == 2 and one.shape == other.shape
    return np.cross(one, other)


def test_the_script_of_matlab(result, exported):
    script = exported("--format", "matlab")
    found = Matlab(script)
    for name, expected in (("K", result.K), ("U0", result.U0[:, None]), ("u_K", result.u_K),
                           ("u_U0", result.u_U0[:, None]), ("covariance", result.covariance),
                           ("K_inverse", np.linalg.inv(result.K))):  # fmt: skip
        assert found.matrix(name).tolist() == expected.tolist()
    assert found.values["tumble.force_unit"] == "'g'" and found.values["tumble.passed"] == "true"
    assert found.called("tumble.apply", OUTPUTS) == pytest.approx(result.apply(OUTPUTS), rel=0, abs=1e-14)
    labelled = exported("--format", "matlab", "--labels")
    assert labelled.isascii() and "% Block: SN" in labelled


@pytest.fixture(scope="module")
def extended():
    """With K2 and K3 that matter, of either sign; still every output up to 50 V (25 g) is that of one force."""
    solved = {"estimator": "least_squares", "model": "k2,k3", "stand": EXAMPLES / "paper_stand.toml"}
    document = tumble.solve(EXAMPLES / "paper_stand.csv", **solved).document
    document["extended"] |= {"k2_per_g": [4e-3, -3e-3, 2e-3], "k3_per_g2": [3e-4, -1e-4, 2e-5]}
    return Result(json.dumps({**document, "environment": {"gravity_m_s2": GRAVITY}}))


def over_the_range(result):
    """Forces to 25 g (200, 3), and the outputs that they give, in fractions, rounded once."""
    forces = np.random.default_rng(5).uniform(-25.0, 25.0, (200, 3))
    forces[:8] = 25.0 * np.array(list(itertools.product((-1, 1), repeat=3)))
    return forces, [outputs_exactly(result, force) for force in forces.tolist()]


NEWTON = r"""
#include "c.h"
#include <stdio.h>
int main(void)
{
    static const REAL outputs[][3] = {OUTPUTS};
    for (unsigned i = 0; i < sizeof outputs / sizeof outputs[0]; i++) {
        REAL force[3];
        tumble_exported_force(outputs[i], force);
        printf("%.17g %.17g %.17g\n", (double)force[0], (double)force[1], (double)force[2]);
    }
    return 0;
}
"""


@with_compiler
@pytest.mark.parametrize(("number", "suffix", "off"), [("double", "", 1e-12), ("float", "f", 2e-4)])
@pytest.mark.parametrize("unit", ["g", "m/s2"])
def test_c_takes_k2_and_k3_out_over_the_range(unit, number, suffix, off, extended, exported, tmp_path):
    """It was off by 1e-8 g at 50 V, with K2 and K3 a tenth of these."""
    forces, outputs = over_the_range(extended)
    listed = ", ".join("{" + ", ".join(f"{one!r}{suffix}" for one in row) + "}" for row in outputs)
    header = exported("--format", "c", "--unit", unit, "--number", number, of=extended)
    printed = numbers(NEWTON.replace("REAL", number).replace("OUTPUTS", listed), tmp_path, ("c.h", header))
    scale = GRAVITY if unit == "m/s2" else 1.0
    assert np.abs(np.reshape(printed, (-1, 3)) / scale - forces).max() < off


def test_python_and_matlab_take_k2_and_k3_out_over_the_range(extended, exported):
    forces, outputs = over_the_range(extended)
    script = Matlab(exported("--format", "matlab", of=extended))
    for found in (extended.apply(outputs), script.called("tumble.apply", outputs)):
        assert np.abs(found - forces).max() < 1e-12


def test_what_holds_no_further_terms(extended, exported):
    for name, program in (("ros", "imu_calib"), ("imucal", "imucal")):
        said = exported("--format", name, "--unit", "g", code=2, of=extended)
        assert said.endswith(f"result.json: {program} holds twelve coefficients, no K2 and K3\n")
    said = exported("--format", "c", "--number", "fixed", "--step", "1e-6", code=2, of=extended)
    assert said.endswith("fixed point has no K2 and K3: export them as float or double\n")


def test_without_a_stand_and_without_gravity(exported, tmp_path):
    alone = tumble.solve(EXAMPLES / "paper_stand.csv")
    found = Matlab(exported("--format", "matlab", of=alone))
    assert found.values["tumble.u_K"] == found.values["tumble.covariance"] == "[]"
    for name in ("ros", "imucal"):
        said = exported("--format", name, code=2, of=alone)
        assert said.endswith(f"result.json: {NO_GRAVITY}\n")
    assert "Uncertainties unknown: no stand was declared." in exported("--format", "ros", "--unit", "g", of=alone)
