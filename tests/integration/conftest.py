"""Fixtures of the integration tests: the command line as a user runs it, and the --full campaigns."""

import os
import re
import secrets
import subprocess
import sys
import zlib
from pathlib import Path

import hypothesis
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/lib"))

import loaded  # noqa: E402

EXAMPLES = ROOT / "examples"
os.environ["TUMBLE_NO_REPORT"] = "1"  # of every bench, for the time it takes: where one is tested, it is asked for
pytest_plugins = ["busy_machine", "hang_guards", "heeding_interrupts", "gateway_bench"]

hypothesis.settings.register_profile("fixed", max_examples=75, derandomize=True, deadline=None, database=None)
hypothesis.settings.register_profile("full", max_examples=2000, deadline=None, database=None, print_blob=True)


def pytest_addoption(parser):
    parser.addoption("--full", action="store_true", help="run the long campaigns too")


def pytest_configure(config):
    hypothesis.settings.load_profile("full" if config.getoption("--full") else "fixed")


def pytest_collection_modifyitems(config, items):
    if config.getoption("--full"):
        return
    for item in items:
        if "full" in item.keywords:
            item.add_marker(pytest.mark.skip(reason="a long campaign: --full runs it"))


@pytest.fixture(scope="session")
def cases(request):
    """How many random cases of a property to try, of so many: all with --full, else one of four."""
    return lambda most: most if request.config.getoption("--full") else -(-most // 4)


@pytest.fixture
def fresh_seed(request):
    """A seed that is new every time with --full, and shown where a test fails; else the test's own."""
    full = request.config.getoption("--full")
    seed = secrets.randbits(32) if full else zlib.crc32(request.node.nodeid.encode())
    print(f"seed {seed}")
    return seed


@pytest.fixture
def tumble():
    """Run `tumble ...` in this process; its output is text. With an environment of its own it gets a process as well:
    Python may look at that as it begins."""

    def run(*arguments, cwd=None, timeout=120, **environment):
        if not environment:
            return loaded.run([*map(str, arguments)], cwd, timeout)
        return subprocess.run(
            [sys.executable, "-m", "tumble", *map(str, arguments)],
            capture_output=True,
            text=True,
            cwd=cwd,
            timeout=timeout,
            env={**os.environ, **environment},
        )

    return run


@pytest.fixture
def without_matplotlib(tmp_path):
    """The environment of a process that finds no matplotlib."""
    (tmp_path / "none").mkdir()
    (tmp_path / "none/matplotlib.py").write_text("raise ImportError('none')\n")
    return {"PYTHONPATH": f"{tmp_path / 'none'}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"}


def cause_and_remedy(stderr):
    """The line of a refusal, without what it took above, and the lines of the command below."""
    lines = stderr.splitlines(keepends=True)
    lines = lines[1:] if lines[0].startswith("took: ") else lines
    assert lines[0].startswith("tumble: ") and (len(lines) == 1 or re.match("remedy[,:]", lines[1])), stderr
    return [lines[0], *lines[2:]]


@pytest.fixture
def refused(tumble, tmp_path):
    """Run `tumble ...` on what it must refuse: exit 2, nothing on stdout, one line on stderr, no file left behind.

    Returns that line. Above it, import says in another what it took; below it is the command that it advises.
    """

    def run(*arguments, cwd=None):
        before = sorted(tmp_path.rglob("*"))
        done = tumble(*arguments, cwd=cwd)
        assert (done.returncode, done.stdout) == (2, ""), done.stderr
        said, *remedy = cause_and_remedy(done.stderr)
        assert arguments[0] == "import" or said == done.stderr
        assert not remedy or remedy[0].startswith("  "), done.stderr
        assert sorted(tmp_path.rglob("*")) == before
        return said

    return run


@pytest.fixture
def forged(monkeypatch, capsys):
    """Run `tumble bench ...` in this process, whose firmware says something else than it found: `forge` changes the
    document. Returns exit code, standard output and error."""

    def run(forge, *words):
        from tumble.cli.main import main
        from tumble.documents import base, bench
        from tumble.world import in_process

        real = in_process.write

        def write(border, folder):
            document = bench.written(real(border, folder))
            forge(document)
            return base.checked(bench.Bench, bench.BENCH, document, "bench.json")

        monkeypatch.setattr(in_process, "write", write)
        code = main(["bench", *words])
        return code, *capsys.readouterr()

    return run
