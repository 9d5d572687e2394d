"""tumble store dump: what it says of a memory, as lines and as a document."""

import re

import pytest
from documents import document_of
from test_store_golden import CASES, GOLDEN, a_set, golden

from tumble.errors import BadInput
from tumble.store import codec
from tumble.store.image import read_image


def put(image, offset, record):
    image[offset : offset + len(record)] = record


def place(found):
    record = codec.encode_set(found)
    return record + codec.mark_of(record)


def an_image(sector=4096):
    image = bytearray(b"\xff" * 8 * sector)
    held = place(a_set(sequence=3, origin=5))
    put(image, 0, place(a_set(sequence=0, origin=1)))
    put(image, sector, place(a_set(sequence=1, origin=2)))
    put(image, 2 * sector, place(a_set(sequence=2, origin=2, serial="active")))
    put(image, 3 * sector, held)
    put(image, 4 * sector, (GOLDEN / "history_entry.bin").read_bytes())
    put(image, 6 * sector, (GOLDEN / "run.bin").read_bytes())
    put(image, 6 * sector + 64, (GOLDEN / "position.bin").read_bytes())
    return image


@pytest.mark.parametrize("sector", [4096, 8192])
def test_the_dump_says_what_is_there(tumble, tmp_path, sector):
    image = tmp_path / "nv"
    image.write_bytes(an_image(sector))
    done = tumble("store", "dump", image, "--sector", sector)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0].startswith("active (slot B): sequence 2, committed, block 'active', ")
    assert [line.split(",")[0] for line in lines[1:4]] == [
        "factory: sequence 0",
        "slot A: sequence 1",
        "proposal: sequence 3",
    ]
    assert lines[4:] == ["history: 1, the newest of 2026-11-21 00:00 UTC with sequence 17",
                         "checkpoint: run 0xc0ffee42, 1 positions"]


def numbers_of(name):
    return {key: golden.exact(value) for key, value in CASES[name]["numbers"].items()}


def rows(nine):
    return [nine[:3], nine[3:6], nine[6:]]


def test_the_document_has_all_that_is_there(tumble, tmp_path):
    image = an_image()
    put(image, 4096, place(a_set(sequence=1, origin=2, temperature_range_c=[-12.5, 21.0])))
    put(image, 6 * 4096 + 64, (GOLDEN / "position_temperature_range.bin").read_bytes())
    image[5 * 4096] = 0
    (tmp_path / "nv").write_bytes(image)
    found = document_of(tumble("store", "dump", tmp_path / "nv", "--json"), "store")
    assert found["active"] == "B" and found["torn"] == ["history, sector 5, entry 1: there is no entry of a history"]
    sets = [found["factory"], found["slots"]["A"], found["slots"]["B"], found["proposal"]]
    assert [(one["sequence"], one["origin"]) for one in sets] == [(0, "factory"), (1, "committed"), (2, "committed"),
                                                                  (3, "held")]
    assert [one["temperature"] for one in sets] == [None, {"min_c": -12.5, "max_c": 21.0}, None, None]
    full, one = numbers_of("set_full"), found["slots"]["A"]
    same = ("estimator", "serial", "date_utc_s", "temperature_c", "gravity_m_s2", "closure_v", "samples",
            "fit_positions", "check_positions", "schedule_crc", "stand_crc", "reasons", "restores", "resumed",
            "other_rules")
    assert {key: one[key] for key in same} == {key: full[key] for key in same}
    assert (one["K"], one["U0"]) == (rows(full["k"]), full["u0"])
    assert (one["u_K"], one["u_U0"]) == (rows(full["u_k"]), full["u_u0"])
    assert list(one["check"].values()) == full["check"]
    entry, (told,) = numbers_of("history_entry"), found["history"]
    assert (told["number"], told["sequence"], told["origin"], told["flags"]) == (33, 17, "accepted", 63)
    assert (told["K"], told["U0"]) == (rows(entry["values"][:9]), entry["values"][9:])
    assert (told["u_K"], told["u_U0"]) == (rows(entry["u"][:9]), entry["u"][9:])
    assert told["temperature_c"] == entry["temperature_c"] and told["date_utc_s"] == entry["date_utc_s"]
    assert found["checkpoint"]["fingerprint"] == 0xC0FFEE42
    position, (kept,) = numbers_of("position_temperature_range"), found["checkpoint"]["positions"]
    assert kept == {"index": 35, "samples": position["samples"], "sums": position["sums"],
                    "scatter": position["scatter"], "temperature": {"min_c": -63.0, "max_c": 21.5}}


