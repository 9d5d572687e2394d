"""From a node of the object table to its C header and source."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace

from headers import OWN
from kinds import Entry
from model import MAX_CONSUMERS, Node, Object, Pdo
from rules import slug
from standard import MAX_MAPPED, PDO_INVALID

NOTICE = "Written by tools/objects/generate from tools/objects/{file}: change it there."
HOMES = {"variable": "VARIABLES", "other": "OTHER", "computed": "COMPUTED", "communication": "COMMUNICATION"}
MAX_OFFSET = OWN.value("TUMBLE_MAX_OFFSET")
COLUMNS = 120
MOST_IN_LINE = 4  # TUMBLE_IN_LINE_4


def parts(node: Node) -> list[Node]:
    """What has C files of its own: the node, and its extension, which has further objects and PDOs."""
    mine = [item for item in node.objects if not item.further]
    if not node.extension:
        return [node]
    unused = Pdo(PDO_INVALID, 255, 0, 0, [])
    own = [unused if pdo.further else pdo for pdo in node.transmit]
    first = replace(node, objects=mine, transmit=own, extension={})
    places = [number for number, pdo in enumerate(node.transmit) if pdo.further]
    settings = node.settings | node.extension | {"saves": [item for item in node.objects if item.saved],
                                                 "first_transmit": places[0] if places else 0}
    further = [item for item in node.objects if item.further]
    behind = node.transmit[places[0]:places[-1] + 1] if places else []
    return [first, replace(node, objects=further, receive=[], transmit=behind, settings=settings,
                           sources=node.extension["sources"])]


def macro(name: str) -> str:
    return slug(name).upper()


def integer(value: int) -> str:
    """A C constant of any integer value."""
    if value == -(1 << 31):
        return "(-2147483647 - 1)"
    return f"{value}U" if value > 0x7FFFFFFF else str(value)


def real(value: float) -> str:
    text = repr(float(value))
    return text if re.search(r"[.e]", text) else text + ".0"


def literal(entry: Entry) -> str:
    if entry.type.is_text:
        return '"' + str(entry.value or "").replace("\\", "\\\\").replace('"', '\\"') + '"'
    if entry.type.key == "bool":
        return "true" if entry.value else "false"
    if entry.type.is_real:
        return real(entry.value or 0.0)
    return integer(int(entry.value or 0))


def is_immediate(entry: Entry) -> bool:
    return entry.home == "value" and entry.type.is_integer and 0 <= int(entry.value) <= MAX_OFFSET


def declaration(entry: Entry, name: str, extra: int = 0) -> str:
    if entry.type.is_text:
        return f"char {name}[{entry.size + extra}];"
    return f"{entry.type.c_type} {name};"


def variables(node: Node) -> list[Entry]:
    """In the order of falling size, so that the struct has no holes."""
    mine = [entry for entry in node.entries if entry.home == "variable"]
    return sorted(mine, key=lambda entry: (entry.type.is_text, -entry.type.size, entry.key))


def comment(entry: Entry) -> str:
    unit = f", {entry.unit}" if entry.unit else ""
    return f"/* {entry.where}{unit} */"


def saved_bytes(item: Object) -> int:
    """Index and count, then every value behind its size."""
    return 3 + sum(1 + entry.size for entry in item.entries[1:])


def title(node: Node) -> str:
    return f"the object dictionary of node {node.id}, {node.settings['name']}"


def table_of(node: Node) -> str:
    """The file that its objects stand in."""
    return node.settings.get("table", node.path.name)


def header(node: Node) -> str:
    prefix = node.prefix
    guard = macro(node.settings["include"].replace(".h", "_h"))
    name = node.settings["include"].split("/")[-1]
    lines = [
        f"/* {name} - {node.settings.get('title') or title(node)}.",
        " *",
        f" * {NOTICE.format(file=table_of(node))}",
        " */",
        f"#ifndef TUMBLE_{guard}",
        f"#define TUMBLE_{guard}",
        "",
        '#include "canopen/node.h"',
        "",
        "#include <stdbool.h>",
        "#include <stdint.h>",
        *([] if "title" in node.settings else ["", f"#define {prefix.upper()}_NODE {node.id}U"]),
    ]
    if variables(node):
        lines += [
            "",
            "/* The variables: TUMBLE_HOME_VARIABLES. */",
            "typedef struct {",
            *(f"    {declaration(entry, entry.member)} {comment(entry)}" for entry in variables(node)),
            f"}} {prefix}_objects_t;",
            "",
            "/* Their power-on values. */",
            f"extern const {prefix}_objects_t {prefix}_objects_initial;",
        ]
    if node.sources:
        lines += [
            "",
            "/* Where what is computed comes from: tumble_entry_t.source. */",
            "typedef enum {",
            *(f"    {source_name(node, name)}, /* {about} */" for name, about in node.sources.items()),
            f"}} {prefix}_source_t;",
        ]
    saves = node.settings.get("saves", [])
    if saves:
        lines += [
            "",
            "/* What 1010h keeps: objects with so many subindices, of either table. */",
            "typedef struct {",
            "    uint16_t index;",
            "    uint8_t count; /* of subindices, from 1 on */",
            "} tumble_saved_t;",
            f"#define {prefix.upper()}_SAVED {len(saves)}",
            f"#define {prefix.upper()}_SAVED_BYTES {sum(map(saved_bytes, saves))} /* in navcomp/parameters.h */",
            f"extern const tumble_saved_t {prefix}_saved[{prefix.upper()}_SAVED];",
        ]
    pdos = [f"extern const tumble_node_defaults_t {prefix}_defaults;"]
    if node.extension:
        size = f"{prefix.upper()}_TRANSMIT"
        pdos = ["", f"#define {size} {len(node.transmit)}U",
                f"#define {prefix.upper()}_FIRST_TRANSMIT {node.settings['first_transmit']}U",
                "/* Transmit PDOs, from that number (0 is 1800h) on. */",
                f"extern const tumble_pdo_setup_t {prefix}_transmit[{size}];"]
    lines += ["", f"extern const tumble_object_table_t {prefix}_table;", *pdos, "", "#endif"]
    return "\n".join(lines) + "\n"


def source_name(node: Node, name: str) -> str:
    return f"{node.prefix.upper()}_SOURCE_{macro(name)}"


class Source:
    """The C source, section by section."""

    def __init__(self, node: Node):
        self.node = node
        self.prefix = node.prefix
        self.constants = [entry for entry in node.entries if entry.home == "value" and not is_immediate(entry)]
        self.limits = sorted({(entry.low, entry.high) for entry in node.entries if entry.low is not None})

    def text(self) -> str:
        settings = self.node.settings
        includes = [f'#include "{settings["include"]}"', ""]
        others = sorted([*settings.get("includes", []), "canopen/table.h"])
        includes += [*(f'#include "{name}"' for name in others), ""]
        notice = f"/* {NOTICE.format(file=table_of(self.node))} */"
        parts = [
            [notice, *includes, *([] if self.node.extension else ["#include <assert.h>"]), "#include <stddef.h>"],
            self.initial_values(),
            self.constant_values(),
            self.limit_table(),
            self.layout_checks(),
            self.entry_table(),
            self.table(),
            *([self.further_pdos()] if self.node.extension else
              [self.pdo_setups("receive", used(self.node.receive)),
               self.pdo_setups("transmit", used(self.node.transmit)), self.defaults()]),
            self.saved(),
        ]
        return "\n\n".join("\n".join(part) for part in parts if part) + "\n"

    def initial_values(self) -> list[str]:
        mine = variables(self.node)
        if not mine:
            return []
        lines = [f"    .{entry.member} = {literal(entry)}," for entry in mine if entry.value is not None]
        return [f"const {self.prefix}_objects_t {self.prefix}_objects_initial = {{", *(lines or ["    0,"]), "};"]

    @staticmethod
    def constant_name(entry: Entry) -> str:
        return f"value_{entry.index:04x}_{entry.subindex}"

    def constant_values(self) -> list[str]:
        if not self.constants:
            return []
        declared = [f"    {declaration(entry, self.constant_name(entry), 1)}" for entry in self.constants]
        given = [f"    .{self.constant_name(entry)} = {literal(entry)}," for entry in self.constants]
        struct = ["typedef struct {", *declared, "} constants_t;"]
        return [*struct, "", "static const constants_t constants = {", *given, "};"]

    def limit_table(self) -> list[str]:
        if not self.limits:
            return []
        rows = [f"    {{{real(low)}, {real(high)}}}," for low, high in self.limits]
        return ["static const tumble_limit_t limits[] = {", *rows, "};"]

    def layout_checks(self) -> list[str]:
        """The entries must agree with the structs that they point into, which others write."""
        apart = [item for item in self.node.objects if item.like in (0, item.index)]
        return [line for item in apart for run in runs_of(item) for line in checks(run)]

    def entry_table(self) -> list[str]:
        rows = []
        for alike in alike_objects(self.node.objects):
            names = alike[0].name if len(alike) == 1 else f"{alike[0].name}, and {len(alike) - 1} more"
            mine = [self.row(run, len(alike) - 1) for run in runs_of(alike[0])]
            rows += [f"{mine[0]} /* {names} */", *mine[1:]]
        return ["static const tumble_entry_t entries[] = {", *rows, "};"]

    def row(self, run: list[Entry], more_objects: int) -> str:
        entry = run[0]
        home, offset = self.home(entry)
        source = source_name(self.node, entry.source) if entry.source else "0"
        limit = 0 if entry.low is None else 1 + self.limits.index((entry.low, entry.high))
        return (f"    TUMBLE_ROW(0x{entry.index:04X}, {entry.subindex}, {entry.type.name}, {home}, {access(entry)}, "
                f"{entry.size}, {limit}, {more_objects}, {len(run) - 1}, {offset}, {source}),")

    def home(self, entry: Entry) -> tuple[str, str]:
        if is_immediate(entry):
            return "IMMEDIATE", str(int(entry.value))
        if entry.home == "value":
            return "CONSTANT", f"offsetof(constants_t, {self.constant_name(entry)})"
        offset = f"offsetof({entry.struct}, {entry.member})" if entry.member else "0"
        return HOMES[entry.home], offset

    def table(self) -> list[str]:
        return [
            f"const tumble_object_table_t {self.prefix}_table = {{",
            "    .entries = entries,",
            f"    .limits = {'limits' if self.limits else 'NULL'},",
            f"    .constants = {'&constants' if self.constants else 'NULL'},",
            "    .count = sizeof entries / sizeof entries[0],",
            "};",
        ]

    def pdo_setups(self, name: str, pdos: list[Pdo]) -> list[str]:
        if not pdos:
            return []
        rows = [line for pdo in pdos for line in pdo_setup(pdo)]
        most = f"static_assert((sizeof {name} / sizeof {name}[0]) <= TUMBLE_MAX_{name.upper()}_PDOS, \"{name}\");"
        return [f"static const tumble_pdo_setup_t {name}[] = {{", *rows, "};", most]

    def further_pdos(self) -> list[str]:
        """How many there may be together with those of the table before, the node's init sees."""
        rows = [line for pdo in self.node.transmit for line in pdo_setup(pdo)]
        size = f"{self.prefix.upper()}_TRANSMIT"
        return [f"const tumble_pdo_setup_t {self.prefix}_transmit[{size}] = {{", *rows, "};"]

    def pdo_defaults(self, name: str) -> list[str]:
        pdos = getattr(self.node, name)
        setups = used(pdos)
        return [
            f"    .{name} = {name if setups else 'NULL'},",
            f"    .first_{name} = {len(pdos) - len(setups)}U,",
            f"    .{name}_count = {len(setups)}U,",
        ]

    def defaults(self) -> list[str]:
        settings = self.node.settings
        consumers = ", ".join(f"0x{settings[f'consumer{i + 1}']:08X}U" for i in range(MAX_CONSUMERS))
        return [
            f"const tumble_node_defaults_t {self.prefix}_defaults = {{",
            *(line for name in ("receive", "transmit") for line in self.pdo_defaults(name)),
            f"    .heartbeat_ms = {settings['heartbeat_ms']}U,",
            f"    .consumers = {{{consumers}}},",
            f"    .on_error = {settings['on_error']}U,",
            "};",
        ]

    def saved(self) -> list[str]:
        """What 1010h keeps, where the node has it: object and its subindices."""
        if "saves" not in self.node.settings:
            return []
        mine = self.node.settings["saves"]
        rows = [f"    {{0x{item.index:04X}U, {len(item.entries) - 1}U}}, /* {item.name} */" for item in mine]
        return [f"const tumble_saved_t {self.prefix}_saved[{self.prefix.upper()}_SAVED] = {{", *rows, "};"]


