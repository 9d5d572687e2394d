"""tumble watch at runs of the bench: one that it starts, and the folder of one."""

import contextlib
import itertools
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import documents
import pytest
from played_run import events
from simulated_bench import HASTY_STAND, scenario
from test_terminal import on_terminal

from tumble import World, client
from tumble.client.names import STATE_NAMES
from tumble.errors import BenchFault
from tumble.watch.node_run import NodeRun
from tumble.watch.runs import FolderRun
from tumble.watch.snapshot import Lost
from tumble.world import in_process
from tumble.world.border import Border

pytestmark = pytest.mark.python
FAULT = "drive_fault at=1.5 phase=move value=0x7500"


@pytest.fixture
def hasty(tmp_path):
    path = tmp_path / "stand.toml"
    path.write_text(HASTY_STAND)
    return path


def faulty(folder):
    """Options of a run with a fault."""
    return "--scenario", scenario(folder, fault=FAULT)


@contextlib.contextmanager
def page(*options, cwd, **environment):
    """tumble watch bench --http on a free port: (process, url). It has been ended, or is killed."""
    command = [sys.executable, "-m", "tumble", "watch", "bench", "--http", "127.0.0.1:0", *map(str, options)]
    process = subprocess.Popen(command, cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               env={**os.environ, **environment})
    try:
        line = process.stderr.readline()
        found = re.fullmatch(r"tumble: (http://127\.0\.0\.1:\d+/) \(Ctrl-C ends it\)\n", line)
        assert found, line + process.stderr.read()
        yield process, found[1]
    finally:
        process.kill()
        process.communicate()


def ended(process, number=signal.SIGINT):
    """(exit code, standard output, standard error), after a signal when the run is over."""
    told = ""
    while not told.endswith("tumble: the run is over; the page stays until Ctrl-C\n"):
        line = process.stderr.readline()
        assert line, told
        told += line
    process.send_signal(number)
    out, err = process.communicate(timeout=60)
    return process.returncode, out, told + err


def until_over(url):
    """Every snapshot that is told, up to the last."""
    told = []
    for number, found in events(url + "events"):
        documents.valid(json.dumps(found), "watch")
        assert not told or number > told[-1][0]
        told.append((number, found))
        if found["snapshot"] is not None and found["snapshot"]["over"]:
            return [one["snapshot"] for _, one in told if one["snapshot"] is not None]
    return pytest.fail("the stream has ended before the run")


class PlayedClock:
    """In the place of the module time: a sleep passes at once."""

    now_s = 0.0

    def monotonic(self):
        return self.now_s

    def sleep(self, seconds):
        self.now_s += seconds


def test_the_events_of_a_run_with_a_pace_tell_the_angle(monkeypatch):
    monkeypatch.setattr(in_process, "time", PlayedClock())
    found = []
    assert not in_process.Run(Border(1, ["procedure.samples = 10"], None), found.append, pace=1.0).to_its_end()
    turning = [event for event in found if event["event"] == "angle"]
    assert len(turning) > 50 and all(set(event) == {"event", "virtual_s", "angle_deg"} for event in turning)
    times = [event["virtual_s"] for event in turning]
    assert all(later - sooner > 0.0999 for sooner, later in itertools.pairwise(times))
    averages = [event for event in found if event["event"] == "average"]
    rests = {(event["mounting"], event["position"]): event["angle_deg"] for event in averages}
    assert [rests[1, position] for position in range(1, 10)] == pytest.approx([45 * n for n in range(9)], abs=0.05)
    before_homing = [event for event in found if event["event"] == "state"][:4]
    assert [event["angle_deg"] for event in before_homing] == [None] * 4


@pytest.mark.toolchain
def test_a_run_is_watched_in_lines_and_is_the_run_that_nobody_watches(tumble, hasty, tmp_path):
    options = ["--stand", hasty, "--seed", 7]
    alone = tumble("bench", *options, "--out", tmp_path / "alone")
    watched = tumble("watch", "bench", *options, "--pace", 1000, "--out", tmp_path / "watched")
    assert (watched.returncode, watched.stdout) == (alone.returncode, alone.stdout) == (0, alone.stdout)
    for name in ("run.csv", "bus.log", "result.json"):
        assert (tmp_path / "alone" / name).read_bytes() == (tmp_path / "watched" / name).read_bytes(), name
    *_, done, folder = watched.stderr.splitlines()
    assert done[9:] == "DONE, mounting 2, position 9, 18 of 18 finished" and folder.startswith("run folder: ")