SLOPES = [[1e-4, 0.0, 0.0, 0.0, -2e-4, 0.0, 0.0, 0.0, 3e-4, 5e-5, -5e-5, 6e-5],
          [0.0] * 8 + [2e-7, 0.0, 0.0, 1e-7]]  # fmt: skip


def test_the_dump_says_the_slopes(tumble, tmp_path):
    image, warm = an_image(), {"temperature_c": 21.5, "temperature_range_c": [-40.0, 60.0]}
    put(image, 4096, place(a_set(sequence=8, origin=2, slopes=SLOPES, **warm)))
    put(image, 0, place(a_set(sequence=0, origin=1, slopes=[SLOPES[0], [0.0] * 12], **warm)))
    (tmp_path / "nv").write_bytes(image)
    active, factory = tumble("store", "dump", tmp_path / "nv").stdout.splitlines()[:2]
    said = (", slopes of K_xx, K_yy, K_zz 0.0001, -0.0002, 0.0003 V/g/K, of U0 5e-05, -5e-05, 6e-05 V/K, ",
            "slopes of K_xx, K_yy, K_zz 0, 0, 2e-07 V/g/K^2, of U0 0, 0, 1e-07 V/K^2, gravity")
    assert ", degree 2 over -40 to 60 deg C about 21.5 deg C" + "".join(said) in active
    assert ", degree 1 over -40 to 60 deg C about 21.5 deg C" + said[0] + "gravity" in factory
    found = document_of(tumble("store", "dump", tmp_path / "nv", "--json"), "store")
    kept = codec.decode_set(codec.encode_set(a_set(slopes=SLOPES, **warm))).slopes
    assert found["slots"]["A"]["slopes"] == {"degree": 2, "K": [rows(one[:9]) for one in kept],
                                             "U0": [one[9:] for one in kept]}
    assert found["factory"]["slopes"]["degree"] == 1 and "slopes" not in found["slots"]["B"]


def test_unknown_is_null_in_the_document(tumble, tmp_path):
    blank = tmp_path / "blank"
    blank.write_bytes(b"\xff" * 8 * 4096)
    assert document_of(tumble("store", "dump", blank, "--json"), "store") == {
        "schema": "tumble.store/1", "active": None, "factory": None, "slots": {"A": None, "B": None}, "proposal": None,
        "history": [], "checkpoint": None, "torn": [], "newer": []}
    image = bytearray(b"\xff" * 8 * 4096)
    put(image, 0, place(codec.CoefficientSet(**numbers_of("set_bare") | {"origin": 1})))
    entry = numbers_of("history_entry") | {"flags": 0, "origin": 6, "date_utc_s": None}
    entry["values"] = [float("nan"), *entry["values"][1:]]
    put(image, 4 * 4096, golden.encode({"kind": "entry", "numbers": entry}))
    blank.write_bytes(image)
    found = document_of(tumble("store", "dump", blank, "--json"), "store")
    unknown = {"date_utc_s", "temperature_c", "temperature", "gravity_m_s2", "u_K", "u_U0", "check", "closure_v",
               "samples", "schedule_crc", "stand_crc"}
    assert found["active"] == "factory"
    assert {key for key, value in found["factory"].items() if value is None} == unknown
    (told,) = found["history"]
    assert {key for key, value in told.items() if value is None} == {"date_utc_s", "temperature_c", "u_K", "u_U0"}
    assert told["origin"] == "decayed" and told["K"][0] == [None, *entry["values"][1:3]]


@pytest.mark.parametrize("at, byte, said", [(4, 3, "(schema 3, flags 0x3f)"), (15, 2, "(schema 1, flags 0x23f)"),
                                            (15, 1, "(schema 1, flags 0x13f)")])