def used(pdos: list[Pdo]) -> list[Pdo]:
    """Without those at the front that are as a node has them without a setup."""
    front = 0
    while front < len(pdos) and pdos[front] == Pdo(PDO_INVALID, 255, 0, 0, []):
        front += 1
    return pdos[front:]


def pdo_setup(pdo: Pdo) -> list[str]:
    maps = [f"0x{entry.map_value:08X}U" for entry in pdo.map] + ["0U"] * (MAX_MAPPED - len(pdo.map))
    return [
        f"    {{.cob_id = 0x{pdo.cob_id:X}U, .type = {pdo.type}U, .count = {len(pdo.map)}U, "
        f".inhibit_100us = {pdo.inhibit_100us}U, .event_ms = {pdo.event_ms}U,",
        f"     .map = {{{', '.join(maps)}}}}},",
    ]


def runs_of(item: Object) -> list[list[Entry]]:
    """The entries of an object, those together that share a row of the table. The highest subindex has none."""
    runs: list[list[Entry]] = []
    for entry in item.entries:
        if not item.is_var and entry.subindex == 0 and entry.home == "value":
            continue
        if runs and continues(item, runs[-1][-1], entry):
            runs[-1].append(entry)
        else:
            runs.append([entry])
    return runs


def continues(item: Object, last: Entry, entry: Entry) -> bool:
    in_line = entry.home == "communication" or (item.runs and entry.home in ("other", "computed") and not entry.apart)
    return in_line and entry.subindex == last.subindex + 1 and shape(entry) == shape(last)


