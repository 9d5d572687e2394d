"""tools/setup: what pictures and reports lack is told once, and tried again when something could have changed. What may
not be installed is told with the line for an administrator; Ctrl-C ends it; no file is installed that is not locked.

It runs in a tree of its own, on a machine of which every program that installs or builds is a stub that writes down how
it was called.
"""
import hashlib
import os
import pty
import shutil
import signal
import subprocess
import sys
import time
import zipfile

import pytest
from conftest import ROOT

STUB = r"""#!/usr/bin/env bash
echo "${0##*/} $*" >>"$WORLD/calls"
case "${0##*/} $*" in
"python -" | "python3 -") cat >/dev/null; echo "$0" ;;
"python3 -m venv "*) mkdir -p .venv/bin .venv/lib/python3.12/site-packages && cp "$0" .venv/bin/python ;;
*"pip install"*/plot.lock | *"pip install"*/report.lock) [[ ! -e $WORLD/no-network ]] ;;
"ldconfig -p") [[ ! -e $WORLD/pango ]] || echo libpangoft2-1.0.so.0 libharfbuzz-subset.so.0 ;;
"cc "*) cat >/dev/null; [[ ! -e $WORLD/no-compiler ]] ;;
*usage.py*) exec "$REAL_PYTHON" "$@" ;;
*apt-get*install*)
    [[ ! -e $WORLD/slow ]] || { trap '' INT; echo $$ >"$WORLD/busy"; sleep 60; }
    exit 1
    ;;
"cmake --build"*) mkdir -p build/host/python && touch build/host/python/_tumble_core.abi3.so ;;
sudo* | apt-get*install* | dpkg*) exit 1 ;;
*launch.py*) echo "$TUMBLE_PROGRAM" >"$WORLD/program" ;;
esac
"""
WITHOUT_PANGO = "tumble: set up without libpango-1.0-0; what needs it will be skipped; to have it: sudo apt-get" \
    " install --no-install-recommends libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0 fonts-dejavu-core"
NAMES = ("python3", "cc", "cmake", "ninja", "apt-get", "dpkg", "sudo", "pkg-config", "ldconfig")


class Machine:
    """A tree with tools/setup and tools/tumble, and the world around it: files `no-network`, `pango`, `status`."""

    def __init__(self, folder):
        self.tree, self.world = folder / "tree", folder / "world"
        (self.tree / "host/python").mkdir(parents=True)
        (self.world / "bin").mkdir(parents=True)
        mine = {"setup", "tumble", "usage", "packages.txt", "locks", "site", "benchmark", "fixture"}
        shutil.copytree(ROOT / "tools", self.tree / "tools", ignore=lambda folder, names: set(names) - mine
                        if folder == str(ROOT / "tools") else ())
        script = self.tree / "tools/setup"
        text = script.read_text()
        assert text.count("EUID") == 1
        script.write_text(text.replace("EUID", "WHO").replace("/var/lib/dpkg/status", str(self.world / "status")))
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
        done = subprocess.run([str(self.tree / command[0]), *command[1:]], text=True, capture_output=True, timeout=60,
                              env=self.environment(who))
        assert (done.returncode, done.stdout) == (0, ""), done.stderr
        return done.stderr.partition(" (log: ")[0], (self.world / "calls").read_text()

    def environment(self, who=0, path=os.environ["PATH"]):
        return {"PATH": f"{self.world / 'bin'}:{path}", "WORLD": str(self.world), "WHO": str(who),
                "REAL_PYTHON": sys.executable}

    def setup(self, profile="report", who=0):
        """As a command of `tumble` that needs a profile calls it."""
        return self.call("tools/setup", profile, "true", who=who)

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


def test_who_asks_for_it_is_told_again(machine):
    """As the message of a command that lacks it says: tools/setup report."""
    machine.setup()
    for _ in range(2):
        assert machine.call("tools/setup", "report")[0] == WITHOUT_PANGO
    (machine.world / "pango").touch()
    assert machine.call("tools/setup", "report")[0].startswith("tumble: set up for 'report' in ")
    assert machine.call("tools/setup", "report") == machine.setup() == ("", "")


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
    (machine.world / "pango").touch()
    said = "tumble: set up without the Python packages of tools/locks/{}.lock; what needs it will be skipped"
    for profile in ("plot", "report"):
        assert machine.setup(profile)[0] == said.format(profile)
        assert machine.setup(profile) == ("", "")


def with_package(machine):
    for name in ("src", "usage.py"):
        (machine.tree / "host/python" / name).symlink_to(ROOT / "host/python" / name)


