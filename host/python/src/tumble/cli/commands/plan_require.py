"""`tumble plan require`: how good the stand must be for a limit of the gravity check."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from tumble.cli.commands.plan_options import (
    add_case_options,
    add_probability,
    add_subject,
    add_weights_option,
    parse_positive,
    parse_probability,
    read_case,
    write_json,
)
from tumble.cli.options import Subparsers
from tumble.errors import EXIT_PASS, UsageError, quoted

if TYPE_CHECKING:
    from tumble.arrays import Floats
    from tumble.planning.case import Case


def add_to(subparsers: Subparsers) -> None:
    """Describe the subject to argparse."""
    parser = add_subject(
        subparsers,
        "require",
        run,
        help="requirements: how bad each source may be for a limit of the gravity check",
        description="Requirements: how bad each source of error of a stand may be for a limit of the gravity check.",
    )
    add_case_options(parser)
    add_weights_option(parser)
    add_probability(
        parser, "what is just enough: probability of passing, and of |a| within the limit at every attitude"
    )
    parser.add_argument(
        "--split",
        metavar="SOURCE=PART,...",
        help="how alpha1 to alpha4, noise, and seat and platform if declared, share a row, as parts of its square;"
        " default: 1 each",
    )


def run(arguments: argparse.Namespace) -> int:
    """Compute and print. Raises TumbleError."""
    probability = parse_probability(arguments.probability)
    case = read_case(arguments)
    limit_g = case.limit_g
    split = _split(arguments.split, case, arguments.weights == "published")

    from tumble.planning import model_cost, tables
    from tumble.planning.promise import promises
    from tumble.planning.require import enough, headroom, margins, requirements
    from tumble.planning.requirement_report import document, show

    found = requirements(case, arguments.weights, arguments.estimator, limit_g, split)
    room = headroom(case, arguments.weights, arguments.estimator, limit_g)
    derived = arguments.weights == "derived"
    of_all = margins(case, limit_g) if derived else {arguments.estimator: room.margin}
    promised = promises(case, probability) if derived else None
    just = enough(case, arguments.estimator, found.limits, probability) if derived else None
    asked = arguments.weights, arguments.estimator, limit_g, split, probability
    further = model_cost.model_cost(case, arguments.estimator)
    plan = document(found, room, of_all, just, promised, case, *asked, further)
    if arguments.json:
        write_json(plan)
    else:
        show(plan, case)
        if further is not None:
            tables.console().print(model_cost.sentence(further))
    return EXIT_PASS


def _split(text: str | None, case: Case, published: bool) -> Floats:
    """Parts by source, in the order of budget.sources."""
    import numpy as np

    from tumble.planning.budget import sources

    parts = dict.fromkeys(sources(case, published), 1.0)
    given = [] if text is None else text.split(",")
    named = [item.partition("=")[0].strip() for item in given]
    for item in given:
        source, equals, part = item.partition("=")
        if not equals or source.strip() not in parts:
            raise UsageError(f"--split: {quoted(item)} is not SOURCE=PART with one of {', '.join(parts)}")
        if named.count(source.strip()) > 1:
            raise UsageError(f"--split: {source.strip()} is given twice")
        parts[source.strip()] = parse_positive(part.strip(), "--split")
    return np.array(list(parts.values()))
