"""The package's own statements agree with each other."""

import re
import subprocess
import sys

from conftest import ROOT

from tumble import __version__, core
from tumble.commands.options import LINEAR_ESTIMATORS

PYTHON = ROOT / "host/python"


def section(text, name):
    """The strings of a list in pyproject.toml."""
    body = re.search(rf"^{re.escape(name)} = \[\n(.*?)^\]", text, re.MULTILINE | re.DOTALL)[1]
    return re.findall(r'"([^"]+)"', body)


def test_requirements_are_those_of_the_project():
    project = (PYTHON / "pyproject.toml").read_text()
    for file, name in (("requirements.txt", "dependencies"), ("requirements-test.txt", "test")):
        assert (PYTHON / file).read_text().split("\n")[:-1] == section(project, name)


def test_the_installed_program_is_what_a_checkout_runs():
    """The entry point is there and takes signals; and the wheel has what `tumble bench` starts, where it looks."""
    project = (PYTHON / "pyproject.toml").read_text()
    module, function = re.search(r'^tumble = "(\S+):(\w+)"$', project, re.MULTILINE).groups()
    program = f"import sys; from {module} import {function}; sys.argv[1:] = ['--version']; {function}()"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"tumble {__version__}\n", "")
    assert '"tumble-bench"' in re.search(r"^build.targets = .*", project, re.MULTILINE)[0]
    assert "install(TARGETS tumble-bench RUNTIME DESTINATION tumble/bench " in (PYTHON / "CMakeLists.txt").read_text()


def test_version(tumble):
    assert tumble("--version").stdout == f"tumble {__version__}\n"


def test_help_names_every_option_and_exit_code(tumble):
    text = tumble("solve", "--help").stdout
    for word in (
        "--estimator",
        "--stand",
        "--schedule",
        "--limit",
        "--json",
        "--out",
        "--columns",
        "--decimal",
        "--unit",
    ):
        assert word in text
    assert "130" in text


def test_estimators_offered_are_those_of_the_core():
    assert LINEAR_ESTIMATORS == core.ESTIMATORS


def test_every_status_has_a_name_and_a_sentence():
    names, sentences = zip(*core.statuses())
    header = (ROOT / "firmware/core/status.h").read_text()
    assert list(names) == re.findall(r"X\((TUMBLE_\w+),", header)
    assert all(sentences) and len(set(sentences)) == len(sentences)


def test_no_plot_or_table_library_is_loaded_for_plain_output(tmp_path):
    """What start-up time is spent on: numpy, and nothing that only a terminal or a test needs."""
    program = (
        "import sys; from tumble.cli import main;"
        f"code = main(['solve', {str(ROOT / 'examples/paper_stand.csv')!r}, '--out', {str(tmp_path / 'r.json')!r}]);"
        "unwanted = {'rich', 'tomllib', 'difflib', 'pytest', 'cffi'} & set(sys.modules);"
        "print(sorted(unwanted), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stderr == "[]\n"
