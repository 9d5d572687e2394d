"""A layer that only passes a sample on is rejected: it is one function more than a sample may enter."""
import shutil
import sys

import pytest
from conftest import ROOT, planted, run

READ = ("firmware", "host/simulation", "tests/benchmark/sample_way", "tests/integration/plain_unity", "tests/lib")
ENGINE = "firmware/procedure/procedure.c"
LAYER = """static outcome_t look_between(tumble_procedure_t *procedure, const tumble_row_t *row)
{
    return check_row(procedure, row, BETWEEN_REPORTS);
}

bool tumble_procedure_sample("""


@pytest.mark.skipif(shutil.which("addr2line") is None, reason="addr2line is not installed")
def test_a_layer_that_only_passes_on_is_rejected(tmp_path):
    for folder in READ:
        shutil.copytree(ROOT / folder, tmp_path / folder)
    with planted(tmp_path, [(ENGINE, "bool tumble_procedure_sample(", LAYER),
                            (ENGINE, "check_row(procedure, row, BETWEEN_REPORTS);\n    if (outcome",
                             "look_between(procedure, row);\n    if (outcome")]):
        result = run(sys.executable, ROOT / "tests/benchmark/sample_way.py", "--root", tmp_path)
    assert result.returncode == 1 and result.stdout.startswith("26 functions in 12 files, at most 25:"), result.stdout
    assert "  look_between\n" in result.stdout
    sound = run(sys.executable, ROOT / "tests/benchmark/sample_way.py", "--root", tmp_path)
    assert sound.returncode == 0 and "look_between" not in sound.stdout
