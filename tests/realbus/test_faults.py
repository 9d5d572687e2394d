"""What can go wrong on a real bus: found within the heartbeat time, the table stopped, the reason given, and no
hanging."""

import signal
import subprocess
import time

import can
import pytest
from processes import HASTE, Node, Stand, scenario, sdo_command, slow_table, wait_until

HEARTBEAT_S = 0.5  # as the scenario has it
SLACK_S = 1.0  # of a slow machine


def reason_of(document):
    """Without its prefix."""
    return document["reason"].removeprefix("TUMBLE_REASON_")


def first(node, state, position=None):
    """When it first came to a state, s."""
    return node.wait_for(state, position)["virtual_s"]


@pytest.fixture
def turning(bus, started, tmp_path):
    """A run with the table on its way to position 1.3: (node, stand)."""

    def start(*options, serve=False, speed_deg_s=60, **keys):
        path = scenario(tmp_path, **slow_table(speed_deg_s), **keys)
        stand = Stand(bus, path, *(["--operator", "start"] if serve else []))
        node = Node(bus, path, *([] if serve else ["--start"]), *options, folder=tmp_path)
        started.extend([stand, node])
        node.wait_for("MOVE", 2)
        time.sleep(0.2)
        return node, stand

    return start


def test_a_drive_that_loses_power_in_a_move(turning, tmp_path):
    node, stand = turning("--out", tmp_path / "run", fault="drive_power_cycle at=1.3 phase=move delay=0.3 duration=0.5")
    code, document = node.wait(timeout=15)
    assert (code, document["end"], document["failed_in"]) == (3, "fault", "TUMBLE_STATE_MOVE")
    assert reason_of(document) in ("STAND_HEARTBEAT", "DRIVE_POWER", "STAND_PROTOCOL"), document["reason"]
    assert len(document["means"]) == 2 and first(node, "FAULT") - first(node, "MOVE", 2) < 0.3 + HEARTBEAT_S + SLACK_S
    assert (tmp_path / "run/bench.json").exists() and (tmp_path / "run/run.csv").read_text().count("\n") == 1 + 2 * 10
    truth = stand.end()
    assert truth["faults"] == [{"kind": "drive_power_cycle", "times": 1}] and truth["table"]["at_rest"]


def test_a_drive_that_loses_power_in_a_move_and_a_run_that_goes_on_by_command(turning, bus):
    """Detected within the heartbeat time; what was measured is kept; nothing hangs."""
    power = "drive_power_cycle at=1.3 phase=move delay=0.3 duration=0.5"
    node, stand = turning("--patience", 30, fault=power, procedure__retries=0)
    node.wait_for("FAULT")
    assert first(node, "FAULT") - first(node, "MOVE", 2) < 0.3 + HEARTBEAT_S + SLACK_S
    time.sleep(1.0)  # its power is back, and it has booted
    sdo_command(bus, 7)
    node.wait_for("AVERAGE", 3)
    node.signal()
    code, document = node.wait()
    assert (code, document["counters"]["resumes"]) == (130, 1) and len(document["means"]) >= 3
    homes = [event for event in node.events() if event.get("state") == "TUMBLE_STATE_HOME"]
    assert len(homes) == 2  # where it stands it has forgotten
    assert stand.end()["table"]["at_rest"]


def test_a_stand_that_dies_and_another_that_takes_its_place(turning, bus, started, tmp_path):
    """Drive and block are gone at once; the run goes on, at the position where it failed, when they are there again."""
    node, stand = turning("--patience", 30)
    stand.signal(signal.SIGKILL)
    event = node.wait_for("FAULT", timeout=HEARTBEAT_S + SLACK_S)
    assert event["reason"].removeprefix("TUMBLE_REASON_") in ("STAND_HEARTBEAT", "BLOCK_HEARTBEAT")
    again = Stand(bus, scenario(tmp_path, "again.txt", **HASTE), "--operator", "none")
    started.append(again)
    time.sleep(0.5)
    sdo_command(bus, 7)
    node.wait_for("AVERAGE", 3)
    node.signal()
    code, document = node.wait()
    assert code == 130 and len(document["means"]) >= 3 and document["counters"]["resumes"] == 1
    assert again.end()["table"]["at_rest"]


