#!/usr/bin/env python3
"""Who may know whom, what firmware may not use, and how long a file or function may be.

    rooms.py [ROOT]     prints file:line: what is wrong; exit 1 if anything is, 2 if ROOT holds no firmware
"""
import ast
import functools
import re
import sys
from pathlib import Path

# A room of firmware/ (or boards) and the rooms whose headers it may include, besides its own.
MAY_INCLUDE = {
    "core": set(),
    "port": {"core"},
    "sample": {"core", "port"},
    "canopen": {"core", "port"},
    "sets": {"core", "port"},
    "stand": {"core", "canopen"},
    "procedure": {"core", "sample", "stand"},
    "navcomp": {"core", "port", "sample", "canopen", "sets", "stand", "procedure"},
    "boards": {"core", "port", "sets", "stand", "navcomp"},  # of stand: which kind the board has
}
# The same for programs of an operating system. A name without a room is beside the file, or in one of these folders.
FIRMWARE = set(MAY_INCLUDE) - {"boards"}
PROGRAMS = {
    "host/simulation": ({"core", "port", "sample", "canopen", "nv"}, []),
    "host/world": (FIRMWARE | {"simulation", "replay"}, ["boards/zcu102"]),
    "host/programs": (FIRMWARE | {"world"}, ["boards/linux"]),
    "host/node": (FIRMWARE | {"world"}, ["host/programs", "boards/linux"]),
    "host/stand": (FIRMWARE | {"world"}, ["host/programs", "boards/linux"]),
    "host/gateway": ({"core", "port", "canopen"}, ["host/programs", "boards/linux"]),
    "host/uml": (set(), []),
    "boards/linux": (FIRMWARE | {"nv"}, []),
}
# A room of the Python package and the rooms that its modules may import. All may import the modules beside the rooms
# (plain data, errors), which import none; the door is the package's own __init__.py.
PACKAGE = "host/python/src/tumble"
EXTENSIONS = {"_tumble_core": "core", "_tumble_world": "world"}  # and the room that each belongs to
BESIDE, DOOR = "(beside the rooms)", "(the door)"
MAY_IMPORT = {
    BESIDE: set(),
    "core": set(),
    "data": set(),
    "model": {"documents"},  # the witness: never of the core, or their agreement means nothing
    "client": {"data", "world"},
    "files": {"core"},
    "documents": {"files"},
    "store": {"documents", "files"},
    "workers": {"files"},
    "solving": {"documents", "core", "model", "files", "workers"},
    "fixture": {"documents", "core", "model", "solving"},
    "planning": {"documents", "core", "model", "files", "solving", "workers"},
    "pictures": {"documents", "core", "model", "files", "solving", "fixture", "planning", "importing"},
    "world": {"documents", "core", "model", "files", "solving", "fixture", "workers", "api"},
    "testing": {"world", "client", "files"},
    "importing": {"documents", "data", "model", "files"},
    "acquisition": {"model", "files", "importing"},
    "comparison": {"documents", "core", "model", "files", "solving", "fixture"},
    "history": {"documents", "model", "files", "store"},
    "report": {"documents", "model", "files", "solving", "pictures", "comparison"},
    "api": {"documents", "core", "model", "files", "solving", "fixture", "comparison", "pictures", "importing",
            "acquisition", "history", "report"},
    "watch": {"documents", "client"},
    "cli": {"documents", "core", "model", "files", "store", "solving", "fixture", "planning", "comparison", "pictures",
            "importing", "acquisition", "world", "report", "history", "api", "client", "watch", "workers", DOOR},
    DOOR: {"core", "data", "model", "files", "solving", "fixture", "planning", "api", "world"},
}
# What a user includes: firmware/include/tumble/NAME.h is the door of the room NAME, these of the core.
OF_THE_CORE = {"status", "version"}
SYSTEM_HEADERS = {"assert.h", "float.h", "limits.h", "stdbool.h", "stddef.h", "stdint.h", "string.h"}
SQUARE_ROOT = "firmware/core/arith.h"  # the one file that may include <math.h>, for sqrt
OWN_ROOT = "boards/mps2_an386/root.c"  # a board's own instead of the library's

HEAP_AND_IO = ("malloc calloc realloc free alloca __builtin_alloca printf fprintf sprintf snprintf vprintf vfprintf "
               "vsnprintf puts putchar fopen fclose fread fwrite scanf sscanf exit abort")
MATH = ("sin cos tan asin acos atan atan2 sinh cosh tanh exp exp2 expm1 log log2 log10 log1p pow hypot cbrt fabs floor "
        "ceil round trunc rint lround fmod remainder fma fmin fmax ldexp frexp isnan isinf isfinite")
FORBIDDEN = {**dict.fromkeys(HEAP_AND_IO.split(), "heap, libc I/O and exits are forbidden in firmware"),
             **dict.fromkeys(MATH.split(), "of <math.h> firmware may use sqrt alone: libraries differ in the last bit")}

