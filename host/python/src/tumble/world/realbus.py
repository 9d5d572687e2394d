"""A calibration in real time on a CAN bus of Linux, between the processes of tumble-stand and of the computer:
tumble-node, or the board zcu102 in its emulator.

`socketcan:IF`: on an interface of this machine. `uml`: on vcan0 inside user-mode Linux. A console (console.py) runs
them there. Either leaves in the stage's folder `bench` what a run in a world leaves: run.csv, bus.log and bench.json,
the computer's document with the stand's truth.

The board is told of its stand and block by a commissioning record, to begin by SDO, and its result is read by SDO, as
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
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from tumble import interruption
from tumble.documents import base, bench
from tumble.documents.bench import NODE, STAND, Bench, Node, RunWithTruth, Stand
from tumble.errors import BadInput, BenchFault, Disagreement, Skipped, UsageError, quoted
from tumble.firmware_tables import STATES
from tumble.schedule import Schedule
from tumble.world import console, emulator, in_process, outcome, programs, replay, uml
from tumble.world.border import Event

INPROCESS, UML, SOCKETCAN = outcome.INPROCESS, "uml", "socketcan:"
HOST, BOARD = "host", replay.BOARD

_IMAGE = "navcomp-emulated"
_STOP_S = 30.0  # for the node to stop the table and end
_PATIENCE_S = 1e6  # of the firmware after a fault, for a person
_TICK_S = 0.05
_MEMORY_MB = {HOST: 256, BOARD: 1024}  # of user-mode Linux
_RECEIVE_BUFFER = 8 * 2**20
_ANSWERS = "done, abort, leave, repeat position INDEX or repeat mounting NUMBER"
_ANSWER = re.compile(r"done|abort|leave|repeat (position|mounting) [0-9]{1,3}", re.ASCII)
_INTERFACE = re.compile(r"[A-Za-z0-9._-]{1,15}", re.ASCII)

OnEvent = Callable[[Event], "str | None"]
_Judged: TypeAlias = "tuple[Ended, RunWithTruth | None]"


@dataclass(frozen=True)
class Ended:
    """How the computer ended: its exit code, what it had to say, and whether it was asked to stop."""

    code: int
    complaint: str
    interrupted: bool


def require_bus(text: str) -> str:
    """A value of --bus, as it is. Raises UsageError."""
    interface = text.removeprefix(SOCKETCAN) if text.startswith(SOCKETCAN) else None
    if text in (INPROCESS, UML) or (interface is not None and _INTERFACE.fullmatch(interface)):
        return text
    raise UsageError(f"--bus: {quoted(text)} is not inprocess, uml, or socketcan: and the name of an interface")


def require_there(bus: str, firmware: str = HOST) -> None:
    """Raise, with one line about what to do, unless this bus, and the firmware on it, are to be had here."""
    if firmware == BOARD and bus == INPROCESS:
        raise UsageError(f"--firmware {BOARD}: on a real bus only: --bus uml or --bus socketcan:IF")
    if bus == UML:
        uml.require_there("--bus uml: ")
    elif bus != INPROCESS:
        _require_interface(bus.removeprefix(SOCKETCAN))
    if firmware == BOARD and (lacking := emulator.missing(_IMAGE)) is not None:
        raise Skipped(f"--firmware {BOARD}: {lacking}")
    if firmware == BOARD and shutil.which("candump") is None:
        raise Skipped(f"--firmware {BOARD}: no candump: install can-utils")


def _require_interface(interface: str) -> None:
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except (AttributeError, OSError):
        lacking = uml.missing()
        other = "--bus uml brings its own" if lacking is None else f"user-mode Linux could bring its own ({lacking})"
        said = f"--bus {SOCKETCAN}{interface}: this kernel has no CAN (modules can, can_raw); {other}"
        raise Skipped(said) from None
    state = Path("/sys/class/net") / interface
    if not state.exists():
        hint = f"; a virtual one: ip link add dev {interface} type vcan && ip link set up {interface}"
        raise UsageError(f"--bus: there is no interface {interface}{hint if interface.startswith('v') else ''}")
    if not int((state / "flags").read_text(), 16) & 1:
        raise BenchFault(f"--bus: the interface {interface} is down: ip link set up {interface}")


def run(
    bus: str,
    firmware: str,
    scenario: Path,
    seed: int,
    stage: Path,
    on_event: OnEvent,
    schedule: Schedule,
    interactive: bool = False,
) -> tuple[Ended, RunWithTruth | None]:
    """Calibrate. Returns how it ended, and its document with the stand's, as it is in stage/bench too: None where it
    failed early.
    `interactive`: what `on_event` answers is done at the stand, and told the node by SDO. Raises TumbleError."""
    require_there(bus, firmware)
    with uml.work_folder() as name:
        folder = Path(name)
        shutil.copy(scenario, folder / "scenario.txt")
        if (gains := replay.gains_beside(scenario)) is not None:
            shutil.copy(gains, folder)
        interface = uml.INTERFACE if bus == UML else bus.removeprefix(SOCKETCAN)
        out = folder / "bench" if bus == UML else stage / "bench"
        stand = [programs.find("tumble-stand"), interface, str(folder / "scenario.txt")]
        stand += ["--seed", str(seed), "--with-parent", *(["--operator", "ask"] if interactive else [])]
        if firmware == BOARD:
            job = {"board": _board(folder, interface)}
            progress = _Progress(folder, lambda told: on_event(_state(told, schedule)) if told["moved"] else None)
        else:
            job = {"node": _node(folder, interface, out, interactive)}
            progress = _Progress(folder, on_event)
        (folder / "job.json").write_text(json.dumps({"interface": interface, "stand": stand, **job}))
        with interruption.instead(progress.stop):
            (_in_uml if bus == UML else _here)(folder, progress, firmware)
        if bus == UML and out.exists():
            shutil.copytree(out, stage / "bench")
        told = _json(folder / "ended.json")
        if told is None:
            raise BenchFault(
                f"nothing is known of the run: {_text(folder / 'console.err')[-200:] or 'it says nothing'}"
            )
        judged = _judged_board if firmware == BOARD else _judged
        return judged(told, folder, stage / "bench", scenario, progress.interrupted)


def _node(folder: Path, interface: str, out: Path, interactive: bool) -> list[str]:
    """The command of the node, without its progress."""
    command = [programs.find("tumble-node"), interface, str(folder / "scenario.txt"), "--start"]
    patience = ["--patience", str(_PATIENCE_S)] if interactive else []
    return [*command, "--with-parent", "--out", str(out), *replay.gain_options(folder / "scenario.txt"), *patience]


def _board(folder: Path, interface: str) -> list[str]:
    """The command of the board, as it is commissioned."""
    (folder / "commissioning").write_bytes(replay.commissioning(str(folder / "scenario.txt")))
    return emulator.command(
        _IMAGE,
        *emulator.commissioned(folder / "commissioning"),
        *emulator.weighted(replay.gains_beside(folder / "scenario.txt")),
        *emulator.on_interface(interface),
    )


def _console(folder: Path) -> list[str]:
    return [sys.executable, "-I", "-S", "-B", console.__file__, str(folder / "job.json")]


def _in_uml(folder: Path, progress: _Progress, firmware: str) -> None:
    """The emulator cannot say what the kernel drops for want of room: there is to be plenty."""
    job = f"{shlex.join(_console(folder))} 2>console.err\n"
    if firmware == BOARD:
        rooms = (f"echo {_RECEIVE_BUFFER} >/proc/sys/net/core/rmem_{name}\n" for name in ("max", "default"))
        job = "".join(rooms) + job
    uml.run(job, folder, on_tick=progress, memory_mb=_MEMORY_MB[firmware])


def _here(folder: Path, progress: _Progress, _firmware: str) -> None:
    with (
        open(folder / "console.err", "w") as errors,
        subprocess.Popen(_console(folder), stdin=subprocess.DEVNULL, stderr=errors, start_new_session=True) as process,
    ):
        try:
            while process.poll() is None:
                progress()
                time.sleep(_TICK_S)
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)  # and all that it has started
            raise
    progress()


class _Progress:
    """Called all the while: hands on the lines of progress as they come, and the answers; and, by `stop`, Ctrl-C."""

    def __init__(self, folder: Path, on_event: OnEvent):
        self.interrupted = False
        self._folder, self._on_event = folder, on_event
        self._read, self._stopping, self._answers = 0, 0.0, 0
        self._handing_on = False

    def __call__(self) -> None:
        path = self._folder / "progress"
        data = path.read_bytes()[self._read :] if path.exists() else b""
        whole = data[: data.rfind(b"\n") + 1]
        self._read += len(whole)
        for line in whole.splitlines():
            self._pass_on(self._hand_on(json.loads(line)))
        if self._stopping and time.monotonic() > self._stopping:
            raise BenchFault("interrupted, but the run does not end: THE TABLE MAY STILL TURN")

    def stop(self) -> None:
        """Have the table stopped and everything ended."""
        self.interrupted = True
        self._stopping = time.monotonic() + _STOP_S
        uml.stop(self._folder)
        if self._handing_on:
            raise KeyboardInterrupt  # nobody waits for an answer any more

    def _hand_on(self, event: Event) -> str | None:
        """Returns what a person says to it, if it is something that can be said."""
        if self.interrupted:
            return None
        try:
            self._handing_on = True
            answer = self._on_event(event)
            while answer is not None and not _ANSWER.fullmatch(answer):
                answer = self._on_event({"event": "refused", "what": f"an answer is {_ANSWERS}"})
            return answer
        except KeyboardInterrupt:
            return None
        finally:
            self._handing_on = False

    def _pass_on(self, answer: str | None) -> None:
        """A file for each answer."""
        if answer is not None:
            self._answers += 1
            part = self._folder / "answer.part"
            part.write_text(f"{answer}\n")
            part.rename(self._folder / f"answer.{self._answers}")


def _state(told: dict[str, Any], schedule: Schedule) -> Event:
    """A state PDO of the board, in the form of tumble-node's progress."""
    position = schedule.positions[min(told["index"], len(schedule.positions) - 1)]
    return {
        "event": "state",
        "state": f"TUMBLE_STATE_{list(STATES)[told['state']]}",
        "virtual_s": told["s"],
        "mounting": position.mounting,
        "position": position.number,
        "index": told["index"],
        "count": len(schedule.positions),
        "finished": told["finished"],
    }


