"""Logs of a CAN bus for tests: frames of the block, lines of candump, a run of the bench, other formats."""

import types

import can
import cantools
import pytest
from conftest import ROOT
from documents import paper_stand

from tumble.files import can_log
from tumble.files.can_log import Frame
from tumble.files.run_layout import LayoutOptions
from tumble.importing import can_bus
from tumble.importing.can_bus import Bus

DBC = ROOT / "docs/bus/block.dbc"
SAMPLES = 120  # of a position: rests of 1.7 s, with 0.5 s in which it settles
CONVERTER = "converter_bits = 24\nrange_v = 10.0\n"
V_PER_COUNT = 10.0 * 2.0**-23


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """A run of the bench: its folder, and the stand file."""
    from loaded import run

    folder = tmp_path_factory.mktemp("bench")
    stand = paper_stand(folder, block=CONVERTER)
    done = run(["bench", "--seed", "6", "--samples", str(SAMPLES), "--stand", str(stand), "--out", str(folder / "run")],
               None, 300)
    assert done.returncode == 0, done.stderr
    return types.SimpleNamespace(log=folder / "run/bus.log", run=folder / "run/run.csv", stand=stand)


def encoded(counter, outputs, status=0, degrees=25.0, node=3, seconds=0.0, channel="can0"):
    """Both frames of a sample, by the DBC file and the page's checksum."""
    halves = {
        can_bus.XY: {"x": outputs[0], "y": outputs[1], "sample_counter": counter % 256, "crc_xy": 0},
        can_bus.Z: {"z": outputs[2], "frame_counter": (2 * counter + 1) % 256, "timestamp": 10 * counter % 4096,
                          "temperature": degrees, "crc_z": 0,
                          **{name: status >> bit & 1 for bit, name in enumerate(can_bus.STATUS)}},
    }
    bus = cantools.database.load_file(DBC)
    for (name, signals), identifier in zip(halves.items(), (0x680 + node, 0x690 + node)):
        payload = bus.get_message_by_name(name).encode(signals)[:7]
        yield Frame(seconds, identifier, False, channel, payload + bytes([crc8(identifier, payload)]), 1)


def crc8(identifier, payload):
    """Bit by bit, as docs/bus has it."""
    crc = 0xFF
    for byte in bytes([identifier & 0xFF]) + payload:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ (0x2F if crc & 0x80 else 0)) & 0xFF
    return crc ^ 0xFF


def encoded_quickly(counter, outputs, status, half_degrees):
    """As `encoded`, without cantools: another witness of the layout."""
    x, y, z = (value.to_bytes(3, "little", signed=True) for value in outputs)
    word = (10 * counter % 4096 | status << 12).to_bytes(2, "little")
    payloads = (
        x + y + bytes([counter % 256]),
        z + bytes([(2 * counter + 1) % 256]) + word + half_degrees.to_bytes(1, "little", signed=True),
    )
    for identifier, payload in zip((0x683, 0x693), payloads):
        yield Frame(0.0, identifier, False, "can0", payload + bytes([crc8(identifier, payload)]), 1)


def lines_of(log):
    return log.read_text().splitlines()


def read_text(lines, options=None, **bus):
    """A log of these lines."""
    data = ("\n".join(lines) + "\n").encode()
    return can_bus.read(data, "bus.log", can_log.kind_of(data), options or LayoutOptions(), Bus(**bus))


def candump(frames):
    return [f"({one.seconds:.6f}) {one.channel} {one.identifier:03X}#{one.data.hex().upper()}" for one in frames]


def stream(count=50, begin=0, **options):
    """Frames of so many samples at 100 Hz."""
    at = options.pop("at", 0.0)
    samples = (encoded(begin + n, (n, -n, 2 * n), seconds=at + n / 100, **options) for n in range(count))
    return [frame for frames in samples for frame in frames]


def rewritten(log, file):
    """The log in the format that the file's name says, by python-can's own writer."""
    with can.Logger(str(file)) as writer:
        for message in can.CanutilsLogReader(str(log)):
            if isinstance(message.channel, str):
                message.channel = int(message.channel.removeprefix("can"))
            writer.on_message_received(message)
    return file
