"""The program tumble-bench: where it is, and a run of it, watched and answered line by line."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tumble.errors import BenchFault, file_name

VARIABLE = "TUMBLE_BENCH"  # of the environment: the program to use
_NAME = "tumble-bench"
_PATIENCE_S = 15.0

Event = dict[str, Any]


@dataclass(frozen=True)
class Ended:
    """How the program ended: its exit code, what it had to say, and whether it was asked to stop."""

    code: int
    complaint: str
    interrupted: bool


def find() -> str:
    """Path of the program: as the environment says, in the build tree beside the extension module, or installed.
    Raises BenchFault."""
    if chosen := os.environ.get(VARIABLE):
        return chosen
    import _tumble_core

    built = Path(_tumble_core.__file__).resolve().parents[1] / "host/bench" / _NAME
    found = str(built) if os.access(built, os.X_OK) else shutil.which(_NAME)
    if found is None:
        raise BenchFault(f"the program {_NAME} is not built: no {file_name(built)}; {VARIABLE} may say where it is")
    return found


def run(arguments: list[str], on_event: Callable[[Event], str | None], interactive: bool) -> Ended:
    """Run the program to its end. `on_event` gets every progress line and returns an answer to it, or None.

    Ctrl-C goes to this process alone (the program has a session of its own), which tells the program to stop: it stops
    the table, and then ends.
    """
    ours, theirs = os.pipe()
    options = [*(["--interactive"] if interactive else []), "--progress-fd", str(theirs)]
    try:
        child = subprocess.Popen(
            [find(), *arguments, *options],
            stdin=subprocess.PIPE if interactive else subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            pass_fds=(theirs,),
            start_new_session=True,
            text=True,
            errors="replace",
        )
    except OSError as error:
        os.close(ours)
        raise BenchFault(f"{_NAME} cannot be started: {(error.strerror or 'unknown').lower()}") from None
    finally:
        os.close(theirs)
    with child, open(ours, encoding="utf-8", errors="replace") as lines:
        try:
            interrupted = _watch(child, lines, on_event)
        except BaseException:
            child.kill()
            raise
        complaint = child.stderr.read().strip()
        code = child.wait()
    return Ended(code, complaint, interrupted)


def _watch(child: subprocess.Popen, lines, on_event: Callable[[Event], str | None]) -> bool:
    """Until the program has nothing more to tell. True: the user interrupted it."""
    try:
        for line in lines:
            answer = on_event(json.loads(line))
            if answer is not None:
                _tell(child, answer)
        return False
    except KeyboardInterrupt:
        child.send_signal(signal.SIGINT)
        _close(child.stdin)
        try:
            child.wait(_PATIENCE_S)  # what it still has to tell fits into the pipe
        except subprocess.TimeoutExpired:
            child.kill()
        return True


def _tell(child: subprocess.Popen, answer: str) -> None:
    try:
        child.stdin.write(answer + "\n")
        child.stdin.flush()
    except BrokenPipeError:
        pass  # it has ended, and will say why


def _close(stream) -> None:
    if stream is not None:
        try:
            stream.close()
        except BrokenPipeError:
            pass