def test_a_drive_that_misses_its_master_stops_within_its_time(turning, bus):
    """The node is killed in a move: when the axis comes to rest, as the bus shows it."""
    node, stand = turning(speed_deg_s=20)
    watcher = can.Bus(interface="socketcan", channel=str(bus), can_filters=[{"can_id": 0x182, "can_mask": 0x7FF}])
    node.signal(signal.SIGKILL)
    killed = time.time()
    angles = []
    while (message := watcher.recv(timeout=1.0)) is not None and time.time() - killed < 1.5:
        angles.append((message.timestamp - killed, int.from_bytes(message.data[2:6], "little", signed=True)))
    watcher.shutdown()
    at_rest_s = next(when for when, angle in angles if angle == angles[-1][1])
    print(f"at rest {at_rest_s:.3f} s after node 1 was killed")
    braking_s = 20 / 7200
    assert at_rest_s < 0.1 + HEARTBEAT_S + braking_s + SLACK_S and angles[0][1] != angles[-1][1]
    assert stand.end()["table"]["at_rest"]


def test_a_stand_that_dies(turning):
    node, stand = turning()
    stand.signal(signal.SIGKILL)
    began = time.monotonic()
    code, document = node.wait(timeout=15)
    assert time.monotonic() - began < HEARTBEAT_S + 5.0 + SLACK_S  # and the time for a stop that nobody confirms
    assert code == 3 and reason_of(document) in ("STAND_HEARTBEAT", "BLOCK_HEARTBEAT"), document["reason"]
    assert first(node, "FAULT") - first(node, "MOVE", 2) < 0.2 + HEARTBEAT_S + SLACK_S


def test_a_node_that_dies_and_another_that_starts_again_by_command(turning, bus, started, tmp_path):
    """The drive has missed its master, stopped and keeps its fault until somebody says that all is well."""
    node, stand = turning(speed_deg_s=20)
    node.signal(signal.SIGKILL)
    node.wait()
    time.sleep(HEARTBEAT_S + SLACK_S)  # of the 2.25 s that the move would take
    path = scenario(tmp_path, "again.txt", **slow_table(20), procedure__preflight_timeout_ms=1500)
    again = Node(bus, path, "--start", "--patience", 20, folder=tmp_path)
    started.append(again)
    assert again.wait_for("FAULT")["reason"] == "TUMBLE_REASON_DRIVE_FAULT"
    sdo_command(bus, 7)
    again.wait_for("MOVE", 1)
    again.signal()
    assert again.wait()[0] == 130
    assert stand.end()["table"]["at_rest"]


def test_a_node_that_dies_and_a_stand_that_is_told_to_end_at_once(turning):
    """The stand goes on until the drive has missed its master and stopped, far from its target."""
    node, stand = turning(speed_deg_s=10)
    node.signal(signal.SIGKILL)
    began = time.monotonic()
    document = stand.end()
    assert document["table"]["at_rest"] and time.monotonic() - began < 3.0
    assert document["angle_deg"] < 45.0 + 10.0 * (0.2 + HEARTBEAT_S + 2 * SLACK_S)