def _judged(told: dict[str, Any], folder: Path, out: Path, scenario: Path, interrupted: bool) -> _Judged:
    """Join the documents of stand and node. Raises BenchFault where one of them did not come to its end."""
    who = "stand" if told["end"] == "stand" else "node"
    complaint = _text(folder / f"{who}.err").replace(str(folder / "scenario.txt"), str(scenario))
    if told["end"] == "stopped":
        return Ended(-signal.SIGTERM, "", interrupted), None
    if told["end"] not in ("done", "stand"):
        raise BenchFault(told["end"])
    ended = Ended(told["code"], complaint, interrupted)
    if ended.code == UsageError.exit_code or (who == "node" and ended.code == Skipped.exit_code):
        return ended, None
    if who == "stand":
        raise BenchFault(f"tumble-stand failed ({ended.code}): {complaint or 'it says nothing'}")
    ours, theirs = _read(Node, NODE, out / outcome.DOCUMENT), _read(Stand, STAND, folder / "stand.json")
    rest = "THE TABLE MAY STILL TURN" if theirs is None else _at_rest(theirs)
    if ours is None:
        raise BenchFault(f"tumble-node ended without a result ({_how(ended)}); {rest}")
    if theirs is None:
        raise BenchFault(f"tumble-stand ended without a document; tumble-node says: {ours.reason_sentence}")
    return ended, _joined(outcome.with_stand(ours, theirs), out)


