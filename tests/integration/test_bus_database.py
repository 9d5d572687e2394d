"""docs/bus/tumble.dbc: every frame of the bus has its message, every bit its signal, and they say what happened."""

import csv
import random

import pytest

pytest.importorskip("cantools", reason="cantools is not installed")

from bus_database import complaints, frames_of, load
from conftest import ROOT
from simulated_bench import DRIVE_FAULT, QUICK, bench

pytestmark = pytest.mark.python
DATABASE = load()
MENDED = {"operator.mend_s": 0.5, "operator.mends": 3}
RUNS = {
    "done": {},
    "a drive fault": {**MENDED, "fault": DRIVE_FAULT},
    "the drive without power": {**MENDED, "fault": "drive_power_cycle at=2.2 phase=average delay=0.1 duration=1"},
    "the block without power": {**MENDED, "fault": "block_power_cycle at=1.7 phase=average delay=0.05 duration=1"},
}


@pytest.fixture(scope="module", params=RUNS)
def folder(request, tmp_path_factory):
    made = tmp_path_factory.mktemp("made") / "run"
    assert bench(QUICK | RUNS[request.param], seed=5, out=made)["exit"] == 0
    return made


def test_every_frame_of_a_run_is_known_to_the_last_bit(folder):
    frames = frames_of(folder / "bus.log")
    assert complaints(DATABASE, frames) == []
    identifiers = {identifier for identifier, _ in frames}
    assert identifiers >= {0x000, 0x181, 0x182, 0x202, 0x582, 0x602, 0x683, 0x693, 0x6C1, 0x701, 0x702, 0x703}


def test_what_it_says_is_what_was(folder):
    """The samples of run.csv are among its samples; states and targets are those of a run that was done."""
    frames = frames_of(folder / "bus.log")
    samples = {tuple(DATABASE.decode_message(i, d)[name] for name in ("x", "y")) for i, d in frames if i == 0x683}
    with open(folder / "run.csv", encoding="utf-8") as stream:
        rows = [(int(row["cx"]), int(row["cy"])) for row in csv.DictReader(stream)]
    assert len(rows) == 180 and set(rows) <= samples
    states = [str(DATABASE.decode_message(i, d)["state"]) for i, d in frames if i == 0x181]
    assert set(states) >= {"home", "move", "settle", "average"}
    targets = [d for i, d in frames if i == 0x202]
    told = [DATABASE.decode_message(0x202, d)["target_position"] for d in targets]
    assert told == [int.from_bytes(d[2:], "little", signed=True) for d in targets] and len(set(told)) >= 9


def test_faults_have_their_names(tmp_path):
    assert bench(QUICK | RUNS["a drive fault"], seed=5, out=tmp_path / "run")["exit"] == 0
    frames = frames_of(tmp_path / "run/bus.log")
    codes = [DATABASE.decode_message(i, d, decode_choices=False)["error_code"] for i, d in frames if i == 0x082]
    assert codes == [30001, 0]
    assert "drive_fault" in {str(DATABASE.decode_message(i, d)["reason"]) for i, d in frames if i == 0x181}
    assert 1 in {DATABASE.decode_message(i, d)["fault"] for i, d in frames if i == 0x182}


@pytest.mark.parametrize("message", DATABASE.messages, ids=lambda one: one.name)
def test_every_bit_of_every_message_is_a_signal(message):
    """Whatever stands in a frame comes back from its signals."""
    draw = random.Random(message.frame_id)
    frames = [(message.frame_id, bytes([first]) + draw.randbytes(message.length - 1)) for first in range(256)]
    assert complaints(DATABASE, frames) == []


def test_it_has_the_messages_that_the_page_of_the_bus_lists():
    expected = {0x000, 0x081, 0x082, 0x083, 0x181, 0x182, 0x202, 0x381, 0x401, 0x581, 0x582, 0x583, 0x601, 0x602, 0x603,
                0x681, 0x683, 0x693, 0x6C1, 0x701, 0x702, 0x703}
    assert {message.frame_id for message in DATABASE.messages} == expected
    assert len({message.name for message in DATABASE.messages}) == len(expected)


def test_the_blocks_messages_are_those_of_its_own_file():
    """Signal by signal, with comments and cycle time; from a firmware's point of view test_block_frames.py."""
    own = load(ROOT / "docs/bus/block.dbc")
    for message in own.messages:
        other = DATABASE.get_message_by_frame_id(message.frame_id)
        assert (message.name, message.length, message.cycle_time, message.comment) == (
            other.name, other.length, other.cycle_time, other.comment)
        assert [repr(one) for one in message.signals] == [repr(one) for one in other.signals]


def test_segments_of_a_transfer_are_told_from_values():
    """CiA 301: an upload of 'Tumble' and its abort, byte by byte."""
    def told(identifier, text):
        return DATABASE.decode_message(identifier, bytes.fromhex(text))

    begun = told(0x601, "4008100000000000")
    assert (str(begun["request"]), begun["object_index"], begun["subindex"]) == ("initiate_upload", 0x1008, 0)
    answer = told(0x581, "410810001A000000")
    assert str(answer["response"]) == "initiate_upload"
    assert (answer["expedited"], answer["size_given"], answer["data"]) == (0, 1, 26)
    segment = told(0x581, "0354756D626C6500")
    assert segment["segment"].to_bytes(7, "little") == b"Tumble\0"
    assert (segment["last"], segment["segment_unused"]) == (1, 1)
    aborted = told(0x401, "8000200100000206")
    assert (str(aborted["request"]), aborted["abort_code"], aborted["object_index"]) == ("abort", 0x06020000, 0x2000)
