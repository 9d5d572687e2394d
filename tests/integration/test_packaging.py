"""The package's own statements agree with each other; what is handed on has its licence and its version."""

import argparse
import email
import hashlib
import importlib.util
import json
import re
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import core_functions
import paced_scripts
import pytest
from _tumble_core import ffi, lib
from conftest import ROOT
from simulated_bench import built
from wheels import build, installed_in

from tumble import __version__, data
from tumble.cli import options
from tumble.estimators import ESTIMATORS, INCLINED, LINEAR, NORM, OPTIMAL

PYTHON = ROOT / "host/python"
LICENCES = ("LICENSE", "NOTICE")
APACHE = "cfc7749b96f63bd31c3c42b5c471bf756814053e847c10f3eb003417bc523d30"  # SHA-256 of the text as published
EXTENSIONS = ("_tumble_core.abi3.so", "_tumble_world.abi3.so")
PROGRAMS = ("tumble-node", "tumble-stand", "tumble-gateway")


def section(text, name):
    """The strings of a list in pyproject.toml."""
    body = re.search(rf"^{re.escape(name)} = \[\n(.*?)^\]", text, re.MULTILINE | re.DOTALL)[1]
    return re.findall(r'"([^"]+)"', body)


def test_requirements_are_those_of_the_project():
    project = (PYTHON / "pyproject.toml").read_text()
    named = {"requirements.txt": "dependencies", "requirements-test.txt": "test"}
    named |= {f"requirements-{name}.txt": name for name in ("plot", "report", "watch")}
    for file, name in named.items():
        assert required(PYTHON / file) == section(project, name)


def required(file):
    """The lines of a file of requirements, with those of the files that it names."""
    lines = file.read_text().split("\n")[:-1]
    return [one for line in lines
            for one in (required(file.with_name(line[3:])) if line.startswith("-r ") else [line])]


def test_the_installed_program_is_what_a_checkout_runs():
    """The entry point is there and takes signals; and the wheel has what `tumble bench` holds."""
    project = (PYTHON / "pyproject.toml").read_text()
    module, function = re.search(r'^tumble = "(\S+):(\w+)"$', project, re.MULTILINE).groups()
    program = f"import sys; from {module} import {function}; sys.argv[1:] = ['--version']; {function}()"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"tumble {__version__}\n", "")
    assert re.search(r"^build.targets = (.*)", project, re.MULTILINE)[1] == '["tumble_wheel"]'
    cmake = (PYTHON / "CMakeLists.txt").read_text()
    assert "add_custom_target(tumble_wheel DEPENDS _tumble_core _tumble_world)" in cmake


def test_estimators_offered_are_those_of_the_core():
    table = {ffi.string(row.name).decode(): row for row in lib.estimator_rows}
    assert tuple(table) == ESTIMATORS and len(lib.estimator_rows) == lib.TUMBLE_ESTIMATE_COUNT
    assert tuple(name for name, row in table.items() if row.estimate and row.uncertainty) == (*LINEAR, INCLINED)
    assert [name for name in table if name not in LINEAR] == [OPTIMAL, INCLINED]


def test_schemas_and_options_name_the_estimators_of_the_core():
    names = [ffi.string(row.name).decode() for row in lib.estimator_rows]
    written = subprocess.run([sys.executable, ROOT / "tools/estimators.py", "--check"], check=False)
    assert written.returncode == 0
    for name, others in (("result", {NORM}), ("plan", set())):  # numpy's own
        schema = json.loads((ROOT / f"docs/schemas/tumble.{name}-1.schema.json").read_text(encoding="utf-8"))
        assert others.union(names) in [set(found) - {None} for found in enums(schema)]
    parser = argparse.ArgumentParser()
    options.add(parser, "--estimator")
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
    names, sentences = zip(*core_functions.statuses())
    header = (ROOT / "firmware/include/tumble/status.h").read_text()
    assert list(names) == re.findall(r"X\((TUMBLE_\w+),", header)
    assert all(sentences) and len(set(sentences)) == len(sentences)


