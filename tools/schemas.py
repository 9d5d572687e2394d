#!/usr/bin/env python3
"""JSON schemas of the documents, made from their types in tumble.documents.

    schemas.py FOLDER [PAGE]    writes them, and the tables of keys of a page of Markdown, docs/files.md

What docs/ holds is held against the types by tests/integration/test_schemas.py.

The docstring of a type describes it, and below, a paragraph a key, "name: text", its keys. Lists of names
that a document may have (patterns, sources, estimators) are those of this version; whoever reads one takes others, too.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any, get_origin

from msgspec import inspect

from tumble.data import SCHEMAS
from tumble.documents.base import END_OF_TEXT, LARGEST, Document, described
from tumble.documents.bench import BENCH, LOG, NODE, REPLAY, STAND, Bench, Computer, Log, Replay, Stand
from tumble.documents.campaign import CAMPAIGN, HOSTILE, Campaign, Hostile
from tumble.documents.comparison import COMPARISON, Comparison
from tumble.documents.fixture import FIXTURE, Fixture
from tumble.documents.history import HISTORY, History
from tumble.documents.importing import IMPORT, Import
from tumble.documents.plan import PLAN, Plan
from tumble.documents.result import RESULT, Result
from tumble.documents.store import STORE, Store
from tumble.documents.thermal import THERMAL, Thermal
from tumble.documents.watch import WATCH, Snapshot, Watch
from tumble.estimators import ESTIMATORS, NORM
from tumble.model.fit import DOUBTS
from tumble.model.patterns import BY_NAME
from tumble.schedule import BUILT_IN
from tumble.solving.noise import CORRELATED
from tumble.stand import SOURCES

DRAFT = "https://json-schema.org/draft/2020-12/schema"
DOCUMENTS: dict[str, tuple[type[Document], str]] = {  # by schema: its type, or what its kinds derive from; title
    PLAN: (Plan, "a stand, judged before a run"),
    FIXTURE: (Fixture, "a stand, judged by the runs made on it"),
    HISTORY: (History, "calibrations of many blocks"),
    IMPORT: (Import, "rests found in recordings, and assumptions"),
    STORE: (Store, "contents of an image of the memory"),
    WATCH: (Watch, "a snapshot of a run"),
    COMPARISON: (Comparison, "two calibrations of one block"),
    RESULT: (Result, "the outcome of one calibration"),
    THERMAL: (Thermal, "a calibration over temperature"),
    BENCH: (Bench, "a run in a simulated world"),
    NODE: (Computer, "a run of the computer on a real bus"),
    STAND: (Stand, "the simulated stand in a run on a real bus"),
    REPLAY: (Replay, "a recorded bus log, replayed through the firmware"),
    LOG: (Log, "one event of a program"),
    CAMPAIGN: (Campaign, "statistics of calibrations"),
    HOSTILE: (Hostile, "the fault campaign and its violations"),
}
_BENCH = ("bus", "firmware", "truth")  # keys of a run on the bench, all or none
_COMBINED = ("K", "U0", "u_K", "u_U0")  # of runs that are consistent, else null
_MORE: dict[str, dict[str, Any]] = {  # by type: what no type says
    "Log": {
        "if": {"properties": {"event": {"const": "end"}}},
        "then": {"required": ["exit"]},
        "additionalProperties": {"type": ["string", "integer"]},
    },
    "Result": {"dependentRequired": {"seed": list(_BENCH), **{one: ["seed"] for one in _BENCH}}},
    "Combined": {
        "if": {"properties": {"consistent": {"const": True}}},
        "then": {"properties": {one: {"type": "array"} for one in _COMBINED}},
        "else": {"properties": {one: {"type": "null"} for one in _COMBINED}},
    },
}
_WRITTEN = {  # by type: keys that are always there, though a reader does without
    "Result": "units stand_seen intrinsic reference means counters item environment",
    "DeclaredStand": "step_v",
    "Si": "u_K u_bias",
    "Snapshot": " ".join(Snapshot.__struct_fields__),
    "Verification": "delta_g_g max_abs_delta_g_fit_g max_abs_delta_g_check_g closure residual_rms",
}
_PATTERNS = [*BY_NAME]
_NAMES: dict[tuple[str, str], Iterable[str | None]] = {  # by type and key: the names that this version writes
    ("Explanation", "patterns"): [*_PATTERNS, *DOUBTS, CORRELATED],
    ("Unseen", "pattern"): _PATTERNS,
    ("Unseen", "unit"): dict.fromkeys(one.unit for one in BY_NAME.values()),
    ("Shift", "source"): [name for name, one in SOURCES.items() if one.is_angle],
    ("Schedule", "name"): [*BUILT_IN, None],
    ("Result", "estimator"): (*ESTIMATORS, NORM),
    ("Result", "stand_doubts"): DOUBTS,
}


def schema(name: str) -> dict[str, Any]:
    """Of the documents that call themselves `name`."""
    kind, title = DOCUMENTS[name]
    writer = _Writer()
    head = {"$schema": DRAFT, "$id": SCHEMAS + name, "title": f"{name}: {title}"}
    if kinds := kind.__subclasses__():
        own = {
            "description": _plain(described(kind)[0]),
            "oneOf": [writer.object_of(inspect.type_info(one)) for one in kinds],
        }
    else:
        own = writer.object_of(inspect.type_info(kind))
    return {**head, **own, "$defs": dict(sorted(writer.parts.items()))}


def _plain(text: str) -> str:
    """Without the marks of Markdown."""
    return re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", text).replace("`", "")


class _Writer:
    """`parts`: what has been met of types that have a name, for $defs."""

    def __init__(self) -> None:
        self.parts: dict[str, Any] = {}

    def object_of(self, kind: inspect.Type) -> dict[str, Any]:
        """A type of documents. A key with one text that it always has must be there."""
        assert isinstance(kind, inspect.StructType)
        own = get_origin(kind.cls) or kind.cls
        (about, of_keys), properties, required = described(own), {}, []
        always = _WRITTEN.get(own.__name__, "").split()
        for field in kind.fields:
            key = field.encode_name
            made = self.value(field.type)
            fixed = made.get("enum") == [field.default]
            if fixed:
                made = {"const": field.default}
            if fixed or field.required or key in always:
                required.append(key)
            if (names := _NAMES.get((own.__name__, key))) is not None:
                made = _one_of(made, list(names))
            properties[key] = ({"description": _plain(of_keys[key])} if key in of_keys else {}) | made
        listed = {"properties": properties, "required": required, "additionalProperties": False}
        listed |= _MORE.get(own.__name__, {})
        return ({"description": _plain(about)} if about else {}) | {"type": "object"} | listed

    def value(self, kind: inspect.Type) -> dict[str, Any]:
        """Any type."""
        match kind:
            case inspect.Metadata():
                return self.value(kind.type) | (kind.extra_json_schema or {})
            case inspect.StructType():
                return self._named(kind)
            case inspect.UnionType():
                return self._any_of([self.value(one) for one in kind.types])
            case inspect.CustomType():
                shape = array_schema(kind.cls)
                self.parts[kind.cls.__name__] = shape
                return {"$ref": f"#/$defs/{kind.cls.__name__}"}
            case inspect.TupleType():
                return self._row(self.value(kind.item_types[0]), len(kind.item_types), len(kind.item_types))
            case inspect.VarTupleType():
                return self._row(self.value(kind.item_type), kind.min_length, kind.max_length)
            case inspect.DictType():
                return self._table(kind)
            case inspect.LiteralType():
                return {"enum": list(kind.values)}
            case inspect.EnumType():
                return {"enum": [one.value for one in kind.cls]}
            case inspect.StrType():
                limits = {
                    "pattern": kind.pattern and kind.pattern.replace(END_OF_TEXT, "$"),
                    "minLength": kind.min_length,
                }
                limits["maxLength"] = kind.max_length
                return _with("string", limits)
            case inspect.FloatType():
                return _with("number", _range(kind))
            case inspect.IntType():
                return _with("integer", _range(kind))
            case inspect.BoolType():
                return {"type": "boolean"}
            case inspect.NoneType():
                return {"type": "null"}
        raise TypeError(f"no document holds a {kind}")

    def _named(self, kind: inspect.StructType) -> dict[str, Any]:
        """A reference to a type with a name of its own; one with parameters is written out."""
        if get_origin(kind.cls) is not None:
            return self.object_of(kind)
        name = kind.cls.__name__
        if name not in self.parts:
            self.parts[name] = {}
            self.parts[name] = self.object_of(kind)
        return {"$ref": f"#/$defs/{name}"}

    def _row(self, item: dict[str, Any], least: int | None, most: int | None) -> dict[str, Any]:
        return _with("array", {"items": item, "minItems": least, "maxItems": most})

    def _table(self, kind: inspect.DictType) -> dict[str, Any]:
        names = self.value(kind.key_type)
        limited = {} if names == {"type": "string"} else {"propertyNames": names}
        limits = {"minProperties": kind.min_length, "additionalProperties": self.value(kind.value_type)}
        return {**_with("object", limited), **_with("object", limits)}

    @staticmethod
    def _any_of(made: list[dict[str, Any]]) -> dict[str, Any]:
        if len(made) == 1:
            return made[0]
        if all(list(one) == ["type"] for one in made):
            return {"type": [one["type"] for one in made]}
        if len(made) == 2 and made[1] == {"type": "null"} and "type" in made[0]:
            return made[0] | {"type": [made[0]["type"], "null"]}
        if len(made) == 2 and made[1] == {"type": "null"} and "enum" in made[0]:
            return {"enum": [*made[0]["enum"], None]}
        return {"anyOf": made}


def _one_of(made: dict[str, Any], names: list[str | None]) -> dict[str, Any]:
    """With the names that it may have, in place of any; in an array, those of its items."""
    return {**made, "items": {"enum": names}} if "items" in made else {"enum": names}


def _with(kind: str, limits: dict[str, Any]) -> dict[str, Any]:
    return {"type": kind, **{key: value for key, value in limits.items() if value is not None}}


def _range(kind: inspect.FloatType | inspect.IntType) -> dict[str, Any]:
    limits = {"minimum": kind.ge, "exclusiveMinimum": kind.gt, "maximum": kind.le, "exclusiveMaximum": kind.lt}
    return {key: value for key, value in limits.items() if value is not None and abs(value) < LARGEST}


def array_schema(kind: Any) -> dict[str, Any]:
    """As JSON schema has it."""
    made: dict[str, Any] = {"type": "number", **({} if kind.least < 0.0 else {"minimum": kind.least})}
    for length in reversed(kind.shape):
        fewest = kind.fewest if length is None else length
        limits = {"minItems": fewest, "maxItems": length}
        made = {"type": "array", "items": made, **{key: limit for key, limit in limits.items() if limit}}
    return made


def text(value: Any, indent: int = 0, before: int = 0) -> str:
    """As JSON, what fits in a line of 120 columns in one; `before`: so much of the line is taken."""
    short = json.dumps(value, ensure_ascii=False)
    if not isinstance(value, (dict, list)) or indent + before + len(short) < 120:
        return short
    inner = indent + 2
    if isinstance(value, dict):
        names = [f"{json.dumps(key)}: " for key in value]
        rows = [name + text(one, inner, len(name)) for name, one in zip(names, value.values())]
    else:
        rows = [text(one, inner) for one in value]
    start, end = "{}" if isinstance(value, dict) else "[]"
    lines = [f"{' ' * inner}{row}" for row in rows]
    return "\n".join([start, ",\n".join(lines), f"{' ' * indent}{end}"])


def tabled(page: str) -> str:
    """A page with its tables of keys made anew: each stands below a line such as <!-- keys of tumble.result/1 -->."""

    def table(found: re.Match[str]) -> str:
        kind, _ = DOCUMENTS[found["name"]]
        keys = {key: text for one in (kind, *kind.__subclasses__()) for key, text in described(one)[1].items()}
        rows = [f"| `{key}` | {text.replace('|', chr(92) + '|')} |" for key, text in keys.items()]
        return "\n".join([found["mark"], "", "| key | what |", "|---|---|", *rows])

    return re.sub(r"(?P<mark><!-- keys of (?P<name>\S+) -->)\n\n(\|.*\n)*\|.*", table, page)


def write(folder: Path) -> None:
    """All schemas."""
    for name in DOCUMENTS:
        path = folder / f"{name.replace('/', '-')}.schema.json"
        path.write_text(text(schema(name)) + "\n", encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit("usage: schemas.py FOLDER [PAGE]")
    write(Path(sys.argv[1]))
    for name in sys.argv[2:]:
        Path(name).write_text(tabled(Path(name).read_text(encoding="utf-8")), encoding="utf-8")
