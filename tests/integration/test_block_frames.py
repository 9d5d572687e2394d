"""docs/bus/block.dbc against the C codec: what one side packs, the other must unpack to the same numbers."""

import random
import re
import subprocess
from pathlib import Path

import pytest
from c_compiler import compiled

cantools = pytest.importorskip("cantools")

ROOT = Path(__file__).resolve().parents[2]
DBC = ROOT / "docs" / "bus" / "block.dbc"

INT24 = (-(2**23), -(2**23) + 1, -65536, -1, 0, 1, 255, 256, 2**23 - 1)
STATUS_BITS = ("saturated", "self_test_failed", "converter_fault", "temperature_out_of_range")


@pytest.fixture(scope="module")
def codec(tmp_path_factory):
    """A function that sends request lines to the C codec and returns its answer lines."""
    program = compiled(tmp_path_factory.mktemp("codec") / "codec", "-Wall", "-Wextra", "-Werror", "-Ihost",
                       "tests/integration/block_frames_harness.c", "firmware/sample/block_frames.c",
                       "firmware/core/count.c", "host/simulation/block_encode.c")

    def ask(requests):
        done = subprocess.run([program], input="\n".join(requests) + "\n", text=True, capture_output=True, check=True)
        return done.stdout.splitlines()

    return ask


@pytest.fixture(scope="module")
def dbc():
    return cantools.database.load_file(DBC, strict=True)


def some_samples(count=2000, seed=1):
    """(x, y, z, counter, timestamp, status, temperature) with the extremes first, then drawn at random."""
    samples = [(a, b, c, i % 256, (i * 4095) % 4096, i % 16, (i % 256) - 128)
               for i, (a, b, c) in enumerate((a, b, c) for a in INT24 for b in INT24 for c in INT24)]
    draw = random.Random(seed)
    for _ in range(count):
        samples.append((*(draw.randint(-(2**23), 2**23 - 1) for _ in range(3)), draw.randrange(256),
                        draw.randrange(4096), draw.randrange(16), draw.randint(-128, 127)))
    return samples


def reference_crc(identifier, payload):
    """CRC-8 bit by bit: polynomial 0x2F, initial value 0xFF, final xor 0xFF."""
    crc = 0xFF
    for byte in bytes([identifier & 0xFF]) + payload:
        crc ^= byte
        for _ in range(8):
            crc = ((crc << 1) ^ 0x2F if crc & 0x80 else crc << 1) & 0xFF
    return crc ^ 0xFF


def signals_of(sample):
    """The signals of both messages for one sample, raw (no scaling, no names of values)."""
    x, y, z, counter, timestamp, status, temperature = sample
    xy = {"x": x, "y": y, "sample_counter": counter}
    second = {"z": z, "frame_counter": (2 * counter + 1) % 256, "timestamp": timestamp, "temperature": temperature}
    second.update({name: status >> bit & 1 for bit, name in enumerate(STATUS_BITS)})
    return xy, second


def test_the_dbc_describes_what_the_c_encoder_encodes(codec, dbc):
    samples = some_samples()
    answers = codec("encode " + " ".join(map(str, sample)) for sample in samples)
    assert len(answers) == len(samples)
    for sample, answer in zip(samples, answers):
        xy_id, xy_data, z_id, z_data = answer.split()
        xy, second = signals_of(sample)
        xy["crc_xy"] = reference_crc(int(xy_id, 16), bytes.fromhex(xy_data)[:7])
        second["crc_z"] = reference_crc(int(z_id, 16), bytes.fromhex(z_data)[:7])
        assert dbc.decode_message(int(xy_id, 16), bytes.fromhex(xy_data), scaling=False, decode_choices=False) == xy
        assert dbc.decode_message(int(z_id, 16), bytes.fromhex(z_data), scaling=False, decode_choices=False) == second


def test_the_c_receiver_takes_what_is_packed_from_the_dbc(codec, dbc):
    requests = []
    samples = [(*sample[:3], index, *sample[4:]) for index, sample in enumerate(some_samples(count=300))]
    for sample in samples:
        signals = signals_of((*sample[:3], sample[3] % 256, *sample[4:]))
        for message, values, crc in zip(("BLOCK_XY", "BLOCK_Z"), signals, ("crc_xy", "crc_z")):
            frame = dbc.get_message_by_name(message)
            payload = frame.encode({**values, crc: 0}, scaling=False)[:7]
            payload += bytes([reference_crc(frame.frame_id, payload)])
            requests.append(f"receive {frame.frame_id:03X} {payload.hex()}")
    answers = codec(requests)
    assert answers[0::2] == ["half"] * len(samples)
    assert answers[1::2] == ["sample " + " ".join(map(str, sample)) for sample in samples]


