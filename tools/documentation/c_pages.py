"""Pages of the C reference: a page for each header of firmware/include/tumble, an anchor for all that has a name."""

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
WORD = re.compile(r"`[^`]*`|\bdocs/[\w/-]+\.md\b|\b(?:tumble|TUMBLE)_\w*|[\\*_\[\]<>|$#~{}^+]")
ROW = re.compile(r'^ +X\((\w+),[\s\\]+"([^"]*)"\)', re.MULTILINE)  # of a list of names, each with its sentence
HEADING = re.compile(r"---- (.*?)\.?(?: ----)?$")


def pages(root):
    """{name of the page: (header in the repository, its text)}; the index stands for the folder."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in (root / FOLDER).glob("*.h")}
    stems = [stem for stem in ORDER if stem in texts] + sorted(set(texts) - set(ORDER))
    headers = {stem: read_header(texts[stem]) for stem in stems}
    roles = roles_of([item for entries in headers.values() for entry in entries for item in entry.declared])
    made = {f"{INDEX}-{stem}": (f"{FOLDER}/{stem}.h", page(entries, roles)) for stem, entries in headers.items()}
    return {INDEX: (FOLDER, index(headers, roles)), **made}


def roles_of(items):
    """{name: how MyST refers to it} of all that is declared, and of what stands in lists of names."""
    named = {name: "c:enumerator" for item in items for name, _ in ROW.findall(item.text)}
    return {**named, **{item.name: ROLES[item.kind] for item in items if item.name}}


def index(headers, roles):
    """The page that leads to the others."""
    rows = [f"| [tumble/{stem}.h](c-{stem}.md) | {prose(first_sentence(entries), roles)} |"
            for stem, entries in headers.items()]  # fmt: skip
    listed = [f"c-{stem}" for stem in headers]
    return INTRODUCTION + "\n".join([*rows, "", "```{toctree}", ":hidden:", "", *listed, "```", ""])


def first_sentence(entries):
    """What the header says of itself, up to the first full stop, without its name."""
    paragraph = paragraphs(entries[0].comment)[0]
    return capital(" ".join(paragraph).partition(" - ")[2].partition(". ")[0].removesuffix("."))


def capital(text):
    return text[:1].upper() + text[1:]


def page(entries, roles):
    """Markdown of a header."""
    name, _, rest = entries[0].comment[0].partition(" - ")
    parts = [f"# {name}", *blocks([capital(rest), *entries[0].comment[1:]], roles)]
    for entry in entries[1:]:
        parts += shown(entry, roles)
    return "\n\n".join(parts) + "\n"


def shown(entry, roles):
    """An entry: what is declared, with what is said of it; or a heading, what is said of its section, and then what is
    declared."""
    groups = [list(group) for _, group in groupby(entry.declared, key=lambda item: item.kind)]
    if entry.comment and entry.comment[0].startswith("----"):
        title, lines = split_heading(entry.comment)
        return [f"## {title}", *blocks(lines, roles), *(declared(group, []) for group in groups)]
    told = blocks(entry.comment, roles)
    if not groups:
        return told
    main = next((group for group in groups if group[0].kind == FUNCTION), groups[0])
    return [declared(group, told if group is main else []) for group in groups]


def split_heading(lines):
    """Title, and what is left of a comment such as `---- Schedules: test positions: how the block is mounted.`"""
    text = lines[0]
    rest = lines[1:]
    while rest and rest[0].strip() and not text.rstrip(" -").endswith("."):
        text, rest = f"{text} {rest[0]}", rest[1:]
    title, _, more = HEADING.match(text.strip())[1].partition(": ")
    end = "" if more.endswith("?") else "."
    return title, [*([f"{capital(more)}{end}"] if more else []), *rest]


def declared(items, told):
    """Declarations of one kind under one comment, and below the last of them what it says."""
    kind = items[0].kind
    rows = ROW.findall(items[0].text) if kind == MACRO else []
    if kind == OTHER:
        return "\n\n".join([*told, code(items)])
    has_code = kind in (TYPE, MACRO) and not rows
    names = [item.name if kind in (TYPE, MACRO) else item.signature for item in items]
    body = [*told, *([code(items)] if has_code else [])]
    parts = [directive(kind, name, body if name == names[-1] else []) for name in names]
    return "\n\n".join([*parts, *(directive("enumerator", name, [f"{capital(told)}."]) for name, told in rows)])


def directive(kind, signature, body):
    """What Sphinx makes an anchor of, and a line of its index."""
    return "\n".join([f"``````{{c:{kind}}} {signature}", "", "\n\n".join(body), "``````"])


def code(items):
    """As it stands in the header; what has bodies with an empty line between."""
    between = "\n" if all("\n" not in item.text or item.kind == MACRO for item in items) else "\n\n"
    return f"```c\n{between.join(item.text for item in items)}\n```"


def blocks(lines, roles):
    """Lines of a comment as Markdown: paragraphs and lists; what is indented by four is code or a table."""
    parts = []
    for is_code, group in groupby(paragraphs(lines), key=lambda part: is_indented(part[0])):
        if is_code:
            text = "\n\n".join("\n".join(line[4:] for line in part) for part in group)
            parts.append(f"```{'c' if ';' in text else 'text'}\n{text.rstrip()}\n```")
        else:
            parts += [prose("\n".join(part), roles) for part in group]
    return parts


def paragraphs(lines):
    """Runs of lines that are not empty, and are all code or all prose. What a function returns has a run of its own."""
    found = [[]]
    for line in lines:
        if not line.strip():
            found.append([])
        elif found[-1] and (line.startswith("Returns ") or is_indented(line) != is_indented(found[-1][0])):
            found.append([line])
        else:
            found[-1].append(line)
    return [part for part in found if part]


def is_indented(line):
    return line.startswith("    ")


def prose(text, roles):
    """Plain text as Markdown: names that are declared lead to their declaration, marks of Markdown mean themselves."""
    return WORD.sub(lambda word: escaped(word[0], roles), text)


def escaped(word, roles):
    """One word or mark that WORD has found, as Markdown."""
    if word.startswith("docs/"):
        return f"[{word}](../{word.removeprefix('docs/')})"
    if word.startswith("`"):
        name = word.strip("`")
        return f"{{{roles[name]}}}{word}" if name in roles else word
    if word in roles:
        return f"{{{roles[word]}}}`{word}`"
    return f"`{word}`" if len(word) > 1 else f"\\{word}"
