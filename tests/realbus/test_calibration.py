"""tumble-node calibrates tumble-stand on a CAN interface; others watch."""

import subprocess

import can
import cantools
import numpy as np
from bus_database import complaints, load
from conftest import ROOT
from processes import HASTE, Node, Stand, scenario, sdo_command, wait_until


def run_folder_of(tmp_path):
    """Rows of run.csv."""
    return np.loadtxt(tmp_path / "run/run.csv", delimiter=",", skiprows=1)


def test_a_calibration_that_candump_and_python_can_watch_and_cantools_decodes(bus, started, tmp_path):
    path = scenario(tmp_path, **HASTE)
    with open(tmp_path / "candump.log", "w") as log:
        dump = subprocess.Popen(["candump", "-L", str(bus)], stdout=log)
    started.append(dump)
    watcher = can.Bus(interface="socketcan", channel=str(bus))
    seen = can.BufferedReader()
    notifier = can.Notifier(watcher, [seen])
    stand = Stand(bus, path, "--seed", 7)
    node = Node(bus, path, "--start", "--out", tmp_path / "run", folder=tmp_path)
    started += [stand, node]
    code, document = node.wait()
    assert code == 0, (document, node.process.returncode)
    truth = stand.end()
    notifier.stop(timeout=2)
    watcher.shutdown()
    dump.terminate()
    dump.wait()

    assert (document["end"], document["state"]) == ("done", "TUMBLE_STATE_DONE")
    assert np.abs(np.array(document["K"]) - truth["truth"]["K"]).max() < 3e-3
    check_counters(document["counters"], truth["counters"])
    assert truth["table"]["at_rest"] and truth["operator"] == {"answers": 2, "refusals": 0}

    ours = frames_of(tmp_path / "run/bus.log")
    theirs = frames_of(tmp_path / "candump.log")
    assert set(ours) <= set(theirs) and len(theirs) - len(ours) < 50  # what came after the node had ended
    assert sorted(ours) == sorted(theirs[: len(ours)]) or len(set(theirs) - set(ours)) < 50
    assert len(ours) == document["counters"]["kernel_received"] + document["counters"]["kernel_sent"]
    count = 0
    while seen.get_message(timeout=0) is not None:
        count += 1
    assert len(ours) - 5 <= count <= len(theirs) + 5  # they do not end at the same moment
    decode(tmp_path)
    assert complaints(load(), theirs) == []  # by the DBC file of the whole bus


def check_counters(node, stand):
    """Nothing was lost, and whatever one side sent the other has."""
    lost = ("kernel_dropped", "samples_lost", "frames_wrong_crc", "error_frames", "interface_downs", "frames_busy")
    for name in lost:
        assert node[name] == 0, name
    for name in ("kernel_dropped", "queue_overflow", "frames_unsent", "bus_overflow"):
        assert stand[name] == 0, name
    assert stand["kernel_received"] == node["kernel_sent"]
    assert node["receive_buffer_bytes"] >= 8 * 2**20


def frames_of(path):
    """Identifier and data of every frame of a log."""
    return [(frame.arbitration_id, bytes(frame.data)) for frame in can.CanutilsLogReader(str(path))]


def decode(tmp_path):
    """The DBC file alone, against what run.csv says."""
    block = cantools.database.load_file(ROOT / "docs/bus/block.dbc")
    decoded, half = {}, None
    for identifier, data in frames_of(tmp_path / "run/bus.log"):
        if identifier == 0x683:
            half = block.decode_message(identifier, data)
        elif identifier == 0x693:
            other = block.decode_message(identifier, data)
            key = half["sample_counter"], other["timestamp"]
            decoded.setdefault(key, []).append((half["x"], half["y"], other["z"]))
    rows = run_folder_of(tmp_path)
    assert len(rows) == 18 * 10
    for _, _, _, _, _, cx, cy, cz, counter, timestamp, temperature, _ in rows:
        assert (cx, cy, cz) in decoded[int(counter) % 256, int(timestamp)] and temperature == 25.0


def test_a_node_that_serves_calibrates_by_command_twice_and_ends_between_two(bus, started, tmp_path):
    path = scenario(tmp_path, **HASTE)
    stand = Stand(bus, path, "--operator", "start")
    node = Node(bus, path, folder=tmp_path)
    started += [stand, node]
    node.wait_for("DONE")
    sdo_command(bus, 1)
    wait_until(lambda: sum(event.get("state") == "TUMBLE_STATE_DONE" for event in node.events()) == 2, timeout=40)
    node.signal()
    out, errors = node.process.communicate(timeout=10)
    assert node.process.returncode == 0, errors
    assert len(out.splitlines()) == 2 and '"end":"done"' in out.splitlines()[0]
    assert stand.end()["operator"] == {"answers": 5, "refusals": 0}


def test_the_virtual_bus_has_the_bit_rate_that_the_interface_lacks(bus, started, tmp_path):
    """Bits and frames of the stand's bus: a classic frame is 47 to 135 bits long with its interframe space."""
    path = scenario(tmp_path, **HASTE)
    stand = Stand(bus, path)
    started.append(stand)
    subprocess.run(["cangen", str(bus), "-g", "1", "-n", "300", "-I", "110", "-L", "8", "-D", "r"], check=True)
    counters = stand.end()["counters"]
    assert counters["kernel_received"] >= 300 and counters["bus_frames"] >= 300
    assert 47 <= counters["bus_bits"] / counters["bus_frames"] <= 135
    assert counters["bus_busy_us"] == 2 * counters["bus_bits"]
