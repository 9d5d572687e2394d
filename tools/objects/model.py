"""The object table as the generator sees it: read the TOML files, check them, resolve values and homes.

Every mistake is a TableError whose text names the file, the object and what is wrong.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from pathlib import Path

from kinds import TYPES, TableError, Type
from standard import MAX_MAPPED, dummy_objects, pdo_objects

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

MAX_BYTES = 64  # TUMBLE_MAX_OBJECT_BYTES
MAX_CONSUMERS = 4  # TUMBLE_MAX_CONSUMERS
PDO_BYTES = 8

HOMES = ("value", "variable", "other", "computed", "communication")
ACCESSES = ("ro", "rw", "wo", "const")
MAPS = (None, "receive", "transmit", "both")
KINDS = ("var", "array", "record")

# Keys of [[object]] that its subs inherit, and those that only one of the two may have.
SHARED_KEYS = {"type", "access", "home", "map", "unit", "low", "high", "struct"}
OBJECT_KEYS = {"index", "name", "kind", "about", "subs", "count_access", "values", "runs"}
ENTRY_KEYS = SHARED_KEYS | {"name", "value", "about", "member", "size", "apart"}
NODE_KEYS = {
    "name", "id", "prefix", "header", "source", "include", "includes", "eds", "about", "device_name",
    "hardware_version", "software_version", "device_type", "vendor", "product", "revision", "serial", "heartbeat_ms",
    "consumers", "on_error", "dummies",
}
OPTIONAL_NODE_KEYS = {"includes", "dummies"}
# What is not text.
NUMBER = (int, float)
KEY_TYPES = {
    "object": list, "receive_pdo": list, "transmit_pdo": list, "node": dict, "lists": dict, "index": int, "subs": list,
    "low": NUMBER, "high": NUMBER, "value": (int, float, str), "size": int, "id": int, "includes": list,
    "device_type": int, "vendor": int, "product": int, "revision": int, "serial": int, "heartbeat_ms": int,
    "consumers": list, "on_error": int, "dummies": bool, "cob_id": int, "inhibit_100us": int, "event_ms": int,
    "map": (str, list), "type": (str, int), "runs": bool, "apart": bool,
}
PDO_KEYS = {"cob_id", "type", "inhibit_100us", "event_ms", "map"}


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
    apart: bool = False  # does not follow the entry before it in the struct

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


@dataclass
class Object:
    index: int
    name: str
    kind: str
    about: str
    values: str | None
    entries: list[Entry]
    runs: bool = False  # entries of one type that follow each other do so in the struct as well
    common: bool = False  # of all nodes

    @property
    def is_var(self) -> bool:
        return self.kind == "var"


@dataclass
class Pdo:
    cob_id: int  # as written: without the node's number if that is to be added
    type: int
    inhibit_100us: int
    event_ms: int
    map: list[Entry]


@dataclass
class Node:
    path: Path
    settings: dict
    objects: list[Object]
    receive: list[Pdo]
    transmit: list[Pdo]
    lists: dict[str, list[tuple[str, str]]] = field(default_factory=dict)

    @property
    def id(self) -> int:
        return self.settings["id"]

    @property
    def prefix(self) -> str:
        return self.settings["prefix"]

    @property
    def entries(self) -> list[Entry]:
        return [entry for item in self.objects for entry in item.entries]


def slug(name: str) -> str:
    """A C identifier from an object's name."""
    return re.sub(r"[^a-z0-9]+", "_", name.lower()).strip("_")


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


def check_names(names: list[str], where: str) -> None:
    """Tools find objects by their names."""
    twice = sorted({name for name in names if names.count(name) > 1})
    check(not twice, where, f"the name {', '.join(twice)} is there twice")


def read_toml(path: Path) -> dict:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise TableError(f"{path}: {error.strerror}") from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise TableError(f"{path}: {error}") from error


