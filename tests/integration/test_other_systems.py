"""The package on Windows and macOS, as far as this machine can tell: what is not there is not asked for."""

import json
import os
import subprocess
import sys

import pytest
from conftest import ROOT

pytestmark = pytest.mark.python

SYSTEMS = ("win32", pytest.param("darwin", marks=pytest.mark.toolchain))


def there(system, statements, folder, *arguments):
    """Run them as on the other system. Returns what they print."""
    script = ROOT / "tests/lib/other_system.py"
    program = [sys.executable, "-X", "warn_default_encoding", "-B", script, system, statements, *arguments]
    environment = dict(os.environ)
    environment["SOURCE_DATE_EPOCH"] = "1700000000"
    done = subprocess.run(program, capture_output=True, text=True, cwd=folder, env=environment, timeout=300)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def here(tmp_path_factory):
    """What the examples give on this system, in a file."""
    folder = tmp_path_factory.mktemp("here")
    there("linux", "import pickle, sys; pickle.dump(run_all('folder-first'), open(sys.argv[3], 'wb'))", folder,
          folder / "found")
    return folder / "found"


SAME = """
import pickle, sys
load_package()
found, expected = run_all("folder-there"), pickle.load(open(sys.argv[3], "rb"))
print(len(found), [name for name in expected if found.get(name) != expected[name]], sys.platform)
"""


@pytest.mark.toolchain
@pytest.mark.parametrize("system", SYSTEMS)
def test_every_module_is_imported_and_the_examples_give_the_same(system, here, tmp_path):
    """Solve, apply, import, export, plan, fixture check, bench: the same files and texts, byte by byte, as on Linux."""
    assert there(system, SAME, tmp_path, here) == f"19 [] {system}\n"


COMMANDS = {
    ("bench", "--bus", "uml"): "--bus uml: user-mode Linux is not there: it runs on Linux alone",
    ("bench", "--bus", "socketcan:can0"): "--bus socketcan:can0: this kernel has no CAN (modules can, can_raw); "
    "user-mode Linux could bring its own (it runs on Linux alone)",
    ("uml", "--", "true"): "user-mode Linux is not there: it runs on Linux alone",
}
WITHOUT_PROGRAMS = """
import json, pathlib, sys
from examples_in_process import run
from tumble.world import programs
programs.built = lambda path: pathlib.Path("nowhere")
print(json.dumps([run(*command) for command in json.loads(sys.argv[3])]))
"""


@pytest.mark.parametrize("system", SYSTEMS)
def test_what_runs_on_linux_alone_says_so(system, tmp_path):
    """Without our programs, as it is in the wheels of other systems: exit 77, one line, nothing left."""
    ended = json.loads(there(system, WITHOUT_PROGRAMS, tmp_path, json.dumps(list(COMMANDS))))
    assert ended == [[77, "", f"tumble: {said}\n"] for said in COMMANDS.values()]
    assert not list(tmp_path.iterdir())


FAULTS = {
    "import fcntl": "ModuleNotFoundError: No module named 'fcntl'",
    "import signal; signal.SIGHUP": "AttributeError: module 'signal' has no attribute 'SIGHUP'",
    "import os; os.open('.', os.O_RDONLY)": "PermissionError",
    "import os; open('a', 'w'); kept = open('a'); os.replace('a', 'b')": "PermissionError",
    "import os; open('c', 'w'); open('d', 'w'); os.rename('c', 'd')": "FileExistsError",
    "open('/proc/self/status')": "FileNotFoundError",
    "import subprocess; subprocess.run(['true'])": "FileNotFoundError",
    "exec(compile('open(\"e\", \"w\")', 'x', 'exec'), {'__name__': 'tumble.errors'})": "EncodingWarning",
}
TRIED = """
import json, sys
for statements in json.loads(sys.argv[3]):
    try:
        exec(statements, {})
        print("nothing")
    except Exception as error:
        print(f"{type(error).__name__}: {error}")
"""


def test_the_other_system_lacks_what_it_should(tmp_path):
    """Canary: each of these would show there, and none of them does here."""
    tried = json.dumps(list(FAULTS))
    found = there("win32", TRIED, tmp_path, tried).splitlines()
    assert len(found) == len(FAULTS) and all(map(str.startswith, found, FAULTS.values())), found
    assert there("linux", TRIED, tmp_path, tried).splitlines() == ["nothing"] * len(FAULTS)
