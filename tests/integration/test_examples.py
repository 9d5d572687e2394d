"""The examples: made by the script from stated truth, and solved as the documentation says."""

import hashlib
import json
import subprocess
import sys

import numpy as np
import pytest
from conftest import EXAMPLES, ROOT

RECORDED = "hand_held_session.csv"
RECORDED_SHA256 = "ff5abc117afa539ac0daf082fa9e18c0661fb6ee566e2b4418c12516d1665737"


def test_generating_again_gives_the_same_bytes(tmp_path):
    subprocess.run([sys.executable, EXAMPLES / "generate.py", tmp_path], check=True)
    made = sorted(path.name for path in tmp_path.iterdir())
    there = [*EXAMPLES.glob("*.csv"), *EXAMPLES.glob("*.truth.json")]
    assert made == sorted(path.name for path in there if path.name != RECORDED)
    for name in made:
        assert (tmp_path / name).read_bytes() == (EXAMPLES / name).read_bytes(), name


NOT_SHOWN = 1, "uncertainty"
SHOWN = 0, None


@pytest.mark.parametrize("stand, verdict", [("paper_stand", SHOWN), ("angle_stand", SHOWN), ("lab_stand", NOT_SHOWN)])
def test_the_stands(stand, verdict, tumble):
    done = tumble("solve", f"{stand}.csv", "--unit", "V", "--stand", f"{stand}.toml", "--json", cwd=EXAMPLES)
    assert ((done.returncode, json.loads(done.stdout)["pass_reason"]), done.stderr) == (verdict, "")


@pytest.mark.parametrize("schedule", ["diagonal", "three_mountings"])
def test_the_stands_of_three_mountings(schedule, tumble):
    name = f"{schedule}_stand"
    done = tumble("solve", f"{name}.csv", "--schedule", schedule, "--stand", f"{name}.toml", "--json", cwd=EXAMPLES)
    assert (done.returncode, done.stderr) == (0, "")
    result, truth = json.loads(done.stdout), json.loads((EXAMPLES / f"{name}.truth.json").read_text())
    errors = np.subtract([*result["K"], result["U0"]], [*truth["K"], truth["U0"]])
    assert np.abs(errors / [*result["u_K"], result["u_U0"]]).max() < 4.0


@pytest.mark.parametrize(
    ("schedule", "options", "verdict"),
    [
        ("six_faces", ["--estimator", "least_squares"], NOT_SHOWN),
        ("with_checks", [], SHOWN),
        ("with_checks", ["--estimator", "least_squares"], NOT_SHOWN),
    ],
)
def test_the_schedules(schedule, options, verdict, tumble):
    arguments = [f"{schedule}.csv", "--schedule", f"{schedule}.toml", "--stand", "paper_stand.toml", *options]
    done = tumble("solve", *arguments, "--unit", "V", "--json", cwd=EXAMPLES)
    assert ((done.returncode, json.loads(done.stdout)["pass_reason"]), done.stderr) == (verdict, "")


def test_examples_are_small():
    assert sum(path.stat().st_size for path in EXAMPLES.iterdir() if path.name != RECORDED) < 250_000


def test_what_others_recorded_has_their_notice():
    """Their bytes, and their licence beside them."""
    assert hashlib.sha256((EXAMPLES / RECORDED).read_bytes()).hexdigest() == RECORDED_SHA256
    notice = (EXAMPLES / "LICENSE-imucal.txt").read_text()
    assert "MIT License" in notice and "MaD-Lab Erlangen" in notice
    assert RECORDED in (ROOT / "NOTICE").read_text()
