"""Programs of the project that the package starts: where they are."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from tumble.errors import BenchFault, Skipped, file_name, set_up


def built(path: str) -> Path:
    """A file of the build tree that the extension module is in, whether or not it exists."""
    import _tumble_core

    return Path(_tumble_core.__file__).resolve().parents[1] / path


def find(name: str) -> str:
    """Path of the program `name`: as the environment says (TUMBLE_NODE for tumble-node, and so on), in the build tree
    (host/node), or installed. Raises BenchFault; Skipped on a system that our programs are not made for."""
    variable = name.upper().replace("-", "_")
    if chosen := os.environ.get(variable):
        return chosen
    path = built(f"host/{name.removeprefix('tumble-')}/{name}")
    beside = next((str(one) for one in (path, Path(__file__).with_name(name)) if os.access(one, os.X_OK)), None)
    found = beside or shutil.which(name)
    if found is None and sys.platform != "linux":
        raise Skipped(f"{name} runs on Linux alone; what else tumble does, it does on this system as well")
    if found is None:
        remedy = f"{by} builds it" if (by := set_up("run")) else f"{variable} may say where it is"
        raise BenchFault(f"the program {name} is not built: no {file_name(path)}; {remedy}")
    return found


def last_words(text: str) -> str:
    """The last line of what a program has printed, fit for a complaint."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return ascii(lines[-1][:200])[1:-1] if lines else "it says nothing"
