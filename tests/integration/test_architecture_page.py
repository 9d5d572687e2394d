"""docs/architecture.md: its list of the package's rooms is the one that tools/rooms.py holds the code to."""

import re
import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tools"))

import rooms

PAGE = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")


def listed(page):
    """{room: the rooms that it may import} of the page; "all" and what all may import are left out."""
    _, _, rows = page.partition("| room | what | may import |\n|---|---|---|\n")
    found = {}
    for row in rows.partition("\n\n")[0].splitlines():
        names, _, may = (cell.strip() for cell in row.strip("|").split("|"))
        if may in ("all", "each other"):
            continue
        common, *own = may.split("; ")
        for room in re.findall(r"`(\w+)/?`", names):
            found[room] = set(common.split(", ")) - {""}
            found[room] |= {name for part in own if f"`{room}/` also" in part
                            for name in part.partition(" also ")[2].split(", ")}
    return found


def test_the_page_lists_what_the_tool_allows():
    allowed = {("__init__" if room == rooms.DOOR else room): may for room, may in rooms.MAY_IMPORT.items()}
    assert listed(PAGE) == {room: may for room, may in allowed.items() if room not in (rooms.BESIDE, "cli")}


@pytest.mark.parametrize(("old", "new"), [
    ("| `testing/`", "| `tasting/`"),
    ("importing, report |", "report |"),
    ("`planning/` also files, workers", "`planning/` also files"),
])
def test_another_list_is_noticed(old, new):
    """The canary."""
    assert PAGE.count(old) == 1 and listed(PAGE.replace(old, new)) != listed(PAGE)
