"""The audit of the paper as a JSON document and as tables."""

from __future__ import annotations

import textwrap
from dataclasses import asdict
from itertools import groupby
from typing import Any

from tumble.planning import tables
from tumble.planning.case import SCHEMA
from tumble.planning.discrepancies import discrepancies
from tumble.planning.paper import AUDIT_K, Line, lines

_TITLES = {
    "Table 1": "Table 1: weights of the averaged estimates",
    "Table 2": "Table 2: contributions of one sample (relative; a0 in g)",
    "Table 3": "Table 3: errors, 50 samples",
    "Table 4": "Table 4: weights of K_yx and K_zx from one mounting",
    "(6)": "(6): errors of K_yx and K_zx from one mounting",
    "(18)": "(18): what dg is divided by, from K_yy; recomputed: 3 sqrt(3) gamma",
    "(19)": "(19): what dg is divided by; recomputed: the rule, in the row that is strictest",
    "Table 5": "Table 5: the stand (rad, V); recomputed: (19), and what (5) says was used",
}
_WEIGHTS = ("Table 1", "Table 4")
_LEGEND = (
    "What is printed, beside what comes out now. ok: equal after rounding to the\n"
    "digits printed, a weight to first order. Numbers in brackets: the list at the end.\n"
)


def document() -> dict[str, Any]:
    """The audit for JSON, schema tumble.plan/1."""
    return {
        "schema": SCHEMA,
        "plan": "paper",
        "misalignments_of_weights": (AUDIT_K / 2.0).tolist(),
        "lines": [{**asdict(line), "notes": list(line.notes)} for line in lines()],
        "discrepancies": [asdict(discrepancy) for discrepancy in discrepancies()],
    }


def show() -> None:
    """Print the audit for people."""
    out = tables.console()
    out.print(_LEGEND)
    for table, group in groupby(lines(), key=lambda line: line.table):
        out.print(tables.heading(_TITLES[table]))
        if table in _WEIGHTS:
            out.print("Values for K = 2 V/g and misalignments of 0.010 to 0.020 rad, all different")
        rows = [_cells(line) for line in group if line.printed != "0" or line.computed != 0.0]
        headings = ["", "", *(["formula"] if table in _WEIGHTS else []), "printed", "recomputed", "", ""]
        out.print(tables.table(headings, rows, left=(0, 1, len(headings) - 1)))
    out.print(tables.heading("Discrepancies"))
    for one in discrepancies():
        out.print(f"[{one.number}] {one.where}", style="bold", markup=False)
        out.print(_indented(f"printed {one.printed}; recomputed {one.computed}"), markup=False)
        out.print(_indented(one.why), markup=False)


def _cells(line: Line) -> list[str]:
    formula = [line.printed] if line.table in _WEIGHTS else []
    printed = f"{line.value:.3g}" if line.table in _WEIGHTS else line.printed
    notes = " ".join(f"\\[{note}]" for note in line.notes)
    return [line.row, line.column, *formula, printed, f"{line.computed:.4g}", "ok" if line.agrees else "differs", notes]


def _indented(text: str) -> str:
    return textwrap.fill(text, tables.WIDTH, initial_indent="    ", subsequent_indent="    ")
