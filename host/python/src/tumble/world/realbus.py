"""A calibration in real time on a CAN bus of Linux, between the processes tumble-node and tumble-stand.

`socketcan:IF`: on an interface of this machine. `uml`: on vcan0 inside user-mode Linux. Either leaves in the stage's
folder `bench` what a run in a world leaves: run.csv, bus.log and bench.json, the node's document with the
stand's truth.
"""

from __future__ import annotations

import json
import re
import shlex
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tumble import interruption
from tumble.errors import BenchFault, Skipped, UsageError, quoted
from tumble.world import outcome, program, programs, replay, uml

INPROCESS, UML, SOCKETCAN = outcome.INPROCESS, "uml", "socketcan:"

_FOLDER = "boards/linux"
_EARLY_S = 0.3  # within which a program that cannot work gives up
_REST_S = 15.0  # for the stand to come to rest and report
_PATIENCE_S = 1e6  # of the firmware after a fault, for a person
_ANSWERS = "done, abort, leave, repeat position INDEX or repeat mounting NUMBER"
_ANSWER = re.compile(r"done|abort|leave|repeat (position|mounting) [0-9]{1,3}", re.ASCII)
_INTERFACE = re.compile(r"[A-Za-z0-9._-]{1,15}", re.ASCII)

OnEvent = Callable[[program.Event], str | None]


def require_bus(text: str) -> str:
    """A value of --bus, as it is. Raises UsageError."""
    interface = text.removeprefix(SOCKETCAN) if text.startswith(SOCKETCAN) else None
    if text in (INPROCESS, UML) or (interface is not None and _INTERFACE.fullmatch(interface)):
        return text
    raise UsageError(f"--bus: {quoted(text)} is not inprocess, uml, or socketcan: and the name of an interface")


def require_there(bus: str) -> None:
    """Raise, with one line about what to do, unless this bus is to be had here."""
    if bus == UML:
        uml.require_there("--bus uml: ")
        return
    interface = bus.removeprefix(SOCKETCAN)
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except (AttributeError, OSError):
        lacking = uml.missing()
        other = "--bus uml brings its own" if lacking is None else f"user-mode Linux could bring its own ({lacking})"
        raise Skipped(f"--bus {bus}: this kernel has no CAN (modules can, can_raw); {other}") from None
    state = Path("/sys/class/net") / interface
    if not state.exists():
        hint = f"; a virtual one: ip link add dev {interface} type vcan && ip link set up {interface}"
        raise UsageError(f"--bus: there is no interface {interface}{hint if interface.startswith('v') else ''}")
    if not int((state / "flags").read_text(), 16) & 1:
        raise BenchFault(f"--bus: the interface {interface} is down: ip link set up {interface}")


@dataclass(frozen=True)
class _Wanted:
    """What both ways of running are told."""

    scenario: Path
    seed: int
    stage: Path
    interactive: bool

    def stand(self, interface: str) -> list[str]:
        """The command of the stand."""
        path = programs.find("tumble-stand", _FOLDER)
        asking = ["--operator", "ask"] if self.interactive else []
        return [path, interface, str(self.scenario), "--seed", str(self.seed), "--with-parent", *asking]

    def node(self, interface: str, out: Path) -> list[str]:
        """The command of the node, without its progress."""
        path = programs.find("tumble-node", _FOLDER)
        options = replay.gain_options(self.scenario)
        if self.interactive:
            options += ["--patience", str(_PATIENCE_S)]
        return [path, interface, str(self.scenario), "--start", "--with-parent", "--out", str(out), *options]


def copy_inputs(scenario: Path, folder: Path) -> None:
    """Scenario, as scenario.txt, and gain record, if the run has one."""
    shutil.copy(scenario, folder / "scenario.txt")
    if (gains := replay.gains_beside(scenario)) is not None:
        shutil.copy(gains, folder)


