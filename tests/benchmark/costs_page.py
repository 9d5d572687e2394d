"""docs/performance.md: its tables, and new figures put beside what it says.

What a benchmark prints stands between the lines `<!-- tools/benchmark NAME --table -->` and `<!-- end -->`: a table,
and on what machine where that matters. A row is known by its first cell. Figures that are measured are new; what people
set (a goal), and the last figure that differs by more than 2 % (before), are taken over from the page.
"""

import re
from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs/performance.md"
BEGIN, END = r"<!-- tools/benchmark (?P<name>\S+) --table -->", "<!-- end -->"
PART = re.compile(f"^{BEGIN}\n(?P<shown>.*?)^{END}$", re.MULTILINE | re.DOTALL)
SAME = 0.02  # of a figure


def names(text):
    """The benchmarks that print tables of a page, in its order."""
    return [part["name"] for part in PART.finditer(text)]


def part_of(text, name):
    """The match of a benchmark's part; ValueError where the page has none."""
    found = next((part for part in PART.finditer(text) if part["name"] == name), None)
    if found is None:
        raise ValueError(f"the page has no lines <!-- tools/benchmark {name} --table --> and <!-- end -->")
    return found


def table_of(text, name):
    """The lines of a benchmark's table."""
    return [line for line in part_of(text, name)["shown"].splitlines() if line.startswith("|")]


def with_part(text, name, shown):
    """The page with what a benchmark has printed in the place of what it printed before."""
    part = part_of(text, name)
    return f"{text[: part.start('shown')]}{shown}\n{text[part.end('shown') :]}"


def rows_of(table):
    """{first cell: {column: cell}}."""
    header, _, *rows = map(cells_of, table)
    return {row[0]: dict(zip(header[1:], row[1:])) for row in rows}


def cells_of(line):
    return [cell.strip() for cell in line.strip()[1:-1].split("|")]


def markdown(columns, rows):
    """A table from {first cell: {column: cell}}; a cell that is not there is empty."""
    lines = [["", *columns], ["---"] * (len(columns) + 1)]
    lines += [[name, *(cells.get(column, "") for column in columns)] for name, cells in rows.items()]
    padded = [[cell if set(cell) == {"-"} else f" {cell} " for cell in line] for line in lines]
    return "\n".join("|" + "|".join(line) + "|" for line in padded)


def number(text):
    """Of a cell, None where it holds none."""
    return float(text.replace(",", "")) if text.strip() else None


def before(now, said, said_before):
    """The cell "before" of a figure, from what the page says of it and of what was before."""
    changed = said and abs(now - number(said)) > SAME * number(said)
    return said if changed else said_before
