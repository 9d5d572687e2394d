"""tools/setup: what pictures and reports lack is told once, and tried again when something could have changed.

It runs in a tree of its own, on a machine of which every program that installs or builds is a stub that writes down how
it was called.
"""
import os
import shutil
import subprocess
import time

import pytest
from conftest import ROOT

STUB = r"""#!/usr/bin/env bash
echo "${0##*/} $*" >>"$WORLD/calls"
case "${0##*/} $*" in
"python -" | "python3 -") cat >/dev/null; echo "$0" ;;
"python3 -m venv "*) mkdir -p "$3/bin" "$3/lib/python3.12/site-packages" && cp "$0" "$3/bin/python" ;;
*"pip install"*-plot.txt | *"pip install"*-report.txt) [[ ! -e $WORLD/no-network ]] ;;
"python -c import weasyprint") [[ -e $WORLD/pango ]] ;;
"cc "*) cat >/dev/null ;;
"cmake --build"*) mkdir -p build/host/python && touch build/host/python/_tumble_core.abi3.so ;;
sudo* | apt-get*install* | dpkg*) exit 1 ;;
*launch.py*) echo "$TUMBLE_PROGRAM" >"$WORLD/program" ;;
esac
"""
WITHOUT_PANGO = "tumble: set up without Pango; what needs it will be skipped"
NAMES = ("python3", "cc", "cmake", "ninja", "apt-get", "dpkg", "sudo", "pkg-config")


class Machine:
    """A tree with tools/setup and tools/tumble, and the world around it: files `no-network`, `pango`, `status`."""

    def __init__(self, folder):
        self.tree, self.world = folder / "tree", folder / "world"
        (self.tree / "host/python").mkdir(parents=True)
        (self.world / "bin").mkdir(parents=True)
        for file in (ROOT / "host/python").glob("requirements*.txt"):
            shutil.copy(file, self.tree / "host/python")
        shutil.copytree(ROOT / "tools", self.tree / "tools", ignore=lambda _, names: set(names) - {"setup", "tumble"})
        script = self.tree / "tools/setup"
        text = script.read_text().replace("EUID", "WHO")
        assert text.count("/var/lib/dpkg/status") == 1 and text.count("WHO") == 2
        script.write_text(text.replace("/var/lib/dpkg/status", str(self.world / "status")))
        for file in (self.tree / "VERSION", self.world / "status"):
            file.touch()
        for name in NAMES:
            (self.world / "bin" / name).write_text(STUB)
            (self.world / "bin" / name).chmod(0o755)
        self.age(2000)

    def age(self, seconds):
        """Make everything that is there older."""
        for path in (*self.tree.rglob("*"), *self.world.rglob("*")):
            told = path.lstat()
            os.utime(path, (told.st_mtime - seconds, told.st_mtime - seconds))

    def call(self, *command, who=0):
        """What a call told, without the log's name; and the programs that it called."""
        (self.world / "calls").write_text("")
        path = f"{self.world / 'bin'}:{os.environ['PATH']}"
        done = subprocess.run([str(self.tree / command[0]), *command[1:]], text=True, capture_output=True, timeout=60,
                              env={"PATH": path, "WORLD": str(self.world), "WHO": str(who)})
        assert (done.returncode, done.stdout) == (0, ""), done.stderr
        return done.stderr.partition(" (log: ")[0], (self.world / "calls").read_text()

    def setup(self, profile="report", who=0):
        return self.call("tools/setup", profile, who=who)

    @property
    def tried(self):
        (found,) = (self.tree / "build/setup").glob("*.tried-*")
        return found


@pytest.fixture
def machine(tmp_path):
    return Machine(tmp_path)


def without(machine, who=0):
    """It has been told that Pango is missing, some time ago; now it could be had."""
    assert machine.setup(who=who)[0] == WITHOUT_PANGO
    machine.age(500)
    (machine.world / "pango").touch()
    return machine


def test_when_nothing_is_missing_it_is_done_once(machine):
    (machine.world / "pango").touch()
    assert machine.setup()[0].startswith("tumble: set up for 'report' in ")
    assert machine.setup() == ("", "")


@pytest.mark.parametrize("who", [0, 1000])
def test_what_is_missing_is_told_once(machine, who):
    without(machine, who)
    for _ in range(2):
        assert machine.setup(who=who) == ("", "")


def install(machine):
    (machine.world / "status").touch()


def change(machine):
    (machine.tree / "VERSION").touch()


def move(machine):
    machine.tried.write_text("/elsewhere\n\n")


def change_packages(machine):
    os.utime(machine.tree / ".venv/lib/python3.12/site-packages")


@pytest.mark.parametrize("happens", [install, change, move, change_packages])
def test_what_could_have_changed_is_tried_again(machine, happens):
    happens(without(machine))
    assert machine.setup()[0].startswith("tumble: set up for 'report' in ")
    assert machine.setup() == ("", "")


def test_other_rights_are_another_try(machine):
    without(machine, who=1000)
    assert machine.setup(who=1000) == ("", "")
    assert machine.setup(who=0)[0].startswith("tumble: set up for 'report' in ")


@pytest.mark.parametrize(("who", "comes_back"), [(0, True), (1000, False)])
def test_a_network_may_come_back_within_an_hour_and_rights_do_not(machine, who, comes_back):
    before = time.time()
    without(machine, who)
    root, again = machine.tried.read_text().splitlines()
    assert root == str(machine.tree) and bool(again) == comes_back
    if comes_back:
        assert before + 3599 <= int(again) <= time.time() + 3600
        machine.tried.write_text(f"{root}\n{int(time.time()) - 1}\n")
        assert machine.setup(who=who)[0].startswith("tumble: set up for 'report' in ")


def test_what_was_there_and_is_gone_is_told_once_as_well(machine):
    (machine.world / "pango").touch()
    machine.setup()
    (machine.world / "pango").unlink()
    machine.age(500)
    change(machine)
    assert machine.setup()[0] == WITHOUT_PANGO
    assert machine.setup() == ("", "")


def test_packages_that_pip_does_not_get_are_told_once(machine):
    (machine.world / "no-network").touch()
    said = "tumble: set up without the packages of host/python/requirements-{}.txt; what needs it will be skipped"
    for profile in ("plot", "report"):
        assert machine.setup(profile)[0] == said.format(profile)
        assert machine.setup(profile) == ("", "")


@pytest.mark.parametrize(("command", "installs"), [
    ("import a.csv --plot a.svg", {"plot"}),
    ("compare a.json b.json --plot=c.svg", {"plot"}),
    ("report a.json --out a.pdf", {"report"}),
    ("bench --report a.html", {"report"}),
    ("plan validate --plot a.svg", set()),  # it draws by itself
    ("solve a.csv", set()),
])
def test_a_command_installs_what_it_needs(machine, command, installs):
    _, calls = machine.call("tools/tumble", *command.split())
    lines = calls.splitlines()
    assert {name for name in ("plot", "report") if f"-rhost/python/requirements-{name}.txt" in calls} == installs
    assert ("python -c import weasyprint" in lines) == ("apt-get update" in lines) == ("report" in installs)
    assert lines[-1] == f"python {machine.tree}/host/python/launch.py {command}"
    assert (machine.world / "program").read_text() == f"{machine.tree}/tools/tumble\n"  # as it was called
