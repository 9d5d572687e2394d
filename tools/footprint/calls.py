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
target whose address nobody holds, and an address made in another way than as a whole word.
"""
import csv
import re

# What the linker leaves in an image: direct branches, words, and references of the unwinding tables.
BRANCHES = {"R_ARM_THM_CALL", "R_ARM_THM_JUMP24", "R_ARM_THM_JUMP19", "R_ARM_THM_JUMP11", "R_ARM_THM_JUMP8",
            "R_ARM_CALL", "R_ARM_JUMP24"}
HARMLESS = BRANCHES | {"R_ARM_NONE", "R_ARM_PREL31"}
WORD = "R_ARM_ABS32"
LOADED = (".text", ".rodata", ".ARM.ex", ".data", ".init_array", ".fini_array")
BOARD = "board"


class Unlisted(Exception):
    """The list and the image disagree; the message says in what."""


class Calls:
    """Where the indirect calls of one image lead."""

    def __init__(self, path, symbols_text, relocations_text, contents_text):
        """`symbols_text` from `nm -S`, `relocations_text` from `readelf -rW`, `contents_text` from `objdump -s`."""
        self._path = path
        self._functions, self._tables = read_symbols(symbols_text)
        self._words = held_words(relocations_text, contents_of(contents_text))
        self._used = set()
        with open(path, newline="", encoding="utf-8") as file:
            self._listed = {row["caller"]: row["targets"].split() for row in csv.DictReader(file)}
        self._targets = {caller: self._resolve(caller, items) for caller, items in self._listed.items()}

    def targets(self, caller):
        """Addresses of the functions that `caller` may call through a pointer; None if it has no entry."""
        self._used.add(plain(caller))
        return self._targets.get(plain(caller))

    def faults(self):
        """What is wrong with the list, after a walk has asked for all the calls that there are."""
        starts = {address: name for name, addresses in self._functions.items() for address in addresses}
        held = {value & ~1 for value in self._words.values() if value & 1 and value & ~1 in starts}
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
        return {self._words[cell] & ~1 for cell in cells if cell in self._words}


def plain(name):
    """The name that a symbol has in the source."""
    return name.split(".", 1)[0]


def read_symbols(symbols_text):
    """Functions (name: addresses) and data (name: (address, size) pairs) of an image."""
    functions, tables = {}, {}
    for address, size, kind, name in re.findall(r"^([0-9a-f]+) ([0-9a-f]+) (\w) (\S+)$", symbols_text, re.MULTILINE):
        if kind in "tTW":
            functions.setdefault(plain(name), set()).add(int(address, 16) & ~1)
        else:
            tables.setdefault(plain(name), set()).add((int(address, 16), int(size, 16)))
    return functions, tables


def held_words(relocations_text, contents):
    """The words of an image that hold an address: place to value."""
    loaded = _parts(relocations_text, r"^Relocation section '\.rel(\.\S+)'")
    found = re.findall(r"^([0-9a-f]{8})\s+[0-9a-f]{8}\s+(R_\w+)", loaded, re.MULTILINE)
    if not found:
        raise Unlisted("the image was linked without --emit-relocs")
    strange = sorted({kind for _, kind in found} - HARMLESS - {WORD})
    if strange:
        raise Unlisted(f"addresses are made in ways that this tool does not follow: {', '.join(strange)}")
    places = [int(place, 16) for place, kind in found if kind == WORD]
    return {place: sum(contents[place + i] << (8 * i) for i in range(4)) for place in places}


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
