"""What a command says of a solution: warnings on stderr, and the solution as JSON, on a terminal, or as plain ASCII."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from tumble.cli import presentation
from tumble.cli.presentation import BAR_WIDTH, GravityBar
from tumble.messages import tell
from tumble.solving.solution import Solution


def warn(sentences: Sequence[str]) -> None:
    """A line on stderr for each of `complaints`."""
    for sentence in sentences:
        tell(f"tumble: warning: {sentence}")


def print_solution(solution: Solution, json_text: str | None, title: str) -> None:
    """As JSON, or for people: with rich on a terminal. `title`: what was solved."""
    if json_text is not None:
        sys.stdout.write(json_text)
    elif sys.stdout.isatty():
        from tumble.cli.terminal import show

        show(solution, title)
    else:
        sys.stdout.write(_plain_text(solution, title))


def _plain_text(solution: Solution, file: str) -> str:
    """All of it, within 80 columns as long as the file's name and the numbers are of ordinary size."""
    lines = [*presentation.foremost(solution), presentation.title(solution, file), ""]
    lines += _table([presentation.coefficient_headings(solution), *presentation.coefficient_rows(solution)])
    lines += presentation.notes(solution) + presentation.uncertainty_notes(solution) + [""]
    lines += [presentation.gravity_title(solution)]
    lines += [_bar(bar) for bar in presentation.gravity_bars(solution)] + [""]
    lines += [*presentation.remarks(solution), "", *presentation.beware(solution)]
    lines += [presentation.verdict(solution)]
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
