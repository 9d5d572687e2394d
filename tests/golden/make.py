#!/usr/bin/env python3
"""Write the golden files of the store from their numbers, store.json, with the package's encoder (struct).

    make.py [--check]     with PYTHONPATH=host/python/src; --check: exit 1 if a file is not what it would write, or
                          there is one too many

Each file is one record: what C and Python must both read as the numbers of store.json, and both write.
"""
import json
import math
import struct
import sys
import zlib
from pathlib import Path

from tumble.store import codec

HERE = Path(__file__).resolve().parent


def encode(case):
    """The bytes of one case of store.json."""
    kind, numbers = case["kind"], {name: exact(value) for name, value in case["numbers"].items()}
    if kind == "set":
        return codec.encode_set(codec.CoefficientSet(**numbers))
    if kind == "entry":
        date, *behind = (numbers[name] for name in ("date_utc_s", "temperature_c", "values", "u"))
        named = (numbers[name] for name in ("number", "sequence", "origin", "estimator", "flags"))
        return sealed(codec._ENTRY.pack(b"THS1", *named, date or 0, behind[0], *behind[1], *behind[2]))
    fingerprint = struct.pack("<I", numbers["fingerprint"])
    if kind == "run":
        return sealed((codec._RUN_HEAD + fingerprint).ljust(60, b"\0"))
    low_c, high_c = numbers["temperature_range_c"] or [codec.COLDEST_C, codec.WARMEST_C]
    margins = math.floor(2 * low_c) + 128, 127 - math.ceil(2 * high_c)  # half degrees from either end
    counts = (numbers["index"], numbers["samples"], *numbers["sums"], *numbers["scatter"])
    return sealed(codec._POSITION.pack(b"TP", *counts, *margins), zlib.crc32(fingerprint))


def sealed(record, before=0):
    return record + struct.pack("<I", zlib.crc32(record, before))


def exact(value):
    """Doubles stand in JSON as the hexadecimal text of their bits' value, 0x1.8p+0, so that nothing is rounded."""
    if isinstance(value, list):
        return [exact(item) for item in value]
    return float.fromhex(value) if isinstance(value, str) and value.lstrip("-").startswith("0x") else value


def cases():
    """Name and case of each golden file."""
    return json.loads((HERE / "store.json").read_text(encoding="utf-8")).items()


def main(arguments):
    if arguments == ["--check"]:
        faults = list(check())
        print("\n".join(faults) or "golden files: all right")
        return 1 if faults else 0
    for name, case in cases():
        (HERE / f"{name}.bin").write_bytes(encode(case))
    return 0


def check():
    """What is wrong with the files, a line each."""
    wanted = {f"{name}.bin": encode(case) for name, case in cases()}
    found = {path.name: path.read_bytes() for path in sorted(HERE.glob("*.bin"))}
    yield from (f"{name} is stale" for name, record in wanted.items() if found.get(name) != record)
    yield from (f"{name} is of no case" for name in found if name not in wanted)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
