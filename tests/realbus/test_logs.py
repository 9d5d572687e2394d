"""The logs of tumble-node, tumble-stand and tumble-gateway: a line for each event, and the first cause to the end."""

import json
import signal
import subprocess
import time
from datetime import datetime, timezone

import pytest
from bench_program import built
from conftest import ROOT
from processes import HASTE, SLOW_TABLE, Node, Stand, scenario, sdo_command, wait_until
from test_gateway import Served

HEARTBEAT_S = 0.5
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
        """All so far (of one event), each with all that every line has."""
        text = self.path.read_text()
        found = [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]
        for line in found:
            assert list(line)[:5] == ["schema", "time", "program", "level", "event"] and list(line)[-1] == "message"
            assert line["schema"] == "tumble.log/1"
        return [line for line in found if event in (None, line["event"])]

    def wait_for(self, event, timeout=60, **members):
        """The first line of that event with these members."""
        def found():
            return [line for line in self.lines(event) if members.items() <= line.items()]

        wait_until(found, timeout)
        return found()[0]


@pytest.fixture
def logged(started, tmp_path):
    """Start a program of boards/linux with --log json: (process, its log)."""

    def start(name, *arguments, folder="boards/linux"):
        log = Log(tmp_path / f"{name}-{time.monotonic_ns()}.log")
        command = [built(name, folder), *map(str, arguments), "--log", "json"]
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=log.file, text=True)
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


@pytest.mark.parametrize("ended_by", ["signal", "command", "resume and command"])
def test_a_stand_that_is_killed_is_the_cause_to_the_end(bus, started, tmp_path, logged, ended_by):
    """kill -9 of the stand in a run of a served node: the line within a second, the cause in the last document and the
    last line, whatever follows."""
    path = scenario(tmp_path, **SLOW_TABLE, procedure__preflight_timeout_ms=1500)
    stand = Stand(bus, path, "--operator", "start")
    started.append(stand)
    node, log = logged("tumble-node", bus, path)
    log.wait_for("state", state="TUMBLE_STATE_MOVE", position=3)
    stand.signal(signal.SIGKILL)
    killed = time.time()
    fault = log.wait_for("fault", timeout=5)
    assert seconds(fault) - killed < 1.0 and fault["reason"] in LOST and fault["level"] == "error"
    assert fault["remedy"] == remedy(fault["reason"]) and fault["remedy"] in fault["message"]
    if ended_by == "resume and command":
        sdo_command(bus, 7)
        second = log.wait_for("fault", reason="TUMBLE_REASON_STAND_OFFLINE")
        assert second["state"] == "TUMBLE_STATE_PREFLIGHT"
    if ended_by != "signal":
        sdo_command(bus, 2)
        aborted = log.wait_for("state", state="TUMBLE_STATE_ABORT")
        assert aborted["cause"] == fault["reason"] and fault["reason"] in aborted["message"]
    code, document = ended(node)
    assert code == (130 if ended_by == "signal" else 0)
    assert (document["cause"]["reason"], document["cause"]["failed_in"]) == (fault["reason"], fault["state"])
    last = log.lines()[-1]
    assert (last["event"], last["exit"], last["cause"]) == ("end", code, fault["reason"])
    assert last["remedy"] == fault["remedy"] and last["remedy"] in last["message"]
