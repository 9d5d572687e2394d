"""Every object of every node is written wrongly in all ways that the EDS file lets one think of: right abort codes, and
nothing changes. The EDS file is read independently of python-canopen."""

import math
import re
import struct

import pytest
from canopen_bridge import EDS, NUMBERS, ROOT, canopen, program, refusal_of, start  # noqa: F401
from eds_reader import BOOLEAN, INTEGERS, TEXT, read

pytestmark = pytest.mark.real_time

READ_ONLY, WRITE_ONLY = 0x06010002, 0x06010001
TOO_LONG, TOO_SHORT = 0x06070012, 0x06070013
VALUE, TOO_HIGH, TOO_LOW = 0x06090030, 0x06090031, 0x06090032
NO_SUBINDEX, NO_DATA, DEVICE_STATE, STORE = 0x06090011, 0x08000024, 0x08000022, 0x08000020

KEY = 0x76726573  # "serv"

# Objects of the keeper whose rules go beyond limits (docs/canopen.md): a good value, bad ones, and their code.
RULES = {
    (0x1010, 1): ([], [0, 1, 0x73617665, 0x65766172, 0xFFFFFFFF], STORE),
    (0x1011, 1): ([], [0, 1, 0x65766173, 0x64616F6D, 0xFFFFFFFF], STORE),
    (0x2006, 1): ([], [1, KEY ^ 1, 0x73657276, 0xFFFFFFFF], VALUE),
    (0x2121, 1): ([1, 1 << 40, 0], [(1 << 40) + 1, (1 << 64) - 1], VALUE),
    (0x2152, 1): ([2, 65535, 0], [1], VALUE),
    (0x2122, 1): ([9.7, 9.9, 0.0], [9.69, 9.91, -9.8, 1e300], VALUE),
}


def upload(ours, entry):
    """Its bytes, or the abort code."""
    try:
        return ours.node.sdo.upload(entry.index, entry.subindex)
    except canopen.SdoAbortedError as refusal:
        return refusal.code


def download(ours, entry, data):
    ours.node.sdo.download(entry.index, entry.subindex, data)


def check_refused(ours, entry, data, code):
    """Refused with this code, and what can be read is what it was."""
    before = upload(ours, entry)
    assert refusal_of(download, ours, entry, data) == code, f"{entry} {data.hex()}"
    assert upload(ours, entry) == before, entry


def quiet(ours, name):
    """No run is to begin by itself in between, and the level is to keep nothing out: the clock stands still."""
    if name == "navcomp":
        ours.node.sdo["Host"]["Inhibit"].raw = 65535
    if NUMBERS[name] == 1:
        ours.node.sdo["Service level"]["Key"].raw = KEY
    return read(EDS[name])


@pytest.mark.parametrize("name", EDS)
def test_access_is_what_the_eds_says(name, start):
    ours = start(name)
    refused = 0
    for entry in quiet(ours, name):
        if not entry.writable:
            for length in (1, entry.size or 1, 8, 12):
                assert refusal_of(download, ours, entry, bytes(length)) == READ_ONLY, entry
            refused += 1
        got = upload(ours, entry)
        if not entry.readable:
            assert got == WRITE_ONLY, entry
        elif isinstance(got, bytes) and entry.type != TEXT:
            assert len(got) == entry.size, entry
        elif not isinstance(got, bytes):
            assert got == NO_DATA, entry
    assert refused > 20


@pytest.mark.parametrize("name", EDS)
def test_numbers_of_a_wrong_length_are_refused(name, start):
    ours = start(name)
    tried = 0
    for entry in (entry for entry in quiet(ours, name) if entry.writable and entry.type != TEXT):
        for length in range(13):
            if length != entry.size:
                check_refused(ours, entry, bytes(length), TOO_LONG if length > entry.size else TOO_SHORT)
                tried += 1
    assert tried > 90


def beyond(entry):
    """(value, abort code) of what lies beyond the limits, next to them and far."""
    if entry.type == BOOLEAN:
        return [(2, VALUE), (255, VALUE)]
    if entry.is_real:
        bad = [(math.nan, VALUE), (math.inf, VALUE), (-math.inf, VALUE)]
        if entry.low is not None:
            bad += [(beside(entry, entry.high, 1), TOO_HIGH), (beside(entry, entry.low, -1), TOO_LOW)]
            bad += [(entry.high + 1e6, TOO_HIGH), (entry.low - 1e6, TOO_LOW)]
        return bad
    least, most = entry.range
    bad = []
    if entry.high is not None and entry.high < most:
        bad += [(entry.high + 1, TOO_HIGH), (most, TOO_HIGH)]
    if entry.low is not None and entry.low > least:
        bad += [(entry.low - 1, TOO_LOW), (least, TOO_LOW)]
    return bad


def beside(entry, limit, way):
    """The next number of the entry's type above or below a limit."""
    if entry.type == 0x11:
        return math.nextafter(limit, way * math.inf)
    bits = struct.unpack("<i", struct.pack("<f", limit))[0]
    if limit == 0.0:
        return way * 1e-45
    return struct.unpack("<f", struct.pack("<i", bits + (way if limit > 0 else -way)))[0]