OPTIONAL = ("matplotlib", "jinja2", "weasyprint", "PIL", "pandas", "polars", "pyarrow", "scipy", "can", "cantools",
            "canopen", "pymodbus", "dask", "distributed")


def test_no_plot_or_table_library_is_loaded_for_plain_output(tmp_path):
    """What start-up time is spent on: numpy, and nothing that only a terminal or a test needs."""
    program = (
        "import sys; from tumble.cli.main import main;"
        f"command = ['solve', {str(ROOT / 'examples/paper_stand.csv')!r}, '--unit', 'V'];"
        f"code = main([*command, '--out', {str(tmp_path / 'r.json')!r}]);"
        f"unwanted = {{'rich', 'tomllib', 'difflib', 'pytest', 'cffi', *{OPTIONAL!r}}} & set(sys.modules);"
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
        f"print(sorted({{'numpy', '_tumble_core', 'csv', 'json', *{OPTIONAL!r}}} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.endswith("\n[]\n"), done.stdout


def test_files_that_come_along_are_found_by_name():
    names = data.names()
    for name in ("examples/paper_stand.csv", "examples/paper_stand.toml", "schemas/tumble.result-1.schema.json",
                 "eds/tumble_block.eds", "bus/block.dbc", "docs/modbus.csv"):
        assert name in names and data.file(name).is_file()
    assert {name.partition("/")[0] for name in names} == set(data.FOLDERS)
    assert "examples/hand_held_session.csv" not in names  # of another licence
    for name in ("examples/none.csv", "paper_stand.csv", "../pyproject.toml", "examples/../bus/block.dbc", ""):
        said = f"no {name!r} comes with tumble; there are: bus/block.dbc, bus/tumble.dbc, docs/modbus.csv, "
        with pytest.raises(FileNotFoundError, match=re.escape(said)):
            data.file(name)


def test_the_page_on_them_shows_what_is_printed(tmp_path):
    page = (ROOT / "docs/client.md").read_text(encoding="utf-8").partition("## What comes with it")[2]
    code, shown = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", page, re.DOTALL).groups()
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == shown


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
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()


@pytest.mark.parametrize("name", PROGRAMS)
def test_every_program_says_its_version(name):
    path = built(name)
    done = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=20)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{name} {__version__}\n", "")
    with open("/dev/full", "w", encoding="ascii") as full:
        assert subprocess.run([path, "--version"], stdout=full, timeout=20).returncode in (2, 3)


@pytest.fixture(scope="module")
def packages(tmp_path_factory):
    """The source package, unpacked; and unpacked the wheel that is made of it, away from the checkout. {kind: folder};
    `file`: the wheel."""
    if importlib.util.find_spec("scikit_build_core") is None:
        pytest.skip("scikit-build-core is not installed")
    folder = tmp_path_factory.mktemp("packages")
    with tarfile.open(build("sdist", PYTHON, folder)) as archive:
        archive.extractall(folder / "sdist")
    source = folder / f"sdist/tumble-{__version__}"
    files = {path for path in source.rglob("*") if path.is_file()}
    wheel = build("wheel", source, folder)
    for path in set(source.rglob("*")) - files:  # what the build has left there
        assert path.is_dir() or "build" in path.relative_to(source).parts, path
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "wheel")
    return {"sdist": source, "wheel": folder / "wheel", "file": wheel}


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


README = (PYTHON / "README.md").read_text(encoding="utf-8")


