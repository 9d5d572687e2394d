#!/usr/bin/env python3
"""Write the names of the estimators, as TUMBLE_ESTIMATOR_LIST of tumble/core.h has them, where they can't be read from
C.

    estimators.py [--check]     exit 1 if something is (or with --check: would be) written anew
"""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HEADER = ROOT / "firmware/include/tumble/core.h"
MODULE = ROOT / "host/python/src/tumble/estimators.py"
SCHEMAS = ROOT / "docs/schemas"
ROW = re.compile(r"^    ONE(?:_WITH_GAINS)?\(\w+, (\w+)(?:, (\w+))?", re.MULTILINE)


def main(arguments):
    rows = ROW.findall(HEADER.read_text(encoding="utf-8"))
    names = [name for name, _ in rows]
    module = MODULE.read_text(encoding="utf-8")
    module = line(module, "HARMONIC", [name for name, needs in rows if needs == "HARMONIC"])
    module = line(module, "LINEAR", [name for name, needs in rows if needs])
    module = line(module, "ESTIMATORS", names)
    texts = {MODULE: module}
    for path in sorted(SCHEMAS.glob("*.json")):
        quoted = ", ".join(f'"{name}"' for name in names)
        texts[path] = re.sub(r'("estimator": \{\s*"enum": \[)[^]]*', lambda match, quoted=quoted: match[1] + quoted,
                             path.read_text(encoding="utf-8"))
    stale = [path for path, text in texts.items() if path.read_text(encoding="utf-8") != text]
    for path in stale:
        print(f"{path.relative_to(ROOT)}: not the estimators of tumble/core.h")
        if "--check" not in arguments:
            path.write_text(texts[path], encoding="utf-8")
    return 1 if stale else 0


def line(text, name, values):
    """`text` with the tuple `name` set to these values; what is said behind it stays."""
    quoted = ", ".join(f'"{value}"' for value in values)
    return re.sub(rf"^{name} = \([^)]*\)", f"{name} = ({quoted})", text, flags=re.MULTILINE)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