def test_an_interface_that_goes_down_and_a_run_that_goes_on_by_command(turning, bus):
    node, stand = turning(serve=True)
    bus.down()
    node.wait_for("FAULT", timeout=HEARTBEAT_S + SLACK_S)
    assert node.events()[-1]["reason"] == "TUMBLE_REASON_BUS"
    time.sleep(HEARTBEAT_S + SLACK_S)
    assert node.process.poll() is None and stand.process.poll() is None
    bus.up()
    time.sleep(2 * HEARTBEAT_S)
    sdo_command(bus, 7)
    node.wait_for("MOVE", 5)
    node.signal()
    code, document = node.wait()
    assert (code, document["end"], len(document["means"])) == (130, "interrupted", 5)
    assert document["counters"]["interface_downs"] == 1 and document["counters"]["resumes"] == 1
    ended = stand.end()
    assert ended["counters"]["interface_downs"] == 1 and ended["counters"]["frames_unsent"] > 0


def test_an_interface_that_goes_down_ends_a_single_run(turning, bus):
    node, stand = turning()
    bus.down()
    began = time.monotonic()
    code, document = node.wait(timeout=15)
    assert (code, reason_of(document)) == (3, "BUS") and time.monotonic() - began < 5.0 + HEARTBEAT_S + SLACK_S
    assert stand.end()["table"]["at_rest"]


