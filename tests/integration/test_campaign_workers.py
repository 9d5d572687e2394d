"""`tumble campaign`: what tumble-bench finds in one process, whoever does it."""

import json
import os

import pytest
from bench_program import bench as program
from conftest import EXAMPLES
from documents import document_of

pytestmark = pytest.mark.python


def bench(*arguments):
    done = program(*arguments, "--jobs", "1")
    assert done.returncode == 0
    return done.stdout


@pytest.fixture
def nowhere(tmp_path):
    """An environment without a simulated world."""
    (tmp_path / "without").mkdir()
    (tmp_path / "without/_tumble_world.py").write_text("raise ImportError\n")
    return {"PYTHONPATH": os.pathsep.join([str(tmp_path / "without"), *filter(None, [os.environ.get("PYTHONPATH")])])}


def without_speed(text):
    document = json.loads(text)
    del document["speed"]
    return document


def test_runs_are_the_bytes_of_one_process(tumble, tmp_path):
    pytest.importorskip("pyarrow")
    scenario, file = tmp_path / "scenario.txt", tmp_path / "done.parquet"
    scenario.write_text("procedure.samples = 5\n")
    given = ("campaign", "runs", scenario, "--runs", "230", "--seed", "7", "--means")
    plain = bench(str(scenario), "--runs", "230", "--seed", "7", "--means")
    assert len(plain.splitlines()) == 230
    for options in ((), ("--workers", "2", "--resume", file), ("--resume", file)):
        done = tumble(*given, *options)
        assert (done.returncode, done.stdout, done.stderr) == (0, plain, "")


def test_lives_are_the_document_of_one_process(tumble):
    plain = without_speed(bench("--campaign", "130", "--seed", "5"))
    for options in ((), ("--workers", "2")):
        done = tumble("campaign", "lives", "--lives", "130", "--seed", "5", *options)
        document_of(done, "hostile")
        assert (done.returncode, without_speed(done.stdout)) == (0, plain)
    assert plain["table"]["lowest_deg"] < -10.0 and plain["table"]["highest_deg"] >= 360.0


def test_more_runs_go_on_from_fewer(tumble, nowhere, tmp_path):
    pytest.importorskip("pyarrow")
    file = tmp_path / "done.parquet"
    given = ("campaign", "runs", "--resume", file, "--runs")
    assert tumble(*given, "100").returncode == 0
    assert tumble(*given, "200", **nowhere).returncode == 3
    assert tumble(*given, "100", **nowhere).stdout == bench("--runs", "100")


@pytest.mark.parametrize(
    "arguments, complaint",
    [
        (["runs", "--runs", "0"], "--runs: '0' is not a whole number from 1"),
        (["lives", "--seed", str(2**64 - 1), "--lives", "2"], "--lives: the seeds would go beyond 2^64 - 1"),
        (["runs", "missing.txt"], "missing.txt: no such file"),
        (["runs", "paper_stand.toml"], "this cannot be simulated: paper_stand.toml:"),
    ],
)
def test_usage(refused, arguments, complaint):
    assert complaint in refused("campaign", *arguments, cwd=EXAMPLES)


@pytest.mark.parametrize("subject", ["runs", "lives"])
def test_help_fits_eighty_columns(subject, tumble):
    done = tumble("campaign", subject, "--help", COLUMNS="80")
    assert done.returncode == 0 and max(map(len, done.stdout.splitlines())) <= 80
