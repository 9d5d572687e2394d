"""The Python in docs/operations.md and docs/client.md: it calibrates, over CAN and over Modbus, where nobody but the
script talks to node 1."""

import ast
import re
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import ROOT
from processes import HASTE, PATIENCE, Node, Stand, scenario
from test_fixture_scripts import served

pytest.importorskip("canopen", reason="python-canopen is not installed")


def blocks(name, title):
    """The Python of a page's section of this title."""
    page = (ROOT / f"docs/{name}.md").read_text(encoding="utf-8")
    text = page.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    return re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


[CALIBRATION] = blocks("operations", "5. The first calibration")
OVER_CAN, OVER_MODBUS, CANOPEN = blocks("client", "Talk to a node")


@pytest.fixture
def stand(bus, network, started, tmp_path):
    """(node, stand) that wait for commands; the person mounts what is asked for."""
    path = scenario(tmp_path, **HASTE, **PATIENCE)
    made = Stand(bus, path, "--seed", 7, "--operator", "on-confirm")
    node = Node(bus, path, "--nv", tmp_path / "nv.bin", folder=tmp_path)
    started += [made, node]
    network.add_node(1, str(ROOT / "docs/eds/tumble_navcomp.eds")).nmt.wait_for_heartbeat(timeout=10)
    return node, made


def printed(block, answers, **replaced):
    """What a block prints, with another link in place of the page's."""
    for theirs, ours in replaced.values():
        assert block.count(theirs) == 1
        block = block.replace(theirs, ours)
    done = subprocess.run([sys.executable, "-c", block], cwd=ROOT, input=answers, capture_output=True, text=True,
                          timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    require_asked(done.stdout, 1 if answers else 0)
    return done.stdout


def require_asked(said, times):
    """For both mountings, so often."""
    for number in (1, 2):
        assert said.count(f"the block on in mounting {number}, ") == times, said


def accepted(stand, tmp_path, k):
    """The coefficients that were printed are those of the block, and the memory has them as accepted."""
    node, made = stand
    node.signal()
    assert node.wait()[0] == 0
    truth = made.end()
    assert np.abs(np.reshape(k, (3, 3)) - truth["truth"]["K"]).max() < 3e-3
    assert truth["operator"] == {"answers": 0, "refusals": 0}
    dumped = subprocess.run([sys.executable, "-m", "tumble", "store", "dump", tmp_path / "nv.bin"], capture_output=True,
                            text=True, timeout=60)
    assert "accepted" in dumped.stdout, dumped.stdout


def matrix(said):
    """The first nine numbers."""
    return [float(number) for number in re.findall(r"-?\d+\.\d*(?:e-?\d+)?", said)[:9]]


def test_ten_lines_calibrate_and_accept_over_can(bus, stand, tmp_path):
    link = ('"can:can0"', f'"can:{bus}"')
    said = printed(CALIBRATION, "\n\nyes\n", link=link)
    assert "HELD\nFIRST, there is no active set to compare with\n" in said
    assert said.endswith("ACCEPTED - calibration counter 1\n"), said
    again = printed(OVER_CAN, "\n\n", link=link)  # on the node that has a set now
    assert re.match("DONE - nothing is wrong\n", again) and re.search(r"^(COMMITTED|HELD \w+)", again, re.MULTILINE)
    for text in (said, again):
        assert np.abs(np.diag(np.reshape(matrix(text), (3, 3))) + 2.0).max() < 0.1, text
    accepted(stand, tmp_path, matrix(said))


def test_ten_lines_calibrate_and_accept_over_modbus(bus, stand, started, tmp_path):
    pytest.importorskip("pymodbus", reason="pymodbus is not installed")
    link = served(bus, started)
    said = printed(OVER_MODBUS, "", link=('"modbus:127.0.0.1:1502"', f'"{link}"'))
    assert re.match(r"10 50 ms\n0 IDLE 0/\d+ NONE\n", said), said
    said = printed(CALIBRATION, "\n\nyes\n", link=('"can:can0"', f'"{link}"'))
    assert "HELD\nFIRST, there is no active set to compare with\n" in said
    assert said.endswith("ACCEPTED - calibration counter 1\n"), said
    accepted(stand, tmp_path, matrix(said))


def test_python_canopen_alone_calibrates_and_accepts(bus, stand, tmp_path):
    said = printed(CANOPEN, "\n\nyes\n", link=('channel="can0"', f'channel="{bus}"'))
    for line in ("DONE; gravity check passed\n", "verdict 5, accepted; calibration counter 1\n"):
        assert said.count(line) == 1, said
    accepted(stand, tmp_path, ast.literal_eval(re.search(r"^K (\[.*\])$", said, re.MULTILINE)[1]))


def answered(block, pace_s, **replaced):
    """What a block prints to a person who thinks for so long before each answer."""
    for theirs, ours in replaced.values():
        block = block.replace(theirs, ours)
    process = subprocess.Popen([sys.executable, "-u", "-c", block], cwd=ROOT, stdin=subprocess.PIPE,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    said = b""
    while character := process.stdout.read(1):
        said += character
        if said.endswith((b", then Enter ", b"to accept: ")):
            time.sleep(pace_s)
            process.stdin.write(b"\n" if said.endswith(b"Enter ") else b"yes\n")
            process.stdin.flush()
    assert process.wait(timeout=20) == 0, said.decode()
    return said.decode()


PACES_S = [0.0, *(0.001 * 1.6**power for power in range(19))]  # to a person's 4.7 s for each answer


def test_the_paces_are_twenty_from_at_once_to_a_persons():
    assert len(PACES_S) == 20 and PACES_S[0] == 0 and 4 < PACES_S[-1] < 5


@pytest.mark.full
@pytest.mark.parametrize("pace_s", PACES_S)
@pytest.mark.parametrize("name", ["ten lines over CAN", "ten lines over Modbus", "python-canopen alone"])
def test_the_examples_work_at_any_pace(bus, stand, started, name, pace_s):
    link = served(bus, started) if name.endswith("Modbus") else f"can:{bus}"
    replaced = {"link": ('"can:can0"', f'"{link}"'), "channel": ('channel="can0"', f'channel="{bus}"')}
    said = answered(CANOPEN if name.endswith("alone") else CALIBRATION, pace_s, **replaced)
    require_asked(said, 1)
    assert re.search(r"accepted; calibration counter 1\n$|ACCEPTED - calibration counter 1\n$", said), said