def _joined(document: RunWithTruth, out: Path) -> RunWithTruth:
    (out / outcome.DOCUMENT).write_text(json.dumps(bench.written(document)), encoding="utf-8")
    return document


def _at_rest(stand: Stand) -> str:
    return "the table is at rest" if stand.table.at_rest else "THE TABLE IS NOT AT REST"


def _how(ended: Ended) -> str:
    code = ended.code - 128 if ended.code > 128 else -ended.code
    if code > 0 and code in set(signal.Signals):
        return f"killed by {signal.Signals(code).name}"
    return ended.complaint or f"exit code {ended.code}"


def _judged_board(board: dict[str, Any], folder: Path, out: Path, scenario: Path, interrupted: bool) -> _Judged:
    """From what the console left to what a run in a world leaves."""
    log, stand = _text(folder / "serial.log"), _read(Stand, STAND, folder / "stand.json")
    began = (folder / "stand.json").exists()  # the stand is started when the board has booted
    if interrupted and not began:
        return Ended(-signal.SIGTERM, "", interrupted), None
    if began and stand is None:
        complaint = _text(folder / "stand.err") or board["end"]
        raise BenchFault(f"tumble-stand ended without a document: {complaint}")
    if board["end"] not in ("done", "failed", "stopped"):
        message = (log.splitlines() or [_text(folder / "board.err")])[-1]
        raise BenchFault(f"{board['end']}; its last words: {ascii(message)[1:-1]}")
    assert stand is not None  # without it no run comes so far
    ours = _replayed(folder, out, scenario)
    if board["end"] == "done":
        _require_same_bits(ours, board["numbers"])
    elif board["end"] == "failed" and ours.reason_number != board["reason"]:
        raise BenchFault(_unexplained(log, stand))
    counters = board["counters"] | _controller_counters(log)
    document = _joined(outcome.with_stand(ours, stand, board=counters), out)
    return Ended(ours.exit, "", interrupted), document


