"""tests/golden/sessions: the command line does what it did. `tools/goldens` says how a session is written."""

import subprocess
import sys

import pytest
from conftest import ROOT

pytestmark = [pytest.mark.python, pytest.mark.slow]
NAMES = sorted(path.stem for path in (ROOT / "tests/golden/sessions").glob("*.txt"))
LONG = ("seeds-angle", "seeds-lab", "seeds-paper")  # seeds-schedules has every schedule and estimator


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.full] * (name in LONG)) for name in NAMES])
def test_session(name):
    done = subprocess.run([sys.executable, "tools/goldens", "check", name], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "goldens: as before\n"), done.stdout + done.stderr


def test_a_session_that_is_not_there():
    done = subprocess.run([sys.executable, "tools/goldens", "nonsense"], cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "goldens: no such session: nonsense\n")
