"""tumble-node is killed in the middle of a run (kill -9: its power) and goes on from its memory when it is back."""

import signal
import time

import pytest
from processes import HASTE, PATIENCE, Node, Stand, scenario, wait_until
from recalibration import Computer

RESUMED = 1 << 5  # of a set's flags
POSITIONS = 18


@pytest.fixture
def switch_on(bus, network, started, tmp_path):
    """Start the node; back when its heartbeat is there."""
    path = scenario(tmp_path, **HASTE, **PATIENCE)
    heard = []
    network.subscribe(0x701, lambda identifier, data, stamp: heard.append(data))

    def start():
        heard.clear()
        node = Node(bus, path, "--nv", tmp_path / "memory", folder=tmp_path)
        started.append(node)
        wait_until(lambda: heard)
        return node

    return start


def test_killed_twice_it_goes_on(bus, network, started, switch_on, tmp_path):
    stand = Stand(bus, scenario(tmp_path, **HASTE, **PATIENCE), "--seed", 11, "--operator", "ask")
    started.append(stand)
    mounted = [1]

    def mount(number):
        if number == mounted[0]:
            return False
        mounted[0] = number
        stand.say("done")
        return True

    computer = Computer(network, lambda ms: time.sleep(ms / 1000), mount, timeout=5.0)
    node = switch_on()
    computer.wait(lambda: computer.state() == "IDLE", step_ms=20)
    command, resumable = "START", 0
    for cut in (4, 12):
        computer.command(command)
        reach(computer, mount, cut)
        node.signal(signal.SIGKILL)
        node.process.wait()
        node = switch_on()
        computer.wait(lambda: computer.state() == "IDLE", step_ms=20)
        resumable = computer["Keeper"]["Resumable positions"].raw
        assert resumable >= cut, "every finished position is kept, but for one that was just being written"
        command = "RESUME"
    computer.command(command)
    computer.wait(lambda: computer.state() != "IDLE", step_ms=20)
    computer.finish_run()

    assert computer["Procedure counters"]["Positions"].raw == POSITIONS - resumable
    assert computer["Proposal"]["Flags"].raw & RESUMED
    assert "FIRST" in computer.objections()
    assert computer.coefficients("Proposal: ") == computer.coefficients()
    assert computer["Keeper"]["Resumable positions"].raw == 0


def reach(computer, mount, finished):
    """Confirm mountings until so many positions are finished, and a moment longer."""
    def there():
        if computer.state() == "WAIT_MOUNTING":
            number = computer["Progress"]["Mounting number"].raw
            if not mount(number):
                computer.command("CONFIRM_MOUNTING", number)
            computer.wait(lambda: computer.state() != "WAIT_MOUNTING", step_ms=20)
        return computer["Progress"]["Positions finished"].raw >= finished

    computer.wait(there, step_ms=20)
    time.sleep(0.3)