DYNAMIC = {"__import__", "import_module"}
STARTS_COMMANDS = "cli/main.py"  # loads a module of cli/commands by its name, which is in the table of commands

MAX_FILE_LINES = 800
MAX_FUNCTION_LINES = 80
HOSTED = ("boards", "linux")  # a board with an operating system: held to sizes, not to what firmware may use
SOURCE_FOLDERS = ["firmware", "boards", "host", "tests", "tools", "examples", "cmake"]
SCRIPTS = {"setup", "site", "test", "tumble", "budget"}  # of tools/, without suffix


def main(arguments):
    if "--help" in arguments:
        print(__doc__.strip())
        return 0
    root = Path(arguments[0] if arguments else Path(__file__).resolve().parents[1])
    firmware = [path for folder in ("firmware", "boards") for path in sorted((root / folder).rglob("*.[ch]"))
                if path.relative_to(root).parts[:2] != HOSTED]
    if not any((root / "firmware") in path.parents for path in firmware):
        print(f"rooms: {root} holds no firmware", file=sys.stderr)
        return 2
    sources = list(find_sources(root))
    programs = [path for folder in PROGRAMS for path in sorted((root / folder).glob("*.[ch]"))]
    modules = sorted((root / PACKAGE).rglob("*.py"))
    violations = [f"{path.relative_to(root)}:{line}: {what}"
                  for check, paths in ((check_firmware, firmware), (check_program, programs), (check_module, modules),
                                      (check_circle, modules), (check_size, sources))
                  for path in paths for line, what in check(root, path)]
    print("\n".join(violations) or f"rooms: {len(firmware)} firmware files, {len(sources)} sources, no violations")
    return 1 if violations else 0


def find_sources(root):
    for folder in SOURCE_FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.is_file() and (path.suffix in (".c", ".h", ".py", ".cmake", ".sh") or path.name in SCRIPTS):
                yield path


def check_firmware(root, path):
    """Yield (line, violation) for the includes and calls of one C file."""
    text = without_comments(path.read_text(encoding="utf-8"))
    location = path.relative_to(root)
    room = room_of(location)
    if room not in MAY_INCLUDE:
        yield 1, f"no such room: {room}; rooms and what they may know stand in tools/rooms.py"
        return
    for number, line in enumerate(text.splitlines(), 1):
        if include := re.match(r"\s*#\s*include\s*(.*)", line):
            if fault := include_fault(root, location, room, include[1].strip()):
                yield number, fault
    code = blank_strings(text)
    for call in re.finditer(r"\b(\w+)\s*\(", code):
        name, number = call[1], code.count("\n", 0, call.start()) + 1
        if name in FORBIDDEN or (name == "sqrt" and location.as_posix() not in (SQUARE_ROOT, OWN_ROOT)):
            yield number, f"{name}: " + FORBIDDEN.get(name, f"the square root is wrapped in {SQUARE_ROOT}")


def room_of(location):
    """The room that a file of firmware/ or boards/ belongs to."""
    if location.parts[:3] == ("firmware", "include", "tumble"):
        return door(location.name)
    return location.parts[1] if location.parts[0] == "firmware" else "boards"


def door(name):
    """The room that a public header is the door of."""
    return "core" if Path(name).stem in OF_THE_CORE else Path(name).stem


def include_fault(root, location, room, target):
    """What is wrong with one include, or None."""
    if system := re.fullmatch(r"<(.+)>", target):
        square_root = system[1] == "math.h" and location.as_posix() == SQUARE_ROOT
        allowed = system[1] in SYSTEM_HEADERS or square_root
        return None if allowed else f"<{system[1]}> is not among the headers that firmware may include"
    quoted = re.fullmatch(r'"([^"]+)"', target)
    if not quoted:
        return f"include of {target}: only a plain name can be checked"
    if room == "boards" and any((folder / quoted[1]).is_file() for folder in (root / location.parent, root / "boards")):
        return None
    places = [root / "firmware" / quoted[1], root / "firmware/include" / quoted[1]]
    if ".." in quoted[1] or not any(place.is_file() for place in places):
        return (f'"{quoted[1]}" is not a header named by its room, such as "core/arith.h", nor a door, such as '
                '"tumble/core.h"')
    folder, name = quoted[1].split("/", 1)
    other = door(name) if folder == "tumble" else folder
    if other == room or other in MAY_INCLUDE[room]:
        return None
    return f"{room} may not know {other}; it may know: {', '.join(sorted(MAY_INCLUDE[room])) or 'no other room'}"


def check_program(root, path):
    """Yield (line, violation) for the includes of one C file of a program."""
    location = path.relative_to(root).parent
    rooms, folders = PROGRAMS[location.as_posix()]
    for number, line in enumerate(without_comments(path.read_text(encoding="utf-8")).splitlines(), 1):
        if include := re.match(r'\s*#\s*include\s*"([^"]+)"', line):
            *room, name = Path(include[1]).parts
            room = [door(name)] if room == ["tumble"] else room
            if room and room[0] not in rooms | {location.name}:
                yield number, f"{location} may not know {room[0]}; it may know: {', '.join(sorted(rooms))}"
            elif not room and not any((root / folder / name).is_file() for folder in [location, *folders]):
                yield number, f'"{name}" is neither beside the file nor in {", ".join(folders) or "another folder"}'


