"""A report as a reader sees it, by a parser of its own: numbers with their paths, texts, tables, what it refers to.

And an oracle for its numbers: the document of the result, read with exact decimals.
"""

import json
import re
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from html.parser import HTMLParser

VOID = {"meta", "img", "br", "hr", "link", "input"}


@dataclass
class Said:
    """What stands in an element with a path."""

    kind: str
    path: str
    times: tuple[str, ...]
    power: int
    text: str = ""

    @property
    def number(self):
        """As a fraction, and the size of a unit of its last digit."""
        digits, _, power = self.text.partition(" \u00d7 10^")
        places, ten = len(digits.partition(".")[2]), Fraction(10) ** int(power or 0)
        return Fraction(digits) * ten, ten / 10**places

    @property
    def digits(self):
        """Significant ones."""
        return len(self.text.partition(" ")[0].lstrip("-").replace(".", "").lstrip("0"))


@dataclass
class Report(HTMLParser):
    """`said`: all elements with a path; `rows`: of all tables, each a list of cells, a cell a list of strings and Said;
    `heads`: rows of headings; `links`: values of src and href; `tags`: of all elements; `text`: of the body without
    pictures and style."""

    source: str
    said: list = field(default_factory=list)
    rows: list = field(default_factory=list)
    heads: list = field(default_factory=list)
    links: list = field(default_factory=list)
    tags: list = field(default_factory=list)
    ids: list = field(default_factory=list)
    unsaid: list = field(default_factory=list)
    text: str = ""
    style: str = ""

    def __post_init__(self):
        super().__init__(convert_charrefs=True)
        self._open, self._said, self._cell, self._row, self._lists = [], None, None, [], False
        self.feed(self.source)
        self.close()
        assert not self._open, self._open

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.tags.append(tag)
        self.links += [attributes[name] for name in ("src", "href", "xlink:href", "action") if name in attributes]
        self.ids += [attributes["id"]] if "id" in attributes else []
        if tag not in VOID:
            self._open.append(tag)
        if "data-path" in attributes:
            power, times = int(attributes.get("data-power", 0)), tuple(attributes.get("data-times", "").split())
            self._said = Said(attributes["class"], attributes["data-path"], times, power)
            self.said.append(self._said)
            if self._cell is not None:
                self._cell.append(self._said)
        self._lists = attributes.get("class") == "unsaid" or (self._lists and tag == "span")
        if tag == "tr":
            self._row = []
            (self.heads if "thead" in self._open else self.rows).append(self._row)
        if tag in ("th", "td"):
            self._cell = []
            self._row.append(self._cell)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self._open.pop()

    def handle_endtag(self, tag):
        assert self._open and self._open[-1] == tag, (tag, self._open)
        self._open.pop()
        if tag == "span":
            self._said = None
        if tag in ("th", "td"):
            self._cell = None

    def handle_data(self, data):
        if "style" in self._open and "svg" not in self._open:
            self.style += data
        if "svg" in self._open or "style" in self._open or "title" in self._open:
            return
        self.text += data
        if self._lists and self._open[-1] == "span":
            self.unsaid.append(data)
        if self._said is not None:
            self._said.text += f"^{data}" if self._open[-1] == "sup" else data
        elif self._cell is not None:
            self._cell.append(data)

    def row(self, name):
        """The one row whose first cell says this, as texts; what is listed as not stated has no row."""
        if name in self.unsaid:
            return ["not stated"]
        (found,) = [row for row in self.rows if row and text_of(row[0]).rstrip("*") == name]
        return [text_of(cell) for cell in found[1:]]


def text_of(cell):
    """All of a cell, in one."""
    return "".join(part if isinstance(part, str) else part.text for part in cell).strip()


def plain(text):
    """With single blanks."""
    return re.sub(r"\s+", " ", text)


def ascii_signs(text):
    """As a document has them."""
    for sign, plain_one in {"µ": "u", "±": "+-", "²": "^2", "³": "^3", "°": " deg", " deg C": "deg C"}.items():
        text = text.replace(sign, plain_one)
    return text.replace("  ", " ")


class Truth:
    """A document by paths of RFC 6901, its numbers exact."""

    def __init__(self, text):
        self._document = json.loads(text, parse_float=Decimal, parse_int=Decimal)

    def at(self, path):
        assert path.startswith("/"), path
        found = self._document
        for key in path[1:].split("/"):
            key = key.replace("~1", "/").replace("~0", "~")
            found = found[int(key)] if isinstance(found, list) else found[key]
        return found

    def number(self, said):
        """What a number should be, unrounded."""
        found = Fraction(self.at(said.path)) * Fraction(10) ** said.power
        for one in said.times:
            found *= Fraction(self.at(one) if one.startswith("/") else one)
        return found