class NodeReader:
    """Builds one Node from its own file and the objects common to all nodes."""

    def __init__(self, path: Path, common: Path, root: Path):
        self.path = path
        self.root = root
        self.document = read_toml(path)
        self.common = read_toml(common)
        check_keys(self.document, {"node", "object", "receive_pdo", "transmit_pdo", "lists"}, path.name)
        check_keys(self.common, {"object"}, common.name)
        self.settings = self.read_settings()

    def read_settings(self) -> dict:
        where = f"{self.path.name}: [node]"
        settings = self.document.get("node")
        check(isinstance(settings, dict), where, "is missing")
        check_keys(settings, NODE_KEYS, where)
        missing = sorted(NODE_KEYS - OPTIONAL_NODE_KEYS - set(settings))
        check(not missing, where, f"lacks {', '.join(missing)}")
        check(1 <= settings["id"] <= 127, where, "id is not within 1 to 127")
        consumers = settings["consumers"]
        check(len(consumers) <= MAX_CONSUMERS, where, f"more than {MAX_CONSUMERS} consumers")
        pairs = all(isinstance(pair, list) and [type(number) for number in pair] == [int, int] for pair in consumers)
        check(pairs, where, "a consumer is not [node, milliseconds]")
        for number in range(MAX_CONSUMERS):
            watched, time_ms = consumers[number] if number < len(consumers) else (0, 0)
            settings[f"consumer{number + 1}"] = watched << 16 | time_ms
        return settings

    def read(self) -> Node:
        tables = self.common["object"] + self.document.get("object", [])
        if self.settings.get("dummies"):
            tables += dummy_objects()
        receive = [self.read_pdo(table, "receive_pdo") for table in self.document.get("receive_pdo", [])]
        transmit = [self.read_pdo(table, "transmit_pdo") for table in self.document.get("transmit_pdo", [])]
        tables += pdo_objects(receive, 0x1400, False) + pdo_objects(transmit, 0x1800, True)
        objects = sorted((self.read_object(table) for table in tables), key=lambda item: item.index)
        node = Node(self.path, self.settings, objects, [], [])
        indices = [item.index for item in objects]
        for item in objects:
            item.common = item.index in {table.get("index") for table in self.common["object"]}
        for index in indices:
            check(indices.count(index) == 1, self.path.name, f"object {index:04X}h is there twice")
        check_names([item.name for item in objects], self.path.name)
        node.receive = self.resolve_pdos(receive, node, "receive", 0x1600)
        node.transmit = self.resolve_pdos(transmit, node, "transmit", 0x1A00)
        node.lists = {name: read_list(self.root / path, name) for name, path in self.document.get("lists", {}).items()}
        return node

    def read_object(self, table: dict) -> Object:
        index = table.get("index")
        where = f"{self.path.name}: object {index:04X}h" if isinstance(index, int) else f"{self.path.name}: an object"
        check_keys(table, OBJECT_KEYS | ENTRY_KEYS, where)
        check("index" in table and "name" in table, where, "needs index and name")
        kind = table.get("kind", "var")
        check(kind in KINDS, where, f"kind is not one of {', '.join(KINDS)}")
        check(0 < table["index"] <= 0xFFFF, where, "index is out of range")
        item = Object(table["index"], table["name"], kind, table.get("about", ""), table.get("values"), [],
                      table.get("runs", kind == "array"))
        if item.is_var:
            own = {key: value for key, value in table.items() if key in ENTRY_KEYS and key != "about"}
            item.entries.append(self.read_entry(own, item, 0))
        else:
            item.entries = self.read_subs(table, item)
        return item

    def read_subs(self, table: dict, item: Object) -> list[Entry]:
        shared = {key: value for key, value in table.items() if key in SHARED_KEYS}
        subs = table.get("subs", [])
        where = f"{self.path.name}: object {item.index:04X}h"
        check(all(isinstance(sub, dict) for sub in subs), where, "a sub is not a table")
        numbers = [sub.get("sub", position + 1) for position, sub in enumerate(subs)]
        check(subs != [] and numbers == sorted(set(numbers)), where, "its subs are missing or out of order")
        count = {"name": "Highest subindex supported", "type": "u8", "home": "value", "value": numbers[-1]}
        if "count_access" in table:
            count |= {"name": "Number of entries", "home": "communication", "access": table["count_access"], "value": 0}
        entries = [self.read_entry(count, item, 0)]
        for number, sub in zip(numbers, subs):
            own = {key: value for key, value in sub.items() if key != "sub"}
            entries.append(self.read_entry(shared | own, item, number))
        check_names([entry.name for entry in entries], where)
        return entries

    def read_entry(self, table: dict, item: Object, subindex: int) -> Entry:
        where = f"{self.path.name}: object {item.index:04X}h:{subindex}"
        check_keys(table, ENTRY_KEYS, where)
        check("name" in table, where, "needs a name")
        check(table.get("type") in TYPES, where, f"type is not one of {', '.join(TYPES)}")
        kind = TYPES[table["type"]]
        home = table.get("home", "variable")
        value = self.resolve(table.get("value"), where)
        entry = Entry(
            index=item.index,
            subindex=subindex,
            name=table["name"],
            type=kind,
            access=table.get("access", "ro"),
            home=home,
            size=text_size(table, kind, value, home),
            value=value,
            **{key: table[key] for key in ("map", "low", "high", "unit", "about", "struct", "member", "apart") if key in table},
        )
        if entry.home == "variable":
            entry.struct = f"{self.settings['prefix']}_objects_t"
            entry.member = slug(item.name if item.is_var else f"{item.name} {entry.name}")
        if item.kind != "var" and subindex == 0:
            entry.struct = entry.member = None
        check_entry(entry, where)
        return entry

    def resolve(self, value: object, where: str) -> object:
        """ "$key" is a setting of the node; "$NODEID+n" stays for the EDS file."""
        if isinstance(value, str) and value.startswith("$") and not value.startswith("$NODEID"):
            check(value[1:] in self.settings, where, f"no setting {value[1:]} in [node]")
            value = self.settings[value[1:]]
        return value

    def read_pdo(self, table: dict, name: str) -> dict:
        where = f"{self.path.name}: [[{name}]]"
        check_keys(table, PDO_KEYS, where)
        check({"cob_id", "type", "map"} <= set(table), where, "needs cob_id, type and map")
        check(all(isinstance(key, int) for key in table["map"]), where, "maps what is not a number")
        check(table["type"] in (254, 255), where, "type is neither 254 nor 255: only event-driven PDOs are there")
        check(len(table["map"]) <= MAX_MAPPED, where, f"maps more than {MAX_MAPPED} objects")
        return table

    def resolve_pdos(self, tables: list[dict], node: Node, direction: str, mapping: int) -> list[Pdo]:
        """The PDOs with the entries that they map; their mapping objects get the same as power-on values."""
        by_key = {entry.key: entry for entry in node.entries}
        pdos = []
        for number, table in enumerate(tables):
            where = f"{self.path.name}: {direction} PDO {number + 1}"
            for key in table["map"]:
                check(key in by_key, where, f"maps {key >> 8:04X}h:{key & 0xFF}, which does not exist")
                check(by_key[key].map in (direction, "both"), where, f"may not map {by_key[key].where}")
            mapped = [by_key[key] for key in table["map"]]
            check(sum(entry.size for entry in mapped) <= PDO_BYTES, where, f"maps more than {PDO_BYTES} bytes")
            by_key[mapping + number << 8].value = len(mapped)
            for slot, entry in enumerate(mapped):
                by_key[mapping + number << 8 | slot + 1].value = entry.map_value
            pdos.append(Pdo(table["cob_id"], table["type"], table.get("inhibit_100us", 0), table.get("event_ms", 0),
                            mapped))
        return pdos


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
    check(entry.home != "value" or entry.access in ("ro", "const") or entry.index < 0x1000, where,
          "a constant that can be written")
    check(entry.home != "other" or (entry.struct and entry.member), where, "home other needs struct and member")
    check(not entry.map or (entry.size <= PDO_BYTES and not kind.is_text and kind.key != "bool"), where,
          "cannot be mapped into a PDO")
    writable = entry.access in ("rw", "wo")
    check(entry.map not in ("receive", "both") or writable, where, "mapped to receive, not writable")
    check(entry.map not in ("transmit", "both") or entry.access != "wo", where, "mapped to transmit, not readable")
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


def read_list(path: Path, name: str) -> list[tuple[str, str]]:
    """The (name, sentence) pairs of an X-macro list in a header."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise TableError(f"{path}: {error.strerror}") from error
    body = re.search(rf"#define {name}_LIST\(X\)(.*?)\n\n", text, re.DOTALL)
    check(body is not None, str(path), f"no list {name}_LIST")
    return re.findall(rf'X\(({name}_\w+), "([^"]*)"\)', body.group(1))
