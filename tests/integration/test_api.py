"""`import tumble`: every way to hand in a run gives the same bits; errors are exceptions with the command's words."""

import doctest
import importlib
import inspect
import json
import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT
from documents import valid

import tumble
from tumble.core import built_in

pytestmark = pytest.mark.python

CSV = EXAMPLES / "paper_stand.csv"
STAND = EXAMPLES / "paper_stand.toml"
NAMES = ("mounting", "position", "ux", "uy", "uz")


@pytest.fixture(scope="module")
def rows():
    return np.loadtxt(CSV, delimiter=",", skiprows=1)


@pytest.fixture(scope="module")
def result():
    return tumble.solve(CSV, stand=STAND)


def same(found, expected):
    """All that does not come from the name and the bytes of a file."""
    documents = [one.document for one in (found, expected)]
    for key in ("run_file", "run_sha256", "created"):
        for document in documents:
            document.pop(key, None)
    assert documents[0] == documents[1]


@pytest.mark.parametrize("module", ["tumble", "tumble.api.recording", "tumble.api.solving", "tumble.api.result"])
def test_the_examples_in_the_docstrings(module, monkeypatch):
    monkeypatch.chdir(ROOT)
    failed, attempted = doctest.testmod(importlib.import_module(module))
    assert failed == 0 and attempted > 1


LISTED = [one for one in (getattr(tumble, name) for name in tumble.__all__) if inspect.isfunction(one)]
LISTED += [getattr(tumble.Result, name) for name in ("apply", "plot", "save", "export", "report")]


@pytest.mark.parametrize("one", [*LISTED, tumble.Stand, tumble.World], ids=lambda one: one.__qualname__)
def test_every_parameter_is_listed_as_numpydoc_has_it(one):
    text = inspect.getdoc(one)
    (body,) = re.findall(r"^Parameters\n-{10}\n(.*?)(?:\n\n\S|\Z)", text, re.MULTILINE | re.DOTALL)
    listed = [name for row in re.findall(r"^(\w[\w, ]*) : \w", body, re.MULTILINE) for name in row.split(", ")]
    assert listed == [name for name in inspect.signature(one).parameters if name != "self"]


def test_what_the_package_offers():
    assert set(tumble.__all__) <= set(dir(tumble))
    assert all(getattr(tumble, name) is not None for name in tumble.__all__)
    assert all(getattr(tumble, name).__doc__ for name in tumble.__all__ if name != "__version__")
    with pytest.raises(AttributeError, match="module 'tumble' has no attribute 'plod'"):
        _ = tumble.plod


def test_a_mapping_a_structured_array_and_a_plain_one(rows, result):
    columns = dict(zip(NAMES, rows.T))
    structured = np.zeros(len(rows), dtype=[(name, float) for name in ("extra", *NAMES)])
    for name, column in columns.items():
        structured[name] = column
    same(tumble.solve(columns, stand=STAND), result)
    same(tumble.solve(rows, stand=str(STAND)), result)
    found = tumble.solve(structured, stand=STAND)
    assert found.document["counters"].pop("columns_ignored") == 1
    assert found.K.tolist() == result.K.tolist()


def test_npz(rows, result, tmp_path):
    np.savez(tmp_path / "run.npz", **{name: column[:, None] for name, column in zip(NAMES, rows.T)})
    found = tumble.solve(tmp_path / "run.npz", stand=STAND)
    assert found.document["run_file"] == "run.npz"
    same(found, result)


def test_a_recording_shows_its_rows(rows):
    run = tumble.read(CSV)
    assert np.array_equal(run.mounting, rows[:, 0]) and np.array_equal(run.position, rows[:, 1])
    assert np.array_equal(run.outputs, rows[:, 2:]) and run.outputs.dtype == np.float64
    assert (len(run), run.unit) == (len(rows), None)
    assert tumble.read(CSV, unit="mV").unit == "mV"


def test_columns_and_unit_by_name(rows, result):
    named = dict(zip(("Halterung", "position", "a [V]", "uy [V]", "uz [V]"), rows.T))
    run = tumble.read(named, columns={"mounting": "Halterung", "ux": "a [V]"})
    assert run.unit == "V"
    found = tumble.solve(run, stand=STAND)
    assert found.K.tolist() == result.K.tolist() and "unit" not in found.assumes and "unit" in result.assumes


def test_a_stand_and_a_schedule_as_objects(result):
    file = tumble.read_stand(str(STAND))
    same(tumble.solve(CSV, stand=file), result)
    found = tumble.solve(CSV, stand=file.stand)
    assert found.covariance.tolist() == result.covariance.tolist() and found.document["environment"] is None
    paper = tumble.solve(CSV, schedule="paper").document
    assert tumble.solve(CSV, schedule=built_in("paper")).document["K"] == paper["K"]


