"""Write the C source of `_tumble_world`, the extension module through which Python holds a simulated world.

    python build_world.py OUTPUT.c

What Python knows of it are the headers of host/world, whole. The module uses the limited API, as _tumble_core.
"""

import re
import sys
from pathlib import Path

import cffi

HEADERS = [Path(__file__).parents[2] / "world" / name for name in ("border.h", "fault_campaign.h", "replay.h")]


def declarations(header: str) -> str:
    """A header without its directives, but for the numbers that it defines."""
    kept = (line for line in header.splitlines() if not line.startswith("#") or re.match(r"#define \w+ \d+$", line))
    return "\n".join(kept)


def main(output: str) -> None:
    """Write the extension's C source to the file `output`."""
    ffi = cffi.FFI()
    for header in HEADERS:
        ffi.cdef(declarations(header.read_text(encoding="utf-8")))
    ffi.set_source("_tumble_world", "".join(f'#include "world/{header.name}"\n' for header in HEADERS))
    ffi.emit_c_code(output)


if __name__ == "__main__":
    main(sys.argv[1])
