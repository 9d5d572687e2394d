"""From the object table to docs/canopen.md."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from kinds import Entry
from model import Node, Object, Pdo
from standard import PDO_INVALID

HEAD = """\
# CANopen objects

<!-- Written by tools/objects/generate: change tools/objects/*.toml instead. -->

This page lists the object dictionary of each node, as its SDO server answers and its EDS file says. Communication:
500 kbit/s, SDO expedited and segmented (no block transfer), event-driven PDOs, heartbeats.

- Numbers are decimal unless they end in `h` or begin with `0x`.
- The column "power-on" has the value after a reset. Limits are inclusive; a write beyond them is refused.
- Access: `ro` read, `rw` read and write, `wo` write, `const` never changes; `R` and `T`: may be mapped into a
  receive or transmit PDO.
- Level `service`: a write from outside is refused (0800 0022h) unless the service level is open (2006h,
  [client.md](client.md#the-service-level)).
- Neighbours that differ only in a number or an axis share a row, matrices row by row: `:1 to :9` are nine subindices. A
  record or an array that is `as` another one has the rows of that one.
- The EDS files have real numbers as CiA 306 asks, the hexadecimal digits of their bits, and their limits as comments
  ([why](gateway.md#eds-files)).
- Subindex 0, where it is not listed, holds the highest subindex (UNSIGNED8, const).

Objects of every node:
"""
HIGHEST = "Highest subindex supported"  # of subindex 0
LAST_PART = re.compile(r"\d+$|[xyz]{1,2}$")


def page(nodes: list[Node]) -> str:
    parts = [HEAD, *notes(item for item in nodes[0].objects if item.common)]
    for node in nodes:
        parts += node_part(node)
    return "\n".join(parts)


def node_part(node: Node) -> list[str]:
    lines = [f"## Node {node.id}: {node.settings['name']}", "", f"{node.settings['about']} {data_sheets(node)}.", ""]
    for name, pdos in (("Receive", node.receive), ("Transmit", node.transmit)):
        lines += [pdo_line(name, number + 1, pdo, node) for number, pdo in enumerate(pdos)]
    told: dict[tuple, int] = {}
    lines += object_table([item for item in node.objects if not item.further], told)
    if node.extension:
        lines += [f"### Further objects of node {node.id}", "", f"{node.extension['only']}."]
        lines += object_table([item for item in node.objects if item.further], told)
    saved = ", ".join(f"{item.index:04X}h" for item in node.objects if item.saved)
    lines += [f"Kept by 1010h: {saved}.", ""] if saved else []
    for name, pairs in node.lists.items():
        lines += value_list(name, pairs)
    return lines


def data_sheets(node: Node) -> str:
    eds = node.settings["eds"].removeprefix("docs/")
    if not node.extension:
        return f"[EDS]({eds})"
    bare = node.extension["eds_without"].removeprefix("docs/")
    return f"[EDS]({eds}); [EDS without the further objects]({bare})"


def object_table(objects: list[Object], told: dict[tuple, int]) -> list[str]:
    """The objects, and what those of them that are not every node's mean. `told`: by their rows,
    the objects that have them already."""
    lines = ["", "| object | name | type | access | level | power-on | limits | unit |",
             "|---|---|---|---|---|---|---|---|"]
    for item in objects:
        lines += rows(item, told)
    return [*lines, "", *notes(item for item in objects if not item.common)]


def pdo_line(name: str, number: int, pdo: Pdo, node: Node) -> str:
    if pdo.cob_id & PDO_INVALID:
        return f"- {name} PDO {number}: not in use at power-on."
    cob_id = pdo.cob_id | (node.id if pdo.cob_id & 0x7F == 0 else 0)
    mapped = ", ".join(f"{entry.name} ({entry.where})" for entry in pdo.map)
    inhibit = f", at most every {pdo.inhibit_100us / 10:g} ms" if pdo.inhibit_100us else ""
    event = f", at least every {pdo.event_ms} ms" if pdo.event_ms else ""
    only = f" {node.extension['only']}: elsewhere not in use at power-on." if pdo.further else ""
    only = only.replace(" (0602 0000h elsewhere)", "")
    return f"- {name} PDO {number}: identifier `0x{cob_id:03X}`{inhibit}{event}; {mapped}.{only}"


def rows(item: Object, told: dict[tuple, int]) -> list[str]:
    lines = entry_rows(item)
    if item.is_var:
        return lines
    first = told.setdefault(tuple(lines), item.index)
    kind = item.kind if first == item.index else f"{item.kind}, as {first:04X}h"
    return [
        f"| {item.index:04X}h | **{cell(item.name)}** | {kind} | | | | | |",
        *(lines if first == item.index else []),
    ]


def entry_rows(item: Object) -> list[str]:
    lines = []
    said = [entry for entry in item.entries if entry.name != HIGHEST]
    for alike in families(said, lambda entry: entry.name, lambda entry: (entry.subindex, columns(entry))):
        place = f"{item.index:04X}h" if item.is_var else span([f":{entry.subindex}" for entry in alike])
        lines.append(f"| {place} | {cell(family_name([entry.name for entry in alike]))} | {columns(alike[0])} |")
    return lines


def columns(entry: Entry) -> str:
    """All that a row says behind the name."""
    return (f"{entry.type.name}{length(entry)} | {access(entry)} | {entry.level or ''} | {cell(value(entry))} "
            f"| {limits(entry)} | {cell(entry.unit)}")


def families(items: list, name: Callable, told: Callable) -> list[list]:
    """What shares a row: neighbours whose names differ in a number or an axis at the end, and of which all else is the
    same; `told` gives the number that counts up from one to the next, and all else."""
    groups: list[list] = []
    for item in items:
        if groups and LAST_PART.search(name(item)) and is_next(groups[-1], item, name, told):
            groups[-1].append(item)
        else:
            groups.append([item])
    return groups


def is_next(group: list, item: object, name: Callable, told: Callable) -> bool:
    (number, rest), (following, its_rest) = told(group[-1]), told(item)
    stems = {LAST_PART.sub("", name(one)) for one in (group[0], item)}
    return (following, its_rest) == (number + 1, rest) and len(stems) == 1


def family_name(names: list[str]) -> str:
    return span([names[0], LAST_PART.search(names[-1])[0]]) if len(names) > 1 else names[0]


def span(places: list[str]) -> str:
    """From the first to the last."""
    return places[0] if places[0] == places[-1] else f"{places[0]} to {places[-1]}"


def cell(text: str) -> str:
    return text.replace("|", "\\|")


def length(entry: Entry) -> str:
    return f"({entry.size})" if entry.type.is_text else ""


def access(entry: Entry) -> str:
    letters = {None: "", "receive": " R", "transmit": " T", "both": " R T"}[entry.map]
    return ("const" if entry.home == "value" and entry.access == "ro" else entry.access) + letters


def value(entry: Entry) -> str:
    if entry.value is None:
        return ""
    if isinstance(entry.value, str):
        return f"`{entry.value}`" if entry.value else ""
    if isinstance(entry.value, float):
        return f"{entry.value:g}"
    wide = entry.type.key == "u32" and entry.index < 0x2000
    return f"0x{entry.value:X}" if wide and entry.value > 9 else str(entry.value)


def limits(entry: Entry) -> str:
    return "" if entry.low is None else f"{entry.low:.10g} to {entry.high:.10g}"


def notes(objects: Iterable[Object]) -> list[str]:
    """What the objects mean, for those that say so."""
    lines = []
    for item in objects:
        said = [item.about] if item.about else []
        explain = not item.is_var and item.like in (0, item.index)  # those like it mean the same
        said += [f"{entry.name}: {entry.about}" for entry in item.entries if entry.about and explain]
        if item.values:
            said.append(f"Numbers: see {item.values}_... below.")
        if said:
            lines.append(f"- **{item.index:04X}h {item.name}**: {' '.join(said)}")
    return [*lines, ""] if lines else []


def value_list(name: str, pairs: list[tuple[str, str]]) -> list[str]:
    lines = [f"`{name}_...`:", "", "| number | name | meaning |", "|---|---|---|"]
    lines += [f"| {number} | `{key}` | {cell(sentence)} |" for number, (key, sentence) in enumerate(pairs)]
    return [*lines, ""]