def test_it_is_what_the_command_prints(tumble, monkeypatch, tmp_path):
    import tumble as package

    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    printed = tumble("solve", CSV, "--stand", STAND, "--json", "--out", tmp_path / "r.json")
    found = package.solve(CSV, stand=STAND)
    assert found.to_json() == printed.stdout == (tmp_path / "r.json").read_text()
    assert [f"tumble: warning: {line}" for line in found.warnings] == printed.stderr.splitlines()
    valid(found.to_json())


def test_the_numbers_are_those_of_the_document(result):
    document = json.loads(result.to_json())
    for name in ("K", "U0", "u_K", "u_U0", "covariance"):
        array = getattr(result, name)
        assert array.tolist() == document[name] and array.dtype == np.float64
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    assert result.passed is True and result.estimator == "refined" and result.unit == "V"
    alone = tumble.solve(CSV)
    assert alone.u_K is alone.u_U0 is alone.covariance is None


def test_a_run_that_fails_is_a_result_too():
    found = tumble.solve(CSV, limit_g=1e-6)
    assert found.passed is False and found.document["pass_reason"] == "gravity"


def test_saved_and_loaded(result, tmp_path):
    result.save(tmp_path / "result.json")
    loaded = tumble.load(tmp_path / "result.json")
    assert loaded.to_json() == result.to_json() == (tmp_path / "result.json").read_text()
    assert loaded.K.tolist() == result.K.tolist() and loaded.warnings == ()
    failed = tumble.solve(CSV, limit_g=1e-6)
    failed.save(tmp_path / "failed.json")
    assert "gravity check FAILED" in tumble.load(tmp_path / "failed.json").warnings[0]


def test_further_terms():
    found = tumble.solve(CSV, stand=STAND, estimator="least_squares", model=("k2",))
    assert found.document["extended"]["terms"] == ["k2"]


ONES = {name: [1] for name in NAMES}
MISSING = "no column uy among 'mounting,position,ux,uz'; name what is missing with {}, or add it"
ASKED = "columns={'uy': 'NAME'}"


def test_a_missing_column_is_named(rows, tmp_path, refused):
    columns = {name: column for name, column in zip(NAMES, rows.T) if name != "uy"}
    for take in (tumble.read, tumble.solve):
        with pytest.raises(ValueError, match="no column uy among") as caught:
            take(columns)
        assert type(caught.value) is tumble.BadInput and str(caught.value) == f"table: {MISSING.format(ASKED)}"
    file = tmp_path / "run.csv"
    file.write_text("mounting,position,ux,uz\n1,1,0,0\n")
    with pytest.raises(tumble.BadInput) as caught:
        tumble.read(file)
    assert str(caught.value) == f"{file}: row 1: {MISSING.format(ASKED)}"
    assert refused("solve", file) == f"tumble: {file}: row 1: {MISSING.format('--columns uy=NAME')}\n"


BAD = {
    "row 2, column ux: nan is not a finite number in range": ("ux", 1, np.nan),
    "row 3, column uz: inf is not a finite number in range": ("uz", 2, np.inf),
    "row 1, column mounting: -1.0 is not the number of a place": ("mounting", 0, -1),
    "row 1, column position: 1.5 is not the number of a place": ("position", 0, 1.5),
    "row 4, column position: the schedule has no position 77 in mounting 1; positions are 1 to 9": ("position", 3, 77),
    "row 1, column mounting: the schedule has no mounting 77; mountings are 1, 2": ("mounting", 0, 77),
}


@pytest.mark.parametrize("said", BAD)
def test_a_bad_row_is_named(said, rows):
    name, row, value = BAD[said]
    columns = {key: column.copy() for key, column in zip(NAMES, rows.T)}
    columns[name][row] = value
    with pytest.raises(tumble.BadInput) as caught:
        tumble.solve(columns)
    assert str(caught.value) == f"table: {said}"


WRONG = {
    "estimator: 'best' is not one of averaged, refined, least_squares, optimal, inclined, norm": {"estimator": "best"},
    "estimator=\"optimal\" weighs the means by the stand's errors: it needs stand=": {"estimator": "optimal"},
    "limit_g: '0' is not a number of g above 0, at most 1": {"limit_g": 0},
    "confidence: '2' is not a number from 0.5 to 0.999999": {"confidence": 2},
    "model: 'k4' is not one of k2, k3, asymmetry, cross, drift, once each": {
        "model": "k4",
        "estimator": "least_squares",
    },
    "stand: a int is neither the path of a stand file nor a tumble.Stand": {"stand": 7},
    "schedule: a int is neither a name nor the path of a schedule file nor a tumble.Schedule": {"schedule": 7},
}


@pytest.mark.parametrize("said", WRONG)
def test_what_contradicts_itself(said):
    with pytest.raises(tumble.UsageError) as caught:
        tumble.solve(CSV, **WRONG[said])
    assert str(caught.value) == said and isinstance(caught.value, ValueError)


