"""Signals to `tumble bench`: it ends as documented, and nothing is left."""

import os
import shlex
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
from conftest import ROOT
from test_bench import paced

from tumble.cli import main

pytestmark = pytest.mark.real_time


def start(tmp_path, *options, **others):
    """A run that turns in real time, and its first line on stderr."""
    child = subprocess.Popen(
        [*paced(3), "--out", str(tmp_path / "run"), *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **others,
    )
    return child, child.stderr.readline()


@pytest.fixture
def heeding_hang_up():
    """Whoever runs these tests with nohup ignores it, and so would all that they start."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.mark.usefixtures("heeding_hang_up")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
@pytest.mark.parametrize("interactive", [False, True])
def test_a_signal_ends_the_run_in_good_order(number, interactive, tmp_path):
    options = ["--interactive"] if interactive else []
    child, first = start(tmp_path, *options, stdin=subprocess.PIPE)
    assert ("Mount the block" if interactive else "mounting 1") in first
    child.send_signal(number)
    out, err = child.communicate(timeout=30)
    assert (child.returncode, out) == (128 + number, "")
    assert err.splitlines()[-1] == "tumble: interrupted; the table is at rest"
    assert os.listdir(tmp_path) == []


def test_what_a_killed_run_left_is_named(tumble, tmp_path):
    (tmp_path / ".run.part").mkdir()
    done = tumble("bench", "--out", "run", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"tumble: run: {tmp_path}/.run.part is there, of a run that goes on or was killed\n"


def test_many_interrupts_do_not_disturb_the_cleaning_up(tmp_path):
    child, _ = start(tmp_path)
    for _ in range(30):
        child.send_signal(signal.SIGINT)
        time.sleep(0.001)
    out, err = child.communicate(timeout=30)
    assert (child.returncode, out) == (130, "")
    assert err.splitlines()[-1] == "tumble: interrupted; the table is at rest" and "Traceback" not in err
    assert os.listdir(tmp_path) == []


def test_hang_up_is_ignored_where_that_is_wanted(tmp_path):
    """As nohup does it."""
    start_ignored = {"preexec_fn": lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)}
    child, _ = start(tmp_path, **start_ignored)
    child.send_signal(signal.SIGHUP)
    time.sleep(0.5)
    assert child.poll() is None
    child.send_signal(signal.SIGTERM)
    child.communicate(timeout=30)
    assert child.returncode == 128 + signal.SIGTERM


def test_no_module_is_loaded_to_compile_the_package():
    """As for \\N{...}: an interrupt while it is loaded comes out as a SyntaxError."""
    files = list((ROOT / "host/python/src/tumble").rglob("*.py"))
    assert len(files) > 100 and [path for path in files if "\\N{" in path.read_text(encoding="utf-8")] == []


@pytest.mark.python
def test_an_early_interrupt_ends_quietly(tmp_path):
    """In every moment of the first quarter of a second, the launcher's included."""
    launched = ["env", "--block-signal=INT", sys.executable, str(ROOT / "host/python/launch.py"), "bench", "--out=run"]
    for step in range(50):
        child = subprocess.Popen(
            launched, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
        )
        time.sleep(0.005 * step)
        child.send_signal(signal.SIGINT)
        _, err = child.communicate(timeout=30)
        assert "Traceback" not in err and "KeyboardInterrupt" not in err, err
        if child.returncode == 0:  # on time
            break
        assert child.returncode in (-signal.SIGINT, 130), err
        assert os.listdir(tmp_path) == []


@pytest.mark.python
@pytest.mark.parametrize("received, code", [([signal.SIGINT], 130), ([], 3)])
def test_a_class_half_made_when_the_interrupt_came(monkeypatch, capsys, received, code):
    """Python 3.11 makes a RuntimeError of what is raised while a class names its attributes."""

    class Interrupting:
        def __set_name__(self, owner, name):
            raise KeyboardInterrupt

    def command(_):
        try:
            type("Half", (), {"made": Interrupting()})
        except KeyboardInterrupt as interrupt:  # as from 3.12 on
            raise RuntimeError("Error calling __set_name__") from interrupt

    monkeypatch.setattr(
        main, "_parser", lambda *_: SimpleNamespace(parse_args=lambda _: SimpleNamespace(run_command=command))
    )
    monkeypatch.setattr(main.interruption, "_received", received)
    assert main.main([]) == code
    assert capsys.readouterr().err.startswith(
        "tumble: interrupted\n" if received else "tumble: fault in tumble itself: "
    )


@pytest.mark.python
def test_the_launcher_of_a_checkout_holds_early_interrupts_back():
    assert 'env --block-signal=INT "$root/.venv/bin/python" "$root/host/python/launch.py"' in (
        ROOT / "tools/tumble"
    ).read_text()


@pytest.mark.python
def test_an_interrupt_that_python_cannot_raise_comes_again():
    """In a destructor an exception is lost."""
    program = """
import os, signal, time
from tumble import interruption
class Last:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(0.01)
interruption.watch()
last = Last()
del last
try:
    time.sleep(20)
except KeyboardInterrupt:
    print(interruption.exit_code())
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=15)
    assert (done.stdout, done.stderr) == (f"{128 + signal.SIGTERM}\n", "")


@pytest.mark.python
@pytest.mark.parametrize(("interrupted", "code"), [(True, 128 + signal.SIGTERM), (False, 3)])
def test_an_interrupt_that_an_import_has_swallowed_counts(interrupted, code):
    """Modules in C make an ImportError of it."""
    program = f"""
import os, signal, sys, time
from tumble.cli import main
from tumble.cli.commands import solve
def run(_):
    try:
        if {interrupted}:
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(1)
    except KeyboardInterrupt:
        pass
    raise ImportError("no module")
solve.run = run
sys.exit(main.main(["solve", "run.csv"], interruptible=True))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=15)
    assert (done.returncode, done.stdout) == (code, "")
    assert (done.stderr == "tumble: interrupted\n") == interrupted


