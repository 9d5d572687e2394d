"""Lists are lists: no item of a page has flowed into the one before it."""

import re

import pytest
from conftest import ROOT

ITEM = re.compile(r"( *)(- |\d+\. )")


def pages():
    found = [ROOT / "README.md", ROOT / "CHANGELOG.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "tools").rglob("*.md")]
    return sorted(path for path in found if path.is_file())


def joined(text):
    """Numbers of lines where a list was joined by whoever filled a paragraph."""
    wrong, code, in_item, last = [], False, False, {}
    for number, line in enumerate(text.splitlines(), start=1):
        code ^= line.lstrip().startswith("```")
        item = ITEM.match(line)
        if code or not line.strip() or line.startswith(("#", "|", "    ")):
            in_item = in_item and bool(line.strip())
            continue
        if item and item[2] != "- ":
            count = int(item[2].split(".")[0])
            wrong += [number] if count not in (1, last.get(item[1], 0) + 1) else []
            last[item[1]] = count
        if in_item and not line.startswith(" ") and not item:
            wrong.append(number)  # an item's further lines are indented
        if re.search(r"\. \d\.$|\S {3,}\S", line):
            wrong.append(number)
        in_item = bool(item) or (in_item and line.startswith(" "))
    return wrong


def test_no_list_has_been_joined():
    found = {str(path.relative_to(ROOT)): joined(path.read_text(encoding="utf-8")) for path in pages()}
    assert {name: lines for name, lines in found.items() if lines} == {}


@pytest.mark.parametrize("text", [
    "4. It is held: there is nothing to compare\nwith.    Read it. 5.\nACCEPT.\n", "1. One.\n2. Two.\n4. Four.\n",
    "- One\nflows on.\n", "Ends with. 5.\n",
])  # fmt: skip
def test_a_joined_list_is_noticed(text):
    """The canary."""
    assert joined(text)
