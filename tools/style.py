#!/usr/bin/env python3
"""Hold the sources to their style: the layout of C and of the package `tumble`, what ruff finds in Python, and the
types of the package.

    style.py [--fix] [layout|lint|types]...     exit 1 when something is found, 77 when a tool is not there

Without names all three. --fix lays out anew, and mends what ruff can mend by itself. The tools are pinned in
tools/requirements-style.txt; what they are told stands in .clang-format and host/python/pyproject.toml.
"""
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
C_FOLDERS = ("boards", "examples", "firmware", "host", "tests", "tools")
RUFF_CACHE = ("--cache-dir", "build/style/ruff")
NOT_THERE = 77
MOST_TOLD = 160  # characters of a command that is shown


def layout(fix):
    """.clang-format-ignore leaves out what tools/objects/generate writes. Of Python the package alone has a layout:
    tests and tools have tables that people align."""
    files = sorted(str(path.relative_to(ROOT)) for folder in C_FOLDERS for path in (ROOT / folder).rglob("*.[ch]"))
    return worst(run("clang-format", *(["-i"] if fix else ["--dry-run", "--Werror"]), *files),
                 run("ruff", "format", "--quiet", *RUFF_CACHE, *([] if fix else ["--diff"]), "host/python/src"))


def lint(fix):
    return run("ruff", "check", "--quiet", *RUFF_CACHE, "--output-format=concise", *(["--fix"] if fix else []),
               ".", *scripts())


def scripts():
    """Programs in Python without a suffix, which ruff does not find by itself."""
    paths = (path for path in sorted((ROOT / "tools").rglob("*")) if path.is_file() and not path.suffix)
    return [str(path.relative_to(ROOT)) for path in paths if path.read_bytes().startswith(b"#!/usr/bin/env python")]


def types(_fix):
    return run("mypy", "--no-error-summary", "--config-file=host/python/pyproject.toml", "--cache-dir=build/style/mypy")


def run(program, *arguments):
    """0, 1 or NOT_THERE. Only the tools of the environment that runs this count: another version finds other things."""
    found = shutil.which(program, path=str(Path(sys.executable).parent))
    if found is None:
        return NOT_THERE
    told = f"$ {program} {' '.join(map(str, arguments))}"
    print(told if len(told) <= MOST_TOLD else f"{told[:MOST_TOLD]}...", flush=True)
    return 1 if subprocess.run([found, *arguments], cwd=ROOT, stderr=subprocess.STDOUT).returncode else 0


def worst(*outcomes):
    """What was found counts for more than what could not be looked for."""
    return 1 if 1 in outcomes else max(outcomes)


CHECKS = {"layout": layout, "lint": lint, "types": types}


def main(arguments):
    if "--help" in arguments:
        print(__doc__.strip())
        return 0
    fix, names = "--fix" in arguments, [name for name in arguments if name != "--fix"] or list(CHECKS)
    if not set(names) <= set(CHECKS):
        print(f"usage: style.py [--fix] [{'|'.join(CHECKS)}]...", file=sys.stderr)
        return 2
    outcomes = {name: CHECKS[name](fix) for name in names}
    missing = [name for name, outcome in outcomes.items() if outcome == NOT_THERE]
    if missing:
        print(f"no tool for {', '.join(missing)}; tools/requirements-style.txt names them")
    return worst(*outcomes.values())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
