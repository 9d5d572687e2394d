"""Which functions of the firmware one averaged sample enters, from its frames' arrival to the sum.

    sample_way.py [--table] [--write] [--root FOLDER]

Counted is every function of firmware/ that is entered, each once, in the step of the navigation computer that takes
the two frames of a sample in the middle of a position: from the step's first line to its return. The computer is one
without memory, with a CiA 402 drive. The firmware is compiled with -O0 -finstrument-functions, so that a function that
a compiler would inline counts like any other, also one of a header. --write puts the list into docs/architecture.md.
"""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import costs_page as costs

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/architecture.md"
MOST = 25  # functions
NAME = "sample_way"
INCLUDES = ("firmware", "firmware/include", "host", "tests/lib", "tests/integration/plain_unity")
SOURCES = ("firmware/**/*.c", "tests/benchmark/sample_way/trace.c", "tests/lib/navcomp_bench.c",
           "tests/lib/scripted_*.c", "host/simulation/block_encode.c")
OPTIONS = "-std=c11 -O0 -gdwarf-4 -no-pie -fno-pie -finstrument-functions -DUNITY_INCLUDE_DOUBLE".split()


def way(root=ROOT):
    """[(depth, function, its file)] in the order in which they are entered."""
    with tempfile.TemporaryDirectory() as folder:
        program = built(root, Path(folder))
        lines = [line.split() for line in printed(program).splitlines()]
        addresses = [address for _, address in lines]
        names = printed("addr2line", "-f", "-e", program, *addresses).splitlines()
    found = {}
    for (depth, _), name, place in zip(lines, names[::2], names[1::2], strict=True):
        file = os.path.relpath(place.rpartition(":")[0], root / "firmware")
        if not file.startswith(".."):  # what plays the bus
            found.setdefault((name, file), (int(depth), name, file))
    return list(found.values())


def built(root, folder):
    """The program that traces, of the sources below `root`."""
    compiler = os.environ.get("CC") or shutil.which("cc") or "gcc"
    sources = [path for pattern in SOURCES for path in sorted(root.glob(pattern))]
    includes = [f"-I{root / path}" for path in INCLUDES]
    subprocess.run([compiler, *OPTIONS, *includes, *sources, "-lm", "-o", folder / "trace"], check=True)
    return folder / "trace"


def printed(*command):
    return subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout


def text_of(functions):
    """As docs/architecture.md has it."""
    width = max(len(file) for *_, file in functions) + 2
    rows = [f"{file:{width}}{'  ' * depth}{name}" for depth, name, file in functions]
    files = len({file for *_, file in functions})
    return "\n".join([f"{len(functions)} functions in {files} files, at most {MOST}:", "", "```", *rows, "```"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--table", action="store_true", help="the one of docs/architecture.md, as without it")
    parser.add_argument("--write", action="store_true", help="into the page, too")
    parser.add_argument("--root", type=Path, default=ROOT, help="of the sources, instead of this checkout")
    options = parser.parse_args()
    functions = way(options.root)
    print(text_of(functions))
    if options.write:
        PAGE.write_text(costs.with_part(PAGE.read_text(encoding="utf-8"), NAME, text_of(functions)), encoding="utf-8")
    return 1 if len(functions) > MOST else 0


if __name__ == "__main__":
    sys.exit(main())