@pytest.mark.toolchain
def test_a_screen_ends_before_the_result_is_printed(hasty, tmp_path):
    command = [sys.executable, "-m", "tumble", "watch", "bench", "--stand", str(hasty), "--pace", "50"]
    shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", on_terminal([*command, "--out", str(tmp_path / "run")]))
    screens, _, result = shown.rpartition("run folder: ")
    last = screens[screens.rindex("╭") :]
    assert "│ DONE  finished" in last and "gravity check   PASS" in last and last.rstrip().endswith("╯")
    assert {len(line) for line in last.strip().splitlines()} == {80}
    assert "PASS, assuming a square seat" in result and "╭" not in result


@pytest.mark.toolchain
def test_a_page_shows_a_run_to_its_end_and_stays(hasty, tmp_path):
    pytest.importorskip("uvicorn", reason="uvicorn is not installed")
    with page("--stand", hasty, "--pace", 20, "--out", tmp_path / "run", "--seed", 7, cwd=tmp_path) as (process, url):
        told = until_over(url)
        assert next(events(url + "events"))[1]["snapshot"] == told[-1]  # who comes late sees it too
        code, out, _ = ended(process)
    assert code == 0 and "PASS" in out
    assert {one["state"] for one in told} - {None} <= set(STATE_NAMES)  # how many it has seen, the machine decides
    finished = [one["finished"] for one in told if one["finished"] is not None]
    assert finished == sorted(finished) and finished[-1] == 18
    assert (told[-1]["mean"]["mounting"], told[-1]["mean"]["position"]) == (2, 9)
    assert told[-1]["angle_rad"] is not None
    result = json.loads((tmp_path / "run/result.json").read_text())
    assert (told[-1]["k_v_per_g"], told[-1]["u0_v"]) == (result["K"], result["U0"])
    assert told[-1]["gravity"]["max_fit_g"] == result["verification"]["max_abs_delta_g_g"]
    assert told[-1]["gravity"]["passed"] is True


@pytest.mark.toolchain
def test_a_page_shows_a_fault_with_its_remedy(hasty, tmp_path):
    pytest.importorskip("uvicorn", reason="uvicorn is not installed")
    run = tmp_path / "run"
    with page("--stand", hasty, "--pace", 100, *faulty(tmp_path), "--out", run, cwd=tmp_path) as (process, url):
        last = until_over(url)[-1]
        code, out, err = ended(process, signal.SIGTERM)
    assert (code, out) == (BenchFault.exit_code, "")
    assert (last["state"], last["reason"], last["k_v_per_g"]) == ("FAULT", "DRIVE_FAULT", None)
    assert last["remedy"].startswith("2004h:3 is the drive's own error code") and last["finished"] == 4
    assert "drive reported a fault" in err and (run / "fault.json").is_file()


def test_over_a_whole_run_the_bus_sees_uploads_alone(hasty):
    """All that a watcher puts on the bus; it sees the run to its end."""
    pytest.importorskip("canopen", reason="python-canopen is not installed")
    from can import CanError

    from tumble.world.virtual_bus import time_of

    world, seen = World(7, stand=hasty), []
    with world.bus() as bus, time_of(bus), pytest.raises((CanError, Lost)):
        source = NodeRun("the world", lambda _: client.open_link(bus))
        while True:
            seen.append(source.snapshot())
            time.sleep(0.1)
    assert world.end == "done" and {one.mounting for one in seen} >= {1, 2} and seen[-1].finished >= 17
    sent = [(frame.id, frame.data[0]) for frame in world.frames() if frame.sender == "guest"]
    assert len(sent) > 20 and set(sent) <= {(0x601, command) for command in (0x40, 0x60, 0x70, 0x80)}


def test_bad_input_ends_a_page_at_once(tumble, tmp_path):
    pytest.importorskip("uvicorn", reason="uvicorn is not installed")
    wrong = "--stand", tmp_path / "none.toml"
    done = tumble("watch", "bench", "--http", "127.0.0.1:0", *wrong, "--out", tmp_path / "run")
    assert (done.returncode, done.stdout) == (2, "") and done.stderr.endswith("none.toml: no such file or folder\n")


