"""The template filled in, and turned into PDF. Nothing of a report comes from elsewhere: no network, no other file.

Jinja2 and WeasyPrint are loaded here alone, when they are needed.
"""

from __future__ import annotations

import base64
import logging
import re
from datetime import datetime
from importlib.resources import files
from typing import Any

from tumble.errors import BadInput, NotInstalled, quoted
from tumble.files.disk import read_bytes
from tumble.report.cells import MISSING
from tumble.report.picture import picture_fault

TEMPLATE = "report.html.j2"
TABLES = "tables.html.j2"
SINCE = "since.html.j2"
STYLE = "report.css"
_OWN = "tumble"  # folder of the templates of this room
_GIVEN = "\0"  # the user's template: whatever its file is called, it hides none of ours, and nothing extends it
EXTRA = "report"
ATTACHED = "result.json"
_NO_DAY = "1970-01-01"  # what readers of PDF take for an unknown date
_LARGEST_LOGO = 2_000_000
_PICTURES = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg"}
_SVG = re.compile(rb"\s*(<\?xml[^>]*>\s*)?(<!--.*?-->\s*|<!DOCTYPE[^>]*>\s*)*<svg[\s>]", re.DOTALL)


def own(name: str) -> str:
    """A file of this room."""
    return files("tumble.report").joinpath(name).read_text(encoding="utf-8")


def html(context: dict[str, Any], template: str | None) -> str:
    """`template`: a file of the user's own, which may extend report.html.j2, also called tumble/report.html.j2;
    None: that one. Raises BadInput for one that cannot be used."""
    from jinja2 import FunctionLoader, StrictUndefined, TemplateSyntaxError
    from jinja2.sandbox import SandboxedEnvironment

    texts = {name: (own(name), f"{_OWN}/{name}", None) for name in (TEMPLATE, TABLES, SINCE)}
    texts |= {f"{_OWN}/{name}": texts[name] for name in (TEMPLATE, TABLES, SINCE)}
    if template is not None:
        texts[_GIVEN] = (_text(template), template, None)
    environment = SandboxedEnvironment(
        loader=FunctionLoader(texts.get),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.tests["missing"] = lambda said: said is MISSING
    if template is None:
        return environment.get_template(TEMPLATE).render(context)
    try:
        return environment.get_template(_GIVEN).render(context)
    except TemplateSyntaxError as error:
        raise BadInput(f"not a template: {quoted(error.message, 80)}", template, error.lineno) from None
    except Exception as error:  # whatever it computes
        said = f"not a template of a report: {quoted(f'{type(error).__name__}: {error}', 80)}"
        raise BadInput(said, template, _line_of(error, template)) from None


def _text(template: str) -> str:
    try:
        return read_bytes(template).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise BadInput("not a template: no text in UTF-8", template) from None


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
    if (fault := picture_fault(data, kind)) is not None:
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
    except (ImportError, OSError):  # it, or the library Pango that it calls
        raise NotInstalled("a report as PDF", "WeasyPrint and Pango", extra=EXTRA) from None