def run(bus: str, scenario: Path, seed: int, stage: Path, on_event: OnEvent, interactive: bool) -> program.Ended:
    """Calibrate. Returns how tumble-node ended; its document, with the stand's, is in stage/bench unless it failed
    early. `interactive`: what `on_event` answers is done at the stand, and told the node by SDO. Raises Skipped,
    UsageError, BenchFault."""
    require_there(bus)
    wanted = _Wanted(scenario, seed, stage, interactive)
    return _in_uml(wanted, on_event) if bus == UML else _here(wanted, bus.removeprefix(SOCKETCAN), on_event)


def _here(wanted: _Wanted, interface: str, on_event: OnEvent) -> program.Ended:
    out = wanted.stage / "bench"
    with _Stand(wanted.stand(interface)) as stand:
        ended = program.run(wanted.node(interface, out), lambda event: stand.tell(_answer(event, on_event)))
        document = stand.end()
    return _judged(ended, out, document)


def _answer(event: program.Event, on_event: OnEvent) -> str | None:
    """What a person says to it, if it is something that can be said."""
    answer = on_event(event)
    while answer is not None and not _ANSWER.fullmatch(answer):
        answer = on_event({"event": "refused", "what": f"an answer is {_ANSWERS}"})
    return answer


class _Stand:
    """The process tumble-stand, for the time of a run."""

    def __init__(self, command: list[str]):
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
            text=True,
            errors="replace",
        )

    def __enter__(self) -> _Stand:
        try:
            self._process.wait(_EARLY_S)
        except subprocess.TimeoutExpired:
            return self
        complaint = self._process.communicate()[1].strip()
        if self._process.returncode == UsageError.exit_code:
            raise UsageError(f"this cannot be simulated: {complaint}")
        raise BenchFault(f"tumble-stand failed ({self._process.returncode}): {complaint or 'it says nothing'}")

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()

    def tell(self, answer: str | None) -> str | None:
        """Have it done there. Returns what is not for the stand, but for the program itself."""
        if answer is not None and answer != program.LEAVE:
            try:
                assert self._process.stdin is not None  # it is a pipe
                self._process.stdin.write(answer + "\n")
                self._process.stdin.flush()
            except BrokenPipeError:
                pass  # it has ended; the node misses its block
        return answer if answer == program.LEAVE else None

    def end(self) -> str:
        """Let it come to rest. Returns its document, or nothing when it has none."""
        self._process.send_signal(signal.SIGTERM)
        try:
            return self._process.communicate(timeout=_REST_S)[0]
        except subprocess.TimeoutExpired:
            return ""


_JOB = """
trap '' PIPE # of a stand that has ended
mkfifo /run/answers
{stand} </run/answers >stand.json 2>stand.err & stand=$!
({{ sh -c 'echo $$ >/run/node.pid; exec "$@"' node {node} --progress-fd 3 3>&1 >/dev/null 2>node.err
    echo $? >node.code; }} | while IFS= read -r line; do printf '%s\\n' "$line" >>progress; done) & node=$!
exec 4>/run/answers
number=1
while kill -0 $node 2>/dev/null; do
    [ ! -e stop ] || {{ kill -TERM $(cat /run/node.pid); break; }}
    if [ -e answer.$number ]; then
        read -r answer <answer.$number
        [ "$answer" = leave ] && kill -USR1 $(cat /run/node.pid) || echo "$answer" >&4
        number=$((number + 1))
    fi
    kill -0 $stand 2>/dev/null || sleep 1 # the node notices by itself
    sleep 0.1
done
wait $node
kill $stand; wait $stand
echo $? >stand.code
"""