def check_module(root, path):
    """Yield (line, violation) for the imports of one module of the Python package, wherever in it they stand."""
    room = python_room(root, path)
    if room not in MAY_IMPORT:
        yield 1, f"no such room: {room}; rooms and what they may know stand in tools/rooms.py"
        return
    for line, other in python_imports(root, path):
        known = MAY_IMPORT[room]
        if other is None and path.relative_to(root / PACKAGE).as_posix() != STARTS_COMMANDS:
            yield line, "only a plain absolute import can be checked"
        elif other is not None and (its := python_room(root, other)) not in known | {room, BESIDE}:
            yield line, f"{room} may not know {its}; it may know: {', '.join(sorted(known)) or 'no other room'}"


def check_circle(root, path):
    """Yield (line, violation) if a module needs itself. Of a circle its first module is told of."""
    ways, queue = {}, [(path, [])]
    while queue:
        module, way = queue.pop(0)
        for line, other in python_imports(root, module):
            if other is not None and other not in ways:
                ways[other] = [*way, (line, other)]
                queue.append((other, ways[other]))
    circle = ways.get(path, [])
    if circle and path == min(module for _, module in circle):
        names = [module.relative_to(root / PACKAGE).as_posix() for module in (path, *(one for _, one in circle))]
        yield circle[0][0], f"a circle: {' -> '.join(names)}"


def python_room(root, path):
    """The room of a module: a folder of the package, or what stands beside them. Who starts the program is of cli."""
    parts = path.relative_to(root / PACKAGE).parts
    if len(parts) > 1:
        return parts[0]
    return {"__init__.py": DOOR, "__main__.py": "cli"}.get(parts[0], BESIDE)


@functools.cache
def python_imports(root, path):
    """[(line, file)] of the package's modules that a module imports; None: one that is not plain. The extension is the
    core's."""
    found = []
    if not path.is_file():  # the extension module
        return found
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" if node.level == 0 else "" for alias in node.names]
        elif isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) in DYNAMIC:
            names = [""]
        else:
            continue
        found += [(node.lineno, module_file(root, name)) for name in names if is_own(name)]
    return found


def is_own(name):
    return name.partition(".")[0] in ("", "tumble", *EXTENSIONS)


def module_file(root, name):
    """The file of a module, or of the one that holds the name; None for an import that is not plain."""
    if not name:
        return None
    if (extension := name.partition(".")[0]) in EXTENSIONS:
        return root / PACKAGE / EXTENSIONS[extension] / extension
    parts = name.split(".")[1:]
    for length in range(len(parts), 0, -1):
        module = (root / PACKAGE).joinpath(*parts[:length])
        for file in (module.with_suffix(".py"), module / "__init__.py"):
            if file.is_file():
                return file
    return root / PACKAGE / "__init__.py"


def without_comments(text):
    """C text with comments blanked out, line breaks and strings kept."""
    def blank(match):
        return match[0] if match[0][0] in "\"'" else re.sub(r"[^\n]", " ", match[0])

    return re.sub(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|/\*.*?\*/|//[^\n]*', blank, text, flags=re.DOTALL)


def blank_strings(text):
    return re.sub(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', '""', text)


def is_door(path):
    """A public header is a manual, and as long as what it says."""
    return path.parts[-4:-1] == ("firmware", "include", "tumble")


def check_size(_root, path):
    """Yield (line, violation) for a file, or functions in it, that are too long."""
    text = path.read_text(encoding="utf-8")
    lines = text.count("\n") + (not text.endswith("\n"))
    if lines > MAX_FILE_LINES and not is_door(path):
        yield 1, f"{lines} lines; a file may have {MAX_FILE_LINES}"
    functions = {".c": c_functions, ".h": c_functions, ".py": python_functions}.get(path.suffix)
    for line, length in functions(text) if functions else []:
        if length > MAX_FUNCTION_LINES:
            yield line, f"function of {length} lines; a function may have {MAX_FUNCTION_LINES}"


def c_functions(text):
    """(first line, lines) of every function body: a brace at depth 0 that follows a closing parenthesis."""
    depth, begin, before = 0, None, ""
    text = blank_strings(re.sub(r'extern "C" \{', "", without_comments(text)))  # its functions are at depth 0 as well
    for line, content in enumerate(text.split("\n"), 1):
        for mark in re.findall(r"[{}]|[^\s{}]+", content):
            if mark == "{":
                begin = line if depth == 0 and before == ")" else begin
                depth += 1
            elif mark == "}":
                depth -= 1
                if depth == 0 and begin is not None:
                    yield begin, line - begin + 1
                    begin = None
            before = mark[-1]


def python_functions(text):
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            yield node.lineno, node.end_lineno - node.lineno + 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
