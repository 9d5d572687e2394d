"""The logs of tumble-node, tumble-stand and tumble-gateway: a line for each event, and the first cause to the end."""

import json
import os
import select
import shutil
import signal
import subprocess
import time
from datetime import datetime, timezone

import documents
import pytest
from conftest import ROOT
from processes import HASTE, PATIENCE, Stand, scenario, sdo_command, slow_table, wait_until
from simulated_bench import built
from test_gateway import KEYS, Served

PAGE = (ROOT / "docs/operations.md").read_text(encoding="utf-8")
LOST = ("TUMBLE_REASON_STAND_HEARTBEAT", "TUMBLE_REASON_BLOCK_HEARTBEAT")


def remedy(reason):
    """As the page for operators has it."""
    row = next(line for line in PAGE.splitlines() if f"| `{reason}` |" in line)
    return row.split(" | ")[2].removesuffix(" |")


class Log:
    """What a program tells on standard error, which goes to a file."""

    def __init__(self, path):
        self.path = path
        self.file = open(path, "w")  # noqa: SIM115 - as long as the program

    def lines(self, event=None):
        """All so far (of one event)."""
        text = self.path.read_text()
        found = [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]
        return [line for line in found if event in (None, line["event"])]

    def check(self):
        """Each line is as the schema has it, and has its members in their order."""
        for line in self.path.read_text().splitlines():
            found = [*documents.valid(line, "log")]
            assert found[:5] == ["schema", "time", "program", "level", "event"] and found[-1] == "message"

    def wait_for(self, event, timeout=60, **members):
        """The first line of that event with these members."""
        def found():
            return [line for line in self.lines(event) if members.items() <= line.items()]

        try:
            wait_until(found, timeout)
        except AssertionError:
            pytest.fail(f"no {event} with {members}: " + "\n".join(line["message"] for line in self.lines()[-12:]))
        return found()[0]


@pytest.fixture
def logged(started, tmp_path):
    """Start a program with --log json: (process, its log)."""

    def start(name, *arguments):
        log = Log(tmp_path / f"{name}-{time.monotonic_ns()}.log")
        command = [built(name), *map(str, arguments), "--log", "json"]
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log.file,
                                   text=True)
        started.append(process)
        return process, log

    return start


def ended(process, number=signal.SIGTERM):
    """(exit code, its last document)."""
    if process.poll() is None:
        process.send_signal(number)
    out = process.communicate(timeout=30)[0].splitlines()
    return process.returncode, json.loads(out[-1]) if out else None


def seconds(line):
    """Since 1970."""
    return datetime.strptime(line["time"], "%Y-%m-%dT%H:%M:%S.%fZ").replace(tzinfo=timezone.utc).timestamp()


@pytest.mark.parametrize("ended_by", ["signal", "command", "resume and command", "itself"])
def test_a_stand_that_is_killed_is_the_cause_to_the_end(bus, started, tmp_path, logged, ended_by):
    """kill -9 of the stand in a run, served or single: the line within a second, the cause in the last document and the
    last line, whatever follows."""
    path = scenario(tmp_path, **slow_table(), procedure__preflight_timeout_ms=1500)
    single = ended_by == "itself"
    stand = Stand(bus, path, "--operator", "mount" if single else "start")
    started.append(stand)
    node, log = logged("tumble-node", bus, path, *(["--start"] if single else []))
    log.wait_for("state", state="TUMBLE_STATE_MOVE", position=3)
    stand.signal(signal.SIGKILL)
    killed = time.time()
    fault = log.wait_for("fault", timeout=5)
    assert seconds(fault) - killed < 1.0 and fault["reason"] in LOST and fault["level"] == "error"
    print(f"told {seconds(fault) - killed:.3f} s after the stand was killed")
    assert fault["remedy"] == remedy(fault["reason"]) and fault["remedy"] in fault["message"]
    if ended_by == "resume and command":
        sdo_command(bus, 7)
        log.wait_for("fault", state="TUMBLE_STATE_PREFLIGHT")
    if ended_by.endswith("command"):
        sdo_command(bus, 2)
        aborted = log.wait_for("state", state="TUMBLE_STATE_ABORT")
        assert aborted["cause"] == fault["reason"] and fault["reason"] in aborted["message"]
    if single:
        node.wait(timeout=20)
    code, document = ended(node)
    assert code == {"signal": 130, "itself": 3}.get(ended_by, 0)
    assert (document["cause"]["reason"], document["cause"]["failed_in"]) == (fault["reason"], fault["state"])
    last = log.lines()[-1]
    assert (last["event"], last["exit"], last["cause"]) == ("end", code, fault["reason"])
    assert last["remedy"] == fault["remedy"] and last["remedy"] in last["message"]


