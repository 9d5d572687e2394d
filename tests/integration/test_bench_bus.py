"""`tumble bench --bus uml`: real time on vcan0 inside user-mode Linux; and what is refused without any bus.

What happens on an interface is tested in tests/realbus.
"""

import os
import re
import signal
import subprocess
import sys

import pytest
from documents import valid
from simulated_bench import HASTY_STAND, wait_until
from uml_kernels import inside, kernels

from tumble.cli import main
from tumble.world import programs, uml

pytestmark = pytest.mark.real_time


@inside
@pytest.mark.slow
def test_the_usual_run_in_user_mode_linux(tumble, tmp_path):
    command = ["bench", "--bus", "uml", "--seed", 1, "--json", "--out", tmp_path / "run"]
    done = tumble(*command, timeout=300, TMPDIR=str(tmp_path))
    assert done.returncode == 0, done.stderr
    result = valid(done.stdout)
    assert (result["seed"], result["bus"], result["firmware"]) == (1, "uml", "host")
    assert result["counters"]["kernel_dropped"] == 0 and result["counters"]["samples_lost"] == 0
    assert result["counters"]["stand_kernel_received"] == result["counters"]["kernel_sent"]
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == ["bus.log", "inputs", "result.json", "run.csv"]
    progress = r"mounting 1: position 1 of 18, \d s\nmounting 2: position 10 of 18, \d\d s\nrun folder: "
    assert re.match(progress, done.stderr)
    assert not kernels(tmp_path)


@inside
@pytest.mark.slow
def test_ctrl_c_stops_the_table_and_leaves_nothing(tmp_path):
    command = [sys.executable, "-m", "tumble", "bench", "--bus", "uml", "--out", str(tmp_path / "run")]
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    child = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, start_new_session=True, env=environment)
    first = child.stderr.readline()
    assert kernels(tmp_path)
    child.send_signal(signal.SIGINT)
    rest = child.communicate(timeout=60)[1]
    assert first.startswith("mounting 1")
    assert (child.returncode, rest) == (130, "tumble: interrupted; the table is at rest\n")
    assert not (tmp_path / "run").exists() and not kernels(tmp_path)


@inside
@pytest.mark.slow
def test_a_person_confirms_a_mounting_and_interrupts_at_the_next_question(tmp_path):
    """Answers get into user-mode Linux, and Ctrl-C ends the wait for one."""
    (tmp_path / "stand.toml").write_text(HASTY_STAND)
    command = [sys.executable, "-m", "tumble", "bench", "--bus", "uml", "--interactive", "--limit", "1e-3"]
    command += ["--stand", str(tmp_path / "stand.toml"), "--out", str(tmp_path / "run")]
    child = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
                             env={**os.environ, "TMPDIR": str(tmp_path)})
    assert child.stderr.readline().startswith("Mount the block as mounting 1 says")
    assert any(line.startswith("[Enter or done") for line in child.stderr)
    child.stdin.write("\n")
    child.stdin.flush()
    assert child.stderr.readline().startswith("mounting 1: position 1 of 18")
    assert child.stderr.readline().startswith("Mount the block as mounting 2 says")
    assert any(line.startswith("[Enter or done") for line in child.stderr)
    child.send_signal(signal.SIGINT)
    rest = child.communicate(timeout=30)[1]
    assert (child.returncode, rest) == (130, "tumble: interrupted; the table is at rest\n")
    assert not (tmp_path / "run").exists() and not kernels(tmp_path)


def test_a_signal_calls_what_it_is_to_call_and_raises_nothing():
    """Whatever is being done at that moment; later ones do not disturb."""
    code = """
import os, signal
from tumble import interruption
interruption.watch()
called = []
with interruption.instead(lambda: called.append(1)):
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGINT):
        os.kill(os.getpid(), number)
print(called, interruption.exit_code())
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("[1] 130\n", "")


@inside
@pytest.mark.slow
def test_a_kernel_that_does_not_start_is_a_fault(tmp_path, monkeypatch):
    """It gets too little memory to live on."""
    monkeypatch.setattr(uml, "_BOOT_S", 3.0)
    with pytest.raises(uml.BenchFault, match=r"user-mode Linux (does not start|ended without a word)"):
        uml.run("exit 0\n", tmp_path, memory_mb=1)


@inside
@pytest.mark.slow
def test_a_job_has_its_exit_code_its_files_and_an_interface(tmp_path):
    code = uml.run("cat /sys/class/net/vcan0/operstate >state; exit 23\n", tmp_path)
    assert (code, (tmp_path / "state").read_text()) == (23, "unknown\n")


@inside
@pytest.mark.slow
def test_a_job_without_end_is_ended(tmp_path):
    with pytest.raises(uml.BenchFault, match="no end after 6 s"):
        uml.run("sleep 1000\n", tmp_path, timeout_s=6.0)
    wait_until(lambda: not kernels(tmp_path), timeout=5.0)


def test_without_can_and_without_user_mode_linux(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(uml, "_KERNEL", "linux.that.is.not.there")
    code = main.main(["bench", "--bus", "uml", "--out", str(tmp_path / "run")])
    out, err = capsys.readouterr()
    assert (code, out) == (77, "") and not (tmp_path / "run").exists()
    assert err == (
        "tumble: --bus uml: user-mode Linux is not there: no linux.that.is.not.there:"
        " install user-mode-linux kmod iproute2\n"
    )


@pytest.mark.parametrize("arguments, message", [
    (["--bus", "can0"], "--bus: 'can0' is not inprocess, uml, or socketcan: and the name of an interface"),
    (["--bus", "socketcan:"], "--bus: 'socketcan:' is not"),
    (["--bus", "socketcan:a/b"], "--bus: 'socketcan:a/b' is not"),
    (["--bus", "socketcan:" + 16 * "x"], "is not"),
    (["--bus", ""], "--bus: '' is not"),
    (["--bus", "uml", "--firmware", "zcu102", "--interactive"], "--interactive: not with --firmware zcu102"),
])
def test_names_of_buses(refused, arguments, message):
    assert message in refused("bench", *arguments)


@pytest.mark.parametrize("name", ["tumble-node", "tumble-stand"])
def test_the_programs_themselves(name):
    path = programs.find(name)

    def run(*arguments):
        return subprocess.run([path, *arguments], capture_output=True, text=True, timeout=20)

    text = run("--help").stdout
    assert text.startswith(f"usage: {name} INTERFACE") and "Exit codes: 0 " in text and "77" in text
    assert max(map(len, text.splitlines())) <= 80 and run("-h").stdout == text
    numbers = ["vcan0", "--seed", "x", "--patience", "-1"]
    for wrong in ([], ["a", "b", "c"], ["--nonsense"], ["vcan0", "nowhere.txt"], numbers):
        done = run(*wrong)
        assert (done.returncode, done.stdout) == (2, ""), wrong
        assert len(done.stderr.splitlines()) == 1 and done.stderr.startswith((name, path)), done.stderr
    if not os.path.exists("/proc/net/can"):
        done = run("vcan0")
        assert (done.returncode, done.stdout) == (77, "")
        says = "this kernel has no CAN sockets: modprobe -a can can_raw (to try without: docs/gateway.md)"
        assert done.stderr == f"{name}: vcan0: {says}\n"
