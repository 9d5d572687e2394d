"""Percentiles and tables of tools/benchmark latency, on pairs of stamps that were made up."""

import random
import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests/benchmark"))

import latency

OUTSIDE = {"taken_s": 9.0, "processors": 2, "idle": 0.25, "others": 0.5}


def pairs(*latencies_us):
    """Asked 4 ms apart; None is never answered."""
    asked = [1_700_000_000_000_000_000 + 4_000_000 * number for number in range(len(latencies_us))]
    return [[ns, 0 if us is None else ns + round(1e3 * us)] for ns, us in zip(asked, latencies_us)]


def found(node, echo):
    """One condition, as a measurement leaves it."""
    condition = {"name": "busy,bus-load,fifo", "requests": len(node), "frames_per_s": 1234.0, "bus_load": 0.3,
                 "samples_lost": 3, "kernel_dropped": 1234, "ended_by": "BUS", "node": node, "echo": echo}
    return {"kernel": "6.1", "processors": 1, "inside_s": 7.0, "outside": OUTSIDE, "conditions": [condition]}


@pytest.mark.parametrize(("count", "expected"), [
    (1, {500: 1, 900: 1, 990: 1, 999: 1, 1000: 1}),
    (2, {500: 1, 501: 2, 1000: 2}),
    (10, {500: 5, 900: 9, 901: 10, 990: 10}),
    (1000, {500: 500, 900: 900, 990: 990, 999: 999, 1000: 1000}),
    (1001, {500: 501, 900: 901, 990: 991, 999: 1000, 1000: 1001}),
])
def test_a_percentile_is_the_least_that_so_many_do_not_exceed(count, expected):
    ordered = list(range(1, count + 1))
    assert {share: latency.percentile(ordered, share) for share in expected} == expected


def test_a_percentile_by_its_definition():
    """Against the definition itself, in whole numbers, of values with repeats."""
    rng = random.Random(3)
    for _ in range(200):
        ordered = sorted(rng.randrange(20) for _ in range(rng.randrange(1, 60)))
        share = rng.randrange(1, 1001)
        least = min(one for one in ordered if 1000 * sum(each <= one for each in ordered) >= share * len(ordered))
        assert latency.percentile(ordered, share) == least


def test_a_tenth_that_is_late_shows_from_its_percentile_on():
    late = [100.0] * 899 + [5000.0] * 101
    assert latency.figures(pairs(*late)) == {
        "50 %": 100.0, "90 %": 5000.0, "99 %": 5000.0, "99.9 %": 5000.0, "max": 5000.0, "lost": 0}
    late = [100.0] * 990 + [5000.0] * 9 + [7000.5]
    assert latency.figures(pairs(*late)) == {
        "50 %": 100.0, "90 %": 100.0, "99 %": 100.0, "99.9 %": 5000.0, "max": 7000.5, "lost": 0}


def test_an_answer_that_is_missing_is_later_than_all_others():
    assert latency.figures(pairs(*[None] * 2, *[40.0] * 98)) == {
        "50 %": 40.0, "90 %": 40.0, "99 %": None, "99.9 %": None, "max": None, "lost": 2}


def test_the_table_has_ratios_and_80_columns():
    measured = found(pairs(*[300.0] * 90, *[9000.0] * 9, None), pairs(*[100.0] * 99, 9876543.0))
    lines = list(latency.table_lines(measured))
    assert max(map(len, lines)) <= 80
    assert lines[1].split() == ["busy,bus-load,fifo", "node", "300", "300", "9,000", "none", "none", "1"]
    assert lines[2].split() == ["echo", "100", "100", "100", "9,876,543", "9,876,543", "0"]
    assert lines[3].split() == ["ratio", "3.0", "3.0", "90.0"]
    assert [line.strip() for line in lines[-2:]] == [
        "lost by the node: 3 samples, 1234 frames", "the node's run ended early: BUS"]
    assert "its clock left out 2 of 9 s" in lines


def test_the_page_has_the_same_cells():
    page = list(latency.page_lines(found(pairs(250.0, 350.0), pairs(100.0, 100.0))))
    assert page[2:5] == ["| busy,bus-load,fifo | node | 250 | 350 | 350 | 350 | 350 | 0 |",
                        "|  | echo | 100 | 100 | 100 | 100 | 100 | 0 |",
                        "|  | ratio | 2.5 | 3.5 | 3.5 | 3.5 | 3.5 |  |"]
    assert "of whose time others had 50%, and 25% was idle" in page


@pytest.mark.parametrize("words", [["--requests", "0"], ["--period-ms", "-1"], ["--busy", "-1"], ["--flood", "0"],
                                   ["--conditions", "none"],
                                   ["--requests", "many"], ["--json", "--table"]])
def test_an_option_that_makes_no_sense_is_refused(words, capsys):
    with pytest.raises(SystemExit) as refused:
        latency.parse(words)
    assert refused.value.code == 2 and words[0] in capsys.readouterr().err
