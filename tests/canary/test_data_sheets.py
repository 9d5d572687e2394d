"""Planted defects of an EDS file, which the gates of tests/integration/test_data_sheets.py must reject; what is not
spoilt they accept."""

import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests/lib"))

from data_sheets import EDS, canopen_faults, dcfchk, editor_faults

REAL = "DefaultValue=0x4024000000000000\n"
ANGLE = "; Limits=-3600.0 to 3600.0\n"
TABLE = {  # name: (gate, file, what is replaced, by what, what must be said)
    "a real number in decimal": (dcfchk, "block", REAL, "DefaultValue=10.0\n", "invalid DefaultValue in [2004sub2]"),
    "its limits in decimal": (dcfchk, "navcomp", ANGLE, "LowLimit=-3600.0\nHighLimit=3600.0\n",
                              "invalid LowLimit in [2002sub3]: -3600.0"),
    "its limits as bits": (canopen_faults, "navcomp", ANGLE, "HighLimit=0x40AC200000000000\n",
                           "2002sub3: bits of a real number taken for a whole one"),
    "a default beyond its limits": (dcfchk, "drive", "HighLimit=3\nDefaultValue=1\n",
                                    "HighLimit=3\nDefaultValue=9\n", "DefaultValue overflow in [6007]"),
    "an object that is not there": (dcfchk, "drive", "=0x6041\n", "=0x6042\n", "object 0x6042 not found"),
    "one subindex less": (dcfchk, "block", "SubNumber=3\n", "SubNumber=4\n", "missing sub-object"),
    "an unknown type": (canopen_faults, "block", "DataType=0x0011\n", "DataType=0x0099\n", "unsupported data type"),
    "no type": (editor_faults, "block", "DataType=0x0011\n", "", "[2004sub2]: no DataType"),
    "an unknown access": (editor_faults, "block", "AccessType=ro\n", "AccessType=reading\n", "unknown AccessType"),
    "another date": (editor_faults, "block", "01-01-2024", "2024-01-01", "does not match format"),
    "a key twice": (editor_faults, "block", REAL, 2 * REAL, "'DefaultValue' in section '2004sub2' already exists"),
    "a comment that is read": (editor_faults, "navcomp", ANGLE, "# Limits\n", "neither section, key nor comment"),
}  # fmt: skip


@pytest.mark.parametrize("name", TABLE)
def test_rejects(name, tmp_path):
    gate, file, old, new, message = TABLE[name]
    text = EDS[file].read_text(encoding="ascii")
    assert old in text
    (tmp_path / "sheet.eds").write_text(text.replace(old, new, 1))
    arguments = () if gate is editor_faults else (1,)
    assert gate(EDS[file], *arguments) in ("", [])
    assert message in str(gate(tmp_path / "sheet.eds", *arguments))
