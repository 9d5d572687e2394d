"""tools/rooms.py names file and line of whatever breaks the rules of docs/architecture.md,
and accepts what does not."""
import pytest
from conftest import run

PACKAGE = "host/python/src/tumble"
CLEAN = {
    "firmware/include/tumble/core.h": "int core;\n" * 900,
    "firmware/include/tumble/status.h": "int status;\n",
    "firmware/core/arith.h": "#include <math.h>\nstatic double root(double x) { return sqrt(x); }\n",
    "firmware/core/means.c": '#include "tumble/core.h"\n#include <stdint.h>\n/* malloc( and <stdio.h> are banned */\n'
                             'const char *text = "free(";\n',
    "firmware/include/tumble/port.h": '#include <stdint.h>\n#include "tumble/status.h"\n',
    "firmware/navcomp/objects.c": "int a;\n" * 800,
    "firmware/navcomp/step.c": '#include "core/arith.h"\n#include "tumble/port.h"\n',
    "boards/demo/port.c": '#include "tumble/port.h"\n#include "uart.h"\n',
    "boards/demo/uart.h": "int uart;\n",
    "boards/linux/can.h": "int can;\n",
    "host/gateway/poll.c": '#include "can.h"\n#include "canopen/node.h"\n',
    "tools/demo.py": "def short():\n" + "    pass\n" * 79,
    f"{PACKAGE}/__init__.py": "from tumble._version import __version__\n",
    f"{PACKAGE}/_version.py": '__version__ = "1"\n',
    f"{PACKAGE}/__main__.py": "from tumble.cli.main import main\n",
    f"{PACKAGE}/errors.py": "import sys\n",
    f"{PACKAGE}/core/__init__.py": "from tumble.core.binding import estimate\n",
    f"{PACKAGE}/core/binding.py": "from _tumble_core import lib\nfrom tumble import errors\n",
    f"{PACKAGE}/model/__init__.py": "import numpy\n",
    f"{PACKAGE}/solving/solution.py": "from tumble import core, model\nfrom tumble.solving.result import write\n",
    f"{PACKAGE}/solving/result.py": "def write():\n    from tumble import errors\n",
    f"{PACKAGE}/cli/main.py": "from tumble import __version__\nimport tumble.solving.result\nf = import_module(name)\n",
    "firmware/core/long.c": "int f(void)\n{\n" + "    g;\n" * 78 + "}\n",
}
LONG_FUNCTION_C = "int f(void)\n{\n" + "    if (x) {\n    }\n" * 40 + "}\n"
DEFECTS = {
    "core knows port": ("firmware/core/means.c", '\n#include "tumble/port.h"\n', "2: core may not know port"),
    "port knows canopen": (
        "firmware/include/tumble/port.h",
        '#include "canopen/node.h"\n',
        '1: "canopen/node.h" is not a header',
    ),
    "stand knows port": ("firmware/stand/a.c", '#include "tumble/port.h"\n', "1: stand may not know port"),
    "a way round": ("firmware/core/means.c", '#include "../tumble/port.h"\n', '1: "../tumble/port.h" is not a header'),
    "a hidden name": ("firmware/core/means.c", "#include HEADER\n", "1: include of HEADER"),
    "an unknown room": ("firmware/attic/a.c", "int a;\n", "1: no such room: attic"),
    "a program's own rooms": (
        "host/gateway/poll.c",
        '#include "tumble/navcomp.h"\n',
        "1: host/gateway may not know navcomp",
    ),
    "a program next door": ("boards/linux/can.h", '\n#include "poll.h"\n', '2: "poll.h" is neither beside the file'),
    "a board knows the host": (
        "boards/linux/can.h",
        '#include "world/world.h"\n',
        "1: boards/linux may not know world",
    ),
    "a stranger next door": ("host/node/a.c", '#include "poll.h"\n', '1: "poll.h" is neither beside the file nor in'),
    "stdio": ("firmware/core/means.c", "#include <stdio.h>\n", "1: <stdio.h> is not among the headers"),
    "math": ("firmware/core/means.c", "#include <math.h>\n", "1: <math.h> is not among the headers"),
    "heap": ("firmware/core/means.c", "int a;\nvoid *b = malloc(4);\n", "2: malloc: heap, libc I/O"),
    "heap on two lines": ("firmware/core/means.c", "int a;\nvoid *b = malloc\n    (4);\n", "2: malloc: heap, libc I/O"),
    "heap on a board": ("boards/demo/port.c", "void *b = calloc (4, 1);\n", "1: calloc: heap, libc I/O"),
    "print": ("firmware/core/means.c", "int a = printf(text);\n", "1: printf: heap, libc I/O"),
    "sine": ("firmware/core/arith.h", "double b = sin(a);\n", "1: sin: of <math.h> firmware may use sqrt alone"),
    "square root": ("firmware/core/means.c", "double b = sqrt(a);\n", "1: sqrt: the square root is wrapped in"),
    "a witness of the core": (
        f"{PACKAGE}/model/a.py",
        "import os\nfrom tumble.core import estimate\n",
        "2: model may not know core; it may know: documents",
    ),
    "a witness of the extension": (
        f"{PACKAGE}/model/a.py",
        "def f():\n    import _tumble_core\n",
        "2: model may not know core",
    ),
    "a room upwards": (f"{PACKAGE}/core/a.py", "import tumble.cli.main\n", "1: core may not know cli"),
    "a room in a function": (
        f"{PACKAGE}/schedule.py",
        "def f():\n    from tumble.core.binding import lib\n",
        "2: (beside the rooms) may not know core",
    ),
    "the package's own door": (f"{PACKAGE}/solving/a.py", "import tumble\n", "1: solving may not know (the door)"),
    "an import by name": (f"{PACKAGE}/model/a.py", "f = __import__(name)\n", "1: only a plain absolute import"),
    "a command by name": (f"{PACKAGE}/cli/a.py", "f = import_module(name)\n", "1: only a plain absolute import"),
    "a relative import": (f"{PACKAGE}/solving/a.py", "from .result import write\n", "1: only a plain absolute import"),
    "an unknown Python room": (f"{PACKAGE}/attic/a.py", "import os\n", "1: no such room: attic"),
    "a circle": (
        f"{PACKAGE}/solving/result.py",
        "def write():\n    from tumble.solving.solution import solve\n",
        "2: a circle: solving/result.py -> solving/solution.py -> solving/result.py",
    ),
    "long file": ("firmware/core/means.c", "int a;\n" * 801, "1: 801 lines; a file may have 800"),
    "long C function": ("firmware/core/means.c", LONG_FUNCTION_C, "2: function of 82 lines"),
    "long C function for C++ too": (
        "firmware/include/tumble/port.h",
        'extern "C" {\n' + LONG_FUNCTION_C + "}\n",
        "3: function of 82 lines",
    ),
    "long Python function": ("tools/demo.py", "def f():\n" + "    pass\n" * 80, "1: function of 81 lines"),
}


def plant(root, files):
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return run("tools/rooms.py", root)


def test_accepts_a_clean_tree(tmp_path):
    result = plant(tmp_path, CLEAN)
    assert (result.returncode, result.stdout) == (0, "rooms: 10 firmware files, 23 sources, no violations\n")


@pytest.mark.parametrize("name", DEFECTS)
def test_rejects(tmp_path, name):
    file, text, message = DEFECTS[name]
    result = plant(tmp_path, {**CLEAN, file: text})
    assert result.returncode == 1
    lines = result.stdout.splitlines()
    assert len(lines) == 1 and lines[0].startswith(f"{file}:{message}"), result.stdout


def test_a_place_without_firmware_is_an_error(tmp_path):
    result = run("tools/rooms.py", tmp_path)
    assert (result.returncode, result.stdout) == (2, f"rooms: {tmp_path} holds no firmware\n")
