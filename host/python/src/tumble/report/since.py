"""What has changed since an earlier result: a section of the report on the later one."""

from __future__ import annotations

from typing import Any

from tumble.comparison import report
from tumble.documents.comparison import Comparison
from tumble.report.cells import Fixed, Table, readable
from tumble.report.number import number_of


def section(told: Comparison | None, earlier: dict[str, Any], later: dict[str, Any]) -> dict[str, Any] | None:
    """`told`: a document of schema tumble.comparison/1, whose A is `earlier` and whose B is `later`, documents of
    schema tumble.result/1; None: without an earlier result, and without a section."""
    if told is None:
        return None
    from markupsafe import Markup

    from tumble.pictures import comparison, svg

    rows = [row for part in (told.parameters, told.seat, told.coefficients) for row in part]
    return {
        "sentence": readable(report.sentence(told)),
        "results": [(Fixed("A, the earlier result"), _called(earlier)), (Fixed("B, this result"), _called(later))],
        "grounds": [readable(_for_compare(one)) for one in (*report.grounds(told), *told.warnings)],
        "table": Table(report.COLUMNS, [tuple(map(Fixed, report.cells(row))) for row in rows], left=(3,)),
        "legend": None if told.tests is None else readable(report.legend(told)),
        "svg": Markup(svg(comparison(told))),
    }


def _for_compare(said: str) -> str:
    """An option that is the comparison's own, and not the report's."""
    return said.replace("(--stand FILE)", "(tumble compare --stand FILE)")


def _called(document: dict[str, Any]) -> Fixed:
    """The number that a report on it has by itself, and when it was made."""
    created = document.get("created")
    return Fixed(", ".join([number_of(document), *([readable(str(created))] if created else [])]))
