"""The object table as the generator sees it: read the TOML files, check them, resolve values and homes.

Every mistake is a TableError whose text names the file, the object and what is wrong.
"""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass, field
from pathlib import Path

from headers import headers_of
from kinds import TYPES, Entry, TableError
from rules import (
    ENTRY_KEYS,
    EXTENSION_KEYS,
    KINDS,
    MAX_CONSUMERS,
    NODE_KEYS,
    OBJECT_KEYS,
    OPTIONAL_ENTRY_KEYS,
    OPTIONAL_NODE_KEYS,
    PDO_BYTES,
    PDO_KEYS,
    SHARED_KEYS,
    check,
    check_entry,
    check_keys,
    check_names,
    slug,
    text_size,
)
from standard import MAX_MAPPED, PDO_INVALID, dummy_objects, pdo_objects

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

VERSION = "VERSION"


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
    modbus: dict = field(default_factory=dict)  # where its registers are: see registers.py
    like: int = 0  # the object that this one is laid out as, if their values are told apart by the index alone
    further: bool = False  # of the node's extension
    saved: bool = False  # 1010h keeps its values

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
    further: bool = False  # of the node's extension; without that it is not in use


@dataclass
class Node:
    path: Path
    settings: dict
    objects: list[Object]
    receive: list[Pdo]
    transmit: list[Pdo]
    lists: dict[str, list[tuple[str, str]]] = field(default_factory=dict)
    sources: dict[str, str] = field(default_factory=dict)  # of computed values: what each is
    extension: dict = field(default_factory=dict)  # settings of the table behind the first; none: no such table

    @property
    def id(self) -> int:
        return self.settings["id"]

    @property
    def prefix(self) -> str:
        return self.settings["prefix"]

    @property
    def entries(self) -> list[Entry]:
        return [entry for item in self.objects for entry in item.entries]


def expanded(tables: list[dict]) -> list[dict]:
    """An object that is `like` another has all that it does not say itself from that one."""
    by_index = {table["index"]: table for table in tables if isinstance(table.get("index"), int)}
    for table in tables:
        check("like" not in table or table["like"] in by_index, f"object {table.get('index')}", "is like none")
    return [{key: value for key, value in by_index.get(table.get("like"), {}).items() if key != "modbus"} | table
            for table in tables]


def elements(sub: dict, where: str) -> list[dict]:
    """Of a sub that is a `matrix` or a `vector` a sub for each element, by rows: in `member` {i} and {j} stand for row
    and column, {n} for the number from `first` on. Any other sub as it is."""
    shape = next((key for key in ("matrix", "vector") if key in sub), None)
    if shape is None:
        return [sub]
    first = sub.get("first", 0)
    check(isinstance(sub[shape], str) and isinstance(sub.get("member"), str) and isinstance(first, int), where,
          f"a {shape} is a name with a member")
    rest = {key: value for key, value in sub.items() if key not in (shape, "first")}
    places = list(itertools.product(range(3), repeat=2 if shape == "matrix" else 1))
    return [rest | {"name": f"{sub[shape]}{''.join('xyz'[axis] for axis in place)}",
                    "member": sub["member"].format(n=first + number, i=place[0], j=place[-1])}
            for number, place in enumerate(places)]


def read_toml(path: Path) -> dict:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise TableError(f"{path}: {error.strerror}") from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise TableError(f"{path}: {error}") from error


def read_version(root: Path) -> str:
    """The one version of everything, from the file VERSION."""
    try:
        text = (root / VERSION).read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError) as error:
        raise TableError(f"{VERSION}: {error}") from error
    check(re.fullmatch(r"\d+\.\d+\.\d+\n", text) is not None, VERSION, "is not one line MAJOR.MINOR.PATCH")
    return text.strip()


