"""Links of the pages: they are written for the repository, and must lead somewhere in the site too."""

import os
import re
from dataclasses import dataclass
from pathlib import Path

from navigation import Site

PICTURES = (".svg", ".png")
FENCED = re.compile(r"^(`{3,}).*?^\1`*$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^()\s]+)\)")


def with_links(text, lead):
    """A text whose links, outside of blocks of code, are what `lead(mark, words, target)` makes of them."""
    parts, at = [], 0
    for block in FENCED.finditer(text):
        parts += [LINK.sub(lambda link: lead(*link.groups()), text[at : block.start()]), block[0]]
        at = block.end()
    return "".join([*parts, LINK.sub(lambda link: lead(*link.groups()), text[at:])])


@dataclass(frozen=True)
class Links:
    """From the repository at `root` to the site whose pages are gathered in `folder`."""

    root: Path
    folder: Path
    site: Site

    def of(self, path, name):
        """What the links of the file `path` become in the page `name`: a function for `with_links`."""
        return lambda mark, words, target: f"{mark}{self._led(path, self.folder / f'{name}.md', words, target)}"

    def _led(self, path, page, words, target):
        """To a page of the site, or to a file of the repository. A folder that is no page is named behind the words.
        What is nowhere stays as it is: Sphinx complains of it."""
        file, mark, anchor = target.partition("#")
        if not file or re.match(r"[a-z]+:", file):
            return f"[{words}]({target})"
        place = Path(os.path.normpath(self.root / Path(path).parent / file))
        inside = os.path.relpath(place, self.root)
        name = self.site.instead.get(inside)
        if name is not None:
            place = self.folder / f"{name}.md"
        elif place.is_dir():
            return f"{words} (`{inside}/`)"
        elif not place.exists():
            return f"[{words}]({target})"
        elif place.suffix in PICTURES and inside.startswith("docs/"):
            place = self.folder / inside.removeprefix("docs/")
        return f"[{words}]({os.path.relpath(place, page.parent)}{mark}{anchor})"
