"""The examples: made by the script from stated truth, and solved as the documentation says."""

import json
import subprocess
import sys

import numpy as np
import pytest
from conftest import EXAMPLES


def test_generating_again_gives_the_same_bytes(tmp_path):
    subprocess.run([sys.executable, EXAMPLES / "generate.py", tmp_path], check=True)
    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == sorted(path.name for path in [*EXAMPLES.glob("*.csv"), *EXAMPLES.glob("*.truth.json")])
    for name in made:
        assert (tmp_path / name).read_bytes() == (EXAMPLES / name).read_bytes(), name


@pytest.mark.parametrize("stand", ["paper_stand", "angle_stand", "lab_stand"])
def test_the_stands(stand, tumble):
    done = tumble("solve", f"{stand}.csv", "--unit", "V", "--stand", f"{stand}.toml", cwd=EXAMPLES)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("schedule", ["diagonal", "three_mountings"])
def test_the_stands_of_three_mountings(schedule, tumble):
    name = f"{schedule}_stand"
    done = tumble("solve", f"{name}.csv", "--schedule", schedule, "--stand", f"{name}.toml", "--json", cwd=EXAMPLES)
    assert (done.returncode, done.stderr) == (0, "")
    result, truth = json.loads(done.stdout), json.loads((EXAMPLES / f"{name}.truth.json").read_text())
    errors = np.subtract([*result["K"], result["U0"]], [*truth["K"], truth["U0"]])
    assert np.abs(errors / [*result["u_K"], result["u_U0"]]).max() < 4.0


@pytest.mark.parametrize(
    ("schedule", "options"),
    [
        ("six_faces", ["--estimator", "least_squares"]),
        ("with_checks", []),
        ("with_checks", ["--estimator", "least_squares"]),
    ],
)
def test_the_schedules(schedule, options, tumble):
    arguments = [f"{schedule}.csv", "--schedule", f"{schedule}.toml", "--stand", "paper_stand.toml", *options]
    done = tumble("solve", *arguments, "--unit", "V", cwd=EXAMPLES)
    assert (done.returncode, done.stderr) == (0, "")


def test_examples_are_small():
    assert sum(path.stat().st_size for path in EXAMPLES.iterdir()) < 200_000
