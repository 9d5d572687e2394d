"""What callers of `import tumble` may get wrong: a TumbleError that names the argument, in Python's words."""

import argparse
import ast
import dataclasses
import re

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT

import tumble
from tumble.api.arguments import import_in_python, in_python
from tumble.cli.commands import import_recording
from tumble.core import built_in
from tumble.units import is_unit

pytestmark = pytest.mark.python

CSV, STAND = EXAMPLES / "paper_stand.csv", EXAMPLES / "paper_stand.toml"
NAMES = ("mounting", "position", "ux", "uy", "uz")
ROWS = np.loadtxt(CSV, delimiter=",", skiprows=1)
TABLE = dict(zip(NAMES, ROWS.T))
DATA = {"ux": [0.1], "uy": [0.1], "uz": [1.9]}
KNOWN = "mounting, position, ux, uy, uz, temperature"


@pytest.fixture(scope="module")
def result():
    return tumble.solve(CSV, stand=STAND)


def said(error, call):
    """What is said by an error of this very class, which is a ValueError too."""
    with pytest.raises(error) as caught:
        call()
    assert type(caught.value) is error and isinstance(caught.value, (tumble.TumbleError, ValueError))
    return str(caught.value)


DELIMITER = "is not a single sign that can separate columns"
LAYOUT = [
    *(({"delimiter": one}, f"delimiter: {str(one)!r} {DELIMITER}") for one in ("ab", "", 7, b",", "\n", "a", "\0")),
    *(({"decimal": one}, f"decimal: {str(one)!r} is neither a point nor a comma") for one in (";", "", 7, b".")),
    *(({"unit": one}, f"unit: {str(one)!r} is not a unit such as V, mV or m/s^2") for one in (7, "", b"V", " V")),
    ({"columns": 7}, "columns: a int is no mapping of names, such as {'mounting': 'Name'}"),
    ({"columns": ["ux"]}, "columns: a list is no mapping of names, such as {'mounting': 'Name'}"),
    ({"columns": {"ux": 7}}, "columns: '7' (for ux) is no name of a column"),
    ({"columns": {"ux": ""}}, "columns: '' (for ux) is no name of a column"),
    ({"columns": {7: "ux"}}, f"columns: '7' is not one of {KNOWN}"),
]


@pytest.mark.parametrize(("arguments", "message"), LAYOUT)
@pytest.mark.parametrize("source", [CSV, TABLE], ids=["file", "table"])
def test_a_layout_that_cannot_be_meant(source, arguments, message):
    assert said(tumble.UsageError, lambda: tumble.read(source, **arguments)) == message


@pytest.mark.parametrize("source", [CSV, TABLE], ids=["file", "table"])
def test_one_column_for_two(source):
    found = said(tumble.BadInput, lambda: tumble.read(source, columns={"ux": "uy"}))
    assert found.endswith(": column 'uy' is named for ux and uy; each has one of its own")


SOLVE = [
    *(({"limit_g": one}, f"limit_g: {str(one)!r} is not a number of g above 0, at most 1")
      for one in ("x", "3e-4", [], 1j, np.nan, np.array([1, 2]))),
    *(({"confidence": one}, f"confidence: {str(one)!r} is not a number from 0.5 to 0.999999")
      for one in ("x", None, [], 1j)),
    *(({"model": one, "estimator": "least_squares"}, f"model: {str(one)!r} is neither a text nor several")
      for one in (7, [1], None, b"k2")),
    ({"estimator": "optimal"}, 'estimator="optimal" weighs the means by the stand\'s errors: it needs stand='),
    ({"model": "k2"}, "model: refined is a closed form of twelve coefficients; use "
                      'estimator="least_squares", or optimal with stand='),
]  # fmt: skip


@pytest.mark.parametrize(("arguments", "message"), SOLVE)
def test_a_solve_that_cannot_be_meant(arguments, message):
    assert said(tumble.UsageError, lambda: tumble.solve(CSV, **arguments)) == message


def test_complex_arrays_are_refused():
    kind = "numpy.ndarray is neither a file, nor a table, nor an array of numbers"
    assert said(tumble.UsageError, lambda: tumble.read(np.zeros((2, 5), dtype=complex))) == kind


APPLY = [
    ({"columns": 7}, "columns: a int is no mapping of names, such as {'ux': 'Name'}"),
    ({"columns": {"ux": 7}}, "columns: '7' (for ux) is no name of a column"),
    ({"columns": {"mounting": "ux"}}, "columns: 'mounting' is not one of ux, uy, uz, temperature"),
    ({"outputs_unit": 7}, "outputs_unit: '7' is not a unit such as V, mV or m/s^2"),
    ({"outputs_unit": ""}, "outputs_unit: '' is not a unit such as V, mV or m/s^2"),
]