@pytest.mark.parametrize(
    ("source", "kind", "said"),
    [
        ("nowhere.csv", tumble.BadInput, "nowhere.csv: no such file or folder"),
        ("nowhere.npz", tumble.BadInput, "nowhere.npz: no such file or folder"),
        (np.zeros((3, 4)), tumble.UsageError, "an array of shape (3, 4) is no run: (rows, 5) is one, of "),
        (object(), tumble.UsageError, "builtins.object is neither a file, nor a table, nor an array of numbers"),
        ({name: [] for name in NAMES}, tumble.BadInput, "table: no samples"),
        ({**ONES, "uz": [1, 2]}, tumble.BadInput, "table: columns of different lengths: "),
        ({**ONES, "uz": ["one"]}, tumble.BadInput, "table: column uz: not numbers: "),
    ],
)
def test_what_is_no_run(source, kind, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(kind) as caught:
        tumble.read(source)
    assert str(caught.value).startswith(said)


def test_what_is_no_npz(tmp_path):
    (tmp_path / "run.npz").write_bytes(b"mounting,position\n")
    with pytest.raises(tumble.BadInput, match="not an NPZ file"):
        tumble.read(tmp_path / "run.npz")


def test_what_is_no_result(tmp_path):
    (tmp_path / "result.json").write_text('{"schema": "tumble.plan/1"}')
    with pytest.raises(tumble.BadInput, match=r"not a result of schema tumble.result/1: schema is 'tumble.plan/1'"):
        tumble.load(tmp_path / "result.json")


def test_a_schedule_object_that_the_core_refuses():
    one = tumble.Schedule((tumble.Mounting(1, ((1, 0, 0), (0, 1, 0), (0, 0, 1))),), (tumble.Position(1, 1, 0.0),))
    with pytest.raises(tumble.BadInput, match=r"^schedule: these positions cannot identify K_xx, "):
        tumble.solve(CSV, schedule=one)


def test_rows_are_found_as_by_a_schedule():
    """Numbers that a schedule can have are kept until there is one."""
    run = tumble.read({"mounting": [0, 255], "position": [255, 0], "ux": [0, 0], "uy": [0, 0], "uz": [0, 0]})
    assert run.mounting.tolist() == [0, 255] and run.position.tolist() == [255, 0]
    with pytest.raises(tumble.BadInput, match=r"row 1, column mounting: 256.0 is not the number of a place"):
        tumble.read({"mounting": [256], "position": [1], "ux": [0], "uy": [0], "uz": [0]})


LIGHT = "import sys, tumble; print(sorted({'numpy', '_tumble_core', 'json', 'csv'} & set(sys.modules)))"
USED = """
import sys
import tumble
for name in tumble.__all__:
    getattr(tumble, name)
result = tumble.solve(sys.argv[1], stand=sys.argv[2])
result.apply([0, 0, 1])
heavy = {"pandas", "polars", "pyarrow", "scipy", "shtab", "rich", "matplotlib", "jinja2", "cffi"}
print(result.passed, sorted(heavy & set(sys.modules)))
"""


def test_importing_it_loads_nothing_heavy():
    done = subprocess.run([sys.executable, "-c", LIGHT], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("[]\n", "")


def test_optional_packages_are_not_loaded_by_using_it():
    """As long as nobody hands in what they read, or asks for a picture."""
    done = subprocess.run([sys.executable, "-c", USED, CSV, STAND], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("True []\n", "")


@pytest.mark.parametrize(("file", "package"), [("run.parquet", "pyarrow or polars"), ("run.mat", "scipy")])
def test_what_is_not_installed_is_told(file, package, tmp_path):
    (tmp_path / file).write_bytes(b"x")
    program = (
        "import sys; sys.modules.update(dict.fromkeys(('pyarrow', 'polars', 'scipy')));"
        "from tumble.__main__ import run; sys.argv[1:] = ['solve', sys.argv[1]]; sys.exit(run())"
    )
    done = subprocess.run([sys.executable, "-c", program, tmp_path / file], capture_output=True, text=True)
    kind = {"run.parquet": "Parquet", "run.mat": "MAT"}[file]
    said = f"tumble: {tmp_path / file}: {kind} needs {package}: .venv/bin/pip install {package.split()[0]}\n"
    assert (done.returncode, done.stdout, done.stderr) == (77, "", said)
    assert issubclass(tumble.NotInstalled, ImportError)


def test_the_page_shows_what_is_printed(tmp_path):
    page = (ROOT / "docs/client.md").read_text(encoding="utf-8")
    code, shown = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", page, re.DOTALL).groups()
    (tmp_path / "examples").symlink_to(EXAMPLES)
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == shown
    for name in set(tumble.__all__) - {"__version__", "TumbleError"}:
        assert f"`{name}" in page, name


def test_complex_outputs_are_refused():
    columns = {"mounting": [1], "position": [1], "ux": [0.1], "uy": [0.2], "uz": np.array([1j])}
    with pytest.raises(tumble.BadInput, match="not numbers: 'complex'"):
        tumble.read(columns, unit="V")
