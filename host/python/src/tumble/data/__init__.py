"""Files that come with the package: examples, schemas of documents, EDS and DBC files, the register map.

    >>> from tumble import data
    >>> data.file("bus/block.dbc").name
    'block.dbc'
    >>> data.schema("tumble.result/1").name
    'tumble.result-1.schema.json'

An installed package has them beside this module, so `importlib.resources.files("tumble.data")` finds them as well; in a
checkout they are where they are kept, in examples/ and docs/.
"""

from __future__ import annotations

from pathlib import Path

FOLDERS = {  # in a checkout
    "examples": "examples",
    "schemas": "docs/schemas",
    "eds": "docs/eds",
    "bus": "docs/bus",
    "docs": "docs",
}
SCHEMAS = "https://schemas.tumble.invalid/"  # nobody serves them: they come with the package

_KINDS = (".csv", ".toml", ".json", ".eds", ".dbc")
_LEFT_OUT = ("hand_held_session.csv", "site.toml")  # as host/python/CMakeLists.txt says
_INSTALLED = Path(__file__).parent


def file(name: str) -> Path:
    """Where a file is: `name` such as "examples/paper_stand.csv", "schemas/tumble.result-1.schema.json",
    "eds/tumble_block.eds", "bus/block.dbc", "docs/modbus.csv". Raises FileNotFoundError, which is an OSError, naming
    those there are."""
    found = next((path for path in _all(str(name).partition("/")[0]) if _name(path) == name), None)
    if found is None:
        raise FileNotFoundError(f"no {name!r} comes with tumble; there are: {', '.join(names())}")
    return found


def schema(name: str) -> Path:
    """Where the JSON schema is of documents whose "schema" is `name`, such as "tumble.result/1". Its "$id" is SCHEMAS
    and that name; a "$ref" in it that begins with "/" is another one's. Raises FileNotFoundError, as `file` does."""
    return file(f"schemas/{name.replace('/', '-')}.schema.json")


def names() -> tuple[str, ...]:
    """Of all files, as `file` takes them, in order."""
    return tuple(sorted(_name(path) for folder in FOLDERS for path in _all(folder)))


def _all(folder: str) -> list[Path]:
    """Of one of FOLDERS, where they are."""
    if folder not in FOLDERS:
        return []
    place = _INSTALLED / folder
    if not place.is_dir():
        place = _INSTALLED.parents[4] / FOLDERS[folder] if len(_INSTALLED.parents) > 4 else place
    found = place.iterdir() if place.is_dir() else ()
    return [path for path in found if path.suffix in _KINDS and path.name not in _LEFT_OUT]


def _name(path: Path) -> str:
    return f"{path.parent.name}/{path.name}"