def test_scaled_values_have_units(dbc):
    message = dbc.get_message_by_name("BLOCK_Z")
    units = {signal.name: signal.unit for signal in message.signals if signal.unit}
    assert units == {"z": "counts", "timestamp": "ms", "temperature": "degC"}
    payload = bytes([0, 0, 0, 1, 0x10, 0x27, 0xFF, 0])
    assert message.decode(payload)["temperature"] == -0.5
    assert message.decode(payload)["timestamp"] == 0x710
    assert str(message.decode(payload)["self_test_failed"]) == "yes"


def test_every_bit_of_both_frames_is_described_once(dbc):
    """No gap that a decoder would ignore and no overlap: 64 bits each."""
    for message in dbc.messages:
        assert message.length == 8
        assert sum(signal.length for signal in message.signals) == 64
        assert {signal.byte_order for signal in message.signals} == {"little_endian"}
        bits = [bit for signal in message.signals for bit in range(signal.start, signal.start + signal.length)]
        assert sorted(bits) == list(range(64))


def test_identifiers_are_free_of_every_canopen_service(dbc):
    """CiA 301: the default connection set of all nodes, SYNC, TIME, LSS and the identifiers of restricted use."""
    taken = {0x000, *range(0x001, 0x080), 0x080, *range(0x081, 0x100), 0x100, *range(0x101, 0x181)}
    for base in (0x180, 0x200, 0x280, 0x300, 0x380, 0x400, 0x480, 0x500, 0x580, 0x600, 0x700):
        taken |= {base + node for node in range(1, 128)}
    taken |= {*range(0x581, 0x600), *range(0x601, 0x680), *range(0x6E0, 0x700), *range(0x701, 0x800)}
    identifiers = {message.frame_id for message in dbc.messages}
    assert identifiers == {0x683, 0x693}
    assert not identifiers & taken


def test_the_header_names_the_same_identifiers(dbc):
    header = (ROOT / "firmware/sample/block_frames.h").read_text()
    named = {int(value, 16) for value in re.findall(r"#define TUMBLE_BLOCK_ID_\w+ (0x[0-9A-F]+)U", header)}
    assert named == {message.frame_id for message in dbc.messages}


def weights_of_undetected_errors(polynomial, bits, up_to):
    """How many error patterns of 1, 2, ... wrong bits leave the checksum right, in a codeword of so many bits."""
    syndromes, value = [], 1
    for _ in range(bits):
        syndromes.append(value)
        value = (value << 1) ^ polynomial if value & 0x80 else value << 1
        value &= 0xFF
    ways = [[0] * 256 for _ in range(up_to + 1)]
    ways[0][0] = 1
    for syndrome in syndromes:
        for weight in range(up_to, 0, -1):
            fewer = ways[weight - 1]
            ways[weight] = [here + fewer[state ^ syndrome] for state, here in enumerate(ways[weight])]
    return [ways[weight][0] for weight in range(1, up_to + 1)]


@pytest.mark.parametrize("polynomial", ["0x2F", "0x07", "0x1D"])
def test_the_page_states_the_computed_strength_of_the_checksums(polynomial):
    """The table in docs/bus/README.md is recomputed: Hamming distance and undetected errors of 1 to 6 bits in 72."""
    undetected = weights_of_undetected_errors(int(polynomial, 16), 72, 6)
    distance = next(weight for weight, count in enumerate(undetected, 1) if count)
    row = next(line for line in (ROOT / "docs/bus/README.md").read_text().splitlines()
               if line.startswith(f"| `{polynomial}` |"))
    cells = [cell.strip().replace(",", "") for cell in row.strip("|").split("|")]
    assert cells[1:] == [str(distance), *map(str, undetected)]


def test_malformed_requests_end_the_harness_with_exit_2(codec):
    with pytest.raises(subprocess.CalledProcessError) as failure:
        codec(["encode 1 2"])
    assert failure.value.returncode == 2
    assert failure.value.stderr == "malformed request: encode 1 2\n"
