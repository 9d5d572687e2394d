"""Pytest plugin: how long a test waits for a process guards against hanging and judges nothing. Tests give the limit
for a machine at rest; here it becomes one that a busy machine keeps, too. What is below GUARD_S is no such limit.
"""

import functools
import subprocess

GUARD_S = 15.0
LONGER = 10.0


def longer(limit_s):
    """The limit that is meant; None: there is none."""
    return limit_s if limit_s is None or limit_s < GUARD_S else LONGER * limit_s


def pytest_configure():
    """For all of subprocess: `run` and its like wait by these two."""
    waits, communicates = subprocess.Popen.wait, subprocess.Popen.communicate

    @functools.wraps(waits)
    def wait(self, timeout=None):
        return waits(self, timeout=longer(timeout))

    @functools.wraps(communicates)
    def communicate(self, input=None, timeout=None):
        return communicates(self, input=input, timeout=longer(timeout))

    subprocess.Popen.wait, subprocess.Popen.communicate = wait, communicate
