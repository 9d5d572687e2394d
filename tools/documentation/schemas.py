"""The page of the JSON schemas: what each document holds, and the schema itself."""

import json
import os

INTRODUCTION = """\
# JSON schemas

What `--json` and `--out` write, a schema ([2020-12](https://json-schema.org/draft/2020-12/schema)) for each kind of
document. [Files, options, exit codes](../files.md) explains the keys at length.
"""


def page(folder, place):
    """Markdown of the page of all schemas in `folder`; the page will stand in the folder `place`."""
    return "\n".join([INTRODUCTION, *(section(path, place) for path in sorted(folder.glob("*.json")))])


def section(path, place):
    """One schema: its description, its keys, the file."""
    text = path.read_text(encoding="utf-8")
    schema = json.loads(text)
    name = path.name.removesuffix(".schema.json").replace("-", "/")
    parts = [f"## {name}", schema.get("description") or schema["title"]]
    for kind in schema.get("oneOf", [schema]):
        named = kind["properties"].get("plan", {}).get("const") or (kind is not schema and kind.get("title"))
        parts += [f"### {named}"] if named else []
        parts.append(table(kind["properties"], kind.get("required", [])))
    parts.append(f"[{path.name}]({os.path.relpath(path, place)}):")
    return "\n\n".join([*parts, f"```json\n{text}```\n"])


def table(properties, required):
    """The keys of a document; whether a document may lack one; what is allowed; what it means."""
    rows = [
        f"| `{key}` | {'always' if key in required else ''} | {allowed(rule)} | {cell(rule.get('description', ''))} |"
        for key, rule in properties.items()
    ]
    return "\n".join(["| key | there | what | meaning |", "|---|---|---|---|", *rows])


def allowed(rule):
    """In short: the values or types that a rule allows."""
    if "const" in rule:
        return f"`{json.dumps(rule['const'])}`" if len(str(rule["const"])) < 40 else "constant"
    if "enum" in rule:
        return ", ".join(f"`{json.dumps(value)}`" for value in rule["enum"])
    if "$ref" in rule:
        return rule["$ref"].rsplit("/", 1)[1]
    if "oneOf" in rule or "anyOf" in rule:
        return " or ".join(allowed(part) for part in rule.get("oneOf") or rule["anyOf"])
    types = rule.get("type", [])
    return types if isinstance(types, str) else " or ".join(types)


def cell(text):
    """Plain text as Markdown in a table."""
    for mark in "\\`*_[]<>|$":
        text = text.replace(mark, f"\\{mark}")
    return text
