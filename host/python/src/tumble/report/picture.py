"""Can a logo be drawn in reasonable time and memory? A small file may hold very large pictures."""

from __future__ import annotations

import re
import struct
from typing import Any
from xml.etree import ElementTree

_MOST_PIXELS = 16_000_000
_MOST_ELEMENTS = 20_000
_REFERENCE = re.compile(r"#([\w.-]+)")


def picture_fault(data: bytes, kind: str) -> str | None:
    """What stands against a picture of this MIME type, as a message says it; None: nothing."""
    if kind == "image/svg+xml":
        return _fault_of_svg(data)
    if kind == "image/png":
        return _fault_of_png(data)
    return None if b"\xff\xd9" in data else "a JPEG picture that is not whole"


def _fault_of_png(data: bytes) -> str | None:
    if len(data) < 24 or b"IEND" not in data:
        return "a PNG picture that is not whole"
    width, height = struct.unpack(">II", data[16:24])
    if width * height > _MOST_PIXELS:
        return f"{width} x {height} pixels; a logo may have {_MOST_PIXELS // 1_000_000} million"
    return None


def _fault_of_svg(data: bytes) -> str | None:
    try:
        drawn = _Drawn(ElementTree.fromstring(data))
    except (ElementTree.ParseError, ValueError, LookupError, RecursionError) as error:
        return f"an SVG picture that cannot be read: {error}"
    return None if drawn.count <= _MOST_ELEMENTS else f"draws more than {_MOST_ELEMENTS} elements"


class _Drawn:
    """How many elements an SVG draws: those that `use`, a pattern or a mask repeats `count` each time."""

    def __init__(self, root: Any):
        self._named = {element.get("id"): element for element in root.iter() if element.get("id")}
        self._known: dict[Any, int] = {}
        self.count = self._of(root)

    def _of(self, element: Any) -> int:
        if element not in self._known:
            self._known[element] = 0  # whatever refers to itself is drawn once
            names = _REFERENCE.findall(" ".join(element.attrib.values()))
            parts = [*element, *(self._named[name] for name in names if name in self._named)]
            self._known[element] = min(1 + sum(map(self._of, parts)), _MOST_ELEMENTS + 1)
        return self._known[element]
