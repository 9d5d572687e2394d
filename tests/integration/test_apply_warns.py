"""What `tumble apply` says of the result that it applies."""

import json

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
    assert told[0] == failed and "assuming" in told[1]


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
