"""What a type checker says of scripts that call the package."""

import os
import subprocess
import sys

import pytest
from conftest import ROOT

pytest.importorskip("mypy")
pytestmark = [pytest.mark.python, pytest.mark.toolchain]

SCRIPT = """\
import numpy as np
import tumble

class Frame:
    @property
    def columns(self) -> list[str]: ...

result = tumble.solve("run.csv", stand=tumble.read_stand("stand.toml"))
reveal_type(result.apply(np.zeros((2, 3))))
reveal_type(result.apply([0.0, 1.0, 2.0]))
reveal_type(result.apply({"ux": [1.0]}))
reveal_type(result.apply(Frame()))
reveal_type(result.u_K)
tumble.solve("run.csv", estimatr="refined")
"""
ARRAY = "numpy.ndarray[tuple[Any, ...], numpy.dtype[numpy.float64]]"
SAID = {9: ARRAY, 10: ARRAY, 11: "dict[str, Any]", 12: "script.Frame", 13: f"{ARRAY} | None"}


def test_arrays_stay_arrays_and_frames_frames(tmp_path):
    (tmp_path / "script.py").write_text(SCRIPT)
    options = ["--strict", "--explicit-package-bases", "--ignore-missing-imports", "--python-version", "3.11"]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *options, "--allow-empty-bodies", "script.py"],
        cwd=tmp_path, capture_output=True, text=True,
        env={**os.environ, "MYPYPATH": f"{ROOT}/host/python/src:{ROOT}/host/python/binding"},
    )  # fmt: skip
    told = [line.split(":", 3) for line in done.stdout.splitlines() if line.startswith("script.py:")]
    for number, kind in SAID.items():
        [said] = [text for _, line, _, text in told if int(line) == number]
        assert said.strip().replace("builtins.", "").replace("Union[", "") == f'Revealed type is "{kind}"'
    [error] = [(line, text) for _, line, level, text in told if level == " error"]
    assert error[0] == "14" and 'Unexpected keyword argument "estimatr"' in error[1]
