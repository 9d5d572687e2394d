"""`tumble plan budget`: what a stand leaves of the accuracy of every coefficient."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tumble.cli.commands.plan_options import (
    DERIVED,
    add_case_options,
    add_subject,
    add_weights_option,
    read_case,
    write_json,
)
from tumble.cli.options import Subparsers
from tumble.errors import EXIT_PASS

if TYPE_CHECKING:
    from tumble.documents.plan import Promise
    from tumble.model.reliability import Reliability
    from tumble.planning.budget import Budget
    from tumble.planning.case import Case
    from tumble.solving.further import Further


def add_to(subparsers: Subparsers) -> None:
    """Describe the subject to argparse."""
    parser = add_subject(
        subparsers,
        "budget",
        run,
        help="error budget: contributions of every source to every coefficient, and their sum",
        description="Error budget: what each source of error of a stand contributes to every coefficient.",
    )
    add_case_options(parser)
    add_weights_option(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compute and print. Raises TumbleError."""
    case = read_case(arguments)
    from tumble.planning import model_cost
    from tumble.planning.budget import budget, document
    from tumble.planning.promise import promise

    found = budget(case, arguments.weights, arguments.estimator)
    derived = arguments.weights == DERIVED
    promised = promise(case, arguments.estimator) if derived else None
    unseen = case.reliability(arguments.estimator) if derived else None
    further = model_cost.model_cost(case, arguments.estimator)
    if arguments.json:
        write_json(document(found, case, promised, unseen, further))
    else:
        _show(found, case, promised, unseen, further)
    return EXIT_PASS


def _show(
    found: Budget, case: Case, promised: Promise | None, unseen: Reliability | None, further: Further | None
) -> None:
    from tumble.model import reliability
    from tumble.planning import model_cost, tables
    from tumble.planning.budget import ALPHAS, notes, numbers_are, unit
    from tumble.planning.promise import sentence
    from tumble.planning.published import NAMES

    out = tables.console()
    out.print(tables.heading(f"Error budget, {found.weights} weights, estimator {found.estimator}"))
    out.print(f"Stand: {case.stand.name or 'without a name'}; numbers are {numbers_are(found.weights)}")
    out.print(case.block_sentence)
    units = ("size", *map(unit, found.sources), "")
    sizes = ("", *(tables.number(size) for size in found.sizes), "")
    rows = [units, sizes]
    for index, name in enumerate(NAMES):
        millionth = "ug" if name.startswith("a0") else "ppm"
        cells = [tables.millionths(value) for value in (*found.terms[index], found.total[index])]
        rows.append((f"{name}, {millionth}", *cells))
    out.print(tables.table(("", *found.sources, "all"), rows))
    out.print(ALPHAS)
    for note in notes(case):
        out.print(note)
    if promised is not None:
        out.print(sentence(promised))
    for line in [] if unseen is None else reliability.lines(unseen):
        out.print(line)
    model_cost.show(out, further)
    if found.second_order.matters:
        for complaint in found.second_order.complaints:
            out.print(f"Beware: {complaint}", style="yellow")
        out.print("That is a bias, and in no column above", style="yellow")