@pytest.mark.toolchain
def test_the_folder_of_a_run(tumble, hasty, tmp_path):
    run = tmp_path / "run"
    assert tumble("bench", "--stand", hasty, "--out", run).returncode == 0
    done = tumble("watch", run, "--json")
    seen = documents.document_of(done, "watch")["snapshot"]
    result = json.loads((run / "result.json").read_text())
    assert (seen["state"], seen["finished"], seen["over"], seen["k_v_per_g"]) == ("DONE", 18, True, result["K"])
    shown = tumble("watch", run)
    assert (shown.returncode, shown.stderr) == (0, "") and " DONE, " in shown.stdout


@pytest.mark.toolchain
def test_the_folder_of_a_run_that_goes_on(tumble, hasty, tmp_path):
    """Its log is played again, piece by piece, where the bench writes it."""
    run, stage = tmp_path / "run", tmp_path / ".again.part/bench"
    assert tumble("bench", "--stand", hasty, "--out", run).returncode == 0
    log = (run / "bus.log").read_bytes()
    stage.mkdir(parents=True)
    watched = FolderRun(tmp_path / "again")
    assert watched.is_there()
    with pytest.raises(Lost, match=r"there is no bus\.log in the folder, or none yet"):
        watched.snapshot()
    seen = []
    with open(stage / "bus.log.part", "wb", buffering=0) as growing:
        for start in range(0, len(log), 1000):  # lines are cut in two
            growing.write(log[start : start + 1000])
            seen.append(watched.snapshot())
    states = {one.state for one in seen}
    assert states >= {"MOVE", "AVERAGE"} and states & {"SOLVE", "VERIFY"} and not any(one.over for one in seen)
    times = [one.virtual_s for one in seen]
    assert times == sorted(times) and math.isclose(times[-1], float(log.splitlines()[-1].split()[0].strip(b"()")))
    shutil.move(run, tmp_path / "again")
    last = watched.snapshot()
    assert (last.state, last.over, last.finished) == ("DONE", True, 18) and last.k_v_per_g is not None


def test_a_folder_with_a_result_that_is_none(tumble, tmp_path):
    (tmp_path / "result.json").write_text("[1")
    done = tumble("watch", tmp_path, "--json")
    assert done.returncode == 3 and re.fullmatch(r"tumble: .*: result\.json cannot be read: .*\n", done.stderr)


NO_RESULTS = (
    [], {}, {"verification": {}}, {"K": 5}, {"K": [[1, 2], [3, 4]]}, {"K": None, "U0": ["a", "b", "c"]}, {"state": "X"},
    {"state": 7, "reason": "TUMBLE_REASON_NONE"}, {"K": None, "verification": 1},
    {"K": None, "verification": {"delta_g_g": [{"use": "other", "delta_g_g": 1}], "limit_g": 1, "pass": True}},
    {"K": None, "verification": {"delta_g_g": [], "limit_g": "x", "pass": True}},
)  # fmt: skip


@pytest.mark.parametrize(
    ("schema", "file"), [("result", "result.json"), ("bench", "fault.json"), ("node", "fault.json")]
)
@pytest.mark.parametrize("damaged", NO_RESULTS[1:], ids=json.dumps)
def test_a_damaged_key_is_named(damaged, schema, file, tmp_path):
    (tmp_path / "bus.log").touch()
    (tmp_path / file).write_text(json.dumps({"schema": f"tumble.{schema}/1", **damaged}))
    with pytest.raises(Lost, match=rf"^{file}: not a result of schema tumble\.{schema}/1: .+$"):
        FolderRun(tmp_path).snapshot()


@pytest.mark.parametrize("damaged", NO_RESULTS, ids=json.dumps)
def test_a_damaged_result_is_one_line(damaged, tmp_path):
    (tmp_path / "bus.log").touch()
    (tmp_path / "result.json").write_text(json.dumps(damaged))
    with pytest.raises(Lost, match=r"^result\.json is not a result of a run$"):
        FolderRun(tmp_path).snapshot()


def test_a_damaged_result_is_no_fault_in_tumble(tumble, tmp_path):
    (tmp_path / "bus.log").touch()
    (tmp_path / "fault.json").write_text('{"state": "X"}')
    done = tumble("watch", tmp_path, "--json")
    assert (done.returncode, done.stderr) == (3, f"tumble: {tmp_path}: fault.json is not a result of a run\n")
