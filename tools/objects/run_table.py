"""The states of a run and all ways between them, from the C sources that are the run.

States and what they mean: the list of firmware/procedure/states.h. `done` and `other`: the rows of procedure_states.c;
the comment beside an `other` says what it is. A command leads where its function in procedure.c goes; a row says where
it is allowed. A state can fail if it watches something, has a timeout, or calls what may call tumble_fail.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from headers import without_comments
from kinds import TableError
from model import read_list
from rules import check

FOLDER = "firmware/procedure"
TABLE, ENGINE = f"{FOLDER}/procedure_states.c", f"{FOLDER}/procedure.c"
LIST = "TUMBLE_STATE"
FAULT = "FAULT"
ROW = re.compile(r"^    \[TUMBLE_STATE_(\w+)\] = \{\n(.*?)\n    \},", re.DOTALL | re.MULTILINE)
FUNCTION = re.compile(r"^\w[\w ]*?[ *](\w+)\([^;{}]*\)\n\{\n(.*?)^\}", re.DOTALL | re.MULTILINE)
GOAL = re.compile(r"\bgo_to\(procedure, (?:TUMBLE_STATE_(\w+)|failed \? TUMBLE_STATE_(\w+) : TUMBLE_STATE_(\w+))\);")
FAILS = "tumble_fail"


class Way(NamedTuple):
    """From a state to another, `by` done, other, fault or a command; `note`: when."""

    begin: str
    end: str
    by: str
    note: str = ""


def states(root: Path) -> list[tuple[str, str]]:
    """(name, sentence) of each state, in the order of their numbers."""
    return [(name.removeprefix(f"{LIST}_"), said) for name, said in read_list(root / FOLDER / "states.h", LIST)]


def ways(root: Path) -> list[Way]:
    """All of them, in the order of the states that they begin in."""
    text, known = read(root / TABLE), [name for name, _ in states(root)]
    rows = dict(ROW.findall(text))
    check(set(rows) == set(known), TABLE, f"its rows are not the states of {FOLDER}/states.h")
    goals, failing = commands(read(root / ENGINE)), may_fail(root)
    found = [way for name in known for way in (*row_ways(name, rows[name]), *fault(name, rows[name], failing),
                                               *row_commands(name, rows[name], macros(text), goals))]
    for way in found:
        check(way.end in known, TABLE, f"{way.begin} leads to {way.end}, which is no state")
    return found


def read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise TableError(f"{path}: {error.strerror}") from error


def row_ways(name: str, row: str) -> list[Way]:
    found = [Way(name, goal, by, note) for by, goal, note in
             re.findall(r"\.(done|other) = TO\((\w+)\),(?: /\* (.*?) \*/)?", row)]
    for way in found:
        check(way.by == "done" or way.note, TABLE, f"{name}: no comment says when .other is taken")
    return found


def fault(name: str, row: str, failing: set[str]) -> list[Way]:
    watches = re.search(r"\.(watch|timeout) =", row) is not None
    return [Way(name, FAULT, "fault")] if watches or failing & set(re.findall(r"\w+", row)) else []


def macros(text: str) -> dict[str, str]:
    return dict(re.findall(r"^#define (\w+) (\(?COMMAND_\w+.*)$", text, re.MULTILINE))


def row_commands(name: str, row: str, short: dict[str, str], goals: dict[str, tuple[str, str]]) -> list[Way]:
    """`goals`: of each command where it leads, from FAULT and from any other state."""
    given = re.search(r"\.commands = ([\w |]+),", row)
    words = re.sub(r"\w+", lambda word: short.get(word[0], word[0]), given[1]) if given else ""
    found = []
    for command in re.findall(r"COMMAND_(\w+)", words):
        check(command in goals, ENGINE, f"COMMAND_{command} leads nowhere")
        found.append(Way(name, goals[command][0 if name == FAULT else 1], command))
    return found


def commands(text: str) -> dict[str, tuple[str, str]]:
    """Where the functions that ask for each command go."""
    found: dict[str, tuple[str, str]] = {}
    for name, body in FUNCTION.findall(without_comments(text)):
        asked = re.findall(r"allows\(procedure, COMMAND_(\w+)\)", body)
        goals = {(goal or failed, goal or other) for goal, failed, other in GOAL.findall(body)}
        check(not asked or len(goals) == body.count("go_to("), ENGINE, f"{name} goes where this program cannot read")
        for command in asked:
            for goal in goals:
                check(found.setdefault(command, goal) == goal, ENGINE, f"COMMAND_{command} leads to two states")
    return found


def may_fail(root: Path) -> set[str]:
    """The functions of the procedure that may make a fault, by themselves or by others of it."""
    bodies = {name: set(re.findall(r"\w+", body)) for path in sorted((root / FOLDER).glob("*.c"))
              for name, body in FUNCTION.findall(without_comments(read(path)))}
    check(FAILS in bodies, FOLDER, f"{FAILS} is not there")
    failing = {FAILS}
    while further := {name for name, words in bodies.items() if words & failing} - failing:
        failing |= further
    return failing
