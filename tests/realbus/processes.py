"""What the tests start: an interface, tumble-node, tumble-stand, and whatever else takes part."""

import json
import signal
import subprocess
import time
from pathlib import Path

from documents import valid
from simulated_bench import scenario, wait_until

from tumble.world import programs

HASTE = {  # a calibration within seconds of real time
    "motion__speed_deg_s": 720,
    "motion__acceleration_deg_s2": 7200,
    "motion__settling_s": 0.05,
    "profile__homing_fast_deg_s": 720,
    "profile__homing_slow_deg_s": 90,
    "procedure__settle_ms": 50,
    "procedure__samples": 10,
    "procedure__warm_up_samples": 5,
    "procedure__gravity_limit_g": 1e-3,
    "operator__mount_s": 0.05,
    "keeper__serial": "TB-0001",
}
PATIENCE = {  # where a busy machine that lets a process wait is not what is tested
    "firmware__heartbeat_timeout_ms": 3000,
    "profile__heartbeat_timeout_ms": 3000,
    "profile__handshake_timeout_ms": 10000,
}


def slow_table(speed_deg_s=60):
    """Time for something to happen. The table turns no faster when it homes: its drive would not."""
    homing = {f"profile__homing_{pace}_deg_s": min(speed_deg_s, HASTE[f"profile__homing_{pace}_deg_s"])
              for pace in ("fast", "slow")}
    return {**HASTE, **homing, "motion__speed_deg_s": speed_deg_s}


__all__ = ["HASTE", "PATIENCE", "Interface", "Node", "Stand", "scenario", "sdo_command", "slow_table", "wait_until"]


class Interface:
    """A virtual CAN interface."""

    def __init__(self, name):
        self.name = name
        self.add()

    def __str__(self):
        return self.name

    def add(self):
        """Make it, up."""
        ip("link", "add", "dev", self.name, "type", "vcan")
        self.up()

    def up(self):
        """Up."""
        ip("link", "set", "up", self.name)

    def down(self):
        """Down."""
        ip("link", "set", "down", self.name)

    def remove(self):
        """Gone."""
        subprocess.run(["ip", "link", "del", self.name], stderr=subprocess.DEVNULL, check=False)

    def frames(self):
        """How many have been sent on it by anybody."""
        return int(Path(f"/sys/class/net/{self.name}/statistics/tx_packets").read_text())


def ip(*arguments):
    """The command ip."""
    subprocess.run(["ip", *arguments], check=True)


class _Program:
    def __init__(self, name, *arguments):
        command = [programs.find(name), *map(str, arguments)]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, text=True)
        self.errors = ""

    def kill(self):
        """At once."""
        self.process.kill()
        self.process.wait()

    def signal(self, number=signal.SIGTERM):
        """Send one."""
        self.process.send_signal(number)

    def wait(self, timeout=60):
        """(exit code, its last document, which its schema allows, or None)."""
        out, self.errors = self.process.communicate(timeout=timeout)
        lines = out.splitlines()
        return self.process.returncode, valid(lines[-1], self.kind) if lines else None


class Node(_Program):
    """tumble-node; its progress goes to a file."""

    kind = "node"  # of its document

    def __init__(self, interface, *arguments, folder):
        self.progress = Path(folder) / f"progress-{time.monotonic_ns()}"
        with open(self.progress, "w") as file:
            command = [programs.find("tumble-node"), str(interface), *map(str, arguments)]
            command += ["--progress-fd", str(file.fileno())]
            self.process = subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, pass_fds=(file.fileno(),)
            )

    def events(self):
        """All that it has told so far."""
        text = self.progress.read_text()
        return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]

    def wait_for(self, state, position=None, timeout=60):
        """Until it has been in a state (at a position of the schedule, by its index)."""
        found = []

        def seen():
            found[:] = [
                event for event in self.events()
                if event["event"] == "state" and event["state"] == f"TUMBLE_STATE_{state}"
                and position in (None, event["index"])
            ]
            return bool(found)

        wait_until(seen, timeout)
        return found[-1]


class Stand(_Program):
    """tumble-stand."""

    kind = "stand"

    def __init__(self, interface, *arguments):
        before = interface.frames()
        super().__init__("tumble-stand", interface, *arguments)
        wait_until(lambda: interface.frames() > before or self.process.poll() is not None)  # its nodes boot up

    def say(self, answer):
        """As the person at the stand (--operator ask)."""
        self.process.stdin.write(answer + "\n")
        self.process.stdin.flush()
        time.sleep(0.1)

    def end(self):
        """Its document, after it was told to end."""
        self.signal()
        code, document = self.wait()
        assert code == 0, self.errors
        return document


def sdo_command(interface, command, argument=0):
    """Give node 1 a command, by cansend: the argument first."""
    for subindex, value in ((1, argument), (2, command)):
        subprocess.run(["cansend", str(interface), f"601#2F0220{subindex:02X}{value:02X}000000"], check=True)
        time.sleep(0.05)
