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


def test_a_run_on_can_and_behind_the_gateway(bus, started, tmp_path):
    config = scenario(tmp_path, **HASTE, **PATIENCE)
    node = Node(bus, config, folder=tmp_path)
    started.append(node)
    gateway = Served(bus)
    started.append(gateway)
    sources = f"can:{bus}", f"modbus:127.0.0.1:{gateway.port}"
    watches = [Watch(source, tmp_path) for source in sources]
    started.extend(watches)
    for watch in watches:
        watch.wait_for("IDLE")
    started.append(Stand(bus, config, "--operator", "start"))
    for watch in watches:
        watch.wait_for("DONE, mounting 2, position 9, 18 of 18 finished")
        assert any(line.startswith(("AVERAGE, mounting ", "MOVE, mounting ")) for line in watch.lines())
    over_can, over_modbus = map(snapshot, sources)
    node.signal()
    _, document = node.wait()
    assert over_can["k_v_per_g"] == document["K"] and over_can["u0_v"] == document["U0"]
    flat = [[value for row in one["k_v_per_g"] for value in row] for one in (over_can, over_modbus)]
    assert flat[1] == pytest.approx(flat[0], abs=1e-8)  # as fine as its registers are
    assert over_can["gravity"]["passed"] is over_modbus["gravity"]["passed"] is True
    assert over_can["run"] == over_modbus["run"] == 1
    assert over_can["emergencies"] == {}


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
