"""Frames of a block in a CAN log: taken as the firmware takes them, damage told, of several blocks one asked for."""

import random
import re
import subprocess

import pytest
from c_compiler import compiled

pytest.importorskip("can", reason="python-can is not installed")
pytest.importorskip("cantools", reason="cantools is not installed")

from can_logs import bench, candump, encoded, encoded_quickly, lines_of, read_text, stream  # noqa: F401

from tumble.errors import BadInput
from tumble.files.can_log import Frame
from tumble.importing import can_bus

pytestmark = pytest.mark.python


# The receiver against the firmware's.

EVENTS = ("repeated", "reordered")
CORRUPTED = ("wrong_length", "wrong_crc", "wrong_pair")


def test_it_takes_and_counts_what_the_firmware_does(tmp_path):
    """The firmware's receiver on the same frames, which are lost, damaged, doubled, exchanged and cut at random."""
    program = compiled(tmp_path / "codec", "-Ihost", "tests/integration/block_frames_harness.c",
                       "firmware/sample/block_frames.c", "firmware/core/count.c",
                       "host/simulation/block_encode.c")
    for seed in range(8):
        frames = spoilt(seed)
        requests = "".join(f"receive {one.identifier:03X} {one.data.hex()}\n" for one in frames)
        answers = subprocess.run([program], input=requests, text=True, capture_output=True, check=True).stdout
        answers = [line.split() for line in answers.splitlines()]
        receiver = can_bus.Receiver(can_bus.messages())
        for one in frames:
            receiver.take(one)
        samples = [list(map(int, words[1:])) for words in answers if words[0] == "sample"]
        healthy = [values for values in samples if values[5] == 0]
        assert receiver.samples[:, 1:4].tolist() == [values[:3] for values in healthy]
        assert receiver.samples[:, 4].tolist() == [values[6] / 2 for values in healthy]
        events = [words[0] for words in answers]
        assert [receiver.counts[name] for name in EVENTS] == [events.count(name) for name in EVENTS]
        assert sum(receiver.counts[name] for name in CORRUPTED) == events.count("corrupted")
        assert receiver.counts["lost"] == samples[-1][3] - samples[0][3] - len(samples) + 1
        assert receiver.counts["unfit"] == len(samples) - len(healthy) and len(healthy) > 500
        assert min(receiver.counts[name] for name in ("lone_halves", "wrong_pair", "repeated", "reordered", "lost")) > 0


def spoilt(seed):
    """A stream of 1000 samples on its way through a bad line."""
    draw = random.Random(seed)
    frames = []
    for counter in range(1000):
        status = draw.randrange(16) if draw.random() < 0.02 else 0
        outputs = [draw.randint(-(2**23), 2**23 - 1) for _ in range(3)]
        frames += encoded_quickly(counter + 37 * seed, outputs, status, draw.randint(-80, 127))
    place = 0
    while place < len(frames) - 1:
        chance, one = draw.random(), frames[place]
        if chance < 0.01:
            del frames[place : place + draw.randint(1, 30)]
        elif chance < 0.02:
            frames.insert(place + draw.randint(0, 3), one)
        elif chance < 0.03:
            frames[place : place + 2] = frames[place + 1], one
        elif chance < 0.04:
            damaged = bytearray(one.data)
            damaged[draw.randrange(8)] ^= 1 << draw.randrange(8)
            frames[place] = one._replace(data=bytes(damaged))
        elif chance < 0.045:
            frames[place] = one._replace(data=one.data[: draw.randrange(1, 8)])
        place += 1
    return frames


def test_both_encoders_agree():
    for counter, outputs, status, degrees in ((0, (0, 0, 0), 0, 25.0), (300, (-(2**23), 2**23 - 1, -1), 9, -3.5)):
        assert [one[4] for one in encoded(counter, outputs, status, degrees)] == [
            one.data for one in encoded_quickly(counter, outputs, status, int(2 * degrees))
        ]


# What a line does to frames, and what a user is told of it.


def changed(line, place, flip=1):
    """The line with a bit of its payload changed."""
    head, data = line.split("#")
    payload = bytearray.fromhex(data)
    payload[place] ^= flip
    return f"{head}#{payload.hex().upper()}"


def test_damage_is_counted_and_told(bench):
    lines = lines_of(bench.log)
    halves = [at for at, line in enumerate(lines) if re.search(" 6[89]3#", line)]
    whole = len(halves) // 2
    first, second = halves[1000::2], halves[1001::2]  # of samples far apart, so that each stands alone
    lines[first[0]] = changed(lines[first[0]], 2)  # wrong CRC; its second half is then alone
    lines[second[20]] = changed(lines[second[20]], 0)
    lines[second[40]] = lines[second[40]][:-4]  # too short
    for at in (first[60], second[80]):
        lines[at] += "\n" + lines[at]  # again
    for at in range(100, 105):
        lines[first[at]] = lines[second[at]] = ""
    found = read_text("\n".join(lines).split("\n"))
    assert found.notes[1:4] == (
        f"block 0x683, 0x693 on can0: {whole - 8} samples",
        "left out: 2 frames with a wrong CRC, 1 frames that are not 8 bytes long, 3 halves without their counterpart, "
        "2 repeated frames",
        "8 samples are missing according to the block's counter",
    )
    assert len(found.outputs) == whole - 8


