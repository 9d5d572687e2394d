"""What is wrong with a site that was built: links within it that lead nowhere, and what a browser would fetch."""

import re
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

ELSEWHERE = re.compile(r"\s*(?:[a-z][a-z0-9+.-]*:)?//", re.IGNORECASE)
FETCHED = {  # attributes that a browser follows by itself
    "script": ("src",), "link": ("href",), "img": ("src", "srcset"), "source": ("src", "srcset"),
    "iframe": ("src",), "video": ("src", "poster"), "audio": ("src",), "object": ("data",), "embed": ("src",),
    "image": ("href", "xlink:href"), "use": ("href", "xlink:href"),
}  # fmt: skip
IN_STYLES = re.compile(r"(?:url\(|@import)\s*[\"']?\s*((?:https?:)?//[^\"')\s]+)", re.IGNORECASE)


class Page(HTMLParser):
    """What a page has: `ids`, `links` (of a), and what it `fetches`."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.fetches = set(), [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        told = {name: value or "" for name, value in attributes}
        self.ids |= {told[name] for name in ("id", "name") if name in told}
        if tag == "a" and "href" in told:
            self.links.append(told["href"])
        self.fetches += [told[name] for name in FETCHED.get(tag, ()) if name in told]
        self.fetches += IN_STYLES.findall(told.get("style", ""))


def faults(folder):
    """What is wrong with the site in `folder`, a line each."""
    folder = folder.resolve()
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.html"))}
    found = []
    for path, page in pages.items():
        name = path.relative_to(folder)
        found += [f"{name}: would fetch {address}" for address in page.fetches if ELSEWHERE.match(address)]
        lost = [link for link in dict.fromkeys(page.links) if not leads(link, path, pages)]
        found += [f"{name}: leads nowhere: {link}" for link in lost]
    for path in sorted({*folder.rglob("*.css"), *folder.rglob("*.svg")}):
        addresses = IN_STYLES.findall(path.read_text(encoding="utf-8"))
        found += [f"{path.relative_to(folder)}: would fetch {address}" for address in addresses]
    return found


def leads(link, path, pages):
    """Does a link of the page at `path` lead to something? Those that leave the site are not asked."""
    if re.match(r"[a-z][a-z0-9+.-]*:|//", link, re.IGNORECASE):
        return True
    file, _, anchor = unquote(link).partition("#")
    target = Path(path.parent, file.partition("?")[0]).resolve() if file else path
    if target not in pages:
        return target.is_file()
    return not anchor or anchor in pages[target].ids