def test_the_readme_of_the_package_needs_no_other_file(tmp_path):
    """A package index shows it alone. What it has of Python runs; its extras are those that there are."""
    assert not re.findall(r"\]\((?!https://)", README) and "<img" not in README
    (code,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.startswith("True 2.0"), done.stderr
    table = README.partition("| extra |")[2]
    extras = set(re.findall(r"`(\w+)`", "".join(row.split("|")[1] for row in table.splitlines() if row.count("|") > 2)))
    project = (PYTHON / "pyproject.toml").read_text()
    options = project.partition("[project.optional-dependencies]")[2].partition("[project.scripts]")[0]
    assert extras == set(re.findall(r"^(\w+) = \[", options, re.MULTILINE)) - {"test"}


TOOLS = ("auditwheel==6.8.2", "abi3audit==0.0.26", "twine==7.0.0", "cyclonedx-python-lib[json-validation]==11.12.0",
         "cffconvert==2.0.0", "setuptools<81")  # fmt: skip


@pytest.fixture(scope="module")
def packagers(tmp_path_factory):
    """Of an environment that has what packagers check with. cffconvert wants a jsonschema of its own, so it has one."""
    return {name: installed_in(tmp_path_factory.mktemp("tools"), *tools)
            for name, tools in (("wheels", TOOLS[:4]), ("citation", TOOLS[4:]))}


@pytest.mark.slow
@pytest.mark.toolchain
def test_what_packagers_check_with_finds_no_fault(packages, packagers):
    run, wheel = packagers["wheels"], packages["file"]
    done = run("auditwheel", "show", wheel)
    major, minor = map(int, re.search(r'"manylinux_(\d+)_(\d+)_', done.stdout).groups())
    assert (major, minor) <= (2, 28), done.stdout
    done = run("abi3audit", "--strict", "--report", wheel)
    (found,) = json.loads(done.stdout)["specs"].values()
    objects = found["wheel"]
    assert done.returncode == 0 and {one["name"] for one in objects} == set(EXTENSIONS)
    assert all(one["result"]["is_abi3"] and not one["result"]["non_abi3_symbols"] for one in objects)
    done = run("twine", "check", "--strict", wheel, *wheel.parent.glob("*.tar.gz"))
    assert done.returncode == 0 and done.stdout.count("PASSED") == 2, done.stdout


VALIDATE = """
import sys
from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator
sys.exit(JsonStrictValidator(SchemaVersion.V1_6).validate_str(open(sys.argv[1]).read()) and 1)
"""


@pytest.mark.slow
@pytest.mark.toolchain
def test_the_bill_of_materials_of_a_wheel(packages, packagers):
    """Of CycloneDX 1.6: Tumble at this version, and nothing else."""
    file = packages["wheel"] / f"tumble-{__version__}.dist-info/sboms/tumble.cdx.json"
    told = json.loads(file.read_text(encoding="utf-8"))
    assert told["metadata"]["component"]["purl"] == f"pkg:pypi/tumble@{__version__}" and told["components"] == []
    assert packagers["wheels"]("python", "-c", VALIDATE, file).returncode == 0


@pytest.mark.slow
@pytest.mark.toolchain
def test_the_citation_is_one(packagers, tmp_path):
    done = packagers["citation"]("cffconvert", "--validate", "-i", ROOT / "CITATION.cff")
    assert done.returncode == 0 and "valid according to schema version 1.2.0" in done.stdout + done.stderr
    (tmp_path / "CITATION.cff").write_text((ROOT / "CITATION.cff").read_text().replace("title: T", "titel: T"))
    assert packagers["citation"]("cffconvert", "--validate", "-i", tmp_path / "CITATION.cff").returncode == 1


def test_a_container_for_developers_is_set_up_as_a_checkout_is():
    told = json.loads((ROOT / ".devcontainer/devcontainer.json").read_text(encoding="utf-8"))
    script, profile = told["postCreateCommand"].split()
    assert (ROOT / script).is_file() and f"\n{profile} " in (ROOT / "tools/setup").read_text()
    assert told["image"] == "debian:12" and "Debian 12" in (ROOT / "README.md").read_text()


@pytest.mark.slow
@pytest.mark.toolchain
def test_a_wheel_says_that_it_is_typed(packages):
    assert (packages["wheel"] / "tumble/py.typed").is_file()


def contents(folder, *patterns):
    """{path: bytes} of the files in a folder, without what Python and the build leave there."""
    paths = {path for pattern in patterns or ("*",) for path in folder.rglob(pattern) if path.is_file()}
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths
            if not {"__pycache__", "build"} & set(path.relative_to(folder).parts)}