class NodeReader:
    """Builds one Node from its own file, the objects common to all nodes, and its extension's file if it has one."""

    def __init__(self, path: Path, common: Path, root: Path, extension: Path | None = None):
        self.path = path
        self.file = path.name  # whose objects are being read
        self.root = root
        headers = headers_of(root)
        self.document, self.common, self.further = (
            headers.resolve(read_toml(table)) if table else {} for table in (path, common, extension))
        check_keys(self.document, {"node", "object", "receive_pdo", "transmit_pdo", "lists", "sources"}, path.name)
        check_keys(self.common, {"object"}, common.name)
        self.sources = self.document.get("sources", {})  # of the file whose objects are being read
        self.settings = self.read_settings()
        if extension:
            where = f"{extension.name}: [extension]"
            check_keys(self.further, {"extension", "object", "transmit_pdo", "lists", "sources"}, extension.name)
            check_keys(self.further.get("extension"), EXTENSION_KEYS, where)
            missing = sorted(EXTENSION_KEYS - set(self.further["extension"]))
            check(not missing, where, f"lacks {', '.join(missing)}")
            self.further["extension"]["table"] = extension.name

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
        settings["software_version"] = read_version(self.root)
        return settings

    def read(self) -> Node:
        pdos = self.document.get("transmit_pdo", [])
        receive = [self.read_pdo(table, "receive_pdo") for table in self.document.get("receive_pdo", [])]
        own = [self.read_pdo(table, "transmit_pdo") for table in pdos]
        transmit = self.with_further_pdos(own)
        tables = self.common_objects() + self.document.get("object", [])
        tables += dummy_objects() if self.settings.get("dummies") else []
        tables += pdo_objects(receive, 0x1400, False) + pdo_objects(transmit, 0x1800, True)
        objects = [self.read_object(table) for table in expanded(tables)]
        self.file = self.further.get("extension", {}).get("table", self.file)
        self.sources = self.further.get("sources", {})
        for table in expanded(self.further.get("object", [])):
            objects.append(self.read_object(table))
            objects[-1].further = True
        return self.join(objects, receive, transmit)

    def common_objects(self) -> list[dict]:
        """Some nodes let them be written at service level only."""
        tables = self.common["object"]
        kept = set(self.settings.get("service", []))
        check(
            kept <= {table.get("index") for table in tables},
            f"{self.path.name}: [node]",
            "service names no common object",
        )
        return [table | {"level": "service"} if table["index"] in kept else table for table in tables]

    def with_further_pdos(self, own: list[dict]) -> list[dict]:
        """The extension's in the places that the node keeps free for them."""
        transmit = list(own)
        for table in self.further.get("transmit_pdo", []):
            where = f"{self.further['extension']['table']}: [[transmit_pdo]]"
            number = self.read_pdo(table, "transmit_pdo").get("number", 0) - 1
            check(0 <= number < len(own) and own[number]["cob_id"] & PDO_INVALID != 0, where,
                  "its number is not that of a PDO that the node leaves unused")
            transmit[number] = table | {"further": True}
        return transmit

    def join(self, objects: list[Object], receive: list[dict], transmit: list[dict]) -> Node:
        """Check what only all objects together can tell, and resolve the PDOs."""
        node = Node(self.path, self.settings, sorted(objects, key=lambda item: item.index), [], [],
                    extension=self.further.get("extension", {}))
        indices = [item.index for item in node.objects]
        for item in node.objects:
            item.common = item.index in {table.get("index") for table in self.common["object"]}
            check(indices.count(item.index) == 1, self.path.name, f"object {item.index:04X}h is there twice")
            for entry in item.entries:
                check(not item.further or entry.home in ("value", "computed", "communication"), self.path.name,
                      f"object {item.index:04X}h: an extension has no variables of its own")
        check_names([item.name for item in node.objects], self.path.name)
        node.receive = self.resolve_pdos(receive, node, "receive", 0x1600)
        node.transmit = self.resolve_pdos(transmit, node, "transmit", 0x1A00)
        lists = self.document.get("lists", {}) | self.further.get("lists", {})
        node.sources = self.used_sources(node, self.document.get("sources", {}), further=False)
        node.extension = node.extension and node.extension | {
            "sources": self.used_sources(node, self.further.get("sources", {}), further=True)}
        node.lists = {name: read_list(self.root / path, name) for name, path in lists.items()}
        return node

    def used_sources(self, node: Node, sources: dict, further: bool) -> dict:
        used = {entry.source for item in node.objects if item.further == further for entry in item.entries}
        unused = sorted(set(sources) - used)
        check(not unused, self.path.name, f"no value comes from the source {', '.join(unused)}")
        return sources

    def read_object(self, table: dict) -> Object:
        index = table.get("index")
        where = f"{self.file}: object {index:04X}h" if isinstance(index, int) else f"{self.file}: an object"
        kind = table.get("kind", "var")
        check_keys(table, OBJECT_KEYS | (ENTRY_KEYS if kind == "var" else SHARED_KEYS), where)
        check("index" in table and "name" in table, where, "needs index and name")
        check(kind in KINDS, where, f"kind is not one of {', '.join(KINDS)}")
        check(0 < table["index"] <= 0xFFFF, where, "index is out of range")
        item = Object(table["index"], table["name"], kind, table.get("about", ""), table.get("values"), [],
                      table.get("runs", kind == "array"), modbus=table.get("modbus", {}), like=table.get("like", 0),
                      saved=table.get("saved", False))
        if item.is_var:
            own = {key: value for key, value in table.items() if key in ENTRY_KEYS and key != "about"}
            item.entries.append(self.read_entry(own, item, 0))
        else:
            item.entries = self.read_subs(table, item)
        return item

    def read_subs(self, table: dict, item: Object) -> list[Entry]:
        shared = {key: value for key, value in table.items() if key in SHARED_KEYS}
        where = f"{self.file}: object {item.index:04X}h"
        check(all(isinstance(sub, dict) for sub in table.get("subs", [])), where, "a sub is not a table")
        subs = [one for sub in table.get("subs", []) for one in elements(sub, where)]
        numbers = [sub.get("sub", position + 1) for position, sub in enumerate(subs)]
        check(subs != [] and numbers == sorted(set(numbers)), where, "its subs are missing or out of order")
        count = {"name": "Highest subindex supported", "type": "u8", "home": "value", "value": numbers[-1]}
        if "count_access" in table:
            count |= {"name": "Number of entries", "home": "communication", "access": table["count_access"], "value": 0}
            count |= {key: table[key] for key in ("level",) if key in table}
        entries = [self.read_entry(count, item, 0)]
        for number, sub in zip(numbers, subs):
            own = {key: value for key, value in sub.items() if key != "sub"}
            entries.append(self.read_entry(shared | own, item, number))
        check_names([entry.name for entry in entries], where)
        return entries

    def read_entry(self, table: dict, item: Object, subindex: int) -> Entry:
        where = f"{self.file}: object {item.index:04X}h:{subindex}"
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
            **{key: table[key] for key in OPTIONAL_ENTRY_KEYS if key in table},
        )
        if entry.home == "variable":
            entry.struct = f"{self.settings['prefix']}_objects_t"
            entry.member = slug(item.name if item.is_var else f"{item.name} {entry.name}")
        if entry.access not in ("rw", "wo"):
            entry.level = None  # given for its object: there is nothing to be written here
        if entry.home != "computed":
            entry.source = None  # given for its object
        if item.kind != "var" and subindex == 0:
            entry.struct = entry.member = None
        check_entry(entry, where)
        check(entry.source in (None, *self.sources), where, f"its source {entry.source} is not in [sources]")
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
                            mapped, table.get("further", False)))
        return pdos


def read_list(path: Path, name: str) -> list[tuple[str, str]]:
    """The (name, sentence) pairs of an X-macro list in a header."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise TableError(f"{path}: {error.strerror}") from error
    body = re.search(rf"#define {name}_LIST\(X\)(.*?)\n\n", text, re.DOTALL)
    check(body is not None, str(path), f"no list {name}_LIST")
    return re.findall(rf'X\(({name}_\w+), "([^"]*)"\)', body.group(1))