def _replayed(folder: Path, out: Path, scenario: Path) -> Bench:
    """The run once more in this process: its run.csv, bus.log and document."""
    try:
        firmware = replay.played(replay.read(str(folder / "bus.log")), str(scenario))
    except (BadInput, UsageError) as error:
        raise BenchFault(f"the board's run cannot be replayed: {error}") from None
    out.mkdir()
    return in_process.write(firmware, out)


def _require_same_bits(ours: Bench, theirs: list[str]) -> None:
    numbers = [] if ours.K is None or ours.U0 is None else [*ours.K.ravel().tolist(), *ours.U0.tolist()]
    if [struct.pack(">d", number).hex() for number in numbers] != theirs:
        raise Disagreement("the board states other coefficients than the replay of its bus gives; no result is given")


def _unexplained(log: str, stand: Stand) -> str:
    """The board stopped for a reason that its replay does not find: it has not heard all that was on the bus."""
    reasons = re.findall(r"TUMBLE_REASON_(\w+)", log)
    overflows = _controller_counters(log).get("controller_receive_overflows", 0)
    return (
        f"the board stopped with {reasons[-1] if reasons else 'no reason'}, which its bus does not explain: frames were"
        f" lost on the way to it (its receive queue overflowed {overflows} times); {_at_rest(stand)}"
    )


def _controller_counters(log: str) -> dict[str, int]:
    """What the board's log says of its CAN controller, at the end of the run."""
    lines = [line for line in log.splitlines() if line.startswith("can: ")]
    pairs = re.findall(r"([a-z][a-z -]*) (\d+)", lines[-1].removeprefix("can: ")) if lines else []
    return {"controller_" + re.sub("[ -]", "_", name.strip()): int(count) for name, count in pairs}


def _text(path: Path) -> str:
    return path.read_text(errors="replace").strip() if path.exists() else ""


def _read(kind: type[base.DocumentT], name: str, path: Path) -> base.DocumentT | None:
    """What a program said at its end; None where it said nothing, or not all of it. Raises BenchFault."""
    text = _text(path)
    try:
        return base.read(kind, name, text.encode(), path.name) if text.endswith("}") else None
    except BadInput as error:
        raise BenchFault(str(error)) from None


def _json(path: Path) -> dict[str, Any] | None:
    text = _text(path)
    return json.loads(text) if text.endswith("}") else None
