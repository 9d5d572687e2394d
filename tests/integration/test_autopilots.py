"""Parameters of autopilots, read as these do and applied by their formula, in exact fractions."""

import json
import re
from fractions import Fraction

import numpy as np
import pytest
from conftest import EXAMPLES

import tumble
from tumble.api.result import Result
from tumble.cli.main import main

pytestmark = pytest.mark.python
K = np.array([[1.012, 0.004, -0.003], [-0.002, 0.991, 0.005], [0.006, -0.001, 1.004]])
U0 = np.array([0.012, -0.034, 0.005])
GRAVITY = 9.8123
STANDARD = 9.80665
SIZES = {"m/s^2": 1.0, "g": STANDARD, "mg": STANDARD / 1000}


def result_in(unit, gravity=None):
    """Of a sensor with this matrix, per g_local in its own unit."""
    found = tumble.solve(EXAMPLES / "paper_stand.csv", stand=EXAMPLES / "paper_stand.toml").document
    one_g = (gravity or STANDARD) / SIZES[unit]
    environment = {} if gravity is None else {"gravity_m_s2": gravity, "u_gravity_m_s2": 1e-5}
    coefficients = {"K": (K * one_g).tolist(), "U0": (U0 * one_g).tolist(), "unit": unit}
    return Result(json.dumps({**found, **coefficients, "environment": environment or None}))


@pytest.fixture
def exported(tmp_path, capsys):
    def export(result, *options, code=0):
        result.save(tmp_path / "result.json")
        assert main(["export", str(tmp_path / "result.json"), *options]) == code
        printed = capsys.readouterr()
        return printed.err if code else printed.out

    return export


def read_qgroundcontrol(text):
    """Its loader: lines of five fields between tabs, # begins a comment."""
    fields = [line.split("\t") for line in text.splitlines() if line and not line.startswith("#")]
    assert all(len(one) == 5 and one[:2] == ["1", "1"] and one[4] == "9" for one in fields)
    return {name: Fraction(value) for _, _, name, value, _ in fields}


def read_mavproxy(text):
    """Its loader, pymavlink's too: commas are blanks, two fields a line, # begins a comment."""
    fields = [line.replace(",", " ").split() for line in text.splitlines() if line and not line.startswith("#")]
    assert all(len(one) == 2 for one in fields)
    return {name: Fraction(value) for name, value in fields}


FORMATS = {
    "px4": (read_qgroundcontrol, "CAL_ACC{}_{}OFF", "CAL_ACC{}_{}SCALE", ("0", "1")),
    "ardupilot": (read_mavproxy, "INS_ACC{}OFFS_{}", "INS_ACC{}SCAL_{}", ("", "2")),
}


@pytest.mark.parametrize("gravity", [None, GRAVITY])
@pytest.mark.parametrize("unit", SIZES)
@pytest.mark.parametrize("name", FORMATS)
def test_each_channel_alone_gives_its_own_axis(exported, name, unit, gravity):
    """An acceleration along an axis comes back to 1e-13; across them what is left is what the file names."""
    read, offset, scale, (first, _) = FORMATS[name]
    text = exported(result_in(unit, gravity), "--format", name)
    parameters, size = read(text), Fraction(SIZES[unit])
    assert set(parameters) == {one.format(first, axis) for one in (offset, scale) for axis in "XYZ"}
    g, left = Fraction(gravity or STANDARD), []
    one_g = (gravity or STANDARD) / SIZES[unit]
    k, u0 = (K * one_g).tolist(), (U0 * one_g).tolist()
    for axis in range(3):
        felt = [Fraction(3) if j == axis else Fraction(0) for j in range(3)]  # g
        force = []
        for i, channel in enumerate("XYZ"):
            output = (Fraction(u0[i]) + sum(Fraction(k[i][j]) * felt[j] for j in range(3))) * size
            force.append(
                (output - parameters[offset.format(first, channel)]) * parameters[scale.format(first, channel)]
            )
        assert abs(force[axis] - 3 * g) < Fraction(1, 10**13) * 300
        left.append([float(one / g / 3) for one in force])
    named = {pair: float(part) for pair, part in re.findall(r"^#   ([xyz]{2}) ([-+]\S+)$", text, re.MULTILINE)}
    assert len(named) == 6
    for pair, part in named.items():
        i, j = map("xyz".index, pair)
        assert part == pytest.approx(left[j][i], rel=6e-3)
    most = np.linalg.norm(np.array(left).T - np.eye(3), 2) * float(g)
    assert float(re.search(r"up to (\S+) m/s\^2 at 1 g", text)[1]) == pytest.approx(most, rel=0.06)


@pytest.mark.parametrize("name", FORMATS)
def test_another_accelerometer_has_names_of_its_own(exported, name):
    read, offset, scale, (_, second) = FORMATS[name]
    parameters = read(exported(result_in("g"), "--format", name, "--accelerometer", "2"))
    assert set(parameters) == {one.format(second, axis) for one in (offset, scale) for axis in "XYZ"}


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--unit", "g"), "--unit g: the parameters of {} are in m/s^2"),
        (("--accelerometer", "4"), "--accelerometer: '4' is not a whole number from 1 to 3"),
        (("--out", "x.json"), "does not end in "),
    ],
)
def test_wrong_options_are_refused(exported, name, options, said):
    assert said.format(name) in exported(result_in("g"), "--format", name, *options, code=2)


@pytest.mark.parametrize("name", FORMATS)
def test_volts_are_refused(exported, name):
    volts = (
        tumble.solve(EXAMPLES / "paper_stand.csv", unit="V") if False else tumble.solve(EXAMPLES / "paper_stand.csv")
    )
    assert "outputs in V: " in (said := exported(volts, "--format", name, code=2))
    assert said.endswith("calibrates accelerations, in m/s^2 or g\n")


def test_a_scale_that_the_autopilot_refuses_is_refused_here(exported):
    document = result_in("g").document
    document["K"] = [[2 * one for one in row] for row in document["K"]]
    said = exported(Result(json.dumps(document)), "--format", "ardupilot", code=2)
    assert "scale 0.4941 of X: ArduPilot takes 0.8 to 1.2" in said


def test_only_an_autopilot_has_several(exported):
    assert "--accelerometer: is for the parameters of an autopilot" in exported(
        result_in("g"), "--format", "csv", "--accelerometer", "2", code=2
    )


def test_pymavlink_reads_them(exported, tmp_path):
    mavparm = pytest.importorskip("pymavlink.mavparm")
    (tmp_path / "acc.param").write_text(text := exported(result_in("m/s^2", GRAVITY), "--format", "ardupilot"))
    read = mavparm.MAVParmDict()
    read.load(str(tmp_path / "acc.param"), check=False)
    assert dict(read) == pytest.approx({name: float(value) for name, value in read_mavproxy(text).items()})
