"""What a command says of a solution: warnings on stderr, and the solution as JSON, on a terminal, or as plain ASCII."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from tumble.cli import presentation, propagated
from tumble.cli.presentation import BAR_WIDTH, GravityBar
from tumble.messages import tell
from tumble.solving import plausibility
from tumble.solving.solution import Solution
from tumble.units import noise_unit

_NO_UNIT = "the run file names no unit: outputs taken for volts (--unit V, or ux [V] in its header)"


def warnings(solution: Solution, odd: Sequence[str] = (), confirmed_volts: bool = False) -> list[str]:
    """A sentence for each reason why a solution may not be what it claims. `odd`: what is odd about its K and its rows;
    `confirmed_volts`: the declared block shows that outputs without a unit are in volts."""
    unit = solution.run.unit
    found = [] if solution.run.unit_told or confirmed_volts else [_NO_UNIT]
    found += odd
    if solution.stand is not None and noise_unit(unit) != "V":
        noise = f"noise_v of the stand file, {solution.stand.noise:g}"
        found.append(f"outputs in {unit}: {noise}, is in {unit} too")
    found += [] if solution.second_order is None else solution.second_order.complaints
    if solution.lone:
        found.append(f"a single row, taken for one sample, at {', '.join(solution.lone)}")
    noisy = presentation.noise_notice(solution)
    if noisy is not None:
        found.append(f"{noisy}; the uncertainties count it")
    if solution.monte_carlo is not None and (open_or_not := propagated.complaint(solution.monte_carlo)):
        found.append(open_or_not)
    found += plausibility.unchecked(solution)
    doubt = presentation.complaint(solution)
    if doubt is not None:
        found.append(f"{doubt}; the uncertainties {presentation.consequence(solution)}")
    return found


def warn(sentences: Sequence[str]) -> None:
    """A line on stderr for each of `warnings`."""
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
    lines = [presentation.title(solution, file), ""]
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
