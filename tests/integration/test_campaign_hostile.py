"""tumble-bench --campaign: hostile lives of the firmware with its memory, held against the simulation's truth."""

import json

import pytest
from bench_program import bench

EXPECTED_SHARE = 0.2  # of the lives, at least, commit a set by themselves


def without_speed(text):
    """The document's bytes up to the one member that differs every time, which is its last."""
    head, mark, tail = text.partition(',"speed":')
    assert mark and tail.endswith("}}\n")
    return head


def judge(lives, seed=1):
    """No violation, and a campaign that deserves the name: every kind of fault and event has come to pass."""
    done = bench("--campaign", lives, "--seed", seed, timeout=3600)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    document = json.loads(done.stdout)
    assert (document["schema"], document["runs"], document["first_seed"]) == ("tumble.hostile/1", lives, seed)
    assert document["violated"] == 0 and set(document["violations"].values()) == {0} and document["first"] == []
    assert min(document["faults"].values()) > 0 and min(document["events"].values()) > 0
    assert document["lives_with_commit"] >= EXPECTED_SHARE * lives
    assert document["sets"]["judged"] >= 0.75 * document["sets"]["committed"] and document["flipped_bits"] > 0
    assert document["sets"]["held"] >= 0.02 * lives and document["excuses"]["rewritten"] <= 0.02 * lives
    for state in ("TUMBLE_STATE_FAULT", "TUMBLE_STATE_ABORT"):
        assert document["ends"][state] and "TUMBLE_REASON_NONE" not in document["ends"][state]
    return document


@pytest.mark.toolchain
def test_a_thousand_lives():
    judge(1000)


@pytest.mark.full
def test_a_hundred_thousand_lives():
    document = judge(100_000)
    print(json.dumps(document["speed"]), json.dumps(document["sets"]))


def test_the_same_bytes_for_any_number_of_processes():
    one, two = (bench("--campaign", 40, "--seed", 77, "--jobs", jobs) for jobs in (1, 2))
    assert without_speed(one.stdout) == without_speed(two.stdout)
    assert one.stderr == two.stderr
    assert json.loads(two.stdout)["speed"]["jobs"] == 2


def test_a_life_is_its_seeds_alone():
    """What a life comes to does not hang on where in a campaign it is."""
    documents = [
        json.loads(bench("--campaign", n, "--seed", seed).stdout) for n, seed in ((2, 500), (1, 500), (1, 501))
    ]
    assert documents[0]["frames"] == documents[1]["frames"] + documents[2]["frames"]
    assert documents[0]["steps"] == documents[1]["steps"] + documents[2]["steps"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--campaign", "0"], "--campaign: must be a whole number from 1 to 1000000000"),
        (["--campaign", "2", "--runs", "2"], "--campaign: takes --seed, --jobs and -v, and nothing else"),
        (["scenario.txt", "--campaign", "2"], "--campaign: takes --seed, --jobs and -v, and nothing else"),
        (["--campaign", "2", "--seed", str(2**64 - 1)], "--campaign: the seeds would go beyond 2^64 - 1"),
        (["-v"], "-v: needs --campaign"),
    ],
)
def test_what_does_not_go_together(options, said):
    done = bench(*options)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"tumble-bench: {said}\n")
