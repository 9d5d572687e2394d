"""The store's records, byte by byte: tests/golden/ by the independent encoder, by the firmware, and back."""

import importlib.util
import itertools
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

import pytest
from c_compiler import compiled, firmware_sources
from hypothesis import given, strategies as st

from tumble.store import codec

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
        slopes = numbers.pop("slopes", None)
        numbers["flags"] ^= codec.HAS_SLOPES | codec.HAS_TEMPERATURE if slopes else 0
        numbers["slopes"] = [number for power in slopes or () for number in power]
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
    if case["kind"] == "set":
        numbers.setdefault("slopes", None)
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
    with pytest.raises(codec.NotARecord, match="its checksum is wrong"):
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


SINGLE = st.floats(min_value=-(2.0**100), max_value=2.0**100, width=32, allow_subnormal=False)
SLOPES = st.lists(st.lists(SINGLE, min_size=12, max_size=12), min_size=2, max_size=2)


@given(SLOPES, st.lists(SINGLE, min_size=12, max_size=12), HALF_DEGREES, FINITE)
def test_any_set_with_slopes_comes_back_of_both(firmware, slopes, constant, range_c, temperature_c):
    found = a_set(k=constant[:9], u0=constant[9:], u_k=[abs(c) for c in constant[:9]], u_u0=[0.0] * 3, slopes=slopes,
                  temperature_c=temperature_c, temperature_range_c=range_c)
    record = codec.encode_set(found)
    assert (len(record), codec.decode_set(record)) == (codec.SET_BYTES, found)
    assert firmware("set", record)[::2] == (0, record)


@pytest.mark.parametrize(("changes", "message"), [
    ({"temperature_c": None}, "slopes need the temperature that they are about, and the range where they hold"),
    ({"temperature_range_c": None}, "slopes need the temperature that they are about, and the range where they hold"),
    ({"temperature_range_c": [20.1, 20.4]}, "a temperature range must hold a half degree"),
    ({"k": [4e38] * 9}, "a number is too large for single precision"),
])
def test_slopes_that_cannot_be_kept_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        codec.encode_set(a_set(**{"temperature_range_c": [20.0, 30.0], "slopes": [[0.0] * 12] * 2, **changes}))


def test_the_range_of_slopes_is_narrowed():
    kept = codec.decode_set(codec.encode_set(a_set(temperature_range_c=[-20.4, 20.4], slopes=[[0.0] * 12] * 2)))
    assert kept.temperature_range_c == [-20.0, 20.0]


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


@pytest.mark.parametrize("changed", [
    [(15, 0x00)],  # schema 2 without the flag of slopes
    [(14, 0xBF)],  # the temperature of a run
    [(14, 0x3E)],  # no range
    [(295, 0xAF)],  # an end below the other
    [(67, 0x7F), (66, 0x80)],  # infinite
], ids=["slopes", "temperature", "no range", "order", "infinite"])
def test_a_wrong_field_of_version_2_is_refused_by_both(firmware, changed):
    whole = (GOLDEN / "set_slopes.bin").read_bytes()
    assert whole[4:6] == bytes([2, 0]) and whole[14:16] == bytes([0xBE, 1]) and whole[294:296] == bytes([0xB0, 0x7F])
    record = with_a_seal(whole, *changed)
    with pytest.raises(codec.NotARecord, match="a field is out of its range"):
        codec.decode_set(record)
    assert firmware("set", record)[0] != 0


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
    message = "a temperature range must lie within -64.0 and 63.5 deg C, the lower end first"
    with pytest.raises(ValueError, match=message):
        codec.encode_set(a_set(temperature_range_c=range_c))


def a_set(**changes):
    numbers = {key: golden.exact(value) for key, value in CASES["set_full"]["numbers"].items()}
    return codec.CoefficientSet(**{**numbers, "from_crc": 0, **changes})


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


def run_of_page(first_line, folder):
    """The block of code of docs/embedding.md that begins so, as it stands there."""
    page = (ROOT / "docs" / "embedding.md").read_text(encoding="utf-8")
    lines = page[page.index(first_line) :].splitlines()
    script = "\n".join(line[4:] for line in itertools.takewhile(lambda line: not line or line[0] == " ", lines))
    subprocess.run([sys.executable, "-c", script], cwd=folder, check=True)


def test_the_factory_set_of_the_page_is_one(tumble, tmp_path):
    run_of_page("    from tumble.store.codec import CoefficientSet", tmp_path)
    image = tmp_path / "nv.bin"
    assert image.stat().st_size == 65536  # as tumble-node --nv has it
    done = tumble("store", "dump", image)
    assert done.stdout.startswith(
        "active (the factory set): sequence 0, factory, block '0042', 2026-11-21 00:00 UTC, K_xx"
    ), done
