"""Planted defects of the bus's DBC file, which must not decode every frame; the file itself does."""

import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests/lib"))

from bus_database import DBC, complaints, load

FRAMES = [(0x182, bytes.fromhex("3716000002A0")), (0x602, bytes.fromhex("407A600000000000")), (0x703, b"\x05")]
TEMPERED = {  # name: (what is replaced, by what, what must be said)
    "a message less": (" 1795 ", " 1796 ", "703#05: no such message"),
    "another length": ("386 DRIVE_TPDO1: 6", "386 DRIVE_TPDO1: 8", "DRIVE_TPDO1 has 8 bytes"),
    "a signal that is too narrow": ("position_actual_value : 16|32@1-", "position_actual_value : 16|24@1-",
                                    "182#3716000002a0: DRIVE_TPDO1 comes back as 371600000200"),
    "a bit that is no signal": ("position_actual_value : 16|32@1-", "position_actual_value : 17|31@1-", None),
    "a selected value without signals": ("object_index request 1-1, 2-2,", "object_index request 1-1,",
                                          "602#407a600000000000: DRIVE_SDO_REQUEST comes back as 4000000000000000"),
}  # fmt: skip


def test_accepts_the_file_itself():
    assert complaints(load(), FRAMES) == []


@pytest.mark.parametrize("name", TEMPERED)
def test_rejects(name, tmp_path):
    old, new, message = TEMPERED[name]
    text = DBC.read_text(encoding="ascii")
    assert old in text
    (tmp_path / "bus.dbc").write_text(text.replace(old, new), encoding="ascii")
    frames = [*FRAMES, (0x182, bytes.fromhex("371601000000"))]
    found = complaints(load(tmp_path / "bus.dbc"), frames)
    assert found and (message is None or any(message in line for line in found))