def test_samples_that_the_block_calls_unfit_are_left_out():
    frames = [frame for counter in range(300)
              for frame in encoded(counter, (1, 2, 3), status={7: 1, 9: 8, 11: 3}.get(counter, 0),
                                   seconds=counter / 100)]
    found = read_text(candump(frames))
    assert len(found.outputs) == 297
    assert found.notes[2] == (
        "left out: 3 samples that the block marks invalid (2 saturated, 1 self test failed, 1 temperature out of range)"
    )


def test_a_block_that_begins_anew_loses_nothing():
    """Its counter starts again at 0: after its boot-up message, or after a silence, that is no old sample."""
    before, after = stream(50, begin=30), stream(50, at=0.6)
    for between in ([Frame(0.55, 0x703, False, "can0", b"\0", 1)], []):
        again = [one._replace(seconds=one.seconds + (0.0 if between else 2.0)) for one in after]
        found = read_text(candump([*before, *between, *again]))
        assert len(found.outputs) == 100 and not any("left out" in note or "missing" in note for note in found.notes)
        silent = "the block was silent 1 times, for over 1 s" in found.notes
        assert silent == (not between)
    found = read_text(candump([*before, *after]))
    assert "left out: 50 frames out of order" in found.notes  # the canary: neither of both


def test_time_that_goes_back_is_refused(bench, refused, tmp_path):
    lines = lines_of(bench.log)
    (tmp_path / "bus.log").write_text("\n".join([*lines, lines[0], *lines[1:]]) + "\n")
    times = [float(line[1:18]) for line in lines if re.search(" 6[89]3#", line)]
    at = len(lines) + 1 + next(at for at, line in enumerate(lines) if " 683#" in line)
    assert refused("import", tmp_path / "bus.log") == (
        f"tumble: {tmp_path}/bus.log: row {at}: the time runs backwards, from {times[-1]:.6f} to {times[0]:.6f} s: "
        "two logs in one file? Pass each log as a file of its own\n"
    )


def test_a_torn_last_line_is_told_and_other_garbage_refused(bench, refused, tmp_path):
    lines = lines_of(bench.log)
    assert "its last line is incomplete and not read" in read_text([*lines, "(0000000099.9"]).notes
    (tmp_path / "bus.log").write_text("\n".join([*lines[:100], "garbage", *lines[100:]]) + "\n")
    assert refused("import", tmp_path / "bus.log") == (
        f"tumble: {tmp_path}/bus.log: row 101: cannot be read as a CAN log (candump): "
        "'not enough values to unpack (expected...'\n"
    )


# Several blocks, other blocks.


def test_of_several_blocks_one_is_asked_for(refused, tmp_path):
    both = sorted(stream() + stream(node=4, begin=7), key=lambda frame: frame.seconds)
    with pytest.raises(BadInput) as caught:
        read_text(candump(both))
    assert str(caught.value) == "bus.log: 2 blocks, 0x683 on can0 and 0x684 on can0: --can-id 0x683 selects one"
    for identifier in (0x683, 0x684):
        found = read_text(candump(both), identifier=identifier)
        assert found.notes[1] == f"block {identifier:#x}, {identifier + 16:#x} on can0: 50 samples"
        assert found.outputs[7].tolist() == [7, -7, 14]
    only = [frame for frame in both if frame.identifier in (0x684, 0x694)]
    assert read_text(candump(only)).notes[1] == "block 0x684, 0x694 on can0: 50 samples"
    (tmp_path / "bus.log").write_text("\n".join(candump(both)) + "\n")
    for option, said in (
        ("0x685", "no samples of the block 0x685, 0x695: 0 of its frames, 0 of them damaged, among 200; another block? "
         "--dbc FILE.dbc describes its frames"),
        ("0x690", "--can-id 0x690: first frames of blocks are 0x681 to 0x68f"),
        ("six", "--can-id: 'six' is not an identifier such as 0x683"),
    ):
        assert refused("import", tmp_path / "bus.log", "--can-id", option).endswith(f"{said}\n")


def test_of_several_channels_one_is_asked_for():
    both = sorted(stream() + stream(channel="can1"), key=lambda frame: frame.seconds)
    with pytest.raises(BadInput) as caught:
        read_text(candump(both))
    assert str(caught.value) == "bus.log: 2 blocks, 0x683 on can0 and 0x683 on can1: --can-channel can0 selects one"
    assert read_text(candump(both), channel="can1").notes[1] == "block 0x683, 0x693 on can1: 50 samples"
    with pytest.raises(BadInput) as caught:
        read_text(candump(both), channel="can2")
    assert str(caught.value) == "bus.log: --can-channel 'can2': no such channel; the log has can0, can1"
