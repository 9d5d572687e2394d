"""Pytest plugin: interrupts are heeded however the tests were started.

Whoever is started in the background by a shell without job control ignores Ctrl-C, and so does all that it starts: a
test that interrupts a command would wait for nothing. So the disposition is set back, before workers are started, and
the run says so. A hang-up stays ignored, or the tests of `nohup` would end with the terminal.
"""

import signal

import pytest

_ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN


@pytest.hookimpl(tryfirst=True)
def pytest_configure():
    """Before xdist starts its workers, which inherit it."""
    if _ignored:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_terminal_summary(terminalreporter):
    if _ignored:
        terminalreporter.write_line("heeding_interrupts: started with interrupts ignored (in the background?); heeded")
