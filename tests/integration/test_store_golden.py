"""The store's records, byte by byte: tests/golden/ by the independent encoder, by the firmware, and back.
And the dump."""

import importlib.util
import itertools
import re
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

import pytest
from c_compiler import compiled, firmware_sources
from documents import document_of
from hypothesis import given, strategies as st

from tumble.errors import BadInput
from tumble.store import codec
from tumble.store.image import read_image

ROOT = Path(__file__).resolve().parents[2]
GOLDEN = ROOT / "tests" / "golden"

_spec = importlib.util.spec_from_file_location("golden_make", GOLDEN / "make.py")
golden = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(golden)
CASES = dict(golden.cases())


@pytest.fixture(scope="module")
def firmware(tmp_path_factory):
    """A function: kind and bytes of a record in, what the firmware reads of it and writes out."""
    sources = [name for name in firmware_sources() if name.startswith(("firmware/core/", "firmware/sets/"))]
    program = compiled(tmp_path_factory.mktemp("codec") / "store_codec", "-Itests/lib",
                       "tests/integration/store_codec_harness.c", "tests/lib/flash.c", *sources)

    def run(kind, record, fingerprint=0):
        done = subprocess.run([program, kind, hex(fingerprint)], input=record, capture_output=True, timeout=60)
        *lines, written = done.stdout.decode().splitlines() or [""]
        fields = {name: values for name, *values in map(str.split, lines)}
        return done.returncode, fields, bytes.fromhex(written)

    return run


def expected_fields(case):
    """What the firmware must print of a case."""
    numbers = {name: golden.exact(value) for name, value in case["numbers"].items()}
    numbers.pop("fingerprint", None)
    if case["kind"] == "set":
        known = ("temperature_c", "gravity_m_s2", "u_k", "check", "closure_v")
        numbers["flags"] = sum(1 << bit for bit, name in enumerate(known) if numbers[name] is not None)
        numbers["flags"] |= codec.RESUMED if numbers.pop("resumed") else 0
        numbers["flags"] |= codec.OTHER_RULES if numbers.pop("other_rules") else 0
        numbers["flags"] |= codec.HAS_TEMPERATURE_RANGE if numbers["temperature_range_c"] else 0
        numbers["serial"] = numbers["serial"].encode().ljust(24, b"\0").hex()
        lengths = {"u_k": 9, "u_u0": 3, "check": 3, "temperature_range_c": 2}
        numbers = {name: [0.0] * lengths.get(name, 1) if value is None else value for name, value in numbers.items()}
    if case["kind"] == "position":
        numbers["temperature_range_c"] = numbers["temperature_range_c"] or []
    return numbers


def as_printed(text, like):
    return (
        text
        if isinstance(like, str)
        else float.fromhex(text)
        if isinstance(like, float)
        else int(float.fromhex(text) if "x" in text else text)
    )


@pytest.mark.parametrize("name", CASES)
def test_the_firmware_reads_the_numbers_and_writes_the_bytes(firmware, name):
    record = (GOLDEN / f"{name}.bin").read_bytes()
    status, fields, written = firmware(CASES[name]["kind"], record, CASES[name]["numbers"].get("fingerprint", 0))
    assert status == 0 and written == record
    for field, value in expected_fields(CASES[name]).items():
        values = value if isinstance(value, list) else [value]
        found = [as_printed(text, like) for text, like in zip(fields[field], values, strict=True)]
        assert list(map(repr, found)) == list(map(repr, values)), field  # repr: a negative zero is one


@pytest.mark.parametrize("name", CASES)
def test_python_writes_the_golden_files_and_reads_them(name):
    case, record = CASES[name], (GOLDEN / f"{name}.bin").read_bytes()
    numbers = {key: golden.exact(value) for key, value in case["numbers"].items()}
    assert golden.encode(case) == record
    fingerprint = numbers.pop("fingerprint", None)
    read = {"set": codec.decode_set, "entry": codec.decode_entry, "run": codec.decode_run,
            "position": lambda r: codec.decode_position(r, fingerprint)}[case["kind"]](record)
    assert read == fingerprint if case["kind"] == "run" else vars(read) == numbers


