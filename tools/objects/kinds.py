"""The data types of an object, an entry of the dictionary, and the error for a mistake in the table."""

from __future__ import annotations

from dataclasses import dataclass


class TableError(Exception):
    """A mistake in the table; one line for a person."""


@dataclass(frozen=True)
class Type:
    """A data type: its name in the tables, CiA 301 code and name, C type, bytes (0: a string's own)."""

    key: str
    code: int
    name: str
    c_type: str
    size: int
    low: int | None = None
    high: int | None = None

    @property
    def is_integer(self) -> bool:
        return self.low is not None

    @property
    def is_real(self) -> bool:
        return self.key in ("f32", "f64")

    @property
    def is_text(self) -> bool:
        return self.key == "text"


TYPES = {
    kind.key: kind
    for kind in (
        Type("bool", 0x01, "BOOLEAN", "bool", 1, 0, 1),
        Type("i8", 0x02, "INTEGER8", "int8_t", 1, -(1 << 7), (1 << 7) - 1),
        Type("i16", 0x03, "INTEGER16", "int16_t", 2, -(1 << 15), (1 << 15) - 1),
        Type("i32", 0x04, "INTEGER32", "int32_t", 4, -(1 << 31), (1 << 31) - 1),
        Type("u8", 0x05, "UNSIGNED8", "uint8_t", 1, 0, (1 << 8) - 1),
        Type("u16", 0x06, "UNSIGNED16", "uint16_t", 2, 0, (1 << 16) - 1),
        Type("u32", 0x07, "UNSIGNED32", "uint32_t", 4, 0, (1 << 32) - 1),
        Type("f32", 0x08, "REAL32", "float", 4),
        Type("text", 0x09, "VISIBLE_STRING", "char", 0),
        Type("f64", 0x11, "REAL64", "double", 8),
        Type("i64", 0x15, "INTEGER64", "int64_t", 8, -(1 << 63), (1 << 63) - 1),
        Type("u64", 0x1B, "UNSIGNED64", "uint64_t", 8, 0, (1 << 64) - 1),
    )
}


@dataclass
class Entry:
    """One (index, subindex) of the dictionary."""

    index: int
    subindex: int
    name: str
    type: Type
    access: str
    home: str
    size: int
    map: str | None = None
    value: object = None  # power-on value; for home "value" the value
    low: float | int | None = None
    high: float | int | None = None
    unit: str = ""
    about: str = ""
    struct: str | None = None
    member: str | None = None
    source: str | None = None  # of a computed value: where it comes from
    apart: bool = False  # does not follow the entry before it in the struct
    level: str | None = None  # at which it can be written from outside; none: at any

    @property
    def key(self) -> int:
        return self.index << 8 | self.subindex

    @property
    def where(self) -> str:
        return f"{self.index:04X}h:{self.subindex}"

    @property
    def map_value(self) -> int:
        """As a mapping object holds it: index, subindex, bits."""
        return self.key << 8 | self.size * 8
