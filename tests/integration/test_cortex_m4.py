"""The instruction counts of the estimators on a Cortex-M4: the command runs, and what the documentation says of it holds."""

import json
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT

PROGRAMS = ("arm-none-eabi-gcc", "qemu-system-arm")
MISSING = [program for program in PROGRAMS if shutil.which(program) is None]
pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(MISSING), reason=f"not there: {', '.join(MISSING)}")]


def benchmark(*options):
    command = [sys.executable, ROOT / "tests/benchmark/cortex_m4.py", *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)


def test_what_the_estimators_cost():
    result = benchmark("--json")
    assert result.returncode == 0, result.stderr
    costs = {name: cost["instructions"] for name, cost in json.loads(result.stdout).items()}
    stacks = {name: cost["stack"] for name, cost in json.loads(result.stdout).items()}
    refined, table = costs["refined"], costs["optimal: table, 2nd order"]
    assert 60_000 < refined < 90_000
    assert refined < costs["optimal, linear: table alone"] < 3 * refined
    assert table < 13 * refined
    assert costs["least_squares: 4 unknowns"] < 0.6 * costs["12 unknowns, normal equations"]
    assert costs["12 unknowns, normal equations"] < costs["12 unknowns, Householder QR"]
    assert stacks["optimal: table, 2nd order"] < 704
    assert stacks["12 unknowns, normal equations"] > 1200


def test_a_table_is_printed_with_ratios():
    result = benchmark()
    assert result.returncode == 0, result.stderr
    header, first, *rest = result.stdout.splitlines()
    assert header.split() == ["instructions", "ratio", "code", "library", "data", "stack"]
    assert first.split()[0] == "refined" and first.split()[2] == "1.00"
    assert len(rest) == 6