def test_a_set_of_a_newer_version_is_not_torn(at, byte, said, tumble, tmp_path):
    image = an_image()
    record = bytearray(image[2 * 4096 : 2 * 4096 + 316])
    record[at] = byte
    sealed = golden.sealed(bytes(record))
    put(image, 2 * 4096, sealed + codec.mark_of(sealed))
    (tmp_path / "nv").write_bytes(image)
    found = read_image(bytes(image))
    assert (found.active_slot, found.torn) == ("A", [])
    assert found.newer == [f"slot B: a set of a newer version {said}"], found.newer
    done = tumble("store", "dump", tmp_path / "nv")
    assert done.returncode == 0 and f"newer: {found.newer[0]}, which this one cannot read\n" in done.stdout
    image[2 * 4096 + 100] ^= 1  # with a wrong checksum it has decayed
    assert read_image(bytes(image)).newer == []


def test_the_dump_finds_what_is_torn_and_what_is_left_over():
    image = an_image()
    held = bytes(image[3 * 4096 : 3 * 4096 + 352])
    put(image, 2 * 4096, place(a_set(sequence=3, origin=3, from_crc=int.from_bytes(held[316:320], "little"))))
    image[4096 + 320] = 0
    image[4 * 4096 + 10] ^= 1
    image[6 * 4096 + 70] ^= 1
    found = read_image(bytes(image))
    assert found.active.sequence == 3 and found.proposal is None and list(found.slots) == ["B"]
    assert found.torn == ["slot A: it was not written completely: the mark is missing",
                          "history, sector 4, entry 1: its checksum is wrong",
                          "checkpoint, position entry 1: its checksum is wrong"]


def test_an_erased_memory_is_no_fault(tumble, tmp_path):
    image = tmp_path / "nv"
    image.write_bytes(b"\xff" * 8 * 4096)
    lines = tumble("store", "dump", image).stdout.splitlines()
    assert lines == ["active: none", "factory: none", "proposal: none", "history: empty", "checkpoint: no run is kept"]


def test_bad_input_is_one_line_and_exit_2(refused, tmp_path):
    short = tmp_path / "short"
    short.write_bytes(b"\xff" * 5000)
    for image, message in (
        (short, "5000 bytes are not whole sectors of 4096 bytes, 8 at least"),
        (tmp_path / "none", "no such file or folder"),
        (tmp_path, "a folder, not a file"),
    ):
        assert refused("store", "dump", image) == f"tumble: {image}: {message}\n"
        assert refused("store", "dump", image, "--json") == f"tumble: {image}: {message}\n"
    small = refused("store", "dump", short, "--sector", "512")
    assert small.startswith("tumble: --sector: '512' is not a whole number from 4096")
    assert "IMAGE" in refused("store", "dump")
    with pytest.raises(BadInput, match="a sector has at least 4096 bytes, not 512"):
        read_image(short.read_bytes(), 512)


@pytest.mark.parametrize(("range_c", "told"), [(None, ""), ([-12.5, 21.0], ", at -12.5 to 21 deg C"),
                                               ([0.0, 0.0], ", at 0 deg C")])
def test_the_dump_tells_the_temperatures_of_the_run(tumble, tmp_path, range_c, told):
    image = tmp_path / "memory"
    memory = bytearray(b"\xff" * (8 * 4096))
    put(memory, 4096, place(a_set(sequence=1, origin=3, temperature_range_c=range_c)))
    image.write_bytes(memory)
    line = tumble("store", "dump", image).stdout.splitlines()[0]
    assert re.search(r"U0 [^V]* V(.*), gravity check", line)[1] == told, line


def test_the_dump_tells_of_other_rules(tumble, tmp_path):
    image, told = tmp_path / "memory", ", under other rules than the board's"
    for flag in (False, True):
        record = codec.encode_set(a_set(sequence=1, origin=3, other_rules=flag))
        memory = bytearray(b"\xff" * (10 * 4096))
        put(memory, 4096, record + codec.mark_of(record))
        image.write_bytes(memory)
        line = tumble("store", "dump", image).stdout.splitlines()[0]
        assert line.startswith("active (slot A): sequence 1, accepted") and line.endswith(told) == flag, line
