"""Others on the simulated bus, in virtual time: python-canopen as a master, a drive that is not ours; cantools on the
bus log."""

import time

import numpy as np
import pytest
from conftest import ROOT

import tumble as package

can = pytest.importorskip("can", reason="python-can is not installed")
canopen = pytest.importorskip("canopen", reason="python-canopen is not installed")
cantools = pytest.importorskip("cantools", reason="cantools is not installed")

from bench_moves import axis, lead, require_moved  # noqa: E402
from python_drive import PROFILE, PythonDrive  # noqa: E402

from tumble.world.virtual_bus import time_of  # noqa: E402


@pytest.fixture
def network():
    """Connect python-canopen to a world, whose time is the test's meanwhile."""
    opened = []

    def connect(world):
        bus = world.bus(script_time=True)
        opened.append(canopen.Network(bus))
        opened[-1].NOTIFIER_CYCLE = 0.01
        opened[-1].connect()
        return opened[-1]

    yield connect
    for made in opened:
        made.disconnect()


def variables(node):
    """Every object of a node's EDS file that can be read."""
    for item in node.object_dictionary.values():
        entries = [item] if isinstance(item, canopen.objectdictionary.ODVariable) else item.values()
        yield from (entry for entry in entries if entry.readable and entry.index >= 0x1000)


def read_all(node):
    """How many objects answered with a value. Instead of one "no data available" is allowed."""
    values = 0
    for entry in variables(node):
        try:
            data = node.sdo.upload(entry.index, entry.subindex)
        except canopen.SdoAbortedError as refusal:
            assert refusal.code == 0x08000024, entry
            continue
        values += 1
        if entry.data_type in canopen.objectdictionary.datatypes.NUMBER_TYPES:
            assert len(data) == len(entry) // 8, entry
    return values


def received(pdo, timeout):
    """PdoMap.wait_for_reception, which waits for a condition: time would stand still."""
    pdo.is_received, end = False, time.monotonic() + timeout
    while not pdo.is_received and time.monotonic() < end:
        time.sleep(0.001)
    return pdo.timestamp if pdo.is_received else None


def test_python_canopen_homes_and_moves_the_axis_and_reads_every_object(network, monkeypatch):
    """BaseNode402 leads the simulated drive; our firmware is not there."""
    monkeypatch.setattr(canopen.pdo.base.PdoMap, "wait_for_reception", received)
    world = package.World(3, **{"present.navcomp": False, "motion.settling_s": 0.1})
    drive = axis(network(world))
    assert read_all(drive) > 70
    lead(drive)
    require_moved(world.stop().table)


def test_python_canopen_reads_every_object_of_the_navigation_computer_while_it_calibrates(network):
    world = package.World(4)
    world.advance(until="AVERAGE")
    ours = network(world).add_node(1, str(ROOT / "docs/eds/tumble_navcomp_without_sets.eds"))
    ours.sdo.RESPONSE_TIMEOUT = 20.0
    assert read_all(ours) > 150 and world.end == "running"
    assert world.stop().end == "interrupted" and world.table["at_rest"]


def with_a_drive_that_is_not_ours(until=lambda drive: False):
    """(world, drive) of a run with other units and another PDO map; the drive falls silent as soon as `until`."""
    keys = {key.replace("__", "."): value for key, value in PROFILE.items()}
    world = package.World(5, samples=10, **keys, **{"procedure.settle_ms": 100, "operator.mount_s": 0.1})
    with world.bus() as bus, time_of(bus), pytest.raises(can.CanOperationError, match="has come to its end"):
        drive = PythonDrive(bus)
        while True:
            drive.step()
            drive.silent = drive.silent or until(drive)
    return world, drive


def test_a_drive_that_is_not_ours_with_other_units_and_another_pdo_map():
    world, drive = with_a_drive_that_is_not_ours()
    assert (world.end, world.reason) == ("done", "NONE")
    assert np.abs(np.array(world.document["K"]) - world.truth["K"]).max() < 1e-3
    drive.require_all_positions()
    assert (drive.get(0x1602, 1), drive.get(0x1A01, 2)) == (0x607A0020, 0x60640020)


def test_a_drive_that_is_not_ours_and_goes_away_is_a_fault():
    world, _ = with_a_drive_that_is_not_ours(until=lambda drive: 45.0 in drive.events)
    assert (world.end, world.reason) == ("fault", "STAND_HEARTBEAT")


def test_cantools_decodes_the_block_from_the_bus_log(tmp_path, tumble):
    """The DBC file alone, against what run.csv says: counts, counters, timestamps."""
    out = tmp_path / "run"
    assert tumble("bench", "--seed", 6, "--samples", 20, "--out", out).returncode == 0
    bus = cantools.database.load_file(ROOT / "docs/bus/block.dbc")
    decoded, half = {}, None
    for frame in can.CanutilsLogReader(str(out / "bus.log")):
        if frame.arbitration_id == 0x683:
            half = bus.decode_message(0x683, bytes(frame.data))
        elif frame.arbitration_id == 0x693:
            other = bus.decode_message(0x693, bytes(frame.data))
            assert other["frame_counter"] == (2 * half["sample_counter"] + 1) % 256
            key = half["sample_counter"], other["timestamp"]
            decoded.setdefault(key, []).append((half["x"], half["y"], other["z"]))
            assert other["saturated"] in (0, "no") and other["temperature"] == 25.0
    rows = np.loadtxt(out / "run.csv", delimiter=",", skiprows=1)
    assert len(rows) == 18 * 20
    for _, _, ux, uy, uz, cx, cy, cz, counter, timestamp, temperature, _ in rows:
        assert (cx, cy, cz) in decoded[int(counter) % 256, int(timestamp)] and temperature == 25.0
        assert np.array_equal(np.array([ux, uy, uz]) * 2**23 / 10, [cx, cy, cz])
