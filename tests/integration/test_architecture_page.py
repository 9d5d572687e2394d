"""docs/architecture.md: its list of the package's rooms is the one that tools/rooms.py holds the code to. And packages'
docstrings: they list the modules that there are. And a sample's way: the functions that a run enters."""

import ast
import re
import shutil
import sys

import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tools"))
sys.path.insert(0, str(ROOT / "tests/benchmark"))

import costs_page
import rooms
import sample_way

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
    ("acquisition, history, report |", "history, report |"),
    ("`planning/` also files, workers", "`planning/` also files"),
])
def test_another_list_is_noticed(old, new):
    """The canary."""
    assert PAGE.count(old) == 1 and listed(PAGE.replace(old, new)) != listed(PAGE)


@pytest.mark.toolchain
@pytest.mark.skipif(shutil.which("addr2line") is None, reason="not there: addr2line")
def test_the_page_lists_the_functions_that_a_sample_enters():
    functions = sample_way.way()
    assert costs_page.part_of(PAGE, sample_way.NAME)["shown"].strip() == sample_way.text_of(functions)
    assert len(functions) <= sample_way.MOST
    names = [name for _, name, _ in functions]
    assert names[0] == "tumble_navcomp_step" and names.index("tumble_block_receive") < names.index("average_sample")
    assert names[-1] == "tumble_accumulator_add_up"


# Docstrings of packages.

PACKAGES = [path for path in sorted((ROOT / rooms.PACKAGE).rglob("__init__.py"))
            if path.parent.name != "commands"]  # whose list is the table of commands


def rows_of(docstring, gap=" {2,}"):
    """What the rows `name, name   what they are` are about."""
    return {name for head in re.findall(rf"^ *([A-Za-z_]+(?:, [A-Za-z_]+)*){gap}\S", docstring, re.MULTILINE)
            for name in head.split(", ")}


def wrong_names(docstring, modules, others=()):
    """Modules that it does not name, in a row or as `name`; and rows of what there is not."""
    named = rows_of(docstring, gap=" +") | set(re.findall(r"`(\w+)`", docstring))  # the longest name has but one space
    return sorted(modules - named), sorted(rows_of(docstring) - modules - set(others))


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.parent.name)
def test_a_package_lists_its_modules(package):
    tree, folder = ast.parse(package.read_text(encoding="utf-8")), package.parent
    modules = {path.stem for path in folder.glob("*.py")} | {path.parent.name for path in folder.glob("*/__init__.py")}
    folders = [path.name for path in folder.iterdir() if path.is_dir()]
    public = [name for node in tree.body if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__"
              for name in ast.literal_eval(node.value)]
    private = {"__init__", "__main__", "_version"}
    assert wrong_names(ast.get_docstring(tree), modules - private, [*folders, *public]) == ([], [])


def test_a_module_that_is_not_listed_or_not_there_is_noticed():
    """The canary."""
    assert wrong_names("Rooms.\n\nbase     numbers\none, two  rows, of `three`", {"base", "one", "three", "four"}) == (
        ["four"], ["two"])
