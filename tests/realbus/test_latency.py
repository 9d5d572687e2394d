"""The benchmark of the node's latency: a delay that is planted shows in it, and so does an answer that is missing."""

import signal
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path

import pytest
from processes import wait_until

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests/benchmark"))

import latency
import latency_run

REQUESTS, WAITING, HELD_S = 120, 60, 0.5
SETTINGS = {"requests": REQUESTS, "period_ms": 3.0, "busy": 1, "flood": 200}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With the programs ask and echo."""
    made = tmp_path_factory.mktemp("latency")
    latency.build(made)
    return made


@pytest.fixture
def averaging(folder):
    """(ask both, node, interface of the echo), while the node averages."""
    with ExitStack() as stack:
        bus, aside = (latency_run.interface(stack, name) for name in (latency_run.BUS, latency_run.ASIDE))
        path = latency_run.scenario(folder, **latency_run.LONG)
        node, _ = latency_run.start_programs(stack, folder, path, bus, aside)
        yield lambda: latency_run.ask(SETTINGS, folder, bus, aside), node, aside


def test_a_node_that_is_stopped_shows_in_the_percentiles(averaging):
    """It is asked on while it stands still: half of the requests were there before the last 0.5 s of that, so at least
    half of the latencies are 0.5 s or more. A client that waits for its answers would have one of them."""
    ask, node, aside = averaging
    before = aside.frames()
    node.send_signal(signal.SIGSTOP)
    with ThreadPoolExecutor() as threads:
        asking = threads.submit(ask)
        wait_until(lambda: aside.frames() - before >= 2 * WAITING)  # the echo's requests and answers
        time.sleep(HELD_S)
        node.send_signal(signal.SIGCONT)
        pairs = asking.result()["node"]
    assert sum(each >= 1e6 * HELD_S for each in latency.latencies_us(pairs)) >= WAITING
    figures = latency.figures(pairs)
    assert figures["lost"] == 0 and 1e6 * HELD_S <= figures["90 %"] <= figures["max"]


def test_answers_that_never_come_are_lost(averaging):
    ask, node, _ = averaging
    node.kill()
    pairs = ask()
    assert latency.figures(pairs["node"]) == dict.fromkeys(latency.SHARES) | {"lost": REQUESTS}
    assert latency.figures(pairs["echo"])["lost"] == 0


def test_every_load_at_once(folder):
    """Each request is answered, in the order of asking, and after it was asked."""
    found = latency_run.measure({**SETTINGS, "conditions": ["busy,bus-load,fifo"]}, folder)
    (condition,) = found["conditions"]
    for name in latency.PROGRAMS:
        pairs = condition[name]
        assert len(pairs) == REQUESTS and pairs == sorted(pairs) and all(asked < answered for asked, answered in pairs)
    assert condition["ended_by"] is None and condition["samples_lost"] == 0
    assert condition["frames_per_s"] > 0 and 0 < condition["bus_load"] < 1
    assert (folder / "began").exists() and (folder / "ended").exists()
