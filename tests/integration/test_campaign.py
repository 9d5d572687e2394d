"""`tumble campaign`: calibrations and runs with faults depend on their seeds alone, whoever does them; no run breaks
a rule."""

import dataclasses
import os

import pytest
from conftest import EXAMPLES
from documents import document_of

from tumble.world import campaigns
from tumble.world.fault_campaign import FaultCampaign

pytestmark = pytest.mark.python
EXPECTED_SHARE = 0.2  # of the runs, at least, commit a set by themselves


@pytest.fixture
def nowhere(tmp_path):
    """An environment without a simulated world."""
    (tmp_path / "without").mkdir()
    (tmp_path / "without/_tumble_world.py").write_text("raise ImportError\n")
    return {"PYTHONPATH": os.pathsep.join([str(tmp_path / "without"), *filter(None, [os.environ.get("PYTHONPATH")])])}


def lived(tumble, lives, seed, *options):
    """The document, valid by its schema, and what differs every time."""
    done = tumble("campaign", "lives", "--lives", lives, "--seed", seed, *options, timeout=3600)
    document = document_of(done, "hostile")
    return document, document.pop("speed")


def judge(tumble, lives):
    """No violation, and a campaign that deserves the name: every kind of fault and event has come to pass."""
    document, speed = lived(tumble, lives, 1, "--workers", os.cpu_count())
    print(speed, document["sets"])
    assert (document["runs"], document["first_seed"]) == (lives, 1)
    assert document["violated"] == 0 and set(document["violations"].values()) == {0} and document["first"] == []
    assert min(document["faults"].values()) > 0 and min(document["events"].values()) > 0
    assert document["lives_with_commit"] >= EXPECTED_SHARE * lives
    assert document["sets"]["judged"] >= 0.75 * document["sets"]["committed"] and document["flipped_bits"] > 0
    assert document["sets"]["held"] >= 0.02 * lives and document["excuses"]["rewritten"] <= 0.02 * lives
    for state in ("TUMBLE_STATE_FAULT", "TUMBLE_STATE_ABORT"):
        assert document["ends"][state] and "TUMBLE_REASON_NONE" not in document["ends"][state]


@pytest.mark.toolchain
def test_a_thousand_lives(tumble):
    judge(tumble, 1000)


@pytest.mark.full
def test_a_hundred_thousand_lives(tumble):
    judge(tumble, 100_000)


def test_a_run_depends_on_its_seed_alone():
    """What it comes to does not hang on what was run before."""
    campaign = FaultCampaign()
    assert [campaign.run_seed(seed) for seed in (500, 501)] == [FaultCampaign().run_seed(seed) for seed in (500, 501)]


def test_lives_are_the_same_document_by_two(tumble):
    alone, two = (lived(tumble, 130, 5, *options)[0] for options in ((), ("--workers", 2)))
    assert alone == two and alone["table"]["lowest_deg"] < -10.0 and alone["table"]["highest_deg"] >= 360.0


def test_runs_are_the_same_bytes_by_two_and_from_what_was_kept(tumble, tmp_path):
    pytest.importorskip("pyarrow")
    scenario, file = tmp_path / "scenario.txt", tmp_path / "done.parquet"
    scenario.write_text("procedure.samples = 5\n")
    given = ("campaign", "runs", scenario, "--runs", 230, "--seed", 7, "--means")
    plain = tumble(*given).stdout
    assert len(plain.splitlines()) == 230
    for options in (("--workers", 2, "--resume", file), ("--resume", file)):
        done = tumble(*given, *options)
        assert (done.returncode, done.stdout, done.stderr) == (0, plain, "")


def test_more_runs_go_on_from_fewer(tumble, nowhere, tmp_path):
    pytest.importorskip("pyarrow")
    given = ("campaign", "runs", "--resume", tmp_path / "done.parquet", "--runs")
    first = tumble(*given, 100)
    assert first.returncode == 0
    assert tumble(*given, 200, **nowhere).returncode == 3
    assert tumble(*given, 100, **nowhere).stdout == first.stdout


@pytest.mark.parametrize(
    "arguments, complaint",
    [
        (["runs", "--runs", "0"], "--runs: '0' is not a whole number from 1"),
        (["lives", "--lives", "0"], "--lives: '0' is not a whole number from 1"),
        (["lives", "--seed", str(2**64 - 1), "--lives", "2"], "--lives: the seeds would go beyond 2^64 - 1"),
        (["runs", "missing.txt"], "missing.txt: no such file"),
        (["runs", "paper_stand.toml"], "this cannot be simulated: paper_stand.toml:"),
    ],
)
def test_usage(refused, arguments, complaint):
    assert complaint in refused("campaign", *arguments, cwd=EXAMPLES)


def test_a_summary_of_pieces_without_their_time():
    """As an earlier version has kept them."""
    summary = campaigns.Summary(1, 1)
    for part in campaigns.ended(campaigns.Runs((), "", False), 1, 2):
        summary.add(dataclasses.replace(part, cpu_s=None))
    found = summary.document()
    assert (found.runs, found.cpu_s, found.calibrations_per_cpu_s) == (2, None, None)


def test_seeds_beyond_the_last(refused):
    assert "the seeds would go beyond 2^64 - 1" in refused("bench", "--seed", str(2**64 - 1), "--runs", "2")
