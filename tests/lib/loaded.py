"""`tumble ...` in this process, which has it loaded: to begin a process takes longer than most commands.

It has its own standard streams, also for the processes that it starts, its own working directory and environment, and
as much warnings and logging as a process of its own. Not for a test of how Python starts, of signals, or of several
commands at once.
"""

import contextlib
import io
import logging
import os
import signal
import subprocess
import sys
import tempfile
import threading
import warnings

import pytest

from tumble.cli.main import main


def run(arguments, cwd, timeout):
    """As subprocess.run does it, with text. A command that hangs fails its test."""
    import hang_guards  # a plugin, which pytest loads after this module

    assert threading.current_thread() is threading.main_thread(), "one command at a time"
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        with _streams(out, err), _surroundings(cwd), _alarm(hang_guards.longer(timeout), arguments):
            code = _exit_code(arguments)
        return subprocess.CompletedProcess(["tumble", *arguments], code, _text(out), _text(err))


def _exit_code(arguments):
    try:
        return main(arguments)
    except SystemExit as end:
        return end.code or 0
    finally:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.flush()


@contextlib.contextmanager
def _streams(out, err):
    """Where the command reads and writes, and what it starts does."""
    kept = [os.dup(number) for number in range(3)]
    python = sys.stdin, sys.stdout, sys.stderr
    with open(os.devnull, "rb") as nothing:
        for number, stream in enumerate((nothing, out, err)):
            os.dup2(stream.fileno(), number)
    sys.stdin, sys.stdout, sys.stderr = (os.fdopen(number, mode, closefd=False) for number, mode in enumerate("rww"))
    try:
        yield
    finally:
        sys.stdin, sys.stdout, sys.stderr = python
        for number, was in enumerate(kept):
            os.dup2(was, number)
            os.close(was)


@contextlib.contextmanager
def _surroundings(cwd):
    """The working directory, and what the command may change or pytest has changed."""
    environment, handlers = dict(os.environ), logging.root.handlers
    with contextlib.chdir(cwd or "."), warnings.catch_warnings():
        warnings.filterwarnings("default", category=Warning)
        for category in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
            warnings.simplefilter("ignore", category)
        warnings.showwarning = lambda *what: print(warnings.formatwarning(*what[:4]), end="", file=sys.stderr)
        logging.root.handlers = []
        try:
            yield
        finally:
            logging.root.handlers = handlers
            if environment != dict(os.environ):
                os.environ.clear()
                os.environ.update(environment)


@contextlib.contextmanager
def _alarm(seconds, arguments):
    def fail(*_):
        pytest.fail(f"no end of tumble {' '.join(arguments)} after {seconds} s")

    before = signal.signal(signal.SIGALRM, fail)
    signal.setitimer(signal.ITIMER_REAL, seconds or 0)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _text(stream):
    stream.seek(0)
    return io.TextIOWrapper(stream, write_through=True).read()
