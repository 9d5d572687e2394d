"""The template filled in, and turned into PDF. Nothing of a report comes from elsewhere: no network, no other file.

Jinja2 and WeasyPrint are loaded here alone, when they are needed.
The number of a report, which stands on every page, is given, or made from what the result says.
"""

from __future__ import annotations

import base64
import hashlib
import json
import logging
import re
import struct
from datetime import date, datetime
from importlib.resources import files
from typing import Any
from xml.etree import ElementTree

from tumble.errors import BadInput, NotInstalled, UsageError, quoted
from tumble.files.disk import read_bytes
from tumble.files.stand_file import plain_key
from tumble.report.source import MISSING

NUMBER = "certificate_number"  # a label
LONGEST = 64
_DIGITS = 12  # hexadecimal: of ten thousand reports of a day, two have one number with a chance of 2e-7
_UNDATED = "undated"
_DATE = re.compile(r"\d{4}-\d\d-\d\d", re.ASCII)


def number_of(document: dict[str, Any]) -> str:
    """The label certificate_number; without it such as T-20261123-9f3a1c77b2d4: the date of the result, the beginning
    of the SHA-256 of its content, whatever blanks its file has. The same result has the same number, and practically no
    other has it. Raises UsageError for a label that is no number."""
    for table in ("item", "environment"):
        labels = document.get(table)
        for key, text in labels.items() if isinstance(labels, dict) else ():
            if plain_key(key) == NUMBER and str(text).strip():
                return require_number(str(text), key)
    content = json.dumps(document, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    created = document.get("created")
    date = created[:10].replace("-", "") if isinstance(created, str) else _UNDATED
    return f"T-{date}-{hashlib.sha256(content.encode('ascii')).hexdigest()[:_DIGITS]}"


def require_date(text: object) -> str:
    """A date of issue of the user's own, as ISO 8601 writes it. Raises UsageError."""
    try:
        return date.fromisoformat(str(text) if _DATE.fullmatch(str(text)) else "").isoformat()
    except ValueError:
        said = quoted(text) if isinstance(text, str) else f"a {type(text).__name__}"
        raise UsageError(f"--issued: {said} is not a date such as 2026-11-28") from None


def require_number(text: object, called: str = "--number") -> str:
    """A number of the user's own; `called`: by what it is given. Raises UsageError."""
    if not isinstance(text, str) or not 1 <= len(text.strip()) <= LONGEST or not text.isprintable():
        said = quoted(text) if isinstance(text, str) else f"a {type(text).__name__}"
        raise UsageError(f"{called}: {said} is not a text of 1 to {LONGEST} characters on one line")
    return text.strip()


_MOST_PIXELS = 16_000_000
_MOST_ELEMENTS = 20_000
_REFERENCE = re.compile(r"#([\w.-]+)")


def _fault(data: bytes, kind: str) -> str | None:
    """What stands against a picture of this MIME type, as a message says it; None: nothing. A small file may hold very
    large pictures: it must be drawn in reasonable time and memory."""
    if kind == "image/svg+xml":
        try:
            count = _drawn(ElementTree.fromstring(data))
        except (ElementTree.ParseError, ValueError, LookupError, RecursionError) as error:
            return f"an SVG picture that cannot be read: {error}"
        return None if count <= _MOST_ELEMENTS else f"draws more than {_MOST_ELEMENTS} elements"
    if kind != "image/png":
        return None if b"\xff\xd9" in data else "a JPEG picture that is not whole"
    if len(data) < 24 or b"IEND" not in data:
        return "a PNG picture that is not whole"
    width, height = struct.unpack(">II", data[16:24])
    if width * height > _MOST_PIXELS:
        return f"{width} x {height} pixels; a logo may have {_MOST_PIXELS // 1_000_000} million"
    return None


def _drawn(root: Any) -> int:
    """How many elements an SVG draws: those that `use`, a pattern or a mask repeats count each time."""
    named = {element.get("id"): element for element in root.iter() if element.get("id")}
    known: dict[Any, int] = {}

    def count(element: Any) -> int:
        if element not in known:
            known[element] = 0  # whatever refers to itself is drawn once
            names = _REFERENCE.findall(" ".join(element.attrib.values()))
            parts = [*element, *(named[name] for name in names if name in named)]
            known[element] = min(1 + sum(map(count, parts)), _MOST_ELEMENTS + 1)
        return known[element]

    return count(root)


TEMPLATE = "report.html.j2"
THERMAL = "thermal.html.j2"  # extends that of a result, and stands in its place
TABLES = "tables.html.j2"
SINCE = "since.html.j2"
HISTORY = "history.html.j2"
HISTORY_PAGE = "history_page.html.j2"
STYLE = "report.css"
_OWN = "tumble"  # folder of the templates of this room
_OF_A_RESULT = "result.html.j2"  # what THERMAL extends
_GIVEN = "\0"  # the user's template: whatever its file is called, it hides none of ours, and nothing extends it
EXTRA = "report"
_PANGO = "libpango-1.0-0 libpangoft2-1.0-0 libharfbuzz-subset0 fonts-dejavu-core"  # as Debian calls it, and a font
ATTACHED = "result.json"
_NO_DAY = "1970-01-01"  # what readers of PDF take for an unknown date
_LARGEST_LOGO = 2_000_000
_PICTURES = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg"}
_SVG = re.compile(rb"\s*(<\?xml[^>]*>\s*)?(<!--.*?-->\s*|<!DOCTYPE[^>]*>\s*)*<svg[\s>]", re.DOTALL)


def own(name: str) -> str:
    """A file of this room."""
    return files("tumble.report").joinpath(name).read_text(encoding="utf-8")


def html(context: dict[str, Any], template: str | None, built_in: str = TEMPLATE) -> str:
    """`template`: a file of the user's own, which may extend report.html.j2, also called tumble/report.html.j2;
    None: that one. `built_in`: what has this name, TEMPLATE or THERMAL. Raises BadInput for one that cannot be used."""
    from jinja2 import TemplateSyntaxError

    if template is None:
        return filled(TEMPLATE, context, built_in)
    try:
        given = read_bytes(template).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise BadInput("not a template: no text in UTF-8", template) from None
    environment = _environment(built_in, {_GIVEN: (given, template, None)})
    try:
        text: str = environment.get_template(_GIVEN).render(context)
        return text
    except TemplateSyntaxError as error:
        raise BadInput(f"not a template: {quoted(error.message, 80)}", template, error.lineno) from None
    except Exception as error:  # whatever it computes
        said = f"not a template of a report: {quoted(f'{type(error).__name__}: {error}', 80)}"
        raise BadInput(said, template, _line_of(error, template)) from None


def filled(name: str, context: dict[str, Any], built_in: str = TEMPLATE) -> str:
    """One of our own templates with what it says."""
    text: str = _environment(built_in, {}).get_template(name).render(context)
    return text


def _environment(built_in: str, more: dict[str, Any]) -> Any:
    from jinja2 import FunctionLoader, StrictUndefined
    from jinja2.sandbox import SandboxedEnvironment

    named = (TEMPLATE, TABLES, SINCE, HISTORY, HISTORY_PAGE)
    texts = {name: (own(name), f"{_OWN}/{name}", None) for name in named}
    texts |= {f"{_OWN}/{name}": texts[name] for name in named} | more
    if built_in != TEMPLATE:
        texts[_OF_A_RESULT] = texts[TEMPLATE]
        texts[TEMPLATE] = texts[f"{_OWN}/{TEMPLATE}"] = own(built_in), f"{_OWN}/{built_in}", None
    environment = SandboxedEnvironment(
        loader=FunctionLoader(texts.get),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.tests["missing"] = lambda said: said is MISSING
    return environment


def _line_of(error: Exception, template: str) -> int | None:
    """The line of the template where it went wrong."""
    found, trace = None, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == template:
            found = trace.tb_lineno
        trace = trace.tb_next
    return found


def css_string(text: str) -> str:
    """A text as a string of CSS, within <style>: whatever it holds, it ends where it ends."""
    escaped = "".join(one if one.isascii() and (one.isalnum() or one in " -_.") else f"\\{ord(one):x} " for one in text)
    return f'"{escaped}"'


def logo(file: str) -> str:
    """A picture as a data URI. Raises BadInput."""
    data = read_bytes(file, most=_LARGEST_LOGO)
    kind = next((kind for begin, kind in _PICTURES.items() if data.startswith(begin)), None)
    if kind is None and _SVG.match(data.removeprefix(b"\xef\xbb\xbf")):
        kind = "image/svg+xml"
    if kind is None:
        raise BadInput("not a picture in PNG, JPEG or SVG", file)
    if (fault := _fault(data, kind)) is not None:
        raise BadInput(fault, file)
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def pdf(text: str, name: str, attached: str, issued: str | None) -> bytes:
    """The pages of this HTML, tagged for readers of screens (PDF/UA-1). `name`: what it is made by, for errors.
    `attached`: the JSON result that goes with them, of the day when the report was `issued`. Raises BadInput where it
    needs anything from elsewhere."""
    from weasyprint import HTML, Attachment
    from weasyprint.urls import URLFetcher

    refused: list[str] = []

    class FromNowhere(URLFetcher):  # type: ignore[misc, unused-ignore] # of a library without types
        def fetch(self, url: str, headers: Any = None) -> Any:
            if not url.startswith("data:"):
                refused.append(url)
                raise ValueError(url)
            return super().fetch(url, headers)

    logging.getLogger("weasyprint").setLevel(logging.CRITICAL)  # of what it leaves out it would tell on stderr
    day = datetime.fromisoformat(issued or _NO_DAY)
    about: dict[str, Any] = {"name": ATTACHED, "description": "The result that this report is on", "created": day}
    result = Attachment(string=attached, relationship="Source", modified=day, **about)
    pages = HTML(string=text, base_url="about:blank", url_fetcher=FromNowhere())
    made: bytes = pages.write_pdf(pdf_variant="pdf/ua-1", attachments=[result])
    if refused:
        raise BadInput(f"needs {quoted(refused[0])}: a report takes nothing from elsewhere", name)
    return made


def require_pdf() -> None:
    """Raises NotInstalled where no PDF can be made."""
    try:
        import weasyprint  # noqa: F401
    except (ImportError, OSError) as error:  # it, or the library Pango that it calls
        lacking = "" if isinstance(error, ImportError) else _PANGO
        raise NotInstalled("a report as PDF", "WeasyPrint and Pango", extra=EXTRA, debian=lacking) from None
