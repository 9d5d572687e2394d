"""A solution as plain ASCII text, for files and pipes."""

from __future__ import annotations

from tumble import presentation
from tumble.presentation import BAR_WIDTH, GravityBar
from tumble.solving.solution import Solution


def render(solution: Solution, file: str) -> str:
    """All of it, within 80 columns as long as the file's name and the numbers are of ordinary size."""
    lines = [presentation.title(solution, file), ""]
    lines += _table([presentation.coefficient_headings(solution), *presentation.coefficient_rows(solution)])
    lines += ([presentation.HINT] if solution.u_k is None else []) + [""]
    lines += [presentation.gravity_title(solution)]
    lines += [_bar(bar) for bar in presentation.gravity_bars(solution)] + [""]
    lines += [*presentation.remarks(solution), "", *presentation.beware(solution), presentation.verdict(solution)]
    return "\n".join(lines) + "\n"


def _table(rows: list[tuple[str, ...]]) -> list[str]:
    """Columns as wide as need be, the first and the unit to the left, numbers to the right."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    return [
        "  ".join(
            cell.ljust(width) if column in (0, 2) else cell.rjust(width)
            for column, (cell, width) in enumerate(zip(row, widths))
        ).rstrip()
        for row in rows
    ]


def _bar(bar: GravityBar) -> str:
    cells = list(("#" * bar.filled).ljust(BAR_WIDTH))
    cells.insert(bar.limit, "|")
    verdict = "  over" if bar.exceeds else ""
    return f"{bar.label:>6}  {bar.use:<5}  {bar.delta_g}  {''.join(cells)}{verdict}".rstrip()
