"""What to do about each reason to stop, in C, as the page for operators says it: its table is the one place."""

from __future__ import annotations

import re
from pathlib import Path

from kinds import TableError

PAGE = "docs/operations.md"
ROW = re.compile(r"^\| \d+ \| `(TUMBLE_REASON_\w+)` \| (.+) \|$", re.MULTILINE)
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
    """boards/linux/remedies.c. Raises TableError when the page has no such table."""
    rows = ROW.findall((root / PAGE).read_text(encoding="utf-8"))
    if not rows:
        raise TableError(f"{PAGE}: there is no table of reasons")
    return HEAD + "".join(f'    [{name}] = "{in_c(plain(said))}",\n' for name, said in rows) + TAIL


def plain(said: str) -> str:
    """Without the marks of a page: of a link its text, of code the words."""
    return re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", said).replace("`", "")


def in_c(said: str) -> str:
    return said.replace("\\", "\\\\").replace('"', '\\"')