def test_a_fault_that_the_run_has_got_over_is_no_cause(bus, started, tmp_path, logged):
    """The last line does not tell of it any more."""
    fault = "drive_fault at=1.3 phase=move duration=0.1 value=0x7500"
    path = scenario(tmp_path, **slow_table(), procedure__retries=0, fault=fault)
    stand, told = logged("tumble-stand", bus, path, "--operator", "start")
    node, log = logged("tumble-node", bus, path)
    failed = log.wait_for("fault")
    assert (failed["reason"], failed["drive_code"], failed["position"]) == ("TUMBLE_REASON_DRIVE_FAULT", 0x7500, 3)
    assert told.wait_for("fault")["kind"] == "drive_fault"
    time.sleep(0.3)
    sdo_command(bus, 7)
    log.wait_for("state", state="TUMBLE_STATE_AVERAGE", position=3)
    assert ended(node)[1]["cause"] is None
    last = log.lines()[-1]
    assert (last["event"], last["exit"], "cause" in last, last["level"]) == ("end", 130, False, "notice")
    assert ended(stand)[0] == 0
    assert [(line["event"], line["exit"], line["at_rest"]) for line in told.lines()[-1:]] == [("end", 0, 1)]


def test_a_recalibration_over_modbus_in_three_logs(bus, started, tmp_path, logged):
    """Who commanded what, what came of it, and what is held and committed, as node, stand and gateway each see it."""
    path = scenario(tmp_path, **HASTE, **PATIENCE, keeper__commits="no")
    stand, of_stand = logged("tumble-stand", bus, path, "--seed", 11)
    node, of_node = logged("tumble-node", bus, path, "--nv", tmp_path / "memory")
    of_node.wait_for("ready", interface=str(bus), memory=str(tmp_path / "memory"))
    served = Served(bus, "--allow-commands", "--log", "json", "--unlock", "600")
    started.append(served)
    served.wait_for("State", 0)
    served.client.write_registers(0, [1, 2], device_id=1)
    served.client.write_registers(0, list(KEYS), device_id=1)
    assert served.execute(0, 0, 0, 0, 1) == (2, 0)
    of_node.wait_for("state", state="TUMBLE_STATE_AVERAGE")
    assert served.execute(0, 0, 0, 0, 1) == (3, 0x08000022)
    served.wait_for("Keeper: Verdict", 3)
    assert served.tell("Service level: Key", 0x76726573)[0] == 2
    assert served.accept() == (2, 0)
    served.wait_for("Keeper: Verdict", 5)
    served.renew()
    told = [json.loads(line) for line in [served.line, *served.end().splitlines()]]
    of_gateway = [(line["event"], line.get("command", line.get("why", line.get("link")))) for line in told]
    start, service, accept = "TUMBLE_COMMAND_START (1)", "setting 2006h:1", "TUMBLE_COMMAND_ACCEPT (9)"
    expected = [("ready", None), ("link", "up"), ("connected", None), ("refused", "wrong keys"), ("unlock", None),
                ("command", start), ("refused", start), ("held", None), ("command", service), ("command", accept),
                ("commit", None), ("disconnected", "by itself"), ("end", None)]
    assert sorted(one for one in of_gateway if one[0] != "state") == sorted(expected, key=str)
    assert [one for one in of_gateway if one in expected[4:]] == expected[4:]
    assert next(line for line in told if line["event"] == "refused" and "command" in line)["abort_code"] == 0x08000022
    assert "TUMBLE_STATE_DONE" in [line["state"] for line in told if line["event"] == "state"]

    assert ended(node)[0] == 0 and ended(stand)[0] == 0
    states = [line["state"].removeprefix("TUMBLE_STATE_") for line in of_node.lines("state")]
    assert states[-1] == "DONE" and {"WAIT_MOUNTING", "AVERAGE"} <= {*states}
    refused = [(line["command"], line["command_number"]) for line in of_node.lines("refused")]
    assert refused == [("TUMBLE_COMMAND_START", 1)], [line["message"] for line in of_node.lines()[-8:]]
    [held], [commit] = of_node.lines("held"), of_node.lines("commit")
    assert held["objections"] & 1 << 10 and "TUMBLE_OBJECTION_BY_HAND, " in held["sentence"]
    assert (commit["calibration_counter"], commit["how"]) == (1, "the proposal is accepted")
    assert len(of_node.lines("unlock")) == 1 and not of_node.lines("fault")
    assert [line["event"] for line in of_node.lines()][:1] == ["ready"] and of_node.lines()[-1]["event"] == "end"

    confirmed = [line for line in of_stand.lines("command") if line["command"] == "TUMBLE_COMMAND_CONFIRM_MOUNTING"]
    assert [line["argument"] for line in confirmed] == [1, 2]
    assert [line["mounting"] for line in of_stand.lines("mounted")] == [1, 2]
    assert not of_stand.lines("lost") + of_node.lines("lost")
    of_stand.check()
    of_node.check()


