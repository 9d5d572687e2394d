"""tools/test does not hide a failure, nor count as passed what was skipped."""
import io
import re
import shutil
import threading
import time

import pytest
import runner
import stages
from conftest import ROOT, run

PYTHON = stages.PYTHON


def stage(function, name="canary", needs=()):
    return runner.Stage(name, "planted", function, needs)


def outcome_of(tmp_path, capsys, *planted, missing=None):
    """(exit status, what was printed) of a run of planted stages."""
    status = runner.run_stages(planted, tmp_path / "logs", missing, timeout_s=60)
    return status, capsys.readouterr().out


def pytest_stage(tmp_path, source):
    (tmp_path / "test_planted.py").write_text(source)
    return stage(lambda log: runner.pytest(log, "-p", "no:cacheprovider", f"--rootdir={tmp_path}", str(tmp_path)))


PASSING = "def test_a(): pass\n"
FAILING = PASSING + "def test_b(): assert 1 == 2, 'planted'\n"
SKIPPING = PASSING + "import pytest\ndef test_b(): pytest.skip('no moon tonight')\n"


@pytest.mark.parametrize("source, status, last", [
    (PASSING, 0, "1 passed, 0 failed, 0 skipped"),
    (FAILING, 1, "1 passed, 1 failed, 0 skipped"),
    (SKIPPING, 0, "1 passed, 0 failed, 1 skipped"),
    ("import nowhere_to_be_found\n", 1, "0 passed, 1 failed, 0 skipped"),
    ("def helper(): pass\n", 1, "0 passed, 1 failed, 0 skipped"),
    (PASSING + "import os\ndef test_b(): os._exit(0)\n", 1, "0 passed, 1 failed, 0 skipped"),
])
def test_pytest_is_believed(tmp_path, capsys, source, status, last):
    result, text = outcome_of(tmp_path, capsys, pytest_stage(tmp_path, source))
    assert (result, text.splitlines()[-1]) == (status, last)


def test_a_failure_shows_the_end_of_its_log(tmp_path, capsys):
    _, text = outcome_of(tmp_path, capsys, pytest_stage(tmp_path, FAILING))
    assert re.search(r"^FAILED   canary", text, re.MULTILINE) and "assert 1 == 2" in text


def test_the_tests_that_failed_are_named_at_the_end(tmp_path, capsys):
    _, text = outcome_of(tmp_path, capsys, pytest_stage(tmp_path, FAILING), stage(lambda log: runner.Outcome(passed=3)))
    assert re.search(r"\nFAILED: canary: test_b: AssertionError: planted\nassert 1 == 2\n\n4 passed", text)


def test_what_was_asserted_is_shown_however_much_was_said_of_it(tmp_path, capsys):
    """A test that has the output of a program to tell, before what it wanted of it; and lines without an end."""
    said = "print('z' * 9000)\n    assert left == 17, 'first ' + 'chatter ' * 900 + 'last'"
    _, text = outcome_of(tmp_path, capsys, pytest_stage(tmp_path, f"def test_a():\n    left = 16\n    {said}\n"))
    told = text.partition("\nFAILED: ")[2]
    assert told.startswith("canary: test_a: AssertionError: first chatter ") and " characters ...]\n" in told
    assert "last\nassert 16 == 17\n" in told and len(told) < 2200
    assert max(map(len, text.partition("\nFAILED: ")[0].splitlines())) <= 4 + runner.TAIL_CHARACTERS


def test_a_skipped_test_gives_its_reason(tmp_path, capsys):
    _, text = outcome_of(tmp_path, capsys, pytest_stage(tmp_path, SKIPPING))
    assert "SKIPPED: no moon tonight" in text


@pytest.mark.parametrize("code, verdict, counts", [
    ("pass", "passed", "1 passed, 0 failed, 0 skipped"),
    ("print('no such tool'); raise SystemExit(77)", "SKIPPED", "0 passed, 0 failed, 1 skipped"),
    ("raise SystemExit(1)", "FAILED", "0 passed, 1 failed, 0 skipped"),
])
def test_a_gate_is_believed(tmp_path, capsys, code, verdict, counts):
    _, text = outcome_of(tmp_path, capsys, stage(lambda log: runner.gate(log, [PYTHON, "-c", code])))
    assert re.search(rf"^{verdict} +canary", text, re.MULTILINE)
    assert text.splitlines()[-1] == counts
    assert ("SKIPPED: no such tool" in text) == (verdict == "SKIPPED")


