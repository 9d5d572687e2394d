"""The Modbus registers of tumble-gateway: those of node 1's objects (their key `modbus`) and its own (gateway.toml)."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinds import Entry
from model import Node, Object, read_toml
from rules import check, check_unique, slug

LAST, VALIDITY_BITS = 0xFFFF, 16  # the last register's number; bits of one
SERVICE_KEY = 0x2006_01
OF_SCALED = " (scaled)"  # behind the name of a number that is there in floating point as well
COLUMNS = 120
MODBUS_KEYS = {"at", "scaled_at", "scale", "marks", "command", "kept", "keys", "with", "settings", "more"}
OWN_KEYS = {"at", "name", "type", "about", "unit", "access", "scale"}
OWN_TYPES = ("u16", "u32", "i32", "f32", "f64")
ALWAYS, KEPT = 0, 1  # groups of values: read in every poll; kept until a mark changes. Others have numbers above.
SETTING_TYPES = ("u8", "u16", "u32", "u64", "i8", "i16", "i32", "i64", "f32", "f64")

# Form of a value in registers: number of words (0: the text's own), words for a person.
WORD, LONG, QUAD, FLOAT, SCALED, TEXT = "WORD", "LONG", "QUAD", "FLOAT", "SCALED", "TEXT"
WORDS = {WORD: 1, LONG: 2, QUAD: 4, FLOAT: 2, SCALED: 2}
FORMS = {
    "bool": (WORD, "u16"), "u8": (WORD, "u16"), "u16": (WORD, "u16"), "i8": (WORD, "i16"), "i16": (WORD, "i16"),
    "u32": (LONG, "u32"), "i32": (LONG, "i32"), "u64": (QUAD, "u64"), "i64": (QUAD, "i64"),
    "f32": (FLOAT, "f32"), "f64": (FLOAT, "f32"), "text": (TEXT, "text"),
}


@dataclass
class Register:
    """One value in registers, or the validity of a group."""

    table: str  # "input" or "holding"
    at: int
    words: int
    type: str  # for a person: u16, i16, u32, i32, u64, i64, f32, text
    name: str
    unit: str = ""
    about: str = ""
    access: str = "ro"
    scale: float | None = None  # of one unit of an integer
    form: str = ""
    entry: Entry | None = None
    validity: int | None = None
    bit: int | None = None
    group: int = ALWAYS  # what is read anew together
    is_key: bool = False  # read in every poll: tells that its group is to be read anew

    @property
    def end(self) -> int:
        return self.at + self.words

    @property
    def place(self) -> str:
        return str(self.at) if self.words == 1 else f"{self.at}-{self.end - 1}"


@dataclass
class Setting:
    """An object that may be written by number."""

    number: int
    entry: Entry
    name: str
    group: int  # read anew once it has been written


@dataclass
class Map:
    version: int
    input: list[Register]
    holding: list[Register]
    counters_at: int
    counters: list[Register]
    commands: list[Object]
    marks: list[Entry]
    gateway: int  # registers below are the gateway's own
    settings: list[Setting]
    groups: int  # how many there are

    @property
    def values(self) -> list[Register]:
        """Those that come from the node, those of one object together, so that it is read once; groups that have keys
        one behind the other, each with its keys first."""
        mine = [register for register in self.input if register.entry]
        return sorted(mine, key=lambda one: (max(one.group, KEPT), not one.is_key, one.entry.key, one.at))

    @property
    def service_key(self) -> Setting:
        """What opens the service level."""
        return next(one for one in self.settings if one.entry.key == SERVICE_KEY)

    @property
    def keys(self) -> list[Entry]:
        """In the order in which they are read."""
        return list({one.entry.key: one.entry for one in self.values if one.is_key}.values())

    def selector(self, group: int) -> Entry | None:
        """The first key of a group."""
        return next((one.entry for one in self.values if one.is_key and one.group == group), None)


def read(path: Path, node: Node) -> Map:
    document = read_toml(path)
    where = path.name
    wanted = {"map_version", "common", "input", "counters", "holding"}
    check(set(document) == wanted, where, f"must hold {', '.join(sorted(wanted))} and nothing else")
    objects = {item.index: item for item in node.objects}
    for table in document["common"]:
        check(table.get("index") in objects, where, f"no object {table.get('index')}")
        objects[table["index"]].modbus = table["modbus"]
    own = [own_register(table, "input", where) for table in document["input"]]
    counters = counter_registers(document["counters"])
    mapped = [item for item in node.objects if item.modbus]
    numbers = group_numbers(mapped, node.path.name)
    groups = [register for item in mapped
              for register in group(item, numbers, f"{node.path.name}: object {item.index:04X}h")]
    holding = [own_register(table, "holding", where) for table in document["holding"]]
    made = Map(document["map_version"], in_order([*own, *counters, *groups]), in_order(holding),
               document["counters"]["at"], counters, command_objects(mapped, node),
               [entry for item in mapped for entry in marks(item)], max(r.end for r in [*own, *counters]),
               settings(mapped, numbers, node.path.name), 1 + max([KEPT, *numbers.values()]))
    check(min(register.at for register in groups) >= made.gateway, where, "an object lies among the gateway's own")
    check(any(one.entry.key == SERVICE_KEY for one in made.settings), where, "no setting opens the service level")
    return made


def own_register(table: dict, name: str, where: str) -> Register:
    check({"at", "name", "type"} <= set(table) <= OWN_KEYS, where, f"a register with wrong keys: {table}")
    check(table["type"] in OWN_TYPES, where, f"{table['name']}: type is not one of {', '.join(OWN_TYPES)}")
    words, type_name = (4, "f64") if table["type"] == "f64" else own_form(table["type"])
    return Register(name, table["at"], words, type_name, table["name"], table.get("unit", ""),
                    table.get("about", ""), table.get("access", "ro"), table.get("scale"))


def own_form(key: str) -> tuple[int, str]:
    form, type_name = FORMS[key]
    return WORDS[form], type_name


def counter_registers(table: dict) -> list[Register]:
    return [Register("input", table["at"] + 2 * place, 2, "u32", name, "", about)
            for place, (name, about) in enumerate(table["names"])]


def group_numbers(items: list[Object], file: str) -> dict[int, int]:
    """{index of an object: number of its group}, of those that have `keys`, and of those `with` them."""
    leaders = [item.index for item in items if "keys" in item.modbus]
    numbers = {index: KEPT + 1 + place for place, index in enumerate(leaders)}
    for item in items:
        if "with" in item.modbus:
            where = f"{file}: object {item.index:04X}h"
            check(item.modbus["with"] in leaders, where, "modbus: with an object that has no keys")
            numbers[item.index] = numbers[item.modbus["with"]]
    return numbers


def group(item: Object, numbers: dict[int, int], where: str) -> list[Register]:
    """Validity, then the values of an object one after the other; and the same again as scaled integers."""
    keys = item.modbus
    check(set(keys) <= MODBUS_KEYS, where, f"modbus may have the keys {', '.join(sorted(MODBUS_KEYS))}")
    if "command" in keys:
        check(set(keys) == {"command"}, where, "a command object has no other registers")
        return []
    if set(keys) == {"settings"}:
        return []
    check("at" in keys, where, "modbus needs at")
    check(len({"keys", "with", "kept"} & set(keys)) < 2, where, "modbus: has two of keys, with and kept")
    check(("scaled_at" in keys) == ("scale" in keys), where, "modbus needs both scaled_at and scale, or neither")
    readable = [entry for entry in item.entries if entry.access != "wo" and (item.is_var or entry.subindex)]
    check(0 < len(readable) <= VALIDITY_BITS, where, f"modbus: not 1 to {VALIDITY_BITS} values that can be read")
    check(set(keys.get("keys", [])) <= {entry.subindex for entry in readable}, where, "modbus: a key does not exist")
    number = numbers.get(item.index, KEPT if keys.get("kept") else ALWAYS)
    first, more_at = keys.get("more", (LAST, 0))
    made = block(item, [entry for entry in readable if entry.subindex < first], keys["at"], None, number)
    if "more" in keys:
        made += block(item, [entry for entry in readable if entry.subindex >= first], more_at, None, number, ", more")
    if "scaled_at" in keys:
        check(keys["scale"] > 0, where, "modbus: scale is not above 0")
        made += block(item, readable, keys["scaled_at"], keys["scale"], number)
    return made


def block(item: Object, entries: list[Entry], at: int, scale: float | None, number: int,
          also: str = "") -> list[Register]:
    about = "Bit n: the value of place n below is there." if scale is None else "As for the numbers in floating point."
    title = item.name + also if scale is None else f"{item.name}, scaled"
    made = [Register("input", at, 1, "u16", f"{title}: valid", about=about)]
    for bit, entry in enumerate(entries):
        if scale is not None and not entry.type.is_real:
            continue
        form, type_name = FORMS[entry.type.key] if scale is None else (SCALED, "i32")
        words = WORDS.get(form) or (entry.size + 1) // 2
        name = full_name(item, entry) + ("" if scale is None else OF_SCALED)
        made.append(Register("input", made[-1].end, words, type_name, name, entry.unit, entry.about,
                             scale=scale, form=form, entry=entry, validity=at, bit=bit, group=number,
                             is_key=entry.subindex in item.modbus.get("keys", [])))
    return made


def full_name(item: Object, entry: Entry) -> str:
    return entry.name if item.is_var else f"{item.name}: {entry.name}"


def settings(items: list[Object], numbers: dict[int, int], file: str) -> list[Setting]:
    """What can be written of the objects that say so; the number that they give is that of subindex 1."""
    made = []
    for item in (item for item in items if "settings" in item.modbus):
        where = f"{file}: object {item.index:04X}h"
        writable = [entry for entry in item.entries if entry.subindex and entry.access in ("rw", "wo")]
        check(writable != [], where, "modbus: settings, and nothing can be written")
        check(all(entry.type.key in SETTING_TYPES for entry in writable), where, "modbus: a setting is no number")
        made += [Setting(item.modbus["settings"] + entry.subindex - 1, entry, full_name(item, entry),
                         numbers.get(item.index, ALWAYS)) for entry in writable]
    made.sort(key=lambda setting: setting.number)
    for before, after in itertools.pairwise(made):
        check(before.number < after.number, file, f"{before.name!r} and {after.name!r} are setting {after.number}")
    check(not made or 0 < made[0].number <= made[-1].number <= LAST, file, f"settings are not within 1 to {LAST}")
    return made


def in_order(registers: list[Register]) -> list[Register]:
    ordered = sorted(registers, key=lambda register: register.at)
    for before, after in itertools.pairwise(ordered):
        check(before.end <= after.at, "Modbus map", f"{before.name!r} and {after.name!r} overlap at {after.at}")
    check(ordered[-1].end <= LAST, "Modbus map", f"ends beyond {LAST}")
    check_unique([register.name for register in ordered], f"Modbus map, {ordered[0].table} registers")
    return ordered


def command_objects(items: list[Object], node: Node) -> list[Object]:
    """In the order of their numbers; each has its argument at subindex 1 and its command at subindex 2, as u8, and may
    have an angle at subindex 3, as f64, and the name of a proposal at subindex 4, as u32."""
    found = sorted((item for item in items if "command" in item.modbus), key=lambda item: item.modbus["command"])
    where = f"{node.path.name}: command objects"
    check([item.modbus["command"] for item in found] == list(range(len(found))), where, "are not numbered from 0 on")
    for item in found:
        types = [entry.type.key for entry in item.entries[1:]]
        check(types in (["u8", "u8"], ["u8", "u8", "f64"], ["u8", "u8", "f64", "u32"]), where,
              f"{item.index:04X}h is not u8, u8, and maybe f64 and u32")
    check(found != [], where, "there is none")
    return found


def marks(item: Object) -> list[Entry]:
    """Values that tell by a change that the results, and whatever else is kept, are others."""
    by_subindex = {entry.subindex: entry for entry in item.entries}
    wanted = item.modbus.get("marks", [])
    check(set(wanted) <= set(by_subindex), f"object {item.index:04X}h", "modbus: marks what does not exist")
    check(all(by_subindex[sub].size <= 8 for sub in wanted), f"object {item.index:04X}h", "modbus: a mark is too long")
    return [by_subindex[sub] for sub in wanted]


NOTICE = "Written by tools/objects/generate from the tables beside it: change them there."


def macro(register: Register) -> str:
    return slug(register.name).upper()


def header(registers: Map) -> str:
    """The numbers of the gateway's own registers."""
    own = [register for register in registers.input if register.at < registers.counters_at]
    width = max(register.end for register in registers.input)
    lines = [
        f"/* {NOTICE} */",
        "#ifndef TUMBLE_GATEWAY_REGISTER_MAP_H",
        "#define TUMBLE_GATEWAY_REGISTER_MAP_H",
        "",
        f"#define GATEWAY_MAP_VERSION {registers.version}U",
        "",
        "/* Input registers; the gateway's own are those below GATEWAY_OWN_END. */",
        *(f"#define GATEWAY_INPUT_{macro(register)} {register.at}U" for register in own),
        f"#define GATEWAY_INPUT_COUNTERS {registers.counters_at}U",
        f"#define GATEWAY_OWN_END {registers.gateway}U",
        f"#define GATEWAY_INPUT_END {width}U",
        "",
        "/* Holding registers. */",
        *(f"#define GATEWAY_HOLDING_{macro(register)} {register.at}U" for register in registers.holding),
        f"#define GATEWAY_HOLDING_END {registers.holding[-1].end}U",
        "",
        "/* Counters: two registers each. */",
        "enum {",
        *(f"    GATEWAY_COUNT_{macro(register)}," for register in registers.counters),
        "    GATEWAY_COUNTERS",
        "};",
        "",
        f"#define GATEWAY_VALUES {len({one.entry.key for one in registers.values})}U",
        f"#define GATEWAY_MARKS {len(registers.marks)}U",
        f"#define GATEWAY_KEYS {len(registers.keys)}U",
        f"#define GATEWAY_GROUPS {registers.groups}U",
        f"#define GATEWAY_TARGETS {len(registers.settings)}U",
        f"#define GATEWAY_TARGET_RUNS {len(in_rows(registers.settings, setting_row))}U",
        f"#define GATEWAY_COMMAND_OBJECTS {len(registers.commands)}U",
        "",
        "/* The setting that opens the service level. */",
        f"#define GATEWAY_SERVICE_KEY {registers.service_key.number}U",
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


RUN_MACROS = [
    "/* Values in a row: V(how many, register, register and bit of their validity, index, subindex, type, bytes,",
    " * group, key); S(..., register scaled, that of their validity, scale) are there as scaled integers, too.",
    " * Settings in a row: T(how many, number, index, subindex, type, bytes, group, at service level only). */",
    "#define V(count, at, validity, bit, index, subindex, type, size, group, key) \\",
    "    {count, {at, validity, bit, index, subindex, TUMBLE_TYPE_##type, size, group, key, 0, 0, 0.0}}",
    "#define S(count, at, validity, bit, index, subindex, type, size, group, key, scaled_at, scaled_validity, unit) \\",
    "    {count, {at, validity, bit, index, subindex, TUMBLE_TYPE_##type, size, group, key, scaled_at, \\",
    "             scaled_validity, unit}}",
    "#define T(count, number, index, subindex, type, size, group, service) \\",
    "    {count, {number, index, subindex, TUMBLE_TYPE_##type, size, group, service}}",
]


def in_rows(items: list, row: Callable[[Any, int], tuple[str, list]]) -> list[str]:
    """Those that follow from the one before in one row each; `row`: the macro and cells of the row whose nth item is
    this."""
    runs: list[list] = []
    for item in items:
        if runs and row(item, len(runs[-1])) == row(runs[-1][0], 0):
            runs[-1].append(item)
        else:
            runs.append([item])
    return [f"{name}({', '.join(map(str, [len(run), *cells]))}),"
            for run in runs for name, cells in [row(run[0], 0)]]


def value_rows(registers: Map) -> list[str]:
    """Each is one subindex, one bit and its own words further than the one before."""
    places = {entry.key: place for place, entry in enumerate(registers.keys)}
    scaled = {one.entry.key: one for one in registers.values if one.form == SCALED}

    def row(one: Register, n: int) -> tuple[str, list]:
        also = scaled.get(one.entry.key)
        cells = [one.at - n * one.words, one.validity, one.bit - n, *row_cells(one.entry, n), one.group,
                 places.get(one.entry.key, len(places))]
        return ("S", [*cells, also.at - n * also.words, also.validity, also.scale]) if also else ("V", cells)

    return in_rows([one for one in registers.values if one.form != SCALED], row)


def setting_row(to: Setting, n: int) -> tuple[str, list]:
    return "T", [to.number - n, *row_cells(to.entry, n), to.group, str(to.entry.level == "service").lower()]


def row_cells(entry: Entry, n: int) -> list:
    return [f"0x{entry.index:04X}", entry.subindex - n, entry.type.name, entry.size]


def filled(cells: Iterable[str]) -> list[str]:
    """Lines with as many of them as they can take."""
    lines: list[str] = []
    for cell in cells:
        if lines and len(lines[-1]) + 1 + len(cell) <= COLUMNS:
            lines[-1] += " " + cell
        else:
            lines.append("    " + cell)
    return lines


def source(registers: Map) -> str:
    places = {entry.key: place for place, entry in enumerate(registers.keys)}
    selectors = [registers.selector(number) for number in range(registers.groups)]
    parts = [
        f"/* {NOTICE} */",
        '#include "registers.h"',
        "",
        '#include "canopen/dictionary.h"',
        "",
        *RUN_MACROS,
        "",
        "const gateway_value_run_t gateway_value_runs[] = {",
        *filled(value_rows(registers)),
        "};",
        "",
        "const gateway_object_t gateway_tells[GATEWAY_MARKS + GATEWAY_KEYS] = {",
        *(f"    {{{object_cells(entry)}}}," for entry in [*registers.marks, *registers.keys]),
        "};",
        "",
        "const uint8_t gateway_selectors[GATEWAY_GROUPS] = {",
        "    " + ", ".join(f"{places[entry.key] if entry else len(places)}U" for entry in selectors) + ",",
        "};",
        "",
        "const gateway_target_run_t gateway_target_runs[GATEWAY_TARGET_RUNS] = {",
        *filled(in_rows(registers.settings, setting_row)),
        "};",
        "",
        "const uint16_t gateway_command_objects[GATEWAY_COMMAND_OBJECTS] = {",
        *(f"    0x{item.index:04X}U, /* {item.name} */" for item in registers.commands),
        "};",
    ]
    return "\n".join(parts) + "\n"


def object_cells(entry: Entry) -> str:
    return f"0x{entry.index:04X}U, {entry.subindex}U, TUMBLE_TYPE_{entry.type.name}, {entry.size}U"