@pytest.mark.parametrize(("command", "installs"), [
    ("import a.csv --plot a.svg", {"plot"}),
    ("compare a.json b.json --plot=c.svg", {"plot"}),
    ("report {}/a.json --out a.pdf", {"report"}),
    ("bench --report --seed 2", {"report"}),
    ("plan validate --plot a.svg", {"plot"}),
    ("draw stand --out a.svg", {"plot"}),
    ("plan validate --runs 200", set()),
    ("solve a.csv", set()),
])
def test_a_command_installs_what_it_needs(machine, command, installs):
    with_package(machine)
    (machine.world / "a.json").touch()
    command = command.format(machine.world)
    _, calls = machine.call("tools/tumble", *command.split())
    lines = calls.splitlines()
    assert {name for name in ("plot", "report") if f"-rtools/locks/{name}.lock" in calls} == installs
    assert ("ldconfig -p" in lines) == ("apt-get update" in lines) == ("report" in installs)
    assert lines[-1] == f"python {machine.tree}/host/python/launch.py {command}"
    assert (machine.world / "program").read_text() == f"{machine.tree}/tools/tumble\n"  # as it was called


NEEDED = ("Or ask an administrator for: sudo apt-get install --no-install-recommends gcc libc6-dev libpango-1.0-0"
          " libpangoft2-1.0-0 libharfbuzz-subset0 fonts-dejavu-core")


def refused(machine, **more):
    """What is told, in one line, by a set-up that ends with 3."""
    (machine.world / "no-compiler").touch()
    done = subprocess.run([machine.tree / "tools/setup", "report"], capture_output=True, text=True, timeout=60, **more)
    assert (done.returncode, done.stdout) == (3, "")
    return done.stderr.partition(" (log: ")[0]


def test_without_a_terminal_an_administrator_is_needed(machine):
    assert refused(machine, env=machine.environment(1000)) == (
        "tumble: set-up: cannot install gcc libc6-dev: sudo does not do it without a password, and there is no terminal"
        f" to ask for it. {NEEDED}")


def test_a_machine_without_sudo_is_told_from_one_that_refuses(machine, tmp_path):
    (machine.world / "bin/sudo").unlink()
    for program in os.listdir("/usr/bin"):
        if program != "sudo" and not (machine.world / "bin" / program).exists():
            (machine.world / "bin" / program).symlink_to(f"/usr/bin/{program}")
    assert refused(machine, env=machine.environment(1000, path="/nowhere")) == (
        f"tumble: set-up: cannot install gcc libc6-dev: you are not root, and there is no sudo. {NEEDED}")


def test_at_a_terminal_it_says_why_before_sudo_asks(machine):
    (machine.world / "no-compiler").touch()
    ours, theirs = pty.openpty()
    done = subprocess.Popen([machine.tree / "tools/setup", "report"], stderr=theirs, env=machine.environment(1000))
    os.close(theirs)
    told = b""
    try:
        while block := os.read(ours, 4096):
            told += block
    except OSError:  # its other end is closed
        pass
    assert done.wait(60) == 3
    first, *_, last = [line for line in told.decode().replace("\r\x1b[K", "").splitlines() if "tumble: " in line]
    assert first.startswith("tumble: set-up for 'report' installs gcc libc6-dev libpango-1.0-0 ") and " min " in first
    assert f"tumble: set-up: cannot install gcc libc6-dev: sudo refused. {NEEDED}" in last
    calls = (machine.world / "calls").read_text()
    assert calls.count("sudo -p ") == 1 and "apt-get" not in calls


BUSY_S = 5  # in which an interrupt ends it; a second where nothing else runs


def test_an_interrupt_ends_it_while_packages_are_installed(machine):
    """Even if apt-get does not listen; it is left to complete what it has begun."""
    for name in ("no-compiler", "slow"):
        (machine.world / name).touch()
    done = subprocess.Popen([machine.tree / "tools/setup", "core"], stderr=subprocess.PIPE, text=True,
                            env=machine.environment(), start_new_session=True)
    busy = machine.world / "busy"
    while not (busy.exists() and busy.read_text()):
        assert done.poll() is None
        time.sleep(0.01)
    begin = time.monotonic()
    os.killpg(done.pid, signal.SIGINT)
    try:
        assert done.wait(30) == 130 and time.monotonic() - begin < BUSY_S
        os.kill(int(busy.read_text()), 0)  # is still there
    finally:
        os.killpg(done.pid, signal.SIGKILL)
    assert done.stderr.read().startswith("tumble: set-up: interrupted; ")
    assert {path.name for path in (machine.tree / "build/setup").iterdir()} == {"lock", "missing"}


@pytest.mark.parametrize(("words", "code"), [
    ("--help", 0), ("", 0), ("solve --help", 0), ("bench -h", 0), ("--version", 0), ("watch --help", 0),
    ("frob", 2), ("solve", 2), ("bench --bogus", 2), ("report r.json --out r.pdf --frob", 2),
    ("report r.json --out r.pdf", 2),
])
def test_help_and_usage_errors_install_nothing(machine, words, code):
    with_package(machine)
    done = subprocess.run([machine.tree / "tools/tumble", *words.split()], capture_output=True, text=True, timeout=60,
                          env=machine.environment())
    assert done.returncode == code and bool(done.stdout) == (code == 0) and bool(done.stderr) == (code == 2)
    assert not (machine.tree / "build").exists() and not (machine.tree / ".venv").exists()


