"""The instruction counts of the estimators on a Cortex-M4: the command runs, what the documentation says holds."""

import json
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests/benchmark"))

import costs_page as page

PROGRAMS = ("arm-none-eabi-gcc", "qemu-system-arm")
MISSING = [program for program in PROGRAMS if shutil.which(program) is None]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.toolchain,
    pytest.mark.skipif(bool(MISSING), reason=f"not there: {', '.join(MISSING)}"),
]


def benchmark(*options):
    command = [sys.executable, ROOT / "tests/benchmark/cortex_m4.py", *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def told():
    """What docs/performance.md says: by row, {instructions, code, data, stack, formula where there is one}."""
    rows = page.rows_of(page.table_of(page.PAGE.read_text(encoding="utf-8"), "cortex_m4"))
    names = {"instructions": "instructions", "code": "code, B", "data": "constants, B", "stack": "stack, B"}
    said = {row: {name: page.number(cells[column]) for name, column in names.items()} for row, cells in rows.items()}
    return {row: {**said[row], "formula": page.number(cells["formula"])} for row, cells in rows.items()}


def beyond(found, told):
    """Rows of which something is off by more than 2 %: (found, told). A row that only one of them has is one too."""
    off = {name: (found.get(name), told.get(name)) for name in found.keys() ^ told.keys()}
    for name in found.keys() & told.keys():
        measured = {key: found[name][key] for key in told[name]}
        if any(is_off(measured[key], said) for key, said in told[name].items()):
            off[name] = measured, told[name]
    return off


def is_off(measured, said):
    """None: there is no such figure."""
    return measured is not said if None in (measured, said) else abs(measured - said) > 0.02 * said


def test_a_row_that_is_off_is_named():
    row = {"instructions": 1000, "code": 200, "data": 0, "stack": 56}
    slower, larger, reaching = row | {"instructions": 1021}, row | {"code": 205}, row | {"data": 4}
    assert beyond({"a": row | {"instructions": 1020, "library": 7}}, {"a": row}) == {}
    for other in (slower, larger, reaching, row | {"instructions": 979}):
        assert beyond({"a": other}, {"a": row}) == {"a": (other, row)}
    formula = row | {"formula": 100}
    assert beyond({"a": formula}, {"a": formula}) == {}
    without = row | {"formula": None}
    assert beyond({"a": without}, {"a": formula}) and beyond({"a": formula}, {"a": without})
    assert beyond({"a": row}, {}) == {"a": (row, None)} and beyond({}, {"a": row}) == {"a": (None, row)}


def test_what_the_estimators_cost():
    result = benchmark("--json")
    assert result.returncode == 0, result.stderr
    found = json.loads(result.stdout)
    steps = found.pop("steps")
    check_whole_model(found.pop("whole_model"))
    check_operations(found.pop("operations"), found["division of the 54 means"]["formula"])
    assert beyond(found, told()) == {}
    costs = {name: cost["instructions"] for name, cost in found.items()}
    stacks = {name: cost["stack"] for name, cost in found.items()}
    refined, table = costs["refined"], costs["optimal: table, 2nd order"]
    assert table < 90 * refined
    assert refined < costs["optimal, linear: table alone"] < table
    assert 1.8 * refined < costs["4 unknowns, shared normal matrix"] < costs["least_squares: 4 unknowns"]
    assert costs["least_squares: 4 unknowns"] < 0.6 * costs["12 unknowns, normal equations"]
    assert costs["12 unknowns, normal equations"] < costs["12 unknowns, Householder QR"]
    assert stacks["optimal: table, 2nd order"] < 880  # its row
    assert stacks["12 unknowns, normal equations"] > 1200
    check_steps(steps)


def check_operations(operations, means):
    """A division takes the longest; the formula of the means has 54 of them, and as many products."""
    assert list(operations) == ["addition", "multiplication", "division"]
    assert 20 < operations["multiplication"] < 5 * operations["addition"] < operations["division"] < 2000
    assert means == 54 * (operations["division"] + operations["multiplication"])


def check_whole_model(whole):
    """No step is much longer than the look at the noise of a run."""
    assert list(whole) == ["paper", "three_mountings", "diagonal"]
    for taken, instructions, longest, stack in whole.values():
        assert taken < 2000 and 20e6 < instructions < 60e6 and instructions / taken < longest < 68_000
        assert stack < 1008  # its row


def check_steps(steps):
    if steps is None:
        pytest.skip("Unity is not there: the steps of the navigation computer were left out")
    for steps_taken, mean, least, most, state in steps.values():
        assert steps_taken > 100 and 0 < least <= mean <= most and state.startswith("TUMBLE_STATE_")
    assert steps["an idle step"][1] < 400
    assert steps["a step with a sample"][2] < 3000


def test_a_table_is_printed_with_ratios():
    result = benchmark()
    assert result.returncode == 0, result.stderr
    estimators, operations, whole, steps, budget, honest = result.stdout.split("\n\n")
    header, first, *rest = estimators.splitlines()
    assert header.split() == ["instructions", "ratio", "code", "library", "data", "stack"]
    assert first.split()[0] == "refined" and first.split()[2] == "1.00"
    assert len(operations.splitlines()) == 4
    assert len(rest) == 24 and len(whole.splitlines()) == 4
    assert "LEFT OUT" in steps or len(steps.splitlines()) == 4
    assert budget.splitlines()[0].split()[-4:] == ["code", "library", "static_ram", "stack"]
    for target in ("cortex-m4", "cortex-a53"):
        assert f"{target} navcomp " in budget or "LEFT OUT" in budget
    assert "The honest comparison is with the shared normal matrix of four unknowns" in " ".join(honest.split())
