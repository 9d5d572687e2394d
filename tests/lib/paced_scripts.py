"""The script of docs/client.md, at any pace."""

import re
import time
from pathlib import Path

_PAGE = Path(__file__).resolve().parents[2] / "docs/client.md"
PAGE = _PAGE.read_text(encoding="utf-8").partition("\n## Test your own scripts\n")[2].partition("\n## ")[0]
SCRIPT, TEST, MARKER, ALONE = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


class Paced:
    """A node between whose calls time passes: that of the bus, where time is virtual."""

    def __init__(self, node, pause_s):
        self._node, self._pause_s = node, pause_s

    def __getattr__(self, name):
        time.sleep(self._pause_s)
        return getattr(self._node, name)


def calibrate(node, pause_s=0.0):
    """The script's function of this name; the result."""
    found = {}
    exec(compile(SCRIPT, "page", "exec"), found)
    return found["calibrate"](Paced(node, pause_s))
