"""A recorded bus log through the firmware again: on this machine, or on the emulated board zcu102. Either way the same
numbers, to the last bit, as in the recorded run.
"""

from __future__ import annotations

import json
import struct
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from tumble.bench import emulator, folder, foreign_log, programs
from tumble.errors import BadInput, BenchFault, Skipped, file_name

SCHEMA = "tumble.replay/1"
BOARD = "zcu102"

_NAME = "tumble-replay"
_COUNTERS = ("received", "samples", "averaged", "lost", "retries", "commands_refused")
_HOST_COUNTERS = {  # by our name: as tumble-bench has it
    "received": "frames_received",
    "samples": "procedure_samples",
    "averaged": "samples_averaged",
    "lost": "samples_lost",
    "retries": "retries",
    "commands_refused": "commands_refused_in_replay",
}


def default_scenario(log: str) -> str | None:
    """The scenario of the run folder that the log stands in, if it does."""
    path = Path(log).resolve().parent / "inputs" / "scenario.txt"
    return str(path) if path.is_file() else None


def replay(log: str, scenario: str | None, firmware: str) -> dict[str, Any]:
    """Replay. Returns the document:

        schema; log; format, time_step_us: as of foreign_log.Read; firmware: "host" | "zcu102"
        state, reason: names of the firmware's lists
        K (3 x 3, V/g), U0 (3, V); bits: the same twelve as hexadecimal digits of IEEE 754 doubles; pass: of the gravity
        check; all null where the run came to no result
        counters {received, samples, averaged, lost, retries, commands_refused}

    Raises BadInput, NotInstalled, Skipped, BenchFault.
    """
    if Path(log).is_dir():
        raise BadInput("a folder, not a file; the log of a run folder is its bus.log", log)
    with tempfile.TemporaryDirectory(prefix="tumble-") as name:
        read = foreign_log.as_candump(log, Path(name))
        told = (_on_board if firmware == BOARD else _on_host)(read.path, scenario)
    numbers = told["numbers"]
    return {
        "schema": SCHEMA,
        "log": file_name(log),
        "format": read.format,
        "time_step_us": read.time_step_us,
        "firmware": firmware,
        "state": told["state"],
        "reason": told["reason"],
        "K": None if numbers is None else [numbers[0:3], numbers[3:6], numbers[6:9]],
        "U0": None if numbers is None else numbers[9:12],
        "bits": None if numbers is None else [struct.pack(">d", number).hex() for number in numbers],
        "pass": told["pass"],
        "counters": told["counters"],
    }


def _on_host(log: str, scenario: str | None) -> dict[str, Any]:
    document = json.loads(_run(*gain_options(scenario), "--", log, *([] if scenario is None else [scenario])))
    known = document["K"] is not None
    return {
        "state": document["state"],
        "reason": document["reason"],
        "numbers": [*sum(document["K"], []), *document["U0"]] if known else None,
        "pass": document["verification"]["pass"] if known else None,
        "counters": {name: document["counters"][_HOST_COUNTERS[name]] for name in _COUNTERS},
    }


def gains_beside(scenario: str | Path | None) -> Path | None:
    """The gain record of the scenario's run, if it had one."""
    path = None if scenario is None else Path(scenario).with_name(folder.GAINS)
    return path if path is not None and path.is_file() else None


def gain_options(scenario: str | Path | None) -> list[str]:
    """What tumble-replay is told of it."""
    path = gains_beside(scenario)
    return [] if path is None else ["--gain-record", str(path)]


def commission(scenario: str | None, record: Path) -> None:
    """Write the record that tells the board what the scenario says. Raises BadInput, BenchFault."""
    _run(*gain_options(scenario), "--commissioning", str(record), "--", *([] if scenario is None else [scenario]))


def _on_board(log: str, scenario: str | None) -> dict[str, Any]:
    scenarios = [] if scenario is None else [scenario]
    if (lacking := emulator.missing("replay")) is not None:
        raise Skipped(f"--firmware {BOARD}: {lacking}")
    with tempfile.TemporaryDirectory(prefix="tumble-") as name:
        recording, record = Path(name) / "recording", Path(name) / "commissioning"
        _run(*gain_options(scenario), "--recording", str(recording), "--", log, *scenarios)
        commission(scenario, record)
        told = emulator.replay(recording, record, gains_beside(scenario))
    known = "K" in told
    return {
        "state": told["state"][0],
        "reason": told["reason"][0],
        "numbers": [struct.unpack(">d", bytes.fromhex(bits))[0] for bits in told["K"] + told["U0"]] if known else None,
        "pass": told["pass"] == ["1"] if known else None,
        "counters": {name: int(told[name][0]) for name in _COUNTERS},
    }


def _run(*arguments: str) -> str:
    """What tumble-replay prints. A run without a result is one, too."""
    command = [programs.find(_NAME, "host/replay"), *arguments]
    try:
        ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    except OSError as error:
        raise BenchFault(f"{_NAME} cannot be started: {(error.strerror or 'unknown').lower()}") from None
    complaint = ended.stderr.strip().removeprefix(f"{_NAME}: ")
    if ended.returncode == BadInput.exit_code:
        raise BadInputLine(complaint)
    if ended.returncode not in (0, 1, 3) or complaint:
        raise BenchFault(f"{_NAME} failed ({ended.returncode}): {complaint or 'it says nothing'}")
    return ended.stdout


class BadInputLine(BadInput):
    """A complaint that names its file and line already."""

    def __init__(self, complaint: str):
        Exception.__init__(self, complaint)
        self.row = self.column = None