def test_what_could_not_be_installed_skips_its_stage(tmp_path, capsys):
    def never(log):
        raise AssertionError("a stage ran without what it needs")

    passing = stage(lambda log: runner.Outcome(passed=3), "other")
    status, text = outcome_of(tmp_path, capsys, stage(never, needs=("Unity",)), passing,
                              missing={"Unity": "no network"})
    assert status == 0
    assert "SKIPPED: Unity is not installed (no network)" in text
    assert text.splitlines()[-1] == "3 passed, 0 failed, 1 skipped"


def test_nothing_but_skips_is_no_success(tmp_path, capsys):
    status, text = outcome_of(tmp_path, capsys, stage(lambda log: runner.skipped("no tool")))
    assert (status, text.splitlines()[-1]) == (1, "0 passed, 0 failed, 1 skipped")


def test_light_neighbours_run_side_by_side_and_are_told_of_in_their_order(tmp_path, capsys):
    """Each waits for the other; without it the wait fails, and so does the stage."""
    both = threading.Barrier(2, timeout=30)

    def meets(_log):
        both.wait()
        return runner.Outcome(passed=1)

    def fails_after_it_met(_log):
        both.wait()
        return runner.Outcome(failed=1)

    status, text = outcome_of(tmp_path, capsys, runner.Stage("one", "planted", meets, light=True),
                              runner.Stage("other", "planted", fails_after_it_met, light=True),
                              stage(lambda _log: runner.Outcome(passed=both.n_waiting == 0), "alone"))
    assert (status, text.splitlines()[-1]) == (1, "2 passed, 1 failed, 0 skipped")
    assert re.findall("^(?:passed|FAILED) +([a-z]+)", text, re.MULTILINE) == ["one", "other", "alone"]


def test_a_heavy_stage_runs_alone():
    planted = [runner.Stage(name, "planted", print, light=name.islower()) for name in "abCDe"]
    assert [[one.name for one in group] for group in runner.side_by_side(planted)] == [["a", "b"], ["C"], ["D"], ["e"]]


def test_a_command_that_hangs_or_is_missing_fails(tmp_path):
    log = runner.Log(tmp_path / "hang.log", timeout_s=0.2)
    assert log.run(PYTHON, "-c", "import time; time.sleep(30)") == 1 and "no end after 0.2 s" in log.text()
    assert log.run("a-command-that-nobody-has") == 1 and "No such file" in log.text()


CTEST = {
    "3 Tests 0 Failures 0 Ignored": (0, (3, 0, 0)),
    "3 Tests 1 Failures 1 Ignored": (1, (1, 1, 1)),
    "died before its summary": (134, (0, 1, 0)),
}


@pytest.mark.parametrize("said", CTEST)
def test_ctest_is_believed(tmp_path, said):
    status, counts = CTEST[said]
    program = tmp_path / "program.sh"
    program.write_text(f"#!/bin/sh\necho '{said}'\nexit {status}\n")
    program.chmod(0o755)
    (tmp_path / "CTestTestfile.cmake").write_text(f"add_test(planted {program})\n")
    outcome = runner.ctest(runner.Log(tmp_path / "ctest.log", 60), tmp_path)
    assert (outcome.passed, outcome.failed, outcome.skipped) == counts


def test_ctest_without_tests_fails(tmp_path):
    (tmp_path / "CTestTestfile.cmake").write_text("")
    assert runner.ctest(runner.Log(tmp_path / "ctest.log", 60), tmp_path).failed == 1


def test_an_unknown_stage_or_option_is_a_usage_error():
    assert run("tools/test", "--fool").returncode == 2
    result = run(PYTHON, "tools/stages.py", "no-such-stage")
    assert (result.returncode, result.stdout) == (2, "test: no such stage: no-such-stage\n")


def test_the_help_lists_every_stage():
    result = run("tools/test", "--help")
    assert result.returncode == 0 and result.stdout.startswith("usage: tools/test [--real|--full] [STAGE...]")
    listed = [line.split()[0] for line in result.stdout.splitlines() if line.startswith("  ")]
    assert sorted(listed) == sorted(planned.name for planned in stages.every_stage())


