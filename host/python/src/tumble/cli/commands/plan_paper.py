"""`tumble plan paper`: the paper's tables and formulas computed again, side by side with what is printed."""

from __future__ import annotations

import argparse

from tumble.cli.commands.plan_options import add_subject, write_json
from tumble.cli.options import Subparsers, refuse_model
from tumble.errors import EXIT_PASS


def add_to(subparsers: Subparsers) -> None:
    """Describe the subject to argparse."""
    parser = add_subject(
        subparsers,
        "paper",
        run,
        help="the paper, audited: its tables and formulas beside what they should be",
        description="Tables 1 to 5 and formulas (6), (18) and (19) of the paper, computed again and compared.",
    )
    refuse_model(parser, "the paper's model has twelve coefficients; further terms are for other plans")


def run(arguments: argparse.Namespace) -> int:
    """Compute and print."""
    from tumble.planning.paper import document, show

    if arguments.json:
        write_json(document())
    else:
        show()
    return EXIT_PASS
