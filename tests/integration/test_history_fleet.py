"""A simulated fleet in `tumble history`, by its benchmark: alarms, due dates and seconds."""

import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests/benchmark"))

import history as benchmark

pytestmark = [pytest.mark.python, pytest.mark.slow]


def check(found):
    assert found["false alarms, of calibrations in order"] < 0.0035  # stated: 0.0027
    for name in found:
        if "missed" in name or "something else" in name:
            assert found[name] < 0.06, name
    assert found["exchanged seats told as such"] > 0.97
    assert found["due date off, 95th percentile"] < 0.06
    assert found["within the limit when due (k = 2)"] > 0.945


def test_a_thousand_blocks(tmp_path):
    pytest.importorskip("pyarrow")
    check(benchmark.measured(1000, 10, str(tmp_path / "history.db"), str(tmp_path / "h.parquet"), with_lines=False))


@pytest.mark.full
def test_a_hundred_thousand_calibrations(tmp_path):
    """In seconds: no longer than pandas takes for straight lines."""
    pytest.importorskip("pandas")
    found = benchmark.measured(10_000, 10, str(tmp_path / "history.db"), str(tmp_path / "h.parquet"))
    check(found)
    assert found["trend, s"] < 2.0 * found["straight lines by pandas, s"]
    assert found["due, s"] < 3.0 * found["straight lines by pandas, s"]
