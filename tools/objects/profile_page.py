"""docs/porting.md: its table of the drive profile's fields, from firmware/stand/drive402/profile_fields.h."""

from __future__ import annotations

import re
from pathlib import Path

from rules import check

PAGE = "docs/porting.md"
FIELDS = "firmware/stand/drive402/profile_fields.h"
ROW = re.compile(r'X\((\w+), (\w+), (\S+), \w+, \w+, \d+, "([\w.]+)", (\S+), (\S+), "([^"]*)"\)')
BEGIN, END = "<!-- The table is written by tools/objects/generate. -->\n", "<!-- End of the table. -->"
HEAD = "| key | in C | standard | what may be given |  |\n|---|---|---|---|---|\n"
WORDS = {"UINT32_MAX": "4294967295", "UINT16_MAX": "65535", "INT32_MAX": "2147483647", "INT8_MIN": "-128",
         "INT8_MAX": "127", "TUMBLE_STOP_BY_QUICK_STOP": "quick_stop", "true": "yes", "false": "no"}


def page(root: Path) -> str:
    """The page with its table as it is to be. Raises TableError."""
    text = (root / PAGE).read_text(encoding="utf-8")
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    check(bool(begin and end), PAGE, "the marks of its table are missing")
    return before + begin + table((root / FIELDS).read_text(encoding="utf-8")) + end + after


def table(header: str) -> str:
    joined = re.sub(r"\s*\\\n\s*", " ", header)
    rows = ROW.findall(joined)
    check(len(rows) == len(re.findall(r"\bX\(\w+, ", joined)), FIELDS, "a row is not as it should be")
    return HEAD + "".join(line(*row) for row in rows)


def line(kind: str, member: str, standard: str, key: str, low: str, high: str, about: str) -> str:
    if kind == "ENUM8":
        allowed, about = " or ".join(about.split("|")), "how it is told to stop"
    else:
        allowed = "no or yes" if kind == "BOOL" else f"{words(low)} to {words(high)}"
    return f"| `{key}` | `{member}` | {words(standard)} | {allowed} | {about} |\n"


def words(value: str) -> str:
    return WORDS.get(value, value.removesuffix("U"))
