"""A public header, cut into what it says and what it declares. It reads the layout that clang-format gives to the
headers of firmware/include/tumble, not C at large: what it does not know is an error, never left out in silence."""

import re
from dataclasses import dataclass, field

FUNCTION, VARIABLE, TYPE, MACRO, OTHER = "function", "var", "type", "macro", ""
SKIPPED = re.compile(r"#include |#undef |#ifdef __cplusplus|#endif|}$|extern \"C\" {")
MACRO_NAME = re.compile(r"#define (\w+)")
TYPE_NAME = re.compile(r"^} (\w+);", re.MULTILINE)
CALLED = re.compile(r"^(?:static inline )?[\w\s*]+?\b(\w+)\(")
NAMED = re.compile(r"\b(\w+)(?:\[\w*\])*;")


@dataclass
class Declaration:
    """`kind`: one of those above. `name`: "" where it has none. `text`: as it stands in the header, with its inner
    comments."""

    kind: str
    name: str
    text: str

    @property
    def signature(self):
        """On one line, without body."""
        text = re.sub(r"/\*.*?\*/", "", self.text, flags=re.DOTALL).split("\n{", maxsplit=1)[0]
        return " ".join(text.split()).removesuffix(";").removeprefix("static inline ").removeprefix("extern ")


@dataclass
class Entry:
    """A comment, as lines without its stars, and what is declared below it, up to the next empty line."""

    comment: list
    declared: list = field(default_factory=list)


def read_header(text):
    """The entries of a header, in its order. The first is the manual of the header itself."""
    lines = text.splitlines()
    guard = next(line.split()[1] for line in lines if line.startswith("#ifndef "))
    entries, at, fresh = [Entry([])], 0, False
    while at < len(lines):
        line = lines[at]
        if not line.strip():
            fresh, at = False, at + 1
        elif line.startswith("/*"):
            comment, at = take_comment(lines, at)
            entries.append(Entry(comment))
            fresh = True
        elif guard in line or SKIPPED.match(line):
            at += 1
        else:
            declaration, at = take_declaration(lines, at)
            entries += [] if fresh else [Entry([])]
            entries[-1].declared.append(declaration)
            fresh = True
    return [entry for entry in entries if entry.comment or entry.declared]


def take_comment(lines, at):
    """A comment that begins at the line `at`, as its lines without stars; and the number of the line behind it."""
    end = next(number for number in range(at, len(lines)) if lines[number].rstrip().endswith("*/"))
    inner = [re.sub(r"^(/\*| \*/?) ?", "", line) for line in lines[at : end + 1]]
    inner[-1] = re.sub(r" ?\*/$", "", inner[-1])
    return trimmed(inner), end + 1


def trimmed(lines):
    """Without empty lines at both ends."""
    while lines and not lines[0].strip():
        lines = lines[1:]
    while lines and not lines[-1].strip():
        lines = lines[:-1]
    return lines


def take_declaration(lines, at):
    """What is declared from the line `at` on, and the number of the line behind it."""
    if lines[at].startswith("#if"):
        end = next(number for number in range(at, len(lines)) if lines[number].startswith("#endif"))
    elif lines[at].startswith("#define"):
        end = next(number for number in range(at, len(lines)) if not lines[number].endswith("\\"))
    else:
        end = next(number for number in range(at, len(lines)) if is_end(lines[at : number + 1]))
    while open_comment(lines[at : end + 1]):
        end += 1
    text = "\n".join(line.rstrip() for line in lines[at : end + 1])
    return Declaration(*kind_and_name(text), text), end + 1


def open_comment(lines):
    """Does a comment begin in these lines that does not end in them?"""
    text = "\n".join(lines)
    return text.rfind("/*") > text.rfind("*/")


def is_end(lines):
    """Is a declaration complete with these lines?"""
    text = re.sub(r"/\*.*?(\*/|$)", "", "\n".join(lines), flags=re.DOTALL).rstrip()
    return text.count("{") == text.count("}") and text.endswith((";", "}")) and not text.startswith("#")


def kind_and_name(text):
    """Raises ValueError for what is no declaration of the headers' kinds."""
    if found := MACRO_NAME.match(text):
        return MACRO, found[1]
    if text.startswith("typedef"):
        return TYPE, TYPE_NAME.search(text)[1]
    if text.startswith("extern"):
        return VARIABLE, NAMED.search(text)[1]
    if text.startswith(("#if", "enum", "static_assert")):
        return OTHER, ""
    if text.startswith("struct") and (found := re.match(r"struct (\w+)", text)):
        return TYPE, found[1]
    if found := CALLED.match(text):
        return FUNCTION, found[1]
    raise ValueError(f"no declaration that c_headers.py knows: {text.splitlines()[0]}")
