"""The package on Windows and macOS, as far as this machine can tell: what is not there is not asked for."""

import os
import subprocess
import sys

import pytest
from conftest import ROOT

pytestmark = pytest.mark.python

SYSTEMS = ("win32", "darwin")


def there(system, statements, folder, code=0):
    """Run them as on the other system. Returns what they print, or what they complain of."""
    script = ROOT / "tests/lib/other_system.py"
    program = [sys.executable, "-X", "warn_default_encoding", "-B", script, system, statements]
    environment = {**os.environ, "SOURCE_DATE_EPOCH": "1700000000"}
    done = subprocess.run(program, capture_output=True, text=True, cwd=folder, env=environment, timeout=300)
    assert done.returncode == code, done.stderr
    return done.stderr if code else done.stdout


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_module_is_imported_and_the_examples_give_the_same(system, tmp_path):
    """Solve, apply, import, export, plan and fixture check: the same files and texts, byte by byte, as on Linux."""
    same = """
load_package()
there = run_all("folder-there")
before = __import__("pickle").loads(open("here.pickle", "rb").read())
assert there == before, [name for name in there if there[name] != before[name]]
print(len(there), __import__("sys").platform)
"""
    there("linux", "__import__('pickle').dump(run_all('folder-first'), open('here.pickle', 'wb'))", tmp_path)
    assert there(system, same, tmp_path) == f"14 {system}\n"


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize(
    ("command", "said"),
    [
        (["bench"], "tumble: tumble-bench runs on Linux alone; what else tumble does, it does on this system as "
         "well\n"),
        (["bench", "--bus", "uml"], "tumble: --bus uml: user-mode Linux is not there: it runs on Linux alone\n"),
        (["bench", "--bus", "socketcan:can0"], "tumble: --bus socketcan:can0: this kernel has no CAN (modules can, "
         "can_raw); user-mode Linux could bring its own (it runs on Linux alone)\n"),
        (["uml", "--", "true"], "tumble: user-mode Linux is not there: it runs on Linux alone\n"),
    ],
)
def test_what_runs_on_linux_alone_says_so(system, command, said, tmp_path, monkeypatch):
    """Without tumble-bench, as it is in the wheels of other systems: exit 77, one line, nothing left."""
    monkeypatch.delenv("TUMBLE_BENCH", raising=False)
    statements = f"""
from tumble.bench import programs
programs.built = lambda path: __import__("pathlib").Path("nowhere")
from examples_in_process import run
assert run(*{command!r}) == (77, "", {said!r}), run(*{command!r})
"""
    there(system, statements, tmp_path)
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize(
    ("statements", "fault"),
    [
        ("import fcntl", "ModuleNotFoundError: No module named 'fcntl'"),
        ("import signal; signal.SIGHUP", "AttributeError: module 'signal' has no attribute 'SIGHUP'"),
        ("import os; os.open('.', os.O_RDONLY)", "PermissionError"),
        ("import os; open('a', 'w'); kept = open('a'); os.replace('a', 'b')", "PermissionError"),
        ("import os; open('a', 'w'); open('b', 'w'); os.rename('a', 'b')", "FileExistsError"),
        ("open('/proc/self/status')", "FileNotFoundError"),
        ("import subprocess; subprocess.run(['true'])", "FileNotFoundError"),
        ("exec(compile('open(\"a\", \"w\")', 'x', 'exec'), {'__name__': 'tumble.errors'})", "EncodingWarning"),
    ],
)
def test_the_other_system_lacks_what_it_should(statements, fault, tmp_path):
    """Canary: each of these would show."""
    assert fault in there("win32", statements, tmp_path, code=1).splitlines()[-1]
