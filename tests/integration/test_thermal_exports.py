"""Calibrations over temperature for other programs: read as these do, and applied by their formulas."""

import os
import shutil
import subprocess
from fractions import Fraction

import numpy as np
import pytest

from tumble.api.thermal import solve_thermal
from tumble.model.coefficients import spread_attitudes
from tumble.model.geometry import built_in, ideal_force

pytestmark = pytest.mark.python
STANDARD = 9.80665
T0, AT_C = 20.0, (-30.0, 0.0, 40.0, 70.0)
K0, SLOPE = np.diag([1.01, 0.99, 1.004]), 1e-4 * np.array([[1.0, 0.3, 0.0], [0.2, -0.8, 0.1], [0.0, 0.1, 0.5]])
U0 = np.array([[0.012, -0.034, 0.005], [2e-4, -1e-4, 3e-4], [1e-6, 2e-6, -3e-6]])


def result_of(slope, unit="g"):
    """Of runs without errors."""
    schedule, runs = built_in("three_mountings"), []
    for t in AT_C:
        means = ideal_force(schedule) @ (K0 + slope * (t - T0)).T + (t - T0) ** np.arange(3.0) @ U0
        columns = {f"u{axis} [{unit}]": means[:, i] for i, axis in enumerate("xyz")}
        columns["mounting"] = [one.mounting for one in schedule.positions]
        columns["position"] = [one.number for one in schedule.positions]
        runs.append({**columns, "temperature": np.full(len(means), t)})
    return solve_thermal(runs, temperature="quadratic", schedule=schedule)


@pytest.fixture
def exported(tumble, tmp_path):
    def export(result, *options, code=0):
        result.save(tmp_path / "warm.json")
        done = tumble("export", tmp_path / "warm.json", *options)
        assert done.returncode == code, done.stderr
        return done.stderr if code else done.stdout

    return export


def read_qgroundcontrol(text):
    """Its loader: lines of five fields between tabs, # begins a comment; types 6 and 9 are int32 and float."""
    fields = [line.split("\t") for line in text.splitlines() if line and not line.startswith("#")]
    assert all(len(one) == 5 and one[:2] == ["1", "1"] and one[4] in ("6", "9") for one in fields)
    return {name: Fraction(value) for _, _, name, value, _ in fields}


def read_mavproxy(text):
    """Its loader, pymavlink's too: commas are blanks, two fields a line, # begins a comment."""
    fields = [line.replace(",", " ").split() for line in text.splitlines() if line and not line.startswith("#")]
    assert all(len(one) == 2 for one in fields)
    return {name: Fraction(value) for name, value in fields}


def px4(told, n, raw, t):
    """m/s^2 of raw outputs: TemperatureCompensation.cpp clips and subtracts, sensor_calibration scales."""
    d = min(max(t, told[f"TC_A{n}_TMIN"]), told[f"TC_A{n}_TMAX"]) - told[f"TC_A{n}_TREF"]
    warm = [sum(told[f"TC_A{n}_X{power}_{i}"] * d**power for power in range(4)) for i in range(3)]
    return [(raw[i] - warm[i] - told[f"CAL_ACC{n}_{a}OFF"]) * told[f"CAL_ACC{n}_{a}SCALE"] for i, a in enumerate("XYZ")]


def ardupilot(told, n, raw, t):
    """The same: AP_InertialSensor_TCal takes polynomials about 35 deg C, and puts that of CALTEMP back."""
    least, most, number = told[f"INS_TCAL{n}_TMIN"], told[f"INS_TCAL{n}_TMAX"], "" if n == 1 else n

    def at(warm, a):
        d = min(max(warm, least), most) - 35
        return sum(told[f"INS_TCAL{n}_ACC{power}_{a}"] * d**power for power in (1, 2, 3)) / 10**6

    return [
        (raw[i] - at(t, a) + at(told[f"INS_ACC{n}_CALTEMP"], a) - told[f"INS_ACC{number}OFFS_{a}"])
        * told[f"INS_ACC{number}SCAL_{a}"] for i, a in enumerate("XYZ")
    ]  # fmt: skip


AUTOPILOTS = {"px4": (read_qgroundcontrol, px4, ("0", "2")), "ardupilot": (read_mavproxy, ardupilot, (1, 3))}


