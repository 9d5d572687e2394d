#!/usr/bin/env python3
"""Static analysis of the firmware.

    analyse.py misra|tidy|analyzer [FILES]     exit 1 when something is found, 77 when the tool is not there
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
INCLUDES = ["-Ifirmware", "-Ifirmware/include"]
NOT_THERE = 77


def misra(files, whole):
    """All files in one call, or the rules that look across files see nothing."""
    program = shutil.which("cppcheck", path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    if program is None:
        return not_there("cppcheck")
    if (version := version_of(program)) < (2, 14):
        return not_there(f"cppcheck 2.14 or later (this is {version}), which reports every violation of a line")
    # --enable=all matters: without the style checks the addon reports nothing at all.
    ignored = ["missingIncludeSystem", "unusedFunction", "checkersReport"]
    if not whole:  # a deviation that the whole firmware no longer needs is reported too
        ignored.append("unmatchedSuppression")
    return run(program, "--quiet", "--addon=misra", "--std=c11", "--enable=all", "--check-level=exhaustive",
               "--platform=arm32-wchar_t4", "--suppressions-list=tools/misra_deviations.txt", "--error-exitcode=1",
               *(f"--suppress={name}" for name in ignored), "--template={file}:{line}: {id}: {message}", *INCLUDES,
               *files)


def version_of(program):
    text = subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout
    return tuple(map(int, re.search(r"(\d+)\.(\d+)", text).groups()))


def tidy(files, _whole):
    """One check is off: for memcpy and memset it wants the functions of C11's Annex K, which no library of ours has."""
    program = shutil.which("clang-tidy-19") or shutil.which("clang-tidy")
    if program is None:
        return not_there("clang-tidy")
    checks = ("-*,bugprone-*,cert-*,clang-analyzer-*,-bugprone-easily-swappable-parameters,"
              "-clang-analyzer-security.insecureAPI.DeprecatedOrUnsafeBufferHandling")
    return run(program, "--quiet", f"--checks={checks}", "--header-filter=.*", "--warnings-as-errors=*", *files,
               "--", "-std=c11", *INCLUDES, "-Xclang", "-analyzer-opt-analyze-headers")


def analyzer(files, _whole):
    """At -O0: optimised code hides from it what it looks for. Its check for uninitialised values is off because it
    takes a loop that fills an array for one that may not run; clang-tidy checks the same."""
    worst = 0
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            worst = max(worst, run(
                "gcc", "-std=c11", "-O0", "-fanalyzer", "-Wno-analyzer-use-of-uninitialized-value", "-Wall", "-Werror",
                "-fdiagnostics-path-format=none", *INCLUDES, "-c", "-o", f"{folder}/object", file))
    return worst


def run(*command):
    print("$", *command, flush=True)
    return 1 if subprocess.run(command, cwd=ROOT, stderr=subprocess.STDOUT).returncode else 0


def not_there(what):
    print(f"{what} is not installed")
    return NOT_THERE


def main(arguments):
    gates = {"misra": misra, "tidy": tidy, "analyzer": analyzer}
    if not arguments or arguments[0] not in gates:
        print(f"usage: analyse.py {'|'.join(gates)} [FILES]", file=sys.stderr)
        return 2
    firmware = [path.relative_to(ROOT).as_posix() for path in sorted((ROOT / "firmware").rglob("*.c"))]
    return gates[arguments[0]](arguments[1:] or firmware, not arguments[1:])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
