"""What set-up installs: every Python package is locked to hashes, and NOTICE names all of it with its licence. What is
missing later is told with the command that brings it."""

import re
import sys
from pathlib import Path

import pytest
from conftest import ROOT

from tumble import errors
from tumble.errors import NotInstalled
from tumble.report.pages import require_pdf

LOCKS = {path.stem: path.read_text(encoding="utf-8") for path in (ROOT / "tools/locks").glob("*.lock")}
REQUIREMENTS = {
    path.stem.removeprefix("requirements").removeprefix("-") or "core": path.read_text(encoding="utf-8")
    for folder in ("host/python", "tools") for path in (ROOT / folder).glob("requirements*.txt")
}  # fmt: skip
PACKAGES = (ROOT / "tools/packages.txt").read_text(encoding="utf-8")
PROJECT = (ROOT / "host/python/pyproject.toml").read_text(encoding="utf-8")
NOTICE = (ROOT / "NOTICE").read_text(encoding="utf-8")


def normal(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def entries(lock):
    """Name, version and hashes of what a lock has; raises ValueError where a line is anything else."""
    found = []
    for entry in re.sub(r" *\\\n *", " ", re.sub(r"(?m)^#.*\n", "", lock)).splitlines():
        told = re.fullmatch(r"([a-z0-9-]+)==([\w.!+-]+)(?: ; [^#]+?)?((?: --hash=sha256:[0-9a-f]{64})+)", entry)
        if told is None:
            raise ValueError(entry)
        found.append((told[1], told[2]))
    return found


def debian():
    return {name for row in PACKAGES.splitlines() if not row.startswith("#") for name in row.split()[2:]}


def unlicensed(notice, python, packages):
    """Names that the notice lacks, and those that it has in vain."""
    _, ours, theirs = re.split(r"\n(?:Python packages|Packages of Debian) [^\n]*:\n", notice)
    told = [{name.strip() for row in re.sub(r"\n {4}", " ", part).splitlines() if ": " in row
             for name in row.split(": ", 1)[1].split(",")} for part in (ours, theirs)]  # fmt: skip
    return (told[0] ^ python) | (told[1] ^ packages)


def test_every_file_of_requirements_has_its_lock():
    assert set(LOCKS) == set(REQUIREMENTS)
    for name, text in REQUIREMENTS.items():
        asked = {normal(word) for word in re.findall(r"(?m)^([A-Za-z][\w.-]*)", text)}
        assert asked <= {package for package, _ in entries(LOCKS[name])}, name


def test_every_package_has_hashes_and_no_lock_says_where_it_came_from():
    for name, text in LOCKS.items():
        assert entries(text) and "http" not in text and "--index" not in text and "--find-links" not in text, name


def test_all_locks_have_the_same_versions():
    """Of a package that has one for each range of Python, a lock may need fewer."""
    pinned = re.compile(r"^([a-z0-9-]+)==(\S+)(?: ; (.*?))? \\$", re.MULTILINE)
    by_range = {}
    for text in LOCKS.values():
        for name, version, where in pinned.findall(text):
            by_range.setdefault((name, where), set()).add(version)
    assert {key: versions for key, versions in by_range.items() if len(versions) > 1} == {}


def test_the_notice_names_what_is_installed():
    python = {name for text in LOCKS.values() for name, _ in entries(text)}
    assert unlicensed(NOTICE, python, debian()) == set()
    assert unlicensed(NOTICE, python | {"planted"}, debian()) == {"planted"}  # the canaries
    assert unlicensed(NOTICE, python, debian() - {"mbpoll"}) == {"mbpoll"}


@pytest.mark.parametrize("line", [
    "numpy==2.2.6\n", "numpy>=2 --hash=sha256:" + "0" * 64 + "\n", "numpy==2.2.6 --hash=sha256:00\n",
    "--index-url somewhere\n", "numpy @ somewhere\n",
])  # fmt: skip
def test_a_line_without_pin_or_hash_is_noticed(line):
    """The canary."""
    with pytest.raises(ValueError):
        entries(line)


def test_the_remedy_is_that_of_where_the_package_is(monkeypatch, tmp_path):
    """A checkout's own set-up and its pip, from wherever one works; else the extra of the installed package."""

    def remedy(name, extra):
        return str(NotInstalled("it", name, extra=extra)).removeprefix(f"it needs {name}: ")

    monkeypatch.chdir(ROOT)
    assert remedy("jinja2", "report") == "tools/setup report" and remedy("pymodbus", "client") == "tools/setup watch"
    assert remedy("scipy", "mat") == ".venv/bin/pip install scipy"
    monkeypatch.chdir(tmp_path)
    assert remedy("jinja2", "report") == f"{ROOT}/tools/setup report"
    monkeypatch.setattr(errors, "_CHECKOUT", tmp_path)
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent))
    assert remedy("scipy", "mat") == "pip install 'tumble[mat]'"
    monkeypatch.setenv("PATH", "/usr/bin")  # of an environment that is not activated, where pip is another one's
    assert remedy("scipy", "mat") == f"{sys.executable} -m pip install 'tumble[mat]'"
    assert errors.set_up("world") is None


def test_a_library_that_no_pip_brings_is_named_as_the_distribution_does(monkeypatch, tmp_path):
    """WeasyPrint is there, Pango is not."""
    (tmp_path / "weasyprint.py").write_text("raise OSError('cannot load library')\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "weasyprint", raising=False)
    told = {row.split()[1]: " ".join(row.split()[2:]) for row in PACKAGES.splitlines() if row.startswith("report ")}
    remedies = {ROOT: f"{ROOT}/tools/setup report", tmp_path: f"sudo apt-get install {told['has_pango']}"}
    for checkout, remedy in remedies.items():
        monkeypatch.setattr(errors, "_CHECKOUT", checkout)
        monkeypatch.chdir(tmp_path)
        with pytest.raises(NotInstalled, match=re.escape(f"WeasyPrint and Pango: {remedy}") + "$"):
            require_pdf()


def test_every_extra_is_one_of_the_package():
    """A remedy that names another one would install nothing."""
    (declared,) = re.findall(r"(?ms)^\[project.optional-dependencies\]\n(.*?)^\[project", PROJECT)
    declared = set(re.findall(r"(?m)^(\w+) = \[", declared))
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "host/python/src").rglob("*.py"))
    named = set(re.findall(r'extra="(\w+)"|^EXTRA = "(\w+)"', sources, re.MULTILINE))
    assert {one or other for one, other in named} == declared - {"test", "readers"}  # of several others
