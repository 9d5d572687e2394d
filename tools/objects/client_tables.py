"""What the client library calls by name: reasons with remedies, commands, objections, verdicts, settings."""

from __future__ import annotations

import re
from pathlib import Path

from drawn import text
from model import Node, read_list
from remedies import Remedies, plain
from rules import check

SETS = "firmware/include/tumble/sets.h"
LISTS = {
    "REASON": "firmware/procedure/states.h",
    "COMMAND": "firmware/navcomp/commands.h",
    "OBJECTION": SETS,
}
STAND = "firmware/include/tumble/stand.h"
STEP = re.compile(r'Y\((\d+), (\w+), "(.*?)"\)')
VERDICT = re.compile(r"TUMBLE_VERDICT_(\w+) = (\d+),?\s*/\* (.*?) \*/")
HOST = 0x2121  # what the host tells; it is no setting that 1010h saves, but one all the same
HEAD = '''"""Names that the client library calls things by. Written by tools/objects/generate from firmware lists,
the object tables and tools/objects/remedies.toml; not to be edited."""

# ruff: noqa: E501
# fmt: off

from __future__ import annotations

'''


def module(root: Path, node: Node, remedies: Remedies) -> str:
    """tumble/client/tables.py. Raises TableError."""
    parts = [listed(root, name, remedies.get(f"TUMBLE_{name}", {})) for name in LISTS]
    return HEAD + "\n".join([*parts, verdicts(root), stand_steps(root), settings(node)])


def listed(root: Path, name: str, said: dict[str, str]) -> str:
    """One list of the firmware, in the order of its numbers; with what to do where that is said."""
    made = [[whole.removeprefix(f"TUMBLE_{name}_"), meaning, *([plain(said[whole])] if said else [])]
            for whole, meaning in read_list(root / LISTS[name], f"TUMBLE_{name}")]
    return table(f"{name}S", f"by number: name, meaning{', what to do' if said else ''}", made)


def verdicts(root: Path) -> str:
    found = VERDICT.findall((root / SETS).read_text(encoding="utf-8"))
    check([int(number) for _, number, _ in found] == list(range(len(found))) != [], SETS, "no list of verdicts")
    rows = [[name, meaning.replace("`", "")] for name, _, meaning in found]
    return table("VERDICTS", "by number: name, meaning", rows)


def stand_steps(root: Path) -> str:
    found = STEP.findall((root / STAND).read_text(encoding="utf-8"))
    check(found != [], STAND, "no list of steps")
    rows = "".join(f"    {number}: {text(what)},\n" for number, _, what in found)
    return f"STAND_STEPS: dict[int, str] = {{  # of 2004h:9: what the drive was asked for\n{rows}}}\n"


def table(name: str, about: str, rows: list[list[str]]) -> str:
    kind = ", ".join(["str"] * len(rows[0]))
    lines = "".join(f"    ({', '.join(map(text, row))}),\n" for row in rows)
    return f"{name}: tuple[tuple[{kind}], ...] = (  # {about}\n{lines})\n"


def settings(node: Node) -> str:
    """What the host tells, and what 1010h saves."""
    rows = []
    for item in node.objects:
        own = [entry for entry in item.entries if entry.subindex and entry.access == "rw"]
        if own and (item.saved or item.index == HOST):
            at_service_level = "".join(f"{text(entry.name)}, " for entry in own if entry.level == "service")
            rows.append(f"    {text(item.name)}: ({at_service_level.strip()}),\n")
    head = "SETTINGS: dict[str, tuple[str, ...]] = {  # by object: which of them need the service level\n"
    return head + "".join(rows) + "}\n"
