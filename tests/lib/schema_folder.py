"""A folder of JSON schemas, looked over: valid drafts, each `$id` once and that of its file, every `$ref` found."""

import json

import jsonschema
import referencing.exceptions
from documents import SCHEMAS, registry

BASE = "https://schemas.tumble.invalid/"
DRAFT = "https://json-schema.org/draft/2020-12/schema"


def faults(folder=SCHEMAS):
    """A line for each thing that is wrong."""
    found, ids = [], []
    for path in sorted(folder.glob("*.json")):
        schema, name = json.loads(path.read_text()), path.name.removesuffix(".schema.json").replace("-", "/")
        found += [f"{path.name}: {said}" for said in _own_faults(schema, name)]
        ids.append(schema.get("$id"))
    found += [f"{one} is the $id of two" for one in sorted({one for one in ids if ids.count(one) > 1})]
    return found if None in ids else found + _lost(folder)


def _own_faults(schema, name):
    if schema.get("$schema") != DRAFT:
        yield f"$schema is not {DRAFT}"
    if schema.get("$id") != f"{BASE}{name}":
        yield f"$id is not {BASE}{name}"
    if not schema.get("title"):
        yield "has no title"
    names = [kind["properties"].get("schema", {}).get("const") for kind in schema.get("oneOf", [schema])]
    if set(names) != {name}:
        yield f'"schema" of its documents is not {name}'
    try:
        jsonschema.Draft202012Validator.check_schema(schema)
    except jsonschema.SchemaError as error:
        yield f"not valid: {error.message}"


def _lost(folder):
    """References that lead nowhere in this folder."""
    known = registry(folder)
    return [f"{name.removeprefix(BASE)}: {reference} leads nowhere" for name in sorted(known)
            for reference in sorted(_references(known.contents(name))) if not _leads(known.resolver(name), reference)]


def _leads(resolver, reference):
    try:
        resolver.lookup(reference)
    except referencing.exceptions.Unresolvable:
        return False
    return True


def _references(value):
    if isinstance(value, dict):
        own = {value["$ref"]} if isinstance(value.get("$ref"), str) else set()
        return own.union(*map(_references, value.values()))
    return set().union(*map(_references, value)) if isinstance(value, list) else set()
