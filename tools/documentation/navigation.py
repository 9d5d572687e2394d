"""Which pages the site has, and in which order: docs/site.toml."""

import re
import sys
from dataclasses import dataclass

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

CONFIGURATION = "docs/site.toml"
HOME = "index"


@dataclass(frozen=True)
class Site:
    """`home`: the first page. `parts`: of the navigation, each with `title` and `pages`. `sources`: {name: path in the
    repository} of the pages that are files there. `instead`: {path in the repository: name of the page that links to it
    lead to}."""

    home: str
    parts: list
    sources: dict
    instead: dict


def read_site(root):
    """The site as docs/site.toml describes it."""
    told = tomllib.loads((root / CONFIGURATION).read_text(encoding="utf-8"))
    names = [name_of(entry) for part in told["part"] for entry in part["pages"]]
    sources = {HOME: told["home"], **{name: path for name in names if (path := source_of(root, name)) is not None}}
    instead = {**told["instead"], **{path: name for name, path in sources.items()}}
    return Site(HOME, told["part"], sources, instead)


def name_of(entry):
    """Of a line of the navigation: what stands in its brackets, or all of it."""
    found = re.fullmatch(r".* <(.*)>", entry)
    return found[1] if found else entry


def source_of(root, name):
    """The file of the repository that is this page; None: it is made."""
    for path in (f"docs/{name}.md", f"docs/{name}.ipynb", f"{name}.md"):
        if (root / path).is_file():
            return path
    return None


def unlisted(root, site):
    """Pages under docs/ that the navigation does not show."""
    there = [path for suffix in ("md", "ipynb") for path in (root / "docs").rglob(f"*.{suffix}")]
    return sorted({path.relative_to(root).as_posix() for path in there} - set(site.sources.values()))
