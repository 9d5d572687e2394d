"""The pages of the site, gathered in one folder as Sphinx wants them: those of docs/site.toml, with links that lead
within the site, and those that are made of the command line's help, schemas, docstrings and headers."""

import shutil

import c_pages
import command_line
import notebook
import python_page
import schemas
from links import PICTURES, Links, with_links
from navigation import CONFIGURATION, read_site, unlisted


def gather(root, folder):
    """Write all pages into `folder`, which is made anew. Returns what is wrong, a line each."""
    shutil.rmtree(folder, ignore_errors=True)
    site = read_site(root)
    of_headers = c_pages.pages(root)
    site.instead.update({path: name for name, (path, _) in of_headers.items()})
    links = Links(root, folder, site)
    for name, path in site.sources.items():
        write(folder, name, with_links(text_of(root / path, folder / name), links.of(path, name)))
    for name, text in {**made(root, folder), **{name: text for name, (_, text) in of_headers.items()}}.items():
        write(folder, name, text)
    append_navigation(folder, site)
    for picture in (root / "docs").rglob("*"):
        if picture.suffix in PICTURES:
            place = folder / picture.relative_to(root / "docs")
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(picture, place)
    return [f"{path}: not in {CONFIGURATION}, so no reader finds it" for path in unlisted(root, site)]


def made(root, folder):
    """{name: text} of the pages that are made, but for those of the headers."""
    return {
        "reference/command-line": command_line.page(),
        "reference/schemas": schemas.page(root / "docs/schemas", folder / "reference"),
        "reference/python": python_page.page(),
    }


def text_of(file, place):
    """Markdown of a page; pictures of a notebook go beside `place`."""
    return notebook.as_markdown(file, place) if file.suffix == ".ipynb" else file.read_text(encoding="utf-8")


def write(folder, name, text):
    place = folder / f"{name}.md"
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(text, encoding="utf-8")


def append_navigation(folder, site):
    """A list of pages for every part of the site, behind the text of its home page, which does not show it."""
    lists = [
        "\n".join(["```{toctree}", ":hidden:", f":caption: {part['title']}", "", *part["pages"], "```"])
        for part in site.parts
    ]
    home = folder / f"{site.home}.md"
    write(folder, site.home, "\n\n".join([home.read_text(encoding="utf-8"), *lists, ""]))
