"""Indirect calls: a committed list of where each may lead, held against the linked image.

The list is a CSV file (caller,targets). A caller is a function that calls through a pointer; its targets, separated by
blanks, are of three kinds:

    name               every function of the image with that name
    table+offset/row   the pointers in one column of a const table, read from the image (bytes to it, bytes per row)
    board              code of the board (port, hooks), whose stack is the board's own matter

Names are those of the source: what the compiler appends to one (name.0, name.isra.0) does not count. A caller that is
inlined is the function that it has become a part of.

It cannot be forgotten. Linked with --emit-relocs, the image tells where it holds addresses: a function whose address is
held, and which no entry names, is refused, and so is a call that has no entry, an entry without its call, a named
target whose address nobody holds, and an address made in a way that this tool does not follow. An entry without targets
is a pointer that nobody sets in this image.
"""
import csv
import re

LOADED = (".text", ".rodata", ".ARM.ex", ".data", ".init_array", ".fini_array")
BOARD = "board"


class Unlisted(Exception):
    """The list and the image disagree; the message says in what."""


class Calls:
    """Where the indirect calls of one image lead."""

    def __init__(self, path, instructions, symbols_text, relocations_text, contents_text):
        """`instructions` is the module of the instruction set; `symbols_text` from `nm -S`, `relocations_text` from
        `readelf -rW`, `contents_text` from `objdump -s`."""
        self._path = path
        self._function_at = instructions.function_at
        self._functions, self._tables = read_symbols(symbols_text)
        found = relocations(relocations_text, instructions)
        self._words = held_words(found, contents_of(contents_text), instructions)
        self._made = {value for _, kind, value in found if kind in instructions.MADE_IN_CODE}
        self._used = set()
        with open(path, newline="", encoding="utf-8") as file:
            self._listed = {row["caller"]: row["targets"].split() for row in csv.DictReader(file)}
        self._targets = {caller: self._resolve(caller, items) for caller, items in self._listed.items()}

    def targets(self, caller):
        """Addresses of the functions that `caller` may call through a pointer; None if it has no entry."""
        self._used.add(source_name(caller))
        return self._targets.get(source_name(caller))

    def faults(self):
        """What is wrong with the list, after a walk has asked for all the calls that there are."""
        starts = {address: name for name, addresses in self._functions.items() for address in addresses}
        held = {self._function_at(value) for value in {*self._words.values(), *self._made}} & set(starts)
        called = set().union(*self._targets.values())
        stale = sorted(set(self._listed) - self._used)
        return ([f"{self._path}: {starts[address]} has its address taken and is nobody's target"
                 for address in sorted(held - called)] +
                [f"{self._path}: {starts[address]} is a target, and nobody holds its address"
                 for address in sorted(called - held)] +
                [f"{self._path}: {caller} calls nothing through a pointer" for caller in stale])

    def _resolve(self, caller, items):
        targets = set()
        for item in items:
            if column := re.fullmatch(r"(\w+)\+(\d+)/(\d+)", item):
                targets |= self._column(caller, column[1], int(column[2]), int(column[3]))
            elif item != BOARD and item not in self._functions:
                raise Unlisted(f"{self._path}: {caller}: the image has no function {item}")
            else:
                targets |= self._functions.get(item, set())
        return targets

    def _column(self, caller, table, offset, row):
        if len(self._tables.get(table, ())) != 1:
            raise Unlisted(f"{self._path}: {caller}: the image has {len(self._tables.get(table, ()))} tables {table}")
        (start, size), = self._tables[table]
        if row == 0 or size % row or offset >= row:
            raise Unlisted(f"{self._path}: {caller}: {table} of {size} B has no column {offset} of rows of {row} B")
        cells = range(start + offset, start + size, row)
        return {self._function_at(self._words[cell]) for cell in cells if cell in self._words}


def source_name(name):
    """The name that a symbol has in the source."""
    return name.split(".", 1)[0]


def read_symbols(symbols_text):
    """Functions (name: addresses) and data (name: (address, size) pairs) of an image."""
    functions, tables = {}, {}
    for address, size, kind, name in re.findall(r"^([0-9a-f]+) ([0-9a-f]+) (\w) (\S+)$", symbols_text, re.MULTILINE):
        if kind in "tTW":
            functions.setdefault(source_name(name), set()).add(int(address, 16) & ~1)
        else:
            tables.setdefault(source_name(name), set()).add((int(address, 16), int(size, 16)))
    return functions, tables


def relocations(relocations_text, instructions):
    """(place, kind, value of its symbol with what is added to that) of all that the linker has filled in."""
    loaded = _parts(relocations_text, r"^Relocation section '\.rela?(\.\S+)'")
    line = r"^([0-9a-f]{8,16})\s+[0-9a-f]{8,16}\s+(R_\w+)(?:[ \t]+([0-9a-f]{8,16})[ \t]+\S+)?(?: ([+-] [0-9a-f]+))?"
    found = [(int(place, 16), kind, int(value or "0", 16) + int(more.replace(" ", "") or "0", 16))
             for place, kind, value, more in re.findall(line, loaded, re.MULTILINE)]
    if not found:
        raise Unlisted("the image was linked without --emit-relocs")
    known = instructions.HARMLESS | instructions.MADE_IN_CODE | {instructions.WORD}
    strange = sorted({kind for _, kind, _ in found} - known)
    if strange:
        raise Unlisted(f"addresses are made in ways that this tool does not follow: {', '.join(strange)}")
    return found


def held_words(found, contents, instructions):
    """The words of an image that hold an address: place to value."""
    places = [place for place, kind, _ in found if kind == instructions.WORD]
    return {place: sum(contents[place + i] << (8 * i) for i in range(instructions.WORD_BYTES)) for place in places}


def contents_of(contents_text):
    """Bytes by address, from `objdump -s`."""
    found, loaded = {}, _parts(contents_text, r"^Contents of section (\.\S+):")
    for address, words in re.findall(r"^ ([0-9a-f]+) ((?:[0-9a-f]{2,8} ){1,4})", loaded, re.MULTILINE):
        found.update(enumerate(bytes.fromhex(words.replace(" ", "")), int(address, 16)))
    return found


def _parts(text, heading):
    """The parts of a listing that are about sections of the image in memory, by the section's name in each heading."""
    pieces = re.split(heading, text, flags=re.MULTILINE)
    return "\n".join(body for name, body in zip(pieces[1::2], pieces[2::2]) if name.startswith(LOADED))
