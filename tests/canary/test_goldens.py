"""tools/goldens rejects another digit in a golden and another constant in the product."""
import os
import shutil

import pytest
from conftest import ROOT, run
from stages import PYTHON

PASSED = (0, "goldens: as before\n")
PLANTED = {  # session: a part of it, what stands there instead
    "a digit of a text": ("solve", "+2.001443346", "+2.001443347"),
    "a digit of a digest": ("memory", "kept.bin 233a", "kept.bin edf5"),
    "a number that may differ in the last places, by more": ("solve", "misfit ~ 0.98904316", "misfit ~ 0.98904317"),
    "an exit code": ("refusals", "= 2", "= 1"),
}


def check(golden, name):
    done = run(PYTHON, "tools/goldens", "check", name, TUMBLE_GOLDEN=str(golden))
    return done.returncode, done.stdout


@pytest.mark.parametrize("defect", PLANTED)
def test_another_golden(defect, tmp_path):
    name, part, instead = PLANTED[defect]
    shutil.copytree(ROOT / "tests/golden", tmp_path / "golden")
    session = tmp_path / f"golden/sessions/{name}.txt"
    sound = session.read_text()
    assert part in sound
    session.write_text(sound.replace(part, instead, 1))
    code, said = check(tmp_path / "golden", name)
    assert code == 1 and said.endswith(f"goldens: {name} not as before\n"), said
    assert said.count("\n-") == said.count("\n+") - 1 == 1, said  # beside the head: the defect, and what is right
    session.write_text(sound)
    assert check(tmp_path / "golden", name) == PASSED


def test_another_product(tmp_path):
    shutil.copytree(ROOT / "tools", tmp_path / "tools")
    shutil.copytree(ROOT / "host/python", tmp_path / "host/python")
    for name in ("examples", "tests", "build", ".venv"):
        os.symlink(ROOT / name, tmp_path / name)
    source = tmp_path / "host/python/src/tumble/defaults.py"
    sound = source.read_text()
    assert sound.count("DEFAULT_LIMIT_G = 3e-4") == 1
    source.write_text(sound.replace("DEFAULT_LIMIT_G = 3e-4", "DEFAULT_LIMIT_G = 4e-4"))
    done = run(PYTHON, tmp_path / "tools/goldens", "check", "solve")
    assert done.returncode == 1 and "\n-| Gravity check" in done.stdout, done.stdout
    source.write_text(sound)
    done = run(PYTHON, tmp_path / "tools/goldens", "check", "solve")
    assert (done.returncode, done.stdout) == PASSED
