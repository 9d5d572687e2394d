"""A calibration by the emulated board zcu102 on a CAN bus of Linux: `tumble bench --firmware zcu102`.

A commissioning record tells the board of its stand and block. It is told to begin, and its result is read, by SDO, as
any host would do it. What it averaged is found by replaying the recorded bus through the firmware of this process; the
twelve coefficients must have the same bits.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tumble import interruption
from tumble.errors import BadInput, BenchFault, Disagreement, Skipped, UsageError
from tumble.schedule import Schedule
from tumble.world import console, emulator, in_process, outcome, program, programs, realbus, replay, uml

FIRMWARE = "zcu102"
STATES = (  # firmware/procedure/states.h
    "IDLE PREFLIGHT WARM_UP WAIT_MOUNTING HOME MOVE SETTLE AVERAGE NEXT SOLVE VERIFY PROPOSE DONE FAULT ABORT".split()
)

_IMAGE = "navcomp-emulated"
_MEMORY_MB = 1024
_RECEIVE_BUFFER = 8 * 2**20
_TICK_S = 0.1

OnEvent = Callable[[program.Event], str | None]


def require_there(bus: str) -> None:
    """Raise, with one line about what to do, unless the board can be had on this bus."""
    if bus == realbus.INPROCESS:
        raise UsageError(f"--firmware {FIRMWARE}: on a real bus only: --bus uml or --bus socketcan:IF")
    realbus.require_there(bus)
    if (lacking := emulator.missing(_IMAGE)) is not None:
        raise Skipped(f"--firmware {FIRMWARE}: {lacking}")
    if shutil.which("candump") is None:
        raise Skipped(f"--firmware {FIRMWARE}: no candump: install can-utils")


def run(bus: str, scenario: Path, seed: int, stage: Path, on_event: OnEvent, schedule: Schedule) -> program.Ended:
    """Calibrate. Leaves run.csv, bus.log and bench.json in stage/bench, as a world does. Raises TumbleError."""
    require_there(bus)
    with uml.work_folder() as name:
        folder = Path(name)
        realbus.copy_inputs(scenario, folder)
        interface = uml.INTERFACE if bus == realbus.UML else bus.removeprefix(realbus.SOCKETCAN)
        (folder / "commissioning").write_bytes(replay.commissioning(str(folder / "scenario.txt")))
        _write_job(folder, interface, seed)
        progress = _Progress(folder, on_event, schedule)
        command = [sys.executable, "-I", "-S", "-B", console.__file__, str(folder / "job.json")]
        with interruption.Instead(progress.stop):
            if bus == realbus.UML:
                _in_uml(folder, command, progress)
            else:
                _here(command, progress)
        return _judged(folder, stage, scenario, progress.interrupted)


def _write_job(folder: Path, interface: str, seed: int) -> None:
    stand = programs.find("tumble-stand", "boards/linux")
    job = {
        "interface": interface,
        "stand": [stand, interface, str(folder / "scenario.txt"), "--seed", str(seed), "--with-parent"],
        "board": emulator.command(
            _IMAGE,
            *emulator.commissioned(folder / "commissioning"),
            *emulator.weighted(replay.gains_beside(folder / "scenario.txt")),
            *emulator.on_interface(interface),
        ),
    }
    (folder / "job.json").write_text(json.dumps(job))


def _in_uml(folder: Path, command: list[str], progress: _Progress) -> None:
    """The emulator cannot say what the kernel drops for want of room: there is to be plenty."""
    room = "".join(f"echo {_RECEIVE_BUFFER} >/proc/sys/net/core/rmem_{name}\n" for name in ("max", "default"))
    job = f"{room}{shlex.join(command)} 2>console.err\n"
    uml.run(job, folder, on_tick=progress, memory_mb=_MEMORY_MB)


def _here(command: list[str], progress: _Progress) -> None:
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True) as process:
        try:
            while process.poll() is None:
                progress()
                time.sleep(_TICK_S)
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)  # and all that it has started
            raise
    progress()


class _Progress:
    """Called all the while: hands on what the console tells, in the form of tumble-node's progress."""

    def __init__(self, folder: Path, on_event: OnEvent, schedule: Schedule):
        self.interrupted = False
        self._folder, self._on_event, self._schedule = folder, on_event, schedule
        self._read = 0

    def stop(self) -> None:
        """Have the table stopped and everything ended."""
        self.interrupted = True
        uml.stop(self._folder)

    def __call__(self) -> None:
        path = self._folder / "progress"
        data = path.read_bytes()[self._read :] if path.exists() else b""
        whole = data[: data.rfind(b"\n") + 1]
        self._read += len(whole)
        for line in whole.splitlines():
            told = json.loads(line)
            if told["moved"]:
                self._on_event(self._event(told))

    def _event(self, told: dict[str, Any]) -> program.Event:
        positions = self._schedule.positions
        position = positions[min(told["index"], len(positions) - 1)]
        return {
            "event": "state",
            "state": f"TUMBLE_STATE_{STATES[told['state']]}",
            "virtual_s": told["s"],
            "mounting": position.mounting,
            "position": position.number,
            "index": told["index"],
            "count": len(positions),
            "finished": told["finished"],
        }


