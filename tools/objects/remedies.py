"""What to do about each reason to stop and each objection to a result: from remedies.toml into the tables of the page
for operators, the words of the logs, and those of the client library."""

from __future__ import annotations

import re
from pathlib import Path

from model import read_list, read_toml
from rules import check

TABLE = "remedies.toml"
PAGE = "docs/operations.md"
LISTS = {"TUMBLE_OBJECTION": "firmware/include/tumble/sets.h", "TUMBLE_REASON": "firmware/procedure/states.h"}
HEADS = {"TUMBLE_OBJECTION": "| bit | objection | what to do |",
         "TUMBLE_REASON": "| number | reason | what to check |"}
Remedies = dict[str, dict[str, str]]  # by list and whole name, in Markdown
BEGIN, END = "<!-- {}: written by tools/objects/generate. -->\n", "<!-- End of the table. -->"
LINK = re.compile(r"\[[^\]]*\]\(([^)#]*)(?:#[^)]*)?\)")
HEAD = """/* Written by tools/objects/generate from tools/objects/remedies.toml: change it there. */
#include "run_log.h"

/* clang-format off */
static const char *const remedies[TUMBLE_REASON_COUNT] = {
"""
TAIL = """};
/* clang-format on */

const char *tumble_reason_remedy(tumble_reason_t reason)
{
    const unsigned index = (unsigned)reason;
    return (index < (unsigned)TUMBLE_REASON_COUNT) ? remedies[index] : "This reason is not in the list.";
}
"""


def read(path: Path, root: Path) -> Remedies:
    """Each list of the firmware whole and in its order. Raises TableError."""
    document = read_toml(path)
    found = {}
    for name, header in LISTS.items():
        said = {f"{name}_{key}": words for key, words in document.get(name, {}).items()}
        wanted = [whole for whole, _ in read_list(root / header, name)]
        silent = [whole for whole in wanted if not isinstance(said.get(whole), str) or said[whole] == ""]
        check(not silent, path.name, f"does not say what to do: {', '.join(silent)}")
        check(list(said) == wanted, path.name, f"[{name}] is not the list of {header}, in its order")
        found[name] = said
    return found


def page(root: Path, remedies: Remedies) -> str:
    """The page for operators with its tables as they are to be. Raises TableError."""
    text = (root / PAGE).read_text(encoding="utf-8")
    for name, said in remedies.items():
        before, begin, rest = text.partition(BEGIN.format(name))
        _, end, after = rest.partition(END)
        check(bool(begin and end), PAGE, f"the marks of the table of {name} are missing")
        rows = "".join(f"| {number} | `{whole}` | {words} |\n" for number, (whole, words) in enumerate(said.items()))
        text = f"{before}{begin}{HEADS[name]}\n|---|---|---|\n{rows}{end}{after}"
    return text


def source(remedies: Remedies) -> str:
    """host/programs/remedies.c."""
    rows = (f'    [{name}] = "{in_c(plain(words))}",\n' for name, words in remedies["TUMBLE_REASON"].items())
    return HEAD + "".join(rows) + TAIL


def plain(said: str) -> str:
    """Without Markdown: a link is the page that it leads to."""
    return LINK.sub(lambda link: f"docs/{link[1] or PAGE.removeprefix('docs/')}", said).replace("`", "")


def in_c(said: str) -> str:
    return said.replace("\\", "\\\\").replace('"', '\\"')
