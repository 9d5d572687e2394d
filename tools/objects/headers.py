"""What the C headers of the firmware say: named constants for the object tables, and whether every member of a
configuration has its row in the table of fields (firmware/procedure/config_fields.h).

A constant is found by its name, wherever its header is, in one of four forms: `#define NAME value`, an enumerator of an
enum that is written out, an X(NAME, "...") of a closed list, an enumerator PREFIX_##name that an enum makes of one. Its
value is whole, made of numbers, names and + - * / << ( ).
"""

from __future__ import annotations

import functools
import re
from pathlib import Path

from kinds import TableError

# Keys of the tables whose value may be given by name.
BY_NAME = ("low", "high", "size", "value")
EXPRESSION = re.compile(r"(?=.*\bTUMBLE_)[\w +\-*/<()]+")
TABLES = {
    "TUMBLE_AVERAGING_FIELDS": "tumble_averaging_config_t",
    "TUMBLE_PROCEDURE_FIELDS": "tumble_procedure_config_t",
    "TUMBLE_DRIVE_FIELDS": "tumble_drive_profile_t",
}
C_TYPES = {"F64": "double", "F32": "float", "U32": "uint32_t", "U16": "uint16_t", "U8": "uint8_t", "I32": "int32_t",
           "I8": "int8_t", "BOOL": "bool", "ENUM8": "uint8_t"}


def without_comments(text: str) -> str:
    return re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)


class Headers:
    """All headers of a source tree's firmware, read once."""

    def __init__(self, root: Path):
        paths = sorted((root / "firmware").rglob("*.h"))
        self.text = without_comments("\n".join(path.read_text(encoding="utf-8") for path in paths))
        self.known = self.enumerators() | self.listed() | self.pasted()

    def enumerators(self) -> dict[str, str]:
        found = {}
        for body in re.findall(r"\benum\s*\{([^{}]*)\}", self.text):
            before = "-1"
            for one in filter(None, map(str.strip, body.split(","))):
                name, _, given = map(str.strip, one.partition("="))
                before = found[name] = given or f"({before}) + 1"
        return found

    def listed(self) -> dict[str, str]:
        lists = re.findall(r"#define TUMBLE_\w+_LIST\(X\)((?:.*\\\n)+.*)", self.text)
        return {name: str(place) for rows in lists for place, name in enumerate(re.findall(r"\bX\((\w+),", rows))}

    def pasted(self) -> dict[str, str]:
        found = {}
        made = r"#define \w+\((\w+), \.\.\.\) (TUMBLE_\w+_)##\1,\s*(TUMBLE_\w+_LIST)\("
        for _, prefix, table in re.findall(made, self.text):
            rows = re.search(rf"#define {table}\([\w, ]+\)((?:.*\\\n)+.*)", self.text)
            names = re.findall(r"^\s*\w+\((\w+),", rows[1], re.MULTILINE) if rows else []
            found |= {prefix + name: str(place) for place, name in enumerate(names)}
        return found

    def value(self, name: str) -> int:
        defined = re.search(rf"^#define {name} (.+)$", self.text, re.MULTILINE)
        if not defined and name not in self.known:
            raise TableError(f"no header of firmware/ has the constant {name}")
        return self.calculate(defined[1] if defined else self.known[name])

    def calculate(self, expression: str) -> int:
        plain = re.sub(r"U?INT\d+_C\(|\(u?int\d+_t\)", lambda match: "(" if match[0].endswith("C(") else "", expression)
        plain = re.sub(r"\b(0[xX][0-9a-fA-F]+|\d+)[uUlL]*\b", r"\1", plain)
        plain = re.sub(r"\b[A-Za-z_]\w*", lambda match: str(self.value(match[0])), plain)
        if not re.fullmatch(r"[0-9a-fA-FxX +\-*/<()]+", plain):
            raise TableError(f"{expression.strip()} is not made of numbers, names and + - * / << ( )")
        try:
            return eval(plain.replace("/", "//"), {"__builtins__": {}})  # digits and operators alone
        except (SyntaxError, TypeError) as error:
            raise TableError(f"{expression.strip()} cannot be calculated") from error

    def resolve(self, table: object) -> object:
        """A table with its named constants as numbers."""
        if isinstance(table, list):
            return [self.resolve(one) for one in table]
        if not isinstance(table, dict):
            return table
        return {key: self.calculate(value) if key in BY_NAME and is_expression(value) else self.resolve(value)
                for key, value in table.items()}

    def check_fields(self) -> None:
        for table, struct in TABLES.items():
            rows = dict(self.rows(table))
            for kind, name in self.members(struct):
                if name not in rows:
                    raise TableError(f"{struct}: {name} has no row in {table}")
                if C_TYPES.get(rows[name], kind) != kind:
                    raise TableError(f"{table}: {name} is {kind}, not {rows[name]}")

    def rows(self, table: str) -> list[tuple[str, str]]:
        """(member, type) of a table of fields."""
        body = re.search(rf"#define {table}\(X\)((?:.*\\\n)+.*)", self.text)
        if not body:
            raise TableError(f"no header of firmware/ has the table {table}")
        return [(name, kind) for kind, name in re.findall(r"\bX\((\w+), (\w+)(?:\[\d\])?,", body[1])]

    def members(self, struct: str) -> list[tuple[str, str]]:
        """(type, name), without lists: a pointer, such as `writes`, and its `write_count`."""
        body = re.search(rf"typedef struct \{{([^{{}}]*)\}} {struct};", self.text)
        if not body:
            raise TableError(f"no header of firmware/ has the struct {struct}")
        lists = {f"{name.rstrip('s')}_count" for name in re.findall(r"\*(\w+);", body[1])}
        for line in re.findall(r"\w+ (\w+, [^;]*);", body[1]):
            raise TableError(f"{struct}: {line} is not one member a line")
        found = re.findall(r"(\w+) (\w+)(?:\[\w+\])?;", re.sub(r"[^;]*\*[^;]*;", "", body[1]))
        return [(kind, name) for kind, name in found if name not in lists]


def is_expression(value: object) -> bool:
    return isinstance(value, str) and EXPRESSION.fullmatch(value) is not None


@functools.cache
def headers_of(root: Path) -> Headers:
    return Headers(root)


OWN = headers_of(Path(__file__).resolve().parents[2])  # what the generator itself must know
