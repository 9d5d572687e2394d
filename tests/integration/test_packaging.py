"""The package's own statements agree with each other; what is handed on has its licence and its version."""

import argparse
import email
import hashlib
import importlib.util
import json
import os
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest
from _tumble_core import ffi, lib
from bench_program import built
from conftest import ROOT

from tumble import __version__, core
from tumble.cli import options
from tumble.estimators import ESTIMATORS, LINEAR, OPTIMAL

PYTHON = ROOT / "host/python"
LICENCES = ("LICENSE", "NOTICE")
APACHE = "cfc7749b96f63bd31c3c42b5c471bf756814053e847c10f3eb003417bc523d30"  # SHA-256 of the text as published
PROGRAMS = {
    "tumble-node": "boards/linux", "tumble-stand": "boards/linux", "tumble-bench": "host/bench",
    "tumble-replay": "host/replay", "tumble-gateway": "host/gateway",
}  # fmt: skip


def section(text, name):
    """The strings of a list in pyproject.toml."""
    body = re.search(rf"^{re.escape(name)} = \[\n(.*?)^\]", text, re.MULTILINE | re.DOTALL)[1]
    return re.findall(r'"([^"]+)"', body)


def test_requirements_are_those_of_the_project():
    project = (PYTHON / "pyproject.toml").read_text()
    named = {"requirements.txt": "dependencies", "requirements-test.txt": "test", "requirements-report.txt": "report"}
    for file, name in named.items():
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


def test_help_names_options_and_exit_codes(tumble):
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
    table = {ffi.string(row.name).decode(): row for row in lib.estimator_rows}
    assert tuple(table) == ESTIMATORS and len(lib.estimator_rows) == lib.TUMBLE_ESTIMATE_COUNT
    assert tuple(name for name, row in table.items() if row.estimate and row.uncertainty) == LINEAR
    assert [name for name in table if name not in LINEAR] == [OPTIMAL]


def test_schemas_and_options_name_the_estimators_of_the_core():
    names = [ffi.string(row.name).decode() for row in lib.estimator_rows]
    written = subprocess.run([sys.executable, ROOT / "tools/estimators.py", "--check"], check=False)
    assert written.returncode == 0
    for name in ("result", "plan"):
        schema = json.loads((ROOT / f"docs/schemas/tumble.{name}-1.schema.json").read_text(encoding="utf-8"))
        assert names in list(enums(schema))
    parser = argparse.ArgumentParser()
    options.add_estimator(parser)
    for name in names:
        assert parser.parse_args(["--estimator", name]).estimator == name
        assert name in parser.format_help()


def enums(schema):
    """Every list of allowed values in a schema."""
    if isinstance(schema, dict):
        yield from ([schema["enum"]] if isinstance(schema.get("enum"), list) else [])
        schema = list(schema.values())
    for part in schema if isinstance(schema, list) else []:
        yield from enums(part)


def test_every_status_has_a_name_and_a_sentence():
    names, sentences = zip(*core.statuses())
    header = (ROOT / "firmware/include/tumble/status.h").read_text()
    assert list(names) == re.findall(r"X\((TUMBLE_\w+),", header)
    assert all(sentences) and len(set(sentences)) == len(sentences)


