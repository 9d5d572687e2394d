"""`tumble uml`: any command inside user-mode Linux; what it may write, how it ends, and the terminal it has."""

import os
import platform
import pty
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from fcntl import ioctl

import pytest
from conftest import ROOT
from simulated_bench import wait_until
from uml_kernels import inside, kernels

from tumble.cli import main
from tumble.world import uml

pytestmark = [pytest.mark.python, pytest.mark.real_time]

COMMAND = [sys.executable, "-m", "tumble", "uml", "--"]
LINES = "".join(f"{number}\n" for number in range(20000))
JOB = """
cat /sys/class/net/vcan0/operstate && cat && echo "$WORD" >said && echo x >$TMPDIR/x || exit 1
test -t 0 || test -t 1 || test -t 2 && exit 2
(trap 'echo ended' TERM; sleep 1000) 2>/dev/null &
seq 0 19999
echo to errors >&2
echo $TMPDIR
touch ../elsewhere 2>/dev/null && exit 3
exit 71
"""


@inside
@pytest.mark.slow
def test_a_command_has_its_exit_code_its_outputs_and_where_it_is_called(tumble, tmp_path):
    """In a folder whose name no option of a mount could hold."""
    here = tmp_path / "a b,ro,'c"
    here.mkdir()
    done = tumble("uml", "--", "sh", "-c", JOB, cwd=here, WORD="it's \"so\" $HOME", TMPDIR=str(tmp_path))
    assert (done.returncode, done.stderr) == (71, "to errors\n")
    temporary = done.stdout.splitlines()[-2]
    assert done.stdout == f"unknown\n{LINES}{temporary}\nended\n" and not os.path.exists(temporary)
    assert [path.name for path in tmp_path.iterdir()] == [here.name]
    assert [path.name for path in here.iterdir()] == ["said"]
    assert (here / "said").read_text() == "it's \"so\" $HOME\n"


@inside
@pytest.mark.slow
def test_no_such_command(tumble):
    done = tumble("uml", "there-is-no-such-program")
    assert done.returncode == 127 and "there-is-no-such-program: not found" in done.stderr


@inside
@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_all_of_it(number, code, tmp_path):
    child = subprocess.Popen([*COMMAND, "sh", "-c", "echo begun; sleep 1000"], stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True, env={**os.environ, "TMPDIR": str(tmp_path)})
    assert child.stdout.readline() == "begun\n" and kernels(tmp_path)
    child.send_signal(number)
    assert child.communicate(timeout=20)[1] == "tumble: interrupted\n" and child.returncode == code
    wait_until(lambda: not kernels(tmp_path), timeout=5.0)


@inside
@pytest.mark.slow
def test_a_reader_that_goes_ends_all_of_it(tmp_path):
    child = subprocess.Popen([*COMMAND, "sh", "-c", "while :; do echo y; done"], stdout=subprocess.PIPE,
                             stderr=subprocess.PIPE, text=True, env={**os.environ, "TMPDIR": str(tmp_path)})
    assert child.stdout.readline() == "y\n"
    child.stdout.close()
    assert child.wait(timeout=20) == 2 and child.stderr.read() == ""
    wait_until(lambda: not kernels(tmp_path), timeout=5.0)


@inside
@pytest.mark.slow
def test_a_shell_on_a_terminal():
    """It has the terminal's size and Ctrl-C; afterwards the terminal is as it was."""
    ours, theirs = pty.openpty()
    ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 33, 99, 0, 0))
    before = termios.tcgetattr(theirs)
    child = subprocess.Popen(COMMAND[:-1], stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
                             env={**os.environ, "SHELL": "/bin/sh", "PS1": "READY "})
    try:
        wait_for_words(ours, b"READY ")
        os.write(ours, b"sh -c 'stty size; exec sleep 1000'\n")  # one job, which Ctrl-C ends at any moment
        wait_for_words(ours, b"33 99\r\n")
        os.write(ours, b"\x03")
        wait_for_words(ours, b"READY ")
        os.write(ours, b"cat /sys/class/net/vcan0/operstate\n")
        wait_for_words(ours, b"unknown\r\n")
        os.write(ours, b"exit 5\n")
        assert child.wait(timeout=20) == 5
        assert termios.tcgetattr(theirs) == before and os.get_blocking(theirs)
    finally:
        if child.poll() is None:
            os.killpg(child.pid, signal.SIGKILL)
            child.wait()
        os.close(ours)
        os.close(theirs)


def wait_for_words(terminal, words):
    """Until these are shown on it."""
    shown = b""
    while words not in shown:
        assert select.select([terminal], [], [], 30.0)[0], shown
        shown += os.read(terminal, 4096)


@inside
@pytest.mark.slow
def test_a_kernel_without_the_interface_is_a_fault(tmp_path, monkeypatch):
    monkeypatch.setattr(uml, "_MODULES", ("net/can/there-is-none", *uml._MODULES))
    with pytest.raises(uml.BenchFault, match="user-mode Linux has no interface vcan0: "):
        uml.run("exit 0\n", tmp_path)


def test_a_shell_needs_a_terminal(tumble):
    done = tumble("uml")
    expected = "tumble: uml: a shell needs a terminal; otherwise say which COMMAND\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", expected)


def test_without_user_mode_linux(monkeypatch, capsys):
    monkeypatch.setattr(uml, "_KERNEL", "linux.that.is.not.there")
    code = main.main(["uml", "--", "true"])
    out, err = capsys.readouterr()
    lacking = "no linux.that.is.not.there: install user-mode-linux kmod iproute2"
    assert (code, out, err) == (77, "", f"tumble: user-mode Linux is not there: {lacking}\n")


SLEEPER = """
import time
latest = 0.0
with open("begun", "w"):
    pass
for _ in range(200):
    begin = time.monotonic()
    time.sleep(0.01)
    latest = max(latest, time.monotonic() - begin)
print(latest)
"""


def latest_wake_up(folder):
    """How late a process in there wakes up at most, s,
    that sleeps for 10 ms at a time while the kernel is held up for 1 s."""
    (folder / "sleeper.py").write_text(SLEEPER)
    held = []

    def hold_up():
        if (folder / "begun").exists() and not held:
            time.sleep(0.3)  # it is in the midst of its sleeps
            held.append(os.getpgid(int(kernels(folder).pop())))
            os.kill(held[0], signal.SIGSTOP)
            time.sleep(1.0)
            os.kill(held[0], signal.SIGCONT)

    assert uml.run(f"{sys.executable} sleeper.py >said\n", folder, on_tick=hold_up) == 0 and held
    return float((folder / "said").read_text())


@inside
@pytest.mark.slow
def test_its_clock_stands_still_while_the_machine_holds_it_up(tmp_path):
    assert latest_wake_up(tmp_path) < 0.5


@inside
@pytest.mark.slow
@pytest.mark.skipif(platform.machine() != "x86_64", reason="nothing is preloaded here")
def test_without_that_clock_it_would_be_late(tmp_path, monkeypatch):
    """The test above can fail."""
    preloaded = tmp_path / "without_clock.so"
    source = ROOT / "host/uml/uml_ptrace.c"
    subprocess.run(["cc", "-shared", "-fPIC", "-o", preloaded, source], check=True)
    monkeypatch.setattr(uml, "built", lambda _: preloaded)
    assert latest_wake_up(tmp_path) >= 0.9