def _judged(folder: Path, stage: Path, scenario: Path, interrupted: bool) -> program.Ended:
    """From what the console left to what a run in a world leaves."""
    stand = _json(folder / "stand.json")
    board = _json(folder / "board.json")
    if board is None:
        raise BenchFault(f"nothing is known of the board: {_text(folder / 'console.err')[-200:] or 'it says nothing'}")
    began = (folder / "stand.json").exists()  # the stand is started when the board has booted
    if interrupted and not began:
        return program.Ended(-signal.SIGTERM, "", interrupted)
    if began and stand is None:
        complaint = _text(folder / "stand.err") or board["end"]
        raise BenchFault(f"tumble-stand ended without a document: {complaint}")
    if board["end"] not in ("done", "failed", "stopped"):
        serial = (_text(folder / "serial.log").splitlines() or [_text(folder / "board.err")])[-1]
        raise BenchFault(f"{board['end']}; its last words: {ascii(serial)[1:-1]}")
    assert stand is not None  # without it no run comes so far
    ours = _replayed(folder, stage, scenario)
    if board["end"] == "done":
        _require_same_bits(ours, board["numbers"])
    elif board["end"] == "failed" and ours["reason_number"] != board["reason"]:
        raise BenchFault(_unexplained(_text(folder / "serial.log"), stand))
    board["counters"] |= _controller_counters(_text(folder / "serial.log"))
    joined = outcome.with_stand(ours, stand, board=board)
    (stage / "bench" / outcome.DOCUMENT).write_text(json.dumps(joined), encoding="utf-8")
    return program.Ended(ours["exit"], "", interrupted)


def _replayed(folder: Path, stage: Path, scenario: Path) -> dict[str, Any]:
    """The run once more in this process: its run.csv, bus.log and document."""
    try:
        firmware = replay.played(replay.read(str(folder / "bus.log")), str(scenario))
    except (BadInput, UsageError) as error:
        raise BenchFault(f"the board's run cannot be replayed: {error}") from None
    (stage / "bench").mkdir()
    return in_process.write(firmware, stage / "bench")


def _require_same_bits(ours: dict[str, Any], theirs: list[str]) -> None:
    numbers = [*sum(ours["K"] or [], []), *(ours["U0"] or [])]
    if [struct.pack(">d", number).hex() for number in numbers] != theirs:
        raise Disagreement("the board states other coefficients than the replay of its bus gives; no result is given")


def _unexplained(log: str, stand: dict[str, Any]) -> str:
    """The board stopped for a reason that its replay does not find: it has not heard all that was on the bus."""
    reasons = re.findall(r"TUMBLE_REASON_(\w+)", log)
    overflows = _controller_counters(log).get("controller_receive_overflows", 0)
    rest = "the table is at rest" if stand["table"]["at_rest"] else "THE TABLE IS NOT AT REST"
    return (
        f"the board stopped with {reasons[-1] if reasons else 'no reason'}, which its bus does not explain: frames were"
        f" lost on the way to it (its receive queue overflowed {overflows} times); {rest}"
    )


def _controller_counters(log: str) -> dict[str, int]:
    """What the board's log says of its CAN controller, at the end of the run."""
    lines = [line for line in log.splitlines() if line.startswith("can: ")]
    pairs = re.findall(r"([a-z][a-z -]*) (\d+)", lines[-1].removeprefix("can: ")) if lines else []
    return {"controller_" + re.sub("[ -]", "_", name.strip()): int(count) for name, count in pairs}


def _text(path: Path) -> str:
    return path.read_text(errors="replace").strip() if path.exists() else ""


def _json(path: Path) -> dict[str, Any] | None:
    text = _text(path)
    return json.loads(text) if text.endswith("}") else None