def shape(entry: Entry) -> tuple:
    """What the entries of one row have in common."""
    return (entry.type, entry.access, entry.home, entry.size, entry.map, entry.low, entry.high, entry.struct,
            entry.source, entry.level)


def alike_objects(objects: list[Object]) -> list[list[Object]]:
    """Objects one after the other of which the first one's rows tell all: PDO parameters, PDO mappings."""
    groups: list[list[Object]] = []
    for item in objects:
        if groups and item.index == groups[-1][-1].index + 1 and layout(item) and layout(item) == layout(groups[-1][0]):
            groups[-1].append(item)
        else:
            groups.append([item])
    return groups


def layout(item: Object) -> list[tuple]:
    """What two objects must have in common to share their rows; nothing if they cannot."""
    if item.like:
        return [(entry.subindex, shape(entry), entry.member) for entry in item.entries]
    if item.is_var or any(entry.home != "communication" for entry in item.entries[1:]):
        return []
    return [(entry.subindex, shape(entry)) for entry in item.entries]


def checks(run: list[Entry]) -> list[str]:
    """Macros of firmware/canopen/table.h: one for an array, one for up to MOST_IN_LINE members of a run."""
    first = run[0]
    if not first.member or first.home not in ("other", "computed"):
        return []
    if array := whole_array(run):
        return [check_line("IS_ARRAY", first, f"{array}, {first.member}, {len(run)}U")]
    if len(run) == 1:
        return [check_line("HAS_SIZE", first, first.member)]
    parts = [run[at:at + MOST_IN_LINE] for at in range(0, len(run) - 1, MOST_IN_LINE - 1)]
    return [check_line(f"IN_LINE_{len(part)}", part[0], ", ".join(entry.member for entry in part)) for part in parts]


