"""The program tumble-node: a run of it, watched line by line."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from tumble.errors import BenchFault

_PATIENCE_S = 15.0

LEAVE = "leave"  # an answer: let the run end where it is

Event = dict[str, Any]


@dataclass(frozen=True)
class Ended:
    """How the program ended: its exit code, what it had to say, and whether it was asked to stop."""

    code: int
    complaint: str
    interrupted: bool


def run(command: list[str], on_event: Callable[[Event], str | None]) -> Ended:
    """Run the program to its end. `on_event` gets every progress line; the answer LEAVE ends the run where it is.

    Ctrl-C goes to this process alone (the program has a session of its own), which tells the program to stop: it stops
    the table, and then ends. It does the same by itself when nobody reads its progress any more.
    """
    ours, theirs = os.pipe()
    try:
        child = subprocess.Popen(
            [*command, "--progress-fd", str(theirs)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            pass_fds=(theirs,),
            start_new_session=True,
            text=True,
            errors="replace",
        )
    except OSError as error:
        os.close(ours)
        name = os.path.basename(command[0])
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


def _watch(child: subprocess.Popen[str], lines: Iterable[str], on_event: Callable[[Event], str | None]) -> bool:
    """Until the program has nothing more to tell. True: the user interrupted it."""
    try:
        for line in lines:
            if on_event(json.loads(line)) == LEAVE:
                child.send_signal(signal.SIGUSR1)
        return False
    except KeyboardInterrupt:
        child.send_signal(signal.SIGTERM)
        try:
            child.wait(_PATIENCE_S)  # what it still has to tell fits into the pipe
        except subprocess.TimeoutExpired:
            child.kill()
        return True