@pytest.mark.parametrize(("arguments", "message"), APPLY)
@pytest.mark.parametrize("data", [DATA, [0.0, 0.0, 1.0]], ids=["table", "array"])
def test_an_apply_that_cannot_be_meant(result, data, arguments, message):
    assert said(tumble.UsageError, lambda: result.apply(data, **arguments)) == message


def test_columns_of_different_lengths(result):
    uneven = {"ux": [1, 2], "uy": [1], "uz": [1]}
    found = said(tumble.BadInput, lambda: result.apply(uneven))
    assert found == "table: columns of different lengths: ux 2, uy 1, uz 1"


@pytest.mark.parametrize("path", [7, None, b"x"])
def test_paths_that_are_none(result, path):
    for call in (tumble.load, tumble.read_stand, result.save):
        message = f"a {type(path).__name__} is not the path of a file"
        assert said(tumble.UsageError, lambda call=call: call(path)) == message


ANGLE, VOLT = "is not a number from 0 to 0.5", "is not a number from 0 to 1e+09"
WRONG_STANDS = [
    *(("axis_tilt", one, ANGLE) for one in ("x", -1, np.nan, np.inf, None, [], 0.6)),
    *(("noise", one, VOLT) for one in ("x", -1, np.nan, np.inf, None, 1e300)),
    *(("seat", one, ANGLE) for one in ("x", np.inf)),
    ("drift", 1e300, VOLT),
    *(("samples", one, "is not a whole number from 1 to ") for one in ("x", 0, -1, 1.5, None, np.nan, 10**30)),
    *(("limits", one, "is not one of sigma1, sigma3, uniform") for one in ("x", None, [])),
    *(("remounting", one, "is not one of independent, common") for one in ("x", None, 0)),
]


@pytest.mark.parametrize(("attribute", "value", "why"), WRONG_STANDS)
def test_a_stand_that_no_file_could_declare(attribute, value, why):
    file = tumble.read_stand(str(STAND))
    stand = dataclasses.replace(file.stand, **{attribute: value})
    for declared in (stand, dataclasses.replace(file, stand=stand)):
        found = said(tumble.BadInput, lambda declared=declared: tumble.solve(CSV, stand=declared))
        assert found.startswith(f"stand: column {attribute}: {str(value)!r} {why}")


def test_schedules_that_cannot_be_used():
    paper = built_in("paper")
    first, *others = paper.positions
    for changes in ({"number": 300}, {"number": 1.5}, {"angle_deg": "x"}, {"mounting": -1}):
        schedule = tumble.Schedule(paper.mountings, (dataclasses.replace(first, **changes), *others))
        found = said(tumble.BadInput, lambda schedule=schedule: tumble.solve(CSV, schedule=schedule))
        assert found.startswith("schedule: ")
    assert said(tumble.BadInput, lambda: tumble.solve(CSV, schedule=tumble.Schedule(7, 8))).startswith("schedule: ")


ODD = [np.array([1, 2]), np.array(3), 10**400, [], {}, object(), set(), 1j, lambda: 0, b"x"]
OF_CALLS = {
    "read": ("columns", "unit", "delimiter", "decimal"),
    "solve": ("stand", "schedule", "estimator", "limit_g", "confidence", "model"),
    "compare": ("stand", "schedule", "levelled", "two_stands", "confidence"),
    "apply": ("unit", "uncertainty", "columns", "outputs_unit"),
    "plot": ("file", "kind", "run", "stand", "schedule"),
}


@pytest.mark.parametrize("argument", [f"{name}.{one}" for name, arguments in OF_CALLS.items() for one in arguments])
def test_whatever_is_given_is_refused_in_one_sentence(result, argument):
    """Or taken, as an empty list for no further terms is."""
    name, argument = argument.split(".")
    calls = {"read": lambda **given: tumble.read(CSV, **given), "solve": lambda **given: tumble.solve(CSV, **given),
             "compare": lambda **given: tumble.compare(result, result, **given),
             "apply": lambda **given: result.apply(DATA, **given),
             "plot": lambda **given: result.plot(**{"kind": "gravity_check", **given})}  # fmt: skip
    if name == "plot":
        pytest.importorskip("matplotlib")
    refused = 0
    for odd in ODD:
        try:
            calls[name](**{argument: odd})
        except tumble.TumbleError as error:
            assert "\n" not in str(error)
            refused += 1
    assert refused >= len(ODD) - 3


def test_sources_that_are_none(result):
    for odd in ODD:
        for call in (tumble.read, tumble.solve, tumble.load, tumble.read_stand, result.save, result.apply,
                     tumble.Result, lambda one: tumble.compare(one, result)):  # fmt: skip
            with pytest.raises(tumble.TumbleError):
                call(odd)


# Words.


