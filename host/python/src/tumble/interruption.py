"""Ctrl-C, SIGTERM and SIGHUP: the first of them ends the command in good order; more of them do not disturb that.

Windows has no SIGHUP, and ends a process that os.kill sends a signal.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
_watched: list[int] = []
_received: list[int] = []  # the first one
_postponed = False
_instead: Callable[[], None] | None = None


def end_at_once() -> None:
    """While there is nothing to clean up, an interrupt simply ends the process."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def watch() -> None:
    """From now on the first of the signals raises KeyboardInterrupt, but for those that whoever started this process
    wants ignored."""
    for number in _SIGNALS:
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, _stop)
            _watched.append(number)
    sys.unraisablehook = _raise_again


def ignore() -> None:
    """What has been watched for comes too late from here on: all is done."""
    for number in _watched:
        signal.signal(number, signal.SIG_IGN)


def heed_again() -> None:
    """What `ignore` has silenced is watched for again: there is more to do after all."""
    for number in _watched:
        signal.signal(number, _stop)


def exit_code() -> int:
    """128 and the number of the signal that came; of Ctrl-C where none is known."""
    return 128 + (_received[0] if _received else signal.SIGINT)


def has_come() -> bool:
    """Whether one of the signals has."""
    return bool(_received)


@contextmanager
def postponed() -> Iterator[None]:
    """What is done meanwhile is finished first; the KeyboardInterrupt comes at its end."""
    global _postponed
    _postponed, before = True, len(_received)
    try:
        yield
    finally:
        _postponed = False
        if len(_received) > before:
            raise KeyboardInterrupt


@contextmanager
def instead(call: Callable[[], None]) -> Iterator[None]:
    """The first signal calls this, whatever is being done at that moment, and does not raise."""
    global _instead
    _instead = call
    try:
        yield
    finally:
        _instead = None


def _raise_again(unraisable: sys.UnraisableHookArgs) -> None:
    """Where Python cannot raise it, such as at certain moments of an import, it comes once more a moment later."""
    if unraisable.exc_type is not KeyboardInterrupt or not _received:
        sys.__unraisablehook__(unraisable)
        return
    import threading

    def again() -> None:
        number = _received.pop()
        if sys.platform == "win32":
            signal.raise_signal(number)
        else:
            os.kill(os.getpid(), number)

    threading.Timer(0.01, again).start()


def _stop(number: int, _frame: FrameType | None) -> None:
    if _received:
        return
    _received.append(number)
    if _instead is not None:
        _instead()
    elif not _postponed:
        raise KeyboardInterrupt
