"""From what the user calls a source to the source."""

from __future__ import annotations

import logging
from pathlib import Path

from tumble.errors import UsageError, quoted
from tumble.watch.node_run import NodeRun
from tumble.watch.runs import FolderRun
from tumble.watch.snapshot import Source

KINDS = "bench, can:INTERFACE, modbus:HOST:PORT, modbus-rtu:DEVICE or the folder of a run"
_LINKS = ("can:", "modbus:", "modbus-rtu:")


def opened(name: str) -> Source:
    """Raises UsageError; NotInstalled, Skipped where this machine lacks something."""
    if name.startswith(_LINKS):
        for library in ("can", "canopen", "pymodbus"):  # what they have to say comes as an exception as well
            logging.getLogger(library).addHandler(logging.NullHandler())
        return NodeRun(name)
    folder = FolderRun(Path(name))
    if folder.is_there():
        return folder
    raise UsageError(f"{quoted(name)} is neither {KINDS}")
