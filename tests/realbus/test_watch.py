"""tumble watch on a CAN interface and behind the gateway: a run to its end, and a node that goes and comes again."""

import subprocess
import sys

import documents
import pytest
from processes import HASTE, PATIENCE, Node, Stand, scenario, wait_until
from test_gateway import Served

pytest.importorskip("canopen", reason="python-canopen is not installed")
pytest.importorskip("pymodbus", reason="pymodbus is not installed")


class Watch:
    """`tumble watch SOURCE`; its lines go to a file."""

    def __init__(self, source, folder):
        self.path = folder / f"watch-{source.partition(':')[0]}"
        with open(self.path, "w") as file:
            command = [sys.executable, "-m", "tumble", "watch", source, "--every", "0.1"]
            self.process = subprocess.Popen(command, stdout=file, stderr=subprocess.STDOUT)

    def lines(self):
        return [line[9:] for line in self.path.read_text().splitlines()]

    def wait_for(self, beginning, timeout=120):
        wait_until(lambda: any(line.startswith(beginning) for line in self.lines()), timeout)

    def kill(self):
        self.process.kill()
        self.process.wait()


def snapshot(source):
    done = subprocess.run([sys.executable, "-m", "tumble", "watch", source, "--json"], capture_output=True, text=True,
                          timeout=120)
    return documents.document_of(done, "watch")["snapshot"]


def done(bus, started, folder, source, config):
    """Watch a run until it is done: the lines, and one snapshot afterwards."""
    watch = Watch(source, folder)
    started.append(watch)
    watch.wait_for("IDLE")
    started.append(Stand(bus, config, "--operator", "start"))
    watch.wait_for("DONE")
    watch.kill()
    return watch.lines(), snapshot(source)


def same(seen, document, off):
    """What was seen is what the node says at the end."""
    flat = [[value for row in k for value in row] for k in (seen["k_v_per_g"], document["K"])]
    assert flat[0] == pytest.approx(flat[1], abs=off) and seen["u0_v"] == pytest.approx(document["U0"], abs=off)
    assert (seen["state"], seen["mounting"], seen["position"], seen["finished"]) == ("DONE", 2, 9, 18)
    assert seen["gravity"]["passed"] is True and seen["run"] == 1 and seen["emergencies"] == {}


def test_a_run_on_can(bus, started, tmp_path):
    config = scenario(tmp_path, **HASTE, **PATIENCE)
    node = Node(bus, config, folder=tmp_path)
    started.append(node)
    lines, seen = done(bus, started, tmp_path, f"can:{bus}", config)
    node.signal()
    same(seen, node.wait()[1], 0.0)
    assert any(line.startswith(("AVERAGE, mounting ", "MOVE, mounting ")) for line in lines), lines


def test_a_run_behind_the_gateway(bus, started, tmp_path):
    config = scenario(tmp_path, **HASTE, **PATIENCE)
    node = Node(bus, config, folder=tmp_path)
    started.append(node)
    started.append(Served(bus))
    _, seen = done(bus, started, tmp_path, f"modbus:127.0.0.1:{started[-1].port}", config)
    node.signal()
    same(seen, node.wait()[1], 1e-8)  # as fine as its registers are


def test_a_node_that_goes_and_comes_again(bus, started, tmp_path):
    config = scenario(tmp_path, **HASTE, **PATIENCE)
    node = Node(bus, config, folder=tmp_path)
    started.append(node)
    watch = Watch(f"can:{bus}", tmp_path)
    started.append(watch)
    watch.wait_for("IDLE")
    node.kill()
    watch.wait_for("connection lost: node 1 does not answer")
    before = len(watch.lines())
    started.append(Node(bus, config, folder=tmp_path))
    wait_until(lambda: any(line.startswith("IDLE") for line in watch.lines()[before:]), 120)
    assert watch.process.poll() is None