@pytest.mark.parametrize("name", EDS)
def test_values_beyond_the_limits_are_refused(name, start):
    ours = start(name)
    tried = 0
    for entry in (entry for entry in quiet(ours, name) if entry.writable and entry.type != TEXT):
        for value, code in beyond(entry):
            check_refused(ours, entry, entry.encode(value), code)
            tried += 1
    assert tried > (100 if name == "navcomp" else 5)


@pytest.mark.parametrize("name", EDS)
def test_the_limits_themselves_are_taken(name, start):
    """Where nothing but the limits rules: the maker's own objects, but for those with further rules."""
    ours = start(name)
    taken = 0
    for entry in quiet(ours, name):
        plain = entry.writable and entry.readable and entry.index >= 0x2000 and entry.low is not None
        if not plain or (entry.index, entry.subindex) in RULES:
            continue
        for value in (entry.low, entry.high):
            download(ours, entry, entry.encode(value))
            assert upload(ours, entry) == entry.encode(value), entry
            taken += 1
    assert taken >= (80 if name == "navcomp" else 2)


def test_rules_beyond_the_limits(start):
    ours = start("navcomp")
    entries = {(entry.index, entry.subindex): entry for entry in quiet(ours, "navcomp")}
    for place, (good, bad, code) in RULES.items():
        entry = entries[place]
        for value in good:
            download(ours, entry, entry.encode(value))
            assert upload(ours, entry) == entry.encode(value), entry
        for value in bad:
            assert refusal_of(download, ours, entry, entry.encode(value)) == code, (entry, value)


@pytest.mark.parametrize("name", EDS)
def test_there_is_nothing_beside_what_the_eds_lists(name, start):
    ours = start(name)
    entries = quiet(ours, name)
    listed = {(entry.index, entry.subindex) for entry in entries}
    for index in sorted({index for index, _ in listed}):
        for subindex in (sub for sub in range(50) if (index, sub) not in listed):
            assert refusal_of(ours.node.sdo.upload, index, subindex) == NO_SUBINDEX, (hex(index), subindex)
            assert refusal_of(ours.node.sdo.download, index, subindex, b"\0") == NO_SUBINDEX, (hex(index), subindex)


@pytest.mark.parametrize("name", EDS)
def test_both_readers_of_the_eds_agree(name, start):
    ours = start(name)
    theirs = {(entry.index, entry.subindex): entry for entry in ours.entries()}
    entries = read(EDS[name])
    assert {(entry.index, entry.subindex) for entry in entries} == set(theirs)
    for entry in entries:
        other = theirs[entry.index, entry.subindex]
        assert (entry.type, entry.access) == (other.data_type, other.access_type), entry
        if entry.type in INTEGERS and entry.type != BOOLEAN:
            assert (entry.low, entry.high) == (other.min, other.max), entry


def test_settings_are_refused_while_a_run_is_on(start):
    ours = start("navcomp")
    ours.node.sdo["Command"]["Command"].raw = 1
    tried = 0
    for entry in read(EDS["navcomp"]):
        if entry.writable and (entry.index in (0x2050, 0x2152) or 0x2122 <= entry.index <= 0x2126):
            value = entry.high if entry.high is not None else 0
            assert refusal_of(download, ours, entry, entry.encode(value)) == DEVICE_STATE, entry
            tried += 1
    assert tried == 50


def test_what_is_of_service_level_is_refused_at_normal_level(start):
    """As docs/canopen.md has it, which the table generates: every such object, and no other for that reason."""
    ours = start("navcomp")
    ours.node.sdo["Host"]["Inhibit"].raw = 65535
    protected = of_service_level()
    tried = 0
    for entry in (entry for entry in read(EDS["navcomp"]) if (entry.index, entry.subindex) in protected):
        before = upload(ours, entry)
        value = before if isinstance(before, bytes) else bytes(entry.size)
        assert refusal_of(download, ours, entry, value) == DEVICE_STATE, entry
        assert upload(ours, entry) == before, entry
        tried += 1
    assert tried == len(protected) > 90
    for place in ((0x1016, 1), (0x1800, 1), (0x2050, 5), (0x2123, 2), (0x2124, 1), (0x2126, 12), (0x1010, 1)):
        assert place in protected


def of_service_level():
    """(index, subindex) of all whose column says so."""
    page = (ROOT / "docs/canopen.md").read_text(encoding="utf-8").split("## Node 1:")[1].split("## Node 2:")[0]
    found, index = set(), 0
    for cells in (line.split("|")[1:-1] for line in page.splitlines() if line.startswith("|")):
        place = cells[0].strip()
        if place.endswith("h"):
            index, place = int(place[:-1], 16), ":0"
            if alike := re.search(r", as ([0-9A-F]{4})h", cells[2]):
                found |= {(index, subindex) for other, subindex in found if other == int(alike[1], 16)}
        if place.startswith(":") and cells[4].strip() == "service":
            subindices = [int(number) for number in re.findall(r":(\d+)", place)]
            found |= {(index, subindex) for subindex in range(subindices[0], subindices[-1] + 1)}
    return found
