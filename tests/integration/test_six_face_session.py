"""A real recording of a real sensor, placed by hand on six faces (outputs in m/s^2)."""

import gzip
import json

import pytest
from conftest import ROOT

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
