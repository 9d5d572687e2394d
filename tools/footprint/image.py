"""What a linked image holds, told apart by origin: the objects of a part, and the libraries that they pull in."""
import os
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

SECTION = re.compile(r"^ (\.\S+|COMMON)\s+0x([0-9a-f]+)\s+0x([0-9a-f]+) (\S.*)$", re.MULTILINE)
FLASH, INITIALISED, ZEROED = (".text", ".rodata", ".ARM.ex"), (".data",), (".bss", "COMMON")

# All that a part may ask of the tool chain: arithmetic helpers, block moves, the square root.
ALLOWED_IMPORTS = re.compile(r"__aeabi_\w+|__\w+[sdt]i\d?|mem(cpy|set|move|cmp)|sqrt")

# What the compiler calls for floating point where no hardware does it.
FLOATING_POINT = re.compile(r"__aeabi_(c?[df]\w*|\w+2[df])|sqrt")


@dataclass
class Sizes:
    """Bytes."""
    code: int      # instructions, constants and initial values of the part itself
    library: int   # the same of the library members linked with it
    static_ram: int  # initialised and zeroed data of both
    flash_padding: int = 0  # what the linker puts between these: it belongs to nobody
    ram_padding: int = 0


def measure(map_text, objects):
    """Sizes from a linker map, where `objects` are the part's own object files."""
    own = tuple(os.path.abspath(name) for name in objects)
    sizes = Sizes(0, 0, 0)
    for name, address, length, origin in SECTION.findall(_contents(map_text)):
        length = int(length, 16) if int(address, 16) else 0  # address 0: thrown away, or debug information
        if name.startswith(FLASH + INITIALISED):
            if any(name.endswith(os.path.normpath(origin)) for name in own):
                sizes.code += length
            else:
                sizes.library += length
        if name.startswith(INITIALISED + ZEROED):
            sizes.static_ram += length
    sizes.flash_padding, sizes.ram_padding = _padding(_contents(map_text))
    return sizes


def _padding(contents):
    """Bytes of padding inside the sections of flash, and of RAM."""
    section, flash, ram = "", 0, 0
    for name, length in re.findall(r"^(?:(\.\S+)| \*fill\*\s+0x[0-9a-f]+\s+0x([0-9a-f]+))", contents, re.MULTILINE):
        section = name or section
        flash += int(length or "0", 16) if section.startswith(FLASH + INITIALISED) else 0
        ram += int(length or "0", 16) if section.startswith(INITIALISED + ZEROED) else 0
    return flash, ram


def _contents(map_text):
    """The memory map alone, entries that the linker broke after a long name put back on one line."""
    text = map_text.split("Linker script and memory map", 1)[1]
    return re.sub(r"^( \S+)\n\s+(0x)", r"\1 \2", text, flags=re.MULTILINE)


def loaded(size_text):
    """(flash, RAM) bytes of the whole image from `size -A`: the witness for `measure`."""
    flash = ram = 0
    for name, length in re.findall(r"^(\.\S+)\s+(\d+)\s+\d+$", size_text, re.MULTILINE):
        flash += int(length) if name.startswith(FLASH + INITIALISED) else 0
        ram += int(length) if name.startswith(INITIALISED + ZEROED) else 0
    return flash, ram


def script_names(map_text):
    """The names that the linker script defines."""
    return set(re.findall(r"^\s+0x[0-9a-f]+\s+(\w+) = ", _contents(map_text), re.MULTILINE))


def foreign_imports(undefined_text, defined):
    """'object: symbol' for every symbol that an object takes from outside the part and may not.

    `undefined_text` from `nm -A -u`, `defined` the names that the part's objects define.
    """
    wanted = re.findall(r"^(\S+?):\s+[Uw] (\S+)$", undefined_text, re.MULTILINE)
    return [f"{Path(origin).name} needs {symbol}" for origin, symbol in wanted
            if symbol not in defined and not ALLOWED_IMPORTS.fullmatch(symbol)]


def floating_faults(ci_texts, integer):
    """What is wrong with the functions `integer`, which are to reach no floating point by direct calls.

    `ci_texts` are what the compiler says of the calls in each object, from -fcallgraph-info.
    """
    calls, defined = {}, set()
    for text in ci_texts:
        defined |= set(re.findall(r'node: \{ title: "([^"]+)" label: "[^"]*?\\n\d+ bytes', text))
        for caller, callee in re.findall(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', text):
            calls.setdefault(caller, set()).add(callee)
    names = {title: title.rsplit(":", 1)[-1] for title in sorted(defined)}  # of a static one after its file's
    ways = [_way_to_floating_point(calls, title, set()) for title, name in names.items() if name in integer]
    return ([f"no object has a function {name}" for name in integer if name not in names.values()] +
            [f"{way[0]} takes floating point: {' > '.join(way)}" for way in ways if way])


def _way_to_floating_point(calls, name, seen):
    """The names from a function to one that is floating point; empty if there is no way."""
    seen.add(name)
    if FLOATING_POINT.fullmatch(name):
        return [name]
    ways = (_way_to_floating_point(calls, callee, seen) for callee in sorted(calls.get(name, set()) - seen))
    return next(([name.rsplit(":", 1)[-1], *way] for way in ways if way), [])


def functions(symbols_text):
    """[(name, address, size)] of the functions of an image, from `nm -S`."""
    found = re.findall(r"^([0-9a-f]+) ([0-9a-f]+) [tTW] (\S+)$", symbols_text, re.MULTILINE)
    return [(name, int(address, 16) & ~1, int(size, 16)) for address, size, name in found]


def by_address(functions):
    """The same, those together that are one function under several names (identical ones are merged)."""
    groups = {}
    for entry in functions:
        groups.setdefault(entry[1], []).append(entry)
    return list(groups.values())


def compiler_frames(ci_text):
    """What the compiler says of its frames, from -fcallgraph-info=su,da: Counter of (function, bytes), and the names
    of functions whose frame it calls dynamic."""
    frames, dynamic = Counter(), []
    nodes = re.findall(r'node: \{ title: "([^"]+)" label: "[^"]*?\\n(\d+) bytes \(([a-z,]+)\)\\n(\d+) dynamic', ci_text)
    for title, size, kind, objects in nodes:
        name = title.rsplit(":", 1)[-1]
        frames[name, int(size)] += 1
        if kind == "dynamic" or (int(objects) and "bounded" not in kind):
            dynamic.append(name)
    return frames, dynamic
