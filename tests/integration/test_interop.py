"""Others on the simulated bus: python-canopen as a master, a drive that is not ours, cantools on the bus log."""

import contextlib
import re
import signal
import time

import numpy as np
import pytest
from conftest import ROOT
from simulated_bench import scenario, served, wait_until

can = pytest.importorskip("can", reason="python-can is not installed")
canopen = pytest.importorskip("canopen", reason="python-canopen is not installed")
cantools = pytest.importorskip("cantools", reason="cantools is not installed")

from bench_guests import connected, disconnect  # noqa: E402
from bench_moves import axis, lead, require_moved  # noqa: E402

from tumble.canbus import TumbleBus  # noqa: E402

pytestmark = pytest.mark.real_time

EDS = ROOT / "docs/eds"


@pytest.fixture
def network():
    """Connect python-canopen to a bench; disconnected in the end."""
    opened = []

    def connect(socket):
        made = connected(TumbleBus(socket))
        opened.append(made)
        return made

    yield connect
    for made in opened:
        disconnect(made)


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


def test_python_canopen_homes_and_moves_the_axis_and_reads_every_object(tmp_path, network):
    """BaseNode402 leads the simulated drive; our firmware is not there."""
    path = scenario(tmp_path, present__navcomp="no", motion__settling_s=0.1)
    with served(path, "--seed", 3) as (run, socket):
        net = network(socket)
        drive = axis(net)
        assert read_all(drive) > 70
        lead(drive)
        disconnect(net)
        assert run.wait() == 0
    assert run.document["end"] == "left"
    require_moved(run.document["table"])


def test_python_canopen_reads_every_object_of_the_navigation_computer_while_it_calibrates(tmp_path, network):
    with served(scenario(tmp_path), "--seed", 4) as (run, socket):
        net = network(socket)
        ours = net.add_node(1, str(EDS / "tumble_navcomp_without_sets.eds"))
        ours.sdo.RESPONSE_TIMEOUT = 20.0
        wait_until(lambda: ours.sdo["State"].raw not in (0, 1), timeout=10)
        assert read_all(ours) > 150
        run.process.send_signal(signal.SIGINT)
        assert run.wait() == 130
    assert run.document["table"]["at_rest"]


HASTE = {
    "motion__settling_s": 0.05,
    "motion__speed_deg_s": 720,
    "motion__acceleration_deg_s2": 7200,
    "procedure__settle_ms": 100,
    "procedure__samples": 10,
    "operator__mount_s": 0.1,
}


def test_a_drive_that_is_not_ours_with_other_units_and_another_pdo_map(tmp_path):
    import python_drive as d

    path = scenario(tmp_path, **HASTE, **d.PROFILE)
    with served(path, "--seed", 5) as (run, socket):
        drive = d.PythonDrive(TumbleBus(socket))
        try:
            code = run.wait(timeout=90)
        finally:
            drive.close()
    document = run.document
    assert (code, document["end"], document["reason"]) == (0, "done", "TUMBLE_REASON_NONE"), document
    assert np.abs(np.array(document["K"]) - np.reshape(document["truth"]["K"], (3, 3))).max() < 1e-3
    drive.require_all_positions()
    assert (drive.get(0x1602, 1), drive.get(0x1A01, 2)) == (0x607A0020, 0x60640020)


def test_a_drive_that_is_not_ours_and_goes_away_is_a_fault(tmp_path):
    import python_drive as d

    path = scenario(tmp_path, **HASTE, **d.PROFILE)
    with served(path, "--seed", 5) as (run, socket):
        drive = d.PythonDrive(TumbleBus(socket))
        try:
            wait_until(lambda: 45.0 in drive.events)
            drive.silent = True
            code = run.wait(timeout=60)
        finally:
            drive.close()
    assert (code, run.document["end"]) == (3, "fault")
    assert run.document["reason"] == "TUMBLE_REASON_STAND_HEARTBEAT", run.document["reason"]


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


def test_the_bus_says_what_it_cannot_do(tmp_path):
    with pytest.raises(can.CanInitializationError, match="No such file"):
        TumbleBus(str(tmp_path / "nobody"), patience_s=0.1)
    path = scenario(tmp_path, present__navcomp="no")
    with served(path) as (run, socket):
        bus = TumbleBus(socket)
        for wrong in ({"is_extended_id": True}, {"is_extended_id": False, "is_remote_frame": True}):
            with pytest.raises(can.CanOperationError, match="only classic"):
                bus.send(can.Message(arbitration_id=0x100, **wrong))
        assert bus.recv(timeout=5.0) is not None
        run.process.send_signal(signal.SIGINT)
        assert run.wait() == 130
        with pytest.raises(can.CanOperationError, match=r"ended|gone"):
            for _ in range(10000):
                bus.recv(timeout=0.1)
        bus.shutdown()


def test_python_can_finds_the_bus_by_its_name():
    project = (ROOT / "host/python/pyproject.toml").read_text()
    assert re.search(r'\[project\.entry-points\."can\.interface"\]\ntumble = "tumble\.canbus:TumbleBus"\n', project)


def frames_of(log):
    """(identifier, data) of every frame of a bus log, in hexadecimal."""
    return [tuple(line.split()[2].split("#")) for line in log.read_text().splitlines()]


def heard(bus):
    """Everything until the bench ends, or sends this guest away."""
    found = []
    with contextlib.suppress(can.CanOperationError):
        while (message := bus.recv(timeout=20.0)) is not None:
            found.append((f"{message.arbitration_id:03X}", message.data.hex().upper()))
    return found


def test_a_guest_that_stands_still_for_a_while_misses_nothing(tmp_path):
    """For a whole run of thousands of frames, many times what a socket holds: a machine may be that busy."""
    keys = {"motion__speed_deg_s": 720, "motion__acceleration_deg_s2": 7200, "procedure__samples": 10}
    path, out = scenario(tmp_path, **keys), tmp_path / "run"
    with served(path, "--pace", "1000", "--out", out) as (run, socket):
        bus = TumbleBus(socket)
        time.sleep(1.0)
        found = heard(bus)
        assert run.wait() == 0
        bus.shutdown()
    assert len(found) > 4000 and found == frames_of(out / "bus.log")


def test_a_guest_that_is_too_far_behind_is_sent_away_and_the_run_goes_on(tmp_path):
    path, out = scenario(tmp_path), tmp_path / "run"
    with served(path, "--pace", "1000", "--out", out) as (run, socket):
        bus = TumbleBus(socket)
        assert run.wait() == 0
        found = heard(bus)
        bus.shutdown()
    sent = frames_of(out / "bus.log")
    assert len(sent) > 10000 and 0 < len(found) < len(sent) and found == sent[: len(found)]
