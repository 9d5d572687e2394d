"""A solution on a terminal, with rich. The same content as the plain text."""

from __future__ import annotations

import sys

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from tumble.cli import presentation
from tumble.cli.presentation import BAR_WIDTH, GravityBar
from tumble.messages import signed_for
from tumble.solving.decision import decide
from tumble.solving.solution import Solution

_WIDTH = 80  # a narrower terminal wraps lines, which loses nothing


def show(solution: Solution, file: str) -> None:
    """Print on standard output. Colours heed NO_COLOR; a terminal without Unicode gets ASCII."""
    console = Console(highlight=False)
    console.width = max(console.width, _WIDTH)
    for line in presentation.foremost(solution):
        console.print(_text(line, style="yellow bold"))
    console.print(_text(presentation.title(solution, file), style="bold"))
    console.print(_coefficients(solution))
    for line in presentation.notes(solution) + presentation.uncertainty_notes(solution):
        console.print(_text(line, style="yellow"))
    console.print(_text("\n" + presentation.gravity_title(solution), style="bold"))
    block = "#" if console.options.ascii_only else "\u2588"
    for bar in presentation.gravity_bars(solution):
        console.print(_bar(bar, block), no_wrap=True, overflow="crop")
    console.print()
    for line in presentation.remarks(solution):
        console.print(_text(line))
    console.print()
    for line in presentation.beware(solution):
        console.print(_text(line, style="yellow"))
    decision = decide(solution)
    colour = "yellow" if decision.is_not_shown or (decision.passed and decision.where) else _colour(decision.passed)
    console.print(_text(presentation.verdict(solution), style=colour + " bold"))


def _text(line: str, style: str = "") -> Text:
    """With the signs of quantities, where the terminal has them."""
    return Text(signed_for(line, sys.stdout), style=style)


def _colour(good: bool) -> str:
    return "green" if good else "red"


def _coefficients(solution: Solution) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, header_style="dim")
    for heading in presentation.coefficient_headings(solution):
        table.add_column(heading, justify="left" if heading in ("", "unit") else "right", no_wrap=True)
    for name, value, unit, u, relative, difference, *known in presentation.coefficient_rows(solution):
        styled = Text(name, style="bold"), Text(value, style="cyan")
        table.add_row(*styled, unit, u, _text(relative), Text(difference, style="dim"), *known)
    return table


def _bar(bar: GravityBar, block: str) -> Text:
    colour = _colour(not bar.exceeds)
    cells = (block * bar.filled).ljust(BAR_WIDTH)
    text = Text(f"{bar.label:>6}  {bar.use:<5}  {bar.delta_g}  ")
    text.append(cells[: bar.limit], style=colour)
    text.append("|", style="bold")
    text.append(cells[bar.limit :], style=colour)
    return text.append("  over" if bar.exceeds else "", style=colour)
