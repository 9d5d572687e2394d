#!/usr/bin/env python3
"""Write the names of the estimators, as TUMBLE_ESTIMATOR_LIST of tumble/core.h has them, for the package, which parses
a command line without C; tools/schemas.py takes them from there.

    estimators.py [--check]     exit 1 if something is (or with --check: would be) written anew
"""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HEADER = ROOT / "firmware/include/tumble/core.h"
MODULE = ROOT / "host/python/src/tumble/estimators.py"
ROW = re.compile(r"^    (?:ONE|LENT)\(\w+, (\w+), (\w+)", re.MULTILINE)


def main(arguments):
    rows = ROW.findall(HEADER.read_text(encoding="utf-8"))
    names = [name for name, _ in rows]
    module = MODULE.read_text(encoding="utf-8")
    module = line(module, "HARMONIC", [name for name, needs in rows if needs == "HARMONIC"])
    module = line(module, "LINEAR", [name for name, needs in rows if needs in ("HARMONIC", "RANK")])
    module = line(module, "ESTIMATORS", names)
    if MODULE.read_text(encoding="utf-8") == module:
        return 0
    print(f"{MODULE.relative_to(ROOT)}: not the estimators of tumble/core.h")
    if "--check" not in arguments:
        MODULE.write_text(module, encoding="utf-8")
    return 1


def line(text, name, values):
    """`text` with the tuple `name` set to these values; what is said behind it stays."""
    quoted = ", ".join(f'"{value}"' for value in values)
    return re.sub(rf"^{name} = \([^)]*\)", f"{name} = ({quoted})", text, flags=re.MULTILINE)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