def test_an_interface_that_is_taken_away_and_comes_back(turning, bus):
    node, stand = turning(serve=True)
    bus.remove()
    node.wait_for("FAULT", timeout=HEARTBEAT_S + SLACK_S)
    bus.add()
    time.sleep(1.0)
    sdo_command(bus, 2)
    node.wait_for("ABORT")
    sdo_command(bus, 1)
    wait_until(lambda: sum(event.get("state") == "TUMBLE_STATE_AVERAGE" for event in node.events()) > 3)
    node.signal()
    assert node.wait()[0] == 130
    assert stand.end()["table"]["at_rest"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_the_table_first(turning, number, tmp_path):
    node, stand = turning("--out", tmp_path / "run", speed_deg_s=20)
    node.signal(number)
    began = time.monotonic()
    code, document = node.wait(timeout=10)
    assert (code, document["end"], document["state"]) == (130, "interrupted", "TUMBLE_STATE_ABORT")
    assert time.monotonic() - began < 2.0
    stand.signal()
    ended = stand.wait(timeout=10)[1]
    assert ended["table"]["at_rest"] and ended["angle_deg"] < 89.0


def test_nobody_answers(bus, started, tmp_path):
    """No stand at all: a reason after the time that the preflight has."""
    node = Node(bus, scenario(tmp_path, procedure__preflight_timeout_ms=1500), "--start", folder=tmp_path)
    started.append(node)
    code, document = node.wait(timeout=10)
    assert (code, reason_of(document)) == (3, "STAND_OFFLINE")


def test_two_faults_that_the_operator_mends(bus, started, tmp_path):
    """By SDO, as the scenario has it; the node waits for him."""
    faults = ["drive_fault at=1.2 phase=move value=0x7500", "block_silent at=2.4 phase=average"]
    path = scenario(tmp_path, **HASTE, fault=faults, operator__mend_s=0.5, operator__mends=2, procedure__retries=0)
    stand = Stand(bus, path)
    node = Node(bus, path, "--start", "--patience", 20, folder=tmp_path)
    started.extend([stand, node])
    code, document = node.wait()
    assert (code, document["end"]) == (0, "done"), document["reason"]
    assert document["counters"]["faults"] == 2 and document["counters"]["resumes"] == 2
    assert [fault["times"] for fault in stand.end()["faults"]] == [1, 1]


def test_a_node_that_is_stopped_loses_nothing_unnoticed(bus, started, tmp_path):
    """For a second it takes no frame, in a flood that its receive buffer cannot hold: the kernel's drops are
    counted."""
    path = scenario(tmp_path, **{**HASTE, "procedure__samples": 200})
    stand = Stand(bus, path)
    before = bus.frames()
    node = Node(bus, path, "--start", "--patience", 0, folder=tmp_path)
    started.extend([stand, node])
    node.wait_for("AVERAGE", 3)
    node.signal(signal.SIGSTOP)
    flood = ["cangen", str(bus), "-g", "0", "-p", "1", "-I", "7F0", "-L", "8", "-n", "40000"]
    subprocess.run(flood, check=True)
    node.signal(signal.SIGCONT)
    code, document = node.wait()
    counters = document["counters"]
    assert counters["kernel_dropped"] > 1000, counters
    assert (code, document["end"]) == (3, "fault"), document["reason"]
    stand.end()
    assert bus.frames() - before >= counters["kernel_received"] + counters["kernel_dropped"] + counters["kernel_sent"]


def test_a_wait_until_that_is_never_true_fails():
    """The tests' own patience."""
    with pytest.raises(AssertionError, match="not in time"):
        wait_until(lambda: False, timeout=0.1)


@pytest.mark.parametrize("ended_by", ["signal", "command"])
def test_a_served_node_tells_the_cause(turning, bus, ended_by):
    """At the fault, on standard error; and in the document, though what ended the run was the abort."""
    node, stand = turning(serve=True, fault="drive_fault at=1.3 phase=move duration=9 value=0x7500")
    node.wait_for("FAULT")
    if ended_by == "command":
        sdo_command(bus, 2)
        node.wait_for("ABORT")
        node.signal()
    else:
        node.signal()
    code, document = node.wait()
    ends = {"command": (0, "COMMAND", "TUMBLE_STATE_ABORT"), "signal": (130, "DRIVE_FAULT", "TUMBLE_STATE_FAULT")}
    assert (code, reason_of(document), document["state"]) == ends[ended_by]
    assert document["cause"] == {
        "failed_in": "TUMBLE_STATE_MOVE", "reason": "TUMBLE_REASON_DRIVE_FAULT", "reason_number": 7,
        "reason_sentence": "the drive reported a fault", "drive_code": 0x7500}
    told = [line for line in node.errors.splitlines() if ": fault " in line]
    assert told == ["tumble-node: fault at position 1.3 (TUMBLE_REASON_DRIVE_FAULT in TUMBLE_STATE_MOVE): "
                    "the drive reported a fault; waits for RESUME or ABORT"]
    stand.end()


def test_a_fault_that_was_mended_is_no_cause(turning, bus):
    node, stand = turning(serve=True, fault="drive_fault at=1.3 phase=move duration=0.1 value=0x7500")
    node.wait_for("FAULT")
    time.sleep(0.3)
    sdo_command(bus, 7)
    node.wait_for("AVERAGE", 2)
    node.signal()
    code, document = node.wait()
    assert (code, reason_of(document), document["cause"]) == (130, "COMMAND", None)
    stand.end()


def test_remote_frames_and_long_identifiers_change_nothing(bus, started, tmp_path):
    """Neither is a frame of ours: requests for each PDO, heartbeat and SDO, set-points in 29 bits. Both ends count."""
    path = scenario(tmp_path, **slow_table())
    stand = Stand(bus, path, "--seed", 5)
    node = Node(bus, path, "--start", folder=tmp_path)
    started.extend([stand, node])
    stranger = can.Bus(interface="socketcan", channel=str(bus))
    states, identifiers = ("HOME", "MOVE", "AVERAGE"), (0x000, 0x080, 0x181, 0x182, 0x202, 0x601, 0x602, 0x701, 0x702)
    for state in states:
        node.wait_for(state)
        for identifier in identifiers:
            stranger.send(can.Message(arbitration_id=identifier, is_remote_frame=True, is_extended_id=False))
            stranger.send(can.Message(arbitration_id=identifier, data=bytes.fromhex("0F00A08601000000")))
    stranger.shutdown()
    node.wait_for("AVERAGE", 2)  # it goes on
    node.signal()
    code, document = node.wait()
    truth, sent = stand.end(), 2 * len(states) * len(identifiers)
    assert code == 130 and truth["table"]["at_rest"] and document["reason"] == "TUMBLE_REASON_COMMAND"
    assert (document["counters"]["frames_foreign"], truth["counters"]["frames_foreign"]) == (sent, sent)