@pytest.mark.parametrize(("told", "expected"), [
    ("name what is missing with --columns ux=NAME,uy=NAME, or add it",
     "name what is missing with columns={'ux': 'NAME', 'uy': 'NAME'}, or add it"),
    ("could both be ux; say which with --columns ux=NAME", "could both be ux; say which with columns={'ux': 'NAME'}"),
    ("look exchanged (--columns)", "look exchanged (columns=)"),
    ("(--unit V, or ux [V] in its header)", '(unit="V", or ux [V] in its header)'),
    ("not in V (--unit mV)", 'not in V (unit="mV")'),
    ("in different units: 'a', 'b'; --unit says which", "in different units: 'a', 'b'; unit= says which"),
    ("(its decimal mark? see --decimal ,)", '(its decimal mark? see decimal=",")'),
    ("what separates the columns with --delimiter", "what separates the columns with delimiter="),
    ("--model k2,k3: not told apart", 'model="k2,k3": not told apart'),
    ("--model: 'k4' is not one of", "model: 'k4' is not one of"),
    ("is a schedule file (--schedule)", "is a schedule file (schedule=)"),
    ("export it with --accelerometer 2", "export it with accelerometer=2"),
    ("--monte-carlo and --units stay", "--monte-carlo and --units stay"),
])  # fmt: skip
def test_options_become_arguments(told, expected):
    assert in_python(told) == expected == in_python(expected)


@pytest.mark.parametrize(("told", "expected"), [
    ("schedule: not given, assumed to be paper (--schedule)", "schedule: not given, assumed to be paper (schedule=)"),
    ("another block? --dbc FILE.dbc describes its frames", "another block? dbc= describes its frames"),
    ("does not fit: all of six_faces have: --schedule six_faces",
     'does not fit: all of six_faces have: schedule="six_faces"'),
    ("all of six_faces have: --schedule six_faces --order any",
     "all of six_faces have: tumble import --schedule six_faces --order any"),
    ("K positive (--columns ux=<that of uy>,uy=<that of ux> --signs=+++)",
     "K positive (tumble import --columns ux=<that of uy>,uy=<that of ux> --signs=+++)"),
    ("give the signs of K (--signs, or --stand FILE)", "give the signs of K (tumble import --signs, or --stand FILE)"),
    ("(--stand) to have V", "(tumble import --stand) to have V"),
    ("--columns mounting=: of a CAN log ux, uy and uz can be named",
     "columns: mounting: of a CAN log ux, uy and uz can be named"),
])  # fmt: skip
def test_options_that_only_an_import_has_are_told_as_its(told, expected):
    assert import_in_python(told) == expected


OF_COMMANDS = {"out", "monte-carlo", "levelled"}  # which no function of the API has
ROOMS = ("api", "files", "solving", "core", "model", "comparison", "fixture", "importing")


def test_no_sentence_that_the_api_can_say_names_an_option():
    """But those of an import: what is left there are options of `tumble import`."""
    sources = [ROOT / f"host/python/src/tumble/{name}.py" for name in ("terms", "defaults", "units", "stand")]
    for room in ROOMS:
        assert (ROOT / "host/python/src/tumble" / room / "__init__.py").is_file()
        sources += sorted((ROOT / "host/python/src/tumble" / room).glob("*.py"))
    of_import, seen = argparse.ArgumentParser(), set()
    import_recording.describe(of_import)
    for source in sources:
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and len(node.value) < 200:
                left = set(re.findall(r"--([a-z][a-z-]+)", in_python(node.value))) - OF_COMMANDS
                seen |= set(re.findall(r"--([a-z][a-z-]+)", node.value))
                if source.parent.name == "importing" or source.stem == "containers":
                    assert {f"--{one}" for one in left} <= of_import._option_string_actions.keys(), node.value
                else:
                    assert not left or "tumble " in node.value, (source, node.value)
    assert {"columns", "unit", "decimal", "model", "schedule", "signs", "order", "repeats", "leave-out"} <= seen


def test_warnings_are_told_in_arguments(tmp_path):
    found = tumble.solve(CSV)
    (warning,) = [one for one in found.warnings if "names no unit" in one]
    assert warning.endswith('(unit="V", or ux [V] in its header)')
    assert any("--unit V" in one for one in found.document["warnings"])
    unnamed = tmp_path / "--columns ux=A.csv"
    unnamed.write_text("mounting,position,ux,uz\n1,1,0,0\n")
    message = said(tumble.BadInput, lambda: tumble.solve(unnamed))
    assert message.startswith(f"{unnamed}: row 1: no column uy among") and "columns={'uy': 'NAME'}" in message


def test_units():
    assert is_unit("m/s^2") and not is_unit(" V") and not is_unit(None) and not is_unit("V" * 17)
