"""A person at the terminal, on a real bus: mountings are confirmed, faults are mended, node 1 is told by SDO."""

import json
import os
import signal
import subprocess
import sys
import time

import can
from processes import HASTE, Node, Stand, scenario, wait_until
from simulated_bench import HASTY_STAND

CONFIRM = (0x401, bytes.fromhex("2F02200203000000"))  # 2002h:2, command 3


def answer(child, said, asked, line):
    """Once it has asked."""
    wait_until(lambda: asked in said.read_text() or "Fault: " in said.read_text() or child.poll() is not None)
    assert asked in said.read_text(), said.read_text()
    child.stdin.write(line + "\n")
    child.stdin.flush()


def test_mountings_are_confirmed_at_the_terminal(bus, started, tmp_path):
    (tmp_path / "stand.toml").write_text(HASTY_STAND)
    options = ["--stand", tmp_path / "stand.toml", "--out", tmp_path / "run", "--interactive", "--json"]
    said = tmp_path / "said"
    with open(said, "w") as errors:
        child = subprocess.Popen(
            [sys.executable, "-m", "tumble", "bench", "--bus", f"socketcan:{bus}", *map(str, options)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, text=True, env=dict(os.environ)
        )
    started.append(child)
    answer(child, said, "Mount the block as mounting 1 says", "well")
    answer(child, said, "not accepted: an answer is done, abort, leave, repeat position INDEX", "repeat position 17")
    answer(child, said, "not accepted: the navigation computer does not take this command now\n", "")
    answer(child, said, "Mount the block as mounting 2 says", "")
    out, _ = child.communicate(timeout=60)
    assert child.returncode == 0, said.read_text()
    assert json.loads(out)["bus"] == f"socketcan:{bus}"
    log = can.CanutilsLogReader(str(tmp_path / "run/bus.log"))
    assert [(frame.arbitration_id, bytes(frame.data)) for frame in log].count(CONFIRM) == 2


def faulty(bus, started, tmp_path):
    """A drive that has faulted on its way to position 1.2, and a person who is asked: (node, stand)."""
    path = scenario(tmp_path, **HASTE, fault="drive_fault at=1.2 phase=move duration=0.1 value=0x7500")
    stand = Stand(bus, path, "--operator", "ask")
    node = Node(bus, path, "--start", "--patience", 60, "--out", tmp_path / "run", folder=tmp_path)
    started.extend([stand, node])
    node.wait_for("WAIT_MOUNTING")
    stand.say("done")
    assert node.wait_for("FAULT")["reason"] == "TUMBLE_REASON_DRIVE_FAULT"
    return node, stand


def test_a_fault_that_a_person_mends_and_repeats_a_position(bus, started, tmp_path):
    node, stand = faulty(bus, started, tmp_path)
    time.sleep(0.3)  # it has gone by itself
    stand.say("repeat position 0")
    node.wait_for("MOVE", 3)
    node.wait_for("WAIT_MOUNTING", 9)
    stand.say("done")
    code, document = node.wait()
    assert (code, document["end"], document["counters"]["faults"]) == (0, "done", 1), document["reason"]
    moves = [event["index"] for event in node.events() if event.get("state") == "TUMBLE_STATE_MOVE"]
    assert moves.count(0) == 2
    assert stand.end()["operator"] == {"answers": 3, "refusals": 0}


def test_a_fault_that_a_person_leaves_as_it_is(bus, started, tmp_path):
    node, stand = faulty(bus, started, tmp_path)
    node.signal(signal.SIGUSR1)
    code, document = node.wait(timeout=10)
    assert (code, document["end"], document["reason"]) == (3, "fault", "TUMBLE_REASON_DRIVE_FAULT")
    assert stand.end()["table"]["at_rest"]


def test_a_command_that_node_1_refuses_is_told_and_may_be_followed_by_another(bus, started, tmp_path):
    node, stand = faulty(bus, started, tmp_path)
    stand.say("repeat mounting 7")
    wait_until(lambda: any(event["event"] == "refused" for event in node.events()), timeout=5)
    stand.say("nonsense")
    stand.say("abort")
    code, document = node.wait(timeout=10)
    assert (code, document["state"]) == (3, "TUMBLE_STATE_ABORT")
    ended = stand.end()
    assert ended["operator"] == {"answers": 2, "refusals": 1}
    assert stand.errors == "tumble-stand: ignored, it answers no open question: nonsense\n"