def test_no_plot_or_table_library_is_loaded_for_plain_output(tmp_path):
    """What start-up time is spent on: numpy, and nothing that only a terminal or a test needs."""
    program = (
        "import sys; from tumble.cli.main import main;"
        f"command = ['solve', {str(ROOT / 'examples/paper_stand.csv')!r}, '--unit', 'V'];"
        f"code = main([*command, '--out', {str(tmp_path / 'r.json')!r}]);"
        "unwanted = {'rich', 'tomllib', 'difflib', 'pytest', 'cffi', 'jinja2', 'matplotlib', 'weasyprint'};"
        "unwanted &= set(sys.modules);"
        "print(sorted(unwanted), file=sys.stderr)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stderr == "[]\n"


def test_help_and_typing_errors_load_no_numpy():
    """Nor the core: both answer at once."""
    program = (
        "import sys; from tumble.cli.main import main\n"
        "for words in (['--help'], ['solve', '--help'], ['bench', '--sed', '1']):\n"
        "    try: main(words)\n"
        "    except SystemExit: pass\n"
        "print(sorted({'numpy', '_tumble_core', 'csv', 'json'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.endswith("\n[]\n"), done.stdout


def test_the_licence_is_the_published_text():
    assert hashlib.sha256((ROOT / "LICENSE").read_bytes()).hexdigest() == APACHE
    for name in LICENCES:  # copies: a package cannot name files outside its folder
        assert (PYTHON / name).read_bytes() == (ROOT / name).read_bytes()


def test_one_version(tumble):
    """The file VERSION, and what CMake, C, the object dictionaries and Python make of it."""
    version = (ROOT / "VERSION").read_text().strip()
    assert __version__ == version and tumble("--version").stdout == f"tumble {version}\n"
    assert f'#define TUMBLE_VERSION "{version}"' in (ROOT / "firmware/include/tumble/version.h").read_text()
    for name in ("navcomp", "drive", "block"):
        assert re.search(r"^ParameterName=Manufacturer software version\n(?:.*\n)*?DefaultValue=(.*)$",
                         (ROOT / f"docs/eds/tumble_{name}.eds").read_text(), re.MULTILINE)[1] == version
    for cache in ROOT.glob("build/host/CMakeCache.txt"):
        assert f"CMAKE_PROJECT_VERSION:STATIC={version}\n" in cache.read_text()
    assert f"\n## [{version}]" in (ROOT / "CHANGELOG.md").read_text()
    assert f"Version {version}" in (ROOT / "README.md").read_text()


@pytest.mark.parametrize("name", PROGRAMS)
def test_every_program_says_its_version(name):
    path = built(name, PROGRAMS[name])
    done = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=20)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{name} {__version__}\n", "")
    with open("/dev/full", "w", encoding="ascii") as full:
        assert subprocess.run([path, "--version"], stdout=full, timeout=20).returncode in (2, 3)


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """Source package and wheel, built as by `pip wheel` and unpacked: {kind: folder}."""
    if importlib.util.find_spec("scikit_build_core") is None:
        pytest.skip("scikit-build-core is not installed")
    folder = tmp_path_factory.mktemp("packages")
    build = f"import scikit_build_core.build as b; b.build_sdist({str(folder)!r}); b.build_wheel({str(folder)!r})"
    environment = {key: value for key, value in os.environ.items() if key != "LD_PRELOAD"}
    done = subprocess.run([sys.executable, "-c", build], cwd=PYTHON, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    with tarfile.open(next(folder.glob("*.tar.gz"))) as archive:
        archive.extractall(folder / "sdist")
    with zipfile.ZipFile(next(folder.glob("*.whl"))) as archive:
        archive.extractall(folder / "wheel")
    return {"sdist": folder / f"sdist/tumble-{__version__}", "wheel": folder / "wheel"}


METADATA = {"sdist": ("PKG-INFO", "."), "wheel": (f"tumble-{__version__}.dist-info/METADATA", "licenses")}


@pytest.mark.slow
@pytest.mark.toolchain
@pytest.mark.parametrize("kind", METADATA)
def test_every_package_has_licence_and_version(packages, kind):
    file, licences = METADATA[kind]
    path = packages[kind] / file
    metadata = email.message_from_string(path.read_text(encoding="utf-8"))
    assert (metadata["Version"], metadata["License-Expression"]) == (__version__, "Apache-2.0")
    assert metadata.get_all("License-File") == list(LICENCES)
    for name in LICENCES:
        assert (path.parent / licences / name).read_bytes() == (ROOT / name).read_bytes()


@pytest.mark.slow
@pytest.mark.toolchain
def test_a_wheel_says_that_it_is_typed(packages):
    assert (packages["wheel"] / "tumble/py.typed").is_file()


def has_libmodbus(binary):
    """Does it link libmodbus, or hold it? Its functions' names and messages are in whatever does."""
    return b"libmodbus" in binary or b"modbus_" in binary


@pytest.mark.slow
@pytest.mark.toolchain
def test_no_wheel_has_libmodbus(packages):
    """It is LGPL. The gateway, which links it, is in no wheel; the canary of the check is the gateway itself."""
    files = [path for path in packages["wheel"].rglob("*") if path.is_file()]
    binaries = [path for path in files if path.read_bytes().startswith(b"\x7fELF")]
    assert sorted(path.name for path in binaries) == ["_tumble_core.abi3.so", "tumble-bench"]
    assert not any(has_libmodbus(path.read_bytes()) for path in binaries)
    assert not any("modbus" in path.name for path in files)


def test_the_gateway_links_libmodbus_dynamically():
    """Not its archive: whoever uses the gateway can exchange the library, as the LGPL wants."""
    path = built("tumble-gateway", "host/gateway")
    done = subprocess.run(["readelf", "--dynamic", path], capture_output=True, text=True, check=True)
    assert re.search(r"\(NEEDED\).*\[libmodbus\.so\.\d+\]", done.stdout)
    assert has_libmodbus(Path(path).read_bytes())


@pytest.mark.slow
@pytest.mark.toolchain
def test_the_wheel_has_what_reports_are_made_of(packages):
    room = ROOT / "host/python/src/tumble/report"
    files = sorted(path.name for path in room.iterdir() if path.suffix in (".j2", ".css"))
    assert files == ["report.css", "report.html.j2", "tables.html.j2"]
    for name in files:
        assert (packages["wheel"] / "tumble/report" / name).read_bytes() == (room / name).read_bytes()