COPIED = ("VERSION", "CMakeLists.txt", "cmake", "firmware", "boards/nv", "boards/replay",
          "boards/zcu102/commissioning.c", "boards/zcu102/commissioning.h", "host/simulation", "host/world",
          "host/python/CMakeLists.txt", "host/python/binding", "docs/schemas", "docs/eds", "docs/bus",
          "docs/modbus.csv")


@pytest.mark.slow
@pytest.mark.toolchain
def test_a_source_package_holds_all_that_it_is_built_from(packages):
    """Byte by byte, and nothing of another licence."""
    sources = packages["sdist"] / "sources"
    for name in COPIED:
        theirs, ours = sources / name, ROOT / name
        assert contents(theirs) == contents(ours) if ours.is_dir() else theirs.read_bytes() == ours.read_bytes(), name
    assert contents(packages["sdist"] / "src") == contents(PYTHON / "src")
    assert (packages["sdist"] / "pyproject.toml").read_bytes() == (PYTHON / "pyproject.toml").read_bytes()
    names = [path.name for path in packages["sdist"].rglob("*")]
    assert not [name for name in names if "LICENSE-imucal" in name or "hand_held" in name]
    expected = {"LICENSE", "NOTICE", "PKG-INFO", "README.md", "pyproject.toml", "sources", "src"}
    assert {path.name for path in packages["sdist"].iterdir()} - {"build"} == expected


@pytest.mark.slow
@pytest.mark.toolchain
def test_a_wheel_holds_the_package_its_data_and_nothing_else(packages):
    """It fits every Python from 3.10 on, and its data are those of a checkout."""
    assert re.fullmatch(rf"tumble-{__version__}-cp310-abi3-linux_\w+\.whl", packages["file"].name)
    inside = contents(packages["wheel"])
    own = {f"tumble/{name}": held for name, held in contents(PYTHON / "src/tumble").items()}
    kept = {f"tumble/data/{name}": data.file(name).read_bytes() for name in data.names()}
    assert len(kept) > 25 and {"tumble/data/examples/paper_stand.csv", "tumble/data/bus/block.dbc"} <= set(kept)
    others = {name for name in inside if name not in {**own, **kept}}
    info = {f"tumble-{__version__}.dist-info/{name}"
            for name in ("METADATA", "RECORD", "WHEEL", "entry_points.txt", "licenses/LICENSE", "licenses/NOTICE",
                         "sboms/tumble.cdx.json")}
    assert others == {*EXTENSIONS, *info}
    assert {**own, **kept} == {name: inside[name] for name in inside if name not in others}


@pytest.mark.slow
@pytest.mark.toolchain
def test_a_checkout_gives_the_same_wheel(packages, tmp_path):
    """As `pip install ./host/python` builds it; the programs may differ, in paths that the compiler notes."""
    with zipfile.ZipFile(build("wheel", PYTHON, tmp_path)) as archive:
        archive.extractall(tmp_path / "wheel")
    ours, theirs = (contents(folder) for folder in (tmp_path / "wheel", packages["wheel"]))
    built_ones = {*EXTENSIONS, f"tumble-{__version__}.dist-info/RECORD"}
    assert set(ours) == set(theirs)
    assert {name for name in ours if ours[name] != theirs[name]} <= built_ones


@pytest.fixture(scope="module")
def installed(packages, tmp_path_factory):
    """Of an environment that has the wheel."""
    return installed_in(tmp_path_factory.mktemp("environment"), packages["file"])


IN_THE_WHEEL = """
import importlib.resources, json, pathlib, sys
import tumble
from tumble import data
assert not [name for name in sys.path if name.startswith(sys.argv[1])], sys.path
run, stand = (str(data.file(f"examples/paper_stand.{suffix}")) for suffix in ("csv", "toml"))
result = tumble.solve(run, stand=stand)
assert result.passed and (importlib.resources.files("tumble.data") / "examples/paper_stand.csv").is_file()
assert json.loads(data.file("schemas/tumble.result-1.schema.json").read_text(encoding="utf-8"))["title"]
result.save("result.json")
pathlib.Path("data.csv").write_text("ux,uy,uz\\n0.0,0.0,2.0\\n", encoding="utf-8")
pathlib.Path("run.txt").write_text(run, encoding="utf-8")
print(len(data.names()))
"""


