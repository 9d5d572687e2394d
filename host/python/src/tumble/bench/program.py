"""The program tumble-bench: where it is, and a run of it, watched and answered line by line."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import IO, Any

from tumble.bench import programs
from tumble.errors import BenchFault

_NAME = "tumble-bench"
_PATIENCE_S = 15.0

LEAVE = "leave"  # an answer: let the run end where it is

Event = dict[str, Any]


@dataclass(frozen=True)
class Ended:
    """How the program ended: its exit code, what it had to say, and whether it was asked to stop."""

    code: int
    complaint: str
    interrupted: bool


def find() -> str:
    """Path of the program. Raises BenchFault."""
    return programs.find(_NAME, "host/bench")


def run(
    arguments: list[str], on_event: Callable[[Event], str | None], interactive: bool, path: str | None = None
) -> Ended:
    """Run the program to its end. `on_event` gets every progress line and returns an answer to it, or None. `path`: of
    another program with the same progress lines, tumble-node, which takes no answer but LEAVE.

    Ctrl-C goes to this process alone (the program has a session of its own), which tells the program to stop: it stops
    the table, and then ends. It does the same by itself when nobody reads its progress any more.
    """
    ours, theirs = os.pipe()
    options = [*(["--interactive"] if interactive else []), "--progress-fd", str(theirs)]
    try:
        child = _start([path or find(), *arguments, *options], theirs, interactive)
    except OSError as error:
        os.close(ours)
        name = os.path.basename(path or _NAME)
        raise BenchFault(f"{name} cannot be started: {(error.strerror or 'unknown').lower()}") from None
    finally:
        os.close(theirs)
    with child, open(ours, encoding="utf-8", errors="replace") as lines:
        try:
            interrupted = _watch(child, lines, on_event)
        except BaseException:
            child.kill()
            raise
        complaint = "" if child.stderr is None else child.stderr.read().strip()
        code = child.wait()
    return Ended(code, complaint, interrupted)


def _start(command: list[str], progress: int, interactive: bool) -> subprocess.Popen[str]:
    return subprocess.Popen(
        command,
        stdin=subprocess.PIPE if interactive else subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        pass_fds=(progress,),
        start_new_session=True,
        text=True,
        errors="replace",
    )


def _watch(child: subprocess.Popen[str], lines: Iterable[str], on_event: Callable[[Event], str | None]) -> bool:
    """Until the program has nothing more to tell. True: the user interrupted it."""
    try:
        for line in lines:
            answer = on_event(json.loads(line))
            if answer is not None:
                _tell(child, answer)
        return False
    except KeyboardInterrupt:
        child.send_signal(signal.SIGTERM)
        _close(child.stdin)
        try:
            child.wait(_PATIENCE_S)  # what it still has to tell fits into the pipe
        except subprocess.TimeoutExpired:
            child.kill()
        return True


def _tell(child: subprocess.Popen[str], answer: str) -> None:
    if child.stdin is None:
        child.send_signal(signal.SIGUSR1)
        return
    try:
        child.stdin.write(answer + "\n")
        child.stdin.flush()
    except BrokenPipeError:
        pass  # it has ended, and will say why


def _close(stream: IO[str] | None) -> None:
    if stream is not None:
        with contextlib.suppress(BrokenPipeError):
            stream.close()
