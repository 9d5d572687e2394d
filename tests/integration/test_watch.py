"""tumble watch with a source that is played: snapshots, what is told when the source goes, terminal, page, schema."""

import base64
import hashlib
import http.client
import io
import json
import logging
import re
import socket
import time
import urllib.error
import urllib.request
from importlib import resources

import documents
import numpy as np
import pytest
from conftest import ROOT
from msgspec.structs import replace
from played_run import AVERAGING, DONE, FAULT, U0, K, PlayedSource, events
from rich.console import Console

from tumble.documents.bench import Deviation, GravityCheck
from tumble.documents.watch import Gravity, Mean, Snapshot
from tumble.watch import snapshot
from tumble.watch.runs import BenchRun, Follower
from tumble.watch.snapshot import Lost, View, document
from tumble.watch.terminal import Lines, drawn
from tumble.world.border import Border

pytestmark = pytest.mark.python
PLACE = {"mounting": 1, "position": 4, "index": 3, "count": 18, "finished": 3, "attempt": 0,
         "reason": "TUMBLE_REASON_NONE"}
PAGE = resources.files("tumble.watch").joinpath("page.html").read_text(encoding="utf-8")


def shown(snapshot, **more):
    return View("bench", 1, 1e9, snapshot, **more)


def valid(view):
    return documents.valid(json.dumps(document(view), allow_nan=False), "watch")


class Clock:
    def __init__(self):
        self.now = 100.0

    def __call__(self):
        self.now += 1.0
        return self.now


