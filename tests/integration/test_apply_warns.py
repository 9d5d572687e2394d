"""What `tumble apply` says of the result that it applies."""

import json
import warnings

import numpy as np
import pytest
from conftest import EXAMPLES
from test_apply import applied

import tumble

pytestmark = pytest.mark.python


@pytest.fixture
def saved(tmp_path):
    """A result as a file."""
    tumble.solve(EXAMPLES / "paper_stand.csv").save(tmp_path / "result.json")
    return tmp_path / "result.json"


def test_a_result_that_failed_is_warned_of(tmp_path, capsysbinary):
    tumble.solve(EXAMPLES / "paper_stand.csv", limit_g=1e-6).save(tmp_path / "failed.json")
    (tmp_path / "data.csv").write_text("ux,uy,uz\n0,0,2\n")
    told = applied(capsysbinary, tmp_path / "failed.json", tmp_path / "data.csv").err.decode().splitlines()
    failed = (
        f"tumble: warning: {tmp_path}/failed.json: the gravity check FAILED: largest error 6.6e-05 g, limit 1e-06 g"
    )
    assert told[1] == failed and "assuming" in told[2]


def test_bad_data_is_one_line(saved, tmp_path, capsysbinary):
    said = applied(capsysbinary, saved, tmp_path / "none.csv", code=2)
    assert (said.out, said.err.count(b"\n")) == (b"", 1)


def test_what_was_warned_of_is_warned_of_again(saved, tmp_path, capsysbinary):
    document = json.loads(saved.read_text())
    document["warnings"] = ["nothing checks this run"]
    saved.write_text(json.dumps(document))
    (tmp_path / "data.csv").write_text("ux,uy,uz\n0.1,0.2,1.9\n")
    said = applied(capsysbinary, saved, tmp_path / "data.csv").err.decode()
    assert f"tumble: warning: {saved}: nothing checks this run\n" in said
    assert tumble.load(saved).warnings == ("nothing checks this run",)


# Units that nobody names.

TURNING = np.linspace(0.0, 2.0, 200)[:, None] * [[1.0, 0.3, 0.7]]
SLOWLY = np.column_stack((np.sin(TURNING[:, 0]) * 0.8, np.cos(TURNING[:, 0]) * 0.8, np.full(200, 0.6)))  # g


@pytest.fixture(scope="module")
def in_g():
    rows = np.loadtxt(EXAMPLES / "paper_stand.csv", delimiter=",", skiprows=1) / [1, 1, 2, 2, 2]
    return tumble.solve(tumble.read(rows, unit="g"))


def outputs(result, times):
    return times * (result.U0 + SLOWLY @ result.K.T)


def written(path, unit, rows):
    header = ",".join(f"{name}{unit}" for name in ("ux", "uy", "uz"))
    np.savetxt(path, rows, "%.7f", delimiter=",", header=header, comments="")
    return path


@pytest.mark.parametrize("times, seen", [
    (9.81, "9.81 g: outputs look to be in m/s^2, the result is for g"),
    (1000.0, "1e+03 g: outputs look to be in mg, the result is for g"),
    (5.16, "5.16 g: outputs look to be in another unit, the result is for g"),
    (0.4, "0.4 g: outputs look to be in another unit, the result is for g"),
])  # fmt: skip
def test_data_of_another_unit_that_nobody_names_is_refused(times, seen, in_g, tmp_path, capsysbinary):
    in_g.save(tmp_path / "g.json")
    data = written(tmp_path / "data.csv", "", outputs(in_g, times) - (times - 1.0) * in_g.U0)
    for words in ((), ("--out", tmp_path / "out.csv")):
        said = applied(capsysbinary, tmp_path / "g.json", data, *words, code=2)
        line = f"at rest the acceleration comes out as {seen}; if it is right, name the unit in the header, as ux [g]"
        assert (said.out, said.err.decode()) == (b"", f"tumble: {data}: {line}\n")
    assert not (tmp_path / "out.csv").exists()


def test_counts_with_an_offset_are_refused(in_g, tmp_path, capsysbinary):
    """No two rests are alike then, but none of them is one of 1 g."""
    in_g.save(tmp_path / "g.json")
    rests = np.repeat(SLOWLY[::20], 20, axis=0)
    data = written(tmp_path / "data.csv", "", 1638.4 * rests + [900.0, -1200.0, 300.0])
    said = applied(capsysbinary, tmp_path / "g.json", data, code=2)
    assert said.out == b"" and b"at rest the acceleration comes out as" in said.err


@pytest.mark.parametrize("times, is_told", [(1.0, False), (0.7, True), (1.4, True)])
def test_rests_not_far_from_1_g_are_written(times, is_told, in_g, tmp_path, capsysbinary):
    """A poor calibration, or another unit? A warning."""
    in_g.save(tmp_path / "g.json")
    data = written(tmp_path / "data.csv", "", outputs(in_g, times) - (times - 1.0) * in_g.U0)
    told = applied(capsysbinary, tmp_path / "g.json", data).err.decode().splitlines()
    taken = "no unit in its header (as ux [V]): outputs taken for g, as in the result"
    assert told[0] == f"tumble: notice: {data}: {taken}"
    assert any("at rest the acceleration comes out as" in line for line in told) == is_told


def test_a_unit_that_is_named_is_believed(in_g, tmp_path, capsysbinary):
    """A centrifuge turns steadily too."""
    in_g.save(tmp_path / "g.json")
    data = written(tmp_path / "data.csv", " [g]", outputs(in_g, 5.0))
    told = applied(capsysbinary, tmp_path / "g.json", data).err.decode()
    assert "no unit" not in told and "at rest" not in told


def test_a_result_whose_run_named_no_unit(saved, tmp_path, capsysbinary):
    """Its unit is assumed, so what its data say of theirs proves nothing."""
    data = written(tmp_path / "data.csv", " [V]", outputs(tumble.load(saved), 1e3))
    told = applied(capsysbinary, saved, data, code=2).err.decode()
    assert told.endswith("outputs look to be in mV, the result is for V; if it is right, solve again with --unit\n")
    data = written(tmp_path / "data.csv", "", outputs(tumble.load(saved), 1.0))
    assert "outputs taken for V, as in the result, whose run names none either" in (
        applied(capsysbinary, saved, data).err.decode()
    )


def test_motion_says_nothing(in_g):
    """Where the length is never steady, or steady at many lengths, nobody can tell the unit by it."""
    rng = np.random.default_rng(3)
    for factor in (rng.uniform(3, 9, 2000), np.repeat(rng.uniform(0.1, 9, 100), 20)):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            in_g.apply(in_g.U0 + factor[:, None] * np.tile(SLOWLY, (10, 1)) @ in_g.K.T)


@pytest.mark.parametrize("unit", ["g", "m/s2"])
def test_arrays_and_tables_are_warned_of(unit, in_g):
    document = json.loads(in_g.to_json())
    document["environment"] = {**(document["environment"] or {}), "gravity_m_s2": 9.81}
    result = tumble.api.result.Result(json.dumps(document))
    off = outputs(result, 9.81)
    for data in (off, dict(zip(("ux", "uy", "uz"), off.T))):
        with pytest.warns(UserWarning, match=r"at rest .* 9\.[78]\d? g: outputs look to be in m/s\^2, the result"):
            result.apply(data, unit=unit)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result.apply(data, unit=unit, outputs_unit="g")
