"""A real recording of a real sensor, placed by hand on six faces (outputs in m/s^2)."""

import csv
import gzip
import json

import pytest
from conftest import ROOT

from tumble import model
from tumble.schedule import Mounting

EXPECTED = {"K_xx": 9.776727847, "K_xy": -0.145014464, "K_yy": 9.833534627, "K_zz": 10.038596053, "U0_x": 0.551139244}


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "six_face_session.csv"
    path.write_bytes(gzip.decompress((ROOT / "tests/data/six_face_session.csv.gz").read_bytes()))
    return path


def test_least_squares_solves_it_and_the_gravity_check_fails(tumble, recording):
    done = tumble("solve", recording, "--estimator", "least_squares", "--unit", "m/s^2", "--json")
    assert (done.returncode, done.stderr) == (1, "")
    result = json.loads(done.stdout)
    found = {
        name: result["U0"]["xyz".index(name[3])]
        if name[0] == "U"
        else result["K"]["xyz".index(name[2])]["xyz".index(name[3])]
        for name in EXPECTED
    }
    assert found == pytest.approx(EXPECTED, abs=1e-7)
    assert not result["verification"]["pass"]
    assert (result["counters"]["rows"], result["counters"]["positions"]) == (3428, 6)
    assert result["stand_seen"]["noise_v"] == pytest.approx(0.0144, rel=0.01)


def test_a_harmonic_estimator_lists_what_is_missing(refused, recording):
    line = refused("solve", recording, "--estimator", "refined")
    assert line.endswith("missing 1.2, 1.4, 1.6, 1.8, 1.9, 2.2, 2.3, 2.4, 2.6, 2.7, 2.8, 2.9\n")


STAND = """[stand]
axis_tilt_rad = 5e-3
level_rad = 5e-3
remount_rad = 5e-3
angle_rad = 5e-3
noise_v = 0.0145
samples = 100
limits = "sigma1"
"""


def placed(folder, recording):
    """Every face as a mounting of its own, with a schedule for that."""
    faces = model.built_in("six_faces")
    mountings = tuple(
        Mounting(number, next(m.matrix for m in faces.mountings if m.number == face.mounting))
        for number, face in enumerate(faces.positions, 1)
    )
    numbers = {(face.mounting, face.number): number for number, face in enumerate(faces.positions, 1)}
    lines = [f"[[mounting]]\nnumber = {m.number}\nmatrix = {[list(row) for row in m.matrix]}\n" for m in mountings]
    lines += [
        f"[[position]]\nmounting = {number}\nposition = 1\nangle_deg = {face.angle_deg}\n"
        for number, face in enumerate(faces.positions, 1)
    ]
    (folder / "placed.toml").write_text("\n".join(lines))
    header, *rows = csv.reader(recording.read_text().splitlines())
    told = [",".join([str(numbers[int(row[0]), int(row[1])]), "1", *row[2:]]) for row in rows]
    (folder / "placed.csv").write_text("\n".join([",".join(header), *told]) + "\n")
    return folder / "placed.csv", folder / "placed.toml"


def solved(tumble, run, schedule, stand):
    command = ("--schedule", schedule, "--stand", stand, "--estimator", "optimal", "--unit", "m/s^2", "--json")
    done = tumble("solve", run, *command)
    return done.returncode, json.loads(done.stdout)


def test_the_whole_model_says_that_every_face_was_laid_down_anew(tumble, recording, tmp_path):
    """The gravity check alone would pass it."""
    (tmp_path / "stand.toml").write_text(STAND)
    code, result = solved(tumble, recording, "six_faces", tmp_path / "stand.toml")
    assert (code, result["pass_reason"], result["verification"]["pass"]) == (1, "fit and uncertainty", True)
    first = result["fit"]["explanations"][0]
    assert result["fit"]["chi2"] > 1000 and first["patterns"][0] == "slip" and first["column"] == "theta_h"
    assert first["size"] == pytest.approx(-3700, rel=0.1)


def test_with_a_seat_for_every_face_it_fits(tumble, recording, tmp_path):
    run, schedule = placed(tmp_path, recording)
    (tmp_path / "stand.toml").write_text(STAND)
    code, plain = solved(tumble, run, schedule, tmp_path / "stand.toml")
    assert code == 1 and not plain["fit"]["fits"]
    (tmp_path / "seats.toml").write_text(STAND + "seat_rad = 5e-3\n")
    code, seated = solved(tumble, run, schedule, tmp_path / "seats.toml")
    assert (code, seated["pass_reason"]) == (1, "uncertainty")  # no face laid by hand shows the default limit
    assert seated["fit"]["p"] > 0.5 and seated["verification"]["max_abs_delta_g_g"] < 1e-5
    assert max(seated["u_U0"]) < 6e-5 * 10.1