@pytest.mark.python
def test_a_command_ends_by_its_signal_from_a_shell(tmp_path):
    """128 and the number, as of a program that has died of it."""
    pipe = tmp_path / "run.csv"
    os.mkfifo(pipe)
    solve = f"{shlex.quote(sys.executable)} -m tumble solve run.csv"
    script = f"{solve} & exec 3>run.csv; kill -TERM $!; exec 3>&-; wait $!"
    done = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "tumble: interrupted\n")


@pytest.mark.parametrize("moment", ["exists", "mkdir", "rmtree"])
@pytest.mark.parametrize("there", [True, False])
def test_an_interrupt_leaves_the_stage_of_another_run_alone(moment, there, tmp_path):
    """Whether it comes before the folder is made, while it is, or while it is removed. `there`: another run's is."""
    program = f"""
import os, shutil, signal
from pathlib import Path
from tumble import interruption
from tumble.world.folder import RunFolder
from tumble.errors import BadInput
interruption.watch()
where = shutil if {moment!r} == "rmtree" else Path
real = getattr(where, {moment!r})
def interrupted(*arguments, **keys):
    os.kill(os.getpid(), signal.SIGINT)
    return real(*arguments, **keys)
folder = RunFolder("runs/one", may_make_parent=True)
setattr(where, {moment!r}, interrupted)
try:
    with folder:
        print("made", flush=True)
except KeyboardInterrupt:
    print("interrupted")
except BadInput as error:
    print(error)
"""
    other = tmp_path / "runs/.one.part"
    if there:
        other.mkdir(parents=True)
        (other / "run.csv").write_text("another's")
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, timeout=20)
    assert done.stderr == "" and done.returncode == 0
    if there:
        assert (other / "run.csv").read_text() == "another's"
        refused = f"runs/one: {other} is there, of a run that goes on or was killed\n"
        assert done.stdout == (refused if moment == "rmtree" else "interrupted\n")
    else:
        assert done.stdout == ("made\n" if moment == "rmtree" else "") + "interrupted\n"
        assert os.listdir(tmp_path) == []
