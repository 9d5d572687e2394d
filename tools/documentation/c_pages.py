"""Pages of the C reference: a page for each header of firmware/include/tumble, with an anchor for all that has a name."""

import re
from itertools import groupby

from c_headers import FUNCTION, MACRO, OTHER, TYPE, VARIABLE, read_header

FOLDER = "firmware/include/tumble"
INDEX = "reference/c"
ORDER = ("core", "sets", "navcomp", "stand", "port", "status", "version")  # as a reader meets them; others behind
INTRODUCTION = """\
# C

The headers that a program includes. They are manuals: units, ranges, who owns what, and every way to fail. These pages
show them as they are. [Embed the C library](../embedding.md) says how to build with them.

| header | what |
|---|---|
"""
ROLES = {FUNCTION: "c:func", VARIABLE: "c:var", TYPE: "c:type", MACRO: "c:macro"}
WORD = re.compile(r"`[^`]*`|\b(?:tumble|TUMBLE)_\w*|[\\*_\[\]<>|$#~{}^+]")
HEADING = re.compile(r"---- (.*?)\.?(?: ----)?$")


def pages(root):
    """{name of the page: (header in the repository, its text)}; the index stands for the folder."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in (root / FOLDER).glob("*.h")}
    stems = [stem for stem in ORDER if stem in texts] + sorted(set(texts) - set(ORDER))
    headers = {stem: read_header(texts[stem]) for stem in stems}
    roles = {item.name: ROLES[item.kind] for entries in headers.values() for entry in entries
             for item in entry.declared if item.name}  # fmt: skip
    made = {f"{INDEX}-{stem}": (f"{FOLDER}/{stem}.h", page(entries, roles)) for stem, entries in headers.items()}
    return {INDEX: (FOLDER, index(headers, roles)), **made}


def index(headers, roles):
    """The page that leads to the others."""
    rows = [f"| [tumble/{stem}.h](c-{stem}.md) | {prose(' '.join(first_sentence(entries)), roles)} |"
            for stem, entries in headers.items()]  # fmt: skip
    listed = [f"c-{stem}" for stem in headers]
    return INTRODUCTION + "\n".join([*rows, "", "```{toctree}", ":hidden:", "", *listed, "```", ""])


def first_sentence(entries):
    """What the header says of itself, up to the first full stop, without its name."""
    paragraph = " ".join(line.strip() for line in entries[0].comment).split(" - ", 1)[1]
    return [paragraph.split(". ")[0].split(".  ")[0].removesuffix(".")[:1].upper() + paragraph.split(". ")[0][1:]]


def page(entries, roles):
    """Markdown of a header."""
    name, _, rest = entries[0].comment[0].partition(" - ")
    first = [rest[:1].upper() + rest[1:], *entries[0].comment[1:]]
    parts = [f"# {name}", *blocks(first, roles)]
    for entry in entries[1:]:
        parts += shown(entry, roles)
    return "\n\n".join(parts) + "\n"


def shown(entry, roles):
    """An entry: a heading, if its comment is one; what is declared, with what is said of it."""
    lines, parts = entry.comment, []
    if lines and lines[0].startswith("----"):
        title, lines = split_heading(lines)
        parts.append(f"## {title}")
    told = blocks(lines, roles)
    groups = [list(group) for _, group in groupby(entry.declared, key=lambda item: item.kind)]
    if not groups:
        return parts + told
    return parts + [declared(group, told if group is groups[0] else []) for group in groups]


def split_heading(lines):
    """Title, and what is left of a comment such as `---- Schedules: test positions: how the block is mounted.`"""
    text = lines[0]
    rest = lines[1:]
    while rest and rest[0].strip() and not text.rstrip(" -").endswith("."):
        text, rest = f"{text} {rest[0]}", rest[1:]
    title, _, more = HEADING.match(text.strip())[1].partition(": ")
    return title, [*([f"{more[:1].upper()}{more[1:]}."] if more else []), *rest]


def declared(items, told):
    """Declarations of one kind under one comment, and what it says."""
    kind = items[0].kind
    code = [f"```c\n{item.text}\n```" for item in items] if kind != MACRO else [macros(items)]
    if kind == OTHER:
        return "\n\n".join([*told, *code])
    signatures = [item.signature if kind in (FUNCTION, VARIABLE) else item.name for item in items]
    body = [*told, *([] if kind in (FUNCTION, VARIABLE) else code)]
    return "\n".join([f"``````{{c:{kind}}} {signatures[0]}", *signatures[1:], "", "\n\n".join(body), "``````"])


def macros(items):
    return "```c\n" + "\n".join(item.text for item in items) + "\n```"


def blocks(lines, roles):
    """Lines of a comment as Markdown: paragraphs and lists; what is indented by four is code or a table."""
    parts = []
    for is_code, group in groupby(paragraphs(lines), key=lambda part: part[0].startswith("    ")):
        if is_code:
            text = "\n\n".join("\n".join(line[4:] for line in part) for part in group)
            parts.append(f"```{'c' if ';' in text else 'text'}\n{text.rstrip()}\n```")
        else:
            parts += [prose("\n".join(part), roles) for part in group]
    return parts


def paragraphs(lines):
    """Runs of lines that are not empty, and are all indented by four or all not."""
    found = []
    for line in lines:
        if not line.strip():
            found.append([])
        elif found and found[-1] and found[-1][0].startswith("    ") == line.startswith("    "):
            found[-1].append(line)
        else:
            found.append([line])
    return [part for part in found if part]


def prose(text, roles):
    """Plain text as Markdown: names that are declared lead to their declaration, marks of Markdown mean themselves."""
    return WORD.sub(lambda word: escaped(word[0], roles), text)


def escaped(word, roles):
    if word.startswith("`"):
        name = word.strip("`")
        return f"{{{roles[name]}}}{word}" if name in roles else word
    if word in roles:
        return f"{{{roles[word]}}}`{word}`"
    return f"`{word}`" if len(word) > 1 else f"\\{word}"
