"""From the object table to docs/canopen.md."""

from __future__ import annotations

from collections.abc import Iterable

from kinds import Entry
from model import Node, Object, Pdo
from standard import PDO_INVALID

HEAD = """\
# CANopen objects

<!-- Written by tools/objects/generate: change tools/objects/*.toml instead. -->

What each node's object dictionary holds, as its SDO server answers and its EDS file says. Communication: 500 kbit/s,
SDO expedited and segmented (no block transfer), event-driven PDOs, heartbeats. Numbers are decimal unless they end in
`h` or begin with `0x`. A value in the column "power-on" is there after a reset; limits are inclusive and a write beyond
them is refused. Access: `ro` read, `rw` read and write, `wo` write, `const` never changes; `R` and `T`: may be mapped
into a receive or transmit PDO. Level `service`: a write from outside is refused (0800 0022h) unless the service level is
open (2006h, [service-level.md](service-level.md)).

Objects of every node:
"""


def page(nodes: list[Node]) -> str:
    parts = [HEAD, *notes(item for item in nodes[0].objects if item.common)]
    for node in nodes:
        parts += node_part(node)
    return "\n".join(parts)


def node_part(node: Node) -> list[str]:
    eds = node.settings["eds"].removeprefix("docs/")
    lines = [f"## Node {node.id}: {node.settings['name']}", "", f"{node.settings['about']} [EDS]({eds}).", ""]
    for name, pdos in (("Receive", node.receive), ("Transmit", node.transmit)):
        lines += [pdo_line(name, number + 1, pdo, node) for number, pdo in enumerate(pdos)]
    lines += object_table([item for item in node.objects if not item.further])
    if node.extension:
        lines += [f"### Further objects of node {node.id}", "", f"{node.extension['only']}. In the same EDS file."]
        lines += object_table([item for item in node.objects if item.further])
    saved = ", ".join(f"{item.index:04X}h" for item in node.objects if item.saved)
    lines += [f"Kept by 1010h: {saved}.", ""] if saved else []
    for name, pairs in node.lists.items():
        lines += value_list(name, pairs)
    return lines


def object_table(objects: list[Object]) -> list[str]:
    """The objects, and what those of them that are not every node's mean."""
    lines = ["", "| object | name | type | access | level | power-on | limits | unit |",
             "|---|---|---|---|---|---|---|---|"]
    for item in objects:
        lines += rows(item)
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


def rows(item: Object) -> list[str]:
    lines = []
    if not item.is_var:
        lines.append(f"| {item.index:04X}h | **{cell(item.name)}** | {item.kind} | | | | | |")
    for entry in item.entries:
        place = f"{item.index:04X}h" if item.is_var else f":{entry.subindex}"
        lines.append(
            f"| {place} | {cell(entry.name)} | {entry.type.name}{length(entry)} | {access(entry)} "
            f"| {entry.level or ''} | {cell(value(entry))} | {limits(entry)} | {cell(entry.unit)} |"
        )
    return lines


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
    return lines + [""] if lines else []


def value_list(name: str, pairs: list[tuple[str, str]]) -> list[str]:
    lines = [f"`{name}_...`:", "", "| number | name | meaning |", "|---|---|---|"]
    lines += [f"| {number} | `{key}` | {cell(sentence)} |" for number, (key, sentence) in enumerate(pairs)]
    return [*lines, ""]
