"""The register map of docs/modbus.csv: where values stand, how they are packed, and how fine they are."""

from __future__ import annotations

import csv
import functools
import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tumble import data
from tumble.client.link import Value
from tumble.errors import BadInput

MOST_WORDS = 125  # of one request
_FORMS = {"u16": ">H", "i16": ">h", "u32": ">I", "i32": ">i", "f32": ">f", "u64": ">Q", "i64": ">q", "f64": ">d"}
_SINGLE_BITS, _SINGLE_LEAST = 24, -149  # of an f32: bits of its fraction, exponent of the least number


@dataclass(frozen=True)
class Register:
    """One row: `words` registers from `at` on; `valid`: register and bit that say whether there is a value."""

    at: int
    words: int
    type: str
    scale: float | None
    valid: tuple[int, int] | None

    def number(self, words: Sequence[int]) -> int | float | str:
        """From registers, the high word first."""
        packed = struct.pack(f">{len(words)}H", *words)
        if self.type == "text":
            return packed.rstrip(b"\0").decode("latin-1")
        number: int | float = struct.unpack(_FORMS[self.type], packed)[0]
        return number if self.scale is None else number * self.scale

    def pack(self, value: float) -> list[int]:
        """Into registers."""
        number = value if self.type in ("f32", "f64") else round(value / (self.scale or 1.0))
        return list(struct.unpack(f">{self.words}H", struct.pack(_FORMS[self.type], number)))

    def step(self, value: float) -> float:
        """Between two neighbouring numbers about a value; 0 where every number that there is can be told."""
        if self.type != "f32":
            return self.scale or 0.0
        return math.ldexp(1.0, max(math.frexp(value)[1] - _SINGLE_BITS, _SINGLE_LEAST)) if value else 2.0**_SINGLE_LEAST

    @property
    def needs(self) -> list[tuple[int, int]]:
        """(first register, how many) of all that must be read to know the value."""
        return [(self.at, self.words)] + ([] if self.valid is None else [(self.valid[0], 1)])


@dataclass(frozen=True)
class RegisterMap:
    """By name: `input`: the registers of a value, which may be there in floating point and scaled; `holding`; numbers
    of `settings`."""

    input: dict[str, list[Register]]
    holding: dict[str, Register]
    settings: dict[str, int]


@functools.cache
def read_map(file: Path | None = None) -> RegisterMap:
    """`file`: None: the one that comes with the package. Raises BadInput."""
    found, objects = RegisterMap({}, {}, {}), dict[tuple[str, str], str]()
    path = file or data.file("docs/modbus.csv")
    try:
        with open(path, encoding="utf-8", newline="") as lines:
            for row in csv.DictReader(lines):
                _take(found, objects, row)
    except (OSError, KeyError, ValueError) as error:
        raise BadInput(f"no register map: {error}", path) from None
    return found


def _take(found: RegisterMap, objects: dict[tuple[str, str], str], row: Mapping[str, str]) -> None:
    """Registers of one object go by the name of the first of them."""
    name, at = row["name"], int(row["register"])
    if row["table"] == "setting":
        found.settings[name] = at
        return
    valid = (int(row["valid_register"]), int(row["valid_bit"])) if row["valid_register"] else None
    scale = float(row["scale"]) if row["scale"] else None
    register = Register(at, int(row["words"]), row["type"], scale, valid)
    if row["table"] == "holding":
        found.holding[name] = register
    else:
        name = objects.setdefault((row["index"], row["subindex"]), name) if row["index"] else name
        found.input.setdefault(name, []).append(register)


def requests(wanted: Sequence[Register]) -> list[tuple[int, int]]:
    """(first register, how many) of as few requests as read all of them, upwards."""
    made: list[tuple[int, int]] = []
    for at, words in sorted(need for register in wanted for need in register.needs):
        if made and at + words - made[-1][0] <= MOST_WORDS:
            made[-1] = made[-1][0], max(made[-1][1], at + words - made[-1][0])
        else:
            made.append((at, words))
    return made


def finest(found: Sequence[Register], words: Mapping[int, int]) -> Value:
    """The value of registers of one name, from the one that resolves most of those that are valid; None: none is."""
    best: tuple[float, Value] = (math.inf, None)
    for register in found:
        if register.valid is None or words[register.valid[0]] >> register.valid[1] & 1:
            value = register.number([words[register.at + place] for place in range(register.words)])
            step = register.step(value) if len(found) > 1 and not isinstance(value, str) else 0.0
            best = min(best, (step, value), key=lambda one: one[0])
    return best[1]
