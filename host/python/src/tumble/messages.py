"""What is said on standard error. Where nobody can read it, it is dropped; results and exit codes stay the same.

The signs of quantities. The product writes ASCII, as programs read it, such as "+- 12 ug" and "90 deg"; people get
±, µ and ° where their terminal, or a report, has them.
"""

from __future__ import annotations

import codecs
import io
import re
import sys
from collections.abc import Iterable
from contextlib import suppress
from typing import TextIO

from tumble.errors import file_name

_PLUS_MINUS = re.compile(r"(?<![^\s(])\+-(?= ?\d)")
_MICRO = re.compile(r"(?<=\d )u(?=(?:g|V|rad)\b)|^u(?=(?:g|V|rad)(?:/g(?:\^\d)?)?$)")
_CELSIUS = re.compile(r"(?<=\d) deg C\b")
_DEGREES = re.compile(r"(?<=\d) deg(?=$|[\s,;:)]|\.(?:\s|$))")
_GAP = re.compile(r"( {2,})")  # between columns


def signed(text: str) -> str:
    """With the signs in place of ASCII, behind numbers or where a unit is all there is. Columns stay in place."""
    parts = _GAP.split(text)
    for place in range(0, len(parts), 2):
        plain = parts[place]
        parts[place] = _MICRO.sub("µ", _PLUS_MINUS.sub("±", plain))
        parts[place] = _DEGREES.sub("°", _CELSIUS.sub(" °C", parts[place]))
        if place + 1 < len(parts):
            parts[place + 1] += " " * (len(plain) - len(parts[place]))
    return "".join(parts)


def signed_for(text: str, stream: TextIO | None) -> str:
    """The same for a terminal of UTF-8; all else, such as a pipe or a file, gets the text as it is."""
    with suppress(LookupError):
        if stream is not None and stream.isatty() and codecs.lookup(stream.encoding or "ascii").name == "utf-8":
            return signed(text)
    return text


def tell(line: str) -> None:
    """One line."""
    stream = sys.stderr or io.StringIO()
    try:
        stream.write(f"{signed_for(line, sys.stderr)}\n")  # at once: an interrupt comes before it, or behind it
        stream.flush()
    except (OSError, ValueError):  # full, gone, or closed
        sys.stderr = None


def warn(sentences: Iterable[str], about: str = "") -> None:
    """A line for each. `about`: the file that they are on, if any."""
    for sentence in sentences:
        tell(f"tumble: warning: {about and file_name(about) + ': '}{sentence}")


def on_terminal() -> bool:
    """Is there a person who watches?"""
    return sys.stderr is not None and sys.stderr.isatty()
