"""python-canopen drives recalibrations of tumble-node with its non-volatile memory in a file, against tumble-stand,
from the EDS file alone: limits, start, mountings, result, proposal, accept, rollback, saved parameters, and a
restart."""

import time

from processes import HASTE, PATIENCE, Node, Stand, scenario, wait_until
from recalibration import Computer, refusal_of

DEVICE_STATE = 0x08000022


class Table:
    """The stand, and the person at it: the block lies there as mounting 1 wants it."""

    def __init__(self, stand):
        self.stand = stand
        self.mounted = 1

    def mount(self, number):
        """True: the person has turned the block, and confirmed it."""
        if number == self.mounted:
            return False
        self.mounted = number
        self.stand.say("done")
        return True


def switch_on(bus, path, started):
    node = Node(bus, path, "--nv", path.with_name("memory"), folder=path.parent)
    started.append(node)
    return node


def switch_off(node):
    node.signal()
    code, _ = node.wait(timeout=20)
    assert code == 0, node.errors


def accept_next(computer, counter):
    """A run, whose result waits, and is accepted. Returns its coefficients."""
    computer.calibrate()
    found = computer.coefficients()
    assert computer["Keeper"]["Proposal present"].raw and "BY_HAND" in computer.objections()
    assert computer.coefficients("Proposal: ") == found and computer.counter() == counter
    computer.accept()
    computer.settle()
    assert computer.counter() == counter + 1
    assert computer.coefficients("Active set: ") == found
    return found


def test_a_life_in_a_file(bus, network, started, tmp_path):
    path = scenario(tmp_path, **HASTE, **PATIENCE)
    stand = Stand(bus, path, "--seed", 7, "--operator", "ask")
    started.append(stand)
    node = switch_on(bus, path, started)
    heard = []
    network.subscribe(0x681, lambda identifier, data, stamp: heard.append(int.from_bytes(data[:4], "little")))
    computer = Computer(network, lambda ms: time.sleep(ms / 1000), Table(stand).mount, timeout=5.0)
    wait_until(lambda: heard)

    computer["Host"]["Calendar"].raw = int(time.time())
    computer.set_rules(1e-3, 1e-4, flags=0)
    first = accept_next(computer, 0)
    second = accept_next(computer, 1)
    assert first != second
    seen = {name: computer["Stand seen"][name].raw for name in ("alpha1", "u_alpha1", "noise", "u_noise")}
    assert refusal_of(computer.command, "ACCEPT") == DEVICE_STATE
    computer.command("ROLLBACK")
    computer.settle()
    assert computer.counter() == 3 and computer.coefficients("Active set: ") == first
    wait_until(lambda: heard[-1] == 3)
    assert sorted(set(heard)) == [0, 1, 2, 3] and heard == sorted(heard)

    computer["Recalibration"]["Interval"].raw = 12_345
    computer.save()
    computer["Recalibration"]["Interval"].raw = 54_321  # not saved
    switch_off(node)
    heard.clear()
    switch_on(bus, path, started)
    wait_until(lambda: heard)
    assert computer.counter() == 3 and computer.coefficients("Active set: ") == first
    assert computer["Recalibration"]["Interval"].raw == 12_345
    assert computer["History"]["Entries"].raw == 3
    assert not computer["Keeper"]["Proposal present"].raw
    assert computer["Store counters"]["Sets torn"].raw == 0
    truth = stand.end()["truth"]
    assert 0 < seen["u_alpha1"] < 1e-3 and abs(seen["alpha1"] - truth["alpha1_rad"]) < 4 * seen["u_alpha1"]
    assert abs(seen["noise"] - 3e-4) < 4 * seen["u_noise"]