def test_events_of_a_bench_become_snapshots():
    run = BenchRun()
    assert run.snapshot() == Snapshot()
    run({"event": "state", "virtual_s": 1.5, "state": "TUMBLE_STATE_MOVE", **PLACE, "angle_deg": 90.0})
    moving = Snapshot(state="MOVE", mounting=1, position=4, count=18, finished=3, attempt=0, virtual_s=1.5,
                      angle_rad=1.5707963267948966)
    assert run.snapshot() == moving
    run({"event": "angle", "virtual_s": 1.6, "angle_deg": 180.0})
    assert run.snapshot() == replace(moving, virtual_s=1.6, angle_rad=3.141592653589793)
    run({"event": "average", "virtual_s": 2.0, "state": "TUMBLE_STATE_AVERAGE", **PLACE, "angle_deg": None,
         "samples": 5, "wanted": 50, "mean_v": [1.0, 2.0, 3.0], "standard_error_v": [0.1, 0.2, 0.3]})
    mean = Mean(1, 4, 5, 50, (1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    averaging = replace(moving, state="AVERAGE", virtual_s=2.0, angle_rad=None, samples=5, wanted=50, mean=mean)
    assert run.snapshot() == averaging
    run({"event": "question", "kind": "mounting", "virtual_s": 3.0, "mounting": 2})
    assert run.snapshot() == averaging
    run({"event": "state", "virtual_s": 3.0, "state": "TUMBLE_STATE_FAULT", **PLACE, "angle_deg": None,
         "reason": "TUMBLE_REASON_STALL"})
    assert (run.snapshot().state, run.snapshot().reason, run.snapshot().samples) == ("FAULT", "STALL", None)
    assert run.snapshot().mean == mean  # the last one stays


def test_the_document_of_a_run_ends_it():
    run, calls = BenchRun(), []
    run.when_over = lambda: calls.append(run.snapshot().over)
    rows = Deviation(1, 1, "fit", -2e-5), Deviation(1, 2, "fit", 1e-5), Deviation(1, 9, "check", 4e-4)
    run.ended(replace(
        Border(1, [], None).document(), state="TUMBLE_STATE_DONE", reason="TUMBLE_REASON_GRAVITY_CHECK",
        K=np.array(K), U0=np.array(U0), verification=GravityCheck(rows, 4e-4, 2e-5, 4e-4, 3e-4, False),
    ))  # fmt: skip
    assert calls == [True]
    assert run.snapshot() == Snapshot(state="DONE", reason="GRAVITY_CHECK", k_v_per_g=K, u0_v=U0, over=True,
                                      gravity=Gravity(2e-5, 4e-4, 3e-4, False))
    assert run.snapshot().gravity.worst_g == 4e-4


def test_a_source_that_goes_and_comes_again():
    source = PlayedSource(AVERAGING, Lost("node 1 is silent"), Lost("node 1 is silent"), DONE)
    told = []
    follower = Follower(source, "can:vcan0", 1.0, Clock(), [told.append])
    assert follower.view() == View("can:vcan0", 0, 101.0)
    first = follower.ask()
    assert first == View("can:vcan0", 1, 102.0, AVERAGING)
    gone = follower.ask()
    assert gone == View("can:vcan0", 2, 104.0, AVERAGING, 103.0, "node 1 is silent")
    assert follower.ask() == gone  # still since then: nothing new
    again = follower.ask()
    assert again == View("can:vcan0", 3, 105.0, DONE) and follower.is_over()
    assert told == [first, gone, again]
    assert valid(gone)["lost"] == {"since_unix_s": 103.0, "why": "node 1 is silent"}


def test_a_fault_of_the_follower_is_not_swallowed():
    with Follower(PlayedSource(ZeroDivisionError("oops")), "x", 0.01) as follower:
        follower._thread.join(timeout=20)
        with pytest.raises(ZeroDivisionError, match="oops"):
            follower.is_over()


def test_the_document_has_words_and_no_number_that_is_none():
    found = valid(shown(FAULT))["snapshot"]
    assert (found["state"], found["reason"]) == ("FAULT", "STALL")
    assert found["sentence"] == "the axis did not follow its command"
    assert found["remedy"].startswith("The axis does not follow: brake") and found["mean"] is None
    infinite = valid(shown(replace(AVERAGING, angle_rad=float("inf"), temperature_c=float("nan"))))["snapshot"]
    assert infinite["angle_rad"] is None and infinite["temperature_c"] is None
    nothing = valid(View("x", 0, 1.0))
    assert nothing["snapshot"] is None and nothing["lost"] is None
    assert valid(shown(DONE))["snapshot"]["k_v_per_g"] == [list(row) for row in K]


def test_the_states_of_the_stand_are_those_of_the_firmware():
    text = (ROOT / "firmware/include/tumble/stand.h").read_text(encoding="utf-8")
    listed = re.search(r"TUMBLE_STAND_OFFLINE = 0.*?\} tumble_stand_state_t", text, re.DOTALL)[0]
    assert tuple(re.findall(r"TUMBLE_STAND_(\w+)\b", listed)) == snapshot.STANDS
    assert set(snapshot.ANGLE_KNOWN) < set(snapshot.STANDS)


def on_terminal(view):
    console = Console(width=80, file=io.StringIO(), record=True, force_terminal=True, _environ={})
    console.print(drawn(view))
    return console.export_text().splitlines()


def body(lines):
    return [line[2:-1].strip() for line in lines[1:-1]]


def test_a_terminal_of_80_columns_averaging():
    lines = on_terminal(shown(AVERAGING))
    assert {len(line) for line in lines} == {80}
    assert lines[0].startswith("╭") and " tumble watch bench " in lines[0]
    assert "11.9 s of virtual time" in lines[-1]
    assert [re.sub(r"\s+[━╸╺ ]*$", "", line) for line in body(lines)] == [
        "AVERAGE  averaging samples  (run 3)",
        "",
        "place           mounting 1, position 4, 3 of 18 finished",
        "samples         34 of 50 at this position",
        "table angle     +135.000 deg, target +135.000 deg, block 24.5 C",
        "",
        "running mean            x          y          z  34 samples of 1.4",
        "mean, V         +1.371945  -0.049884  -1.360990",
        "its error, V      5.1e-05    4.9e-05    4.7e-05",
        "",
        "last run         K x, V/g   K y, V/g   K z, V/g      U0, V",
        *(f"{axis}                       -          -          -          -" for axis in "xyz"),
        "",
        "gravity check   not made yet; limit 3.0e-04 g",
    ]


def test_a_terminal_of_80_columns_done_fault_lost_and_nothing():
    done = body(on_terminal(shown(DONE)))
    assert "x               -1.995926  +0.024190  +0.039290  +0.011680" in done
    assert "u               2.3e-05    5.5e-05    5.5e-05    1.7e-05" in done
    assert "gravity check   PASS  5.8e-05 g of at most 3.0e-04 g" in done
    fault = body(on_terminal(shown(FAULT)))
    assert fault[0].startswith("FAULT  stopped by a fault")
    assert "! STALL: the axis did not follow its command" in fault
    assert "The axis does not follow: brake, obstacle, current limit." in fault
    assert "! emergency 8611h of drive" in fault
    lost = on_terminal(shown(AVERAGING, lost_since=1e9, why="node 1 does not answer"))
    assert re.search(r"! connection lost since \d\d:\d\d:40: node 1 does not answer; retrying", "\n".join(lost))
    assert {len(line) for line in on_terminal(View("x", 0, 1.0))} == {80}


def test_lines_where_there_is_no_terminal():
    stream = io.StringIO()
    lines = Lines(stream)
    for view in (shown(AVERAGING), shown(replace(AVERAGING, samples=35)), shown(FAULT),
                 shown(FAULT, lost_since=1e9, why="the bus is down")):
        lines(view)
    told = [line[9:] for line in stream.getvalue().splitlines()]
    assert told == [
        "AVERAGE, mounting 1, position 4, 3 of 18 finished",
        "FAULT STALL: the axis did not follow its command, mounting 1, position 5, 4 of 18 finished",
        "connection lost: the bus is down",
    ]


@pytest.fixture
def served():
    """Start a server of what a played source tells: (server, follower)."""
    server = pytest.importorskip("tumble.watch.server", reason="starlette or uvicorn is not installed")
    stack = []

    def start(*answers):
        follower = Follower(PlayedSource(*answers), "played", 0.01)
        stack.append(server.Server(follower.view, "127.0.0.1", 0))
        stack[-1].__enter__()
        return stack[-1], follower

    yield start
    for one in stack:
        one.__exit__()


def test_changes_come_as_server_sent_events(served):
    server, follower = served(AVERAGING, Lost("gone"), DONE)
    stream = events(server.url + "events")
    assert next(stream) == (0, document(follower.view()))
    for state, why in (("AVERAGE", None), ("AVERAGE", "gone"), ("DONE", None)):
        view = follower.ask()
        number, told = next(stream)
        assert number == view.number and told == document(view)
        assert (told["snapshot"]["state"], (told["lost"] or {}).get("why")) == (state, why)
    stream.close()
    with urllib.request.urlopen(server.url + "snapshot.json", timeout=20) as answer:
        assert json.load(answer) == told


def test_a_stream_ends_with_the_server(served):
    server, _ = served(DONE)
    stream = events(server.url + "events")
    next(stream)
    server._server.should_exit = True
    assert list(stream) == []


def status(server, method="GET", path="/", **headers):
    place = re.fullmatch(r"http://(.+):(\d+)/", server.url)
    connection = http.client.HTTPConnection(place[1], int(place[2]), timeout=20)
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    answer.read()
    connection.close()
    return answer.status


def test_the_server_reads_only_and_answers_to_its_own_names_alone(served):
    server, follower = served(DONE)
    assert not server.open_to_others
    assert [status(server, "GET", path) for path in ("/", "/snapshot.json", "/nothing")] == [200, 200, 404]
    for method in ("POST", "PUT", "DELETE", "PATCH"):
        assert [status(server, method, path) for path in ("/", "/snapshot.json", "/events")] == [405] * 3
    port = server.url.rstrip("/").rpartition(":")[2]
    for host in ("localhost", "127.0.0.1", "LOCALHOST", "[::1]"):
        assert status(server, Host=f"{host}:{port}") == 200, host
    for host in ("evil.example", "127.0.0.1.evil.example", "www.localhost"):
        assert status(server, Host=host) == 400, host
    assert follower._source.asked == 0  # who looks on asks the node nothing


def port_of(server):
    return int(server.url.rstrip("/").rpartition(":")[2])


def test_the_head_of_a_stream_ends(served):
    """The connection is free for what is asked next."""
    server, _ = served(DONE)
    connection = http.client.HTTPConnection("127.0.0.1", port_of(server), timeout=20)
    for method, path, code in (("HEAD", "/events", 200), ("GET", "/nothing", 404)):
        connection.request(method, path)
        answer = connection.getresponse()
        assert answer.status == code
        answer.read()
    connection.close()


def said_to(server, request):
    """The first bytes of the answer to what need not be HTTP."""
    with socket.create_connection(("127.0.0.1", port_of(server)), timeout=20) as one:
        one.sendall(request)
        return one.recv(12)


def test_bad_requests_are_not_told_on_stderr(served, capfd, monkeypatch):
    """pytest's own handlers of logging would take what goes to stderr without them."""
    monkeypatch.setattr(logging.getLogger(), "handlers", [])
    server, _ = served(DONE)
    assert said_to(server, b"\x16\x03\x01 no request\r\n\r\n") == b"HTTP/1.1 400"
    upgrade = b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n"
    assert said_to(server, upgrade) == b"HTTP/1.1 200"
    assert capfd.readouterr().err == ""


def test_64_look_on_and_no_more(served):
    server, _ = served(DONE)
    streams = [events(server.url + "events") for _ in range(64)]
    for stream in streams:
        next(stream)
    assert status(server) == 503
    streams.pop().close()
    end = time.monotonic() + 20
    while status(server) != 200:
        assert time.monotonic() < end
    for stream in streams:
        stream.close()


def test_a_port_that_is_taken(served):
    from tumble.errors import UsageError
    from tumble.watch.server import Server

    server, _ = served(DONE)
    port = int(server.url.rstrip("/").rpartition(":")[2])
    with pytest.raises(UsageError, match=f"^--http: cannot listen on 127.0.0.1 port {port}: address already in use$"):
        Server(lambda: None, "127.0.0.1", port)


def test_the_page_needs_nothing_else_and_may_run_its_own_script_alone(served):
    assert not re.search(r"(?:src|href)=[\"'](?!data:,|snapshot\.json)|@import|url\(|https?://|innerHTML", PAGE)
    for wanted in ('aria-live="polite"', 'role="alert"', 'lang="en"', 'name="viewport"', "prefers-color-scheme: dark"):
        assert wanted in PAGE
    server, _ = served(DONE)
    with urllib.request.urlopen(server.url, timeout=20) as answer:
        assert answer.read().decode() == PAGE
        policy = answer.headers["Content-Security-Policy"]
    [script] = re.findall(r"<script>(.*?)</script>", PAGE, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest())
    assert f"script-src 'sha256-{digest.decode()}'" in policy and "default-src 'none'" in policy


@pytest.mark.parametrize(("words", "said"), [
    (("nonsense",), "'nonsense' is neither bench, can:INTERFACE"),
    (("bench", "--http", "8402"), "'8402' is not HOST:PORT, such as 127.0.0.1:8402; SOURCE comes before --http"),
    (("bench", "--http", "::1:70000"), "--http: '::1:70000' is not HOST:PORT"),
    (("can:vcan0", "--every", "0"), "--every: '0' is not a number from 0.1 to 60"),
    (("can:vcan0", "--seed", "3"), "--seed is of SOURCE bench alone"),
    (("can:vcan0", "--pace", "3"), "--pace is of SOURCE bench alone"),
    (("bench", "--pace", "fast"), "'fast'"),
    (("bench", "--interactive"), "--interactive: who watches commands nothing"),
    (("modbus:here",), "the link modbus:here has no HOST:PORT"),
])  # fmt: skip
def test_what_is_refused(refused, words, said):
    assert said in refused("watch", *words)


def test_one_snapshot_of_who_does_not_answer(tumble):
    done = tumble("watch", "modbus:127.0.0.1:1", "--json")
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr == "tumble: modbus:127.0.0.1:1: the gateway cannot be reached\n"
