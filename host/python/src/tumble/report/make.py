"""From a result's document to the bytes of a report, with what has changed since an earlier result."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

from tumble.comparison import report
from tumble.documents.comparison import Comparison
from tumble.documents.history import Due, Trend
from tumble.errors import UsageError, needing, quoted
from tumble.report import history, pages, sections, temperatures
from tumble.report.pages import number_of, require_number
from tumble.report.source import MISSING, DocumentSource, Fixed, Source, Table, line, readable
from tumble.solving.result import schedule_of


def section(told: Comparison | None, earlier: dict[str, Any], later: dict[str, Any]) -> dict[str, Any] | None:
    """`told`: a document of schema tumble.comparison/1, whose A is `earlier` and whose B is `later`, documents of
    schema tumble.result/1; None: without an earlier result, and without a section."""
    if told is None:
        return None
    from markupsafe import Markup

    from tumble.pictures import comparison, svg

    # an option that is the comparison's own, and not the report's
    said = [
        one.replace("(--stand FILE)", "(tumble compare --stand FILE)")
        for one in (*report.grounds(told), *told.warnings)
    ]
    rows = [row for part in (told.parameters, told.seat, told.coefficients) for row in part]
    return {
        "sentence": readable(report.sentence(told)),
        "results": [(Fixed("A, the earlier result"), _called(earlier)), (Fixed("B, this result"), _called(later))],
        "grounds": [readable(one) for one in said],
        "table": Table(report.COLUMNS, [tuple(map(Fixed, report.cells(row))) for row in rows], left=(3,)),
        "legend": None if told.tests is None else readable(report.legend(told)),
        "svg": Markup(svg(comparison(told))),
    }


def _called(document: dict[str, Any]) -> Fixed:
    """The number that a report on it has by itself, and when it was made."""
    created = document.get("created")
    return Fixed(", ".join([number_of(document), *([readable(str(created))] if created else [])]))


HTML, PDF = "html", "pdf"
_MOST_MOUNTINGS = 6
_ON_A_TABLE = "How the block sat in each mounting with the table at angle zero, seen from the front."
_INCLINED = "How the stand was inclined for each mounting, seen from the right; the block stayed bolted on."
_BY_HAND = "How the block lay in each mounting, seen from the front."
_PERHAPS_BY_HAND = (
    "The mountings of the schedule on a rotary table at angle zero, seen from the front. A block that was laid by hand"
    " had the same faces up, without a table."
)
_KINDS = {".html": HTML, ".htm": HTML, ".pdf": PDF}


def kind_of(file: str, option: str = "--out") -> str:
    """HTML or PDF, by the end of its name; `option`: what the user calls it. Raises UsageError."""
    found = _KINDS.get(os.path.splitext(file)[1].lower())
    if found is None:
        raise UsageError(f"{option}: {quoted(file)} does not end in .html or .pdf")
    return found


def require_installed(kind: str) -> None:
    """Raises NotInstalled where a package is missing."""
    with needing("a report", extra=pages.EXTRA):
        import jinja2  # noqa: F401
        import matplotlib  # type: ignore[import-not-found, unused-ignore] # noqa: F401
    if kind == PDF:
        pages.require_pdf()


def made(
    document: dict[str, Any],
    name: str,
    kind: str = HTML,
    *,
    run: Any = None,
    template: str | None = None,
    logo: str | None = None,
    number: str | None = None,
    issued: str | None = None,
    earlier: tuple[dict[str, Any], Comparison] | None = None,
    known: tuple[Trend, Due] | None = None,
    attached: str = "",
) -> bytes:
    """A report on `document`, schema tumble.result/1, as JSON has it; `name`: what errors call it.

    `run`: the Recording that was solved, for a picture of its samples. `template`: a file of Jinja2; `logo`: a picture;
    `number`: one that is given. `issued`: the date of issue, None for none. `earlier`: an earlier result, and what has
    changed since (schema tumble.comparison/1). `known`: what a history says of the block (tumble.history/1).
    `attached`: the document's JSON, which a PDF carries with it. Raises BadInput, UsageError, NotInstalled.
    """
    told = number_of(document) if number is None else require_number(number)
    require_installed(kind)
    source = Source(document, name)
    found = context(source, told, None if logo is None else pages.logo(logo), issued)
    before, changes = ({}, None) if earlier is None else earlier
    drawn = {"figures": pictures(source, run), "since": section(changes, before, document)}
    drawn |= {"history": None if known is None else history.section(*known)}
    text = pages.html({**found, **drawn}, template)
    return _finished(text, kind, template or name, attached, issued)


def made_over_temperature(
    document: dict[str, Any],
    name: str,
    kind: str = HTML,
    *,
    template: str | None = None,
    logo: str | None = None,
    number: str | None = None,
    issued: str | None = None,
    attached: str = "",
) -> bytes:
    """A report on `document`, schema tumble.thermal/1; the rest as `made` has it."""
    told = number_of(document) if number is None else require_number(number)
    require_installed(kind)
    source = temperatures.ThermalSource(document, name)
    found = {
        **_common(source, told, None if logo is None else pages.logo(logo), issued),
        **{one.__name__: one(source) for one in _OVER_TEMPERATURE},
        "figures": _over_temperature(source),
        "unseen": sections.unseen(source),
        **dict.fromkeys(("simulated", "since", "history"), None),
    }
    text = pages.html(found, template, pages.THERMAL)
    return _finished(text, kind, template or name, attached, issued)


def _finished(text: str, kind: str, name: str, attached: str, issued: str | None) -> bytes:
    return pages.pdf(text, name, attached, issued) if kind == PDF else text.encode("utf-8", "replace")


def _over_temperature(source: temperatures.ThermalSource) -> list[dict[str, Any]]:
    from markupsafe import Markup

    from tumble.pictures import svg, thermal

    drawn = thermal.figures(source.solved).items()
    return [{"name": name, "svg": Markup(svg(one)), "caption": thermal.CAPTIONS[name]} for name, one in drawn]


def pictures(source: Source, run: Any) -> list[dict[str, Any]]:
    """Of a document and perhaps its run: `name`, `svg` and `caption` of each. Raises BadInput, UsageError."""
    from markupsafe import Markup

    from tumble.pictures import caption, figures, svg

    drawn = figures(source.solved, run)
    told = [(name, svg(one), caption(name, source.solved)) for name, one in drawn.items()]
    return [
        {"name": name, "svg": Markup(one), "caption": caption} for name, one, caption in [*_mountings(source), *told]
    ]


def _mountings(source: Source) -> list[tuple[str, str, str]]:
    """How the block sat; not of a schedule with so many mountings that nobody could tell them apart."""
    from tumble.pictures import mountings, svg

    schedule = schedule_of(source.solved, source.name)
    if schedule is None or len(schedule.data.mountings) > _MOST_MOUNTINGS:
        return []
    if schedule.data.is_inclined:
        from tumble.pictures import inclinations

        return [("inclined", svg(inclinations(schedule.data)), _INCLINED)]
    caption = _ON_A_TABLE if source.table("stand") else _PERHAPS_BY_HAND
    caption = _BY_HAND if schedule.data.is_laid_by_hand else caption
    return [("mountings", svg(mountings(schedule.data)), caption)]


_OF_THE_SOURCE: tuple[Callable[[Source], Any], ...] = (  # what a template has under the names of these
    *(sections.verdict, sections.findings, sections.rule, sections.positions, sections.about_positions),
    *(sections.explanations, sections.unseen, sections.method, sections.environment),
    *(sections.declared, sections.seen, sections.further, sections.worst_norm),
)
_OVER_TEMPERATURE: tuple[Callable[[temperatures.ThermalSource], Any], ...] = (
    *(temperatures.verdict, temperatures.findings, temperatures.rule, temperatures.method, temperatures.declared),
    *(temperatures.about_values, temperatures.coefficients, temperatures.powers, temperatures.runs),
    *(temperatures.worst_norm, temperatures.data),
)


def context(source: Source, number: str, logo: str | None, issued: str | None = None) -> dict[str, Any]:
    """What a template may say, but for `figures`, `since` and `history`. docs/files.md lists it."""
    given = sections.uncertainties(source)
    return {
        **_common(source, number, logo, issued),
        **{one.__name__: one(source) for one in _OF_THE_SOURCE},
        "simulated": line("seed ", source.told("seed")) if "seed" in source.document else None,
        "uncertainties": given.about,
        "coefficients": sections.coefficients(source, given),
        "in_si": bool(source.table("si")),
        "marks": sections.legend(source),
        "intrinsic": sections.intrinsic(source, given),
        "data": [
            (Fixed("Run file"), source.told("run_file")),
            (Fixed("SHA-256 of the run file"), source.told("run_sha256")),
        ],
    }


def _common(source: DocumentSource, number: str, logo: str | None, issued: str | None) -> dict[str, Any]:
    """What is the same of a result and of a calibration over temperature."""
    from markupsafe import Markup

    date = MISSING if issued is None else Fixed(issued)
    return {
        "number": number,
        "logo": logo,
        "style": Markup(pages.own(pages.STYLE).replace("NUMBER", pages.css_string(number))),
        "created": source.at("created") or "",
        "document": source.document,
        "warnings": None if source.at("warnings") is None else source.each("warnings"),
        "assumptions": sections.assumptions(source),
        "item": sections.item(source),
        "parties": sections.facts(source, sections.PARTIES),
        "issued": date,
        "dates": sections.dates(source, date),
        "issue": sections.issue(source, date),
        "labels": sections.further_labels(source),
        "traceability": sections.facts(source, sections.TRACEABILITY),
        "deviations": sections.facts(source, sections.DEVIATIONS),
    }