@pytest.mark.parametrize("name", CASES)
def test_an_altered_bit_is_noticed_by_both(firmware, name):
    case, record = CASES[name], bytearray((GOLDEN / f"{name}.bin").read_bytes())
    record[len(record) // 2] ^= 0x10
    fingerprint = case["numbers"].get("fingerprint", 0)
    decode = {"set": codec.decode_set, "entry": codec.decode_entry, "run": codec.decode_run,
              "position": lambda r: codec.decode_position(r, fingerprint)}[case["kind"]]
    with pytest.raises(codec.NotARecord, match="its checksum does not agree"):
        decode(bytes(record))
    if case["kind"] != "run":
        assert firmware(case["kind"], bytes(record), fingerprint)[0] != 0


HALF_DEGREES = st.lists(st.integers(-128, 127), min_size=2, max_size=2).map(lambda pair: [n / 2 for n in sorted(pair)])
FINITE = st.floats(allow_nan=False, allow_infinity=False)
POSITIVE = st.floats(min_value=0.0, allow_infinity=False).map(abs)
WORD = st.integers(0, 2**32 - 1)


@given(
    st.builds(
        codec.CoefficientSet,
        sequence=WORD,
        origin=st.integers(1, 5),
        estimator=st.integers(0, 255),
        serial=st.text(st.characters(codec="ascii", exclude_characters="\0"), max_size=24),
        date_utc_s=st.integers(1, 2**64 - 1) | st.none(),
        temperature_c=FINITE | st.none(),
        gravity_m_s2=st.just(9.81) | st.none(),
        k=st.lists(FINITE, min_size=9, max_size=9),
        u0=st.lists(FINITE, min_size=3, max_size=3),
        u_k=st.lists(POSITIVE, min_size=9, max_size=9),
        u_u0=st.lists(POSITIVE, min_size=3, max_size=3),
        check=st.lists(POSITIVE, min_size=3, max_size=3) | st.none(),
        closure_v=POSITIVE | st.none(),
        samples=WORD,
        fit_positions=st.integers(0, 255),
        check_positions=st.integers(0, 255),
        schedule_crc=WORD,
        stand_crc=WORD,
        reasons=WORD,
        restores=WORD,
        from_crc=WORD,
        resumed=st.booleans(),
        other_rules=st.booleans(),
        temperature_range_c=HALF_DEGREES | st.none(),
    )
)
def test_any_set_comes_back(found):
    assert codec.decode_set(codec.encode_set(found)) == found


def with_a_seal(record, *changed):
    record = bytearray(record[:-4])
    for at, byte in changed:
        record[at] = byte
    return bytes(record) + zlib.crc32(record).to_bytes(4, "little")


@pytest.mark.parametrize("changed", [
    [(15, 0x01)],  # a flag that does not exist
    [(15, 0x80)],
    [(295, 0xE5)],  # -13 degrees C at least, -13.5 at most
    [(14, 0x3F)],  # the range is there, and its flag is not
], ids=["flag 0100h", "flag 8000h", "order", "no flag"])
def test_a_wrong_field_under_a_right_checksum_is_refused_by_both(firmware, changed):
    whole = (GOLDEN / "set_temperature_range.bin").read_bytes()
    assert whole[14:16] == bytes([0xBF, 0]) and whole[294:296] == bytes([0xE6, 0xE9])
    record = with_a_seal(whole, *changed)
    with pytest.raises(codec.NotARecord, match="a field is out of its range"):
        codec.decode_set(record)
    assert firmware("set", record)[0] != 0
    assert codec.decode_set(with_a_seal(whole)).temperature_range_c == [-13.0, -11.5]


RANGES = {  # deg C, by how many half degrees they are off the cold end and off the warm one
    (2, 1): [-63.0, 63.0],
    (128, 127): [0.0, 0.0],
    (254, 1): [63.0, 63.0],
    (2, 253): [-63.0, -63.0],
    (0, 0): None,
    (0, 87): None,  # at an end the block may have been beyond it; the cold one is two values wide
    (1, 87): None,
    (0, 255): None,
    (168, 0): None,
    (255, 0): None,
    (128, 128): None,  # the least above the largest
    (255, 255): None,  # no sample yet
}


@pytest.mark.parametrize(("margins", "range_c"), RANGES.items())
def test_a_range_that_touches_an_end_is_unknown_to_both(firmware, margins, range_c):
    fingerprint = CASES["position"]["numbers"]["fingerprint"]
    record = a_position(margins, fingerprint)
    status, fields, written = firmware("position", record, fingerprint)
    assert (status, written) == (0, record)
    assert [float.fromhex(text) for text in fields["temperature_range_c"]] == (range_c or [])
    assert codec.decode_position(record, fingerprint).temperature_range_c == range_c


def test_the_ends_of_both_readers_are_the_same(firmware):
    for cold, warm in itertools.product((0, 1, 2, 3, 127, 128, 254, 255), repeat=2):
        record = a_position((cold, warm), 5)
        told = [float.fromhex(text) for text in firmware("position", record, 5)[1]["temperature_range_c"]]
        assert (codec.decode_position(record, 5).temperature_range_c or []) == told, (cold, warm)


def a_position(margins, fingerprint):
    """The golden one as an entry of this run with these margins."""
    record = bytearray((GOLDEN / "position.bin").read_bytes()[:-4])
    record[44:46] = margins
    return bytes(record) + zlib.crc32(record, zlib.crc32(fingerprint.to_bytes(4, "little"))).to_bytes(4, "little")


@pytest.mark.parametrize(("range_c", "kept_c"), [([20.1, 20.4], [20.0, 20.5]), ([-20.4, -20.1], [-20.5, -20.0]),
                                                 ([-64.0, 63.5], [-64.0, 63.5]), ([21.5, 21.5], [21.5, 21.5])])
def test_a_range_between_half_degrees_is_widened(range_c, kept_c):
    assert codec.decode_set(codec.encode_set(a_set(temperature_range_c=range_c))).temperature_range_c == kept_c


@pytest.mark.parametrize("range_c", [[-64.1, 20.0], [20.0, 63.6], [20.5, 20.4], [float("nan"), 20.0]])
def test_a_range_that_cannot_be_kept_is_refused(range_c):
    message = "a range of temperatures lies within -64.0 and 63.5 deg C, the lower first"
    with pytest.raises(ValueError, match=message):
        codec.encode_set(a_set(temperature_range_c=range_c))


def a_set(**changes):
    numbers = {key: golden.exact(value) for key, value in CASES["set_full"]["numbers"].items()}
    return codec.CoefficientSet(**{**numbers, "from_crc": 0, **changes})


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


def test_unknown_is_null_in_the_document(tumble, tmp_path):
    blank = tmp_path / "blank"
    blank.write_bytes(b"\xff" * 8 * 4096)
    assert document_of(tumble("store", "dump", blank, "--json"), "store") == {
        "schema": "tumble.store/1", "active": None, "factory": None, "slots": {"A": None, "B": None}, "proposal": None,
        "history": [], "checkpoint": None, "torn": []}
    image = bytearray(b"\xff" * 8 * 4096)
    put(image, 0, place(codec.CoefficientSet(**numbers_of("set_bare") | {"origin": 1})))
    entry = numbers_of("history_entry") | {"flags": 0, "origin": 6, "date_utc_s": None}
    entry["values"] = [float("nan"), *entry["values"][1:]]
    put(image, 4 * 4096, codec.encode_entry(codec.HistoryEntry(**entry)))
    blank.write_bytes(image)
    found = document_of(tumble("store", "dump", blank, "--json"), "store")
    unknown = {"date_utc_s", "temperature_c", "temperature", "gravity_m_s2", "u_K", "u_U0", "check", "closure_v",
               "samples", "schedule_crc", "stand_crc"}
    assert found["active"] == "factory"
    assert {key for key, value in found["factory"].items() if value is None} == unknown
    (told,) = found["history"]
    assert {key for key, value in told.items() if value is None} == {"date_utc_s", "temperature_c", "u_K", "u_U0"}
    assert told["origin"] == "decayed" and told["K"][0] == [None, *entry["values"][1:3]]


def test_the_dump_finds_what_is_torn_and_what_is_left_over():
    image = an_image()
    held = bytes(image[3 * 4096 : 3 * 4096 + 352])
    put(image, 2 * 4096, place(a_set(sequence=3, origin=3, from_crc=int.from_bytes(held[316:320], "little"))))
    image[4096 + 320] = 0
    image[4 * 4096 + 10] ^= 1
    image[6 * 4096 + 70] ^= 1
    found = read_image(bytes(image))
    assert found.active.sequence == 3 and found.proposal is None and list(found.slots) == ["B"]
    assert found.torn == ["slot A: it was not written to its end: the mark is missing",
                          "history, sector 4, entry 1: its checksum does not agree",
                          "checkpoint, position entry 1: its checksum does not agree"]


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


def check_golden(folder):
    done = subprocess.run([sys.executable, "-B", folder / "make.py", "--check"], capture_output=True, text=True)
    return done.returncode, done.stdout


def test_the_golden_files_are_what_their_generator_writes():
    assert check_golden(GOLDEN) == (0, "golden files: all right\n")


@pytest.mark.parametrize("name", CASES)
def test_a_changed_byte_of_a_golden_file_is_told(name, tmp_path):
    for file in (GOLDEN / "make.py", GOLDEN / "store.json", *GOLDEN.glob("*.bin")):
        shutil.copy(file, tmp_path)
    record = bytearray((tmp_path / f"{name}.bin").read_bytes())
    record[-1] ^= 1
    (tmp_path / f"{name}.bin").write_bytes(record)
    (tmp_path / "left_over.bin").write_bytes(record)
    assert check_golden(tmp_path) == (1, f"{name}.bin is stale\nleft_over.bin is of no case\n")


def test_the_factory_set_of_the_page_is_one(tumble, tmp_path):
    """docs/store.md, the last block of code, as it stands there."""
    page = (ROOT / "docs" / "store.md").read_text(encoding="utf-8")
    code = page[page.index("    from tumble.store.codec import") :]
    script = "\n".join(line[4:] for line in code.splitlines())
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True)
    image = tmp_path / "nv.bin"
    assert image.stat().st_size == 65536  # as tumble-node --nv has it
    done = tumble("store", "dump", image)
    assert done.stdout.startswith(
        "active (the factory set): sequence 0, factory, block '0042', 2026-11-21 00:00 UTC, K_xx"
    ), done


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