def _in_uml(wanted: _Wanted, on_event: OnEvent) -> program.Ended:
    with uml.work_folder() as name:
        folder = Path(name)
        copy_inputs(wanted.scenario, folder)
        inside = _Wanted(folder / "scenario.txt", wanted.seed, folder, wanted.interactive)
        job = _JOB.format(
            stand=shlex.join(inside.stand(uml.INTERFACE)), node=shlex.join(inside.node(uml.INTERFACE, folder / "bench"))
        )
        progress = _Progress(folder, on_event)
        with interruption.Instead(progress.stop):
            uml.run(job, folder, on_tick=progress)
        complaint = _text(folder / "stand.err") or _text(folder / "node.err")
        code = int(_text(folder / "node.code") or BenchFault.exit_code)
        document = _text(folder / "stand.json")
        if (folder / "bench").exists():
            shutil.copytree(folder / "bench", wanted.stage / "bench")
    complaint = complaint.replace(str(inside.scenario), str(wanted.scenario))
    return _judged(program.Ended(code, complaint, progress.interrupted), wanted.stage / "bench", document)


def _text(path: Path) -> str:
    return path.read_text(errors="replace").strip() if path.exists() else ""


class _Progress:
    """Called all the while: hands on the lines of progress as they come; and, by `stop`, Ctrl-C."""

    def __init__(self, folder: Path, on_event: OnEvent):
        self.interrupted = False
        self._folder, self._on_event = folder, on_event
        self._read, self._stopping, self._answers = 0, 0.0, 0
        self._handing_on = False

    def __call__(self) -> None:
        self._hand_on()
        if self._stopping and time.monotonic() > self._stopping:
            raise BenchFault("interrupted, but tumble-node does not end: THE TABLE MAY STILL TURN")

    def stop(self) -> None:
        """Tell the node to stop the table and end."""
        self.interrupted = True
        self._stopping = time.monotonic() + 2 * _REST_S
        uml.stop(self._folder)
        if self._handing_on:
            raise KeyboardInterrupt  # nobody waits for an answer any more

    def _hand_on(self) -> None:
        path = self._folder / "progress"
        if not path.exists():
            return
        with open(path, "rb") as file:
            file.seek(self._read)
            data = file.read()
        whole = data[: data.rfind(b"\n") + 1]
        self._read += len(whole)
        for line in whole.splitlines():
            self._pass_on(self._hand_one_on(json.loads(line)))

    def _hand_one_on(self, event: program.Event) -> str | None:
        if self.interrupted:
            return None
        try:
            self._handing_on = True
            return _answer(event, self._on_event)
        except KeyboardInterrupt:
            return None
        finally:
            self._handing_on = False

    def _pass_on(self, answer: str | None) -> None:
        """Into user-mode Linux: a file for each answer."""
        if answer is not None:
            self._answers += 1
            part = self._folder / "answer.part"
            part.write_text(f"{answer}\n")
            part.rename(self._folder / f"answer.{self._answers}")


def _judged(ended: program.Ended, out: Path, stand: str) -> program.Ended:
    """Join the documents. Raises BenchFault where one of the two programs did not come to its end."""
    ours = outcome.read_document(out)
    theirs = json.loads(stand) if stand.strip().endswith("}") else None
    if ended.code in (UsageError.exit_code, Skipped.exit_code):
        return ended
    rest = "; THE TABLE MAY STILL TURN" if theirs is None else _at_rest(theirs)
    if ours is None:
        raise BenchFault(f"tumble-node ended without a result ({_how(ended)}){rest}")
    if theirs is None:
        raise BenchFault(f"tumble-stand ended without a document; tumble-node says: {ours['reason_sentence']}")
    (out / outcome.DOCUMENT).write_text(json.dumps(outcome.with_stand(ours, theirs)), encoding="utf-8")
    return ended


def _at_rest(stand: dict[str, Any]) -> str:
    return "; the table is at rest" if stand["table"]["at_rest"] else "; THE TABLE IS NOT AT REST"


def _how(ended: program.Ended) -> str:
    code = ended.code - 128 if ended.code > 128 else -ended.code
    if code > 0 and code in set(signal.Signals):
        return f"killed by {signal.Signals(code).name}"
    return ended.complaint or f"exit code {ended.code}"
