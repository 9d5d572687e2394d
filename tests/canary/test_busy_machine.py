"""A test in real time is run again where the machine was busy, and only there; what fails every time has failed."""
import os
import subprocess
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest
import realbus
import runner
from conftest import ROOT

PLUGIN = ROOT / "tests/lib"
PLANTED = """
import threading, time, busy_machine, pytest
def tries(more=[0]):
    more[0] += 1
    return more[0]
@pytest.mark.real_time
def test_planted(pytestconfig):
    number = tries()
    seen = pytestconfig.stash[busy_machine.WATCH].seen
    if {busy}:
        threading.Timer({told_after}, lambda: seen.append((time.monotonic(), "planted"))).start()
        time.sleep({sleeps})
    assert number >= {passes_at}
"""


def outcome_of(tmp_path, busy, passes_at, *path, told_after=0.0, sleeps=0.1):
    """Of one planted test, by the runner that the stages use; the watch tells so long after its begin."""
    given = {"busy": busy, "passes_at": passes_at, "told_after": told_after, "sleeps": sleeps}
    (tmp_path / "test_planted.py").write_text(PLANTED.format(**given))
    (tmp_path / "conftest.py").write_text("pytest_plugins = ['busy_machine']\n")
    log = runner.Log(tmp_path / "log", 60)
    searched = ":".join(map(str, [*path, PLUGIN]))
    environment = {"TUMBLE_WATCH": "no", "PYTHONPATH": searched}  # this machine is not watched
    return runner.pytest(log, "-p", "no:cacheprovider", f"--rootdir={tmp_path}", str(tmp_path), env=environment)


def test_one_that_passes_does_not_wait_for_the_machine_to_rest(tmp_path):
    rests = tmp_path / "rests"
    rest = f"busy_machine.rest = lambda watch: open({str(rests)!r}, 'a').write('x')\n"
    found = f"import sys; sys.path.insert(0, {str(PLUGIN)!r}); import busy_machine\n"
    (tmp_path / "sitecustomize.py").write_text(found + rest)
    for passes_at, times in ((1, 0), (2, 1)):
        outcome = outcome_of(tmp_path, True, passes_at, tmp_path)
        assert (outcome.passed, rests.stat().st_size if rests.exists() else 0) == (1, times)


@pytest.mark.parametrize("busy, passes_at, passed, again",
                         [(True, 1, 1, 0), (True, 2, 1, 1), (False, 2, 0, 0), (True, 9, 0, 3)])
def test_only_a_busy_machine_gives_another_try(tmp_path, busy, passes_at, passed, again):
    outcome = outcome_of(tmp_path, busy, passes_at)
    assert (outcome.passed, outcome.failed, len(outcome.again)) == (passed, 1 - passed, again)
    assert all("the machine was busy (planted): " in told for told in outcome.again)


def test_one_that_fails_at_once_waits_for_what_the_watch_says_of_that_time(tmp_path):
    outcome = outcome_of(tmp_path, True, 2, told_after=0.3, sleeps=0.0)
    assert (outcome.passed, outcome.failed, len(outcome.again)) == (1, 0, 1)


def test_a_busy_machine_is_seen():
    """More work than processors, and the watch says so; it ends, and the watch is silent."""
    code = "import sys; sys.path.insert(0, sys.argv[1]); import busy_machine as b, time; w = b.Watch(); w.start(); " \
           "time.sleep(4); print(len(w.seen))"
    loops = [subprocess.Popen(["sh", "-c", "while :; do :; done"]) for _ in range(2 * os.cpu_count())]
    try:
        time.sleep(0.5)
        seen = subprocess.run(["python3", "-c", code, PLUGIN], capture_output=True, text=True, check=True).stdout
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()
    assert int(seen) >= 2


@pytest.mark.parametrize("busy, alone, code, again", [(True, "passes", 0, 1), (True, "fails", 1, 1), (False, "", 1, 0)])
def test_what_failed_in_a_busy_guest_is_run_once_more_alone(tmp_path, monkeypatch, busy, alone, code, again):
    """And what failed in one that was not busy is not."""
    asked = []

    def guest(whole, chosen):
        asked.append(chosen)
        is_alone = "::" in chosen[0]
        passes = alone == "passes" if is_alone else "test_load" not in chosen[0]
        told = '<properties><property name="ran again" value="busy"/></properties>' if busy and not is_alone else ""
        name = "test_load" if is_alone else Path(chosen[0]).stem
        failure = "" if passes else '<failure message="planted"/>'
        case = f'<testcase classname="{name}" name="test_planted">{told}{failure}</testcase>'
        whole.append(ElementTree.fromstring(f"<testsuite>{case}</testsuite>"))
        return 0 if passes else 1

    monkeypatch.setattr(realbus, "in_uml", guest)
    monkeypatch.setattr(realbus.os, "cpu_count", lambda: 1)
    files = len(list((ROOT / "tests/realbus").glob("test_*.py")))
    assert realbus.in_machines(tmp_path / "report.xml", ["--full"]) == code
    assert asked[files:] == [["tests/realbus/test_load.py::test_planted", "--full"]] * again
    outcome = runner.read_junit(tmp_path / "report.xml")
    assert (outcome.failed, outcome.passed) == (code, files - code)
    assert sum("run alone" in told for told in outcome.again) == again


def test_a_guest_that_could_not_run_its_tests_has_failed(tmp_path, monkeypatch):
    """Though no test in its report did."""
    monkeypatch.setattr(realbus, "in_uml", lambda whole, chosen: realbus.NO_END)
    assert realbus.in_machines(tmp_path / "report.xml", []) == realbus.NO_END
