"""The Python in docs/operations.md: it calibrates, on a bus where nobody but the script talks to node 1."""

import re
import subprocess
import sys

import numpy as np
import pytest
from conftest import ROOT
from processes import HASTE, PATIENCE, Node, Stand, scenario

pytest.importorskip("canopen", reason="python-canopen is not installed")
PAGE = re.search(r"```python\n(.*?)```", (ROOT / "docs/operations.md").read_text(encoding="utf-8"), re.DOTALL)[1]


def test_the_example_calibrates_and_accepts(bus, network, started, tmp_path):
    path = scenario(tmp_path, **HASTE, **PATIENCE)
    stand = Stand(bus, path, "--seed", 7, "--operator", "hands")
    node = Node(bus, path, "--nv", tmp_path / "nv.bin", folder=tmp_path)
    started += [stand, node]
    network.add_node(1, str(ROOT / "docs/eds/tumble_navcomp.eds")).nmt.wait_for_heartbeat(timeout=10)
    assert PAGE.count('channel="can0"') == 1
    done = subprocess.run([sys.executable, "-c", PAGE.replace('channel="can0"', f'channel="{bus}"')], cwd=ROOT,
                          input="\n\nyes\n", capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    for said in ("the block on in mounting 1, ", "the block on in mounting 2, ", "DONE; gravity check passed\n",
                 "verdict 5, accepted; calibration counter 1\n"):
        assert done.stdout.count(said) == 1, done.stdout
    k = [float(number) for number in re.search(r"^K \[(.*)\]$", done.stdout, re.MULTILINE)[1].split(", ")]
    node.signal()
    assert node.wait()[0] == 0
    truth = stand.end()
    assert np.abs(np.reshape(k, (3, 3)) - truth["truth"]["K"]).max() < 3e-3
    assert truth["operator"] == {"answers": 0, "refusals": 0}
    dumped = subprocess.run([sys.executable, "-m", "tumble", "store", "dump", tmp_path / "nv.bin"], capture_output=True,
                            text=True, timeout=60)
    assert "accepted" in dumped.stdout, dumped.stdout