@pytest.mark.slow
@pytest.mark.toolchain
def test_the_installed_wheel_works_alone(installed, tmp_path):
    assert installed("tumble", "--version").stdout == f"tumble {__version__}\n"
    done = installed("python", "-I", "-c", IN_THE_WHEEL, str(ROOT))
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{len(data.names())}\n", "")
    done = installed("tumble", "apply", "result.json", "data.csv")
    assert done.returncode == 0 and done.stdout.splitlines()[1].endswith(",0.004450219,-0.012136139,0.986791694")
    done = installed("tumble", "bench", "--seed", "3", "--samples", "5", "--out", tmp_path / "run")
    assert done.returncode == 0 and (tmp_path / "run/bus.log").is_file(), done.stderr
    done = installed("tumble", "import", tmp_path / "run/bus.log")
    assert (done.returncode, done.stdout) == (77, "")
    assert re.search(r"a CAN log needs python-can: \S+/bin/python3? -m pip install 'tumble\[can\]'\n$", done.stderr)


@pytest.mark.slow
@pytest.mark.toolchain
def test_the_pytest_plugin_of_the_wheel(packages, tmp_path):
    """docs/client.md as it is printed, where nobody names the plugin."""
    (tmp_path / "calibrate.py").write_text(paced_scripts.SCRIPT, encoding="utf-8")
    (tmp_path / "test_calibrate.py").write_text(paced_scripts.TEST, encoding="utf-8")
    done = installed_in(tmp_path, f"{packages['file']}[client]", "pytest")("pytest", "test_calibrate.py")
    assert done.returncode == 0 and " 1 passed in " in done.stdout, done.stdout + done.stderr


def has_libmodbus(binary):
    """Does it link libmodbus, or hold it? Its functions' names and messages are in whatever does."""
    return b"libmodbus" in binary or b"modbus_" in binary


@pytest.mark.slow
@pytest.mark.toolchain
def test_no_wheel_has_libmodbus(packages):
    """It is LGPL. The gateway, which links it, is in no wheel; the canary of the check is the gateway itself."""
    files = [path for path in packages["wheel"].rglob("*") if path.is_file()]
    binaries = [path for path in files if path.read_bytes().startswith(b"\x7fELF")]
    assert sorted(path.name for path in binaries) == [*EXTENSIONS]
    assert not any(has_libmodbus(path.read_bytes()) for path in binaries)
    assert not any("libmodbus" in path.name for path in files)


def test_the_gateway_links_libmodbus_dynamically():
    """Not its archive: whoever uses the gateway can exchange the library, as the LGPL wants."""
    path = built("tumble-gateway")
    done = subprocess.run(["readelf", "--dynamic", path], capture_output=True, text=True, check=True)
    assert re.search(r"\(NEEDED\).*\[libmodbus\.so\.\d+\]", done.stdout)
    assert has_libmodbus(Path(path).read_bytes())


@pytest.mark.slow
@pytest.mark.toolchain
def test_the_wheel_has_the_page_of_watch(packages):
    name = "tumble/watch/page.html"
    assert (packages["wheel"] / name).read_bytes() == (ROOT / "host/python/src" / name).read_bytes()


@pytest.mark.slow
@pytest.mark.toolchain
def test_the_wheel_has_what_reports_are_made_of(packages):
    room = ROOT / "host/python/src/tumble/report"
    files = sorted(path.name for path in room.iterdir() if path.suffix in (".j2", ".css"))
    pages = [f"{name}.html.j2" for name in ("history", "history_page", "report", "since", "tables", "thermal")]
    assert files == sorted([*pages, "report.css"])
    for name in files:
        assert (packages["wheel"] / "tumble/report" / name).read_bytes() == (room / name).read_bytes()
