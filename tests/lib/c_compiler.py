"""What tests that compile C of their own need: the machine's compiler, called in the root of the repo,
and the firmware."""

import os
import shutil
import subprocess
from pathlib import Path

INCLUDES = ["-Ifirmware", "-Ifirmware/include"]
SANITIZERS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
_ROOT = Path(__file__).resolve().parents[2]


def firmware_sources():
    """All rooms."""
    return sorted(path.relative_to(_ROOT).as_posix() for path in (_ROOT / "firmware").rglob("*.c"))


def compiled(program, *arguments):
    """The program, compiled from these options and sources with the firmware's headers at hand."""
    compiler = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc")
    assert compiler, "no C compiler: set CC"
    program.parent.mkdir(exist_ok=True)
    subprocess.run([compiler, "-std=c11", "-ffp-contract=off", *INCLUDES, *map(str, arguments), "-lm", "-o", program],
                   cwd=_ROOT, check=True)
    return program
