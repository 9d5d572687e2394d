"""Write the C source of `_tumble_core`, the extension module through which Python calls the firmware core.

    python build_core.py OUTPUT.c

What Python knows of the core is its header, whole, and what batch.c and rows.c add to it for Python alone. The module
uses the limited API, so one build serves every Python from 3.10 on.
"""

import re
import sys
from pathlib import Path

import cffi

BINDING = Path(__file__).resolve().parent
HEADERS = [BINDING.parents[2] / "firmware/include/tumble" / name for name in ("status.h", "core.h")]
SOURCES = [BINDING / name for name in ("batch.c", "rows.c")]


def constants(text: str) -> list[str]:
    """The numbers that headers define."""
    found: dict[str, float] = {}
    for name, value in re.findall(r"^#define (\w+) +(\S.*)$", text, re.MULTILINE):
        found[name] = eval(re.sub(r"INT64_C|(?<=\d)U\b", "", value).replace("/", "//"), {}, found)
    is_whole = {name: isinstance(value, int) for name, value in found.items()}
    return [f"#define {name} {found[name]}" if is_whole[name] else f"static const double {name};" for name in found]


def enums(text: str) -> list[str]:
    """The enums that the preprocessor makes of lists."""
    statuses = re.findall(r"\bX\((\w+), ", text)
    estimators = [f"TUMBLE_ESTIMATE_{name}" for name in re.findall(r"\b(?:ONE|LENT)\((\w+), \w+,", text)]
    return [
        f"typedef enum {{ {', '.join(statuses)}, TUMBLE_STATUS_COUNT }} tumble_status_t;",
        f"typedef enum {{ {', '.join(estimators)}, TUMBLE_ESTIMATE_COUNT }} tumble_estimate_t;",
    ]


def declarations(text: str) -> str:
    """Headers or sources without what cffi does not read: directives, lists that these expand, assertions, bodies of
    functions, and what is static."""
    lines = r"^#ifdef __cplusplus.*?^#endif|^typedef enum \{\n#.*?^\}.*?;|^#.*?$"
    text = re.sub(lines, "", text, flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r'^static_assert\(.*?"\);|^\{$.*?^\}$', ";", text, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"^static (?!inline)[^;]*;", "", text, flags=re.MULTILINE).replace("static inline ", "")


def main(output: str) -> None:
    """Write the extension's C source to the file `output`."""
    headers, sources = ("\n".join(path.read_text(encoding="utf-8") for path in of) for of in (HEADERS, SOURCES))
    known, own = (re.sub(r"/\*.*?\*/|\\\n", " ", text, flags=re.DOTALL) for text in (headers, sources))
    rows = "static const estimator_row_t estimator_rows[...];"
    ffi = cffi.FFI()
    ffi.cdef("\n".join([*constants(known), *enums(known), declarations(known), declarations(own), rows]))
    ffi.set_source("_tumble_core", '#include "tumble/core.h"\n' + sources)
    ffi.emit_c_code(output)


if __name__ == "__main__":
    main(sys.argv[1])