def check_line(name: str, entry: Entry, members: str) -> str:
    first = f'TUMBLE_{name}("{entry.where}", {entry.struct}, {entry.size}U,'
    return one_line_or_two(first, " " * (len(f"TUMBLE_{name}") + 1), f"{members});")


def whole_array(run: list[Entry]) -> str | None:
    """The array whose elements, one after the other from the first, are a run; C says whether they are all."""
    array = run[0].member.split("[")[0]
    places = [tuple(map(int, re.findall(r"\[(\d+)\]", entry.member))) for entry in run]
    ends = tuple(last + 1 for last in places[-1])
    in_order = places == list(itertools.product(*map(range, ends)))
    alike = all(entry.member == array + "".join(f"[{n}]" for n in place) for entry, place in zip(run, places))
    return array if len(run) > 1 and in_order and alike else None


def one_line_or_two(first: str, indent: str, rest: str) -> str:
    joined = f"{first} {rest}"
    return joined if len(joined) <= COLUMNS else f"{first}\n{indent}{rest}"


def access(entry: Entry) -> str:
    bits = [{"ro": "RO", "const": "RO", "rw": "RW", "wo": "WO"}[entry.access]]
    bits += {None: [], "receive": ["RPDO"], "transmit": ["TPDO"], "both": ["RPDO", "TPDO"]}[entry.map]
    bits += {None: [], "service": ["SERVICE"]}[entry.level]
    return " | ".join(bits)


def source(node: Node) -> str:
    return Source(node).text()