def test_a_folder_that_is_gone_in_the_end(bus, started, tmp_path, logged):
    """It is an event, not a line of another kind, and the last one is told all the same."""
    path = scenario(tmp_path, **HASTE, **PATIENCE)
    stand = Stand(bus, path)
    started.append(stand)
    node, log = logged("tumble-node", bus, path, "--start", "--out", tmp_path / "run")
    log.wait_for("state", state="TUMBLE_STATE_AVERAGE")
    shutil.rmtree(tmp_path / "run")
    node.wait(timeout=60)
    assert ended(node) == (3, None)
    log.check()
    unwritten, end = log.lines()[-2:]
    assert (unwritten["event"], unwritten["level"], unwritten["folder"]) == (
        "unwritten", "error", str(tmp_path / "run"))
    assert (end["event"], end["end"], end["exit"], end["level"]) == ("end", "done", 3, "error")
    stand.end()


def test_a_log_that_nobody_reads_holds_up_no_run(bus, started, tmp_path):
    """Its pipe is full from the beginning."""
    ours, theirs = os.pipe()
    os.set_blocking(theirs, False)
    with pytest.raises(BlockingIOError):
        while True:
            os.write(theirs, bytes(4096))
    os.set_blocking(theirs, True)
    path = scenario(tmp_path, **HASTE, **PATIENCE)
    stand = Stand(bus, path)
    command = [built("tumble-node"), str(bus), str(path), "--start", "--log", "json"]
    node = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs, text=True)
    started.extend([stand, node])
    out, _ = node.communicate(timeout=60)
    assert (node.returncode, json.loads(out)["end"]) == (0, "done")
    stand.end()
    os.close(theirs)
    with open(ours, "rb") as rest:
        assert not rest.read().strip(b"\0")


def test_without_the_option_standard_error_is_as_it_was(bus, started, tmp_path):
    """Of a whole run: the sentence that it is ready."""
    path = scenario(tmp_path, **HASTE)
    stand = Stand(bus, path, "--operator", "start")
    command = [built("tumble-node"), str(bus), str(path)]
    node = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    started.extend([stand, node])
    assert select.select([node.stdout], [], [], 60)[0], "no document within a minute"
    document = json.loads(node.stdout.readline())
    node.terminate()
    assert (document["end"], node.communicate(timeout=20)[1]) == (
        "done", f"tumble-node: node 1 on {bus}, memory none; waits for commands\n")
    assert stand.end()["operator"]["answers"] == 3 and stand.errors == ""
