"""When, by what and from what a result was made."""

import hashlib
import json
import re
from datetime import datetime, timedelta, timezone

import pytest
from conftest import EXAMPLES
from documents import document_of

from tumble import __version__
from tumble.solving.result import created

pytestmark = pytest.mark.python


def test_a_result_says_when_by_what_and_from_what(tumble):
    before = datetime.now(timezone.utc) - timedelta(seconds=1)
    result = document_of(tumble("solve", "paper_stand.csv", "--unit", "V", "--json", cwd=EXAMPLES))
    written = datetime.strptime(result["created"], "%Y-%m-%dT%H:%M:%SZ").replace(tzinfo=timezone.utc)
    assert before <= written <= datetime.now(timezone.utc)
    assert result["tumble"] == __version__
    assert result["run_sha256"] == hashlib.sha256((EXAMPLES / "paper_stand.csv").read_bytes()).hexdigest()


@pytest.mark.parametrize("command", ["solve", "bench"])
def test_the_environment_sets_the_date(command, tumble, tmp_path):
    arguments = [EXAMPLES / "paper_stand.csv"] if command == "solve" else ["--out", tmp_path / "run"]
    done = tumble(command, *arguments, "--json", SOURCE_DATE_EPOCH="1700000000")
    assert done.returncode == 0 and json.loads(done.stdout)["created"] == "2023-11-14T22:13:20Z"


def test_a_run_in_virtual_time_has_no_date(tumble, tmp_path):
    result = json.loads(tumble("bench", "--out", tmp_path / "run", "--json").stdout)
    assert result["created"] is None
    assert result["run_sha256"] == hashlib.sha256((tmp_path / "run/run.csv").read_bytes()).hexdigest()


@pytest.mark.parametrize("told", ["", "now", "-1", "1.5", "253402300800", "\u0661"])
def test_another_date_is_refused(told, tumble, tmp_path):
    done = tumble("solve", EXAMPLES / "paper_stand.csv", "--out", tmp_path / "result.json", SOURCE_DATE_EPOCH=told)
    assert (done.returncode, done.stdout, list(tmp_path.iterdir())) == (2, "", [])
    assert re.fullmatch(r"tumble: SOURCE_DATE_EPOCH: .* is not a whole number of seconds since 1970\n", done.stderr)


def test_the_last_second_is_taken(monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "253402300799")
    assert created(clock=False) == "9999-12-31T23:59:59Z"
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    assert created(clock=False) is None