@pytest.mark.parametrize("name", AUTOPILOTS)
@pytest.mark.parametrize("which", [0, 1])
def test_an_autopilot_finds_the_force_by_its_own_formula(exported, name, which):
    read, formula, numbers = AUTOPILOTS[name]
    number = ["--accelerometer", "3"] if which else []
    told = read(exported(result_of(0.0 * SLOPE), "--format", name, *number))
    assert told["TC_A_ENABLE" if name == "px4" else f"INS_TCAL{numbers[which]}_ENABLE"] == 1
    for t in (-30, 20, 35, 61):
        force = np.array([0.3, -0.4, 0.7])
        raw = STANDARD * (K0 @ force + (t - T0) ** np.arange(3.0) @ U0)
        found = formula(told, numbers[which], [Fraction(one) for one in raw], Fraction(t))
        assert np.abs(np.array(found, dtype=float) - STANDARD * force).max() < 1e-9


@pytest.mark.parametrize("name", AUTOPILOTS)
def test_what_an_autopilot_cannot_hold_is_named_with_its_size(exported, name):
    text = exported(result_of(SLOPE), "--format", name)
    [said] = [line for line in text.splitlines() if "without them the error" in line]
    n, left = spread_attitudes(20_000), []
    for t in (-30.0, 70.0):
        force = n @ (K0 + SLOPE * (t - T0)).T / np.diag(K0)
        left.append(np.linalg.norm(force - n, axis=1).max() * STANDARD)
    assert float(said.split("up to ")[1].split()[0]) == pytest.approx(max(left), rel=0.05)


@pytest.mark.parametrize("name", ["c", *AUTOPILOTS])
def test_a_pass_without_a_stand_holds_at_the_measured_positions(exported, name):
    said = "Verdict: PASS from -30 to 70 deg C at the 108 measured positions only: no stand declared, no uncertainty"
    assert said in exported(result_of(SLOPE), "--format", name)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
@pytest.mark.parametrize(("real", "off"), [("double", 1e-13), ("float", 1e-6)])
def test_the_c_header_finds_the_force(exported, tmp_path, real, off):
    result, rng = result_of(SLOPE, "V"), np.random.default_rng(3)
    cases = [(force, t) for t in (-30.0, 11.0, 70.0) for force in rng.uniform(-1, 1, (20, 3))]
    (tmp_path / "c.h").write_text(exported(result, "--format", "c", "--number", real))
    rows = []
    for force, t in cases:
        outputs = (K0 + SLOPE * (t - T0)) @ force + (t - T0) ** np.arange(3.0) @ U0
        rows.append("{" + ", ".join(f"{one!r}" for one in [*outputs.tolist(), t]) + "}")
    (tmp_path / "main.c").write_text(f"""
#include "c.h"
#include <stdio.h>
int main(void)
{{
    static const double cases[][4] = {{{", ".join(rows)}}};
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {{
        const {real} outputs[3] = {{({real})cases[i][0], ({real})cases[i][1], ({real})cases[i][2]}};
        {real} force[3];
        tumble_exported_force(outputs, ({real})cases[i][3], force);
        printf("%.17g %.17g %.17g\\n", (double)force[0], (double)force[1], (double)force[2]);
    }}
    return TUMBLE_PASSED == 1 && TUMBLE_UNCERTAINTY_KNOWN == 0 ? 0 : 1;
}}
""")
    ours = {name: value for name, value in os.environ.items() if name != "LD_PRELOAD"}
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic"]
    subprocess.run(["cc", *flags, "main.c", "-o", "main"], cwd=tmp_path, check=True, env=ours)
    done = subprocess.run([tmp_path / "main"], check=True, capture_output=True, text=True, env=ours)
    found = np.array([line.split() for line in done.stdout.splitlines()], dtype=float)
    assert np.abs(found - np.array([force for force, _ in cases])).max() < off


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--format", "csv"], "over temperature there are formats c, px4, ardupilot, not csv"),
        (["--format", "c", "--number", "fixed", "--step", "1e-6"], "over temperature in double or float, for g alone"),
        (["--format", "px4", "--unit", "m/s2"], "over temperature for g alone: leave out --unit"),
        (["--format", "px4"], "outputs in V: PX4 calibrates accelerations, in m/s^2 or g"),
    ],
)
def test_what_is_refused(exported, options, said):
    assert exported(result_of(SLOPE, "V"), *options, code=2).endswith(f"warm.json: {said}\n")
