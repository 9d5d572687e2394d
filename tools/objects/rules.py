"""What a table may say: its keys, and the rules that an entry must keep."""

from __future__ import annotations

import math
import re
from functools import cache

from headers import OWN
from kinds import Entry, TableError, Type

MAX_BYTES = OWN.value("TUMBLE_MAX_OBJECT_BYTES")
MAX_CONSUMERS = OWN.value("TUMBLE_MAX_CONSUMERS")
PDO_BYTES = 8

HOMES = ("value", "variable", "other", "computed", "communication")
ACCESSES = ("ro", "rw", "wo", "const")
MAPS = (None, "receive", "transmit", "both")
LEVELS = (None, "service")
KINDS = ("var", "array", "record")

# Keys of [[object]] that its subs inherit, and those that only one of the two may have.
SHARED_KEYS = {"type", "access", "home", "map", "unit", "low", "high", "struct", "level", "source"}
OBJECT_KEYS = {"index", "name", "kind", "about", "subs", "count_access", "values", "runs", "modbus", "like", "saved"}
OPTIONAL_ENTRY_KEYS = ("map", "low", "high", "unit", "about", "struct", "member", "source", "apart", "level")
ENTRY_KEYS = SHARED_KEYS | {"name", "value", "about", "member", "size", "apart"}
NODE_KEYS = {
    "name", "id", "prefix", "header", "source", "include", "includes", "eds", "about", "device_name",
    "hardware_version", "device_type", "vendor", "product", "revision", "serial", "heartbeat_ms",
    "consumers", "on_error", "dummies", "service",
}
OPTIONAL_NODE_KEYS = {"includes", "dummies", "service"}
EXTENSION_KEYS = {"prefix", "header", "source", "include", "includes", "title", "only", "eds_without", "about_without"}
# What is not text.
NUMBER = (int, float)
KEY_TYPES = {
    "object": list, "receive_pdo": list, "transmit_pdo": list, "node": dict, "lists": dict, "index": int, "subs": list,
    "saved": bool, "low": NUMBER, "high": NUMBER, "value": (int, float, str), "size": int, "id": int, "includes": list,
    "device_type": int, "vendor": int, "product": int, "revision": int, "serial": int, "heartbeat_ms": int,
    "consumers": list, "on_error": int, "dummies": bool, "cob_id": int, "inhibit_100us": int, "event_ms": int,
    "map": (str, list), "type": (str, int), "runs": bool, "apart": bool, "modbus": dict,
    "like": int, "extension": dict, "number": int, "service": list, "sources": dict,
}
PDO_KEYS = {"about", "cob_id", "type", "inhibit_100us", "event_ms", "map", "level", "number"}


def check(good: bool, where: str, what: str) -> None:
    if not good:
        raise TableError(f"{where}: {what}")


def check_keys(table: object, allowed: set[str], where: str) -> None:
    check(isinstance(table, dict), where, "is not a table")
    unknown = sorted(set(table) - allowed)
    check(not unknown, where, f"unknown key {', '.join(unknown)}")
    for key, value in table.items():
        wanted = KEY_TYPES.get(key, str)
        check(isinstance(value, wanted), where, f"{key} has a value of the wrong type")


@cache
def slug(name: str) -> str:
    """A C identifier from an object's name."""
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")


def check_unique(names: list[str], where: str) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    check(not twice, where, f"the name {', '.join(twice)} is there twice")


def check_names(names: list[str], where: str) -> None:
    """Tools find objects by their names, C by the identifiers made of them; both stand in comments of C."""
    check_unique(names, where)
    for name in names:
        alike = [other for other in names if slug(other) == slug(name)]
        check(slug(name) != "" and name.isprintable(), where, f"the name {name!r} is no identifier of C")
        check(len(alike) == 1, where, f"the names {' and '.join(alike)} are one identifier of C")
        check("*/" not in name and "/*" not in name, where, f"the name {name!r} would end or begin a comment of C")


def text_size(table: dict, kind: Type, value: object, home: str) -> int:
    if not kind.is_text:
        return kind.size
    return table.get("size", len(str(value)) if home == "value" else 0)


def check_entry(entry: Entry, where: str) -> None:
    kind = entry.type
    check(entry.access in ACCESSES, where, f"access is not one of {', '.join(ACCESSES)}")
    check(entry.home in HOMES, where, f"home is not one of {', '.join(HOMES)}")
    check(entry.map in MAPS, where, "map is not receive, transmit or both")
    check(1 <= entry.size <= MAX_BYTES, where, f"its size is not within 1 to {MAX_BYTES} bytes")
    check(entry.home != "value" or entry.value is not None, where, "home value without a value")
    check(entry.home != "computed" or entry.value is None, where, "a computed value has no power-on value")
    has_source = entry.source is not None
    check((entry.home == "computed") == has_source, where, "a computed value, and no other, has a source")
    check(entry.home != "value" or entry.access in ("ro", "const") or entry.index < 0x1000, where,
          "a constant that can be written")
    check(entry.home != "other" or (entry.struct and entry.member), where, "home other needs struct and member")
    check(not entry.map or (entry.size <= PDO_BYTES and not kind.is_text and kind.key != "bool"), where,
          "cannot be mapped into a PDO")
    writable = entry.access in ("rw", "wo")
    check(entry.map not in ("receive", "both") or writable, where, "mapped to receive, not writable")
    check(entry.map not in ("transmit", "both") or entry.access != "wo", where, "mapped to transmit, not readable")
    check(entry.level in LEVELS, where, "level is not service")
    check(not entry.level or writable, where, "has a level, and cannot be written")
    check(
        not entry.level or entry.map not in ("receive", "both"),
        where,
        "has a level that a receive PDO would not ask for",
    )
    check_range(entry, where)


def check_range(entry: Entry, where: str) -> None:
    kind = entry.type
    limited = entry.low is not None or entry.high is not None
    check(not limited or (entry.low is not None and entry.high is not None), where, "needs both low and high")
    check(not limited or not kind.is_text, where, "a text has no limits")
    check(not limited or kind.size < 8 or kind.is_real, where, "64-bit integers have no limits")
    check(not limited or entry.low <= entry.high, where, "low is above high")
    if isinstance(entry.value, str) and entry.value.startswith("$NODEID"):
        return
    if kind.is_text:
        check(entry.value is None or len(str(entry.value).encode()) <= entry.size, where, "its text is too long")
        return
    for number in (value for value in (entry.value, entry.low, entry.high) if value is not None):
        good = isinstance(number, (int, float)) and math.isfinite(number)
        check(good, where, f"{number!r} is not a number")
        if kind.is_integer:
            check(isinstance(number, int) and kind.low <= number <= kind.high, where, f"{number} is not {kind.name}")
    if limited and entry.value is not None:
        check(entry.low <= entry.value <= entry.high, where, "its value is outside its limits")
