"""The static analysis of the long run rejects planted violations and accepts the same code without them."""
import pytest
from conftest import ROOT, run

from stages import PYTHON

REJECTED = {  # gate: what it must say
    "misra": "misra-c2012-11.3",
    "tidy": "[clang-analyzer-core.DivideZero",
    "analyzer": "[-Werror=analyzer-null-dereference]",
}


def analyse(gate, file):
    result = run(PYTHON, "tools/analyse.py", gate, file)
    if result.returncode == 77:
        pytest.skip(result.stdout.strip())
    return result


@pytest.mark.parametrize("gate", REJECTED)
def test_rejects(gate):
    result = analyse(gate, f"tests/canary/analysis/{gate}.c")
    assert result.returncode == 1
    assert REJECTED[gate] in result.stdout, result.stdout


@pytest.mark.parametrize("gate", REJECTED)
def test_accepts(gate):
    result = analyse(gate, "tests/canary/analysis/clean.c")
    assert result.returncode == 0, result.stdout


def test_a_missing_tool_is_a_skip_and_not_a_pass(tmp_path):
    result = run(PYTHON, "-S", "-c", f"import sys; sys.path.insert(0, {str(ROOT / 'tools')!r}); import analyse; "
                 "sys.exit(analyse.main(['tidy']))", PATH=str(tmp_path))
    assert (result.returncode, result.stdout) == (77, "clang-tidy is not installed\n")
