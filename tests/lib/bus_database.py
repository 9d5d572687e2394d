"""A DBC file held against frames: what it does not know, and what does not come back to the same bytes."""

import re
from pathlib import Path

import pytest

cantools = pytest.importorskip("cantools", reason="cantools is not installed")

DBC = Path(__file__).resolve().parents[2] / "docs/bus/tumble.dbc"
LINE = re.compile(r"\(\d+\.\d+\) \S+ ([0-9A-F]{3})#([0-9A-F]*)")


def frames_of(log):
    """[(identifier, data)] of a bus.log, every frame of it."""
    return [(int(identifier, 16), bytes.fromhex(data)) for identifier, data in
            (LINE.fullmatch(line).groups() for line in Path(log).read_text().splitlines())]


def load(path=DBC):
    return cantools.database.load_file(path)


def complaints(database, frames):
    """A line for each frame that the file cannot tell: an unknown identifier, another length, bytes that are not those
    of its signals. Frames that are alike are looked at once."""
    known = {message.frame_id: message for message in database.messages}
    found = []
    for identifier, data in sorted(set(frames)):
        message, where = known.get(identifier), f"{identifier:03X}#{data.hex()}"
        if message is None:
            found.append(f"{where}: no such message")
        elif message.length != len(data):
            found.append(f"{where}: {message.name} has {message.length} bytes")
        else:
            again = message.encode(message.decode(data), strict=False)
            found += [] if again == data else [f"{where}: {message.name} comes back as {again.hex()}"]
    return found
