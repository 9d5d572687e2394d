"""python-canopen as an independent master: the EDS files, and every object of our nodes read and written by SDO."""

import logging
import math
import random
import struct
import warnings

import pytest
from canopen_bridge import EDS, NUMBERS, canopen, program, refusal_of, start  # noqa: F401

pytestmark = pytest.mark.real_time

datatypes = canopen.objectdictionary.datatypes

INTEGERS = {
    datatypes.INTEGER8: "<b", datatypes.INTEGER16: "<h", datatypes.INTEGER32: "<i", datatypes.INTEGER64: "<q",
    datatypes.UNSIGNED8: "<B", datatypes.UNSIGNED16: "<H", datatypes.UNSIGNED32: "<I", datatypes.UNSIGNED64: "<Q",
}
REALS = {datatypes.REAL32: "<f", datatypes.REAL64: "<d"}
NO_DATA = 0x08000024
WITHOUT_A_RESULT = (0x1003, 0x2008, 0x2010, 0x2011, 0x2020, 0x2021, 0x2022, 0x2023, 0x2024, 0x2025, 0x2026, 0x2140,
                    0x2141, 0x2150, 0x2152, 0x2160, 0x2161, 0x2162, 0x2163, 0x2164)


@pytest.mark.parametrize("name", EDS)
def test_eds_loads_without_a_warning(name, caplog):
    with caplog.at_level(logging.WARNING), warnings.catch_warnings():
        warnings.simplefilter("error")
        dictionary = canopen.import_od(str(EDS[name]), NUMBERS[name])
    assert not caplog.records
    assert dictionary[0x1000].data_type == datatypes.UNSIGNED32
    assert dictionary["Identity object"]["Product code"].default == 0x54420000 + NUMBERS[name]
    assert dictionary.device_information.allowed_baudrates == {500000}
    assert dictionary[0x1014].default == 0x80 + NUMBERS[name]


@pytest.mark.parametrize("name", EDS)
def test_every_object_of_the_eds_is_there_with_its_type_and_default(name, start):
    """Read all; what has a default in the EDS file has that value after power-on."""
    ours = start(name)
    compared = 0
    for entry in ours.entries():
        try:
            raw = ours.upload(entry)
        except canopen.SdoAbortedError as refusal:
            if not entry.readable:
                assert refusal.code == 0x06010001, entry
            else:  # empty history, no measurement yet
                assert refusal.code == NO_DATA, entry
                assert entry.index in WITHOUT_A_RESULT or 0x2100 <= entry.index < 0x2118, entry
            continue
        assert entry.readable, entry
        if entry.data_type in INTEGERS or entry.data_type in REALS:
            assert len(raw) == struct.calcsize((INTEGERS | REALS)[entry.data_type]), entry
        if entry.default is not None and not differs_by_configuration(name, entry):
            assert entry.decode_raw(raw) == entry.default, entry
            compared += 1
    assert compared > 25


def differs_by_configuration(name, entry):
    """What the navigation computer sets from its own configuration, whatever the table says."""
    return NUMBERS[name] == 1 and entry.index == 0x1016


@pytest.mark.parametrize("name", EDS)
def test_the_eds_lists_all_there_is(name, start):
    """No object beside those of the EDS file, subindex by subindex and on all indices of the ranges in use."""
    ours = start(name)
    listed = {(entry.index, entry.subindex) for entry in ours.entries()}
    draw = random.Random(5)
    indices = {index for index, _ in listed}
    probes = {(index, sub) for index in indices for sub in (0, 1, 2, 9, 255)}
    probes |= {(index + step, 0) for index in indices for step in (-1, 1)}
    probes |= {(draw.randrange(0x1000, 0x10000), draw.randrange(4)) for _ in range(100)}
    for index, sub in sorted(probes - listed):
        code = refusal_of(ours.node.sdo.upload, index, sub)
        assert code == (0x06090011 if index in indices else 0x06020000), (hex(index), sub)