def test_every_stage_has_a_name_of_its_own():
    names = {kind: [planned.name for planned in stages.plan(kind)] for kind in ("", "real", "full")}
    assert all(len(set(some)) == len(some) for some in names.values())
    assert set(names[""]) < set(names["real"]) < set(names["full"]) | {"integration"}
    assert (ROOT / ".ci/run").read_text().count("tools/test\" --real") == 1


@pytest.fixture
def set_up_for(tmp_path):
    """What tools/test asks tools/setup for, which fails, so that nothing else happens; its exit code is handed on."""
    (tmp_path / "tools").mkdir()
    for name in ("test", "stages.py"):
        shutil.copy(ROOT / "tools" / name, tmp_path / "tools")
    asked = tmp_path / "tools/setup"
    asked.write_text('#!/bin/sh\necho "$@"\nexit 130\n')
    asked.chmod(0o755)

    def ask(*arguments):
        result = run(tmp_path / "tools/test", *arguments)
        assert result.returncode == 130, result
        return result.stdout.strip()

    return ask


def test_a_stage_that_is_not_there_is_told_before_set_up(set_up_for, tmp_path):
    result = run(tmp_path / "tools/test", "unti")
    assert (result.returncode, result.stdout) == (2, "test: no such stage: unti\n")


def test_a_stage_is_set_up_for_what_it_needs(set_up_for):
    virtual, real = ({planned.name for planned in stages.plan(kind)} for kind in ("", "real"))
    assert {name: set_up_for(name) for name in virtual} == {
        "rooms": "core", "objects": "core", "style": "test", "unit": "test", "integration": "test"}
    assert {set_up_for(name) for name in real - virtual} == {"real"}
    assert [set_up_for(*options) for options in ((), ("--real",), ("--full",))] == ["test", "real", "full"]
    larger = {more: set_up_for("rooms", more) for more in ("unit", "realbus", "--real", "--full")}
    assert larger == {"unit": "test", "realbus": "real", "--real": "real", "--full": "full"}
    assert set_up_for("--full", "rooms") == "full"


def test_what_needs_real_time_or_a_toolchain_is_not_in_virtual_time():
    """A marker that pytest did not know, or a stage that asked for none, would let it in."""
    collect = (PYTHON, "-m", "pytest", "-q", "--collect-only", "tests/integration", "-m", stages.VIRTUAL)
    chosen = run(*collect, PYTHONPATH=stages.paths("host")).stdout
    assert "test_bad_runs.py" in chosen
    assert not re.search(r"test_(gateway_(serial|crowds|registers)|bench_signals|zcu102|cortex_m4)\.py", chosen)


@pytest.mark.parametrize("workers", ["0", "1"])
@pytest.mark.parametrize("plugin, failed", [("heeding_interrupts", 0), ("busy_machine", 1)])
def test_tests_started_in_the_background_heed_interrupts(tmp_path, plugin, failed, workers):
    (tmp_path / "test_planted.py").write_text(
        "import signal, subprocess\n"
        "def test_a():\n"
        "    child = subprocess.Popen(['sleep', '1'])\n"
        "    child.send_signal(signal.SIGINT)\n"
        "    assert child.wait() == -signal.SIGINT\n"
    )
    (tmp_path / "conftest.py").write_text(f"pytest_plugins = ['{plugin}']\n")
    command = [PYTHON, "-m", "pytest", "-q", "-n", workers, "-p", "no:cacheprovider", "--rootdir", tmp_path, tmp_path]
    done = run("sh", "-c", 'trap "" INT; exec "$@"', "sh", *command, PYTHONPATH=str(ROOT / "tests/lib"))
    assert done.returncode == failed, done.stdout
    assert ("started with interrupts ignored" in done.stdout) == (failed == 0)


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_terminal_is_shown_how_far_it_is_and_a_file_is_not(tmp_path, monkeypatch):
    monkeypatch.setattr(runner, "PROGRESS_S", 0.01)
    (tmp_path / "one.log").write_text("....... [ 7/80]\n.......s [15/80]\n.s.")
    (tmp_path / "other.log").write_text("[7/80] Building C object\n")
    group = [stage(print, name) for name in ("one", "other", "silent")]
    for out, shown in ((Terminal(), True), (io.StringIO(), False)):
        with runner.progress(group, tmp_path, out):
            for _ in range(1000):
                if " s: " in out.getvalue():
                    break
                time.sleep(0.01 if shown else 0.0001)
        assert (" s: one 18/80, other 7/80, silent" in out.getvalue()) == shown
        assert out.getvalue().endswith(runner.CLEAR) == shown