def test_an_interrupt_while_it_looks_for_usage_errors_leaves_no_word(machine):
    package = machine.tree / "host/python/src/tumble/cli"
    package.mkdir(parents=True)
    busy = machine.world / "busy"
    (package / "main.py").write_text(f"import time\nopen({str(busy)!r}, 'w').close()\ntime.sleep(60)\n")
    (machine.tree / "host/python/usage.py").symlink_to(ROOT / "host/python/usage.py")
    done = subprocess.Popen([machine.tree / "tools/tumble", "solve", "a.csv"], stderr=subprocess.PIPE, text=True,
                            env=machine.environment(), start_new_session=True)
    while not busy.exists():
        assert done.poll() is None
        time.sleep(0.01)
    begin = time.monotonic()
    os.killpg(done.pid, signal.SIGINT)
    assert done.communicate(timeout=30) == (None, "") and time.monotonic() - begin < BUSY_S
    assert done.returncode in (-signal.SIGINT, 130) and not (machine.tree / "build").exists()


@pytest.mark.parametrize(("words", "code"), [
    ("site --help", 0), ("site --frob", 2), ("site a b", 2),
    ("benchmark --help", 0), ("benchmark violations --help", 0), ("benchmark frob", 2), ("benchmark --frob", 2),
    ("fixture/validate --help", 0), ("fixture/validate", 2), ("fixture/validate can:can0 axis", 2),
])
def test_nor_do_those_of_the_other_tools(machine, words, code):
    (machine.tree / "tests").symlink_to(ROOT / "tests")
    command, *more = words.split()
    done = subprocess.run([machine.tree / "tools" / command, *more], capture_output=True, text=True, timeout=60,
                          env=machine.environment())
    assert (done.returncode, done.stderr.count("\n")) == (code, code // 2), done.stderr
    assert (f"tools/{' '.join([command, *more[:-1]])}" in done.stdout) == (code == 0)
    assert not (machine.tree / "build").exists() and not (machine.tree / ".venv").exists()


@pytest.mark.parametrize(("words", "code"), [("--help", 0), ("-h", 0), ("all", 2), ("--frob", 2)])
def test_set_up_tells_its_profiles_without_one(machine, words, code):
    done = subprocess.run([machine.tree / "tools/setup", words], capture_output=True, text=True, timeout=60)
    assert done.returncode == code and ("\n  report   tumble report: " in done.stdout) == (code == 0)
    assert done.stderr.startswith("usage: tools/setup ") == (code == 2)
    assert not (machine.tree / "build").exists()


WHEEL = "numpy-1.0-py3-none-any.whl"


@pytest.fixture
def locked(machine):
    """The machine's real Python, an index of one package that is no more than its name, and a lock that asks for it."""
    for name in ("python3", "cc", "cmake", "ninja"):
        (machine.world / "bin" / name).unlink()
    about = "Metadata-Version: 2.1\nName: numpy\nVersion: 1.0\n"
    tag = "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
    with zipfile.ZipFile(machine.world / WHEEL, "w") as wheel:
        for name, text in (("METADATA", about), ("WHEEL", tag), ("RECORD", "")):
            wheel.writestr(f"numpy-1.0.dist-info/{name}", text)
    true = hashlib.sha256((machine.world / WHEEL).read_bytes()).hexdigest()

    def setup(line, tree=machine.tree):
        (tree / "tools/locks/core.lock").write_text(line.format(true=true) + "\n")
        environment = {**machine.environment(), "PIP_NO_INDEX": "1", "PIP_FIND_LINKS": str(machine.world)}
        done = subprocess.run([tree / "tools/setup", "core"], capture_output=True, text=True, timeout=120,
                              env=environment)
        assert done.returncode == 3  # at the latest where there is nothing to build
        return done.stderr.partition(" (log: ")[0]

    return setup


def test_only_files_of_the_lock_are_installed(locked):
    why = "tumble: set-up: cannot install Python packages: "
    forged = f"{why}numpy==1.0 is not the file whose hash stands in tools/locks"
    assert locked("numpy==1.0 --hash=sha256:" + "0" * 64) == forged
    assert locked("numpy==1.0") == why + "a package of tools/locks has no hash"
    assert locked("numpy==1.0 --hash=sha256:{true}") == "tumble: set-up: cannot build the extension module"


def test_an_environment_that_came_from_elsewhere_is_made_anew(locked, machine):
    """Its pip would install where it came from."""
    locked("numpy==1.0 --hash=sha256:{true}")
    moved = machine.tree.rename(machine.tree.with_name("moved"))
    locked("numpy==1.0 --hash=sha256:{true}", moved)
    done = subprocess.run([moved / ".venv/bin/pip", "--version"], capture_output=True, text=True, timeout=60)
    assert str(moved / ".venv") in done.stdout