def writable_variables(ours):
    """Plain variables: what is written is read back, and nothing else happens. Those with rules beyond their limits,
    the keeper's, are test_canopen_access.py's."""
    return [entry for entry in ours.entries()
            if entry.access_type in ("rw", "rww", "rwr") and entry.index >= 0x2000
            and not 0x2100 <= entry.index < 0x2200 and entry.name != "Angle"]


def values_for(entry, draw):
    """Two values within the limits, drawn, and two beyond them where there are limits."""
    if entry.data_type in INTEGERS:
        bits = 8 * struct.calcsize(INTEGERS[entry.data_type])
        signed = INTEGERS[entry.data_type][1].islower()
        least = -(1 << bits - 1) if signed else 0
        most = (1 << bits - 1) - 1 if signed else (1 << bits) - 1
        low = least if entry.min is None else entry.min
        high = most if entry.max is None else entry.max
        beyond = ([low - 1] if low > least else []) + ([high + 1] if high < most else [])
        return [low, high, draw.randint(low, high)], beyond
    if entry.data_type in REALS:
        return [1e-3, 0.25], [math.nan, math.inf, -math.inf, 1e300]
    return ["", "a", "abcd", "a note of thirty-two characters."], []


def encode(entry, value):
    """Without the client's own check of limits, so that the server's is tested."""
    if isinstance(value, str):
        return value.encode("ascii")
    return struct.pack((INTEGERS | REALS)[entry.data_type], value)


@pytest.mark.parametrize("name", EDS)
def test_every_writable_object_keeps_what_is_written_and_refuses_the_rest(name, start):
    ours = start(name)
    if NUMBERS[name] == 1:
        ours.node.sdo["Service level"]["Key"].raw = 0x76726573
    draw = random.Random(1)
    written = 0
    for entry in writable_variables(ours):
        good, beyond = values_for(entry, draw)
        for value in good:
            ours.download(entry, encode(entry, value))
            raw = ours.upload(entry)
            assert raw == encode(entry, value), entry
            written += 1
        for value in beyond:
            code = refusal_of(ours.download, entry, encode(entry, value))
            assert code in (0x06090030, 0x06090031, 0x06090032), entry
            assert ours.upload(entry) == raw, entry
        for length in range(12):
            check_length(ours, entry, len(raw), bytes(length))
    assert written > 0


def check_length(ours, entry, right, data):
    """A number of the wrong length is refused with the code for it."""
    if (entry.data_type not in INTEGERS and entry.data_type not in REALS) or len(data) == right:
        return
    assert refusal_of(ours.download, entry, data) == (0x06070012 if len(data) > right else 0x06070013), entry


def test_read_only_objects_refuse_writing(start):
    ours = start("drive")
    for entry in ours.entries():
        if entry.access_type in ("ro", "const"):
            assert refusal_of(ours.download, entry, bytes(max(1, len(entry) // 8))) == 0x06010002, entry


def test_strings_and_reals_go_in_segments(start):
    ours = start("block")
    sdo = ours.node.sdo
    assert sdo["Manufacturer device name"].raw == "Tumble accelerometer block"
    assert sdo["Converter"]["Range"].raw == 10.0
    sdo["Note"].raw = "twenty-nine characters of it"
    assert sdo["Note"].raw == "twenty-nine characters of it"
    with sdo.open(0x2005, 0, "wb", size=3, force_segment=True) as note:
        note.write(b"abc")
    assert sdo["Note"].raw == "abc"
    assert ours.refusal_of_raw(sdo["Note"], 33 * "x") == 0x06070012


@pytest.mark.parametrize("mode", ["rb", "wb"])
def test_block_transfer_is_refused(start, mode):
    ours = start("block")

    def transfer():
        with ours.node.sdo.open(0x2005, 0, mode, size=3, block_transfer=True) as stream:
            stream.read() if mode == "rb" else stream.write(b"abc")

    assert refusal_of(transfer) == 0x05040001
    assert ours.node.sdo["Note"].raw == ""
