"""What the tests of user-mode Linux share: whether it is there, and which of its kernels run."""

import os
from pathlib import Path

import pytest

from tumble.world import uml

LACKING = uml.missing()
inside = pytest.mark.skipif(LACKING is not None, reason=f"user-mode Linux is not there: {LACKING}")


def kernels(folder):
    """User-mode Linux kernels that run in a folder of ours, by their process number."""
    found = set()
    for process in Path("/proc").glob("[0-9]*"):
        try:
            command = (process / "cmdline").read_bytes()
        except OSError:
            continue
        if command.startswith((b"linux.uml", b"/usr/bin/linux.uml")) and os.fsencode(folder) in command:
            found.add(process.name)
    return found
