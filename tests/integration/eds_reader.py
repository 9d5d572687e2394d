"""An EDS file read without python-canopen's help (CiA 306): every (index, subindex) with type, access and limits."""

import configparser
import re
import struct
from dataclasses import dataclass
from pathlib import Path

INTEGERS = {0x01: "<B", 0x02: "<b", 0x03: "<h", 0x04: "<i", 0x05: "<B", 0x06: "<H", 0x07: "<I", 0x15: "<q", 0x1B: "<Q"}
REALS = {0x08: "<f", 0x11: "<d"}
BOOLEAN, TEXT = 0x01, 0x09


@dataclass(frozen=True)
class Entry:
    """One value of the dictionary."""

    index: int
    subindex: int
    name: str
    type: int
    access: str
    low: float | int | None
    high: float | int | None

    @property
    def readable(self):
        return self.access != "wo"

    @property
    def writable(self):
        return self.access in ("rw", "rww", "rwr", "wo")

    @property
    def size(self):
        """Bytes of a number; None of a text."""
        form = (INTEGERS | REALS).get(self.type)
        return struct.calcsize(form) if form else None

    @property
    def is_real(self):
        return self.type in REALS

    @property
    def range(self):
        """What an integer of its type can hold."""
        bits = 8 * self.size
        signed = INTEGERS[self.type][1].islower()
        return (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)

    def encode(self, number):
        """Little-endian bytes of a number."""
        return struct.pack((INTEGERS | REALS)[self.type], number)

    def __str__(self):
        return f"{self.index:04X}h:{self.subindex} {self.name}"


def number(text):
    return None if text is None or text == "" or "$" in text else int(text, 0)


def limits(keys, is_real):
    """Lowest and highest value; of real numbers they stand in a comment, which `read` has made a key."""
    if is_real:
        return map(float, keys["Limits"].split(" to ")) if "Limits" in keys else (None, None)
    return (number(keys.get(key)) for key in ("LowLimit", "HighLimit"))


def read(path):
    """All entries from 1000h on, in order."""
    parser = configparser.RawConfigParser(strict=True)
    parser.optionxform = str
    parser.read_string(Path(path).read_text(encoding="ascii").replace("; Limits=", "Limits="))
    entries = []
    for section in parser.sections():
        place = re.fullmatch(r"([0-9A-F]{4})(?:sub([0-9A-F]{1,2}))?", section)
        keys = dict(parser[section]) if place else {}
        if not place or "DataType" not in keys:
            continue
        kind = int(keys["DataType"], 16)
        entries.append(Entry(int(place[1], 16), int(place[2] or "0", 16), keys["ParameterName"], kind,
                             keys["AccessType"], *limits(keys, kind in REALS)))
    return sorted((entry for entry in entries if entry.index >= 0x1000), key=lambda one: (one.index, one.subindex))
