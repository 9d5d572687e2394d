"""What to do about each reason to stop, in C, as the page for operators says it: its table is the one place."""

from __future__ import annotations

import re
from pathlib import Path

from kinds import TableError

PAGE = "docs/operations.md"
ROW = re.compile(r"^\| \d+ \| `(TUMBLE_(?:REASON|OBJECTION)_\w+)` \| (.+) \|$", re.MULTILINE)
LINK = re.compile(r"\[[^\]]*\]\(([^)#]*)(?:#[^)]*)?\)")
REASON = "TUMBLE_REASON_"
HEAD = """/* Written by tools/objects/generate from docs/operations.md: change it there. */
#include "remedies.h"

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


def source(root: Path) -> str:
    """boards/linux/remedies.c. Raises TableError when the page has no table of reasons."""
    said = remedies((root / PAGE).read_text(encoding="utf-8"))
    rows = [f'    [{name}] = "{in_c(words)}",\n' for name, words in said.items() if name.startswith(REASON)]
    if not rows:
        raise TableError(f"{PAGE}: there is no table of reasons")
    return HEAD + "".join(rows) + TAIL


def remedies(page: str) -> dict[str, str]:
    """What the page says of each reason and objection, as plain text."""
    return {name: plain(said) for name, said in ROW.findall(page)}


def plain(said: str) -> str:
    """Without Markdown: a link is the page that it leads to."""
    return LINK.sub(lambda link: f"docs/{link[1] or PAGE.removeprefix('docs/')}", said).replace("`", "")


def in_c(said: str) -> str:
    return said.replace("\\", "\\\\").replace('"', '\\"')
